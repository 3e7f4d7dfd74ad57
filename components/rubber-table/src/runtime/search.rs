//! Search for the next trial of a step.
//!
//! The excess r(d) = F(d) - h(d) - ν (d - d0)/dt falls as the ring retreats, at least by h' + ν/dt
//! for each metre, and by jumps where a contact opens: a dashpot pushes up to the end. A secant
//! finds its zero in a few passes; what two trials on either side have between them is halved where
//! that does not shrink fast, and so even a jump is found, which no pass of a fixed size settles
//! on.

/// Slopes of the excess downwards [N/m].
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    /// Of table and damping alone: contacts only add to it.
    pub least: f64,
    /// With the contacts at the start of the step.
    pub first: f64,
}

/// Findings of the passes of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    slopes: Slopes,
    /// Largest trial that must retreat further, smallest that must not [m].
    below: f64,
    above: f64,
    /// Trial [m] and excess [N] of the pass before.
    before: Option<[f64; 2]>,
    /// Distance between the two of before, once and twice.
    widths: [f64; 2],
}

impl Search {
    /// Nothing is known but the slopes.
    pub fn new(slopes: Slopes) -> Self {
        let far = f64::INFINITY;
        Self { slopes, below: -far, above: far, before: None, widths: [far; 2] }
    }

    /// The trial after the one at `trial` [m], which had this `excess` [N], and how far it may
    /// still be from the zero [m]: by the slope of the start, or by the trials on either side.
    pub fn next(&mut self, trial: f64, excess: f64) -> (f64, f64) {
        if excess >= 0.0 {
            self.below = self.below.max(trial);
        }
        if excess <= 0.0 {
            self.above = self.above.min(trial);
        }
        let secant = trial + excess / self.slope(trial, excess);
        let width = self.above - self.below;
        let is_slow = width > 0.5 * self.widths[1];
        let is_between = self.below < secant && secant < self.above;
        let next = match width.is_finite() && width > 0.0 && (is_slow || !is_between) {
            true => 0.5 * (self.below + self.above),
            false => secant,
        };
        self.before = Some([trial, excess]);
        self.widths = [width, self.widths[0]];
        (next, (excess.abs() / self.slopes.first).min(0.5 * width.max(0.0)))
    }

    /// Slope downwards to go by.
    fn slope(&self, trial: f64, excess: f64) -> f64 {
        let Slopes { least, first } = self.slopes;
        let Some([then, was]) = self.before else { return first };
        let secant = (was - excess) / (trial - then);
        let is_across = (was < 0.0) != (excess < 0.0);
        match (secant > 0.0, is_across) {
            (true, true) => secant,
            // On one side: not a shorter way than without having measured, nor a longer one than
            // any contact lets.
            (true, false) => secant.min(first).max(least),
            _ => first,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes until what remains is less than `tolerance`, and where that is.
    fn solve(slopes: Slopes, start: f64, excess: impl Fn(f64) -> f64) -> (f64, u32) {
        let (mut search, mut trial) = (Search::new(slopes), start);
        for pass in 1..200 {
            let (next, left) = search.next(trial, excess(trial));
            if left < 1e-12 {
                return (trial, pass);
            }
            trial = next;
        }
        (trial, 200)
    }

    const SLOPES: Slopes = Slopes { least: 1.0, first: 2.0 };

    #[test]
    fn straight_lines_take_two_more_passes_whatever_the_slope_was_said_to_be() {
        for slope in [1.0, 1.5, 2.0, 30.0] {
            let (zero, passes) = solve(SLOPES, 0.0, |d| slope * (0.3 - d));
            assert!((zero - 0.3).abs() < 1e-11 && passes <= 3, "{slope}: {zero}, {passes}");
        }
    }

    /// Kinks, jumps downwards, jumps upwards, and all of them.
    #[test]
    fn what_falls_in_pieces_is_solved_from_either_side() {
        let step = |d: f64, at: f64| if d < at { 1.0 } else { 0.0 };
        let cases: [(&dyn Fn(f64) -> f64, f64); 5] = [
            (&|d| 0.3 - d + 1e4 * (0.2 - d).max(0.0), 0.3),
            (&|d| 0.1 - d + 1e4 * (0.2 - d).max(0.0), 0.2 - 0.1 / 10_001.0),
            (&|d| 0.1 - d + 50.0 * step(d, 0.2), 0.2),
            (&|d| 0.5 - d - 0.1 * step(d, 0.31), 0.5),
            (&|d| 0.1 - d + 50.0 * step(d, 0.2) - 3.0 * step(d, 0.15), 0.2),
        ];
        for (k, (excess, expected)) in cases.into_iter().enumerate() {
            for start in [0.0, 0.1999, 0.25, 0.9] {
                let (zero, passes) = solve(SLOPES, start, excess);
                assert!((zero - expected).abs() < 1e-11, "{k} from {start}: {zero}");
                assert!(passes < 90, "{k} from {start}: {passes}");
            }
        }
    }
}
