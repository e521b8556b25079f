//! Vertices of the user, particles of the model.
//!
//! Meshes come numbered as the program that made them pleased. Their particles are numbered so that neighbours are near in memory.

use glam::Vec3;

use crate::geometry::{Pool, Vectors, for_each_chunk};

use super::Adjacency;

/// Which particle each vertex is, and back. Vertices of all cloths are counted through, in the scene's order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Numbering {
    particles: Vec<u32>,
    vertices: Vec<u32>,
    /// Whether a vertex and its particle have different numbers anywhere.
    differs: bool,
}

impl Numbering {
    /// Goes on with a cloth whose vertices become these particles, both counted from its first.
    pub(super) fn extend(&mut self, particles: &[u32]) {
        let first = self.particles.len() as u32;
        self.vertices.resize(self.vertices.len() + particles.len(), 0);
        for (vertex, particle) in (first..).zip(particles) {
            self.particles.push(first + particle);
            self.differs |= vertex != first + particle;
            self.vertices[(first + particle) as usize] = vertex;
        }
    }

    /// The particle of a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn particle(&self, vertex: u32) -> u32 {
        self.particles[vertex as usize]
    }

    /// The vertex of a particle.
    ///
    /// # Panics
    /// If there is no such particle.
    #[must_use]
    pub fn vertex(&self, particle: u32) -> u32 {
        self.vertices[particle as usize]
    }

    /// Values of particles in the order of the vertices.
    pub fn by_vertex<'a, T: Copy>(&'a self, of_particles: &'a [T]) -> impl Iterator<Item = T> + 'a {
        self.particles.iter().map(|&particle| of_particles[particle as usize])
    }

    /// Vectors of particles in the order of the vertices; none stay none.
    #[must_use]
    pub fn to_vertices(&self, of_particles: &Vectors) -> Vectors {
        self.reordered(&self.particles, of_particles)
    }

    /// Writes what `row` makes of vectors of particles, in the order of the vertices, from the vertex `start` on.
    ///
    /// # Panics
    /// If there are fewer vertices than rows.
    pub fn write_rows(
        &self,
        of_particles: &Vectors,
        start: usize,
        rows: &mut [[f32; 3]],
        pool: &Pool,
        row: impl Fn(Vec3) -> [f32; 3] + Sync,
    ) {
        for_each_chunk(rows, pool, |first, rows| {
            let first = start + first;
            if self.differs {
                let particles = &self.particles[first..first + rows.len()];
                rows.iter_mut().zip(particles).for_each(|(to, particle)| *to = row(of_particles.get(*particle as usize)));
            } else {
                let [x, y, z] = [&of_particles.x, &of_particles.y, &of_particles.z].map(|column| &column[first..][..rows.len()]);
                rows.iter_mut().zip(x.iter().zip(y).zip(z)).for_each(|(to, ((x, y), z))| *to = row(Vec3::new(*x, *y, *z)));
            }
        });
    }

    /// Vectors of vertices in the order of the particles; none stay none.
    #[must_use]
    pub fn to_particles(&self, of_vertices: &Vectors) -> Vectors {
        self.reordered(&self.vertices, of_vertices)
    }

    fn reordered(&self, order: &[u32], vectors: &Vectors) -> Vectors {
        if vectors.is_empty() || !self.differs {
            return vectors.clone();
        }
        order.iter().map(|&index| vectors.get(index as usize)).collect()
    }
}

/// Numbers for so many vertices, neighbours close to each other: fronts that spread from one side of a piece to the other
/// [CuthillMcKee69]. A vertex without neighbours comes last.
pub(super) fn near_together(count: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Vec<u32> {
    let neighbours = Adjacency::new(count, edges.flat_map(|[a, b]| [(a, b), (b, a)]));
    let mut search = Search { neighbours: &neighbours, seen: vec![0; count], round: 0, front: Vec::new() };
    let mut numbers = vec![0; count];
    let mut next = 0..;
    let mut numbered = vec![false; count];
    for start in (0..count as u32).filter(|&vertex| !neighbours.of(vertex as usize).is_empty()) {
        if numbered[start as usize] {
            continue;
        }
        // From some vertex to one that is far from it, and from there to the other end.
        let side = search.last_of(start);
        let end = search.last_of(side);
        search.last_of(end);
        for &vertex in &search.front {
            numbers[vertex as usize] = next.next().unwrap_or_default();
            numbered[vertex as usize] = true;
        }
    }
    for (_, number) in numbered.iter().zip(&mut numbers).filter(|(numbered, _)| !**numbered) {
        *number = next.next().unwrap_or_default();
    }
    numbers
}

/// Breadth first.
struct Search<'a> {
    neighbours: &'a Adjacency<u32>,
    /// The last round in which a vertex was reached.
    seen: Vec<u32>,
    round: u32,
    front: Vec<u32>,
}

impl Search<'_> {
    /// Fills the front with all that can be reached from a vertex, in the order of reaching it; the last one.
    fn last_of(&mut self, start: u32) -> u32 {
        self.round += 1;
        self.front.clear();
        self.front.push(start);
        self.seen[start as usize] = self.round;
        let mut next = 0;
        while let Some(&vertex) = self.front.get(next) {
            next += 1;
            for &other in self.neighbours.of(vertex as usize) {
                if std::mem::replace(&mut self.seen[other as usize], self.round) != self.round {
                    self.front.push(other);
                }
            }
        }
        self.front.last().copied().unwrap_or(start)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_number_is_given_once(count in 1_u32..40, edges in prop::collection::vec([0_u32..40, 0_u32..40], 0..60)) {
            let edges = edges.iter().map(|ends| ends.map(|end| end % count)).filter(|[a, b]| a != b);
            let mut numbers = near_together(count as usize, edges);
            let mut numbering = Numbering::default();
            numbering.extend(&[0, 1]);
            numbering.extend(&numbers);
            for vertex in 0..count + 2 {
                prop_assert_eq!(numbering.vertex(numbering.particle(vertex)), vertex);
            }
            numbers.sort_unstable();
            prop_assert!(numbers.into_iter().eq(0..count));
        }
    }

    #[test]
    fn neighbours_in_a_strip_come_close_however_it_was_numbered() {
        // 100 x 5 vertices, numbered by leaps.
        let name = |column: u32, row: u32| (column * 5 + row) * 77 % 500;
        let along = (0..99).flat_map(|column| (0..5).map(move |row| [name(column, row), name(column + 1, row)]));
        let across = (0..100).flat_map(|column| (0..4).map(move |row| [name(column, row), name(column, row + 1)]));
        let edges: Vec<[u32; 2]> = along.chain(across).collect();
        let numbers = near_together(500, edges.iter().copied());
        let furthest = edges.iter().map(|ends| ends.map(|end| numbers[end as usize])).map(|[a, b]| a.abs_diff(b)).max();
        assert!(furthest <= Some(6), "{furthest:?}");
    }
}
