//! Links of a sphere: found when cells around it change hands, used until then.
//!
//! A sphere in slow motion covers the same cells for many steps, and only where its surface cuts a
//! link changes. So the links of an item are listed with what stays: the cell and the direction,
//! and where populations are. A list holds as long as the sphere covers the same cells, the same
//! ones around it are fluid, and it shares none with another body; the second is asked of the
//! bricks around it, and row by row in words of bits where one has changed.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::change_blocks::ChangeBlocks;
use crate::bodies::near_cells::{Near, NearCells};
use crate::boundary::link_kernels::{LANES, Standing};
use crate::boundary::mesh_links::as_seen;
use crate::boundary::population_addresses::PopulationAddresses;
use crate::boundary::post_collision::PostCollision;
use crate::boundary::unresolved_gaps::{GapLink, Gaps, MetInGap};
use crate::boundary::wall_distances::WallDistances;
use crate::lattice::d3q19::{C, Q};
use crate::lattice::populations::Real;

/// Cells of a row whose links are found at once: as a byte has bits.
const CHUNK: i32 = 8;

/// Layers on either side of a list's own that cells next to the ends of its links can lie in.
const BEYOND: i32 = 2;

/// Number of rows ahead of their use at which memory is asked for the table of places.
const AHEAD: usize = 4;

/// The first of the fluid cells next to the end of a link, and the end of them, in a list.
type Witnesses = [u32; 2];

/// The links of some layers of a sphere's shell.
#[derive(Clone, Debug, Default)]
pub struct SphereLinks {
    /// Number of the shell's fit at which they were found; 0 before the first.
    fit: u64,
    /// True if they were found while the sphere shared cells.
    shares: bool,
    /// The bricks in which cells near the sphere are, and the last step of which it is known that
    /// the same are fluid.
    bricks: Vec<u32>,
    seen: u64,
    /// Bits of the fluid cells in each row near the sphere, also in some more layers.
    fluid: Vec<u64>,
    /// Cells and directions as seen from the sphere, in eights.
    pub standing: Vec<Standing>,
    /// Places of their populations.
    pub slots: Vec<PopulationAddresses>,
    /// Axes at which each is mirrored; none if no link is.
    pub mirrors: Vec<u8>,
    /// Links that may be gap links, and the fluid cells next to their ends; see `unresolved_gaps`.
    gaps: Vec<(GapLink, MetInGap, Witnesses)>,
    witnesses: Vec<u32>,
    /// Number of searches for them.
    finds: u64,
}

impl SphereLinks {
    /// Room for the links of `layers` layers of a sphere's shell of `side` rows, and for gap links
    /// if gaps press.
    pub fn with_room(radius: f64, layers: i32, side: i32, gaps_press: bool) -> Self {
        // A direction's links cross the sphere's section, those of two axes 2^1/2 times as many: 24
        // r^2 pi in all, and as many in each layer. Small spheres vary.
        let section = std::f64::consts::PI * (radius + 1.0).powi(2);
        let part = (f64::from(layers + 2) / (2.0 * radius)).min(1.0);
        let links = (24.0 * section * part) as usize + 64;
        let rows = |layers: i32| 2 * (layers.min(side) * side) as usize;
        // Where a sphere touches others, a few of its links.
        let gaps = if gaps_press { links / 4 } else { 0 };
        Self {
            bricks: Vec::with_capacity(ChangeBlocks::most(side)),
            fluid: Vec::with_capacity(rows(layers + 2 * BEYOND)),
            standing: Vec::with_capacity(links / LANES + 1),
            slots: Vec::with_capacity(links),
            mirrors: Vec::with_capacity(links),
            gaps: Vec::with_capacity(gaps),
            witnesses: Vec::with_capacity(2 * gaps),
            ..Self::default()
        }
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        size_of::<u32>() * self.bricks.capacity()
            + size_of::<u64>() * self.fluid.capacity()
            + size_of::<Standing>() * self.standing.capacity()
            + size_of::<PopulationAddresses>() * self.slots.capacity()
            + self.mirrors.capacity()
            + size_of::<(GapLink, MetInGap, Witnesses)>() * self.gaps.capacity()
            + size_of::<u32>() * self.witnesses.capacity()
    }

    fn clear(&mut self) {
        self.fluid.clear();
        self.standing.clear();
        self.slots.clear();
        self.mirrors.clear();
        self.gaps.clear();
        self.witnesses.clear();
    }

    /// Takes a link, given as seen from the sphere.
    #[inline(always)]
    fn push(
        &mut self,
        slots: PopulationAddresses,
        seen: usize,
        mirrors: u8,
        from_origin: [i32; 3],
    ) {
        let lane = self.slots.len() % LANES;
        if lane == 0 {
            self.standing.push(Standing::NONE);
        }
        let last = self.standing.len() - 1;
        let eight = &mut self.standing[last];
        for a in 0..3 {
            eight.at[a][lane] = from_origin[a] as i16;
            eight.c[a][lane] = C[seen][a] as i8;
        }
        self.slots.push(slots);
        if mirrors != 0 {
            self.mirrors.resize(self.slots.len() - 1, 0);
            self.mirrors.push(mirrors);
        }
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Brings the links of some layers of a sphere's shell up to date.
    pub fn find_sphere(
        &self,
        bodies: &Bodies,
        body: &Body,
        layers: std::ops::Range<i32>,
        links: &mut SphereLinks,
    ) {
        let (shell, beyond) = (&body.shell, layers.start - BEYOND..layers.end + BEYOND);
        let all = || shell.near(beyond.clone());
        let fluid = |near: &Near| near.free & self.flags.fluid_among(near.cells, near.number);
        let before = std::mem::replace(&mut links.seen, self.bricks.step());
        // Few numbers are compared first; rows of bits only where a cell in the bricks changed.
        let holds = links.fit == shell.fits()
            && !links.shares
            && !body.shares
            && (self.bricks.are_as_in(&links.bricks, before)
                || all().iter().zip(&links.fluid).all(|(near, &known)| fluid(near) == known));
        if holds {
            return;
        }
        let all = all();
        links.clear();
        links.finds += 1;
        (links.fit, links.shares) = (shell.fits(), body.shares);
        links.fluid.extend(all.iter().map(fluid));
        let [mut first, mut last] = [shell.origin(), shell.origin().map(|k| k + shell.side() - 1)];
        (last[2], first[2]) =
            (last[2].min(first[2] + beyond.end - 1), first[2] + beyond.start.max(0));
        self.bricks.list(&self.layout.grid, first, last, &mut links.bricks);
        let own = all.iter().position(|near| layers.contains(&near.row[1])).unwrap_or(all.len());
        let rows = shell.near(layers);
        for (number, near) in rows.iter().enumerate() {
            if let Some(next) = rows.get(number + AHEAD) {
                self.layout.places.prefetch(next.number, next.cells.count_ones());
            }
            let fluid = links.fluid[own + number];
            let row = Row::new(self, bodies, body, near);
            self.find_row(&row, near, fluid, links);
            if let Some(walls) = &self.gaps.walls {
                self.find_gaps(&row, walls, near.free & !fluid, links);
            }
        }
        if !links.mirrors.is_empty() {
            links.mirrors.resize(links.slots.len(), 0);
        }
    }

    /// Finds the links that begin in the `fluid` cells of a row near a sphere.
    fn find_row(&self, row: &Row, near: &Near, fluid: u64, links: &mut SphereLinks) {
        let (count, mut number) = (row.body.shell.window(near.window).count, near.number);
        for first in (0..count).step_by(CHUNK as usize) {
            let chunk = u64::MAX >> (64 - CHUNK) << first;
            if fluid & chunk != 0 {
                self.find_chunk(row, first, fluid & chunk, number, links);
            }
            number += (near.cells & chunk).count_ones();
        }
    }

    /// Finds the links that begin in the `fluid` ones of [`CHUNK`] cells of a row. `number` is that
    /// of the first of them that is stored.
    fn find_chunk(
        &self,
        row: &Row,
        first: i32,
        fluid: u64,
        mut number: u32,
        links: &mut SphereLinks,
    ) {
        let mut numbers = [0; CHUNK as usize];
        for (k, own) in (first..).zip(&mut numbers) {
            *own = number;
            number += u32::from(row.cells >> k & 1 == 1);
        }
        // A byte for each direction, so that one loop finds the links of eight.
        for from in [1, 9, 17] {
            let mut found = 0;
            for byte in 0..8.min(Q - from) {
                found |= ((row.into[from + byte] & fluid) >> first) << (8 * byte);
            }
            while found != 0 {
                let bit = found.trailing_zeros() as usize;
                found &= found - 1;
                let (i, k) = (from + bit / 8, bit % 8);
                let (lane, cell) = (first + k as i32, numbers[k]);
                if row.doubtful >> lane & 1 == 0 || self.is_mine(row, cell, i) {
                    self.take(row, lane, i, cell, links);
                }
            }
        }
    }

    /// Lists the link `i` of cell `k` of a row.
    #[inline(always)]
    fn take(&self, row: &Row, k: i32, i: usize, cell: u32, links: &mut SphereLinks) {
        let (grid, mut mirrors) = (&self.layout.grid, row.mirrors[NearCells::to(i)]);
        let x = row.first + k;
        let end = x + C[i][0];
        if !grid.periodic[0] && (end < 0 || end >= grid.n[0]) {
            mirrors |= 1;
        }
        let mut at = [x, row.y, row.z];
        let mut seen = i;
        if mirrors != 0 {
            // As seen by the body: the mirrored link of the mirrored cell.
            (at, seen) = as_seen(grid, at, i, mirrors);
        }
        let origin = row.body.shell.origin();
        let from_origin = std::array::from_fn(|a| at[a] - origin[a]);
        links.push(PopulationAddresses::new(self.layout, cell, i), seen, mirrors, from_origin);
    }

    /// True if a link ends at no thin solid, and no other body that holds its end is met before.
    fn is_mine(&self, row: &Row, cell: u32, i: usize) -> bool {
        self.layout.neighbour(cell, i).is_some_and(|end| {
            !self.flags.is_shared(end) || self.is_first(row.bodies, row.body, cell, i, end)
        })
    }

    /// Lists what may be gap links of those that begin in the cells of a row whose bits are set in
    /// `solid`.
    fn find_gaps(&self, row: &Row, walls: &WallDistances, solid: u64, links: &mut SphereLinks) {
        let grid = &self.layout.grid;
        for i in 1..Q {
            let mut found = row.gaps(i) & solid;
            while found != 0 {
                let x = row.first + found.trailing_zeros() as i32;
                found &= found - 1;
                let end = x + C[i][0];
                if (grid.periodic[0] || (end >= 0 && end < grid.n[0]))
                    && let Some(link) = self.gap_link(walls, [x, row.y, row.z], i)
                {
                    let witnesses = self.witnesses(link.cell, links);
                    links.gaps.push((link, MetInGap::default(), witnesses));
                }
            }
        }
    }

    /// Lists the fluid cells next to one that the sphere covers, unless they are listed.
    fn witnesses(&self, cell: u32, links: &mut SphereLinks) -> Witnesses {
        let known = links.gaps.iter().rev().find(|(link, ..)| link.cell == cell);
        if let Some((.., witnesses)) = known {
            return *witnesses;
        }
        let first = links.witnesses.len() as u32;
        let fluid = self.layout.places.neighbours(cell).filter(|&next| self.flags.is_fluid(next));
        links.witnesses.extend(fluid);
        [first, links.witnesses.len() as u32]
    }

    /// Finds what gaps do to the sphere; see `unresolved_gaps`.
    pub fn gaps_of_sphere(
        &self,
        bodies: &Bodies,
        body: &Body,
        links: &mut SphereLinks,
        gaps: &mut Gaps,
    ) {
        for (link, met, [first, end]) in &mut links.gaps {
            let witnesses = &links.witnesses[*first as usize..*end as usize];
            self.gap_seen(bodies, body, (link, met), witnesses, gaps);
        }
    }
}

/// A row of cells around a sphere, in a window of its shell.
struct Row<'a> {
    bodies: &'a Bodies,
    body: &'a Body,
    /// Coordinates as seen from the body.
    y: i32,
    z: i32,
    /// The same of its first cell.
    first: i32,
    /// Bits of its stored cells.
    cells: u64,
    /// Those whose links may end at a thin solid, or in cells that others hold too.
    doubtful: u64,
    /// For each row around, the axes among y and z at which links to it are mirrored.
    mirrors: [u8; 9],
    /// Those of its cells from which a link of each direction ends inside.
    into: [u64; Q],
}

impl<'a> Row<'a> {
    fn new<T: Real>(
        after: &PostCollision<T>,
        bodies: &'a Bodies,
        body: &'a Body,
        near: &Near,
    ) -> Self {
        let (grid, shell) = (&after.layout.grid, &body.shell);
        let [y, z] = shell.coordinates(near.row);
        let to_y = [-1, 0, 1].map(|d| grid.fold(1, y + d).1);
        let to_z = [-1, 0, 1].map(|d| grid.fold(2, z + d).1);
        let ends = shell.around(near);
        Self {
            bodies,
            body,
            y,
            z,
            first: shell.window(near.window).first,
            cells: near.cells,
            doubtful: if body.shares { u64::MAX } else { near.at_sheets },
            mirrors: std::array::from_fn(|n| to_y[n % 3] << 1 | to_z[n / 3] << 2),
            into: std::array::from_fn(|i| ends[NearCells::to(i)] >> (1 + C[i][0])),
        }
    }

    /// The cells from which a link of a direction ends inside without meeting a mirror along y or
    /// z.
    fn gaps(&self, i: usize) -> u64 {
        if self.mirrors[NearCells::to(i)] == 0 { self.into[i] } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use crate::domain::parameters::{Parameters, Refill};
    use crate::solver::lbm_solver::LbmSolver;
    use tremie_messages::scene::{Domain, Face, FluidMaterial, Scene};
    use tremie_messages::units::Time;
    use tremie_messages::{BodyEvent, BodyState, Load};
    use tremie_team::Variant;

    fn event(id: u64, kind: u32, radius: f64) -> BodyEvent {
        BodyEvent {
            id,
            kind,
            shape: BodyEvent::SPHERE,
            motion: BodyEvent::FREE,
            set: 0,
            mass: 1.0,
            size: [radius, 0.0, 0.0],
            table: 0,
        }
    }

    /// Spheres that drift slowly: through a periodic face, through each other, along a wall and a
    /// mirror, one so large that it has several items and windows; one leaves, and its place is
    /// taken. Every bit of the loads.
    fn loads(forgetful: bool) -> (Vec<u64>, usize) {
        let sides = |face: Face| [face.clone(), face];
        let faces = [sides(Face::Periodic), [Face::WALL, Face::Symmetry], sides(Face::Periodic)];
        let scene = Scene {
            fluid: Some(FluidMaterial {
                velocity: [0.01, 0.0, 0.02],
                ..FluidMaterial::at_rest(1.0, 0.02)
            }),
            ..Scene::empty(Domain::new([0.0; 3], [70.0, 24.0, 26.0], faces))
        };
        let parameters = Parameters {
            time_step: Some(Time(1.0)),
            refill: Refill::Mass,
            ..Parameters::with_cell(1.0)
        };
        let variant = Variant::widest();
        let mut solver = LbmSolver::<f64>::new(&scene, &parameters, 1.0, 2, variant).unwrap();
        let places = [
            ([69.2, 12.1, 13.3], 2.4, [0.02, 0.0, 0.004]),
            ([20.3, 9.2, 12.4], 8.6, [0.004, 0.0, 0.0]),
            ([31.6, 9.4, 12.2], 2.3, [-0.015, 0.001, 0.0]),
            ([45.0, 1.9, 6.0], 1.6, [0.01, -0.004, 0.003]),
            ([50.0, 23.1, 15.0], 2.1, [0.0, 0.006, 0.005]),
            // One at rest, and one that covers cells beside it.
            ([58.3, 17.6, 6.2], 2.2, [0.0; 3]),
            ([52.2, 17.8, 6.5], 1.6, [0.0125, 0.0, 0.0]),
            ([58.0, 12.0, 25.7], 1.33, [0.003, 0.002, 0.008]),
        ];
        let mut bodies = Vec::new();
        let mut events = Vec::new();
        for (id, (position, radius, velocity)) in (0..).zip(places) {
            bodies.push(BodyState { velocity, ..BodyState::at_rest(id, position) });
            events.push(event(id, BodyEvent::ADDED, radius));
        }
        solver.apply_events(&events).unwrap();
        let mut loads = vec![Load::default(); bodies.len()];
        solver.start(&bodies, &mut loads).unwrap();
        let (mut bits, mut kept) = (Vec::new(), 0);
        for step in 0..160 {
            if step == 70 {
                bodies.pop();
                bodies.push(BodyState::at_rest(9, [47.1, 2.2, 7.9]));
                let swap = [event(7, BodyEvent::REMOVED, 0.0), event(9, BodyEvent::ADDED, 1.5)];
                solver.apply_events(&swap).unwrap();
            }
            for body in &mut bodies {
                for a in 0..3 {
                    body.position[a] += body.velocity[a];
                }
            }
            let before: Vec<u64> =
                solver.bodies.links.iter().map(|item| item.of_sphere.finds).collect();
            if forgetful {
                solver.bodies.links.iter_mut().for_each(|item| item.of_sphere.fit = 0);
            }
            solver.step(&bodies, &mut loads).unwrap();
            let items = solver.bodies.links.iter().zip(before);
            kept += items.filter(|(item, before)| item.of_sphere.finds == *before).count();
            for load in &loads {
                bits.extend(load.force.iter().chain(&load.torque).map(|x| x.to_bits()));
            }
        }
        (bits, kept)
    }

    #[test]
    fn lists_that_are_kept_are_those_that_would_be_found() {
        let ((kept_bits, kept), (found_bits, found)) = (loads(false), loads(true));
        assert!(kept > 300 && found == 0, "{kept} {found}");
        assert!(kept_bits == found_bits);
    }
}
