//! Pressure of polyhedra: integrals of the depth over the surfaces inside them.
//!
//! Let `d(x)` be how deep a point lies in a convex body, the least of its depths under the faces.
//! Of two bodies A and B that overlap,
//!
//! ```text
//! W = kappa (int d_A dV + int d_B dV)       over the overlap
//! ```
//!
//! is the energy, and the forces are its derivatives, all of them integrals over polygons:
//!
//! ```text
//! F on A = kappa (int d_A n_B dS - int d_B n_A dS)    over the surface of B in A, and of A in B
//! ```
//!
//! and the torque likewise with `x x n`. So whatever bodies do without friction and dashpots, no
//! energy is made: force and torque are continuous, face on face is a spring that resists rocking
//! too, and there is no point of contact to jump. Action equals reaction term by term. For a
//! surface of something else, walls and triangles, only the first integral is there (in the spirit
//! of elastic foundations, Elandt, Drumwright, Sherman & Ruina, IROS 2019, and of energies as
//! functions of the overlap, Feng, *Comput. Methods Appl. Mech. Eng.* 373, 2021).
//!
//! Nothing is iterated: polygons are clipped by planes, and where `d` changes from one face to
//! another the polygon is cut. So no result depends on where a search for closest points gives up.

use super::shape::Solid;
use crate::Vec3;
use tremie_geometry::Convex;

/// Room for the corners of a polygon: those of a face, and one more for each cut.
const MOST: usize = Convex::MOST_CORNERS + 2 * Convex::MOST_FACES + 4;

/// Clips a convex polygon to the half space where a linear function is not negative, into `out`.
pub(super) fn clip(polygon: &[Vec3], value: impl Fn(Vec3) -> f64, out: &mut Vec<Vec3>) {
    out.clear();
    let Some(&last) = polygon.last() else { return };
    let (mut from, mut of_from) = (last, value(last));
    for &to in polygon {
        let of_to = value(to);
        if (of_from < 0.0) != (of_to < 0.0) {
            // From the corner outside: an edge is cut at the same place from either end.
            out.push(if of_from < 0.0 {
                from + (to - from) * (of_from / (of_from - of_to))
            } else {
                to + (from - to) * (of_to / (of_to - of_from))
            });
        }
        if of_to >= 0.0 {
            out.push(to);
        }
        (from, of_from) = (to, of_to);
    }
}

/// Planes that bound a convex region: unit normals outward, and depths of the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes<'a> {
    solid: Solid<'a>,
    /// Position of the body [m].
    at: Vec3,
}

impl<'a> Planes<'a> {
    /// Planes of a body whose centroid is at a place.
    pub fn of(solid: Solid<'a>, at: Vec3) -> Self {
        Self { solid, at }
    }

    pub(super) fn count(&self) -> usize {
        self.solid.normals.len()
    }

    /// Depth of a point under a face [m].
    #[inline(always)]
    pub(super) fn depth(&self, face: usize, x: Vec3) -> f64 {
        self.solid.depth(face, x - self.at)
    }
}

/// Pressure on a body, over the stiffness: `kappa` times the integrals is the load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Press {
    /// `int d n dS` [m³].
    pub force: Vec3,
    /// `int d x x n dS` [m⁴].
    pub torque: Vec3,
    /// `int d dS` and `int d x dS`.
    weight: f64,
    first: Vec3,
    /// `int n dS` [m²].
    pub area: Vec3,
    /// `int dS`, `int x dS` and `int x x dS`, the last as xx, yy, zz, xy, xz, yz.
    plain: f64,
    middle: Vec3,
    second: [f64; 6],
    /// Largest depth [m].
    pub deepest: f64,
}

impl Press {
    pub const NONE: Self = Self {
        force: Vec3::new(0.0, 0.0, 0.0),
        torque: Vec3::new(0.0, 0.0, 0.0),
        weight: 0.0,
        first: Vec3::new(0.0, 0.0, 0.0),
        area: Vec3::new(0.0, 0.0, 0.0),
        plain: 0.0,
        middle: Vec3::new(0.0, 0.0, 0.0),
        second: [0.0; 6],
        deepest: 0.0,
    };

    /// True if the pressure is not zero.
    pub fn acts(&self) -> bool {
        self.weight > 0.0
    }

    /// Integral of the depth [m³].
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The middle of the load: a point, about which friction acts [m].
    pub fn centre(&self) -> Vec3 {
        self.first / self.weight
    }

    /// Mean of `x x^T` of the loaded surface about a point [m²], applied to a vector.
    pub fn spread(&self, about: Vec3, v: Vec3) -> Vec3 {
        let [xx, yy, zz, xy, xz, yz] = self.second;
        let around = Vec3::new(
            xx * v.x + xy * v.y + xz * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z,
        );
        let along = about.dot(&v);
        let shift = about * self.middle.dot(&v) + self.middle * along;
        (around - shift) / self.plain + about * along
    }

    /// Mean square distance of the loaded surface from a line through a point [m²].
    pub fn square_radius(&self, about: Vec3, direction: Vec3) -> f64 {
        let [xx, yy, zz, ..] = self.second;
        let mean = self.middle / self.plain;
        let trace = (xx + yy + zz) / self.plain - 2.0 * about.dot(&mean) + about.norm_squared();
        (trace - direction.dot(&self.spread(about, direction))).max(0.0)
    }

    /// Adds pressure at another place.
    pub fn merge(&mut self, other: &Self) {
        self.force += other.force;
        self.torque += other.torque;
        self.weight += other.weight;
        self.first += other.first;
        self.area += other.area;
        self.plain += other.plain;
        self.middle += other.middle;
        for (sum, more) in self.second.iter_mut().zip(other.second) {
            *sum += more;
        }
        self.deepest = self.deepest.max(other.deepest);
    }

    /// Adds a triangle with the depths of its corners; `n` is the direction in which it presses.
    #[inline(always)]
    fn add(&mut self, corners: [Vec3; 3], depths: [f64; 3], n: Vec3, area: f64) {
        let [a, b, c] = corners;
        let sum = a + b + c;
        let total = depths[0] + depths[1] + depths[2];
        let weight = area * total / 3.0;
        let first = (sum * total + a * depths[0] + b * depths[1] + c * depths[2]) * (area / 12.0);
        self.weight += weight;
        self.first += first;
        self.force += n * weight;
        self.torque += first.cross(&n);
        self.area += n * area;
        self.plain += area;
        self.middle += sum * (area / 3.0);
        let twelfth = area / 12.0;
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        for (second, (i, j)) in self.second.iter_mut().zip(pairs) {
            let corners = a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
            *second += twelfth * (corners + sum[i] * sum[j]);
        }
    }
}

/// Room to work in.
#[derive(Clone, Debug)]
pub(crate) struct OverlapRoom {
    /// The convex polygon that is looked at.
    pub polygon: Vec<Vec3>,
    pub(super) spare: Vec<Vec3>,
    piece: Vec<Vec3>,
}

impl Default for OverlapRoom {
    fn default() -> Self {
        let room = || Vec::with_capacity(MOST);
        Self { polygon: room(), spare: room(), piece: room() }
    }
}

/// Integrand over the pieces of a polygon, each under one face of the body.
pub(crate) trait Pieces {
    /// A piece of a polygon, with the depths of points under the face, and the face.
    fn piece(&mut self, points: &[Vec3], depth: impl Fn(Vec3) -> f64, face: usize);
}

impl OverlapRoom {
    /// Visits the parts of `self.polygon` in a body, piece by piece: each under the face that it is
    /// closest to.
    pub fn visit(&mut self, planes: &Planes<'_>, pieces: &mut impl Pieces) {
        for face in 0..planes.count() {
            let ends = self.ends(planes, face);
            if ends[1] <= 0.0 {
                return;
            }
            if ends[0] < 0.0 {
                clip(&self.polygon, |x| planes.depth(face, x), &mut self.spare);
                std::mem::swap(&mut self.polygon, &mut self.spare);
                if self.polygon.len() < 3 {
                    return;
                }
            }
        }
        // Nothing lies deeper than this, so that faces farther away are nowhere the closest.
        let mut range = [[0.0; 2]; Convex::MOST_FACES];
        let mut deepest = f64::INFINITY;
        for face in 0..planes.count() {
            range[face] = self.ends(planes, face);
            deepest = deepest.min(range[face][1]);
        }
        let mut close = [0u8; Convex::MOST_FACES];
        let mut count = 0;
        for face in 0..planes.count() {
            if range[face][0] <= deepest {
                close[count] = face as u8;
                count += 1;
            }
        }
        let close = &close[..count];
        for &face in close {
            let face = face as usize;
            self.piece.clone_from(&self.polygon);
            for &other in close {
                let other = other as usize;
                if other == face || range[face][1] <= range[other][0] {
                    continue;
                }
                let beyond = |x| planes.depth(other, x) - planes.depth(face, x);
                clip(&self.piece, beyond, &mut self.spare);
                std::mem::swap(&mut self.piece, &mut self.spare);
                if self.piece.len() < 3 {
                    break;
                }
            }
            if self.piece.len() >= 3 {
                pieces.piece(&self.piece, |x| planes.depth(face, x), face);
            }
        }
    }

    fn ends(&self, planes: &Planes<'_>, face: usize) -> [f64; 2] {
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for &x in &self.polygon {
            let depth = planes.depth(face, x);
            ends = [ends[0].min(depth), ends[1].max(depth)];
        }
        ends
    }
}

/// Adds up pressure along a direction.
pub(crate) struct OverlapSum<'a> {
    pub press: &'a mut Press,
    /// Outward normal of the polygon.
    pub normal: Vec3,
    /// 1 if the load is along it, -1 if against.
    pub sign: f64,
}

impl Pieces for OverlapSum<'_> {
    fn piece(&mut self, points: &[Vec3], depth: impl Fn(Vec3) -> f64, _face: usize) {
        let (first, rest) = (points[0], &points[1..]);
        let of_first = depth(first);
        self.press.deepest = self.press.deepest.max(of_first);
        let mut of_last = depth(rest[0]);
        self.press.deepest = self.press.deepest.max(of_last);
        for pair in rest.windows(2) {
            let of_next = depth(pair[1]);
            self.press.deepest = self.press.deepest.max(of_next);
            let cross = (pair[0] - first).cross(&(pair[1] - first));
            let area = 0.5 * cross.dot(&self.normal);
            let depths = [of_first, of_last, of_next];
            self.press.add([first, pair[0], pair[1]], depths, self.normal * self.sign, area);
            of_last = of_next;
        }
    }
}
