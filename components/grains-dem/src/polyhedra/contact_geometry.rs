//! Pressure integrals of a polyhedron against other polyhedra, walls and triangles of parts.

use super::{
    overlap_integrals::{OverlapRoom, OverlapSum, Planes, Press},
    shape::Solid,
};
use crate::Vec3;
use tremie_grains_kit::space::wall_triangle::{Grooves, Triangle, closest_point};

/// Pressure of body b, displaced by `way` from a, on a: all vectors from a's centroid.
pub(crate) fn of_solids(a: Solid<'_>, b: Solid<'_>, way: Vec3, room: &mut OverlapRoom) -> Press {
    let mut press = Press::NONE;
    if apart(a, b, way) || apart(b, a, -way) {
        return press;
    }
    let (of_a, of_b) = (Planes::of(a, Vec3::zeros()), Planes::of(b, way));
    faces_within(b, way, &of_a, 1.0, room, &mut press);
    faces_within(a, Vec3::zeros(), &of_b, -1.0, room, &mut press);
    press
}

/// Adds the faces of one body, at a place, as far as they lie in another. What presses is along
/// their outward normals, or against.
fn faces_within(
    one: Solid<'_>,
    at: Vec3,
    other: &Planes<'_>,
    sign: f64,
    room: &mut OverlapRoom,
    press: &mut Press,
) {
    for face in 0..one.shape.faces() {
        let corners = one.shape.corners(face).iter();
        room.polygon.clear();
        room.polygon.extend(corners.map(|&k| one.vertices[k as usize] + at));
        room.visit(other, &mut OverlapSum { press, normal: one.normals[face], sign });
    }
}

/// True if a face of a separates it from b, displaced by `way` from a.
fn apart(a: Solid<'_>, b: Solid<'_>, way: Vec3) -> bool {
    (0..a.shape.faces()).any(|face| {
        let n = a.normals[face];
        let reach = a.shape.offsets[face] * a.size - n.dot(&way);
        b.vertices.iter().all(|v| n.dot(v) >= reach)
    })
}

/// Pressure of a plane on a body: `normal` points to the bodies, `height` is that of the centroid
/// over the plane [m].
pub(crate) fn of_plane(a: Solid<'_>, normal: Vec3, height: f64, room: &mut OverlapRoom) -> Press {
    let mut press = Press::NONE;
    if a.support(-normal) <= height {
        return press;
    }
    square(normal, height, a.shape.circumradius * a.size, &mut room.polygon);
    room.visit(
        &Planes::of(a, Vec3::zeros()),
        &mut OverlapSum { press: &mut press, normal, sign: 1.0 },
    );
    press
}

/// The part of a plane that a body can cut, as a square.
pub(super) fn square(normal: Vec3, height: f64, radius: f64, out: &mut Vec<Vec3>) {
    let axis = normal.iamin();
    let u = Vec3::ith(axis, 1.0).cross(&normal);
    let u = u * (2.0 * radius / u.norm_squared().sqrt());
    let v = normal.cross(&u);
    let foot = normal * -height;
    out.clear();
    out.extend([foot - u - v, foot + u - v, foot + u + v, foot - u + v]);
}

/// Adds the pressure of a triangle on a body, its corners from the body's centroid.
pub(crate) fn of_triangle(
    a: Solid<'_>,
    triangle: &Triangle,
    room: &mut OverlapRoom,
    press: &mut Press,
) {
    let height = -triangle.corners[0].dot(&triangle.normal);
    if a.support(-triangle.normal) <= height {
        return;
    }
    room.polygon.clear();
    room.polygon.extend(triangle.corners);
    let planes = Planes::of(a, Vec3::zeros());
    room.visit(&planes, &mut OverlapSum { press, normal: triangle.normal, sign: 1.0 });
}

/// Pressure of a convex polygon on a body; corners are given from the body's centroid.
pub(crate) fn of_polygon(
    a: Solid<'_>,
    polygon: &[Vec3],
    normal: Vec3,
    room: &mut OverlapRoom,
) -> Press {
    let mut press = Press::NONE;
    room.polygon.clear();
    room.polygon.extend(polygon);
    let planes = Planes::of(a, Vec3::zeros());
    room.visit(&planes, &mut OverlapSum { press: &mut press, normal, sign: 1.0 });
    press
}

/// Closest point of a body to a sphere: the distance of the sphere's centre from the body [m], and
/// the unit vector from that point to the centre. With the centre inside: the negative depth under
/// the closest face, and that face's normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest {
    pub normal: Vec3,
    pub distance: f64,
}

/// The closest point of a body to a centre, by its faces, none searched for: of each face the point
/// of the polygon, by its triangles.
pub(crate) fn closest(a: Solid<'_>, centre: Vec3) -> Closest {
    let depth = |face: usize| (a.depth(face, centre), face);
    let nearer = |x: (f64, usize), y: (f64, usize)| if y.0 < x.0 { y } else { x };
    let (least, face) = (0..a.shape.faces()).map(depth).fold((f64::INFINITY, 0), nearer);
    if least > 0.0 {
        let normal = a.normals[face];
        return Closest { normal, distance: -least };
    }
    let mut best = (f64::INFINITY, Vec3::zeros());
    for face in 0..a.shape.faces() {
        // The closest point lies on a face that is seen from the centre.
        if a.depth(face, centre) > 0.0 {
            continue;
        }
        let corner = |k: u32| a.vertices[k as usize];
        let corners = a.shape.corners(face);
        for pair in corners[1..].windows(2) {
            let corners = [corner(corners[0]), corner(pair[0]), corner(pair[1])];
            let (normal, grooves) = (a.normals[face], Grooves::NONE);
            let triangle = Triangle { corners, normal, grooves };
            let point = closest_point(centre, &triangle);
            let square = (centre - point).norm_squared();
            if square < best.0 {
                best = (square, point);
            }
        }
    }
    let distance = best.0.sqrt();
    let away = centre - best.1;
    let normal = if distance > 0.0 { away / distance } else { a.normals[face] };
    Closest { normal, distance }
}
