//! The bodies of a scene, placed.

use crate::{
    bodies::{Ball, PlacedSphere, Twist},
    packing::{self, Surroundings},
    parts::PlacedPart,
    periodic::PeriodicBox,
    walls::Wall,
};
use core::f64::consts::PI;
use tremie_messages::{
    Problem,
    scene::{BodySet, Placement, Scene, Sphere},
};

/// Mass of a sphere [kg].
pub(crate) fn mass(density: f64, diameter: f64) -> f64 {
    density * (PI / 6.0 * diameter * diameter * diameter)
}

/// The listed spheres of all sets.
pub(crate) fn listed(scene: &Scene) -> Vec<PlacedSphere> {
    let sets = scene.bodies.iter().enumerate();
    sets.flat_map(|(set, bodies)| listed_of(set, bodies)).collect()
}

/// All bodies, in the order of sets. Packings keep clear of all parts, of all listed bodies,
/// wherever these stand in the scene, and of the packings before them.
///
/// # Errors
/// Packings that cannot be made, with what was reached.
pub(crate) fn place(
    scene: &Scene,
    parts: &[PlacedPart],
) -> Result<Vec<PlacedSphere>, Vec<Problem>> {
    let mut surroundings = Surroundings {
        parts,
        bounds: PeriodicBox::new(&scene.domain),
        planes: scene
            .planes
            .iter()
            .map(|p| Wall::through(p.point.into(), p.normal.into()))
            .collect(),
        balls: listed(scene).iter().map(|s| s.ball).collect(),
    };
    let mut placed = Vec::new();
    let mut problems = Vec::new();
    for (index, set) in scene.bodies.iter().enumerate() {
        match &set.placement {
            Placement::Listed(_) => placed.extend(listed_of(index, set)),
            Placement::Packed(packing) => match packing::pack(packing, &surroundings) {
                Ok(balls) => {
                    placed.extend(balls.iter().map(|&ball| at_rest(index, set, ball)));
                    surroundings.balls.extend(balls);
                }
                Err(reached) => {
                    let key = format!("scene.bodies[{index}].placement.packed.fraction");
                    problems.push(Problem::new(key, reached.to_string()).help(
                        "lower the fraction, enlarge the region, or let the grains settle into it",
                    ));
                }
            },
        }
    }
    if problems.is_empty() { Ok(placed) } else { Err(problems) }
}

fn listed_of(set: usize, bodies: &BodySet) -> Vec<PlacedSphere> {
    let Placement::Listed(list) = &bodies.placement else {
        return Vec::new();
    };
    let place = |sphere: &Sphere| PlacedSphere {
        twist: Twist { v: sphere.velocity.into(), w: sphere.angular_velocity.into() },
        ..at_rest(set, bodies, Ball { x: sphere.position.into(), radius: 0.5 * sphere.diameter })
    };
    list.iter().map(place).collect()
}

fn at_rest(set: usize, bodies: &BodySet, ball: Ball) -> PlacedSphere {
    PlacedSphere {
        ball,
        twist: Twist::zero(),
        mass: mass(bodies.density, 2.0 * ball.radius),
        motion: bodies.motion.clone(),
        set,
    }
}
