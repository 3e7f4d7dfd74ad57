//! Faces beyond which a reservoir with a piston lies: its density, and a flow that follows.
//!
//! After streaming, when all else is done, with the sums over the directions along the face (0) and
//! out of the fluid (-), `n` the normal into the fluid, and `rho` the density of the cylinder (see
//! `cylinder`), each cell at the face gets
//!
//! ```text
//! u_n = 1 - (S_0 + 2 S_-)/rho          that of a pressure face after Zou & He 1997
//! u_n += r (mean of u_n over the face - u_n)
//! f_i = feq_i(rho, u_n n)              for all i
//! ```
//!
//! (Mutabaruka & Kamrin, Eq. 31; `u_n` does not depend on how the missing mass is divided among the
//! directions that enter.) What a cell then holds more than before streaming brought the cylinder's
//! fluid to it is what the cylinder loses, with what links to walls brought to these cells:
//! cylinder and domain together keep their mass to rounding. Their `rho` from the velocity at the
//! face instead has a mode of two steps that grows where the cylinder is short and the viscosity
//! low.
//!
//! The full equilibrium has no viscous stress; the flow is straight at the face, `u_t = 0`. Cells
//! that bodies cover are left out. Bodies that move across the face count as fluid of the cylinder
//! (`crossing_bodies`).

use crate::boundary::face_scheme::{
    FaceCell, FaceItem, FaceScheme, Gain, PostStreaming, StepBegin, items_of,
};
use crate::boundary::virtual_piston::cylinder::Cylinder;
use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::boundary::zou_he::Inward;
use crate::lattice::d3q19::{Q, equilibria};
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::lattice::units::Units;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::ops::Range;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::scene::Reservoir;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Cells that are one item of work, and what the last step found there.
#[derive(Clone, Debug)]
struct PistonItem {
    cells: Range<usize>,
    /// True if this part of the lattice counts them.
    is_own: bool,
    /// Sum of the normal velocities.
    sum: f64,
    /// Largest normal velocity, by amount.
    fastest: f64,
    /// Cells that are fluid.
    wet: usize,
    gain: Gain,
}

/// A face with the cylinder behind it.
#[derive(Clone, Debug)]
pub struct ReservoirFace {
    axis: usize,
    side: usize,
    relaxation: f64,
    cells: Vec<FaceCell>,
    items: Vec<PistonItem>,
    cylinder: Cylinder,
    /// Mean of the normal velocities that the face has, without half the step's force.
    mean: f64,
}

impl ReservoirFace {
    /// A face of these cells, `2 axis + side`.
    pub fn new(
        layout: &Layout,
        face: usize,
        cells: Vec<FaceCell>,
        reservoir: &Reservoir,
        (units, ranks): (&Units, &mut Ranks),
    ) -> Self {
        let item = |FaceItem { cells, is_own }: FaceItem| PistonItem {
            cells,
            is_own,
            sum: 0.0,
            fastest: 0.0,
            wet: 0,
            gain: Gain::default(),
        };
        let mut area = [cells.iter().filter(|open| layout.is_own(open.cell)).count() as i64];
        ranks.count(&mut area);
        Self {
            axis: face / 2,
            side: face % 2,
            relaxation: reservoir.relaxation,
            items: items_of(layout, &cells).into_iter().map(item).collect(),
            cylinder: Cylinder::new(reservoir, area[0] as f64, units),
            cells,
            mean: 0.0,
        }
    }

    /// Cells at the face.
    pub fn cells(&self) -> impl Iterator<Item = u32> {
        self.cells.iter().map(|cell| cell.cell)
    }

    /// Puts the cylinder's fluid into the state of the face: density, less 1, and velocity into the
    /// domain.
    pub fn fill(&mut self, drho: f64, velocity: f64) {
        self.cylinder.fill(drho);
        self.mean = velocity;
    }

    /// 1 where the normal into the fluid points along the axis, else -1.
    pub fn inward(&self) -> f64 {
        [1.0, -1.0][self.side]
    }

    /// Distance of a place from the face [cells].
    pub fn distance(&self, x: [f64; 3], grid: &Grid) -> f64 {
        let face = [0.0, f64::from(grid.n[self.axis])][self.side];
        (x[self.axis] - face).abs()
    }

    /// Takes back a mass from the domain.
    pub fn take_back(&mut self, mass: f64) {
        self.cylinder.drain(-mass);
    }

    /// Axis that the face is across.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// The face.
    fn place(&self) -> ReservoirPlace {
        ReservoirPlace::Face { axis: self.axis, side: self.side }
    }

    /// State of the reservoir, SI units.
    pub fn state(&self, acceleration: [f64; 3], units: &Units) -> ReservoirState {
        let half = 0.5 * acceleration[self.axis] * self.inward();
        self.cylinder.state(self.place(), self.mean + half, units)
    }
}

impl<T: Real> FaceScheme<T> for ReservoirFace {
    /// Moves the piston through the step; fails where it comes too close to the face, and nothing
    /// has changed then.
    fn begin(&mut self, begin: &StepBegin<T>, _team: &mut Team) -> Result<(), FluidError> {
        let place = self.place();
        self.cylinder.advance(begin.time, self.mean, begin.units).map_err(|spent| spent.at(place))
    }

    /// Gives the cells at the face their populations, and lets the cylinder lose what they gained;
    /// fails where the flow through the face is too fast for the lattice, or not finite.
    fn apply(
        &mut self,
        next: &PostStreaming<T>,
        team: &mut Team,
        ranks: &mut Ranks,
    ) -> Result<(), FluidError> {
        let (cells, drho) = (&self.cells, self.cylinder.drho());
        let [axis, side] = [self.axis, self.side];
        let view = View { next, inward: Inward::of(2 * axis + side), drho };
        team.for_each(&mut self.items, |_, item| view.measure(&cells[item.cells.clone()], item));
        let (mut sum, mut wet, mut fastest) = (ExactSum::default(), [0], 0.0);
        for item in self.items.iter().filter(|item| item.is_own) {
            sum.add(item.sum);
            wet[0] += item.wet as i64;
            fastest = f64::max(fastest, item.fastest);
        }
        ranks.add_up([&mut sum]);
        ranks.count(&mut wet);
        let [fastest] = ranks.largest([fastest]);
        let mean = if wet[0] > 0 { sum.value() / wet[0] as f64 } else { 0.0 };
        let relaxation = self.relaxation;
        team.for_each(&mut self.items, |_, item| {
            view.fill(&cells[item.cells.clone()], mean, relaxation, item);
        });
        self.mean = mean;
        let at_walls = next.brought[2 * axis + side].total();
        let mut gained = ExactSum::default();
        let own = self.items.iter().filter(|item| item.is_own);
        own.for_each(|item| gained.add(item.gain.mass));
        ranks.add_up([&mut gained]);
        self.cylinder.drain(gained.value() + at_walls);
        self.cylinder.passes([mean, fastest], self.place(), next.units)
    }

    fn each_gain(&self, add: &mut dyn FnMut([f64; 3], f64)) {
        let own = self.items.iter().filter(|item| item.is_own);
        own.for_each(|item| add(item.gain.impulse, item.gain.mass));
    }

    fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }

    fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        _: &WholeNumbers,
    ) -> Result<(), StateError> {
        state.value("mean", &mut self.mean)?;
        self.cylinder.exchange(state)
    }
}

/// A face in a step.
struct View<'a, T: Real> {
    next: &'a PostStreaming<'a, T>,
    inward: Inward,
    /// Density minus 1 of the cylinder.
    drho: f64,
}

impl<T: Real> View<'_, T> {
    /// Velocity into the fluid that the density and the populations say.
    fn normal_velocity(&self, h: &[f64; Q]) -> f64 {
        (self.drho - self.inward.known_sum(h)) / (1.0 + self.drho)
    }

    fn measure(&self, cells: &[FaceCell], item: &mut PistonItem) {
        (item.sum, item.fastest, item.wet) = (0.0, 0.0, 0);
        for open in cells.iter().filter(|open| self.next.flags.is_fluid(open.cell)) {
            let u = self.normal_velocity(&self.next.populations(open.cell));
            item.sum += u;
            item.fastest = item.fastest.max(u.abs());
            item.wet += 1;
        }
    }

    fn fill(&self, cells: &[FaceCell], mean: f64, relaxation: f64, item: &mut PistonItem) {
        item.gain = Gain::default();
        for open in cells.iter().filter(|open| self.next.flags.is_fluid(open.cell)) {
            let old = self.next.populations(open.cell);
            let u = self.normal_velocity(&old);
            let mut velocity = [0.0; 3];
            velocity[self.inward.axis] =
                f64::from(self.inward.sign) * (u + relaxation * (mean - u));
            let new = equilibria(self.drho, velocity);
            self.next.replace(open, &old, &new, &mut item.gain);
        }
    }
}
