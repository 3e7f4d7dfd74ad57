//! Parts whose surfaces had to be mended.

use crate::survey::static_geometry::StaticGeometry;
use serde::{Deserialize, Serialize};
use tremie_geometry::Surface;
use tremie_messages::Finding;
use tremie_messages::scene::Scene;

/// Part of a surface's triangles whose mending a user should look at.
const MENDED: f64 = 0.05;
/// A part whose file had to be mended to make a closed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MendedPart {
    /// Its name.
    pub part: String,
    /// Triangles and vertices that were changed.
    pub changes: usize,
    /// Triangles that it has now.
    pub triangles: usize,
    /// Changes that were made, in words.
    pub what: String,
}

impl MendedPart {
    /// With a verdict.
    pub fn finding(&self) -> Finding {
        let Self { part, changes, triangles, what } = self;
        let all = format!("of {triangles} triangles: {what}");
        Finding::new(format!("repairs of {part}"), *changes as f64, "1").because(&all).doubtful_if(
            *changes as f64 > MENDED * *triangles as f64,
            format!("{all}; so much is rarely an accident of the export"),
            "look at the part in the viewer, or export it again as one closed solid",
        )
    }
}

/// Parts whose files had to be mended.
pub fn mended_parts(scene: &Scene, ground: &StaticGeometry) -> Vec<MendedPart> {
    let of = |(part, surface): (usize, &Surface)| {
        let done = surface.repairs();
        let changes = done.welded_near + done.dropped + done.turned + done.flipped;
        (changes > 0 || done.offset > 0.0).then(|| MendedPart {
            part: scene.parts[part].name.clone(),
            changes,
            triangles: surface.mesh().triangles.len(),
            what: done.to_string(),
        })
    };
    ground.part_surfaces().filter_map(of).collect()
}
