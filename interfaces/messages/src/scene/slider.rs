//! Parts that move along one axis under forces: valves, pistons on springs, gates.

use serde::{Deserialize, Serialize};

/// One degree of freedom: a mass on an axis, with a spring and stops.
///
/// ```text
/// M y'' = (fluid + grains + M g).axis - spring(y) + stops(y, y') + force
/// ```
///
/// y is the lift. The part does not turn. Symmetry planes cut a part if the origin of its frame
/// lies on them. Mass, spring, force and stops are then of the whole part, and loads count the
/// mirrored half too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slider {
    /// Direction of growing lift, of any length but zero.
    pub axis: [f64; 3],
    /// Mass of all that moves [kg].
    pub mass: f64,
    /// Lift at the start [m]: that of the part's pose in the scene.
    pub lift: f64,
    /// Velocity at the start, along the axis [m/s].
    pub velocity: f64,
    /// The spring, whose force is against the axis.
    pub spring: SliderSpring,
    /// Constant force along the axis, besides the weight [N].
    pub force: f64,
    /// Stops that bound the travel, if there are any.
    pub stops: Option<Stops>,
}

/// Force of a spring against the axis, by the lift y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SliderSpring {
    /// None.
    None,
    /// `preload + rate y`.
    Linear {
        /// Stiffness [N/m].
        rate: f64,
        /// Force at lift 0 [N].
        preload: f64,
    },
    /// `preload + rate (2 a/pi) tan(pi y/(2 a))`, a the stroke: coils that close one by one
    /// (Mutabaruka & Kamrin, *Comput. Part. Mech.* 5, 2018). From where the tangent stiffness
    /// exceeds that of the stops on, the force goes on as a straight line of that stiffness.
    Tangent {
        /// Stiffness at lift 0 [N/m].
        rate: f64,
        /// Force at lift 0 [N].
        preload: f64,
        /// Lift at which no travel is left [m].
        stroke: f64,
    },
    /// Points `[lift, force]` [m, N], lifts ascending, linear between them.
    Table(Vec<[f64; 2]>),
}

/// Ends of the travel: each a contact of the one mass, with a linear spring, and a dashpot that
/// does not pull.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stops {
    /// Lift at which the lower one touches [m].
    pub lower: Option<f64>,
    /// Lift at which the upper one touches [m].
    pub upper: Option<f64>,
    /// Stiffness [N/m].
    pub stiffness: f64,
    /// Coefficient of restitution, in (0, 1].
    pub restitution: f64,
}
