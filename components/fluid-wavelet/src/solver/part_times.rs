//! Where the time of a step goes. It is for benchmarks: nothing in a run depends on it.

use std::time::Duration;

/// Time of the parts of all steps so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct PartTimes {
    /// All steps.
    pub steps: Duration,
    /// Adaptation of the grid.
    pub adaptation: Duration,
    /// Adaptations that were looked at, whether the grid changed or not.
    pub adaptations: u32,
    /// The transform: parents from children, ghosts from neighbours and parents.
    pub transform: Duration,
    /// Rates of change of all points: the right-hand side.
    pub rates: Duration,
    /// Right-hand sides, three a step.
    pub right_hand_sides: u32,
    /// Bodies: which points they hold, and what those hold.
    pub bodies: Duration,
}

impl PartTimes {
    /// Shares of adaptation, transform, rates and bodies in the time of the steps.
    pub fn shares(&self) -> [f64; 4] {
        let parts = [self.adaptation, self.transform, self.rates, self.bodies];
        parts.map(|part| part.as_secs_f64() / self.steps.as_secs_f64())
    }

    /// Time of one adaptation over that of one right-hand side, the transform after it included.
    pub fn adaptation_over_rates(&self) -> f64 {
        let one = (self.rates + self.transform).as_secs_f64() / f64::from(self.right_hand_sides);
        self.adaptation.as_secs_f64() / f64::from(self.adaptations) / one
    }
}
