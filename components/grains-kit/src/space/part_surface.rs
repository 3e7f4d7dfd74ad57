//! The surface of a rigid part where it is: its triangles near a place, and the way out of it.

use crate::Vec3;
use crate::space::wall_triangle::{Grooves, Triangle};
use tremie_geometry::{Bounds, EdgeKind, Endless, Frame, Surface};
use tremie_messages::scene::Pose;

/// The surface of a part, ready to be asked about places in the world.
#[derive(Clone, Debug)]
pub struct PartSurface {
    surface: Surface,
    cavity: bool,
    /// By triangle.
    grooves: Vec<Grooves>,
    /// Continuation of the part through periodic faces.
    endless: Endless,
    /// Frame of the surface: that of the pose, except along an axis on which the part is endless.
    frame: Frame,
}

/// Grooves of each triangle: the edges and corners that nowhere stick out towards the grains.
fn grooves_of(surface: &Surface, cavity: bool) -> Vec<Grooves> {
    let mesh = surface.mesh();
    let out = if cavity { EdgeKind::Concave } else { EdgeKind::Convex };
    // Of each corner, whether any edge there sticks out.
    let mut corners = vec![false; mesh.vertices.len()];
    let walls = |&(t, _): &(usize, &[u32; 3])| surface.is_wall(t as u32);
    for (t, names) in mesh.triangles.iter().enumerate().filter(walls) {
        for (i, kind) in surface.edge_kinds(t as u32).into_iter().enumerate() {
            corners[names[i] as usize] |= kind == out;
            corners[names[(i + 1) % 3] as usize] |= kind == out;
        }
    }
    let of_triangle = |(t, names): (usize, &[u32; 3])| {
        let kinds = surface.edge_kinds(t as u32);
        let bits = (0..3).map(|i| {
            let (edge, corner) = (kinds[i] != out, !corners[names[i] as usize]);
            (u8::from(edge) << i) | (u8::from(corner) << (3 + i))
        });
        Grooves(bits.fold(0, |all, bit| all | bit))
    };
    mesh.triangles.iter().enumerate().map(of_triangle).collect()
}

impl PartSurface {
    /// The surface of a part at a pose, in a domain.
    pub fn new(surface: Surface, cavity: bool, pose: &Pose) -> Self {
        let (grooves, endless) = (grooves_of(&surface, cavity), surface.endless());
        let mut own = Self { surface, cavity, grooves, endless, frame: Frame::of(pose) };
        own.place(pose);
        own
    }

    /// Puts it at another pose.
    pub fn place(&mut self, pose: &Pose) {
        self.frame = self.frame_at(pose);
    }

    /// The frame of the surface when the part is at a pose.
    pub fn frame_at(&self, pose: &Pose) -> Frame {
        let home = self.endless.place(pose.position);
        Frame::of(&Pose { position: home.into(), ..*pose })
    }

    /// The surface in its frame.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Continuation of the part through periodic faces.
    pub fn endless(&self) -> &Endless {
        &self.endless
    }

    /// True if the space inside the surface is free and the space outside is solid.
    pub fn is_cavity(&self) -> bool {
        self.cavity
    }

    /// True if bodies see the part through an image displaced by `shift`. An endless part needs no
    /// image along its endless axes.
    #[inline]
    pub fn is_seen(&self, shift: Vec3) -> bool {
        (0..3).all(|a| shift[a] == 0.0 || !self.endless.axes[a])
    }

    /// Number of triangles of its surface.
    pub fn triangles(&self) -> u64 {
        self.surface.mesh().triangles.len() as u64
    }

    /// Radius about the reference point that holds it [m].
    pub fn bounding_radius(&self) -> f64 {
        self.surface.bounding_radius()
    }

    /// Area of its surface [m²].
    pub fn area(&self) -> f64 {
        self.surface.area()
    }

    /// A point of the world in the part's frame.
    #[inline(always)]
    pub fn to_part(&self, x: Vec3) -> Vec3 {
        self.frame.to_part(x)
    }

    /// A direction of the part in the world.
    #[inline(always)]
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.frame.turn_to_world(direction)
    }

    /// A triangle, in the part's frame, its normal to the side of the grains.
    #[inline(always)]
    pub fn triangle(&self, index: u32) -> Triangle {
        let surface = &self.surface;
        let normal = surface.normal(index);
        Triangle {
            grooves: self.grooves[index as usize],
            corners: surface.mesh().corners(index as usize),
            normal: if self.cavity { -normal } else { normal },
        }
    }

    /// Puts into `out` the triangles near a sphere with its centre at `x`, in the part's frame.
    pub fn triangles_near(&self, x: Vec3, radius: f64, out: &mut Vec<u32>) {
        let bounds = Bounds { min: x, max: x }.grown(radius);
        if self.surface.bounds().meets(&bounds) {
            self.surface.triangles_near(&bounds, out);
        } else {
            out.clear();
        }
    }

    /// A triangle in the world, its corners anticlockwise seen from the grains.
    pub fn placed_triangle(&self, index: u32) -> Triangle {
        let Triangle { mut corners, normal, .. } = self.triangle(index);
        if self.cavity {
            corners.swap(1, 2);
        }
        let place = |corner: Vec3| self.frame.to_world(corner);
        let normal = self.to_world(normal);
        Triangle { corners: corners.map(place), normal, grooves: Grooves::NONE }
    }

    /// True if a point of the world may be closer to the solid than `gap` [m].
    pub fn is_near(&self, x: Vec3, gap: f64) -> bool {
        self.cavity || self.surface.bounds().grown(gap).contains(self.to_part(x))
    }

    /// Distance of a point of the world from the surface [m], negative in the solid, and the unit
    /// vector along which it grows.
    pub fn clearance(&self, x: Vec3) -> (f64, Vec3) {
        let x = self.to_part(x);
        let closest = self.surface.closest(x);
        let sign = if self.cavity { -1.0 } else { 1.0 };
        let away = x - closest.point;
        let length = away.norm_squared().sqrt();
        // On the surface itself there is no line to the closest point.
        let direction = if length > 1e-9 * self.bounding_radius() {
            away * (closest.distance.signum() / length)
        } else {
            closest.normal
        };
        (sign * closest.distance, self.to_world(direction * sign))
    }
}
