//! Links between fluid and bodies: reflection at a moving curved wall, and the force that it takes.
//!
//! A link runs from the fluid cell `x_f` along `c_i` into a body and meets its surface at `x_f + q
//! c_i`. The reflected population is interpolated linearly (see `bouzidi`), `i'` being the opposite
//! direction, `u_w` the surface's velocity there.
//!
//! If `x_f - c_i` is not fluid and `q < 1/2`, the wall is taken half-way (`q = 1/2`). If several
//! bodies hold the link's end, the one with the smallest `q` has it. A link that ends beyond a face
//! of the domain or in a static solid belongs to that.
//!
//! The force on the body is the Galilean-invariant exchange of Wen et al. 2014, `g_i (c_i - u_w) -
//! f_i' (c_i' - u_w)`, in deviations from the fluid at rest, so that it counts gauge pressure.
//!
//! # Order of work
//! Links are listed and used until what they depend on changes: those of a sphere are found in
//! words of bits, row by row (see `sphere_links`, `near_cells`), those of parts as `mesh_links`
//! says. They are done in batches: one loop does the geometry of the whole batch, one asks memory
//! for places, one reads and writes populations, one adds up forces. Loops over a batch have no
//! branches where vectors can do them. Sums run in eight lanes and depend on no order (`link_kernels`).

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::change_blocks::ChangeBlocks;
use crate::boundary::gap_sinks::GapTables;
use crate::boundary::link_batch::Batch;
use crate::boundary::mesh_links::{LinkSearch, PartLinks, as_seen};
use crate::boundary::sphere_links::SphereLinks;
use crate::boundary::unresolved_gaps::Gaps;
use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::{C, OPPOSITE, Q, each};
use crate::lattice::layout::Layout;
use crate::lattice::momentum_exchange::ExchangeTally;
use crate::lattice::populations::{Field, Real};
use tremie_team::Variant;

/// Rows of a body's shell that are one item of work.
const ROWS_PER_ITEM: i32 = 256;

/// Layers of a body's links. The cut into items depends on the body's size alone, and what items
/// exchanged is added up in their order.
#[derive(Clone, Debug)]
pub struct LinkItem {
    /// Place of the body among the living.
    pub body: usize,
    /// Layers of the shell, along z.
    layers: std::ops::Range<i32>,
    /// Gaps that they found.
    pub gaps: Gaps,
    /// The links, of a part.
    pub found: PartLinks,
    /// The links, of a sphere.
    pub of_sphere: SphereLinks,
}

/// The items of all bodies; those of parts that press count for so many declared gaps and intakes.
pub fn items(bodies: &mut Bodies, gaps_press: bool, counts: [usize; 2]) -> Vec<LinkItem> {
    let mut items = Vec::new();
    for (place, body) in bodies.living.iter_mut().enumerate() {
        let begin = items.len();
        let [side, all] = body.shell_size();
        let layers = (ROWS_PER_ITEM / side).max(1);
        let mut first = 0;
        while first < all {
            let layers = first..(first + layers).min(all);
            first = layers.end;
            // Grains draw nothing in.
            let [declared, intakes] = if body.is_part() { counts } else { [0; 2] };
            let gaps =
                if gaps_press { Gaps::with_room(declared, intakes) } else { Gaps::default() };
            let of_sphere = match &body.part {
                None => {
                    let layers = layers.end - layers.start;
                    SphereLinks::with_room(body.radius, layers, side, gaps_press)
                }
                Some(_) => SphereLinks::default(),
            };
            items.push(LinkItem {
                body: place,
                layers,
                gaps,
                found: PartLinks::default(),
                of_sphere,
            });
        }
        body.items = begin..items.len();
    }
    items
}

/// The fluid after a collision, before its links are reflected.
#[derive(Clone, Copy)]
pub struct PostCollision<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Layout of the cells, with the places of their populations.
    pub layout: &'a Layout,
    /// Owners of the cells.
    pub flags: &'a CellFlags,
    /// Steps in which bricks of cells last changed.
    pub bricks: &'a ChangeBlocks,
    /// Parity of the collision just done.
    pub parity: Parity,
    /// Densities of the lines near bodies.
    pub drho: &'a Field<T>,
    /// Vector instructions that are used.
    pub variant: Variant,
    /// Mean density of the fluid.
    pub mean: f64,
    /// True if bodies keep accounts of mass.
    pub keeps_mass: bool,
    /// See [`nearest_wall`].
    pub nearest_wall: f64,
    /// Gaps that hold no fluid.
    pub gaps: &'a GapTables,
}

impl LinkItem {
    /// Memory that its links take [bytes].
    pub fn bytes(&self) -> usize {
        self.found.bytes() + self.of_sphere.bytes()
    }

    /// Finds the links of a part, if it has moved; true if they are others than in the step before.
    pub fn find(&mut self, site: &LinkSearch, bodies: &Bodies) -> bool {
        if !self.found.find(site, &bodies.living[self.body], self.layers.clone()) {
            return false;
        }
        let felt = self.found.felt();
        if felt > self.gaps.felt.capacity() {
            self.gaps.felt.clear();
            self.gaps.felt.reserve(felt + felt / 2);
        }
        true
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Post-collision population `g_i` of a cell.
    #[inline(always)]
    pub fn post_one(&self, cell: u32, i: usize) -> f64 {
        self.field.get(self.layout.place(self.parity, cell, OPPOSITE[i]))
    }

    /// All post-collision populations of a cell.
    #[inline(always)]
    pub fn post(&self, cell: u32) -> [f64; Q] {
        let places = self.layout.places.of_cell(self.parity, cell);
        each(|i| self.field.get(places[OPPOSITE[i]]))
    }

    /// Reflects the links of an item; returns what they exchanged.
    pub fn reflect(
        &self,
        bodies: &Bodies,
        item: &mut LinkItem,
        batch: &mut Batch,
    ) -> ExchangeTally {
        let body = &bodies.living[item.body];
        batch.begin();
        std::mem::swap(&mut batch.gaps, &mut item.gaps);
        batch.gaps.clear();
        if let Some(part) = &body.part {
            self.reflect_part(bodies, body, part, &item.found, batch);
            batch.flush(self, body);
        } else {
            self.find_sphere(bodies, body, item.layers.clone(), &mut item.of_sphere);
            batch.reflect_sphere(self, body, &item.of_sphere);
            self.gaps_of_sphere(bodies, body, &mut item.of_sphere, &mut batch.gaps);
        }
        std::mem::swap(&mut batch.gaps, &mut item.gaps);
        if let Some(walls) = self.gaps.walls.as_ref().filter(|_| item.layers.start == 0) {
            self.gaps_at_faces(bodies, body, walls, &mut item.gaps);
        }
        batch.exchange()
    }

    /// True if the link `i` of a cell meets this body first, among all that hold its end; at the
    /// same distance, if this has the lowest id. The distance to a body does not depend on who
    /// asks: else two might take the link, or nobody.
    pub fn is_first(&self, bodies: &Bodies, body: &Body, cell: u32, i: usize, end: u32) -> bool {
        let at = self.layout.at(cell);
        let q = self.met_at(body, at, i);
        self.flags.claimants(end).filter(|&handle| handle != body.handle).all(|handle| {
            let other = bodies.with_handle(handle);
            let of_other = self.met_at(other, at, i);
            q < of_other || (q == of_other && body.id < other.id)
        })
    }

    /// Wall distance along the link `i` of a cell to a body that holds its end; for a part, at the
    /// pose where its links were found.
    fn met_at(&self, body: &Body, at: [i32; 3], i: usize) -> f64 {
        let grid = &self.layout.grid;
        let mirrors = grid.mirrors_to(std::array::from_fn(|a| at[a] + C[i][a]));
        let (at, seen) = as_seen(grid, at, i, mirrors);
        body.met_at(grid.arm(body.position, at), seen)
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Wall distance along the link `i` of a cell, at `arm` from a body, to another body that holds
    /// its end.
    pub fn distance(&self, body: &Body, other: &Body, arm: [f64; 3], i: usize) -> f64 {
        // From the other body to the cell, by the shortest way.
        let arm = std::array::from_fn(|a| {
            let d = arm[a] + body.position[a] - other.position[a];
            let n = f64::from(self.layout.grid.n[a]);
            if self.layout.grid.periodic[a] { d - n * (d / n).round() } else { d }
        });
        other.met_at(arm, i)
    }
}

/// As part of a link, how near a wall may be to the cell where the link begins; one that is nearer
/// counts as that near.
///
/// Interpolation to a wall that nearly touches the last cell amplifies waves between it and a wall
/// across: with BGK below a relaxation time of some 0.514 at a fiftieth of a link, of 0.507 at a
/// tenth. At less than a fifth nothing grows at any relaxation time. So the bound falls from a
/// fifth at 1/2 to nothing at 0.52. Parts that move stay where they are: a valve that stands where
/// a layer of cells opens would hunt for the step in its flow.
pub fn nearest_wall(tau: f64) -> f64 {
    0.2 * (1.0 - (tau - 0.5) / 0.02).clamp(0.0, 1.0)
}

/// Density of a cell from its populations.
#[inline]
pub fn density(g: &[f64; Q]) -> f64 {
    let mut drho = [0.0; 3];
    for i in 0..Q {
        drho[i % 3] += g[i];
    }
    1.0 + (drho[0] + drho[1] + drho[2])
}
