//! Loads on bodies and walls, and what else a user may ask of the solver.

use crate::pressure::body_coupling::Wrench;
use crate::solids::rigid_body::RigidBody;
use crate::solver::pic_solver::{PicSolver, is_deep};

/// Sums over the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidSums<const D: usize> {
    /// Volume that its cells fill [m³].
    pub volume: f64,
    /// Momentum [kg m/s].
    pub momentum: [f64; D],
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Potential energy in gravity, from the domain's lower corner [J].
    pub potential: f64,
    /// Largest speed of a particle [m/s].
    pub max_speed: f64,
    /// Farthest coordinate of a particle along each axis [m].
    pub farthest: [f64; D],
}

impl<const D: usize> PicSolver<D> {
    /// Loads of pressure and shear on all bodies.
    pub(super) fn take_loads(&mut self, dt: f64, bodies: &[RigidBody<D>], loads: &mut Vec<Wrench>) {
        loads.clear();
        self.pressed.clear();
        let at_rest = self.fractions.at_rest.len();
        let (mut free, mut held) = (0, at_rest);
        for (number, body) in bodies.iter().enumerate() {
            let place = if body.is_free() { &mut free } else { &mut held };
            let load = self.load(dt, body.is_free(), *place, at_rest + number);
            if body.is_free() {
                let shear = self.viscosity.loads.solids[at_rest + number];
                self.pressed.push((body.id, std::array::from_fn(|k| load[k] - shear[k])));
            }
            loads.push(load);
            *place += 1;
        }
    }

    /// The load on a body, given its number among the free or held ones and among all solids.
    fn load(&self, dt: f64, is_free: bool, number: usize, solid: usize) -> Wrench {
        let unit = self.full_mass() / dt;
        let border = if is_free { &self.fractions.free } else { &self.fractions.held };
        let of_pressure = border.coupling.wrench(number, &self.q);
        let shear = self.viscosity.loads.solids[solid];
        let before = if is_free { 0 } else { self.fractions.free.coupling.count() };
        let lift = self.lift[before + number];
        std::array::from_fn(|k| {
            unit * of_pressure[k] + shear[k] + if k < D { lift[k] } else { 0.0 }
        })
    }

    /// Loads on the solids that never move.
    pub fn loads_at_rest(&self, dt: f64, loads: &mut Vec<Wrench>) {
        loads.clear();
        // Before the first step there are none.
        if self.viscosity.loads.solids.len() < self.fractions.at_rest.len() {
            return;
        }
        loads.extend((0..self.fractions.at_rest.len()).map(|k| self.load(dt, false, k, k)));
    }

    /// Forces of pressure and shear on the walls of the box [N], lower and upper along each axis.
    pub fn wall_forces(&self, dt: f64) -> [[[f64; D]; 2]; D] {
        let mut forces = self.viscosity.loads.walls;
        let unit = self.full_mass() / dt;
        // From the centre of a cell to the wall the pressure changes by the weight in between.
        let weight = self.settings.gravity.map(|g| 0.5 * self.full_mass() * g);
        for cell in self.grid.all() {
            let q = self.q[self.grid.place(cell)];
            if q == 0.0 {
                continue;
            }
            for a in (0..D).filter(|&a| !self.grid.periodic[a]) {
                if cell[a] == 0 {
                    forces[a][0][a] -= unit * q - weight[a];
                }
                if cell[a] + 1 == self.grid.cells[a] as isize {
                    forces[a][1][a] += unit * q + weight[a];
                }
            }
        }
        // What bodies cover of a wall, the fluid does not press on.
        for &(a, side, cell, share) in &self.fractions.on_walls {
            let (a, side) = (usize::from(a), usize::from(side));
            let sign = [-1.0, 1.0][side];
            let pressed = unit * self.q[cell as usize] + sign * weight[a];
            forces[a][side][a] -= sign * share * pressed;
        }
        forces
    }

    /// Density of the fluid [kg/m³].
    pub fn density(&self) -> f64 {
        self.settings.density
    }

    /// Loads of shear on all solids, those at rest first, then the bodies of the last step.
    pub fn shear_loads(&self) -> &[Wrench] {
        &self.viscosity.loads.solids
    }

    /// Volume of the fluid [m³]: of cells deep inside what is open of them, of others what their
    /// particles would fill.
    fn volume(&self) -> f64 {
        let full = self.full_mass();
        let of = |cell: [isize; D]| {
            let at = self.grid.place(cell);
            if is_deep(&self.grid, &self.fractions, &self.depth, at) {
                self.fractions.volume[at]
            } else {
                self.cell_mass[at] / full
            }
        };
        let own: f64 = self.grid.all().map(of).sum();
        // The hat of a particle beside a wall reaches beyond.
        let inside: f64 = self.grid.all().map(|cell| self.cell_mass[self.grid.place(cell)]).sum();
        let beyond = self.particles.mass * self.particles.len() as f64 - inside;
        (own + beyond / full) * self.grid.cell_volume()
    }

    /// Volumes of the fluid that entered through open faces, and that left, since the start [m³].
    pub fn passed_volumes(&self) -> [f64; 2] {
        let volume = self.particles.mass / self.settings.density;
        self.open_faces.passed().map(|count| count as f64 * volume)
    }

    /// Largest speed of particles [m/s].
    pub fn max_speed(&self) -> f64 {
        let of = |k: usize| -> f64 {
            (0..D).map(|a| self.particles.velocity[a][k].powi(2)).sum::<f64>()
        };
        (0..self.particles.len()).map(of).fold(0.0, f64::max).sqrt()
    }

    /// Position of the fastest particle, the first of several [m].
    pub fn place_of_fastest(&self) -> Option<[f64; D]> {
        let particles = &self.particles;
        let square = |k: usize| (0..D).map(|a| particles.velocity[a][k].powi(2)).sum::<f64>();
        let mut most: Option<(f64, usize)> = None;
        for k in 0..particles.len() {
            let square = square(k);
            if most.is_none_or(|(most, _)| square > most) {
                most = Some((square, k));
            }
        }
        most.map(|(_, k)| std::array::from_fn(|a| particles.position[a][k]))
    }

    /// Gauge pressure in a cell after a step of `dt` [Pa].
    pub fn pressure(&self, cell: [isize; D], dt: f64) -> f64 {
        self.q[self.grid.place(cell)] * self.settings.density * self.grid.spacing / dt
    }

    /// True if a cell is part of the fluid.
    pub fn is_fluid(&self, cell: [isize; D]) -> bool {
        self.is_wet(self.grid.place(cell))
    }

    /// Open fraction of a cell.
    pub fn open_volume(&self, cell: [isize; D]) -> f64 {
        self.fractions.volume[self.grid.place(cell)]
    }

    /// Share of a cell that fluid fills.
    pub fn fill(&self, cell: [isize; D]) -> f64 {
        let at = self.grid.place(cell);
        let depth = (self.depth[at] + 0.5).clamp(0.0, 1.0);
        depth * self.fractions.volume[at]
    }

    /// Velocity at the centre of a cell [m/s].
    pub fn velocity_in(&self, cell: [isize; D]) -> [f64; D] {
        let at = self.grid.place(cell);
        std::array::from_fn(|a| {
            0.5 * (self.velocity[a][at] + self.velocity[a][at + self.grid.stride[a]])
        })
    }

    /// Largest imbalance of the volume of a wet cell, over its volume [1/s].
    pub fn divergence(&self) -> f64 {
        let mut largest = 0.0_f64;
        let mut motions = vec![0.0; self.grid.stored];
        for cell in self.grid.all() {
            let at = self.grid.place(cell);
            if self.stencil.diagonal[at] > 0.0 {
                motions[at] = self.right[at] - self.stencil.applied_at(&self.q, at);
            }
        }
        self.fractions.free.coupling.apply(&self.q, &mut motions, |_| -1.0);
        for cell in self.grid.all() {
            let at = self.grid.place(cell);
            if self.stencil.diagonal[at] > 0.0 {
                largest = largest.max(motions[at].abs());
            }
        }
        largest / self.grid.spacing
    }

    /// Number of wet cells.
    pub fn wet_cells(&self) -> usize {
        self.near.cells().filter(|&at| self.depth[at] > 0.0).count()
    }

    /// Sums over the particles.
    pub fn sums(&self) -> FluidSums<D> {
        let mut sums = FluidSums {
            volume: 0.0,
            momentum: [0.0; D],
            kinetic: 0.0,
            potential: 0.0,
            max_speed: 0.0,
            farthest: self.grid.origin,
        };
        let mass = self.particles.mass;
        for k in 0..self.particles.len() {
            let mut speed2 = 0.0;
            for a in 0..D {
                let (x, u) = (self.particles.position[a][k], self.particles.velocity[a][k]);
                speed2 += u * u;
                sums.momentum[a] += mass * u;
                sums.potential -= mass * self.settings.gravity[a] * (x - self.grid.origin[a]);
                sums.farthest[a] = sums.farthest[a].max(x);
            }
            sums.kinetic += 0.5 * mass * speed2;
            sums.max_speed = sums.max_speed.max(speed2);
        }
        sums.max_speed = sums.max_speed.sqrt();
        sums.volume = self.volume();
        sums
    }
}
