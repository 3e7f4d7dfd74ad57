//! Meshes to files.

use crate::Vec3;
use crate::vector::unit;
use crate::{GeometryError, Mesh};
use std::io::Write;
use stl_io::{Triangle, Vector};

impl Mesh {
    /// Writes the mesh as a binary STL file whose unit is `unit` metres. STL keeps single
    /// precision.
    ///
    /// # Errors
    /// [`GeometryError::Length`] for a unit that is none, [`GeometryError::NotFinite`] for a
    /// coordinate that single precision cannot hold, [`GeometryError::Write`].
    pub fn write_stl(&self, to: &mut impl Write, unit: f64) -> Result<(), GeometryError> {
        crate::shapes::positive("unit", unit)?;
        self.check_numbers()?;
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for t in 0..self.triangles.len() {
            triangles.push(self.single(t, unit)?);
        }
        stl_io::write_stl(to, triangles.iter())
            .map_err(|e| GeometryError::Write { why: e.to_string() })
    }

    /// A triangle in single precision.
    fn single(&self, triangle: usize, one: f64) -> Result<Triangle, GeometryError> {
        let corners @ [a, b, c] = self.corners(triangle);
        let vertices = corners.map(|p| p.map(|x| (x / one) as f32));
        if let Some(bad) = vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            return Err(GeometryError::NotFinite { triangle, found: corners[bad] });
        }
        let normal = unit((b - a).cross(&(c - a))).unwrap_or(Vec3::zeros());
        let vector = |v: nalgebra::Vector3<f32>| Vector(v.into());
        Ok(Triangle { normal: vector(normal.map(|x| x as f32)), vertices: vertices.map(vector) })
    }
}
