//! The factor of a matrix, and what is solved with it.

use std::ops::Range;

use amd::Control;
use pulp::{Simd, WithSimd};

use super::supernodes::{NONE, ROWS, Supernode, supernodes};
use crate::geometry::arch;

/// Columns of a panel that are looked at together.
const COLUMNS: usize = 4;

/// The pattern of a symmetric matrix, and its factor.
pub struct Cholesky {
    /// Which row of the matrix each of the factor is.
    order: Vec<u32>,
    /// Where in the factor each entry of the matrix goes.
    places: Vec<u32>,
    supernodes: Vec<Supernode>,
    /// Which supernode a column is of.
    owners: Vec<u32>,
    /// Rows of supernodes, one after the other; their panels.
    rows: Vec<u32>,
    values: Vec<f64>,
    /// Workspace: where in the present panel a row is; the first supernode that has something for one, the next of these, and the
    /// first of its rows that is left; a right side.
    local: Vec<u32>,
    waiting: Vec<u32>,
    next: Vec<u32>,
    left: Vec<u32>,
    right: Vec<f64>,
    gathered: Vec<f64>,
}

impl Cholesky {
    /// Of the upper triangle with such first entries of its columns, and such rows of its entries in ascending order; none if it is too
    /// large.
    pub fn new(columns: Vec<u32>, rows: Vec<u32>) -> Option<Self> {
        let count = columns.len() - 1;
        let signed = |numbers: &[u32]| numbers.iter().map(|&number| i32::try_from(number).ok()).collect::<Option<Vec<_>>>();
        let (order, numbers, _) =
            amd::order(i32::try_from(count).ok()?, &signed(&columns)?, &signed(&rows)?, &Control::default()).ok()?;
        let [order, numbers] = [order, numbers].map(|all| all.into_iter().map(|number| number as u32).collect::<Vec<_>>());
        // Entries of the lower triangle in the order of the factor: column and row.
        let entry = |column: usize, row: u32| {
            let [a, b] = [numbers[column], numbers[row as usize]];
            [a.min(b), a.max(b)]
        };
        let column = |column: usize| &rows[columns[column] as usize..columns[column + 1] as usize];
        let entries: Vec<[u32; 2]> = (0..count).flat_map(|at| column(at).iter().map(move |&row| entry(at, row))).collect();
        let (supernodes, rows) = supernodes(count, &entries);
        let size = supernodes.last().map_or(0, |last| last.panel().end);
        u32::try_from(size).ok()?;
        let mut owners = vec![0; count];
        for (index, supernode) in (0..).zip(&supernodes) {
            owners[supernode.columns.clone()].fill(index);
        }
        let places = entries.iter().map(|&[column, row]| {
            let supernode = &supernodes[owners[column as usize] as usize];
            let at = rows[supernode.rows.clone()].partition_point(|&other| other < row);
            (supernode.panel + (column as usize - supernode.columns.start) * supernode.stride() + at) as u32
        });
        let highest = supernodes.iter().map(|node| node.rows.len()).max().unwrap_or_default();
        Some(Self {
            order,
            places: places.collect(),
            owners,
            values: vec![0.0; size],
            local: vec![0; count],
            waiting: vec![NONE; supernodes.len()],
            next: vec![NONE; supernodes.len()],
            left: vec![0; supernodes.len()],
            right: vec![0.0; count],
            gathered: vec![0.0; highest],
            supernodes,
            rows,
        })
    }

    /// Takes the values of the entries. Returns false if the matrix is not positive definite.
    pub fn factorise(&mut self, values: &[f64]) -> bool {
        self.values.fill(0.0);
        for (&place, value) in self.places.iter().zip(values) {
            self.values[place as usize] += value;
        }
        arch().dispatch(Factorise(self))
    }

    /// Replaces a right side by the solution for the values that were last factorised.
    pub fn solve(&mut self, right: &mut [f64]) {
        for (own, &row) in self.right.iter_mut().zip(&self.order) {
            *own = right[row as usize];
        }
        arch().dispatch(Solve(self));
        for (own, &row) in self.right.iter().zip(&self.order) {
            right[row as usize] = *own;
        }
    }
}

/// The sums over the columns of a panel of products of its entries, those of `ROWS` rows with those of `COLUMNS` others.
#[inline(always)]
fn products(panel: &[f64], stride: usize, row: usize, other: usize) -> [[f64; ROWS]; COLUMNS] {
    let mut sums = [[0.0; ROWS]; COLUMNS];
    for column in panel.chunks_exact(stride) {
        let (a, b) = (&column[row..][..ROWS], &column[other..][..COLUMNS]);
        for (sums, b) in sums.iter_mut().zip(b) {
            for (sum, a) in sums.iter_mut().zip(a) {
                *sum += a * b;
            }
        }
    }
    sums
}

struct Factorise<'a>(&'a mut Cholesky);

impl WithSimd for Factorise<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Cholesky { supernodes, owners, rows, values, local, waiting, next, left, .. } = self.0;
        waiting.fill(NONE);
        for (index, node) in (0..).zip(&*supernodes) {
            let own = &rows[node.rows.clone()];
            (0..).zip(own).for_each(|(place, &row)| local[row as usize] = place);
            let (before, panel) = values.split_at_mut(node.panel);
            let panel = &mut panel[..node.panel().len()];
            let mut giver = waiting[index as usize];
            while giver != NONE {
                let (from, first) = (&supernodes[giver as usize], left[giver as usize] as usize);
                let theirs = &rows[from.rows.clone()];
                let last = first + theirs[first..].partition_point(|row| (*row as usize) < node.columns.end);
                take(panel, node, local, &before[from.panel()], from, theirs, first..last);
                let following = next[giver as usize];
                hand_on(giver, theirs, last, owners, [waiting, next, left]);
                giver = following;
            }
            if !factorise_panel(panel, node) {
                return false;
            }
            hand_on(index, own, node.columns.len(), owners, [waiting, next, left]);
        }
        true
    }
}

/// Has a supernode wait for the owner of the first of its rows that are left, if there is one.
#[inline(always)]
fn hand_on(giver: u32, rows: &[u32], at: usize, owners: &[u32], [waiting, next, left]: [&mut [u32]; 3]) {
    if let Some(&row) = rows.get(at) {
        left[giver as usize] = at as u32;
        next[giver as usize] = std::mem::replace(&mut waiting[owners[row as usize] as usize], giver);
    }
}

/// Takes from a panel what another one has for it, whose rows `columns` are columns of this one. What is above the diagonal is not used.
#[inline(always)]
fn take(
    panel: &mut [f64],
    node: &Supernode,
    local: &[u32],
    theirs: &[f64],
    from: &Supernode,
    rows: &[u32],
    columns: Range<usize>,
) {
    for first in columns.clone().step_by(COLUMNS) {
        for row in (first..rows.len()).step_by(ROWS) {
            let sums = products(theirs, from.stride(), row, first);
            let rows_here = &rows[row..rows.len().min(row + ROWS)];
            for (sums, &column) in sums.iter().zip(&rows[first..columns.end]) {
                let panel = &mut panel[(column as usize - node.columns.start) * node.stride()..][..node.stride()];
                for (sum, &row) in sums.iter().zip(rows_here) {
                    panel[local[row as usize] as usize] -= sum;
                }
            }
        }
    }
}

/// Factorises the columns of a panel. Returns false if they are not positive definite.
#[inline(always)]
fn factorise_panel(panel: &mut [f64], node: &Supernode) -> bool {
    let (width, height, stride) = (node.columns.len(), node.rows.len(), node.stride());
    for first in (0..width).step_by(COLUMNS) {
        let (done, panel) = panel.split_at_mut(first * stride);
        let panel = &mut panel[..(width - first).min(COLUMNS) * stride];
        for row in (first..height).step_by(ROWS) {
            let sums = products(done, stride, row, first);
            for (column, sums) in panel.chunks_exact_mut(stride).zip(&sums) {
                column[row..][..ROWS].iter_mut().zip(sums).for_each(|(entry, sum)| *entry -= sum);
            }
        }
        for own in 0..panel.len() / stride {
            let diagonal = first + own;
            let (done, column) = panel.split_at_mut(own * stride);
            let column = &mut column[diagonal..height];
            for other in done.chunks_exact(stride) {
                let factor = other[diagonal];
                column.iter_mut().zip(&other[diagonal..height]).for_each(|(entry, other)| *entry -= other * factor);
            }
            let root = column[0].sqrt();
            if root.is_nan() || root <= 0.0 {
                return false;
            }
            column.iter_mut().for_each(|entry| *entry /= root);
        }
    }
    true
}

struct Solve<'a>(&'a mut Cholesky);

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Cholesky { supernodes, rows, values, right, gathered, .. } = self.0;
        for node in supernodes.iter() {
            let (own, below) = rows[node.rows.clone()].split_at(node.columns.len());
            let gathered = &mut gathered[..node.rows.len()];
            gathered.fill(0.0);
            for (place, (&row, column)) in own.iter().zip(values[node.panel()].chunks_exact(node.stride())).enumerate() {
                let x = (right[row as usize] - gathered[place]) / column[place];
                right[row as usize] = x;
                gathered[place + 1..].iter_mut().zip(&column[place + 1..]).for_each(|(sum, entry)| *sum += entry * x);
            }
            below.iter().zip(&gathered[own.len()..]).for_each(|(&row, sum)| right[row as usize] -= sum);
        }
        for node in supernodes.iter().rev() {
            let own = &rows[node.rows.clone()];
            let gathered = &mut gathered[..own.len()];
            gathered.iter_mut().zip(own).for_each(|(x, &row)| *x = right[row as usize]);
            for (place, column) in values[node.panel()].chunks_exact(node.stride()).enumerate().rev() {
                gathered[place] = (gathered[place] - dot(&column[place + 1..own.len()], &gathered[place + 1..])) / column[place];
            }
            let columns = node.columns.clone();
            right[columns.clone()].copy_from_slice(&gathered[..columns.len()]);
        }
    }
}

/// The sum of products, in `ROWS` sums side by side.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; ROWS];
    let (a, b) = (a.chunks_exact(ROWS), b.chunks_exact(ROWS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The upper triangle of a matrix with such pairs of columns, and its values: as stiff as springs along the line, and a little more.
    fn springs(count: usize, pairs: &[(usize, usize, f64)]) -> (Vec<u32>, Vec<u32>, Vec<f64>, Vec<Vec<f64>>) {
        let mut full = vec![vec![0.0; count]; count];
        (0..count).for_each(|at| full[at][at] = 0.1);
        for &(a, b, stiffness) in pairs {
            let [a, b] = [a % count, b % count];
            if a != b {
                full[a][a] += stiffness;
                full[b][b] += stiffness;
                full[a][b] -= stiffness;
                full[b][a] -= stiffness;
            }
        }
        let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for (column, entries) in full.iter().enumerate() {
            for (row, &entry) in entries[..=column].iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                rows.push(row as u32);
                values.push(entry);
            }
            columns.push(rows.len() as u32);
        }
        (columns, rows, values, full)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn what_is_solved_is_the_right_side(
            count in 1_usize..90,
            pairs in prop::collection::vec((0_usize..90, 0_usize..90, 0.01..100.0_f64), 0..400),
            near in prop::bool::ANY,
        ) {
            // Near pairs alone leave wide gaps, as cloth does; others fill the factor.
            let near = |(a, b, stiffness): (usize, usize, f64)| (a, if near { a + b % 4 } else { b }, stiffness);
            let pairs: Vec<_> = pairs.into_iter().map(near).collect();
            let (columns, rows, values, full) = springs(count, &pairs);
            let mut cholesky = Cholesky::new(columns, rows).expect("a small matrix");
            let right: Vec<f64> = (0..count).map(|at| (at * 37 % 101) as f64 - 50.0).collect();
            // Twice: what the first leaves must not stay.
            for scale in [3.0, 1.0] {
                let scaled: Vec<f64> = values.iter().map(|value| value * scale).collect();
                prop_assert!(cholesky.factorise(&scaled));
                let mut found = right.clone();
                cholesky.solve(&mut found);
                for (row, right) in full.iter().zip(&right) {
                    let sum: f64 = row.iter().zip(&found).map(|(entry, x)| entry * x * scale).sum();
                    let size: f64 = row.iter().zip(&found).map(|(entry, x)| (entry * x * scale).abs()).sum();
                    prop_assert!((sum - right).abs() <= 1e-12 * (size + 50.0), "{sum} for {right}");
                }
            }
            let factor = cholesky.values.clone();
            cholesky.values.fill(0.0);
            cholesky.places.iter().zip(&values).for_each(|(&place, value)| cholesky.values[place as usize] += value);
            prop_assert!(Factorise(&mut cholesky).with_simd(pulp::Scalar::new()));
            prop_assert_eq!(factor, cholesky.values, "other bits without vector registers");
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_told() {
        let (columns, rows, mut values, _) = springs(9, &[(0, 1, 2.0), (1, 5, 3.0), (5, 8, 1.0)]);
        let mut cholesky = Cholesky::new(columns.clone(), rows).expect("a small matrix");
        assert!(cholesky.factorise(&values));
        for bad in [-1.0, 0.0, f64::NAN] {
            // The last entry of a column lies on the diagonal.
            let kept = std::mem::replace(&mut values[columns[6] as usize - 1], bad);
            assert!(!cholesky.factorise(&values), "{bad} on the diagonal");
            values[columns[6] as usize - 1] = kept;
        }
        assert!(cholesky.factorise(&values));
    }
}
