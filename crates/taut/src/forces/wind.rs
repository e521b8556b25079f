//! Wind (paper, section 2.2), in the classical form on triangles (panels) and in the paper's cheaper form on particles.
//!
//! Both act along the normal and on the velocity relative to the moving air; see docs/equations.md, "Wind", for how the
//! printed scalar formulas are read.

use glam::Vec3;

use crate::geometry::{Pool, Vectors, sine_of_turns};
use crate::model::{Air, Model};
use crate::scene::WindModel;
use crate::state::State;

/// What a first pass over the panels leaves for the particles to gather.
#[derive(Debug)]
pub(super) struct OnPanels {
    /// Area vectors [m^2] in the particle form, forces on one corner [N] in the triangle form; empty without wind.
    values: Vectors,
    /// Phase of each gust wave at the time of the step [turns].
    phases: Vec<f32>,
}

impl OnPanels {
    pub(super) fn new(model: &Model) -> Self {
        let panels = if model.air.is_some() { model.panels.corners.len() } else { 0 };
        let waves = model.air.as_ref().map_or(0, |air| air.waves.len());
        Self { values: Vectors::zeros(panels), phases: vec![0.0; waves] }
    }

    /// First pass: a value for each panel.
    pub(super) fn prepare(&mut self, model: &Model, state: &State, pool: &Pool) {
        let Some(air) = &model.air else { return };
        let time = state.time(model);
        for (phase, wave) in self.phases.iter_mut().zip(&air.waves) {
            *phase = (wave.phase - wave.turns_per_second * time).rem_euclid(1.0) as f32;
        }
        let phases = &self.phases;
        self.values.for_each_chunk(pool, |chunk| {
            chunk.map(|panel, _| {
                let corners = model.panels.corners[panel].map(|corner| corner as usize);
                let [a, b, c] = corners.map(|corner| state.positions.get(corner));
                let area_vector = (b - a).cross(c - a) * (0.5 * model.panels.weight[panel]);
                if air.model == WindModel::Particle {
                    return area_vector;
                }
                let area = area_vector.length();
                if area == 0.0 {
                    return Vec3::ZERO;
                }
                let mean = corners.map(|corner| state.velocities.get(corner)).iter().sum::<Vec3>() / 3.0;
                let relative = mean - velocity_at((a + b + c) / 3.0, air, phases);
                let drag = model.particles.drag_coefficient[corners[0]];
                force(relative, area_vector / area, area, air.density * drag) / 3.0
            });
        });
    }

    /// Second pass: the wind force on a particle [N].
    #[inline]
    pub(super) fn on_particle(&self, model: &Model, state: &State, particle: usize) -> Vec3 {
        let Some(air) = &model.air else { return Vec3::ZERO };
        let around = model.panels.around.of(particle);
        let values = around.iter().map(|&panel| self.values.get(panel as usize));
        if air.model == WindModel::Triangle {
            return values.sum();
        }
        let (mut sum, mut area) = (Vec3::ZERO, 0.0);
        for value in values {
            sum += value;
            area += value.length();
        }
        let length = sum.length();
        if length == 0.0 {
            return Vec3::ZERO;
        }
        let relative = state.velocities.get(particle) - velocity_at(state.positions.get(particle), air, &self.phases);
        let drag = model.particles.drag_coefficient[particle];
        force(relative, sum / length, area / 3.0, air.density * drag)
    }
}

/// `F_W = -1/2 rho C_d A |V_rel| (V_rel . N) N` [N], `V_rel` the velocity relative to the air.
#[inline]
fn force(relative: Vec3, normal: Vec3, area: f32, density_drag: f32) -> Vec3 {
    normal * (-0.5 * density_drag * area * relative.length() * relative.dot(normal))
}

/// Velocity of the air at a point [m/s]: the mean and the gusts.
#[inline]
fn velocity_at(point: Vec3, air: &Air, phases: &[f32]) -> Vec3 {
    let waves = air.waves.iter().zip(phases);
    waves.fold(air.velocity, |sum, (wave, &phase)| sum + wave.amplitude * sine_of_turns(wave.turns_per_metre.dot(point) + phase))
}
