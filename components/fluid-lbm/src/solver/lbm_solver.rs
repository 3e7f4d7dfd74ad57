//! The solver in one precision: what it is made of, and the order of a step.

use crate::bodies::body_list::Bodies;
use crate::bodies::body_shapes::BodyShapes;
use crate::bodies::pose_rounding::Rounding;
use crate::boundary::boundaries::Boundaries;
use crate::domain::parameters::{Collision, Parameters, Refill};
use crate::lattice::collision::Relaxation;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::values;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::units::Units;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::cell_shares::{CellShares, depth};
use crate::ranks::halo::Halo;
use crate::ranks::rank_sums::Ranks;
use crate::solver::budget::Budget;
use crate::solver::collide_and_stream::CollideAndStream;
use crate::solver::crossing_bodies::count_crossing;
use crate::solver::deformable_surfaces::AwaitedSurfaces;
use crate::solver::diagnostics::{Diagnostics, Extreme};
use crate::solver::execution::Execution;
use crate::solver::facet_loads;
use crate::solver::gap_flows::GapFlows;
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::loads;
use crate::solver::mass_correction::settle_bodies;
use crate::solver::moving_bodies::MovingBodies;
use crate::solver::moving_boundaries::{count_losses, refill};
use crate::solver::open_boundaries::OpenBoundaries;
use crate::solver::pinched_cells::Pinched;
use crate::solver::ports::PortFaces;
use crate::solver::probes::Probes;
use crate::solver::section_flux::Sight;
use crate::solver::static_boundaries::StaticBoundaries;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;
use tremie_messages::scene::{FluidMaterial, Part, Scene};
use tremie_messages::{BodyEvent, BodyState, FacetLoad, Load, PortState, Problem, SurfaceVertex};
use tremie_team::Variant;

/// A lattice-Boltzmann fluid in the precision `T`. See [`crate::LbmFluid`] for the meaning of its
/// methods.
pub struct LbmSolver<T: CollisionKernel> {
    /// Cells, populations, flags.
    pub lattice: LatticeState<T>,
    /// Collision and streaming.
    pub collision: CollideAndStream<T>,
    /// Bodies and their links.
    pub bodies: MovingBodies,
    /// Static walls and solids, and their links.
    pub walls: StaticBoundaries,
    /// Open faces, and reservoirs behind faces.
    pub faces: OpenBoundaries<T>,
    /// Gaps that hold no fluid.
    pub gaps: GapModel,
    /// Cells that nothing flows through.
    pub pinched: Pinched,
    /// Momentum and mass of a step.
    pub budget: Budget,
    /// Probes of the scene.
    pub probes: Probes,
    /// Velocities that inlets of grains take.
    pub ports: PortFaces,
    /// Threads and vector instructions.
    pub exec: Execution,
    /// Largest Mach number.
    pub mach_limit: f64,
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
        Self::on(ground, scene, parameters, time_step, (threads, variant), Ranks::default())
    }

    /// On the static geometry of a scene; see [`crate::LbmFluid::with_variant`].
    pub fn on(
        ground: StaticGeometry,
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        (threads, variant): (usize, Variant),
        ranks: Ranks,
    ) -> Result<Self, Vec<Problem>> {
        let fluid = scene.fluid.as_ref().expect("a scene that was resolved has a fluid");
        let mut problems = Vec::new();
        parameters.check_step(fluid, time_step, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let depth = depth(scene, &ground.voxels.obstacles);
        let shares = shares_of(&ground, &ranks, depth)?;
        let mut exec = Execution::new(threads, variant, ranks)?;
        let units = Units {
            cell: parameters.cell.0,
            time_step,
            density: fluid.density,
            min: scene.domain.min,
        };
        let centres = Centres { cell: units.cell, min: units.min };
        let tau = parameters.tau_of(time_step, fluid.viscosity / fluid.density);
        let upright = ground.upright;
        let mut boundaries = Boundaries::new(scene, ground, parameters, &units);
        let rank = exec.ranks.number();
        let window = shares.as_ref().map(|shares| shares.window(rank));
        let mut built = boundaries.build::<T>(&mut exec.ranks, window.as_ref());
        let bodies = bodies_of(scene, parameters, &units, upright, &mut boundaries);
        let collision = CollideAndStream::new(&built, &boundaries.references, variant);
        let gaps = GapModel::new(scene, parameters, &boundaries, &built.layout, centres, tau);
        let walls = StaticBoundaries::new(boundaries, &mut built);
        let faces = OpenBoundaries::new(&mut built);
        let relaxation = relaxation_of(parameters, fluid, &units, tau);
        let mut lattice = LatticeState::new(built.layout, units, relaxation, tau);
        lattice.numbers = WholeNumbers::new(&lattice.layout, window);
        if let Some(shares) = &shares {
            let obstacles = &walls.conditions.ground().voxels.obstacles;
            lattice.halo = Halo::new(shares, rank, (&lattice.layout, obstacles), size_of::<T>());
        }
        // Links that slip and mouths of gaps are searched anew only around cells that changed.
        if !gaps.modelled.is_empty() {
            lattice.flags.list_changes();
        }
        let mut solver = Self {
            probes: Probes::new(&scene.probes, &lattice.layout, &centres, &mut exec.ranks),
            ports: PortFaces::new(scene, &lattice.layout, &centres, &mut exec.ranks),
            pinched: Pinched::among(lattice.layout.cells.len()),
            lattice,
            collision,
            bodies,
            walls,
            faces,
            gaps,
            budget: Budget::default(),
            exec,
            mach_limit: parameters.mach_limit,
        };
        let (velocity, pressure) = (fluid.velocity, fluid.pressure);
        solver.set_state(|_| (velocity, pressure));
        Ok(solver)
    }

    /// See [`crate::LbmFluid::apply_events`].
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        if events.is_empty() {
            return Ok(());
        }
        self.bodies.list.apply(events, &self.lattice.units, &self.lattice.layout)?;
        self.budget.lost.change();
        self.list_items();
        Ok(())
    }

    /// See [`crate::LbmFluid::set_surfaces`].
    pub fn set_surfaces(&mut self, vertices: &[SurfaceVertex]) -> Result<(), FluidError> {
        let MovingBodies { awaited, list, .. } = &mut self.bodies;
        let LatticeState { units, layout, .. } = &self.lattice;
        if awaited.take(vertices, list, units, &layout.grid)? {
            self.list_items();
        }
        Ok(())
    }

    /// Makes the items of the bodies' links, and room for what changes in a step.
    pub(super) fn list_items(&mut self) {
        let Self { lattice, collision, bodies, walls, gaps, pinched, .. } = self;
        collision.make_room(&lattice.layout);
        if let Some(distances) = gaps.tables.walls.as_mut().filter(|walls| walls.is_empty()) {
            let halfway = collision.blocks.iter().flat_map(|block| block.halfway.ends());
            let ends = walls.links.ends().chain(halfway);
            *distances = walls.conditions.wall_distances(&lattice.layout, ends);
        }
        bodies.list_links(gaps.feels_gaps(), [gaps.modelled.len(), gaps.tables.sinks.len()]);
        gaps.make_room(bodies.links.len(), bodies.list.living.len());
        let changes = bodies.most_changes();
        lattice.flags.reserve(changes);
        bodies.refills.reserve(changes.saturating_sub(bodies.refills.len()));
        pinched.reserve(changes);
    }

    /// See [`crate::LbmFluid::set_state`].
    pub fn set_state(&mut self, state: impl Fn([f64; 3]) -> ([f64; 3], f64)) {
        self.lattice.end_refresh(&mut self.exec.ranks);
        self.lattice.set_state(state);
        self.faces.fill_reservoirs(&self.lattice, &mut self.exec.ranks);
        self.collision.measure(&mut self.lattice, &mut self.exec);
        self.budget.begin(&self.bodies.list.leaving);
        self.close_budget(false);
        self.lose_nothing();
    }

    /// See [`crate::LbmFluid::start`].
    pub fn start(&mut self, states: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.list.check(states, loads.len())?;
        self.bodies.awaited.check()?;
        self.lattice.end_refresh(&mut self.exec.ranks);
        self.budget.begin(&self.bodies.list.leaving);
        self.update_cover(states);
        self.pinched.find(&self.lattice);
        self.bodies.list.forget_events();
        self.collision.measure(&mut self.lattice, &mut self.exec);
        self.bodies.forget_exchange();
        self.assemble_loads(loads);
        self.close_budget(false);
        self.settle_accounts();
        self.lose_nothing();
        Ok(())
    }

    /// See [`crate::LbmFluid::step`].
    pub fn step(&mut self, states: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        let begin = self.exec.begin_step(self.lattice.flags.fluid_cells);
        let advanced = self.advance(states, loads);
        self.exec.end_step(begin);
        advanced
    }

    /// One time step; `states` are the bodies at its end.
    fn advance(&mut self, states: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.bodies.list.check(states, loads.len())?;
        self.bodies.awaited.check()?;
        if !self.faces.is_empty() {
            // Faces look at the cells inside.
            self.lattice.end_refresh(&mut self.exec.ranks);
        }
        // dH/dt = v_p: the piston's way makes the density at its face (Mutabaruka & Kamrin 2018,
        // Eqs. 29, 30).
        self.faces.begin(&self.lattice, &mut self.exec)?;
        self.budget.begin(&self.bodies.list.leaving);
        // Cells change between fluid and solid; what bodies uncover is refilled before it collides.
        self.update_cover(states);
        // Fluid and bodies that enter have the volume of the piston's way together.
        let Self { faces, bodies, gaps, lattice, exec, .. } = self;
        if count_crossing(faces, &bodies.list, gaps, lattice, &mut exec.ranks) {
            self.budget.lost.change();
        }
        self.bodies.list.forget_events();
        // f_i(x + c_i, t + 1) = g_i(x, t), in one array (AA pattern, Bailey et al. 2009): half-way
        // walls and mirrors are in the addresses.
        self.collision.step(&mut self.lattice, &mut self.exec);
        self.lattice.steps += 1;
        // f_i'(x, t + 1) of links that met a surface, by its distance (Bouzidi et al. 2001).
        self.bounce_back()?;
        self.lattice.parity = self.lattice.parity.flipped();
        // All f_i at open faces: Guo et al. 2002, Zou & He 1997, Mutabaruka & Kamrin 2018, Eq. 31.
        // Last, for they read what all others wrote.
        self.faces.apply(&self.lattice, &self.walls, &mut self.exec)?;
        // j(t + 1) = -j(t) where nothing flows through: the mean of both (Zanetti 1989).
        self.pinched.calm(&self.lattice);
        // It ends where the next step looks at copies: mostly when own cells have collided.
        self.lattice.begin_refresh(&mut self.exec.ranks);
        // F = sum g_i (c_i - u_w) - f_i' (c_i' - u_w) (Wen et al. 2014), gaps, images, buoyancy.
        self.assemble_loads(loads);
        self.close_budget(true);
        // Interpolation keeps no mass: what walls and bodies took, the coming steps pay.
        self.settle_accounts();
        self.budget.count_lost(&self.lattice, &self.walls, &self.bodies);
        if self.probes.looks_now(self.lattice.steps) {
            // Sections look at cells on both sides.
            self.lattice.end_refresh(&mut self.exec.ranks);
        }
        let before = self.lattice.before();
        let (flags, bodies, now) = (&self.lattice.flags, &self.bodies.list, &self.walls.now[..]);
        let sight = Sight { before, flags, bodies, now };
        let with = (&mut self.exec.team, &mut self.exec.ranks);
        self.probes.look(with, &sight, self.lattice.steps);
        Ok(())
    }

    /// Takes the bodies to the end of the step: cells leave the fluid and join it, links are found.
    fn update_cover(&mut self, states: &[BodyState]) {
        let Self { lattice, collision, bodies, walls, gaps, budget, exec, .. } = self;
        lattice.flags.begin();
        let moved = bodies.list.take(states, &lattice.units, &lattice.layout.grid);
        if !moved && !gaps.modelled.is_fresh() {
            return;
        }
        // What joins the fluid takes from the cells around.
        lattice.end_refresh(&mut exec.ranks);
        let all_want = collision.requests.begin();
        let outgrown = bodies.rasterise(lattice, &collision.requests, all_want, exec);
        bodies.claim_cells(&mut lattice.flags);
        gaps.freeze(lattice, &bodies.list, exec);
        count_losses(lattice, bodies, gaps, budget);
        refill(lattice, bodies, gaps, budget, exec);
        lattice.flags.admit();
        self.pinched.find_anew(lattice);
        lattice.note_changes();
        let obstacles = &walls.conditions.ground().voxels.obstacles;
        gaps.find_openings(lattice, obstacles, &bodies.list, exec);
        lattice.flags.forget_changes();
        if outgrown {
            self.list_items();
        }
        let Self { lattice, collision, bodies, gaps, exec, .. } = self;
        bodies.find_links(lattice, gaps, &collision.requests, all_want, exec);
    }

    /// Reflects what ran into bodies and walls. A link's result takes the place of what another
    /// link reads: so what is cut or slips is read first and written last. Bodies come before
    /// walls: at a cell between both they read what the wall's links change in place.
    fn bounce_back(&mut self) -> Result<(), FluidError> {
        let Self { lattice, collision, bodies, walls, faces, gaps, exec, .. } = self;
        let GapModel { tables, modelled, slip, .. } = gaps;
        let after = collision.after(lattice, tables, bodies.keeps_mass, exec.variant);
        let any_cut = bodies.read_cuts(&after, exec);
        faces.read_surfaces(&after, exec);
        if tables.slips {
            slip.read(&after, &bodies.list, &mut exec.team);
        }
        modelled.reflect(&after, &mut exec.ranks);
        bodies.bounce_back(&after, exec);
        walls.prescribe(lattice.time(), lattice.units.time_step);
        walls.bounce_back(&after, exec);
        if tables.slips {
            let with = (&mut exec.team, &mut exec.ranks);
            slip.write(&after, &walls.conditions.references, with);
        }
        if any_cut {
            bodies.write_cuts(&after);
        }
        faces.write_surfaces(&after, &walls.conditions.references, &lattice.units, exec)
    }

    /// Gives the bodies their loads, from what their links exchanged and what gaps press.
    fn assemble_loads(&mut self, loads: &mut [Load]) {
        let Self { lattice, bodies, walls, gaps, budget, exec, .. } = self;
        let (grid, references) = (&lattice.layout.grid, &walls.conditions.references);
        gaps.press_on(&mut bodies.list, &bodies.links, (grid, references), exec);
        bodies.total = MomentumExchange::default();
        bodies.join_exchanges(&mut exec.ranks);
        facet_loads::load_facets(lattice, bodies, gaps, budget, exec);
        loads::assemble(lattice, bodies, gaps, budget, loads);
    }

    /// Completes the balance of a step, which may have been without a collision.
    fn close_budget(&mut self, collided: bool) {
        let Self { lattice, collision, bodies, walls, faces, gaps, budget, exec, .. } = self;
        let slip = gaps.tables.slips.then_some(&gaps.slip);
        let (ranks, tally) = (&mut exec.ranks, &collision.tally);
        let blocks = (&collision.blocks[..], lattice.layout.own_blocks());
        let mirrors = walls.join_exchanges(blocks, tally, slip, &faces.surfaces, ranks);
        ranks.add_up(self.pinched.impulse.iter_mut().chain(budget.changed.sums()));
        budget.add_changed();
        if collided {
            budget.add_forces(lattice, values(&self.pinched.impulse), gaps.modelled.impulse);
            budget.add_bodies(&bodies.total, mirrors);
            budget.add_walls(walls);
            budget.add_open_faces(faces.gained(ranks), walls);
            faces.count_entering(ranks);
        }
        for (fixture, pressed) in walls.exchanges.iter_mut().zip(&gaps.pressed) {
            fixture.join(pressed);
        }
        budget.close(lattice);
        lattice.count_cells(&mut exec.ranks);
    }

    /// Settles the accounts of walls and bodies at the end of a step, once its balance is known.
    fn settle_accounts(&mut self) {
        let Self { lattice, bodies, walls, gaps, budget, exec, .. } = self;
        let of_walls = walls.patches.settle(&mut walls.items, &mut exec.ranks);
        let of_bodies = settle_bodies(bodies, gaps, budget.mean_density(lattice));
        budget.note_owed(of_walls + of_bodies, &lattice.units);
    }

    /// Begins the account of lost mass anew: nothing is lost.
    fn lose_nothing(&mut self) {
        self.walls.patches.forgive(&mut self.walls.items);
        self.budget.lost.restart(self.lattice.fluid_cells);
    }

    /// See [`crate::LbmFluid::diagnostics`].
    pub fn diagnostics(&self) -> Diagnostics {
        Diagnostics::of(&self.lattice, &self.bodies, self.faces.entering)
    }

    /// See [`crate::LbmFluid::check`].
    pub fn check(&self) -> Result<(), FluidError> {
        self.lattice.check(&self.bodies.total, self.mach_limit, &self.exec.ranks)
    }

    /// See [`crate::LbmFluid::place_of`].
    pub fn place_of(&self, extreme: Extreme) -> Option<[f64; 3]> {
        self.lattice.place_of(extreme, &self.exec.ranks)
    }

    /// See [`crate::LbmFluid::surface_loads`].
    pub fn surface_loads(&mut self, loads: &mut [FacetLoad]) {
        facet_loads::surface_loads(&self.bodies.list, &self.lattice.units, loads, &mut self.exec);
    }

    /// See [`crate::LbmFluid::loads_on_parts`].
    pub fn loads_on_parts(&self, loads: &mut Vec<Load>) {
        self.walls.loads_on_parts(&self.lattice, self.bodies.lift, loads);
    }

    /// See [`crate::LbmFluid::probes`].
    pub fn probes(&mut self, values: &mut Vec<f64>) {
        let LatticeState { flags, units, .. } = &self.lattice;
        let with = (&mut self.exec.team, &mut self.exec.ranks);
        self.probes.read(with, &self.lattice.before(), flags, units, values);
    }

    /// See [`crate::LbmFluid::ports`].
    pub fn ports(&mut self) -> &[PortState] {
        self.ports.measure(&self.lattice, &mut self.exec)
    }

    /// See [`crate::LbmFluid::memory_bytes`].
    pub fn memory_bytes(&self) -> usize {
        self.lattice.bytes()
            + self.collision.bytes()
            + self.bodies.bytes()
            + self.walls.bytes()
            + self.faces.bytes()
            + self.gaps.bytes()
            + self.pinched.bytes()
    }
}

impl<T: CollisionKernel> Drop for LbmSolver<T> {
    /// What is under way to other ranks, and from them, keeps its place in memory until it is there.
    fn drop(&mut self) {
        self.lattice.end_refresh(&mut self.exec.ranks);
    }
}

/// The shares of ranks that compute a lattice together; none for one that is alone.
fn shares_of(
    ground: &StaticGeometry,
    ranks: &Ranks,
    depth: i32,
) -> Result<Option<CellShares>, Vec<Problem>> {
    let Some(count) = ranks.count_of_many() else { return Ok(None) };
    let shares = CellShares::new(&ground.grid, &ground.voxels.obstacles, (count, depth));
    let problem = |text: String| vec![Problem::of_parameter("launch", text)];
    shares.map(Some).map_err(problem)
}

/// No bodies yet, with what they can be in a scene.
fn bodies_of(
    scene: &Scene,
    parameters: &Parameters,
    units: &Units,
    upright: [f64; 4],
    boundaries: &mut Boundaries,
) -> MovingBodies {
    let step = parameters.spacing_of_poses();
    let rounding = |part: &Part| Rounding {
        position: units.position_to_lattice(part.pose.position),
        orientation: part.pose.orientation,
        step,
    };
    let roundings = scene.parts.iter().map(rounding).collect();
    let moving = std::mem::take(&mut boundaries.moving);
    let shapes = BodyShapes::new(scene, moving, roundings, (upright, step));
    let acceleration = scene.fluid.as_ref().map_or([0.0; 3], |fluid| fluid.acceleration);
    let unit = units.acceleration();
    MovingBodies {
        list: Bodies::of(shapes, parameters.velocity_lead),
        awaited: AwaitedSurfaces::new(scene, step),
        links: Vec::new(),
        exchanges: Vec::new(),
        of_bodies: Vec::new(),
        total: MomentumExchange::default(),
        gap_flows: GapFlows::default(),
        refills: Vec::new(),
        keeps_mass: parameters.refill == Refill::Mass,
        average_force: parameters.average_force,
        lift: std::array::from_fn(|a| acceleration[a] / unit - scene.gravity[a] / unit),
    }
}

/// Relaxation of the collision that the parameters choose.
fn relaxation_of(
    parameters: &Parameters,
    fluid: &FluidMaterial,
    units: &Units,
    tau: f64,
) -> Relaxation {
    let acceleration = fluid.acceleration.map(|a| a / units.acceleration());
    match parameters.collision {
        Collision::Bgk => Relaxation::single(tau, acceleration),
        Collision::CentralMoments => Relaxation::central(tau, acceleration),
        Collision::Trt => Relaxation::with_magic(tau, parameters.magic, acceleration),
    }
    .with_smagorinsky(parameters.smagorinsky)
    .with_bulk(parameters.bulk_tau(units.time_step, fluid.density))
}
