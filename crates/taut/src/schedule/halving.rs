//! Steps that are halved where contact asks for it.
//!
//! What touches may need shorter steps than the cloth alone, and nobody knows before. A step would have to be cut where something would
//! cross something else. Such a step is taken back and taken in two halves, and these again. What helped is remembered: the next steps
//! begin with as many parts, and every now and then with fewer. Where even the shortest parts had to be cut in two steps, since cloth is
//! pinched, the next one is taken whole, and cut. Where bodies have given way to what they pinch, steps are cut as they are, and whole from then on.

use glam::Vec3;

/// A step is halved so often at most: into 8 parts.
const MOST: u32 = 3;
/// Steps wait at most so long before one is taken in other parts.
const LONGEST_WAIT: u32 = 16;

/// What is remembered from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halving {
    /// Steps begin with 2 to the power of this many parts.
    pub halvings: u32,
    /// So many steps are taken like that before one with half as many parts is tried; none while one is tried. Whole steps that wait
    /// are not halved, since it was in vain.
    pub wait: u32,
    /// How long the next wait is: it doubles with every try that fails.
    pub patience: u32,
}

impl Default for Halving {
    fn default() -> Self {
        Self { halvings: 0, wait: 0, patience: 1 }
    }
}

impl Halving {
    /// What is remembered, as it was told by someone else.
    #[must_use]
    pub fn new(halvings: u32, wait: u32, patience: u32) -> Self {
        Self { halvings: halvings.min(MOST), wait: wait.min(LONGEST_WAIT), patience: patience.clamp(1, LONGEST_WAIT) }
    }

    /// As the coordinates of a vector.
    #[must_use]
    pub fn to_vector(self) -> Vec3 {
        Vec3::new(self.halvings as f32, self.wait as f32, self.patience as f32)
    }

    /// What [`Self::to_vector`] wrote; whole steps where that is none.
    #[must_use]
    pub fn from_vector(vector: Vec3) -> Self {
        Self::new(vector.x as u32, vector.y as u32, vector.z as u32)
    }

    fn is_spared(self) -> bool {
        self.halvings == 0 && self.wait > 0
    }

    fn waits(self, halvings: u32) -> Self {
        Self::new(halvings, self.patience, 2 * self.patience)
    }
}

/// A step on its way: how far it is, and in which parts it goes on.
#[derive(Debug)]
pub struct Parts {
    /// In the shortest parts.
    done: u32,
    all: u32,
    halvings: u32,
    most: u32,
    needed_more: bool,
    in_vain: bool,
    given_way: bool,
}

impl Parts {
    /// A step that is taken in `least` parts in any case; whether it can be halved is what `halving` says.
    #[must_use]
    pub fn new(least: u32, halving: Option<Halving>) -> Self {
        let halving = halving.filter(|halving| !halving.is_spared());
        let (halvings, most) = halving.map_or((0, 0), |halving| (halving.halvings, MOST));
        Self { done: 0, all: least << most, halvings, most, needed_more: false, in_vain: false, given_way: false }
    }

    /// The length of the next part, as a part of the step [1]; none where all is done.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        (self.done < self.all).then(|| f64::from(self.size()) / f64::from(self.all))
    }

    /// Whether the next part can be halved if it does not go well.
    #[must_use]
    pub fn can_be_halved(&self) -> bool {
        self.halvings < self.most
    }

    /// Halves the next part, and those after it.
    pub fn halve(&mut self) {
        self.halvings += 1;
        self.needed_more = true;
    }

    /// The next part has been taken, and `was_cut` or not; whether bodies that have given way pressed there.
    pub fn take(&mut self, was_cut: bool, given_way: bool) {
        self.done += self.size();
        self.in_vain |= was_cut;
        self.given_way |= given_way;
    }

    /// Whether contact has it taken in more parts than it has to be.
    #[must_use]
    pub fn was_halved(&self) -> bool {
        self.halvings > 0
    }

    /// What is to be remembered after the step.
    #[must_use]
    pub fn remember(&self, before: Halving) -> Halving {
        let Self { halvings, .. } = *self;
        if before.is_spared() {
            return Halving { wait: before.wait - 1, ..before };
        }
        if self.given_way {
            return Halving::default();
        }
        // The next step begins with the shortest parts. Where these have been in vain twice it is taken whole; a longer wait than one step
        // brings what goes on through narrow places to a stop.
        if self.in_vain {
            let halvings = if before.halvings < MOST { MOST } else { 0 };
            return Halving { halvings, wait: 1, ..Halving::default() };
        }
        if self.needed_more {
            return before.waits(halvings);
        }
        match (halvings, before.wait) {
            (0, _) => Halving::default(),
            // What was tried went well.
            (_, 0) => Halving { halvings: halvings - 1, ..Halving::default() },
            (_, 1) => Halving { halvings: halvings - 1, wait: 0, ..before },
            (_, wait) => Halving { wait: wait - 1, ..before },
        }
    }

    fn size(&self) -> u32 {
        1 << (self.most - self.halvings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts of a step whose parts longer than `bears` [1] have to be cut, and what is remembered.
    fn step(before: Halving, bears: f64) -> (Vec<f64>, Halving) {
        let mut parts = Parts::new(1, Some(before));
        let mut taken = Vec::new();
        while let Some(part) = parts.next() {
            let was_cut = part > bears;
            if was_cut && parts.can_be_halved() {
                parts.halve();
                continue;
            }
            taken.push(part);
            parts.take(was_cut, false);
        }
        (taken, parts.remember(before))
    }

    #[test]
    fn parts_are_halved_until_they_go_well_and_grow_again() {
        let (taken, mut halving) = step(Halving::default(), 0.25);
        assert_eq!(taken, [0.25; 4]);
        let mut counts = Vec::new();
        while halving != Halving::default() {
            let taken;
            (taken, halving) = step(halving, 1.0);
            counts.push(taken.len());
        }
        assert_eq!(counts, [4, 2]);
    }

    #[test]
    fn where_shorter_parts_are_needed_for_long_longer_ones_are_tried_ever_less() {
        let (mut halving, mut tries) = (Halving::default(), Vec::new());
        for at in 0..60 {
            let before = halving;
            let (taken, then) = step(halving, 0.5);
            assert_eq!(taken, [0.5; 2]);
            if before.halvings == 0 {
                tries.push(at);
            }
            halving = then;
        }
        assert_eq!(tries, [0, 2, 5, 10, 19, 36, 53]);
    }

    #[test]
    fn what_is_in_vain_twice_is_spared_in_the_next_step() {
        let (mut halving, mut lengths) = (Halving::default(), Vec::new());
        for _ in 0..6 {
            let (taken, then) = step(halving, 0.0);
            lengths.push(taken.len());
            halving = then;
        }
        assert_eq!(lengths, [8, 8, 1, 8, 8, 1]);
    }

    #[test]
    fn where_bodies_have_given_way_the_next_step_is_taken_whole() {
        let mut parts = Parts::new(1, Some(Halving::new(MOST, 1, 1)));
        for part in 0..1 << MOST {
            parts.take(true, part == 3);
        }
        assert_eq!(parts.next(), None);
        assert_eq!(parts.remember(Halving::new(MOST, 1, 1)), Halving::default());
    }

    #[test]
    fn where_nothing_touches_steps_are_taken_as_they_are() {
        let mut parts = Parts::new(3, None);
        let mut sum = 0.0;
        while let Some(part) = parts.next() {
            assert!(!parts.can_be_halved());
            sum += part;
            parts.take(false, false);
        }
        assert_eq!(sum, 1.0);
    }

    #[test]
    fn what_is_told_comes_back() {
        for halving in [Halving::default(), Halving::new(3, 5, 8), Halving::new(0, 7, 16)] {
            assert_eq!(Halving::from_vector(halving.to_vector()), halving);
        }
        assert_eq!(Halving::from_vector(Vec3::splat(f32::MAX)), Halving::new(MOST, LONGEST_WAIT, LONGEST_WAIT));
    }
}
