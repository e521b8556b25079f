//! The particles that wait to be visited, the one with the smallest key first.

/// What is not in the queue.
const NOWHERE: u32 = u32::MAX;

/// A binary heap that knows where each particle is, so that no particle is in it twice and it never grows. Of equal keys the
/// smaller number comes first: the order does not depend on how the particles came in.
pub(super) struct Queue {
    /// Bits of the key, which order those that are not negative, and the particle.
    heap: Vec<(u32, u32)>,
    /// Where each particle is in the heap.
    places: Vec<u32>,
}

impl Queue {
    /// A queue for so many particles.
    pub fn new(particles: usize) -> Self {
        Self { heap: Vec::with_capacity(particles), places: vec![NOWHERE; particles] }
    }

    /// Puts a particle in, or gives it a smaller key; keys are not negative.
    pub fn put(&mut self, particle: usize, key: f32) {
        let entry = (key.to_bits(), particle as u32);
        let mut place = self.places[particle] as usize;
        if place == NOWHERE as usize {
            place = self.heap.len();
            self.heap.push(entry);
        } else if entry < self.heap[place] {
            self.heap[place] = entry;
        } else {
            return;
        }
        while place > 0 && entry < self.heap[(place - 1) / 2] {
            self.swap(place, (place - 1) / 2);
            place = (place - 1) / 2;
        }
        self.places[particle] = place as u32;
    }

    /// Takes the particle with the smallest key out.
    pub fn take(&mut self) -> Option<usize> {
        if self.heap.is_empty() {
            return None;
        }
        let (_, particle) = self.heap.swap_remove(0);
        self.places[particle as usize] = NOWHERE;
        if let Some(&(_, moved)) = self.heap.first() {
            self.places[moved as usize] = 0;
        }
        let mut place = 0;
        loop {
            let children = [2 * place + 1, 2 * place + 2].into_iter().filter(|&child| child < self.heap.len());
            match children.min_by_key(|&child| self.heap[child]) {
                Some(child) if self.heap[child] < self.heap[place] => {
                    self.swap(place, child);
                    place = child;
                }
                _ => return Some(particle as usize),
            }
        }
    }

    /// Takes all out.
    pub fn clear(&mut self) {
        self.heap.drain(..).for_each(|(_, particle)| self.places[particle as usize] = NOWHERE);
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.heap.swap(a, b);
        for place in [a, b] {
            self.places[self.heap[place].1 as usize] = place as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_smallest_comes_first_and_none_twice(entries in prop::collection::vec((0_usize..20, 0_u8..10), 0..60)) {
            let mut queue = Queue::new(20);
            let mut smallest = BTreeMap::new();
            for &(particle, factor) in &entries {
                queue.put(particle, f32::from(factor) / 10.0);
                let least = smallest.entry(particle).or_insert(factor);
                *least = factor.min(*least);
            }
            let mut expected: Vec<(u8, usize)> = smallest.into_iter().map(|(particle, factor)| (factor, particle)).collect();
            expected.sort_unstable();
            let found: Vec<usize> = std::iter::from_fn(|| queue.take()).collect();
            prop_assert_eq!(found, expected.into_iter().map(|(_, particle)| particle).collect::<Vec<_>>());
            prop_assert!(queue.places.iter().all(|&place| place == NOWHERE));
            entries.iter().for_each(|&(particle, factor)| queue.put(particle, f32::from(factor)));
            queue.clear();
            prop_assert!(queue.take().is_none() && queue.places.iter().all(|&place| place == NOWHERE));
        }
    }
}
