//! Surfaces of the scene's parts, where they are.

use crate::document::Document;
use crate::parameters::Compression;
use tremie_geometry::{Frame, GeometryError, Mesh};
use tremie_messages::BodyEvent;
use tremie_messages::frame::BodySample;
use tremie_messages::scene::{Part, Pose};
use tremie_sdk::Moment;
use tremie_sdk::state::{KeepsState, StateError, StateExchange};

/// The parts of a scene.
pub struct Parts {
    parts: Vec<Placed>,
}

/// A part's triangles and how it moves now.
struct Placed {
    mesh: Mesh,
    pose: Pose,
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
}

impl Parts {
    /// The parts at the start.
    ///
    /// # Errors
    /// A part's surface that cannot be read: its index and why.
    pub fn new(parts: &[Part]) -> Result<Self, (usize, GeometryError)> {
        let place = |(k, part): (usize, &Part)| {
            let mesh = Mesh::of(&part.geometry).map_err(|error| (k, error))?;
            let (velocity, angular_velocity) = ([0.0; 3], [0.0; 3]);
            Ok(Placed { mesh, pose: part.pose, velocity, angular_velocity })
        };
        Ok(Self { parts: parts.iter().enumerate().map(place).collect::<Result<_, _>>()? })
    }

    /// Takes the poses of parts that are among the bodies; returns whether any moved.
    pub fn follow(&mut self, bodies: &[BodySample]) -> bool {
        let mut moved = false;
        for body in bodies.iter().filter(|body| body.shape == BodyEvent::PART) {
            let Some(part) = self.parts.get_mut(body.part as usize) else { continue };
            let state = &body.state;
            let pose = Pose { position: state.position, orientation: state.orientation };
            moved |= pose != part.pose
                || state.velocity != part.velocity
                || state.angular_velocity != part.angular_velocity;
            part.pose = pose;
            part.velocity = state.velocity;
            part.angular_velocity = state.angular_velocity;
        }
        moved
    }

    /// All triangles as they are now.
    pub fn document(&self, at: Moment, compression: Compression) -> Document {
        let points: usize = self.parts.iter().map(|part| part.mesh.vertices.len()).sum();
        let triangles: usize = self.parts.iter().map(|part| part.mesh.triangles.len()).sum();
        let mut document = Document::surface(at, points, triangles, compression);
        document.begin("PointData", "Vectors=\"velocity\"");
        document.array("velocity", 3, "m/s", self.parts.iter().flat_map(Placed::velocities));
        document.end();
        document.begin("CellData", "Scalars=\"part\"");
        let numbers = self
            .parts
            .iter()
            .enumerate()
            .flat_map(|(k, part)| std::iter::repeat_n(k as u32, part.mesh.triangles.len()));
        document.array("part", 1, "", numbers);
        document.end();
        let mut before = 0;
        let corners = self.parts.iter().flat_map(|part| {
            let first = before;
            before += part.mesh.vertices.len() as i64;
            let own = part.mesh.triangles.iter();
            own.map(move |corners| corners.map(|corner| first + i64::from(corner)))
        });
        document.mesh(self.parts.iter().flat_map(Placed::points), corners);
        document
    }
}

impl KeepsState for Parts {
    const STATE_VERSION: u32 = 1;

    /// Where the parts were: whether they moved since is seen from that.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let parts = &mut self.parts;
        state.column(
            "position",
            parts,
            |part| part.pose.position,
            |part, x| part.pose.position = x,
        )?;
        let (get, set) = (|part: &Placed| part.pose.orientation, Placed::turn);
        state.column("orientation", parts, get, set)?;
        state.column("velocity", parts, |part| part.velocity, |part, v| part.velocity = v)?;
        let get = |part: &Placed| part.angular_velocity;
        state.column("angular_velocity", parts, get, |part, w| part.angular_velocity = w)
    }
}

impl Placed {
    fn turn(&mut self, orientation: [f64; 4]) {
        self.pose.orientation = orientation;
    }

    fn points(&self) -> impl Iterator<Item = f64> {
        let frame = Frame::of(&self.pose);
        self.mesh.vertices.iter().flat_map(move |vertex| <[f64; 3]>::from(frame.to_world(*vertex)))
    }

    /// `v + omega x r` at each vertex.
    fn velocities(&self) -> impl Iterator<Item = f64> {
        let frame = Frame::of(&self.pose);
        let (v, w) = (self.velocity, self.angular_velocity);
        self.mesh.vertices.iter().flat_map(move |vertex| {
            let r = frame.turn_to_world(*vertex);
            [
                v[0] + w[1] * r[2] - w[2] * r[1],
                v[1] + w[2] * r[0] - w[0] * r[2],
                v[2] + w[0] * r[1] - w[1] * r[0],
            ]
        })
    }
}
