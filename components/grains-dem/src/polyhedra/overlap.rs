//! Overlap depth at the start of pairs with a polyhedron.

use super::{
    Polyhedra, contact_geometry,
    overlap_integrals::{OverlapRoom, Press},
    shape::Solid,
};
use crate::Vec3;
use crate::bodies::body_arrays::BoundingSphere;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::placed_parts::PlacedPart;
use tremie_grains_kit::space::solid_part::SolidPart;

/// Overlap of two bodies [m], the second `way` from the first, by the numbers of their polyhedra;
/// and the length that it is measured by. None without a polyhedron.
pub(crate) fn of_bodies(
    polyhedra: &Polyhedra,
    [a, b]: [(u32, &BoundingSphere); 2],
    way: Vec3,
    room: &mut OverlapRoom,
) -> Option<(f64, f64)> {
    let of_ball = |grain: u32, ball: &BoundingSphere, way: Vec3| {
        let solid = polyhedra.solid(grain as usize);
        let overlap = ball.radius - contact_geometry::closest(solid, way).distance;
        (overlap, ball.radius.min(solid.inradius()))
    };
    match [a.0, b.0] {
        [SPHERE, SPHERE] => None,
        [SPHERE, grain] => Some(of_ball(grain, a.1, -way)),
        [grain, SPHERE] => Some(of_ball(grain, b.1, way)),
        [one, other] => {
            let [one, other] = [one, other].map(|grain| polyhedra.solid(grain as usize));
            let press = contact_geometry::of_solids(one, other, way, room);
            Some((press.deepest, one.inradius().min(other.inradius())))
        }
    }
}

/// Overlap depth of a polyhedron at `x` in a part [m].
pub(crate) fn with_part(
    solid: Solid<'_>,
    x: Vec3,
    part: &PlacedPart,
    room: &mut OverlapRoom,
) -> f64 {
    let (clearance, _) = part.clearance(x);
    if clearance <= 0.0 {
        return solid.inradius();
    }
    let mut near = Vec::new();
    let reach = solid.shape.circumradius * solid.size;
    part.shape.triangles_near(part.shape.to_part(x), reach, &mut near);
    let mut press = Press::NONE;
    for triangle in near {
        let mut triangle = part.shape.placed_triangle(triangle);
        triangle.corners = triangle.corners.map(|corner| corner - x);
        contact_geometry::of_triangle(solid, &triangle, room, &mut press);
    }
    press.deepest
}
