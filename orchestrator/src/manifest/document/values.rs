//! Values with a short and a long form.

use super::ComponentTable;
use super::forms::{Form, Never, read, read_by_form};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};
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

read_by_form!(ComponentEntry: "the name of a program or a table", Word => Program, Table => Table);

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

read_by_form!(DiameterEntry: "a length with a unit, as \"1 mm\", or two of them, as [\"1 mm\", \"2 mm\"]", Word => One, List => Between);

/// What one unit of a file is: `"mm"`, or a length as `"25.4 mm"`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub(in super::super) struct FileUnit(pub Length);

impl<'de> Deserialize<'de> for FileUnit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expecting = "a unit of length, as \"mm\", or a length, as \"25.4 mm\"";
        let form: Form<String, Never, Never> = read(deserializer, expecting)?;
        let text = match form {
            Form::Word(text) => text,
            Form::List(never) | Form::Table(never) => match never {},
        };
        let length = text.parse().or_else(|_| format!("1 {}", text.trim()).parse());
        length
            .map(Self)
            .map_err(|_| de::Error::custom(format!("found \"{text}\", expected {expecting}")))
    }
}

impl JsonSchema for FileUnit {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FileUnit".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": "string",
            "description": "a unit of length, or a length",
            "examples": ["mm", "m", "25.4 mm"],
        })
    }
}
