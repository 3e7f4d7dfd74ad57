//! Parts behind whose surface a reservoir with a piston lies: an opening that faces any way.
//!
//! Links that end at the part get the cylinder's density (see `cylinder`), as at a part with a
//! pressure, and then a share of the mean flow. With `g` the populations after the collision, `i'`
//! opposite to `i`, the link `i` leaving the fluid, `n` the direction in which all of the surface looks
//! into the fluid, and `rho` the density of the cylinder:
//!
//! ```text
//! b_i = -g_i + 2 w_i rho [1 + 9/2 (c_i.u)^2 - 3/2 u.u]        u that of the cell
//! a_i = -6 w_i rho c_i.n                                      what a unit of velocity along n brings
//! u_n = sum over the cell's links (b_i - g_i)/sum a_i
//! f_i' = b_i + r (mean of u_n over the surface - u_n) a_i
//! ```
//!
//! The first line is anti-bounce-back (Ginzburg, Verhaeghe & d'Humieres 2008, eq. 22), the surface
//! half-way; the last keeps cells from going each their own way, as `face` does (Mutabaruka & Kamrin,
//! Eq. 31). The mean is by area, so the last term brings no mass in all.
//!
//! The sum of `a_i/rho` is the area of a plane surface in the mean over its cells, less what links lack
//! that end at a wall beside it: 3 % in a duct of 12 cells. So the cylinder has the area that the scene
//! gives, and its piston displaces what the scene says.
//!
//! The cylinder loses what the links bring, to rounding. Links are read before any link of the step is
//! reflected and written after all, as in `sheet_links`.

use crate::boundary::post_collision::PostCollision;
use crate::boundary::refill::PreCollision;
use crate::boundary::static_wall_links::at_density;
use crate::boundary::virtual_piston::cylinder::Cylinder;
use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::lattice::aa_pattern::Blocked;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C_F64, OPPOSITE, W, dot};
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::{ExactSum, add_vector, values};
use crate::lattice::layout::{Layout, items_in_blocks};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::lattice::units::Units;
use crate::ranks::rank_sums::Ranks;
use std::ops::Range;
use tremie_messages::scene::Reservoir;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Cells that are one item of work at most.
const CELLS_PER_ITEM: usize = 512;

/// Least length of the sum of all areas over the sum of the amounts of each cell's: below, the surface
/// looks more than one way.
pub const ONE_WAY: f64 = 0.5;

/// Least area of a cell's links [cells] that gives it a velocity of its own.
const LEAST_AREA: f64 = 0.25;

/// What the link `i` of a cell is of the area that it ends at, as a vector into the fluid.
pub fn area_of_link(i: usize) -> [f64; 3] {
    C_F64[i].map(|c| -6.0 * W[i] * c)
}

/// By how much a given area is divided to be that of the surface which was found, up to `mirrors` times
/// by two: mirrors may cut the surface, and the scene give the area of the whole.
pub fn parts_of_area(given: f64, found: f64, mirrors: usize) -> f64 {
    let parts = (0..=mirrors).map(|k| f64::from(1_u32 << k));
    let apart = |parts: &f64| (parts * found / given).ln().abs();
    parts.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(1.0)
}

/// A link, and what the step finds there.
#[derive(Clone, Copy, Debug)]
struct SurfaceLink {
    dir: u8,
    /// `a_i/rho`.
    area: f64,
    /// `g_i`, and what comes back.
    g: f64,
    f: f64,
}

/// A cell with its links among those of the item.
#[derive(Clone, Debug)]
struct SurfaceCell {
    cell: u32,
    first: u32,
    end: u32,
    /// Sum of `a_i/rho` of its links.
    area: f64,
    /// True if it is fluid.
    is_wet: bool,
    /// Its `u_n`.
    velocity: f64,
}

/// Cells that are one item of work, and what the step found there.
#[derive(Clone, Debug, Default)]
struct SurfaceItem {
    cells: Vec<SurfaceCell>,
    /// True if this part of the lattice counts them.
    is_own: bool,
    links: Vec<SurfaceLink>,
    /// Sums over the cells that are fluid: of the mass that would come in, over `rho`, and of areas.
    flow: f64,
    area: f64,
    /// Largest normal velocity, by amount.
    fastest: f64,
    exchange: MomentumExchange,
}

/// The surface of a part with the cylinder behind it.
#[derive(Clone, Debug)]
pub struct ReservoirSurface {
    place: ReservoirPlace,
    /// The part among what links meet.
    pub fixture: BoundaryId,
    relaxation: f64,
    /// Direction in which the surface looks into the fluid.
    normal: [f64; 3],
    items: Vec<SurfaceItem>,
    cylinder: Cylinder,
    /// Area of the links over that of the surface.
    share: f64,
    /// Mean of the normal velocities.
    mean: f64,
}

impl ReservoirSurface {
    /// The surface of a part, an index, at which these links end, by cell, in a domain with so many axes
    /// that have a mirror.
    pub fn new(
        layout: &Layout,
        (part, fixture): (usize, BoundaryId),
        links: &[Blocked],
        (reservoir, mirrors): (&Reservoir, usize),
        (units, ranks): (&Units, &mut Ranks),
    ) -> Self {
        let mut whole = [ExactSum::default(); 3];
        for link in links.iter().filter(|link| layout.is_own(link.cell)) {
            add_vector(&mut whole, area_of_link(link.dir.into()));
        }
        ranks.add_up(&mut whole);
        let whole = values(&whole);
        let found = dot(whole, whole).sqrt();
        let normal = whole.map(|a| if found > 0.0 { a / found } else { 0.0 });
        let given = reservoir.area / (units.cell * units.cell);
        let area = given / parts_of_area(given, found, mirrors);
        let cells: Vec<&[Blocked]> = links.chunk_by(|a, b| a.cell == b.cell).collect();
        let numbers: Vec<u32> = cells.iter().map(|links| links[0].cell).collect();
        let item = |range: Range<usize>| {
            let is_own = layout.is_own(cells[range.start][0].cell);
            let mut item = SurfaceItem { is_own, ..SurfaceItem::default() };
            for links in &cells[range] {
                let first = item.links.len() as u32;
                item.links.extend(links.iter().map(|link| SurfaceLink {
                    dir: link.dir,
                    area: dot(area_of_link(link.dir.into()), normal),
                    g: 0.0,
                    f: 0.0,
                }));
                let own = &item.links[first as usize..];
                let area = own.iter().map(|link| link.area).sum();
                let end = item.links.len() as u32;
                let cell = links[0].cell;
                let is_wet = false;
                item.cells.push(SurfaceCell { cell, first, end, area, is_wet, velocity: 0.0 });
            }
            item
        };
        Self {
            place: ReservoirPlace::Part(part),
            fixture,
            relaxation: reservoir.relaxation,
            normal,
            items: items_in_blocks(&numbers, CELLS_PER_ITEM).map(item).collect(),
            cylinder: Cylinder::new(reservoir, area, units),
            share: found / area,
            mean: 0.0,
        }
    }

    /// The items that this part of the lattice counts.
    fn own(&self) -> impl Iterator<Item = &SurfaceItem> {
        self.items.iter().filter(|item| item.is_own)
    }

    /// Puts the cylinder's fluid into the state of the cells at the surface.
    pub fn fill<T: Real>(
        &mut self,
        before: &PreCollision<T>,
        flags: &CellFlags,
        ranks: &mut Ranks,
    ) {
        let mut sums = [ExactSum::default(); 3];
        let cells = self.own().flat_map(|item| item.cells.iter().map(|cell| cell.cell));
        for cell in cells.filter(|&cell| flags.is_fluid(cell)) {
            let content = before.content(cell);
            sums[0].add(1.0);
            sums[1].add(content.drho);
            sums[2].add(dot(self.normal, content.j) / (1.0 + content.drho));
        }
        ranks.add_up(&mut sums);
        let [count, drho, velocity] = values(&sums);
        self.cylinder.fill(drho / f64::max(count, 1.0));
        self.mean = velocity / f64::max(count, 1.0);
    }

    /// Moves the piston through the step that begins at a time [s].
    ///
    /// # Errors
    /// A piston that comes too close to the surface.
    pub fn begin(&mut self, time: f64, units: &Units) -> Result<(), FluidError> {
        let place = self.place;
        self.cylinder.advance(time, self.share * self.mean, units).map_err(|spent| spent.at(place))
    }

    /// Finds what comes back through the links, before any of the step's links is reflected.
    pub fn read<T: Real>(&mut self, after: &PostCollision<T>, team: &mut Team, ranks: &mut Ranks) {
        let drho = self.cylinder.drho();
        team.for_each(&mut self.items, |_, item| item.read(after, drho));
        let mut sums = [ExactSum::default(); 2];
        for item in self.own() {
            sums[0].add(item.flow);
            sums[1].add(item.area);
        }
        ranks.add_up(&mut sums);
        let [flow, area] = values(&sums);
        self.mean = if area > 0.0 { flow / area } else { 0.0 };
    }

    /// Gives the cells what comes back, after all other links are reflected, and lets the cylinder lose
    /// what they gained. `reference` is the point about which the part's torque counts.
    ///
    /// # Errors
    /// A flow that is too fast for the lattice, or not finite.
    pub fn write<T: Real>(
        &mut self,
        after: &PostCollision<T>,
        reference: [f64; 3],
        units: &Units,
        (team, ranks): (&mut Team, &mut Ranks),
    ) -> Result<(), FluidError> {
        let more = [self.relaxation * (1.0 + self.cylinder.drho()), self.mean];
        team.for_each(&mut self.items, |_, item| item.write(after, more, reference));
        let mut gained = ExactSum::default();
        self.own().for_each(|item| gained.add(item.exchange.mass));
        ranks.add_up([&mut gained]);
        self.cylinder.drain(gained.value());
        let fastest = self.own().map(|item| item.fastest).fold(0.0, f64::max);
        let [fastest] = ranks.largest([fastest]);
        self.cylinder.passes([self.mean, fastest], self.place, units)
    }

    /// What the fluid exchanged with the part in the last step, piece by piece.
    pub fn exchanges(&self) -> impl Iterator<Item = (BoundaryId, &MomentumExchange)> {
        self.own().map(|item| (self.fixture, &item.exchange))
    }

    /// State of the reservoir, SI units.
    pub fn state(&self, units: &Units) -> ReservoirState {
        self.cylinder.state(self.place, self.share * self.mean, units)
    }

    /// Keeps piston and fluid, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("mean", &mut self.mean)?;
        self.cylinder.exchange(state)
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        let of = |item: &SurfaceItem| {
            size_of_val(item.cells.as_slice()) + size_of_val(item.links.as_slice())
        };
        self.items.iter().map(of).sum()
    }
}

impl SurfaceItem {
    fn read<T: Real>(&mut self, after: &PostCollision<T>, drho: f64) {
        let Self { cells, links, flow, area, fastest, .. } = self;
        (*flow, *area, *fastest) = (0.0, 0.0, 0.0);
        for own in cells {
            own.is_wet = after.flags.is_fluid(own.cell);
            if !own.is_wet {
                continue;
            }
            let all = after.post(own.cell);
            let mut gain = 0.0;
            for link in &mut links[own.first as usize..own.end as usize] {
                link.g = all[usize::from(link.dir)];
                link.f = at_density(link.dir.into(), link.g, drho, &all);
                gain += link.f - link.g;
            }
            gain /= 1.0 + drho;
            own.velocity = gain / own.area;
            // The few links of a cell at an edge may look aside: they have the density alone.
            if own.area >= LEAST_AREA {
                *flow += gain;
                *area += own.area;
                *fastest = fastest.max(own.velocity.abs());
            }
        }
    }

    fn write<T: Real>(
        &mut self,
        after: &PostCollision<T>,
        [share, mean]: [f64; 2],
        reference: [f64; 3],
    ) {
        let Self { cells, links, exchange, .. } = self;
        *exchange = MomentumExchange::default();
        for own in cells.iter().filter(|own| own.is_wet) {
            // What this adds sums to zero over the surface.
            let has_own = own.area >= LEAST_AREA;
            let more = if has_own { share * (mean - own.velocity) } else { 0.0 };
            let at = after.layout.at(own.cell);
            let arm = after.layout.grid.arm(reference, at);
            for link in &links[own.first as usize..own.end as usize] {
                let i = usize::from(link.dir);
                let place = after.next_place(own.cell, OPPOSITE[i]);
                let f = after.field.set(place, link.f + more * link.area);
                exchange.add_link(C_F64[i], [link.g + f, f - link.g], [0.0; 3], arm);
                exchange.links += 1;
            }
        }
    }
}
