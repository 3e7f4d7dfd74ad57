//! From a part's frame to the world and back.

use crate::Vec3;
use nalgebra::Matrix3;
use tremie_messages::scene::Pose;

/// The place of a part's frame in the world, ready to use: a rotation matrix and an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    origin: Vec3,
    /// From the part to the world.
    rotation: Matrix3<f64>,
}

impl Frame {
    /// The frame at a pose. A quaternion that is not quite of length one is taken for the rotation
    /// it stands for; the identity gives exactly the identity.
    pub fn of(pose: &Pose) -> Self {
        let [x, y, z, w] = pose.orientation;
        let s = 2.0 / (x * x + y * y + z * z + w * w);
        let rotation = Matrix3::new(
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (x * z + y * w),
            s * (x * y + z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z - x * w),
            s * (x * z - y * w),
            s * (y * z + x * w),
            1.0 - s * (x * x + y * y),
        );
        Self { origin: pose.position.into(), rotation }
    }

    /// A point of the part, in the world.
    pub fn to_world(&self, point: impl Into<Vec3>) -> Vec3 {
        self.turn_to_world(point) + self.origin
    }

    /// A point of the world, in the part's frame.
    pub fn to_part(&self, point: impl Into<Vec3>) -> Vec3 {
        self.turn_to_part(point.into() - self.origin)
    }

    /// A direction of the part, in the world.
    pub fn turn_to_world(&self, vector: impl Into<Vec3>) -> Vec3 {
        self.rotation * vector.into()
    }

    /// A direction of the world, in the part's frame.
    pub fn turn_to_part(&self, vector: impl Into<Vec3>) -> Vec3 {
        self.rotation.tr_mul(&vector.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let half = 0.5f64.sqrt();
        let pose = Pose { position: [1.0, 2.0, 3.0], orientation: [0.0, 0.0, half, half] };
        let frame = Frame::of(&pose);
        let moved = frame.to_world([1.0, 0.0, 0.0]);
        assert!((moved - Vec3::from([1.0, 3.0, 3.0])).norm() < 1e-15);
        assert!((frame.to_part(moved) - Vec3::x()).norm() < 1e-15);
        assert!((frame.turn_to_part([0.0, 1.0, 0.0]) - Vec3::x()).norm() < 1e-15);
    }

    #[test]
    fn the_identity_changes_no_bit() {
        let point = Vec3::new(0.1, -0.2, 1e-17);
        assert_eq!(Frame::of(&Pose::IDENTITY).to_world(point), point);
        assert_eq!(Frame::of(&Pose::IDENTITY).to_part(point), point);
    }
}
