//! Networks in a few words.

use glam::DVec3;
use serde_json::{Value, json};

use super::oracle::{pierces, places};
use super::{Simulation, chain_links};

/// A net of so many cells along each side; `place` takes coordinates from 0 to 1.
pub fn net(cells: [u32; 2], mass: f64, place: impl Fn(f64, f64) -> DVec3) -> Value {
    let across = cells[0] + 1;
    let points: Vec<[f64; 3]> = (0..across * (cells[1] + 1))
        .map(|point| {
            let [i, j] = [point % across, point / across].map(f64::from);
            place(i / f64::from(cells[0]), j / f64::from(cells[1])).to_array()
        })
        .collect();
    let along = (0..=cells[1]).flat_map(|j| (0..cells[0]).map(move |i| j * across + i)).map(|a| [a, a + 1]);
    let up = (0..cells[1]).flat_map(|j| (0..across).map(move |i| j * across + i)).map(|a| [a, a + across]);
    let links: Vec<[u32; 2]> = along.chain(up).collect();
    of_network(json!({ "points": points, "links": links, "mass": mass / f64::from(across * (cells[1] + 1)) }))
}

/// A rope of so many links; `place` takes a coordinate from 0 to 1.
pub fn rope(links: u32, mass: f64, place: impl Fn(f64) -> DVec3) -> Value {
    let points: Vec<[f64; 3]> = (0..=links).map(|point| place(f64::from(point) / f64::from(links)).to_array()).collect();
    of_network(json!({ "points": points, "links": chain_links(links), "mass": mass / f64::from(links + 1) }))
}

fn of_network(network: Value) -> Value {
    json!({
        "network": network, "stiffness": 200.0, "damping": 0.01, "strain_limit": 0.03, "thickness": 0.006, "friction": 0.3,
        "air_drag": 0.5,
    })
}

pub fn with(mut cloth: Value, field: &str, value: Value) -> Value {
    cloth[field] = value;
    cloth
}

/// How many links pass through triangles.
pub fn crossings(run: &Simulation) -> usize {
    let model = &run.model;
    let x: Vec<DVec3> = places(run).into_iter().chain(run.state.bodies.iter().copied()).collect();
    let count = model.particle_count() as u32;
    let of_bodies = model.bodies.triangles.iter().map(|corners| corners.map(|corner| corner + count));
    let triangles: Vec<[DVec3; 3]> =
        model.triangles.iter().copied().chain(of_bodies).map(|corners| corners.map(|corner| x[corner as usize])).collect();
    let nets = model.cloths.iter().filter(|cloth| cloth.is_network);
    let links = nets.flat_map(|net| &model.springs.ends[net.springs.clone()]).map(|ends| ends.map(|end| x[end as usize]));
    links.map(|link| triangles.iter().filter(|corners| pierces(link, **corners)).count()).sum()
}
