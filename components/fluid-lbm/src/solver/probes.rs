//! Probes: weighted means over the fluid cells where they are.

use crate::boundary::refill::PreCollision;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::CS2;
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::layout::{Layout, block_of};
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::ranks::rank_sums::Ranks;
use crate::solver::section_flux::{Crossing, Sight};
use serde::{Deserialize, Serialize};
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::probes::probe_plan::{ProbePlan, ProbeSum, SAMPLES_PER_ITEM};
use tremie_fluid_kit::probes::probe_signals::{ProbeValues, append};
use tremie_fluid_kit::probes::sampling::samples;
use tremie_messages::scene::{Probe, ProbeShape};
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Fewer samples of a line than these are read one by one.
const FEW: usize = 3;

/// Mass that passes a section.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Passing {
    /// Of the last step that was looked at, and summed up since means began [a step].
    last: Option<f64>,
    sum: f64,
}

/// The probes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    plan: ProbePlan,
    /// Links that cross sections.
    crossings: Vec<Crossing>,
    /// Of each probe, what passes it if it is a section.
    passing: Vec<Passing>,
    /// Room for what passes each, and for the sums of each value.
    passed: Vec<ExactSum>,
    sums: Vec<ExactSum>,
    /// Steps that were looked at since means began.
    looks: u32,
    /// Sections are looked at in every so many steps: none if there is no section.
    every: Option<u64>,
}

/// Cells of sections over all cells up to which sections are looked at in every step. A cell takes
/// two to three times as long as in a collision.
const SHARE_OF_SECTIONS: f64 = 0.005;

impl Probes {
    /// Of a scene, in stored cells.
    pub fn new(probes: &[Probe], layout: &Layout, centres: &Centres, ranks: &mut Ranks) -> Self {
        let stored = |at| layout.cell(at).filter(|&cell| layout.is_own(cell));
        let mut own = Self {
            plan: ProbePlan::in_pieces(probes, &layout.grid, centres, stored, block_of),
            passing: vec![Passing::default(); probes.len()],
            passed: vec![ExactSum::default(); probes.len()],
            ..Self::default()
        };
        for (number, probe) in probes.iter().enumerate() {
            if let ProbeShape::Section { axis, .. } = &probe.shape {
                let cells = samples(&layout.grid, centres, &probe.shape);
                let crossings = cells.chunks(SAMPLES_PER_ITEM);
                let crossings = crossings.map(|cells| Crossing::of(layout, *axis, number, cells));
                own.crossings.extend(crossings);
            }
        }
        let mut counts = [own.plan.samples_of_sections() as i64, layout.own.len() as i64];
        ranks.count(&mut counts);
        let [looked_at, all] = counts;
        if looked_at > 0 {
            // The more cells sections have, the more seldom they are looked at.
            let share = looked_at as f64 / all as f64;
            own.every = Some((share / SHARE_OF_SECTIONS).ceil().max(1.0) as u64);
        }
        own
    }

    /// Keeps the means that were begun, or puts them back.
    ///
    /// # Errors
    /// A state of other probes.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let probes = self.passing.len();
        state.value("passing", &mut self.passing)?;
        state.value("looks", &mut self.looks)?;
        match self.passing.len() == probes {
            true => Ok(()),
            false => state.unfit("the state is that of other probes"),
        }
    }

    /// True if it is the turn of sections to be looked at.
    pub fn looks_now(&self, steps: u64) -> bool {
        self.every.is_some_and(|every| steps.is_multiple_of(every))
    }

    /// Looks at what passes sections at the end of a step, if it is their turn.
    pub fn look<T: Real>(
        &mut self,
        (team, ranks): (&mut Team, &mut Ranks),
        sight: &Sight<T>,
        steps: u64,
    ) {
        if !self.looks_now(steps) {
            return;
        }
        team.for_each(&mut self.crossings, |_, crossing| crossing.look(sight));
        self.looks += 1;
        self.passed.fill(ExactSum::default());
        for crossing in &self.crossings {
            crossing.passed.add_to(&mut self.passed[crossing.probe]);
        }
        ranks.add_up(&mut self.passed);
        for (passing, passed) in self.passing.iter_mut().zip(&self.passed) {
            passing.last = Some(passed.value());
            passing.sum += passed.value();
        }
    }

    /// Begins means over time anew.
    pub fn restart_means(&mut self) {
        self.looks = 0;
        self.passing.iter_mut().for_each(|passing| passing.sum = 0.0);
    }

    /// Appends the values of all probes to `out`, SI units. A probe all of whose cells are covered
    /// reads 0.
    pub fn read<T: Real>(
        &mut self,
        (team, ranks): (&mut Team, &mut Ranks),
        before: &PreCollision<T>,
        flags: &CellFlags,
        units: &Units,
        out: &mut Vec<f64>,
    ) {
        let line = |cell: u32| cell as usize / T::LINE;
        self.plan.measure(team, |samples, sum| {
            for samples in samples.chunk_by(|a, b| line(a.0) == line(b.0)) {
                let number = line(samples[0].0);
                let first = number * T::LINE;
                // Where it pays, the cells of a line are read together.
                let together = (samples.len() >= FEW).then(|| {
                    before.contents(number, T::LINE.min(before.layout.cells.len() - first))
                });
                for &(cell, weight) in samples {
                    if flags.is_fluid(cell) {
                        let content = match &together {
                            Some(contents) => contents[cell as usize - first],
                            None => before.content(cell),
                        };
                        let velocity = content.velocity(before.acceleration);
                        sum.add(weight, content.drho, velocity);
                    } else {
                        sum.covered += weight;
                    }
                }
            }
        });
        let sums = &mut self.sums;
        sums.clear();
        self.plan.tell_items(|_, _, items| {
            let mut all = [ExactSum::default(); VALUES];
            for item in items {
                let [x, y, z] = item.velocity;
                let own = [item.fluid, item.covered, item.pressure, x, y, z];
                all.iter_mut().zip(own).for_each(|(sum, own)| sum.add(own));
            }
            sums.extend(all);
        });
        ranks.add_up(&mut *sums);
        let mut sums = sums.chunks_exact(VALUES);
        self.plan.tell_items(|number, shape, _| {
            let sum = &sums.next().map(rounded).unwrap_or_default();
            let Passing { last, sum: passed } = self.passing[number];
            // Between looks, the last one.
            let mean = (self.looks > 0).then(|| passed / f64::from(self.looks)).or(last);
            append(shape, &values(shape, sum, mean, units), out);
        });
    }
}

/// Sums of a probe.
const VALUES: usize = 6;

/// The sums of a probe, each rounded once.
fn rounded(sums: &[ExactSum]) -> ProbeSum {
    let value = |k: usize| sums[k].value();
    ProbeSum {
        fluid: value(0),
        covered: value(1),
        pressure: value(2),
        velocity: [value(3), value(4), value(5)],
        ..ProbeSum::default()
    }
}

/// Values of one probe in SI units. The sum of the pressure is that of the density's deviation.
fn values(shape: &ProbeShape, sum: &ProbeSum, passing: Option<f64>, units: &Units) -> ProbeValues {
    let across = if let ProbeShape::Section { axis, .. } = shape { *axis } else { 0 };
    let drho = sum.mean(sum.pressure);
    // Before the first look, as it is.
    let now = || sum.velocity[across] * (1.0 + drho);
    ProbeValues {
        pressure: drho * CS2 * units.pressure(),
        velocity: sum.velocity.map(|u| sum.mean(u) * units.velocity()),
        solid_fraction: sum.solid_fraction(),
        flow_rate: sum.velocity[across] * units.velocity() * (units.cell * units.cell),
        mass_flow_rate: passing.unwrap_or_else(now) * units.mass() / units.time_step,
    }
}
