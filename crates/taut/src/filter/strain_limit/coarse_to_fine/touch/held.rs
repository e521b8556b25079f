//! What rows cannot move: what is held, what bodies grip, and bodies themselves.

use super::super::unit::Unit;
use super::Touch;
use crate::contact::Grip;
use crate::schedule::Stride;
use crate::state::State;

impl Touch {
    /// Has what is held stop where bodies are in its way.
    pub(super) fn stop_held(&mut self, units: &mut [Unit], stride: Stride<'_>, state: &State) {
        let Self { contact, stopped, where_is, proposed, velocities, .. } = self;
        contact.rows.stop_held(&mut contact.places, stopped);
        for particle in stopped.iter().map(|&particle| particle as usize) {
            let way = (contact.places.ends[particle] - contact.places.x[particle]).as_vec3();
            where_is.hold(units, particle, way);
            proposed.set(particle, state.positions.get(particle) + way);
            velocities.set(particle, way / stride.plan.length as f32);
        }
    }

    /// Grips what bodies press between them; not where something heavy hangs on rows, which is solved with them, nor where something
    /// is brought apart.
    pub(super) fn grip(&mut self, units: &mut [Unit]) {
        if self.contact.brings_apart().is_some() {
            return;
        }
        let Self { contact, where_is, joint, .. } = self;
        let may = |particle: u32| where_is.of(particle as usize).is_some_and(|(unit, _)| !joint.is_heavy(unit));
        for &Grip { particle, way } in contact.rows.grip(may) {
            if let Some((unit, own)) = where_is.of(particle as usize) {
                units[unit].grip(own, way);
            }
        }
    }

    /// Whether all bodies that move where something would cross have given way already: shorter steps do not help against them, and they can
    /// stay behind. Skins have that are further behind their paths than they and the cloth are thick, rigid bodies by more than a cell.
    pub(super) fn given_way(&self, stride: Stride<'_>, state: &State) -> bool {
        self.are_pressed_by(stride, state, |body| {
            let far =
                if stride.inputs.bodies.deforms(body) { self.contact.thickness_on(body) } else { stride.model.contact.cell };
            self.led.late[body] > far
        })
    }

    /// Whether they are skins, each vertex of which stays behind by itself.
    pub(super) fn are_skins(&self, stride: Stride<'_>, state: &State) -> bool {
        self.are_pressed_by(stride, state, |body| stride.inputs.bodies.deforms(body))
    }

    /// Whether there are such bodies, and no others move where something would cross.
    fn are_pressed_by(&self, Stride { model, .. }: Stride<'_>, state: &State, is: impl Fn(usize) -> bool) -> bool {
        let bodies = &model.bodies.list;
        let corners = self.contact.cuts.list.iter().flat_map(|cut| cut.pair.corners);
        let vertices = corners.filter_map(|corner| (corner as usize).checked_sub(model.particle_count()));
        let mut moved = vertices.filter(|&vertex| self.led.ends[vertex] != state.bodies[vertex]);
        let of = |vertex: usize| bodies.iter().position(|body| body.vertices.contains(&vertex));
        (0..bodies.len()).any(&is) && moved.all(|vertex| of(vertex).is_some_and(&is))
    }
}
