//! How fast a cloth sets out whose masses are scaled.
//!
//! Levels whose particles are tied to what is held give an even load nothing there. With the shares a_l of what is borne the load gives
//! the cloth the part `sum_l sum_i a_l,i M_l,i / sum M` of its acceleration on the whole (docs/equations.md, "Scaled masses").

use super::{Hierarchy, shares, shares_of_nodes};
use crate::model::LevelRate;

/// From one w^2 that is looked at to the next [1].
const RATIO: f64 = 1.25;
/// What is over this counts as all [1].
const ALL: f64 = 0.999;

/// How much of its acceleration an even load gives a cloth, for the w^2 that is borne of each level.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EvenLoad {
    /// w^2 [1/s^2] and that part [1], both rising.
    parts: Vec<[f64; 2]>,
}

impl EvenLoad {
    /// Of levels whose particles are all alike; `moving` is the part of all mass that the particles of each carry [1].
    pub(super) fn of_levels(rates: &[LevelRate], moving: &[f64]) -> Self {
        Self::new(rates, |borne| {
            let shares = shares(borne, rates.iter().map(|rate| rate.frequency_squared));
            shares.iter().zip(moving).map(|(share, moving)| share * moving).sum()
        })
    }

    /// Of a mesh; `rates` are the fastest of its levels.
    pub(in crate::model) fn of_hierarchy(Hierarchy { levels }: &Hierarchy, rates: &[LevelRate]) -> Self {
        let all: f64 = levels[0].masses.iter().sum();
        Self::new(rates, |borne| {
            let shares = shares_of_nodes(borne, levels, |rate| rate.frequency_squared);
            let of_level = shares.iter().zip(levels);
            let moved = of_level.flat_map(|(shares, level)| shares.iter().zip(&level.masses)).map(|(share, mass)| share * mass);
            moved.sum::<f64>() / all
        })
    }

    fn new(rates: &[LevelRate], part: impl Fn(f64) -> f64) -> Self {
        let mut parts: Vec<[f64; 2]> = Vec::new();
        let (Some(coarsest), Some(finest)) = (rates.last(), rates.first()) else { return Self { parts } };
        let mut borne = coarsest.frequency_squared;
        while borne > 0.0 && parts.last().is_none_or(|last| last[1] < ALL) {
            parts.push([borne, part(borne)]);
            if borne >= finest.frequency_squared {
                break;
            }
            borne = (RATIO * borne).min(finest.frequency_squared);
        }
        Self { parts }
    }

    /// The least w^2 of the coarsest level or more, bearing which gives a cloth such a part of its acceleration [1/s^2].
    #[must_use]
    pub fn needed(&self, part: f64) -> f64 {
        let Some(above) = self.parts.iter().position(|known| known[1] >= part) else {
            return self.parts.last().map_or(0.0, |known| known[0]);
        };
        let [square, most] = self.parts[above];
        let [below, least] = if above > 0 { self.parts[above - 1] } else { return square };
        below + (square - below) * (part - least) / (most - least)
    }
}
