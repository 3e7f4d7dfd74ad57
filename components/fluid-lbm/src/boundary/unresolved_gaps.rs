//! Gaps too narrow to hold a cell, and the pressure in them: `gap_pressure`.
//!
//! A body may be so near to a wall, a part or another body that the cells of the one adjoin those
//! of the other. It has no links there, and nothing would press on it. A *gap link* goes from a
//! cell that a body covers to a neighbour that is covered by something else, or is a wall's, or is
//! frozen because no neighbour is fluid. It counts where the two surfaces, met on that link, are
//! apart by more than [`CONTACT`]; surfaces in contact press on each other and the fluid on
//! neither. A gap link of direction `i` into the body gives it what a link would, `2 w_i drho c_i`
//! at its surface, so that a flat face feels pressure times area.
//!
//! All gap links between the same two make one gap with one pressure: the mean over the fluid cells
//! next to the covered cells where its links begin, counted once for each link that sees them; both
//! bodies' cells in a gap between two. A closed gap that parts two chambers so has the mean of the
//! two, weighted by the cells that see it. A gap that sees no fluid takes the mean over the body's
//! others; one without these is at gauge pressure zero. A body in a mirror counts as another. A
//! part that stands still feels the opposite of what the body feels; between two parts that stand
//! still there are no gap links.
//!
//! Gaps that the scene declares have a pressure of their own, by rule, and their cells may be
//! frozen: see `modelled`. A link into such a cell is a gap link as wide as a cell.
//!
//! Gap links between a moving part and what stands still are found with its other links, and follow
//! its motion as they do (see `mesh_links`); the others are found in each step.
//!
//! The force is that of a fluid that is not simulated: the ledger lists it by itself, as
//! `unresolved_gaps`.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::deformable_shape::{Felt, NO_FACET};
use crate::bodies::sphere_raster::{inside, wall_distance};
use crate::boundary::gap_sinks::Given;
use crate::boundary::post_collision::PostCollision;
use crate::boundary::wall_distances::WallDistances;
use crate::lattice::cell_flags::{BODY, FLUID, FROZEN, ISOLATED, SHARED, VACATED};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C, C_F64, OPPOSITE, Q, W, cross, mirrored};
use crate::lattice::exact_sum::BinnedSum;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use tremie_fluid_kit::cells::grid::{Grid, Reach, Side};
use tremie_fluid_kit::survey::mirrors::mirrors_of_part;

/// Surfaces nearer than this part of a link are in contact.
pub const CONTACT: f64 = 1e-3;

/// Gaps of an item for which there is room from the start.
const ROOM: usize = 24;

/// The weight `2 w_i` of a direction along two axes; that of one along one axis is twice as much.
pub const FORCE_UNIT: f64 = 1.0 / 18.0;

/// Other side of a gap: a fixture, a body's handle beyond [`OtherSide::BODIES`], or a frozen cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct OtherSide(u32);

impl OtherSide {
    const BODIES: u32 = 1 << 31;
    /// A frozen cell.
    pub const FROZEN: Self = Self(1 << 30);
    /// Of a gap that the scene declares, by its number beyond this.
    const DECLARED: u32 = 1 << 28;
    /// Of a body's image in a mirror.
    const IMAGE: u32 = 1 << 29;

    fn body(handle: u32, is_image: bool) -> Self {
        Self(Self::BODIES + handle + if is_image { Self::IMAGE } else { 0 })
    }

    /// Body with `handle` as this side sees it across the gap: as an image if this is one.
    pub fn seen_back(self, handle: u32) -> Self {
        Self::body(handle, self.0 & Self::IMAGE != 0)
    }

    fn fixture(BoundaryId(number): BoundaryId) -> Self {
        Self(number.into())
    }

    /// As a number, which is the same on all ranks.
    pub fn number(self) -> u32 {
        self.0
    }

    /// That of a number.
    pub fn numbered(number: u32) -> Self {
        Self(number)
    }

    /// A gap that the scene declares.
    pub fn declared(gap: u16) -> Self {
        Self(Self::DECLARED + u32::from(gap))
    }

    /// The number of the fixture, if it is one.
    pub fn as_fixture(self) -> Option<usize> {
        (self.0 < Self::DECLARED).then_some(self.0 as usize)
    }

    /// The number of the gap, if the scene declares it.
    pub fn as_declared(self) -> Option<u16> {
        let is_one = (Self::DECLARED..Self::IMAGE).contains(&self.0);
        is_one.then(|| (self.0 - Self::DECLARED) as u16)
    }

    /// The handle of the body, if it is one.
    pub fn as_body(self) -> Option<u32> {
        self.0.checked_sub(Self::BODIES).map(|handle| handle & !Self::IMAGE)
    }
}

/// A link that may be a gap link: all that stands still of it.
#[derive(Clone, Copy, Debug)]
pub struct GapLink {
    /// Cell where it begins, as seen from the body.
    at: [i32; 3],
    dir: u8,
    /// Cell where it ends, which the body covers.
    pub cell: u32,
    begin: Begin,
}

impl GapLink {
    /// From a stored cell at `at` in the direction `dir`, through no mirror, to a covered one.
    pub fn between(at: [i32; 3], dir: u8, begin: u32, end: u32) -> Self {
        Self { at, dir, cell: end, begin: Begin::Stored { cell: begin, mirrors: 0 } }
    }
}

/// Distance of a part along a gap link from the link's end, found by a search in its surface. It
/// holds as long as the part's cells are where they were found.
#[derive(Clone, Copy, Debug, Default)]
pub struct MetInGap {
    /// The part, and its search.
    of: Option<(u64, u64)>,
    distance: f64,
}

/// Kind of the cell where a gap link begins.
#[derive(Clone, Copy, Debug)]
enum Begin {
    /// A solid at rest, and the distance of its surface from the covered cell.
    Still { across: OtherSide, distance: f64 },
    /// A stored cell, through a mirror at some axes.
    Stored { cell: u32, mirrors: u8 },
}

impl MetInGap {
    /// The distance of a body, found anew unless it is that of a part which is known.
    fn of(&mut self, other: &Body, find: impl FnOnce() -> f64) -> f64 {
        let Some(part) = &other.part else { return find() };
        let of = Some((other.id, part.search()));
        if self.of != of {
            *self = Self { of, distance: find() };
        }
        self.distance
    }
}

/// A gap, or the part of it that an item of links found.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Other side of the gap.
    pub across: OtherSide,
    /// Sum over the fluid cells next to it of the density minus 1, and their number.
    pub drho: BinnedSum,
    /// See there.
    pub cells: u32,
    /// Force on the body for each unit of `drho` [[`FORCE_UNIT`]].
    pub force: [i32; 3],
    /// Torque, likewise.
    pub torque: [BinnedSum; 3],
}

/// The gaps of an item of links.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    pub list: Vec<Gap>,
    /// Forces on facets of a deformable surface, of gaps and of the fluid.
    pub felt: Vec<Felt>,
    /// Volume by which the body receded from each gap that the scene declares.
    pub drawn: Vec<BinnedSum>,
    /// Sums of the links that gave to each intake of those gaps.
    pub given: Vec<Given>,
}

impl Gap {
    fn new(across: OtherSide) -> Self {
        let (drho, torque) = (BinnedSum::default(), [BinnedSum::default(); 3]);
        Self { across, drho, cells: 0, force: [0; 3], torque }
    }

    /// Adds a fluid cell next to it.
    #[inline]
    pub fn see(&mut self, drho: f64) {
        self.drho.add(drho);
        self.cells += 1;
    }
}

impl Gaps {
    /// None, with room for those of an item, and for gaps that the scene declares and their
    /// intakes.
    pub fn with_room(declared: usize, intakes: usize) -> Self {
        Self {
            list: Vec::with_capacity(ROOM),
            felt: Vec::new(),
            drawn: vec![BinnedSum::default(); declared],
            given: vec![Given::default(); intakes],
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.list.clear();
        self.felt.clear();
        self.drawn.fill(BinnedSum::default());
        self.given.fill(Given::default());
    }

    /// Adds what the gap link `i` gives that leads from `arm`, seen from the body, to its surface
    /// at `q`, there being `facet` if it can deform. Returns the gap.
    pub fn add(
        &mut self,
        across: OtherSide,
        arm: [f64; 3],
        (i, q): (usize, f64),
        facet: u32,
    ) -> &mut Gap {
        let (place, c) = (self.place(across), C_F64[i]);
        let at = std::array::from_fn(|a| arm[a] + q * c[a]);
        let force = c.map(|c| 2.0 * W[i] * c);
        if facet != NO_FACET {
            self.felt.push(Felt { facet, gap: place as u16, force, at });
        }
        let gap = &mut self.list[place];
        // 2 w_i is 1/9 along an axis and 1/18 aslant.
        let weight = if C[i].iter().map(|c| c * c).sum::<i32>() == 1 { 2 } else { 1 };
        for (a, torque) in cross(at, force).into_iter().enumerate() {
            gap.force[a] += weight * C[i][a];
            gap.torque[a].add(torque);
        }
        gap
    }

    /// Counts a volume by which the body recedes from a gap that the scene declares.
    pub fn draw(&mut self, gap: u16, volume: f64) {
        self.drawn[usize::from(gap)].add(volume);
    }

    /// Place of the gap to something.
    fn place(&mut self, across: OtherSide) -> usize {
        let place = self.list.iter().position(|gap| gap.across == across);
        place.unwrap_or_else(|| {
            self.list.push(Gap::new(across));
            self.list.len() - 1
        })
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Finds the gap links between a body and what is in mirrors, and, for a sphere, the walls of
    /// the domain.
    pub fn gaps_at_faces(
        &self,
        bodies: &Bodies,
        body: &Body,
        walls: &WallDistances,
        gaps: &mut Gaps,
    ) {
        let grid = &self.layout.grid;
        // A part on a mirror is its own image.
        let own_image = mirrors_of_part(grid, body.position);
        let is_wanted = |axis: usize, side: usize| match grid.sides[axis][side] {
            Side::Wall => body.part.is_none(),
            Side::Symmetry => body.part.is_none() || !own_image[axis],
            Side::Periodic | Side::Open => false,
        };
        each_beyond(grid, body, is_wanted, |at, i| {
            // A part's links to what stands still, and into frozen cells, are known.
            let is_known = body.part.is_some()
                && match beyond(self.layout, at) {
                    Beyond::Stored { cell, .. } => self.flags.of(cell) == FROZEN,
                    Beyond::BoundaryId(_) | Beyond::Open => true,
                };
            if !is_known {
                self.gap(bodies, body, walls, at, i, gaps);
            }
        });
    }

    /// Records the gap link `i` that leads from `at`, as seen from the body, into the body, if it
    /// is one.
    pub fn gap(
        &self,
        bodies: &Bodies,
        body: &Body,
        walls: &WallDistances,
        at: [i32; 3],
        i: usize,
        gaps: &mut Gaps,
    ) {
        if let Some(link) = self.gap_link(walls, at, i) {
            self.gap_met((bodies, body), &link, None, gaps);
        }
    }

    /// The same of a link of which it is known where it meets the body, if that is a part: after
    /// what part, and on which facet.
    pub fn gap_met(
        &self,
        (bodies, body): (&Bodies, &Body),
        link: &GapLink,
        meeting: Option<(f64, u32)>,
        gaps: &mut Gaps,
    ) {
        let cell = link.cell;
        let met = &mut MetInGap::default();
        if let Some(gap) = self.press((bodies, body), link, (meeting, met), gaps) {
            for next in self.layout.places.neighbours(cell) {
                if self.flags.is_fluid(next) {
                    gap.see(self.drho.get(next as usize));
                }
            }
        }
    }

    /// The same of a link into the sphere that is known with all fluid cells next to its end.
    pub fn gap_seen(
        &self,
        bodies: &Bodies,
        body: &Body,
        (link, met): (&GapLink, &mut MetInGap),
        witnesses: &[u32],
        gaps: &mut Gaps,
    ) {
        if let Some(gap) = self.press((bodies, body), link, (None, met), gaps) {
            witnesses.iter().for_each(|&cell| gap.see(self.drho.get(cell as usize)));
        }
    }

    /// The link `i` from `at` to a stored cell, if it can be a gap link.
    pub fn gap_link(&self, walls: &WallDistances, at: [i32; 3], i: usize) -> Option<GapLink> {
        let grid = &self.layout.grid;
        let own = std::array::from_fn(|a| grid.wrap(a, at[a] + C[i][a]));
        let cell = grid.contains(own).then(|| self.layout.cell(own)).flatten()?;
        let begin = match beyond(self.layout, at) {
            Beyond::Open => return None,
            Beyond::BoundaryId(face) => {
                let (across, distance) = fixture(walls, face, cell, i)?;
                Begin::Still { across, distance }
            }
            Beyond::Stored { cell, mirrors } => Begin::Stored { cell, mirrors },
        };
        Some(GapLink { at, dir: i as u8, cell, begin })
    }

    /// Records that a gap link presses on the body, if it does. Returns the gap.
    fn press<'g>(
        &self,
        (bodies, body): (&Bodies, &Body),
        link: &GapLink,
        (meeting, met): (Option<(f64, u32)>, &mut MetInGap),
        gaps: &'g mut Gaps,
    ) -> Option<&'g mut Gap> {
        if !self.layout.is_own(link.cell) {
            return None;
        }
        let (at, i) = (link.at, usize::from(link.dir));
        let c = C_F64[i];
        let arm = std::array::from_fn(|a| f64::from(at[a]) + 0.5 - body.position[a]);
        let (q, facet) = match &body.part {
            None if inside(arm, body.r2()) => return None,
            None => (wall_distance(arm, c, body.r2()), NO_FACET),
            Some(part) => meeting.unwrap_or_else(|| part.meet_facet(at, C[i])),
        };
        let (across, far) = self.across(bodies, body, link, met)?;
        // Both as seen from the covered cell.
        if far - (1.0 - q) <= CONTACT {
            return None;
        }
        Some(gaps.add(across, arm, (i, q), facet))
    }

    /// Other side at a link's beginning, and the distance of its surface from the covered cell on
    /// the link. `None` if both belong to one body or to bonded ones, or if the beginning is fluid.
    fn across(
        &self,
        bodies: &Bodies,
        body: &Body,
        link: &GapLink,
        met: &mut MetInGap,
    ) -> Option<(OtherSide, f64)> {
        let GapLink { at, cell, .. } = *link;
        let (grid, i) = (&self.layout.grid, usize::from(link.dir));
        let back = OPPOSITE[i];
        let (other, mirrors) = match link.begin {
            Begin::Still { across, distance } => return Some((across, distance)),
            Begin::Stored { cell, mirrors } => (cell, mirrors),
        };
        // An image is met where the other is met from the covered cell's image.
        let is_image = mirrors != 0;
        let from: [i32; 3] = std::array::from_fn(|a| {
            let k = at[a] + C[i][a];
            match mirrors >> a & 1 {
                0 => k,
                _ if at[a] < k => -1 - k,
                _ => 2 * grid.n[a] - 1 - k,
            }
        });
        let arm = std::array::from_fn(|a| f64::from(from[a]) + 0.5 - body.position[a]);
        let of_body = |handle: u32| {
            let both = !is_image
                && self.flags.of(cell) == SHARED
                && self.flags.claimants(cell).any(|claimant| claimant == handle);
            let (other, back) = (bodies.with_handle(handle), mirrored(back, mirrors));
            let distance =
                if both { 0.0 } else { met.of(other, || self.distance(body, other, arm, back)) };
            (OtherSide::body(handle, is_image), distance)
        };
        // A surface is bonded to the part that carries it.
        let is_apart = |handle: u32| !body.is_bonded_to(bodies.with_handle(handle));
        match self.flags.of(other) {
            FLUID | VACATED => None,
            ISOLATED | FROZEN => Some((OtherSide::FROZEN, 1.0)),
            SHARED => {
                let all = self.flags.claimants(other);
                let all = all.filter(|&handle| is_image || handle != body.handle);
                let all = all.filter(|&handle| is_apart(handle));
                all.map(of_body).min_by(|a, b| a.1.total_cmp(&b.1))
            }
            owner => Some(owner - BODY).filter(|&handle| is_apart(handle)).map(of_body),
        }
    }
}

/// Kind of a cell that may lie beyond a face.
pub enum Beyond {
    /// A wall of the domain or, without one, a static solid.
    BoundaryId(Option<BoundaryId>),
    /// A stored cell, through a mirror at some axes.
    Stored { cell: u32, mirrors: u8 },
    /// Beyond an open face.
    Open,
}

pub fn beyond(layout: &Layout, at: [i32; 3]) -> Beyond {
    match layout.grid.reach(at) {
        Reach::Face { axis, side } if layout.grid.sides[axis][side] == Side::Wall => {
            Beyond::BoundaryId(Some(BoundaryId::face(axis, side)))
        }
        Reach::Face { .. } => Beyond::Open,
        Reach::Cell { at, mirrors } => match layout.cell(at) {
            Some(cell) => Beyond::Stored { cell, mirrors },
            None => Beyond::BoundaryId(None),
        },
    }
}

/// Fixture at the start of the link `i` into the covered cell `cell`, a face or the solid that is
/// met, and its distance from that cell.
pub fn fixture(
    walls: &WallDistances,
    face: Option<BoundaryId>,
    cell: u32,
    i: usize,
) -> Option<(OtherSide, f64)> {
    if let Some(face) = face {
        return Some((OtherSide::fixture(face), 0.5));
    }
    let (met, distance) = walls.meet(cell, OPPOSITE[i])?;
    Some((OtherSide::fixture(met), distance))
}

/// Calls `visit` with each cell beyond a wanted face that is next to one that a body covers, and
/// the direction from it to that.
pub fn each_beyond(
    grid: &Grid,
    body: &Body,
    is_wanted: impl Fn(usize, usize) -> bool,
    mut visit: impl FnMut([i32; 3], usize),
) {
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let x = body.position[axis];
        let far = [x, f64::from(grid.n[axis]) - x][side] - body.radius > 1.0;
        if !is_wanted(axis, side) || far {
            continue;
        }
        let ([b, c], layer) = ([(axis + 1) % 3, (axis + 2) % 3], [0, grid.n[axis] - 1][side]);
        let outward = [-1, 1][side];
        for k in range(grid, body, c) {
            for j in range(grid, body, b) {
                let mut at = [layer; 3];
                (at[b], at[c]) = (j, k);
                if !body.covers(at) {
                    continue;
                }
                for i in (1..Q).filter(|&i| C[i][axis] == outward) {
                    let beyond = std::array::from_fn(|a| at[a] + C[i][a]);
                    // At edges the face that the link meets, and of mirrors the first.
                    let is_here = match grid.reach(beyond) {
                        Reach::Face { axis: a, side: s } => (a, s) == (axis, side),
                        Reach::Cell { mirrors, .. } => mirrors.trailing_zeros() == axis as u32,
                    };
                    if is_here {
                        visit(beyond, OPPOSITE[i]);
                    }
                }
            }
        }
    }
}

/// Cells along an axis that a body may cover, in the box unless that wraps around.
fn range(grid: &Grid, body: &Body, axis: usize) -> std::ops::RangeInclusive<i32> {
    let first = (body.position[axis] - body.radius).floor() as i32 - 1;
    let last = (body.position[axis] + body.radius).floor() as i32 + 1;
    if grid.periodic[axis] { first..=last } else { first.max(0)..=last.min(grid.n[axis] - 1) }
}
