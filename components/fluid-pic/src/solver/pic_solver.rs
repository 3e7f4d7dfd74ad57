//! The solver: one step after the other.
//!
//! ```text
//! 1  particles to grid          u^n
//! 2  surface                    depth of each cell
//! 3  open fractions             bodies where they are
//! 4  forces                     u* = u^n + dt g
//! 5  pressure and bodies        (A + J^T S J) q = - div u* - J^T U*
//! 6  projection                 u = u* - grad q,  extrapolated beyond the fluid
//! 7  grid to particles          FLIP and PIC, or APIC
//! 8  advection                  particles move
//! ```

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::cell_order::{CellOrder, cell_of};
use crate::particles::from_grid::{FaceVelocity, advect, take_velocities};
use crate::particles::particle_arrays::{ParticleArrays, Transfer};
use crate::particles::to_grid::{to_cells, to_faces};
use crate::pressure::body_coupling::{BodyCoupling, Wrench};
use crate::pressure::conjugate_gradients::{ConjugateGradients, PressureOutcome, Tolerance};
use crate::pressure::multigrid::Multigrid;
use crate::pressure::stencil::Stencil;
use crate::solids::open_fractions::{MARGIN, OpenFractions};
use crate::solids::rigid_body::RigidBody;
use crate::solver::extrapolation::{FaceState, extrapolate};
use crate::solver::free_surface::SurfaceOrder;
use crate::surface::fill_level::{depth, room};
use tremie_team::{Team, Variant};

/// Layers of faces beyond the fluid that have a velocity.
const LAYERS: usize = 3;

/// Settings of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PicSettings<const D: usize> {
    /// Density of the fluid [kg/m³].
    pub density: f64,
    /// Acceleration of gravity [m/s²].
    pub gravity: [f64; D],
    /// Transfer between particles and grid.
    pub transfer: Transfer,
    /// Order of the free surface.
    pub surface: SurfaceOrder,
    /// End of the pressure's iteration.
    pub tolerance: Tolerance,
    /// Particles along each axis of a cell at the start.
    pub particles_per_axis: usize,
}

impl<const D: usize> PicSettings<D> {
    /// Water, by FLIP with a share of 0.01 of PIC, with a surface of second order.
    pub fn water(gravity: [f64; D]) -> Self {
        Self {
            density: 1000.0,
            gravity,
            transfer: Transfer::Blend { pic: 0.01 },
            surface: SurfaceOrder::Second,
            tolerance: Tolerance { relative: 1e-8, absolute: 1e-12, iterations: 100 },
            particles_per_axis: 2,
        }
    }
}

/// A fluid with a free surface, and bodies in it.
pub struct PicSolver<const D: usize> {
    /// The grid.
    pub grid: StaggeredGrid<D>,
    settings: PicSettings<D>,
    team: Team,
    variant: Variant,
    /// The particles.
    pub particles: ParticleArrays<D>,
    order: CellOrder,
    fractions: OpenFractions<D>,
    coupling: BodyCoupling,
    before: FaceVelocity<D>,
    velocity: FaceVelocity<D>,
    face_mass: Vec<f64>,
    state: [Vec<FaceState>; D],
    found: Vec<(u32, f64)>,
    cell_mass: Vec<f64>,
    room: Vec<f64>,
    work: Vec<f64>,
    depth: Vec<f64>,
    stencil: Stencil<f64, D>,
    right: Vec<f64>,
    q: Vec<f64>,
    multigrid: Multigrid<D>,
    iteration: ConjugateGradients,
    has_surface: bool,
    /// Lift of each free body beyond that of the faces that it covers [N].
    lift: Vec<[f64; D]>,
}

impl<const D: usize> PicSolver<D> {
    /// Without any particles. `is_open` says which faces (axis, side) of the box fluid may leave
    /// through.
    ///
    /// # Errors
    /// If the system gives no more threads.
    pub fn new(
        grid: StaggeredGrid<D>,
        settings: PicSettings<D>,
        threads: usize,
        is_open: impl Fn(usize, usize) -> bool,
    ) -> std::io::Result<Self> {
        let zeros = || vec![0.0; grid.stored];
        let per_cell = settings.particles_per_axis.pow(D as u32) as f64;
        let mass = settings.density * grid.cell_volume() / per_cell;
        Ok(Self {
            team: Team::new("fluid-pic", threads)?,
            variant: Variant::widest(),
            particles: ParticleArrays::new(mass),
            order: CellOrder::default(),
            fractions: OpenFractions::new(&grid, is_open),
            coupling: BodyCoupling::default(),
            before: std::array::from_fn(|_| zeros()),
            velocity: std::array::from_fn(|_| zeros()),
            face_mass: zeros(),
            state: std::array::from_fn(|_| vec![FaceState::Unknown; grid.stored]),
            found: Vec::new(),
            cell_mass: zeros(),
            room: zeros(),
            work: zeros(),
            depth: zeros(),
            stencil: Stencil::empty(grid.stored, grid.stride),
            right: zeros(),
            q: zeros(),
            multigrid: Multigrid::new(grid.cells),
            iteration: ConjugateGradients::new(grid.stored),
            has_surface: false,
            lift: Vec::new(),
            settings,
            grid,
        })
    }

    /// Mass of a cell full of fluid [kg], in two dimensions [kg/m].
    fn full_mass(&self) -> f64 {
        self.settings.density * self.grid.cell_volume()
    }

    /// Advances the fluid by `dt` [s] with bodies where they are. `forces` become the fluid's on
    /// each of them [N].
    pub fn step(
        &mut self,
        dt: f64,
        bodies: &[RigidBody<D>],
        forces: &mut Vec<[f64; D]>,
    ) -> PressureOutcome {
        self.gather();
        let full = self.full_mass();
        self.fractions.place_bodies(&self.grid, bodies, full, &mut self.coupling);
        self.find_surface();
        self.accelerate(dt);
        self.assemble(dt, bodies);
        let outcome = self.solve();
        self.project();
        self.forces(dt, bodies, forces);
        self.scatter(dt, bodies);
        outcome
    }

    /// Particles to grid.
    fn gather(&mut self) {
        self.order.sort(&self.grid, &mut self.particles);
        for a in 0..D {
            to_faces(&self.grid, &self.particles, a, &mut self.face_mass, &mut self.before[a]);
            for at in 0..self.grid.stored {
                let is_known = self.face_mass[at] > 0.0;
                self.state[a][at] = if is_known { FaceState::Fluid } else { FaceState::Unknown };
            }
            let (state, before) = (&mut self.state[a], &mut self.before[a]);
            extrapolate(&self.grid, LAYERS, state, before, &mut self.found);
        }
    }

    /// Depth of each cell below the surface.
    fn find_surface(&mut self) {
        to_cells(&self.grid, &self.particles, &mut self.cell_mass);
        room(&self.grid, &self.fractions.volume, &mut self.room, &mut self.work);
        let full = self.full_mass();
        for at in 0..self.grid.stored {
            let is_cell = self.fractions.volume[at] > 0.0;
            self.depth[at] =
                if is_cell { depth(self.cell_mass[at] / full, self.room[at]) } else { -1.0 };
        }
    }

    /// Forces that need no pressure.
    fn accelerate(&mut self, dt: f64) {
        for a in 0..D {
            let gain = dt * self.settings.gravity[a];
            for (after, before) in self.velocity[a].iter_mut().zip(&self.before[a]) {
                *after = before + gain;
            }
        }
    }

    #[inline]
    fn is_wet(&self, at: usize) -> bool {
        self.depth[at] > 0.0
    }

    /// The pressure's equations.
    fn assemble(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        let stride = self.grid.stride;
        self.has_surface = false;
        for at in 0..self.grid.stored {
            self.stencil.diagonal[at] = 0.0;
            self.right[at] = 0.0;
            for a in 0..D {
                self.stencil.coupling[a][at] = 0.0;
            }
        }
        for cell in self.grid.all() {
            let at = self.grid.place(cell);
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
                    } else {
                        self.stencil.diagonal[at] += open / self.to_surface(at, beyond);
                        self.has_surface = true;
                    }
                }
            }
            self.right[at] = -outflow;
        }
        self.add_bodies(dt, bodies);
        self.stencil.find_rows(self.grid.row_length());
        for at in 0..self.grid.stored {
            if self.stencil.diagonal[at] == 0.0 {
                self.right[at] = 0.0;
            }
        }
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
        for (cell, wrench) in self.coupling.cells.iter().zip(&mut self.coupling.wrenches) {
            if self.stencil.diagonal[*cell as usize] == 0.0 {
                *wrench = [0.0; 6];
            }
        }
        self.lift.clear();
        for body in 0..self.coupling.count() {
            let mut lift = [0.0; D];
            for entry in self.coupling.entries(body) {
                if self.coupling.wrenches[entry] != [0.0; 6] {
                    for a in 0..D {
                        lift[a] += self.fractions.beyond_faces[entry][a];
                    }
                }
            }
            let full = self.full_mass();
            self.lift.push(std::array::from_fn(|a| -full * self.settings.gravity[a] * lift[a]));
        }
        let free = bodies.iter().filter_map(|body| body.mass.map(|mass| (body, mass)));
        for (number, (body, mass)) in free.enumerate() {
            let mut velocity: Wrench = [0.0; 6];
            for a in 0..D {
                velocity[a] = body.velocity[a]
                    + dt * (self.settings.gravity[a]
                        + (body.force[a] + self.lift[number][a]) / mass);
            }
            self.coupling.add_flux(number, &velocity, &mut self.right, |_| -1.0);
        }
    }

    fn solve(&mut self) -> PressureOutcome {
        if !self.has_surface {
            self.make_compatible();
        }
        self.multigrid.prepare(&self.stencil, &self.coupling);
        self.iteration.solve(
            &mut self.team,
            self.variant,
            &self.stencil,
            &self.coupling,
            &mut self.multigrid,
            &self.right,
            &mut self.q,
            self.settings.tolerance,
        )
    }

    /// Without a surface, what flows in must flow out: the rest is taken from all cells alike.
    fn make_compatible(&mut self) {
        let cells = || (0..self.grid.stored).filter(|&at| self.stencil.diagonal[at] > 0.0);
        let (sum, count) = cells().fold((0.0, 0), |(s, n), at| (s + self.right[at], n + 1));
        let mean = sum / f64::from(count.max(1));
        for at in 0..self.grid.stored {
            if self.stencil.diagonal[at] > 0.0 {
                self.right[at] -= mean;
            }
        }
    }

    /// Takes the pressure's gradient from the velocities, and extrapolates them.
    fn project(&mut self) {
        for a in 0..D {
            let stride = self.grid.stride[a];
            self.state[a][..stride].fill(FaceState::Unknown);
            for at in stride..self.grid.stored {
                let below = at - stride;
                let open = self.fractions.open[a][at];
                self.state[a][at] = if self.fractions.is_wall(a, at, below) {
                    self.velocity[a][at] = 0.0;
                    FaceState::Wall
                } else if open == 0.0 {
                    FaceState::Unknown
                } else {
                    match (self.is_wet(below), self.is_wet(at)) {
                        (true, true) => {
                            self.velocity[a][at] -= self.q[at] - self.q[below];
                            FaceState::Fluid
                        }
                        (true, false) => {
                            self.velocity[a][at] += self.q[below] / self.to_surface(below, at);
                            FaceState::Fluid
                        }
                        (false, true) => {
                            self.velocity[a][at] -= self.q[at] / self.to_surface(at, below);
                            FaceState::Fluid
                        }
                        (false, false) => FaceState::Unknown,
                    }
                };
            }
            let (state, velocity) = (&mut self.state[a], &mut self.velocity[a]);
            extrapolate(&self.grid, LAYERS, state, velocity, &mut self.found);
        }
    }

    /// Forces of the pressure on all bodies.
    fn forces(&mut self, dt: f64, bodies: &[RigidBody<D>], forces: &mut Vec<[f64; D]>) {
        let unit = self.full_mass() / dt;
        forces.clear();
        let mut number = 0;
        for body in bodies {
            if body.mass.is_some() {
                let wrench = self.coupling.wrench(number, &self.q);
                let lift = self.lift[number];
                forces.push(std::array::from_fn(|a| unit * wrench[a] + lift[a]));
                number += 1;
            } else {
                forces.push([0.0; D]);
            }
        }
    }

    /// Grid to particles; particles move, and leave bodies.
    fn scatter(&mut self, dt: f64, bodies: &[RigidBody<D>]) {
        take_velocities(
            &self.grid,
            &mut self.team,
            self.settings.transfer,
            &self.before,
            &self.velocity,
            &mut self.particles,
        );
        let margin = MARGIN * self.grid.spacing;
        let lower = self.grid.origin.map(|x| x + margin);
        let upper = self.grid.end().map(|x| x - margin);
        advect(&self.grid, &self.velocity, dt, lower, upper, &mut self.particles);
        self.push_out(bodies, margin);
    }

    /// Moves particles out of bodies, straight away from their centres. Most particles are in cells
    /// that no body comes near.
    fn push_out(&mut self, bodies: &[RigidBody<D>], margin: f64) {
        for particle in 0..self.particles.len() {
            let mut at = self.particles.at(particle);
            if !self.fractions.is_near_a_body(cell_of(&self.grid, at)) {
                continue;
            }
            for body in bodies {
                let arm: [f64; D] = std::array::from_fn(|a| at[a] - body.centre[a]);
                let distance2: f64 = arm.iter().map(|x| x * x).sum();
                let reach = body.radius + margin;
                if distance2 < reach * reach && distance2 > 0.0 {
                    let stretch = reach / distance2.sqrt();
                    at = std::array::from_fn(|a| body.centre[a] + stretch * arm[a]);
                }
            }
            for a in 0..D {
                self.particles.position[a][particle] = at[a];
            }
        }
    }

    /// Largest speed of particles [m/s].
    pub fn max_speed(&self) -> f64 {
        let of = |k: usize| -> f64 {
            (0..D).map(|a| self.particles.velocity[a][k].powi(2)).sum::<f64>()
        };
        (0..self.particles.len()).map(of).fold(0.0, f64::max).sqrt()
    }

    /// Gauge pressure in a cell after a step of `dt` [Pa].
    pub fn pressure(&self, cell: [isize; D], dt: f64) -> f64 {
        self.q[self.grid.place(cell)] * self.settings.density * self.grid.spacing / dt
    }
}

#[cfg(test)]
mod tests;
