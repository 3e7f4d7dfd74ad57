//! Walls that slip in thin gaps.
//!
//! At a small viscosity a gap of a few cells is held up by its walls: half-way reflection stops
//! what moves along them within a step or two, which no boundary layer of the real flow does. In
//! gaps that the scene declares so (`slip_below`), and below a lattice viscosity, links that meet a
//! wall are reflected like light: with `a` the axis nearest to the direction across the gap, `m(i)`
//! the direction `i` mirrored across it, and `t` the part of `c_i` along the wall,
//!
//! ```text
//! f_i'(x_f) = g_m(i')(x_f + t) - 6 w_i rho c_ia u_wa           i' opposite to i, u_w the wall's velocity
//! ```
//!
//! for every pair of links that are each other's image, one of them in the gap, so that no mass is
//! made; any other link stays as it is. It is done after all other reflection, as a correction of
//! what that gave.
//!
//! The link straight at the wall is its own image, and half-way too: between the mirrors,
//! interpolation to the surface feeds the sound across the gap where the last cells are nearly all
//! covered or nearly all free, and as tau comes near to 1/2 nothing damps it. In a gap of one cell
//! it stays interpolated, which damps: a shut valve and its seal would feed the sound in it.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::deformable_shape::{Felt, Hit, NO_FACET};
use crate::boundary::mesh_links::as_seen;
use crate::boundary::post_collision::PostCollision;
use crate::gaps::modelled::ModelledGaps;
use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::{BODY, CellFlags, Owner, SHARED};
use crate::lattice::d3q19::{C, C_F64, MIRROR, OPPOSITE, Q, W, mirrored};
use crate::lattice::layout::Layout;
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::{ExchangeTally, MomentumExchange};
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use tremie_fluid_kit::cells::grid::{Reach, Side};
use tremie_team::Team;

/// Room for links, for each cell: as many as end aslant at one side of a gap and at the other.
const LINKS_PER_CELL: usize = 10;

/// In the order of [`SlipLink::given`] and [`SlipLink::taken`].
const PARITIES: [Parity; 2] = [Parity::Even, Parity::Odd];

/// Whose wall a link meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whose {
    /// A body, by its handle.
    Body(u32),
    /// A fixture.
    Fixture(u16),
}

impl Whose {
    /// As a number, which is the same on all ranks.
    fn number(self) -> u32 {
        match self {
            Self::Fixture(number) => number.into(),
            Self::Body(handle) => 1 << 31 | handle,
        }
    }
}

/// A link that slips.
#[derive(Clone, Copy, Debug)]
struct SlipLink {
    /// Its number among all that an item may have: in the order of its links.
    number: u32,
    cell: u32,
    /// Cell from which the population comes, and its direction there.
    source: u32,
    from: u8,
    dir: u8,
    /// Direction and cell as seen by a body, and the axes at which they are mirrored.
    seen: u8,
    mirrors: u8,
    axis: u8,
    at: [i32; 3],
    whose: Whose,
    /// Place where it meets a deformable surface, as that was when its cells were found.
    hit: Hit,
    /// Places at which even and odd steps leave the population that it takes over, and at which the
    /// steps after them read it.
    given: [u32; 2],
    taken: [u32; 2],
    value: f64,
}

/// Motion of a body's wall where a link meets it.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// From the body's origin to there.
    arm: [f64; 3],
    velocity: [f64; 3],
}

/// Links, and by how much slipping changes what their walls exchanged.
#[derive(Clone, Debug, Default)]
struct SlipItem {
    /// True if this rank counts its cells.
    is_own: bool,
    links: Vec<SlipLink>,
    /// Those of the step before.
    before: Vec<SlipLink>,
    /// For each link how its wall moves in this step, if that is a body's.
    motions: Vec<Motion>,
    exchanges: Vec<(Whose, MomentumExchange)>,
    /// Forces of it on facets of deformable surfaces, with the handle of the body.
    felt: Vec<(u32, Felt)>,
}

/// All links that slip, in items as the cells of gaps.
#[derive(Clone, Debug, Default)]
pub struct SpecularWalls {
    items: Vec<SlipItem>,
    /// By cell, whether links depend on whose it is.
    matters: Vec<bool>,
    /// By cell, whether its links are to be found anew, and which cells those are.
    is_stale: Vec<bool>,
    stale: Vec<u32>,
    /// True if links were found at all.
    is_found: bool,
    /// What slipping added to the exchange of each wall in the last step, by the wall's number; of all ranks.
    totals: Vec<(u32, ExchangeTally)>,
}

impl SpecularWalls {
    /// None yet, in the cells that may be in gaps.
    pub fn in_gaps(gaps: &ModelledGaps, layout: &Layout) -> Self {
        let cells = layout.cells.len();
        let mut matters = vec![false; cells];
        for cell in gaps.items().enumerate().flat_map(|(item, _)| gaps.cells_of(item)) {
            around(layout, cell).for_each(|near| matters[near as usize] = true);
        }
        let is_own =
            |item: usize| gaps.cells_of(item).next().is_some_and(|cell| layout.is_own(cell));
        let item = |(number, cells): (usize, usize)| SlipItem {
            is_own: is_own(number),
            links: Vec::with_capacity(cells * LINKS_PER_CELL),
            before: Vec::with_capacity(cells * LINKS_PER_CELL),
            motions: Vec::with_capacity(cells * LINKS_PER_CELL),
            exchanges: Vec::with_capacity(8),
            felt: Vec::with_capacity(cells * LINKS_PER_CELL),
        };
        Self {
            items: gaps.items().enumerate().map(item).collect(),
            matters,
            is_stale: vec![false; cells],
            stale: Vec::with_capacity(cells),
            is_found: false,
            totals: Vec::new(),
        }
    }

    /// Finds the links: of all cells if parts have moved, else of those around which cells changed
    /// hands.
    pub fn find(
        &mut self,
        gaps: &ModelledGaps,
        bodies: &Bodies,
        flags: &CellFlags,
        layout: &Layout,
        team: &mut Team,
    ) {
        let is_new = !std::mem::replace(&mut self.is_found, true) || bodies.parts_moved();
        if !is_new {
            self.mark(flags, layout);
        }
        if !is_new && self.stale.is_empty() {
            return;
        }
        let is_stale = &self.is_stale;
        team.for_each(&mut self.items, |number, item| {
            if !is_new && !gaps.cells_of(number).any(|cell| is_stale[cell as usize]) {
                return;
            }
            std::mem::swap(&mut item.links, &mut item.before);
            item.links.clear();
            // Both lists are in the order of numbers: links of cells that are not stale are taken
            // over in one pass.
            let mut known = item.before.iter().filter(|_| !is_new).peekable();
            for (k, cell) in gaps.cells_of(number).enumerate() {
                let (first, end) = ((k * 2 * Q) as u32, ((k + 1) * 2 * Q) as u32);
                while known.next_if(|link| link.number < first).is_some() {}
                if !is_new && !is_stale[cell as usize] {
                    while let Some(&link) = known.next_if(|link| link.number < end) {
                        item.links.push(link);
                    }
                } else if let Some(axis) = gaps.slips_at(cell).filter(|_| flags.is_fluid(cell)) {
                    let site = SlipSite { gaps, bodies, flags, layout, inside: cell, first };
                    let begin = item.links.len();
                    site.find(axis, &mut item.links);
                    // A surface may have moved since its cells were found: a link that was there
                    // keeps its place on it.
                    for link in &mut item.links[begin..] {
                        while known.next_if(|before| before.number < link.number).is_some() {}
                        link.hit = known
                            .peek()
                            .filter(|before| before.is_same(link))
                            .map_or_else(|| link.meet(bodies, layout), |before| before.hit);
                    }
                }
            }
        });
        for cell in self.stale.drain(..) {
            self.is_stale[cell as usize] = false;
        }
    }

    /// Marks the cells whose links may differ since cells changed hands: those around them.
    fn mark(&mut self, flags: &CellFlags, layout: &Layout) {
        for &cell in flags.changed().iter().filter(|&&cell| self.matters[cell as usize]) {
            for near in around(layout, cell) {
                if !std::mem::replace(&mut self.is_stale[near as usize], true) {
                    self.stale.push(near);
                }
            }
        }
    }

    /// Reads what slips, before anything is reflected.
    pub fn read<T: Real>(&mut self, after: &PostCollision<T>, bodies: &Bodies, team: &mut Team) {
        team.for_each(&mut self.items, |_, item| {
            item.motions.clear();
            for link in &mut item.links {
                let mut motion = Motion::default();
                let push = match link.whose {
                    Whose::Fixture(_) => 0.0,
                    Whose::Body(handle) => {
                        let (axis, i) = (usize::from(link.axis), usize::from(link.seen));
                        let body = bodies.with_handle(handle);
                        let arm = link.arm(body, after.layout);
                        motion = Motion { arm, velocity: body.velocity_of(link.hit, arm) };
                        let u = motion.velocity;
                        // With what it pays back, see `mass_correction`.
                        let given = || after.gaps.sinks.at(link.cell).map_or(0.0, |(_, rate)| rate);
                        let paid = if after.keeps_mass { body.account.pay - given() } else { 0.0 };
                        let rho = 1.0 + after.drho.get(link.cell as usize);
                        6.0 * W[i] * rho * (C_F64[i][axis] * u[axis] - paid)
                    }
                };
                link.value = after.field.get(link.given[after.parity as usize] as usize) - push;
                item.motions.push(motion);
            }
        });
    }

    /// Puts it where it belongs, after everything is reflected.
    pub fn write<T: Real>(
        &mut self,
        after: &PostCollision<T>,
        references: &[[f64; 3]],
        (team, ranks): (&mut Team, &mut Ranks),
    ) {
        team.for_each(&mut self.items, |_, item| {
            item.exchanges.clear();
            item.felt.clear();
            for (link, motion) in item.links.iter().zip(&item.motions) {
                let place = link.taken[after.parity as usize] as usize;
                let old = after.field.get(place);
                // `set` returns the number as stored, so that the balance counts what the field
                // holds.
                let gain = after.field.set(place, link.value) - old;
                if !item.is_own {
                    continue;
                }
                let known = item.exchanges.iter().position(|(whose, _)| *whose == link.whose);
                let known = known.unwrap_or_else(|| {
                    item.exchanges.push((link.whose, MomentumExchange::default()));
                    item.exchanges.len() - 1
                });
                let exchange = &mut item.exchanges[known].1;
                match link.whose {
                    Whose::Fixture(number) => {
                        let force = C_F64[usize::from(link.dir)].map(|c| gain * c);
                        let reference = references[usize::from(number)];
                        let arm = after.layout.grid.arm(reference, link.begin(after.layout));
                        exchange.add_force(force, arm);
                    }
                    Whose::Body(handle) => {
                        let Motion { arm, velocity } = *motion;
                        let force = give(exchange, link, gain, arm, velocity);
                        if link.hit.facet != NO_FACET {
                            let facet = link.hit.facet;
                            let felt = Felt { facet, gap: Felt::FLUID, force, at: arm };
                            item.felt.push((handle, felt));
                        }
                    }
                }
                exchange.mass += gain;
            }
        });
        self.add_up(ranks);
    }

    /// Adds up what slipping changed.
    fn add_up(&mut self, ranks: &mut Ranks) {
        let Self { items, totals, .. } = self;
        totals.clear();
        for (whose, exchange) in items.iter().flat_map(|item| &item.exchanges) {
            let key = whose.number();
            let place = totals.binary_search_by_key(&key, |total| total.0);
            let place = place.unwrap_or_else(|place| {
                totals.insert(place, (key, ExchangeTally::default()));
                place
            });
            totals[place].1.add(exchange);
        }
        ranks.join_keyed(totals);
    }

    /// Exchange that slipping adds to a body's.
    pub fn on_body(&self, handle: u32) -> MomentumExchange {
        self.on(Whose::Body(handle))
    }

    /// Exchange that slipping adds to a fixture's.
    pub fn on_fixture(&self, number: usize) -> MomentumExchange {
        self.on(Whose::Fixture(number as u16))
    }

    /// Forces that slipping gave to facets of a deformable surface.
    pub fn on_facets(&self, handle: u32) -> impl Iterator<Item = &Felt> {
        let all = self.items.iter().flat_map(|item| &item.felt);
        all.filter(move |(whose, _)| *whose == handle).map(|(_, felt)| felt)
    }

    fn on(&self, wanted: Whose) -> MomentumExchange {
        let found = self.totals.binary_search_by_key(&wanted.number(), |total| total.0);
        found.map_or_else(|_| MomentumExchange::default(), |place| self.totals[place].1.value())
    }
}

/// A cell and the stored cells next to it, over corners too.
fn around(layout: &Layout, cell: u32) -> impl Iterator<Item = u32> {
    let at = layout.at(cell);
    let near = move |k| layout.near(at, [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    (0..27).filter_map(near).map(|(near, _)| near)
}

impl SlipLink {
    /// True if this is the link of the step before.
    fn is_same(&self, now: &Self) -> bool {
        (self.number, self.whose) == (now.number, now.whose)
    }

    /// Coordinates of the cell where it begins.
    fn begin(&self, layout: &Layout) -> [i32; 3] {
        if self.mirrors == 0 { self.at } else { layout.at(self.cell) }
    }

    /// Place where it meets a deformable surface.
    fn meet(&self, bodies: &Bodies, layout: &Layout) -> Hit {
        let Whose::Body(handle) = self.whose else { return Hit::NONE };
        let body = bodies.with_handle(handle);
        body.hit_near(self.arm(body, layout))
    }

    /// Place where it meets a body, half-way, seen from the body's origin.
    fn arm(&self, body: &Body, layout: &Layout) -> [f64; 3] {
        let (arm, c) = (layout.grid.arm(body.position, self.at), C_F64[usize::from(self.seen)]);
        std::array::from_fn(|a| arm[a] + 0.5 * c[a])
    }
}

/// Adds the Galilean-invariant exchange of a link whose reflected population grew by `gain`;
/// returns the force.
fn give(
    exchange: &mut MomentumExchange,
    link: &SlipLink,
    gain: f64,
    arm: [f64; 3],
    u: [f64; 3],
) -> [f64; 3] {
    let c = C_F64[usize::from(link.seen)];
    let force: [f64; 3] = std::array::from_fn(|a| gain * (c[a] + u[a]));
    exchange.add_force(force, arm);
    add_scaled(&mut exchange.swept, u, gain);
    for a in (0..3).filter(|a| link.mirrors >> a & 1 == 1) {
        exchange.image[a] += 2.0 * force[a];
        exchange.image_swept[a] += 2.0 * gain * u[a];
    }
    force
}

/// Surroundings in which links that slip are searched.
#[derive(Clone, Copy)]
struct SlipSite<'a> {
    gaps: &'a ModelledGaps,
    bodies: &'a Bodies,
    flags: &'a CellFlags,
    layout: &'a Layout,
    /// A cell of the gap in question, and the number of its first link.
    inside: u32,
    first: u32,
}

impl SlipSite<'_> {
    /// Lists the links of its cell, and their images.
    fn find(&self, axis: usize, links: &mut Vec<SlipLink>) {
        for i in (1..Q).filter(|&i| C[i][axis] != 0) {
            let number = self.first + 2 * i as u32;
            let Some(link) = self.link(self.inside, i, axis) else { continue };
            links.push(SlipLink { number, ..link });
            // At the end of a gap the image begins outside.
            let (source, from) = (link.source, usize::from(link.from));
            if self.gaps.slips_at(source) != Some(axis) {
                let image = self.link(source, from, axis);
                links.extend(image.map(|link| SlipLink { number: number + 1, ..link }));
            }
        }
    }

    /// The link `i` of a cell, if it and its image slip.
    fn link(&self, cell: u32, i: usize, axis: usize) -> Option<SlipLink> {
        let whose = self.whose(cell, i)?;
        let at = self.layout.at(cell);
        // Specular reflection keeps the motion along the wall: the population comes from there.
        let mut along = C[i];
        along[axis] = 0;
        if along == [0; 3] && self.gaps.is_one_cell(self.inside) {
            return None;
        }
        let (source, mirrors) = self.layout.near(at, along)?;
        let from = mirrored(MIRROR[axis][OPPOSITE[i]], mirrors);
        if !self.flags.is_fluid(source) || self.whose(source, from).is_none() {
            return None;
        }
        let mirrors = self.layout.grid.mirrors_to(std::array::from_fn(|a| at[a] + C[i][a]));
        let (at, seen) = as_seen(&self.layout.grid, at, i, mirrors);
        let place = |parity, cell, i| self.layout.place(parity, cell, i) as u32;
        Some(SlipLink {
            number: self.first,
            cell,
            source,
            from: from as u8,
            dir: i as u8,
            seen: seen as u8,
            mirrors,
            axis: axis as u8,
            at,
            whose,
            hit: Hit::NONE,
            given: PARITIES.map(|parity| place(parity, source, OPPOSITE[from])),
            taken: PARITIES.map(|parity| place(parity.flipped(), cell, OPPOSITE[i])),
            value: 0.0,
        })
    }

    /// Whose wall a link meets; `None` if it is no wall that slips, such as a sphere in the gap.
    fn whose(&self, cell: u32, i: usize) -> Option<Whose> {
        let still = || {
            let at = self.layout.at(cell);
            let end = self.layout.grid.reach(std::array::from_fn(|a| at[a] + C[i][a]));
            if let Reach::Face { axis, side } = end
                && self.layout.grid.sides[axis][side] != Side::Wall
            {
                return None;
            }
            // A cell beside the gap counts for the one that it is beside.
            let still = |cell| self.gaps.still_side_at(cell);
            let number = still(cell).or_else(|| still(self.inside)).unwrap_or_default();
            Some(Whose::Fixture(number as u16))
        };
        let Some(end) = self.layout.neighbour(cell, i) else { return still() };
        let owner: Owner = self.flags.of(end);
        let is_side = |handle: &u32| self.gaps.is_side_at(self.inside, self.bodies, *handle);
        match owner {
            SHARED => self.flags.claimants(end).find(is_side).map(Whose::Body),
            owner => owner.checked_sub(BODY).filter(is_side).map(Whose::Body),
        }
    }
}
