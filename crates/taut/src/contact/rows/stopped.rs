//! What is held, by pins or by a user, stops where a body is in its way, and goes on along it.
//!
//! It goes where it is told, whatever that takes, and so do bodies: rows between them push nothing. Left to the certificate, the step would
//! be cut for all of the cloth, and the cloth would hang in the air for as long as its pins are told to go into a wall.

use super::Rows;
use crate::contact::Places;

/// What is held comes no nearer to a body by itself than this part of the thickness between them [1]: more than the certificate asks for, since
/// ways along what is curved are not those along its planes.
const KEEPS: f32 = 0.25;
/// What is left after a projection, as a part of the way [1].
const ROUNDING: f64 = 1e-6;
/// So often rows are looked at: what is in a corner has several.
const ROUNDS: usize = 8;

impl Rows {
    /// Shortens the ways of held vertices to where bodies leave them room. Tells which vertices that are, in rising order. What is inside of a
    /// body goes freely: so garments are fastened.
    pub fn stop_held(&self, places: &mut Places, stopped: &mut Vec<u32>) {
        stopped.clear();
        for _ in 0..ROUNDS {
            let mut any = false;
            for row in self.list.iter().filter(|row| row.give == 0.0 && row.distance > 0.0 && self.is_of_body(row)) {
                let normal = row.normal.as_dvec3();
                let vertex = |end: usize| self.vertices[row.ends[end] as usize] as usize;
                let is_held = |end: &usize| vertex(*end) < self.particles;
                let ends = (0..4).filter(|&end| row.parts[end] != 0.0);
                let along =
                    |end: usize| (places.ends[vertex(end)] - places.x[vertex(end)]).dot(normal) * f64::from(row.parts[end]);
                let all: f64 = ends.clone().map(along).sum();
                let own: f64 = ends.clone().filter(is_held).map(along).sum();
                // It is never pushed by a body.
                let room = f64::from((row.distance - KEEPS * row.thickness).max(0.0));
                let back = (-room - all).min(-own);
                if back <= ROUNDING * own.abs() {
                    continue;
                }
                let held = ends.filter(is_held);
                let squares: f64 = held.clone().map(|end| f64::from(row.parts[end] * row.parts[end])).sum();
                for end in held {
                    places.ends[vertex(end)] += normal * (back * f64::from(row.parts[end]) / squares);
                    stopped.push(vertex(end) as u32);
                }
                any = true;
            }
            if !any {
                break;
            }
        }
        stopped.sort_unstable();
        stopped.dedup();
    }
}
