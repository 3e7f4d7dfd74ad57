//! What bodies feel besides fluid and weight, as far as it lasts.
//!
//! The pressure is solved for together with the velocities of the bodies. So it has to know what
//! else pushes them: a grain that lies on the ground would otherwise fall anew in each step, and
//! take the fluid along. Nobody tells the fluid of contacts. But it sees what they did: of the
//! change of a body's velocity in a window, what its own load and the weight do not explain. A
//! force that was there in the last two windows is taken to be there in the next; a blow is not.

use serde::{Deserialize, Serialize};

/// A body's motion and what the fluid knows of it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct LastingForce {
    /// Velocity when the window began [m/s].
    velocity: [f64; 3],
    /// What the fluid's load and the weight were expected to change it by [m/s].
    expected: Option<[f64; 3]>,
    /// Acceleration that they do not explain, in the last window and the one before [m/s²].
    unexplained: [Option<[f64; 3]>; 2],
}

impl LastingForce {
    /// Takes the velocity at the end of a window of length `dt` [s].
    pub fn see(&mut self, velocity: [f64; 3], dt: f64) {
        if let Some(expected) = self.expected {
            let change =
                std::array::from_fn(|a| (velocity[a] - self.velocity[a] - expected[a]) / dt);
            self.unexplained = [Some(change), self.unexplained[0]];
        }
        self.velocity = velocity;
    }

    /// Notes what the fluid's load and the weight will do in the next window [m/s].
    pub fn expect(&mut self, change: [f64; 3]) {
        self.expected = Some(change);
    }

    /// The acceleration that lasts [m/s²]: of the last two the smaller, where they agree in sign.
    pub fn acceleration(&self) -> [f64; 3] {
        let [Some(last), Some(before)] = self.unexplained else { return [0.0; 3] };
        std::array::from_fn(|a| {
            if last[a] * before[a] <= 0.0 {
                0.0
            } else if last[a].abs() < before[a].abs() {
                last[a]
            } else {
                before[a]
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lasts_is_expected_and_a_blow_is_not() {
        let mut body = LastingForce::default();
        let (dt, weight) = (0.1, [0.0, 0.0, -0.981]);
        body.see([0.0; 3], dt);
        for _ in 0..2 {
            assert_eq!(body.acceleration(), [0.0; 3]);
            body.expect(weight);
            // It lies on the ground.
            body.see([0.0; 3], dt);
        }
        assert!((body.acceleration()[2] - 9.81).abs() < 1e-12);
        body.expect(weight);
        // Something pulls it up, once.
        body.see([0.0, 0.0, 1.0], dt);
        assert!((body.acceleration()[2] - 9.81).abs() < 1e-12);
        // Then it flies.
        body.expect(weight);
        body.see([0.0, 0.0, 1.0 - 0.981], dt);
        assert!(body.acceleration()[2].abs() < 1e-12);
    }
}
