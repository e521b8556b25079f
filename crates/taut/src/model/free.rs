//! What may change while a model is simulated: which particles are held, with inverse masses, levels and how fast they vibrate; and
//! strain limits.

use std::sync::Arc;

use super::hierarchy::{of_grid, of_hierarchy};
use super::{Bending, Borne, ClothRange, Hierarchy, Lattice, Model, Particles, Rates, Springs, rates};
use crate::scene::FilterKind;

impl Model {
    /// The same model with further particles held, as if the scene had pinned them; what does not depend on that is shared.
    #[must_use]
    pub fn holding(&self, particles: &[u32]) -> Self {
        let mut model = self.clone();
        particles.iter().for_each(|&particle| model.particles.inverse_mass[particle as usize] = 0.0);
        let Rates { still_air, wind, .. } = self.rates;
        model.rates = Rates::new(&model.particles, &model.springs, &model.bending, still_air, wind);
        model.hierarchies = levels(
            self.solver.filter,
            &mut model.cloths,
            &model.particles,
            &model.springs,
            &model.bending,
            &model.triangles,
            &model.lattices,
        )
        .into();
        model
    }
}

impl Model {
    /// Gives a cloth another strain limit [1]. What the model shares with others is copied first.
    pub fn set_limit(&mut self, cloth: usize, strain_limit: f32) {
        let cloth = &self.cloths[cloth];
        let springs = Arc::make_mut(&mut self.springs);
        springs.strain_limit[cloth.springs.clone()].fill(strain_limit);
        if let Some(lattice) = cloth.lattice {
            Arc::make_mut(&mut self.lattices)[lattice].set_limits(cloth, springs);
        }
    }
}

/// Levels, for filters that work on them, and how fast they vibrate, for steps that scale masses.
pub(super) fn levels(
    filter: FilterKind,
    cloths: &mut [ClothRange],
    particles: &Particles,
    springs: &Springs,
    bending: &Bending,
    triangles: &[[u32; 3]],
    lattices: &[Lattice],
) -> Vec<Hierarchy> {
    let mut hierarchies = Vec::new();
    let rates = rates::of_cloths(cloths, particles, springs, bending);
    for (range, (fastest, _)) in cloths.iter_mut().zip(&rates) {
        range.fastest = *fastest;
    }
    if filter != FilterKind::CoarseToFine {
        return hierarchies;
    }
    for range in cloths {
        range.heaviest = particles.heaviest(range);
        let (finest, bends) = rates[range.index];
        let held = |particle: usize| particles.inverse_mass[range.first + particle] == 0.0;
        if let Some(lattice) = range.lattice.map(|lattice| &lattices[lattice]).filter(|lattice| lattice.is_held_plainly(held)) {
            range.rates = of_grid([lattice.columns, lattice.rows], particles.free_masses(range), finest);
            range.borne = Borne::of_grid(&range.rates);
            range.hierarchy = None;
            continue;
        }
        let mut hierarchy = Hierarchy::new(range, particles, springs, triangles);
        range.rates = if range.is_network { Vec::new() } else { of_hierarchy(&mut hierarchy, range, springs, bends) };
        range.borne = Borne::of_mesh(&hierarchy, range, &range.rates, springs, bending);
        range.hierarchy = Some(hierarchies.len());
        hierarchies.push(hierarchy);
    }
    hierarchies
}
