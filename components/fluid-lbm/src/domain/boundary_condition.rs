//! Velocities and densities that boundaries prescribe at a time, in lattice units.

use crate::lattice::d3q19::CS2;
use crate::lattice::units::Units;
use tremie_messages::scene::{Course, Face, PartBoundary, Profile};

/// Condition that a boundary prescribes over the whole run [lattice units].
#[derive(Clone, Debug, PartialEq)]
pub enum BoundaryCondition {
    /// No slip at a wall.
    Wall {
        /// Its velocity.
        velocity: [f64; 3],
        /// Factor over time [s].
        course: Course,
    },
    /// The fluid has this velocity.
    Velocity {
        /// Velocity, at the middle of a profile.
        velocity: [f64; 3],
        /// Variation over a face.
        profile: Profile,
        /// Factor over time [s].
        course: Course,
    },
    /// The fluid has this density, less 1.
    Density {
        /// Density minus 1.
        drho: f64,
        /// Factor over time [s].
        course: Course,
    },
    /// The density follows from the flow: see `face` and `part_surface`.
    Reservoir,
}

impl BoundaryCondition {
    /// A wall that never moves.
    pub const AT_REST: Self = Self::Wall { velocity: [0.0; 3], course: Course::CONSTANT };

    /// True if it is a wall that never moves.
    pub fn is_at_rest(&self) -> bool {
        matches!(self, Self::Wall { velocity: [0.0, 0.0, 0.0], .. })
    }

    /// Of a face; `None` for one that prescribes nothing.
    pub fn of_face(face: &Face, units: &Units) -> Option<Self> {
        match face {
            Face::Periodic | Face::Symmetry => None,
            Face::Wall { velocity, course } => Some(Self::Wall {
                velocity: velocity.map(|v| v / units.velocity()),
                course: course.clone(),
            }),
            Face::Velocity(open) => Some(Self::Velocity {
                velocity: open.velocity.map(|v| v / units.velocity()),
                profile: open.profile,
                course: open.course.clone(),
            }),
            Face::Pressure { pressure, course, .. } => {
                Some(Self::density(*pressure, course, units))
            }
            Face::Reservoir(_) => Some(Self::Reservoir),
        }
    }

    /// Of a part at rest.
    pub fn of_part(boundary: &PartBoundary, units: &Units) -> Self {
        match boundary {
            PartBoundary::Wall => Self::AT_REST,
            PartBoundary::Velocity { velocity, course } => Self::Velocity {
                velocity: velocity.map(|v| v / units.velocity()),
                profile: Profile::Uniform,
                course: course.clone(),
            },
            PartBoundary::Pressure { pressure, course } => Self::density(*pressure, course, units),
            PartBoundary::Reservoir(_) => Self::Reservoir,
        }
    }

    fn density(pressure: f64, course: &Course, units: &Units) -> Self {
        Self::Density { drho: pressure / units.pressure() / CS2, course: course.clone() }
    }

    /// Value in a step that ends at `end` [s] and took `step` [s]; `None` where it depends on the
    /// flow. A wall's value is that of the middle of the step, when links are reflected at it;
    /// cells at open faces are set at the end of the step.
    pub fn in_step(&self, end: f64, step: f64) -> Option<BoundaryValue> {
        Some(match self {
            Self::Wall { velocity, course } => {
                let factor = course.at(end - 0.5 * step);
                BoundaryValue::Wall(velocity.map(|v| v * factor))
            }
            Self::Velocity { velocity, course, .. } => {
                let factor = course.at(end);
                BoundaryValue::Wall(velocity.map(|v| v * factor))
            }
            Self::Density { drho, course } => BoundaryValue::Density(drho * course.at(end)),
            Self::Reservoir => return None,
        })
    }
}

/// Value that a boundary prescribes in a step [lattice units].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoundaryValue {
    /// This velocity.
    Wall([f64; 3]),
    /// This density, less 1.
    Density(f64),
}
