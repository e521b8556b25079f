//! Wind (paper, section 2.2), in the classical form on triangles (and whole cells of grids) and in the paper's cheaper
//! form on particles.
//!
//! Both act on the velocity relative to the moving air; see docs/equations.md, "Wind", for how the printed scalar formulas
//! are read. However long the step, the impulse only slows what moves against the air and never turns it round ("Steps that
//! are too long for the air").

use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::geometry::{Pool, Vectors, VectorsChunk, sine_of_turns};
use crate::model::{Air, Flows, Model, Resistance, Wave};
use crate::scene::{WindLaw, WindModel};
use crate::state::Moment;

/// What two first passes leave for the particles to gather; empty without wind.
#[derive(Debug)]
pub(super) struct Wind {
    /// Velocity of each particle relative to the air around it [m/s].
    relative: Vectors,
    /// A corner's share of each panel: of its area vector [m^2] in the particle form, of its force [N] in the triangle form.
    panels: Vectors,
    /// Phase of each gust wave at the time of the step [turns].
    phases: Vec<f32>,
    /// What gives way to an impulse on each panel [kg]; infinite where all corners are held.
    inertia: Vec<f32>,
}

impl Wind {
    pub(super) fn new(model: &Model) -> Self {
        let (particles, panels, waves) = match &model.air {
            Some(air) => (model.particle_count(), model.panels.corners.len(), air.waves.len()),
            None => (0, 0, 0),
        };
        let inertia = (0..panels).map(|panel| inertia_of_panel(model, panel)).collect();
        Self { relative: Vectors::zeros(particles), panels: Vectors::zeros(panels), phases: vec![0.0; waves], inertia }
    }

    /// First passes: the relative velocities, then a value for each panel.
    pub(super) fn prepare(&mut self, model: &Model, moment: Moment<'_>, pool: &Pool) {
        let Some(air) = &model.air else { return };
        let time = moment.time;
        for (phase, wave) in self.phases.iter_mut().zip(&air.waves) {
            *phase = (wave.phase - wave.turns_per_second * time).rem_euclid(1.0) as f32;
        }
        let phases = &self.phases;
        self.relative.for_each_chunk(pool, |mut chunk| relative_velocity(&mut chunk, air, phases, moment));
        let (relative, inertia) = (&self.relative, &self.inertia);
        self.panels.for_each_chunk(pool, |chunk| {
            chunk.map(|panel, _| share_of_panel(model, moment, relative, panel, inertia[panel]));
        });
    }

    /// Second pass: the wind force on a particle [N].
    #[inline]
    pub(super) fn on_particle(&self, model: &Model, particle: usize) -> Vec3 {
        let Some(air) = &model.air else { return Vec3::ZERO };
        let around = model.panels.around.of(particle);
        let values = around.iter().map(|&panel| self.panels.get(panel as usize));
        if air.model == WindModel::Triangle {
            return values.sum();
        }
        let (sum, area) = values.fold((Vec3::ZERO, 0.0), |(sum, area), value| (sum + value, area + value.length()));
        let length = sum.length();
        if length == 0.0 {
            return Vec3::ZERO;
        }
        let most = model.particles.mass[particle] / model.timing.step_length as f32;
        force(air, &model.particles.wind[particle], self.relative.get(particle), sum / length, area, most)
    }
}

/// The wind force [N] on an area [m^2] whose velocity relative to the air is V_rel; `most` is the inertia that it acts on over
/// the length of the step [kg/s].
#[inline]
fn force(air: &Air, resistance: &Resistance, relative: Vec3, normal: Vec3, area: f32, most: f32) -> Vec3 {
    let across = match air.law {
        WindLaw::Pressure => pressure(relative, normal, area, air.density * resistance.drag, most),
        WindLaw::DragLift => drag_and_lift(relative, normal, 0.5 * air.density * area, resistance, most),
    };
    if resistance.friction == 0.0 {
        return across;
    }
    across + friction(relative, normal, 0.5 * air.density * resistance.friction * area, most)
}

/// `F_W = -1/2 rho C_d A |V_rel| (V_rel . N) N` (paper, section 2.2).
#[inline]
fn pressure(relative: Vec3, normal: Vec3, area: f32, density_drag: f32, most: f32) -> Vec3 {
    let speed = relative.length();
    if 0.5 * density_drag * area * speed > most {
        return normal * (-most * relative.dot(normal));
    }
    normal * (-0.5 * density_drag * area * speed * relative.dot(normal))
}

/// Keckeisen et al. 2004: drag against V_rel on the area that the flow sees, `-1/2 rho C_d A |V_n| V_rel`, and lift at right
/// angles to V_rel in its plane with the normal, `-1/2 rho C_l A |V_rel| (V_n - |V_n|^2 / |V_rel|^2 V_rel)`, where
/// `V_n = (V_rel . N) N`.
#[inline]
fn drag_and_lift(relative: Vec3, normal: Vec3, factor: f32, resistance: &Resistance, most: f32) -> Vec3 {
    let speed = relative.length();
    if speed == 0.0 {
        return Vec3::ZERO;
    }
    let factor = factor.min(most / (speed * (resistance.drag + resistance.lift)));
    let across = relative.dot(normal);
    let lift = normal * across - relative * (across * across / (speed * speed));
    relative * (-factor * resistance.drag * across.abs()) - lift * (factor * resistance.lift * speed)
}

/// Skin friction `-1/2 rho C_f A |V_rel| V_t` along the cloth, `V_t = V_rel - (V_rel . N) N`.
#[inline]
fn friction(relative: Vec3, normal: Vec3, factor: f32, most: f32) -> Vec3 {
    (relative - normal * relative.dot(normal)) * -(factor * relative.length()).min(most)
}

/// `1 / m = sum of (share^2 n / M)` over the corners, n being the number of panels around each.
fn inertia_of_panel(model: &Model, panel: usize) -> f32 {
    let corners = model.panels.corners[panel];
    let distinct = if corners[2] == corners[3] { &corners[..3] } else { &corners[..] };
    let share = model.panels.share[panel];
    let give = |&corner: &u32| {
        let corner = corner as usize;
        share * share * model.panels.around.of(corner).len() as f32 * model.particles.inverse_mass[corner]
    };
    1.0 / distinct.iter().map(give).sum::<f32>()
}

/// V_rel = V - W(X), W being the mean wind, the gusts and the flows.
fn relative_velocity(chunk: &mut VectorsChunk<'_>, air: &Air, phases: &[f32], moment: Moment<'_>) {
    let run = chunk.first..chunk.first + chunk.x.len();
    let (mean, len) = (air.velocity, run.len());
    let (out_x, out_y, out_z) = (&mut chunk.x[..len], &mut chunk.y[..len], &mut chunk.z[..len]);
    let [x, y, z] = [&moment.positions.x, &moment.positions.y, &moment.positions.z].map(|column| &column[run.clone()]);
    let [u, v, w] = [&moment.velocities.x, &moment.velocities.y, &moment.velocities.z].map(|column| &column[run.clone()]);
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for i in 0..len {
                (out_x[i], out_y[i], out_z[i]) = (u[i] - mean.x, v[i] - mean.y, w[i] - mean.z);
            }
            for (Wave { amplitude, turns_per_metre, .. }, &phase) in air.waves.iter().zip(phases) {
                for i in 0..len {
                    let turns = turns_per_metre.x * x[i] + turns_per_metre.y * y[i] + turns_per_metre.z * z[i] + phase;
                    let sine = sine_of_turns(turns);
                    out_x[i] -= amplitude.x * sine;
                    out_y[i] -= amplitude.y * sine;
                    out_z[i] -= amplitude.z * sine;
                }
            }
        },
    );
    if air.flows != Flows::default() {
        Arch::new().dispatch(TakeFlows { flows: &air.flows, x, y, z, out: [out_x, out_y, out_z] });
    }
}

/// V_rel -= V of the flows.
struct TakeFlows<'a> {
    flows: &'a Flows,
    x: &'a [f32],
    y: &'a [f32],
    z: &'a [f32],
    out: [&'a mut [f32]; 3],
}

impl WithSimd for TakeFlows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { flows, x, y, z, out: [u, v, w] } = self;
        for vortex in &flows.vortices {
            take(x, y, z, [&mut *u, &mut *v, &mut *w], |place| vortex.velocity(place));
        }
        for outflow in &flows.outflows {
            take(x, y, z, [&mut *u, &mut *v, &mut *w], |place| outflow.velocity(place));
        }
    }
}

#[inline(always)]
fn take(x: &[f32], y: &[f32], z: &[f32], [u, v, w]: [&mut [f32]; 3], velocity: impl Fn([f32; 3]) -> [f32; 3]) {
    let len = x.len();
    let (y, z, u, v, w) = (&y[..len], &z[..len], &mut u[..len], &mut v[..len], &mut w[..len]);
    for i in 0..len {
        let air = velocity([x[i], y[i], z[i]]);
        (u[i], v[i], w[i]) = (u[i] - air[0], v[i] - air[1], w[i] - air[2]);
    }
}

/// What each corner gets of a panel: its area vector [m^2] or the force on it [N].
#[inline]
fn share_of_panel(model: &Model, moment: Moment<'_>, relative: &Vectors, panel: usize, inertia: f32) -> Vec3 {
    let Some(air) = &model.air else { return Vec3::ZERO };
    let corners = model.panels.corners[panel].map(|corner| corner as usize);
    let share = model.panels.share[panel];
    let [a, b, c, d] = corners.map(|corner| moment.positions.get(corner));
    let area_vector = 0.5 * (c - a).cross(d - b);
    if air.model == WindModel::Particle {
        return area_vector * share;
    }
    let area = area_vector.length();
    if area == 0.0 {
        return Vec3::ZERO;
    }
    let [a, b, c, d] = corners.map(|corner| relative.get(corner));
    // A triangle has its last corner twice; it counts once.
    let mean = (a + b + c + if corners[2] == corners[3] { Vec3::ZERO } else { d }) * share;
    let most = inertia / model.timing.step_length as f32;
    force(air, &model.particles.wind[corners[0]], mean, area_vector / area, area, most) * share
}
