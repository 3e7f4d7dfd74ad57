//! Numbers of a run with grains.

use super::valve_run::{ValveRun, Varied};
use crate::results::debris::debris;
use crate::scene::Dimensions;
use std::f64::consts::PI;

/// Time from which on the start has passed [s].
pub const SETTLED: f64 = 10e-3;

/// Fluxes of grains between the paper's regimes [m/s].
pub const REGIMES: [f64; 2] = [0.405, 0.611];

/// Cosine of the cone's slope.
fn cosine() -> f64 {
    libm::cos(Dimensions::default().cone_slope.0)
}

/// A number of a run beside the least that the paper has for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    pub found: f64,
    pub least: f64,
}

impl ValveRun<'_> {
    /// Volume of the grains that come to the valve, over the conduit's section and time [m/s]: the
    /// fraction that is fed times the piston's speed, less the share that a safety valve's conduit
    /// lets out beside the valve. Mutabaruka and Kamrin (section 3.2) take off what leaves by both
    /// outlets; here what has passed the valve counts, or nothing would be left in a steady flow.
    pub fn flux(&self) -> f64 {
        let grown = |name: &str| {
            let rows = self.rows(SETTLED, self.stop);
            let masses = &self.signal(name)?[rows];
            Some(masses.last()? - masses.first()?).filter(|mass| mass.is_finite())
        };
        let fed = grown("grains.feed.mass_inserted").filter(|mass| *mass > 0.0);
        let beside = grown("grains.overflow.mass_removed").zip(fed);
        let share = beside.map_or(0.0, |(out, fed)| out / fed);
        self.number(Varied::Fraction) * self.number(Varied::Piston) * (1.0 - share)
    }

    /// Mean, least and greatest lift from the start's end to the piston's stop [m].
    pub fn envelope(&self) -> Option<[f64; 3]> {
        self.steady()?;
        self.spread(self.lift, SETTLED, self.stop)
    }

    /// Swing of the packing over its mean, over the same time.
    pub fn packing_swing(&self) -> Option<f64> {
        self.steady()?;
        let packing = self.signal("grains.packing.solid_fraction")?;
        let [mean, least, greatest] = self.spread(packing, SETTLED, self.stop)?;
        Some((greatest - least) / mean)
    }

    /// Lifts at which one layer of grains holds it, of the least and of the greatest [m] (Eq. 32).
    pub fn layer_lifts(&self) -> Option<[f64; 2]> {
        self.diameters.map(|sizes| sizes.map(|diameter| diameter / cosine()))
    }

    /// Area of stuck grains at the end over the channel's (NASP, Eq. 33).
    pub fn stuck_area(&self) -> Option<Bounded> {
        let found = *self.signal("grains.stuck.area_fraction")?.last()?;
        Some(Bounded { found, least: 1.5 * self.number(Varied::Fraction) / cosine() })
    }

    /// Debris of the stuck grains at the end, in cubes of a diameter (Eq. 35).
    pub fn stuck_debris(&self) -> Option<Bounded> {
        let numbers = Dimensions::default();
        let (outer, inner) = (numbers.rubber_outer_radius.0, numbers.bore_radius.0);
        let seat = PI * (outer * outer - inner * inner);
        let (area, lift, d) = (self.stuck_area()?, self.rest()?, self.number(Varied::Diameter));
        // The bound supposes a layer as high as a diameter over the cosine.
        let least = debris(d / cosine(), seat, area.least, d);
        Some(Bounded { found: debris(lift, seat, area.found, d), least })
    }
}

#[cfg(test)]
mod tests {
    use super::super::valve_run::made_up::{lift, run, signals};
    use crate::scene::Closure;

    /// 1 kg/s comes in; a quarter of it leaves beside the valve.
    #[test]
    fn the_flux_to_a_safety_valve_is_less_what_leaves_beside_it() {
        let opening = |t: f64| lift(t, [2e-3, 2e-3, 1e-3, 0.5e-3]);
        let both = signals(&[
            ("grains.valve.lift", &opening),
            ("grains.feed.mass_inserted", &|t| t),
            ("grains.overflow.mass_removed", &|t| 0.25 * (t - 2e-3).max(0.0)),
        ]);
        let of = |signals, kind| run(signals, kind, [1e-3, 6.0], Some([0.8e-3, 0.084])).flux();
        assert!((of(&both, Closure::Safety) / (0.75 * 0.504) - 1.0).abs() < 1e-9);
        let one =
            signals(&[("grains.valve.lift", &opening), ("grains.feed.mass_inserted", &|t| t)]);
        assert!((of(&one, Closure::Pressure) / 0.504 - 1.0).abs() < 1e-9);
    }
}
