//! Ranges: what is allowed, and what is allowed but suspicious.

use super::error::brief;
use super::{
    Bending, Cloth, Flow, FlowElement, FlowKind, Keyframe, Network, Pin, PointMass, Scene, SceneError, Selector, Source,
    Substeps, Wind, body, contact, curves, turn,
};

/// What a check finds wrong first, if anything.
pub(super) type Check = Result<(), SceneError>;

/// Coordinates and lengths beyond this [m] are mistakes.
pub const FARTHEST: f64 = 1e5;
/// Lengths and factors on lengths below this [m; 1] are mistakes: single precision has no room for their fourth powers.
pub const NEAREST: f64 = 1e-9;
/// More vertices than this in all grids would not fit the memory of an ordinary machine.
const MOST_VERTICES: u64 = 16_000_000;
/// Constants of a material are 0 or at least this: what is smaller vanishes in single precision beside anything else.
const LEAST: f64 = 1e-20;
/// Masses of points lie between these [kg]: their squares, and those of 1 / mass, have room in single precision.
pub const MASSES: [f64; 2] = [1e-15, 1e15];
/// Limits below this [1] are none: 1 + limit is 1 in single precision.
const TIGHTEST: f64 = 1e-9;
/// Gusts that are shorter than this [s] pass within every step.
const SHORTEST_GUST: f64 = 1e-3;
/// Longer names [characters] fill the screen.
const LONGEST_NAME: usize = 100;
/// Vortices and sources thinner than this [m] would be faster than sound long before they are felt.
const SMALLEST_CORE: f64 = 1e-3;
/// More steps per frame than this is a mistake in the units.
const MOST_SUBSTEPS: u32 = 100_000;

/// Refuses the first field that is out of range.
pub(super) fn check(scene: &Scene) -> Check {
    within("duration", scene.duration, 0.0, 1e6, "5.0")?;
    within("fps", scene.fps, 1e-3, 1e5, "60")?;
    check_gravity(&scene.gravity())?;
    check_keyframes("gravity_keyframes", &scene.gravity_keyframes, 1e6)?;
    if let Some(wind) = &scene.wind {
        check_wind(wind)?;
    }
    check_solver(scene)?;
    curves::check_filter(scene)?;
    contact::check_filter(scene)?;
    if scene.cloth.is_empty() {
        return Err(SceneError::at("cloth", "there is none; add a [[cloth]] with grid, mesh or network"));
    }
    let mut vertices = 0;
    for (index, cloth) in scene.cloth.iter().enumerate() {
        check_cloth(&format!("cloth[{index}]"), cloth, &mut vertices)?;
        if let Some(first) = scene.cloth[..index].iter().position(|other| !cloth.name.is_empty() && other.name == cloth.name) {
            return Err(SceneError::with_value(
                format!("cloth[{index}].name"),
                format!("{:?}", cloth.name),
                format!("already the name of cloth[{first}]; choose another"),
            ));
        }
    }
    body::check(scene)
}

/// Names are short enough for a screen.
pub(super) fn check_name(at: &str, name: &str) -> Check {
    if name.chars().count() > LONGEST_NAME || name.contains(char::is_control) {
        let problem = format!("must have at most {LONGEST_NAME} characters, none of them a control character");
        return Err(SceneError::with_value(format!("{at}.name"), format!("{name:?}"), problem));
    }
    Ok(())
}

pub fn check_gravity(gravity: &[f64; 3]) -> Check {
    vector("gravity", gravity, 1e6, "[0, 0, -9.81]")
}

pub(super) fn check_wind(wind: &Wind) -> Check {
    vector("wind.velocity", &wind.velocity, 1e4, "[8, 1.5, 0]")?;
    check_keyframes("wind.keyframes", &wind.keyframes, 1e4)?;
    constant("wind.density", wind.density, 1e5, "1.2 (air)")?;
    if let Some(gust) = &wind.gust {
        within("wind.gust.strength", gust.strength, 0.0, 10.0, "0.3")?;
        within("wind.gust.period", gust.period, SHORTEST_GUST, 1e6, "2.0")?;
    }
    wind.elements.iter().enumerate().try_for_each(|(index, element)| check_flow(&format!("wind.elements[{index}]"), element))
}

fn check_flow(at: &str, element: &FlowElement) -> Check {
    let Some(flow) = element.flow() else {
        let needs = match element.kind {
            FlowKind::Uniform => "a uniform flow has velocity [m/s]",
            FlowKind::Vortex => "a vortex has centre [m], axis, circulation [m^2/s] and core [m]",
            FlowKind::Source => "a source has centre [m], flow [m^3/s; negative for a sink] and core [m]",
        };
        return Err(SceneError::at(at, format!("{needs}, all of them and nothing else")));
    };
    let place = |centre: &[f64; 3], core: f64| {
        vector(&format!("{at}.centre"), centre, FARTHEST, "[1, 0, 1.5]")?;
        within(&format!("{at}.core"), core, SMALLEST_CORE, FARTHEST, "0.1")
    };
    match flow {
        Flow::Uniform(velocity) => vector(&format!("{at}.velocity"), &velocity, 1e4, "[1, 0, 0]"),
        Flow::Vortex { centre, axis, circulation, core } => {
            place(&centre, core)?;
            vector(&format!("{at}.axis"), &axis, 1e6, "[0, 0, 1]")?;
            if norm(&axis) < 1e-6 {
                return Err(SceneError::at(format!("{at}.axis"), "has no direction; try [0, 0, 1]"));
            }
            within(&format!("{at}.circulation"), circulation, -1e6, 1e6, "2.0")
        }
        Flow::Source { centre, flow, core } => {
            place(&centre, core)?;
            within(&format!("{at}.flow"), flow, -1e6, 1e6, "1.0")
        }
    }
}

fn check_solver(scene: &Scene) -> Check {
    if let Substeps::Count(count) = scene.solver.substeps
        && !(1..=MOST_SUBSTEPS).contains(&count)
    {
        return Err(out_of_range("solver.substeps", count, &format!("in [1, {MOST_SUBSTEPS}]"), "\"auto\""));
    }
    if !(1..=1_000_000).contains(&scene.solver.iterations()) {
        return Err(out_of_range("solver.iterations", scene.solver.iterations(), "in [1, 1000000]", "200"));
    }
    within("solver.tolerance", scene.solver.tolerance, 0.0, 1.0, "0.001")
}

/// Checks a cloth; `vertices` counts those of all grids.
fn check_cloth(at: &str, cloth: &Cloth, vertices: &mut u64) -> Check {
    check_name(at, &cloth.name)?;
    match cloth.sources().as_slice() {
        [Source::Grid(grid)] => {
            for (axis, size) in grid.size.iter().enumerate() {
                within(&format!("{at}.grid.size[{axis}]"), *size, NEAREST, FARTHEST, "1.0")?;
            }
            for (axis, &cells) in grid.cells.iter().enumerate() {
                if cells == 0 {
                    return Err(out_of_range(&format!("{at}.grid.cells[{axis}]"), cells, "at least 1", "32"));
                }
            }
            let own = grid.cells.iter().map(|&cells| u64::from(cells) + 1).fold(1, u64::saturating_mul);
            *vertices = vertices.saturating_add(own);
            if *vertices > MOST_VERTICES {
                let cells = format!("[{}, {}]", grid.cells[0], grid.cells[1]);
                let allowed = format!("at most {MOST_VERTICES} vertices in all grids together, not {vertices}");
                return Err(out_of_range(&format!("{at}.grid.cells"), cells, &allowed, "[256, 256]"));
            }
            vector(&format!("{at}.grid.origin"), &grid.origin, FARTHEST, "[0, 0, 0]")?;
            if grid.axes[0].coordinate() == grid.axes[1].coordinate() {
                return Err(SceneError::at(format!("{at}.grid.axes"), "the two axes must differ; try [\"x\", \"z\"]"));
            }
        }
        [Source::Mesh("")] => {
            return Err(SceneError::at(format!("{at}.mesh"), "must be the path of a mesh file"));
        }
        [Source::Mesh(_)] => {}
        [Source::Network(network)] => check_network(&format!("{at}.network"), network)?,
        given => {
            let problem = "needs exactly one of grid, mesh, network";
            return Err(SceneError::at(at, format!("{problem}; it has {}", if given.is_empty() { "none" } else { "several" })));
        }
    }
    within(&format!("{at}.scale"), cloth.scale, NEAREST, 1e6, "1.0")?;
    vector(&format!("{at}.rotate"), &cloth.rotate, 1e6, "[0, 0, 90]")?;
    vector(&format!("{at}.translate"), &cloth.translate, FARTHEST, "[0, 0, 1]")?;
    curves::check(at, cloth)?;
    check_material(at, cloth)?;
    contact::check_cloth(at, cloth)?;
    constant(&format!("{at}.imperfection"), cloth.imperfection, 1e-2, "1e-5")?;
    for (index, pin) in cloth.pins.iter().enumerate() {
        check_pin(&format!("{at}.pins[{index}]"), pin, cloth)?;
    }
    for (index, weight) in cloth.weights.iter().enumerate() {
        let at = format!("{at}.weights[{index}]");
        check_selection(&at, &weight.selectors(), cloth)?;
        within(&format!("{at}.mass"), weight.mass, MASSES[0], 1e6, "0.2")?;
    }
    Ok(())
}

fn check_material(at: &str, cloth: &Cloth) -> Check {
    let material = cloth.material();
    within(&format!("{at}.strain_limit"), material.strain_limit, TIGHTEST, 1.0, "0.05")?;
    let mut previous = 0.0;
    for (index, key) in cloth.strain_limit_keyframes.iter().enumerate() {
        let at = format!("{at}.strain_limit_keyframes[{index}]");
        check_time(&at, key.0, &mut previous)?;
        within(&at, key.1, TIGHTEST, 1.0, "0.05")?;
    }
    within(&format!("{at}.density"), material.density, 1e-9, 1e4, "0.2")?;
    constant(&format!("{at}.stiffness"), material.stiffness, 1e9, "20")?;
    constant(&format!("{at}.shear_stiffness"), material.shear_stiffness, 1e9, "10")?;
    constant(&format!("{at}.flexion_stiffness"), cloth.flexion_stiffness, 1e9, "0")?;
    if cloth.bending == Bending::Fabric && cloth.network.is_some() {
        let problem = "a network has no breadth that the fabric's stiffness could count for; give a number [N m^2]";
        return Err(SceneError::with_value(format!("{at}.bending"), "\"fabric\"", problem));
    }
    constant(&format!("{at}.bending"), cloth.bending(), 1e6, "1e-5 or \"fabric\"")?;
    constant(&format!("{at}.damping"), material.damping, 1e6, "0.005")?;
    constant(&format!("{at}.air_drag"), material.air_drag, 1e6, "0.1")?;
    constant(&format!("{at}.drag_coefficient"), material.drag_coefficient, 1e3, "1.2")?;
    constant(&format!("{at}.lift_coefficient"), material.lift_coefficient, 1e3, "1.2")?;
    constant(&format!("{at}.friction_coefficient"), cloth.friction_coefficient, 1e3, "0.01")
}

/// Keyframes of what has a value of its own at time 0.
fn check_keyframes(at: &str, keyframes: &[Keyframe], most: f64) -> Check {
    let mut previous = 0.0;
    for (index, key) in keyframes.iter().enumerate() {
        let at = format!("{at}[{index}]");
        check_time(&at, key.0, &mut previous)?;
        vector(&at, &key.1, most, "[0, 0, 0]")?;
    }
    Ok(())
}

/// Times rise from above 0.
fn check_time(at: &str, time: f64, previous: &mut f64) -> Check {
    within(at, time, 0.0, 1e9, "1.0")?;
    if time <= *previous {
        return Err(SceneError::with_value(at, time, "times must be above 0 and increase from keyframe to keyframe"));
    }
    *previous = time;
    Ok(())
}

fn check_network(at: &str, network: &Network) -> Check {
    if network.points.is_empty() {
        return Err(SceneError::at(format!("{at}.points"), "there are none; give at least one [x, y, z]"));
    }
    for (index, point) in network.points.iter().enumerate() {
        vector(&format!("{at}.points[{index}]"), point, FARTHEST, "[0, 0, 0]")?;
    }
    let (count, points) = (network.points.len(), format!("{at}.points"));
    for (index, link) in network.links.iter().enumerate() {
        let at = format!("{at}.links[{index}]");
        let value = format!("[{}, {}]", link[0], link[1]);
        if link.iter().any(|&end| end as usize >= count) {
            return Err(SceneError::with_value(at, value, format!("there are {count} points, numbered 0 to {}", count - 1)));
        }
        if link[0] == link[1] || network.points[link[0] as usize] == network.points[link[1] as usize] {
            let [a, b] = link.map(|end| format!("{points}[{end}]"));
            return Err(SceneError::with_value(at, value, format!("must join two points at different places, not {a} and {b}")));
        }
    }
    match &network.mass {
        PointMass::One(mass) => within(&format!("{at}.mass"), *mass, MASSES[0], 1e6, "0.003"),
        PointMass::Each(masses) if masses.len() != count => Err(SceneError::at(
            format!("{at}.mass"),
            format!("has {} numbers for {count} points; give one number for all, or {count}", masses.len()),
        )),
        PointMass::Each(masses) => masses
            .iter()
            .enumerate()
            .try_for_each(|(index, mass)| within(&format!("{at}.mass[{index}]"), *mass, MASSES[0], 1e6, "0.003")),
    }
}

fn check_selection(at: &str, selectors: &[Selector<'_>], cloth: &Cloth) -> Check {
    match selectors {
        [Selector::Corner(_) | Selector::Edge(_)] if cloth.grid.is_none() => {
            return Err(SceneError::at(at, "corner and edge need a grid; choose by vertices, box or nearest"));
        }
        [Selector::Vertices([])] => return Err(SceneError::at(format!("{at}.vertices"), "names no vertex")),
        [Selector::Box([low, high])] => {
            vector(&format!("{at}.box[0]"), low, f64::MAX, "[0, 0, 0]")?;
            vector(&format!("{at}.box[1]"), high, f64::MAX, "[1, 1, 1]")?;
            if (0..3).any(|axis| low[axis] > high[axis]) {
                return Err(SceneError::at(format!("{at}.box"), "its first corner must be the lowest in x, y and z"));
            }
        }
        [Selector::Nearest(point)] => vector(&format!("{at}.nearest"), point, f64::MAX, "[0, 0, 1]")?,
        [_] => {}
        given => {
            let problem = "needs exactly one of corner, edge, vertices, box, nearest";
            return Err(SceneError::at(at, format!("{problem}; it has {}", if given.is_empty() { "none" } else { "several" })));
        }
    }
    Ok(())
}

fn check_pin(at: &str, pin: &Pin, cloth: &Cloth) -> Check {
    check_selection(at, &pin.selectors(), cloth)?;
    if let Some(path) = &pin.follow {
        let refuse = |problem: &str| Err(SceneError::with_value(format!("{at}.follow"), path, problem));
        if path.is_empty() {
            return refuse("must be the path of an .npy or .pc2 file, or a list of .obj files, one for each frame");
        }
        if pin.turn.is_some() || !pin.keyframes.is_empty() {
            return refuse("a pin that follows an array has neither `move` nor `turn`; leave them out, or `follow`");
        }
    }
    if let Some(turn) = &pin.turn {
        turn::check(&format!("{at}.turn"), turn)?;
    }
    check_moves(&format!("{at}.move"), &pin.keyframes, "a pin is where the cloth is")
}

/// Keyframes of a displacement from the start, where `truth` holds.
pub(super) fn check_moves(at: &str, keyframes: &[Keyframe], truth: &str) -> Check {
    let mut previous = f64::NEG_INFINITY;
    for (index, key) in keyframes.iter().enumerate() {
        let at = format!("{at}[{index}]");
        within(&at, key.0, 0.0, 1e9, "0.0")?;
        vector(&at, &key.1, FARTHEST, "[0, 0, 0]")?;
        if key.0 <= previous {
            return Err(SceneError::with_value(at, key.0, "times must increase from keyframe to keyframe"));
        }
        if key.0 == 0.0 && key.1 != [0.0; 3] {
            return Err(SceneError::at(at, format!("at time 0 {truth}; begin with [0, [0, 0, 0]]")));
        }
        previous = key.0;
    }
    Ok(())
}

/// What is allowed but looks like a mistake.
pub(super) fn suspicions(scene: &Scene) -> Vec<String> {
    let mut found = Vec::new();
    for (index, cloth) in scene.cloth.iter().enumerate() {
        let material = cloth.material();
        let (least, most) = cloth.fabric.usual_density();
        if cloth.network.is_none() && !(least..=most).contains(&material.density) {
            let fabric = format!("{:?}", cloth.fabric).to_lowercase();
            found.push(format!(
                "scene.cloth[{index}].density = {} kg/m^2: {fabric} is usually {least} to {most} kg/m^2 (1 g/m^2 is 0.001 kg/m^2)",
                material.density
            ));
        }
        if !(0.01..=0.15).contains(&material.strain_limit) {
            found.push(format!(
                "scene.cloth[{index}].strain_limit = {}: cloth usually gives 0.01 to 0.15 (1 to 15 %)",
                material.strain_limit
            ));
        }
    }
    let speed = scene.wind.as_ref().map_or(0.0, |wind| norm(&wind.velocity));
    if speed > 60.0 {
        found.push(format!("scene.wind.velocity: {speed:.0} m/s is stronger than a hurricane (over 33 m/s)"));
    }
    let pull = norm(&scene.gravity());
    if pull > 100.0 {
        found.push(format!("scene.gravity: {pull:.0} m/s^2 is over ten times the Earth's 9.81; are the units metres?"));
    }
    found
}

pub(super) fn norm(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

pub(super) fn out_of_range(at: &str, value: impl std::fmt::Display, allowed: &str, remedy: &str) -> SceneError {
    SceneError::with_value(at, value, format!("must be {allowed}; try {remedy}"))
}

pub(super) fn within(at: &str, value: f64, least: f64, most: f64, remedy: &str) -> Check {
    let allowed = || format!("in [{}, {most}]", brief(least));
    if (least..=most).contains(&value) { Ok(()) } else { Err(out_of_range(at, brief(value), &allowed(), remedy)) }
}

/// A constant of a material or of the air: nothing, or what single precision sees.
pub(super) fn constant(at: &str, value: f64, most: f64, remedy: &str) -> Check {
    let allowed = || format!("0 or in [{LEAST:e}, {most}]");
    if value == 0.0 || (LEAST..=most).contains(&value) { Ok(()) } else { Err(out_of_range(at, brief(value), &allowed(), remedy)) }
}

pub(super) fn vector(at: &str, value: &[f64; 3], most: f64, remedy: &str) -> Check {
    if value.iter().all(|part| part.is_finite() && part.abs() <= most) {
        return Ok(());
    }
    let allowed = if most == f64::MAX { "finite numbers".to_owned() } else { format!("numbers in [-{most}, {most}]") };
    Err(out_of_range(at, format!("[{}]", value.map(brief).join(", ")), &allowed, remedy))
}

/// A vector with a direction.
pub(super) fn direction(at: &str, value: &[f64; 3]) -> Check {
    vector(at, value, 1e6, "[0, 0, 1]")?;
    if norm(value) < 1e-6 {
        return Err(out_of_range(at, format!("{value:?}"), "a direction, at least 1e-6 long", "[0, 0, 1]"));
    }
    Ok(())
}
