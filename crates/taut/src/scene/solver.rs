//! How a scene is simulated.

use std::fmt;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// How a scene is simulated.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solver {
    /// Steps per frame [1]: "auto" (from the stability bound; with "coarse_to_fine", whose steps springs and dampers divide further, from accuracy and drag) or a number.
    pub substeps: Substeps,
    /// Allow a step over the stability bound (true, false).
    pub force_step: bool,
    /// How velocities and positions advance: "euler" (the paper's, velocity first; where "coarse_to_fine" divides a step, leapfrog inside it), "forward_euler" (to show why not), "midpoint", "rk4", "verlet", "implicit_euler" or "bdf2".
    pub integrator: IntegratorKind,
    /// What limits the stretch: "coarse_to_fine" (no spring over its limit, ever), "sweeps", "sequential" (the paper's steps 1 to 6 to the letter), "provot", "rods", "fast_projection", "tethers", "xpbd" or "none".
    pub filter: FilterKind,
    /// Most passes (cycles of "coarse_to_fine", solves of "fast_projection") in one step [1]; when left out: 200, of "fast_projection" 10, of "provot", "tethers" and "xpbd" 1.
    pub iterations: Option<u32>,
    /// "sweeps" and "rods" stop early once no spring is off its limit, or its length, by more than this fraction of it [1].
    pub tolerance: f64,
    /// Where everything lies still nothing is computed until something from outside changes (true, false): what games want. Steps are then told as "asleep".
    pub sleep: bool,
    /// "sweeps" leaves out what a pass could not change, with the same result: true, or false to measure what that saves.
    pub local_correction: bool,
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            substeps: Substeps::Auto,
            force_step: false,
            integrator: IntegratorKind::Euler,
            filter: FilterKind::CoarseToFine,
            iterations: None,
            tolerance: 1e-3,
            sleep: false,
            local_correction: true,
        }
    }
}

impl Solver {
    /// Most passes of the filter in one step [1].
    #[must_use]
    pub fn iterations(&self) -> u32 {
        self.iterations.unwrap_or(match self.filter {
            // What their authors do; more passes are another method.
            FilterKind::Provot | FilterKind::Tethers | FilterKind::Xpbd => 1,
            // Converges quadratically.
            FilterKind::FastProjection => 10,
            _ => 200,
        })
    }
}

/// Display says the word that a scene file has for it.
macro_rules! says_its_word {
    ($($kind:ty)*) => {
        $(impl fmt::Display for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.serialize(f)
            }
        })*
    };
}

says_its_word! { IntegratorKind FilterKind }

/// How velocities and positions advance.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorKind {
    /// Velocity first, position with the new velocity (paper, section 3; symplectic Euler today).
    Euler,
    /// Position with the old velocity: vibrations grow.
    ForwardEuler,
    /// The explicit midpoint method, order 2: vibrations grow slowly.
    Midpoint,
    /// The classical Runge-Kutta method, order 4.
    Rk4,
    /// Velocity Verlet, order 2.
    Verlet,
    /// Linearised backward Euler (Baraff & Witkin 1998): stable at any step, and damps.
    ImplicitEuler,
    /// The second-order backward differences of Choi & Ko 2002: stable at any step, damps less.
    Bdf2,
}

impl IntegratorKind {
    /// Whether the state has to carry the last step.
    #[must_use]
    pub fn remembers(self) -> bool {
        self == Self::Bdf2
    }

    /// Whether the stability of springs, bending and dampers does not bound the step.
    #[must_use]
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::ImplicitEuler | Self::Bdf2)
    }
}

impl Solver {
    /// Whether V may be another velocity than that of the motion after a step. Without a filter it is not. The backward Euler method
    /// and the undivided forward one of the paper move particles by h V, and a filter keeps that up; all others divide what forces do
    /// between two steps, but not what a filter does (docs/equations.md, "Velocities of the motion").
    #[must_use]
    pub fn tells_motion_apart(&self) -> bool {
        match self.integrator {
            IntegratorKind::Euler => self.filter == FilterKind::CoarseToFine,
            IntegratorKind::ImplicitEuler => false,
            _ => self.filter != FilterKind::None,
        }
    }

    /// Whether the filter takes cycles, of which a calm cloth keeps the number.
    #[must_use]
    pub fn takes_cycles(&self) -> bool {
        self.filter == FilterKind::CoarseToFine
    }
}

/// What turns proposed velocities into admissible ones.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FilterKind {
    /// Nothing: the bare mass-spring cloth, which over-stretches.
    None,
    /// The paper's steps 1 to 6 to the letter (section 3).
    Sequential,
    /// Repeated symmetric, mass-weighted projections.
    Sweeps,
    /// The coarse-to-fine velocity constraint: every spring within its limit after every step.
    CoarseToFine,
    /// Positions of over-stretched springs are corrected, one spring after the other, half by each end (Provot 1995).
    Provot,
    /// Rigid rods in place of the structural springs, by repeated projections (after Li & Xiu 2006).
    Rods,
    /// Inextensible warp and weft, by Newton steps with a sparse factorisation (Goldenthal et al. 2007).
    FastProjection,
    /// No particle further from its nearest pins than along the cloth (Kim, Chentanez & Müller-Fischer 2012).
    Tethers,
    /// Compliant springs that turn rigid at the limit, one pass a step (Macklin et al. 2019).
    Xpbd,
}

/// Steps per frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Substeps {
    /// From the stability bound of springs and damping.
    Auto,
    /// A given number per frame.
    Count(u32),
}

impl Serialize for Substeps {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Count(count) => serializer.serialize_u32(*count),
        }
    }
}

impl<'de> Deserialize<'de> for Substeps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Substeps;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"auto\" or a whole number of at least 1")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Substeps, E> {
                if text == "auto" { Ok(Substeps::Auto) } else { Err(E::invalid_value(de::Unexpected::Str(text), &self)) }
            }

            fn visit_u64<E: de::Error>(self, count: u64) -> Result<Substeps, E> {
                u32::try_from(count)
                    .ok()
                    .filter(|&count| count >= 1)
                    .map(Substeps::Count)
                    .ok_or_else(|| E::invalid_value(de::Unexpected::Unsigned(count), &self))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Substeps {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Substeps".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [{ "const": "auto" }, { "type": "integer", "minimum": 1 }] })
    }
}
