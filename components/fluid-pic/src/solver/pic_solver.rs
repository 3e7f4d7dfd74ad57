//! The solver: one step after the other.
//!
//! ```text
//! 1  particles to grid          u^n
//! 2  surface                    depth of each cell
//! 3  open fractions             bodies where they are
//! 4  forces, viscosity          u* = u^n + dt (g + nu lap u*)
//! 5  pressure and bodies        (A + J^T S J) q = - div u* - J^T U*
//! 6  projection                 u = u* - grad q,  extrapolated beyond the fluid
//! 7  grid to particles          FLIP and PIC, or APIC
//! 8  advection                  particles move
//! ```
//!
//! [`PicSolver::find_loads`] goes as far as 6, with the bodies where a step begins: then the loads
//! on them are known. [`PicSolver::move_particles`] does the rest, with the bodies where it ends.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::cell_order::{CellOrder, cell_of};
use crate::particles::from_grid::{FaceVelocity, ParticleMotion, StartValues, gather_start_values};
use crate::particles::hat_weights::HatWeights;
use crate::particles::particle_arrays::ParticleArrays;
use crate::particles::to_grid::{FaceSums, to_cells, to_faces};
use crate::pressure::body_coupling::Wrench;
use crate::pressure::conjugate_gradients::{ConjugateGradients, PressureOutcome};
use crate::pressure::multigrid::Multigrid;
use crate::pressure::stencil::Stencil;
use crate::solids::open_fractions::{MARGIN, OpenFractions};
use crate::solids::rigid_body::RigidBody;
use crate::solver::extrapolation::{ExtrapolationRoom, FaceState, extrapolate};
use crate::solver::gap_damping::GapBands;
use crate::solver::held_faces::hold;
use crate::solver::open_faces::{OpenFace, OpenFaces};
use crate::solver::pic_settings::{BoxWall, PicSettings};
use crate::solver::pressure_gradient::PressureGradient;
use crate::solver::separation::Separation;
use crate::solver::slip_faces::SlipFaces;
use crate::solver::viscosity::Viscosity;
use crate::solver::volume_correction::VolumeCorrection;
use crate::solver::wall_links::ViscousStep;
use crate::surface::fill_level::{depth, room};
use tremie_team::{Cut, Team, Variant};

/// Layers of faces beyond the fluid that have a velocity.
const LAYERS: usize = 3;

/// Room below which particles do not say whether a cell is part of the fluid [cells].
const HALF: f64 = 0.5;

/// Cells that the fastest fluid crosses in a step for which settings are meant.
const USUAL_COURANT: f64 = 0.5;

/// Times that the pressure is solved for again because fluid lets go of solids.
const ROUNDS: usize = 3;

/// A fluid with a free surface, and bodies in it.
pub struct PicSolver<const D: usize> {
    /// The grid.
    pub grid: StaggeredGrid<D>,
    pub(super) settings: PicSettings<D>,
    pub(super) team: Team,
    variant: Variant,
    /// The particles.
    pub particles: ParticleArrays<D>,
    order: CellOrder,
    /// Cells near particles: all others are air, or solid, and have no values.
    pub(super) near: NearRows,
    pub(super) fractions: OpenFractions<D>,
    pub(super) before: FaceVelocity<D>,
    pub(super) velocity: FaceVelocity<D>,
    face_mass: FaceVelocity<D>,
    face_sums: [FaceSums; D],
    start_values: [StartValues; D],
    /// Faces that particles reach.
    is_carried: [Vec<bool>; D],
    pub(super) state: [Vec<FaceState>; D],
    found: [ExtrapolationRoom; D],
    voids: Vec<u32>,
    /// Particles that no wet cell is near.
    is_adrift: Vec<bool>,
    pub(super) cell_mass: Vec<f64>,
    pub(super) room: Vec<f64>,
    work: Vec<f64>,
    pub(super) depth: Vec<f64>,
    pub(super) viscosity: Viscosity<D>,
    pub(super) stencil: Stencil<f64, D>,
    pub(super) right: Vec<f64>,
    pub(super) q: Vec<f64>,
    multigrid: Multigrid<D>,
    iteration: ConjugateGradients,
    pub(super) correction: VolumeCorrection<D>,
    pub(super) separation: Separation,
    pub(super) gap_bands: GapBands<D>,
    slip_faces: SlipFaces<D>,
    /// Motions of the bodies at the end of the step.
    motions: Vec<Wrench>,
    pub(super) open_faces: OpenFaces<D>,
    has_surface: bool,
    /// True once `room` is found; it changes with the fractions alone.
    has_room: bool,
    /// The step whose pressure `q` is; 0 before the first [s].
    pub(super) last_step: f64,
    /// Loads of pressure on the free bodies in the last step, by the bodies' numbers.
    pub(super) pressed: Vec<(u64, Wrench)>,
    /// Changes of the free bodies' motions that are expected.
    expected_gains: Vec<Wrench>,
    relaxation: f64,
    /// Lift of each free body, then of each held one, beyond that of the faces that it covers [N].
    pub(super) lift: Vec<[f64; D]>,
}

impl<const D: usize> PicSolver<D> {
    /// Without any particles. Faces of the box are walls where no open face is, and the axis does
    /// not wrap around; `at_rest` are the solids that never move.
    ///
    /// # Errors
    /// If the system gives no more threads.
    pub fn new(
        grid: StaggeredGrid<D>,
        settings: PicSettings<D>,
        threads: usize,
        open_faces: Vec<OpenFace<D>>,
        at_rest: Vec<RigidBody<D>>,
    ) -> std::io::Result<Self> {
        let zeros = || vec![0.0; grid.stored];
        let per_cell = settings.particles_per_axis.pow(D as u32) as f64;
        let mass = settings.density * grid.cell_volume() / per_cell;
        let is_open =
            |axis, side| open_faces.iter().any(|face| (face.axis, face.side) == (axis, side));
        let fractions = OpenFractions::new(&grid, is_open, at_rest);
        let slip_faces = SlipFaces::new(&grid, &fractions);
        Ok(Self {
            team: Team::new("fluid-pic", threads)?,
            variant: Variant::widest(),
            particles: ParticleArrays::new(mass),
            order: CellOrder::default(),
            near: NearRows::default(),
            open_faces: OpenFaces::new(&grid, &fractions, &settings, open_faces),
            fractions,
            before: std::array::from_fn(|_| zeros()),
            velocity: std::array::from_fn(|_| zeros()),
            face_mass: std::array::from_fn(|_| zeros()),
            face_sums: std::array::from_fn(|_| FaceSums::new()),
            start_values: std::array::from_fn(|_| StartValues::new()),
            is_carried: std::array::from_fn(|_| vec![false; grid.stored]),
            state: std::array::from_fn(|_| vec![FaceState::Unknown; grid.stored]),
            found: std::array::from_fn(|_| ExtrapolationRoom::default()),
            voids: Vec::new(),
            is_adrift: Vec::new(),
            cell_mass: zeros(),
            room: zeros(),
            work: zeros(),
            depth: vec![-1.0; grid.stored],
            viscosity: Viscosity::default(),
            stencil: Stencil::of_grid(&grid),
            right: zeros(),
            q: zeros(),
            multigrid: Multigrid::new(grid.cells, grid.periodic),
            iteration: ConjugateGradients::new(grid.stored),
            correction: VolumeCorrection::new(&grid),
            separation: Separation::default(),
            gap_bands: GapBands::default(),
            slip_faces,
            motions: Vec::new(),
            has_surface: false,
            has_room: false,
            last_step: 0.0,
            pressed: Vec::new(),
            expected_gains: Vec::new(),
            relaxation: 0.0,
            lift: Vec::new(),
            settings,
            grid,
        })
    }

    /// Mass of a cell full of fluid [kg], in two dimensions [kg/m].
    pub fn full_mass(&self) -> f64 {
        self.settings.density * self.grid.cell_volume()
    }

    /// Removes particles that are in a solid.
    pub fn remove_inside(&mut self, bodies: &[RigidBody<D>]) {
        let full = self.full_mass();
        self.fractions.place_bodies(&self.grid, bodies, full);
        let Self { grid, particles, fractions, .. } = self;
        particles.retain(|at| {
            let cell = cell_of(grid, at);
            let holds = |number| {
                let (body, at) = fractions.seen_by(grid, bodies, number, at);
                body.holds(at)
            };
            !fractions.near(cell).any(holds)
        });
    }

    /// Advances the fluid by `dt` [s] with bodies where they are. `loads` become the fluid's on
    /// each of them: forces [N] and torques about their centres [N m].
    pub fn step(
        &mut self,
        dt: f64,
        bodies: &[RigidBody<D>],
        loads: &mut Vec<Wrench>,
    ) -> PressureOutcome {
        let outcome = self.find_loads(dt, bodies, loads);
        self.move_particles(dt, bodies);
        outcome
    }

    /// The first part of a step: velocities at its end, and the loads on the bodies meanwhile.
    pub fn find_loads(
        &mut self,
        dt: f64,
        bodies: &[RigidBody<D>],
        loads: &mut Vec<Wrench>,
    ) -> PressureOutcome {
        let full = self.full_mass();
        self.gather();
        self.fractions.place_bodies(&self.grid, bodies, full);
        self.find_surface();
        self.hold_faces(bodies);
        self.find_relaxation(dt);
        self.accelerate(dt, bodies);
        self.keep_separated();
        self.assemble(dt, bodies);
        let mut outcome = self.solve();
        for _ in 0..ROUNDS {
            let Self { separation, grid, near, fractions, q, room, depth, .. } = self;
            if !self.has_surface || !separation.find((grid, near), fractions, (q, room), depth) {
                break;
            }
            self.assemble(dt, bodies);
            let again = self.solve();
            outcome =
                PressureOutcome { iterations: outcome.iterations + again.iterations, ..again };
        }
        self.last_step = dt;
        self.correct_volume();
        self.project(dt, bodies);
        self.take_loads(dt, bodies, loads);
        self.slip(dt, bodies, loads);
        outcome
    }

    /// The second part of a step: particles take the velocities, move, and leave bodies, which are
    /// where the step ends. Bodies may have gone since the first part, or have come.
    pub fn move_particles(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        self.fractions.follow(bodies);
        let margin = MARGIN * self.grid.spacing;
        self.find_adrift();
        let [lower, upper] =
            [self.grid.origin.map(|x| x + margin), self.grid.end().map(|x| x - margin)];
        let [lower, upper] = self.open_faces.reach(self.grid.spacing, [lower, upper]);
        let Self { grid, near, team, before, velocity, correction, start_values, .. } = self;
        let of_faces = [&*before, &*velocity, &correction.displacement];
        gather_start_values(team, near, of_faces, start_values);
        let motion = ParticleMotion {
            grid,
            after: velocity,
            start: start_values,
            transfer: self.settings.transfer,
            is_adrift: &self.is_adrift,
            dt,
            fall: std::array::from_fn(|a| dt * self.settings.gravity[a]),
            lower,
            upper,
        };
        let (variant, particles) = (self.variant, &mut self.particles);
        if let Some(damping) = &self.settings.gap_damping {
            motion.take_velocities(team, variant, particles);
            let solids = (&self.fractions, bodies);
            self.gap_bands.damp(damping, grid, solids, &self.order, particles);
            motion.advect(team, variant, particles);
        } else {
            motion.carry(team, variant, particles);
        }
        self.push_out(bodies, margin);
        self.pass_open_faces(dt, bodies);
    }

    /// Finds again what the first part of the last step ([`PicSolver::find_loads`]) left, as far as it
    /// follows from particles and bodies: order, surface, fractions, and the equations but for their
    /// right side. Velocities and pressure do not.
    pub(super) fn resume(&mut self, bodies: &[RigidBody<D>]) {
        let full = self.full_mass();
        self.gather();
        self.open_faces.mark(&mut self.state);
        self.fractions.place_bodies(&self.grid, bodies, full);
        self.find_surface();
        self.hold_faces(bodies);
        self.separation.let_go(&self.grid, &mut self.depth);
        self.assemble(self.last_step, bodies);
    }

    /// Particles leave and enter through open faces.
    fn pass_open_faces(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let Self { grid, open_faces, fractions, velocity, particles, .. } = self;
        open_faces.exchange(dt, grid, velocity, particles, |at| {
            !fractions.near(cell_of(grid, at)).any(|number| {
                let (body, at) = fractions.seen_by(grid, bodies, number, at);
                body.holds(at)
            })
        });
    }

    /// Momentum that the damping in gaps took from the fluid in the last step [kg m/s].
    pub fn gap_damping_taken(&self) -> [f64; D] {
        std::array::from_fn(|a| self.gap_bands.taken[a])
    }

    /// Sets the walls of the box.
    pub fn set_walls(&mut self, walls: [[BoxWall<D>; 2]; D]) {
        self.settings.walls = walls;
    }

    /// Sets the factors over time of velocities and pressures at open faces, in their order.
    pub fn set_open_factors(&mut self, factors: impl IntoIterator<Item = f64>) {
        self.open_faces.set_factors(factors);
    }

    /// Finds the particles that no wet cell is near: they fly by themselves.
    fn find_adrift(&mut self) {
        let Self { grid, order, depth, particles, is_adrift, .. } = self;
        is_adrift.clear();
        is_adrift.resize(particles.len(), false);
        // Particles of a wet cell are near that one.
        for (_, held) in order.cells().filter(|(place, _)| depth[*place] <= 0.0) {
            for particle in held {
                let around = HatWeights::new(grid, None, particles.at(particle));
                let mut is_dry = true;
                around.each(grid, |place, _| is_dry &= depth[place] <= 0.0);
                is_adrift[particle] = is_dry;
            }
        }
    }

    /// Particles to grid. Components are works of their own, so that sums keep their order.
    fn gather(&mut self) {
        self.order.sort(&self.grid, &mut self.particles);
        let places = self.order.cells().map(|(place, _)| place as u32);
        self.near.find(&self.grid, self.settings.fills_all, places);
        let Self { grid, near, particles, team, before, face_mass, face_sums, .. } = self;
        let Self { is_carried, state, found, variant, .. } = self;
        let (grid, near, particles, variant) = (&*grid, &*near, &*particles, *variant);
        team.for_pieces(
            (
                Cut::every(before, 1),
                Cut::every(face_mass, 1),
                Cut::every(face_sums, 1),
                Cut::every(is_carried, 1),
                Cut::every(state, 1),
                Cut::every(found, 1),
            ),
            |a, (before, mass, sums, carried, state, found): Gathered| {
                let gathered = (&mut mass[0][..], &mut before[0][..]);
                to_faces(variant, (grid, near), particles, a, &mut sums[0], gathered);
                near.clear_left(&mut carried[0], false);
                near.clear_left(&mut state[0], FaceState::Unknown);
                for at in near.spans().flatten() {
                    let mass = mass[0][at];
                    carried[0][at] = mass > 0.0;
                    state[0][at] = if mass > 0.0 { FaceState::Fluid } else { FaceState::Unknown };
                }
                extrapolate(grid, near, LAYERS, &mut state[0], &mut before[0], &mut found[0]);
            },
        );
    }

    /// Depth of each cell below the surface.
    fn find_surface(&mut self) {
        let grids = (&self.grid, &self.near);
        to_cells(self.variant, grids, &self.particles, &mut self.cell_mass);
        if self.fractions.has_changed || !self.has_room {
            room(&self.grid, &self.fractions.volume, &mut self.room, &mut self.work);
            self.has_room = true;
        }
        let full = self.full_mass();
        self.near.clear_left(&mut self.depth, -1.0);
        for at in self.near.spans().flatten() {
            let is_cell = self.fractions.volume[at] > 0.0;
            self.depth[at] = match (is_cell, self.settings.fills_all) {
                (true, true) => 1.0,
                (true, false) => depth(self.cell_mass[at] / full, self.room[at]),
                (false, _) => -1.0,
            };
        }
        if !self.settings.fills_all {
            self.close_voids();
        }
    }

    /// Takes a cell without fluid that has fluid on all sides for fluid: it ran empty because
    /// particles gather elsewhere, and the pressure of nothing in there would drive them on. Cells
    /// that solids take more than half of have too few particles to say anything.
    fn close_voids(&mut self) {
        self.voids.clear();
        for at in self.near.cells() {
            if self.depth[at] > 0.0 || self.fractions.volume[at] == 0.0 {
                continue;
            }
            let Self { grid, fractions, depth, room, .. } = &*self;
            let is_air = |beyond: usize| {
                depth[beyond] <= 0.0 && room[beyond] >= HALF && fractions.volume[beyond] > 0.0
            };
            let is_dry = |beyond: usize| depth[beyond] <= 0.0;
            if all_around(grid, fractions, at, |beyond| !is_air(beyond))
                && !all_around(grid, fractions, at, is_dry)
            {
                self.voids.push(at as u32);
            }
        }
        for &at in &self.voids {
            self.depth[at as usize] = 1.0;
        }
        self.grid.ghosts.fill(&mut self.depth);
    }

    /// Where surfaces hold the fluid back: faces in bodies have the bodies' velocity, and faces
    /// beyond the box such a one that the walls between have theirs.
    fn hold_faces(&mut self, bodies: &[RigidBody<D>]) {
        for a in 0..D {
            let grids = (&self.grid, &self.near);
            hold(grids, &self.fractions, &self.settings, bodies, a, &mut self.before[a]);
            self.grid.ghosts.fill(&mut self.before[a]);
        }
    }

    /// Forces that need no pressure. Shear acts on the velocities that the fluid has, and on what of
    /// gravity the pressure is expected not to hold up: what it did in the step before.
    fn accelerate(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let PicSettings { gravity, drive, viscosity, walls, bodies_stick, density, .. } =
            self.settings;
        for (after, before) in self.velocity.iter_mut().zip(&self.before) {
            self.near.clear_left(after, 0.0);
            self.near.spans().for_each(|span| after[span.clone()].copy_from_slice(&before[span]));
        }
        let at_rest = self.fractions.at_rest.len();
        self.viscosity.clear(at_rest, bodies, density * self.grid.cell_volume());
        let gain: [f64; D] = std::array::from_fn(|a| dt * (gravity[a] + drive[a]));
        if viscosity > 0.0 {
            self.expect(dt, gain, bodies, 1.0);
            let Self { grid, fractions, expected_gains, .. } = self;
            let step = ViscousStep {
                grid,
                fractions,
                bodies,
                walls: &walls,
                bodies_stick,
                density,
                number: dt * viscosity / (grid.spacing * grid.spacing),
                dt,
                gains: expected_gains,
            };
            let Self { viscosity, team, variant, is_carried, velocity, .. } = self;
            viscosity.shear(team, *variant, &step, is_carried, velocity);
            self.expect(dt, gain, bodies, -1.0);
        }
        for (velocity, gain) in self.velocity.iter_mut().zip(gain) {
            self.near.spans().flatten().for_each(|at| velocity[at] += gain);
        }
        self.open_faces.prescribe(&mut self.velocity);
    }

    /// Adds to the velocities, times a factor, what gravity and pressure together are expected to
    /// change them by: gravity, and the pressure of the step before in the cells that had one. With
    /// it the shear sees the velocities at the end of the step; without it they would slip along
    /// walls by what the pressure then changes, and a disc in a shear flow would turn too slowly, in
    /// proportion to the step (Van Kan, *SIAM J. Sci. Stat. Comput.* 7 (1986) 870).
    fn expect(&mut self, dt: f64, gain: [f64; D], bodies: &[RigidBody<D>], factor: f64) {
        self.expected_gains.clear();
        if self.last_step == 0.0 {
            return;
        }
        let Self { grid, near, fractions, settings, q, depth, velocity, .. } = self;
        let ratio = dt / self.last_step;
        let gradient = PressureGradient { stride: grid.stride, fractions, settings, q, depth };
        for (a, velocity) in velocity.iter_mut().enumerate() {
            for at in near.spans().flatten().filter(|&at| at >= grid.stride[a]) {
                if let Some(slope) = gradient.known(a, at) {
                    velocity[at] += factor * (gain[a] - ratio * slope);
                }
            }
            grid.ghosts.fill(velocity);
        }
        let full = self.settings.density * grid.cell_volume();
        let coupling = &self.fractions.free.coupling;
        let free = bodies.iter().filter(|body| body.is_free());
        for (number, body) in free.enumerate() {
            // A body moves from cell to cell, some of which had no pressure: its load is known as a
            // whole.
            let same = self.pressed.get(number).filter(|(id, _)| *id == body.id);
            let Some((_, load)) =
                same.or_else(|| self.pressed.iter().find(|(id, _)| *id == body.id))
            else {
                self.expected_gains.push([0.0; 6]);
                continue;
            };
            let mut wrench = load.map(|w| dt / full * w);
            for a in 0..D {
                let weight = body.mass().unwrap_or(0.0) * self.settings.gravity[a];
                wrench[a] += dt / full * (body.force[a] + weight);
            }
            self.expected_gains.push(coupling.moved(number, &wrench));
        }
    }

    #[inline]
    pub(super) fn is_wet(&self, at: usize) -> bool {
        self.depth[at] > 0.0
    }

    /// Cells that solids let go of in the last step are air still, unless fluid gathers there.
    fn keep_separated(&mut self) {
        let Self { separation, fractions, velocity, depth, grid, .. } = self;
        let gathers = |at: usize| {
            let outflow: f64 = (0..D)
                .map(|a| {
                    let upper = at + grid.stride[a];
                    fractions.open[a][upper] * velocity[a][upper]
                        - fractions.open[a][at] * velocity[a][at]
                })
                .sum();
            outflow + fractions.pushed[at] + fractions.pushed_by_free[at] <= 0.0
        };
        separation.keep(depth, gathers);
        grid.ghosts.fill(depth);
    }

    /// The pressure's equations.
    fn assemble(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let stride = self.grid.stride;
        self.has_surface = false;
        let Self { stencil, right, near, .. } = self;
        let Stencil { diagonal, coupling, .. } = stencil;
        for array in coupling.iter_mut().chain([diagonal, right]) {
            near.clear_left(array, 0.0);
            near.fill(array, 0.0);
        }
        near.clear_left(&mut self.q, 0.0);
        for at in self.near.cells() {
            if !self.is_wet(at) {
                self.q[at] = 0.0;
                continue;
            }
            let mut outflow = self.fractions.pushed[at];
            for a in 0..D {
                for (face, beyond, sign) in
                    [(at, at - stride[a], -1.0), (at + stride[a], at + stride[a], 1.0)]
                {
                    let open = self.fractions.open[a][face];
                    if open == 0.0 {
                        continue;
                    }
                    outflow += sign * open * self.velocity[a][face];
                    if self.is_wet(beyond) {
                        self.stencil.diagonal[at] += open;
                        self.stencil.coupling[a][face] = open;
                    } else if !self.settings.fills_all && self.fractions.volume[beyond] > 0.0 {
                        self.stencil.diagonal[at] += open / self.to_surface(at, beyond);
                        self.has_surface = true;
                    }
                }
            }
            self.right[at] = -outflow;
        }
        let Self { open_faces, fractions, velocity, stencil, right, depth, grid, .. } = self;
        let step = (dt, grid.spacing);
        let is_wet = |at: usize| depth[at] > 0.0;
        self.has_surface |=
            open_faces.add_to_equations(step, &fractions.open, velocity, is_wet, stencil, right);
        self.add_bodies(dt, bodies);
        self.stencil.find_rows_near(&self.near, self.grid.row_length());
        for at in self.near.cells() {
            if self.stencil.diagonal[at] == 0.0 {
                self.right[at] = 0.0;
                self.q[at] = 0.0;
            }
        }
    }

    /// The share of a cell's excess of mass that is moved away in this step. Particles gather as they
    /// move, so it goes with the cells that the fastest fluid crosses.
    fn find_relaxation(&mut self, dt: f64) {
        let of_near =
            |u: &Vec<f64>| self.near.spans().flatten().fold(0.0, |most, at| u[at].abs().max(most));
        let fastest = self.before.iter().map(of_near).fold(0.0_f64, f64::max);
        let crossed = fastest * dt / self.grid.spacing;
        self.relaxation = self.settings.relaxation * (crossed / USUAL_COURANT).min(1.0);
    }

    /// Finds how particles are to move apart. Where the surface is near, only excess counts: there a
    /// cell may well be less than full.
    fn correct_volume(&mut self) {
        let full = self.full_mass();
        let Self { grid, near, team, stencil, fractions, settings, depth, .. } = self;
        let Self { cell_mass, room, .. } = self;
        let share = self.relaxation;
        let excess = |at: usize| {
            let filled = cell_mass[at] / full - room[at];
            share * if is_deep(grid, fractions, depth, at) { filled } else { filled.max(0.0) }
        };
        let to_surface =
            |wet: usize, air: usize| settings.surface.distance(depth[wet], depth[air].min(0.0));
        let open = &fractions.open;
        self.correction.find(team, self.variant, (grid, near), stencil, open, excess, to_surface);
        self.open_faces.hold_still(&mut self.correction.displacement);
    }

    /// Distance of the surface from a wet cell towards a cell of air.
    #[inline]
    fn to_surface(&self, wet: usize, air: usize) -> f64 {
        self.settings.surface.distance(self.depth[wet], self.depth[air].min(0.0))
    }

    /// Free bodies: what of them enters the right side, `- J^T U*`. Cells without an equation press
    /// on nothing. The pressure of a fluid at rest lifts a body by the faces that it covers; what
    /// its volume differs from that is added.
    fn add_bodies(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let full = self.full_mass();
        let PicSettings { gravity, .. } = self.settings;
        let diagonal = &self.stencil.diagonal;
        let coupling = &mut self.fractions.free.coupling;
        for (cell, wrench) in coupling.cells.iter().zip(&mut coupling.wrenches) {
            if diagonal[*cell as usize] == 0.0 {
                *wrench = [0.0; 6];
            }
        }
        self.lift.clear();
        for border in [&self.fractions.free, &self.fractions.held] {
            for body in 0..border.coupling.count() {
                let mut lift = [0.0; D];
                for entry in border.coupling.entries(body) {
                    if diagonal[border.coupling.cells[entry] as usize] > 0.0 {
                        for a in 0..D {
                            lift[a] += border.beyond_faces[entry][a];
                        }
                    }
                }
                self.lift.push(std::array::from_fn(|a| -full * gravity[a] * lift[a]));
            }
        }
        let at_rest = self.fractions.at_rest.len();
        let shear = &self.viscosity.loads.solids;
        let coupling = &self.fractions.free.coupling;
        let free = bodies.iter().enumerate().filter(|(_, body)| body.is_free());
        for (number, (index, body)) in free.enumerate() {
            // Per unit of `q`, mobility is what a force of `full` over a second would change.
            let mut wrench: Wrench = shear[at_rest + index];
            for a in 0..D {
                let mass = body.mass().unwrap_or(0.0);
                wrench[a] += body.force[a] + self.lift[number][a] + mass * gravity[a];
            }
            let gain = coupling.moved(number, &wrench.map(|w| w * dt / full));
            let motion = body.motion();
            let velocity: Wrench = std::array::from_fn(|k| motion[k] + gain[k]);
            coupling.add_flux(number, &velocity, &mut self.right, |_| -1.0);
        }
    }

    pub(super) fn solve(&mut self) -> PressureOutcome {
        if !self.has_surface {
            self.make_compatible();
        }
        let coupling = &self.fractions.free.coupling;
        self.multigrid.prepare(&self.stencil, &self.near, coupling);
        let outcome = self.iteration.solve(
            &mut self.team,
            self.variant,
            &self.stencil,
            coupling,
            &mut self.multigrid,
            &self.right,
            &mut self.q,
            self.settings.tolerance,
            self.has_surface,
        );
        self.grid.ghosts.fill(&mut self.q);
        outcome
    }

    /// Without a surface, what flows in must flow out: the rest is taken from all cells alike.
    fn make_compatible(&mut self) {
        let Self { stencil, right, .. } = self;
        let spans = || stencil.rows.all_spans().flatten();
        let cells = || spans().filter(|&at| stencil.diagonal[at] > 0.0);
        let (sum, count) = cells().fold((0.0, 0), |(s, n), at| (s + right[at], n + 1));
        let mean = sum / f64::from(count.max(1));
        cells().for_each(|at| right[at] -= mean);
    }

    /// Takes the pressure's gradient from the velocities, and extrapolates them.
    fn project(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let Self { grid, near, team, velocity, state, found, is_carried, .. } = self;
        let near = &*near;
        let Self { fractions, settings, q, depth, open_faces, .. } = self;
        let is_wet = |at: usize| depth[at] > 0.0;
        let step = (dt, grid.spacing);
        let passing = &*open_faces;
        let gradient = PressureGradient { stride: grid.stride, fractions, settings, q, depth };
        team.for_pieces(
            (Cut::every(velocity, 1), Cut::every(state, 1), Cut::every(found, 1)),
            |a, (velocity, state, found): Projected| {
                let (velocity, state) = (&mut velocity[0], &mut state[0]);
                gradient.take(a, near, &is_carried[a], velocity, state);
                passing.set_velocities(a, step, (q, is_wet), velocity, state);
                extrapolate(grid, near, LAYERS, state, velocity, &mut found[0]);
                hold((grid, near), fractions, settings, bodies, a, velocity);
                grid.ghosts.fill(velocity);
            },
        );
        open_faces.follow(dt, grid, velocity, is_wet);
    }

    /// Faces in solids that the fluid slips along have the solids' normal velocities, as they are once
    /// the loads have acted.
    fn slip(&mut self, dt: f64, bodies: &[RigidBody<D>], loads: &[Wrench]) {
        let sticks = self.settings.bodies_stick && self.settings.viscosity > 0.0;
        if sticks || self.slip_faces.is_empty(&self.fractions) {
            return;
        }
        let full = self.full_mass();
        let Self { grid, fractions, velocity, slip_faces, motions, settings, .. } = self;
        motions.clear();
        for (body, load) in bodies.iter().zip(loads) {
            let mut wrench = *load;
            for a in 0..D {
                wrench[a] += body.force[a] + body.mass().unwrap_or(0.0) * settings.gravity[a];
            }
            let mobility = body.mobility_by_shear(full);
            let mut motion = body.motion();
            for (k, row) in mobility.iter().enumerate() {
                motion[k] += (0..6).map(|l| row[l] * wrench[l]).sum::<f64>() * dt / full;
            }
            motions.push(motion);
        }
        slip_faces.constrain(grid, (fractions, bodies), motions, velocity);
        velocity.iter_mut().for_each(|component| grid.ghosts.fill(component));
    }

    /// Moves particles out of solids, along their normals. Most particles are in cells that no
    /// solid comes near.
    fn push_out(&mut self, bodies: &[RigidBody<D>], margin: f64) {
        let reach = 2.0 * self.grid.spacing;
        for particle in 0..self.particles.len() {
            let mut at = self.particles.at(particle);
            let cell = cell_of(&self.grid, at);
            if !self.fractions.is_near_a_body(cell) {
                continue;
            }
            for number in self.fractions.near(cell) {
                let (body, seen) = self.fractions.seen_by(&self.grid, bodies, number, at);
                let Some((height, normal)) = body.height(seen, reach) else { continue };
                if height < margin {
                    let step = normal.map(|n| (margin - height) * n);
                    at = std::array::from_fn(|a| at[a] + step[a]);
                    if self.is_adrift[particle] {
                        let met = std::array::from_fn(|a| seen[a] + step[a]);
                        self.particles.stop_into(particle, normal, body.velocity_at(met));
                    }
                }
            }
            for a in 0..D {
                self.particles.position[a][particle] = self.grid.wrapped_along(a, at[a]);
            }
        }
    }
}

/// True if something holds for all cells that a cell is open to.
fn all_around<const D: usize>(
    grid: &StaggeredGrid<D>,
    fractions: &OpenFractions<D>,
    at: usize,
    holds: impl Fn(usize) -> bool,
) -> bool {
    (0..D).all(|a| {
        let stride = grid.stride[a];
        let beside = [(at, at - stride), (at + stride, at + stride)];
        beside.into_iter().all(|(face, beyond)| fractions.open[a][face] == 0.0 || holds(beyond))
    })
}

/// True if a cell is part of the fluid, and all that it is open to are.
pub(super) fn is_deep<const D: usize>(
    grid: &StaggeredGrid<D>,
    fractions: &OpenFractions<D>,
    depth: &[f64],
    at: usize,
) -> bool {
    depth[at] > 0.0 && all_around(grid, fractions, at, |beyond| depth[beyond] > 0.0)
}

/// Arrays of a component that come from particles.
type Gathered<'a> = (
    &'a mut [Vec<f64>],
    &'a mut [Vec<f64>],
    &'a mut [FaceSums],
    &'a mut [Vec<bool>],
    &'a mut [Vec<FaceState>],
    &'a mut [ExtrapolationRoom],
);

/// Arrays of a component that the pressure changes.
type Projected<'a> = (&'a mut [Vec<f64>], &'a mut [Vec<FaceState>], &'a mut [ExtrapolationRoom]);

#[cfg(test)]
mod tests;
