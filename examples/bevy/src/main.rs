//! A flag in a window of Bevy: `cargo run` in this folder.
//!
//! The cloth steps in `FixedUpdate`, always by the same time, so that its motion has the same bits on every machine; `Update` shows where it
//! is.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use taut::{Axis, Cloth, Edge, Fabric, Gust, Pin, Up, Wind};

/// Cloth is number 0 of its world.
const FLAG: usize = 0;

#[derive(Resource)]
struct Sky {
    world: taut::World,
    mesh: Handle<Mesh>,
}

fn main() {
    App::new()
        .add_plugins(DefaultPlugins)
        .insert_resource(Time::<Fixed>::from_hz(60.0))
        .add_systems(Startup, set_up)
        .add_systems(FixedUpdate, step)
        .add_systems(Update, show)
        .run();
}

fn set_up(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) -> Result {
    // Bevy's y points up.
    let flag = Cloth::grid([1.5, 1.0], [48, 32]).axes([Axis::X, Axis::Y]).fabric(Fabric::Nylon).strain_limit(0.05);
    let wind = Wind { gust: Some(Gust::default()), ..[7.0, 0.5, 1.5].into() };
    let world = taut::World::builder().up(Up::Y).cloth(flag.pin(Pin::edge(Edge::Left))).wind(wind).build()?;

    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, world.positions(FLAG)?.to_vec());
    mesh.insert_indices(Indices::U32(world.faces(FLAG)?.concat()));
    mesh.compute_smooth_normals();
    let mesh = meshes.add(mesh);

    let material = StandardMaterial {
        base_color: Color::srgb(0.8, 0.2, 0.15),
        double_sided: true,
        cull_mode: None,
        perceptual_roughness: 0.8,
        ..default()
    };
    commands.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(materials.add(material))));
    let pole = Capsule3d::new(0.02, 2.4);
    commands.spawn((
        Mesh3d(meshes.add(pole)),
        MeshMaterial3d(materials.add(Color::srgb(0.4, 0.4, 0.45))),
        Transform::from_xyz(-0.02, 0.0, 0.0),
    ));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), Transform::from_xyz(1.5, 0.8, 3.0).looking_at(Vec3::new(0.8, 0.5, 0.0), Vec3::Y)));
    commands.insert_resource(Sky { world, mesh });
    Ok(())
}

fn step(time: Res<Time>, mut sky: ResMut<Sky>) -> Result {
    sky.world.step(time.delta_secs_f64())?;
    Ok(())
}

fn show(sky: Res<Sky>, mut meshes: ResMut<Assets<Mesh>>) -> Result {
    if let Some(mesh) = meshes.get_mut(&sky.mesh) {
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, sky.world.positions(FLAG)?.to_vec());
        mesh.compute_smooth_normals();
    }
    Ok(())
}
