//! Values with a short and a long form. They are read by hand: serde's untagged enums forget
//! which key inside them was wrong.

use super::ComponentTable;
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize, de};
use std::fmt;
use tremie_messages::units::Length;

/// A component: its program, or all about it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum ComponentEntry {
    /// The program alone.
    Program(String),
    /// All about it.
    Table(ComponentTable),
}

impl ComponentEntry {
    /// The long form of it.
    pub fn table(&self) -> ComponentTable {
        match self {
            Self::Program(program) => {
                ComponentTable { program: Some(program.clone()), ..ComponentTable::default() }
            }
            Self::Table(table) => table.clone(),
        }
    }
}

impl<'de> Deserialize<'de> for ComponentEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = ComponentEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a program or a table")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ComponentEntry, E> {
                Ok(ComponentEntry::Program(text.to_string()))
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<ComponentEntry, A::Error> {
                ComponentTable::deserialize(MapAccessDeserializer::new(map))
                    .map(ComponentEntry::Table)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A diameter, or the bounds of a uniform distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum DiameterEntry {
    /// One for all.
    One(Length),
    /// Smallest and largest.
    Between([Length; 2]),
}

impl DiameterEntry {
    /// Smallest and largest.
    pub fn bounds(self) -> [Length; 2] {
        match self {
            Self::One(diameter) => [diameter, diameter],
            Self::Between(bounds) => bounds,
        }
    }
}

impl<'de> Deserialize<'de> for DiameterEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = DiameterEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a length with a unit, as \"1 mm\", or two of them, as [\"1 mm\", \"2 mm\"]",
                )
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<DiameterEntry, E> {
                text.parse().map(DiameterEntry::One).map_err(E::custom)
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<DiameterEntry, A::Error> {
                <[Length; 2]>::deserialize(SeqAccessDeserializer::new(seq))
                    .map(DiameterEntry::Between)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
