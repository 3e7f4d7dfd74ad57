//! Convective outflow: what arrives at a face is carried out through it with the mean velocity `U`
//! there.
//!
//! ```text
//! df_i/dt + U df_i/dn = 0        n out of the fluid                                  (Orlanski 1976; Sommerfeld's condition)
//! f_i(x_B, t+1) = [f_i(x_B, t) + U f_i(x_I, t+1)] / (1 + U)        for all i         (Lou, Guo & Shi 2013)
//! ```
//!
//! `x_B` is a cell at the face, `x_I` the next one inside; `U` is the mean over the face's fluid
//! cells of the velocity of `x_I` out of the fluid, at least 0: a face through which fluid enters
//! as a whole keeps what it has. Derivatives are those of the lattice, one-sided and implicit, so
//! that any `U` is stable.
//!
//! Nothing in this holds the level of the pressure. So the mean density over the face is drawn to
//! the given one, as fast as at an absorbing face (see `open_boundary`), by an equilibrium at rest,
//! which carries no momentum:
//!
//! ```text
//! f_i(x_B) += w_i r (drho_given + b - <drho carried>)          <>: mean over the face
//! b        += r/4 (drho_given - <drho_F>)                      r = s c_s/L, s = 1/4, L: the domain's length
//! drho_F    = (3 drho(x_B, t) - drho(x_I, t+1))/2              on the face, half a cell outside of x_B
//! ```
//!
//! `b` makes up for the gradient of the pressure, which the first equation flattens; with a quarter
//! of the rate the level does not swing (critical damping).
//!
//! A vortex, or the wake of a body, leaves without the pressure that a constant density at the face
//! would throw back. Sound is faster than `U` and meets a face that stands almost still: of a pulse
//! a quarter comes back, at a pressure face all.
//!
//! Mass that passes is what the populations say: the balance closes to rounding, and no cell is
//! held to a flow.

use crate::boundary::face_scheme::{
    FaceCell, FaceItem, FaceScheme, Gain, PostStreaming, StepBegin, items_of,
};
use crate::boundary::open_boundary::relaxation;
use crate::boundary::refill::Content;
use crate::boundary::zou_he::Inward;
use crate::domain::boundary_condition::BoundaryValue;
use crate::lattice::d3q19::{Q, W};
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::ops::Range;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// A face through which fluid leaves by convection.
#[derive(Clone, Debug)]
pub struct ConvectiveOutflow {
    /// `2 axis + side`.
    face: usize,
    /// Part of the mean density's difference from the given one that a step makes up for.
    relaxation: f64,
    /// By how much the density is aimed higher than given, so that the mean is the given one.
    offset: f64,
    cells: Vec<FaceCell>,
    items: Vec<OutflowItem>,
}

/// Cells that are one item of work, and what was found there.
#[derive(Clone, Debug)]
struct OutflowItem {
    cells: Range<usize>,
    /// True if this part of the lattice counts them.
    is_own: bool,
    /// Populations of each cell at the beginning of the step; none if it was no fluid.
    before: Vec<Option<[f64; Q]>>,
    sums: OutflowSums,
    gain: Gain,
}

/// Sums over fluid cells.
#[derive(Clone, Copy, Debug, Default)]
struct OutflowSums {
    cells: f64,
    /// Velocity out of the fluid of the next cells inside.
    outward: f64,
    /// Density minus 1 of the next cells inside, and of the cells themselves at the beginning of
    /// the step.
    inner: f64,
    own: f64,
}

impl ConvectiveOutflow {
    /// A face, `2 axis + side`, of a domain of so many cells along its axis.
    pub fn new(layout: &Layout, face: usize, cells: Vec<FaceCell>, length: i32) -> Self {
        let item = |FaceItem { cells, is_own }: FaceItem| OutflowItem {
            before: vec![None; cells.len()],
            cells,
            is_own,
            sums: OutflowSums::default(),
            gain: Gain::default(),
        };
        let items = items_of(layout, &cells).into_iter().map(item).collect();
        Self { face, relaxation: relaxation(length), offset: 0.0, cells, items }
    }
}

impl<T: Real> FaceScheme<T> for ConvectiveOutflow {
    fn begin(&mut self, begin: &StepBegin<T>, team: &mut Team) -> Result<(), FluidError> {
        let cells = &self.cells;
        team.for_each(&mut self.items, |_, item| {
            for (open, before) in cells[item.cells.clone()].iter().zip(&mut item.before) {
                let is_fluid = begin.flags.is_fluid(open.cell);
                *before = is_fluid.then(|| begin.before.populations(open.cell));
            }
        });
        Ok(())
    }

    fn apply(
        &mut self,
        next: &PostStreaming<T>,
        team: &mut Team,
        ranks: &mut Ranks,
    ) -> Result<(), FluidError> {
        let Self { face, relaxation, offset, cells, items } = self;
        let inward = Inward::of(*face);
        // Two loops, because `U` and the mean densities are those of the whole face.
        team.for_each(items, |_, item| {
            item.sums = OutflowSums::default();
            for (open, before) in cells[item.cells.clone()].iter().zip(&item.before) {
                if next.flags.is_fluid(open.cell) {
                    item.sums.add(&arriving(next, open), before.as_ref(), inward);
                }
            }
        });
        let own = items.iter().filter(|item| item.is_own);
        let all = OutflowSums::over(own.map(|item| &item.sums), ranks);
        let count = all.cells.max(1.0);
        // Where fluid enters as a whole, `U` is 0: nothing is carried in from beyond.
        let speed = (all.outward / count).max(0.0);
        let (own, inner) = (all.own / count, all.inner / count);
        let carried = (own + speed * inner) / (1.0 + speed);
        let BoundaryValue::Density(given) = next.now[*face] else {
            unreachable!("an outflow is a face with a pressure");
        };
        let more = *relaxation * (given + *offset - carried);
        let on_face = 1.5 * own - 0.5 * inner;
        *offset += 0.25 * *relaxation * (given - on_face);
        team.for_each(items, |_, item| {
            item.gain = Gain::default();
            for (open, before) in cells[item.cells.clone()].iter().zip(&item.before) {
                if !next.flags.is_fluid(open.cell) {
                    continue;
                }
                let (old, inner) = (next.populations(open.cell), arriving(next, open));
                let before = before.as_ref().unwrap_or(&inner);
                let carried = |i: usize| (before[i] + speed * inner[i]) / (1.0 + speed);
                let new = std::array::from_fn(|i| carried(i) + W[i] * more);
                next.replace(open, &old, &new, &mut item.gain);
            }
        });
        Ok(())
    }

    fn each_gain(&self, add: &mut dyn FnMut([f64; 3], f64)) {
        let own = self.items.iter().filter(|item| item.is_own);
        own.for_each(|item| add(item.gain.impulse, item.gain.mass));
    }

    fn bytes(&self) -> usize {
        self.cells.len() * (size_of::<FaceCell>() + size_of::<Option<[f64; Q]>>())
    }

    fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        _: &WholeNumbers,
    ) -> Result<(), StateError> {
        state.value("offset", &mut self.offset)
    }
}

/// Populations that arrive at a cell: those of the next one inside; its own if that is no fluid.
fn arriving<T: Real>(next: &PostStreaming<T>, open: &FaceCell) -> [f64; Q] {
    next.populations(next.inner(open).unwrap_or(open.cell))
}

impl OutflowSums {
    /// Adds a cell at which `inner` arrives, and which held `before`.
    fn add(&mut self, inner: &[f64; Q], before: Option<&[f64; Q]>, inward: Inward) {
        let Content { drho, j } = Content::of(inner);
        self.cells += 1.0;
        self.outward -= f64::from(inward.sign) * j[inward.axis] / (1.0 + drho);
        self.inner += drho;
        self.own += before.map_or(drho, |h| Content::of(h).drho);
    }

    /// The sums of all items, of all ranks.
    fn over<'s>(items: impl Iterator<Item = &'s Self>, ranks: &mut Ranks) -> Self {
        let mut sums = [ExactSum::default(); 4];
        for item in items {
            let own = [item.cells, item.outward, item.inner, item.own];
            sums.iter_mut().zip(own).for_each(|(sum, own)| sum.add(own));
        }
        ranks.add_up(&mut sums);
        let [cells, outward, inner, own] = values(&sums);
        Self { cells, outward, inner, own }
    }
}
