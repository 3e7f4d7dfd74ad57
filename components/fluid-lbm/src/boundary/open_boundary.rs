//! Open faces: the first cells inside a face that prescribes velocity or pressure.
//!
//! `x_B` is such a cell, `x_I = x_B + n` the next one inside, `n` the normal into the fluid. After
//! streaming, when all else is done, the cell gets
//!
//! ```text
//! NEE   f_i(x_B) = feq_i(rho, u) + f_i(x_I) - feq_i(rho(x_I), u(x_I))                for all i
//! ```
//!
//! with `rho` given and `u = u(x_I)` at a pressure face, `u` given and `rho = rho(x_I)` at a velocity
//! face (non-equilibrium extrapolation, Guo, Zheng & Shi 2002); or, with sums over the directions
//! along the face (0) and out of the fluid (-),
//!
//! ```text
//! NEBB  u.n = 1 - (S_0 + 2 S_-)/rho     (pressure)      rho = (S_0 + 2 S_-)/(1 - u.n)     (velocity)
//!       N_t = 1/2 sum_{c_j.n = 0} c_j,t f_j - rho u_t/3
//!       f_i = f_i' + 6 w_i rho (c_i.u) - (c_i - (c_i.n) n).N_t                      for c_i.n > 0
//! ```
//!
//! (non-equilibrium bounce-back, Zou & He 1997, Hecht & Harting 2010), `u_t` being that of `x_I` at a
//! pressure face. What is prescribed holds at the centre of `x_B`, half a cell inside the face. At a
//! pressure face through which the fluid enters, `u_t = 0`; such cells are counted.
//!
//! An *absorbing* pressure face lets sound out. Of the two waves that meet there, the one that comes in
//! is held to what the given pressure and the mean flow say, instead of the pressure itself:
//!
//! ```text
//! drho = (drho_I + drho_given)/2 + (v_I - v_mean)/(2 c_s)      v: velocity out of the fluid, of x_I
//! v    = v_I + c_s (drho_I - drho)
//! v_mean += (v - v_mean) s c_s/L                                s = 1/4, L: the domain's length
//! ```
//!
//! So a wave of circular frequency `w` is thrown back by `1/sqrt(1 + (2 w L/(s c_s))^2)` (Rudy &
//! Strikwerda 1980, Poinsot & Lele 1992; the formula from Selle, Nicoud & Poinsot 2004), the domain's
//! longest by 8 %, and where the flow is steady the pressure is the given one. `v_mean` is each cell's
//! own and starts with the flow. Such faces are NEE in either scheme.
//!
//! # What a velocity face delivers
//! Next to a wall, the links that would carry fluid along it are the wall's, and the layer between `x_B` and `x_I` passes
//! less than the velocities at `x_B` say: of a uniform profile a sixth in each cell beside a wall, and more or less of that
//! with the shear there, which no formula foretells. So the mass `m` that enters through the face, with what links to walls
//! bring to its cells, is compared with the one that was asked for, and the velocities of the whole face take a factor `1 + e`:
//!
//! ```text
//! M  = <rho> u.n sum of (mean factor of the profile over a cell) (open area of the cell)
//! e += r (M - m) M/M_max^2                                              r = 0.02
//! ```
//!
//! `<rho>` is the mean density of the fluid: so the volume is right halfway between where the flow's pressure is highest
//! and lowest, and faces that are to pass the same do. A wall of a part that crosses a cell within the face leaves it the
//! area beside it (see `open_area`). (The rule is that of least mean squares, Widrow & Hoff 1960; it rests where the flow turns round.)
//!
//! Cells at two open faces belong to the one of the first axis (of the world) and look along both normals. Where a
//! link leaves through a wall and an open face at once, it belongs to the wall; there, and at two open
//! faces, NEBB would lack equations and NEE takes its place.

use crate::boundary::link_kernels::{LANES, Lane};
use crate::boundary::nonequilibrium_extrapolation::{
    AddUp, Extrapolate, InnerCells, LookInside, gained,
};
use crate::boundary::open_area::OpenAreas;
use crate::boundary::refill::Content;
use crate::boundary::wall_mass::Brought;
use crate::domain::boundary_condition::{BoundaryCondition, BoundaryValue};
use crate::domain::parameters::OpenFaces;
use crate::lattice::aa_pattern::{Blocked, Parity};
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::{C, C_F64, CS2, OPPOSITE, Q, W, dot, each};
use crate::lattice::grid::{Grid, Side};
use crate::lattice::layout::Layout;
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::{Field, Real};
use std::ops::Range;
use tremie_messages::scene::Profile;
use tremie_team::Variant;

/// Cells that are one item of work.
pub const CELLS_PER_ITEM: usize = 512;

/// Part of the way that the mean velocity at an absorbing face goes in the time in which sound crosses
/// the domain.
const RELAX: f64 = 0.25;

/// Part of the difference of mass by which the velocities of a face change in a step.
const STEER: f64 = 0.02;

/// The most by which they may.
const STEER_LIMIT: f64 = 0.25;

/// How many cells ahead of its use memory is asked for.
const AHEAD: usize = 8;

/// A cell at an open face.
#[derive(Clone, Copy, Debug)]
struct OpenCell {
    cell: u32,
    /// The next cell inside; [`crate::lattice::cell_list::NONE`] if that is solid.
    inner: u32,
    /// Bits of the directions that come from beyond an open face.
    unknown: u32,
    /// `2 axis + side`.
    face: u8,
    /// Whether all unknown directions come through this face, and no other wall is near.
    plain: bool,
    /// Factor of the velocity's profile.
    profile: f64,
    /// Mean of that factor over the cell times the area of the face that is open there.
    share: f64,
    /// What part of its difference the mean velocity takes over in a step, where the face absorbs; else
    /// 0.
    relax: f64,
}

/// The cells at open faces.
#[derive(Clone, Debug, Default)]
pub struct OpenCells {
    cells: Vec<OpenCell>,
    /// How each face with a velocity is held to what it is to deliver, `2 axis + side`.
    steering: [Steering; 6],
}

/// By how much the velocities of a face are larger than given, so that it delivers what is asked for.
#[derive(Clone, Copy, Debug, Default)]
struct Steering {
    /// As a part of them.
    more: f64,
    /// Largest mass that was to enter, or to leave, in a step.
    most: f64,
}

/// Cells that are one item of work, and what entered through them in the last step.
#[derive(Clone, Debug)]
pub struct OpenItem {
    cells: Range<usize>,
    /// The face: `2 axis + side`.
    face: usize,
    /// Sum of the shares of its cells that are fluid.
    share: f64,
    /// For each cell the mean velocity out of the fluid, at absorbing faces; not a number at first.
    means: Vec<f64>,
    /// Momentum that the fluid gained.
    pub impulse: [f64; 3],
    /// Mass that the fluid gained.
    pub mass: f64,
    /// Cells of pressure faces through which fluid enters.
    pub entering: usize,
}

/// The fluid as the next collision will find it.
#[derive(Clone, Copy)]
pub struct PostStreaming<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Where they are.
    pub layout: &'a Layout,
    /// Which cells are fluid.
    pub flags: &'a CellFlags,
    /// Parity of the next collision.
    pub parity: Parity,
    /// Acceleration of the fluid.
    pub acceleration: [f64; 3],
    /// What the faces prescribe, by number.
    pub now: &'a [BoundaryValue],
    /// Which scheme.
    pub scheme: OpenFaces,
    /// Which vector instructions.
    pub variant: Variant,
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

impl OpenCells {
    /// Of the links that open faces block. `absorbing` says it of each face; `areas` how much of each cell is open.
    pub fn new(
        layout: &Layout,
        laws: &[Option<BoundaryCondition>],
        absorbing: [bool; 6],
        blocked: &[Blocked],
        areas: &OpenAreas,
    ) -> (Self, Vec<OpenItem>) {
        let mut own = Self::default();
        for links in blocked.chunk_by(|a, b| a.cell == b.cell) {
            let grid = &layout.grid;
            let at = layout.at(links[0].cell);
            let open: Vec<_> = open_faces(grid, at).collect();
            let Some(&(axis, side)) = open.first() else { continue };
            let mut normal = [0; 3];
            for &(axis, side) in &open {
                normal[axis] = [1, -1][side];
            }
            let unknown = links.iter().fold(0, |bits, l| bits | 1 << OPPOSITE[l.dir as usize]);
            let across: u32 =
                (0..Q).filter(|&i| C[i][axis] == [1, -1][side]).fold(0, |bits, i| bits | 1 << i);
            let [profile, mean] = match &laws[2 * axis + side] {
                Some(BoundaryCondition::Velocity { profile: Profile::Parabolic, .. }) => {
                    parabola(grid, axis, at)
                }
                _ => [1.0; 2],
            };
            own.cells.push(OpenCell {
                cell: links[0].cell,
                inner: layout
                    .near(at, normal)
                    .map_or(crate::lattice::cell_list::NONE, |(cell, _)| cell),
                unknown,
                face: (2 * axis + side) as u8,
                plain: unknown == across && open.len() == 1,
                profile,
                share: mean * areas.of(links[0].cell),
                relax: if absorbing[2 * axis + side] {
                    RELAX * CS2.sqrt() / f64::from(grid.n[axis])
                } else {
                    0.0
                },
            });
        }
        own.cells.sort_by_key(|open| open.face);
        let mut items = Vec::new();
        let mut first = 0;
        for of_face in own.cells.chunk_by(|a, b| a.face == b.face) {
            for cells in of_face.chunks(CELLS_PER_ITEM) {
                items.push(OpenItem {
                    cells: first..first + cells.len(),
                    face: of_face[0].face.into(),
                    share: 0.0,
                    means: vec![f64::NAN; cells.len()],
                    impulse: [0.0; 3],
                    mass: 0.0,
                    entering: 0,
                });
                first += cells.len();
            }
        }
        (own, items)
    }

    /// Memory that the table takes [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }

    /// Compares what entered through faces with a velocity in a step, and what links brought to their cells, with what was to, in a
    /// fluid of a mean density. Sums are in the order of the items.
    pub fn steer(
        &mut self,
        items: &[OpenItem],
        now: &[BoundaryValue],
        density: f64,
        brought: &[Brought; 6],
    ) {
        for of_face in items.chunk_by(|a, b| a.face == b.face) {
            let face = of_face[0].face;
            let BoundaryValue::Wall(velocity) = now[face] else { continue };
            let inward = velocity[face / 2] * [1.0, -1.0][face % 2];
            let (mut mass, mut share) = (brought[face].total(), 0.0);
            for item in of_face {
                (mass, share) = (mass + item.mass, share + item.share);
            }
            let Steering { more, most } = &mut self.steering[face];
            let wanted = density * inward * share;
            *most = most.max(wanted.abs());
            if *most > 0.0 {
                let step = STEER * (wanted - mass) / *most * (wanted / *most);
                *more = (*more + step).clamp(-STEER_LIMIT, STEER_LIMIT);
            }
        }
    }
}

/// The open faces at which a cell lies, in the order of the world's axes.
pub fn open_faces(grid: &Grid, at: [i32; 3]) -> impl Iterator<Item = (usize, usize)> {
    let is_at = move |axis: usize, side: usize| {
        grid.sides[axis][side] == Side::Open && at[axis] == [0, grid.n[axis] - 1][side]
    };
    grid.order.into_iter().filter_map(move |axis| {
        let side = (0..2).find(|&side| is_at(axis, side))?;
        Some((axis, side))
    })
}

/// The product of `4 s (1 - s)` over the face's edges that do not wrap around, at the centre of a cell and its mean over
/// the cell.
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

impl<T: Real> PostStreaming<'_, T> {
    /// Gives an item's cells their populations and records what entered.
    pub fn open(&self, cells: &OpenCells, item: &mut OpenItem) {
        (item.impulse, item.mass, item.entering) = ([0.0; 3], 0.0, 0);
        item.share = 0.0;
        let more = cells.steering[item.face].more;
        let own = &cells.cells[item.cells.clone()];
        let mut waiting = Waiting::NONE;
        for (k, open) in own.iter().enumerate() {
            if let Some(next) = own.get(k + AHEAD) {
                self.ask_for(next, &own[k + AHEAD - 1]);
            }
            if !self.flags.is_fluid(open.cell) {
                continue;
            }
            item.share += open.share;
            if self.scheme == OpenFaces::Nebb && open.plain && open.relax == 0.0 {
                self.bounce_cell(open, more, item);
                continue;
            }
            self.take(open, k, &mut waiting);
            if waiting.count == LANES {
                self.extrapolate(own, more, &mut waiting, item);
            }
        }
        self.extrapolate(own, more, &mut waiting, item);
    }

    /// Asks memory for what a cell needs, unless it lies in one line with the cell before.
    fn ask_for(&self, open: &OpenCell, before: &OpenCell) {
        let line = |cell: u32| cell as usize / T::LINE;
        let pairs = [(open.cell, before.cell), (open.inner, before.inner)];
        for (cell, before) in pairs {
            if cell != crate::lattice::cell_list::NONE && line(cell) != line(before) {
                for place in self.layout.places.of_cell(self.parity, cell) {
                    self.field.prefetch(place);
                }
            }
        }
    }

    /// Populations that the next collision finds in a cell.
    #[inline]
    pub fn populations(&self, cell: u32) -> [f64; Q] {
        self.layout.populations(self.field, self.parity, cell)
    }

    /// The next cell inside, if there is fluid.
    fn inner(&self, open: &OpenCell) -> Option<u32> {
        let is_there =
            open.inner != crate::lattice::cell_list::NONE && self.flags.is_fluid(open.inner);
        is_there.then_some(open.inner)
    }

    fn bounce_cell(&self, open: &OpenCell, more: f64, item: &mut OpenItem) {
        let old = self.populations(open.cell);
        let inner = self.inner(open).map(|cell| self.populations(cell));
        let new = self.zou_he(open, more, (&old, inner.as_ref()), item);
        self.replace(open.cell, open.unknown, [&old, &new], &mut item.impulse, &mut item.mass);
    }

    /// Takes a cell of an item among those that wait.
    fn take(&self, open: &OpenCell, number: usize, waiting: &mut Waiting) {
        let lane = waiting.count;
        waiting.own[lane] = open.cell;
        waiting.from[lane] = self.inner(open).unwrap_or(open.cell);
        waiting.cells.unknown[lane] = open.unknown;
        waiting.numbers[lane] = number;
        waiting.count += 1;
    }

    /// Calls `visit` with direction, number among the cells, and place of each population of cells.
    #[inline(always)]
    fn each_place(&self, cells: &[u32], mut visit: impl FnMut(usize, usize, usize)) {
        let mut first = 0;
        for run in self.layout.places.runs(cells) {
            for i in 0..Q {
                let each = |k, place| visit(i, first + k, place);
                self.layout.places.each_of(self.parity, run, i, each);
            }
            first += run.1;
        }
    }

    /// Reads the populations of cells.
    fn read(&self, cells: &[u32], populations: &mut [Lane; Q]) {
        self.each_place(cells, |i, lane, place| populations[i][lane] = self.field.get(place));
    }

    /// Writes the populations of cells, and leaves of them what they gained.
    fn write(&self, cells: &[u32], populations: &mut [Lane; Q], old: &[Lane; Q]) {
        self.each_place(cells, |i, lane, place| {
            let new = self.field.set(place, populations[i][lane]);
            populations[i][lane] = new - old[i][lane];
        });
    }

    /// Gives the cells that wait their populations by extrapolation.
    fn extrapolate(&self, own: &[OpenCell], more: f64, waiting: &mut Waiting, item: &mut OpenItem) {
        let Waiting { cells, numbers, own: places, from, count } = waiting;
        let count = std::mem::take(count);
        if count == 0 {
            return;
        }
        let (numbers, places) = (&numbers[..count], &places[..count]);
        self.read(places, &mut cells.old);
        self.read(&from[..count], &mut cells.from);
        self.variant.run(LookInside(cells, self.acceleration));
        for (lane, &number) in numbers.iter().enumerate() {
            let u = cells.velocity.map(|u| u[lane]);
            let inside = (cells.drho[lane], u);
            let (drho, u) = self.prescribed(&own[number], more, number, inside, item);
            cells.given.0[lane] = drho;
            for (given, u) in cells.given.1.iter_mut().zip(u) {
                given[lane] = u;
            }
        }
        self.variant.run(Extrapolate(cells));
        self.write(places, &mut cells.new, &cells.old);
        self.variant.run(AddUp(cells));
        for lane in 0..numbers.len() {
            item.mass += cells.mass[lane];
            add_scaled(&mut item.impulse, cells.impulse.map(|p| p[lane]), 1.0);
        }
    }

    /// Replaces the old populations of a cell by new ones and adds up what the fluid gained. The
    /// `unknown` ones come through an open face.
    pub fn replace(
        &self,
        cell: u32,
        unknown: u32,
        [old, new]: [&[f64; Q]; 2],
        impulse: &mut [f64; 3],
        mass: &mut f64,
    ) {
        let places = self.layout.places.of_cell(self.parity, cell);
        let gain = each(|i| self.field.set(places[i], new[i]) - old[i]);
        let (more, momentum) = gained(gain, old, unknown);
        *mass += more;
        add_scaled(impulse, momentum, 1.0);
    }

    /// Velocity as the face lets it pass: without its part along the face where fluid enters.
    fn limited(&self, open: &OpenCell, u: [f64; 3], item: &mut OpenItem) -> [f64; 3] {
        let (axis, inward) = (usize::from(open.face / 2), [1.0, -1.0][usize::from(open.face % 2)]);
        if u[axis] * inward <= 0.0 {
            return u;
        }
        item.entering += 1;
        std::array::from_fn(|a| if a == axis { u[a] } else { 0.0 })
    }

    /// Density, less 1, and velocity at an absorbing face with density `given`, from those of the next
    /// cell inside.
    fn absorb(
        &self,
        open: &OpenCell,
        mean: &mut f64,
        given: f64,
        drho: f64,
        u: [f64; 3],
    ) -> (f64, [f64; 3]) {
        let (axis, outward) = (usize::from(open.face / 2), [-1.0, 1.0][usize::from(open.face % 2)]);
        let (v, sound) = (u[axis] * outward, CS2.sqrt());
        if mean.is_nan() {
            *mean = v;
        }
        let here = 0.5 * (drho + given) + 0.5 * (v - *mean) / sound;
        let out = v + sound * (drho - here);
        *mean += open.relax * (out - *mean);
        let mut velocity = u;
        velocity[axis] = out * outward;
        (here, velocity)
    }

    /// Density, less 1, and velocity at a cell, the given number of its item, from those of the next inside.
    fn prescribed(
        &self,
        open: &OpenCell,
        more: f64,
        number: usize,
        (drho, u): (f64, [f64; 3]),
        item: &mut OpenItem,
    ) -> (f64, [f64; 3]) {
        match self.now[open.face as usize] {
            BoundaryValue::Wall(given) => (drho, given.map(|v| v * (open.profile * (1.0 + more)))),
            BoundaryValue::Density(given) if open.relax > 0.0 => {
                let (drho, u) = self.absorb(open, &mut item.means[number], given, drho, u);
                (drho, self.limited(open, u, item))
            }
            BoundaryValue::Density(given) => (given, self.limited(open, u, item)),
        }
    }

    fn zou_he(
        &self,
        open: &OpenCell,
        more: f64,
        (old, inner): (&[f64; Q], Option<&[f64; Q]>),
        item: &mut OpenItem,
    ) -> [f64; Q] {
        let (axis, inward) = (usize::from(open.face / 2), [1, -1][usize::from(open.face % 2)]);
        let n = f64::from(inward);
        let half = self.acceleration.map(|a| 0.5 * a);
        // S_0 + 2 S_-, less what it is at rest, which is 1.
        let mut s = 0.0;
        for i in 0..Q {
            match C[i][axis] * inward {
                0 => s += old[i],
                -1 => s += 2.0 * old[i],
                _ => {}
            }
        }
        // `u` is the momentum over the density: without half the step's force.
        let (drho, u) = match self.now[open.face as usize] {
            BoundaryValue::Wall(given) => {
                let u: [f64; 3] =
                    std::array::from_fn(|a| given[a] * (open.profile * (1.0 + more)) - half[a]);
                ((s + u[axis] * n) / (1.0 - u[axis] * n), u)
            }
            BoundaryValue::Density(drho) => {
                let along = inner.map_or([0.0; 3], |h| Content::of(h).velocity(self.acceleration));
                let mut u = along;
                u[axis] = n * (drho - s) / (1.0 + drho) + half[axis];
                let u = self.limited(open, u, item);
                (drho, std::array::from_fn(|a| u[a] - half[a]))
            }
        };
        let rho = 1.0 + drho;
        let transverse: [f64; 3] = std::array::from_fn(|a| {
            if a == axis {
                return 0.0;
            }
            let along = (0..Q).filter(|&j| C[j][axis] == 0).map(|j| C_F64[j][a] * old[j]);
            0.5 * along.sum::<f64>() - rho * u[a] / 3.0
        });
        let mut new = *old;
        for i in (0..Q).filter(|&i| C[i][axis] == inward) {
            new[i] =
                old[OPPOSITE[i]] + 6.0 * W[i] * rho * dot(C_F64[i], u) - dot(C_F64[i], transverse);
        }
        new
    }
}
