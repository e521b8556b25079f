//! The time since the start.

/// Steps and time since the start. As long as steps are equal the time is their number times their length, and no rounding adds up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Clock {
    /// All steps.
    pub steps: u64,
    /// When the present run of equal steps began [s].
    pub(super) start: f64,
    /// How many steps it has ..
    pub(super) run: u64,
    /// .. and how long they are [s].
    pub(super) length: f64,
}

impl Clock {
    /// After so many steps of one length [s].
    #[must_use]
    pub fn after(steps: u64, length: f64) -> Self {
        Self { steps, start: 0.0, run: steps, length }
    }

    /// The time [s].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.start + self.run as f64 * self.length
    }

    /// One step of `length` seconds later.
    #[must_use]
    pub fn next(&self, length: f64) -> Self {
        let (start, run) = if length == self.length { (self.start, self.run) } else { (self.time(), 0) };
        Self { steps: self.steps + 1, start, run: run + 1, length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_steps_do_not_add_up_rounding_and_others_follow_on() {
        let mut clock = Clock::default();
        for _ in 0..1_000_000 {
            clock = clock.next(1.0 / 60.0);
        }
        assert_eq!(clock.time(), 1_000_000.0 / 60.0);
        assert_eq!(clock, Clock::after(1_000_000, 1.0 / 60.0));
        let later = clock.next(0.25).next(0.25).next(0.5);
        assert_eq!((later.time(), later.steps), (clock.time() + 1.0, 1_000_003));
    }
}
