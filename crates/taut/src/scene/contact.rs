//! Whether cloths collide, and with what.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::body::{ROUGHEST, THICKEST};
use super::validate::{Check, constant, within};
use super::{Cloth, FilterKind, Scene, SceneError};

/// Cloths thinner than this [m] are a mistake in the units: single precision has no room between their sides.
const THINNEST: f64 = 1e-6;
/// Coulomb's coefficient of the friction of cloth on cloth [1], where a scene gives none.
const FRICTION: f64 = 0.3;
/// More layers of cloth than this on one another are a mistake.
const OUTERMOST: u32 = 1000;

/// What cloths collide with besides bodies.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contact {
    /// Whether cloths collide with themselves and with each other (true, false); when left out they do as soon as one of them is given a `thickness`.
    #[serde(rename = "self", skip_serializing_if = "Option::is_none")]
    pub self_contact: Option<bool>,
    /// Whether what intersects at the start is brought apart in the first frames (true, false): cloth inside of bodies goes out of them, of two cloths that cross the one with the higher `layer` to the outside; true when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub untangle: Option<bool>,
}

impl Scene {
    /// Whether anything can collide: there is a body, or cloths collide with themselves.
    #[must_use]
    pub fn has_contact(&self) -> bool {
        !self.body.is_empty() || self.self_contact()
    }

    /// Whether cloths collide with themselves and with each other: what `contact.self` says, else whether any cloth is given a
    /// thickness.
    #[must_use]
    pub fn self_contact(&self) -> bool {
        let said = self.contact.as_ref().and_then(|contact| contact.self_contact);
        said.unwrap_or_else(|| self.cloth.iter().any(|cloth| cloth.thickness.is_some()))
    }

    /// Whether what intersects at the start is brought apart: unless `contact.untangle` says no.
    #[must_use]
    pub fn untangles(&self) -> bool {
        self.contact.as_ref().and_then(|contact| contact.untangle).unwrap_or(true)
    }

    /// Writes out what was left to a default. Scenes in which nothing collides stay as they are.
    pub(super) fn fill_in_contact(&mut self) {
        let collides = self.has_contact();
        if self.contact.is_some() || collides {
            // First, as cloths without a given thickness are about to have one.
            self.contact = Some(Contact { self_contact: Some(self.self_contact()), untangle: Some(self.untangles()) });
        }
        if collides {
            for cloth in &mut self.cloth {
                cloth.thickness = Some(cloth.thickness());
                cloth.friction = Some(cloth.friction());
            }
        }
    }
}

impl Cloth {
    /// How far mid-surfaces are kept apart, given or of the preset [m].
    #[must_use]
    pub fn thickness(&self) -> f64 {
        self.material().thickness
    }

    /// Coulomb's coefficient of the friction of cloth on cloth [1].
    #[must_use]
    pub fn friction(&self) -> f64 {
        self.friction.unwrap_or(FRICTION)
    }
}

/// Refuses a thickness or a friction out of range.
pub(super) fn check_cloth(at: &str, cloth: &Cloth) -> Check {
    within(&format!("{at}.thickness"), cloth.thickness(), THINNEST, THICKEST, "0.001")?;
    within(&format!("{at}.layer"), f64::from(cloth.layer), 0.0, f64::from(OUTERMOST), "1")?;
    constant(&format!("{at}.friction"), cloth.friction(), ROUGHEST, "0.3")
}

/// Refuses a filter that knows nothing of contact.
pub(super) fn check_filter(scene: &Scene) -> Check {
    if !scene.has_contact() || scene.solver.filter == FilterKind::CoarseToFine {
        return Ok(());
    }
    let (what, remedy) = if scene.body.is_empty() {
        ("cloths collide with themselves (contact.self, or a cloth's thickness)", "set contact.self = false")
    } else {
        ("there are bodies to collide with (body[0])", "leave bodies and contact out")
    };
    let problem = format!("knows no contact, but {what}; must be \"coarse_to_fine\" here; choose it, or {remedy}");
    Err(SceneError::with_value("solver.filter", format!("\"{}\"", scene.solver.filter), problem))
}
