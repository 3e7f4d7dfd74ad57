//! Timing of a schedule: shares of a window's wall time, and an estimate for the other schedule.
//!
//! The manifest sets the schedule, because it changes results. A user wants to know all the same
//! how much time another one would take. Threads change no results. So fluid and grains measure by
//! themselves whether more than one pays.

use super::ComponentTotals;
use serde::Serialize;
use std::fmt;
use tremie_messages::Role;
use tremie_messages::schedule::Schedule;

/// Shares of the physics in a window's wall time, means over a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScheduleTiming {
    /// The schedule of the run.
    pub schedule: Schedule,
    /// Wall time of a window in which the fluid computes and sends [s].
    pub fluid: f64,
    /// The same of grains and rubber, which take turns in each substep [s].
    pub others: f64,
    /// Wall time of a window in the other schedule, roughly [s]. For the parallel schedule it is a
    /// lower bound, because the two may disturb each other. For the serial one it is an upper
    /// bound, because they disturb each other now.
    pub in_other_schedule: f64,
}

/// A component of the physics: its role, the threads that it may use, and the sums of its reports.
pub type Worked = (Role, u32, ComponentTotals);

impl ScheduleTiming {
    /// Timing of so many windows on a machine of `cores`; `None` without a fluid and something that
    /// moves in it.
    pub fn of(
        schedule: Schedule,
        cores: u32,
        components: impl IntoIterator<Item = Worked>,
        windows: u64,
    ) -> Option<Self> {
        let (mut fluid, mut others, mut threads) = (0, 0, 1);
        for (role, may_use, totals) in components {
            let busy = totals.compute + totals.exchange;
            match role {
                Role::Fluid => (fluid, threads) = (busy, may_use.min(cores)),
                _ => others += busy,
            }
        }
        if fluid == 0 || others == 0 || windows == 0 {
            return None;
        }
        let each = |nanoseconds: u64| nanoseconds as f64 * 1e-9 / windows as f64;
        let (fluid, others) = (each(fluid), each(others));
        let in_other_schedule = match schedule {
            // Bounds: all cores share the work evenly, and neither side is faster than alone.
            Schedule::Serial => {
                let shared = (fluid * f64::from(threads) + others) / f64::from(cores.max(1));
                shared.max(fluid).max(others)
            }
            Schedule::Parallel => fluid + others,
        };
        Some(Self { schedule, fluid, others, in_other_schedule })
    }
}

impl fmt::Display for ScheduleTiming {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [fluid, others, other] =
            [self.fluid, self.others, self.in_other_schedule].map(|time| 1e3 * time);
        write!(f, "of a window the fluid takes {fluid:.3} ms, the others {others:.3} ms, ")?;
        match self.schedule {
            Schedule::Serial => write!(
                f,
                "in turns; schedule = \"parallel\" would take {other:.3} ms at best, with other results"
            ),
            Schedule::Parallel => write!(
                f,
                "side by side; schedule = \"serial\" would take {other:.3} ms at most, with other results"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn busy(compute: u64, exchange: u64) -> ComponentTotals {
        ComponentTotals { compute, exchange, wait: 77, work: 1 }
    }

    #[test]
    fn a_fluid_on_all_cores_leaves_the_others_little_to_gain() {
        let run = [
            (Role::Fluid, 2, busy(3_900_000, 100_000)),
            (Role::Grains, 2, busy(500_000, 0)),
            (Role::Rubber, 1, busy(500_000, 0)),
        ];
        let turns = ScheduleTiming::of(Schedule::Serial, 2, run, 1).unwrap();
        assert!((turns.fluid - 4.0e-3).abs() < 1e-12 && (turns.others - 1.0e-3).abs() < 1e-12);
        // Two cores share 2 x 4 + 1 ms.
        assert!((turns.in_other_schedule - 4.5e-3).abs() < 1e-12);
        let text = turns.to_string();
        assert!(text.contains("4.000 ms") && text.contains("4.500 ms at best"), "{text}");
    }

    #[test]
    fn the_slower_one_bounds_what_there_is_to_gain() {
        let run = [(Role::Fluid, 1, busy(3_000, 0)), (Role::Grains, 1, busy(2_000, 0))];
        let turns = ScheduleTiming::of(Schedule::Serial, 4, run, 1).unwrap();
        assert!((turns.in_other_schedule - 3.0e-6).abs() < 1e-15);
        let turns = ScheduleTiming::of(Schedule::Parallel, 4, run, 1).unwrap();
        assert!((turns.in_other_schedule - 5.0e-6).abs() < 1e-15);
        assert!(turns.to_string().contains("at most"));
    }

    #[test]
    fn nobody_waits_for_nobody() {
        let fluid = [(Role::Fluid, 2, busy(1, 1))];
        assert_eq!(ScheduleTiming::of(Schedule::Serial, 2, fluid, 10), None);
        let both = [fluid[0], (Role::Grains, 1, busy(1, 1))];
        assert_eq!(ScheduleTiming::of(Schedule::Serial, 2, both, 0), None);
    }
}
