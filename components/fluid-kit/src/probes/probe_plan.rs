//! The cells that the probes of a scene read, as pieces of work for a team.

use crate::cells::centres::Centres;
use crate::cells::grid::Grid;
use crate::probes::sampling::samples;
use tremie_messages::scene::{Probe, ProbeShape};
use tremie_team::Team;

/// Samples that are one item of work.
pub const SAMPLES_PER_ITEM: usize = 2048;

/// Weighted sums over samples, in the fluid's own units.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeSum {
    /// Weight of the fluid cells.
    pub fluid: f64,
    /// Weight of the cells without fluid.
    pub covered: f64,
    /// Of the pressure, or what stands for it.
    pub pressure: f64,
    /// Of the velocity.
    pub velocity: [f64; 3],
    /// Of the momentum of a volume, of a fluid whose density varies.
    pub momentum: [f64; 3],
}

impl ProbeSum {
    /// Adds a cell of the fluid.
    #[inline]
    pub fn add(&mut self, weight: f64, pressure: f64, velocity: [f64; 3]) {
        self.fluid += weight;
        self.pressure += weight * pressure;
        for a in 0..3 {
            self.velocity[a] += weight * velocity[a];
        }
    }

    /// Adds a cell of a fluid whose density varies.
    pub fn add_dense(&mut self, weight: f64, pressure: f64, velocity: [f64; 3], density: f64) {
        self.add(weight, pressure, velocity);
        for a in 0..3 {
            self.momentum[a] += weight * density * velocity[a];
        }
    }

    fn join(&mut self, other: &Self) {
        self.fluid += other.fluid;
        self.covered += other.covered;
        self.pressure += other.pressure;
        for a in 0..3 {
            self.velocity[a] += other.velocity[a];
            self.momentum[a] += other.momentum[a];
        }
    }

    /// Mean over the fluid of one of its sums; 0 if all cells are covered.
    pub fn mean(&self, sum: f64) -> f64 {
        if self.fluid > 0.0 { sum / self.fluid } else { 0.0 }
    }

    /// Share of the place that no fluid fills.
    pub fn solid_fraction(&self) -> f64 {
        let all = self.fluid + self.covered;
        if all > 0.0 { self.covered / all } else { 0.0 }
    }
}

/// Samples that are one item of work, and their sums.
#[derive(Clone, Debug)]
struct ProbeItem {
    probe: usize,
    /// The strip, of a profile; else 0.
    strip: usize,
    samples: Vec<(u32, f64)>,
    sum: ProbeSum,
}

/// The probes of a scene.
#[derive(Clone, Debug, Default)]
pub struct ProbePlan {
    shapes: Vec<ProbeShape>,
    items: Vec<ProbeItem>,
}

impl ProbePlan {
    /// Of probes in a box of cells. `stored` gives the number under which a cell is read, if it is
    /// stored at all.
    pub fn new(
        probes: &[Probe],
        grid: &Grid,
        centres: &Centres,
        stored: impl Fn([i32; 3]) -> Option<u32>,
    ) -> Self {
        Self::in_pieces(probes, grid, centres, stored, |_| 0)
    }

    /// The same, where cells of different pieces are never one item of work; `piece_of` gives the piece of a cell
    /// that is stored under a number.
    pub fn in_pieces(
        probes: &[Probe],
        grid: &Grid,
        centres: &Centres,
        stored: impl Fn([i32; 3]) -> Option<u32>,
        piece_of: impl Fn(u32) -> u32,
    ) -> Self {
        let mut own = Self::default();
        for (number, probe) in probes.iter().enumerate() {
            let mut cells = vec![Vec::new(); strips(&probe.shape)];
            for (at, weight) in samples(grid, centres, &probe.shape) {
                let strip = strip_of(&probe.shape, centres, at);
                cells[strip].extend(stored(at).map(|cell| (cell, weight)));
            }
            for (strip, cells) in cells.iter().enumerate() {
                let pieces = cells.chunk_by(|a, b| piece_of(a.0) == piece_of(b.0));
                let items = pieces.flat_map(|piece| piece.chunks(SAMPLES_PER_ITEM));
                own.items.extend(items.map(|samples| ProbeItem {
                    probe: number,
                    strip,
                    samples: samples.to_vec(),
                    sum: ProbeSum::default(),
                }));
            }
            own.shapes.push(probe.shape.clone());
        }
        own
    }

    /// Number of samples of sections.
    pub fn samples_of_sections(&self) -> usize {
        let is_section =
            |item: &&ProbeItem| matches!(self.shapes[item.probe], ProbeShape::Section { .. });
        self.items.iter().filter(is_section).map(|item| item.samples.len()).sum()
    }

    /// Measures: `read` adds samples, numbers of cells with weights, to a sum.
    pub fn measure(&mut self, team: &mut Team, read: impl Fn(&[(u32, f64)], &mut ProbeSum) + Sync) {
        team.for_each(&mut self.items, |_, item| {
            item.sum = ProbeSum::default();
            read(&item.samples, &mut item.sum);
        });
    }

    /// Calls `tell` with the number of each probe, its shape and what was measured there; of a
    /// profile once for each strip.
    pub fn tell(&self, mut tell: impl FnMut(usize, &ProbeShape, &ProbeSum)) {
        self.tell_items(|number, shape, items| {
            let mut sum = ProbeSum::default();
            items.for_each(|item| sum.join(item));
            tell(number, shape, &sum);
        });
    }

    /// The same with the sums of all items of work, for those who add them up by themselves.
    pub fn tell_items(
        &self,
        mut tell: impl FnMut(usize, &ProbeShape, &mut dyn Iterator<Item = &ProbeSum>),
    ) {
        let mut rest = &self.items[..];
        for (number, shape) in self.shapes.iter().enumerate() {
            for strip in 0..strips(shape) {
                let is_of = |item: &ProbeItem| (item.probe, item.strip) == (number, strip);
                let (own, others) = rest.split_at(rest.iter().take_while(|i| is_of(i)).count());
                rest = others;
                tell(number, shape, &mut own.iter().map(|item| &item.sum));
            }
        }
    }
}

/// Strips of a probe, which have a value each.
fn strips(shape: &ProbeShape) -> usize {
    if let ProbeShape::Profile { bins, .. } = shape { *bins } else { 1 }
}

/// The strip of a probe in which a cell lies.
fn strip_of(shape: &ProbeShape, centres: &Centres, at: [i32; 3]) -> usize {
    let ProbeShape::Profile { min, max, along, bins, .. } = shape else { return 0 };
    let part = (centres.of(at)[*along] - min[*along]) / (max[*along] - min[*along]);
    ((part * *bins as f64) as usize).min(bins - 1)
}
