//! What sticks is to stay for good. Sweeps end where little is left, and what they leave of each step would add up to a creep: it is
//! remembered, and friction takes it back in the steps that follow, within its cone.

use glam::Vec3;

use super::{Row, Rows};
use crate::contact::Places;
use crate::geometry::Vectors;

/// What uses up this part of its cone slides [1].
const SLIDES: f32 = 0.999;

/// How far particles have crept before the step [m], none for those after the last of them; and workspace.
#[derive(Debug, Default)]
pub(super) struct Crept {
    before: Vectors,
    /// Of each place in the workspace the sum of what rows say, weighted by their pushes, and of these weights.
    sums: Vec<(Vec3, f32)>,
}

impl Crept {
    /// How far two features have crept along each other, across a normal.
    pub fn along(&self, corners: [u32; 4], parts: [f32; 4], normal: Vec3) -> Vec3 {
        let of = |corner: u32| if (corner as usize) < self.before.len() { self.before.get(corner as usize) } else { Vec3::ZERO };
        let all: Vec3 =
            corners.into_iter().zip(parts).filter(|(_, part)| *part != 0.0).map(|(corner, part)| of(corner) * part).sum();
        all - normal * normal.dot(all)
    }
}

impl Rows {
    /// Takes how far particles have crept before the step.
    pub fn take_crept(&mut self, crept: &Vectors) {
        self.crept.before.clone_from(crept);
    }

    /// Tells how far they have at its end: nothing where they touch nothing, or slide.
    pub fn tell_crept(&mut self, places: &Places, crept: &mut Vectors) {
        for column in [&mut crept.x, &mut crept.y, &mut crept.z] {
            column.fill(0.0);
        }
        let mut sums = std::mem::take(&mut self.crept.sums);
        sums.clear();
        sums.resize(self.vertices.len(), (Vec3::ZERO, 0.0));
        for row in self.list.iter().filter(|row| row.pushes()) {
            let way = if row.slides() { Vec3::ZERO } else { self.crept_along(row, places) };
            // Two features have their shares by how easily they move; together they have all of it.
            let weight = |end: usize| row.parts[end] * row.parts[end] * self.weights[row.ends[end] as usize];
            let share = |sign: f32| (0..4).filter(|&end| row.parts[end] * sign > 0.0).map(weight).sum::<f32>() * row.give * sign;
            let shares = [1.0, -1.0].map(share);
            for end in (0..4).filter(|&end| row.parts[end] != 0.0) {
                let (share, by) = (shares[usize::from(row.parts[end] < 0.0)], row.push * row.parts[end].abs());
                let (sum, all) = &mut sums[row.ends[end] as usize];
                *sum += way * (share * by);
                *all += by;
            }
        }
        for (&vertex, &(sum, all)) in self.vertices.iter().zip(&sums).filter(|(_, (_, all))| *all > 0.0) {
            if (vertex as usize) < self.particles {
                crept.set(vertex as usize, sum / all);
            }
        }
        self.crept.sums = sums;
    }

    /// How far the features of a row have crept along each other, with what they had before the step; at most as far as it is good for.
    fn crept_along(&self, row: &Row, places: &Places) -> Vec3 {
        let of = |end: usize| {
            let vertex = self.vertices[row.ends[end] as usize] as usize;
            (places.ends[vertex] - places.x[vertex]).as_vec3() * row.parts[end]
        };
        let way: Vec3 = (0..4).filter(|&end| row.parts[end] != 0.0).map(of).sum();
        (way - row.normal * row.normal.dot(way) + row.carried).clamp_length_max(row.slack)
    }
}

impl Row {
    fn slides(&self) -> bool {
        self.hold.length() >= SLIDES * self.friction * self.push
    }
}
