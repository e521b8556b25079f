//! A scene becomes a model.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use xxhash_rust::xxh3::Xxh3;

use super::bending::{CurvedCloth, Row};
use super::extent;
use super::part::{Panel, Part};
use super::{
    Adjacency, Bend, Bending, Bodies, Borne, Buckling, ClothRange, ContactSettings, Curvatures, Curve, CurvedLink, CurvedSprings,
    Follows, Lattice, LevelRate, Link, MeshData, Model, Numbering, Origin, Panels, Particles, PinGroup, Resistance, SpringKind,
    Springs, bending, compatibility, curve::CurvesOfCloth, free::levels, grid, mesh, network, numbering, pins, precision,
    rates::Rates, thick, weights,
};
use crate::geometry::{Vectors, turn};
use crate::scene::{BendingModel, Cloth, FilterKind, PointMass, Scene, SceneError, Source};

/// Particle and spring numbers are 32 bits wide.
const MOST_PARTICLES: usize = i32::MAX as usize;

impl Model {
    /// Builds a model; `meshes` holds the geometry of every mesh that the scene names.
    ///
    /// # Errors
    /// A mesh of a cloth or a body is missing or unusable, a pin matches nothing, the solver can do nothing for a cloth.
    pub fn build(scene: &Scene, meshes: &BTreeMap<String, MeshData>) -> Result<Self, SceneError> {
        let mut assembly = Assembly { warnings: scene.warnings(), ..Assembly::default() };
        for (index, cloth) in scene.cloth.iter().enumerate() {
            let at = format!("cloth[{index}]");
            let (part, origin) = build_part(cloth, &at, meshes)?;
            assembly.add(scene, cloth, part, origin, &at)?;
        }
        let bodies = Bodies::build(scene, meshes, &mut assembly.warnings)?;
        assembly.finish(scene, bodies)
    }
}

fn build_part(cloth: &Cloth, at: &str, meshes: &BTreeMap<String, MeshData>) -> Result<(Part, Origin), SceneError> {
    let flexion = cloth.flexion_stiffness > 0.0 || buckles(cloth);
    let mut part = match cloth.sources().first() {
        Some(Source::Grid(source)) => grid::build(source, flexion),
        Some(Source::Network(source)) => network::build(source, flexion),
        Some(Source::Mesh(path)) => {
            let missing = || SceneError::with_value(format!("{at}.mesh"), format!("{path:?}"), "its geometry was not given");
            mesh::build(meshes.get(*path).ok_or_else(missing)?, &format!("{at}.mesh"), cloth.scale, flexion)?
        }
        None => return Err(SceneError::at(at, "needs one of grid, mesh, network")),
    };
    let placed = cloth.scale != 1.0 || cloth.rotate != [0.0; 3] || cloth.translate != [0.0; 3];
    if cloth.grid.is_none() {
        part.begin_at(Origin::near(DVec3::ZERO, &part.points).at);
    }
    if placed {
        let turn = turn(cloth.rotate);
        part.points.iter_mut().for_each(|point| *point = turn * (*point * cloth.scale));
        part.origin = turn * (part.origin * cloth.scale) + DVec3::from_array(cloth.translate);
    }
    let origin = Origin::near(part.origin, &part.points);
    part.begin_at(origin.at);
    if cloth.grid.is_none() {
        // What is at rest must be so in single precision, too; the springs of a grid are alike, and stay so.
        part.points.iter_mut().for_each(|point| *point = point.as_vec3().as_dvec3());
    }
    Ok((part, origin))
}

/// Cloths put together so far.
#[derive(Default)]
struct Assembly {
    cloths: Vec<ClothRange>,
    origins: Vec<Origin>,
    numbering: Numbering,
    particles: Particles,
    triangles: Vec<[u32; 3]>,
    panels: Vec<Panel>,
    springs: Vec<Spring>,
    bends: Vec<([u32; 2], f64)>,
    buckling: Vec<(u32, Buckling)>,
    /// The curves that springs follow, and the cloths that bend along one.
    curves: Vec<Curve>,
    curved_cloths: Vec<CurvedCloth>,
    pins: Vec<PinGroup>,
    /// Largest rate at which air of 1 kg/m^3 slows a particle per unit of relative wind speed [m^2/kg], without lift and with it; and
    /// in still air [1/s].
    wind_rate: [f64; 2],
    drag_rate: f64,
    warnings: Vec<String>,
}

struct Spring {
    ends: [u32; 2],
    kind: SpringKind,
    rest: f64,
    stiffness: f64,
    /// In place of the stiffness.
    follows: Option<Follows>,
    damping: f64,
    strain_limit: f64,
}

impl Assembly {
    fn add(&mut self, scene: &Scene, cloth: &Cloth, part: Part, origin: Origin, at: &str) -> Result<(), SceneError> {
        let first = self.particles.mass.len();
        if first + part.points.len() > MOST_PARTICLES {
            return Err(SceneError::at(at, format!("more than {MOST_PARTICLES} vertices in all")));
        }
        let material = cloth.material();
        self.warnings.extend(precision::check_lengths(cloth, &part, at)?);
        self.warnings.extend(part.notes.iter().map(|note| format!("{} ({at}): {note}", cloth.name)));
        let pins = pins::build(cloth, &part, at, first as u32, &mut self.warnings)?;
        let held = |vertex: u32| pins.iter().any(|group| group.particles.contains(&(vertex + first as u32)));
        let extra = weights::build(cloth, &part, at, held, &mut self.warnings)?;
        // All that the user says in numbers of vertices has been heard.
        let count = part.points.len();
        let numbers = if cloth.mesh.is_some() {
            numbering::near_together(count, part.springs.iter().map(|spring| spring.ends))
        } else {
            (0..count as u32).collect()
        };
        self.numbering.extend(&numbers);
        let part = if cloth.mesh.is_some() { part.renumbered(&numbers) } else { part };
        self.pins.extend(pins.into_iter().map(|group| PinGroup {
            cloth: self.cloths.len(),
            particles: group.particles.iter().map(|&vertex| self.numbering.particle(vertex)).collect(),
            ..group
        }));
        // One that is joined to others: what is loose may stay behind.
        let guide = part.springs.first().map_or(0, |spring| spring.ends[0]);
        self.origins.push(Origin { guide: guide + first as u32, ..origin });
        let areas = part.areas();
        let coefficients =
            [0.0, material.lift_coefficient].map(|lift| material.drag_coefficient + lift + cloth.friction_coefficient);
        for (index, point) in part.points.iter().enumerate() {
            let vertex = self.numbering.vertex((first + index) as u32) as usize - first;
            let own = match cloth.network.as_ref().map(|network| &network.mass) {
                Some(PointMass::One(mass)) => *mass,
                Some(PointMass::Each(masses)) => masses[vertex],
                None => material.density * areas[index],
            };
            let mass = own + extra[vertex];
            if mass > 0.0 {
                precision::check_mass(cloth, mass, areas[index], vertex, at)?;
            }
            let single = mass as f32;
            // Vertices without a face have no mass; they are held where they are.
            self.particles.inverse_mass.push(if single > 0.0 { 1.0 / single } else { 0.0 });
            self.particles.mass.push(single);
            // The air sees the cloth alone: its drag is k_A times the cloth's own mass.
            let own_part = if extra[vertex] > 0.0 { own / mass } else { 1.0 };
            self.particles.air_drag.push((material.air_drag * own_part) as f32);
            self.particles.wind.push(Resistance {
                drag: material.drag_coefficient as f32,
                lift: material.lift_coefficient as f32,
                friction: cloth.friction_coefficient as f32,
            });
            let rest = &mut self.particles.rest;
            let point = point.as_vec3();
            rest.x.push(point.x);
            rest.y.push(point.y);
            rest.z.push(point.z);
            if mass > 0.0 {
                for (rate, coefficient) in self.wind_rate.iter_mut().zip(coefficients) {
                    *rate = rate.max(coefficient * areas[index] / mass);
                }
            }
        }
        self.drag_rate = self.drag_rate.max(material.air_drag);
        let shift = first as u32;
        self.triangles.extend(part.triangles.iter().map(|corners| corners.map(|corner| corner + shift)));
        let shifted = |panel: &Panel| Panel { corners: panel.corners.map(|corner| corner + shift) };
        self.panels.extend(part.panels.iter().map(shifted));
        let moved = |([a, b], pull): ([u32; 2], f64)| ([a + shift, b + shift], pull);
        let curvatures = curvatures(cloth, &part);
        let rows = curvatures.len();
        let first_row = self.curved_cloths.iter().map(|cloth| cloth.rows.len()).sum::<usize>();
        let mut bends_along = 0;
        if let Some(curve) = cloth.curves.as_ref().and_then(|curves| curves.bending.as_ref()) {
            // The three second derivatives of a triangle together have no direction.
            let together = if cloth.mesh.is_some() { 3 } else { 1 };
            let curve = Curve::new(curve, f64::INFINITY, false);
            self.curved_cloths.push(CurvedCloth { rows: curvatures, together, first: shift, curve });
            bends_along = rows;
        } else {
            self.bends.extend(bending::pairs(&curvatures, cloth.bending()).into_iter().map(moved));
        }
        if buckles(cloth) {
            let seeds = part.springs.iter().filter(|seed| seed.kind == SpringKind::Flexion);
            self.buckling.extend(seeds.flat_map(|seed| {
                let rest = part.rest_length(seed.ends);
                // It is compressed like the two structural springs beneath it.
                let (breadth, compression) = if cloth.network.is_some() {
                    (1.0, 0.5 * material.stiffness)
                } else {
                    let breadth = seed.weight * cloth.scale;
                    (breadth, material.stiffness * breadth / rest)
                };
                // Springs two cells long overlap: each has half of the bending stiffness of its breadth of cloth.
                let half = 0.5 * cloth.bending() * breadth;
                let [a, b] = seed.ends.map(|end| end + shift);
                [(a, b), (b, a)].map(|(here, other)| (here, Buckling::new(other, rest, half, compression)))
            }));
        }
        let curves = CurvesOfCloth::new(cloth, scene.solver.filter, &mut self.curves);
        if curves.shears() && part.springs.iter().all(|seed| seed.kind != SpringKind::Shear) {
            let reason = "a mesh of triangles has no diagonals that could be sheared; its edges follow tension alone";
            self.warnings.push(format!("scene.{at}.curves.shear has no effect: {reason}"));
        }
        // It would double as it grows, and it is the largest list.
        self.springs.reserve(part.springs.len());
        let kept = part.springs.iter().filter(|seed| seed.kind.is_type1() || cloth.flexion_stiffness > 0.0);
        self.springs.extend(kept.map(|seed| {
            let follows = curves.of(seed, &part);
            let stiffness = match seed.kind {
                _ if follows.is_some() => 0.0,
                SpringKind::Structural => material.stiffness * seed.weight,
                SpringKind::Shear => material.shear_stiffness * seed.weight,
                SpringKind::Flexion => cloth.flexion_stiffness,
            };
            Spring {
                ends: seed.ends.map(|end| end + shift),
                kind: seed.kind,
                rest: part.rest_length(seed.ends),
                stiffness,
                follows,
                damping: if seed.kind.is_type1() { material.damping * seed.weight } else { 0.0 },
                strain_limit: if seed.kind.is_type1() { material.strain_limit } else { f64::INFINITY },
            }
        }));
        let name = cloth.name.clone();
        // Springs and lattice are known when all cloths are there.
        self.cloths.push(ClothRange {
            name,
            first,
            count,
            springs: 0..0,
            linked: None,
            curved: cloth.curves.as_ref().is_some_and(|curves| curves.tension.is_some() || curves.shear.is_some()),
            bends: cloth.bending() > 0.0 || bends_along > 0,
            curvatures: first_row..first_row + bends_along,
            is_network: cloth.network.is_some(),
            lattice: None,
            hierarchy: None,
            index: self.cloths.len(),
            size: 0.0,
            extends: None,
            imperfection: cloth.imperfection as f32,
            strain_limit: cloth.tightest_limit(),
            fastest: LevelRate::default(),
            rates: Vec::new(),
            borne: Borne::default(),
            heaviest: 0.0,
        });
        Ok(())
    }

    fn finish(mut self, scene: &Scene, bodies: Bodies) -> Result<Model, SceneError> {
        for group in &self.pins {
            for &particle in &group.particles {
                self.particles.inverse_mass[particle as usize] = 0.0;
            }
        }
        // Type 1 first: filters and reports walk over a prefix.
        self.springs.sort_by_key(|spring| !spring.kind.is_type1());
        let count = self.particles.mass.len();
        let springs = arrays(&self.springs, &self.curves, scene.solver.filter);
        let bending = Bending {
            quadratic: Bend::both_ways(count, &self.bends),
            buckling: Adjacency::new(count, self.buckling.into_iter()),
            curved: Curvatures::new(&self.particles, self.curved_cloths),
        };
        let around =
            (0..).zip(&self.panels).flat_map(|(index, panel)| panel.distinct().iter().map(move |&corner| (corner, index)));
        let mut lattices = Vec::new();
        let (mut next, mut linked) = (0, 0..);
        for (cloth, range) in scene.cloth.iter().zip(&mut self.cloths) {
            let particles = range.particles();
            let of_cloth = springs.ends[next..springs.type1].iter().take_while(|ends| particles.contains(&(ends[0] as usize)));
            range.springs = next..next + of_cloth.count();
            next = range.springs.end;
            range.size = extent::size(&springs, range.springs.clone(), &self.particles.rest);
            range.extends = extent::flat(&self.particles.rest, range.particles());
            if let Some(lattice) =
                cloth.grid.as_ref().filter(|_| !scene.has_contact()).and_then(|grid| Lattice::new(grid, range, &springs))
            {
                range.lattice = Some(lattices.len());
                lattices.push(lattice);
            }
            let is_linked = range.lattice.is_none() || cloth.flexion_stiffness > 0.0;
            range.linked = if is_linked { linked.next() } else { None };
        }
        let rates = Rates::new(&self.particles, &springs, &bending, self.drag_rate, self.wind_rate);
        let filter = scene.solver.filter;
        let hierarchies = levels(filter, &mut self.cloths, &self.particles, &springs, &bending, &self.triangles, &lattices);
        self.warnings.extend(compatibility::check(&scene.solver, &self.cloths, &springs, &self.particles)?);
        self.warnings.extend(thick::cautions(scene, &self.cloths, &springs, &self.numbering));
        let in_lattice = |index: &usize| self.cloths.iter().any(|cloth| cloth.lattice.is_some() && cloth.springs.contains(index));
        let listed: Vec<usize> = (0..springs.len()).filter(|index| !in_lattice(index)).collect();
        let both_ways = listed.iter().flat_map(|&index| {
            let [a, b] = springs.ends[index];
            let (rest, stiffness, damping) = (springs.rest[index], springs.force_stiffness[index], springs.damping[index]);
            [(a, b), (b, a)].map(|(here, other)| (here, Link { other, rest, stiffness, damping }))
        });
        let links = Adjacency::new(count, both_ways);
        let follow = |spring: &Spring| spring.follows.filter(|_| !spring.kind.is_left_to(scene.solver.filter));
        let curved = self.springs.iter().filter_map(|spring| follow(spring).map(|follows| (spring, follows)));
        let both_ways = curved.flat_map(|(&Spring { ends: [a, b], rest, .. }, follows)| {
            [(a, b), (b, a)].map(|(here, other)| (here, CurvedLink { other, rest: rest as f32, follows }))
        });
        let curved = CurvedSprings { links: Adjacency::new(count, both_ways), curves: self.curves };
        Ok(Model {
            contact: ContactSettings::of(scene, &self.cloths, &springs),
            lattices: lattices.into(),
            hierarchies: hierarchies.into(),
            links: links.into(),
            curved: curved.into(),
            bending: bending.into(),
            fingerprint: fingerprint(scene, &self.particles.rest, &springs, &bodies),
            panels: Arc::new(Panels {
                around: Adjacency::new(count, around),
                corners: self.panels.iter().map(|panel| panel.corners).collect(),
                share: self.panels.iter().map(|panel| 1.0 / panel.distinct().len() as f32).collect(),
            }),
            triangles: self.triangles.into(),
            cloths: self.cloths,
            origins: self.origins,
            numbering: self.numbering.into(),
            particles: self.particles,
            springs: springs.into(),
            pins: self.pins.into(),
            bodies: bodies.into(),
            solver: scene.solver.clone(),
            rates,
            warnings: self.warnings,
        })
    }
}

/// Second derivatives of a cloth that resists bending as a plate, in its size and place at rest.
fn curvatures(cloth: &Cloth, part: &Part) -> Vec<Row> {
    let along_curve = cloth.curves.as_ref().is_some_and(|curves| curves.bending.is_some());
    if !along_curve && (cloth.bending() == 0.0 || cloth.bending_model != BendingModel::Quadratic) {
        return Vec::new();
    }
    if let Some(grid) = &cloth.grid {
        return bending::grid(grid.cells, [0, 1].map(|axis| cloth.scale * grid.size[axis] / f64::from(grid.cells[axis])));
    }
    if cloth.network.is_some() {
        let links: Vec<[u32; 2]> = part.springs.iter().filter(|seed| seed.kind.is_type1()).map(|seed| seed.ends).collect();
        let lines = network::straight_lines(&part.points, &links);
        return lines.into_iter().map(|line| bending::network(&part.points, line)).collect();
    }
    bending::mesh(&part.points, &part.triangles)
}

/// Whether the cloth buckles at once under compression.
fn buckles(cloth: &Cloth) -> bool {
    cloth.bending() > 0.0 && cloth.bending_model == BendingModel::ChoiKo
}

fn arrays(list: &[Spring], curves: &[Curve], filter: FilterKind) -> Springs {
    let steepest = |spring: &Spring| {
        let slope = |follows: Follows| follows.steepest(&curves[follows.curve as usize], spring.rest);
        if spring.kind.is_left_to(filter) { 0.0 } else { spring.follows.map_or(0.0, slope) as f32 }
    };
    let unless = |left_out: bool, stiffness: f64| if left_out { 0.0 } else { stiffness as f32 };
    Springs {
        ends: list.iter().map(|spring| spring.ends).collect(),
        kind: list.iter().map(|spring| spring.kind).collect(),
        rest: list.iter().map(|spring| spring.rest as f32).collect(),
        stiffness: list.iter().map(|spring| unless(spring.kind.is_rod(filter), spring.stiffness)).collect(),
        force_stiffness: list.iter().map(|spring| unless(spring.kind.is_left_to(filter), spring.stiffness)).collect(),
        steepest: list.iter().map(steepest).collect(),
        damping: list.iter().map(|spring| spring.damping as f32).collect(),
        strain_limit: list.iter().map(|spring| spring.strain_limit as f32).collect(),
        type1: list.iter().filter(|spring| spring.kind.is_type1()).count(),
    }
}

/// Hash of the scene and of the geometry it led to.
fn fingerprint(scene: &Scene, rest: &Vectors, springs: &Springs, bodies: &Bodies) -> u64 {
    let mut hash = Xxh3::new();
    #[cfg(feature = "json")]
    hash.update(scene.to_json().as_bytes());
    #[cfg(not(feature = "json"))]
    hash.update(format!("{scene:?}").as_bytes());
    for point in rest.iter() {
        point.to_array().iter().for_each(|part| hash.update(&part.to_le_bytes()));
    }
    springs.ends.iter().flatten().for_each(|end| hash.update(&end.to_le_bytes()));
    bodies.rest.iter().flat_map(|place| place.to_array()).for_each(|part| hash.update(&part.to_le_bytes()));
    bodies.triangles.iter().flatten().for_each(|corner| hash.update(&corner.to_le_bytes()));
    hash.digest()
}
