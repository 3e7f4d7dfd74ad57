//! Energy of contacts of polyhedra: `int d dV` over the overlap.
//!
//! In the region of a body A where face i is the closest, `d` is the depth `h` under that face and
//! the gradient of d is `m`, the unit normal inward. That region is convex, and by the divergence
//! theorem
//!
//! ```text
//! int h dV = int h^2/2 m.n dS      over its faces: those of the other body, and where face j is as close
//! ```
//!
//! Face i itself adds nothing. Of the faces between regions i and j both sides together add
//! `(m_i - m_j).n h^2/2`, with n towards j.

use super::{
    contact_geometry::square,
    contact_pair::{Around, SolidPairEntry, SolidPairKind, stiffness},
    overlap_integrals::{OverlapRoom, Pieces, Planes, clip},
    shape::Solid,
    surfaces::{Bench, Owner, SurfacesBeside},
};
use crate::Vec3;
use crate::bodies::body_arrays::SPHERE;
use crate::contact::springs::Reduced;

/// Adds up `h^2/2 m.n` over the pieces of a polygon.
struct Half<'a> {
    sum: f64,
    solid: Solid<'a>,
    /// Outward normal of the polygon.
    normal: Vec3,
}

impl Pieces for Half<'_> {
    fn piece(&mut self, points: &[Vec3], depth: impl Fn(Vec3) -> f64, face: usize) {
        let share = -0.5 * self.solid.normals[face].dot(&self.normal);
        self.sum += share * of_square(points, self.normal, depth);
    }
}

/// Integral of the square of a linear function over a polygon.
fn of_square(points: &[Vec3], normal: Vec3, value: impl Fn(Vec3) -> f64) -> f64 {
    let first = points[0];
    let fan = points[1..].windows(2).map(|pair| {
        let area = 0.5 * (pair[0] - first).cross(&(pair[1] - first)).dot(&normal);
        let [a, b, c] = [value(first), value(pair[0]), value(pair[1])];
        area / 6.0 * (a * a + b * b + c * c + a * b + a * c + b * c)
    });
    fan.sum()
}

/// A plane: its normal outward, and `x . normal` of its points [m].
type FacePlane = (Vec3, f64);

/// A polygon with its normal, outward.
type Face = (Vec<Vec3>, Vec3);

/// The other side of an overlap: planes beyond which it is not, with normals outward.
struct Solids<'a> {
    planes: &'a [FacePlane],
}

impl Solids<'_> {
    /// Depth of a point under a plane [m].
    fn depth(&self, plane: usize, x: Vec3) -> f64 {
        let (normal, offset) = self.planes[plane];
        offset - normal.dot(&x)
    }
}

/// `int d dV` over the part of a body, its centroid in the origin, that lies behind all `planes`;
/// `faces` are their polygons, as far as they can reach into the body.
fn depth_within(
    a: Solid<'_>,
    planes: &[FacePlane],
    faces: impl Iterator<Item = Face>,
    room: &mut OverlapRoom,
) -> f64 {
    let own = Planes::of(a, Vec3::zeros());
    let mut sum = 0.0;
    for (polygon, normal) in faces {
        room.polygon.clear();
        room.polygon.extend(polygon);
        let mut half = Half { sum: 0.0, solid: a, normal };
        room.visit(&own, &mut half);
        sum += half.sum;
    }
    let other = Solids { planes };
    for i in 0..own.count() {
        for j in i + 1..own.count() {
            sum += between(a, &own, &other, [i, j], room);
        }
    }
    sum
}

/// Contribution of the plane between the regions of two faces.
fn between(
    a: Solid<'_>,
    own: &Planes<'_>,
    other: &Solids<'_>,
    [i, j]: [usize; 2],
    room: &mut OverlapRoom,
) -> f64 {
    // h_j - h_i vanishes there, and falls towards j.
    let apart = a.normals[j] - a.normals[i];
    let length = apart.norm_squared().sqrt();
    if length < 1e-12 {
        return 0.0;
    }
    let n = apart / length;
    let offset = (own.depth(j, Vec3::zeros()) - own.depth(i, Vec3::zeros())) / length;
    if offset.abs() > a.shape.circumradius * a.size {
        return 0.0;
    }
    square(n, -offset, 2.0 * a.shape.circumradius * a.size, &mut room.polygon);
    let mut keep = |value: &dyn Fn(Vec3) -> f64| {
        clip(&room.polygon, value, &mut room.spare);
        std::mem::swap(&mut room.polygon, &mut room.spare);
        room.polygon.len() >= 3
    };
    let inside = (0..other.planes.len()).all(|k| keep(&|x| other.depth(k, x)));
    let inside = inside && keep(&|x| own.depth(i, x));
    let closest = (0..own.count()).filter(|&k| k != i && k != j);
    let mut closest = closest.map(|k| keep(&|x| own.depth(k, x) - own.depth(i, x)));
    if !(inside && closest.all(|some| some)) {
        return 0.0;
    }
    let share = 0.5 * (a.normals[j] - a.normals[i]).dot(&n);
    share * of_square(&room.polygon, n, |x| own.depth(i, x))
}

/// Planes and polygons of a body at a place.
fn faces_of(b: Solid<'_>, at: Vec3) -> (Vec<FacePlane>, Vec<Face>) {
    let plane = |f: usize| (b.normals[f], b.shape.offsets[f] * b.size + b.normals[f].dot(&at));
    let corner = |&k: &u32| b.vertices[k as usize] + at;
    let polygon = |f: usize| (b.shape.corners(f).iter().map(corner).collect(), b.normals[f]);
    let faces = 0..b.shape.faces();
    (faces.clone().map(plane).collect(), faces.map(polygon).collect())
}

impl SolidPairEntry {
    /// Energy in the normal springs of a contact [J].
    pub(super) fn energy(&self, around: &Around<'_>, owners: &[Owner], bench: &mut Bench) -> f64 {
        let bodies = around.scenery.bodies;
        let solid = |place: u32| around.polyhedra.solid(bodies.poly[place as usize] as usize);
        let i = self.places[0] as usize;
        match self.key.1 {
            SolidPairKind::Body => {
                let room = &mut bench.room;
                let law = &around.scenery.laws[self.law as usize];
                let kappa = stiffness(law) / self.area;
                let [a, b] = self.places;
                let way = around.scenery.between(i, b as usize, self.image);
                let balls = self.places.map(|place| bodies.poly[place as usize] == SPHERE);
                let of_ball = |grain: u32, ball: u32, way: Vec3| {
                    let radius = bodies.balls[ball as usize].radius;
                    let overlap =
                        radius - super::contact_geometry::closest(solid(grain), way).distance;
                    let pair = Reduced { root_mass: self.root_mass, radius, ..Reduced::NONE };
                    law.normal_energy(overlap, pair)
                };
                match balls {
                    [true, _] => of_ball(b, a, -way),
                    [_, true] => of_ball(a, b, way),
                    _ => {
                        let of = |a: Solid<'_>, b: Solid<'_>, way: Vec3, room: &mut OverlapRoom| {
                            let (planes, faces) = faces_of(b, way);
                            depth_within(a, &planes, faces.into_iter(), room)
                        };
                        let both =
                            of(solid(a), solid(b), way, room) + of(solid(b), solid(a), -way, room);
                        // Two bodies press on each other, each with half of the stiffness.
                        0.5 * kappa * both
                    }
                }
            }
            SolidPairKind::Surfaces => {
                let beside = SurfacesBeside::new(around, i);
                let solid = beside.solid;
                beside.cover(owners, &mut bench.covers);
                let mut sum = 0.0;
                for o in 0..owners.len() {
                    let law = &around.scenery.laws[owners[o].law as usize];
                    let kappa = stiffness(law) / self.area;
                    beside.polygons((owners, o), bench, |(all, n), _, covers, room| {
                        sum += kappa
                            * match covers {
                                None => below(solid, all, n, room),
                                Some(covers) => {
                                    covers.pieces().map(|piece| below(solid, piece, n, room)).sum()
                                }
                            };
                    });
                }
                sum
            }
        }
    }
}

/// `int d dV` straight below a polygon with a normal.
fn below(a: Solid<'_>, polygon: &[Vec3], n: Vec3, room: &mut OverlapRoom) -> f64 {
    let mut planes = vec![(n, n.dot(&polygon[0]))];
    for k in 0..polygon.len() {
        let side = (polygon[(k + 1) % polygon.len()] - polygon[k]).cross(&n);
        planes.push((side, side.dot(&polygon[k])));
    }
    let face = std::iter::once((polygon.to_vec(), n));
    depth_within(a, &planes, face, room) + sides(a, polygon, n, room)
}

/// Contribution of the sides of the prism below a polygon.
fn sides(a: Solid<'_>, corners: &[Vec3], n: Vec3, room: &mut OverlapRoom) -> f64 {
    let deep = n * (-4.0 * a.shape.circumradius * a.size);
    let own = Planes::of(a, Vec3::zeros());
    let mut of = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        let normal = (to - from).cross(&n);
        let normal = normal / normal.norm_squared().sqrt();
        room.polygon.clear();
        room.polygon.extend([from + deep, to + deep, to, from]);
        let mut half = Half { sum: 0.0, solid: a, normal };
        room.visit(&own, &mut half);
        half.sum
    };
    (0..corners.len()).map(&mut of).sum()
}
