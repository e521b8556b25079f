//! What a step must bear of the levels of a cloth whose masses are scaled (docs/equations.md, "Scaled masses").

use super::overlap::{Stiffness, largest};
use super::{Hierarchy, HierarchyLevel, shares, shares_of_nodes};
use crate::model::{Bending, ClothRange, LevelRate, Springs};

/// The least part of its acceleration that an even load gives a cloth with scaled masses on the whole [1], of a grid and of a mesh, counted
/// level by level. Levels of a mesh lie further apart, so that more of it is beside what is held.
const SETS_OUT: f64 = 0.9;
const SETS_OUT_OF_MESHES: f64 = 0.96;
/// The same of a mesh, counted particle by particle.
const SETS_OUT_OF_NODES: f64 = 0.98;
/// How exactly the w^2 is found that this takes [1].
const WITHIN: f64 = 0.01;
/// What is slower than this part of the fastest is not looked for [1].
const SLOWEST: f64 = 1e-12;
/// `Borne::overlap` of grids, whose levels are all alike [1].
const OVERLAP_OF_GRIDS: f64 = 1.25;
/// Over the overlap that is found, which is found from below [1].
const TO_SPARE: f64 = 1.03;
/// The overlap of meshes falls as more is borne. It is found for the least and for so many times as much [1].
const FAR_MORE: f64 = 8.0;

/// What a step must bear of the levels of a cloth whose masses are scaled.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Borne {
    /// The least w^2 of each level with which the cloth sets out as it should, not less than that of the coarsest level [1/s^2].
    pub least: f64,
    /// How much larger the largest eigenvalue with scaled masses is than the w^2 borne of each level, at most [1].
    pub overlap: f64,
    /// The same where `FAR_MORE` times the least is borne.
    overlap_of_far_more: f64,
}

impl Borne {
    /// Of a grid with such levels.
    pub(in crate::model) fn of_grid(rates: &[LevelRate]) -> Self {
        let overlap = OVERLAP_OF_GRIDS;
        Self { least: least(rates, |borne| by_levels(borne, rates) >= SETS_OUT), overlap, overlap_of_far_more: overlap }
    }

    /// Of a mesh with such levels. Either of two counts will do: level by level, as if each were everywhere as fast as at its finest place,
    /// or particle by particle.
    pub(in crate::model) fn of_mesh(
        Hierarchy { levels }: &Hierarchy,
        cloth: &ClothRange,
        rates: &[LevelRate],
        springs: &Springs,
        bending: &Bending,
    ) -> Self {
        let least =
            least(rates, |borne| by_levels(borne, rates) >= SETS_OUT_OF_MESHES || by_nodes(borne, levels) >= SETS_OUT_OF_NODES);
        if least == 0.0 {
            return Self { least, overlap: 1.0, overlap_of_far_more: 1.0 };
        }
        let stiffness = Stiffness::new(cloth, &levels[0], springs, bending);
        let overlap = |borne: f64| TO_SPARE * largest(&stiffness, levels, borne) / borne;
        Self { least, overlap: overlap(least), overlap_of_far_more: overlap(FAR_MORE * least) }
    }

    /// The w^2 that a step bears of each level, if it bears such a one of the whole cloth [1/s^2].
    pub(crate) fn of_each_level(&self, frequency_squared: f64) -> f64 {
        let far_more = frequency_squared / self.overlap_of_far_more;
        if far_more >= FAR_MORE * self.least { far_more } else { frequency_squared / self.overlap }
    }
}

/// The least w^2 between those of the coarsest and the finest level that is enough [1/s^2].
fn least(rates: &[LevelRate], is_enough: impl Fn(f64) -> bool) -> f64 {
    let [coarsest, mut above] = [rates.last(), rates.first()].map(|rate| rate.map_or(0.0, |rate| rate.frequency_squared));
    // All of the coarsest level may be held.
    let mut below = coarsest.max(SLOWEST * above);
    if below == 0.0 || is_enough(below) {
        return below;
    }
    while above > (1.0 + WITHIN) * below {
        let middle = (below * above).sqrt();
        *(if is_enough(middle) { &mut above } else { &mut below }) = middle;
    }
    above
}

/// The part of its acceleration that an even load gives a cloth [1]. Levels whose particles are tied to what is held give nothing there.
fn by_levels(borne: f64, rates: &[LevelRate]) -> f64 {
    let shares = shares(borne, rates.iter().map(|rate| rate.frequency_squared));
    shares.iter().zip(rates).map(|(share, rate)| share * rate.moving).sum()
}

fn by_nodes(borne: f64, levels: &[HierarchyLevel]) -> f64 {
    let shares = shares_of_nodes(borne, levels, |rate| rate.frequency_squared);
    let of_level = |(shares, level): (&Vec<f64>, &HierarchyLevel)| -> f64 {
        shares.iter().zip(&level.masses).map(|(share, mass)| share * mass).sum()
    };
    shares.iter().zip(levels).map(of_level).sum::<f64>() / levels[0].masses.iter().sum::<f64>()
}
