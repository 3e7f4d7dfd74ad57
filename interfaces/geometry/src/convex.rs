//! Convex polyhedra: hulls of few points, with exact faces, moments and principal axes.

use crate::vector::unit;
use crate::{Mesh, Moments, Vec3};
use core::f64::consts::PI;
use nalgebra::Matrix3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::{ConvexHullError, try_convex_hull};

/// A convex polyhedron in its own frame.
///
/// Faces are polygons, however many corners they have; coplanar triangles are one face.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    vertices: Vec<Vec3>,
    faces: Vec<ConvexFace>,
}

/// A face of a convex polyhedron.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexFace {
    /// Unit normal, outward.
    pub normal: Vec3,
    /// `x . normal` of its points [m].
    pub offset: f64,
    /// Its corners, as indices of vertices, anticlockwise seen from outside.
    pub corners: Vec<u32>,
}

/// Points that make no convex polyhedron.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConvexError {
    /// A coordinate that is infinite or no number.
    #[error("vertex {vertex} is no point")]
    NotFinite {
        /// Its number, from zero.
        vertex: usize,
    },
    /// Too few points, or all in a plane.
    #[error(
        "the {points} vertices enclose no volume: expected four or more that do not lie in one plane"
    )]
    Flat {
        /// Number of them.
        points: usize,
    },
    /// A point that the others enclose: the solid is not convex, or the point is none of its
    /// corners.
    #[error(
        "vertex {vertex} lies inside the hull of the others, by {depth:.3e} of their extent: expected a convex polyhedron"
    )]
    Inside {
        /// Its number, from zero.
        vertex: usize,
        /// Depth, over the extent.
        depth: f64,
    },
    /// More corners than contacts are made for.
    #[error("found {found} corners, expected at most {most}")]
    TooMany {
        /// Number found.
        found: usize,
        /// Number possible.
        most: usize,
    },
    /// More faces than contacts are made for.
    #[error("found {found} faces, expected at most {most}")]
    TooManyFaces {
        /// Number found.
        found: usize,
        /// Number possible.
        most: usize,
    },
    /// Faces so close to one plane that they cannot be told apart.
    #[error(
        "faces lie so close to one plane that they cannot be told apart: expected angles of more than about 1e-5 between them"
    )]
    Unclear,
    /// A closed surface that is not that of its hull.
    #[error("the surface encloses {found:.6} of the volume of its hull: expected a convex solid")]
    NotConvex {
        /// Its volume over that of the hull.
        found: f64,
    },
}

/// Distance from a plane that counts as in it, over the extent of the points: coordinates in single
/// precision round by a tenth of it.
const TOLERANCE: f64 = 1e-6;

/// Points farther inside than this, over the extent, are no rounding.
const INSIDE: f64 = 1e-5;

impl Convex {
    /// Most corners of a polyhedron.
    pub const MOST_CORNERS: usize = 60;

    /// Most faces of a polyhedron: as many as 32 corners have at most. A prism of 60 corners has 32.
    pub const MOST_FACES: usize = 60;

    /// The hull of points, each of which lies on it. Those that are no corner are left out.
    ///
    /// # Errors
    /// Points inside the hull of others or all in a plane, too many corners.
    pub fn hull<P: Into<Vec3> + Copy>(points: &[P]) -> Result<Self, ConvexError> {
        let points: Vec<Vec3> = points.iter().map(|point| (*point).into()).collect();
        if let Some(vertex) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(ConvexError::NotFinite { vertex });
        }
        let points = distinct(&points);
        if points.len() > 8 * Self::MOST_CORNERS {
            return Err(ConvexError::TooMany { found: points.len(), most: Self::MOST_CORNERS });
        }
        let extent = extent(&points);
        let planes = supporting_planes(&points, extent)?;
        if planes.len() < 4 {
            return Err(ConvexError::Flat { points: points.len() });
        }
        for (vertex, &p) in points.iter().enumerate() {
            let depth = planes.iter().map(|(n, o)| o - n.dot(&p)).fold(f64::INFINITY, f64::min);
            if depth > INSIDE * extent {
                return Err(ConvexError::Inside { vertex, depth: depth / extent });
            }
        }
        let faces = planes.iter().map(|&plane| face(&points, plane, extent)).collect();
        Self { vertices: points, faces }.of_corners()
    }

    /// The solid that a closed mesh encloses, if it is convex.
    ///
    /// # Errors
    /// As [`hull`](Self::hull), and surfaces that are not those of their hulls.
    pub fn of_mesh(mesh: &Mesh) -> Result<Self, ConvexError> {
        let own = Self::hull(&mesh.vertices)?;
        let found = mesh.moments().volume / own.moments().volume;
        let same = (found - 1.0).abs() < 1e-4;
        if same { Ok(own) } else { Err(ConvexError::NotConvex { found }) }
    }

    /// A prism over a convex outline in the plane across an axis of the world, `depth` long, from
    /// `-depth/2` to `depth/2` [m]. The outline's coordinates are along the other two axes, in their
    /// order.
    ///
    /// # Errors
    /// As [`hull`](Self::hull); vertices are numbered as the outline's.
    pub fn prism(outline: &[[f64; 2]], across: usize, depth: f64) -> Result<Self, ConvexError> {
        let others = match across {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        let corner = |&[u, v]: &[f64; 2], end: f64| {
            let mut corner = Vec3::zeros();
            (corner[others[0]], corner[others[1]], corner[across]) = (u, v, end * depth);
            corner
        };
        let ends = [-0.5, 0.5].map(|end| outline.iter().map(move |c| corner(c, end)));
        let corners: Vec<Vec3> = ends.into_iter().flatten().collect();
        let numbered = |error| match error {
            ConvexError::NotFinite { vertex } => {
                ConvexError::NotFinite { vertex: vertex % outline.len() }
            }
            other => other,
        };
        let own = Self::hull(&corners).map_err(numbered)?;
        // A corner that the others enclose lies on the ends, which says nothing.
        let sides = || own.faces.iter().filter(|face| face.normal[across].abs() < 0.5);
        let extent = extent(&corners[..outline.len()]);
        for (vertex, corner) in corners[..outline.len()].iter().enumerate() {
            let depth = sides()
                .map(|face| face.offset - face.normal.dot(corner))
                .fold(f64::INFINITY, f64::min);
            if depth > INSIDE * extent {
                return Err(ConvexError::Inside { vertex, depth: depth / extent });
            }
        }
        Ok(own)
    }

    /// Least width of its outline as a prism along an axis [m]: the least distance of two parallel
    /// planes along the axis that it fits between.
    pub fn least_width_across(&self, axis: usize) -> f64 {
        let sides = self.faces.iter().map(|face| face.normal).filter(|n| n[axis].abs() < 1e-6);
        sides.map(|n| self.width_along(n)).fold(f64::INFINITY, f64::min)
    }

    /// The same shape of unit size: as large as a sphere of diameter 1, its centroid in the origin.
    pub fn unit(&self) -> Self {
        let Moments { volume, centroid, .. } = self.moments();
        let factor = libm::cbrt(PI / 6.0 / volume);
        let mut own = self.clone();
        for v in &mut own.vertices {
            *v = (*v - centroid) * factor;
        }
        for face in &mut own.faces {
            face.offset = (face.offset - face.normal.dot(&centroid)) * factor;
        }
        own
    }

    /// Its corners.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Its faces.
    pub fn faces(&self) -> &[ConvexFace] {
        &self.faces
    }

    /// Its edges, as indices of vertices; each once.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.faces.iter().flat_map(|face| sides(&face.corners)).filter(|[a, b]| a < b)
    }

    /// Length of its longest edge [m].
    pub fn longest_edge(&self) -> f64 {
        let length =
            |[a, b]: [u32; 2]| (self.vertices[a as usize] - self.vertices[b as usize]).norm();
        self.edges().map(length).fold(0.0, f64::max)
    }

    /// The least distance of two parallel planes that it fits between [m]: one holds a face, or
    /// each an edge.
    pub fn least_width(&self) -> f64 {
        let along = |[a, b]: [u32; 2]| self.vertices[b as usize] - self.vertices[a as usize];
        let edges: Vec<Vec3> = self.edges().map(along).collect();
        let pairs = edges.iter().enumerate();
        let across = pairs.flat_map(|(k, &e)| edges[..k].iter().map(move |&f| e.cross(&f)));
        let faces = self.faces.iter().map(|face| face.normal);
        faces
            .chain(across.filter_map(unit))
            .map(|n| self.width_along(n))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance of the two planes across a unit vector that it fits between [m].
    pub fn width_along(&self, n: Vec3) -> f64 {
        let heights = self.vertices.iter().map(|&v| n.dot(&v));
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = heights.fold(range, |[l, h], x| [l.min(x), h.max(x)]);
        high - low
    }

    /// Distance of the farthest corner from the origin [m].
    pub fn circumradius(&self) -> f64 {
        self.vertices.iter().map(|&v| v.norm()).fold(0.0, f64::max)
    }

    /// Distance of the closest face from the origin [m].
    pub fn inradius(&self) -> f64 {
        self.faces.iter().map(|face| face.offset).fold(f64::INFINITY, f64::min)
    }

    /// Area of the largest face [m²].
    pub fn largest_face(&self) -> f64 {
        let area = |face: &ConvexFace| {
            let corner = |k: u32| self.vertices[k as usize];
            let first = corner(face.corners[0]);
            let fan = face.corners[1..].windows(2).fold(Vec3::zeros(), |sum, pair| {
                sum + (corner(pair[0]) - first).cross(&(corner(pair[1]) - first))
            });
            0.5 * fan.dot(&face.normal)
        };
        self.faces.iter().map(area).fold(0.0, f64::max)
    }

    /// Its faces as triangles, anticlockwise seen from outside.
    pub fn mesh(&self) -> Mesh {
        let fan = |face: &ConvexFace| {
            let first = face.corners[0];
            let pairs = face.corners[1..].windows(2);
            pairs.map(move |pair| [first, pair[0], pair[1]]).collect::<Vec<_>>()
        };
        let triangles = self.faces.iter().flat_map(fan).collect();
        Mesh { vertices: self.vertices.clone(), triangles }
    }

    /// Volume, area, centroid and inertia, exact but for rounding.
    pub fn moments(&self) -> Moments {
        self.mesh().moments()
    }

    /// Leaves out vertices that are no corner of any face, and checks that faces close.
    fn of_corners(mut self) -> Result<Self, ConvexError> {
        let is_corner = |k: u32| self.faces.iter().any(|face| face.corners.contains(&k));
        let kept: Vec<u32> = (0..self.vertices.len() as u32).filter(|&k| is_corner(k)).collect();
        for corner in self.faces.iter_mut().flat_map(|face| &mut face.corners) {
            *corner = kept.partition_point(|k| k < corner) as u32;
        }
        self.vertices = kept.iter().map(|&k| self.vertices[k as usize]).collect();
        if self.vertices.len() > Self::MOST_CORNERS {
            let (found, most) = (self.vertices.len(), Self::MOST_CORNERS);
            return Err(ConvexError::TooMany { found, most });
        }
        if self.faces.len() > Self::MOST_FACES {
            let (found, most) = (self.faces.len(), Self::MOST_FACES);
            return Err(ConvexError::TooManyFaces { found, most });
        }
        let all: Vec<[u32; 2]> = self.faces.iter().flat_map(|face| sides(&face.corners)).collect();
        let closed = all.iter().all(|&[a, b]| {
            all.iter().filter(|&&side| side == [b, a]).count() == 1
                && all.iter().filter(|&&side| side == [a, b]).count() == 1
        });
        let whole = self.faces.iter().all(|face| face.corners.len() >= 3);
        if closed && whole { Ok(self) } else { Err(ConvexError::Unclear) }
    }
}

/// Sides of a polygon, in its order.
fn sides(corners: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]])
}

/// The points without repetitions, in their order.
fn distinct(points: &[Vec3]) -> Vec<Vec3> {
    let near = 0.1 * TOLERANCE * extent(points);
    let mut kept: Vec<Vec3> = Vec::new();
    for &p in points {
        if !kept.iter().any(|&k| (p - k).norm() <= near) {
            kept.push(p);
        }
    }
    kept
}

/// Longest edge of the box around points.
fn extent(points: &[Vec3]) -> f64 {
    let along = |a: usize| {
        let ends = points
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p[a]), h.max(p[a])]);
        (ends[1] - ends[0]).max(0.0)
    };
    (0..3).map(along).fold(0.0, f64::max)
}

/// Planes that have all points on one side and hold a face of their hull: unit normal, outward, and
/// offset; in the order of the first points that lie in them.
///
/// The hull is parry's (quickhull); its triangles say which planes to try. 256 points take 1 ms,
/// where trying all triples of them took 1.2 s.
fn supporting_planes(points: &[Vec3], extent: f64) -> Result<Vec<(Vec3, f64)>, ConvexError> {
    let near = TOLERANCE * extent;
    // Parry leaves out points, and numbers those that it keeps anew.
    let own: Vec<Vector> = points.iter().map(|&p| Vector::from_array(p.into())).collect();
    let (corners, triangles) = match try_convex_hull(&own) {
        Ok(hull) => hull,
        Err(ConvexHullError::IncompleteInput | ConvexHullError::MissingSupportPoint) => {
            return Ok(Vec::new());
        }
        Err(_) => return Err(ConvexError::Unclear),
    };
    let mut planes: Vec<(Vec<usize>, (Vec3, f64))> = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|k| Vec3::from(corners[k as usize].to_array()));
        let (u, v) = (b - a, c - a);
        let n = u.cross(&v);
        // Three points almost in a line tell no plane.
        if n.norm() <= 1e-4 * u.norm() * v.norm() {
            continue;
        }
        let Some(normal) = unit(n) else { continue };
        let offset = normal.dot(&a);
        let height = |p: &Vec3| normal.dot(&(p - a));
        let known = |(_, (n, o)): &(Vec<usize>, (Vec3, f64))| {
            (n - normal).norm() < 1e-4 && (o - offset).abs() < 4.0 * near
        };
        if points.iter().all(|p| height(p) <= near) && !planes.iter().any(known) {
            let held = (0..points.len()).filter(|&k| height(&points[k]) >= -near).collect();
            planes.push((held, (normal, offset)));
        }
    }
    planes.sort_by(|(a, _), (b, _)| a.cmp(b));
    Ok(planes.into_iter().map(|(_, plane)| plane).collect())
}

/// The face of a plane: the hull of the points in it (Andrew's monotone chain, 1979).
fn face(points: &[Vec3], (normal, offset): (Vec3, f64), extent: f64) -> ConvexFace {
    let smallest = normal.iamin();
    let u = unit(Vec3::ith(smallest, 1.0).cross(&normal)).unwrap_or(Vec3::x());
    let v = normal.cross(&u);
    let in_plane = |p: Vec3| (normal.dot(&p) - offset).abs() <= 2.0 * TOLERANCE * extent;
    let mut flat: Vec<(f64, f64, u32)> = (0..)
        .zip(points)
        .filter(|(_, p)| in_plane(**p))
        .map(|(k, p)| (u.dot(p), v.dot(p), k))
        .collect();
    flat.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let turn = |a: &(f64, f64, u32), b: &(f64, f64, u32), c: &(f64, f64, u32)| {
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    };
    let least = TOLERANCE * extent * extent;
    let chain = |order: &mut dyn Iterator<Item = &(f64, f64, u32)>| {
        let mut chain: Vec<(f64, f64, u32)> = Vec::new();
        for point in order {
            while let [.., a, b] = &chain[..]
                && turn(a, b, point) <= least
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut flat.iter());
    corners.extend(chain(&mut flat.iter().rev()));
    let corners: Vec<u32> = corners.iter().map(|(_, _, k)| *k).collect();
    let corner = |k: u32| points[k as usize];
    // Newell's normal follows all corners, and the offset is their mean.
    let sum = sides(&corners).fold(Vec3::zeros(), |sum, [a, b]| sum + corner(a).cross(&corner(b)));
    let normal = unit(sum).unwrap_or(normal);
    let mean = corners.iter().map(|&k| normal.dot(&corner(k))).sum::<f64>();
    ConvexFace { normal, offset: mean / corners.len() as f64, corners }
}

/// Eigenvalues of a symmetric matrix, and its unit eigenvectors, a right-handed frame: Jacobi's
/// method. A matrix that is diagonal already keeps its axes.
pub fn principal(matrix: &Matrix3<f64>) -> ([f64; 3], [Vec3; 3]) {
    let mut m = *matrix;
    let mut axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let size = m.diagonal().abs().sum();
    // It converges quadratically: far fewer rounds than these do.
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[(p, q)].abs() <= 1e-15 * size {
                continue;
            }
            let theta = (m[(q, q)] - m[(p, p)]) / (2.0 * m[(p, q)]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for k in 0..3 {
                (m[(k, p)], m[(k, q)]) =
                    (c * m[(k, p)] - s * m[(k, q)], s * m[(k, p)] + c * m[(k, q)]);
            }
            for k in 0..3 {
                (m[(p, k)], m[(q, k)]) =
                    (c * m[(p, k)] - s * m[(q, k)], s * m[(p, k)] + c * m[(q, k)]);
                (axes[p][k], axes[q][k]) =
                    (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
            }
        }
    }
    axes[2] = axes[0].cross(&axes[1]);
    ([m[(0, 0)], m[(1, 1)], m[(2, 2)]], axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    /// Planes through three points with all others on one side, by trying all threes.
    fn by_all_triples(points: &[Vec3], near: f64) -> Vec<Vec<usize>> {
        let mut found = Vec::new();
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                for k in j + 1..points.len() {
                    let n = (points[j] - points[i]).cross(&(points[k] - points[i]));
                    let Some(n) = unit(n).filter(|_| n.norm() > 1e-3) else { continue };
                    let heights = points.iter().map(|p| n.dot(&(p - points[i])));
                    let heights: Vec<f64> = heights.collect();
                    let is_side = |s: f64| heights.iter().all(|h| s * h <= near);
                    let held = (0..points.len()).filter(|&p| heights[p].abs() <= near).collect();
                    if (is_side(1.0) || is_side(-1.0)) && !found.contains(&held) {
                        found.push(held);
                    }
                }
            }
        }
        found
    }

    #[test]
    fn a_prism_is_as_large_as_its_outline() {
        // A trapezium, its corners in no order.
        let outline = [[3.0, 2.0], [0.0, 0.0], [1.0, 2.0], [4.0, 0.0]];
        for across in 0..3 {
            let prism = Convex::prism(&outline, across, 0.5).unwrap();
            assert_eq!((prism.vertices().len(), prism.faces().len()), (8, 6));
            assert!((prism.moments().volume - 6.0 * 0.5).abs() < 1e-12);
            assert!((prism.least_width_across(across) - 2.0).abs() < 1e-12);
            assert!((prism.least_width() - 0.5).abs() < 1e-12);
        }
        let bent = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.5, 1.0]];
        let error = Convex::prism(&bent, 1, 1.0).unwrap_err();
        assert!(matches!(error, ConvexError::Inside { vertex: 4, .. }), "{error}");
    }

    proptest! {
        /// Blocks, their faces of four corners, some with points on them; turned anyhow.
        #[test]
        fn faces_are_those_that_all_triples_tell(
            size in prop::array::uniform3(0.3..1.0f64),
            turn in prop::array::uniform3(-3.0..3.0f64),
            on in prop::collection::vec((0usize..3, any::<bool>(), 0.1..0.9f64, 0.1..0.9f64), 0..8),
        ) {
            let turn = UnitQuaternion::from_scaled_axis(Vec3::from(turn));
            let corner = |k: usize| Vec3::from_fn(|a, _| (k >> a & 1) as f64);
            let on_face = |(axis, upper, s, t): (usize, bool, f64, f64)| {
                let mut place = Vec3::ith((axis + 1) % 3, s) + Vec3::ith((axis + 2) % 3, t);
                place[axis] = f64::from(u8::from(upper));
                place
            };
            let unturned = (0..8).map(corner).chain(on.into_iter().map(on_face));
            let place = |p: Vec3| turn * p.component_mul(&Vec3::from(size));
            let points: Vec<Vec3> = unturned.map(place).collect();
            let extent = extent(&points);
            let planes = supporting_planes(&points, extent).unwrap();
            let held = |(normal, offset): &(Vec3, f64)| {
                let height = |p: &Vec3| (normal.dot(p) - offset).abs();
                (0..points.len()).filter(|&p| height(&points[p]) <= TOLERANCE * extent).collect()
            };
            let found: Vec<Vec<usize>> = planes.iter().map(held).collect();
            prop_assert_eq!(found, by_all_triples(&points, TOLERANCE * extent));
        }
    }
}
