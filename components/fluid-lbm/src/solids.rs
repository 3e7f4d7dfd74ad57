//! Static solids of a scene: fixed parts and planes, in the frame of the box of cells.

use crate::displaced::{Displaced, window};
use crate::grid::Grid;
use crate::lattice::dot;
use std::sync::Arc;
use tremie_geometry::{Bounds, Frame, Row, RowScratch, Surface};
use tremie_messages::Problem;
use tremie_messages::scene::{Motion, Part, PartBoundary, Plane, Scene};

/// A solid that never moves.
pub struct Solid {
    /// What a user calls it.
    pub name: String,
    /// Index into the scene's parts, unless it is a plane.
    pub part: Option<usize>,
    /// What it is to the fluid.
    pub boundary: PartBoundary,
    /// The point about which its torque counts [m].
    pub reference: [f64; 3],
    shape: Shape,
}

/// Where a solid is.
enum Shape {
    Part {
        surface: Box<Surface>,
        frame: Frame,
        /// Whether the space inside is free and that outside solid.
        cavity: bool,
        /// Around the surface, in the world [m].
        bounds: Bounds,
    },
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
}

/// The centres of the cells.
#[derive(Clone, Copy, Debug, Default)]
pub struct Centres {
    /// Edge of a cell [m].
    pub cell: f64,
    /// Lower corner of the domain [m].
    pub min: [f64; 3],
}

impl Centres {
    /// Centre of a cell, which may lie outside the box [m].
    pub fn of(&self, at: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.min[a] + (f64::from(at[a]) + 0.5) * self.cell)
    }
}

/// The static solids of a scene: its fixed parts in their order, then its planes.
///
/// # Errors
/// Every part whose surface cannot be had.
pub fn solids(scene: &Scene) -> Result<Vec<Solid>, Vec<Problem>> {
    let (mut solids, mut problems) = (Vec::new(), Vec::new());
    for (index, part) in scene.parts.iter().enumerate().filter(|(_, p)| p.motion == Motion::Fixed) {
        match Solid::of_part(index, part) {
            Ok(solid) => solids.push(solid),
            Err(problem) => problems.push(problem),
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
        let key = format!("scene.parts[{index}].geometry");
        let surface = Surface::of(&part.geometry);
        surface.map_err(|e| problems.push(Problem::new(key, e.to_string()))).ok().map(Arc::new)
    });
    let surfaces = surfaces.collect();
    if problems.is_empty() { Ok(surfaces) } else { Err(problems) }
}

impl Solid {
    fn of_part(index: usize, part: &Part) -> Result<Self, Problem> {
        let key = format!("scene.parts[{index}].geometry");
        let surface =
            Surface::of_part(part).map_err(|error| Problem::new(key, error.to_string()))?;
        let frame = Frame::of(&part.pose);
        let bounds =
            Bounds::of(surface.mesh().vertices.iter().map(|&vertex| frame.to_world(vertex)));
        Ok(Self {
            name: part.name.clone(),
            part: Some(index),
            boundary: part.boundary.clone(),
            reference: part.pose.position,
            shape: Shape::Part { surface: Box::new(surface), frame, cavity: part.cavity, bounds },
        })
    }

    fn of_plane(index: usize, plane: &Plane) -> Self {
        Self {
            name: format!("plane {index}"),
            part: None,
            boundary: PartBoundary::Wall,
            reference: plane.point,
            shape: Shape::Plane { point: plane.point, normal: plane.normal },
        }
    }

    /// What it displaces where it counts, about its reference [m³, m⁴]: nothing, of a plane. `mirrors` are the axes across
    /// which a symmetry plane cuts it.
    pub fn displaced(&self, grid: &Grid, centres: &Centres, mirrors: [bool; 3]) -> Displaced {
        let Shape::Part { surface, frame, bounds, .. } = &self.shape else {
            return Displaced::default();
        };
        let window = window(grid, (centres.min, centres.cell), bounds.size(), mirrors);
        let place = |vertex| frame.to_world(vertex);
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
            Shape::Plane { point, normal } => {
                for (x, inside) in (0..).zip(inside) {
                    let centre = centres.of([x, y, z]);
                    let d = std::array::from_fn(|a| centre[a] - point[a]);
                    *inside = dot(d, *normal) <= 0.0;
                }
            }
            Shape::Part { surface, frame, cavity, bounds } => {
                let (first, last) = (centres.of([0, y, z]), centres.of([grid.n[0] - 1, y, z]));
                if bounds.grown(centres.cell).meets(&Bounds::of([first, last])) {
                    surface.fill_row(&row(frame, centres, [y, z]), inside, scratch);
                } else {
                    inside.fill(*cavity);
                }
            }
        }
    }

    /// Whether a point [m] is in the solid, its surface included.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        match &self.shape {
            Shape::Plane { point: on, normal } => {
                dot(std::array::from_fn(|a| point[a] - on[a]), *normal) <= 0.0
            }
            Shape::Part { surface, frame, .. } => surface.contains(frame.to_part(point)),
        }
    }

    /// Its surface, unless it is a plane.
    pub fn surface(&self) -> Option<&Surface> {
        match &self.shape {
            Shape::Part { surface, .. } => Some(surface),
            Shape::Plane { .. } => None,
        }
    }

    /// Around its surface, if that is bounded [m].
    pub fn bounds(&self) -> Option<Bounds> {
        match &self.shape {
            Shape::Part { bounds, .. } => Some(*bounds),
            Shape::Plane { .. } => None,
        }
    }

    /// Where the link from the centre of one cell to that of another, at most a step away along each
    /// axis, meets the surface first, as part of its length, in `(0, 1]`. Decided for the very
    /// points of [`Solid::fill_row`], so that a link with one end in the solid meets it.
    pub fn crossing(&self, centres: &Centres, from: [i32; 3], to: [i32; 3]) -> Option<f64> {
        let fraction = match &self.shape {
            Shape::Plane { point, normal } => {
                let height = |at| {
                    let centre = centres.of(at);
                    dot(std::array::from_fn(|a| centre[a] - point[a]), *normal)
                };
                let (start, end) = (height(from), height(to));
                ((start > 0.0) != (end > 0.0)).then(|| start / (start - end))
            }
            Shape::Part { surface, frame, .. } => {
                let point = |at: [i32; 3]| {
                    let row = row(frame, centres, [at[1], at[2]]);
                    std::array::from_fn(|a| row.start[a] + f64::from(at[0]) * row.step[a])
                };
                surface.first_crossing(point(from), point(to)).map(|crossing| crossing.fraction)
            }
        };
        fraction.map(|fraction| fraction.clamp(f64::MIN_POSITIVE, 1.0))
    }

    /// Distance of a point [m] from the surface [m].
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        match &self.shape {
            Shape::Plane { point: on, normal } => {
                dot(std::array::from_fn(|a| point[a] - on[a]), *normal).abs()
            }
            Shape::Part { surface, frame, .. } => {
                surface.closest(frame.to_part(point)).distance.abs()
            }
        }
    }

    /// The way from a point [m] to the nearest one of the surface [m], if it is at most `reach` [m] long.
    pub fn way_within(&self, point: [f64; 3], reach: f64) -> Option<[f64; 3]> {
        match &self.shape {
            Shape::Plane { point: on, normal } => {
                let height = dot(std::array::from_fn(|a| point[a] - on[a]), *normal);
                (height.abs() <= reach).then(|| normal.map(|n| -height * n))
            }
            Shape::Part { surface, frame, .. } => {
                let seen = frame.to_part(point);
                let closest = surface.closest_within(seen, reach)?;
                let way = std::array::from_fn(|a| closest.point[a] - seen[a]);
                Some(frame.turn_to_world(way))
            }
        }
    }

    /// Cells of the box that may begin links through the surface, as ranges `[first, last]` of
    /// coordinates around each of its triangles; the whole box for a plane.
    pub fn each_near(&self, grid: &Grid, centres: &Centres, mut visit: impl FnMut([[i32; 3]; 2])) {
        let whole = [[0; 3], grid.n.map(|n| n - 1)];
        let Shape::Part { surface, frame, .. } = &self.shape else { return visit(whole) };
        let mesh = surface.mesh();
        for triangle in 0..mesh.triangles.len() {
            let corners = mesh.corners(triangle).map(|corner| frame.to_world(corner));
            let bounds = Bounds::of(corners);
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

/// The centres of the cells of a row, in a part's frame.
fn row(frame: &Frame, centres: &Centres, [y, z]: [i32; 2]) -> Row {
    Row {
        start: frame.to_part(centres.of([0, y, z])),
        step: frame.turn_to_part([centres.cell, 0.0, 0.0]),
    }
}
