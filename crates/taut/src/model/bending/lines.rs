//! Second derivatives where particles stand in lines: grids and networks.

use glam::DVec3;

use super::Row;

/// Central differences on a regular grid: along rows, along columns, and both at once in the middle of each cell.
pub(in crate::model) fn grid([nx, ny]: [u32; 2], cell: [f64; 2]) -> Vec<Row> {
    let id = |i: u32, j: u32| j * (nx + 1) + i;
    let inner = |index: u32, cells: u32| if index == 0 || index == cells { 0.5 } else { 1.0 };
    let area = cell[0] * cell[1];
    let mut rows = Vec::new();
    let mut line = |ids: [u32; 3], length: f64, area: f64| {
        let weight = area.sqrt() / (length * length);
        rows.push(Row { weights: vec![(ids[0], weight), (ids[1], -2.0 * weight), (ids[2], weight)], area });
    };
    for j in 0..=ny {
        (1..nx).for_each(|i| line([id(i - 1, j), id(i, j), id(i + 1, j)], cell[0], area * inner(j, ny)));
    }
    for j in 1..ny {
        (0..=nx).for_each(|i| line([id(i, j - 1), id(i, j), id(i, j + 1)], cell[1], area * inner(i, nx)));
    }
    let twist = (2.0 * area).sqrt() / area;
    let corners = |i, j| Row {
        weights: vec![(id(i, j), twist), (id(i + 1, j), -twist), (id(i + 1, j + 1), twist), (id(i, j + 1), -twist)],
        area,
    };
    rows.extend((0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).map(|(i, j)| corners(i, j)));
    rows
}

/// Curvature at the middle of three points of a network that follow one another.
pub(in crate::model) fn network(points: &[DVec3], [a, middle, b]: [u32; 3]) -> Row {
    let length = |end: u32| points[end as usize].distance(points[middle as usize]);
    let (before, after) = (length(a), length(b));
    let area = 0.5 * (before + after);
    let root = area.sqrt();
    let weights =
        vec![(a, 1.0 / (root * before)), (middle, -1.0 / (root * before) - 1.0 / (root * after)), (b, 1.0 / (root * after))];
    Row { weights, area }
}
