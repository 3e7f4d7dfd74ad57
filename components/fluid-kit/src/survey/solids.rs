//! Static solids of a scene: fixed parts and planes, in the frame of the box of cells.

use crate::cells::centres::Centres;
use crate::cells::grid::Grid;
use crate::cells::vector::dot;
use crate::survey::displaced_volume::{Displaced, window};
use std::sync::Arc;
use tremie_geometry::{Bounds, Frame, Row, RowScratch, Surface, Vec3, motion_problem};
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Motion, Part, PartBoundary, Plane, Pose, Scene};

/// A solid that never moves.
pub struct Solid {
    /// Name that a user knows it by.
    pub name: String,
    /// Index into the scene's parts, unless it is a plane.
    pub part: Option<usize>,
    /// Boundary condition of its surface.
    pub boundary: PartBoundary,
    /// The point about which its torque counts [m].
    pub reference: [f64; 3],
    shape: SolidShape,
}

/// Shape of a solid and its place.
enum SolidShape {
    Part {
        surface: Arc<Surface>,
        /// Its surface in the world: itself first, then its images through periodic faces.
        images: Vec<Image>,
        /// True if the space inside is free and that outside solid.
        cavity: bool,
    },
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
}

/// A part's surface in the world.
struct Image {
    frame: Frame,
    /// Around it [m].
    bounds: Bounds,
}

/// The frame of a part where it is at the start. An endless one stands in the domain.
pub fn start_frame(part: &Part, surface: &Surface) -> Frame {
    let position = surface.endless().place(part.pose.position).into();
    Frame::of(&Pose { position, ..part.pose })
}

/// Images of a part's surface in a domain: at its place, and a period away where it reaches beyond
/// a periodic face or to less than a cell from one.
fn images(part: &Part, surface: &Surface, domain: &Domain, cell: f64) -> Vec<Image> {
    let endless = surface.endless();
    let home: [f64; 3] = endless.place(part.pose.position).into();
    let at = |position| {
        let frame = Frame::of(&Pose { position, ..part.pose });
        let vertices = surface.mesh().vertices.iter();
        Image { frame, bounds: Bounds::of(vertices.map(|&vertex| frame.to_world(vertex))) }
    };
    let mut images = vec![at(home)];
    let near = Bounds { min: domain.min.into(), max: domain.max.into() }.grown(cell);
    let steps = |a: usize| {
        if domain.is_periodic(a) && !endless.axes[a] { -1..=1 } else { 0..=0 }
    };
    for z in steps(2) {
        for y in steps(1) {
            for x in steps(0).filter(|&x| [x, y, z] != [0; 3]) {
                let shift = [x, y, z].map(f64::from);
                let moved = std::array::from_fn(|a| home[a] + shift[a] * domain.size()[a]);
                images.extend(Some(at(moved)).filter(|image| image.bounds.meets(&near)));
            }
        }
    }
    images
}

/// The static solids of a scene: its fixed parts in their order, then its planes; `cell` is the
/// edge of a cell [m].
///
/// # Errors
/// Every part whose surface cannot be had.
pub fn solids(scene: &Scene, cell: f64) -> Result<Vec<Solid>, Vec<Problem>> {
    let (mut solids, mut problems) = (Vec::new(), Vec::new());
    for (index, part) in scene.parts.iter().enumerate().filter(|(_, p)| p.motion == Motion::Fixed) {
        match Solid::of_part(index, part, &scene.domain, cell) {
            Ok(solid) => solids.push(solid),
            Err(more) => problems.extend(more),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    solids.extend(
        scene.planes.iter().enumerate().map(|(index, plane)| Solid::of_plane(index, plane)),
    );
    Ok(solids)
}

/// The parts that move, where the scene has them, of their `surfaces` by index of the part.
pub fn moving_solids(scene: &Scene, cell: f64, surfaces: &[Option<Arc<Surface>>]) -> Vec<Solid> {
    let parts = scene.parts.iter().zip(surfaces).enumerate();
    let of = |(index, (part, surface)): (usize, (&Part, &Option<Arc<Surface>>))| {
        let surface = surface.clone()?;
        Some(Solid::of_surface(index, part, surface, &scene.domain, cell))
    };
    parts.filter_map(of).collect()
}

/// Surfaces of the scene's parts that move, by index of the part.
///
/// # Errors
/// Every part whose surface cannot be had.
pub fn moving_surfaces(scene: &Scene) -> Result<Vec<Option<Arc<Surface>>>, Vec<Problem>> {
    let mut problems = Vec::new();
    let surfaces = scene.parts.iter().enumerate().map(|(index, part)| {
        if part.motion == Motion::Fixed {
            return None;
        }
        let key = format!("scene.parts[{index}]");
        match Surface::in_domain(part, &scene.domain) {
            Ok(surface) => {
                problems.extend(motion_problem(&key, part, &surface, &scene.domain));
                Some(Arc::new(surface))
            }
            Err(error) => {
                problems.extend(error.problems(&format!("{key}.geometry")));
                None
            }
        }
    });
    let surfaces = surfaces.collect();
    if problems.is_empty() { Ok(surfaces) } else { Err(problems) }
}

impl Solid {
    fn of_part(
        index: usize,
        part: &Part,
        domain: &Domain,
        cell: f64,
    ) -> Result<Self, Vec<Problem>> {
        let key = format!("scene.parts[{index}].geometry");
        let surface = Surface::in_domain(part, domain).map_err(|error| error.problems(&key))?;
        Ok(Self::of_surface(index, part, Arc::new(surface), domain, cell))
    }

    fn of_surface(
        index: usize,
        part: &Part,
        surface: Arc<Surface>,
        domain: &Domain,
        cell: f64,
    ) -> Self {
        let surface = if part.cavity {
            Arc::new(Arc::unwrap_or_clone(surface).inside_out())
        } else {
            surface
        };
        let images = images(part, &surface, domain, cell);
        Self {
            name: part.name.clone(),
            part: Some(index),
            boundary: part.boundary.clone(),
            reference: part.pose.position,
            shape: SolidShape::Part { surface, images, cavity: part.cavity },
        }
    }

    fn of_plane(index: usize, plane: &Plane) -> Self {
        Self {
            name: format!("plane {index}"),
            part: None,
            boundary: PartBoundary::Wall,
            reference: plane.point,
            shape: SolidShape::Plane { point: plane.point, normal: plane.normal },
        }
    }

    /// Volume that it displaces where it counts, and its first moments about its reference [m³,
    /// m⁴]; zero for a plane. `mirrors` are the axes across which a symmetry plane cuts it.
    pub fn displaced(&self, grid: &Grid, centres: &Centres, mirrors: [bool; 3]) -> Displaced {
        let SolidShape::Part { surface, images, .. } = &self.shape else {
            return Displaced::default();
        };
        let Image { frame, bounds } = &images[0];
        let window = window(grid, (centres.min, centres.cell), bounds.size().into(), mirrors);
        let place = |vertex| frame.to_world(vertex).into();
        Displaced::by(surface.mesh(), place, &window, self.reference)
    }

    /// Says for each cell of a row of the box whether its centre is in the solid.
    pub fn fill_row(
        &self,
        grid: &Grid,
        centres: &Centres,
        [y, z]: [i32; 2],
        inside: &mut [bool],
        scratch: &mut RowScratch,
    ) {
        match &self.shape {
            SolidShape::Plane { point, normal } => {
                for (x, inside) in (0..).zip(inside) {
                    let centre = centres.of([x, y, z]);
                    let d = std::array::from_fn(|a| centre[a] - point[a]);
                    *inside = dot(d, *normal) <= 0.0;
                }
            }
            SolidShape::Part { surface, images, cavity } => {
                let (first, last) = (centres.of([0, y, z]), centres.of([grid.n[0] - 1, y, z]));
                let row_bounds = Bounds::of([first, last]);
                inside.fill(*cavity);
                let mut own = vec![false; if images.len() > 1 { inside.len() } else { 0 }];
                for image in images {
                    if !image.bounds.grown(centres.cell).meets(&row_bounds) {
                        continue;
                    }
                    let row = row(&image.frame, centres, [y, z]);
                    if images.len() == 1 {
                        surface.fill_row(&row, inside, scratch);
                        continue;
                    }
                    // Solid where any image is; in a cavity free where any is.
                    surface.fill_row(&row, &mut own, scratch);
                    for (all, &own) in inside.iter_mut().zip(&own) {
                        *all = if *cavity { *all && own } else { *all || own };
                    }
                }
            }
        }
    }

    /// True if a point [m] is in the solid, its surface included.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        match &self.shape {
            SolidShape::Plane { point: on, normal } => {
                dot(std::array::from_fn(|a| point[a] - on[a]), *normal) <= 0.0
            }
            SolidShape::Part { surface, images, cavity } => {
                let in_image = |image: &Image| surface.contains(image.frame.to_part(point));
                // A cavity's surface says of what is around it that it is solid.
                if *cavity { images.iter().all(in_image) } else { images.iter().any(in_image) }
            }
        }
    }

    /// Its surface, unless it is a plane.
    pub fn surface(&self) -> Option<&Surface> {
        match &self.shape {
            SolidShape::Part { surface, .. } => Some(surface),
            SolidShape::Plane { .. } => None,
        }
    }

    /// Around its surface, if that is bounded [m].
    pub fn bounds(&self) -> Option<Bounds> {
        match &self.shape {
            SolidShape::Part { images, .. } => Some(images[0].bounds),
            SolidShape::Plane { .. } => None,
        }
    }

    /// First crossing of the surface by the link from the centre of one cell to that of another, at
    /// most a step away along each axis: as part of its length, in `(0, 1]`. Decided for the very
    /// points of [`Solid::fill_row`], so that a link with one end in the solid meets it.
    pub fn crossing(&self, centres: &Centres, from: [i32; 3], to: [i32; 3]) -> Option<f64> {
        let fraction = match &self.shape {
            SolidShape::Plane { point, normal } => {
                let height = |at| {
                    let centre = centres.of(at);
                    dot(std::array::from_fn(|a| centre[a] - point[a]), *normal)
                };
                let (start, end) = (height(from), height(to));
                ((start > 0.0) != (end > 0.0)).then(|| start / (start - end))
            }
            SolidShape::Part { surface, images, .. } => {
                let of = |image: &Image| {
                    let point = |at: [i32; 3]| {
                        let row = row(&image.frame, centres, [at[1], at[2]]);
                        std::array::from_fn(|a| row.start[a] + f64::from(at[0]) * row.step[a])
                    };
                    surface.first_crossing(point(from), point(to)).map(|crossing| crossing.fraction)
                };
                images.iter().filter_map(of).min_by(f64::total_cmp)
            }
        };
        fraction.map(|fraction| fraction.clamp(f64::MIN_POSITIVE, 1.0))
    }

    /// Distance of a point [m] from the surface [m].
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        match &self.shape {
            SolidShape::Plane { point: on, normal } => {
                dot(std::array::from_fn(|a| point[a] - on[a]), *normal).abs()
            }
            SolidShape::Part { surface, images, .. } => {
                let of = |image: &Image| surface.closest(image.frame.to_part(point)).distance.abs();
                images.iter().map(of).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The way from a point [m] to the nearest one of the surface [m], if it is at most `reach` [m]
    /// long.
    pub fn way_within(&self, point: [f64; 3], reach: f64) -> Option<[f64; 3]> {
        match &self.shape {
            SolidShape::Plane { point: on, normal } => {
                let height = dot(std::array::from_fn(|a| point[a] - on[a]), *normal);
                (height.abs() <= reach).then(|| normal.map(|n| -height * n))
            }
            SolidShape::Part { surface, images, .. } => {
                let of = |image: &Image| {
                    let seen = image.frame.to_part(point);
                    let closest = surface.closest_within(seen, reach)?;
                    let way = closest.point - seen;
                    Some((closest.distance.abs(), image.frame.turn_to_world(way)))
                };
                let nearest = images.iter().filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0));
                nearest.map(|(_, way)| way.into())
            }
        }
    }

    /// Cells of the box that may begin links through the surface, as ranges `[first, last]` of
    /// coordinates around each of its triangles; the whole box for a plane.
    pub fn each_near(&self, grid: &Grid, centres: &Centres, mut visit: impl FnMut([[i32; 3]; 2])) {
        let whole = [[0; 3], grid.n.map(|n| n - 1)];
        let SolidShape::Part { surface, images, .. } = &self.shape else { return visit(whole) };
        let mesh = surface.mesh();
        let walls = (0..mesh.triangles.len()).filter(|&t| surface.is_wall(t as u32));
        for (image, triangle) in
            images.iter().flat_map(|image| walls.clone().map(move |t| (image, t)))
        {
            let corners = mesh.corners(triangle).map(|corner| image.frame.to_world(corner));
            let bounds = Bounds::of(corners);
            if images.len() > 1 && !image_near(grid, centres, &bounds) {
                continue;
            }
            let range = [0, 1].map(|end| {
                std::array::from_fn(|a| {
                    let x = [bounds.min, bounds.max][end][a];
                    let k = ((x - centres.min[a]) / centres.cell - 0.5).floor() as i32;
                    (k + [-1, 2][end]).clamp(0, grid.n[a] - 1)
                })
            });
            visit(range);
        }
    }
}

/// True if a box meets the domain or is less than a cell from it.
fn image_near(grid: &Grid, centres: &Centres, bounds: &Bounds) -> bool {
    let max = Vec3::from_fn(|a, _| centres.min[a] + f64::from(grid.n[a]) * centres.cell);
    Bounds { min: centres.min.into(), max }.grown(centres.cell).meets(bounds)
}

/// The centres of the cells of a row, in a part's frame.
fn row(frame: &Frame, centres: &Centres, [y, z]: [i32; 2]) -> Row {
    Row {
        start: frame.to_part(centres.of([0, y, z])),
        step: frame.turn_to_part([centres.cell, 0.0, 0.0]),
    }
}
