//! Shapes of polyhedra, in the form that contacts want.

use super::free_rotation::Inertia;
use crate::Vec3;
use core::ops::Range;
use tremie_geometry::{Convex, ConvexError, principal};
use tremie_messages::scene::Shape as SceneShape;

/// A convex polyhedron as large as a sphere of diameter 1, its centroid in the origin.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Corners.
    pub vertices: Vec<Vec3>,
    /// Unit normals of the faces, outward.
    pub normals: Vec<Vec3>,
    /// Distances of the faces from the origin.
    pub offsets: Vec<f64>,
    /// Corners of the faces, one face after the other, anticlockwise seen from outside.
    corners: Vec<u32>,
    /// `ends[f]..ends[f + 1]` are the corners of face f.
    ends: Vec<u32>,
    /// Distance of the farthest corner from the origin.
    pub circumradius: f64,
    /// Distance of the closest face from the origin.
    pub inradius: f64,
    /// Area of the largest face.
    pub largest_face: f64,
    /// Principal moments of inertia over the mass.
    pub inertia: [f64; 3],
    /// Unit vectors along the principal axes, right-handed.
    pub axes: [Vec3; 3],
}

impl Shape {
    /// The shape of a scene.
    ///
    /// # Errors
    /// Corners that make no convex polyhedron.
    pub fn of(shape: &SceneShape) -> Result<Self, ConvexError> {
        let convex = Convex::hull(&shape.vertices)?.unit();
        let moments = convex.moments();
        let (inertia, axes) = principal(&moments.inertia);
        let mut corners = Vec::new();
        let mut ends = vec![0];
        for face in convex.faces() {
            corners.extend(&face.corners);
            ends.push(corners.len() as u32);
        }
        Ok(Self {
            vertices: convex.vertices().to_vec(),
            normals: convex.faces().iter().map(|face| face.normal).collect(),
            offsets: convex.faces().iter().map(|face| face.offset).collect(),
            corners,
            ends,
            circumradius: convex.circumradius(),
            inradius: convex.inradius(),
            largest_face: convex.largest_face(),
            inertia: inertia.map(|i| i / moments.volume),
            axes,
        })
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.normals.len()
    }

    /// Corners of a face.
    #[inline(always)]
    pub fn corners(&self, face: usize) -> &[u32] {
        let own: Range<usize> = self.ends[face] as usize..self.ends[face + 1] as usize;
        &self.corners[own]
    }

    /// Inertia of a body [kg·m²], of this mass [kg] and as large as a sphere of this diameter [m].
    pub fn inertia_of(&self, mass: f64, size: f64) -> Inertia {
        Inertia { moments: self.inertia.map(|i| i * (mass * size * size)), axes: self.axes }
    }

    /// Largest ratio of the motion by a push beside the centroid to that by a push through it: `1 +
    /// R^2 m/I` with the circumradius and the smallest moment of inertia. For a sphere 3.5.
    pub fn lever(&self) -> f64 {
        let least = self.inertia.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        1.0 + self.circumradius * self.circumradius / least
    }
}

/// A polyhedron where it is: a shape at a size and an orientation. All vectors from its centroid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid<'a> {
    pub shape: &'a Shape,
    /// Diameter of a sphere of equal volume [m].
    pub size: f64,
    /// Corners [m].
    pub vertices: &'a [Vec3],
    /// Unit normals of the faces, outward.
    pub normals: &'a [Vec3],
}

impl Solid<'_> {
    /// Depth of a point under a face [m]; negative beyond.
    #[inline(always)]
    pub fn depth(&self, face: usize, x: Vec3) -> f64 {
        self.shape.offsets[face] * self.size - self.normals[face].dot(&x)
    }

    /// Radius of the largest sphere about the centroid inside it [m].
    pub fn inradius(&self) -> f64 {
        self.shape.inradius * self.size
    }

    /// The farthest that it reaches along a direction [m].
    pub fn support(&self, direction: Vec3) -> f64 {
        self.vertices.iter().fold(f64::NEG_INFINITY, |most, v| most.max(v.dot(&direction)))
    }
}

/// The rotation of a unit quaternion `(x, y, z, w)`, as images of the three axes.
#[inline(always)]
pub(crate) fn turned_axes([x, y, z, w]: [f64; 4]) -> [Vec3; 3] {
    [
        Vec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        Vec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        Vec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    ]
}

/// A vector of the body in the world.
#[inline(always)]
pub(crate) fn to_world(axes: &[Vec3; 3], v: Vec3) -> Vec3 {
    axes[0] * v.x + axes[1] * v.y + axes[2] * v.z
}

/// A vector of the world in the body.
#[inline(always)]
pub(crate) fn to_body(axes: &[Vec3; 3], v: Vec3) -> Vec3 {
    Vec3::new(axes[0].dot(&v), axes[1].dot(&v), axes[2].dot(&v))
}
