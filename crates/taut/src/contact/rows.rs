//! What near pairs ask of displacements: half-spaces, and friction within Coulomb's cone.
//!
//! The row of a pair is `n . sum_i s_i (X_i + D_i) >= target`, with the normal n and the parts s of its closest points at X (or at the
//! time of impact). Rows are inequalities like the springs of the cloth, projected one after the other in the mass norm. Friction holds
//! back the tangential displacement `sum_i s_i D_i` of the step by an impulse of at most mu times that of the row, so that what sticks
//! does so for ever.

mod alone;
mod carriers;
mod crept;
mod cuts;
mod gripped;
mod index;
mod lanes;
mod pairs;
mod pinched;
mod stopped;
mod supports;
mod touching;
mod vertices;
mod wanted;

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::surfaces::Surfaces;
use super::untangle::Asked;
use super::{Places, floor};
use crate::geometry::{CHUNK, Pool, for_each_chunk, for_each_part, for_each_two_chunks};
use crate::model::{ClothRange, Model};
use alone::Alone;
use carriers::Told;
pub(crate) use carriers::{Carried, Carrier, RigidMotion};
use crept::Crept;
pub(crate) use gripped::Grip;
use gripped::Gripped;
use index::Index;
use lanes::Lanes;
use pairs::Stands;
use pinched::Pinched;
pub(crate) use supports::Support;
pub use touching::Touching;
pub(super) use vertices::square_stood_for;
use wanted::Wanted;

/// Rows that lack no more than this part of what lies between their target and the floor are as good as kept [1].
const GOOD: f64 = 0.25;
/// Where what is free has less than this part in a row [1] all of it counts as held: it would have to go so many times further than the row
/// asks.
const LEVER: f32 = 0.05;
const NONE: u32 = u32::MAX;

/// What keeps two features apart.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// The corners of each feature that count, in rising order: tells rows apart.
    key: [[u32; 3]; 2],
    /// Places in the workspace, and parts, of up to four vertices.
    ends: [u32; 4],
    parts: [f32; 4],
    normal: Vec3,
    /// The distance at X beyond the target [m].
    gap: f32,
    /// So much below that a row is good [m].
    slack: f32,
    /// The distance at X [m], the one that thicknesses ask for, and the one that the certificate does.
    distance: f32,
    thickness: f32,
    floor: f32,
    /// 1 / sum of parts^2 / M [kg]; nothing if all is held.
    give: f32,
    friction: f32,
    /// What the row has pushed, and held back along it, in this step [kg m].
    push: f32,
    hold: Vec3,
    /// What stands for its push where two bodies grip what it keeps off one of them [kg m].
    grips: f32,
    /// The same as the last cycle began.
    before: (f32, Vec3),
    /// The cloth, if there is one only.
    cloth: u32,
    /// How much further than its middle the surface of a turning ball or capsule goes, as the relative displacement counts [m].
    carried: Vec3,
}

/// A row as the levels of one cloth see it: they may use up the room, and no more.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Obstacle {
    /// Particles of the cloth, counted from its first, and their parts; zero where there are fewer.
    pub nodes: [(u32, f32); 4],
    pub normal: Vec3,
    /// How much nearer its nodes may come [m].
    pub room: f32,
    /// The row, and what it has pushed so far [kg m].
    pub row: u32,
    pub push: f32,
}

/// The rows of a step.
pub(crate) struct Rows {
    list: Vec<Row>,
    /// The vertices in rows; where each vertex stands among them.
    vertices: Vec<u32>,
    locals: Vec<u32>,
    /// Their displacements [m], those that the levels have, and inverse masses [1/kg].
    d: Vec<Vec3>,
    before: Vec<Vec3>,
    weights: Vec<f32>,
    /// Inverse masses of all vertices [1/kg].
    all_weights: Vec<f32>,
    particles: usize,
    /// What parts of the pairs want; the ends are vertices there.
    parts: Vec<Vec<Row>>,
    alone: Alone,
    lanes: Lanes,
    stands: Stands,
    pinched: Pinched,
    gripped: Gripped,
    index: Index,
    crept: Crept,
    told: Told,
}

impl Rows {
    pub fn new(model: &Model, surfaces: &Surfaces) -> Self {
        Self {
            list: Vec::new(),
            vertices: Vec::new(),
            locals: vec![NONE; surfaces.count()],
            d: Vec::new(),
            before: Vec::new(),
            weights: Vec::new(),
            all_weights: surfaces.weights.clone(),
            particles: model.particle_count(),
            parts: Vec::new(),
            alone: Alone::default(),
            lanes: Lanes::default(),
            stands: Stands::default(),
            pinched: Pinched::default(),
            gripped: Gripped::default(),
            index: Index::default(),
            crept: Crept::default(),
            told: Told::default(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    pub fn clear(&mut self) {
        for vertex in self.vertices.drain(..) {
            self.locals[vertex as usize] = NONE;
        }
        self.list.clear();
        self.alone.count = 0;
        self.pinched.any = false;
        self.gripped.list.clear();
        self.d.clear();
        self.before.clear();
        self.weights.clear();
    }

    /// Makes rows of what some things want.
    fn take_each<T: Copy + Sync>(
        &mut self,
        things: &[T],
        surfaces: &Surfaces,
        pool: &Pool,
        wanted: impl Fn(T) -> Option<Wanted> + Sync,
    ) {
        let mut parts = std::mem::take(&mut self.parts);
        let count = things.len().div_ceil(CHUNK);
        if parts.len() < count {
            parts.resize_with(count, Vec::new);
        }
        for_each_part(&mut parts[..count], things.len(), pool, |index, part| {
            part.clear();
            let things = things[index * CHUNK..].iter().take(CHUNK);
            part.extend(things.filter_map(|&thing| Some(self.row(surfaces, &wanted(thing)?))));
        });
        let first = self.list.len();
        parts[..count].iter().for_each(|part| self.list.extend_from_slice(part));
        self.parts = parts;
        self.number(first);
    }

    /// Makes rows of what brings intersecting things apart, without friction.
    pub fn take_asked(&mut self, surfaces: &Surfaces, list: &[Asked]) {
        for &Asked { corners, parts, split, normal, push } in list {
            let owners = [corners[0], corners[split]].map(|corner| surfaces.owners[corner as usize]);
            let thickness = surfaces.thickness(owners);
            let (distance, target, carried) = (0.0, push, DVec3::ZERO);
            let wanted = Wanted { corners, parts, split, owners, normal, distance, thickness, target, carried };
            self.add(Row { friction: 0.0, ..self.row(surfaces, &wanted) });
        }
    }

    /// What is wanted, with vertices as its ends.
    fn row(&self, surfaces: &Surfaces, wanted: &Wanted) -> Row {
        let Wanted { corners, parts, split, owners, normal, distance, thickness, target, carried } = *wanted;
        let floor = floor(surfaces.thickness(owners), distance.max(0.0));
        let mut key = [[NONE; 3]; 2];
        let mut counts = [0; 2];
        for end in (0..4).filter(|&end| parts[end] != 0.0) {
            let side = usize::from(end >= split);
            key[side][counts[side]] = corners[end];
            counts[side] += 1;
        }
        key.iter_mut().for_each(|side| side.sort_unstable());
        key.sort_unstable();
        let parts = parts.map(|part| part as f32);
        Row {
            key,
            ends: corners,
            parts,
            normal: normal.as_vec3(),
            gap: (distance - target) as f32,
            slack: (GOOD * (target - floor)) as f32,
            distance: distance as f32,
            thickness: thickness as f32,
            floor: floor as f32,
            give: 0.0,
            friction: surfaces.friction(owners) as f32,
            push: 0.0,
            hold: Vec3::ZERO,
            grips: 0.0,
            before: (0.0, Vec3::ZERO),
            cloth: surfaces.cloth_of(owners).unwrap_or(NONE),
            carried: carried.as_vec3() + self.crept.along(corners, parts, normal.as_vec3()),
        }
    }

    /// Adds a row whose ends are vertices.
    fn add(&mut self, row: Row) {
        self.list.push(row);
        self.number(self.list.len() - 1);
    }

    /// Gives rows from `first` on, whose ends are vertices, places in the workspace instead.
    fn number(&mut self, first: usize) {
        for index in first..self.list.len() {
            let Row { ends, parts, .. } = self.list[index];
            let ends = [0, 1, 2, 3].map(|end| if parts[end] == 0.0 { 0 } else { self.local(ends[end]) });
            let give = self.give(ends, parts);
            let row = &mut self.list[index];
            (row.ends, row.give) = (ends, give);
        }
    }

    /// What a row gives [kg]; nothing if all, or nearly all, is held.
    fn give(&self, ends: [u32; 4], parts: [f32; 4]) -> f32 {
        let own = ends.into_iter().zip(parts).filter(|(_, part)| *part != 0.0);
        let free = own.filter(|(end, _)| self.weights[*end as usize] > 0.0);
        let (lever, weight) = free.fold((0.0, 0.0), |(lever, weight), (end, part)| {
            (lever + part * part, weight + part * part * self.weights[end as usize])
        });
        if lever > LEVER * LEVER { 1.0 / weight } else { 0.0 }
    }

    /// The place of a vertex in the workspace.
    fn local(&mut self, vertex: u32) -> u32 {
        let local = &mut self.locals[vertex as usize];
        if *local == NONE {
            *local = self.vertices.len() as u32;
            self.vertices.push(vertex);
            self.d.push(Vec3::ZERO);
            self.before.push(Vec3::ZERO);
            self.weights.push(self.all_weights[vertex as usize]);
        }
        *local
    }

    /// Gives bodies their displacements in this step.
    fn load_bodies(&mut self, places: &Places) {
        for ((d, before), &vertex) in self.d.iter_mut().zip(&mut self.before).zip(&self.vertices) {
            if vertex as usize >= self.particles {
                *d = (places.ends[vertex as usize] - places.x[vertex as usize]).as_vec3();
                *before = *d;
            }
        }
    }

    /// The vertices in rows, in the order of what [`Rows::take`] and [`Rows::ways`] speak of.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Takes the displacements that a run of particles has so far [m].
    pub fn take(&mut self, run: Range<usize>, pool: &Pool, displacements: impl Fn(Range<usize>, &mut [Vec3]) + Sync) {
        let Self { d, before, .. } = self;
        for_each_two_chunks(&mut d[run.clone()], &mut before[run.clone()], pool, |first, d, before| {
            let first = run.start + first;
            displacements(first..first + d.len(), d);
            before.copy_from_slice(d);
        });
    }

    /// The displacements of a run of particles before the last sweeps, and now [m].
    pub fn ways(&self, run: Range<usize>) -> [&[Vec3]; 2] {
        [&self.before[run.clone()], &self.d[run]]
    }

    /// Whether all rows are as good as kept.
    pub fn are_kept(&self) -> bool {
        self.unkept_rows(0, |_| ())
    }

    fn is_kept(&self, row: &Row) -> bool {
        row.give == 0.0 || self.gap(row) >= -row.slack
    }

    /// The distance beyond the target now [m].
    fn gap(&self, row: &Row) -> f32 {
        let relative: Vec3 = (0..4).map(|end| self.d[row.ends[end] as usize] * row.parts[end]).sum();
        row.gap + row.normal.dot(relative)
    }

    /// The rows as a cloth sees them.
    pub fn obstacles(&self, cloth: &ClothRange, list: &mut Vec<Obstacle>, pool: &Pool) {
        let own = cloth.particles();
        let is_own = |end: &u32| own.contains(&(self.vertices[*end as usize] as usize));
        list.clear();
        let theirs =
            (0..).zip(&self.list).filter(|(_, row)| row.ends.iter().zip(row.parts).any(|(end, part)| part != 0.0 && is_own(end)));
        list.extend(theirs.map(|(row, _)| Obstacle { row, ..Obstacle::default() }));
        for_each_chunk(list, pool, |_, list| {
            for Obstacle { nodes, normal, room, row, push } in list {
                let number = *row as usize;
                let row = &self.list[number];
                for (node, (end, &part)) in nodes.iter_mut().zip(row.ends.iter().zip(&row.parts)) {
                    if part != 0.0 && is_own(end) {
                        *node = ((self.vertices[*end as usize] as usize - own.start) as u32, part);
                    }
                }
                *normal = row.normal;
                let (gap, pushed) = self.gap_and_push(number);
                (*room, *push) = (gap.max(0.0), pushed.max(0.0));
            }
        });
    }

    /// Brings their room and what they have pushed up to date.
    pub fn renew(&self, list: &mut [Obstacle], pool: &Pool) {
        for_each_chunk(list, pool, |_, list| {
            for Obstacle { room, row, push, .. } in list {
                let (gap, pushed) = self.gap_and_push(*row as usize);
                (*room, *push) = (gap.max(0.0), pushed.max(0.0));
            }
        });
    }

    /// Takes what coarse levels of a cloth have leant on a row [kg m]: it bears that as well. Of two cloths it goes unseen: the other one would
    /// have to take it on its own coarse levels.
    pub fn lean(&mut self, row: u32, push: f32) {
        let row = row as usize;
        // What is alone with its vertex lies on a body.
        if row < self.alone.count || self.list[row].cloth != NONE {
            *self.push_of(row) += push;
        }
    }

    /// The particles that rows have pushed in this step.
    pub fn pushed(&self) -> impl Iterator<Item = usize> {
        let rows = self.list.iter().filter(|row| row.push > 0.0);
        rows.flat_map(|row| (0..4).filter(|&end| row.parts[end] != 0.0).map(|end| self.vertices[row.ends[end] as usize] as usize))
            .filter(|&vertex| vertex < self.particles)
    }
}

impl Row {
    /// The places in the workspace of its vertices.
    fn locals(&self) -> impl Iterator<Item = usize> {
        self.ends.into_iter().zip(self.parts).filter(|(_, part)| *part != 0.0).map(|(end, _)| end as usize)
    }

    /// Whether it pushes something that can move.
    fn pushes(&self) -> bool {
        self.push > 0.0 && self.give > 0.0
    }

    /// Whether it tells how what it keeps off moves.
    fn carries(&self) -> bool {
        self.pushes() || self.grips > 0.0
    }

    /// Projects it. Tells which places in the workspace that moves, and how far [m].
    fn project(&mut self, d: &mut [Vec3], weights: &[f32], mut tell: impl FnMut(usize, Vec3)) {
        let ends = self.ends.map(|end| end as usize);
        let impulse = self.respond((0..4).map(|end| d[ends[end]] * self.parts[end]).sum());
        if impulse != Vec3::ZERO {
            for end in 0..4 {
                let share = self.parts[end] * weights[ends[end]];
                d[ends[end]] += impulse * share;
                if share != 0.0 {
                    tell(ends[end], impulse * share);
                }
            }
        }
    }

    /// What it adds to its impulse in answer to a relative displacement [kg m].
    fn respond(&mut self, relative: Vec3) -> Vec3 {
        let along = self.normal.dot(relative);
        // What other rows and the springs have done since may make a part of its push needless.
        let pushed = (self.push - (self.gap + along) * self.give).max(0.0) - self.push;
        self.push += pushed;
        let mut impulse = self.normal * pushed;
        // What no longer pushes holds nothing back either.
        if self.friction > 0.0 && (self.push > 0.0 || self.hold != Vec3::ZERO) {
            let sideways = relative - self.normal * along + self.carried;
            let hold = (self.hold - sideways * self.give).clamp_length_max(self.friction * self.push);
            impulse += hold - self.hold;
            self.hold = hold;
        }
        impulse
    }
}
