//! Diagnostics of the fluid, and values of its cells.

use crate::lattice::d3q19::{CS2, Q, dot};
use crate::lattice::error::FluidError;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use crate::solver::lattice_state::LatticeState;
use crate::solver::moving_bodies::MovingBodies;
use tremie_fluid_kit::observed::cut::layer;

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

/// Values of a cell, SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceNode {
    /// Velocity [m/s]; zero inside a solid.
    pub velocity: [f64; 3],
    /// Pressure over that of the reference density [Pa]; zero inside a solid.
    pub pressure: f64,
    /// Density [kg/m³]; zero inside a solid.
    pub density: f64,
    /// True if the cell is inside a body (or isolated by bodies).
    pub solid: bool,
}

/// A quantity of cells whose greatest value has a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extreme {
    /// Speed, and with it the Mach number.
    Speed,
    /// Size of the relative deviation of the density, without its hydrostatic part.
    DensityDeviation,
}

/// A cell that stands out: by a number that is none, or else by a large one.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    value: f64,
    is_lost: bool,
    at: [i32; 3],
}

impl Suspect {
    /// The one that stands out among those of all ranks: the first that is lost, else the first of the largest.
    fn of_all(own: Option<Self>, ranks: &Ranks) -> Option<Self> {
        let numbers = own.map_or(Vec::new(), |Self { value, is_lost, at: [x, y, z] }| {
            vec![value.to_bits() as i64, is_lost.into(), x.into(), y.into(), z.into()]
        });
        let all = ranks.collect(&numbers);
        let suspect = |numbers: &[i64]| Self {
            value: f64::from_bits(numbers[0] as u64),
            is_lost: numbers[1] != 0,
            at: [numbers[2] as i32, numbers[3] as i32, numbers[4] as i32],
        };
        let mut all = all.chunks_exact(5).map(suspect);
        let first = all.next()?;
        let worse = |a: Self, b: Self| {
            let is_worse = !a.is_lost && (b.is_lost || b.value > a.value);
            if is_worse { b } else { a }
        };
        Some(all.fold(first, worse))
    }
}

impl Diagnostics {
    /// Largest size of the relative deviation of the density.
    pub fn density_deviation(&self) -> f64 {
        self.max_density_deviation.max(-self.min_density_deviation)
    }

    /// Of the fluid at the end of a step.
    pub fn of<T: Real>(lattice: &LatticeState<T>, bodies: &MovingBodies, entering: usize) -> Self {
        let statistics = &lattice.statistics;
        let [covered, uncovered, isolated, frozen] = lattice.counts.map(|count| count as usize);
        let speed = statistics.speed2.sqrt();
        Self {
            max_speed: speed * lattice.units.velocity(),
            max_mach: speed / CS2.sqrt(),
            min_density_deviation: statistics.min_drho,
            max_density_deviation: statistics.max_drho,
            covered,
            uncovered,
            isolated,
            frozen,
            links: bodies.total.links,
            fallback_links: bodies.total.fallbacks,
            fluid_cells: lattice.fluid_cells,
            max_tau: statistics.max_tau.max(lattice.tau),
            entering,
        }
    }
}

impl<T: Real> LatticeState<T> {
    /// Cells along each axis.
    pub fn cells(&self) -> [usize; 3] {
        self.layout.grid.n.map(|n| n as usize)
    }

    /// Centre of a cell [m].
    pub fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.units.centre(cell.map(|k| k as i32))
    }

    /// Checks that the fluid is finite, with its exchange with bodies, and no faster than a Mach
    /// number.
    ///
    /// # Errors
    /// The cell where it is not.
    pub fn check(
        &self,
        exchange: &MomentumExchange,
        mach_limit: f64,
        ranks: &Ranks,
    ) -> Result<(), FluidError> {
        let s = &self.statistics;
        let exchange = exchange.force.iter().chain(&exchange.torque);
        let finite = s.j.iter().chain([&s.excess]).chain(exchange).all(|x| x.is_finite());
        let mach = (s.speed2 / CS2).sqrt();
        if finite && mach <= mach_limit {
            return Ok(());
        }
        self.locate(mach_limit, ranks).map_or(Ok(()), Err)
    }

    /// The first cell that is not finite, else the fastest one if it is too fast.
    fn locate(&self, mach_limit: f64, ranks: &Ranks) -> Option<FluidError> {
        let mut worst: Option<Suspect> = None;
        let own = self.layout.own.clone().filter(|&cell| self.flags.is_fluid(cell));
        for cell in own {
            let h = self.before().populations(cell);
            if let Some(i) = h.iter().position(|h| !h.is_finite()) {
                worst = Some(Suspect { value: h[i], is_lost: true, at: self.layout.at(cell) });
                break;
            }
            let u = self.before().content(cell).velocity(self.relaxation.acceleration);
            let speed = dot(u, u).sqrt();
            if worst.is_none_or(|worst| speed > worst.value) {
                worst = Some(Suspect { value: speed, is_lost: false, at: self.layout.at(cell) });
            }
        }
        let Suspect { value, is_lost, at } = Suspect::of_all(worst, ranks)?;
        if is_lost {
            return Some(FluidError::NonFinite {
                cell: at.map(|k| k as usize),
                position: self.units.centre(at),
                value: format!("a population is {value}"),
            });
        }
        let speed = value;
        let mach = speed / CS2.sqrt();
        (mach > mach_limit).then(|| FluidError::Mach {
            cell: at.map(|k| k as usize),
            position: self.units.centre(at),
            speed: speed * self.units.velocity(),
            mach,
            limit: mach_limit,
            remedy: self.units.time_step * mach_limit / mach,
        })
    }

    /// Centre of the fluid cell in which a quantity is greatest now [m].
    pub fn place_of(&self, extreme: Extreme, ranks: &Ranks) -> Option<[f64; 3]> {
        let mut most: Option<Suspect> = None;
        for cell in self.layout.own.clone().filter(|&cell| self.flags.is_fluid(cell)) {
            let content = self.before().content(cell);
            let value = match extreme {
                Extreme::Speed => {
                    let u = content.velocity(self.relaxation.acceleration);
                    dot(u, u)
                }
                Extreme::DensityDeviation => content.drho.abs(),
            };
            if most.is_none_or(|most| value > most.value) {
                most = Some(Suspect { value, is_lost: false, at: self.layout.at(cell) });
            }
        }
        Suspect::of_all(most, ranks).map(|most| self.units.centre(most.at))
    }

    /// Values of a cell, SI units.
    pub fn node(&self, cell: [usize; 3]) -> SliceNode {
        let at = cell.map(|k| k as i32);
        let Some(cell) = self.layout.cell(at).filter(|&cell| self.flags.is_fluid(cell)) else {
            return SliceNode { solid: true, ..SliceNode::default() };
        };
        let content = self.before().content(cell);
        let u = content.velocity(self.relaxation.acceleration);
        SliceNode {
            velocity: u.map(|u| u * self.units.velocity()),
            pressure: CS2 * content.drho * self.units.pressure(),
            density: (1.0 + content.drho) * self.units.density,
            solid: false,
        }
    }

    /// Populations that the next collision finds in a cell; zeros in a static solid.
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
        let (cells, units) = (self.cells(), &self.units);
        let cells_of_it =
            layer(cells, (axis, position), (units.min[axis], units.cell), [fast, slow]);
        out.clear();
        out.extend(cells_of_it.map(|at| self.node(at)));
        [fast, slow].map(|a| cells[a])
    }
}
