//! How a cloth resists bending.

use std::fmt;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// How a cloth resists bending.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BendingModel {
    /// A thin plate of Poisson's ratio 0 with a constant matrix (Bergou et al. 2006).
    Quadratic,
    /// Type 2 springs that push with the force of a buckled arc (Choi & Ko 2002).
    ChoiKo,
}

/// How much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bending {
    /// [N m]; in a network [N m^2].
    Given(f64),
    /// As the preset.
    Fabric,
}

impl Serialize for Bending {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Given(stiffness) => serializer.serialize_f64(*stiffness),
            Self::Fabric => serializer.serialize_str("fabric"),
        }
    }
}

impl<'de> Deserialize<'de> for Bending {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Bending;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"fabric\" or a number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Bending, E> {
                if text == "fabric" { Ok(Bending::Fabric) } else { Err(E::invalid_value(de::Unexpected::Str(text), &self)) }
            }

            fn visit_f64<E: de::Error>(self, stiffness: f64) -> Result<Bending, E> {
                Ok(Bending::Given(stiffness))
            }

            fn visit_u64<E: de::Error>(self, stiffness: u64) -> Result<Bending, E> {
                Ok(Bending::Given(stiffness as f64))
            }

            fn visit_i64<E: de::Error>(self, stiffness: i64) -> Result<Bending, E> {
                Ok(Bending::Given(stiffness as f64))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Bending {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Bending".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [{ "const": "fabric" }, { "type": "number", "minimum": 0 }] })
    }
}
