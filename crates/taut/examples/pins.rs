//! A cape on shoulders that a game moves each frame: `cargo run --release --example pins`.

use taut::{Cloth, Edge, Fabric, Pin, World};

const FRAME: f64 = 1.0 / 60.0;

fn main() -> Result<(), taut::Error> {
    let cape = Cloth::grid([0.6, 1.0], [12, 20]).fabric(Fabric::Wool).strain_limit(0.05).pin(Pin::edge(Edge::Top));
    let mut world = World::builder().cloth(cape).build()?;

    let shoulders = world.pinned(0, 0)?;
    let start: Vec<[f32; 3]> =
        shoulders.iter().map(|&vertex| world.positions(0).map(|all| all[vertex as usize])).collect::<Result<_, _>>()?;
    let mut places = start.clone();
    for frame in 1..=120_u16 {
        // Whoever wears it runs along y and bobs.
        let time = f32::from(frame) / 60.0;
        for (place, [x, y, z]) in places.iter_mut().zip(&start) {
            *place = [*x, y + 3.0 * time, z + 0.05 * (12.0 * time).sin()];
        }
        // There by the end of the next step.
        world.hold(0, &shoulders, &places, FRAME)?;
        let report = world.step(FRAME)?;
        assert!(report.worst_stretch <= 0.05 + 1e-5, "no spring is over its limit");
    }

    let all = world.positions(0)?;
    for (&vertex, place) in shoulders.iter().zip(&places) {
        assert!(distance(all[vertex as usize], *place) < 1e-4, "held vertices are where they were told to be");
    }
    println!("the shoulders ran to y = {:.2} m, the hem trails {:.2} m behind", places[0][1], places[0][1] - all[0][1]);

    world.release(0, &shoulders)?;
    world.step(FRAME)?;
    Ok(())
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}
