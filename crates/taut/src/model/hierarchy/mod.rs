//! A mesh or network at several resolutions: levels of particles chosen from its own, joined by springs as long as the cloth
//! between them (docs/equations.md, "Coarse to fine").

mod borne;
pub mod coarse_grid;
mod coarsen;
mod interpolation;
mod overlap;
mod rates;

use glam::Vec3;

use super::surface::{Search, Surface};
use super::{ClothRange, Particles, Springs};
pub use borne::Borne;
use coarsen::{Choosing, EVEN, coarser};
pub use rates::{NodeRate, shares, shares_of_nodes};
pub(super) use rates::{of_grid, of_hierarchy};

/// A level of so few particles needs no coarser one.
const FEW: usize = 4;
/// Nor does one of which the next level would keep more than this part: it has fallen into pieces.
const SHRINKS: f64 = 0.8;

/// The levels of a cloth that is no lattice, or holds what the levels of one could not know.
#[derive(Debug)]
pub struct Hierarchy {
    /// The finest first.
    pub levels: Vec<HierarchyLevel>,
}

/// Some particles of a cloth.
#[derive(Debug, Default)]
pub struct HierarchyLevel {
    /// Their numbers in the cloth, in rising order.
    pub nodes: Vec<u32>,
    /// Places of the two ends in `nodes`, the lower one first, and the distance between them along the cloth at rest [m]. On the
    /// finest level the springs of type 1 that are not between two held particles.
    pub springs: Vec<Bond>,
    /// What each particle of the next finer level follows: what is held only itself, or nothing. None on the finest level.
    pub parents: Vec<Parents>,
    /// The masses that they carry when displacements are interpolated [kg]: those of the finest level, shared out as the
    /// particles follow. What is held carries nothing and shares nothing; all others carry something.
    pub masses: Vec<f64>,
    /// How fast each of them can vibrate at most; none in networks, whose masses are never scaled.
    pub rates: Vec<NodeRate>,
}

/// A spring of a level.
pub type Bond = ([u32; 2], f32);

/// The particles of the next coarser level that one follows: the corners of a triangle around it, or fewer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Parents {
    /// Their places in that level.
    pub places: [u32; 3],
    /// The parts by which each is followed: they add up to one, and those that are not needed are zero.
    pub parts: [f32; 3],
}

impl Parents {
    fn new(list: &[(u32, f32)]) -> Self {
        let mut parents = Self::default();
        for (index, &(place, part)) in list.iter().enumerate() {
            (parents.places[index], parents.parts[index]) = (place, part);
        }
        parents
    }

    /// Those that are needed, with their parts.
    pub fn iter(&self) -> impl Iterator<Item = (u32, f32)> + Clone + use<> {
        self.places.into_iter().zip(self.parts).filter(|(_, part)| *part != 0.0)
    }
}

impl Hierarchy {
    /// Level 0 is the cloth, without the particles that nothing is tied to.
    pub(super) fn new(cloth: &ClothRange, particles: &Particles, springs: &Springs, triangles: &[[u32; 3]]) -> Self {
        let surface = Surface::new(cloth, &particles.rest, springs, triangles);
        let held: Vec<bool> = cloth.particles().map(|particle| particles.inverse_mass[particle] == 0.0).collect();
        let rank = ranks(cloth, particles, &surface, &held);
        let nodes: Vec<u32> = (0..cloth.count as u32).filter(|&node| !surface.links(node).is_empty()).collect();
        let mut place = vec![0; cloth.count];
        (0..).zip(&nodes).for_each(|(index, &node)| place[node as usize] = index);
        let bond = |spring: usize| {
            let [u, v] = springs.ends[spring].map(|end| end as usize - cloth.first);
            let [a, b] = [place[u], place[v]];
            (!(held[u] && held[v])).then_some(([a.min(b), a.max(b)], springs.rest[spring]))
        };
        let mut bonds: Vec<Bond> = cloth.springs.clone().filter_map(bond).collect();
        bonds.sort_by_key(|bond| bond.0);
        let mass = |&node: &u32| if held[node as usize] { 0.0 } else { f64::from(particles.mass[cloth.first + node as usize]) };
        let masses = nodes.iter().map(mass).collect();
        let mut levels = vec![HierarchyLevel { nodes, springs: bonds, masses, ..HierarchyLevel::default() }];
        let mut search = Search::new(cloth.count);
        let on = Choosing { surface: &surface, held: &held, rank: &rank };
        while let Some(fine) = levels.last().filter(|level| level.nodes.len() > FEW) {
            let shrinks = |coarse: &HierarchyLevel| {
                !coarse.springs.is_empty() && coarse.nodes.len() as f64 <= SHRINKS * fine.nodes.len() as f64
            };
            let coarse = [EVEN, f32::INFINITY].into_iter().map(|even| coarser(fine, &on, even, &mut search)).find(shrinks);
            let Some(coarse) = coarse else { break };
            levels.push(coarse);
        }
        Self { levels }
    }
}

/// What is held comes first, and of that the ends of a held border, which bear most; then corners, then borders: levels keep the
/// outline of the cloth.
fn ranks(cloth: &ClothRange, particles: &Particles, surface: &Surface, is_held: &[bool]) -> Vec<u8> {
    /// How far the mean direction to the neighbours is from zero.
    const CORNER: f32 = 0.6;
    const BORDER: f32 = 0.3;
    let at = |node: u32| particles.rest.get(cloth.first + node as usize);
    let rank = |(node, &held): (u32, &bool)| {
        let links = surface.links(node);
        let sum: Vec3 = links.iter().map(|&(other, _)| (at(other) - at(node)).normalize_or_zero()).sum();
        let lopsided = sum.length() / links.len().max(1) as f32;
        if held {
            let within = links.iter().filter(|&&(other, _)| is_held[other as usize]).count() > 1 && lopsided <= CORNER;
            if within { 3 } else { 4 }
        } else if lopsided > CORNER {
            2
        } else {
            u8::from(lopsided > BORDER)
        }
    };
    (0..).zip(is_held).map(rank).collect()
}
