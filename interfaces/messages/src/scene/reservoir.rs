//! A reservoir that a piston empties, without its space being simulated.

use super::course::Course;
use serde::{Deserialize, Serialize};

/// A cylinder beyond a face of the domain, or behind the surface of a part, closed by a piston.
///
/// Of its fluid only the mass is followed: density and pressure are the same everywhere in it. So
/// times must be long beside the time that sound takes from piston to face, and there is no
/// friction. Only the ratio `volume/area` enters the physics: a model cut by symmetry planes takes
/// the area and the volume of the whole, or of its part, with the same result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reservoir {
    /// Area of the piston, which is that of the fluid at the face or surface [m²].
    pub area: f64,
    /// Volume between piston and face at time zero [m³].
    pub volume: f64,
    /// Velocity of the piston towards the domain [m/s].
    pub piston: f64,
    /// Factor on that velocity over time.
    pub course: Course,
    /// Time from which on the piston stands still [s].
    #[serde(default)]
    pub stop: Option<f64>,
    /// Part of its difference from the face's mean that a cell's normal velocity loses in a step,
    /// from 0 to 1. Without any, velocities along a wide face may run away from each other.
    #[serde(default = "Reservoir::default_relaxation")]
    pub relaxation: f64,
    /// Balance of the reservoir's mass.
    #[serde(default)]
    pub mode: ReservoirMode,
}

/// Balance of the mass of a reservoir.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReservoirMode {
    /// The reservoir loses the mass that the fluid gains, to rounding.
    #[default]
    Conservative,
    /// The reservoir's density follows from the velocity at the face, as published (Mutabaruka &
    /// Kamrin, Eq. 30).
    /// Unstable for short reservoirs of nearly inviscid fluid: kept to show that.
    Mk,
}

impl Reservoir {
    /// Default relaxation.
    pub const RELAXATION: f64 = 0.02;

    fn default_relaxation() -> f64 {
        Self::RELAXATION
    }

    /// With a piston that has moved at one velocity [m/s] since time zero.
    pub fn new(area: f64, volume: f64, piston: f64) -> Self {
        Self {
            area,
            volume,
            piston,
            course: Course::default(),
            stop: None,
            relaxation: Self::RELAXATION,
            mode: ReservoirMode::default(),
        }
    }

    /// Velocity of the piston at a time [s], towards the domain [m/s].
    pub fn piston_at(&self, time: f64) -> f64 {
        if self.stop.is_some_and(|stop| time >= stop) {
            return 0.0;
        }
        self.piston * self.course.at(time)
    }

    /// Length of the cylinder at time zero, volume over area [m].
    pub fn length(&self) -> f64 {
        self.volume / self.area
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piston_ramps_and_stops() {
        let reservoir = Reservoir {
            course: Course::Points(vec![[0.0, 0.0], [1.0, 1.0]]),
            stop: Some(3.0),
            ..Reservoir::new(2.0, 8.0, 6.0)
        };
        assert_eq!([0.5, 2.0, 3.0].map(|t| reservoir.piston_at(t)), [3.0, 6.0, 0.0]);
        assert_eq!(reservoir.length(), 4.0);
    }

    #[test]
    fn what_is_left_out_has_a_default() {
        let text = r#"{"area":2.0,"volume":8.0,"piston":6.0,"course":{"points":[]}}"#;
        let read: Reservoir = serde_json::from_str(text).unwrap();
        assert_eq!(read, Reservoir::new(2.0, 8.0, 6.0));
    }
}
