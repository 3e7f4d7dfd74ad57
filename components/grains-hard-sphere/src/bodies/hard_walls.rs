//! Plane walls, and the faces of the domain that slide along themselves.

use crate::Vec3;
use crate::impact::collision::{Collider, ImpactLaw};
use crate::impact::impact_laws::ImpactLaws;
use tremie_grains_kit::space::plane_walls::{self, Sliding, Wall};
use tremie_messages::scene::Scene;

/// The walls of a scene, with their materials and what pushed them.
#[derive(Clone, Debug, Default)]
pub struct HardWalls {
    /// The walls: faces of the domain first.
    pub walls: Vec<Wall>,
    materials: Vec<u16>,
    sliding: Vec<Sliding>,
    /// Impulse that each received since a window began [N·s].
    pub impulses: Vec<Vec3>,
}

impl HardWalls {
    /// The walls of a scene.
    pub fn of_scene(scene: &Scene, laws: &ImpactLaws) -> Self {
        let walls = plane_walls::of_scene(scene);
        let materials = plane_walls::materials(scene).map(|name| laws.material(name)).collect();
        let sliding = plane_walls::sliding(scene).into_iter().filter(Sliding::changes).collect();
        let impulses = vec![Vec3::zeros(); walls.len()];
        Self { walls, materials, sliding, impulses }
    }

    /// Gives walls that slide their velocities at a time of the run [s].
    pub fn set_time(&mut self, time: f64) {
        for sliding in &self.sliding {
            sliding.set(&mut self.walls, time);
        }
    }

    /// A wall as a partner in a collision.
    pub fn collider(&self, wall: usize) -> Collider {
        let v = self.walls[wall].velocity;
        Collider { v, ..Collider::STILL }
    }

    /// The law between a wall and a material; a symmetry plane has no friction.
    pub fn law(&self, wall: usize, material: u16, laws: &ImpactLaws) -> ImpactLaw {
        let law = *laws.between(self.materials[wall], material);
        if self.walls[wall].mirror { ImpactLaw { friction: 0.0, ..law } } else { law }
    }
}
