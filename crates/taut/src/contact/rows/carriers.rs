//! What carries cloth: how the bodies move that push it.

use glam::{DMat3, DVec3};

use super::wanted::carried;
use super::{NONE, Row, Rows};
use crate::contact::Places;
use crate::contact::surfaces::Surfaces;

/// Bodies move as one where what their places differ from one rigid motion is less than this part of their ways, root mean square [1].
const AS_ONE: f64 = 0.1;
/// Places along a line tell no turn round it: what they tell is as good as none below this part of what they tell of others [1].
const TOLD: f64 = 1e-6;
/// A turn is found to the first order, so many times.
const TURNS: usize = 2;

/// How a cloth is carried in a step, together with all that it touches, be it through others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried {
    pub by: Carrier,
    /// The first of the cloths that touch each other.
    pub first: usize,
    /// How the bodies go that push these, on the mean, if any does; and how far their surfaces go beside that, and bring apart what is too
    /// near, at most [m].
    pub motion: Option<RigidMotion>,
    pub apart: f64,
    /// Whether more of what pushes it is bodies than cloth.
    pub is_on_bodies: bool,
}

impl Carried {
    /// Whether no body pushes the cloth, and no other one of `all` touches it.
    pub fn is_alone(&self, all: &[Self]) -> bool {
        self.motion.is_none() && all.iter().filter(|other| other.first == self.first).count() == 1
    }
}

/// What carries a cloth in a step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Carrier {
    /// No body that moves pushes it, be it through other cloth.
    Nothing,
    /// All bodies that push it, and what touches it, move as one.
    Rigid(RigidMotion),
    /// They move apart.
    Several,
}

/// A motion that changes no lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RigidMotion {
    center: DVec3,
    /// How far the center goes [m], and the tangent of half the angle of the turn around it, along its axis [1].
    way: DVec3,
    turn: DVec3,
}

impl RigidMotion {
    const NONE: Self = Self::along(DVec3::ZERO);

    /// One without a turn.
    pub const fn along(way: DVec3) -> Self {
        Self { center: DVec3::ZERO, way, turn: DVec3::ZERO }
    }

    /// How far a place goes [m].
    pub fn way(&self, place: DVec3) -> DVec3 {
        let across = self.turn.cross(place - self.center);
        self.way + (across + self.turn.cross(across)) * (2.0 / (1.0 + self.turn.length_squared()))
    }
}

/// A place where a body pushes a cloth: how hard [kg m], and how far the surface of the body goes there [m].
#[derive(Debug, Clone, Copy)]
struct Place {
    cloth: usize,
    by: f64,
    place: DVec3,
    way: DVec3,
    moves: bool,
}

/// Workspace: of each cloth the first of those that touch it, be it through others; all places, and what they say of those first cloths.
#[derive(Debug, Default)]
pub(super) struct Told {
    together: Vec<usize>,
    places: Vec<Place>,
    sums: Vec<Sums>,
    /// Of each cloth, by how many more rows of bodies push it than of cloth.
    on_bodies: Vec<i64>,
}

/// What the places of a cloth, and of those that touch it, say about how they are carried: sums weighted by pushes.
#[derive(Debug, Clone, Copy)]
struct Sums {
    any: bool,
    any_moves: bool,
    all: f64,
    place: DVec3,
    way: DVec3,
    /// The moment of inertia round their mean.
    inertia: DMat3,
    /// The motion as far as it is known, the moment of what it leaves of ways, and the squares of both.
    motion: RigidMotion,
    moment: DVec3,
    left: f64,
    square: f64,
    furthest: f64,
    /// How far rows bring apart what is too near, at most [m].
    lack: f64,
}

impl Sums {
    const NONE: Self = Self {
        any: false,
        any_moves: false,
        all: 0.0,
        place: DVec3::ZERO,
        way: DVec3::ZERO,
        inertia: DMat3::ZERO,
        motion: RigidMotion::NONE,
        moment: DVec3::ZERO,
        left: 0.0,
        square: 0.0,
        furthest: 0.0,
        lack: 0.0,
    };

    fn take(&mut self, at: &Place) {
        self.any_moves |= at.moves;
        self.all += at.by;
        self.place += at.place * at.by;
        self.way += at.way * at.by;
    }

    /// Knows how they go on the mean.
    fn center(&mut self) {
        if self.all > 0.0 {
            self.motion = RigidMotion { center: self.place / self.all, way: self.way / self.all, turn: DVec3::ZERO };
        }
    }

    fn take_inertia(&mut self, at: &Place) {
        let arm = at.place - self.motion.center;
        let [x, y, z] = (arm * at.by).to_array().map(|part| arm * part);
        self.inertia += DMat3::from_diagonal(DVec3::splat(at.by * arm.length_squared())) - DMat3::from_cols(x, y, z);
    }

    fn take_left(&mut self, at: &Place) {
        let left = at.way - self.motion.way(at.place);
        self.moment += (at.place - self.motion.center).cross(left) * at.by;
        self.left += at.by * left.length_squared();
        self.square += at.by * at.way.length_squared();
        self.furthest = self.furthest.max(left.length_squared());
    }

    /// Turns so that least is left, to the first order.
    fn turn(&mut self) {
        let DMat3 { x_axis, y_axis, z_axis } = self.inertia;
        let least = TOLD * (x_axis.x + y_axis.y + z_axis.z);
        if least > 0.0 {
            self.motion.turn += (self.inertia + DMat3::from_diagonal(DVec3::splat(least))).inverse() * self.moment * 0.5;
        }
        (self.moment, self.left, self.square, self.furthest) = (DVec3::ZERO, 0.0, 0.0, 0.0);
    }
}

impl Rows {
    /// Tells of each cloth what carries it.
    pub(in crate::contact) fn tell_carriers(&mut self, surfaces: &Surfaces, places: &Places, carriers: &mut Vec<Carried>) {
        let cloths = surfaces.cloths.len();
        let Told { mut together, places: mut told, mut sums, mut on_bodies } = std::mem::take(&mut self.told);
        let owner = |local: usize| surfaces.owners[self.vertices[local] as usize] as usize;
        let carry = || self.list.iter().filter(|row| row.carries());
        together.clear();
        together.extend(0..cloths);
        for row in carry().filter(|row| row.cloth == NONE) {
            let all = || row.locals().map(owner).filter(|&owner| owner < cloths);
            let Some(first) = all().map(|owner| together[owner]).min() else { continue };
            for owner in all() {
                let one = together[owner];
                together.iter_mut().filter(|other| **other == one).for_each(|other| *other = first);
            }
        }
        sums.clear();
        sums.resize(cloths, Sums::NONE);
        on_bodies.clear();
        on_bodies.resize(cloths, 0);
        for row in carry() {
            let Some(cloth) = row.locals().map(owner).find(|&owner| owner < cloths) else { continue };
            let sums = &mut sums[together[cloth]];
            sums.lack = sums.lack.max(-f64::from(row.gap));
            let is_of_body = row.cloth != NONE && row.locals().any(|local| owner(local) >= cloths);
            sums.any |= is_of_body;
            // A row of two cloths counts at both.
            match (row.cloth, is_of_body) {
                (NONE, _) => row.locals().map(owner).for_each(|cloth| on_bodies[cloth] -= 1),
                (cloth, true) => on_bodies[cloth as usize] += 1,
                (cloth, false) => on_bodies[cloth as usize] -= 1,
            }
        }
        // Most cloth lies on what stands still.
        told.clear();
        if places.turns.iter().any(|turn| *turn != DVec3::ZERO) || places.x[self.particles..] != places.ends[self.particles..] {
            told.extend(carry().filter_map(|row| self.told_by(row, surfaces, places)));
            told.iter_mut().for_each(|at| at.cloth = together[at.cloth]);
            if !told.iter().any(|at| at.moves) {
                told.clear();
            }
        }
        told.iter().for_each(|at| sums[at.cloth].take(at));
        sums.iter_mut().for_each(Sums::center);
        told.iter().for_each(|at| sums[at.cloth].take_inertia(at));
        for _ in 0..TURNS {
            told.iter().for_each(|at| sums[at.cloth].take_left(at));
            sums.iter_mut().for_each(Sums::turn);
        }
        told.iter().for_each(|at| sums[at.cloth].take_left(at));
        carriers.clear();
        carriers.extend(together.iter().zip(&on_bodies).map(|(&first, &more)| {
            let sums = &sums[first];
            let by = match sums {
                sums if !sums.any_moves => Carrier::Nothing,
                sums if sums.left > AS_ONE * AS_ONE * sums.square => Carrier::Several,
                sums => Carrier::Rigid(sums.motion),
            };
            let (motion, apart) = (sums.any.then_some(sums.motion), sums.furthest.sqrt() + sums.lack);
            Carried { by, first, motion, apart, is_on_bodies: more > 0 }
        }));
        self.told = Told { together, places: told, sums, on_bodies };
    }

    /// What a row says of how its cloth is carried, if a body pushes it.
    fn told_by(&self, row: &Row, surfaces: &Surfaces, places: &Places) -> Option<Place> {
        let cloths = surfaces.cloths.len();
        let (mut cloth, mut body, mut sign) = (None, None, 0.0);
        let (mut place, mut way, mut moves) = (DVec3::ZERO, DVec3::ZERO, false);
        for end in (0..4).filter(|&end| row.parts[end] != 0.0) {
            let (vertex, part) = (self.vertices[row.ends[end] as usize] as usize, f64::from(row.parts[end]));
            let owner = surfaces.owners[vertex] as usize;
            match owner.checked_sub(cloths) {
                None => {
                    cloth = Some(owner);
                    sign = part.signum();
                    place += places.x[vertex] * part;
                }
                Some(number) => {
                    body = Some(number);
                    way += (places.ends[vertex] - places.x[vertex]) * part;
                    moves |= places.ends[vertex] != places.x[vertex];
                }
            }
        }
        let (cloth, body) = (cloth?, body?);
        way += carried(surfaces, places, [(cloths + body) as u32, cloth as u32], row.normal.as_dvec3());
        let moves = moves || places.turns[body] != DVec3::ZERO;
        // Parts of the body have the other sign.
        Some(Place { cloth, by: f64::from(row.push.max(row.grips)), place: place * sign, way: way * -sign, moves })
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn motion_of(places: &[DVec3], way: impl Fn(DVec3) -> DVec3) -> RigidMotion {
        let told: Vec<Place> =
            places.iter().map(|&place| Place { cloth: 0, by: 0.5, place, way: way(place), moves: true }).collect();
        let mut sums = Sums::NONE;
        told.iter().for_each(|at| sums.take(at));
        sums.center();
        told.iter().for_each(|at| sums.take_inertia(at));
        for _ in 0..TURNS {
            told.iter().for_each(|at| sums.take_left(at));
            sums.turn();
        }
        sums.motion
    }

    #[test]
    fn places_of_a_body_that_turns_tell_its_motion() {
        let (center, axis) = (DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.6, 0.0, 0.8));
        let turn = DQuat::from_axis_angle(axis, 0.05);
        let way = |place: DVec3| turn * (place - center) - (place - center) + DVec3::new(0.01, 0.02, -0.03);
        let places = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(2.0, 1.0, -1.0)];
        let motion = motion_of(&places, way);
        for place in places {
            assert!((motion.way(place) - way(place)).length() < 3e-5, "{}", motion.way(place) - way(place));
        }
        let (a, b) = (places[0], places[3]);
        let length = (a + motion.way(a)).distance(b + motion.way(b));
        assert!((length - a.distance(b)).abs() < 1e-12, "{length}");
    }

    #[test]
    fn places_along_a_line_tell_no_turn_round_it() {
        let motion = motion_of(&[DVec3::X, 2.0 * DVec3::X], |_| DVec3::Y);
        assert!((motion.way(DVec3::new(5.0, 6.0, 7.0)) - DVec3::Y).length() < 1e-12);
        let motion = motion_of(&[DVec3::X], |_| DVec3::Y);
        assert_eq!(motion.way(DVec3::new(5.0, 6.0, 7.0)), DVec3::Y);
    }
}
