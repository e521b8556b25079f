//! What a report says of springs, against sums over all of them in double precision.

use crate::common::{Simulation, chain_links, network, sheet};
use serde_json::json;

#[test]
fn energies_and_the_longest_spring_are_those_of_all_springs() {
    let rope = network(&[[0.0, 3.0, 0.0], [0.1, 3.0, 0.0], [0.2, 3.0, 0.0]], &chain_links(2), 0.01);
    // Rows that do and do not fill vector registers; more and fewer rows than are examined together.
    for cells in [[2, 2], [5, 7], [17, 8], [40, 33]] {
        let mut one = sheet(cells, 0.1, json!([{ "corner": "bottom-left" }]));
        let mut other = sheet([cells[1], cells[0]], 0.05, json!([{ "edge": "top" }]));
        (one["name"], other["name"], other["grid"]["origin"]) = (json!("one"), json!("other"), json!([2.0, 0.0, 0.0]));
        other["flexion_stiffness"] = json!(5.0);
        let scene = |order: [usize; 3]| {
            let cloths = [one.clone(), rope.clone(), other.clone()];
            json!({ "fps": 60.0, "gravity": [0.3, 0.0, -9.81], "cloth": order.map(|index| cloths[index].clone()) })
        };
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let mut run = Simulation::new(&scene(order));
            let report = run.steps(12).last;
            let springs = &run.model.springs;
            let length = |spring: usize| {
                let [u, v] = springs.ends[spring].map(|end| run.state.positions.get(end as usize).as_dvec3());
                u.distance(v)
            };
            let stretch = |spring: usize| length(spring) / f64::from(springs.rest[spring]) - 1.0;
            let extension = |spring: usize| length(spring) - f64::from(springs.rest[spring]);
            let energy = |spring: usize| 0.5 * f64::from(springs.stiffness[spring]) * extension(spring).powi(2);
            let (longest, elastic) =
                ((0..springs.type1).map(stretch).fold(0.0, f64::max), (0..springs.len()).map(energy).sum::<f64>());
            let said = report.worst_spring.expect("some spring is longer than at rest") as usize;
            assert!((report.worst_stretch - longest).abs() < 2e-5, "{cells:?}: {} and {longest}", report.worst_stretch);
            assert!((stretch(said) - longest).abs() < 2e-5, "{cells:?}: spring {said}: {} and {longest}", stretch(said));
            assert!((report.elastic_energy / elastic - 1.0).abs() < 1e-3, "{cells:?}: {} and {elastic} J", report.elastic_energy);
        }
    }
}
