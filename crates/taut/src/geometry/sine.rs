//! A sine that gives the same bits on every machine.

/// sin(2 pi `turns`), within 5e-6, for less than four million turns.
///
/// The standard library's sine differs between platforms in the last bit. This odd polynomial (Taylor terms to the
/// ninth power on a quarter turn) uses additions and multiplications alone. The compiler can vectorise it.
#[inline(always)]
#[must_use]
pub fn sine_of_turns(turns: f32) -> f32 {
    // Adding and taking away 1.5 * 2^23 rounds to a whole number (ties to even) in two instructions on any machine.
    const ROUNDER: f32 = 12_582_912.0;
    let part = turns - ((turns + ROUNDER) - ROUNDER);
    // Fold the half turn on to the quarter turn: sin(pi - a) = sin(a).
    let folded = if part.abs() > 0.25 { 0.5_f32.copysign(part) - part } else { part };
    let angle = folded * std::f32::consts::TAU;
    let square = angle * angle;
    let tail = 1.0 / 362_880.0 * square - 1.0 / 5_040.0;
    let tail = (tail * square + 1.0 / 120.0) * square - 1.0 / 6.0;
    angle + angle * square * tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_true_sine() {
        for step in -4000..4000 {
            let turns = step as f32 / 1000.0;
            let exact = (f64::from(turns) * std::f64::consts::TAU).sin();
            let error = (f64::from(sine_of_turns(turns)) - exact).abs();
            assert!(error < 5e-6, "sine of {turns} turns is off by {error}");
        }
    }
}
