//! Selective mass scaling: grids and meshes take springs and dampers in fewer parts than their fastest vibrations need.
//!
//! Velocities gain S F h instead of F h / M, with the sum over the levels of a cloth
//!
//! ```text
//! S = sum_l a_l P_l M_l^-1 P_l^T
//! ```
//!
//! P_l interpolates. M_l = P_l^T M are the masses that coarse particles carry. The a_l add up to one; on meshes each particle has its own. A
//! motion that a coarse level can show is accelerated as always. Finer vibrations are accelerated less, the faster they are. It is the sum of
//! Bramble, Pasciak & Xu 1990 [BPX90], as the inverse of a mass matrix in the sense of Olovsson, Simonsson & Unosson 2005 [Olovsson05]. S is
//! symmetric and positive, so nothing is damped, and where forces balance they still do. It keeps momentum where nothing is held
//! (docs/equations.md, "Scaled masses").

mod general;
mod lattice;

use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::schedule::ScaledTiming;
use general::GeneralMassLevels;
use lattice::LatticeMassLevels;

/// The levels of a cloth, with their shares.
pub(super) struct MassScaling {
    levels: Box<dyn MassLevels>,
    scales_dampers: bool,
}

/// What makes velocities gain something: each has shares of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Acting {
    Springs,
    Dampers,
}

/// Levels that can add `S M gains`.
trait MassLevels: Send + Sync {
    /// Gives the levels of a cloth the shares with which none has to bear more than this: w^2 [1/s^2] or g [1/s].
    fn share_out(&mut self, model: &Model, cloth: &ClothRange, acting: Acting, borne: f64);

    /// `velocities += S M gains` with the shares of what acts; gains of what is held are zero.
    fn add(&mut self, acting: Acting, gains: &Vectors, velocities: &mut Vectors, pool: &Pool);
}

impl MassScaling {
    /// Of a cloth with levels, for a step whose masses are scaled.
    pub fn new(model: &Model, cloth: &ClothRange, timing: &ScaledTiming) -> Option<Self> {
        let count = cloth.rates.len();
        let levels: Box<dyn MassLevels> = match cloth.lattice_of_levels() {
            Some(lattice) => Box::new(LatticeMassLevels::new(model, cloth, &model.lattices[lattice], count)),
            None => Box::new(GeneralMassLevels::new(cloth, &model.hierarchies[cloth.hierarchy?])),
        };
        let mut masses = Self { levels, scales_dampers: false };
        masses.share_out(model, cloth, timing);
        Some(masses)
    }

    /// Gives the levels the shares of another step.
    pub fn share_out(&mut self, model: &Model, cloth: &ClothRange, timing: &ScaledTiming) {
        self.levels.share_out(model, cloth, Acting::Springs, timing.frequency_squared);
        self.scales_dampers = timing.damping.is_some();
        if let Some(borne) = timing.damping {
            self.levels.share_out(model, cloth, Acting::Dampers, borne);
        }
    }

    /// `velocities += S M gains` of springs; gains of what is held are zero.
    pub fn add(&mut self, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        self.levels.add(Acting::Springs, gains, velocities, pool);
    }

    /// Whether dampers have shares, too.
    pub fn scales_dampers(&self) -> bool {
        self.scales_dampers
    }

    /// The same of dampers.
    pub fn add_damping(&mut self, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        self.levels.add(Acting::Dampers, gains, velocities, pool);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::{DVec3, Vec3};
    use serde_json::{Value, json};

    use super::*;
    use crate::forces::{Forces, gains};
    use crate::inputs::Inputs;
    use crate::model::MeshData;
    use crate::scene::Scene;
    use crate::schedule::{Plan, Schedule};

    /// A sheet, as a grid or as a crooked mesh of as many vertices, which is alike everywhere or finer and finer towards one corner; or a
    /// disc in so many rings and spokes, fine in the middle, whose rings are alike or each wider than the one within by the same factor.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Source {
        Grid,
        Mesh,
        Graded,
        Disc,
        Target,
    }

    fn model(source: Source, cells: [u32; 2], pins: Value, stiffness: f64) -> (Model, Plan) {
        let mut cloth = json!({ "density": 0.2, "stiffness": stiffness, "damping": 0.0, "pins": pins });
        let mut meshes = BTreeMap::new();
        match source {
            Source::Grid => cloth["grid"] = json!({ "size": [1.0, 0.8], "cells": cells, "axes": ["x", "y"] }),
            mesh => {
                cloth["mesh"] = json!("mesh");
                let mesh = match mesh {
                    Source::Mesh => crooked(cells),
                    Source::Graded => graded(cells),
                    Source::Target => disc(cells, |ring| (1.0 + 4.0 / 12.0_f64.max(cells[0].into())).powi(ring as i32) - 1.0),
                    _ => disc(cells, f64::from),
                };
                meshes.insert("mesh".to_owned(), mesh);
            }
        }
        let document = json!({ "cloth": [cloth], "gravity": [0.0, 0.0, 0.0] });
        let scene = Scene::from_json(&document.to_string()).expect("a valid scene");
        let model = Model::build(&scene, &meshes).expect("a valid model");
        let inputs = Inputs::new(&scene, &model, &BTreeMap::new()).expect("pins that stay");
        let schedule = Schedule::new(&scene, &model, &inputs).expect("a step");
        let plan = schedule.plan(&model, schedule.step_length);
        (model, plan)
    }

    /// Vertices off their places by up to a third of a cell, cells cut either way.
    fn crooked(cells: [u32; 2]) -> MeshData {
        let random = |seed: u32| (f64::from(seed) * 0.618_034).fract() - 0.5;
        let mut mesh = MeshData::default();
        let [nx, ny] = cells;
        for vertex in 0..(nx + 1) * (ny + 1) {
            let (i, j) = (vertex % (nx + 1), vertex / (nx + 1));
            let off = |at: u32, count: u32, seed: u32| if at == 0 || at == count { 0.0 } else { 0.66 * random(seed) };
            let x = (f64::from(i) + off(i, nx, 7 * vertex)) / f64::from(nx);
            let y = 0.8 * (f64::from(j) + off(j, ny, 13 * vertex + 3)) / f64::from(ny);
            mesh.vertices.push([x, y, 0.0]);
        }
        for cell in 0..nx * ny {
            let a = i64::from(cell / nx * (nx + 1) + cell % nx);
            let [b, c, d] = [a + 1, a + i64::from(nx) + 2, a + i64::from(nx) + 1];
            mesh.corners.extend(if random(5 * cell) < 0.0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
            mesh.counts.extend([3, 3]);
        }
        mesh
    }

    /// The same with edges that grow along both sides.
    fn graded(cells: [u32; 2]) -> MeshData {
        let mut mesh = crooked(cells);
        mesh.vertices.iter_mut().for_each(|[x, y, _]| (*x, *y) = (*x * *x, *y * *y / 0.8));
        mesh
    }

    /// A disc of 1 m around (0.5, 0.4), with rings of such radii.
    fn disc([rings, spokes]: [u32; 2], radius: impl Fn(u32) -> f64) -> MeshData {
        let mut mesh = MeshData { vertices: vec![[0.5, 0.4, 0.0]], ..MeshData::default() };
        for (ring, spoke) in (1..=rings).flat_map(|ring| (0..spokes).map(move |spoke| (ring, spoke))) {
            let (radius, angle) =
                (0.5 * radius(ring) / radius(rings), std::f64::consts::TAU * f64::from(spoke) / f64::from(spokes));
            mesh.vertices.push([0.5 + radius * angle.cos(), 0.4 + radius * angle.sin(), 0.0]);
        }
        let at = |ring: u32, spoke: u32| i64::from(1 + ring * spokes + spoke % spokes);
        for spoke in 0..spokes {
            mesh.corners.extend([0, at(0, spoke), at(0, spoke + 1)]);
            for ring in 1..rings {
                let [a, b, c, d] = [at(ring - 1, spoke), at(ring, spoke), at(ring, spoke + 1), at(ring - 1, spoke + 1)];
                mesh.corners.extend([a, b, c, a, c, d]);
            }
        }
        mesh.counts = vec![3; mesh.corners.len() / 3];
        mesh
    }

    /// A sheet of so many cells, if its masses are scaled.
    fn scaled(source: Source, cells: [u32; 2], pins: Value, stiffness: f64) -> Option<(Model, Plan, MassScaling)> {
        let (model, plan) = model(source, cells, pins, stiffness);
        let scaling = MassScaling::new(&model, &model.cloths[0], plan.of(&model.cloths[0]).scaled.as_ref()?)?;
        Some((model, plan, scaling))
    }

    /// Some velocities that differ from particle to particle, those of held ones zero.
    fn velocities(model: &Model, seed: f32) -> Vectors {
        let value = |particle: usize| {
            let phase = seed + particle as f32;
            let free = f32::from(model.particles.inverse_mass[particle] > 0.0);
            Vec3::new((12.9 * phase).sin(), (78.2 * phase).sin(), (37.7 * phase).sin()) * free
        };
        (0..model.particle_count()).map(value).collect()
    }

    /// Sum of M a b.
    fn product(model: &Model, a: &Vectors, b: &Vectors) -> f64 {
        let terms = a.iter().zip(b.iter()).zip(&model.particles.mass);
        terms.map(|((a, b), mass)| f64::from(*mass) * a.as_dvec3().dot(b.as_dvec3())).sum()
    }

    fn apply(scaling: &mut MassScaling, field: &Vectors) -> Vectors {
        let mut result = Vectors::zeros(field.len());
        scaling.add(field, &mut result, &Pool::new(1));
        result
    }

    /// Sheets of many sizes and stiffnesses whose masses are scaled, and what they are.
    fn sheets(pins: &Value) -> Vec<(String, Model, Plan, MassScaling)> {
        let mut sheets = Vec::new();
        for cells in [[3, 3], [5, 9], [16, 16], [31, 12], [40, 33]] {
            for (stiffness, source) in
                [1e3, 1e4].into_iter().flat_map(|k| [Source::Grid, Source::Mesh, Source::Disc].map(|source| (k, source)))
            {
                if let Some((model, plan, scaling)) = scaled(source, cells, pins.clone(), stiffness) {
                    sheets.push((format!("{source:?} {cells:?}, {stiffness} N/m"), model, plan, scaling));
                }
            }
        }
        assert!(sheets.len() >= 10, "{}", sheets.len());
        sheets
    }

    #[test]
    fn a_field_without_differences_passes_and_momentum_is_kept() {
        for (sheet, model, _, mut scaling) in sheets(&json!([])) {
            let even = (0..model.particle_count()).map(|_| Vec3::new(1.0, -2.0, 0.5)).collect();
            for value in apply(&mut scaling, &even).iter() {
                assert!(value.abs_diff_eq(Vec3::new(1.0, -2.0, 0.5), 1e-5), "{sheet}: {value}");
            }
            let momentum = |field: &Vectors| {
                field.iter().zip(&model.particles.mass).map(|(v, mass)| v.as_dvec3() * f64::from(*mass)).sum::<DVec3>()
            };
            let field = velocities(&model, 0.3);
            let off = momentum(&apply(&mut scaling, &field)) - momentum(&field);
            assert!(off.length() < 1e-6, "{sheet}: {off}");
        }
    }

    #[test]
    fn it_is_symmetric_and_positive_and_moves_nothing_that_is_held() {
        let pins = json!([{ "nearest": [0.0, 0.8, 0.0] }, { "nearest": [0.4, 0.3, 0.0] }]);
        for (sheet, model, plan, mut scaling) in sheets(&pins) {
            let (a, b) = (velocities(&model, 0.1), velocities(&model, 0.7));
            let (of_a, of_b) = (apply(&mut scaling, &a), apply(&mut scaling, &b));
            let (one, other) = (product(&model, &of_a, &b), product(&model, &a, &of_b));
            let size = product(&model, &a, &a);
            assert!((one - other).abs() < 1e-6 * size, "{sheet}: {one} {other}");
            let kept = product(&model, &of_a, &a);
            let borne = plan.cloths[0].scaled.expect("masses are scaled").frequency_squared;
            let least = (borne / model.cloths[0].rates[0].frequency_squared).min(1.0);
            assert!(kept > 0.99 * least * size && kept < 1.001 * size, "{sheet}: {kept} of {size}");
            for (value, weight) in of_a.iter().zip(&model.particles.inverse_mass) {
                assert!(*weight > 0.0 || value == Vec3::ZERO);
            }
        }
    }

    #[test]
    fn no_vibration_is_faster_than_the_step_bears() {
        let mut found = 0;
        for (cells, pins, stiffness) in [
            ([20, 20], json!([]), 40.0),
            ([33, 17], json!([{ "nearest": [0.0, 0.8, 0.0] }]), 20.0),
            ([62, 45], json!([{ "nearest": [0.0, 0.8, 0.0] }, { "nearest": [1.0, 0.8, 0.0] }]), 20.0),
            ([12, 12], json!([{ "nearest": [0.0, 0.8, 0.0] }]), 5e4),
            ([130, 21], json!([]), 20.0),
            ([98, 75], json!([{ "nearest": [0.31, 0.4, 0.0] }]), 20.0),
            ([24, 40], json!([{ "box": [[-0.01, -1, -1], [0.01, 1, 1]] }, { "nearest": [0.53, 0.41, 0.0] }]), 20.0),
        ] {
            for source in [Source::Grid, Source::Mesh, Source::Graded, Source::Disc, Source::Target] {
                let Some((model, plan, mut scaling)) = scaled(source, cells, pins.clone(), stiffness) else { continue };
                found += 1;
                let timing = plan.cloths[0].scaled.expect("masses are scaled");
                // The largest eigenvalue by power iteration on small displacements.
                let (pool, mut forces, all) = (Pool::new(1), Forces::new(&model), 0..model.particle_count());
                let mut mode = velocities(&model, 0.2);
                let mut square = 0.0;
                for _ in 0..200 {
                    let small = 1e-4 / product(&model, &mode, &mode).sqrt();
                    let (mut moved, mut gained) = (model.particles.rest.clone(), Vectors::zeros(all.len()));
                    moved.add_scaled(all.clone(), &mode, small as f32, &pool);
                    gains(&model, &model.cloths[0], &moved, &mut gained, 1.0, &mut forces, &pool);
                    mode = apply(&mut scaling, &gained);
                    square = product(&model, &mode, &mode).sqrt() / 1e-4;
                }
                let part = plan.length / f64::from(timing.parts);
                let (vibrates, damped) = (part * part * square, part * square * timing.springs_ahead);
                // How far levels add up is found for each mesh, and known of grids on the whole.
                let most = if source == Source::Grid { 4.0 } else { 3.3 };
                assert!(vibrates + 2.0 * damped < most, "{source:?} {cells:?}: {vibrates} {damped}");
                assert!(vibrates + 2.0 * damped > 0.8, "{source:?} {cells:?}: needlessly slow, {vibrates} {damped}");
            }
        }
        assert!(found >= 15, "{found}");
    }

    #[test]
    fn a_mesh_that_is_much_finer_in_places_takes_few_parts() {
        let pins = json!([{ "nearest": [1.0, 0.4, 0.0] }]);
        for (source, cells) in [(Source::Target, [12, 24]), (Source::Target, [8, 48]), (Source::Graded, [40, 40])] {
            let (model, plan, mut scaling) = scaled(source, cells, pins.clone(), 100.0).expect("masses are scaled");
            let cloth = &plan.cloths[0];
            assert!(30 * cloth.parts() < cloth.spring_steps, "{source:?}: {} of {}", cloth.parts(), cloth.spring_steps);
            let is_free = |particle: usize| f32::from(model.particles.inverse_mass[particle] > 0.0);
            let even: Vectors = (0..model.particle_count()).map(|particle| Vec3::X * is_free(particle)).collect();
            let moved = product(&model, &apply(&mut scaling, &even), &even) / product(&model, &even, &even);
            assert!(moved > 0.9, "{source:?}: an even load gives {moved} of its acceleration");
        }
    }

    #[test]
    fn masses_are_scaled_only_where_a_mesh_is_fine() {
        let (model, _, mut scaling) = scaled(Source::Disc, [24, 96], json!([]), 1.0).expect("masses are scaled");
        let rest: Vec<Vec3> = model.particles.rest.iter().collect();
        let middle = rest.iter().sum::<Vec3>() / rest.len() as f32;
        // Neighbours go apart, so that coarse levels see next to nothing of it.
        let shaking = velocities(&model, 0.3);
        let kept = apply(&mut scaling, &shaking);
        let kept = |from: f32, to: f32| {
            let within = (0..rest.len()).filter(|&particle| (from..to).contains(&rest[particle].distance(middle)));
            let [kept, all] =
                within.fold([0.0, 0.0], |[kept_of, all], p| [kept_of + kept.get(p).length(), all + shaking.get(p).length()]);
            kept / all
        };
        assert!(kept(0.0, 0.1) < 0.4, "in the middle: {}", kept(0.0, 0.1));
        assert!(kept(0.4, 1.0) > 0.8, "near the rim: {}", kept(0.4, 1.0));
    }
}
