//! What probes measure: weighted means over the fluid cells where they are.

use crate::field::Real;
use crate::grid::Grid;
use crate::lattice::CS2;
use crate::layout::Layout;
use crate::owners::Owners;
use crate::refill::{Before, Content};
use crate::solids::Centres;
use crate::units::Units;
use std::ops::Range;
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
        ProbeShape::Section { .. } => &[("flow_rate", "m³/s"), ("pressure", "Pa")],
        ProbeShape::Region { .. } | ProbeShape::Ring(_) => &REGION,
    }
}

/// How many values a probe of a shape has.
pub fn count(shape: &ProbeShape) -> usize {
    values(shape).len()
}

/// Which of the values of a probe of a shape is the first of the three of a velocity, if it has one.
pub fn first_velocity(shape: &ProbeShape) -> Option<usize> {
    values(shape).iter().position(|(name, _)| *name == "velocity_x")
}

/// Cells that a probe reads, with their weights.
pub fn samples(grid: &Grid, centres: &Centres, shape: &ProbeShape) -> Vec<([i32; 3], f64)> {
    match shape {
        ProbeShape::Point(point) => between(grid, centres, *point),
        ProbeShape::Line { from, to } => {
            let along: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
            let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            // At least two points a cell.
            let count = (2.0 * length / centres.cell).ceil().max(1.0);
            let at = |k: i32| {
                let s = (f64::from(k) + 0.5) / count;
                std::array::from_fn(|a| from[a] + s * along[a])
            };
            (0..count as i32).flat_map(|k| between(grid, centres, at(k))).collect()
        }
        ProbeShape::Section { axis, position, min, max } => {
            let layer = ((position - centres.min[*axis]) / centres.cell).floor() as i32;
            let layer = layer.clamp(0, grid.n[*axis] - 1);
            let mut range = range(grid, centres, min, max);
            range[*axis] = layer..layer + 1;
            each(range)
        }
        ProbeShape::Region { min, max } => each(range(grid, centres, min, max)),
        ProbeShape::Ring(ring) => {
            let [min, max] = ring.corners();
            let centre = |at: [i32; 3]| {
                std::array::from_fn(|a| centres.min[a] + centres.cell * (f64::from(at[a]) + 0.5))
            };
            let mut cells = each(range(grid, centres, &min, &max));
            cells.retain(|(at, _)| ring.holds(centre(*at)));
            cells
        }
    }
}

/// Cells whose centres lie in a box.
fn range(grid: &Grid, centres: &Centres, min: &[f64; 3], max: &[f64; 3]) -> [Range<i32>; 3] {
    std::array::from_fn(|a| {
        let place = |x: f64| (x - centres.min[a]) / centres.cell - 0.5;
        let n = f64::from(grid.n[a]);
        let first = place(min[a]).ceil().clamp(0.0, n) as i32;
        first..(place(max[a]).floor() + 1.0).clamp(0.0, n) as i32
    })
}

fn each([x, y, z]: [Range<i32>; 3]) -> Vec<([i32; 3], f64)> {
    let rows = z.flat_map(|z| y.clone().map(move |y| (y, z)));
    rows.flat_map(|(y, z)| x.clone().map(move |x| ([x, y, z], 1.0))).collect()
}

/// The eight cells around a point, linear weights; at the box's faces the nearest ones.
fn between(grid: &Grid, centres: &Centres, point: [f64; 3]) -> Vec<([i32; 3], f64)> {
    let place: [f64; 3] = std::array::from_fn(|a| (point[a] - centres.min[a]) / centres.cell - 0.5);
    let corner = |k: usize| {
        let mut weight = 1.0;
        let at = std::array::from_fn(|a| {
            let (low, upper) = (place[a].floor(), k >> a & 1);
            let part = place[a] - low;
            weight *= if upper == 1 { part } else { 1.0 - part };
            let cell = low as i32 + upper as i32;
            if grid.periodic[a] { grid.wrap(a, cell) } else { cell.clamp(0, grid.n[a] - 1) }
        });
        (at, weight)
    };
    (0..8).map(corner).filter(|&(_, weight)| weight > 0.0).collect()
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
struct Item {
    probe: usize,
    samples: Vec<(u32, f64)>,
    sum: Sum,
}

/// The probes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    shapes: Vec<ProbeShape>,
    items: Vec<Item>,
}

impl Probes {
    /// Of a scene, in stored cells.
    pub fn new(probes: &[Probe], layout: &Layout, centres: &Centres) -> Self {
        let mut own = Self::default();
        for (number, probe) in probes.iter().enumerate() {
            own.shapes.push(probe.shape.clone());
            let cells: Vec<(u32, f64)> = samples(&layout.grid, centres, &probe.shape)
                .into_iter()
                .filter_map(|(at, weight)| layout.cell(at).map(|cell| (cell, weight)))
                .collect();
            own.items.extend(cells.chunks(SAMPLES_PER_ITEM).map(|samples| Item {
                probe: number,
                samples: samples.to_vec(),
                sum: Sum::default(),
            }));
        }
        own
    }

    /// Appends the values of all probes to `out`, SI units. A probe all of whose cells are covered
    /// reads 0.
    pub fn read<T: Real>(
        &mut self,
        team: &mut Team,
        before: &Before<T>,
        owners: &Owners,
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
                    if owners.is_fluid(cell) {
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
            let mut sum = Sum::default();
            while let Some(item) = items.next_if(|item| item.probe == number) {
                sum.join(&item.sum);
            }
            push(shape, &sum, units, out);
        }
    }
}

/// Appends the values of one probe.
fn push(shape: &ProbeShape, sum: &Sum, units: &Units, out: &mut Vec<f64>) {
    let mean = |x: f64| if sum.fluid > 0.0 { x / sum.fluid } else { 0.0 };
    let pressure = mean(sum.drho) * CS2 * units.pressure();
    let velocity = sum.u.map(|u| mean(u) * units.velocity());
    match shape {
        ProbeShape::Section { axis, .. } => {
            let area = units.cell * units.cell;
            out.extend([sum.u[*axis] * units.velocity() * area, pressure]);
        }
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
