//! Corners of a file that are damaged numbers.
//!
//! One of them makes the box of a part so large that everything else in it looks like one point;
//! what is wrong with the surface then is not what is wrong with the file.

use crate::{Bounds, GeometryError, Mesh, Vec3};

/// A corner this many times as far from the others as these are from each other is no part of the
/// shape.
const RATIO: f64 = 1e5;
/// Nothing is so far away [m].
const BEYOND: f64 = 1e9;

/// A corner far from most others; `None` where there is none. A file may mean it, so this is for
/// one that is no good as it is. Numbers are in the file's unit.
pub fn corner(mesh: &Mesh) -> Option<GeometryError> {
    let count = mesh.vertices.len();
    let bounds = mesh.bounds();
    // Halves, so that the greatest numbers do not overflow.
    let extent = (0..3).map(|k| 0.5 * bounds.max[k] - 0.5 * bounds.min[k]).fold(0.0, f64::max);
    let limit = 2.0 * (extent / RATIO);
    let near = |p: &Vec3, q: &Vec3| (0..3).all(|k| (p[k] - q[k]).abs() <= limit);
    // Of three corners one at least is among the many, if few are astray.
    let references = [0, count / 3, 2 * count / 3].into_iter().filter_map(|v| mesh.vertices.get(v));
    for reference in references {
        let others = mesh.vertices.iter().filter(|p| near(p, reference)).count();
        if 2 * others < count || others == count {
            continue;
        }
        let many = Bounds::of(mesh.vertices.iter().filter(|p| near(p, reference)).copied());
        let within = many.diagonal();
        let is_astray = |v: &&u32| !near(&mesh.vertices[**v as usize], reference);
        let (at, v) = mesh
            .triangles
            .iter()
            .enumerate()
            .find_map(|(t, corners)| Some((t, *corners.iter().find(is_astray)?)))?;
        return Some(GeometryError::Stray {
            triangle: at + 1,
            found: mesh.vertices[v as usize],
            others,
            within,
        });
    }
    None
}

/// A corner that is farther away than anything is; `unit` is what one of the file is [m].
pub fn beyond(mesh: &Mesh, unit: f64) -> Option<GeometryError> {
    let away = |v: u32| {
        mesh.vertices[v as usize].iter().fold(0.0, |most: f64, x| most.max((x * unit).abs()))
    };
    let (at, v) = mesh
        .triangles
        .iter()
        .enumerate()
        .find_map(|(t, corners)| Some((t, *corners.iter().find(|v| away(**v) > BEYOND)?)))?;
    Some(GeometryError::Far { triangle: at + 1, found: mesh.vertices[v as usize], away: away(v) })
}
