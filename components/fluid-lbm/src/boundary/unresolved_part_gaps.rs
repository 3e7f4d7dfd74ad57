//! Gap links between a moving part and what stands still: found with the part's other links, and
//! used until it has moved by a step. See `unresolved_gaps` for what they are and `mesh_links` for
//! how they follow.

use crate::bodies::body::Body;
use crate::bodies::deformable_shape::Hit;
use crate::bodies::mesh_body::{MeshBody, NearFacets};
use crate::boundary::link_batch::BatchLink;
use crate::boundary::mesh_links::{LinkSearch, recession, wall_velocity};
use crate::boundary::population_addresses::PopulationAddresses;
use crate::boundary::post_collision::PostCollision;
use crate::boundary::unresolved_gaps::{
    Beyond, CONTACT, Gaps, OtherSide, beyond, each_beyond, fixture,
};
use crate::boundary::wall_distances::WallDistances;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C, Q, dot};
use crate::lattice::populations::Real;
use tremie_fluid_kit::cells::grid::Side;

/// A gap link between a moving part and what stands still, as it was when it was found.
#[derive(Clone, Copy, Debug)]
struct PartGapLink {
    across: OtherSide,
    /// The cell where it ends, which the part covers.
    cell: u32,
    dir: u8,
    /// The cell where it begins, as seen from the body.
    at: [i32; 3],
    /// Wall distance to the part, its gradient by the part's motion, and the width of the gap.
    q: f64,
    slope: [f32; 3],
    width: f64,
    /// End of its witnesses in the list; they begin where those of the link before end.
    end: u32,
}

/// The gap links between an item of a moving part and what stands still.
#[derive(Clone, Debug, Default)]
pub struct GapLinks {
    links: Vec<PartGapLink>,
    /// Cells whose density, where they are fluid, is that of the gap.
    witnesses: Vec<u32>,
    /// For each link where it meets a surface that can deform; none for rigid parts.
    hits: Vec<Hit>,
}

impl GapLinks {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.links.clear();
        self.hits.clear();
        self.witnesses.clear();
    }

    /// Room for half as many more.
    pub fn make_room(&mut self) {
        self.links.reserve(self.links.len() / 2 + 64);
        self.hits.reserve(self.hits.len() / 2);
        self.witnesses.reserve(self.witnesses.len() / 2 + 64);
    }

    /// Number of the links.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Cells whose densities are needed.
    pub fn witnesses(&self) -> impl Iterator<Item = u32> {
        self.witnesses.iter().copied()
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Records a part's link into a frozen cell of a declared gap.
    pub fn press_frozen(&self, gap: u16, link: &BatchLink, facet: u32, gaps: &mut Gaps) {
        gaps.add(OtherSide::declared(gap), link.arm, (link.seen.into(), link.q), facet);
    }

    /// Records the gap links between a part and what stands still, and the volume by which the part
    /// recedes from declared gaps, as far as it is not in contact: there is no fluid to draw in or
    /// to press out.
    pub fn press_on(&self, body: &Body, part: &MeshBody, list: &GapLinks, gaps: &mut Gaps) {
        let mut first = 0;
        for (k, link) in list.links.iter().enumerate() {
            let hit = list.hits.get(k).copied().unwrap_or(Hit::NONE);
            let witnesses = &list.witnesses[first..link.end as usize];
            first = link.end as usize;
            let arm = std::array::from_fn(|a| f64::from(link.at[a]) + 0.5 - body.position[a]);
            let by = dot(link.slope.map(f64::from), part.drift_of(hit, arm));
            let width = link.width + by;
            if !self.layout.is_own(link.cell) {
                continue;
            }
            if let Some(gap) = link.across.as_declared() {
                let (dir, q) = (link.dir, link.q + by);
                let now =
                    BatchLink { slots: PopulationAddresses::NONE, seen: dir, mirrors: 0, arm, q };
                let velocity = wall_velocity(body, &now, hit);
                let wider = dot(link.slope.map(f64::from), velocity);
                gaps.draw(gap, recession(&now, velocity) * part_apart(width, wider));
            }
            // In contact there is no fluid to press.
            if width <= CONTACT {
                continue;
            }
            let gap = gaps.add(link.across, arm, (link.dir.into(), link.q + by), hit.facet);
            for &cell in witnesses {
                if self.flags.is_fluid(cell) {
                    gap.see(self.drho.get(cell as usize));
                }
            }
        }
    }
}

/// The part of a step in which surfaces were apart that are now so far from each other, after they
/// have come apart by `wider`: what goes into contact and comes out of it again has then drawn in
/// as much as it has pressed out.
fn part_apart(width: f64, wider: f64) -> f64 {
    let apart = |width: f64| (width - CONTACT).max(0.0);
    if wider == 0.0 {
        return f64::from(u8::from(width > CONTACT));
    }
    (apart(width) - apart(width - wider)) / wider
}

impl LinkSearch<'_> {
    /// Finds the gap links between a part and the walls of the domain.
    pub fn gaps_at_walls(
        &self,
        body: &Body,
        walls: &WallDistances,
        facets: &mut NearFacets,
        gaps: &mut GapLinks,
    ) {
        let Some(part) = &body.part else { return };
        let grid = &self.layout.grid;
        let is_wall = |axis: usize, side: usize| grid.sides[axis][side] == Side::Wall;
        each_beyond(grid, body, is_wall, |at, i| {
            part.facets_near(at, facets);
            self.static_gap(part, facets, walls, at, i, gaps);
        });
    }

    /// Lists the gap link `i` that leads from `at` into a part, if it is one to something that
    /// stands still; `facets` are those near `at`.
    pub fn static_gap(
        &self,
        part: &MeshBody,
        facets: &NearFacets,
        walls: &WallDistances,
        at: [i32; 3],
        i: usize,
        gaps: &mut GapLinks,
    ) {
        let grid = &self.layout.grid;
        let own = std::array::from_fn(|a| grid.wrap(a, at[a] + C[i][a]));
        let Some(cell) = grid.contains(own).then(|| self.layout.cell(own)).flatten() else {
            return;
        };
        let Beyond::BoundaryId(face) = beyond(self.layout, at) else { return };
        let Some((across, far)) = fixture(walls, face, cell, i) else { return };
        let meeting = part.meet_among(facets, at, C[i]);
        let place =
            std::array::from_fn(|a| f64::from(at[a]) + 0.5 + meeting.q * f64::from(C[i][a]));
        let across = match across.as_fixture().map(|number| BoundaryId(number as u16)) {
            Some(fixture) => {
                let gap = (self.gap_between)(part.index, fixture, place);
                gap.map_or(across, OtherSide::declared)
            }
            None => across,
        };
        let width = far - (1.0 - meeting.q);
        // It may come apart before the next search.
        if width < -1.0 {
            return;
        }
        let neighbours = (1..Q).filter_map(|k| self.layout.neighbour(cell, k));
        gaps.witnesses.extend(neighbours);
        if part.shape.is_some() {
            gaps.hits.push(meeting.hit);
        }
        gaps.links.push(PartGapLink {
            across,
            cell,
            dir: i as u8,
            at,
            q: meeting.q,
            slope: meeting.slope.map(|x| x as f32),
            width,
            end: gaps.witnesses.len() as u32,
        });
    }
}
