//! What probes measure: weighted means over the fluid cells where they are.

use crate::boundary::refill::{Content, PreCollision};
use crate::domain::sampling::samples;
use crate::domain::solids::Centres;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::CS2;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::section_flux::{Crossing, Sight};
use tremie_messages::finding::short;
use tremie_messages::scene::{Probe, ProbeShape, Scene};
use tremie_team::Team;

/// Samples that are one item of work.
const SAMPLES_PER_ITEM: usize = 2048;

/// Fewer samples of a line than these are read one by one.
const FEW: usize = 3;

/// Names and units of the values of a scene's probes, in their order: `probe.value`.
pub fn probe_signals(scene: &Scene) -> Vec<(String, &'static str)> {
    scene.probe_signals(values)
}

/// Mean velocities in the strips of a profile.
const STRIPS: [(&str, &str); ProbeShape::MOST_BINS] = [
    ("u0", "m/s"),
    ("u1", "m/s"),
    ("u2", "m/s"),
    ("u3", "m/s"),
    ("u4", "m/s"),
    ("u5", "m/s"),
    ("u6", "m/s"),
    ("u7", "m/s"),
    ("u8", "m/s"),
    ("u9", "m/s"),
    ("u10", "m/s"),
    ("u11", "m/s"),
    ("u12", "m/s"),
    ("u13", "m/s"),
    ("u14", "m/s"),
    ("u15", "m/s"),
    ("u16", "m/s"),
    ("u17", "m/s"),
    ("u18", "m/s"),
    ("u19", "m/s"),
    ("u20", "m/s"),
    ("u21", "m/s"),
    ("u22", "m/s"),
    ("u23", "m/s"),
    ("u24", "m/s"),
    ("u25", "m/s"),
    ("u26", "m/s"),
    ("u27", "m/s"),
    ("u28", "m/s"),
    ("u29", "m/s"),
    ("u30", "m/s"),
    ("u31", "m/s"),
    ("u32", "m/s"),
    ("u33", "m/s"),
    ("u34", "m/s"),
    ("u35", "m/s"),
    ("u36", "m/s"),
    ("u37", "m/s"),
    ("u38", "m/s"),
    ("u39", "m/s"),
    ("u40", "m/s"),
    ("u41", "m/s"),
    ("u42", "m/s"),
    ("u43", "m/s"),
    ("u44", "m/s"),
    ("u45", "m/s"),
    ("u46", "m/s"),
    ("u47", "m/s"),
    ("u48", "m/s"),
    ("u49", "m/s"),
    ("u50", "m/s"),
    ("u51", "m/s"),
    ("u52", "m/s"),
    ("u53", "m/s"),
    ("u54", "m/s"),
    ("u55", "m/s"),
    ("u56", "m/s"),
    ("u57", "m/s"),
    ("u58", "m/s"),
    ("u59", "m/s"),
    ("u60", "m/s"),
    ("u61", "m/s"),
    ("u62", "m/s"),
    ("u63", "m/s"),
];

fn values(shape: &ProbeShape) -> &'static [(&'static str, &'static str)] {
    const REGION: [(&str, &str); 5] = [
        ("pressure", "Pa"),
        ("velocity_x", "m/s"),
        ("velocity_y", "m/s"),
        ("velocity_z", "m/s"),
        ("solid_fraction", "1"),
    ];
    match shape {
        ProbeShape::Point(_) | ProbeShape::Line { .. } => &REGION[..4],
        ProbeShape::Section { .. } => {
            &[("flow_rate", "m³/s"), ("pressure", "Pa"), ("mass_flow_rate", "kg/s")]
        }
        ProbeShape::Profile { bins, .. } => &STRIPS[..(*bins).min(STRIPS.len())],
        ProbeShape::Region { .. } | ProbeShape::Ring(_) => &REGION,
    }
}

/// What the values of a scene's probes are, in the order of [`probe_signals`], where that is not by their names alone.
pub fn probe_meanings(scene: &Scene) -> Vec<Option<String>> {
    let of = |probe: &Probe| match &probe.shape {
        ProbeShape::Profile { axis, min, max, along, bins, .. } => {
            let width = (max[*along] - min[*along]) / *bins as f64;
            let names = ["x", "y", "z"];
            let strip = |k: usize| {
                let at = |k: usize| short(min[*along] + width * k as f64);
                Some(format!(
                    "mean velocity of the fluid along {} where {} is {} to {} m",
                    names[*axis],
                    names[*along],
                    at(k),
                    at(k + 1)
                ))
            };
            (0..*bins).map(strip).collect()
        }
        shape => vec![None; count(shape)],
    };
    scene.probes.iter().flat_map(of).collect()
}

/// How many values a probe of a shape has.
pub fn count(shape: &ProbeShape) -> usize {
    values(shape).len()
}

/// Which of the values of a probe of a shape is the first of the three of a velocity, if it has one.
pub fn first_velocity(shape: &ProbeShape) -> Option<usize> {
    values(shape).iter().position(|(name, _)| *name == "velocity_x")
}

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
    let pressure = mean(sum.drho) * CS2 * units.pressure();
    let velocity = sum.u.map(|u| mean(u) * units.velocity());
    match shape {
        ProbeShape::Section { axis, .. } => {
            let area = units.cell * units.cell;
            // Before the first look, as it is.
            let now = || sum.u[*axis] * (1.0 + mean(sum.drho));
            let rate = passing.unwrap_or_else(now) * units.mass() / units.time_step;
            out.extend([sum.u[*axis] * units.velocity() * area, pressure, rate]);
        }
        ProbeShape::Profile { axis, .. } => out.push(velocity[*axis]),
        ProbeShape::Point(_) | ProbeShape::Line { .. } => {
            out.push(pressure);
            out.extend(velocity);
        }
        ProbeShape::Region { .. } | ProbeShape::Ring(_) => {
            out.push(pressure);
            out.extend(velocity);
            let all = sum.fluid + sum.covered;
            out.push(if all > 0.0 { sum.covered / all } else { 0.0 });
        }
    }
}
