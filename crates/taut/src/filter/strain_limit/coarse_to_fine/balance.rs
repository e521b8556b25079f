//! The place within all limits and rows that is nearest to the proposed one, with friction within Coulomb's cone.
//!
//! As interior.rs, with rows `gap + n . u + k p >= 0` beside the springs, u being the relative displacement of the features of a row
//! and p its push: its multiplier. k p is what a row gives way, next to nothing where rows can be kept; where they contradict each
//! other they share what is too narrow, and pushes stay finite.
//!
//! Under a taut cloth the place where an edge is closest goes far along it while the edge tilts little. So the distance of an edge whose ends
//! go apart by t along n is less by `tilt t^2 / 2` (docs/equations.md). Without that the light points of a cloth over a rod go to and fro by a tenth of its
//! thickness in every step, and that shakes it down.
//!
//! Friction is the smallest `1/2 sum M |D - D*|^2 + sum b |u_t|`, whose multipliers are within |t| <= b, with `b = mu p`. p is that of the
//! Newton step before: a fixed-point iteration within the others. |u_t| is smoothed as much as the products of slacks and multipliers
//! are above zero, and its multipliers are unknowns of their own (Chan, Golub and Mulet, SIAM J. Sci. Comput. 20(6), 1999): what sticks
//! and what slides is found as what is taut is.

mod best;

use glam::{DMat3, DVec3};

use best::Best;

use super::blocks::{Blocks, add_to, of, outer};
use super::interior::Link;
use crate::contact::Support;

/// Newton steps at most.
const ROUNDS: usize = 40;
/// Steps end this close to where a slack or a multiplier would be zero.
const NEAR: f64 = 0.99;
/// .. and of what is left to the bound of friction they take this part at most.
const NEAR_BOUND: f64 = 0.9;
/// Where products of slacks and multipliers come to so many times the energy in question, aims contradict each other.
const HOPELESS: f64 = 1e3;
/// The least slack of a spring at the start [1], and of a row, as a part of its own.
const LEAST_SLACK: f64 = 1e-6;
/// What |u_t| is smoothed by, times b, as a part of the mean product of slacks and multipliers.
const SMOOTHED: f64 = 1.0;
/// .. and at least by this part of about how far the features would go.
const SMOOTHEST: f64 = 1e-4;
/// Rows are kept to within this part of their slack.
const KEPT: f64 = 0.01;
/// What of the energy the forces that are left may change [1]: friction is found by a fixed-point iteration, slowly at last.
const OFF: f64 = 3e-7;
/// After so many Newton steps so many times as much is enough with each.
const EXACT_NEWTON_STEPS: usize = 20;
const TOLERANCE_GROWTH: f64 = 2.0;
/// Products need not be made smaller than this part of what is enough.
const LAST: f64 = 0.1;
pub(super) const NONE: u32 = u32::MAX;

/// What is asked for.
pub(super) struct Task<'a> {
    /// Springs between particles.
    pub links: &'a [Link],
    /// The column of each particle, or none if it does not move; and the particles of the columns.
    pub number: &'a [u32],
    pub movable: &'a [u32],
    /// M of each column [kg], and its proposed displacement [m].
    pub masses: &'a [f64],
    pub proposed: &'a [DVec3],
    /// Rows, of particles.
    pub supports: &'a mut [Support],
    /// How much rows give way for their pushes, times their slack [1/(kg m)].
    pub give: f64,
    /// About twice the energy that is to change [kg m^2], and about how far springs move, as a part of their lengths, and rows [m].
    pub energy: f64,
    pub spread: f64,
    pub way: f64,
    /// What springs may be over their aims, as a part of these [1], and what of the energy may be in doubt [1].
    pub exact: f64,
    pub nearly: f64,
}

/// A multiplier and what it is of.
#[derive(Clone, Copy, Default)]
struct Pair {
    slack: f64,
    multiplier: f64,
    slack_step: f64,
    multiplier_step: f64,
    /// What is asked of the product of both, and what is missing between the slack and what it is the slack of.
    product: f64,
    residual: f64,
}

/// A spring.
#[derive(Clone, Copy, Default)]
struct Strut {
    columns: [u32; 2],
    place: u32,
    gradient: DVec3,
    value: f64,
    pair: Pair,
}

/// A row.
#[derive(Clone, Copy)]
struct Foot {
    columns: [u32; 4],
    parts: [f64; 4],
    places: [u32; 6],
    /// The gradient of its distance by each of its nodes, how far its edge tilts [m], and the gradient of that.
    slopes: [DVec3; 4],
    tilted: f64,
    leans: [DVec3; 4],
    /// gap + n . u - tilt tilted^2 / 2 + what going straight on along a round body adds, and how much it gives way for a push.
    value: f64,
    give: f64,
    pair: Pair,
    /// u_t, its smoothed length, and the multiplier of it, as a part of b.
    sideways: DVec3,
    length: f64,
    hold: DVec3,
    hold_step: DVec3,
    bound: f64,
}

/// The pairs of the four ends of a row.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Workspace.
#[derive(Default)]
pub(super) struct Balance {
    struts: Vec<Strut>,
    feet: Vec<Foot>,
    /// Right side, then the step [m].
    step: Vec<f64>,
    best: Best,
}

impl Balance {
    /// Finds the displacements, from `found` on [m]; both are of columns for what moves and of particles for links. Returns the number of
    /// Newton steps, if that was done, and has rows know what they push and hold.
    pub fn run(&mut self, task: &mut Task<'_>, blocks: &mut Blocks, found: &mut [DVec3]) -> Option<usize> {
        self.begin(task, blocks);
        self.look(task, found);
        let count = (self.struts.len() + self.feet.len()) as f64;
        let (each, least) = (task.energy / count, LEAST_SLACK);
        for strut in &mut self.struts {
            strut.pair.slack = strut.value.abs().max(task.spread).max(least);
            strut.pair.multiplier = each / strut.pair.slack;
        }
        for (foot, support) in self.feet.iter_mut().zip(&*task.supports) {
            foot.pair.slack = foot.value.abs().max(task.way).max(least * support.slack);
            foot.pair.multiplier = each / foot.pair.slack;
        }
        let mut loose = 1.0;
        self.best.missing = f64::INFINITY;
        for round in 0..ROUNDS {
            let sum = self.products(0.0);
            let mean = sum / count;
            let doubt = self.smooth(mean, SMOOTHEST * task.way, task.supports);
            let worst = self.struts.iter().fold(0.0, |worst: f64, strut| worst.max(strut.value));
            let off = self.residual(task, found);
            let kept = self.feet.iter().zip(&*task.supports).all(|(foot, support)| {
                (foot.value + foot.give * foot.pair.multiplier - foot.pair.slack).abs() <= KEPT * support.slack
            });
            let sure = task.nearly * task.energy;
            loose *= if round > EXACT_NEWTON_STEPS { TOLERANCE_GROWTH } else { 1.0 };
            if worst <= task.exact && kept {
                let missing = (sum.max(doubt) / sure).max(off / (OFF * task.energy));
                self.best.keep(task, &self.feet, found, missing);
            }
            if self.best.missing <= loose {
                self.best.tell(task, found);
                return Some(round);
            }
            if sum.is_nan() || sum > HOPELESS * task.energy || !self.factorise(task, blocks) {
                return None;
            }
            // The predictor goes for the solution itself ..
            for strut in &mut self.struts {
                (strut.pair.product, strut.pair.residual) = (0.0, strut.value + strut.pair.slack);
            }
            for foot in &mut self.feet {
                let kept = foot.value + foot.give * foot.pair.multiplier;
                (foot.pair.product, foot.pair.residual) = (0.0, foot.pair.slack - kept);
            }
            self.solve(task, blocks, found);
            let left = self.products(self.reach(1.0)) / sum;
            // .. and tells how far from the boundary the corrector is to stay.
            let centre = ((left * left * left).min(1.0) * mean).max(LAST * sure / count);
            for (strut, link) in self.struts.iter_mut().zip(task.links) {
                let [u, v] = strut.columns.map(|column| step_of(&self.step, column));
                strut.pair.product = centre - strut.pair.slack_step * strut.pair.multiplier_step;
                strut.pair.residual += 0.5 * (v - u).length_squared() / (link.aim * link.aim);
            }
            for (foot, support) in self.feet.iter_mut().zip(&*task.supports) {
                foot.pair.product = centre - foot.pair.slack_step * foot.pair.multiplier_step;
                let ends = foot.columns.into_iter().zip(foot.leans);
                let tilted: f64 = ends.map(|(column, lean)| lean.dot(step_of(&self.step, column))).sum();
                foot.pair.residual += 0.5 * support.tilt * tilted * tilted;
            }
            self.solve(task, blocks, found);
            let part = self.reach(NEAR);
            for (column, &particle) in task.movable.iter().enumerate() {
                found[particle as usize] += part * of(&self.step, column as u32);
            }
            self.struts.iter_mut().for_each(|strut| strut.pair.go(part));
            for foot in &mut self.feet {
                foot.pair.go(part);
                foot.hold = within(foot.hold, part * foot.hold_step);
            }
            self.look(task, found);
        }
        None
    }

    fn begin(&mut self, task: &Task<'_>, blocks: &Blocks) {
        let column = |particle: u32| task.number[particle as usize];
        let place = |pair: [u32; 2]| if pair.contains(&NONE) { NONE } else { blocks.place(pair).unwrap_or(NONE) };
        self.step.resize(3 * task.movable.len(), 0.0);
        self.struts.clear();
        self.struts.extend(task.links.iter().map(|link| {
            let columns = link.ends.map(column);
            Strut { columns, place: place(columns), ..Strut::default() }
        }));
        self.feet.clear();
        self.feet.extend(task.supports.iter().map(|support| {
            let columns = support.nodes.map(|(particle, part)| if part == 0.0 { NONE } else { column(particle) });
            let mut leans = support.nodes.map(|(_, part)| support.roll * part);
            if support.tilt > 0.0 {
                leans[support.edge[0]] -= support.normal;
                leans[support.edge[1]] += support.normal;
            }
            Foot {
                columns,
                slopes: [DVec3::ZERO; 4],
                tilted: 0.0,
                leans,
                parts: support.nodes.map(|(_, part)| part),
                places: PAIRS.map(|pair| place(pair.map(|end| columns[end]))),
                value: 0.0,
                give: task.give * support.slack,
                pair: Pair::default(),
                sideways: DVec3::ZERO,
                length: 0.0,
                hold: DVec3::ZERO,
                hold_step: DVec3::ZERO,
                bound: 0.0,
            }
        }));
    }

    /// Springs and rows at the present displacements.
    fn look(&mut self, task: &Task<'_>, found: &[DVec3]) {
        for (strut, link) in self.struts.iter_mut().zip(task.links) {
            let (way, square) = (link.way(found), link.aim * link.aim);
            strut.gradient = way / square;
            strut.value = 0.5 * (way.length_squared() / square - 1.0);
        }
        for (foot, support) in self.feet.iter_mut().zip(&*task.supports) {
            let way: DVec3 = support.nodes.iter().map(|&(particle, part)| found[particle as usize] * part).sum();
            let along = support.normal.dot(way);
            let ends = support.nodes.iter().zip(foot.leans);
            foot.tilted = support.tilted + ends.map(|(&(particle, _), lean)| lean.dot(found[particle as usize])).sum::<f64>();
            let straight = support.roll.dot(way) + support.tilted;
            foot.value = support.gap + along + 0.5 * support.tilt * (straight * straight - foot.tilted * foot.tilted);
            let turned = support.tilt * foot.tilted;
            foot.slopes = std::array::from_fn(|end| support.normal * foot.parts[end] - foot.leans[end] * turned);
            foot.sideways = way - support.normal * along + support.sideways;
        }
    }

    /// Smooths friction as much as the products are above zero. Returns what of the energy that leaves in doubt.
    fn smooth(&mut self, mean: f64, least: f64, supports: &[Support]) -> f64 {
        let mut doubt = 0.0;
        for (foot, support) in self.feet.iter_mut().zip(supports) {
            foot.bound = support.friction * foot.pair.multiplier;
            if foot.bound > 0.0 {
                let least = least.max(SMOOTHED * mean / foot.bound);
                foot.length = (foot.sideways.length_squared() + least * least).sqrt();
                doubt += foot.bound * (foot.hold * foot.length - foot.sideways).length();
            }
        }
        doubt
    }

    /// The sum of the products of slacks and multipliers after a part of their steps.
    fn products(&self, part: f64) -> f64 {
        let product = |pair: &Pair| (pair.slack + part * pair.slack_step) * (pair.multiplier + part * pair.multiplier_step);
        self.struts.iter().map(|strut| product(&strut.pair)).sum::<f64>()
            + self.feet.iter().map(|foot| product(&foot.pair)).sum::<f64>()
    }

    /// What is left of M (D - D*) and of all that pushes and pulls, as a motion: twice its energy.
    fn residual(&mut self, task: &Task<'_>, found: &[DVec3]) -> f64 {
        self.right_side(task, found, |strut| strut.multiplier, |foot| (foot.pair.multiplier, foot.hold * foot.bound));
        let places = task.masses.iter().enumerate();
        places.map(|(column, mass)| of(&self.step, column as u32).length_squared() / mass).sum()
    }

    /// -(M (D - D*) + what springs pull) + what rows push and hold back, into the step.
    fn right_side(
        &mut self,
        task: &Task<'_>,
        found: &[DVec3],
        pull: impl Fn(&Pair) -> f64,
        push: impl Fn(&Foot) -> (f64, DVec3),
    ) {
        for (column, (&particle, mass)) in task.movable.iter().zip(task.masses).enumerate() {
            let missing = (task.proposed[particle as usize] - found[particle as usize]) * *mass;
            missing.write_to_slice(&mut self.step[3 * column..]);
        }
        for strut in &self.struts {
            let force = strut.gradient * pull(&strut.pair);
            for (column, force) in strut.columns.into_iter().zip([force, -force]).filter(|(column, _)| *column != NONE) {
                add_to(&mut self.step, column, force);
            }
        }
        for foot in &self.feet {
            let (along, back) = push(foot);
            for end in (0..4).filter(|&end| foot.columns[end] != NONE) {
                let force = foot.slopes[end] * along - back * foot.parts[end];
                add_to(&mut self.step, foot.columns[end], force);
            }
        }
    }

    fn factorise(&self, task: &Task<'_>, blocks: &mut Blocks) -> bool {
        blocks.begin(task.masses.iter().copied());
        for (strut, link) in self.struts.iter().zip(task.links) {
            let Pair { slack, multiplier, .. } = strut.pair;
            let across = multiplier / (link.aim * link.aim);
            let block = outer(strut.gradient, strut.gradient * (multiplier / slack)) + DMat3::from_diagonal(DVec3::splat(across));
            strut.columns.into_iter().filter(|column| *column != NONE).for_each(|column| blocks.add(column, &block));
            if strut.place != NONE {
                blocks.add_between(strut.columns, strut.place, &(block * -1.0));
            }
        }
        for (foot, support) in self.feet.iter().zip(&*task.supports) {
            let Pair { slack, multiplier, .. } = foot.pair;
            let normal = support.normal;
            let along = outer(normal, normal);
            let stiff = [multiplier / (slack + foot.give * multiplier), multiplier * support.tilt];
            let mut across = DMat3::ZERO;
            if foot.bound > 0.0 {
                let (unit, stiffness) = (foot.sideways / foot.length, foot.bound / foot.length);
                let both = outer(foot.hold, unit);
                across = (DMat3::IDENTITY - along - (both + both.transpose()) * 0.5) * stiffness;
            }
            let block = |one: usize, two: usize| {
                outer(foot.slopes[one], foot.slopes[two] * stiff[0])
                    + outer(foot.leans[one], foot.leans[two] * stiff[1])
                    + across * (foot.parts[one] * foot.parts[two])
            };
            for end in (0..4).filter(|&end| foot.columns[end] != NONE) {
                blocks.add(foot.columns[end], &block(end, end));
            }
            for ([one, two], place) in PAIRS.into_iter().zip(foot.places).filter(|(_, place)| *place != NONE) {
                // The rows of a block are of the earlier column.
                let [one, two] = if foot.columns[one] < foot.columns[two] { [one, two] } else { [two, one] };
                blocks.add_between([foot.columns[one], foot.columns[two]], place, &block(one, two));
            }
        }
        blocks.factorise()
    }

    /// The steps of displacements, slacks and multipliers for what is asked of them.
    fn solve(&mut self, task: &Task<'_>, blocks: &mut Blocks, found: &[DVec3]) {
        self.right_side(
            task,
            found,
            |pair| (pair.product + pair.multiplier * pair.residual) / pair.slack,
            |foot| {
                let Pair { slack, multiplier, product, residual, .. } = foot.pair;
                let soft = slack + foot.give * multiplier;
                let push = multiplier + (product - multiplier * slack + multiplier * residual) / soft;
                let back = if foot.bound > 0.0 { foot.sideways * (foot.bound / foot.length) } else { DVec3::ZERO };
                (push, back)
            },
        );
        blocks.solve(&mut self.step);
        for strut in &mut self.struts {
            let [u, v] = strut.columns.map(|column| step_of(&self.step, column));
            let pair = &mut strut.pair;
            pair.slack_step = -pair.residual - strut.gradient.dot(v - u);
            pair.multiplier_step = (pair.product - pair.multiplier * pair.slack_step) / pair.slack - pair.multiplier;
        }
        for (foot, support) in self.feet.iter_mut().zip(&*task.supports) {
            let ends = foot.columns.into_iter().zip(foot.parts);
            let way: DVec3 = ends.map(|(column, part)| step_of(&self.step, column) * part).sum();
            let along = support.normal.dot(way);
            let slopes = foot.columns.into_iter().zip(foot.slopes);
            let closer = slopes.map(|(column, slope)| slope.dot(step_of(&self.step, column))).sum::<f64>();
            let pair = &mut foot.pair;
            let Pair { slack, multiplier, product, residual, .. } = *pair;
            let soft = slack + foot.give * multiplier;
            pair.multiplier_step = (product - multiplier * slack + multiplier * (residual - closer)) / soft;
            pair.slack_step = closer - residual + foot.give * pair.multiplier_step;
            if foot.bound > 0.0 {
                let (unit, across) = (foot.sideways / foot.length, way - support.normal * along);
                foot.hold_step = (across - foot.hold * unit.dot(across) + foot.sideways) / foot.length - foot.hold;
            }
        }
    }

    /// The part of the step, 1 at most, at which slacks and multipliers have come to `near` of zero.
    fn reach(&self, near: f64) -> f64 {
        let struts = self.struts.iter().map(|strut| strut.pair.reach(near));
        struts.chain(self.feet.iter().map(|foot| foot.pair.reach(near))).fold(1.0, f64::min)
    }
}

impl Pair {
    fn go(&mut self, part: f64) {
        self.slack += part * self.slack_step;
        self.multiplier += part * self.multiplier_step;
    }

    fn reach(&self, near: f64) -> f64 {
        let to_zero = |value: f64, step: f64| if step < 0.0 { -near * value / step } else { 1.0 };
        to_zero(self.slack, self.slack_step).min(to_zero(self.multiplier, self.multiplier_step))
    }
}

/// What friction holds after a step, nearer to its bound by no more than most of what is left.
fn within(hold: DVec3, step: DVec3) -> DVec3 {
    let most = 1.0 - (1.0 - NEAR_BOUND) * (1.0 - hold.length()).max(0.0);
    let square = step.length_squared();
    if (hold + step).length_squared() <= most * most || square <= 0.0 {
        return hold + step;
    }
    let (along, left) = (hold.dot(step) / square, (most * most - hold.length_squared()).max(0.0) / square);
    hold + step * ((along * along + left).sqrt() - along).max(0.0)
}

fn step_of(step: &[f64], column: u32) -> DVec3 {
    if column == NONE { DVec3::ZERO } else { of(step, column) }
}
