//! Leaves of trees that meet in a step, found on all threads; but for those of cloth that is so flat that it cannot touch itself.

use super::bounds::Bounds;
use super::detect::around;
use super::surfaces::Surfaces;
use crate::geometry::{Pool, for_each_part};

/// Pairs of nodes of two trees, or of one, that threads share.
const FRONTS: usize = 64;

/// Two leaves that meet, and whose they are: a cloth, and a cloth or a body after all cloths. Instead of the second there may be something
/// thick, by its number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub trees: [u32; 2],
    pub leaves: [u32; 2],
    pub thick: Option<u32>,
}

/// All of them, in an order that does not depend on the number of threads; and workspace.
#[derive(Debug, Default)]
pub(super) struct Meetings {
    pub list: Vec<Met>,
    roots: Vec<[u32; 2]>,
    fronts: Vec<Front>,
}

/// Two nodes of the trees of two owners, or of one, and the leaves below them that meet.
#[derive(Debug, Default)]
struct Front {
    trees: [u32; 2],
    root: [u32; 2],
    stack: Vec<[u32; 2]>,
    met: Vec<Met>,
}

impl Meetings {
    /// Finds them, with boxes that are fitted; `bounds` are those of vertices, and `asked` tells which of these are asked about.
    pub fn find(&mut self, surfaces: &Surfaces, bounds: &[Bounds], asked: &[bool], pool: &Pool) {
        let Self { list, roots, fronts } = self;
        let Surfaces { cloths, bodies, monotone, thick, skins, among_cloths, .. } = surfaces;
        let other_of = |[one, other]: [u32; 2]| (other > one).then(|| surfaces.tree(other));
        let (mut used, mut leaves) = (0, 0);
        for index in 0..cloths.len() {
            let others = if *among_cloths { index } else { cloths.len() }..cloths.len() + bodies.len();
            leaves += cloths[index].leaves.len();
            for other in others {
                let trees = [index as u32, other as u32];
                cloths[index].fronts(other_of(trees), FRONTS, roots);
                for &root in &*roots {
                    if used == fronts.len() {
                        fronts.push(Front::default());
                    }
                    (fronts[used].trees, fronts[used].root) = (trees, root);
                    used += 1;
                }
            }
        }
        for_each_part(&mut fronts[..used], leaves, pool, |_, Front { trees, root, stack, met }| {
            met.clear();
            stack.push(*root);
            let is_own = trees[0] == trees[1];
            cloths[trees[0] as usize].meet_from(other_of(*trees), stack, |one, two| {
                if !(is_own && monotone[trees[0] as usize].spares(one, two)) {
                    met.push(Met { trees: *trees, leaves: [one.index, two.index], thick: None });
                }
            });
        });
        list.clear();
        fronts[..used].iter().for_each(|front| list.extend(&front.met));
        for (index, tree) in (0..).zip(cloths) {
            for (number, thick) in (0..).zip(thick) {
                let radius = skins[thick.owner as usize].radius as f32;
                let is_asked = thick.vertices.clone().any(|vertex| asked[vertex as usize]);
                tree.within(&around(bounds, thick, radius), is_asked, |leaf| {
                    list.push(Met { trees: [index; 2], leaves: [leaf.index; 2], thick: Some(number) });
                });
            }
        }
    }
}
