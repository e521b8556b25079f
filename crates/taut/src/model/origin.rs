//! Where the coordinates of a cloth begin.
//!
//! Single precision loses digits with the distance from the origin: at 1 km it tells places 0.06 mm apart, which is 0.6 % of a spring of
//! 1 cm. So each cloth has an origin near it, and its positions are local: its places in the world are origin + local. From one possible
//! origin to the next it is a power of two, at least twice the cloth's size. Cloth near the origin of the world has that one. A shape
//! that is put elsewhere, by the origin of a grid or by `translate`, has the same local positions to the last bit.

use glam::{DVec3, Vec3};

/// Where the coordinates of a cloth begin, and when it takes the next origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// In the world, at the start [m].
    pub at: DVec3,
    /// From one possible origin to the next, along each axis [m].
    pub pitch: f64,
    /// The particle that is followed when the cloth travels.
    pub guide: u32,
}

impl Origin {
    /// One near the middle of some points [m], which are counted from `from` [m]. It is that of the world, if that is the nearest of
    /// its multiples. Otherwise it is a multiple from `from`, so that a shape has the same coordinates wherever it is put.
    #[must_use]
    pub fn near(from: DVec3, points: &[DVec3]) -> Self {
        let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.iter().fold(nowhere, |(low, high), &point| (low.min(point), high.max(point)));
        if points.is_empty() {
            return Self { at: DVec3::ZERO, pitch: 1.0, guide: 0 };
        }
        let pitch = pitch((high - low).max_element());
        let middle = 0.5 * (low + high);
        let at_home = nearest(from + middle, pitch) == DVec3::ZERO;
        Self { at: if at_home { DVec3::ZERO } else { from + nearest(middle, pitch) }, pitch, guide: 0 }
    }

    /// How far the origin has to move [m], its guide being at a local place [m]: nothing unless that is further off than a pitch.
    #[must_use]
    pub fn way(&self, guide: Vec3) -> DVec3 {
        let guide = guide.as_dvec3();
        let far = guide.abs().cmpgt(DVec3::splat(self.pitch));
        if far.any() && guide.is_finite() { DVec3::select(far, nearest(guide, self.pitch), DVec3::ZERO) } else { DVec3::ZERO }
    }
}

/// What rounding far away from the origin of the world may add [1].
const ALIKE: f64 = 1e-6;

/// The least power of two that is at least twice a size [m].
fn pitch(size: f64) -> f64 {
    let mut pitch = 1.0;
    if size > 0.0 {
        while pitch < 2.0 * (1.0 - ALIKE) * size {
            pitch *= 2.0;
        }
        while pitch >= 4.0 * (1.0 - ALIKE) * size {
            pitch *= 0.5;
        }
    }
    pitch
}

/// The nearest multiples of the pitch; of two that are as near the lower one.
fn nearest(place: DVec3, pitch: f64) -> DVec3 {
    // Minus zero plus zero is zero.
    (place / pitch - (0.5 + ALIKE)).ceil() * pitch + DVec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_near_and_as_far_apart_as_asked_for() {
        let of = |low: f64, high: f64| Origin::near(DVec3::ZERO, &[DVec3::splat(low), DVec3::splat(high)]);
        for (low, high, at, pitch) in [
            (0.0, 1.0, 0.0, 2.0),
            (-1.0, 0.0, 0.0, 2.0),
            (1e5, 1e5 + 0.2, 1e5, 0.5),
            (-20.0, -19.8, -20.0, 0.5),
            (3.0, 3.0, 3.0, 1.0),
        ] {
            let origin = of(low, high);
            assert_eq!((origin.at, origin.pitch), (DVec3::splat(at), pitch), "{low} to {high}");
        }
    }

    #[test]
    fn an_origin_follows_its_guide_and_comes_to_rest() {
        let origin = Origin { at: DVec3::ZERO, pitch: 2.0, guide: 0 };
        assert_eq!(origin.way(Vec3::new(2.0, -2.0, 0.3)), DVec3::ZERO);
        assert_eq!(origin.way(Vec3::new(2.1, -7.2, 1.9)), DVec3::new(2.0, -8.0, 0.0));
        assert_eq!(origin.way(Vec3::new(f32::INFINITY, 0.0, 0.0)), DVec3::ZERO);
        assert_eq!(origin.way(Vec3::new(f32::NAN, 9.0, 0.0)), DVec3::ZERO);
    }
}
