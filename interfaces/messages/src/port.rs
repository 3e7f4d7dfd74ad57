//! Ports: velocities of the fluid at the open faces of the domain on which inlets of grains sit.

use crate::Message;
use crate::scene::{InletVelocity, Scene};

/// The fluid at an open face of the domain. 16 bytes.
///
/// The `ports` channel carries one for each face that the scene's inlets name, in the order of
/// [`PortState::all`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PortState {
    /// Axis of the face: 0, 1, 2 for x, y, z.
    pub axis: u32,
    /// 0 for the lower face, 1 for the upper.
    pub side: u32,
    /// Mean velocity through the face, volume flux over area of what is fluid there: positive into
    /// the domain [m/s].
    pub velocity: f64,
}

// SAFETY: 4 + 4 + 8 bytes, no padding.
unsafe impl Message for PortState {
    const TYPE_NAME: &'static str = "tremie.PortState.1";
}

impl PortState {
    /// The faces whose velocity the inlets of a scene take, each once: by axis, lower before upper;
    /// at rest.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let named = |face: (usize, usize)| {
            let (axis, side) = face;
            let of_face = InletVelocity::Face { axis, side };
            scene.inlets.iter().any(|inlet| inlet.velocity == of_face)
        };
        let faces = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
        let at_rest = |(axis, side)| Self { axis: axis as u32, side: side as u32, velocity: 0.0 };
        faces.filter(|face| named(*face)).map(at_rest).collect()
    }

    /// True if both are of the same face.
    pub fn is_of(&self, other: &Self) -> bool {
        (self.axis, self.side) == (other.axis, other.side)
    }

    /// The velocity as a vector, world frame [m/s].
    pub fn vector(&self) -> [f64; 3] {
        let inward = if self.side == 0 { self.velocity } else { -self.velocity };
        std::array::from_fn(|a| if a == self.axis as usize { inward } else { 0.0 })
    }
}

/// The face, as a manifest calls it: `z_lower`.
impl std::fmt::Display for PortState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (["x", "y", "z"].get(self.axis as usize), self.side) {
            (Some(axis), 0) => write!(f, "{axis}_lower"),
            (Some(axis), 1) => write!(f, "{axis}_upper"),
            _ => write!(f, "axis {}, side {}", self.axis, self.side),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Diameters, Domain, Face, Inlet};

    #[test]
    fn each_face_that_inlets_name_is_a_port_once() {
        let inlet = |velocity| Inlet {
            name: String::new(),
            bodies: String::new(),
            min: [0.0; 3],
            max: [1.0; 3],
            fraction: 0.1,
            diameters: Diameters::Uniform { min: 0.1, max: 0.1 },
            every: None,
            velocity,
            until: None,
            seed: 1,
            tries: 1,
        };
        let mut scene = Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS));
        let face = |axis, side| InletVelocity::Face { axis, side };
        for velocity in [face(2, 1), InletVelocity::Given([1.0; 3]), face(0, 0), face(2, 1)] {
            scene.inlets.push(inlet(velocity));
        }
        let ports = PortState::all(&scene);
        assert_eq!(
            ports.iter().map(ToString::to_string).collect::<Vec<_>>(),
            ["x_lower", "z_upper"]
        );
        let told = PortState { velocity: 2.0, ..ports[1] };
        assert!(told.is_of(&ports[1]) && !told.is_of(&ports[0]));
        assert_eq!(told.vector(), [0.0, 0.0, -2.0]);
    }
}
