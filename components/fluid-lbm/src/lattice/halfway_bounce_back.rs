//! Links at walls at rest that are met half-way: what these walls feel.
//!
//! Such a link costs the fluid nothing, because the next step finds what it reflects where the
//! collision left it (see `aa_pattern`). The wall feels `2 g_i c_i` of each, in deviations from
//! rest. Links of a block of cells that share direction and fixture are added up together, directly
//! after the block's collision: the sum of `g_i` and its first moments give force and torque.

use crate::lattice::aa_pattern::Blocked;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C_F64, OPPOSITE, cross};
use crate::lattice::layout::Layout;
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::{Field, Real};
use tremie_team::{Variant, instructions::Work};

/// Links that are added up side by side.
const LANES: usize = 8;

/// Links of a block, and what their walls felt in the last step.
#[derive(Clone, Debug, Default)]
pub struct HalfwayLinks {
    runs: Vec<HalfwayRun>,
    /// For each fixture that the links meet, its exchange.
    pub exchanges: Vec<(BoundaryId, MomentumExchange)>,
}

/// Links that share direction and fixture.
#[derive(Clone, Debug)]
struct HalfwayRun {
    /// Place of the fixture in the list.
    fixture: usize,
    /// Direction, out of the fluid.
    dir: usize,
    /// The cell with the lowest number.
    first: u32,
    /// From the fixture's reference to the first of the links' cells, the shortest way.
    arm: [f64; 3],
    links: usize,
    /// The links; at the end of the last eight some that count nothing.
    eights: Vec<Eight>,
}

/// The cells of eight links: a block has fewer than these numbers hold.
#[derive(Clone, Copy, Debug, Default)]
struct Eight {
    /// Numbers from the lowest one.
    cells: [u16; LANES],
    /// From the cell of the run's first link.
    steps: [[i16; LANES]; 3],
}

impl HalfwayLinks {
    /// Of a block; `references` are the points about which torques count.
    pub fn new(layout: &Layout, links: &[Blocked], references: &[[f64; 3]]) -> Self {
        let mut links = links.to_vec();
        links.sort_by_key(|link| (link.fixture, link.dir, link.cell));
        let mut own = Self::default();
        for run in links.chunk_by(|a, b| (a.fixture, a.dir) == (b.fixture, b.dir)) {
            let fixture = run[0].fixture;
            if own.exchanges.last().is_none_or(|last| last.0 != fixture) {
                own.exchanges.push((fixture, MomentumExchange::default()));
            }
            let reference = references[usize::from(fixture.0)];
            let arm = |cell: u32| layout.grid.arm(reference, layout.at(cell));
            let mut rest = run;
            while let [first, ..] = rest {
                let origin = arm(first.cell);
                let is_near = |link: &&Blocked| {
                    let to = arm(link.cell);
                    (0..3).all(|a| (to[a] - origin[a]).abs() < f64::from(i16::MAX))
                };
                let (near, far) = rest.split_at(rest.iter().take_while(is_near).count());
                own.runs.push(HalfwayRun::new(own.exchanges.len() - 1, near, arm));
                rest = far;
            }
        }
        own
    }

    /// Cell and direction of each link.
    pub fn ends(&self) -> impl Iterator<Item = (u32, u8)> {
        self.runs.iter().flat_map(|run| {
            let all = run.eights.iter().flat_map(|eight| eight.cells).take(run.links);
            all.map(|cell| (run.first + u32::from(cell), run.dir as u8))
        })
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.runs.iter().map(|run| size_of_val(run.eights.as_slice())).sum()
    }

    /// Adds up what the walls feel of the block, once it has collided.
    pub fn feel<T: Real>(
        &mut self,
        variant: Variant,
        field: &Field<T>,
        stride: usize,
        flags: &CellFlags,
    ) {
        for (_, exchange) in &mut self.exchanges {
            *exchange = MomentumExchange::default();
        }
        let exchanges = &mut self.exchanges[..];
        for run in &self.runs {
            let plane = OPPOSITE[run.dir] * stride + run.first as usize;
            let exchange = &mut exchanges[run.fixture].1;
            variant.run(Feel { run, field, plane, flags, exchange });
        }
    }
}

impl HalfwayRun {
    /// Of links that share direction and fixture, which is in this place of the list.
    fn new(fixture: usize, links: &[Blocked], arm: impl Fn(u32) -> [f64; 3]) -> Self {
        let first = links.iter().map(|link| link.cell).min().unwrap_or_default();
        let origin = arm(links[0].cell);
        let eight = |links: &[Blocked]| {
            let mut eight = Eight::default();
            for (lane, link) in links.iter().enumerate() {
                eight.cells[lane] = (link.cell - first) as u16;
                for (a, x) in arm(link.cell).into_iter().enumerate() {
                    eight.steps[a][lane] = (x - origin[a]).round() as i16;
                }
            }
            eight
        };
        Self {
            fixture,
            dir: links[0].dir.into(),
            first,
            arm: origin,
            links: links.len(),
            eights: links.chunks(LANES).map(eight).collect(),
        }
    }
}

/// Adding up what a wall feels of a run.
struct Feel<'a, T: Real> {
    run: &'a HalfwayRun,
    field: &'a Field<T>,
    /// Place at which the collision left the first cell's population of the direction.
    plane: usize,
    flags: &'a CellFlags,
    exchange: &'a mut MomentumExchange,
}

impl<T: Real> Work for Feel<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { run, field, plane, flags, exchange } = self;
        let all_fluid = flags.all_fluid();
        // The sum of `g_i` of fluid cells, and its first moments about the first cell.
        let mut sums = [[0.0; LANES]; 4];
        let (mut links, mut left) = (0, run.links);
        for eight in &run.eights {
            let mut g = [0.0; LANES];
            for (g, cell) in g.iter_mut().zip(eight.cells).take(left) {
                let is_fluid = all_fluid || flags.is_fluid(run.first + u32::from(cell));
                *g = if is_fluid { field.get(plane + usize::from(cell)) } else { 0.0 };
                links += usize::from(is_fluid);
            }
            left = left.saturating_sub(LANES);
            for lane in 0..LANES {
                sums[0][lane] += g[lane];
                for a in 0..3 {
                    sums[a + 1][lane] += g[lane] * f64::from(eight.steps[a][lane]);
                }
            }
        }
        let [sum, moments @ ..] = sums.map(|lanes| lanes.iter().sum());
        let c = C_F64[run.dir].map(|c| 2.0 * c);
        let mut arm: [f64; 3] = moments;
        add_scaled(&mut arm, run.arm, sum);
        add_scaled(&mut exchange.force, c, sum);
        add_scaled(&mut exchange.torque, cross(arm, c), 1.0);
        exchange.links += links;
    }
}
