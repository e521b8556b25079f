//! Threads that simulations share.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use taut::geometry::Pool;

/// The pools that are in use, and the process that has their threads: a fork does not inherit them.
static POOLS: Mutex<Vec<(u32, Weak<Pool>)>> = Mutex::new(Vec::new());

/// The pool of so many threads that other simulations of this process use, or a new one.
pub fn shared(threads: usize) -> Arc<Pool> {
    let process = std::process::id();
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    pools.retain(|(owner, pool)| *owner == process && pool.strong_count() > 0);
    let found = pools.iter().filter_map(|(_, pool)| pool.upgrade()).find(|pool| pool.threads() == threads);
    found.unwrap_or_else(|| {
        let pool = Arc::new(Pool::new(threads));
        pools.push((process, Arc::downgrade(&pool)));
        pool
    })
}
