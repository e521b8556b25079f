//! A world that steps.

use std::ops::Range;
use std::{fmt, mem};

use glam::DVec3;

use super::error::{as_many, below, duration};
use super::{Error, Pool, Report, WorldBuilder};
use crate::advance::advance;
use crate::inputs::{Air, Inputs, Target, Track};
use crate::model::Model;
use crate::prepare::Prepared;
use crate::scene::{FARTHEST, Wind, check_gravity};
use crate::state::State;
use crate::step::{Work, touches};

/// Longer times in one call [s] are a mistake in the units.
const LONGEST: f64 = 60.0;

/// Cloths, the air and gravity they live in, and the bodies in their way.
///
/// Cloths, bodies and the vertices of each cloth are numbered from 0 in the order in which they were given. Lengths are in metres, times in
/// seconds, masses in kilograms. The same calls lead to the same bits on every machine and on any number of threads.
///
/// ```
/// use taut::{Cloth, Corner, Pin, World};
///
/// let cape = Cloth::grid([1.0, 1.2], [20, 24]).strain_limit(0.05).pin(Pin::corner(Corner::TopLeft)).pin(Pin::corner(Corner::TopRight));
/// let mut world = World::builder().cloth(cape).wind([0.0, 3.0, 0.0]).build()?;
/// let report = world.step(1.0 / 60.0)?;
/// assert!(report.worst_stretch <= 0.05 + 1e-5);
/// assert_eq!(world.positions(0)?.len(), 21 * 25);
/// # Ok::<(), taut::Error>(())
/// ```
pub struct World {
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) inputs: Inputs,
    wind: Option<Wind>,
    work: Work,
    seen: Seen,
    report: Report,
}

/// What callers look at.
struct Seen {
    positions: Vec<[f32; 3]>,
    velocities: Vec<[f32; 3]>,
    /// Of all cloths, in numbers of vertices of their own.
    faces: Vec<[u32; 3]>,
    /// The faces of each cloth.
    of_cloths: Vec<Range<usize>>,
}

/// A place where cloth touched something in the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// The cloth.
    pub cloth: usize,
    /// The vertex of it that is nearest to the place.
    pub vertex: u32,
    /// The body that it touched; none: cloth.
    pub body: Option<usize>,
    /// On the cloth, in the world [m].
    pub place: [f64; 3],
    /// The way in which the cloth was pushed, of length 1.
    pub normal: [f64; 3],
    /// How hard, along the normal [N].
    pub force: f64,
    /// Friction on the cloth, across the normal [N].
    pub friction: [f64; 3],
}

impl World {
    /// A world that is asked for.
    #[must_use]
    pub fn builder() -> WorldBuilder {
        WorldBuilder::default()
    }

    pub(super) fn new(Prepared { model, inputs, schedule }: Prepared, wind: Option<Wind>, pool: Pool) -> Self {
        let state = State::new(&model);
        let work = Work::with_pool(&model, &schedule, pool.0);
        let seen = Seen::new(&model);
        let mut world = Self { model, state, inputs, wind, work, seen, report: Report::default() };
        // Nothing has moved: that cannot fail.
        let _ = world.look(0, 0.0);
        world
    }

    /// Goes on by `dt` seconds, in as many steps as the world needs for its accuracy. Where all calls have the same `dt`, nothing is
    /// allocated. A `dt` of 0 only looks.
    ///
    /// # Errors
    /// [`Error::Argument`] unless `dt` is 0 or in [1e-12, 60]; [`Error::NonFinite`]. The world is then as it was before.
    pub fn step(&mut self, dt: f64) -> Result<Report, Error> {
        if dt == 0.0 {
            return self.look(0, 0.0);
        }
        if !(dt > 0.0 && dt <= LONGEST) {
            return Err(Error::argument("dt", dt, format!("must be 0, or in [1e-12, {LONGEST}] s; take 1.0 / 60.0")));
        }
        // A time that is a whole number of steps but for rounding needs no further one.
        let count = (dt / self.step_length() * (1.0 - 1e-9)).ceil().max(1.0);
        self.look(count as u64, dt / count)
    }

    fn look(&mut self, count: u64, length: f64) -> Result<Report, Error> {
        let Self { model, state, inputs, work, seen, .. } = self;
        let summary = advance(model, state, inputs, length, count, work);
        let summary = summary.map_err(|failure| Error::of_steps(model, failure, length * count as f64))?;
        seen.look(model, state, work);
        self.report = Report::new(&summary, state.time());
        Ok(self.report)
    }

    /// What the last call of [`Self::step`] told.
    #[must_use]
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Time since the start [s].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.state.time()
    }

    /// The longest step that [`Self::step`] takes at once [s].
    #[must_use]
    pub fn step_length(&self) -> f64 {
        self.work.schedule().step_length
    }

    /// What is allowed but looks like a mistake, and what was repaired in meshes: one sentence each.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.model.warnings
    }

    /// How many cloths there are.
    #[must_use]
    pub fn cloth_count(&self) -> usize {
        self.model.cloths.len()
    }

    /// The cloth of a name.
    #[must_use]
    pub fn cloth_named(&self, name: &str) -> Option<usize> {
        self.model.cloths.iter().position(|cloth| cloth.name == name)
    }

    /// Where the vertices of a cloth are [m].
    ///
    /// # Errors
    /// There is no such cloth.
    pub fn positions(&self, cloth: usize) -> Result<&[[f32; 3]], Error> {
        Ok(&self.seen.positions[self.vertices(cloth)?])
    }

    /// The same in double precision, for cloth that is far from the origin [m].
    ///
    /// # Errors
    /// There is no such cloth.
    pub fn exact_positions(&self, cloth: usize) -> Result<Vec<[f64; 3]>, Error> {
        let place = |vertex: usize| self.state.place(cloth, self.model.numbering.particle(vertex as u32) as usize).to_array();
        Ok(self.vertices(cloth)?.map(place).collect())
    }

    /// How fast the vertices of a cloth are [m/s].
    ///
    /// # Errors
    /// There is no such cloth.
    pub fn velocities(&self, cloth: usize) -> Result<&[[f32; 3]], Error> {
        Ok(&self.seen.velocities[self.vertices(cloth)?])
    }

    /// The triangles of a cloth, counter-clockwise seen from its front; none of a network.
    ///
    /// # Errors
    /// There is no such cloth.
    pub fn faces(&self, cloth: usize) -> Result<&[[u32; 3]], Error> {
        below("cloth", cloth, self.cloth_count())?;
        Ok(&self.seen.faces[self.seen.of_cloths[cloth].clone()])
    }

    /// The vertices that a pin of a cloth holds.
    ///
    /// # Errors
    /// There is no such cloth, or no such pin of it.
    pub fn pinned(&self, cloth: usize, pin: usize) -> Result<Vec<u32>, Error> {
        let first = self.vertices(cloth)?.start as u32;
        let groups: Vec<_> = self.model.pins.iter().filter(|group| group.cloth == cloth).collect();
        below("pin", pin, groups.len())?;
        Ok(groups[pin].particles.iter().map(|&particle| self.model.numbering.vertex(particle) - first).collect())
    }

    /// Holds vertices: within `over` seconds they go straight to their places [m] and stay there, whatever their mass, until they are
    /// given other places or released. Pinned ones leave their pins. With the `dt` of the next step for `over` they arrive at its end.
    /// With 0 they jump there, as far as the strain limit lets them. A body in their way stops them, and they go on along that; where the
    /// way is free again, they come to their places little by little.
    ///
    /// # Errors
    /// There is no such cloth or vertex, there is not one place for each vertex, a place is not finite or too far away, a time is none.
    pub fn hold<T: Copy + Into<f64>>(
        &mut self,
        cloth: usize,
        vertices: &[u32],
        places: &[[T; 3]],
        over: f64,
    ) -> Result<(), Error> {
        as_many("places", places.len(), vertices.len(), "vertices")?;
        duration("over", over)?;
        let arrival = self.time() + over;
        let particles = self.particles(cloth, vertices)?;
        let each = places.iter().enumerate();
        let places = each.map(|(index, place)| near(|| format!("places[{index}]"), place.map(Into::into)));
        let places = places.collect::<Result<Vec<_>, _>>()?;
        for (particle, place) in particles.into_iter().zip(places) {
            self.inputs.grips.hold(particle, Target { place, arrival });
        }
        Ok(())
    }

    /// Leads a vertex by hand to a place [m] at a speed of at most `speed` [m/s], to pull at cloth with a pointer. Unlike one that is held
    /// it keeps its mass. It stays behind where the strain limit or something in its way asks for it.
    ///
    /// # Errors
    /// There is no such cloth or vertex, the place is not finite or too far away, the speed is not above 0.
    pub fn lead(&mut self, cloth: usize, vertex: u32, place: [impl Into<f64>; 3], speed: f64) -> Result<(), Error> {
        let particles = self.particles(cloth, &[vertex])?;
        let place = near(|| "place".to_owned(), place.map(Into::into))?;
        if !(speed > 0.0 && speed <= 1e6) {
            return Err(Error::argument("speed", speed, "must be above 0 and at most 1e6 m/s; take 10.0"));
        }
        self.inputs.grips.lead(particles[0], place, speed as f32);
        Ok(())
    }

    /// Lets vertices go that were held or led; pinned ones go back to their pins.
    ///
    /// # Errors
    /// There is no such cloth or vertex.
    pub fn release(&mut self, cloth: usize, vertices: &[u32]) -> Result<(), Error> {
        self.particles(cloth, vertices)?.into_iter().for_each(|particle| self.inputs.grips.release(particle));
        Ok(())
    }

    /// Acceleration of gravity now [m/s^2].
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.inputs.gravity.at(self.time()).to_array()
    }

    /// Another gravity from now on [m/s^2].
    ///
    /// # Errors
    /// It is not finite, or too strong.
    pub fn set_gravity(&mut self, gravity: [impl Into<f64>; 3]) -> Result<(), Error> {
        let gravity = gravity.map(Into::into);
        check_gravity(&gravity)?;
        self.inputs.gravity = Track::constant(gravity.into());
        Ok(())
    }

    /// The moving air; none where none was given, and only the `air_drag` of a cloth slows it.
    #[must_use]
    pub fn wind(&self) -> Option<&Wind> {
        self.wind.as_ref()
    }

    /// Another wind from now on; its keyframes count from the start of the world. Where it is `[0.0; 3]`, cloth meets still air.
    ///
    /// # Errors
    /// A field of it is out of range.
    pub fn set_wind(&mut self, wind: impl Into<Wind>) -> Result<(), Error> {
        let wind = wind.into();
        wind.check()?;
        self.inputs.air = Some(Air::new(&wind));
        self.wind = Some(wind);
        Ok(())
    }

    /// Where cloth touched something in the last step; nothing before the first one, and after [`Self::restore`].
    #[must_use]
    pub fn contacts(&self) -> Vec<Contact> {
        let told = |touch: crate::step::Touch| {
            let vertex = self.model.numbering.vertex(touch.particle);
            let cloth = self.model.cloths.iter().position(|cloth| cloth.particles().contains(&(vertex as usize)))?;
            Some(Contact {
                cloth,
                vertex: vertex - self.model.cloths[cloth].first as u32,
                body: touch.body.map(|body| body as usize),
                place: touch.place.to_array(),
                normal: touch.normal.to_array(),
                force: touch.force,
                friction: touch.friction.to_array(),
            })
        };
        touches(&self.state, &self.work).into_iter().filter_map(told).collect()
    }

    /// Everything that changes, as bytes: a world of the same cloths and bodies that restores them goes on with the same bits. Gravity and
    /// wind that were set are no part of them.
    #[must_use]
    pub fn snapshot(&self) -> Vec<u8> {
        self.state.to_bytes(&self.model, &self.inputs.grips)
    }

    /// Goes back to a snapshot. What was held then is held again.
    ///
    /// # Errors
    /// [`Error::Snapshot`]: these bytes are none, are damaged, or are of another world; [`Error::NonFinite`]: they were made up. The world is
    /// then as it was before.
    pub fn restore(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let (state, grips) = State::from_bytes(snapshot, &self.model)?;
        let before = (mem::replace(&mut self.state, state), mem::take(&mut self.inputs.grips));
        self.work.forget_step();
        self.inputs.take(grips);
        self.look(0, 0.0).map(drop).inspect_err(|_| {
            self.state = before.0;
            self.inputs.take(before.1);
        })
    }

    /// The vertices of a cloth, among those of all.
    fn vertices(&self, cloth: usize) -> Result<Range<usize>, Error> {
        below("cloth", cloth, self.cloth_count())?;
        Ok(self.model.cloths[cloth].particles())
    }

    /// The particles of vertices of a cloth.
    fn particles(&self, cloth: usize, vertices: &[u32]) -> Result<Vec<u32>, Error> {
        let all = self.vertices(cloth)?;
        let wrong = vertices.iter().position(|&vertex| vertex as usize >= all.len());
        wrong.map_or(Ok(()), |index| below(&format!("vertices[{index}]"), vertices[index] as usize, all.len()))?;
        Ok(vertices.iter().map(|vertex| self.model.numbering.particle(all.start as u32 + vertex)).collect())
    }
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (cloths, bodies) = (self.cloth_count(), self.body_count());
        f.debug_struct("World").field("time", &self.time()).field("cloths", &cloths).field("bodies", &bodies).finish()
    }
}

impl Seen {
    fn new(model: &Model) -> Self {
        let count = model.particle_count();
        let (mut faces, mut of_cloths) = (Vec::with_capacity(model.triangles.len()), Vec::new());
        for cloth in &model.cloths {
            let start = faces.len();
            let own = |triangle: &&[u32; 3]| cloth.particles().contains(&(triangle[0] as usize));
            let vertex = |particle| model.numbering.vertex(particle) - cloth.first as u32;
            faces.extend(model.triangles.iter().filter(own).map(|triangle| triangle.map(vertex)));
            of_cloths.push(start..faces.len());
        }
        Self { positions: vec![[0.0; 3]; count], velocities: vec![[0.0; 3]; count], faces, of_cloths }
    }

    fn look(&mut self, model: &Model, state: &State, work: &Work) {
        let Self { positions, velocities, .. } = self;
        let pool = work.pool();
        pool.install(positions.len(), || {
            state.write_places(model, positions, &pool);
            model.numbering.write_rows(state.of_motion(), 0, velocities, &pool, |velocity| velocity.to_array());
        });
    }
}

/// A place that is finite and not too far away.
pub(super) fn near(name: impl Fn() -> String, place: [f64; 3]) -> Result<DVec3, Error> {
    if place.iter().all(|part| part.abs() <= FARTHEST) {
        return Ok(place.into());
    }
    Err(Error::argument(name(), format!("{place:?}"), format!("must be finite numbers in [-{FARTHEST}, {FARTHEST}] m")))
}
