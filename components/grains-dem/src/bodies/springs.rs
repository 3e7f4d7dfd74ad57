//! Springs and stops of sliders: force, energy and stiffness by the lift.

use crate::math::damping::damping_ratio;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use tremie_messages::scene::{SliderSpring, Stops};

/// A spring whose force is against the axis, in the form that a step wants.
#[derive(Clone, Debug)]
pub(crate) enum SpringLaw {
    /// `preload + rate y`.
    Line { rate: f64, preload: f64 },
    /// `preload + rate (2 a/pi) tan(pi y/(2 a))` up to the lift `bend` on either side of 0, from
    /// where on it is a line of the stiffness `limit`.
    Tangent { rate: f64, preload: f64, stroke: f64, bend: f64, limit: f64 },
    /// Points; beyond the ends the first and the last line go on.
    Table(Vec<SpringKnot>),
}

/// A point of a table, with the energy up to it and the slope from there to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpringKnot {
    lift: f64,
    force: f64,
    slope: f64,
    energy: f64,
}

impl SpringLaw {
    /// The law of a valid spring; `limit` is the stiffness of the stops [N/m].
    pub fn new(spring: &SliderSpring, limit: f64) -> Self {
        match spring {
            SliderSpring::None => Self::Line { rate: 0.0, preload: 0.0 },
            &SliderSpring::Linear { rate, preload } => Self::Line { rate, preload },
            &SliderSpring::Tangent { rate, preload, stroke } => {
                // The tangent stiffness is rate/cos^2.
                let bend = stroke * FRAC_2_PI * libm::acos((rate / limit).sqrt().min(1.0));
                Self::Tangent { rate, preload, stroke, bend, limit }
            }
            SliderSpring::Table(points) => Self::Table(knots(points)),
        }
    }

    /// Force against the axis at a lift [N].
    pub fn force(&self, lift: f64) -> f64 {
        match self {
            Self::Line { rate, preload } => preload + rate * lift,
            Self::Tangent { rate, preload, stroke, bend, limit } => {
                let inside = lift.clamp(-bend, *bend);
                let scale = rate * stroke * FRAC_2_PI;
                let line = limit * (lift - inside);
                preload + scale * libm::tan(FRAC_PI_2 * inside / stroke) + line
            }
            Self::Table(knots) => {
                let knot = knot_of(knots, lift);
                knot.force + knot.slope * (lift - knot.lift)
            }
        }
    }

    /// Work done against it up to a lift [J]: from lift 0, or from the first point of a table.
    pub fn energy(&self, lift: f64) -> f64 {
        match self {
            Self::Line { rate, preload } => (preload + 0.5 * rate * lift) * lift,
            Self::Tangent { rate, preload, stroke, bend, limit } => {
                let inside = lift.clamp(-bend, *bend);
                let (length, beyond) = (stroke * FRAC_2_PI, lift - inside);
                let angle = FRAC_PI_2 * inside / stroke;
                let at_bend = rate * length * libm::tan(angle);
                preload * lift - rate * length * length * libm::log(libm::cos(angle))
                    + (at_bend + 0.5 * limit * beyond) * beyond
            }
            Self::Table(knots) => {
                let knot = knot_of(knots, lift);
                let way = lift - knot.lift;
                knot.energy + (knot.force + 0.5 * knot.slope * way) * way
            }
        }
    }

    /// Largest stiffness, of either sign, anywhere [N/m].
    pub fn stiffest(&self) -> f64 {
        match self {
            Self::Line { rate, .. } => rate.abs(),
            Self::Tangent { limit, .. } => *limit,
            Self::Table(knots) => knots.iter().fold(0.0, |k, knot| k.max(knot.slope.abs())),
        }
    }
}

/// The points of a table, two at least; the last takes the slope of the line before it.
fn knots(points: &[[f64; 2]]) -> Vec<SpringKnot> {
    let mut knots: Vec<SpringKnot> = Vec::with_capacity(points.len());
    for (k, &[lift, force]) in points.iter().enumerate() {
        let energy = knots.last().map_or(0.0, |before| {
            before.energy + 0.5 * (before.force + force) * (lift - before.lift)
        });
        let slope = match (points.get(k + 1), knots.last()) {
            (Some([next, after]), _) => (after - force) / (next - lift),
            (None, Some(before)) => before.slope,
            (None, None) => 0.0,
        };
        knots.push(SpringKnot { lift, force, slope, energy });
    }
    knots
}

/// The point whose line holds at a lift.
fn knot_of(knots: &[SpringKnot], lift: f64) -> &SpringKnot {
    let after = knots.partition_point(|knot| knot.lift <= lift);
    &knots[after.saturating_sub(1)]
}

/// The ends of a travel as contacts of a mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopLaw {
    lower: f64,
    upper: f64,
    /// Stiffness [N/m] and dashpot [kg/s].
    pub stiffness: f64,
    pub gamma: f64,
}

impl StopLaw {
    /// The law of valid stops for a mass [kg]; none has no stiffness.
    pub fn new(stops: Option<&Stops>, mass: f64) -> Self {
        let none =
            Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY, stiffness: 0.0, gamma: 0.0 };
        stops.map_or(none, |stops| Self {
            lower: stops.lower.unwrap_or(none.lower),
            upper: stops.upper.unwrap_or(none.upper),
            stiffness: stops.stiffness,
            gamma: 2.0 * damping_ratio(stops.restitution, false) * (stops.stiffness * mass).sqrt(),
        })
    }

    /// Depths of a mass at a lift in the lower and in the upper stop [m]; negative outside.
    fn depths(&self, lift: f64) -> [f64; 2] {
        [self.lower - lift, lift - self.upper]
    }

    /// Force along the axis [N] at a lift and a velocity; it pushes only.
    pub fn force(&self, lift: f64, velocity: f64) -> f64 {
        let [low, high] = self.depths(lift);
        let push = |depth: f64, approach: f64| {
            let force = self.stiffness * depth + self.gamma * approach;
            if depth > 0.0 { force.max(0.0) } else { 0.0 }
        };
        push(low, -velocity) - push(high, velocity)
    }

    /// Energy of their springs [J].
    pub fn energy(&self, lift: f64) -> f64 {
        let of = |depth: f64| if depth > 0.0 { 0.5 * self.stiffness * depth * depth } else { 0.0 };
        self.depths(lift).map(of).iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALVE: SliderSpring =
        SliderSpring::Tangent { rate: 625.0, preload: 57.5, stroke: 4.5e-3 };

    #[test]
    fn the_tan_law_has_the_published_forces() {
        let law = SpringLaw::new(&VALVE, 1e7);
        for (mm, newton) in [
            (0.0, 57.50),
            (0.48, 57.80),
            (1.0, 58.15),
            (2.0, 59.00),
            (3.0, 60.60),
            (4.0, 67.65),
            (4.4, 108.8),
        ] {
            let found = law.force(1e-3 * mm);
            // Half a unit of the last digit.
            let rounding = if newton < 100.0 { 0.005 } else { 0.05 };
            assert!((found - newton).abs() < 1.01 * rounding, "{mm}: {found}");
        }
    }

    /// Simpson's rule over steps so small that its error is rounding.
    fn work(law: &SpringLaw, from: f64, to: f64) -> f64 {
        let n = 20_000;
        let h = (to - from) / f64::from(n);
        let sum: f64 = (0..n)
            .map(|k| {
                let x = from + h * f64::from(k);
                law.force(x) + 4.0 * law.force(x + 0.5 * h) + law.force(x + h)
            })
            .sum();
        sum * h / 6.0
    }

    #[test]
    fn energies_are_integrals_of_forces() {
        let table =
            SliderSpring::Table(vec![[-1e-3, 3.0], [1e-3, 5.0], [2e-3, 20.0], [4e-3, 21.0]]);
        let linear = SliderSpring::Linear { rate: 625.0, preload: 57.5 };
        for (spring, ends) in [
            (&VALVE, [-1e-3, 4.4e-3]),
            (&VALVE, [4.4e-3, 4.6e-3]),
            (&VALVE, [-4.6e-3, -4.4e-3]),
            (&table, [-2e-3, 6e-3]),
            (&linear, [-1e-3, 3e-3]),
        ] {
            let law = SpringLaw::new(spring, 1e7);
            let found = law.energy(ends[1]) - law.energy(ends[0]);
            let exact = work(&law, ends[0], ends[1]);
            assert!((found / exact - 1.0).abs() < 1e-7, "{spring:?} {ends:?}: {found} {exact}");
        }
    }

    #[test]
    fn the_tan_law_bends_into_a_line_of_the_stops_stiffness() {
        let law = SpringLaw::new(&VALVE, 1e7);
        let SpringLaw::Tangent { bend, .. } = law else { panic!() };
        assert!(bend > 0.99 * 4.5e-3 && bend < 4.5e-3, "{bend}");
        let slope = |x: f64, h: f64| (law.force(x + h) - law.force(x)) / h;
        assert!((slope(bend, -1e-9) / 1e7 - 1.0).abs() < 1e-3);
        assert!((slope(bend, 1e-3) / 1e7 - 1.0).abs() < 1e-9);
        assert!(law.force(5e-3).is_finite());
        assert_eq!(law.stiffest(), 1e7);
    }
}
