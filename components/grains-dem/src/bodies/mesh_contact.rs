//! Contact points of a sphere with walls: surfaces of triangles, one or many, and planes.
//!
//! Contacts with faces come first, the deepest before the others, then those with edges, then those
//! with vertices (Hu et al., *Powder Technol.* 2013). A contact counts only if its point stands out
//! of the tangent planes of all before: edges and vertices of a face that the sphere touches
//! already do not, nor do those that do not stick out. That is asked of points in space, and not of
//! what triangles share, so that it holds across seams of parts and planes that stand flush as
//! well. So a sphere rolls over a flat floor of triangles as over a plane. The shares of the
//! remaining contacts follow from [`crate::contact::region_shares`].
//!
//! A contact with an edge or a vertex belongs to the first of the triangles that share it, whatever
//! round-off says of their distances; a point that several owners share to the one of the lowest
//! rank.
//!
//! Of the triangles listed near a sphere few are touched. So how far each is gets noted when all
//! are looked at, and until sphere and surface have come some way, only those are looked at again
//! that they may have reached since: what is found is the same.

use crate::Vec3;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::wall_triangle::{Triangle, border};

/// A point of a wall within reach of a sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WallPoint {
    /// Unit vector from the point to the centre of the sphere.
    pub normal: Vec3,
    /// Distance of the point from the centre [m].
    pub distance: f64,
    /// 0 for a face, 1 for an edge, 2 for a vertex.
    pub feature: u8,
    /// The point, from the same origin for all that are compared.
    pub point: Vec3,
    /// Index of its triangle, among the triangles given.
    pub triangle: u32,
    /// Owner of the triangles, and its rank: the lowest rank comes first among owners that share a
    /// point.
    pub owner: u32,
    pub rank: u32,
}

/// Most contacts of a sphere with walls at once.
pub(crate) const MOST: usize = 8;

/// A contact that turned by less is the same one: cosine of 10 degrees.
pub(crate) const SAME: f64 = 0.984_807_753;

/// Least distance by which a point must stand out of another contact's tangent plane, over the
/// radius. It exceeds the error of triangle corners that a file rounds.
const OUT: f64 = 1e-5;

/// Points that are nearer to each other than this, over the radius, are one.
const TIE: f64 = 1e-9;

/// The contacts found, in the order described above.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(into = "Vec<WallPoint>", try_from = "Vec<WallPoint>")]
pub(crate) struct WallPoints {
    list: [WallPoint; MOST],
    count: usize,
}

impl WallPoints {
    pub const NONE: Self = Self { list: [WallPoint::NONE; MOST], count: 0 };

    /// The contact point with points from an origin that had the coordinates `x`.
    pub fn moved_by(mut self, x: Vec3) -> Self {
        self.list[..self.count].iter_mut().for_each(|near| near.point += x);
        self
    }

    pub fn contacts(&self) -> &[WallPoint] {
        &self.list[..self.count]
    }
}

impl From<WallPoints> for Vec<WallPoint> {
    fn from(found: WallPoints) -> Self {
        found.contacts().to_vec()
    }
}

impl TryFrom<Vec<WallPoint>> for WallPoints {
    type Error = String;

    fn try_from(points: Vec<WallPoint>) -> Result<Self, String> {
        let (mut found, count) = (Self::NONE, points.len());
        let room = found.list.get_mut(..count);
        room.ok_or_else(|| format!("a sphere has {count} contacts"))?.copy_from_slice(&points);
        Ok(Self { count, ..found })
    }
}

/// A sphere in search of its contact points.
#[derive(Clone, Copy)]
pub(crate) struct Seeker {
    pub centre: Vec3,
    pub radius: f64,
    /// Surfaces that are closer to the centre count.
    pub reach: f64,
}

/// State of a sphere at its last full search of the triangles near it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct LookedFrom {
    centre: Vec3,
    /// Travel of the surface until then [m].
    travel: f64,
}

impl LookedFrom {
    /// State before the first search.
    pub const NEVER: Self = Self { centre: Vec3::new(0.0, 0.0, 0.0), travel: f64::NEG_INFINITY };
}

/// Cosine of twice the angle that is taken as flat, [`tremie_geometry::FLAT_ANGLE`].
const ALONG: f64 = 1.0 - 2e-6;

/// After so much of its radius a sphere looks at all triangles again.
const AGAIN: f64 = 0.02;

/// Distances are noted this much shorter, for they are rounded.
const SHORTER: f64 = 1.0 - 1e-6;

/// The contacts of a sphere with those triangles that are in reach, of as many as there are
/// `distances`. No point of theirs has moved by more than `travel` grew since it `looked`.
pub(crate) fn find(
    sphere: Seeker,
    travel: f64,
    looked: &mut LookedFrom,
    distances: &mut [f32],
    triangle: impl Fn(usize) -> Triangle,
) -> WallPoints {
    let mut candidates = ReachedPoints::NONE;
    look(sphere, travel, (looked, distances), triangle, |near| candidates.take(near));
    candidates.contacts(sphere.radius)
}

/// Looks for the points of triangles that are in reach, and gives each to `take`; the rest as
/// [`find`].
#[inline(always)]
pub(crate) fn look(
    sphere: Seeker,
    travel: f64,
    (looked, distances): (&mut LookedFrom, &mut [f32]),
    triangle: impl Fn(usize) -> Triangle,
    mut take: impl FnMut(WallPoint),
) {
    let Seeker { centre, radius, reach } = sphere;
    let moved = (centre - looked.centre).norm_squared().sqrt() + (travel - looked.travel);
    let mut offer = |near: Option<WallPoint>, number: usize| {
        if let Some(near) = near.filter(|near| near.distance < reach) {
            take(WallPoint { triangle: number as u32, ..near });
        }
    };
    // What is no number looks again, too.
    if moved <= AGAIN * radius {
        for (number, &distance) in distances.iter().enumerate() {
            if f64::from(distance) - moved < reach {
                offer(nearest(centre, &triangle(number)).1, number);
            }
        }
    } else {
        *looked = LookedFrom { centre, travel };
        for (number, noted) in distances.iter_mut().enumerate() {
            let (distance, near) = nearest(centre, &triangle(number));
            *noted = (distance * SHORTER) as f32;
            offer(near, number);
        }
    }
}

/// A bounded choice of the best points in reach, kept sorted; more than these are never contacts.
pub(crate) struct ReachedPoints {
    list: [WallPoint; 4 * MOST],
    count: usize,
}

impl ReachedPoints {
    pub const NONE: Self = Self { list: [WallPoint::NONE; 4 * MOST], count: 0 };

    /// Takes a point that is in reach.
    pub fn take(&mut self, near: WallPoint) {
        let place = self.list[..self.count].partition_point(|other| !before(&near, other));
        if place == self.list.len() {
            return;
        }
        self.count = (self.count + 1).min(self.list.len());
        self.list.copy_within(place..self.count - 1, place + 1);
        self.list[place] = near;
    }

    /// Candidates that are contacts of a sphere.
    pub fn contacts(&self, radius: f64) -> WallPoints {
        let mut found = WallPoints::NONE;
        for near in &self.list[..self.count] {
            let hidden =
                |other: &WallPoint| (near.point - other.point).dot(&other.normal) <= OUT * radius;
            if let Some(by) = found.contacts().iter().position(hidden) {
                found.list[by].share(near, radius);
            } else if found.count < MOST {
                found.list[found.count] = *near;
                found.count += 1;
            }
        }
        found
    }
}

impl WallPoint {
    pub const NONE: Self = Self {
        normal: Vec3::new(0.0, 0.0, 0.0),
        distance: 0.0,
        feature: 0,
        point: Vec3::new(0.0, 0.0, 0.0),
        triangle: 0,
        owner: 0,
        rank: 0,
    };

    /// The point of a plane that is closest to the origin.
    pub fn of_plane(normal: Vec3, distance: f64) -> Self {
        Self { normal, distance, point: normal * -distance, ..Self::NONE }
    }

    /// Hands a point of an edge or a vertex to the first of the triangles at it, and one that
    /// stands flush with another's to the owner of the lower rank.
    fn share(&mut self, other: &WallPoint, radius: f64) {
        if (self.point - other.point).norm_squared() > (TIE * radius).powi(2) {
            return;
        }
        let of_one = self.feature > 0 && self.feature == other.feature;
        let places = |near: &WallPoint| (near.rank, near.owner, near.triangle);
        if (of_one || self.owner != other.owner) && places(other) < places(self) {
            (self.rank, self.owner, self.triangle) = places(other);
        }
    }
}

/// True if candidate `a` comes before `b` in the order of evaluation.
fn before(a: &WallPoint, b: &WallPoint) -> bool {
    // Down to the point, so that where two are as deep the order of triangles in a file does not
    // matter.
    let key = |near: &WallPoint| {
        (near.feature, near.distance, near.rank, near.point.x, near.point.y, near.point.z)
    };
    key(a) < key(b)
}

/// Distance of a triangle, and its point that is closest to `centre`, unless the centre is behind
/// the triangle.
fn nearest(centre: Vec3, triangle: &Triangle) -> (f64, Option<WallPoint>) {
    let Some((feature, number, point)) = border(centre, triangle) else {
        let height = (centre - triangle.corners[0]).dot(&triangle.normal);
        let (normal, point) = (triangle.normal, centre - triangle.normal * height);
        let near = WallPoint { normal, distance: height, point, ..WallPoint::NONE };
        return (height.abs(), (height > 0.0).then_some(near));
    };
    let away = centre - point;
    let distance = away.norm_squared().sqrt();
    let normal = away / distance;
    let near = WallPoint { normal, distance, feature, point, ..WallPoint::NONE };
    // There the neighbour is as close only where the line to the centre is along the normal.
    let along = normal.dot(&triangle.normal) > ALONG;
    let counts = distance > 0.0 && (along || !triangle.grooves.has(feature, number));
    (distance, counts.then_some(near))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::space::wall_triangle::Grooves;

    /// The faces z = 0 (two triangles) and x = 0 (two) of a step: concave or convex.
    fn quad(a: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [Triangle; 2] {
        let (a, u, v) = (Vec3::from(a), Vec3::from(u), Vec3::from(v));
        let normal = u.cross(&v).normalize();
        let of = |corners| Triangle { corners, normal, grooves: Grooves::NONE };
        [of([a, a + u, a + u + v]), of([a, a + u + v, a + v])]
    }

    fn at(centre: [f64; 3], faces: &[[Triangle; 2]]) -> Vec<WallPoint> {
        let all: Vec<Triangle> = faces.iter().flatten().copied().collect();
        let sphere = Seeker { centre: centre.into(), radius: 1.0, reach: 1.0 };
        let mut distances = vec![0.0; all.len()];
        let found = find(sphere, 0.0, &mut LookedFrom::NEVER.clone(), &mut distances, |k| all[k]);
        found.contacts().to_vec()
    }

    /// A sphere moves over bumps that heave; the distances that it remembers must hide no contact.
    #[test]
    fn what_was_noted_of_distances_hides_no_contact() {
        let height = |x: i32, y: i32, t: f64| {
            let (x, y) = (f64::from(x), f64::from(y));
            0.3 * (1.7 * x + 0.9 * y).sin() + 0.02 * (t + x).sin()
        };
        let bumps = |t: f64| -> Vec<Triangle> {
            let at = |x, y| Vec3::new(f64::from(x), f64::from(y), height(x, y, t));
            let of = |x: i32, y: i32| {
                let (a, b) = (at(x, y), at(x + 1, y));
                let (c, d) = (at(x + 1, y + 1), at(x, y + 1));
                [Triangle::of([a, b, c]), Triangle::of([a, c, d])]
            };
            (-3..3).flat_map(|x| (-3..3).flat_map(move |y| of(x, y))).collect()
        };
        let (mut looked, mut travel) = (LookedFrom::NEVER, 0.0);
        let mut distances = vec![0.0; 72];
        let (mut before, mut touched, mut spared) = (bumps(0.0), 0, 0);
        for step in 0..4000 {
            let t = 1e-2 * f64::from(step);
            let now = bumps(0.1 * t);
            let corners = |all: &[Triangle]| all.iter().flat_map(|t| t.corners).collect::<Vec<_>>();
            let moved =
                corners(&now).into_iter().zip(corners(&before)).map(|(a, b)| (a - b).norm());
            travel += moved.fold(0.0, f64::max);
            before = now;
            let centre =
                Vec3::new(2.0 * (0.3 * t).sin(), 2.0 * (0.21 * t).cos(), 0.9 + 0.3 * t.sin());
            let sphere = Seeker { centre, radius: 1.0, reach: 1.0 };
            let asked = std::cell::Cell::new(0);
            let triangle = |k: usize| {
                asked.set(asked.get() + 1);
                before[k]
            };
            let found = find(sphere, travel, &mut looked, &mut distances, triangle);
            let mut anew = vec![0.0; 72];
            let all = find(sphere, 0.0, &mut LookedFrom::NEVER.clone(), &mut anew, |k| before[k]);
            assert_eq!(found.contacts(), all.contacts(), "step {step}");
            touched += all.contacts().len();
            spared += 72 - asked.get();
        }
        assert!(touched > 3000 && spared > 50 * 4000 / 2, "{touched} {spared}");
    }

    #[test]
    fn a_flat_floor_has_no_seams() {
        let floor = [quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0])];
        for k in 0..200 {
            let x = -2.0 + 0.02 * f64::from(k);
            for y in [x, 0.37, -x] {
                let found = at([x, y, 0.9], &floor);
                assert_eq!(found.len(), 1, "{x} {y}");
                assert!((found[0].distance - 0.9).abs() < 1e-14);
                assert!((found[0].normal - Vec3::z()).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn a_corner_of_three_faces_is_three_contacts() {
        let faces = [
            quad([0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]),
            quad([0.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]),
            quad([0.0, 0.0, 0.0], [0.0, 0.0, 9.0], [9.0, 0.0, 0.0]),
        ];
        let found = at([0.97, 0.98, 0.99], &faces);
        let distances: Vec<f64> = found.iter().map(|near| near.distance).collect();
        assert_eq!(distances, [0.97, 0.98, 0.99]);
    }

    #[test]
    fn a_convex_edge_and_a_vertex_are_touched_alone() {
        // The block x < 0, y < 0, z < 0.
        let block = [
            quad([-9.0, -9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]),
            quad([0.0, -9.0, -9.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]),
            quad([-9.0, 0.0, -9.0], [0.0, 0.0, 9.0], [9.0, 0.0, 0.0]),
        ];
        let edge = at([0.5, -3.3, 0.5], &block);
        assert_eq!(edge.len(), 1);
        assert!((edge[0].distance - 0.5f64.sqrt()).abs() < 1e-15);
        let vertex = at([0.5, 0.5, 0.5], &block);
        assert_eq!(vertex.len(), 1);
        assert!((vertex[0].distance - 0.75f64.sqrt()).abs() < 1e-15);
        // Above the top and near its rim: the top alone, not its edge.
        assert_eq!(at([-0.1, -3.3, 0.9], &block).len(), 1);
        // From the face over the edge the distance is continuous.
        let over = |x: f64| at([x, -3.3, 0.9], &block)[0].distance;
        assert!((over(-1e-9) - over(1e-9)).abs() < 1e-15);
    }

    /// An edge askew: round-off decides from which of its two faces it looks nearer.
    #[test]
    fn a_point_of_an_edge_is_of_the_first_face_there() {
        let (u, v) = (Vec3::new(0.3, 0.7, 0.1).normalize(), Vec3::new(-0.2, 0.4, 0.9).normalize());
        let along = u.cross(&v).normalize();
        let face = |side: Vec3, turned: bool| {
            let (a, b) = if turned { (side, along) } else { (along, side) };
            quad((side * -9.0 - along * 4.0).into(), (a * 9.0).into(), (b * 9.0).into())
        };
        let (first, second) = (face(u, false), face(v, true));
        let out = -(first[0].normal + second[0].normal) * 0.2;
        let out = if out.dot(&u) > 0.0 { out } else { -out };
        let mut asked = 0;
        for k in 0..300 {
            let x = along * (-3.0 + 0.021 * f64::from(k)) + out * (1.0 + 1e-3 * f64::from(k % 7));
            for faces in [[first, second], [second, first]] {
                for near in at(x.into(), &faces).iter().filter(|near| near.feature == 1) {
                    assert!(near.triangle < 2, "{k}: {near:?}");
                    asked += 1;
                }
            }
        }
        assert!(asked > 400, "{asked}");
    }

    #[test]
    fn the_back_of_a_thin_plate_is_not_felt() {
        let plate = [
            quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]),
            quad([-9.0, -9.0, -0.05], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0]),
        ];
        let found = at([0.3, 0.2, 0.9], &plate);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].distance, 0.9);
    }
}
