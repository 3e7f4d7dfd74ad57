//! The manifest's table of watchdogs.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::fmt;

/// Limits of quantities that tell whether the physics goes wrong. Above a limit the run stops; some
/// way below it makes a checkpoint. Each is a number, or `"off"`. `tremie check` says which hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct WatchTable {
    /// Largest Mach number of the fluid: of a lattice over the lattice's speed of sound (default:
    /// `mach_limit` of `fluid-lbm`), of a gas over its own (default: 20).
    pub mach: Option<WatchEntry>,
    /// Largest relative deviation of the fluid's density: of a lattice from the density of the
    /// manifest (default: 0.5), of a gas from the range that it has at the start (default: 200).
    pub density: Option<WatchEntry>,
    /// Deepest overlap of grains since the start, over the smaller radius (default: 0.5).
    pub overlap: Option<WatchEntry>,
    /// Way of the fastest thing in a step: of a particle of fluid in cells (default: 20), of a grain
    /// in smallest radii (default: 1 for `grains-dem`, 2 for `grains-hard-sphere`).
    pub speed: Option<WatchEntry>,
    /// Share of the mass or volume of the fluid that the method lost or made (default: 0.2 for
    /// `fluid-pic`, else 0.1).
    pub mass: Option<WatchEntry>,
    /// Share of the energy at the start that the method made or lost, in scenes in which nothing
    /// gives or takes any (default: 1 for grains, 0.1 for a gas).
    pub energy: Option<WatchEntry>,
    /// Compression of a seal over the largest of its table (default: 0.99).
    pub compression: Option<WatchEntry>,
}

impl WatchTable {
    /// True if nothing is given.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A limit, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum WatchEntry {
    /// Above it the run stops.
    Limit(f64),
    /// The quantity is not watched.
    Off,
}

const OFF: &str = "off";

impl Serialize for WatchEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Limit(limit) => serializer.serialize_f64(*limit),
            Self::Off => serializer.serialize_str(OFF),
        }
    }
}

impl<'de> Deserialize<'de> for WatchEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EntryVisitor)
    }
}

struct EntryVisitor;

impl de::Visitor<'_> for EntryVisitor {
    type Value = WatchEntry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number above zero, or \"off\"")
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<WatchEntry, E> {
        Ok(WatchEntry::Limit(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<WatchEntry, E> {
        Ok(WatchEntry::Limit(value as f64))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<WatchEntry, E> {
        Ok(WatchEntry::Limit(value as f64))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<WatchEntry, E> {
        match text {
            OFF => Ok(WatchEntry::Off),
            _ => Err(E::custom(format!(
                "found \"{text}\", expected a number above zero, or \"off\""
            ))),
        }
    }
}

impl JsonSchema for WatchEntry {
    fn schema_name() -> Cow<'static, str> {
        "WatchEntry".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, { "const": OFF }],
        })
    }
}
