//! Grids of stride 1, 2, 4 ..: each has every second column and row of the one before it, and its particles follow it by halves.

/// How many coarse columns (or rows) `count` fine ones have.
#[must_use]
pub fn coarsened(count: usize) -> usize {
    count.div_ceil(2)
}

/// The two coarse neighbours of a fine column (or row), each with weight 1/2. It is the same one twice where the column is sampled
/// itself, and beyond the last coarse one. A coarse cell that is narrower than the others would be stiffer than its level bears.
#[must_use]
pub fn parents(fine: usize, count: usize) -> [usize; 2] {
    if fine.is_multiple_of(2) || fine + 1 == count { [fine / 2; 2] } else { [fine / 2, fine / 2 + 1] }
}

/// P^T M one grid up; nothing where that would carry what is held.
#[must_use]
pub fn carry(masses: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    let coarse_columns = coarsened(columns);
    let mut carried = vec![0.0; coarse_columns * coarsened(rows)];
    let mut held = vec![false; carried.len()];
    for (index, &mass) in masses.iter().enumerate() {
        for j in parents(index / columns, rows) {
            for i in parents(index % columns, columns) {
                carried[j * coarse_columns + i] += 0.25 * mass;
                held[j * coarse_columns + i] |= mass == 0.0;
            }
        }
    }
    carried.iter().zip(held).map(|(&mass, held)| if held { 0.0 } else { mass }).collect()
}
