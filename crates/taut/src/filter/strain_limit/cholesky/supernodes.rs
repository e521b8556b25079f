//! The pattern of a factor: columns with the same rows together.

use std::ops::Range;

/// Rows of a panel that are looked at together.
pub(super) const ROWS: usize = 8;
/// A supernode takes in the next one as long as no more than these parts of both are zeros, if together they have no more columns
/// than that (Ashcraft and Grimes, ACM Trans. Math. Softw. 15(4), 1989).
const ZEROS: [(usize, f64); 3] = [(8, 0.8), (24, 0.3), (usize::MAX, 0.1)];
/// None, where a number would be.
pub(super) const NONE: u32 = u32::MAX;

/// Columns one after the other that have the same rows below them.
pub(super) struct Supernode {
    pub columns: Range<usize>,
    /// Its rows, those of its own columns first.
    pub rows: Range<usize>,
    /// Where its panel begins: a column after the other, each with room for the last rows to be looked at together.
    pub panel: usize,
}

impl Supernode {
    /// From one column of its panel to the next.
    pub fn stride(&self) -> usize {
        self.rows.len() + ROWS - 1
    }

    pub fn panel(&self) -> Range<usize> {
        self.panel..self.panel + self.columns.len() * self.stride()
    }
}

/// The supernodes of a factor, and their rows, from the entries of the lower triangle.
pub(super) fn supernodes(count: usize, entries: &[[u32; 2]]) -> (Vec<Supernode>, Vec<u32>) {
    // Columns in lists of the rows of the matrix.
    let mut starts = vec![0_u32; count + 1];
    entries.iter().for_each(|[column, _]| starts[*column as usize + 1] += 1);
    (0..count).for_each(|column| starts[column + 1] += starts[column]);
    let (mut ends, mut below) = (starts.clone(), vec![0; entries.len()]);
    for &[column, row] in entries {
        below[ends[column as usize] as usize] = row;
        ends[column as usize] += 1;
    }
    // Rows of each column of the factor below the diagonal: its own, and those of the columns that it is the first row of.
    let mut structures: Vec<Vec<u32>> = Vec::with_capacity(count);
    let (mut children, mut siblings) = (vec![NONE; count], vec![NONE; count]);
    let mut seen = vec![NONE; count];
    for column in 0..count {
        let mut structure = Vec::new();
        let mut take = |row: u32| {
            if row as usize > column && std::mem::replace(&mut seen[row as usize], column as u32) != column as u32 {
                structure.push(row);
            }
        };
        below[starts[column] as usize..starts[column + 1] as usize].iter().copied().for_each(&mut take);
        let mut child = children[column];
        while child != NONE {
            structures[child as usize].iter().copied().for_each(&mut take);
            child = siblings[child as usize];
        }
        structure.sort_unstable();
        if let Some(&parent) = structure.first() {
            siblings[column] = children[parent as usize];
            children[parent as usize] = column as u32;
        }
        structures.push(structure);
    }
    // Columns that have the rows of the one before; and these supernodes, with the next one where that brings few zeros.
    let is_next = |column: usize| structures[column - 1].first() == Some(&(column as u32));
    let is_head =
        |&column: &usize| column == 0 || !is_next(column) || structures[column - 1].len() != structures[column].len() + 1;
    let heads: Vec<usize> = (0..count).filter(is_head).collect();
    let mut merged: Vec<(Range<usize>, usize)> = Vec::new();
    for (index, &head) in heads.iter().enumerate() {
        merged.push((head..heads.get(index + 1).copied().unwrap_or(count), 0));
        while let [.., (first, zeros), (second, more)] = &merged[..]
            && is_next(second.start)
        {
            let entries = |columns: Range<usize>, end: usize| -> usize {
                columns.map(|column| end - column + structures[end - 1].len()).sum()
            };
            let added = entries(first.clone(), second.end) - entries(first.clone(), first.end);
            let (columns, zeros) = (first.start..second.end, zeros + more + added);
            let part = zeros as f64 / entries(columns.clone(), second.end) as f64;
            let most = ZEROS.iter().find(|(widest, _)| columns.len() <= *widest).map_or(0.0, |(_, most)| *most);
            if part > most {
                break;
            }
            merged.truncate(merged.len() - 2);
            merged.push((columns, zeros));
        }
    }
    let (mut nodes, mut rows, mut panel) = (Vec::with_capacity(merged.len()), Vec::new(), 0);
    for (columns, _) in merged {
        let first = rows.len();
        rows.extend(columns.clone().map(|column| column as u32));
        rows.extend_from_slice(&structures[columns.end - 1]);
        let node = Supernode { columns, rows: first..rows.len(), panel };
        panel = node.panel().end;
        nodes.push(node);
    }
    (nodes, rows)
}
