//! What boundaries prescribe at a time, in lattice units.

use crate::lattice::CS2;
use crate::units::Units;
use tremie_messages::scene::{Course, Face, PartBoundary, Profile};

/// What a boundary prescribes.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// No slip at a wall with this velocity.
    Wall([f64; 3]),
    /// The fluid has this velocity.
    Velocity {
        /// Velocity, at the middle of a profile.
        velocity: [f64; 3],
        /// How it varies over a face.
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
    /// The density follows from the flow: see `reservoir`.
    Reservoir,
}

impl Law {
    /// Of a face; `None` for one that prescribes nothing.
    pub fn of_face(face: &Face, units: &Units) -> Option<Self> {
        match face {
            Face::Periodic | Face::Symmetry => None,
            Face::Wall { velocity } => Some(Self::Wall(velocity.map(|v| v / units.velocity()))),
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
            PartBoundary::Wall => Self::Wall([0.0; 3]),
            PartBoundary::Velocity { velocity, course } => Self::Velocity {
                velocity: velocity.map(|v| v / units.velocity()),
                profile: Profile::Uniform,
                course: course.clone(),
            },
            PartBoundary::Pressure { pressure, course } => Self::density(*pressure, course, units),
        }
    }

    fn density(pressure: f64, course: &Course, units: &Units) -> Self {
        Self::Density { drho: pressure / units.pressure() / CS2, course: course.clone() }
    }

    /// What holds at a time [s]; `None` where that depends on the flow.
    pub fn at(&self, time: f64) -> Option<Now> {
        Some(match self {
            Self::Wall(velocity) => Now::Wall(*velocity),
            Self::Velocity { velocity, course, .. } => {
                Now::Wall(velocity.map(|v| v * course.at(time)))
            }
            Self::Density { drho, course } => Now::Density(drho * course.at(time)),
            Self::Reservoir => return None,
        })
    }
}

/// What a boundary prescribes now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Now {
    /// This velocity.
    Wall([f64; 3]),
    /// This density, less 1.
    Density(f64),
}
