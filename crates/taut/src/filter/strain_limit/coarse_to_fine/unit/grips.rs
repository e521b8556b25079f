//! What is gripped of a cloth in a step: particles that go such a way, as if they were pinned.

use glam::Vec3;

use super::Unit;

impl Unit {
    /// Grips a particle of it, which goes such a way in this step [m].
    pub fn grip(&mut self, own: usize, way: Vec3) {
        self.gripped.push((own, std::mem::take(&mut self.weights[own])));
        self.levels.hold(own, way);
    }

    /// Whether anything is gripped.
    pub fn is_gripped(&self) -> bool {
        !self.gripped.is_empty()
    }

    /// Lets some go again: those with these numbers among all particles, in rising order.
    pub fn let_go(&mut self, particles: &[u32]) {
        let Self { gripped, weights, levels, cloth, .. } = self;
        levels.release();
        gripped.retain(|&(own, weight)| {
            let stays = particles.binary_search(&((cloth.first + own) as u32)).is_err();
            if stays {
                levels.hold(own, levels.displacement(own));
            } else {
                weights[own] = weight;
            }
            stays
        });
    }

    /// Lets all go that was gripped.
    pub fn release(&mut self) {
        self.gripped.drain(..).for_each(|(own, weight)| self.weights[own] = weight);
        self.levels.release();
    }
}
