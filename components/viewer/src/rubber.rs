//! Deformable surfaces, coloured by how much they are sheared.

use crate::scale::{GREY, Scale};
use crate::section::Mirror;
use crate::session::REPEAT;
use crate::view::{part, single, unit};
use rerun::{Color, Mesh3D, RecordingStream, RecordingStreamResult};
use std::collections::BTreeMap;
use tremie_geometry::{Frame, Turned, Vec3, triangulate};
use tremie_messages::frame::SurfaceSample;
use tremie_messages::scene::{DeformableSurface, Scene};

/// Cosine of the angle between facets from which on the edge between them looks sharp: 40 degrees.
const SHARP: f64 = 0.766;

/// The deformable surfaces of a scene.
pub struct Rubber {
    surfaces: Vec<Surface>,
}

/// A surface as it is drawn.
struct Surface {
    path: String,
    /// Number of its first vertex among those of all surfaces.
    first: usize,
    /// Corners of its triangles, as indices into `vertices`.
    triangles: Vec<[u32; 3]>,
    /// Vertex of the surface behind each that is drawn: one on a sharp edge is drawn once for each
    /// side.
    vertices: Vec<u32>,
    age: u32,
}

impl Rubber {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let mirrors = Mirror::all(&scene.domain);
        let mut first = 0;
        let surface = |surface: &DeformableSurface| {
            let drawn = Surface::new(scene, surface, first, &mirrors);
            first += surface.vertex_count();
            drawn
        };
        Self { surfaces: scene.surfaces.iter().map(surface).collect() }
    }

    /// True if there are any.
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        samples: &[SurfaceSample],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        self.surfaces.iter_mut().try_for_each(|surface| surface.log(stream, samples, scale))
    }
}

/// Finite strains of a frame.
pub fn strains(samples: &[SurfaceSample]) -> Vec<f32> {
    samples.iter().map(|sample| sample.strain as f32).filter(|strain| strain.is_finite()).collect()
}

impl Surface {
    fn new(scene: &Scene, surface: &DeformableSurface, first: usize, mirrors: &[Mirror]) -> Self {
        let turned = Turned::of(surface);
        let carrier = scene.parts.iter().find(|part| part.name == surface.carrier);
        let mut places = turned.places(surface.start_points());
        let mut triangles = turned.triangles;
        if let Some(carrier) = carrier {
            let (outer, inner) = (Frame::of(&carrier.pose), Frame::of(&surface.pose));
            places.iter_mut().for_each(|place| *place = outer.to_world(inner.to_world(*place)));
            for mirror in Mirror::of(mirrors, carrier) {
                triangles = cut(&places, &triangles, mirror);
            }
        }
        let (vertices, triangles) = split_at_sharp_edges(&places, &triangles);
        let path = format!("scene/rubber/{}", part(&surface.name));
        Self { path, first, triangles, vertices, age: REPEAT }
    }

    fn log(
        &mut self,
        stream: &RecordingStream,
        samples: &[SurfaceSample],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let sample = |vertex: &u32| samples.get(self.first + *vertex as usize);
        let Some(own) = self.vertices.iter().map(sample).collect::<Option<Vec<_>>>() else {
            return Ok(());
        };
        let places: Vec<Vec3> = own.iter().map(|sample| sample.vertex.position.into()).collect();
        let colour = |strain: f64| {
            let colour = if strain.is_finite() { scale.colour(strain as f32) } else { GREY };
            Color::from_u32(colour)
        };
        let mut mesh = Mesh3D::update_fields()
            .with_vertex_positions(places.iter().copied().map(single))
            .with_vertex_normals(normals(&places, &self.triangles).into_iter().map(single))
            .with_vertex_colors(own.iter().map(|sample| colour(sample.strain)));
        self.age += 1;
        if self.age >= REPEAT {
            mesh = mesh.with_triangle_indices(self.triangles.iter().copied());
            self.age = 0;
        }
        stream.log(self.path.as_str(), &mesh)
    }
}

/// The triangles on the inner side of a mirror, and those that close the section where vertices lie
/// on it.
fn cut(places: &[Vec3], triangles: &[[u32; 3]], mirror: Mirror) -> Vec<[u32; 3]> {
    let distance = |vertex: u32| mirror.distance(places[vertex as usize]);
    let is_inside =
        |corners: &&[u32; 3]| corners.iter().map(|corner| distance(*corner)).sum::<f64>() > 0.0;
    let mut kept: Vec<[u32; 3]> = triangles.iter().filter(is_inside).copied().collect();
    // Edges on the mirror that one triangle has: the cap has them the other way round.
    let mut next = BTreeMap::new();
    for corners in &kept {
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            if distance(from) != 0.0 || distance(to) != 0.0 {
                continue;
            }
            if next.get(&from) == Some(&to) {
                next.remove(&from);
            } else {
                next.insert(to, from);
            }
        }
    }
    while let Some((start, mut at)) = next.pop_first() {
        let mut outline = vec![start];
        while at != start {
            outline.push(at);
            let Some(on) = next.remove(&at) else { break };
            at = on;
        }
        if at == start && outline.len() > 2 {
            let corners: Vec<Vec3> = outline.iter().map(|v| places[*v as usize]).collect();
            kept.extend(triangulate(&corners).iter().map(|ear| ear.map(|k| outline[k])));
        }
    }
    kept
}

/// Vertices to draw, as numbers of the surface's, and the triangles between them: where facets meet
/// at a sharp edge, each side has vertices of its own.
fn split_at_sharp_edges(places: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut vertices: Vec<u32> = Vec::new();
    // Of each vertex: those drawn for it, with the normal of the facet that asked first.
    let mut drawn: BTreeMap<u32, Vec<(u32, Vec3)>> = BTreeMap::new();
    let mut draw = |vertex: u32, normal: Vec3| {
        let copies = drawn.entry(vertex).or_default();
        if let Some((copy, _)) = copies.iter().find(|(_, other)| other.dot(&normal) > SHARP) {
            return *copy;
        }
        let copy = vertices.len() as u32;
        vertices.push(vertex);
        copies.push((copy, normal));
        copy
    };
    let split = |corners: &[u32; 3]| {
        let normal = unit(twice_area(places, *corners));
        corners.map(|corner| draw(corner, normal))
    };
    let triangles = triangles.iter().map(split).collect();
    (vertices, triangles)
}

/// Twice the area of a triangle, along its normal.
fn twice_area(places: &[Vec3], corners: [u32; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|corner| places[corner as usize]);
    (b - a).cross(&(c - a))
}

/// Normals of the vertices: means of those of the triangles around each, by area.
fn normals(places: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); places.len()];
    for corners in triangles {
        let normal = twice_area(places, *corners);
        for corner in corners {
            normals[*corner as usize] += normal;
        }
    }
    normals.into_iter().map(unit).collect()
}
