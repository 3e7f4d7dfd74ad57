//! Links at walls at rest that are met half-way: what these walls feel.
//!
//! Such a link costs the fluid nothing, because the next step finds what it reflects where the collision left it
//! (see `places`). The wall feels `2 g_i c_i` of each, in deviations from rest. Links of some cells that share
//! direction and fixture are added up together: the sum of `g_i` and its first moments give force and torque, and
//! planes of populations are read in the order of cells.

use crate::cells::Fixture;
use crate::field::Real;
use crate::lattice::{C_F64, OPPOSITE, cross};
use crate::layout::Layout;
use crate::ledger::add_scaled;
use crate::links::{After, Exchange};
use crate::places::Blocked;

/// Links that are one item of work, about.
const LINKS_PER_ITEM: usize = 4096;
/// Links that are added up side by side.
const LANES: usize = 8;
/// How many links ahead of its use memory is asked for.
const AHEAD: usize = 32;

/// Some links, and what their walls felt in the last step.
#[derive(Clone, Debug)]
pub struct Item {
    runs: Vec<Run>,
    /// For each fixture that the links meet, its exchange.
    pub exchanges: Vec<(Fixture, Exchange)>,
}

/// Links that share direction and fixture.
#[derive(Clone, Debug)]
struct Run {
    /// Place of the fixture in the item's list.
    fixture: usize,
    /// Direction, out of the fluid.
    dir: usize,
    cells: Vec<u32>,
    /// From the fixture's reference to the first cell, the shortest way.
    arm: [f64; 3],
    /// From there to each cell; whole numbers.
    steps: [Vec<f32>; 3],
}

/// The items of links in the order of cells; `references` are the points about which torques count.
pub fn items(layout: &Layout, links: &[Blocked], references: &[[f64; 3]]) -> Vec<Item> {
    let mut items = Vec::new();
    let mut rest = links;
    while !rest.is_empty() {
        // All links of a cell are in one item.
        let last = rest[rest.len().min(LINKS_PER_ITEM) - 1].cell;
        let (own, next) = rest.split_at(rest.partition_point(|link| link.cell <= last));
        items.push(Item::new(layout, own.to_vec(), references));
        rest = next;
    }
    items
}

impl Item {
    fn new(layout: &Layout, mut links: Vec<Blocked>, references: &[[f64; 3]]) -> Self {
        links.sort_by_key(|link| (link.fixture, link.dir, link.cell));
        let mut item = Self { runs: Vec::new(), exchanges: Vec::new() };
        for run in links.chunk_by(|a, b| (a.fixture, a.dir) == (b.fixture, b.dir)) {
            let Blocked { fixture, dir, .. } = run[0];
            if item.exchanges.last().is_none_or(|last| last.0 != fixture) {
                item.exchanges.push((fixture, Exchange::default()));
            }
            let reference = references[usize::from(fixture.0)];
            let arm = |cell: u32| layout.grid.arm(reference, layout.at(cell));
            let first = arm(run[0].cell);
            item.runs.push(Run {
                fixture: item.exchanges.len() - 1,
                dir: dir.into(),
                cells: run.iter().map(|link| link.cell).collect(),
                arm: first,
                steps: std::array::from_fn(|a| {
                    run.iter().map(|link| (arm(link.cell)[a] - first[a]).round() as f32).collect()
                }),
            });
        }
        item
    }

    /// Cell and direction of each link.
    pub fn ends(&self) -> impl Iterator<Item = (u32, u8)> {
        let runs = self.runs.iter();
        runs.flat_map(|run| run.cells.iter().map(|&cell| (cell, run.dir as u8)))
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.runs.iter().map(|run| 16 * run.cells.len()).sum()
    }
}

impl<T: Real> After<'_, T> {
    /// Adds up what the walls of an item's links feel.
    pub fn feel_halfway(&self, item: &mut Item) {
        for (_, exchange) in &mut item.exchanges {
            *exchange = Exchange::default();
        }
        for run in &item.runs {
            let ([sum, moments @ ..], links) = self.add_up(run);
            let c = C_F64[run.dir].map(|c| 2.0 * c);
            let mut arm = moments;
            add_scaled(&mut arm, run.arm, sum);
            let exchange = &mut item.exchanges[run.fixture].1;
            add_scaled(&mut exchange.force, c, sum);
            add_scaled(&mut exchange.torque, cross(arm, c), 1.0);
            exchange.links += links;
        }
    }

    /// The sum of `g_i` and its first moments about the run's first cell, and the number of links, of fluid cells.
    fn add_up(&self, run: &Run) -> ([f64; 4], usize) {
        let plane = OPPOSITE[run.dir] * self.layout.places.stride();
        let all_fluid = self.owners.all_fluid();
        let mut sums = [[0.0; LANES]; 4];
        let mut links = 0;
        let [x, y, z] = run.steps.each_ref().map(|steps| steps.chunks(LANES));
        let chunks = run.cells.chunks(LANES).zip(x).zip(y).zip(z).enumerate();
        for (number, (((cells, x), y), z)) in chunks {
            for &cell in run.cells.iter().skip(number * LANES + AHEAD).take(LANES).step_by(2) {
                self.field.prefetch(plane + cell as usize);
            }
            let (mut g, mut steps) = ([0.0; LANES], [[0.0; LANES]; 3]);
            for (lane, &cell) in cells.iter().enumerate() {
                let is_fluid = all_fluid || self.owners.is_fluid(cell);
                g[lane] = if is_fluid { self.field.get(plane + cell as usize) } else { 0.0 };
                links += usize::from(is_fluid);
                for (step, along) in steps.iter_mut().zip([x, y, z]) {
                    step[lane] = f64::from(along[lane]);
                }
            }
            for lane in 0..LANES {
                sums[0][lane] += g[lane];
                for a in 0..3 {
                    sums[a + 1][lane] += g[lane] * steps[a][lane];
                }
            }
        }
        (sums.map(|lanes| lanes.iter().sum()), links)
    }
}
