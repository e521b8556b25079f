//! Worlds in a few words, for the tests of the facade.
#![allow(dead_code, missing_docs)]

use taut::{Cloth, Edge, Error, Pin, Report, World};

pub const FRAME: f64 = 1.0 / 60.0;
pub const NAN: f64 = f64::NAN;

pub fn sheet() -> Cloth {
    Cloth::grid([1.0, 1.0], [8, 8]).strain_limit(0.05).pin(Pin::edge(Edge::Top))
}

pub fn world() -> World {
    World::builder().cloth(sheet()).build().expect("a world")
}

pub fn frames(world: &mut World, count: u32) -> Report {
    (0..count).map(|_| world.step(FRAME).expect("stays finite")).last().expect("at least one")
}

/// The error of what must be refused; it names this.
pub fn refused<T: std::fmt::Debug>(result: Result<T, Error>, name: &str) {
    let text = result.expect_err(name).to_string();
    assert!(text.starts_with(name), "{text:?} does not begin with {name:?}");
}

pub fn bits(world: &World, cloth: usize) -> Vec<[u32; 3]> {
    let all = [world.positions(cloth), world.velocities(cloth)].map(|of| of.expect("a cloth"));
    all.concat().into_iter().map(|vector| vector.map(f32::to_bits)).collect()
}

/// Triangles of a sheet in the plane of x and z.
pub fn mesh(cells: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let row = cells + 1;
    let place = |vertex: u32| [(vertex % row) as f32 / cells as f32, 0.0, (vertex / row) as f32 / cells as f32];
    let cell = |cell: u32| {
        let a = cell / cells * row + cell % cells;
        [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]
    };
    ((0..row * row).map(place).collect(), (0..cells * cells).flat_map(cell).collect())
}
