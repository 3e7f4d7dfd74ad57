//! Numerical parameters of the solver, as a user may set them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Time, Velocity};

/// Numerical parameters of hard spheres; everything physical stands in the scene, of whose contact
/// laws these grains take restitution and friction.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Time step; unset: the time in which the expected speed takes a body a tenth of the smallest
    /// radius. From event to event it only says how often others hear of the bodies.
    pub time_step: Option<Time>,
    /// Largest relative speed of two bodies that the user expects. Unset: twice the fastest speed
    /// at the start and what a fall through the domain adds.
    pub expected_speed: Option<Velocity>,
    /// How collisions are found.
    pub detection: Detection,
    /// Guard against inelastic collapse (TC model): a collision is elastic if either body collided
    /// less than this time before. Results must not change when it is halved. Unset: a
    /// hundred-thousandth of the time in which the expected speed takes a body its smallest
    /// diameter.
    pub contact_time: Option<Time>,
    /// Guard against inelastic collapse under weight: slower impacts are elastic. Unset: the speed
    /// of a fall through a ten-millionth of the smallest diameter; 0 without gravity.
    pub elastic_speed: Option<Velocity>,
    /// Coefficient of tangential restitution of contacts that do not slide, from -1 to 1: 0 where
    /// surfaces stick, 1 where perfectly rough ones give back all.
    pub tangential_restitution: f64,
    /// Most collisions of a body in a time step that are resolved. A body that has more stays where
    /// it is until the step ends, and is counted by the signal `crowded`.
    pub most_collisions: u16,
}

/// How collisions are found.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Detection {
    /// From event to event where nothing but weight acts between collisions: no fluid, nothing that
    /// moves as prescribed. Else from step to step.
    #[default]
    Auto,
    /// From event to event: each collision at its time, none missed.
    Events,
    /// From step to step: overlaps at the end of a step are taken back to the moment of touch.
    Steps,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            time_step: None,
            expected_speed: None,
            detection: Detection::Auto,
            contact_time: None,
            elastic_speed: None,
            tangential_restitution: 0.0,
            most_collisions: 100,
        }
    }
}
