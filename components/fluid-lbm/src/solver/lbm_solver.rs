//! The solver in one precision: what it is made of, and the order of a step.

use crate::bodies::body::Body;
use crate::bodies::body::UnionShare;
use crate::bodies::body_list::Bodies;
use crate::bodies::body_shapes::BodyShapes;
use crate::bodies::change_blocks::ChangeBlocks;
use crate::bodies::deformable_surface::SoftSurface;
use crate::bodies::mesh_body::Rounding;
use crate::boundary::boundaries::Boundaries;
use crate::boundary::gap_sinks::GapSinks;
use crate::boundary::link_batch::Batch;
use crate::boundary::open_boundary::{self, OpenCells};
use crate::boundary::post_collision::{self};
use crate::boundary::refill::PreCollision;
use crate::boundary::sheet_links::{SheetItem, SheetLinks};
use crate::boundary::static_wall_links::{self, StaticWallLinks};
use crate::boundary::virtual_piston::face::ReservoirFace;
use crate::boundary::wall_distances::WallDistances;
use crate::boundary::wall_mass::{Brought, Patches};
use crate::domain::boundary_condition::BoundaryValue;
use crate::domain::parameters::{Collision, GapPressure, OpenFaces, Parameters, Refill};
use crate::domain::solids::Centres;
use crate::domain::static_geometry::StaticGeometry;
use crate::gaps::modelled::ModelledGaps;
use crate::gaps::specular_walls::SpecularWalls;
use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::collision::Relaxation;
use crate::lattice::collision_kernel::{
    CellBlock, CollisionKernel, DensityRequests, Kernel, Sweep,
};
use crate::lattice::d3q19::CS2;
use crate::lattice::error::FluidError;
use crate::lattice::halfway_bounce_back::HalfwayLinks;
use crate::lattice::layout::Layout;
use crate::lattice::ledger::Ledger;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Field;
use crate::lattice::reductions::CellStatistics;
use crate::lattice::reflection_impulse::ReflectionImpulse;
use crate::lattice::units::Units;
use crate::solver::gap_pressure::{InGaps, Seen, UNKNOWN};
use crate::solver::lost_mass::Lost;
use crate::solver::moving_boundaries::Filled;
use crate::solver::pinched_cells::Pinched;
use crate::solver::ports::PortFaces;
use crate::solver::probes::Probes;
use crate::solver::section_flux::Sight;
use std::sync::atomic::AtomicU8;
use tremie_messages::scene::{Part, Scene};
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_team::{Choice, Found, Team, Variant};

/// Cells that are one item of work of the collision. Blocks are added up in their order.
const CELLS_PER_BLOCK: usize = 4096;

/// The fluid before the next collision, borrowing no more of the solver than that takes.
macro_rules! before {
    ($solver:expr) => {
        $crate::boundary::refill::PreCollision {
            field: &$solver.field,
            layout: &$solver.layout,
            parity: $solver.parity,
            acceleration: $solver.relaxation.acceleration,
        }
    };
}
pub(crate) use before;

/// A lattice-Boltzmann fluid in the precision `T`. See [`crate::LbmFluid`] for the meaning of its
/// methods.
pub struct LbmSolver<T: CollisionKernel> {
    pub(crate) units: Units,
    pub(crate) layout: Layout,
    pub(crate) field: Field<T>,
    pub(crate) owners: CellFlags,
    pub(crate) bricks: ChangeBlocks,
    pub(crate) wanted: DensityRequests<T>,
    pub(crate) bodies: Bodies,
    pub(crate) relaxation: Relaxation,
    /// Parity of the next collision.
    pub(crate) parity: Parity,
    /// Steps done.
    pub(crate) steps: u64,
    pub(crate) tau: f64,
    pub(crate) mach_limit: f64,
    pub(crate) average_force: bool,
    /// Whether bodies keep accounts of the mass that they owe.
    pub(crate) keeps_mass: bool,
    /// Whether gaps without cells press on bodies.
    pub(crate) gaps_press: bool,
    /// Gaps that the scene declares, and by cell.
    pub(crate) declared: ModelledGaps,
    pub(crate) gap_of: Vec<u16>,
    /// Where what they draw in leaves the fluid.
    pub(crate) intakes: GapSinks,
    /// Links that slip in them, and whether any do.
    pub(crate) walls: WallDistances,
    pub(crate) slip: SpecularWalls,
    pub(crate) slips: bool,
    pub(crate) scheme: OpenFaces,
    /// Deformable surfaces whose vertices have not come yet, vertices of all, and parts of the scene.
    pub(crate) waiting: Vec<SoftSurface>,
    pub(crate) soft_vertices: usize,
    pub(crate) parts: usize,
    /// How far a vertex moves until cells and links are found anew [cells].
    pub(crate) pose_spacing: f64,
    /// Force per volume of a body by hydrostatic pressure and mean pressure gradient.
    pub(crate) lift: [f64; 3],
    kernel: Kernel<T>,
    pub(crate) variant: Variant,
    pub(crate) team: Team,
    /// Whether a step is faster on the whole team or alone, once that may be tried, and what was found.
    choice: Option<Choice>,
    found: Option<Found>,
    /// Room for the links of a body, for each thread.
    pub(crate) batches: Vec<Batch>,
    pub(crate) blocks: Vec<CellBlock>,
    pub(crate) tally: ReflectionImpulse,
    /// Faces and static solids.
    pub(crate) surroundings: Boundaries,
    /// What they prescribe at the end of the step.
    pub(crate) now: Vec<BoundaryValue>,
    pub(crate) fixed: StaticWallLinks,
    pub(crate) fixed_items: Vec<static_wall_links::WallItem>,
    pub(crate) sheets: SheetLinks,
    pub(crate) sheet_items: Vec<SheetItem>,
    pub(crate) patches: Patches,
    /// What links brought to the cells at each open face in the last step, `2 axis + side`.
    pub(crate) brought: [Brought; 6],
    pub(crate) open: OpenCells,
    pub(crate) open_items: Vec<open_boundary::OpenItem>,
    pub(crate) reservoirs: Vec<ReservoirFace>,
    pub(crate) link_items: Vec<post_collision::LinkItem>,
    /// What each item exchanged in the last step, and the gaps that it found, if gaps press.
    pub(crate) exchanges: Vec<MomentumExchange>,
    pub(crate) seen: Vec<Seen>,
    pub(crate) pinched: Pinched,
    pub(crate) probes: Probes,
    pub(crate) ports: PortFaces,
    pub(crate) refills: Vec<Filled>,
    /// The last step's balance, in lattice units and in SI.
    pub(crate) balance: Ledger,
    pub(crate) ledger: Ledger,
    /// What the scheme lost since the start.
    pub(crate) lost: Lost,
    /// What the last collision found, the sum of all bodies' exchange after it, and the exchange
    /// with each fixture.
    pub(crate) survey: CellStatistics,
    pub(crate) exchange: MomentumExchange,
    pub(crate) fixtures: Vec<MomentumExchange>,
    /// What gaps without cells gave to each fixture.
    pub(crate) pressed: Vec<MomentumExchange>,
    /// Density minus 1 in the gaps of each item of links.
    pub(crate) in_gaps: Vec<InGaps>,
    /// Room for sums over fixtures.
    pub(crate) impulses: Vec<[f64; 3]>,
    /// Force of the fluid on each symmetry plane, `2 axis + side`.
    pub(crate) mirrors: [[f64; 3]; 6],
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// See [`crate::LbmFluid::with_variant`]; by the world's axes.
    #[cfg(test)]
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
        variant: Variant,
    ) -> Result<Self, Vec<Problem>> {
        let (_, ground) = parameters.survey(scene)?;
        Self::on(ground, scene, parameters, time_step, threads, variant)
    }

    /// On the static geometry of a scene; see [`crate::LbmFluid::with_variant`].
    pub fn on(
        ground: StaticGeometry,
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
        variant: Variant,
    ) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        let fluid = scene.fluid.as_ref().expect("a scene that was resolved has a fluid");
        parameters.check_step(fluid, time_step, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let units = Units {
            cell: parameters.cell.0,
            time_step,
            density: fluid.density,
            min: scene.domain.min,
        };
        let tau = parameters.tau_of(time_step, fluid.viscosity / fluid.density);
        let acceleration = fluid.acceleration.map(|a| a / units.acceleration());
        let relaxation = match parameters.collision {
            Collision::Bgk => Relaxation::single(tau, acceleration),
            Collision::Trt => Relaxation::with_magic(tau, parameters.magic, acceleration),
        }
        .with_smagorinsky(parameters.smagorinsky);
        let team = Team::new("fluid", threads).map_err(|error| {
            vec![Problem::new(
                "threads",
                format!("the system does not give {threads} threads: {error}"),
            )]
        })?;
        let upright = ground.upright;
        let mut surroundings = Boundaries::new(scene, ground, parameters, &units);
        let built = surroundings.build(T::LINE);
        let count = built.layout.places.lines().len();
        let step = CELLS_PER_BLOCK / T::LINE;
        let ranges: Vec<_> =
            (0..count).step_by(step).map(|first| first..(first + step).min(count)).collect();
        let tally = ReflectionImpulse::new(&built.reflections, &ranges, T::LINE);
        let halfway_in = |lines: &std::ops::Range<usize>| {
            let before = |line: usize| {
                built.halfway.partition_point(|link| (link.cell as usize) < line * T::LINE)
            };
            let links = &built.halfway[before(lines.start)..before(lines.end)];
            HalfwayLinks::new(&built.layout, links, &surroundings.references)
        };
        let blocks: Vec<CellBlock> = ranges
            .iter()
            .enumerate()
            .map(|(number, lines)| CellBlock {
                lines: lines.clone(),
                survey: CellStatistics::NONE,
                reflected: vec![0.0; tally.runs(number).len()],
                halfway: halfway_in(lines),
            })
            .collect();
        let waiting = SoftSurface::all(scene);
        let fixtures = surroundings.laws.len();
        let centres = Centres { cell: units.cell, min: units.min };
        let probes = Probes::new(&scene.probes, &built.layout, &centres);
        let ports = PortFaces::new(scene, &built.layout, &centres);
        let declared = ModelledGaps::new(scene, &surroundings, &built.layout, centres);
        let slips = declared.any_slips() && (tau - 0.5) * CS2 < parameters.slip_viscosity;
        let cells = built.layout.cells.len();
        let mut owners = CellFlags::new(cells);
        if !declared.is_empty() {
            owners.list_changes();
        }
        let mut solver = Self {
            units,
            field: Field::new(built.layout.places.stride()),
            owners,
            bricks: ChangeBlocks::new(&built.layout.grid),
            wanted: DensityRequests { lines: Vec::new(), left: 0, drho: Field::zeros(0) },
            bodies: Bodies::of(
                BodyShapes::new(
                    scene,
                    std::mem::take(&mut surroundings.moving),
                    roundings(scene, parameters, &units),
                    (upright, parameters.spacing_of_poses()),
                ),
                parameters.velocity_lead,
            ),
            relaxation,
            parity: Parity::Even,
            steps: 0,
            tau,
            mach_limit: parameters.mach_limit,
            average_force: parameters.average_force,
            gaps_press: parameters.gap_pressure == GapPressure::Nearest,
            keeps_mass: parameters.refill == Refill::Mass,
            gap_of: declared.by_cell().to_vec(),
            intakes: declared.intakes(),
            walls: WallDistances::default(),
            slip: if slips {
                SpecularWalls::in_gaps(&declared, &built.layout)
            } else {
                SpecularWalls::default()
            },
            slips,
            declared,
            soft_vertices: waiting.iter().map(|soft| soft.vertices().len()).sum(),
            waiting,
            parts: scene.parts.len(),
            pose_spacing: parameters.spacing_of_poses(),
            scheme: parameters.open_faces,
            lift: std::array::from_fn(|a| {
                acceleration[a] - scene.gravity[a] / units.acceleration()
            }),
            kernel: T::kernel(variant),
            variant,
            batches: (0..team.threads()).map(|_| Batch::default()).collect(),
            team,
            choice: None,
            found: None,
            blocks,
            tally,
            surroundings,
            now: vec![BoundaryValue::Wall([0.0; 3]); fixtures],
            layout: built.layout,
            fixed: built.fixed,
            fixed_items: built.fixed_items,
            sheets: built.sheets,
            sheet_items: built.sheet_items,
            patches: built.patches,
            brought: Default::default(),
            open: built.open,
            open_items: built.open_items,
            reservoirs: built.reservoirs,
            link_items: Vec::new(),
            exchanges: Vec::new(),
            pinched: Pinched::among(cells),
            seen: Vec::new(),
            probes,
            ports,
            refills: Vec::new(),
            balance: Ledger::default(),
            ledger: Ledger::default(),
            lost: Lost::default(),
            survey: CellStatistics { min_drho: 0.0, max_drho: 0.0, ..CellStatistics::NONE },
            exchange: MomentumExchange::default(),
            fixtures: vec![MomentumExchange::default(); fixtures],
            pressed: vec![MomentumExchange::default(); fixtures],
            in_gaps: Vec::new(),
            impulses: vec![[0.0; 3]; fixtures],
            mirrors: [[0.0; 3]; 6],
        };
        let (velocity, pressure) = (fluid.velocity, fluid.pressure);
        solver.set_state(|_| (velocity, pressure));
        Ok(solver)
    }

    /// Tells what bodies of the scene's sets displace; see [`Bodies::displace`].
    pub fn share_unions(&mut self, shares: Vec<Vec<UnionShare>>) {
        self.bodies.share_unions(shares);
    }

    /// See [`crate::LbmFluid::apply_events`].
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        if events.is_empty() {
            return Ok(());
        }
        self.bodies.apply(events, &self.units, &self.layout)?;
        self.lost.change();
        self.list_items();
        Ok(())
    }

    /// Makes the items of the bodies' links, and room for what changes in a step.
    pub(crate) fn list_items(&mut self) {
        if self.wanted.lines.is_empty() {
            let lines = self.layout.places.lines().len();
            self.wanted.lines.resize_with(lines, AtomicU8::default);
            self.wanted.drho = Field::zeros(lines * T::LINE);
        }
        let press = self.feels_gaps();
        if press && self.walls.is_empty() {
            let halfway = self.blocks.iter().flat_map(|block| block.halfway.ends());
            let ends = self.fixed.ends().chain(halfway);
            self.walls = self.surroundings.wall_distances(&self.layout, ends);
        }
        let counts = [self.declared.len(), self.intakes.len()];
        self.link_items = post_collision::items(&mut self.bodies, press, counts);
        let count = self.link_items.len();
        self.exchanges = vec![MomentumExchange::default(); count];
        self.seen = vec![Seen::NONE; if press { count } else { 0 }];
        self.in_gaps.resize(count, UNKNOWN);
        // A body's changes in a step are less than its shell's rows, see `Body::new`.
        let shell = |b: &Body| b.most_changes();
        let changes = self.bodies.living.iter().map(shell).sum::<usize>();
        self.owners.reserve(changes);
        self.refills.reserve(changes.saturating_sub(self.refills.len()));
        self.pinched.reserve(changes);
    }

    /// Whether the links' search looks across gaps that hold no fluid.
    pub(crate) fn feels_gaps(&self) -> bool {
        self.gaps_press || !self.declared.is_empty()
    }

    /// See [`crate::LbmFluid::start`].
    pub fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.check(bodies, loads.len())?;
        self.check_surfaces()?;
        self.begin_balance();
        self.move_bodies(bodies);
        self.find_pinched();
        self.bodies.newcomers.clear();
        self.measure();
        self.exchange = MomentumExchange::default();
        self.exchanges.fill(MomentumExchange::default());
        self.seen.fill(Seen::NONE);
        self.link_items.iter_mut().for_each(|item| item.gaps.clear());
        self.give_loads(loads);
        self.end_balance(false);
        self.settle_accounts();
        self.lose_nothing();
        Ok(())
    }

    /// See [`crate::LbmFluid::choose_threads`].
    pub fn choose_threads(&mut self) {
        self.choice = Some(Choice::new(self.team.threads()));
    }

    /// See [`crate::LbmFluid::take_found`].
    pub fn take_found(&mut self) -> Option<Found> {
        self.found.take()
    }

    /// See [`crate::LbmFluid::step`].
    pub fn step(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        let Some(mut choice) = self.choice.take() else { return self.advance(bodies, loads) };
        self.team.work_alone(choice.begin(self.owners.fluid_cells));
        let begin = choice.clock();
        let advanced = self.advance(bodies, loads);
        choice.spend(begin);
        self.found = choice.end().or(self.found.take());
        self.choice = Some(choice);
        advanced
    }

    /// One time step.
    fn advance(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.check(bodies, loads.len())?;
        self.check_surfaces()?;
        let begin = self.steps as f64 * self.units.time_step;
        for reservoir in &mut self.reservoirs {
            reservoir.advance(begin, &self.units)?;
        }
        self.begin_balance();
        self.move_bodies(bodies);
        self.give_back();
        self.collide();
        self.steps += 1;
        self.reflect();
        self.parity = self.parity.flipped();
        self.open()?;
        self.calm_pinched();
        self.give_loads(loads);
        self.end_balance(true);
        self.settle_accounts();
        self.count_lost();
        let (before, now) = (before!(self), &self.now);
        let sight = Sight { before, owners: &self.owners, bodies: &self.bodies, now };
        self.probes.look(&mut self.team, &sight, self.steps);
        Ok(())
    }

    /// The fluid before the next collision.
    pub(crate) fn before(&self) -> PreCollision<'_, T> {
        before!(self)
    }

    /// Collides and streams all fluid cells.
    fn collide(&mut self) {
        let sweep = Sweep {
            field: &self.field,
            places: &self.layout.places,
            fluid: self.owners.fluid_bits(),
            parity: self.parity,
            relaxation: &self.relaxation,
            tally: &self.tally,
            wanted: &self.wanted,
        };
        let (kernel, stride) = (self.kernel, self.layout.places.stride());
        self.team.for_each(&mut self.blocks, |number, block| {
            // SAFETY: the variant was checked when the kernel was chosen; blocks are disjoint, and
            // so are the places of their cells; all tables were made for these cells; nothing else
            // runs.
            unsafe { kernel(&sweep, number, block) };
            block.halfway.feel(self.variant, &self.field, stride, &self.owners);
        });
        let (field, fluid, tally) = (&self.field, self.owners.fluid_bits(), &self.tally);
        if tally.is_late() {
            self.team.for_each(&mut self.blocks, |number, block| {
                tally.sum_late(field, fluid, number, &mut block.reflected);
            });
        }
        self.join_surveys();
    }

    /// Adds up the blocks.
    pub(crate) fn join_surveys(&mut self) {
        self.survey = CellStatistics::NONE;
        for block in &self.blocks {
            self.survey.join(&block.survey);
        }
    }
}

/// How the poses of the scene's parts are rounded.
fn roundings(scene: &Scene, parameters: &Parameters, units: &Units) -> Vec<Rounding> {
    let step = parameters.spacing_of_poses();
    let of = |part: &Part| Rounding {
        position: units.position_to_lattice(part.pose.position),
        orientation: part.pose.orientation,
        step,
    };
    scene.parts.iter().map(of).collect()
}
