//! Which filters and integrators can do nothing for which cloths.

use super::{Adjacency, ClothRange, Particles, Springs};
use crate::scene::{FilterKind, IntegratorKind, SceneError, Solver};

/// If rods leave a particle fewer degrees of freedom than this, on average, the cloth cannot bend. With every edge of a triangle mesh as a
/// rod none is left but for the border. With warp and weft as rods one is left.
const LEAST_FREEDOM: f64 = 0.5;

/// Refuses a filter for a cloth that it cannot limit; returns what is worth a warning.
///
/// # Errors
/// Names the filter, the cloth, the reason and what would do instead.
pub(super) fn check(
    solver: &Solver,
    cloths: &[ClothRange],
    springs: &Springs,
    particles: &Particles,
) -> Result<Vec<String>, SceneError> {
    let filter = solver.filter;
    check_integrator(solver, cloths)?;
    if cfg!(not(feature = "direct")) && filter == FilterKind::FastProjection {
        let problem = "solves sparse systems, for which this build of taut lacks the feature \"direct\"; build with it, or choose another \
                       filter, such as \"coarse_to_fine\"";
        return Err(SceneError::with_value("solver.filter", format!("\"{filter}\""), problem));
    }
    let mut notes = Vec::new();
    for (index, cloth) in cloths.iter().enumerate() {
        let problem = match filter {
            FilterKind::Rods | FilterKind::FastProjection => locks(filter, cloth, springs, particles),
            FilterKind::Tethers => {
                let loose = untethered(cloth, springs, particles);
                if loose > 0 && loose < cloth.count {
                    notes.push(format!("{}: {loose} vertices are tied to no pin; \"tethers\" does not limit them", cloth.name));
                }
                (loose == cloth.count).then(|| "has no pin that its vertices could be tethered to; add pins".to_owned())
            }
            _ => None,
        };
        if let Some(problem) = problem {
            let remedy = "choose another filter, such as \"coarse_to_fine\"";
            return Err(SceneError::with_value(
                "solver.filter",
                format!("\"{filter}\""),
                format!("cloth[{index}] ({}) {problem}, or {remedy}", cloth.name),
            ));
        }
    }
    Ok(notes)
}

/// Refuses an integrator that the filter or a cloth has no use for.
fn check_integrator(solver: &Solver, cloths: &[ClothRange]) -> Result<(), SceneError> {
    let name = format!("\"{}\"", solver.integrator);
    let refused = |problem: String| Err(SceneError::with_value("solver.integrator", name, problem));
    // The paper's steps 1 to 6 give velocities, and its last line makes positions of them: X + V h.
    let compatible = matches!(solver.integrator, IntegratorKind::Euler | IntegratorKind::ImplicitEuler);
    if solver.filter == FilterKind::Sequential && !compatible {
        let problem = "\"sequential\" is the paper's filter to the letter and leads to X + V h, which is not where this integrator \
                       goes; use \"euler\" or \"implicit_euler\", or another filter, such as \"coarse_to_fine\"";
        return refused(problem.to_owned());
    }
    let bends_along_a_curve = |cloth: &&ClothRange| !cloth.curvatures.is_empty();
    match cloths.iter().find(bends_along_a_curve) {
        Some(cloth) if solver.integrator.is_implicit() => refused(format!(
            "{} bends along a measured curve, whose derivatives an implicit method would need; use \"euler\" or \"rk4\", or give \
             its bending as a number",
            cloth.name
        )),
        _ => Ok(()),
    }
}

/// Why the rods of a cloth would lock it, if they would.
fn locks(filter: FilterKind, cloth: &ClothRange, springs: &Springs, particles: &Particles) -> Option<String> {
    let free = |end: u32| particles.inverse_mass[end as usize] > 0.0;
    let rods = cloth.springs.clone().filter(|&spring| springs.kind[spring].is_rod(filter));
    let (mut count, mut tied) = (0_u32, vec![false; cloth.count]);
    for ends in rods.map(|spring| springs.ends[spring]).filter(|ends| ends.iter().any(|&end| free(end))) {
        count += 1;
        ends.iter().filter(|end| free(**end)).for_each(|&end| tied[end as usize - cloth.first] = true);
    }
    let moving = tied.iter().filter(|tied| **tied).count();
    let freedom = 3.0 - f64::from(count) / moving.max(1) as f64;
    (moving > 0 && freedom < LEAST_FREEDOM).then(|| {
        format!(
            "would lock: {count} rigid edges leave each of {moving} free vertices {:.2} degrees of freedom, and it could not \
             bend; use a grid or a mesh of quads, whose diagonals are not rigid",
            freedom.max(0.0)
        )
    })
}

/// How many particles of a cloth no path of springs joins to a pin.
fn untethered(cloth: &ClothRange, springs: &Springs, particles: &Particles) -> usize {
    let local = |end: u32| end - cloth.first as u32;
    let both = cloth.springs.clone().flat_map(|spring| {
        let [a, b] = springs.ends[spring].map(local);
        [(a, b), (b, a)]
    });
    let links = Adjacency::new(cloth.count, both);
    let held = |particle: &u32| particles.inverse_mass[cloth.first + *particle as usize] == 0.0;
    let mut next: Vec<u32> = (0..cloth.count as u32).filter(|particle| held(particle)).collect();
    let mut reached = vec![false; cloth.count];
    while let Some(particle) = next.pop() {
        if !std::mem::replace(&mut reached[particle as usize], true) {
            next.extend(links.of(particle as usize));
        }
    }
    reached.iter().filter(|reached| !**reached).count()
}
