//! Triangles of a part.

use crate::extrude::extruded;
use crate::mend::{Repairs, mend};
use crate::revolve::revolved;
use crate::{Bounds, Frame, GeometryError, Vec3, read, shapes, stray};
use std::path::Path;
use tremie_messages::scene::{Geometry, Pose};

/// Triangles with shared vertices.
///
/// One from [`load`] or [`mend`] is closed, every edge has exactly two triangles, and all normals
/// point out of the solid: the corners of a triangle run anticlockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Points [m].
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle, as indices of vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// A part's mesh, and what had to be done to get it.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The mesh, in the part's frame [m].
    pub mesh: Mesh,
    /// Repairs; worth a line in the log.
    pub repairs: Repairs,
}

/// The mesh of a geometry, in the part's frame.
///
/// A file is scaled by its unit, welded, stripped of triangles without area, and its triangles are
/// turned so that normals point outward, and into the hollow of a shell that lies inside another.
/// True if triangles cross each other is not looked at: see
/// [`Surface::intersections`](crate::Surface::intersections).
///
/// # Errors
/// A file that cannot be read or is no STL or OBJ file, and a surface that is not closed: see
/// [`GeometryError`].
pub fn load(geometry: &Geometry) -> Result<Loaded, GeometryError> {
    match geometry {
        Geometry::File { path, unit } => {
            shapes::positive("unit", *unit)?;
            let mut mesh = read::read(Path::new(path))?;
            mesh.check_numbers()?;
            let stray = stray::corner(&mesh);
            if let Some(far) = stray::beyond(&mesh, *unit) {
                return Err(stray.unwrap_or(far));
            }
            mesh.scale(*unit);
            let (mesh, repairs) = mend(mesh).map_err(|error| stray.unwrap_or(error))?;
            Ok(Loaded { mesh, repairs })
        }
        Geometry::Box { size } => shape(shapes::cuboid((*size).into())?),
        Geometry::Cylinder { radius, length } => shape(shapes::cylinder(*radius, *length)?),
        Geometry::Sphere { radius } => shape(shapes::sphere(*radius)?),
        Geometry::Revolved { profile } => {
            let (mesh, repairs) = mend(revolved(profile)?)?;
            Ok(Loaded { mesh, repairs })
        }
        Geometry::Extruded { outline, axis, length } => {
            let (mesh, repairs) = mend(extruded(outline, *axis, *length)?)?;
            Ok(Loaded { mesh, repairs })
        }
    }
}

fn shape(mesh: Mesh) -> Result<Loaded, GeometryError> {
    Ok(Loaded { mesh, repairs: Repairs { shells: 1, ..Repairs::default() } })
}

impl Mesh {
    /// The mesh of a geometry: [`load`] without the account of repairs.
    ///
    /// # Errors
    /// As [`load`].
    pub fn of(geometry: &Geometry) -> Result<Self, GeometryError> {
        load(geometry).map(|loaded| loaded.mesh)
    }

    /// Corners of a triangle.
    ///
    /// # Panics
    /// If there is no triangle of that number.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The least box around the vertices. A part much larger or smaller than its surroundings
    /// hints at a wrong unit.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.vertices.iter().copied())
    }

    /// Distance of the farthest vertex from the origin of the part's frame [m]: however the part
    /// turns about it, it stays within this radius.
    pub fn bounding_radius(&self) -> f64 {
        let squared = |v: &Vec3| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        self.vertices.iter().map(squared).fold(0.0, f64::max).sqrt()
    }

    /// The mesh put at a pose.
    pub fn placed(&self, pose: &Pose) -> Self {
        let frame = Frame::of(pose);
        let vertices = self.vertices.iter().map(|&v| frame.to_world(v)).collect();
        Self { vertices, triangles: self.triangles.clone() }
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        self.vertices.iter_mut().flatten().for_each(|x| *x *= factor);
    }

    /// Every index names a vertex, every vertex is a point.
    pub(crate) fn check_numbers(&self) -> Result<(), GeometryError> {
        // Half-edges are numbered with 32 bits, and the last number means "none".
        let limit = (u32::MAX / 3) as usize - 1;
        if self.triangles.len() > limit {
            return Err(GeometryError::TooMany { found: self.triangles.len(), limit });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for &found in corners {
                let Some(&point) = self.vertices.get(found as usize) else {
                    let vertices = self.vertices.len();
                    return Err(GeometryError::Index { triangle, found, vertices });
                };
                if !point.iter().all(|x| x.is_finite()) {
                    return Err(GeometryError::NotFinite { triangle, found: point });
                }
            }
        }
        Ok(())
    }
}
