//! No length, time or speed of the engine's own: a scene and the same scene at another scale move alike, to the last bit.
//!
//! Lengths times s and times times the root of s leave gravity as it is. Powers of four keep every number's bits but its exponent.

use std::collections::BTreeMap;

use crate::common::{Built, Simulation, build, crooked, scene};
use serde_json::{Value, json};
use taut::state::State;

/// What scales with which powers of the root of s.
struct Scale {
    root: f64,
}

impl Scale {
    fn length(&self, value: f64) -> f64 {
        value * self.root.powi(2)
    }

    fn time(&self, value: f64) -> f64 {
        value * self.root
    }

    fn speed(&self, value: f64) -> f64 {
        value * self.root
    }

    fn place(&self, value: [f64; 3]) -> [f64; 3] {
        value.map(|part| self.length(part))
    }

    /// Of masses per area as s, so that air of the same density is as heavy beside it.
    fn fabric(&self, limit: f64) -> Value {
        json!({
            "density": 0.2 * self.root.powi(2), "stiffness": 80.0 * self.root.powi(4), "shear_stiffness": 20.0 * self.root.powi(4),
            "damping": 0.01 * self.root.powi(5), "bending": 1e-5 * self.root.powi(8), "air_drag": 0.2 / self.root,
            "strain_limit": limit, "drag_coefficient": 1.0, "friction_coefficient": 0.01,
        })
    }

    fn grid(&self, limit: f64) -> Value {
        let mut cloth = self.fabric(limit);
        cloth["name"] = json!("grid");
        cloth["grid"] = json!({
            "size": [self.length(1.0), self.length(0.75)], "cells": [32, 24], "axes": ["x", "y"], "origin": self.place([0.0, 0.0, 1.0]),
        });
        cloth["pins"] = json!([
            { "corner": "bottom-left" },
            { "corner": "top-left", "move": [[self.time(0.25), self.place([0.125, -0.25, 0.0])], [self.time(0.5), self.place([0.0; 3])]] },
        ]);
        cloth["weights"] = json!([{ "corner": "top-right", "mass": 0.02 * self.root.powi(6) }]);
        cloth
    }

    fn mesh(&self, limit: f64) -> Value {
        let mut cloth = self.fabric(limit);
        (cloth["name"], cloth["mesh"], cloth["scale"]) = (json!("mesh"), json!("crooked"), json!(self.length(1.0)));
        cloth["translate"] = json!(self.place([0.0, 2.0, 1.0]));
        cloth["pins"] = json!([{ "nearest": self.place([0.0, 2.0, 1.0]) }]);
        cloth
    }

    fn net(&self, limit: f64) -> Value {
        let side = 10;
        let points: Vec<[f64; 3]> =
            (0..side * side).map(|at| self.place([f64::from(at % side) / 8.0, f64::from(at / side) / 8.0, -1.0])).collect();
        let along = (0..side * side).filter(|at| at % side + 1 < side).map(|at| [at, at + 1]);
        let up = (0..side * (side - 1)).map(|at| [at, at + side]);
        let links: Vec<[i32; 2]> = along.chain(up).collect();
        json!({
            "name": "net", "network": { "points": points, "links": links, "mass": 0.1 * self.root.powi(6) },
            "stiffness": 100.0 * self.root.powi(4), "damping": 0.002 * self.root.powi(5), "air_drag": 0.1 / self.root,
            "strain_limit": limit, "pins": [{ "vertices": [0, 9] }],
            "weights": [{ "vertices": [95], "mass": 0.05 * self.root.powi(6) }],
        })
    }

    /// A mesh that falls on a ball, and touches itself.
    fn ball(&self, limit: f64) -> Built {
        let mut cloth = self.mesh(limit);
        (cloth["thickness"], cloth["friction"], cloth["pins"]) = (json!(self.length(0.004)), json!(0.3), json!([]));
        let sphere = json!({ "center": self.place([0.5, 2.5, 0.75]), "radius": self.length(0.2) });
        let ball = json!({ "sphere": sphere, "friction": 0.3, "thickness": self.length(0.001) });
        let document = json!({ "fps": 60.0 / self.root, "cloth": [cloth], "body": [ball] });
        built(&document)
    }

    fn scene(&self, cloth: &[Value], solver: &Value, wind: bool) -> Built {
        let mut document = json!({ "fps": 60.0 / self.root, "cloth": cloth, "solver": solver });
        if wind {
            let velocity = [4.0, 1.0, 0.5].map(|part| self.speed(part));
            document["wind"] = json!({
                "velocity": velocity,
                "gust": { "strength": 0.3, "period": self.time(0.5), "seed": 1 },
                "elements": [{
                    "kind": "vortex", "centre": self.place([0.5, 0.25, 1.5]), "axis": [0, 0, 1],
                    "circulation": self.length(self.speed(2.0)), "core": self.length(0.25),
                }],
            });
        }
        built(&document)
    }
}

fn built(document: &Value) -> Built {
    build(&scene(document), &BTreeMap::from([("crooked".to_owned(), crooked(20))])).expect("a model")
}

/// Positions and velocities after some frames of the scene of 1 m, as they would be there, and steps and passes.
fn after(frames: u64, scale: &Scale, built: Built) -> (Vec<[f32; 3]>, Vec<[f32; 3]>, u64, u64) {
    let mut run = Simulation::of(built);
    let summary = run.steps(u64::from(run.model.schedule.substeps) * frames);
    let rows = |vectors: &taut::geometry::Vectors, unit: f64| {
        vectors.iter().map(|vector| (vector / unit as f32).to_array()).collect::<Vec<_>>()
    };
    let State { positions, velocities, .. } = &run.state;
    (rows(positions, scale.length(1.0)), rows(velocities, scale.speed(1.0)), summary.steps, summary.sweeps)
}

fn check(name: &str, cloths: impl Fn(&Scale) -> Vec<Value>, solver: &Value, wind: bool) {
    same(name, 60, &[0.125, 0.5, 2.0, 8.0], |scale| scale.scene(&cloths(scale), solver, wind));
}

fn same(name: &str, frames: u64, roots: &[f64], built: impl Fn(&Scale) -> Built) {
    let run = |root: f64| {
        let scale = Scale { root };
        after(frames, &scale, built(&scale))
    };
    let one = run(1.0);
    for &root in roots {
        let other = run(root);
        assert_eq!((one.2, one.3), (other.2, other.3), "{name}, {} times as large: steps and passes", root * root);
        assert!(one.0 == other.0 && one.1 == other.1, "{name}, {} times as large", root * root);
    }
}

#[test]
fn a_grid_moves_alike_at_any_scale() {
    for limit in [0.1, 0.01] {
        for wind in [false, true] {
            check(&format!("grid, {limit}, wind {wind}"), |scale| vec![scale.grid(limit)], &json!({}), wind);
        }
    }
}

#[test]
fn so_do_meshes_nets_and_all_together() {
    for limit in [0.1, 0.01] {
        check(&format!("mesh, {limit}"), |scale| vec![scale.mesh(limit)], &json!({}), true);
        check(&format!("net, {limit}"), |scale| vec![scale.net(limit)], &json!({}), true);
        let all = |scale: &Scale| vec![scale.grid(limit), scale.mesh(limit), scale.net(limit)];
        check(&format!("all, {limit}"), all, &json!({}), false);
    }
}

/// Other methods take hundreds of steps a frame: a quarter of a second, at the ends of the range.
fn check_method(name: &str, cloth: impl Fn(&Scale) -> Value, solver: &Value) {
    same(name, 15, &[0.125, 8.0], |scale| scale.scene(&[cloth(scale)], solver, true));
}

#[test]
fn so_they_do_with_every_filter() {
    for filter in ["none", "sweeps", "sequential", "provot", "tethers", "xpbd", "rods", "fast_projection"] {
        check_method(filter, |scale| scale.grid(0.1), &json!({ "filter": filter, "iterations": 10 }));
    }
}

#[test]
fn so_they_do_with_every_integrator() {
    for integrator in ["rk4", "verlet", "implicit_euler", "bdf2"] {
        check_method(integrator, |scale| scale.mesh(0.1), &json!({ "integrator": integrator }));
    }
    // How many steps of the others grow too fast is a matter of the seconds of who looks on.
    for integrator in ["midpoint", "forward_euler"] {
        let solver = json!({ "integrator": integrator, "substeps": 200, "force_step": true });
        check_method(integrator, |scale| scale.mesh(0.1), &solver);
    }
}

#[test]
fn so_does_what_touches() {
    for limit in [0.1, 0.01] {
        same(&format!("on a ball, {limit}"), 45, &[0.125, 0.5, 2.0, 8.0], |scale| scale.ball(limit));
    }
}
