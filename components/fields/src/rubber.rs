//! Deformable surfaces, where they are.

use crate::document::Document;
use crate::parameters::Compression;
use tremie_geometry::Turned;
use tremie_messages::frame::SurfaceSample;
use tremie_messages::scene::{FacetKind, Scene};
use tremie_sdk::Moment;

/// The deformable surfaces of a scene, numbered through.
pub struct Rubber {
    triangles: Vec<[i64; 3]>,
    surfaces: Vec<u32>,
    kinds: Vec<u8>,
}

impl Rubber {
    /// Those of a scene that has some.
    pub fn new(scene: &Scene) -> Option<Self> {
        let mut all = Self { triangles: Vec::new(), surfaces: Vec::new(), kinds: Vec::new() };
        let mut first = 0;
        for (number, surface) in (0..).zip(&scene.surfaces) {
            let turned = Turned::of(surface);
            let own = turned.triangles.iter().map(|corners| corners.map(|k| first + i64::from(k)));
            all.triangles.extend(own);
            all.surfaces.resize(all.triangles.len(), number);
            all.kinds.extend(turned.kinds.iter().map(|kind| match kind {
                FacetKind::Seat => 0,
                FacetKind::Bonded => 2,
                _ => 1,
            }));
            first += turned.vertex_count() as i64;
        }
        (!scene.surfaces.is_empty()).then_some(all)
    }

    /// All triangles at one moment.
    pub fn document(
        &self,
        at: Moment,
        samples: &[SurfaceSample],
        compression: Compression,
    ) -> Document {
        let mut document = Document::surface(at, samples.len(), self.triangles.len(), compression);
        let points = || samples.iter().map(|sample| &sample.vertex);
        document.begin("PointData", "Scalars=\"strain\" Vectors=\"velocity\"");
        document.array("velocity", 3, "m/s", points().flat_map(|vertex| vertex.velocity));
        document.array("strain", 1, "", samples.iter().map(|sample| sample.strain));
        document.end();
        document.begin("CellData", "Scalars=\"surface\"");
        document.array("surface", 1, "", self.surfaces.iter().copied());
        document.array("kind", 1, "", self.kinds.iter().copied());
        document.end();
        let positions = points().flat_map(|vertex| vertex.position);
        document.mesh(positions, self.triangles.iter().copied());
        document
    }
}
