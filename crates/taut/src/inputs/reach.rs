//! Can the cloth reach from pin to pin at all?

use std::collections::BTreeSet;

use super::Paths;
use super::travel::Travel;
use crate::model::{Adjacency, Model, PinGroup, Reach};
use crate::scene::SceneError;

/// Pins of a group from which distances are measured; more would make large scenes slow to build.
const MOST_SOURCES: usize = 32;

/// Refuses pins that move further apart than the cloth between them may stretch, at any keyframe or on a turn.
///
/// On straight lines the distance of two pins is a convex function of time between keyframes, so keyframes are the worst moments.
/// Turns are looked at every few degrees.
///
/// # Errors
/// Names the two particles, their distance, the cloth's reach and the time.
pub(super) fn check(paths: &Paths, model: &Model) -> Result<(), SceneError> {
    let (groups, springs, particles) = (&model.pins, &model.springs, model.particle_count());
    let moments: BTreeSet<u64> =
        (0..groups.len()).filter_map(|group| paths.travel(group)).flat_map(Travel::moments).map(f64::to_bits).collect();
    if moments.is_empty() {
        return Ok(());
    }
    let graph = Adjacency::new(particles, springs.ways(0..springs.type1));
    for (index, one) in groups.iter().enumerate() {
        // What follows an array is held back where the cloth cannot follow; its frames are too many to look at all.
        let Some(travel) = paths.travel(index) else { continue };
        let others: Vec<usize> =
            (index + 1..groups.len()).filter(|&other| paths.travel(other).is_some_and(|other| other != travel)).collect();
        if others.is_empty() {
            continue;
        }
        let stride = one.particles.len().div_ceil(MOST_SOURCES).max(1);
        for source in (0..one.particles.len()).step_by(stride) {
            let reach = Reach::new(&graph, particles, &one.particles[source..=source]).lengths;
            for &other in &others {
                check_pair(paths, (index, source), other, &reach, &moments, model)?;
            }
        }
    }
    Ok(())
}

fn check_pair(
    paths: &Paths,
    (one, source): (usize, usize),
    other: usize,
    reach: &[f64],
    moments: &BTreeSet<u64>,
    model: &Model,
) -> Result<(), SceneError> {
    let pins = |group: usize| -> &PinGroup { &model.pins[group] };
    for time in moments.iter().map(|&bits| f64::from_bits(bits)) {
        let (here, places) = (paths.places(model, one, time).of(source), paths.places(model, other, time));
        for (target, &particle) in pins(other).particles.iter().enumerate() {
            let apart = here.distance(places.of(target));
            let within = reach[particle as usize];
            if apart > within * (1.0 + 1e-6) {
                let [a, b] = [pins(one).particles[source], particle].map(|particle| model.numbering.vertex(particle));
                let problem = format!(
                    "infeasible: pins {a} and {b} are {apart:.3} m apart at {time} s, the cloth reaches {within:.3} m; \
                     move them less or raise strain_limit"
                );
                return Err(SceneError::at("cloth", problem));
            }
        }
    }
    Ok(())
}
