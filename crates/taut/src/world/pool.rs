//! Threads that worlds share.

use std::fmt;
use std::sync::Arc;

use super::Error;
use crate::geometry;

/// The threads on which worlds step; a copy is the same pool. No result depends on them.
///
/// Only loops over more than some thousand vertices are handed to several threads.
#[derive(Clone)]
pub struct Pool(pub(super) Arc<geometry::Pool>);

impl Pool {
    /// A pool of so many threads; one is the caller's own. Without the feature `threads`, and where the system
    /// refuses more, it is the caller's alone: see [`Self::threads`].
    ///
    /// # Errors
    /// No thread at all.
    pub fn new(threads: usize) -> Result<Self, Error> {
        if threads == 0 {
            return Err(Error::argument("threads", threads, "must be at least 1, which is the caller's own"));
        }
        Ok(Self(Arc::new(geometry::Pool::new(threads))))
    }

    /// The threads of the rayon pool in which [`World::step`](super::World::step) is called, or of rayon's global one outside of any.
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn of_host() -> Self {
        Self(Arc::new(geometry::Pool::of_host()))
    }

    /// How many threads it has.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.0.threads()
    }
}

impl Default for Pool {
    /// The caller's thread.
    fn default() -> Self {
        Self(Arc::new(geometry::Pool::new(1)))
    }
}

impl fmt::Debug for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pool").field("threads", &self.threads()).finish()
    }
}
