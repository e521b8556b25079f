//! Neighbouring triangles must agree on which side is the front: the wind asks for mean normals.

use std::collections::VecDeque;

/// Turns triangles round until neighbours agree with the first of their connected piece; returns how many were turned.
///
/// An edge of three or more triangles joins nothing; a Moebius strip keeps one line where its sides disagree.
pub(super) fn make_consistent(triangles: &mut [[u32; 3]]) -> usize {
    let mut sides: Vec<([u32; 2], u32)> = triangles
        .iter()
        .enumerate()
        .flat_map(|(index, &[a, b, c])| [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], index as u32)))
        .collect();
    sides.sort_unstable();
    let mut neighbours = vec![Vec::new(); triangles.len()];
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(ends, one), (_, other)] = *edge {
            neighbours[one as usize].push((other, ends));
            neighbours[other as usize].push((one, ends));
        }
    }
    let mut seen = vec![false; triangles.len()];
    let mut queue = VecDeque::new();
    let mut turned = 0;
    for start in 0..triangles.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        queue.push_back(start);
        while let Some(index) = queue.pop_front() {
            for &(other, ends) in &neighbours[index] {
                let other = other as usize;
                if std::mem::replace(&mut seen[other], true) {
                    continue;
                }
                if runs_forwards(triangles[index], ends) == runs_forwards(triangles[other], ends) {
                    triangles[other].swap(1, 2);
                    turned += 1;
                }
                queue.push_back(other);
            }
        }
    }
    turned
}

/// Whether the triangle walks along the edge from its lower to its higher vertex.
fn runs_forwards([a, b, c]: [u32; 3], [low, high]: [u32; 2]) -> bool {
    [[a, b], [b, c], [c, a]].contains(&[low, high])
}

#[cfg(test)]
mod tests {
    use super::make_consistent;

    #[test]
    fn a_turned_triangle_is_turned_back() {
        let mut strip = [[0, 1, 2], [1, 2, 3], [2, 3, 4]];
        assert_eq!(make_consistent(&mut strip), 1);
        assert_eq!(strip, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    }
}
