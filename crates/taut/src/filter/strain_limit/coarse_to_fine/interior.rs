//! The place within all limits that is nearest to the proposed one, by an interior-point method.
//!
//! The smallest `1/2 sum M |D - D*|^2` with `g = 1/2 (|P_uv|^2 / a^2 - 1) <= 0` for every spring is a convex problem. With slacks s and
//! multipliers m >= 0 of springs it is solved by primal-dual Newton steps, each with a predictor and a corrector (Mehrotra, SIAM J. Optim. 2(4),
//! 1992; Nocedal and Wright, Numerical Optimization, section 19.3):
//!
//! `(M + sum m L / a^2 + sum m / s j j^T) dD = ..`, j the gradient of g and L the Laplacian of a spring: blocks of 3 x 3 for each particle
//! and each spring. L is what projections along fixed directions do not have: it knows that springs turn.

use glam::{DMat3, DVec3};

use super::blocks::{Blocks, add_to, of, outer};

/// Newton steps at most.
const ROUNDS: usize = 60;
/// Steps end this close to where a slack or a multiplier would be zero.
const NEAR: f64 = 0.99;
/// Where products of slacks and multipliers come to so many times the energy in question, aims contradict each other.
const HOPELESS: f64 = 1e3;
/// The least slack at the start [1].
const LEAST_SLACK: f64 = 1e-6;

/// A limited spring in one step.
#[derive(Clone, Copy)]
pub(super) struct Link {
    /// Its particles, from the cloth's first.
    pub ends: [u32; 2],
    /// Where it begins [m], and how long it may be.
    pub start: DVec3,
    pub aim: f64,
}

impl Link {
    /// From one end to the other [m], where its particles went.
    pub fn way(&self, went: &[DVec3]) -> DVec3 {
        let [u, v] = self.ends.map(|end| went[end as usize]);
        self.start + (v - u)
    }
}

/// What is asked for.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub links: &'a [Link],
    /// W of each particle [1/kg].
    pub weights: &'a [f64],
    /// Displacements [m].
    pub proposed: &'a [DVec3],
    /// About twice the energy that is to change [kg m^2].
    pub energy: f64,
    /// About how far springs move, as a part of their lengths [1].
    pub spread: f64,
    /// What springs may be over their aims, as a part of these [1].
    pub exact: f64,
    /// What of that energy may be in doubt [1].
    pub nearly: f64,
}

/// The matrix of a cloth, and the iterate.
pub(super) struct Interior {
    /// Particles that may move, and the number of each among them.
    movable: Vec<u32>,
    number: Vec<Option<u32>>,
    /// The matrix, and, for each spring, the place of its block in a column.
    blocks: Blocks,
    places: Vec<u32>,
    springs: Vec<Iterate>,
    /// Right side, then the step [m].
    step: Vec<f64>,
}

/// Of a spring.
#[derive(Clone, Copy, Default)]
struct Iterate {
    gradient: DVec3,
    /// g, s and m.
    value: f64,
    slack: f64,
    multiplier: f64,
    /// Steps of the latter two.
    slack_step: f64,
    multiplier_step: f64,
    /// What is asked of m s, and of g + s.
    product: f64,
    residual: f64,
}

impl Interior {
    /// Of springs between such particles of a cloth; none if nothing moves.
    pub fn new(pairs: impl ExactSizeIterator<Item = [u32; 2]> + Clone, weights: &[f64], movable: &[usize]) -> Option<Self> {
        let mut number = vec![None; weights.len()];
        for (index, &particle) in (0_u32..).zip(movable) {
            number[particle] = Some(index);
        }
        let both = |[u, v]: [u32; 2]| Some([number[u as usize]?, number[v as usize]?]);
        let blocks = (!movable.is_empty()).then(|| Blocks::new(movable.len(), pairs.clone().filter_map(both)))??;
        Some(Self {
            places: pairs.clone().map(|ends| both(ends).and_then(|columns| blocks.place(columns)).unwrap_or(0)).collect(),
            springs: vec![Iterate::default(); pairs.len()],
            step: vec![0.0; 3 * movable.len()],
            movable: movable.iter().map(|particle| *particle as u32).collect(),
            number,
            blocks,
        })
    }

    /// Finds the displacements within all aims that are nearest to the proposed ones, from `found` on [m]. Returns whether that was done.
    pub fn run(&mut self, task: Task<'_>, found: &mut [DVec3]) -> bool {
        let Task { links, weights, proposed, energy, spread, exact, nearly } = task;
        self.look(links, found);
        for spring in &mut self.springs {
            spring.slack = spring.value.abs().max(spread).max(LEAST_SLACK);
            spring.multiplier = energy / links.len() as f64 / spring.slack;
        }
        for _ in 0..ROUNDS {
            let mean = self.springs.iter().map(|spring| spring.slack * spring.multiplier).sum::<f64>() / links.len() as f64;
            let worst = self.springs.iter().fold(0.0, |worst: f64, spring| worst.max(spring.value));
            let off = self.residual(links, weights, proposed, found);
            if worst <= exact && mean * links.len() as f64 <= nearly * energy && off <= nearly * nearly * energy {
                return true;
            }
            if mean * links.len() as f64 > HOPELESS * energy || !self.factorise(links, weights) {
                return false;
            }
            // The predictor goes for the solution itself ..
            for spring in &mut self.springs {
                (spring.product, spring.residual) = (0.0, spring.value + spring.slack);
            }
            self.solve(links, weights, proposed, found);
            let part = self.reach(1.0);
            let product = |spring: &Iterate| {
                (spring.slack + part * spring.slack_step) * (spring.multiplier + part * spring.multiplier_step)
            };
            let ahead = self.springs.iter().map(product).sum::<f64>() / links.len() as f64;
            // .. and tells how far from the boundary the corrector is to stay.
            let left = ahead / mean;
            let centre = (left * left * left).min(1.0) * mean;
            for (spring, link) in self.springs.iter_mut().zip(links) {
                let [u, v] = link.ends.map(|end| Self::step_of(&self.number, &self.step, end));
                spring.product = centre - spring.slack_step * spring.multiplier_step;
                spring.residual += 0.5 * (v - u).length_squared() / (link.aim * link.aim);
            }
            self.solve(links, weights, proposed, found);
            let part = self.reach(NEAR);
            for (column, &particle) in self.movable.iter().enumerate() {
                found[particle as usize] += part * of(&self.step, column as u32);
            }
            for spring in &mut self.springs {
                spring.slack += part * spring.slack_step;
                spring.multiplier += part * spring.multiplier_step;
            }
            self.look(links, found);
        }
        false
    }

    fn step_of(number: &[Option<u32>], step: &[f64], particle: u32) -> DVec3 {
        number[particle as usize].map_or(DVec3::ZERO, |column| of(step, column))
    }

    /// Springs at the present displacements.
    fn look(&mut self, links: &[Link], found: &[DVec3]) {
        for (spring, link) in self.springs.iter_mut().zip(links) {
            let (way, square) = (link.way(found), link.aim * link.aim);
            spring.gradient = way / square;
            spring.value = 0.5 * (way.length_squared() / square - 1.0);
        }
    }

    /// What is left of M (D - D*) + sum m j, as a motion: twice its energy.
    fn residual(&mut self, links: &[Link], weights: &[f64], proposed: &[DVec3], found: &[DVec3]) -> f64 {
        self.right_side(links, weights, proposed, found, |spring| spring.multiplier);
        let places = self.movable.iter().enumerate();
        places.map(|(column, &particle)| of(&self.step, column as u32).length_squared() * weights[particle as usize]).sum()
    }

    /// -(M (D - D*) + sum j pull(spring)), into the step.
    fn right_side(
        &mut self,
        links: &[Link],
        weights: &[f64],
        proposed: &[DVec3],
        found: &[DVec3],
        pull: impl Fn(&Iterate) -> f64,
    ) {
        for (column, &particle) in self.movable.iter().enumerate() {
            let particle = particle as usize;
            ((proposed[particle] - found[particle]) / weights[particle]).write_to_slice(&mut self.step[3 * column..]);
        }
        for (spring, link) in self.springs.iter().zip(links) {
            let force = spring.gradient * pull(spring);
            for (end, force) in link.ends.into_iter().zip([force, -force]) {
                if let Some(column) = self.number[end as usize] {
                    add_to(&mut self.step, column, force);
                }
            }
        }
    }

    fn factorise(&mut self, links: &[Link], weights: &[f64]) -> bool {
        self.blocks.begin(self.movable.iter().map(|&particle| weights[particle as usize].recip()));
        for ((spring, link), &place) in self.springs.iter().zip(links).zip(&self.places) {
            let across = DVec3::splat(spring.multiplier / (link.aim * link.aim));
            let block =
                outer(spring.gradient, spring.gradient * (spring.multiplier / spring.slack)) + DMat3::from_diagonal(across);
            let numbers = link.ends.map(|end| self.number[end as usize]);
            numbers.into_iter().flatten().for_each(|column| self.blocks.add(column, &block));
            if let [Some(u), Some(v)] = numbers {
                self.blocks.add_between([u, v], place, &(block * -1.0));
            }
        }
        self.blocks.factorise()
    }

    /// The steps of displacements, slacks and multipliers for what is asked of springs.
    fn solve(&mut self, links: &[Link], weights: &[f64], proposed: &[DVec3], found: &[DVec3]) {
        // m + dm = (product + m (residual + j dD)) / s
        self.right_side(links, weights, proposed, found, |spring| {
            (spring.product + spring.multiplier * spring.residual) / spring.slack
        });
        self.blocks.solve(&mut self.step);
        for (spring, link) in self.springs.iter_mut().zip(links) {
            let [u, v] = link.ends.map(|end| Self::step_of(&self.number, &self.step, end));
            let closer = spring.gradient.dot(v - u);
            spring.slack_step = -spring.residual - closer;
            spring.multiplier_step = (spring.product - spring.multiplier * spring.slack_step) / spring.slack - spring.multiplier;
        }
    }

    /// The part of the step, 1 at most, at which slacks and multipliers have come to `near` of zero.
    fn reach(&self, near: f64) -> f64 {
        let to_zero = |value: f64, step: f64| if step < 0.0 { -near * value / step } else { 1.0 };
        self.springs.iter().fold(1.0, |part: f64, spring| {
            part.min(to_zero(spring.slack, spring.slack_step)).min(to_zero(spring.multiplier, spring.multiplier_step))
        })
    }
}
