//! Impulse that crosses between fluid and grains, summed on both sides in the same order.
//!
//! The impulse that the fluid delivered through window `k` equals that which the grains received
//! through window `k + 1`, bit for bit: the loads of a window are applied in the next one.

use serde::{Deserialize, Serialize};
use tremie_messages::Load;
use tremie_messages::start::{Description, Signal};

/// Impulse that has crossed so far, world frame [N s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
            let meaning = "impulse of the loads of the fluid on all bodies since the start".into();
            description.signals.push(Signal { name, unit: "N s".into(), meaning, sampled: false });
        }
        description
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_sum_to_the_same_bits_one_window_apart() {
        let loads = |window: u64| -> Vec<Load> {
            let force = |id: u64| [0.1 * id as f64, 1.0 / (window + id + 1) as f64, -3.3e-7];
            (0..50).map(|id| Load { id, force: force(id), torque: [0.0; 3] }).collect()
        };
        let (mut delivered, mut received) = (Impulse::default(), Impulse::default());
        for window in 0..20 {
            delivered.add(&loads(window), 1.2e-7);
            if window > 0 {
                received.add(&loads(window - 1), 1.2e-7);
            }
            let mut last = Impulse::default();
            (0..window).for_each(|w| last.add(&loads(w), 1.2e-7));
            assert_eq!(received, last);
        }
        received.add(&loads(19), 1.2e-7);
        assert_eq!(delivered, received);
    }
}
