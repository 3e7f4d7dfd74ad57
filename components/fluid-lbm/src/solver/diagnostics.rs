//! What can be seen of the fluid.

use crate::bodies::body::Body;
use crate::boundary::post_collision::LinkItem;
use crate::boundary::virtual_piston::face::{ReservoirFace, ReservoirState};
use crate::domain::mirrors::{mirrors_of_part, with_image};
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::d3q19::{CS2, Q, dot, equilibria};
use crate::lattice::error::FluidError;
use crate::lattice::ledger::Ledger;
use crate::lattice::populations::Field;
use crate::solver::lbm_solver::{LbmSolver, before};
use tremie_messages::Load;

/// A summary of the flow, SI units.
///
/// Velocities and densities are those that the last step's collision found; counts are of the last
/// step's end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// Largest speed [m/s].
    pub max_speed: f64,
    /// Largest Mach number.
    pub max_mach: f64,
    /// Smallest relative deviation of the density (or 0, if all are larger).
    pub min_density_deviation: f64,
    /// Largest relative deviation of the density (or 0, if all are smaller).
    pub max_density_deviation: f64,
    /// Cells that bodies covered in the last step.
    pub covered: usize,
    /// Cells that bodies uncovered in the last step.
    pub uncovered: usize,
    /// Cells now frozen because no neighbour is fluid.
    pub isolated: usize,
    /// Cells now frozen in declared gaps and pockets.
    pub frozen: usize,
    /// Links from the fluid into bodies.
    pub links: usize,
    /// Links on which a second fluid node was missing, so that they fell back to half-way
    /// reflection.
    pub fallback_links: usize,
    /// Fluid cells.
    pub fluid_cells: usize,
    /// Largest relaxation time [steps]; the only one, without a closure for turbulence.
    pub max_tau: f64,
    /// Cells at pressure faces through which fluid enters.
    pub entering: usize,
}

/// What a cell holds, SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceNode {
    /// Velocity [m/s]; zero inside a solid.
    pub velocity: [f64; 3],
    /// Pressure over that of the reference density [Pa]; zero inside a solid.
    pub pressure: f64,
    /// Whether the cell is inside a body (or isolated by bodies).
    pub solid: bool,
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// See [`crate::LbmFluid::ledger`].
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// See [`crate::LbmFluid::cells`].
    pub fn cells(&self) -> [usize; 3] {
        self.layout.grid.n.map(|n| n as usize)
    }

    /// See [`crate::LbmFluid::centre`].
    pub fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.units.centre(cell.map(|k| k as i32))
    }

    /// See [`crate::LbmFluid::time_step`].
    pub fn time_step(&self) -> f64 {
        self.units.time_step
    }

    /// See [`crate::LbmFluid::tau`].
    pub fn tau(&self) -> f64 {
        self.tau
    }

    /// See [`crate::LbmFluid::diagnostics`].
    pub fn diagnostics(&self) -> Diagnostics {
        let speed = self.survey.speed2.sqrt();
        Diagnostics {
            max_speed: speed * self.units.velocity(),
            max_mach: speed / CS2.sqrt(),
            min_density_deviation: self.survey.min_drho,
            max_density_deviation: self.survey.max_drho,
            covered: self.owners.covered.len(),
            uncovered: self.owners.vacated.len(),
            isolated: self.owners.isolated,
            frozen: self.owners.frozen,
            links: self.exchange.links,
            fallback_links: self.exchange.fallbacks,
            fluid_cells: self.owners.fluid_cells,
            max_tau: self.survey.max_tau.max(self.tau),
            entering: self.open_items.iter().map(|item| item.entering).sum(),
        }
    }

    /// See [`crate::LbmFluid::loads_on_parts`].
    pub fn loads_on_parts(&self, loads: &mut Vec<Load>) {
        let (force, length) = (self.units.force(), self.units.cell);
        loads.clear();
        loads.extend(self.surroundings.parts().map(|(fixture, part)| {
            let exchange = &self.fixtures[fixture];
            let origin = self.surroundings.references[fixture];
            let mirrors = mirrors_of_part(&self.layout.grid, origin);
            let [whole, turning] = with_image(mirrors, [exchange.force, exchange.torque]);
            let [lift, turn] = self.surroundings.displaced[fixture].load(self.lift);
            Load {
                id: part as u64,
                force: std::array::from_fn(|a| (whole[a] + lift[a]) * force),
                torque: std::array::from_fn(|a| (turning[a] + turn[a]) * force * length),
            }
        }));
    }

    /// See [`crate::LbmFluid::wall_forces`].
    pub fn wall_forces(&self) -> [[[f64; 3]; 2]; 3] {
        let unit = self.units.force();
        std::array::from_fn(|axis| {
            std::array::from_fn(|side| {
                let number = 2 * axis + side;
                let (wall, mirror) = (self.fixtures[number].force, self.mirrors[number]);
                std::array::from_fn(|a| (wall[a] + mirror[a]) * unit)
            })
        })
    }

    /// See [`crate::LbmFluid::probes`].
    pub fn probes(&mut self, values: &mut Vec<f64>) {
        let before = before!(self);
        self.probes.read(&mut self.team, &before, &self.owners, &self.units, values);
    }

    /// See [`crate::LbmFluid::restart_means`].
    pub fn restart_means(&mut self) {
        self.probes.restart_means();
    }

    /// See [`crate::LbmFluid::memory_bytes`].
    pub fn memory_bytes(&self) -> usize {
        let stride = self.layout.places.stride();
        Field::<T>::bytes(stride as u64) as usize
            + self.layout.cells.bytes()
            + self.layout.places.bytes()
            + self.tally.bytes()
            + self.fixed.bytes()
            + self.sheets.bytes()
            + self.blocks.iter().map(|block| block.halfway.bytes()).sum::<usize>()
            + self.walls.bytes()
            + self.open.bytes()
            + self.reservoirs.iter().map(ReservoirFace::bytes).sum::<usize>()
            + self.owners.bytes()
            + self.pinched.bytes()
            + self.bricks.bytes()
            + self.declared.bytes()
            + self.intakes.bytes()
            + self.wanted.bytes()
            + self.bodies.living.iter().map(Body::bytes).sum::<usize>()
            + self.link_items.iter().map(LinkItem::bytes).sum::<usize>()
            + size_of_val(self.exchanges.as_slice())
            + size_of_val(self.seen.as_slice())
    }

    /// See [`crate::LbmFluid::check`].
    pub fn check(&self) -> Result<(), FluidError> {
        let s = &self.survey;
        let exchange = self.exchange.force.iter().chain(&self.exchange.torque);
        let finite = s.j.iter().chain([&s.excess]).chain(exchange).all(|x| x.is_finite());
        let mach = (s.speed2 / CS2).sqrt();
        if finite && mach <= self.mach_limit {
            return Ok(());
        }
        self.locate().map_or(Ok(()), Err)
    }

    /// The first cell that is not finite, else the fastest one if it is too fast.
    fn locate(&self) -> Option<FluidError> {
        let mut fastest: Option<(f64, [i32; 3])> = None;
        for cell in (0..self.layout.cells.len() as u32).filter(|&c| self.owners.is_fluid(c)) {
            let h = self.before().populations(cell);
            if let Some(i) = h.iter().position(|h| !h.is_finite()) {
                let at = self.layout.at(cell);
                return Some(FluidError::NonFinite {
                    cell: at.map(|k| k as usize),
                    position: self.units.centre(at),
                    value: format!("a population is {}", h[i]),
                });
            }
            let u = self.before().content(cell).velocity(self.relaxation.acceleration);
            let speed = dot(u, u).sqrt();
            if fastest.is_none_or(|(most, _)| speed > most) {
                fastest = Some((speed, self.layout.at(cell)));
            }
        }
        let (speed, at) = fastest?;
        let mach = speed / CS2.sqrt();
        (mach > self.mach_limit).then(|| FluidError::Mach {
            cell: at.map(|k| k as usize),
            position: self.units.centre(at),
            speed: speed * self.units.velocity(),
            mach,
            limit: self.mach_limit,
            remedy: self.units.time_step * self.mach_limit / mach,
        })
    }

    /// See [`crate::LbmFluid::node`].
    pub fn node(&self, cell: [usize; 3]) -> SliceNode {
        self.node_at(cell.map(|k| k as i32))
    }

    fn node_at(&self, at: [i32; 3]) -> SliceNode {
        let Some(cell) = self.layout.cell(at).filter(|&cell| self.owners.is_fluid(cell)) else {
            return SliceNode { solid: true, ..SliceNode::default() };
        };
        let content = self.before().content(cell);
        let u = content.velocity(self.relaxation.acceleration);
        SliceNode {
            velocity: u.map(|u| u * self.units.velocity()),
            pressure: CS2 * content.drho * self.units.pressure(),
            solid: false,
        }
    }

    /// See [`crate::LbmFluid::populations_at`].
    pub fn populations_at(&self, cell: [usize; 3]) -> [f64; Q] {
        let cell = self.layout.cell(cell.map(|k| k as i32));
        cell.map_or([0.0; Q], |cell| self.before().populations(cell))
    }

    /// See [`crate::LbmFluid::slice`]; the other two axes are given, that which runs fastest first.
    pub fn slice(
        &self,
        axis: usize,
        position: f64,
        [fast, slow]: [usize; 2],
        out: &mut Vec<SliceNode>,
    ) -> [usize; 2] {
        let layer = ((position - self.units.min[axis]) / self.units.cell).floor() as i32;
        let layer = layer.clamp(0, self.layout.grid.n[axis] - 1);
        out.clear();
        for k in 0..self.layout.grid.n[slow] {
            for j in 0..self.layout.grid.n[fast] {
                let mut at = [layer; 3];
                (at[fast], at[slow]) = (j, k);
                out.push(self.node_at(at));
            }
        }
        [fast, slow].map(|a| self.layout.grid.n[a] as usize)
    }

    /// See [`crate::LbmFluid::set_state`].
    pub fn set_state(&mut self, state: impl Fn([f64; 3]) -> ([f64; 3], f64)) {
        let a = self.relaxation.acceleration;
        for cell in 0..self.layout.cells.len() as u32 {
            let (u, pressure) = state(self.units.centre(self.layout.at(cell)));
            let drho = pressure / self.units.pressure() / CS2;
            // Without half the force, which outputs and the collision add: see
            // `Content::velocity`.
            let u = std::array::from_fn(|k| u[k] / self.units.velocity() - 0.5 * a[k]);
            self.before().put(cell, &equilibria(drho, u));
        }
        self.fill_reservoirs();
        self.measure();
        self.begin_balance();
        self.end_balance(false);
        self.lose_nothing();
    }

    /// Gives the reservoirs the mean density and velocity of the cells at their faces.
    fn fill_reservoirs(&mut self) {
        for reservoir in &mut self.reservoirs {
            let (before, axis, inward) = (before!(self), reservoir.axis(), reservoir.inward());
            let (mut count, mut drho, mut velocity) = (0.0, 0.0, 0.0);
            for cell in reservoir.cells().filter(|&cell| self.owners.is_fluid(cell)) {
                let content = before.content(cell);
                count += 1.0;
                drho += content.drho;
                velocity += inward * content.j[axis] / (1.0 + content.drho);
            }
            reservoir.fill(drho / f64::max(count, 1.0), velocity / f64::max(count, 1.0));
        }
    }

    /// See [`crate::LbmFluid::reservoirs`].
    pub fn reservoirs(&self) -> impl Iterator<Item = ReservoirState> {
        let acceleration = self.relaxation.acceleration;
        self.reservoirs.iter().map(move |r| r.state(acceleration, &self.units))
    }
}
