//! A state as bytes, and back.

use glam::DVec3;
use xxhash_rust::xxh3::xxh3_64;

use super::{Clock, Past, State};
use crate::geometry::Vectors;
use crate::model::Model;

/// First bytes of every snapshot; the last one is the version of the layout.
const MAGIC: [u8; 8] = *b"TAUTSNP3";
/// Magic, fingerprint of the model, steps and time, length of the past step.
const HEADER: usize = 56;
const CHECKSUM: usize = 8;

/// Bytes that are no snapshot of this model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// Not ours at all.
    #[error("these bytes are not a taut snapshot (version 3)")]
    NotASnapshot,
    /// Cut short or altered.
    #[error("the snapshot is damaged: its checksum does not fit; take another one")]
    Damaged,
    /// Of a different scene, mesh or size.
    #[error("the snapshot belongs to another scene; restore it into a simulation of the scene it was taken from")]
    OtherModel,
}

impl State {
    /// The state as bytes: magic, fingerprint, steps and time, the origins (little-endian `f64`), the coordinate arrays of positions,
    /// velocities and the past, if any
    /// (little-endian `f32`), XXH3 of all these.
    #[must_use]
    pub fn to_bytes(&self, model: &Model) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + 24 * self.positions.len() + CHECKSUM);
        bytes.extend(MAGIC);
        bytes.extend(model.fingerprint.to_le_bytes());
        let Clock { steps, start, run, length } = self.clock;
        for number in [steps, start.to_bits(), run, length.to_bits(), self.past.length.to_bits()] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(self.origins.iter().flat_map(|origin| origin.to_array()).flat_map(f64::to_le_bytes));
        let all = [&self.positions, &self.velocities, &self.past.displacements, &self.past.gains];
        for column in all.into_iter().flat_map(columns) {
            bytes.extend(column.iter().flat_map(|value| value.to_le_bytes()));
        }
        bytes.extend(xxh3_64(&bytes).to_le_bytes());
        bytes
    }

    /// The state that [`Self::to_bytes`] wrote for an equal model.
    ///
    /// # Errors
    /// See [`SnapshotError`].
    pub fn from_bytes(bytes: &[u8], model: &Model) -> Result<Self, SnapshotError> {
        if !bytes.starts_with(&MAGIC) || bytes.len() < HEADER + CHECKSUM {
            return Err(SnapshotError::NotASnapshot);
        }
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
        if xxh3_64(content).to_le_bytes() != *checksum {
            return Err(SnapshotError::Damaged);
        }
        let number = |at: usize| content[at..at + 8].iter().rev().fold(0_u64, |value, &byte| value << 8 | u64::from(byte));
        let count = model.particle_count();
        let of_past = Past::none(model).gains.len();
        let cloths = model.cloths.len();
        if number(8) != model.fingerprint || content.len() != HEADER + 24 * (cloths + count + of_past) {
            return Err(SnapshotError::OtherModel);
        }
        let (origins, vectors) = content[HEADER..].split_at(24 * cloths);
        let part = |at: usize| f64::from_bits(u64::from_le_bytes(std::array::from_fn(|byte| origins[8 * at + byte])));
        let origins = (0..cloths).map(|cloth| DVec3::new(part(3 * cloth), part(3 * cloth + 1), part(3 * cloth + 2))).collect();
        let mut values = vectors.chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
        let mut vectors = |count| {
            let mut column = || values.by_ref().take(count).collect::<Vec<f32>>();
            Vectors { x: column(), y: column(), z: column() }
        };
        let (positions, velocities) = (vectors(count), vectors(count));
        let real = |at: usize| f64::from_bits(number(at));
        let past = Past { displacements: vectors(of_past), gains: vectors(of_past), length: real(48) };
        let clock = Clock { steps: number(16), start: real(24), run: number(32), length: real(40) };
        Ok(Self { origins, positions, velocities, clock, past })
    }
}

fn columns(vectors: &Vectors) -> [&Vec<f32>; 3] {
    [&vectors.x, &vectors.y, &vectors.z]
}
