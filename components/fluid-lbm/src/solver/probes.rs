//! Probes: weighted means over the fluid cells where they are.

use crate::boundary::refill::{Content, PreCollision};
use crate::domain::sampling::samples;
use crate::domain::solids::Centres;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::CS2;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::probe_signals::{ProbeValues, rows};
use crate::solver::section_flux::{Crossing, Sight};
use tremie_messages::scene::{Probe, ProbeShape};
use tremie_team::Team;

/// Samples that are one item of work.
const SAMPLES_PER_ITEM: usize = 2048;

/// Fewer samples of a line than these are read one by one.
const FEW: usize = 3;

/// Weighted sums over samples.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    /// Weight of the fluid cells, and of those that bodies cover.
    fluid: f64,
    covered: f64,
    drho: f64,
    u: [f64; 3],
}

impl Sum {
    fn add(&mut self, weight: f64, content: &Content, acceleration: [f64; 3]) {
        let u = content.velocity(acceleration).map(|u| weight * u);
        self.join(&Self { fluid: weight, covered: 0.0, drho: weight * content.drho, u });
    }

    fn join(&mut self, other: &Self) {
        self.fluid += other.fluid;
        self.covered += other.covered;
        self.drho += other.drho;
        for a in 0..3 {
            self.u[a] += other.u[a];
        }
    }
}

/// Samples that are one item of work, and their sums.
#[derive(Clone, Debug)]
struct ProbeItem {
    probe: usize,
    /// The strip, of a profile; else 0.
    strip: usize,
    samples: Vec<(u32, f64)>,
    sum: Sum,
}

/// Mass that passes a section.
#[derive(Clone, Copy, Debug, Default)]
struct Passing {
    /// Of the last step that was looked at, and summed up since means began [a step].
    last: Option<f64>,
    sum: f64,
}

/// The probes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    shapes: Vec<ProbeShape>,
    items: Vec<ProbeItem>,
    /// Links that cross sections.
    crossings: Vec<Crossing>,
    /// Of each probe, what passes it if it is a section.
    passing: Vec<Passing>,
    /// Steps that were looked at since means began.
    looks: u32,
    /// Sections are looked at in every so many steps: none if there is no section.
    every: Option<u64>,
}

/// Cells of sections over all cells up to which sections are looked at in every step. A cell takes two to three times as
/// long as in a collision.
const SHARE_OF_SECTIONS: f64 = 0.005;

impl Probes {
    /// Of a scene, in stored cells.
    pub fn new(probes: &[Probe], layout: &Layout, centres: &Centres) -> Self {
        let mut own = Self::default();
        for (number, probe) in probes.iter().enumerate() {
            own.shapes.push(probe.shape.clone());
            let strips =
                if let ProbeShape::Profile { bins, .. } = &probe.shape { *bins } else { 1 };
            let mut cells = vec![Vec::new(); strips];
            let samples = samples(&layout.grid, centres, &probe.shape);
            if let ProbeShape::Section { axis, .. } = &probe.shape {
                let crossings = samples.chunks(SAMPLES_PER_ITEM);
                let crossings = crossings.map(|cells| Crossing::of(layout, *axis, number, cells));
                own.crossings.extend(crossings);
            }
            for (at, weight) in samples {
                let strip = strip_of(&probe.shape, centres, at);
                cells[strip].extend(layout.cell(at).map(|cell| (cell, weight)));
            }
            for (strip, cells) in cells.iter().enumerate() {
                own.items.extend(cells.chunks(SAMPLES_PER_ITEM).map(|samples| ProbeItem {
                    probe: number,
                    strip,
                    samples: samples.to_vec(),
                    sum: Sum::default(),
                }));
            }
        }
        own.passing = vec![Passing::default(); own.shapes.len()];
        let sections = own
            .items
            .iter()
            .filter(|item| matches!(own.shapes[item.probe], ProbeShape::Section { .. }));
        let looked_at: usize = sections.map(|item| item.samples.len()).sum();
        if looked_at > 0 {
            // The more cells sections have, the more seldom they are looked at.
            let share = looked_at as f64 / layout.cells.len().max(1) as f64;
            own.every = Some((share / SHARE_OF_SECTIONS).ceil().max(1.0) as u64);
        }
        own
    }

    /// Looks at what passes sections at the end of a step, if it is their turn.
    pub fn look<T: Real>(&mut self, team: &mut Team, sight: &Sight<T>, steps: u64) {
        if !self.every.is_some_and(|every| steps.is_multiple_of(every)) {
            return;
        }
        team.for_each(&mut self.crossings, |_, crossing| crossing.look(sight));
        self.looks += 1;
        self.passing.iter_mut().for_each(|passing| passing.last = Some(0.0));
        for crossing in &self.crossings {
            *self.passing[crossing.probe].last.get_or_insert(0.0) += crossing.passed;
        }
        self.passing.iter_mut().for_each(|passing| passing.sum += passing.last.unwrap_or(0.0));
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
        team: &mut Team,
        before: &PreCollision<T>,
        flags: &CellFlags,
        units: &Units,
        out: &mut Vec<f64>,
    ) {
        team.for_each(&mut self.items, |_, item| {
            item.sum = Sum::default();
            let line = |cell: u32| cell as usize / T::LINE;
            for samples in item.samples.chunk_by(|a, b| line(a.0) == line(b.0)) {
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
                        item.sum.add(weight, &content, before.acceleration);
                    } else {
                        item.sum.covered += weight;
                    }
                }
            }
        });
        let mut items = self.items.iter().peekable();
        for (number, shape) in self.shapes.iter().enumerate() {
            let strips = if let ProbeShape::Profile { bins, .. } = shape { *bins } else { 1 };
            let Passing { last, sum: passed } = self.passing[number];
            // Between looks, the last one.
            let mean = (self.looks > 0).then(|| passed / f64::from(self.looks)).or(last);
            for strip in 0..strips {
                let mut sum = Sum::default();
                while let Some(item) =
                    items.next_if(|item| (item.probe, item.strip) == (number, strip))
                {
                    sum.join(&item.sum);
                }
                push(shape, &sum, mean, units, out);
            }
        }
    }
}

/// The strip of a probe in which a cell lies.
fn strip_of(shape: &ProbeShape, centres: &Centres, at: [i32; 3]) -> usize {
    let ProbeShape::Profile { min, max, along, bins, .. } = shape else { return 0 };
    let part = (centres.of(at)[*along] - min[*along]) / (max[*along] - min[*along]);
    ((part * *bins as f64) as usize).min(bins - 1)
}

/// Appends the values of one probe.
fn push(shape: &ProbeShape, sum: &Sum, passing: Option<f64>, units: &Units, out: &mut Vec<f64>) {
    let mean = |x: f64| if sum.fluid > 0.0 { x / sum.fluid } else { 0.0 };
    let velocity = sum.u.map(|u| mean(u) * units.velocity());
    if let ProbeShape::Profile { axis, .. } = shape {
        return out.push(velocity[*axis]);
    }
    let across = if let ProbeShape::Section { axis, .. } = shape { *axis } else { 0 };
    let all = sum.fluid + sum.covered;
    // Before the first look, as it is.
    let now = || sum.u[across] * (1.0 + mean(sum.drho));
    let measured = ProbeValues {
        pressure: mean(sum.drho) * CS2 * units.pressure(),
        velocity,
        solid_fraction: if all > 0.0 { sum.covered / all } else { 0.0 },
        flow_rate: sum.u[across] * units.velocity() * (units.cell * units.cell),
        mass_flow_rate: passing.unwrap_or_else(now) * units.mass() / units.time_step,
    };
    out.extend(rows(shape).iter().map(|(_, _, _, value)| value(&measured)));
}
