//! A cloth falls on a ball that is then carried away: `cargo run --release --example contact`.

use taut::{Axis, Body, Cloth, Fabric, World};

const FRAME: f64 = 1.0 / 60.0;
const THICKNESS: f64 = 0.004;
const RADIUS: f64 = 0.25;

fn main() -> Result<(), taut::Error> {
    let napkin = Cloth::grid([0.8, 0.8], [24, 24]).axes([Axis::X, Axis::Y]).translate([-0.4, -0.4, 0.6]);
    let napkin = napkin.fabric(Fabric::Cotton).thickness(THICKNESS);
    let ball = Body::sphere([0.0, 0.0, 0.3], RADIUS).friction(0.5);
    let floor = Body::plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let mut world = World::builder().cloth(napkin).body(ball).body(floor).build()?;

    let mut lying = 0;
    for frame in 1..=60 {
        if frame > 40 {
            // Up by 1 m in a second.
            world.move_body(0, [0.0, 0.0, f64::from(frame - 40) / 60.0], FRAME)?;
        }
        world.step(FRAME)?;
        let middle = world.body_positions(0)?[0];
        for place in world.positions(0)? {
            let square: f64 = place.iter().zip(middle).map(|(place, middle)| (f64::from(*place) - middle).powi(2)).sum();
            assert!(square.sqrt() > RADIUS, "nothing enters the ball");
            assert!(place[2] > 0.0, "nothing falls through the floor");
        }
        lying = world.contacts().iter().filter(|contact| contact.body == Some(0)).count();
    }
    assert!(lying > 0, "it lies on the ball");
    println!("the ball carries the cloth up to {:.2} m, touching it at {lying} places", world.body_positions(0)?[0][2]);
    Ok(())
}
