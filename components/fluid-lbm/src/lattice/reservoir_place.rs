//! Where a reservoir is.

use std::fmt;
use tremie_fluid_kit::cells::grid::face_name;
use tremie_messages::scene::Scene;

/// Through what a reservoir's fluid comes. Displayed as the manifest calls it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReservoirPlace {
    /// A face of the domain.
    Face {
        /// Axis that the face is across, 0, 1, 2 for x, y, z.
        axis: usize,
        /// 0 for the lower, 1 for the upper face.
        side: usize,
    },
    /// The surface of a part, by index among the scene's parts.
    Part(usize),
}

impl Default for ReservoirPlace {
    fn default() -> Self {
        Self::Face { axis: 0, side: 0 }
    }
}

impl fmt::Display for ReservoirPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Face { axis, side } => write!(f, "{}", face_name(axis, side)),
            Self::Part(index) => write!(f, "scene.parts[{index}]"),
        }
    }
}

impl ReservoirPlace {
    /// Key of the manifest that says what the reservoir is.
    pub fn key(&self) -> String {
        match *self {
            Self::Face { axis, side } => format!("scene.domain.faces.{}", face_name(axis, side)),
            Self::Part(index) => format!("scene.parts[{index}].boundary"),
        }
    }

    /// Name by which signals know it.
    pub fn name(&self, scene: &Scene) -> String {
        match *self {
            Self::Face { axis, side } => face_name(axis, side).to_string(),
            Self::Part(index) => scene.parts[index].name.clone(),
        }
    }
}
