//! Polyhedra as instances of a mesh, one mesh for each set.

use crate::parts::surface;
use crate::view::{part, single};
use rerun::components::AlbedoFactor;
use rerun::{InstancePoses3D, Quaternion, RecordingStream, RecordingStreamResult};
use tremie_geometry::Convex;
use tremie_messages::BodyEvent;
use tremie_messages::frame::BodySample;
use tremie_messages::scene::{Placement, Scene};

/// Colours of sets, one after the other: a mesh has one colour for all its instances.
const COLOURS: [u32; 6] = [0xd9a066ff, 0x8fb3d9ff, 0xa3c585ff, 0xc99bcbff, 0xe0cb6cff, 0xd98880ff];

/// The sets of polyhedra of a scene.
pub struct Solids {
    sets: Vec<SolidSet>,
}

struct SolidSet {
    number: u32,
    path: String,
    mesh: rerun::Mesh3D,
    /// Radius about the centroid that holds the mesh.
    radius: f64,
    shown: bool,
}

impl Solids {
    /// Those of a scene; the grains have checked its shapes.
    pub fn new(scene: &Scene) -> Self {
        let mut sets = Vec::new();
        for (number, set) in (0..).zip(&scene.bodies) {
            let Placement::Polyhedra(own) = &set.placement else { continue };
            let shape = scene.shapes.iter().find(|shape| shape.name == own.shape);
            let Some(Ok(convex)) = shape.map(|shape| Convex::hull(&shape.vertices)) else {
                continue;
            };
            let convex = convex.unit();
            let colour = COLOURS[sets.len() % COLOURS.len()];
            sets.push(SolidSet {
                number,
                path: format!("scene/bodies/{}", part(&set.name)),
                mesh: surface(&convex.mesh())
                    .with_albedo_factor(AlbedoFactor(rerun::Rgba32(colour))),
                radius: convex.circumradius(),
                shown: false,
            });
        }
        Self { sets }
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        bodies: &[BodySample],
    ) -> RecordingStreamResult<()> {
        for set in &mut self.sets {
            let is_own =
                |body: &&BodySample| body.shape == BodyEvent::POLYHEDRON && body.set == set.number;
            let own = || bodies.iter().filter(is_own);
            if !std::mem::replace(&mut set.shown, true) {
                stream.log_static(set.path.as_str(), &set.mesh)?;
            }
            let turned =
                |body: &BodySample| Quaternion::from_xyzw(body.state.orientation.map(|x| x as f32));
            let scale = |body: &BodySample| [(body.radius / set.radius) as f32; 3];
            let poses = InstancePoses3D::new()
                .with_translations(own().map(|body| single(body.state.position)))
                .with_quaternions(own().map(turned))
                .with_scales(own().map(scale));
            stream.log(set.path.as_str(), &poses)?;
        }
        Ok(())
    }
}
