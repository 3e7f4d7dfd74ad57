//! Links between two cells of the fluid that pass through a body: sharp edges and thin walls cut
//! them.
//!
//! Neither end is in the body, so no search for links into it finds them (see `ridges` for those
//! that may be). A wall stands at both ends, each with a distance of its own, and both are
//! reflected as `post_collision` says. The population that comes back to one end belongs in the
//! place from which the other reads (see `aa_pattern`): so all such links are read before any link
//! is reflected, and written after all. Where two bodies cut the same link, the first has it.
//!
//! A rigid body displaces nothing along such a link: its velocity along the link is the same at
//! both ends, and what one side of it leaves the other takes. But interpolation makes or takes mass
//! at each end, by `(2q - 1) w_i` times what the population changes by along the link, and beside
//! an edge that is most, for the fluid is fastest there. So what both ends got together is taken
//! from them again, half from each:
//!
//! ```text
//! f_i'(x)       -= m/2        m = f_i'(x) - g_i(x) + f_i(x + c_i) - g_i'(x + c_i)
//! f_i(x + c_i)  -= m/2
//! ```
//!
//! The force on the body, in which they count with opposite signs, stays the same, and so does a
//! cube's Stokes drag to 3e-4. (Of solids at rest: `sheet_links`.)
//!
//! Of surfaces that deform they are not looked for. Diagnostics do not count them: there a link
//! ends in a body.

use crate::bodies::body::Body;
use crate::bodies::body::late;
use crate::bodies::deformable_shape::Hit;
use crate::bodies::mesh_body::{MeshBody, NearFacets};
use crate::boundary::bouzidi::Bouzidi;
use crate::boundary::gap_sinks::NO_GAP;
use crate::boundary::population_addresses::PopulationAddresses;
use crate::boundary::post_collision::PostCollision;
use crate::lattice::d3q19::{C, C_F64, OPPOSITE, W, dot, mirrored};
use crate::lattice::layout::Layout;
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::{ExchangeTally, MomentumExchange};
use crate::lattice::populations::Real;
use std::ops::RangeInclusive;
use tremie_fluid_kit::cells::grid::Grid;

/// One end of a cut link.
#[derive(Clone, Copy, Debug)]
struct CutEnd {
    slots: PopulationAddresses,
    /// The cell as seen from the body, and the direction.
    at: [i32; 3],
    dir: u8,
    /// Axes at which it is mirrored on its way.
    mirrors: u8,
    /// True if the link behind is cut, too.
    is_shut: bool,
    /// Wall distance, and its gradient by the motion of the surface.
    q: f64,
    slope: [f32; 3],
}

/// Populations at an end: `g` that it sends, and `f` that comes back.
#[derive(Clone, Copy, Debug, Default)]
struct Read {
    g: f64,
    f: f64,
}

/// The cut links of an item.
#[derive(Clone, Debug, Default)]
pub struct CutLinks {
    links: Vec<[CutEnd; 2]>,
    /// Populations that were read; `None` where an end is not fluid.
    read: Vec<Option<[Read; 2]>>,
    /// Room for the search.
    may_be: Vec<([i32; 3], u8)>,
    shut: Vec<(u32, u8)>,
}

impl CutLinks {
    /// Forgets them.
    pub fn clear(&mut self) {
        self.links.clear();
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Room for half as many more.
    pub fn make_room(&mut self) {
        let more = |len: usize, capacity: usize| (len + len / 2 + 32).max(capacity) - len;
        self.links.reserve(more(self.links.len(), self.links.capacity()));
        self.read.clear();
        self.read.reserve(self.links.capacity());
        self.may_be.reserve(more(self.may_be.len(), self.may_be.capacity()));
        self.shut.clear();
        self.shut.reserve(2 * self.links.capacity());
    }

    /// Cells of which densities are needed.
    pub fn cells(&self) -> impl Iterator<Item = u32> {
        self.links.iter().flatten().map(|end| end.slots.cell)
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        size_of::<[CutEnd; 2]>() * self.links.capacity()
            + size_of::<Option<[Read; 2]>>() * self.read.capacity()
    }

    /// Finds those that begin in some layers.
    pub fn find(
        &mut self,
        layout: &Layout,
        part: &MeshBody,
        layers: RangeInclusive<i32>,
        facets: &mut NearFacets,
    ) {
        self.may_be.clear();
        let grid = &layout.grid;
        let is_inside = |[x, y, z]: [i32; 3]| part.inside(y, z, x, x) != 0;
        part.each_cut(layers, is_inside, |at, i| {
            if is_inside(std::array::from_fn(|a| at[a] + C[i][a])) {
                return;
            }
            if let Some(([x, y, z], i)) = in_box(grid, at, i) {
                self.may_be.push(([z, y, x], i as u8));
            }
        });
        self.may_be.sort_unstable();
        self.may_be.dedup();
        let mut near = None;
        let mut meet = |by: [i32; 3], at: [i32; 3], i: usize| {
            if near != Some(by) {
                part.facets_near(by, facets);
                near = Some(by);
            }
            let meeting = part.meets_among(facets, at, C[i])?;
            Some((meeting.q, meeting.slope.map(|x| x as f32)))
        };
        for k in 0..self.may_be.len() {
            let ([z, y, x], dir) = self.may_be[k];
            let (at, i) = ([x, y, z], usize::from(dir));
            let (to, back, mirrors) = other_end(grid, at, i);
            if is_inside(at) || is_inside(to) {
                continue;
            }
            let Some(cell) = layout.cell(std::array::from_fn(|a| grid.wrap(a, at[a]))) else {
                continue;
            };
            let own = || layout.sees_itself(cell, i).then_some(cell);
            let Some(end) = layout.neighbour(cell, i).or_else(own) else { continue };
            // Through a mirror a link is found from both of its ends; a straight one has but one.
            let twice = self.may_be.binary_search(&([to[2], to[1], to[0]], back as u8));
            if twice.is_ok_and(|other| other < k) {
                continue;
            }
            let Some(there) = meet(at, at, i) else { continue };
            // Facets near the one end are near the whole link, but not behind a mirror.
            let by = if mirrors == 0 { at } else { to };
            let Some(here) = meet(by, to, back) else { continue };
            if there.0 + here.0 >= 1.0 {
                continue;
            }
            let one = |cell: u32, at: [i32; 3], i: usize, (q, slope): (f64, [f32; 3])| CutEnd {
                slots: PopulationAddresses::new(layout, cell, i),
                at,
                dir: i as u8,
                mirrors,
                is_shut: false,
                q,
                slope,
            };
            self.links.push([one(cell, at, i, there), one(end, to, back, here)]);
        }
        self.mark_shut();
    }

    /// Marks the ends whose links behind are cut, too.
    fn mark_shut(&mut self) {
        self.shut.clear();
        self.shut.extend(self.links.iter().flatten().map(|end| (end.slots.cell, end.dir)));
        self.shut.sort_unstable();
        for end in self.links.iter_mut().flatten() {
            let behind = (end.slots.cell, OPPOSITE[usize::from(end.dir)] as u8);
            end.is_shut = self.shut.binary_search(&behind).is_ok();
        }
    }
}

/// Coordinates, or those of the image where they are beyond a mirror, and the axes of such.
fn folded(grid: &Grid, mut at: [i32; 3]) -> ([i32; 3], u8) {
    let mut mirrors = 0;
    for (a, x) in at.iter_mut().enumerate() {
        let mirror;
        (*x, mirror) = grid.fold(a, *x);
        mirrors |= mirror << a;
    }
    (at, mirrors)
}

/// A link as the half of it that is simulated: where it begins beyond a mirror, its image. None
/// where it begins beyond another face that ends the fluid.
fn in_box(grid: &Grid, at: [i32; 3], i: usize) -> Option<([i32; 3], usize)> {
    let (at, mirrors) = folded(grid, at);
    let ends = (0..3).any(|a| !grid.periodic[a] && !(0..grid.n[a]).contains(&at[a]));
    (!ends).then(|| (at, mirrored(i, mirrors)))
}

/// Cell at the other end of a link, and the link's direction from there; the image where that is
/// beyond a mirror, and the axes of such mirrors.
fn other_end(grid: &Grid, at: [i32; 3], i: usize) -> ([i32; 3], usize, u8) {
    let (end, mirrors) = folded(grid, std::array::from_fn(|a| at[a] + C[i][a]));
    (end, OPPOSITE[mirrored(i, mirrors)], mirrors)
}

/// Number of ends of a link: one where it sees itself in a mirror.
fn ends_of([one, other]: &[CutEnd; 2]) -> usize {
    if (one.slots.cell, one.dir) == (other.slots.cell, other.dir) { 1 } else { 2 }
}

/// Mass that each end of a cut link gives back of what both got, `f_i' - g_i`, so that together
/// they lose nothing; of one end alone all of it.
pub fn share_of_both(got: [Option<f64>; 2]) -> f64 {
    got.iter().flatten().sum::<f64>() / got.iter().flatten().count().max(1) as f64
}

impl CutEnd {
    /// From the body to the cell, and where the link meets the surface now.
    fn now(&self, body: &Body, part: &MeshBody, nearest: f64) -> ([f64; 3], f64) {
        let arm: [f64; 3] = std::array::from_fn(|a| f64::from(self.at[a]) + 0.5 - body.position[a]);
        let q = self.q + dot(self.slope.map(f64::from), part.drift_of(Hit::NONE, arm));
        (arm, q.clamp(f64::MIN_POSITIVE, 1.0).max(nearest))
    }

    /// Point at which the surface is met, and its velocity there.
    fn wall(&self, body: &Body, arm: [f64; 3], q: f64) -> ([f64; 3], [f64; 3]) {
        let c = C_F64[usize::from(self.dir)];
        let wall = std::array::from_fn(|a| arm[a] + q * c[a]);
        (wall, body.velocity_at(wall))
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Reads the cut links of an item, before any link is reflected.
    pub fn read_cuts(&self, body: &Body, cuts: &mut CutLinks) {
        let Some(part) = &body.part else { return };
        let nearest = if body.is_part() { 0.0 } else { self.nearest_wall };
        let CutLinks { links, read, .. } = cuts;
        read.clear();
        read.extend(links.iter().map(|ends| {
            let is_cut = ends.iter().all(|end| self.is_cut(end.slots.cell));
            is_cut.then(|| {
                let read = ends.each_ref().map(|end| self.read_end(body, part, end, nearest));
                let share = share_of_both(read.map(|end| Some(end.f - end.g)));
                read.map(|end| Read { f: end.f - share, ..end })
            })
        }));
    }

    /// True if links from a cell are cut. They are not in a gap whose walls slip: fluid that slips
    /// there passes edges, too.
    pub fn is_cut(&self, cell: u32) -> bool {
        let in_gap = || self.gaps.gap_of.get(cell as usize).is_some_and(|&gap| gap != NO_GAP);
        self.flags.is_fluid(cell) && !(self.gaps.slips && in_gap())
    }

    fn read_end(&self, body: &Body, part: &MeshBody, end: &CutEnd, nearest: f64) -> Read {
        let (arm, q) = end.now(body, part, nearest);
        let (_, u) = end.wall(body, arm, q);
        let i = usize::from(end.dir);
        let along = dot(C_F64[i], u) + late(q) * dot(C_F64[i], body.change);
        let density = 1.0 + self.drho.get(end.slots.cell as usize);
        let push = 6.0 * W[i] * density * along;
        let g = self.field.get(end.slots.own(self.parity));
        let near = q < 0.5;
        let fallback = near && (end.is_shut || !end.slots.is_behind_fluid(self.flags));
        if fallback {
            return Read { g, f: g - push };
        }
        let other = self.field.get(end.slots.other(self.parity, near));
        Read { g, f: Bouzidi::at(q).reflect(g, other, push) }
    }

    /// Writes the cut links of an item, after all links were reflected; returns what they
    /// exchanged.
    pub fn write_cuts(&self, body: &Body, cuts: &CutLinks) -> ExchangeTally {
        let mut exchange = ExchangeTally::default();
        let Some(part) = &body.part else { return exchange };
        let nearest = if body.is_part() { 0.0 } else { self.nearest_wall };
        for (ends, read) in cuts.links.iter().zip(&cuts.read) {
            let Some(read) = read else { continue };
            let is_as_read = |(end, read): (&CutEnd, &Read)| {
                self.field.get(end.slots.own(self.parity)) == read.g
            };
            // Else another body's edge has cut it.
            if !ends.iter().zip(read).all(is_as_read) {
                continue;
            }
            for (end, read) in ends.iter().zip(read).take(ends_of(ends)) {
                let f = self.field.set(end.slots.result(self.parity), read.f);
                let (arm, q) = end.now(body, part, nearest);
                let (wall, u) = end.wall(body, arm, q);
                let c = C_F64[usize::from(end.dir)];
                if !self.layout.is_own(end.slots.cell) {
                    continue;
                }
                let mut link = MomentumExchange::default();
                link.add_link(c, [read.g + f, f - read.g], u, wall);
                // Cells on both sides being fluid, the mirror's account holds what it would have
                // turned.
                let turned = |a: usize| if end.mirrors >> a & 1 == 1 { -2.0 * c[a] } else { 0.0 };
                add_scaled(&mut link.unmirrored, std::array::from_fn(turned), read.g);
                exchange.add(&link);
            }
        }
        exchange
    }
}
