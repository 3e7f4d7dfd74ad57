//! Links between two cells of the fluid that sharp edges and thin walls of solids at rest cut.
//!
//! `static_wall_links` reflects each end by itself, as any link at a wall. But what interpolation
//! makes or takes at the one end, it mostly does at the other, and beside an edge that is most (see
//! `cut_links`, of solids that move). A rigid solid displaces nothing along such a link. So what
//! both ends got together is taken from them again, half from each, as `cut_links` says.
//!
//! Force and torque on the solid stay the same. Such links keep the mass, so patches of wall
//! (`wall_mass`) hold none of them. If a body covers one end, the other keeps its mass by itself:
//! it is reflected half-way.
//!
//! Not those that end at an open face, which replaces what its cells hold, nor those at what
//! prescribes a pressure.

use crate::boundary::cut_links::share_of_both;
use crate::boundary::post_collision::PostCollision;
use crate::domain::boundary_condition::BoundaryCondition;
use crate::lattice::aa_pattern::{Blocked, Parity};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C, C_F64, OPPOSITE};
use crate::lattice::layout::{Layout, items_in_blocks};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use std::ops::Range;
use tremie_fluid_kit::cells::grid::Reach;

/// Links that are one item of work at most; their first ends are in one block.
const LINKS_PER_ITEM: usize = 1024;

/// One end of a cut link: a cell, and the direction out of it.
#[derive(Clone, Copy, Debug)]
struct SheetEnd {
    cell: u32,
    /// Place at which the collision leaves `g_i` and the next finds `f_i'`, in either parity: see
    /// `aa_pattern`.
    place: u32,
    dir: u8,
}

/// All such links, by the cell of their first end.
#[derive(Clone, Debug, Default)]
pub struct SheetLinks {
    links: Vec<[SheetEnd; 2]>,
    fixtures: Vec<BoundaryId>,
}

/// Links that are one item of work, and what these exchanged.
#[derive(Clone, Debug, Default)]
pub struct SheetItem {
    links: Range<usize>,
    /// True if this part of the lattice counts the cells of their first ends.
    pub is_own: bool,
    /// The populations `g` at both ends of each; none at an end that is no fluid.
    sent: Vec<[Option<f64>; 2]>,
    /// Exchange of each fixture beyond that of the ends by themselves.
    pub exchanges: Vec<(BoundaryId, MomentumExchange)>,
}

impl SheetLinks {
    /// Of blocked links in the order of cells, with `q` of each; `law_of` says what a fixture
    /// prescribes.
    pub fn new(
        layout: &Layout,
        blocked: &[(Blocked, f64)],
        law_of: impl Fn(BoundaryId) -> Option<BoundaryCondition>,
    ) -> (Self, Vec<SheetItem>) {
        let mut own = Self::default();
        let end = |cell: u32, dir: u8| {
            let place = layout.place(Parity::Even, cell, OPPOSITE[usize::from(dir)]) as u32;
            SheetEnd { cell, place, dir }
        };
        let is_first = |dir: u8| usize::from(dir) < OPPOSITE[usize::from(dir)];
        let candidates =
            blocked.iter().filter(|(met, _)| is_first(met.dir) && layout.is_at_sheet(met.cell));
        for &(Blocked { cell, dir, fixture }, q) in candidates {
            let Some(law @ (BoundaryCondition::Wall { .. } | BoundaryCondition::Velocity { .. })) =
                law_of(fixture)
            else {
                continue;
            };
            let Some(other) = other_end(layout, cell, dir) else { continue };
            let key = |(met, _): &(Blocked, f64)| (met.cell, met.dir);
            let Ok(place) = blocked.binary_search_by_key(&other, key) else { continue };
            let (there, other_q) = &blocked[place];
            let at_open_face = |cell: u32| layout.grid.open_faces(layout.at(cell)).next().is_some();
            if there.fixture != fixture || at_open_face(cell) || at_open_face(other.0) {
                continue;
            }
            // Half-way at both ends makes nothing, unless the wall slides.
            if (q, *other_q) == (0.5, 0.5) && law.is_at_rest() {
                continue;
            }
            own.links.push([end(cell, dir), end(other.0, other.1)]);
            own.fixtures.push(fixture);
        }
        let begins: Vec<u32> = own.links.iter().map(|ends| ends[0].cell).collect();
        let items = items_in_blocks(&begins, LINKS_PER_ITEM);
        let items = items.map(|links| own.item(layout.is_own(begins[links.start]), links));
        let items = items.collect();
        (own, items)
    }

    fn item(&self, is_own: bool, links: Range<usize>) -> SheetItem {
        let sent = vec![[None; 2]; links.len()];
        let mut fixtures = self.fixtures[links.clone()].to_vec();
        fixtures.sort_unstable_by_key(|fixture| fixture.0);
        fixtures.dedup();
        let exchanges = fixtures.into_iter().map(|fixture| (fixture, MomentumExchange::default()));
        SheetItem { links, is_own, sent, exchanges: exchanges.collect() }
    }

    /// Cell and direction of both ends of each, sorted.
    pub fn ends(&self) -> Vec<(u32, u8)> {
        let mut ends: Vec<_> = self.links.iter().flatten().map(|end| (end.cell, end.dir)).collect();
        ends.sort_unstable();
        ends
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        let of_items = size_of::<[Option<f64>; 2]>() * self.links.len();
        size_of_val(self.links.as_slice()) + size_of_val(self.fixtures.as_slice()) + of_items
    }
}

/// Cell at the other end of a cell's link, and the direction from there; of straight links.
fn other_end(layout: &Layout, cell: u32, dir: u8) -> Option<(u32, u8)> {
    let (at, c) = (layout.at(cell), C[usize::from(dir)]);
    match layout.grid.reach(std::array::from_fn(|a| at[a] + c[a])) {
        Reach::Cell { at, mirrors: 0 } => {
            Some((layout.cell(at)?, OPPOSITE[usize::from(dir)] as u8))
        }
        _ => None,
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Reads what the ends of an item's links send, before any is reflected.
    pub fn read_sheets(&self, links: &SheetLinks, item: &mut SheetItem) {
        for (ends, sent) in links.links[item.links.clone()].iter().zip(&mut item.sent) {
            *sent =
                ends.map(|end| self.is_cut(end.cell).then(|| self.field.get(end.place as usize)));
        }
    }

    /// Takes back what both ends of a link got together, after all were reflected.
    pub fn balance_sheets(
        &self,
        links: &SheetLinks,
        references: &[[f64; 3]],
        item: &mut SheetItem,
    ) {
        for (_, exchange) in &mut item.exchanges {
            *exchange = MomentumExchange::default();
        }
        for (k, sent) in item.links.clone().zip(&item.sent) {
            let (ends, fixture) = (&links.links[k], links.fixtures[k]);
            let got = |k: usize| sent[k].map(|g| self.field.get(ends[k].place as usize) - g);
            let share = share_of_both([got(0), got(1)]);
            if share == 0.0 {
                continue;
            }
            let reference = references[usize::from(fixture.0)];
            let of_fixture = item.exchanges.iter_mut().find(|(other, _)| *other == fixture);
            let (_, exchange) = of_fixture.expect("an item lists the fixtures of its links");
            for end in ends.iter().zip(sent).filter_map(|(end, sent)| sent.and(Some(end))) {
                let old = self.field.get(end.place as usize);
                let gain = self.field.set(end.place as usize, old - share) - old;
                let arm = self.layout.grid.arm(reference, self.layout.at(end.cell));
                exchange.add_link(C_F64[usize::from(end.dir)], [gain; 2], [0.0; 3], arm);
            }
        }
    }
}
