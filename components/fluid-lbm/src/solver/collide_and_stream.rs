//! Collision and streaming of all fluid cells, in one array:
//!
//! ```text
//! f_i(x + c_i, t + 1) = g_i(x, t)        g = f - (f - feq)/tau + force       (see `collision`)
//! ```
//!
//! In the AA pattern (Bailey et al. 2009) the addresses of populations see to half-way walls,
//! mirrors and periodic faces.

use crate::boundary::boundaries::Built;
use crate::boundary::gap_sinks::GapTables;
use crate::boundary::post_collision::{PostCollision, nearest_wall};
use crate::lattice::collision_kernel::{
    CellBlock, CollisionKernel, DensityRequests, Kernel, Sweep,
};
use crate::lattice::d3q19::dot;
use crate::lattice::exact_sum::values;
use crate::lattice::halfway_bounce_back::HalfwayLinks;
use crate::lattice::layout::{CELLS_PER_BLOCK, Layout};
use crate::lattice::populations::Field;
use crate::lattice::reductions::CellStatistics;
use crate::lattice::reflection_impulse::ReflectionImpulse;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::solver::execution::Execution;
use crate::solver::lattice_state::LatticeState;
use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use tremie_state::{StateError, StateExchange};
use tremie_team::Variant;

/// The loop over all cells, and what it finds in passing.
pub struct CollideAndStream<T: CollisionKernel> {
    kernel: Kernel<T>,
    /// Consecutive lines that are one item of work, with what walls on their way felt.
    pub blocks: Vec<CellBlock>,
    /// Links that walls and mirrors reflect on their way.
    pub tally: ReflectionImpulse,
    /// Densities that the links of bodies will need.
    pub requests: DensityRequests<T>,
}

impl<T: CollisionKernel> CollideAndStream<T> {
    /// Of the cells that were laid out; `references` are the points about which torques on fixtures
    /// count.
    pub fn new(built: &Built<T>, references: &[[f64; 3]], variant: Variant) -> Self {
        let count = built.layout.places.lines().len();
        let step = CELLS_PER_BLOCK as usize / T::LINE;
        let ranges: Vec<_> =
            (0..count).step_by(step).map(|first| first..(first + step).min(count)).collect();
        let tally = ReflectionImpulse::new(&built.reflections, &ranges, T::LINE);
        let halfway_in = |lines: &Range<usize>| {
            let before = |line: usize| {
                built.halfway.partition_point(|link| (link.cell as usize) < line * T::LINE)
            };
            let links = &built.halfway[before(lines.start)..before(lines.end)];
            HalfwayLinks::new(&built.layout, links, references)
        };
        let block = |(number, lines): (usize, &Range<usize>)| CellBlock {
            lines: lines.clone(),
            survey: CellStatistics::NONE,
            reflected: vec![0.0; tally.runs(number).len()],
            halfway: halfway_in(lines),
        };
        Self {
            kernel: T::kernel(variant),
            blocks: ranges.iter().enumerate().map(block).collect(),
            tally,
            requests: DensityRequests { lines: Vec::new(), left: 0, drho: Field::zeros(0) },
        }
    }

    /// Collides and streams all fluid cells: first those that this rank counts, while copies of others' may still be
    /// on their way.
    pub fn step(&mut self, lattice: &mut LatticeState<T>, exec: &mut Execution) {
        let own = lattice.layout.own_blocks();
        self.collide(own.clone(), lattice, exec);
        lattice.end_refresh(&mut exec.ranks);
        self.collide(0..own.start, lattice, exec);
        self.collide(own.end..self.blocks.len(), lattice, exec);
        let (field, fluid, tally) = (&lattice.field, lattice.flags.fluid_bits(), &self.tally);
        if tally.is_late() {
            exec.team.for_each(&mut self.blocks, |number, block| {
                tally.sum_late(field, fluid, number, &mut block.reflected);
            });
        }
        self.join_statistics(lattice, exec);
    }

    /// Collides and streams the fluid cells of some blocks.
    fn collide(&mut self, blocks: Range<usize>, lattice: &LatticeState<T>, exec: &mut Execution) {
        let sweep = Sweep {
            field: &lattice.field,
            places: &lattice.layout.places,
            fluid: lattice.flags.fluid_bits(),
            parity: lattice.parity,
            relaxation: &lattice.relaxation,
            tally: &self.tally,
            wanted: &self.requests,
        };
        let (kernel, stride) = (self.kernel, lattice.layout.places.stride());
        let (variant, flags) = (exec.variant, &lattice.flags);
        let first = blocks.start;
        exec.team.for_each(&mut self.blocks[blocks], |number, block| {
            let number = first + number;
            // SAFETY: the variant was checked when the kernel was chosen; blocks are disjoint, and
            // so are the places of their cells; all tables were made for these cells; nothing else
            // runs.
            unsafe { kernel(&sweep, number, block) };
            block.halfway.feel(variant, sweep.field, stride, flags);
        });
    }

    /// Finds the statistics of the fluid as it stands, without a collision.
    pub fn measure(&mut self, lattice: &mut LatticeState<T>, exec: &mut Execution) {
        let (before, flags) = (lattice.before(), &lattice.flags);
        exec.team.for_each(&mut self.blocks, |_, block| {
            let mut survey =
                CellStatistics { min_drho: 0.0, max_drho: 0.0, ..CellStatistics::NONE };
            let first = block.lines.start * T::LINE;
            let end = (block.lines.end * T::LINE).min(before.layout.cells.len());
            for cell in (first as u32..end as u32).filter(|&cell| flags.is_fluid(cell)) {
                let content = before.content(cell);
                let u = content.velocity(before.acceleration);
                survey.join(&CellStatistics {
                    excess: content.drho,
                    j: content.j,
                    speed2: dot(u, u),
                    min_drho: content.drho,
                    max_drho: content.drho,
                    max_tau: 0.0,
                });
            }
            block.survey = survey;
        });
        self.join_statistics(lattice, exec);
    }

    /// Adds up the blocks, of all ranks.
    fn join_statistics(&self, lattice: &mut LatticeState<T>, exec: &mut Execution) {
        let own = self.own_blocks(&lattice.layout);
        let (mut sums, mut all) = CellStatistics::of_blocks(own.map(|block| &block.survey));
        let mut cells = [lattice.flags.fluid_cells as i64];
        exec.ranks.add_up(&mut sums);
        exec.ranks.count(&mut cells);
        [all.speed2, all.min_drho, all.max_drho, all.max_tau] =
            exec.ranks.largest([all.speed2, -all.min_drho, all.max_drho, all.max_tau]);
        all.min_drho = -all.min_drho;
        let [excess, j @ ..] = values(&sums);
        lattice.statistics = CellStatistics { excess, j, ..all };
        lattice.fluid_cells = cells[0] as usize;
    }

    /// The blocks whose cells this part of the lattice counts.
    fn own_blocks(&self, layout: &Layout) -> impl Iterator<Item = &CellBlock> {
        self.blocks[layout.own_blocks()].iter()
    }

    /// The fluid after the collision, whose links are to be reflected.
    pub fn after<'a>(
        &'a self,
        lattice: &'a LatticeState<T>,
        gaps: &'a GapTables,
        keeps_mass: bool,
        variant: Variant,
    ) -> PostCollision<'a, T> {
        PostCollision {
            field: &lattice.field,
            layout: &lattice.layout,
            flags: &lattice.flags,
            bricks: &lattice.changes,
            parity: lattice.parity,
            drho: &self.requests.drho,
            variant,
            mean: lattice.mean_density(),
            keeps_mass,
            nearest_wall: nearest_wall(lattice.tau),
            gaps,
        }
    }

    /// Keeps which densities are wanted, or puts it back.
    ///
    /// # Errors
    /// A state of another lattice.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        layout: &Layout,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError> {
        let mut are_wanted = !self.requests.lines.is_empty();
        state.value("are_wanted", &mut are_wanted)?;
        state.value("wanted_for", &mut self.requests.left)?;
        if !are_wanted {
            return Ok(());
        }
        self.make_room(layout);
        let (restores, lines) = (state.restores(), &self.requests.lines);
        let rows = numbers.rows_of(T::LINE);
        state.shared_array("wanted_lines", &rows, |first, wanted: &mut [u8]| {
            let Some(cell) = numbers.here((first * T::LINE) as u32) else { return };
            for (line, wanted) in lines[cell as usize / T::LINE..].iter().zip(wanted) {
                match restores {
                    true => line.store(*wanted, Relaxed),
                    false => *wanted = line.load(Relaxed),
                }
            }
        })
    }

    /// Makes room for the densities that links of bodies need, once there are bodies.
    pub fn make_room(&mut self, layout: &Layout) {
        if self.requests.lines.is_empty() {
            let lines = layout.places.lines().len();
            self.requests.lines.resize_with(lines, AtomicU8::default);
            self.requests.drho = Field::zeros(lines * T::LINE);
        }
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.tally.bytes()
            + self.blocks.iter().map(|block| block.halfway.bytes()).sum::<usize>()
            + self.requests.bytes()
    }
}
