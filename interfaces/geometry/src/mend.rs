//! From the triangles of a file to a closed surface with normals outward.

use crate::caps::flip_caps;
use crate::edges::pair;
use crate::nesting::orient_shells;
use crate::orient::agree_on_sides;
use crate::weld::{drop_collapsed, weld_equal, weld_near};
use crate::{GeometryError, Mesh};

/// Repairs that made a mesh a closed surface with normals outward.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Repairs {
    /// Vertices that were united with another at the very same place. An STL file has about five
    /// for each that remains.
    pub welded: usize,
    /// Vertices that were united with another nearby.
    pub welded_near: usize,
    /// Tolerance of that [m], zero where none was needed.
    pub tolerance: f64,
    /// Triangles that were dropped because two of their corners were one.
    pub dropped: usize,
    /// Triangles with hardly any height whose longest edge was exchanged for the other diagonal.
    pub flipped: usize,
    /// Triangles that were turned round.
    pub turned: usize,
    /// Connected pieces of surface.
    pub shells: usize,
    /// Greatest coordinate of a surface that lies so far from the origin of its frame that single
    /// precision would not hold it there [m]; zero of others.
    pub offset: f64,
}

impl std::fmt::Display for Repairs {
    /// The repairs in words; "nothing" if the mesh was right as it was.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let near = format!("vertices united with another within {:.1e} m", self.tolerance);
        let done = [
            (self.welded_near, near.as_str()),
            (self.dropped, "triangles without area dropped"),
            (self.turned, "triangles turned round"),
            (self.flipped, "triangles without height given to their neighbours"),
        ];
        let done = done.iter().filter(|(count, _)| *count > 0);
        let words: Vec<String> = done.map(|(count, what)| format!("{count} {what}")).collect();
        f.write_str(if words.is_empty() { "nothing" } else { "" })?;
        f.write_str(&words.join(", "))?;
        if self.offset > 0.0 {
            write!(
                f,
                "; it lies {:.3e} m from the origin of its file, where single precision, of binary STL files and of \
                 text with few digits, is {:.1e} m: numbers are kept in double precision, but what the file rounded is lost",
                self.offset,
                self.offset * f64::from(f32::EPSILON)
            )?;
        }
        Ok(())
    }
}

/// Vertices may differ by this part of the largest coordinate and still be meant as one: four
/// roundings to single precision, in which STL files store them.
const NEAR: f64 = 4.0 / (1u64 << 23) as f64;

/// A surface that lies this many of its sizes away from the origin is measured by its size.
const FAR: f64 = 100.0;

/// Makes a closed surface of triangles: unites vertices, drops triangles without area, turns
/// triangles so that normals point outward.
///
/// Vertices are united where they are equal; if that leaves open edges, also where they are within
/// 5e-7 of the largest coordinate (of a surface that lies far from the origin first of its own
/// size). Windings are made to agree across edges; then each shell is turned outward, or inward if
/// an odd number of other shells holds all its vertices.
///
/// # Errors
/// [`GeometryError::Faults`] for a surface with holes, with edges of more than two triangles, with
/// one side, or without volume; and numbers that are no points.
pub fn mend(mut mesh: Mesh) -> Result<(Mesh, Repairs), GeometryError> {
    mesh.check_numbers()?;
    let mut repairs = Repairs::default();
    let found = mesh.triangles.len();
    repairs.welded = weld_equal(&mut mesh);
    repairs.dropped = drop_collapsed(&mut mesh);
    let bounds = mesh.bounds();
    let size = 0.5 * bounds.diagonal();
    let mut tolerance = NEAR * bounds.magnitude();
    let mut edges = pair(&mesh.triangles);
    if bounds.magnitude() > FAR * size {
        // In their own midst numbers are finer than single precision far from it: first as finely
        // as they may be meant.
        repairs.offset = bounds.magnitude();
        tolerance = NEAR * size;
        if !edges.open.is_empty() {
            repairs.tolerance = tolerance;
            repairs.welded_near = weld_near(&mut mesh, tolerance);
            repairs.dropped += drop_collapsed(&mut mesh);
            edges = pair(&mesh.triangles);
            tolerance = NEAR * bounds.magnitude();
        }
    }
    if !edges.open.is_empty() {
        repairs.tolerance = tolerance;
        repairs.welded_near += weld_near(&mut mesh, tolerance);
        repairs.dropped += drop_collapsed(&mut mesh);
        edges = pair(&mesh.triangles);
    }
    if mesh.triangles.is_empty() {
        return Err(GeometryError::Empty { found });
    }
    let faults = edges.faults(&mesh, tolerance);
    if !faults.is_empty() {
        return Err(GeometryError::Faults(faults));
    }
    let wound = mesh.triangles.clone();
    let shells = agree_on_sides(&mut mesh, &edges)?;
    repairs.shells = shells.count;
    orient_shells(&mut mesh, &shells)?;
    repairs.turned = wound.iter().zip(&mesh.triangles).filter(|(a, b)| a != b).count();
    repairs.flipped = flip_caps(&mut mesh, tolerance);
    Ok((mesh, repairs))
}
