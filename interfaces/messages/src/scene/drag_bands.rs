//! Boxes in which grains are braked, as recycled ones are above a bed.

use serde::{Deserialize, Serialize};

/// A box in which a drag acts on grains, so that their fall tends to a terminal speed.
///
/// In a domain that is periodic along the flow, grains that left at the bottom come in again at the
/// top and would fall onto the bed at speed. In the band each free body whose centre lies in the box
/// feels `F = -(m g / v_T^2) |v| v` (Goetsch, thesis, Iowa State University, 2015, sec. 3.2.5, with the constant by
/// which weight and drag balance at `v_T`), where `g` is the strength of gravity and `v` its
/// velocity in the world's frame. It acts at the centre and turns nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DragBand {
    /// Name, unique in the scene; signals are `NAME.momentum_removed_x` and so on.
    pub name: String,
    /// Lower corner [m]; it belongs to the box.
    pub min: [f64; 3],
    /// Upper corner [m]; it does not.
    pub max: [f64; 3],
    /// Speed `v_T` at which drag and weight balance [m/s].
    pub terminal_speed: f64,
}
