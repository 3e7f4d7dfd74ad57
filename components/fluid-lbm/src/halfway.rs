//! Links at walls at rest that are met half-way: what these walls feel.
//!
//! Such a link costs the fluid nothing, because the next step finds what it reflects where the collision left it
//! (see `places`). The wall feels `2 g_i c_i` of each, in deviations from rest. Links of a block of cells that share
//! direction and fixture are added up together, directly after the block's collision: the sum of `g_i` and its first moments
//! give force and torque.

use crate::cells::Fixture;
use crate::field::{Field, Real};
use crate::lattice::{C_F64, OPPOSITE, cross};
use crate::layout::Layout;
use crate::ledger::add_scaled;
use crate::links::Exchange;
use crate::owners::Owners;
use crate::places::Blocked;

/// Links that are added up side by side.
const LANES: usize = 8;

/// Links of a block, and what their walls felt in the last step.
#[derive(Clone, Debug, Default)]
pub struct HalfwayLinks {
    runs: Vec<Run>,
    /// For each fixture that the links meet, its exchange.
    pub exchanges: Vec<(Fixture, Exchange)>,
}

/// Links that share direction and fixture.
#[derive(Clone, Debug)]
struct Run {
    /// Place of the fixture in the list.
    fixture: usize,
    /// Direction, out of the fluid.
    dir: usize,
    cells: Vec<u32>,
    /// From the fixture's reference to the first cell, the shortest way.
    arm: [f64; 3],
    /// From there to each cell; whole numbers.
    steps: [Vec<f32>; 3],
}

impl HalfwayLinks {
    /// Of a block; `references` are the points about which torques count.
    pub fn new(layout: &Layout, links: &[Blocked], references: &[[f64; 3]]) -> Self {
        let mut links = links.to_vec();
        links.sort_by_key(|link| (link.fixture, link.dir, link.cell));
        let mut own = Self::default();
        for run in links.chunk_by(|a, b| (a.fixture, a.dir) == (b.fixture, b.dir)) {
            let Blocked { fixture, dir, .. } = run[0];
            if own.exchanges.last().is_none_or(|last| last.0 != fixture) {
                own.exchanges.push((fixture, Exchange::default()));
            }
            let reference = references[usize::from(fixture.0)];
            let arm = |cell: u32| layout.grid.arm(reference, layout.at(cell));
            let first = arm(run[0].cell);
            own.runs.push(Run {
                fixture: own.exchanges.len() - 1,
                dir: dir.into(),
                cells: run.iter().map(|link| link.cell).collect(),
                arm: first,
                steps: std::array::from_fn(|a| {
                    run.iter().map(|link| (arm(link.cell)[a] - first[a]).round() as f32).collect()
                }),
            });
        }
        own
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

    /// Adds up what the walls feel of the block, once it has collided.
    pub fn feel<T: Real>(&mut self, field: &Field<T>, stride: usize, owners: &Owners) {
        for (_, exchange) in &mut self.exchanges {
            *exchange = Exchange::default();
        }
        for run in &self.runs {
            let plane = OPPOSITE[run.dir] * stride;
            let ([sum, moments @ ..], links) = run.add_up(field, plane, owners);
            let c = C_F64[run.dir].map(|c| 2.0 * c);
            let mut arm = moments;
            add_scaled(&mut arm, run.arm, sum);
            let exchange = &mut self.exchanges[run.fixture].1;
            add_scaled(&mut exchange.force, c, sum);
            add_scaled(&mut exchange.torque, cross(arm, c), 1.0);
            exchange.links += links;
        }
    }
}

impl Run {
    /// The sum of `g_i` and its first moments about the first cell, and the number of links, of fluid cells.
    fn add_up<T: Real>(
        &self,
        field: &Field<T>,
        plane: usize,
        owners: &Owners,
    ) -> ([f64; 4], usize) {
        let all_fluid = owners.all_fluid();
        let mut sums = [[0.0; LANES]; 4];
        let mut links = 0;
        let [x, y, z] = self.steps.each_ref().map(|steps| steps.chunks(LANES));
        for (((cells, x), y), z) in self.cells.chunks(LANES).zip(x).zip(y).zip(z) {
            let (mut g, mut steps) = ([0.0; LANES], [[0.0; LANES]; 3]);
            for (lane, &cell) in cells.iter().enumerate() {
                let is_fluid = all_fluid || owners.is_fluid(cell);
                g[lane] = if is_fluid { field.get(plane + cell as usize) } else { 0.0 };
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
