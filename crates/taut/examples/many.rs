//! Many cloths, each a world of its own, on one pool of threads: `cargo run --release --example many`.

use taut::{Cloth, Corner, Error, Fabric, Pin, Pool, World};

const FRAME: f64 = 1.0 / 60.0;

fn banner(number: u16, pool: &Pool) -> Result<World, Error> {
    let fabric = [Fabric::Silk, Fabric::Cotton, Fabric::Nylon][usize::from(number % 3)];
    let cloth = Cloth::grid([1.0, 1.5], [32, 48]).fabric(fabric).translate([2.0 * f64::from(number), 0.0, 0.0]);
    let cloth = cloth.pin(Pin::corner(Corner::TopLeft)).pin(Pin::corner(Corner::TopRight));
    World::builder().cloth(cloth).wind([1.0, 0.2 * f64::from(number), 0.0]).pool(pool).build()
}

fn main() -> Result<(), Error> {
    // One pool for all: threads do not multiply. `Pool::of_host()` takes those of the rayon pool that the program has already.
    let pool = Pool::new(4)?;
    let mut banners = (0..8).map(|number| banner(number, &pool)).collect::<Result<Vec<_>, _>>()?;
    for _ in 0..20 {
        for banner in &mut banners {
            banner.step(FRAME)?;
        }
    }

    // No result depends on threads: one of them alone, on this thread, comes to the same bits.
    let mut alone = banner(5, &Pool::default())?;
    for _ in 0..20 {
        alone.step(FRAME)?;
    }
    assert_eq!(alone.positions(0)?, banners[5].positions(0)?);
    println!("{} banners on {} threads; number 5 alone has the same bits", banners.len(), pool.threads());
    Ok(())
}
