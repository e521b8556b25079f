//! Hashes that only a change of what is computed may change: `tests/goldens.txt`.
//!
//! A new golden needs a reason; write it into the commit. `TAUT_GOLDENS=write cargo test -p taut --test determinism` takes
//! those found.

use std::fmt::Write;
use std::sync::Mutex;

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/goldens.txt");

/// One test at a time reads and writes.
static FILE: Mutex<()> = Mutex::new(());

/// Compares hashes with those of the file.
///
/// # Panics
/// If one differs: the message has the lines of all that do, as the file would have them.
pub fn check(found: &[(String, u64)]) {
    let _alone = FILE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let text = std::fs::read_to_string(PATH).unwrap_or_default();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut different = String::new();
    for (name, hash) in found {
        let line = format!("{hash:016x} {name}");
        let place = lines.iter().position(|line| line.get(17..) == Some(name));
        if place.is_none_or(|place| lines[place] != line) {
            writeln!(different, "{line}").expect("a string takes all");
        }
        match place {
            Some(place) => lines[place] = line,
            None => lines.push(line),
        }
    }
    if std::env::var("TAUT_GOLDENS").as_deref() == Ok("write") {
        std::fs::write(PATH, lines.join("\n") + "\n").expect("the file can be written");
    } else {
        assert!(different.is_empty(), "other bits than ever (renew with TAUT_GOLDENS=write, and say why):\n{different}");
    }
}
