//! Cloth that is thick beside its edges.

use super::{ClothRange, Numbering, Springs};
use crate::scene::{Scene, brief};

/// A cloth that touches itself or others should have no edge shorter than this many of its thicknesses [1].
const LEAST: f64 = 2.0;
/// .. and a network no shorter link than this: it knows what is near along its links.
const LEAST_OF_LINKS: f64 = 0.5;

/// Warns, where cloths touch each other, of those whose thickness is more than half of their shortest edge, or twice their shortest link.
/// Parts that belong together would push each other away. Bodies see the thickness from outside.
pub(super) fn cautions(scene: &Scene, cloths: &[ClothRange], springs: &Springs, numbering: &Numbering) -> Vec<String> {
    if !scene.self_contact() {
        return Vec::new();
    }
    let caution = |cloth: &ClothRange| {
        let thickness = scene.cloth[cloth.index].thickness();
        let length = |spring: usize| f64::from(springs.rest[spring]);
        let edges = cloth.springs.clone();
        let shortest = edges.clone().min_by(|&one, &other| length(one).total_cmp(&length(other)))?;
        // Lengths are rounded.
        let (least, part, many) = if cloth.is_network { (LEAST_OF_LINKS, "half of", "links") } else { (LEAST, "twice", "edges") };
        let is_short = |spring: &usize| length(*spring) < least * thickness * (1.0 - 1e-6);
        let short = edges.clone().filter(is_short).count();
        let [a, b] = springs.ends[shortest].map(|end| numbering.vertex(end) as usize - cloth.first);
        let few = |number: f64| brief(format!("{number:.2e}").parse().unwrap_or(number));
        (short > 0).then(|| {
            format!(
                "scene.cloth[{}].thickness = {}: {short} of {} {many} are shorter than {part} that, the shortest, from vertex {a} to {b}, is \
                 {} m long; where cloth touches itself such parts push each other away: make it at most {} m, or such {many} longer",
                cloth.index,
                brief(thickness),
                edges.len(),
                few(length(shortest)),
                few(length(shortest) / least),
            )
        })
    };
    cloths.iter().filter_map(caution).collect()
}
