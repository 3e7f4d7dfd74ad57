//! Cells that a moving part covers, and intersections of links with its surface.
//!
//! Both answers come from the part's surface, for the same points: cell centres taken into the
//! part's frame row by row. Lengths in cells, but where the surface is asked.
//!
//! They are looked for at rounded poses, see `pose_rounding`.

mod link_intersections;

use crate::bodies::deformable_shape::{DeformableShape, Hit};
use crate::bodies::mesh_raster::{Cover, Layer, room_for};
use crate::bodies::pose_rounding::{PlacedMesh, Rounding, product};
use crate::bodies::ridges::Ridges;
use crate::lattice::units::Units;
use std::ops::RangeInclusive;
use std::sync::Arc;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::survey::displaced_volume::{Displaced, window};
use tremie_geometry::{Bounds, Endless, Frame, Row, Surface};
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::Pose;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

pub use self::link_intersections::NearFacets;

/// A part, or a polyhedron, as a body in the fluid.
#[derive(Clone, Debug)]
pub struct MeshBody {
    /// Its index among the parts of the scene; a surface's comes after those of all parts; of a
    /// polyhedron [`MeshBody::NO_PART`].
    pub index: usize,
    /// Vertices and loads of a deformable surface.
    pub shape: Option<Box<DeformableShape>>,
    surface: Arc<Surface>,
    /// Places where links between two cells outside may pass through it.
    ridges: Ridges,
    /// Edge of a cell [m].
    cell: f64,
    /// Volume.
    pub volume: f64,
    /// Centre of the volume in the part's frame [m].
    centroid: [f64; 3],
    orientation: [f64; 4],
    rounding: Rounding,
    /// Pose at which its cells and links were found last; none before the first time.
    found: Option<PlacedMesh>,
    /// Number of searches for its cells.
    searches: u64,
    /// For the cells it covers now, and for those that it covered before its last move: the pose at
    /// which they were found, and the number of the search.
    known: [Option<(PlacedMesh, u64)>; 2],
    /// From where they were found to where it is: shift of the origin, and the turn about it as a
    /// small vector.
    drift: [[f64; 3]; 2],
    frame: Frame,
    /// Axes along which it goes on through periodic faces.
    endless: Endless,
    now: Cover,
    previous: Cover,
}

impl MeshBody {
    /// Index of what is no part of the scene.
    pub const NO_PART: usize = usize::MAX;

    /// A part with a surface; `cell` is the edge of a cell [m].
    pub fn new(index: usize, surface: Arc<Surface>, rounding: Rounding, cell: f64) -> Self {
        let (volume, centroid) = surface.volume_and_centroid();
        let endless = surface.endless();
        let side = (2.0 * surface.bounding_radius() / cell).ceil() as i32 + 2;
        let period = std::array::from_fn(|a| {
            if endless.axes[a] { (endless.period()[a] / cell).round() as i32 } else { 0 }
        });
        let cover = Cover::new(side, period);
        Self {
            index,
            ridges: Ridges::of(&surface, cell),
            shape: None,
            volume: volume / (cell * cell * cell),
            centroid: centroid.into(),
            endless,
            orientation: [0.0, 0.0, 0.0, 1.0],
            rounding,
            found: None,
            searches: 0,
            known: [None; 2],
            drift: [[0.0; 3]; 2],
            frame: Frame::of(&Pose::IDENTITY),
            now: cover.clone(),
            previous: cover,
            surface,
            cell,
        }
    }

    /// A deformable surface, its mesh being seen from the reference that it is to be placed at.
    pub fn deformable(
        index: usize,
        surface: Surface,
        carrier: usize,
        rounding: Rounding,
        cell: f64,
    ) -> Self {
        let shape = DeformableShape::new(surface.mesh(), carrier);
        let side = side_of(&surface, cell);
        let mut own = Self::new(index, Arc::new(surface), rounding, cell);
        (own.now, own.previous) = (Cover::new(side, [0; 3]), Cover::new(side, [0; 3]));
        own.shape = Some(Box::new(shape));
        own.ridges = Ridges::default();
        own
    }

    /// Takes over the vertices of a deformable surface; true if its cells and links must be found
    /// anew.
    pub fn deform(&mut self, vertices: &[SurfaceVertex], lead: f64, units: &Units) -> bool {
        let Some(shape) = &mut self.shape else { return false };
        let position = self.rounding.position;
        let reference = std::array::from_fn(|a| units.min[a] + position[a] * units.cell);
        let far = (lead, self.rounding.step);
        let moved = shape.take(vertices, reference, far, &self.surface, units);
        moved || self.searches == 0
    }

    /// Keeps a deformable surface, or puts it back with its cells.
    ///
    /// # Errors
    /// A state of another surface.
    pub fn exchange_shape(
        &mut self,
        state: &mut StateExchange<'_>,
        grid: &Grid,
        team: &mut Team,
    ) -> Result<(), StateError> {
        // The vertices at which cells and links were found.
        let vertices = self.surface.mesh().vertices.iter();
        let mut found: Vec<[f64; 3]> = vertices.map(|&vertex| vertex.into()).collect();
        state.array("found", &mut found)?;
        // They grew with the surface, and links are cut into items by them.
        let mut sides = [self.now.size[0], self.previous.size[0]];
        state.array("sides", &mut sides)?;
        let Some(shape) = &mut self.shape else { return Ok(()) };
        if state.restores() {
            let longest = grid.n.into_iter().fold(8, i32::max);
            let fit = sides.iter().all(|side| (1..=8 * longest).contains(side));
            if !fit || !found.iter().flatten().all(|x| x.is_finite()) {
                return state.unfit("a surface of the state does not fit the scene");
            }
            shape.now.copy_from_slice(&found);
            // Finding the cells has the two change places.
            let [now, previous] = sides.map(|side| Cover::new(side, [0; 3]));
            (self.now, self.previous) = (previous, now);
            self.cover(grid, team);
        }
        self.shape.as_mut().map_or(Ok(()), |shape| shape.exchange(state))
    }

    /// Takes a deformable surface to where its vertices are.
    fn reshape(&mut self) {
        let Some(shape) = &mut self.shape else { return };
        shape.settle();
        let surface = Arc::make_mut(&mut self.surface);
        surface.reshape(&shape.now);
        let moments = surface.mesh().moments();
        self.volume = moments.volume / (self.cell * self.cell * self.cell);
        self.centroid = moments.centroid.into();
        let side = room_for(side_of(surface, self.cell), self.previous.size[0]);
        if side > self.now.size[0] {
            self.now = Cover::new(side, [0; 3]);
        }
    }

    /// Place of a deformable surface's reference in the scene.
    pub fn reference(&self) -> [f64; 3] {
        self.rounding.position
    }

    /// Point of a deformable surface nearest to `arm`, seen from its reference.
    pub fn hit_near(&self, arm: [f64; 3]) -> Hit {
        let point = self.frame.turn_to_part(arm.map(|x| x * self.cell));
        let closest = self.surface.closest(point);
        Hit::on(self.surface.mesh(), closest.triangle, closest.point.into())
    }

    /// Distance of its farthest point from its origin.
    pub fn radius(&self) -> f64 {
        self.surface.bounding_radius() / self.cell
    }

    /// Takes over a pose; true if its cells and links must be found anew.
    pub fn place(&mut self, position: [f64; 3], orientation: [f64; 4]) -> bool {
        self.orientation = orientation;
        let placed = self.rounding.of(position, orientation, self.radius());
        let moved = self.found != Some(placed);
        self.found = Some(placed);
        let [x, y, z, w] = placed.orientation;
        let turn = product(orientation, [-x, -y, -z, w]);
        let twice = if turn[3] < 0.0 { -2.0 } else { 2.0 };
        self.drift = [
            std::array::from_fn(|a| position[a] - placed.position[a]),
            [turn[0], turn[1], turn[2]].map(|q| twice * q),
        ];
        moved
    }

    /// Orientation that it was placed in last.
    pub fn orientation(&self) -> [f64; 4] {
        self.orientation
    }

    /// As [`MeshBody::drift_at`], of a place on a surface that may deform.
    #[inline(always)]
    pub fn drift_of(&self, hit: Hit, arm: [f64; 3]) -> [f64; 3] {
        match &self.shape {
            Some(shape) => shape.drift_at(hit),
            None => self.drift_at(arm),
        }
    }

    /// Motion of the point at `arm` from its origin since links were found [cells].
    #[inline(always)]
    pub fn drift_at(&self, arm: [f64; 3]) -> [f64; 3] {
        let [d, t] = self.drift;
        [
            d[0] + (t[1] * arm[2] - t[2] * arm[1]),
            d[1] + (t[2] * arm[0] - t[0] * arm[2]),
            d[2] + (t[0] * arm[1] - t[1] * arm[0]),
        ]
    }

    /// Place of its origin in the box [cells], for a position [m].
    pub fn home(&self, position: [f64; 3], units: &Units, grid: &Grid) -> [f64; 3] {
        let placed = units.position_to_lattice(self.endless.place(position).into());
        let canonical = grid.canonical(placed);
        std::array::from_fn(|a| if self.endless.axes[a] { placed[a] } else { canonical[a] })
    }

    /// Cells along each axis among which are all that it may cover.
    pub fn size(&self) -> [i32; 3] {
        self.now.size
    }

    /// The first and the last coordinate along an axis of cells in which links to it may begin.
    /// Along one on which it is endless these are those of the domain, each once.
    pub fn near(&self, axis: usize) -> [i32; 2] {
        let (first, count) = (self.now.origin[axis], self.now.size[axis]);
        let ring = i32::from(self.now.period[axis] == 0);
        [first - ring, first + count - 1 + ring]
    }

    /// Moves the coordinates of its cells.
    pub fn shift(&mut self, by: [i32; 3]) {
        for a in 0..3 {
            self.now.origin[a] += by[a];
        }
        self.known[0] = None;
    }

    /// Number of the search that found its cells; 0 before the first.
    pub fn search(&self) -> u64 {
        self.known[0].map_or(0, |(_, search)| search)
    }

    /// Finds the cells inside where it was placed; along faces that do not wrap around it is cut
    /// off.
    pub fn cover(&mut self, grid: &Grid, team: &mut Team) {
        let Some(placed) = self.found else { return };
        std::mem::swap(&mut self.now, &mut self.previous);
        self.known.swap(0, 1);
        let PlacedMesh { position, orientation } = placed;
        let pose = Pose { position: position.map(|x| x * self.cell), orientation };
        self.frame = Frame::of(&pose);
        if self.shape.is_none() && self.known[0].is_some_and(|(known, _)| known == placed) {
            return;
        }
        self.searches += 1;
        self.known[0] = Some((placed, self.searches));
        self.reshape();
        let [least, most] = self.cells_around(grid);
        self.now.origin = least;
        let mut layers = std::mem::take(&mut self.now.layers);
        team.for_each(&mut layers, |k, layer| self.fill(most, k as i32, layer));
        self.now.layers = layers;
    }

    /// First and last coordinate of cells that it may cover, in the box but along axes that wrap
    /// around.
    fn cells_around(&self, grid: &Grid) -> [[i32; 3]; 2] {
        let vertices = self.surface.mesh().vertices.iter();
        let bounds = Bounds::of(vertices.map(|&vertex| self.frame.to_world(vertex)));
        let end = |a: usize, x: f64, low: i32, high: i32| {
            let k = (x / self.cell).floor() as i32;
            if grid.periodic[a] { k } else { k.clamp(low, high) }
        };
        // Beyond a face that does not wrap around, the last comes before the first.
        let has_ends = |a: usize| !self.endless.axes[a];
        let least =
            std::array::from_fn(
                |a| {
                    if has_ends(a) { end(a, bounds.min[a], 0, grid.n[a]) } else { 0 }
                },
            );
        let most = std::array::from_fn(|a| {
            let last = grid.n[a] - 1;
            if has_ends(a) { end(a, bounds.max[a], -1, last) } else { last }
        });
        [least, most]
    }

    /// Fills a layer up to the cells `most`.
    fn fill(&self, most: [i32; 3], k: i32, layer: &mut Layer) {
        let ([ox, oy, oz], [side, rows, _]) = (self.now.origin, self.now.size.map(|n| n as usize));
        let wide = (most[0] - ox + 1).clamp(0, self.now.size[0]) as usize;
        for j in 0..rows {
            let (y, z) = (oy + j as i32, oz + k);
            let cells = &mut layer.cells[j * side..(j + 1) * side];
            if std::mem::take(&mut layer.rows[j]) {
                cells.fill(false);
            }
            if y <= most[1] && z <= most[2] && wide > 0 {
                let cells = &mut cells[..wide];
                self.surface.fill_row(&self.frame_row(y, z), cells, &mut layer.scratch);
                layer.rows[j] = cells.iter().any(|&inside| inside);
            }
        }
    }

    /// Leaves all cells.
    pub fn leave(&mut self) {
        std::mem::swap(&mut self.now, &mut self.previous);
        self.known = [None; 2];
        for layer in &mut self.now.layers {
            layer.cells.fill(false);
            layer.rows.fill(false);
        }
    }

    /// Calls `left` and `entered` with the coordinates of cells that the last move changed.
    pub fn changes(&self, left: impl FnMut([i32; 3]), entered: impl FnMut([i32; 3])) {
        self.previous.minus(&self.now, left);
        self.now.minus(&self.previous, entered);
    }

    /// Bits of the cells `first..=last` of a row that are inside.
    #[inline]
    pub fn inside(&self, y: i32, z: i32, first: i32, last: i32) -> u32 {
        let Some(row) = self.now.row(y, z) else { return 0 };
        let bits = (first..=last).enumerate();
        bits.fold(0, |bits, (k, x)| {
            let x = self.now.own(0, x) - self.now.origin[0];
            let inside = x >= 0 && row.get(x as usize).copied().unwrap_or(false);
            bits | u32::from(inside) << k
        })
    }

    /// True if a row holds any cell.
    #[inline]
    pub fn has_row(&self, y: i32, z: i32) -> bool {
        self.now.row(y, z).is_some()
    }

    /// Calls `visit` with begin and direction of links between cells outside that it may cut, see
    /// [`Ridges::each_link`]. Cells that `skip` has are left out.
    pub fn each_cut(
        &self,
        layers: RangeInclusive<i32>,
        skip: impl Fn([i32; 3]) -> bool,
        visit: impl FnMut([i32; 3], usize),
    ) {
        if !self.ridges.is_empty() {
            self.ridges.each_link(&self.frame, self.cell, layers, skip, visit);
        }
    }

    /// A cell's coordinates where its surface has been made: in the domain along axes on which it
    /// is endless.
    #[inline(always)]
    fn own(&self, at: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|a| self.now.own(a, at[a]))
    }

    /// Centre of a cell in the part's frame [m]: the very point of which rows are asked.
    fn point(&self, at: [i32; 3]) -> [f64; 3] {
        let row = self.frame_row(at[1], at[2]);
        let x = f64::from(at[0] - self.now.origin[0]);
        std::array::from_fn(|a| row.start[a] + x * row.step[a])
    }

    /// Direction away from the part, at a point seen from its origin.
    pub fn outward(&self, arm: [f64; 3]) -> [f64; 3] {
        let point = self.frame.turn_to_part(arm.map(|x| x * self.cell));
        self.frame.turn_to_world(self.surface.closest(point).normal).into()
    }

    /// The way from the centre of a cell to the nearest point of its surface, if it is no longer
    /// than `reach`.
    pub fn nearest(&self, grid: &Grid, at: [i32; 3], reach: f64) -> Option<[f64; 3]> {
        let arm = grid.arm(self.found?.position, at).map(|x| x * self.cell);
        let point = self.frame.turn_to_part(arm);
        let closest = self.surface.closest_within(point, reach.max(0.0) * self.cell)?;
        let way = closest.point - point;
        Some(self.frame.turn_to_world(way).map(|x| x / self.cell).into())
    }

    /// From its origin to the centre of its volume.
    pub fn middle(&self) -> [f64; 3] {
        self.frame.turn_to_world(self.centroid).map(|x| x / self.cell).into()
    }

    /// Volume that it displaces with its origin at a position, and first moments about that; `None`
    /// where it displaces all of its volume.
    pub fn displaced(
        &self,
        grid: &Grid,
        position: [f64; 3],
        mirrors: [bool; 3],
    ) -> Option<Displaced> {
        let radius = self.radius();
        let place = |vertex: [f64; 3]| {
            let arm = self.frame.turn_to_world(vertex);
            std::array::from_fn(|a| position[a] + arm[a] / self.cell)
        };
        let has_ends = |a: usize| !self.endless.axes[a];
        let is_short = |a: usize| !grid.periodic[a] || 2.0 * radius < f64::from(grid.n[a]);
        let extent = if (0..3).filter(|&a| has_ends(a)).all(is_short) {
            [2.0 * radius; 3]
        } else {
            Bounds::of(self.surface.mesh().vertices.iter().map(|&v| place(v.into()))).size().into()
        };
        let extent = std::array::from_fn(|a| if has_ends(a) { extent[a] } else { f64::INFINITY });
        let window = window(grid, ([0.0; 3], 1.0), extent, mirrors);
        let is_in =
            |a: usize| position[a] - radius > window.min[a] && position[a] + radius < window.max[a];
        if (0..3).all(is_in) {
            return None;
        }
        Some(Displaced::by(self.surface.mesh(), place, &window, position))
    }

    /// Centres of the cells of a row from the cover's origin on, in the part's frame [m].
    fn frame_row(&self, y: i32, z: i32) -> Row {
        let start = [self.now.origin[0], y, z].map(|k| (f64::from(k) + 0.5) * self.cell);
        Row {
            start: self.frame.to_part(start),
            step: self.frame.turn_to_part([self.cell, 0.0, 0.0]),
        }
    }
}

/// Side of a cube of cells that holds a deformable surface.
fn side_of(surface: &Surface, cell: f64) -> i32 {
    let size = surface.bounds().size();
    (size[0].max(size[1]).max(size[2]) / cell).ceil() as i32 + 3
}
