//! Wind (paper, section 2.2), in the classical form on triangles (and whole cells of grids) and in the paper's cheaper
//! form on particles.
//!
//! Both act on the velocity relative to the moving air; see docs/equations.md, "Wind", for how the printed scalar formulas
//! are read. However long the step, the impulse only slows what moves against the air and never turns it round ("Steps that
//! are too long for the air").

use glam::{Vec3, Vec4, Vec4Swizzles};
use pulp::{Arch, Simd, WithSimd};

use crate::geometry::{Pool, Vectors, VectorsChunk, for_each_chunk, sine_of_turns};
use crate::model::{Air, Flows, Model, Resistance, Wave};
use crate::scene::{WindLaw, WindModel};
use crate::state::Moment;

/// What two first passes leave for the particles to gather; empty without wind.
#[derive(Debug)]
pub(super) struct Wind {
    /// Velocity of each particle relative to the air around it [m/s].
    relative: Vectors,
    /// A corner's share of each panel: of its area vector [m^2] in the particle form, of its force [N] in the triangle form; and how
    /// long that is.
    panels: Vec<Vec4>,
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
        Self { relative: Vectors::zeros(particles), panels: vec![Vec4::ZERO; panels], phases: vec![0.0; waves], inertia }
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
        for_each_chunk(&mut self.panels, pool, |first, shares| {
            Arch::new().dispatch(OfPanels { model, air, moment, relative, inertia, first, shares });
        });
    }

    /// Second pass: the wind force on a particle [N].
    #[inline]
    pub(super) fn on_particle(&self, model: &Model, particle: usize) -> Vec3 {
        let Some(air) = &model.air else { return Vec3::ZERO };
        let around = model.panels.around.of(particle);
        let sum: Vec4 = around.iter().map(|&panel| self.panels[panel as usize]).sum();
        let (sum, area) = (sum.xyz(), sum.w);
        if air.model == WindModel::Triangle {
            return sum;
        }
        let length = sum.length();
        if length == 0.0 {
            return Vec3::ZERO;
        }
        let most = model.particles.mass[particle] / model.timing.step_length as f32;
        force(air, air.law, &model.particles.wind[particle], self.relative.get(particle), sum / length, area, most)
    }
}

/// The wind force [N] on an area [m^2] whose velocity relative to the air is V_rel; `most` is the inertia that it acts on over
/// the length of the step [kg/s].
#[inline(always)]
fn force(air: &Air, law: WindLaw, resistance: &Resistance, relative: Vec3, normal: Vec3, area: f32, most: f32) -> Vec3 {
    let across = match law {
        WindLaw::Pressure => pressure(relative, normal, area, air.density * resistance.drag, most),
        WindLaw::DragLift => drag_and_lift(relative, normal, 0.5 * air.density * area, resistance, most),
    };
    across + friction(relative, normal, 0.5 * air.density * resistance.friction * area, most)
}

/// `F_W = -1/2 rho C_d A |V_rel| (V_rel . N) N` (paper, section 2.2).
#[inline(always)]
fn pressure(relative: Vec3, normal: Vec3, area: f32, density_drag: f32, most: f32) -> Vec3 {
    normal * (-least(0.5 * density_drag * area * relative.length(), most) * relative.dot(normal))
}

/// Keckeisen et al. 2004: drag against V_rel on the area that the flow sees, `-1/2 rho C_d A |V_n| V_rel`, and lift at right
/// angles to V_rel in its plane with the normal, `-1/2 rho C_l A |V_rel| (V_n - |V_n|^2 / |V_rel|^2 V_rel)`, where
/// `V_n = (V_rel . N) N`.
#[inline(always)]
fn drag_and_lift(relative: Vec3, normal: Vec3, factor: f32, resistance: &Resistance, most: f32) -> Vec3 {
    let square = relative.length_squared();
    let speed = square.sqrt();
    let factor = least(factor, most / (speed * (resistance.drag + resistance.lift)));
    let across = relative.dot(normal);
    // Where nothing moves against the air, that is 0 / 0 without the floor.
    let lift =
        normal * across - relative * (across * across / if square > f32::MIN_POSITIVE { square } else { f32::MIN_POSITIVE });
    relative * (-factor * resistance.drag * across.abs()) - lift * (factor * resistance.lift * speed)
}

/// Skin friction `-1/2 rho C_f A |V_rel| V_t` along the cloth, `V_t = V_rel - (V_rel . N) N`.
#[inline(always)]
fn friction(relative: Vec3, normal: Vec3, factor: f32, most: f32) -> Vec3 {
    (relative - normal * relative.dot(normal)) * -least(factor * relative.length(), most)
}

/// The smaller one; `most` if that cannot be told. One instruction in vector registers, as `f32::min` is not.
#[inline(always)]
fn least(value: f32, most: f32) -> f32 {
    if value < most { value } else { most }
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

/// So many panels are looked at together.
const LANES: usize = 16;

/// What each corner gets of some panels: their area vectors [m^2] or the forces on them [N].
struct OfPanels<'a> {
    model: &'a Model,
    air: &'a Air,
    moment: Moment<'a>,
    relative: &'a Vectors,
    inertia: &'a [f32],
    /// Of the panels from this one on.
    first: usize,
    shares: &'a mut [Vec4],
}

/// Numbers of some panels, gathered from their corners.
#[derive(Default)]
struct Lanes {
    /// From corner to corner across the panel, both ways [m].
    diagonals: [[[f32; LANES]; 3]; 2],
    /// V_rel in the middle [m/s].
    relative: [[f32; LANES]; 3],
    share: [f32; LANES],
    /// [kg/s]
    most: [f32; LANES],
    resistance: [Resistance; LANES],
}

impl WithSimd for OfPanels<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { model, air, moment, relative, inertia, first, shares } = self;
        let per_step = 1.0 / model.timing.step_length as f32;
        let mut lanes = Lanes::default();
        for (run, shares) in shares.chunks_mut(LANES).enumerate() {
            for lane in 0..shares.len() {
                let panel = first + run * LANES + lane;
                lanes.gather(lane, model, moment, relative, panel);
                lanes.most[lane] = inertia[panel] * per_step;
            }
            // The laws are told apart out here, so that a loop has one of them.
            let [x, y, z, size] = match (air.model, air.law) {
                (WindModel::Particle, _) => lanes.each(|lanes, lane| lanes.area_vector(lane)),
                (WindModel::Triangle, WindLaw::Pressure) => lanes.each(|lanes, lane| lanes.force(lane, air, WindLaw::Pressure)),
                (WindModel::Triangle, WindLaw::DragLift) => lanes.each(|lanes, lane| lanes.force(lane, air, WindLaw::DragLift)),
            };
            for (lane, share) in shares.iter_mut().enumerate() {
                *share = Vec4::new(x[lane], y[lane], z[lane], size[lane]);
            }
        }
    }
}

impl Lanes {
    #[inline(always)]
    fn gather(&mut self, lane: usize, model: &Model, moment: Moment<'_>, relative: &Vectors, panel: usize) {
        let corners = model.panels.corners[panel].map(|corner| corner as usize);
        let share = model.panels.share[panel];
        let [a, b, c, d] = corners.map(|corner| moment.positions.get(corner));
        for (diagonal, way) in self.diagonals.iter_mut().zip([c - a, d - b]) {
            (diagonal[0][lane], diagonal[1][lane], diagonal[2][lane]) = (way.x, way.y, way.z);
        }
        let [a, b, c, d] = corners.map(|corner| relative.get(corner));
        // A triangle has its last corner twice; it counts once.
        let mean = (a + b + c + if corners[2] == corners[3] { Vec3::ZERO } else { d }) * share;
        (self.relative[0][lane], self.relative[1][lane], self.relative[2][lane]) = (mean.x, mean.y, mean.z);
        self.share[lane] = share;
        self.resistance[lane] = model.particles.wind[corners[0]];
    }

    /// The shares, coordinate by coordinate, and how long they are.
    #[inline(always)]
    fn each(&self, value: impl Fn(&Self, usize) -> Vec3) -> [[f32; LANES]; 4] {
        let [mut x, mut y, mut z, mut size] = [[0.0; LANES]; 4];
        for (lane, share) in self.share.iter().enumerate() {
            let share = value(self, lane) * *share;
            (x[lane], y[lane], z[lane], size[lane]) = (share.x, share.y, share.z, share.length());
        }
        [x, y, z, size]
    }

    #[inline(always)]
    fn area_vector(&self, lane: usize) -> Vec3 {
        let [one, other] = self.diagonals.each_ref().map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]));
        0.5 * one.cross(other)
    }

    #[inline(always)]
    fn force(&self, lane: usize, air: &Air, law: WindLaw) -> Vec3 {
        let area_vector = self.area_vector(lane);
        let area = area_vector.length();
        // A panel without an area has no normal, and no force.
        let normal = area_vector / if area > f32::MIN_POSITIVE { area } else { f32::MIN_POSITIVE };
        let relative = Vec3::new(self.relative[0][lane], self.relative[1][lane], self.relative[2][lane]);
        force(air, law, &self.resistance[lane], relative, normal, area, self.most[lane])
    }
}
