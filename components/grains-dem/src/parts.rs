//! Rigid parts: surfaces that grains meet, fixed or moved as the scene prescribes.

use crate::{
    Vec3,
    bodies::Twist,
    mesh_contact::Triangle,
    motion::{Path, turn},
    periodic::PeriodicBox,
};
use tremie_geometry::{Bounds, Frame, Surface};
use tremie_messages::{
    Problem,
    scene::{Motion, Part, Pose, Scene},
};

/// A part where it is.
pub(crate) struct PlacedPart {
    surface: Surface,
    cavity: bool,
    /// How it moves, if it does.
    path: Option<Path>,
    pub pose: Pose,
    frame: Frame,
    /// Velocities of its reference point, the origin of its frame.
    pub twist: Twist,
    /// How far any of its points can have gone since neighbours were listed [m].
    pub moved: f64,
}

/// Loads the surfaces of all parts.
///
/// # Errors
/// Surfaces that cannot be had, and motions that are none of a part.
pub(crate) fn load(scene: &Scene) -> Result<Vec<PlacedPart>, Vec<Problem>> {
    let (mut parts, mut problems) = (Vec::new(), Vec::new());
    for (i, part) in scene.parts.iter().enumerate() {
        let key = format!("scene.parts[{i}]");
        if part.motion == Motion::Free {
            let message = "is free, but parts are moved by no force";
            let help = "fix the part, prescribe its motion, or make it a sphere";
            problems.push(Problem::new(format!("{key}.motion"), message).help(help));
        }
        match Surface::of(&part.geometry) {
            Ok(surface) => parts.push(PlacedPart::new(part, surface)),
            Err(error) => problems.extend(error.problems(&format!("{key}.geometry"))),
        }
    }
    if problems.is_empty() { Ok(parts) } else { Err(problems) }
}

impl PlacedPart {
    fn new(part: &Part, surface: Surface) -> Self {
        let path = match &part.motion {
            Motion::Prescribed(points) => Some(Path::new(points, Twist::zero())),
            _ => None,
        };
        let twist = path.as_ref().map_or(Twist::zero(), |path| path.twist(0.0));
        Self {
            surface,
            cavity: part.cavity,
            path,
            pose: part.pose,
            frame: Frame::of(&part.pose),
            twist,
            moved: 0.0,
        }
    }

    /// Whether its motion is prescribed, so that it is a body of the run.
    pub fn moves(&self) -> bool {
        self.path.is_some()
    }

    /// Whether the space inside its surface is free and that outside solid.
    pub fn is_cavity(&self) -> bool {
        self.cavity
    }

    /// Radius about the reference point that holds it [m].
    pub fn bounding_radius(&self) -> f64 {
        self.surface.bounding_radius()
    }

    /// Moves it through a time; true if its reference point crossed a periodic face.
    pub fn advance(&mut self, from: f64, to: f64, bounds: &PeriodicBox) -> bool {
        let Some(path) = &self.path else { return false };
        let step = path.travelled(from, to);
        let position = Vec3::from(self.pose.position) + step.v;
        let wrapped = bounds.wrap(position);
        self.pose.position = wrapped.into();
        self.pose.orientation = turn(self.pose.orientation, step.w);
        self.frame = Frame::of(&self.pose);
        self.twist = path.twist(to);
        let radius = self.surface.bounding_radius();
        self.moved += step.v.norm_squared().sqrt() + radius * step.w.norm_squared().sqrt();
        wrapped != position
    }

    /// Velocity of its point at `x` [m/s].
    #[inline(always)]
    pub fn velocity_at(&self, x: Vec3) -> Vec3 {
        self.twist.v + self.twist.w.cross(&(x - Vec3::from(self.pose.position)))
    }

    /// A point of the world in the part's frame.
    #[inline(always)]
    pub fn to_part(&self, x: Vec3) -> Vec3 {
        self.frame.to_part(x.into()).into()
    }

    /// A direction of the part in the world.
    #[inline(always)]
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.frame.turn_to_world(direction.into()).into()
    }

    /// A triangle, in the part's frame, its normal to the side of the grains.
    #[inline(always)]
    pub fn triangle(&self, index: u32) -> Triangle {
        let surface = &self.surface;
        let normal = Vec3::from(surface.normal(index));
        Triangle {
            corners: surface.mesh().corners(index as usize).map(Vec3::from),
            normal: if self.cavity { -normal } else { normal },
        }
    }

    /// Puts into `out` the triangles near a sphere with its centre at `x`, in the part's frame.
    pub fn triangles_near(&self, x: Vec3, radius: f64, out: &mut Vec<u32>) {
        let bounds = Bounds { min: x.into(), max: x.into() }.grown(radius);
        if self.surface.bounds().meets(&bounds) {
            self.surface.triangles_near(&bounds, out);
        } else {
            out.clear();
        }
    }

    /// Distance of a point of the world from the surface [m], negative in the solid, and the unit
    /// vector along which it grows.
    pub fn clearance(&self, x: Vec3) -> (f64, Vec3) {
        let x = self.to_part(x);
        let closest = self.surface.closest(x.into());
        let sign = if self.cavity { -1.0 } else { 1.0 };
        let away = x - Vec3::from(closest.point);
        let length = away.norm_squared().sqrt();
        // On the surface itself there is no line to the closest point.
        let direction = if length > 1e-9 * self.bounding_radius() {
            away * (closest.distance.signum() / length)
        } else {
            Vec3::from(closest.normal)
        };
        (sign * closest.distance, self.to_world(direction * sign))
    }
}
