//! When everything lies still: a world that sleeps does not move, and costs next to nothing, until something from outside changes.
//!
//! Cloth is never quite at rest. It lies still where no vertex is faster than a small part of the speed with which it would fall by its own
//! size. After two spans of that it sleeps, if no vertex was faster in the second one than in the first: what gathers speed from rest, as a
//! sheet that stands on its edge or one that begins to slide, is faster in each span than in the one before.

use glam::Vec3;

use crate::model::Model;

/// Vertices lie still below this part of `sqrt(g L)` [1], L being the size of the smallest cloth: 1.3 mm/s for 1 m.
const STILL: f64 = 4e-4;
/// How long a span is, in `sqrt(L / g)` of the largest cloth [1]: a quarter of the swing of a pendulum that long, 0.5 s for 1 m.
const SPAN: f64 = std::f64::consts::FRAC_PI_2;

/// Whether a world sleeps, and what is known of how it comes to that.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sleep {
    /// What acts from outside since it lies still, as one number; it has so many bits that two vectors keep it.
    acting: u64,
    /// How long this span has been [s], and how fast the fastest vertex was in it, and in the one before [m/s]; zero where there is none.
    spent: f32,
    fastest: f32,
    before: f32,
    is_asleep: bool,
}

/// The bits of what acts that are kept, in two halves: whole numbers that single precision holds.
const BITS: u32 = 48;

/// What lies still in a model, under some gravity: how fast it is at most [m/s], and how long a span is [s].
#[derive(Debug, Clone, Copy)]
pub struct Stillness {
    speed: f32,
    span: f32,
}

impl Stillness {
    /// Under an acceleration of gravity [m/s^2]. Without any nothing lies still: what drifts in empty space goes on for ever.
    #[must_use]
    pub fn of(model: &Model, gravity: f64) -> Self {
        let sizes = || model.cloths.iter().map(|cloth| cloth.size).filter(|size| *size > 0.0);
        let (smallest, largest) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
        let is_any = gravity > 0.0 && largest > 0.0;
        let speed = if is_any { STILL * (gravity * smallest).sqrt() } else { -1.0 };
        Self { speed: speed as f32, span: (SPAN * (largest / gravity).sqrt()) as f32 }
    }
}

impl Sleep {
    /// Whether it sleeps.
    #[must_use]
    pub fn is_asleep(self) -> bool {
        self.is_asleep
    }

    /// Whether it goes on sleeping under what acts now; nothing tells what changes with time.
    #[must_use]
    pub fn goes_on(self, acting: Option<u64>) -> bool {
        self.is_asleep && acting.map(kept) == Some(self.acting)
    }

    /// After a step of `dt` seconds in which the fastest vertex had such a speed [m/s], or where it is not to sleep none. `acting` tells what acts
    /// from outside, if that does not change.
    #[must_use]
    pub fn after(self, dt: f64, fastest: Option<f32>, still: Stillness, acting: impl FnOnce() -> Option<u64>) -> Self {
        let Some(fastest) = fastest.filter(|fastest| *fastest <= still.speed) else { return Self::default() };
        let Some(acting) = acting().map(kept) else { return Self::default() };
        let known = if self.acting == acting { self } else { Self { acting, ..Self::default() } };
        let spent = known.spent + dt as f32;
        let fastest = known.fastest.max(fastest);
        if spent < still.span {
            return Self { spent, fastest, ..known };
        }
        // One that was not even slow has a span behind it, too.
        let is_asleep = known.before > 0.0 && fastest <= known.before;
        Self { acting, spent: 0.0, fastest: 0.0, before: fastest.max(f32::MIN_POSITIVE), is_asleep }
    }

    /// As the coordinates of two vectors.
    #[must_use]
    pub fn to_vectors(self) -> [Vec3; 2] {
        let half = BITS / 2;
        let [high, low] = [self.acting >> half, self.acting & ((1 << half) - 1)].map(|bits| bits as f32);
        [Vec3::new(self.spent, self.fastest, self.before), Vec3::new(high, low, f32::from(u8::from(self.is_asleep)))]
    }

    /// What [`Self::to_vectors`] wrote; awake where it is none.
    #[must_use]
    pub fn from_vectors([of_span, of_all]: [Vec3; 2]) -> Self {
        let half = BITS / 2;
        let is_whole = |bits: f32| bits >= 0.0 && bits < (1_u32 << half) as f32 && bits.fract() == 0.0;
        let is_one = of_span.is_finite() && of_span.min_element() >= 0.0 && is_whole(of_all.x) && is_whole(of_all.y);
        if !is_one {
            return Self::default();
        }
        let [spent, fastest, before] = of_span.to_array();
        let acting = (of_all.x as u64) << half | of_all.y as u64;
        Self { acting, spent, fastest, before, is_asleep: of_all.z == 1.0 }
    }
}

/// The bits that are kept.
fn kept(acting: u64) -> u64 {
    acting & ((1 << BITS) - 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STILLNESS: Stillness = Stillness { speed: 1e-3, span: 0.5 };

    /// After steps of 0.1 s with such speeds [m/s].
    fn after(speeds: impl IntoIterator<Item = f32>) -> Sleep {
        speeds.into_iter().fold(Sleep::default(), |sleep, speed| sleep.after(0.1, Some(speed), STILLNESS, || Some(7)))
    }

    #[test]
    fn what_lies_still_for_two_spans_sleeps_while_nothing_changes() {
        assert!(!after([5e-4; 9]).is_asleep());
        let asleep = after([5e-4; 10]);
        assert!(asleep.is_asleep() && asleep.goes_on(Some(7)) && !asleep.goes_on(Some(8)) && !asleep.goes_on(None));
        assert!(!after([5e-4, 5e-4, 5e-4, 2e-3, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4]).is_asleep());
    }

    #[test]
    fn what_gathers_speed_does_not() {
        assert!(!after((1..100).map(|step| 1e-5 * step as f32)).is_asleep());
        assert!(!after((1..100).map(|step| 1e-9 * 1.1_f32.powi(step))).is_asleep());
        // What trembles does, in a span in which it trembles no more than in the one before.
        assert!(after((0..20).map(|step| if step == 6 { 8e-4 } else { 5e-4 })).is_asleep());
    }

    #[test]
    fn what_acts_from_outside_must_have_been_the_same() {
        let mut sleep = Sleep::default();
        for step in 0..100 {
            sleep = sleep.after(0.1, Some(1e-4), STILLNESS, || Some(step / 4));
            assert!(!sleep.is_asleep());
        }
        assert_eq!(sleep.after(0.1, Some(1e-4), STILLNESS, || None), Sleep::default());
        assert_eq!(sleep.after(0.1, None, STILLNESS, || Some(1)), Sleep::default());
    }

    proptest! {
        #[test]
        fn vectors_keep_all(acting: u64, speeds in prop::collection::vec(0.0_f32..1e-3, 0..12), garbage in prop::array::uniform6(any::<f32>())) {
            let sleep = speeds.iter().fold(Sleep::default(), |sleep, &speed| sleep.after(0.1, Some(speed), STILLNESS, || Some(acting)));
            prop_assert_eq!(Sleep::from_vectors(sleep.to_vectors()), sleep);
            let [a, b, c, d, e, f] = garbage;
            let read = Sleep::from_vectors([Vec3::new(a, b, c), Vec3::new(d, e, f)]);
            prop_assert!(read.acting < 1 << BITS && read.spent.is_finite() && read.spent >= 0.0);
        }
    }
}
