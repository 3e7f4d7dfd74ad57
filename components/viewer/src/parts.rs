//! Rigid parts as surfaces that move with their bodies: half transparent where they stand still.

use crate::section::Mirror;
use crate::view::{part, single, unit};
use rerun::components::AlbedoFactor;
use rerun::{Mesh3D, Quaternion, RecordingStream, RecordingStreamResult, Transform3D};
use tremie_geometry::{Frame, GeometryError, Mesh, Vec3};
use tremie_messages::frame::BodySample;
use tremie_messages::scene::{Motion, Part, PartBoundary, Pose, Scene};
use tremie_messages::{BodyEvent, Problem};

/// Colour of walls.
const WALL: [u8; 4] = [176, 184, 196, 110];
/// Colour of walls that move.
const MOVING: [u8; 4] = [104, 111, 122, 255];
/// Colour of the wall of a cavity: it stands between the eye and everything.
const CAVITY: [u8; 4] = [176, 184, 196, 36];
/// Colour where fluid is driven in or out.
pub const VELOCITY: [u8; 4] = [90, 170, 255, 90];
/// Colour where the pressure is given.
pub const PRESSURE: [u8; 4] = [255, 170, 80, 90];

/// The parts of a scene.
pub struct Parts {
    /// Entity and pose, as they were drawn last.
    drawn: Vec<(String, Pose)>,
}

/// A part's surface in its own frame, with flat shading: each triangle has corners of its own.
pub(crate) fn surface(mesh: &Mesh) -> Mesh3D {
    let corners = mesh
        .triangles
        .iter()
        .flat_map(|corners| corners.map(|corner| single(mesh.vertices[corner as usize])));
    let normals = mesh.triangles.iter().flat_map(|corners| {
        let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize]);
        [single(normal(a, b, c)); 3]
    });
    Mesh3D::new(corners).with_vertex_normals(normals)
}

fn normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    unit((b - a).cross(&(c - a)))
}

/// The part of a part's surface that is drawn, in its own frame.
fn seen(part: &Part, mesh: &Mesh, mirrors: &[Mirror]) -> Mesh {
    let frame = Frame::of(&part.pose);
    let mut world = mesh.clone();
    world.vertices.iter_mut().for_each(|vertex| *vertex = frame.to_world(*vertex));
    for mirror in Mirror::of(mirrors, part) {
        // A cavity is a surface without a solid inside.
        world = mirror.cut(&world, !part.cavity);
    }
    world.vertices.iter_mut().for_each(|vertex| *vertex = frame.to_part(*vertex));
    world
}

fn colour(part: &Part) -> [u8; 4] {
    match part.boundary {
        PartBoundary::Velocity { .. } | PartBoundary::Reservoir(_) => VELOCITY,
        PartBoundary::Pressure { .. } => PRESSURE,
        PartBoundary::Wall if part.cavity => CAVITY,
        PartBoundary::Wall if part.motion != Motion::Fixed => MOVING,
        PartBoundary::Wall => WALL,
    }
}

/// The surfaces of all parts of a scene.
///
/// # Errors
/// Each part whose surface cannot be read.
pub fn meshes(scene: &Scene) -> Result<Vec<Mesh>, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut problem = |k: usize, error: GeometryError| {
        problems.push(Problem::new(format!("scene.parts[{k}].geometry"), error.to_string()));
    };
    let meshes: Vec<Mesh> = (scene.parts.iter().enumerate())
        .filter_map(|(k, part)| Mesh::of(&part.geometry).map_err(|error| problem(k, error)).ok())
        .collect();
    if problems.is_empty() { Ok(meshes) } else { Err(problems) }
}

impl Parts {
    /// Draws the parts where they are at the start.
    pub fn open(
        stream: &RecordingStream,
        scene: &Scene,
        meshes: &[Mesh],
    ) -> RecordingStreamResult<Self> {
        let mut drawn = Vec::new();
        let mirrors = Mirror::all(&scene.domain);
        for (part_, mesh) in scene.parts.iter().zip(meshes) {
            let path = format!("scene/parts/{}", part(&part_.name));
            let [r, g, b, a] = colour(part_);
            let colour = AlbedoFactor(rerun::Rgba32::from_unmultiplied_rgba(r, g, b, a));
            stream.log_static(
                path.as_str(),
                &surface(&seen(part_, mesh, &mirrors)).with_albedo_factor(colour),
            )?;
            // Not static: what is static cannot move later.
            stream.log(path.as_str(), &transform(&part_.pose))?;
            drawn.push((path, part_.pose));
        }
        Ok(Self { drawn })
    }

    /// Moves the parts that are among the bodies of one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        bodies: &[BodySample],
    ) -> RecordingStreamResult<()> {
        for body in bodies.iter().filter(|body| body.shape == BodyEvent::PART) {
            let Some((path, last)) = self.drawn.get_mut(body.part as usize) else { continue };
            let (position, orientation) = (body.state.position, body.state.orientation);
            let pose = Pose { position, orientation };
            if pose != *last {
                stream.log(path.as_str(), &transform(&pose))?;
                *last = pose;
            }
        }
        Ok(())
    }
}

fn transform(pose: &Pose) -> Transform3D {
    Transform3D::from_translation_rotation(
        single(pose.position),
        Quaternion::from_xyzw(pose.orientation.map(|x| x as f32)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_point_out_of_anticlockwise_triangles() {
        assert_eq!(normal(Vec3::zeros(), Vec3::x() * 2.0, Vec3::y()), Vec3::z());
    }
}
