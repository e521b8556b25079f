//! Between the state, whose rows have their columns in order, and the finest level, which keeps even and odd ones apart.

use pulp::{Simd, WithSimd};

use super::level::Level;
use crate::state::State;

/// Takes positions and the displacements h V from the state.
pub(super) struct Load<'a> {
    pub level: &'a mut Level,
    /// First particle of the cloth.
    pub first: usize,
    pub state: &'a State,
    /// h [s].
    pub step: f32,
}

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { level, first, state, step } = self;
        for row in 0..level.rows {
            let columns = first + row * level.columns..first + (row + 1) * level.columns;
            let places = [level.place(0, row), level.place(1, row)];
            let fields = [
                (&state.positions.x, &mut level.x.x, 1.0),
                (&state.positions.y, &mut level.x.y, 1.0),
                (&state.positions.z, &mut level.x.z, 1.0),
                (&state.velocities.x, &mut level.d.x, step),
                (&state.velocities.y, &mut level.d.y, step),
                (&state.velocities.z, &mut level.d.z, step),
            ];
            for (from, to, factor) in fields {
                let (pairs, rest) = from[columns.clone()].as_chunks::<2>();
                for (odd, place) in places.into_iter().enumerate() {
                    for (to, pair) in to[place..place + pairs.len()].iter_mut().zip(pairs) {
                        *to = pair[odd] * factor;
                    }
                }
                if let [last] = rest {
                    to[places[0] + pairs.len()] = last * factor;
                }
            }
        }
    }
}

/// Gives the corrected displacements back as velocities.
pub(super) struct Store<'a> {
    pub level: &'a Level,
    /// First particle of the cloth.
    pub first: usize,
    pub state: &'a mut State,
    /// h [s].
    pub step: f32,
}

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { level, first, state, step } = self;
        // What was not corrected keeps its velocity to the last bit.
        let corrected = |velocity: f32, d: f32| velocity + (d - velocity * step) / step;
        for row in 0..level.rows {
            let columns = first + row * level.columns..first + (row + 1) * level.columns;
            let places = [level.place(0, row), level.place(1, row)];
            let velocities = &mut state.velocities;
            let fields = [(&level.d.x, &mut velocities.x), (&level.d.y, &mut velocities.y), (&level.d.z, &mut velocities.z)];
            for (from, to) in fields {
                let (pairs, rest) = to[columns.clone()].as_chunks_mut::<2>();
                let (even, odd) = (&from[places[0]..places[0] + pairs.len()], &from[places[1]..places[1] + pairs.len()]);
                for ((pair, even), odd) in pairs.iter_mut().zip(even).zip(odd) {
                    *pair = [corrected(pair[0], *even), corrected(pair[1], *odd)];
                }
                if let [last] = rest {
                    *last = corrected(*last, from[places[0] + pairs.len()]);
                }
            }
        }
    }
}
