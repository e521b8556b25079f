//! How springs, bending and dampers of a cloth answer to small changes: -dF/dX and -dF/dV, for implicit integrators.
//!
//! Both are sums over pairs of particles: `a N N^T + b I` of the one and `c I` of the other, acting on the difference of the
//! two. A spring of length l pulls back with k along N and with `k (1 - L / l)` across it (docs/equations.md, "Stiffness"). In a
//! compressed spring the latter is negative, and the linear system could lose its solution. It is left out, as Choi & Ko
//! (*Stable but responsive cloth*, 2002, section 4) do. What is left never pulls back too little. That is stable, and costs
//! no more than accuracy.

use glam::DVec3;

use crate::geometry::{Pool, Vectors, for_each_chunk};
use crate::model::{Adjacency, Buckling, ClothRange, Model};

/// The pairs of one cloth; particles are counted from its first.
pub(crate) struct Stiffness {
    first: usize,
    pairs: Vec<Pair>,
    around: Adjacency<Tie>,
    answers: Vec<Answer>,
}

/// A pair as one of its ends sees it.
#[derive(Debug, Clone, Copy, Default)]
struct Tie {
    other: u32,
    pair: u32,
}

struct Pair {
    ends: [u32; 2],
    law: Law,
}

enum Law {
    Spring {
        rest: f64,
        stiffness: f64,
        damping: f64,
    },
    Buckling(Buckling),
    /// A pair in the matrix of quadratic bending: its pull per distance [N/m].
    Bend(f64),
}

/// What a pair answers with.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Answer {
    /// N.
    pub direction: DVec3,
    /// a [N/m].
    pub along: f64,
    /// b [N/m].
    pub all_ways: f64,
    /// c [kg/s].
    pub damping: f64,
}

impl Stiffness {
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let (springs, particles) = (&model.springs, cloth.particles());
        let local = |end: usize| (end - cloth.first) as u32;
        let of_cloth = (0..springs.len()).filter(|&spring| particles.contains(&(springs.ends[spring][0] as usize)));
        let springs = of_cloth.map(|spring| Pair {
            ends: springs.ends[spring].map(|end| local(end as usize)),
            law: Law::Spring {
                rest: f64::from(springs.rest[spring]),
                // A spring with a curve is taken to be as stiff everywhere as where it is stiffest.
                stiffness: f64::from(springs.force_stiffness[spring] + springs.steepest[spring]),
                damping: f64::from(springs.damping[spring]),
            },
        });
        // Each pair stands in the lists of both its ends.
        let bends = cloth.particles().flat_map(|here| {
            let others = model.bending.quadratic.of(here).iter().filter(move |bend| bend.other as usize > here);
            others
                .map(move |bend| Pair { ends: [local(here), local(bend.other as usize)], law: Law::Bend(f64::from(bend.weight)) })
        });
        let buckling = cloth.particles().flat_map(|here| {
            let others = model.bending.buckling.of(here).iter().filter(move |spring| spring.other as usize > here);
            others.map(move |spring| Pair { ends: [local(here), local(spring.other as usize)], law: Law::Buckling(*spring) })
        });
        let pairs: Vec<Pair> = springs.chain(bends).chain(buckling).collect();
        let both_ways = (0_u32..)
            .zip(&pairs)
            .flat_map(|(pair, Pair { ends: [a, b], .. })| [(*a, *b), (*b, *a)].map(|(here, other)| (here, Tie { other, pair })));
        let around = Adjacency::new(cloth.count, both_ways);
        Self { first: cloth.first, answers: vec![Answer::default(); pairs.len()], pairs, around }
    }

    /// Looks at all pairs with the particles at these positions.
    pub fn look(&mut self, positions: &Vectors, pool: &Pool) {
        let Self { first, pairs, answers, .. } = self;
        for_each_chunk(answers, pool, |start, answers| {
            for (answer, Pair { ends, law }) in answers.iter_mut().zip(&pairs[start..]) {
                let [a, b] = ends.map(|end| positions.get(*first + end as usize).as_dvec3());
                *answer = law.answer(b - a);
            }
        });
    }

    /// The other particle and the answer of every pair of a particle.
    #[inline]
    pub fn around(&self, particle: usize) -> impl Iterator<Item = (usize, &Answer)> {
        self.around.of(particle).iter().map(|tie| (tie.other as usize, &self.answers[tie.pair as usize]))
    }
}

impl Law {
    fn answer(&self, way: DVec3) -> Answer {
        let length = way.length();
        // Two particles at the same place have no direction.
        let direction = if length > 0.0 { way / length } else { DVec3::ZERO };
        match self {
            Self::Spring { rest, stiffness, damping } => {
                let across = if length > 0.0 { stiffness * (1.0 - rest / length).max(0.0) } else { *stiffness };
                Answer { direction, along: stiffness - across, all_ways: across, damping: *damping }
            }
            Self::Buckling(spring) => Answer { direction, along: spring.slope(length).max(0.0), ..Answer::default() },
            Self::Bend(pull) => Answer { all_ways: *pull, ..Answer::default() },
        }
    }
}
