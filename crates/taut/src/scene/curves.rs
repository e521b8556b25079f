//! A fabric as it was measured: curves instead of single stiffnesses (after Breen, House & Wozny 1994).

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BendingModel, Cloth, FilterKind, Scene, SceneError};

/// More points than this cost time in every step and say no more about a fabric.
const MOST_POINTS: usize = 64;
/// A point this part of the greatest force below the straight line through a curve is no knee.
const KNEE: f64 = 1e-3;
/// Points of a curve lie at least so far apart, in the unit of their first number: steeper slopes are steps.
const APART: f64 = 1e-6;
/// The least force that is one, in the unit of the second number.
const LEAST: f64 = 1e-20;

/// Points that begin at [0, 0] and never fall; straight lines join them and go on from the last one.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Curve(pub Vec<[f64; 2]>);

impl Curve {
    /// The first coordinate of the knee: of the point furthest below the straight line from the first to the last point, where
    /// the slope passes its mean. A curve that lies nowhere below that line has its knee at its end.
    #[must_use]
    pub fn knee(&self) -> f64 {
        let [end, top] = self.0.last().copied().unwrap_or_default();
        let below = |&[x, y]: &[f64; 2]| top * x / end - y;
        let deepest = self.0.iter().max_by(|a, b| below(a).total_cmp(&below(b)));
        deepest.filter(|point| below(point) > KNEE * top).map_or(end, |point| point[0])
    }
}

/// Measured curves; what has none keeps its stiffness.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Curves {
    /// Tension: [strain [1], force per width [N/m]] in place of `stiffness`, along warp and weft; in a network [strain, force of a link [N]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension: Option<Curve>,
    /// The same along the weft (the width of a grid) where it differs; `tension` then is that of the warp (its height).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_weft: Option<Curve>,
    /// Shear: [angle [rad], force per width [N/m]] in place of `shear_stiffness`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<Curve>,
    /// Bending: [curvature [1/m], moment per width [N m/m]] in place of `bending`; in a network [curvature, moment [N m]].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending: Option<Curve>,
}

impl Curves {
    /// lambda where the scene gives none: the least knee of the curves of tension [1].
    pub(super) fn knee(&self) -> Option<f64> {
        self.tension.iter().chain(&self.tension_weft).map(Curve::knee).reduce(f64::min)
    }
}

/// Refuses curves that are not measurements, and those that say the same as another field.
pub(super) fn check(at: &str, cloth: &Cloth) -> Result<(), SceneError> {
    let Some(curves) = &cloth.curves else { return Ok(()) };
    let Curves { tension, tension_weft, shear, bending } = curves;
    let named = [
        ("tension", tension, 1.0, "strain"),
        ("tension_weft", tension_weft, 1.0, "strain"),
        ("shear", shear, std::f64::consts::FRAC_PI_2, "angle [rad]"),
        ("bending", bending, 1e6, "curvature [1/m]"),
    ];
    for (name, curve, most, what) in named {
        if let Some(curve) = curve {
            check_curve(&format!("{at}.curves.{name}"), curve, most, what)?;
        }
    }
    let refuse = |name: &str, problem: &str| Err(SceneError::at(format!("{at}.curves.{name}"), problem));
    match (cloth.stiffness, cloth.shear_stiffness) {
        (Some(_), _) if tension.is_some() => refuse("tension", "says what stiffness says; leave one of them out"),
        (_, Some(_)) if shear.is_some() => refuse("shear", "says what shear_stiffness says; leave one of them out"),
        _ if bending.is_some() && cloth.bending() > 0.0 => {
            refuse("bending", "says what cloth.bending says; leave one of them out")
        }
        _ if bending.is_some() && cloth.bending_model == BendingModel::ChoiKo => {
            refuse("bending", "is for bending_model = \"quadratic\"; \"choi_ko\" needs one number, cloth.bending")
        }
        _ if tension.is_some() && cloth.bending_model == BendingModel::ChoiKo => {
            refuse("tension", "bending_model = \"choi_ko\" needs one stiffness under compression; use \"quadratic\"")
        }
        _ if tension_weft.is_some() && tension.is_none() => refuse("tension_weft", "needs tension, the curve along the warp"),
        _ if tension_weft.is_some() && cloth.grid.is_none() => {
            refuse("tension_weft", "needs a grid, whose width is the weft; elsewhere tension alone says it for all directions")
        }
        _ if shear.is_some() && cloth.network.is_some() => refuse("shear", "a network has no shear; leave it out"),
        _ => Ok(()),
    }
}

fn check_curve(at: &str, curve: &Curve, most: f64, what: &str) -> Result<(), SceneError> {
    let points = &curve.0;
    if !(2..=MOST_POINTS).contains(&points.len()) {
        let problem = format!("has {} points; give 2 to {MOST_POINTS}, as in [[0, 0], [0.03, 1.5], [0.05, 40]]", points.len());
        return Err(SceneError::at(at, problem));
    }
    let refuse = |index: usize, problem: String| {
        let [x, y] = points[index];
        Err(SceneError::with_value(format!("{at}[{index}]"), format!("[{x}, {y}]"), problem))
    };
    if points[0] != [0.0, 0.0] {
        return refuse(0, "a curve begins at [0, 0]; subtract the tare of the measurement".to_owned());
    }
    for (index, pair) in points.windows(2).enumerate() {
        let ([before, low], [x, y]) = (pair[0], pair[1]);
        if !(x - before >= APART * (1.0 - 1e-9) && x <= most) {
            return refuse(
                index + 1,
                format!("the {what} must increase by {APART:e} or more from point to point and be at most {most}"),
            );
        }
        if !(y >= low && y <= 1e9 && (y == 0.0 || y >= LEAST)) {
            let problem = format!(
                "the second number must be 0 or at least {LEAST:e}, and must not fall from point to point nor exceed 1e9; smooth the \
                 measurement"
            );
            return refuse(index + 1, problem);
        }
    }
    if points[points.len() - 1][1] == 0.0 {
        return refuse(
            points.len() - 1,
            "a curve that stays at 0 resists nothing; leave it out and set the stiffness to 0".to_owned(),
        );
    }
    Ok(())
}

/// Refuses a filter that has no use for curves.
pub(super) fn check_filter(scene: &Scene) -> Result<(), SceneError> {
    let curved = scene.cloth.iter().position(|cloth| cloth.curves.is_some());
    match curved {
        Some(index) if scene.solver.filter == FilterKind::Xpbd => {
            let problem = "its springs are constraints of one compliance each and follow no curve";
            let remedy = "choose another filter, such as \"coarse_to_fine\"";
            let problem = format!("{problem}, but cloth[{index}] has curves; {remedy}, or give stiffness");
            Err(SceneError::with_value("solver.filter", "\"xpbd\"", problem))
        }
        _ => Ok(()),
    }
}
