//! Functions that give the same bits on every machine.
//!
//! The standard library takes `cbrt`, `sin`, `powf` and their like from the platform, and leaves open how `powi` multiplies: their
//! last bits differ between machines. These are those of the crate libm, which is compiled along with the engine, or
//! multiplications in a fixed order. Square roots need no care: IEEE 754 demands the nearest number. `tools/check_house.py`
//! refuses the others.

use glam::{DQuat, DVec3};

/// The cube root of x.
#[must_use]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// The length of the vector (x, y).
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// 2 to the power of x.
#[must_use]
pub fn exp2(x: f64) -> f64 {
    libm::exp2(x)
}

/// x to a whole power.
#[must_use]
pub fn power(x: f64, exponent: u32) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * x)
}

/// The turn round x, then y, then z, each about its fixed axis, by these angles in degrees.
#[must_use]
pub fn turn([x, y, z]: [f64; 3]) -> DQuat {
    turn_about(DVec3::Z, z) * turn_about(DVec3::Y, y) * turn_about(DVec3::X, x)
}

/// The turn round an axis of length 1 by an angle in degrees, counter-clockwise seen against it.
#[must_use]
pub fn turn_about(axis: DVec3, degrees: f64) -> DQuat {
    let half = 0.5 * degrees * (std::f64::consts::PI / 180.0);
    let along = axis * libm::sin(half);
    DQuat::from_xyzw(along.x, along.y, along.z, libm::cos(half))
}

/// The shortest turn from one rotation to another: its axis times its angle [rad].
#[must_use]
pub fn turn_between(from: DQuat, to: DQuat) -> DVec3 {
    let between = to * from.conjugate();
    let between = if between.w < 0.0 { -between } else { between };
    let along = between.xyz();
    let sine = along.length();
    if sine == 0.0 { DVec3::ZERO } else { along * (2.0 * libm::atan2(sine, between.w) / sine) }
}

#[cfg(test)]
mod tests {
    use glam::EulerRot;

    use super::*;

    #[test]
    #[cfg_attr(miri, ignore = "Miri has functions of the platform err on purpose")]
    fn they_are_those_of_the_standard_library_but_for_rounding() {
        let same = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
        for step in 1..2000 {
            let x = 1e-3 * f64::from(step * step);
            assert!(same(cbrt(x), x.cbrt()) && same(hypot(x, 1.7), x.hypot(1.7)), "{x}");
            assert!(same(exp2(-x.min(900.0)), (-x.min(900.0)).exp2()) && same(power(x, 5), x.powi(5)), "{x}");
        }
    }

    #[test]
    fn a_turn_is_that_of_its_angles() {
        for angles in [[0.0, 0.0, 90.0], [30.0, 0.0, 0.0], [12.0, -145.0, 71.0], [1e5, -3e4, 7.0]] {
            let [x, y, z] = angles.map(f64::to_radians);
            let expected = DQuat::from_euler(EulerRot::ZYX, z, y, x);
            for point in [DVec3::X, DVec3::Y, DVec3::new(0.3, -2.0, 1.7)] {
                assert!((turn(angles) * point).distance(expected * point) < 1e-13 * 1e3, "{angles:?}");
            }
        }
    }

    #[test]
    fn the_same_bits_on_every_machine() {
        let bits = [cbrt(0.3), hypot(0.3, 0.7), exp2(-1.0 / 3.0), power(0.3, 3), turn([10.0, 20.0, 30.0]).x].map(f64::to_bits);
        assert_eq!(
            bits,
            [
                4_604_204_935_514_355_597,
                4_605_034_898_129_617_804,
                4_605_324_238_331_407_933,
                4_583_439_441_564_520_153,
                4_585_656_592_696_660_570,
            ]
        );
    }
}
