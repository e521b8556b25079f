//! What steps spend their time on. The engine has no clock: a host may bring one, and nothing that is computed depends on it.

/// Seconds that steps spent in the phases of their filter, by the clock of the host; all 0 where it brought none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// Finding pairs that are near or come near, what intersects at the start, and the rows of all these [s].
    pub detection: f64,
    /// Projecting springs and rows, and the certificates of strain limits [s].
    pub solve: f64,
    /// Looking for what would cross on the way [s].
    pub certificate: f64,
}

impl Times {
    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            detection: self.detection + other.detection,
            solve: self.solve + other.solve,
            certificate: self.certificate + other.certificate,
        }
    }
}

/// A clock of the host, if it brought one, and what was measured by it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Watch {
    /// Seconds since any moment.
    pub clock: Option<fn() -> f64>,
    /// Measured since the last [`Self::take`].
    pub times: Times,
}

impl Watch {
    /// What the clock shows now [s]; 0 without one.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.clock.map_or(0.0, |clock| clock())
    }

    /// What was measured; from here on it measures anew.
    pub fn take(&mut self) -> Times {
        std::mem::take(&mut self.times)
    }
}
