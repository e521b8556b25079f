//! A flag in the wind: `cargo run --release --example hello`.
use taut::{Cloth, Edge, Fabric, Pin, World};

fn main() -> Result<(), taut::Error> {
    let flag = Cloth::grid([1.5, 1.0], [24, 16]).fabric(Fabric::Nylon).strain_limit(0.05).pin(Pin::edge(Edge::Left));
    let mut world = World::builder().cloth(flag).wind([8.0, 1.5, 0.0]).build()?;
    for _ in 0..60 {
        let report = world.step(1.0 / 60.0)?;
        assert!(report.worst_stretch <= 0.05 + 1e-5, "no spring is over its limit, ever");
    }
    let tip = world.positions(0)?[24];
    println!("after {:.1} s the lower free corner of the flag is at {tip:.3?} m", world.time());
    Ok(())
}
