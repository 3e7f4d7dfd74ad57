//! Links of moving parts: found when the part has moved by a step, used until then.
//!
//! The lists depend on the part's rounded pose (see `mesh_body`) and on static solids: every link
//! from a stored cell outside the part to one that it covers, and every gap link (see
//! `unresolved_gaps`) from a static solid or a wall. Data that change from step to step are looked
//! up when the list is used: which of those cells are fluid, whether another body holds a link's
//! end and is met before, how far the surface has come since. A link beside a wall that the part
//! moves along pushes for those that the wall takes: a piston displaces what it should. A flat wall
//! that has moved by `d` is met at `q + d.n / (c.n)`.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::deformable_shape::Hit;
use crate::bodies::mesh_body::{MeshBody, NearFacets};
use crate::boundary::cut_links::CutLinks;
use crate::boundary::gap_sinks::NO_GAP;
use crate::boundary::link_batch::{Batch, BatchLink};
use crate::boundary::population_addresses::PopulationAddresses;
use crate::boundary::post_collision::PostCollision;
use crate::boundary::unresolved_gaps::{Beyond, GapLink, beyond};
use crate::boundary::unresolved_part_gaps::GapLinks;
use crate::boundary::wall_distances::WallDistances;
use crate::lattice::cell_flags::{BODY, FROZEN, SHARED};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::cell_list::NONE;
use crate::lattice::d3q19::{C, C_F64, Q, W, dot, mirrored};
use crate::lattice::layout::Layout;
use crate::lattice::populations::{Real, prefetch};
use tremie_fluid_kit::cells::grid::Grid;

/// Number of links ahead of their use at which memory is asked for them.
const AHEAD: usize = 24;

/// A link, as it was when it was found.
#[derive(Clone, Copy, Debug)]
pub struct PartLink {
    /// Places of its populations.
    slots: PopulationAddresses,
    /// The cell where it ends.
    end: u32,
    /// Its direction.
    dir: u8,
    /// Its direction as seen by the body.
    seen: u8,
    /// Axes at which it is mirrored.
    mirrors: u8,
    /// Sides along it where what stands still takes links from the part; see [`rims`].
    rims: u8,
    /// The cell as seen from the body.
    at: [i32; 3],
    /// Wall distance at the pose of the search, as part of the link's length.
    q: f64,
    /// Gradient of `q` by the motion of the surface [1/cell].
    slope: [f32; 3],
}

/// The links of an item: those of the part's last search, and of the one before, to which it may
/// come back.
#[derive(Clone, Debug, Default)]
pub struct PartLinks {
    now: ListedMeshLinks,
    before: ListedMeshLinks,
    facets: NearFacets,
}

/// The links that a search found.
#[derive(Clone, Debug, Default)]
pub struct ListedMeshLinks {
    /// Number of the search; 0 before the first.
    search: u64,
    links: Vec<PartLink>,
    /// For each link where it meets a surface that can deform; none for rigid parts.
    hits: Vec<Hit>,
    gaps: GapLinks,
    /// Links between two cells outside that pass through it.
    cuts: CutLinks,
    /// Lines that hold the cells of which densities are needed.
    lines: Vec<u32>,
}

impl ListedMeshLinks {
    fn clear(&mut self) {
        self.links.clear();
        self.hits.clear();
        self.gaps.clear();
        self.cuts.clear();
        self.lines.clear();
    }

    /// Room for half as many more.
    fn make_room(&mut self) {
        self.links.reserve(self.links.len() / 2 + 64);
        self.hits.reserve(self.hits.len() / 2);
        self.lines.reserve(self.lines.len() / 2 + 64);
        self.gaps.make_room();
        self.cuts.make_room();
    }

    fn bytes(&self) -> usize {
        size_of::<PartLink>() * self.links.capacity()
            + size_of::<Hit>() * self.hits.capacity()
            + self.cuts.bytes()
    }
}

/// Surroundings that a search looks at.
#[derive(Clone, Copy)]
pub struct LinkSearch<'a> {
    /// Layout of the cells.
    pub layout: &'a Layout,
    /// The static geometry, if gaps press.
    pub walls: Option<&'a WallDistances>,
    /// The declared gap between a part of the scene and something that stands still, at a point as
    /// lattice coordinates.
    pub gap_between: &'a (dyn Fn(usize, BoundaryId, [f64; 3]) -> Option<u16> + Sync),
    /// Cells of a line.
    pub line: usize,
}

impl PartLinks {
    /// Finds the links that begin in the layers `layers` of a part's shell, unless those of its
    /// last search are known. True if these are others than before.
    pub fn find(&mut self, site: &LinkSearch, body: &Body, layers: std::ops::Range<i32>) -> bool {
        let Some(part) = body.part.as_deref().filter(|part| part.search() != self.now.search)
        else {
            return false;
        };
        // A part that trembles about the border of two poses comes back to the search before.
        std::mem::swap(&mut self.now, &mut self.before);
        if self.now.search == part.search() {
            return true;
        }
        let is_first = self.before.search == 0 && self.now.search == 0;
        self.now.clear();
        self.now.search = part.search();
        for z in layers.clone() {
            for y in 0..body.shell_size()[0] {
                self.find_row(site, part, body.shell_row(y, z));
            }
        }
        let layer = |z: i32| body.shell_row(0, z)[1];
        let own = layer(layers.start)..=layer(layers.end - 1);
        self.now.cuts.find(site.layout, part, own, &mut self.facets);
        // Gap links at walls belong to no layer of the shell: the first item has them all.
        if let Some(walls) = site.walls.filter(|_| layers.start == 0) {
            site.gaps_at_walls(body, walls, &mut self.facets, &mut self.now.gaps);
        }
        let ListedMeshLinks { links, gaps, cuts, lines, .. } = &mut self.now;
        let line = |cell: u32| cell / site.line as u32;
        for link in links {
            if lines.last() != Some(&line(link.slots.cell)) {
                lines.push(line(link.slots.cell));
            }
        }
        lines.extend(gaps.witnesses().map(line));
        lines.extend(cuts.cells().map(line));
        lines.sort_unstable();
        lines.dedup();
        if is_first {
            self.make_room();
        }
        true
    }

    /// Room for what a part that moves on will need: half as much again.
    fn make_room(&mut self) {
        self.now.make_room();
        // As much for the next search, which fills the other list.
        self.before.clone_from(&self.now);
        self.before.make_room();
        self.before.clear();
        self.before.search = 0;
        self.facets.make_room();
    }

    /// Lines that hold the cells of which densities are needed.
    pub fn lines(&self) -> &[u32] {
        &self.now.lines
    }

    /// Links between two cells outside that pass through it.
    pub fn cuts(&self) -> &CutLinks {
        &self.now.cuts
    }

    /// The same, to be read.
    pub fn cuts_mut(&mut self) -> &mut CutLinks {
        &mut self.now.cuts
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        self.now.bytes() + self.before.bytes()
    }

    /// Largest number of forces that the links of a deformable surface give to facets; 0 for other
    /// parts.
    pub fn felt(&self) -> usize {
        let ListedMeshLinks { links, hits, gaps, .. } = &self.now;
        if hits.is_empty() { 0 } else { links.len() + gaps.len() }
    }

    fn find_row(&mut self, site: &LinkSearch, part: &MeshBody, [y, z]: [i32; 2]) {
        let grid = &site.layout.grid;
        let (real_y, real_z) = (grid.wrap(1, y), grid.wrap(2, z));
        if !grid.contains([0, real_y, real_z]) {
            return;
        }
        let ends: [([i32; 2], u8); Q] = std::array::from_fn(|i| {
            let (to_y, mirror_y) = grid.fold(1, y + C[i][1]);
            let (to_z, mirror_z) = grid.fold(2, z + C[i][2]);
            ([to_y, to_z], mirror_y << 1 | mirror_z << 2)
        });
        let [mut first, mut last] = part.near(0);
        if !grid.periodic[0] {
            (first, last) = (first.max(0), last.min(grid.n[0] - 1));
        }
        if !ends.iter().any(|&([y, z], _)| part.has_row(y, z)) {
            return;
        }
        let base = grid.index([0, real_y, real_z]);
        for x in first..=last {
            if part.inside(y, z, x, x) != 0 {
                continue;
            }
            let mut found = [(0, 0); Q];
            let mut count = 0;
            for i in 1..Q {
                let ([to_y, to_z], mut mirrors) = ends[i];
                let (to_x, mirror_x) = grid.fold(0, x + C[i][0]);
                mirrors |= mirror_x;
                if part.inside(to_y, to_z, to_x, to_x) != 0 {
                    found[count] = (i, mirrors);
                    count += 1;
                }
            }
            if count == 0 {
                continue;
            }
            let number = site.layout.cells.number(base + grid.wrap(0, x) as usize);
            // A cell that is not stored has no populations: only gap links can begin there.
            if number == NONE {
                self.find_gaps(site, part, [x, y, z], &found[..count]);
            } else {
                self.find_links(site, part, number, [x, y, z], &found[..count]);
            }
        }
    }

    fn find_links(
        &mut self,
        site: &LinkSearch,
        part: &MeshBody,
        cell: u32,
        at: [i32; 3],
        found: &[(usize, u8)],
    ) {
        let mut near = None;
        for &(i, mirrors) in found {
            let Some(end) = site.layout.neighbour(cell, i) else { continue };
            let (at, seen) = as_seen(&site.layout.grid, at, i, mirrors);
            // Links of a cell follow each other: the facets near it are looked up once.
            if near != Some(at) {
                part.facets_near(at, &mut self.facets);
                near = Some(at);
            }
            let meeting = part.meet_among(&self.facets, at, C[seen]);
            if part.shape.is_some() {
                self.now.hits.push(meeting.hit);
            }
            self.now.links.push(PartLink {
                slots: PopulationAddresses::new(site.layout, cell, i),
                end,
                dir: i as u8,
                seen: seen as u8,
                mirrors,
                rims: rims(site.layout, cell, i),
                at,
                q: meeting.q,
                slope: meeting.slope.map(|x| x as f32),
            });
        }
    }

    fn find_gaps(
        &mut self,
        site: &LinkSearch,
        part: &MeshBody,
        at: [i32; 3],
        found: &[(usize, u8)],
    ) {
        let Some(walls) = site.walls else { return };
        let mut near = None;
        for &(i, mirrors) in found {
            let (at, seen) = as_seen(&site.layout.grid, at, i, mirrors);
            if near != Some(at) {
                part.facets_near(at, &mut self.facets);
                near = Some(at);
            }
            site.static_gap(part, &self.facets, walls, at, seen, &mut self.now.gaps);
        }
    }
}

/// Number of sides of a straight link along which something stands still, at its beginning and at
/// its end. A part that moves along a wall pushes fluid with four of the five links of a flat face
/// there, the fifth being the wall's; the straight one stands for it.
fn rims(layout: &Layout, cell: u32, i: usize) -> u8 {
    if C[i].iter().map(|c| c.abs()).sum::<i32>() != 1 {
        return 0;
    }
    let at = layout.at(cell);
    let stands = |by: [i32; 3]| {
        let at = std::array::from_fn(|a| at[a] + by[a]);
        matches!(beyond(layout, at), Beyond::BoundaryId(_))
    };
    let sides = (1..Q).map(|k| C[k]).filter(|e| {
        e.iter().map(|c| c.abs()).sum::<i32>() == 1 && (0..3).all(|a| e[a] * C[i][a] == 0)
    });
    let rims = sides.filter(|e| stands(*e) && stands(std::array::from_fn(|a| e[a] + C[i][a])));
    rims.count() as u8
}

/// A cell and a direction as the body sees them, of a link that is mirrored at some axes.
pub fn as_seen(grid: &Grid, mut at: [i32; 3], i: usize, mirrors: u8) -> ([i32; 3], usize) {
    for a in 0..3 {
        if mirrors >> a & 1 == 1 {
            at[a] = if C[i][a] < 0 { -1 - at[a] } else { 2 * grid.n[a] - 1 - at[a] };
        }
    }
    (at, mirrored(i, mirrors))
}

impl<T: Real> PostCollision<'_, T> {
    /// Reflects the links of an item of a part.
    pub fn reflect_part(
        &self,
        bodies: &Bodies,
        body: &Body,
        part: &MeshBody,
        list: &PartLinks,
        batch: &mut Batch,
    ) {
        let list = &list.now;
        let mut hits = list.hits.as_slice();
        for run in list.links.chunk_by(|a, b| a.slots.cell == b.slots.cell) {
            let cell = run[0].slots.cell;
            for k in 0..run.len() {
                prefetch(run.as_ptr().wrapping_add(AHEAD + k));
            }
            let mine = hits.split_off(..run.len().min(hits.len())).unwrap_or_default();
            if !self.flags.is_fluid(cell) {
                if self.gaps.walls.is_some() {
                    self.gaps_of_run((bodies, body, part), (run, mine), batch);
                }
                continue;
            }
            batch.make_room(self, body);
            for (k, found) in run.iter().enumerate() {
                let hit = mine.get(k).copied().unwrap_or(Hit::NONE);
                let link = found.now(body, part, hit);
                let is_mine = !body.shares
                    || !self.flags.is_shared(found.end)
                    || self.is_first(bodies, body, cell, found.dir.into(), found.end);
                if is_mine {
                    batch.push(link);
                    if found.rims != 0 {
                        // A diagonal link weighs half of a straight one.
                        batch.widen(1.0 + 0.5 * f64::from(found.rims));
                    }
                    if let Some(shape) = &part.shape {
                        batch.wall(shape.velocity_at(hit), hit.facet);
                    }
                }
            }
        }
        if self.gaps.walls.is_some() {
            self.press_on(body, part, &list.gaps, &mut batch.gaps);
        }
    }

    /// True if nobody holds a cell but the body and bodies that it is bonded to. There is no gap
    /// then, and links need not be followed to see it.
    fn is_bonded(&self, bodies: &Bodies, body: &Body, cell: u32) -> bool {
        let is_own =
            |handle: u32| handle == body.handle || body.is_bonded_to(bodies.with_handle(handle));
        match self.flags.of(cell) {
            SHARED => self.flags.claimants(cell).all(is_own),
            owner => owner.checked_sub(BODY).is_some_and(is_own),
        }
    }

    /// Finds the gap links between a part and what holds the cell where links begin: another body,
    /// or nobody if it is frozen.
    fn gaps_of_run(
        &self,
        (bodies, body, part): (&Bodies, &Body, &MeshBody),
        (run, hits): (&[PartLink], &[Hit]),
        batch: &mut Batch,
    ) {
        let cell = run[0].slots.cell;
        let hit = |k: usize| hits.get(k).copied().unwrap_or(Hit::NONE);
        if self.flags.of(cell) == FROZEN {
            let gap = self.gaps.gap_of.get(cell as usize).copied().filter(|&gap| gap != NO_GAP);
            // Others count the links of their cells.
            let own = if self.layout.is_own(cell) { run } else { &[] };
            for (k, link) in own.iter().enumerate() {
                let link = link.now(body, part, hit(k));
                let receded = recession(&link, wall_velocity(body, &link, hit(k)));
                match gap {
                    Some(gap) => {
                        batch.gaps.draw(gap, receded);
                        self.press_frozen(gap, &link, hit(k).facet, &mut batch.gaps);
                    }
                    // A frozen cell of no declared gap is in a pocket.
                    None => batch.draw(receded),
                }
            }
            if gap.is_some() {
                return;
            }
        }
        if self.is_bonded(bodies, body, cell) {
            return;
        }
        for (k, link) in run.iter().enumerate().filter(|(_, link)| link.mirrors == 0) {
            let meeting = (link.q, hit(k).facet);
            let link = GapLink::between(link.at, link.dir, cell, link.end);
            self.gap_met((bodies, body), &link, Some(meeting), &mut batch.gaps);
        }
    }
}

/// Velocity of the wall where a link meets it.
pub fn wall_velocity(body: &Body, link: &BatchLink, hit: Hit) -> [f64; 3] {
    let c = C_F64[usize::from(link.seen)];
    body.velocity_of(hit, std::array::from_fn(|a| link.arm[a] + link.q * c[a]))
}

/// Volume by which a wall of a velocity recedes along a link.
pub fn recession(link: &BatchLink, velocity: [f64; 3]) -> f64 {
    let seen = usize::from(link.seen);
    6.0 * W[seen] * dot(C_F64[seen], velocity)
}

impl PartLink {
    /// The link as it is now.
    #[inline(always)]
    fn now(&self, body: &Body, part: &MeshBody, hit: Hit) -> BatchLink {
        let arm: [f64; 3] = std::array::from_fn(|a| f64::from(self.at[a]) + 0.5 - body.position[a]);
        let drift = part.drift_of(hit, arm);
        let s = self.slope.map(f64::from);
        let q = self.q + (s[0] * drift[0] + s[1] * drift[1] + s[2] * drift[2]);
        let q = q.clamp(f64::MIN_POSITIVE, 1.0);
        BatchLink { slots: self.slots, seen: self.seen, mirrors: self.mirrors, arm, q }
    }
}
