//! Rows that are alone with their vertex, four at a time.
//!
//! Rounds sweep over them again and again, and ask each time whether they are kept. So what that takes stands together here while rounds go
//! on, and nothing else: a third of the memory, and each number of four rows in one register. In between rows are as they were, but for
//! what they push and hold.

use glam::{BVec4A, Vec3, Vec4};
use pulp::{Simd, WithSimd};

use super::{Row, Rows};
use crate::geometry::{Pool, arch, by_axis, by_vector, for_each_of_both, roots};

/// Rows that are looked at together.
const LANES: usize = 4;

/// Those rows, and what they pushed and held as the last cycle began.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    rows: Vec<Four>,
    before: Vec<Before>,
}

/// Four rows; those that are missing ask for nothing.
#[derive(Debug, Clone, Copy, Default)]
struct Four {
    normal: [Vec4; 3],
    /// The distance at X beyond the target, and what the vertex slides by, as far as bodies make it [m].
    gap: Vec4,
    carried: [Vec4; 3],
    slack: Vec4,
    give: Vec4,
    friction: Vec4,
    /// The part that the vertex has, and by how much an impulse moves it [1/kg].
    part: Vec4,
    weight: Vec4,
    push: Vec4,
    hold: [Vec4; 3],
}

/// What four rows pushed and held, and of which cloths they are.
#[derive(Debug, Clone, Copy, Default)]
struct Before {
    push: Vec4,
    hold: [Vec4; 3],
    cloths: [u32; LANES],
}

impl Rows {
    /// Takes the rows that are alone. From now on what they push and hold stands there, until [`Rows::unpack`].
    pub fn pack(&mut self, pool: &Pool) {
        let Self { list, d, weights, alone, lanes: Lanes { rows, before }, .. } = self;
        let list = &list[..alone.count];
        rows.clear();
        rows.resize(list.len().div_ceil(LANES), Four::default());
        before.clear();
        before.resize(rows.len(), Before::default());
        for_each_of_both(rows, before, 1, pool, |first, rows, before| {
            let fours = list[LANES * first..].chunks(LANES).enumerate();
            for ((index, four), (packed, then)) in fours.zip(rows.iter_mut().zip(before)) {
                for (lane, row) in four.iter().enumerate() {
                    let own = LANES * (first + index) + lane;
                    packed.put(lane, row, own, d, weights[own]);
                    then.push[lane] = row.before.0;
                    put(&mut then.hold, lane, row.before.1);
                    then.cloths[lane] = row.cloth;
                }
            }
        });
    }

    /// Gives rows back what they push and hold.
    pub fn unpack(&mut self) {
        let Self { list, alone, lanes: Lanes { rows, before }, .. } = self;
        let packed = rows.iter().zip(before);
        for (four, (now, then)) in list[..alone.count].chunks_mut(LANES).zip(packed) {
            for (lane, row) in four.iter_mut().enumerate() {
                (row.push, row.hold) = (now.push[lane], at(&now.hold, lane));
                row.before = (then.push[lane], at(&then.hold, lane));
            }
        }
    }

    /// Projects all rows.
    pub fn sweep(&mut self, pool: &Pool) {
        let Self { list, d, weights, alone, lanes, .. } = self;
        for_each_of_both(&mut lanes.rows, &mut d[..alone.count], LANES, pool, |_, rows, d| arch().dispatch(Sweep { rows, d }));
        list[alone.count..].iter_mut().for_each(|row| row.project(d, weights, |_, _| ()));
    }

    /// Goes on with the momentum with which the displacements of each cloth do: what they gain by pushes, pushes gain as well.
    pub fn go_on(&mut self, momenta: &[f32], pool: &Pool) {
        let of = |cloth: u32| momenta.get(cloth as usize).copied();
        let Self { list, alone, lanes: Lanes { rows, before }, .. } = self;
        for_each_of_both(rows, before, 1, pool, |_, rows, before| {
            for (row, before) in rows.iter_mut().zip(before) {
                let momentum = Vec4::from_array(before.cloths.map(|cloth| of(cloth).unwrap_or_default()));
                let (push, hold) = (row.push, row.hold);
                row.push += (push - before.push) * momentum;
                row.hold = [0, 1, 2].map(|axis| hold[axis] + (hold[axis] - before.hold[axis]) * momentum);
                (before.push, before.hold) = (push, hold);
            }
        });
        for row in &mut list[alone.count..] {
            if let Some(momentum) = of(row.cloth) {
                let now = (row.push, row.hold);
                row.push += (now.0 - row.before.0) * momentum;
                row.hold += (now.1 - row.before.1) * momentum;
                row.before = now;
            }
        }
    }

    /// What a row has pushed so far [kg m], to be changed.
    pub(super) fn push_of(&mut self, row: usize) -> &mut f32 {
        match row < self.alone.count {
            true => &mut self.lanes.rows[row / LANES].push[row % LANES],
            false => &mut self.list[row].push,
        }
    }

    /// The distance of a row beyond its target now [m], and what it has pushed so far [kg m].
    pub(super) fn gap_and_push(&self, row: usize) -> (f32, f32) {
        if row >= self.alone.count {
            let row = &self.list[row];
            return (self.gap(row), row.push);
        }
        let (four, lane) = (&self.lanes.rows[row / LANES], row % LANES);
        let d = self.d[row];
        let along = four.normal[0][lane] * d.x + four.normal[1][lane] * d.y + four.normal[2][lane] * d.z;
        (four.gap[lane] + along * four.part[lane], four.push[lane])
    }

    /// Calls `visit` with the numbers of rows that are not kept, as long as these are at most so many. Returns whether they are.
    pub(super) fn unkept_rows(&self, most: usize, mut visit: impl FnMut(usize)) -> bool {
        let mut left = most;
        let mut take_one = |row: usize| match left.checked_sub(1) {
            Some(fewer) => {
                left = fewer;
                visit(row);
                true
            }
            None => false,
        };
        for (index, (row, d)) in self.lanes.rows.iter().zip(self.d.chunks(LANES)).enumerate() {
            let unkept = row.unkept(take(d)).bitmask();
            if unkept != 0 && !(0..LANES).all(|lane| unkept >> lane & 1 == 0 || take_one(LANES * index + lane)) {
                return false;
            }
        }
        let mut others = (self.alone.count..).zip(&self.list[self.alone.count..]);
        others.all(|(index, row)| self.is_kept(row) || take_one(index))
    }

    /// Projects a row if it is not kept. Tells which vertices that moves, and how far [m].
    pub(super) fn put_row_right(&mut self, row: usize, mut tell: impl FnMut(usize, Vec3)) {
        if row >= self.alone.count {
            if !self.is_kept(&self.list[row]) {
                let Self { list, d, weights, vertices, .. } = self;
                list[row].project(d, weights, |local, way| tell(vertices[local] as usize, way));
            }
            return;
        }
        let (four, lane) = (&mut self.lanes.rows[row / LANES], row % LANES);
        let d = &mut self.d[row - lane..];
        let at_start = take(d);
        if four.unkept(at_start).bitmask() >> lane & 1 == 0 {
            return;
        }
        let Answer { push, hold, way } = four.answer(at_start);
        four.push[lane] = push[lane];
        put(&mut four.hold, lane, at(&hold, lane));
        let way = at(&way, lane);
        if way != Vec3::ZERO {
            d[lane] += way;
            tell(self.vertices[row] as usize, way);
        }
    }
}

/// What rows push and hold in answer to displacements, and what that moves their vertices by [m].
struct Answer {
    push: Vec4,
    hold: [Vec4; 3],
    way: [Vec4; 3],
}

impl Four {
    /// Puts a row in a lane, the one of the vertex `own` in the workspace, with what bodies do, and what an impulse gives that [1/kg].
    fn put(&mut self, lane: usize, row: &Row, own: usize, d: &[Vec3], weight: f32) {
        let (mut part, mut moved) = (0.0, Vec3::ZERO);
        for end in 0..4 {
            match row.ends[end] as usize {
                local if local == own => part += row.parts[end],
                local => moved += d[local] * row.parts[end],
            }
        }
        let along = row.normal.dot(moved);
        put(&mut self.normal, lane, row.normal);
        put(&mut self.carried, lane, moved - row.normal * along + row.carried);
        put(&mut self.hold, lane, row.hold);
        self.gap[lane] = row.gap + along;
        self.slack[lane] = row.slack;
        self.give[lane] = row.give;
        self.friction[lane] = row.friction;
        self.part[lane] = part;
        self.weight[lane] = part * weight;
        self.push[lane] = row.push;
    }

    /// The distance beyond the target with such displacements of the vertices [m].
    #[inline(always)]
    fn gaps(&self, d: [Vec4; 3]) -> Vec4 {
        self.gap + dot(self.normal, d) * self.part
    }

    #[inline(always)]
    fn unkept(&self, d: [Vec4; 3]) -> BVec4A {
        !self.gaps(d).cmpge(-self.slack) & self.give.cmpgt(Vec4::ZERO)
    }

    /// As a row answers by itself ([`super::Row::respond`]).
    #[inline(always)]
    fn answer(&self, d: [Vec4; 3]) -> Answer {
        let Self { normal, gap, carried, give, friction, part, weight, push: pushed, hold: held, .. } = self;
        let along = dot(*normal, d) * *part;
        let push = (*pushed - (*gap + along) * *give).max(Vec4::ZERO);
        let hold = [0, 1, 2].map(|axis| held[axis] - (d[axis] * *part - normal[axis] * along + carried[axis]) * *give);
        let (square, most) = (dot(hold, hold), *friction * push);
        let slides = square.cmpgt(most * most);
        let shorter = Vec4::select(slides, most / roots(square), Vec4::ONE);
        let hold = hold.map(|hold| hold * shorter);
        let gained = push - *pushed;
        let way = [0, 1, 2].map(|axis| (normal[axis] * gained + (hold[axis] - held[axis])) * *weight);
        Answer { push, hold, way }
    }

    /// Whether none of them touches anything, and none has.
    #[inline(always)]
    fn is_apart(&self, d: [Vec4; 3]) -> bool {
        let [x, y, z] = self.hold;
        let free = self.gaps(d).cmpge(Vec4::ZERO) & self.push.cmple(Vec4::ZERO);
        (free & (x.abs() + y.abs() + z.abs()).cmpeq(Vec4::ZERO)).all()
    }
}

/// Rows with the displacements of their vertices [m].
struct Sweep<'a> {
    rows: &'a mut [Four],
    d: &'a mut [Vec3],
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (row, d) in self.rows.iter_mut().zip(self.d.chunks_mut(LANES)) {
            let start = take(d);
            if row.is_apart(start) {
                row.push = Vec4::ZERO;
                continue;
            }
            let Answer { push, hold, way } = row.answer(start);
            (row.push, row.hold) = (push, hold);
            d.iter_mut().zip(by_vector(way)).for_each(|(d, way)| *d += way.truncate());
        }
    }
}

/// Each coordinate of up to four vectors, and of zero for those that are missing.
#[inline(always)]
fn take(vectors: &[Vec3]) -> [Vec4; 3] {
    match vectors {
        [a, b, c, d, ..] => by_axis([a.extend(0.0), b.extend(0.0), c.extend(0.0), d.extend(0.0)]),
        _ => by_axis([0, 1, 2, 3].map(|lane| vectors.get(lane).map_or(Vec4::ZERO, |vector| vector.extend(0.0)))),
    }
}

#[inline(always)]
fn dot([a, b, c]: [Vec4; 3], [d, e, f]: [Vec4; 3]) -> Vec4 {
    a * d + b * e + c * f
}

fn at(by_axis: &[Vec4; 3], lane: usize) -> Vec3 {
    Vec3::new(by_axis[0][lane], by_axis[1][lane], by_axis[2][lane])
}

fn put(by_axis: &mut [Vec4; 3], lane: usize, vector: Vec3) {
    (0..3).for_each(|axis| by_axis[axis][lane] = vector[axis]);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::NONE;
    use super::*;

    prop_compose! {
        /// A row of the vertex 0 and another one, with their displacements [m] and the inverse mass of the first [1/kg].
        fn row()(
            normal in prop::array::uniform3(-1.0_f32..1.0),
            d in prop::array::uniform2(prop::array::uniform3(-0.01_f32..0.01)),
            hold in prop::array::uniform3(-1e-3_f32..1e-3),
            carried in prop::array::uniform3(-1e-3_f32..1e-3),
            gap in -0.01_f32..0.01,
            friction in 0.0_f32..1.0,
            push in 0.0_f32..0.01,
            weight in 0.1_f32..10.0,
            sign in prop::sample::select(vec![-1.0_f32, 1.0]),
        ) -> (Row, [Vec3; 2], f32) {
            let row = Row {
                key: [[NONE; 3]; 2],
                ends: [0, 1, 1, 1],
                parts: [sign, -sign, 0.0, 0.0],
                normal: Vec3::from(normal).normalize_or(Vec3::X),
                gap,
                slack: 1e-3,
                distance: 0.0,
                thickness: 0.0,
                floor: 0.0,
                give: 1.0 / weight,
                friction,
                push,
                hold: Vec3::from(hold),
                grips: 0.0,
                before: (0.0, Vec3::ZERO),
                cloth: 0,
                carried: Vec3::from(carried),
            };
            (row, d.map(Vec3::from), weight)
        }
    }

    proptest! {
        /// Four rows together answer as each does by itself, in any lane; where there are fewer the others do nothing.
        #[test]
        fn rows_answer_together_as_each_does_alone(rows in prop::collection::vec(row(), 1..=LANES)) {
            let mut four = Four::default();
            let mut d = Vec::new();
            for (lane, (row, ways, weight)) in rows.iter().enumerate() {
                four.put(lane, row, 0, ways, *weight);
                d.push(ways[0]);
            }
            let unkept = four.unkept(take(&d)).bitmask();
            let is_apart = four.is_apart(take(&d));
            Sweep { rows: std::slice::from_mut(&mut four), d: &mut d }.with_simd(pulp::Scalar::new());
            let mut any = false;
            for (lane, (row, ways, weight)) in rows.iter().enumerate() {
                let (mut alone, mut then) = (*row, *ways);
                alone.project(&mut then, &[*weight, 0.0], |_, _| ());
                prop_assert!((four.push[lane] - alone.push).abs() < 1e-6, "{} and {}", four.push[lane], alone.push);
                prop_assert!((at(&four.hold, lane) - alone.hold).length() < 1e-6);
                prop_assert!((d[lane] - then[0]).length() < 1e-6, "{} and {}", d[lane], then[0]);
                let gap = row.gap + row.normal.dot((ways[0] - ways[1]) * row.parts[0]);
                prop_assert!((gap + row.slack).abs() < 1e-6 || (unkept >> lane & 1 == 1) == (gap < -row.slack));
                any |= then[0] != ways[0];
            }
            prop_assert!(unkept >> rows.len() == 0);
            prop_assert!(!is_apart || !any);
        }
    }
}
