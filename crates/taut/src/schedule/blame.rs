//! Why a scene needs more steps than anybody would wait for, in the user's own words: his fields.

use super::choice::{MOST_STEPS, ROOMY, remedy};
use super::pace::LONGEST;
use super::parts::is_divided;
use super::stability::of_euler;
use crate::geometry::cbrt;
use crate::inputs::Inputs;
use crate::model::Model;
use crate::scene::{Scene, SceneError, brief};

/// What makes a step short.
#[derive(Clone, Copy, PartialEq)]
enum Cause {
    Springs,
    Dampers,
    Air,
    Motion,
}

impl Cause {
    fn says(self) -> &'static str {
        match self {
            Self::Springs => "has springs or bending too stiff for its masses",
            Self::Dampers => "has damping too strong for its masses",
            Self::Air => "meets air too strong for its masses",
            Self::Motion => "moves by its own size in too short a time",
        }
    }

    /// The fields of a scene and of a cloth that have a part in it.
    fn fields(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            Self::Springs => (
                &["fps"],
                &[
                    "stiffness",
                    "shear_stiffness",
                    "flexion_stiffness",
                    "bending",
                    "curves.tension",
                    "curves.tension_weft",
                    "curves.shear",
                    "curves.bending",
                ],
            ),
            Self::Dampers => (&["fps"], &["damping"]),
            Self::Air => (
                &["fps", "wind.velocity", "wind.keyframes", "wind.gust.strength", "wind.elements", "wind.density"],
                &["air_drag", "drag_coefficient", "lift_coefficient", "friction_coefficient"],
            ),
            Self::Motion => (
                &[
                    "fps",
                    "gravity",
                    "gravity_keyframes",
                    "wind.velocity",
                    "wind.keyframes",
                    "wind.gust.strength",
                    "wind.elements",
                ],
                &["strain_limit", "strain_limit_keyframes"],
            ),
        }
    }
}

/// Of every cloth: its masses follow from these.
const MASSES: [&str; 8] = ["density", "network.mass", "grid.size", "grid.cells", "mesh", "network.points", "scale", "weights"];

/// The error of a scene that would need so many `steps` a frame; each cloth moves by its size in `pace` seconds.
pub(super) fn too_many(scene: &Scene, model: &Model, inputs: &Inputs, pace: &[f64], steps: f64) -> SceneError {
    let drag = inputs.drag(&model.rates);
    let divided = is_divided(&scene.solver);
    let bounds = model.cloths.iter().flat_map(|cloth| {
        let (fastest, index) = (&cloth.fastest, cloth.index);
        // Springs and dampers that take a step in parts do not bound it.
        let [springs, dampers] = if divided { [0.0; 2] } else { [fastest.frequency_squared, fastest.damping] };
        let motion = LONGEST * pace[index] * cbrt(cloth.strain_limit / ROOMY).min(1.0);
        [
            (Cause::Springs, index, of_euler(springs, 0.0)),
            (Cause::Dampers, index, of_euler(0.0, dampers)),
            (Cause::Air, index, of_euler(0.0, drag)),
            (Cause::Motion, index, motion),
        ]
    });
    let shortest = bounds.min_by(|one, other| one.2.total_cmp(&other.2));
    let (cause, index) = shortest.map_or((Cause::Motion, 0), |(cause, index, _)| (cause, index));
    let problem = format!("\"auto\" would need {} steps a frame, more than {MOST_STEPS}", brief(steps.ceil()));
    error(scene, cause, index, &problem)
}

/// The error of a cloth whose springs would need so many `parts` of a frame.
pub(super) fn too_many_parts(scene: &Scene, index: usize, parts: f64) -> SceneError {
    let problem = format!("springs would need {} parts of each frame, more than {MOST_STEPS}", brief(parts));
    error(scene, Cause::Springs, index, &problem)
}

fn error(scene: &Scene, cause: Cause, index: usize, problem: &str) -> SceneError {
    let (name, says, fields) = (&scene.cloth[index].name, cause.says(), told(scene, cause, index));
    SceneError::at(
        "solver.substeps",
        format!("{problem}: cloth[{index}] ({name}) {says}; this follows from {fields}{}", remedy(scene)),
    )
}

/// `scene.fps = 60, scene.cloth[0].density = 1e-9 and ..`
fn told(scene: &Scene, cause: Cause, index: usize) -> String {
    let value = values(scene);
    let (of_scene, of_cloth) = cause.fields();
    let whole = of_scene.iter().map(|&field| (field.to_owned(), field.to_owned()));
    let own = of_cloth.iter().chain(&MASSES).map(|field| (format!("cloth[{index}].{field}"), format!("cloth.{index}.{field}")));
    let fields = whole.chain(own).filter_map(|(name, path)| Some(format!("scene.{name}{}", value(&path)?)));
    fields.collect::<Vec<_>>().join(", ")
}

/// ` = 60` for the path of a field; nothing for one that does nothing.
#[cfg(feature = "json")]
fn values(scene: &Scene) -> impl Fn(&str) -> Option<String> {
    use serde_json::Value;

    let document = serde_json::to_value(scene).unwrap_or_default();
    let nothing = |value: &Value| value.is_null() || *value == 0.0 || value.as_array().is_some_and(Vec::is_empty);
    move |path| {
        let value = document.pointer(&format!("/{}", path.replace('.', "/")))?;
        (!nothing(value)).then(|| format!(" = {}", crate::scene::shorten(&value.to_string())))
    }
}

/// Without JSON fields have no values to show.
#[cfg(not(feature = "json"))]
fn values(_: &Scene) -> impl Fn(&str) -> Option<String> {
    |_| Some(String::new())
}
