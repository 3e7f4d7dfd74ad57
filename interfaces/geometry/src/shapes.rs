//! Triangles of simple shapes.
//!
//! A round shape becomes a polygon or polyhedron with *the same volume*. A slightly bumpy cylinder
//! or sphere has, to first order, the drag of the round one whose radius is its mean radius, as the
//! bumps of higher order contribute at second order only (for the sphere: Brenner, *Chem. Eng.
//! Sci.* 19 (1964) 519); and equal volume makes the mean radius equal to second order. An inscribed
//! shape, the usual choice, has a mean radius that is too small.

use crate::edges::pair;
use crate::moments::signed_volume;
use crate::vector::unit;
use crate::{GeometryError, Mesh, Vec3};
use std::f64::consts::PI;

/// Sides of a cylinder. The surface is within -2.6e-5 and +5.1e-5 of the radius; volume and area of
/// the cross-section are exact.
pub const CYLINDER_SEGMENTS: u32 = 256;

/// Number of times that the triangles of an icosahedron are divided in four for a sphere: 20,480
/// triangles. The surface is within -1.1e-4 and +1.9e-4 of the radius; the volume is exact.
pub const SPHERE_LEVELS: u32 = 5;

/// A box about the origin, with edge lengths `size` [m].
pub fn cuboid(size: Vec3) -> Result<Mesh, GeometryError> {
    for edge in size.iter() {
        positive("an edge of the box", *edge)?;
    }
    let corner =
        |i: u32| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { 0.5 * size[k] } else { -0.5 * size[k] });
    // Corner i is at the high end of axis k if bit k is set; sides anticlockwise seen from outside.
    const SIDES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Ok(Mesh { vertices: (0..8).map(corner).collect(), triangles })
}

/// A cylinder about the z axis, its middle at the origin [m].
pub fn cylinder(radius: f64, length: f64) -> Result<Mesh, GeometryError> {
    positive("the radius of the cylinder", radius)?;
    positive("the length of the cylinder", length)?;
    let n = CYLINDER_SEGMENTS;
    let step = 2.0 * PI / f64::from(n);
    // The area of the polygon with corners at this radius is that of the circle.
    let corners = radius * (step / libm::sin(step)).sqrt();
    let ring = |z: f64| {
        (0..n).map(move |k| {
            let (sin, cos) = libm::sincos(step * f64::from(k));
            Vec3::new(corners * cos, corners * sin, z)
        })
    };
    let (low, high) = (-0.5 * length, 0.5 * length);
    let mut vertices: Vec<Vec3> = ring(low).chain(ring(high)).collect();
    vertices.extend([Vec3::new(0.0, 0.0, low), Vec3::new(0.0, 0.0, high)]);
    let (floor, roof) = (2 * n, 2 * n + 1);
    let triangles = (0..n)
        .flat_map(|k| {
            let (a, b) = (k, (k + 1) % n);
            let (c, d) = (a + n, b + n);
            [[a, b, d], [a, d, c], [floor, b, a], [roof, c, d]]
        })
        .collect();
    Ok(Mesh { vertices, triangles })
}

/// A sphere about the origin [m].
pub fn sphere(radius: f64) -> Result<Mesh, GeometryError> {
    positive("the radius of the sphere", radius)?;
    let mut mesh = icosahedron();
    for _ in 0..SPHERE_LEVELS {
        mesh = divided(&mesh);
    }
    let triangles = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
    let volume = signed_volume(triangles, Vec3::zeros());
    mesh.scale(radius * libm::cbrt(4.0 / 3.0 * PI / volume));
    Ok(mesh)
}

/// The icosahedron with corners at distance one.
fn icosahedron() -> Mesh {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let signs = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let on = |axis: usize, [s, g]: [f64; 2]| {
        let mut p = [0.0; 3];
        p[axis] = s;
        p[(axis + 1) % 3] = g * golden;
        unit(p.into()).expect("not at the origin")
    };
    let vertices = (0..3).flat_map(|axis| signs.map(|s| on(axis, s))).collect();
    #[rustfmt::skip]
    let triangles = vec![
        [0, 4, 1], [0, 1, 6], [0, 8, 4], [0, 6, 9], [0, 9, 8],
        [1, 4, 10], [1, 11, 6], [1, 10, 11], [2, 3, 5], [2, 7, 3],
        [2, 5, 8], [2, 9, 7], [2, 8, 9], [3, 10, 5], [3, 7, 11],
        [3, 11, 10], [4, 8, 5], [4, 5, 10], [6, 7, 9], [6, 11, 7],
    ];
    Mesh { vertices, triangles }
}

/// Every triangle divided in four, the new vertices at distance one.
fn divided(mesh: &Mesh) -> Mesh {
    let twins = pair(&mesh.triangles).twins;
    let mut vertices = mesh.vertices.clone();
    let mut middle = vec![0; twins.len()];
    for (h, &twin) in twins.iter().enumerate() {
        middle[h] = if (twin as usize) < h {
            middle[twin as usize]
        } else {
            let [a, b, c] = mesh.corners(h / 3);
            let [from, to] = [[a, b], [b, c], [c, a]][h % 3];
            vertices.push(unit(from + ((to + (from * -1.0)) * (0.5))).expect("not at the origin"));
            vertices.len() as u32 - 1
        };
    }
    let four = |(t, &[a, b, c]): (usize, &[u32; 3])| {
        let [ab, bc, ca] = [middle[3 * t], middle[3 * t + 1], middle[3 * t + 2]];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let triangles = mesh.triangles.iter().enumerate().flat_map(four).collect();
    Mesh { vertices, triangles }
}

/// A length that must be finite and greater than zero.
pub fn positive(what: &'static str, found: f64) -> Result<(), GeometryError> {
    if found > 0.0 && found.is_finite() {
        Ok(())
    } else {
        Err(GeometryError::Length { what, found })
    }
}
