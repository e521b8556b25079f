//! Strips over rods, with a weight at either end: what friction holds on a rod is what Euler and Eytelwein say.

use std::f64::consts::PI;

use crate::common::{Simulation, mesh_scene};
use glam::DVec3;
use serde_json::json;
use taut::model::MeshData;

const G: f64 = 9.81;
const DENSITY: f64 = 0.1;
const WIDTH: f64 = 0.05;
const HANGING: f64 = 0.2;
const LIGHT: f64 = 0.05;
/// Of the middle of the strip from the surface of the rod: the skin of the rod and half of the thickness of the strip.
const OFF: f64 = 0.002;
const ACROSS: u32 = 2;

/// Half round a rod along y, and down on both sides; quadrilaterals, or triangles off their places by up to a quarter of a cell.
fn strip(radius: f64, cell: f64, is_crooked: bool) -> (MeshData, u32) {
    let random = |seed: u32| (f64::from(seed) * 0.618_034).fract() - 0.5;
    let radius = radius + OFF + 1e-4;
    let length = PI * radius + 2.0 * HANGING;
    let along = (length / cell).round() as u32;
    let place = |s: f64, y: f64| match s - HANGING {
        s if s < 0.0 => DVec3::new(-radius, y, s),
        s if s < PI * radius => DVec3::new(-radius * (s / radius).cos(), y, radius * (s / radius).sin()),
        s => DVec3::new(radius, y, PI * radius - s),
    };
    let mut mesh = MeshData::default();
    for vertex in 0..(along + 1) * (ACROSS + 1) {
        let part = |at: u32, count: u32, seed: u32| {
            let off = if at == 0 || at == count || !is_crooked { 0.0 } else { 0.5 * random(seed) };
            (f64::from(at) + off) / f64::from(count)
        };
        let [s, y] = [part(vertex % (along + 1), along, 7 * vertex), part(vertex / (along + 1), ACROSS, 13 * vertex + 3)];
        mesh.vertices.push(place(length * s, WIDTH * (y - 0.5)).into());
    }
    for cell in 0..along * ACROSS {
        let a = i64::from(cell / along * (along + 1) + cell % along);
        let [b, c, d] = [a + 1, a + i64::from(along) + 2, a + i64::from(along) + 1];
        if is_crooked {
            mesh.corners.extend(if random(5 * cell) < 0.0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
            mesh.counts.extend([3, 3]);
        } else {
            mesh.corners.extend([a, b, c, d]);
            mesh.counts.push(4);
        }
    }
    (mesh, along)
}

/// The pull that just drags a strip over the rod against another, its own weight counted [N].
fn pull(friction: f64, light: f64, radius: f64) -> f64 {
    const STEPS: u32 = 10_000;
    let step = PI / f64::from(STEPS);
    (0..STEPS).fold(light, |force, index| {
        let (sine, cosine) = ((f64::from(index) + 0.5) * step).sin_cos();
        let own = DENSITY * WIDTH * G * (radius + OFF);
        force + step * (friction * (force + own * sine) + own * cosine)
    })
}

struct Capstan {
    run: Simulation,
    friction: f64,
    radius: f64,
    heavy: f64,
    /// Particles of the heavy end.
    end: Vec<usize>,
}

impl Capstan {
    /// With so much of the weight that would just make it slip.
    fn new(part: f64, friction: f64, radius: f64, is_crooked: bool) -> Self {
        let own = DENSITY * WIDTH * HANGING;
        let heavy = part * (pull(friction, (LIGHT + own) * G, radius) / G - own);
        let (mesh, along) = strip(radius, 0.016, is_crooked);
        let [left, right] = [0, along].map(|at| (0..=ACROSS).map(|row| row * (along + 1) + at).collect::<Vec<u32>>());
        let rod = json!({ "capsule": { "from": [0, -0.3, 0], "to": [0, 0.3, 0], "radius": radius }, "friction": friction });
        let cloth = json!({
            "density": DENSITY, "strain_limit": 0.02, "thickness": 0.002, "friction": friction, "air_drag": 0.0, "drag_coefficient": 0.0,
            "weights": [{ "vertices": left, "mass": LIGHT }, { "vertices": right, "mass": heavy }],
        });
        let run = Simulation::of(mesh_scene(json!({ "fps": 60, "body": [rod] }), cloth, mesh));
        let end = right.iter().map(|&vertex| run.model.numbering.particle(vertex) as usize).collect();
        Self { run, friction, radius, heavy, end }
    }

    fn height(&self) -> f64 {
        let heights = self.end.iter().map(|&particle| f64::from(self.run.state.positions.get(particle).z));
        heights.sum::<f64>() / self.end.len() as f64 + self.run.state.origins[0].z
    }

    fn frames(&mut self, count: u64) -> f64 {
        for _ in 0..count {
            let report = self.run.steps(self.run.model.schedule.substeps.into());
            assert!(report.worst_stretch <= 0.02 * (1.0 + 1e-5), "stretched by {}", report.worst_stretch);
            assert_eq!(report.contact_cuts, 0);
        }
        self.height()
    }

    /// How far the ratio of the tensions is from what makes it slide, by the acceleration of the ends [1].
    fn off(&mut self) -> f64 {
        self.frames(15);
        let heights: Vec<f64> = (0..3).map(|_| self.frames(6)).collect();
        let down = -(heights[2] - 2.0 * heights[1] + heights[0]) * 100.0;
        let own = DENSITY * WIDTH * HANGING;
        (self.heavy + own) * (G - down) / pull(self.friction, (LIGHT + own) * (G + down), self.radius) - 1.0
    }

    /// How fast it sinks once it hangs still [m/s].
    fn creep(&mut self) -> f64 {
        let before = self.frames(50);
        (before - self.frames(15)) * 4.0
    }
}

fn does_not_creep(is_crooked: bool, friction: f64, radius: f64) {
    let creep = Capstan::new(0.95, friction, radius, is_crooked).creep();
    assert!(creep.abs() < 1e-4, "{creep} m/s");
}

fn slides(is_crooked: bool, friction: f64, radius: f64) {
    let off = Capstan::new(1.2, friction, radius, is_crooked).off();
    assert!(off.abs() < 0.05, "off by {off}");
}

#[test]
fn a_grid_with_less_than_the_weight_that_slips_does_not_creep() {
    does_not_creep(false, 0.3, 0.08);
}

#[test]
fn a_mesh_with_less_than_the_weight_that_slips_does_not_creep() {
    does_not_creep(true, 0.3, 0.08);
}

#[test]
fn a_grid_with_more_slides_as_fast_as_the_tensions_say() {
    slides(false, 0.5, 0.08);
}

#[test]
fn a_mesh_with_more_slides_as_fast_as_the_tensions_say() {
    slides(true, 0.2, 0.05);
}
