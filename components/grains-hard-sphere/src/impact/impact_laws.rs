//! The impact laws of a scene as a table by materials.

use crate::impact::collision::ImpactLaw;
use tremie_messages::scene::{Damping, Scene};

/// Materials of a scene by number, and the law of each pair of them.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactLaws {
    materials: Vec<String>,
    of_pair: Vec<ImpactLaw>,
}

impl ImpactLaws {
    /// The table of a checked scene. Materials that never meet lose nothing.
    pub fn of_scene(scene: &Scene, tangential_restitution: f64) -> Self {
        let mut materials: Vec<String> = Vec::new();
        let names = core::iter::once(&scene.domain.material)
            .chain(scene.planes.iter().map(|plane| &plane.material))
            .chain(scene.parts.iter().map(|part| &part.material))
            .chain(scene.bodies.iter().map(|set| &set.material));
        for name in names {
            if !materials.contains(name) {
                materials.push(name.clone());
            }
        }
        let law = |a: &String, b: &String| {
            let found = scene.law(a, b);
            let restitution = match found.map(|law| law.damping) {
                Some(Damping::Restitution(e)) => e,
                _ => 1.0,
            };
            let friction = found.map_or(0.0, |law| law.friction);
            ImpactLaw { restitution, friction, tangential_restitution }
        };
        let of_pair =
            materials.iter().flat_map(|a| materials.iter().map(move |b| law(a, b))).collect();
        Self { materials, of_pair }
    }

    /// Number of a material of the scene.
    pub fn material(&self, name: &str) -> u16 {
        // Every material of the scene is in the table.
        self.materials.iter().position(|known| known == name).unwrap_or(0) as u16
    }

    /// The law between two materials.
    #[inline(always)]
    pub fn between(&self, a: u16, b: u16) -> &ImpactLaw {
        &self.of_pair[a as usize * self.materials.len() + b as usize]
    }
}
