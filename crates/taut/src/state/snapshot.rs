//! A state, and what a user holds, as bytes, and back.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};
use xxhash_rust::xxh3::xxh3_64;

use super::{Behind, Calm, Clock, Offset, Past, State};
use crate::geometry::Vectors;
use crate::inputs::{BodyForm, BodyShift, Grips, Target};
use crate::model::Model;
use crate::schedule::{Halving, Sleep};

/// First bytes of every snapshot; the last one is the version of the layout, in base 36.
const MAGIC: [u8; 8] = *b"TAUTSNPD";
const CHECKSUM: usize = 8;

/// Bytes that are no snapshot of this model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// Not from taut, or from a version that writes others.
    #[error("these bytes are not a taut snapshot (version 13)")]
    NotASnapshot,
    /// Cut short or altered since they were taken: the checksum does not fit.
    #[error("the snapshot is damaged: its checksum does not fit; take another one")]
    Damaged,
    /// From a simulation of other cloths, bodies or settings.
    #[error("the snapshot belongs to another scene; restore it into a simulation of the scene it was taken from")]
    OtherModel,
}

impl State {
    /// The state and what a user holds as bytes, little-endian. In this order:
    ///
    /// - magic, fingerprint, steps and time, origins;
    /// - the coordinate arrays of positions, V, velocities of the motion and the past, if any;
    /// - how calm cloths are, offsets of pins, places of bodies and how they come back to their paths;
    /// - whether anything may intersect, in how many parts steps are taken, how near it is to sleep, loads that brakes are for, how far particles have crept;
    /// - held particles that are behind their places;
    /// - held particles, hands, moved pins, bodies whose vertices were told, moved bodies;
    /// - XXH3 of all these.
    #[must_use]
    pub fn to_bytes(&self, model: &Model, grips: &Grips) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(128 + 36 * self.positions.len() + 24 * self.past.gains.len());
        bytes.extend(MAGIC);
        let Clock { steps, start, run, length } = self.clock;
        let numbers = [model.fingerprint, steps, start.to_bits(), run, length.to_bits(), self.past.length.to_bits()];
        bytes.extend(numbers.into_iter().flat_map(u64::to_le_bytes));
        bytes.extend(self.origins.iter().flat_map(|origin| origin.to_array()).flat_map(f64::to_le_bytes));
        let all = [&self.positions, &self.velocities, &self.motion, &self.past.displacements, &self.past.gains];
        for column in all.into_iter().flat_map(|vectors| [&vectors.x, &vectors.y, &vectors.z]) {
            bytes.extend(column.iter().flat_map(|value| value.to_le_bytes()));
        }
        for Calm { cycles, room, brake } in &self.calm {
            bytes.extend(cycles.to_le_bytes());
            bytes.extend([room, brake].into_iter().flat_map(|part| part.to_le_bytes()));
        }
        bytes.extend(self.offsets.iter().flat_map(Offset::numbers).flat_map(f64::to_le_bytes));
        bytes.extend(self.bodies.iter().flat_map(|place| place.to_array()).flat_map(f64::to_le_bytes));
        bytes.extend(self.paces.iter().flat_map(|pace| pace.to_le_bytes()));
        bytes.push(u8::from(self.may_cross));
        if let Some(Halving { halvings, wait, patience }) = self.halving {
            bytes.extend([halvings, wait, patience].into_iter().flat_map(u32::to_le_bytes));
        }
        let sleep = self.sleep.into_iter().flat_map(Sleep::to_vectors);
        bytes.extend(sleep.flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes));
        bytes.extend(self.loads.iter().flat_map(|load| load.to_array()).flat_map(f32::to_le_bytes));
        for column in [&self.crept.x, &self.crept.y, &self.crept.z] {
            bytes.extend(column.iter().flat_map(|value| value.to_le_bytes()));
        }
        bytes.extend((self.behind.len() as u64).to_le_bytes());
        for Behind { particle, speed } in &self.behind {
            bytes.extend(particle.to_le_bytes());
            bytes.extend(speed.to_le_bytes());
        }
        bytes.extend((grips.particles().len() as u64).to_le_bytes());
        for (particle, Target { place, arrival }) in grips.held() {
            bytes.extend(particle.to_le_bytes());
            bytes.extend(place.to_array().into_iter().chain([arrival]).flat_map(f64::to_le_bytes));
        }
        bytes.extend((grips.leads().len() as u64).to_le_bytes());
        for lead in grips.leads() {
            bytes.extend(lead.particle.to_le_bytes());
            bytes.extend(lead.target.to_array().into_iter().flat_map(f64::to_le_bytes));
            bytes.extend(lead.speed.to_le_bytes());
        }
        bytes.extend((grips.shifts().len() as u64).to_le_bytes());
        for shift in grips.shifts() {
            bytes.extend((shift.group as u64).to_le_bytes());
            bytes.extend(shift.target.to_array().into_iter().chain([shift.speed]).flat_map(f64::to_le_bytes));
        }
        bytes.extend((grips.body_forms().len() as u64).to_le_bytes());
        for BodyForm { body, from, to, start, arrival } in grips.body_forms() {
            bytes.extend((*body as u64).to_le_bytes());
            let numbers = from.iter().chain(&**to).flat_map(|place| place.to_array()).chain([*start, *arrival]);
            bytes.extend(numbers.flat_map(f64::to_le_bytes));
        }
        bytes.extend((grips.body_shifts().len() as u64).to_le_bytes());
        for BodyShift { body, from, to, turned, turn, start, arrival } in grips.body_shifts() {
            bytes.extend((*body as u64).to_le_bytes());
            let places = from.to_array().into_iter().chain(to.to_array());
            let numbers = places.chain(turned.to_array()).chain(turn.to_array()).chain([*start, *arrival]);
            bytes.extend(numbers.flat_map(f64::to_le_bytes));
        }
        bytes.extend(xxh3_64(&bytes).to_le_bytes());
        bytes
    }

    /// What [`Self::to_bytes`] wrote for an equal model.
    ///
    /// # Errors
    /// See [`SnapshotError`].
    pub fn from_bytes(bytes: &[u8], model: &Model) -> Result<(Self, Grips), SnapshotError> {
        if !bytes.starts_with(&MAGIC) || bytes.len() < MAGIC.len() + CHECKSUM {
            return Err(SnapshotError::NotASnapshot);
        }
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
        if xxh3_64(content).to_le_bytes() != *checksum {
            return Err(SnapshotError::Damaged);
        }
        let mut reader = Reader(&content[MAGIC.len()..]);
        reader.read(model).filter(|_| reader.0.is_empty()).ok_or(SnapshotError::OtherModel)
    }
}

/// What has not been read yet.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    /// Nothing if the bytes are not those of such a model.
    fn read(&mut self, model: &Model) -> Option<(State, Grips)> {
        if self.whole()? != model.fingerprint {
            return None;
        }
        let clock = Clock { steps: self.whole()?, start: self.real()?, run: self.whole()?, length: self.real()? };
        let length = self.real()?;
        let (count, of_past) = (model.particle_count(), Past::none(model).gains.len());
        let of_motion = if model.solver.tells_motion_apart() { count } else { 0 };
        let origins = model.cloths.iter().map(|_| self.place()).collect::<Option<_>>()?;
        let (positions, velocities, motion) = (self.vectors(count)?, self.vectors(count)?, self.vectors(of_motion)?);
        let past = Past { displacements: self.vectors(of_past)?, gains: self.vectors(of_past)?, length };
        let mut state = State { origins, motion, past, ..State::at(model, positions, velocities, clock) };
        for calm in &mut state.calm {
            *calm = Calm { cycles: self.take().map(u32::from_le_bytes)?, room: self.single()?, brake: self.single()? };
        }
        for offset in &mut state.offsets {
            *offset = Offset { now: self.place()?, target: self.place()?, pace: self.real()? };
        }
        for place in &mut state.bodies {
            *place = self.place()?;
        }
        for pace in &mut state.paces {
            *pace = self.single()?;
        }
        state.may_cross = self.take::<1>()? != [0];
        if let Some(halving) = &mut state.halving {
            let [halvings, wait, patience] = [self.take()?, self.take()?, self.take()?].map(u32::from_le_bytes);
            *halving = Halving::new(halvings, wait, patience);
        }
        if let Some(sleep) = &mut state.sleep {
            let mut vector = || Some(Vec3::new(self.single()?, self.single()?, self.single()?));
            *sleep = Sleep::from_vectors([vector()?, vector()?]);
        }
        for load in &mut state.loads {
            *load = Vec3::new(self.single()?, self.single()?, self.single()?);
        }
        state.crept = self.vectors(state.crept.len())?;
        for _ in 0..self.whole()? {
            state.behind.push(Behind { particle: self.particle(count)?, speed: self.single()? });
        }
        let mut grips = Grips::default();
        for _ in 0..self.whole()? {
            let particle = self.particle(count)?;
            grips.hold(particle, Target { place: self.place()?, arrival: self.real()? });
        }
        for _ in 0..self.whole()? {
            let particle = self.particle(count)?;
            grips.lead(particle, self.place()?, self.single()?);
        }
        for _ in 0..self.whole()? {
            let group = usize::try_from(self.whole()?).ok().filter(|group| *group < model.pins.len())?;
            grips.shift(group, self.place()?, self.real()?);
        }
        for _ in 0..self.whole()? {
            let body = self.body(model)?;
            let count = model.bodies.list[body].vertices.len();
            let mut places = || (0..count).map(|_| self.place()).collect::<Option<Arc<[DVec3]>>>();
            let (from, to) = (places()?, places()?);
            grips.form_body(BodyForm { body, from, to, start: self.real()?, arrival: self.real()? });
        }
        for _ in 0..self.whole()? {
            grips.shift_body(BodyShift {
                body: self.body(model)?,
                from: self.place()?,
                to: self.place()?,
                turned: DQuat::from_array([self.real()?, self.real()?, self.real()?, self.real()?]),
                turn: self.place()?,
                start: self.real()?,
                arrival: self.real()?,
            });
        }
        Some((state, grips))
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn whole(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn real(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn single(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    fn particle(&mut self, count: usize) -> Option<u32> {
        self.take().map(u32::from_le_bytes).filter(|particle| (*particle as usize) < count)
    }

    fn body(&mut self, model: &Model) -> Option<usize> {
        self.whole().and_then(|body| usize::try_from(body).ok()).filter(|body| *body < model.bodies.list.len())
    }

    fn place(&mut self) -> Option<DVec3> {
        Some(DVec3::new(self.real()?, self.real()?, self.real()?))
    }

    fn vectors(&mut self, count: usize) -> Option<Vectors> {
        let (columns, rest) = self.0.split_at_checked(12 * count)?;
        self.0 = rest;
        let mut values = columns.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        let mut column = || values.by_ref().take(count).collect();
        Some(Vectors { x: column(), y: column(), z: column() })
    }
}
