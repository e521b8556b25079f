//! The bodies of a world: where they are, and where they are sent.

use glam::DVec3;

use super::error::{as_many, below, duration};
use super::running::near;
use super::{Error, World};
use crate::scene::FARTHEST;

impl World {
    /// How many bodies there are.
    #[must_use]
    pub fn body_count(&self) -> usize {
        self.model.bodies.list.len()
    }

    /// The body of a name.
    #[must_use]
    pub fn body_named(&self, name: &str) -> Option<usize> {
        self.model.bodies.list.iter().position(|body| body.name == name)
    }

    /// Sends a body off the place, or the path, that it was given: within `over` seconds it goes straight to `offset` beside it [m].
    /// With the `dt` of the next step for `over` it arrives at its end. With 0 it is there at once, and cloth is not moved out of its way.
    ///
    /// # Errors
    /// There is no such body, the offset is not finite or too far, the time is none.
    pub fn move_body(&mut self, body: usize, offset: [impl Into<f64>; 3], over: f64) -> Result<(), Error> {
        below("body", body, self.body_count())?;
        duration("over", over)?;
        let to = near(|| "offset".to_owned(), offset.map(Into::into))?;
        let Self { model, state, inputs, .. } = self;
        state.pose_body(model, inputs, body, to, None, over);
        Ok(())
    }

    /// Turns a body as well; otherwise like [`Self::move_body`], which leaves it turned. First it turns about its middle, the mean of its
    /// vertices (a plane about its point), then it is displaced. The rotation is the one against its path, an axis times an angle [rad]. It
    /// turns evenly and the shorter way from how it is turned: lead it by less than half a turn a call.
    ///
    /// # Errors
    /// There is no such body, the offset or the rotation is not finite or too far, the time is none.
    pub fn pose_body(
        &mut self,
        body: usize,
        offset: [impl Into<f64>; 3],
        rotation: [impl Into<f64>; 3],
        over: f64,
    ) -> Result<(), Error> {
        below("body", body, self.body_count())?;
        duration("over", over)?;
        let to = near(|| "offset".to_owned(), offset.map(Into::into))?;
        let rotation = rotation.map(Into::into);
        if !rotation.iter().all(|part| part.abs() <= FARTHEST) {
            let remedy = format!("must be finite numbers in [-{FARTHEST}, {FARTHEST}] rad; take the axis times the angle");
            return Err(Error::argument("rotation", format!("{rotation:?}"), remedy));
        }
        let Self { model, state, inputs, .. } = self;
        state.pose_body(model, inputs, body, to, Some(rotation.into()), over);
        Ok(())
    }

    /// Tells where the vertices of a body shall be [m], as [`Self::body_positions`] has them: a body that is animated elsewhere. Within
    /// `over` seconds each goes straight there and stays: the body has left its path. With the `dt` of the next step for `over` it arrives
    /// at its end. With 0 it is there at once, and cloth is not moved out of its way.
    ///
    /// # Errors
    /// There is no such body, there is not one place for each of its vertices, a place is not finite or too far away, the time is none.
    pub fn set_body_vertices<T: Copy + Into<f64>>(&mut self, body: usize, positions: &[[T; 3]], over: f64) -> Result<(), Error> {
        below("body", body, self.body_count())?;
        as_many("positions", positions.len(), self.model.bodies.list[body].vertices.len(), "vertices")?;
        duration("over", over)?;
        let each = positions.iter().enumerate();
        let places = each.map(|(index, place)| near(|| format!("positions[{index}]"), place.map(Into::into)));
        let places: Vec<DVec3> = places.collect::<Result<_, _>>()?;
        let Self { model, state, inputs, .. } = self;
        state.form_body(model, inputs, body, places.into(), over);
        Ok(())
    }

    /// Where the vertices of a body are [m]: the middle of a sphere; the ends of the line of a capsule; a point of a plane and the one 1 m
    /// from it along its normal; the corners of a box; those of a mesh.
    ///
    /// # Errors
    /// There is no such body.
    pub fn body_positions(&self, body: usize) -> Result<Vec<[f64; 3]>, Error> {
        below("body", body, self.body_count())?;
        let own = self.model.bodies.list[body].vertices.clone();
        Ok(self.state.bodies[own].iter().map(|place| place.to_array()).collect())
    }
}
