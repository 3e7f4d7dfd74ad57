//! The closest point of a surface, and which way the surface faces there.

use crate::exact::Corners;
use crate::inside::winding;
use crate::surface::Surface;
use crate::{Bounds, Vec3};

/// Part of a triangle: face, edge or corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Its inside.
    Face,
    /// The edge from this corner to the next, corners excluded.
    Edge(u8),
    /// This corner.
    Vertex(u8),
}

/// The point of a surface that is closest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point [m].
    pub point: Vec3,
    /// Its distance [m], negative for a point in the solid.
    pub distance: f64,
    /// Outward unit normal there. On an edge the mean of its two triangles, at a vertex the mean of
    /// its triangles weighted by their angles: the point in question is on the side to which it
    /// points (Baerentzen & Aanaes, *IEEE Trans. Vis. Comput. Graphics* 11 (2005) 243).
    pub normal: Vec3,
    /// A triangle that has the point; of several the first.
    pub triangle: u32,
    /// Part of that triangle.
    pub feature: Feature,
}

/// A candidate while searching.
#[derive(Clone, Copy)]
struct Nearest {
    squared: f64,
    point: Vec3,
    triangle: u32,
    feature: Feature,
}

impl Surface {
    /// The closest point of the surface. For a point that is none (not a number) its distance is
    /// none either.
    pub fn closest(&self, point: impl Into<Vec3>) -> Closest {
        self.closest_within(point, f64::INFINITY).unwrap_or_else(|| Closest {
            point: self.mesh.corners(0)[0],
            distance: f64::NAN,
            normal: self.normal(0),
            triangle: 0,
            feature: Feature::Vertex(0),
        })
    }

    /// The closest point of the surface, if it is no farther than `reach` [m].
    pub fn closest_within(&self, point: impl Into<Vec3>, reach: f64) -> Option<Closest> {
        let point = point.into();
        let mut best: Option<Nearest> = None;
        let mut farthest = reach * reach;
        self.tree.approach(point, farthest, |triangle, corners| {
            let is_far = Bounds::of(*corners).distance_squared(point) > farthest;
            if is_far || !self.is_wall(triangle) {
                return farthest;
            }
            let near = nearest_of(triangle, corners, self.mesh.triangles[triangle as usize], point);
            let better = match &best {
                Some(b) => (near.squared, triangle) < (b.squared, b.triangle),
                None => near.squared <= farthest,
            };
            if better {
                farthest = near.squared;
                best = Some(near);
            }
            farthest
        });
        best.map(|near| {
            let distance = near.squared.sqrt();
            Closest {
                point: near.point,
                distance: if self.contains(point) { -distance } else { distance },
                normal: self.normal_of(near.triangle, near.feature),
                triangle: near.triangle,
                feature: near.feature,
            }
        })
    }

    /// Distance to the surface [m], negative in the solid. Its sign agrees with
    /// [`Surface::contains`].
    pub fn signed_distance(&self, point: impl Into<Vec3>) -> f64 {
        self.closest(point).distance
    }

    /// True if a point is in the solid, its surface included. Exact for the triangles as they
    /// are; where solids overlap, it is in their union. For a cavity that is every point not
    /// strictly inside.
    pub fn contains(&self, point: impl Into<Vec3>) -> bool {
        winding(&self.tree, point.into()).is_solid(self.far)
    }

    fn normal_of(&self, triangle: u32, feature: Feature) -> Vec3 {
        match feature {
            Feature::Face => self.features.normal(triangle),
            Feature::Edge(i) => self.features.edge_normal(triangle, i),
            Feature::Vertex(i) => {
                let vertex = self.mesh.triangles[triangle as usize][i as usize];
                self.features.vertex_normal(vertex)
            }
        }
    }
}

/// The closest point of one triangle.
fn nearest_of(triangle: u32, corners: &Corners, names: [u32; 3], point: Vec3) -> Nearest {
    if let Some(on_face) = foot(corners, point) {
        let squared = (point - on_face).norm_squared();
        return Nearest { squared, point: on_face, triangle, feature: Feature::Face };
    }
    let on_edge = |i: usize| {
        let j = (i + 1) % 3;
        // The neighbour across the edge must get the same bits: both start at the same end.
        let (from, to) = if names[i] < names[j] { (i, j) } else { (j, i) };
        let along = corners[to] - corners[from];
        let (part, whole) = ((point - corners[from]).dot(&along), along.dot(&along));
        let (on_edge, feature) = if part <= 0.0 {
            (corners[from], Feature::Vertex(from as u8))
        } else if part >= whole {
            (corners[to], Feature::Vertex(to as u8))
        } else {
            (corners[from] + (along * (part / whole)), Feature::Edge(i as u8))
        };
        Nearest { squared: (point - on_edge).norm_squared(), point: on_edge, triangle, feature }
    };
    let [a, b, c] = [on_edge(0), on_edge(1), on_edge(2)];
    let nearer = |x: Nearest, y: Nearest| if y.squared < x.squared { y } else { x };
    nearer(nearer(a, b), c)
}

/// The foot of the perpendicular from a point to a triangle, if it is inside the triangle.
fn foot([a, b, c]: &Corners, point: Vec3) -> Option<Vec3> {
    let (ab, ac, ap) = (*b - *a, *c - *a, point - *a);
    let normal = ab.cross(&ac);
    let square = normal.dot(&normal);
    // Twice the areas of the triangles that the foot makes with the edges, times the normal's
    // length.
    let opposite_c = ab.cross(&ap).dot(&normal);
    let opposite_b = ap.cross(&ac).dot(&normal);
    let opposite_a = square - opposite_b - opposite_c;
    let inside = opposite_a > 0.0 && opposite_b > 0.0 && opposite_c > 0.0;
    inside.then(|| point - (normal * (ap.dot(&normal) / square)))
}
