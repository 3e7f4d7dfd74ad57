//! Open faces: the first cells inside a face that prescribes velocity or pressure.
//!
//! `x_B` is such a cell, `x_I = x_B + n` the next one inside, `n` the normal into the fluid. After
//! streaming, when all else is done, the cell gets
//!
//! ```text
//! NEE   f_i(x_B) = feq_i(rho, u) + f_i(x_I) - feq_i(rho(x_I), u(x_I))                for all i
//! ```
//!
//! with `rho` given and `u = u(x_I)` at a pressure face, `u` given and `rho = rho(x_I)` at a
//! velocity face (non-equilibrium extrapolation, Guo, Zheng & Shi 2002); or by non-equilibrium
//! bounce-back (see `zou_he`), `u_t` being that of `x_I` at a pressure face. At a pressure face
//! through which the fluid enters, `u_t = 0`; such cells are counted.
//!
//! The prescribed values hold on the face, half a cell outside of `x_B`. So the cell is given what
//! lies on the straight line from the face to `x_I`:
//!
//! ```text
//! u(x_B) = (2 u_given + u(x_I))/3        rho(x_B) = (2 rho_given + rho(x_I))/3
//! ```
//!
//! A cell without fluid next to it inside takes the given value itself.
//!
//! An *absorbing* pressure face lets sound out. Of the two waves that meet there, the one that
//! comes in is held to what the given pressure and the mean flow say, instead of the pressure
//! itself:
//!
//! ```text
//! drho = (drho_I + drho_B)/2 + (v_I - v_mean)/(2 c_s)          v: velocity out of the fluid, of x_I
//! v    = v_I + c_s (drho_I - drho)
//! drho_B  = drho_given + d_mean/2                               on the face it is the given one
//! v_mean += (v - v_mean) s c_s/L                                s = 1/4, L: the domain's length
//! d_mean += (drho_I - drho - d_mean) s c_s/L
//! ```
//!
//! So a wave of circular frequency `w` is thrown back by `1/sqrt(1 + (2 w L/(s c_s))^2)` (Rudy &
//! Strikwerda 1980, Poinsot & Lele 1992; the formula from Selle, Nicoud & Poinsot 2004), the
//! domain's longest by 8 %, and where the flow is steady the pressure is the given one. `v_mean` and
//! `d_mean` are each cell's own; they start with the flow, and with 0. Such faces are NEE in either
//! scheme.
//!
//! # What a velocity face delivers
//! Next to a wall, the links that would carry fluid along it are the wall's, and the layer between
//! `x_B` and `x_I` passes less than the velocities at `x_B` say: of a uniform profile a sixth in
//! each cell beside a wall, and more or less of that with the shear there, which no formula
//! foretells. So the mass `m` that enters through the face, with what links to walls bring to its
//! cells, is compared with the one that was asked for, and the velocities of the whole face take a
//! factor `1 + e`:
//!
//! ```text
//! M  = <rho> u.n sum of (mean factor of the profile over a cell) (open area of the cell)
//! e += r (M - m) M/M_max^2                                              r = 0.03
//! ```
//!
//! `<rho>` is the mean density of the fluid: so the volume is right halfway between where the
//! flow's pressure is highest and lowest, and faces that are to pass the same do. A wall of a part
//! that crosses a cell within the face leaves it the area beside it (see `open_area`). (The rule is
//! that of least mean squares, Widrow & Hoff 1960; it rests where the flow turns round.)
//!
//! Cells at two open faces belong to the one of the first axis (of the world) and look along both
//! normals. Where a link leaves through a wall and an open face at once, it belongs to the wall;
//! there, and at two open faces, NEBB would lack equations and NEE takes its place.

use crate::boundary::face_scheme::{FaceCell, FaceItem, FaceScheme, Gain, PostStreaming, items_of};
use crate::boundary::link_kernels::{LANES, Lane};
use crate::boundary::nonequilibrium_extrapolation::{AddUp, Extrapolate, InnerCells, LookInside};
use crate::boundary::open_area::OpenAreas;
use crate::boundary::refill::Content;
use crate::boundary::zou_he::Inward;
use crate::domain::boundary_condition::{BoundaryCondition, BoundaryValue};
use crate::domain::parameters::OpenFaces;
use crate::lattice::cell_list::NONE;
use crate::lattice::d3q19::{CS2, Q};
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::layout::Layout;
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::ops::Range;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::scene::Profile;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Part of the way that the mean velocity at an absorbing face goes in the time in which sound
/// crosses the domain.
const RELAX: f64 = 0.25;

/// Part of the difference of mass by which the velocities of a face change in a step.
const STEER: f64 = 0.03;

/// The most by which they may. The first cells take two thirds of it.
const STEER_LIMIT: f64 = 0.375;

/// Number of cells ahead of its use at which memory is asked for.
const AHEAD: usize = 8;

/// A cell at an open face.
#[derive(Clone, Copy, Debug)]
struct OpenCell {
    at: FaceCell,
    /// Factor of the velocity's profile.
    profile: f64,
    /// Mean of that factor over the cell times the area of the face that is open there.
    share: f64,
}

/// A face that prescribes a velocity or a pressure.
#[derive(Clone, Debug)]
pub struct OpenFace {
    /// `2 axis + side`.
    face: usize,
    scheme: OpenFaces,
    /// Part of the difference between a cell's velocity and its mean that the mean takes over in a
    /// step, where the face absorbs; else 0.
    relax: f64,
    cells: Vec<OpenCell>,
    items: Vec<OpenItem>,
    steering: Steering,
}

/// By how much the velocities of a face are larger than given, so that it delivers what is asked
/// for.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Steering {
    /// As a part of them.
    more: f64,
    /// Largest mass that was to enter, or to leave, in a step.
    most: f64,
}

/// Cells that are one item of work, and what entered through them in the last step.
#[derive(Clone, Debug)]
struct OpenItem {
    cells: Range<usize>,
    /// True if this part of the lattice counts them.
    is_own: bool,
    /// Sum of the shares of its cells that are fluid.
    share: f64,
    /// For each cell of an absorbing face.
    means: Vec<MeanFlow>,
    gain: Gain,
    /// Cells of pressure faces through which fluid enters.
    entering: usize,
}

/// What an absorbing face knows of the flow through a cell, without its sound.
#[derive(Clone, Copy, Debug)]
struct MeanFlow {
    /// Velocity out of the fluid; not a number at first.
    velocity: f64,
    /// Density of the next cell inside less that of the cell.
    difference: f64,
}

/// Cells that wait to be extrapolated together.
struct Waiting {
    cells: InnerCells,
    /// Their numbers in the item.
    numbers: [usize; LANES],
    /// The cells, and those that are extrapolated.
    own: [u32; LANES],
    from: [u32; LANES],
    count: usize,
}

impl Waiting {
    /// None.
    const NONE: Self = Self {
        cells: InnerCells::NONE,
        numbers: [0; LANES],
        own: [0; LANES],
        from: [0; LANES],
        count: 0,
    };
}

impl OpenFace {
    /// A face, `2 axis + side`, by a scheme; of these cells, of which `areas` says how much is
    /// open.
    pub fn new(
        layout: &Layout,
        face: usize,
        scheme: OpenFaces,
        condition: Option<&BoundaryCondition>,
        cells: &[FaceCell],
        areas: &OpenAreas,
    ) -> Self {
        let open_cell = |at: &FaceCell| {
            let [profile, mean] = match condition {
                Some(BoundaryCondition::Velocity { profile: Profile::Parabolic, .. }) => {
                    parabola(&layout.grid, face / 2, layout.at(at.cell))
                }
                _ => [1.0; 2],
            };
            OpenCell { at: *at, profile, share: mean * areas.of(at.cell) }
        };
        let item = |FaceItem { cells, is_own }: FaceItem| OpenItem {
            share: 0.0,
            means: vec![MeanFlow { velocity: f64::NAN, difference: 0.0 }; cells.len()],
            cells,
            is_own,
            gain: Gain::default(),
            entering: 0,
        };
        Self {
            face,
            scheme,
            relax: 0.0,
            items: items_of(layout, cells).into_iter().map(item).collect(),
            cells: cells.iter().map(open_cell).collect(),
            steering: Steering::default(),
        }
    }

    /// That lets sound out; of a domain of so many cells along the face's axis.
    pub fn absorbing(self, length: i32) -> Self {
        Self { relax: relaxation(length), ..self }
    }

    /// Compares what entered through a face with a velocity in a step, and what links brought to
    /// its cells, with what was to, in a fluid of a mean density.
    fn steer<T: Real>(&mut self, next: &PostStreaming<T>, ranks: &mut Ranks) {
        let BoundaryValue::Wall(velocity) = next.now[self.face] else { return };
        let inward = velocity[self.face / 2] * [1.0, -1.0][self.face % 2];
        let mut sums = [ExactSum::default(); 2];
        for item in self.items.iter().filter(|item| item.is_own) {
            sums[0].add(item.gain.mass);
            sums[1].add(item.share);
        }
        ranks.add_up(&mut sums);
        let [gain, share] = values(&sums);
        let mass = next.brought[self.face].total() + gain;
        let Steering { more, most } = &mut self.steering;
        let wanted = next.density * inward * share;
        *most = most.max(wanted.abs());
        if *most > 0.0 {
            let step = STEER * (wanted - mass) / *most * (wanted / *most);
            *more = (*more + step).clamp(-STEER_LIMIT, STEER_LIMIT);
        }
    }
}

impl<T: Real> FaceScheme<T> for OpenFace {
    fn apply(
        &mut self,
        next: &PostStreaming<T>,
        team: &mut Team,
        ranks: &mut Ranks,
    ) -> Result<(), FluidError> {
        let Self { cells, items, face, scheme, relax, steering, .. } = self;
        let view = FaceView {
            next,
            inward: Inward::of(*face),
            value: next.now[*face],
            bounces: *scheme == OpenFaces::Nebb && *relax == 0.0,
            relax: *relax,
            more: steering.more,
        };
        team.for_each(items, |_, item| view.fill(&cells[item.cells.clone()], item));
        self.steer(next, ranks);
        Ok(())
    }

    fn each_gain(&self, add: &mut dyn FnMut([f64; 3], f64)) {
        let own = self.items.iter().filter(|item| item.is_own);
        own.for_each(|item| add(item.gain.impulse, item.gain.mass));
    }

    fn entering(&self) -> usize {
        self.items.iter().filter(|item| item.is_own).map(|item| item.entering).sum()
    }

    fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }

    fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError> {
        state.value("steering", &mut self.steering)?;
        let other = "the open cells of the state are those of another face";
        let whole = |cells: &[OpenCell], k: usize| numbers.in_whole(cells[k].at.cell);
        // Of each item, its first cell and how many let fluid enter.
        let own = self.items.iter().filter(|item| item.is_own);
        let entry = |item: &OpenItem| [whole(&self.cells, item.cells.start), item.entering as u32];
        let mut entering: Vec<[u32; 2]> = own.clone().map(entry).collect();
        state.shared_list("entering", &mut entering)?;
        let (mut cells, mut means) = (Vec::new(), Vec::new());
        if self.relax > 0.0 {
            let of_item = |item: &OpenItem| item.cells.clone().zip(item.means.clone());
            for (k, mean) in own.flat_map(of_item) {
                cells.push(whole(&self.cells, k));
                means.push([mean.velocity, mean.difference]);
            }
            state.shared_list("cells", &mut cells)?;
            state.shared_list("means", &mut means)?;
        }
        if !state.restores() {
            return Ok(());
        }
        let entering: HashMap<u32, u32> = entering.into_iter().map(<(_, _)>::from).collect();
        let means: HashMap<u32, [f64; 2]> = cells.into_iter().zip(means).collect();
        for item in &mut self.items {
            let Some(&found) = entering.get(&whole(&self.cells, item.cells.start)) else {
                return state.unfit(other);
            };
            item.entering = found as usize;
            for (k, mean) in item.cells.clone().zip(&mut item.means) {
                match means.get(&whole(&self.cells, k)) {
                    Some(&[velocity, difference]) => *mean = MeanFlow { velocity, difference },
                    None if self.relax > 0.0 => return state.unfit(other),
                    None => {}
                }
            }
        }
        Ok(())
    }
}

/// The part of a difference from what is given that an open face makes up for in a step, so that
/// sound passes and the mean is held: in a domain of so many cells along the face's axis.
pub fn relaxation(length: i32) -> f64 {
    RELAX * CS2.sqrt() / f64::from(length)
}

/// A value in the middle of a face's first cell, on the straight line from the one on the face to
/// the one in the middle of the next cell inside, if there is fluid.
fn beside_face(face: f64, inside: Option<f64>) -> f64 {
    inside.map_or(face, |inside| (2.0 * face + inside) / 3.0)
}

/// The product of `4 s (1 - s)` over the face's edges that do not wrap around, at the centre of a
/// cell and its mean over the cell.
fn parabola(grid: &Grid, axis: usize, at: [i32; 3]) -> [f64; 2] {
    let mut factors = [1.0; 2];
    for a in (0..3).filter(|&a| a != axis && !grid.periodic[a]) {
        let n = f64::from(grid.n[a]);
        let s = (f64::from(at[a]) + 0.5) / n;
        let factor = 4.0 * s * (1.0 - s);
        factors[0] *= factor;
        factors[1] *= factor - 1.0 / (3.0 * n * n);
    }
    factors
}

/// A face in a step.
struct FaceView<'a, T: Real> {
    next: &'a PostStreaming<'a, T>,
    inward: Inward,
    /// Value that it prescribes.
    value: BoundaryValue,
    /// True if plain cells are filled by non-equilibrium bounce-back.
    bounces: bool,
    /// See [`OpenFace`].
    relax: f64,
    more: f64,
}

impl<T: Real> FaceView<'_, T> {
    /// Gives an item's cells their populations and records what entered.
    fn fill(&self, own: &[OpenCell], item: &mut OpenItem) {
        (item.gain, item.entering, item.share) = (Gain::default(), 0, 0.0);
        let mut waiting = Waiting::NONE;
        for (k, open) in own.iter().enumerate() {
            if let Some(next) = own.get(k + AHEAD) {
                self.ask_for(&next.at, &own[k + AHEAD - 1].at);
            }
            if !self.next.flags.is_fluid(open.at.cell) {
                continue;
            }
            item.share += open.share;
            if self.bounces && open.at.plain {
                self.bounce_cell(open, item);
                continue;
            }
            self.take(&open.at, k, &mut waiting);
            if waiting.count == LANES {
                self.extrapolate(own, &mut waiting, item);
            }
        }
        self.extrapolate(own, &mut waiting, item);
    }

    /// Asks memory for what a cell needs, unless it lies in one line with the cell before.
    fn ask_for(&self, open: &FaceCell, before: &FaceCell) {
        let line = |cell: u32| cell as usize / T::LINE;
        let pairs = [(open.cell, before.cell), (open.inner, before.inner)];
        for (cell, before) in pairs {
            if cell != NONE && line(cell) != line(before) {
                for place in self.next.layout.places.of_cell(self.next.parity, cell) {
                    self.next.field.prefetch(place);
                }
            }
        }
    }

    /// Takes a cell of an item among those that wait.
    fn take(&self, open: &FaceCell, number: usize, waiting: &mut Waiting) {
        let lane = waiting.count;
        waiting.own[lane] = open.cell;
        waiting.from[lane] = self.next.inner(open).unwrap_or(open.cell);
        waiting.cells.unknown[lane] = open.unknown;
        waiting.numbers[lane] = number;
        waiting.count += 1;
    }

    /// Calls `visit` with direction, number among the cells, and place of each population of cells.
    #[inline(always)]
    fn each_place(&self, cells: &[u32], mut visit: impl FnMut(usize, usize, usize)) {
        let mut first = 0;
        for run in self.next.layout.places.runs(cells) {
            for i in 0..Q {
                let each = |k, place| visit(i, first + k, place);
                self.next.layout.places.each_of(self.next.parity, run, i, each);
            }
            first += run.1;
        }
    }

    /// Reads the populations of cells.
    fn read(&self, cells: &[u32], populations: &mut [Lane; Q]) {
        self.each_place(cells, |i, lane, place| populations[i][lane] = self.next.field.get(place));
    }

    /// Writes the populations of cells, and leaves of them what they gained.
    fn write(&self, cells: &[u32], populations: &mut [Lane; Q], old: &[Lane; Q]) {
        self.each_place(cells, |i, lane, place| {
            let new = self.next.field.set(place, populations[i][lane]);
            populations[i][lane] = new - old[i][lane];
        });
    }

    /// Gives the cells that wait their populations by extrapolation.
    fn extrapolate(&self, own: &[OpenCell], waiting: &mut Waiting, item: &mut OpenItem) {
        let Waiting { cells, numbers, own: places, from, count } = waiting;
        let count = std::mem::take(count);
        if count == 0 {
            return;
        }
        let (numbers, places) = (&numbers[..count], &places[..count]);
        self.read(places, &mut cells.old);
        self.read(&from[..count], &mut cells.from);
        self.next.variant.run(LookInside(cells, self.next.acceleration));
        for (lane, &number) in numbers.iter().enumerate() {
            let u = cells.velocity.map(|u| u[lane]);
            let inside = (cells.drho[lane], u);
            let (drho, u) = self.prescribed(&own[number], number, inside, item);
            cells.given.0[lane] = drho;
            for (given, u) in cells.given.1.iter_mut().zip(u) {
                given[lane] = u;
            }
        }
        self.next.variant.run(Extrapolate(cells));
        self.write(places, &mut cells.new, &cells.old);
        self.next.variant.run(AddUp(cells));
        for lane in 0..numbers.len() {
            item.gain.mass += cells.mass[lane];
            add_scaled(&mut item.gain.impulse, cells.impulse.map(|p| p[lane]), 1.0);
        }
    }

    /// Velocity as the face lets it pass: without its part along the face where fluid enters.
    fn limited(&self, u: [f64; 3], item: &mut OpenItem) -> [f64; 3] {
        let Inward { axis, sign } = self.inward;
        if u[axis] * f64::from(sign) <= 0.0 {
            return u;
        }
        item.entering += 1;
        std::array::from_fn(|a| if a == axis { u[a] } else { 0.0 })
    }

    /// Density, less 1, and velocity at an absorbing face with density `given`, from those of the
    /// next cell inside.
    fn absorb(&self, mean: &mut MeanFlow, given: f64, drho: f64, u: [f64; 3]) -> (f64, [f64; 3]) {
        let (axis, outward) = (self.inward.axis, -f64::from(self.inward.sign));
        let (v, sound) = (u[axis] * outward, CS2.sqrt());
        if mean.velocity.is_nan() {
            mean.velocity = v;
        }
        let given = given + 0.5 * mean.difference;
        let here = 0.5 * (drho + given) + 0.5 * (v - mean.velocity) / sound;
        let out = v + sound * (drho - here);
        mean.velocity += self.relax * (out - mean.velocity);
        mean.difference += self.relax * (drho - here - mean.difference);
        let mut velocity = u;
        velocity[axis] = out * outward;
        (here, velocity)
    }

    /// Density, less 1, and velocity at a cell, the given number of its item, from those of the
    /// next inside.
    fn prescribed(
        &self,
        open: &OpenCell,
        number: usize,
        (drho, u): (f64, [f64; 3]),
        item: &mut OpenItem,
    ) -> (f64, [f64; 3]) {
        match self.value {
            BoundaryValue::Wall(given) => {
                let given = self.steered(open, given);
                let inside = self.next.inner(&open.at).map(|_| u);
                (drho, std::array::from_fn(|a| beside_face(given[a], inside.map(|u| u[a]))))
            }
            BoundaryValue::Density(given) if self.relax > 0.0 => {
                let (drho, u) = self.absorb(&mut item.means[number], given, drho, u);
                (drho, self.limited(u, item))
            }
            BoundaryValue::Density(given) => {
                let inside = self.next.inner(&open.at).map(|_| drho);
                (beside_face(given, inside), self.limited(u, item))
            }
        }
    }

    /// Velocity of a cell where the face has a given one.
    fn steered(&self, open: &OpenCell, given: [f64; 3]) -> [f64; 3] {
        given.map(|v| v * (open.profile * (1.0 + self.more)))
    }

    /// Gives a plain cell its populations by non-equilibrium bounce-back.
    fn bounce_cell(&self, open: &OpenCell, item: &mut OpenItem) {
        let old = self.next.populations(open.at.cell);
        let Inward { axis, sign } = self.inward;
        let n = f64::from(sign);
        let half = self.next.acceleration.map(|a| 0.5 * a);
        let s = self.inward.known_sum(&old);
        let inner = self.next.inner(&open.at).map(|cell| Content::of(&self.next.populations(cell)));
        let velocity = inner.as_ref().map(|inner| inner.velocity(self.next.acceleration));
        // `u` is the momentum over the density: without half the step's force.
        let (drho, u) = match self.value {
            BoundaryValue::Wall(given) => {
                let given = self.steered(open, given);
                let given = |a: usize| beside_face(given[a], velocity.map(|u| u[a]));
                let u: [f64; 3] = std::array::from_fn(|a| given(a) - half[a]);
                ((s + u[axis] * n) / (1.0 - u[axis] * n), u)
            }
            BoundaryValue::Density(given) => {
                let drho = beside_face(given, inner.map(|inner| inner.drho));
                let mut u = velocity.unwrap_or_default();
                u[axis] = n * (drho - s) / (1.0 + drho) + half[axis];
                let u = self.limited(u, item);
                (drho, std::array::from_fn(|a| u[a] - half[a]))
            }
        };
        let new = self.inward.zou_he(&old, drho, u);
        self.next.replace(&open.at, &old, &new, &mut item.gain);
    }
}
