//! The crate rapier-cloth (XPBD, with Rapier's collision queries) on one thread: `rapier-cloth-adapter JOB.json`, the
//! job as in `harness.py`.
//!
//! settings: substeps (a frame), iterations (a substep), compliance [m/N] of the edges (0, its default: particles also
//! know how far they may be from a pin, its long range bounds); with contact also continuous (1: ways are swept).
//!
//! Bending cannot be left out; it is as soft as it needs to be not to matter. Masses are its own, by areas
//! of triangles.

use std::error::Error;
use std::fs::{File, read, write};
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use cpu_time::ProcessTime;
use rapier_cloth::rapier::prelude::*;
use rapier_cloth::{
    Cloth, ClothContactSettings, ClothHandle, ClothMaterial, ClothMesh, RapierClothWorld, RapierScene, Real, SceneSnapshot, Vec3,
    WorldId,
};
use serde::Deserialize;
use serde_json::json;

const FPS: f64 = 60.0;
const GRAVITY: Real = 9.81;
/// As in `harness.py`.
const FORESIGHT: usize = 5;
/// Compliance of bending [rad/(N m)]: a thousand times that of the crate's softest example.
const LIMP: Real = 1e6;

/// What to simulate, see `harness.py`.
#[derive(Deserialize)]
struct Job {
    positions: Vec<[f64; 3]>,
    masses: Vec<f64>,
    pins: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    settings: Settings,
    frames: usize,
    seconds: f64,
    foresee: bool,
    output: PathBuf,
    report: PathBuf,
    bodies: Option<Vec<Body>>,
    #[serde(default)]
    thickness: f64,
    #[serde(default)]
    friction: f64,
    least: Option<usize>,
}

#[derive(Deserialize)]
struct Settings {
    substeps: u64,
    iterations: usize,
    compliance: Real,
    #[serde(default)]
    continuous: u8,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Body {
    Floor { height: Real },
    Ball { centre: [Real; 3], radius: Real },
    Box { centre: [Real; 3], half: [Real; 3], quaternion: [Real; 4] },
}

impl Body {
    fn collider(&self) -> ColliderBuilder {
        match *self {
            Self::Floor { height } => ColliderBuilder::new(SharedShape::halfspace(Vec3::Z)).translation(Vec3::Z * height),
            Self::Ball { centre, radius } => ColliderBuilder::ball(radius).translation(centre.into()),
            Self::Box { centre, half: [x, y, z], quaternion: [w, i, j, k] } => {
                let sine = Vec3::new(i, j, k);
                let turned = sine.normalize_or_zero() * (2.0 * sine.length().atan2(w));
                ColliderBuilder::cuboid(x, y, z).translation(centre.into()).rotation(turned)
            }
        }
    }
}

/// The cloth and Rapier's world around it.
struct World {
    id: WorldId,
    rigid: PhysicsWorld,
    cloths: RapierClothWorld,
    sheet: ClothHandle,
    substeps: u64,
    step: u64,
}

impl World {
    fn new(job: &Job) -> Result<Self, Box<dyn Error>> {
        let id = WorldId::new();
        let mut rigid = PhysicsWorld::new();
        rigid.gravity = -Vec3::Z * GRAVITY;
        rigid.integration_parameters.dt = (1.0 / (FPS * job.settings.substeps as f64)) as Real;
        for body in job.bodies.iter().flatten() {
            rigid.colliders.insert(body.collider().friction(job.friction as Real));
        }
        let mut cloths = RapierClothWorld::new(id);
        cloths.solver_settings.iterations = job.settings.iterations;
        let sheet = cloths.add_cloth(cloth(job)?);
        Ok(Self { id, rigid, cloths, sheet, substeps: job.settings.substeps, step: 0 })
    }

    /// Advance by 1/60 s.
    fn frame(&mut self) -> Result<(), Box<dyn Error>> {
        let h = self.rigid.integration_parameters.dt;
        for _ in 0..self.substeps {
            let rigid = &mut self.rigid;
            let before = SceneSnapshot::capture(self.id, self.step, &rigid.bodies, &rigid.colliders);
            rigid.step();
            let query = rigid.broad_phase.as_query_pipeline(
                rigid.narrow_phase.query_dispatcher(),
                &rigid.bodies,
                &rigid.colliders,
                QueryFilter::default(),
            );
            self.cloths.step_substep(h, &RapierScene::new(query, &before, h, rigid.gravity))?;
            self.step += 1;
        }
        Ok(())
    }

    fn positions(&self) -> Result<&[Vec3], Box<dyn Error>> {
        Ok(self.cloths.cloth(self.sheet)?.positions())
    }
}

fn cloth(job: &Job) -> Result<Cloth, Box<dyn Error>> {
    let positions = job.positions.iter().map(|at| Vec3::from(at.map(|x| x as Real))).collect();
    let mesh = ClothMesh::new(positions, job.triangles.clone())?;
    let mut material = ClothMaterial {
        stretch_compliance: job.settings.compliance,
        bend_compliance: LIMP,
        damping: 0.0,
        friction: job.friction as Real,
        ..ClothMaterial::default()
    };
    material.surface_density = job.masses.iter().sum::<f64>() as Real / area(job);
    let mut cloth = Cloth::new(mesh, material)?;
    for &pin in &job.pins {
        cloth.pin(pin, cloth.positions()[pin as usize])?;
    }
    if job.bodies.is_some() {
        let continuous = job.settings.continuous == 1;
        cloth.set_contact_settings(Some(ClothContactSettings {
            thickness: job.thickness as Real,
            self_collision: true,
            rigid_surface_collision: true,
            continuous_self_collision: continuous,
            continuous_rigid_collision: continuous,
            static_friction: job.friction as Real,
            kinetic_friction: job.friction as Real,
            ..ClothContactSettings::default()
        }))?;
    }
    Ok(cloth)
}

/// Area of the sheet [m^2].
fn area(job: &Job) -> Real {
    let corner = |index: u32| Vec3::from(job.positions[index as usize].map(|x| x as Real));
    let twice = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
    job.triangles.iter().map(|&corners| twice(corners)).sum::<Real>() / 2.0
}

/// Whether the job's time is used up, or (if asked to foresee it) will not suffice.
fn enough(job: &Job, spent: &[f64]) -> bool {
    if spent.len() < FORESIGHT {
        return false;
    }
    let total: f64 = spent[1..].iter().sum();
    if job.foresee {
        return total / (spent.len() - 1) as f64 * job.frames as f64 > job.seconds;
    }
    total > job.seconds && spent.len() >= job.least.unwrap_or(2 * FORESIGHT)
}

fn main() {
    if let Err(error) = serve() {
        eprintln!("{error}");
        std::process::exit(1);
    }
}

fn serve() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("rapier-cloth-adapter JOB.json")?;
    let job: Job = serde_json::from_slice(&read(path)?)?;
    let mut world = World::new(&job)?;
    let mut output = BufWriter::new(File::create(&job.output)?);
    let start_seconds = ProcessTime::now().as_duration().as_secs_f64();
    let mut spent = Vec::new();
    while spent.len() < job.frames && !enough(&job, &spent) {
        let before = ProcessTime::now();
        world.frame().map_err(|error| format!("at {:.2} s: {error}", (spent.len() + 1) as f64 / FPS))?;
        spent.push(before.elapsed().as_secs_f64());
        for coordinate in world.positions()?.iter().flat_map(|at| at.to_array()) {
            match job.bodies {
                None => output.write_all(&(coordinate as f32).to_le_bytes())?,
                Some(_) => output.write_all(&f64::from(coordinate).to_le_bytes())?,
            }
        }
    }
    output.flush()?;
    let cpu_ms: Vec<f64> = spent.iter().map(|seconds| 1e3 * seconds).collect();
    write(&job.report, json!({ "start_seconds": start_seconds, "cpu_ms": cpu_ms }).to_string())?;
    Ok(())
}
