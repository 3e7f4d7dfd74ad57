//! Solids of revolution.

use crate::Vec3;
use crate::shapes::CYLINDER_SEGMENTS;
use crate::{GeometryError, Mesh};
use std::f64::consts::PI;

/// The surface that a profile of corners `[r, z]` [m] sweeps about the z axis.
///
/// Circles become polygons with the same area, so that a volume between corners is exact. Triangles
/// may face either way.
pub fn revolved(profile: &[[f64; 2]]) -> Result<Mesh, GeometryError> {
    check(profile)?;
    let step = 2.0 * PI / f64::from(CYLINDER_SEGMENTS);
    let stretch = (step / libm::sin(step)).sqrt();
    let mut mesh = Mesh::default();
    let rings: Vec<Ring> =
        profile.iter().map(|&[r, z]| Ring::new(&mut mesh, r * stretch, z)).collect();
    let closed = !is_on_axis(profile);
    let edges = rings.len() - usize::from(!closed);
    for k in 0..edges {
        join(&mut mesh, rings[k], rings[(k + 1) % rings.len()]);
    }
    Ok(mesh)
}

/// True if the axis closes a profile.
fn is_on_axis(profile: &[[f64; 2]]) -> bool {
    matches!((profile.first(), profile.last()), (Some([a, _]), Some([b, _])) if *a == 0.0 && *b == 0.0)
}

fn check(profile: &[[f64; 2]]) -> Result<(), GeometryError> {
    let wrong = |why: String| Err(GeometryError::Profile { why });
    if profile.len() < 3 {
        return wrong(format!("it has {} corners, but needs three or more", profile.len()));
    }
    let inner_on_axis = |k: usize| profile[k][0] == 0.0 && k != 0 && k + 1 != profile.len();
    for (k, [r, z]) in profile.iter().enumerate() {
        if !(r.is_finite() && z.is_finite()) {
            return wrong(format!("corner {k} is at [{r}, {z}] m, which is no point"));
        }
        if *r < 0.0 {
            return wrong(format!("corner {k} is at the radius {r} m, which is less than zero"));
        }
        if inner_on_axis(k) || (*r == 0.0 && !is_on_axis(profile)) {
            return wrong(format!(
                "corner {k} is on the axis: a profile touches it nowhere, or with its first and its last corner"
            ));
        }
    }
    let next = |k: usize| profile[(k + 1) % profile.len()];
    match (0..profile.len()).find(|&k| profile[k] == next(k)) {
        Some(k) => wrong(format!("corner {k} and the next are both at {:?} m", profile[k])),
        None => Ok(()),
    }
}

/// The vertices that a corner sweeps: many, or one on the axis.
#[derive(Clone, Copy)]
struct Ring {
    first: u32,
    on_axis: bool,
}

impl Ring {
    fn new(mesh: &mut Mesh, r: f64, z: f64) -> Self {
        let first = mesh.vertices.len() as u32;
        let on_axis = r == 0.0;
        let step = 2.0 * PI / f64::from(CYLINDER_SEGMENTS);
        let corners = if on_axis { 1 } else { CYLINDER_SEGMENTS };
        mesh.vertices.extend((0..corners).map(|k| {
            let (sin, cos) = libm::sincos(step * f64::from(k));
            Vec3::new(r * cos, r * sin, z)
        }));
        Self { first, on_axis }
    }

    fn at(self, k: u32) -> u32 {
        if self.on_axis { self.first } else { self.first + k % CYLINDER_SEGMENTS }
    }
}

fn join(mesh: &mut Mesh, low: Ring, high: Ring) {
    for k in 0..CYLINDER_SEGMENTS {
        let (a, b, c, d) = (low.at(k), low.at(k + 1), high.at(k), high.at(k + 1));
        if !low.on_axis {
            mesh.triangles.push([a, b, d]);
        }
        if !high.on_axis {
            mesh.triangles.push([a, d, c]);
        }
    }
}
