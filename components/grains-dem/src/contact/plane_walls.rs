//! Laws of walls, and walls that lean against each other.

use crate::contact::material_laws::Laws;
use crate::contact::region_shares::in_common;
use tremie_grains_kit::space::plane_walls::{Wall, of_scene};
use tremie_messages::scene::Scene;

/// Number of each wall's law with each material: `of[wall][material]`.
pub(crate) type WallLaws = Vec<Vec<u16>>;

/// True if a body may touch two of the walls as one region: the angle between their normals is less
/// than in a corner.
pub(crate) fn any_lean(walls: &[Wall]) -> bool {
    let walls = || walls.iter().filter(|wall| !wall.mirror).enumerate();
    walls().any(|(i, a)| walls().take(i).any(|(_, b)| in_common(a.normal, b.normal) > 0.0))
}

/// The laws of the walls of [`of_scene`]; mirrors get laws of their own, without friction.
pub(crate) fn laws_of_scene(scene: &Scene, laws: &mut Laws) -> WallLaws {
    let surfaces = crate::contact::material_laws::surfaces(scene);
    let walls = surfaces.iter().take(of_scene(scene).len());
    walls
        .map(|wall| {
            let material = laws.material(wall.material);
            (0..laws.materials())
                .map(|other| {
                    let law = laws.between(material, other);
                    if wall.mirror { laws.add_mirror(law) } else { law }
                })
                .collect()
        })
        .collect()
}
