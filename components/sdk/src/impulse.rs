//! Impulse that crosses between fluid and grains, summed on both sides in the same order.
//!
//! What the fluid delivered through window `k` equals what the grains received through window
//! `k + 1`, bit for bit: the loads of a window are applied in the next one.

use tremie_messages::Load;
use tremie_messages::start::{Description, Signal};

/// Impulse that has crossed so far, world frame [N s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse([f64; 3]);

impl Impulse {
    /// Adds that of `loads` that act for `window` seconds.
    pub fn add(&mut self, loads: &[Load], window: f64) {
        let mut force = [0.0; 3];
        for load in loads {
            for axis in 0..3 {
                force[axis] += load.force[axis];
            }
        }
        for axis in 0..3 {
            self.0[axis] += force[axis] * window;
        }
    }

    /// Pushes the three components.
    pub fn push(&self, values: &mut Vec<f64>) {
        values.extend(self.0);
    }

    /// Adds the three signals to a description.
    pub fn announce(mut description: Description, name: &str) -> Description {
        for axis in ["x", "y", "z"] {
            let name = format!("{name}_{axis}");
            description.signals.push(Signal { name, unit: "N s".into() });
        }
        description
    }
}
