//! Polyhedra as surfaces, where they are.

use crate::document::Document;
use crate::parameters::Compression;
use tremie_geometry::{Convex, Frame, Mesh};
use tremie_messages::BodyEvent;
use tremie_messages::frame::BodySample;
use tremie_messages::scene::{Placement, Pose, Scene};
use tremie_sdk::Moment;

/// The shapes of a scene, of unit size.
pub struct Solids {
    shapes: Vec<(Mesh, f64)>,
}

/// A polyhedron with the triangles of its shape.
struct Solid<'a> {
    body: &'a BodySample,
    mesh: &'a Mesh,
    /// Its size [m].
    scale: f64,
}

impl Solids {
    /// Those of a scene that has polyhedra.
    pub fn new(scene: &Scene) -> Option<Self> {
        let any = scene.bodies.iter().any(|set| matches!(set.placement, Placement::Polyhedra(_)));
        let shape = |vertices: &[[f64; 3]]| {
            let convex = Convex::hull(vertices).ok()?.unit();
            Some((convex.mesh(), convex.circumradius()))
        };
        let shapes = scene.shapes.iter().map(|s| shape(&s.vertices)).collect::<Option<_>>()?;
        any.then_some(Self { shapes })
    }

    /// All triangles of polyhedra among the bodies.
    pub fn document(
        &self,
        at: Moment,
        bodies: &[BodySample],
        compression: Compression,
    ) -> Document {
        let solid = |body| {
            let body: &BodySample = body;
            let (mesh, radius) = self.shapes.get(body.part as usize)?;
            let is_solid = body.shape == BodyEvent::POLYHEDRON;
            is_solid.then_some(Solid { body, mesh, scale: body.radius / radius })
        };
        let solids: Vec<Solid> = bodies.iter().filter_map(solid).collect();
        let points: usize = solids.iter().map(|solid| solid.mesh.vertices.len()).sum();
        let triangles: usize = solids.iter().map(|solid| solid.mesh.triangles.len()).sum();
        let mut document = Document::surface(at, points, triangles, compression);
        document.begin("PointData", "Vectors=\"velocity\"");
        document.array("velocity", 3, "m/s", solids.iter().flat_map(Solid::velocities));
        document.end();
        document.begin("CellData", "Scalars=\"id\"");
        let cells = || {
            let of = |solid: &Solid<'_>| vec![*solid.body; solid.mesh.triangles.len()];
            solids.iter().flat_map(of)
        };
        document.array("id", 1, "", cells().map(|body| body.state.id));
        document.array("set", 1, "", cells().map(|body| body.set));
        document.array("shape", 1, "", cells().map(|body| body.part));
        document.end();
        let mut before = 0;
        let corners = solids.iter().flat_map(|solid| {
            let first = before;
            before += solid.mesh.vertices.len() as i64;
            let own = solid.mesh.triangles.iter();
            own.map(move |corners| corners.map(|corner| first + i64::from(corner)))
        });
        document.mesh(solids.iter().flat_map(Solid::points), corners);
        document
    }
}

impl Solid<'_> {
    fn frame(&self) -> Frame {
        let state = &self.body.state;
        Frame::of(&Pose { position: state.position, orientation: state.orientation })
    }

    fn points(&self) -> impl Iterator<Item = f64> {
        let (frame, scale) = (self.frame(), self.scale);
        self.mesh.vertices.iter().flat_map(move |v| <[f64; 3]>::from(frame.to_world(v * scale)))
    }

    /// `v + omega x r` at each vertex.
    fn velocities(&self) -> impl Iterator<Item = f64> {
        let (frame, scale) = (self.frame(), self.scale);
        let (v, w) = (self.body.state.velocity, self.body.state.angular_velocity);
        self.mesh.vertices.iter().flat_map(move |vertex| {
            let r = frame.turn_to_world(vertex.map(|x| x * scale));
            [
                v[0] + w[1] * r[2] - w[2] * r[1],
                v[1] + w[2] * r[0] - w[0] * r[2],
                v[2] + w[0] * r[1] - w[1] * r[0],
            ]
        })
    }
}
