//! What a step tells the next one about how calm its cloth hangs.

use super::{HELD, LEAST_ROOM, NO_ROOM, PACE, SHRINK};

/// How many cycles the next step takes at least, after one of which as much was asked and that took so many. It rises little by little: a
/// single step that took many is no reason for all that follow.
pub(super) fn cycles_from_now(at_least: u32, taken: u32, calm: bool) -> u32 {
    match calm {
        true if taken > at_least => taken.min(at_least + at_least / 4 + 4),
        true => at_least,
        false => at_least * 3 / 4,
    }
}

/// The room of coarse levels in the next step, after one with `room` that left such a part of its kinetic energy. Where its cycles want less,
/// whatever made up for what they did, the next ones would do so again.
pub(super) fn room_from_now(room: f32, left_of_energy: f64, want_less: bool) -> f32 {
    if want_less {
        return less_room(room);
    }
    let freedom = ((left_of_energy - HELD[0]) / (HELD[1] - HELD[0])).clamp(0.0, 1.0) as f32;
    room + PACE * (LEAST_ROOM + (1.0 - LEAST_ROOM) * freedom - room)
}

/// The room of cycles after some that pulled further than the step moved.
pub(super) fn less_room(room: f32) -> f32 {
    (SHRINK * room).max(NO_ROOM)
}
