//! The solver in one precision: the order of a step.

use crate::bodies::{Bodies, Body};
use crate::collision::Relaxation;
use crate::error::FluidError;
use crate::field::Field;
use crate::grid::{Grid, Parity};
use crate::kernel::{Collides, Kernel, Survey, Sweep};
use crate::lanes::Variant;
use crate::ledger::{Ledger, add_scaled};
use crate::links::{self, After, Exchange};
use crate::owners::{Owners, Vacated};
use crate::parameters::{Collision, Parameters};
use crate::refill::{Before, Content};
use crate::units::Units;
use crate::walls::{self, Wall};
use tremie_messages::scene::Scene;
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_team::Team;

/// Cells of the block of rows that is one item of work of the collision. Blocks are added up in
/// their order.
const CELLS_PER_BLOCK: usize = 4096;

/// A block of rows of the box.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) rows: std::ops::Range<usize>,
    pub(crate) survey: Survey,
}

/// A cell to refill, and what it then holds.
#[derive(Clone, Copy, Debug)]
struct Refill {
    vacated: Vacated,
    content: Content,
}

/// The fluid before the next collision, borrowing no more of the solver than that takes.
macro_rules! before {
    ($solver:expr) => {
        $crate::refill::Before {
            field: &$solver.field,
            grid: &$solver.grid,
            parity: $solver.parity,
            acceleration: $solver.relaxation.acceleration,
        }
    };
}
pub(crate) use before;

/// A lattice-Boltzmann fluid in the precision `T`. See [`crate::FluidLbm`] for the meaning of its
/// methods.
pub struct Solver<T: Collides> {
    pub(crate) units: Units,
    pub(crate) grid: Grid,
    pub(crate) field: Field<T>,
    pub(crate) owners: Owners,
    pub(crate) bodies: Bodies,
    pub(crate) relaxation: Relaxation,
    /// Parity of the next collision.
    pub(crate) parity: Parity,
    pub(crate) tau: f64,
    pub(crate) mach_limit: f64,
    pub(crate) average_force: bool,
    /// Force per volume of a body by hydrostatic pressure and mean pressure gradient.
    pub(crate) lift: [f64; 3],
    kernel: Kernel<T>,
    pub(crate) team: Team,
    pub(crate) walls: Vec<Wall>,
    pub(crate) blocks: Vec<Block>,
    pub(crate) wall_items: Vec<walls::Item>,
    pub(crate) link_items: Vec<links::Item>,
    refills: Vec<Refill>,
    /// The last step's balance, in lattice units and in SI.
    pub(crate) balance: Ledger,
    pub(crate) ledger: Ledger,
    /// What the last collision found, and the sum of all links' exchange after it.
    pub(crate) survey: Survey,
    pub(crate) exchange: Exchange,
}

impl<T: Collides> Solver<T> {
    /// See [`crate::FluidLbm::new`].
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
        variant: Variant,
    ) -> Result<Self, Vec<Problem>> {
        let resolution = parameters.resolve(scene)?;
        let mut problems = Vec::new();
        let fluid = scene.fluid.as_ref().expect("a scene that was resolved has a fluid");
        parameters.check_step(fluid, time_step, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let units = Units {
            cell: resolution.cell,
            time_step,
            density: fluid.density,
            min: scene.domain.min,
        };
        let tau = parameters.tau_of(time_step, fluid.viscosity / fluid.density);
        let acceleration = fluid.acceleration.map(|a| a / units.acceleration());
        let relaxation = match parameters.collision {
            Collision::Bgk => Relaxation::single(tau, acceleration),
            Collision::Trt => Relaxation::with_magic(tau, parameters.magic, acceleration),
        };
        let team = Team::new("fluid", threads).map_err(|error| {
            vec![Problem::new(
                "threads",
                format!("the system does not give {threads} threads: {error}"),
            )]
        })?;
        let grid =
            Grid::new(resolution.cells, std::array::from_fn(|a| scene.domain.is_periodic(a)));
        let walls = walls::walls(&grid);
        let mut solver = Self {
            units,
            field: Field::new(grid.len),
            owners: Owners::new(&grid),
            bodies: Bodies::default(),
            relaxation,
            parity: Parity::Even,
            tau,
            mach_limit: parameters.mach_limit,
            average_force: parameters.average_force,
            lift: std::array::from_fn(|a| {
                acceleration[a] - scene.gravity[a] / units.acceleration()
            }),
            kernel: T::kernel(variant),
            team,
            blocks: blocks(&grid),
            wall_items: walls::items(&walls, &grid),
            walls,
            link_items: Vec::new(),
            refills: Vec::new(),
            balance: Ledger::default(),
            ledger: Ledger::default(),
            survey: Survey { min_drho: 0.0, max_drho: 0.0, ..Survey::NONE },
            exchange: Exchange::default(),
            grid,
        };
        let velocity = fluid.velocity;
        solver.set_state(|_| (velocity, 0.0));
        Ok(solver)
    }

    /// See [`crate::FluidLbm::apply_events`].
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        if events.is_empty() {
            return Ok(());
        }
        self.bodies.apply(events, &self.units, &self.grid)?;
        self.link_items = links::items(&self.bodies);
        // A body's changes in a step are less than its shell's rows, see `Body::new`.
        let shell = |b: &Body| (b.spans.shell_side() * b.spans.shell_side()) as usize;
        let changes = self.bodies.living.iter().map(shell).sum::<usize>();
        self.owners.reserve(changes);
        self.refills.reserve(changes.saturating_sub(self.refills.len()));
        Ok(())
    }

    /// See [`crate::FluidLbm::start`].
    pub fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.check(bodies, loads.len())?;
        self.begin_balance();
        self.move_bodies(bodies);
        self.measure();
        self.exchange = Exchange::default();
        for item in &mut self.link_items {
            item.exchange = Exchange::default();
        }
        self.give_loads(loads);
        self.end_balance(false);
        Ok(())
    }

    /// See [`crate::FluidLbm::step`].
    pub fn step(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.check(bodies, loads.len())?;
        self.begin_balance();
        self.move_bodies(bodies);
        self.collide();
        self.reflect();
        self.parity = self.parity.flipped();
        self.give_loads(loads);
        self.end_balance(true);
        Ok(())
    }

    /// Moves the bodies: covers and uncovers cells, refills.
    fn move_bodies(&mut self, states: &[BodyState]) {
        self.owners.begin();
        if !self.bodies.take(states, &self.units, &self.grid) {
            return;
        }
        let grid = &self.grid;
        self.team.for_each(&mut self.bodies.living, |_, body| body.cover(grid));
        for body in self.bodies.leaving.iter().chain(&self.bodies.living) {
            for &cell in &body.left {
                self.owners.release(cell, body.handle);
            }
        }
        for body in &self.bodies.living {
            for &cell in &body.entered {
                self.owners.claim(cell, body.handle);
            }
        }
        self.owners.settle(grid);
        self.count_losses();
        self.refill();
        self.owners.admit();
        self.bodies.forget_leaving();
    }

    /// The fluid before the next collision.
    pub(crate) fn before(&self) -> Before<'_, T> {
        before!(self)
    }

    /// Balances what left the fluid with covered and isolated cells.
    fn count_losses(&mut self) {
        let mut balance = self.balance;
        let before = self.before();
        for &cell in &self.owners.covered {
            let content = before.content(self.grid.cell_of(cell as usize));
            add_scaled(&mut balance.covered, content.j, -1.0);
            balance.mass_covered -= 1.0 + content.drho;
        }
        for &cell in &self.owners.enclosed {
            let content = before.content(self.grid.cell_of(cell as usize));
            add_scaled(&mut balance.isolated, content.j, -1.0);
            balance.mass_isolated -= 1.0 + content.drho;
        }
        self.balance = balance;
    }

    /// Fills the cells that joined the fluid.
    fn refill(&mut self) {
        self.refills.clear();
        for &vacated in &self.owners.vacated {
            self.refills.push(Refill { vacated, content: Content::default() });
        }
        let before = before!(self);
        let (owners, bodies) = (&self.owners, &self.bodies);
        self.team.for_each(&mut self.refills, |_, refill| {
            let body = bodies.any_with_handle(refill.vacated.handle);
            let cell = before.grid.cell_of(refill.vacated.cell as usize);
            refill.content = before.refill(owners, cell, body);
        });
        for refill in &self.refills {
            add_scaled(&mut self.balance.uncovered, refill.content.j, 1.0);
            self.balance.mass_uncovered += 1.0 + refill.content.drho;
        }
    }

    /// Collides and streams all fluid cells.
    fn collide(&mut self) {
        let sweep = Sweep {
            field: &self.field,
            grid: &self.grid,
            fluid: self.owners.fluid_bits(),
            parity: self.parity,
            relaxation: &self.relaxation,
        };
        let kernel = self.kernel;
        self.team.for_each(&mut self.blocks, |_, block| {
            // SAFETY: the variant was checked when the kernel was chosen; blocks are disjoint, and
            // so are the places of their cells; field and bits were made for this grid; nothing
            // else runs.
            block.survey = unsafe { kernel(&sweep, block.rows.clone()) };
        });
        self.join_surveys();
    }

    /// Adds up the blocks.
    pub(crate) fn join_surveys(&mut self) {
        self.survey = Survey::NONE;
        for block in &self.blocks {
            self.survey.join(&block.survey);
        }
    }

    /// Reflects the populations that ran into walls and bodies.
    fn reflect(&mut self) {
        let after = After {
            field: &self.field,
            grid: &self.grid,
            owners: &self.owners,
            parity: self.parity,
        };
        let (walls, bodies) = (&self.walls, &self.bodies);
        self.team.for_each(&mut self.wall_items, |_, item| walls::reflect(&after, walls, item));
        self.team.for_each(&mut self.link_items, |_, item| after.reflect(bodies, item));
    }
}

/// The box cut into blocks.
fn blocks(grid: &Grid) -> Vec<Block> {
    let step = (CELLS_PER_BLOCK / grid.n[0] as usize).max(1);
    (0..grid.rows())
        .step_by(step)
        .map(|first| Block { rows: first..(first + step).min(grid.rows()), survey: Survey::NONE })
        .collect()
}
