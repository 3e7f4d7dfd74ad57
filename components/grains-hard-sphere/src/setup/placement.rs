//! Bodies of a scene at the start: listed ones, and packings.

use crate::Vec3;
use crate::bodies::hard_body::HardBody;
use crate::bodies::hard_parts::HardPart;
use crate::impact::impact_laws::ImpactLaws;
use tremie_grains_kit::packing::random_packing::{self, PackingSurroundings};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_grains_kit::space::rigid_body::{BoundingSphere, Twist};
use tremie_messages::Problem;
use tremie_messages::scene::{BodySet, Motion, Placement, Scene, Sphere};

/// A body as it is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedBody {
    /// Where and how large it is.
    pub ball: BoundingSphere,
    /// Velocities.
    pub twist: Twist,
    /// Index of its set.
    pub set: usize,
}

impl PlacedBody {
    /// Its mass in a scene [kg].
    pub fn mass(&self, scene: &Scene) -> f64 {
        scene.bodies[self.set].density * scene.domain.body_volume(2.0 * self.ball.radius)
    }

    /// As the solver takes it.
    pub fn body(&self, scene: &Scene, laws: &ImpactLaws) -> HardBody {
        let set = &scene.bodies[self.set];
        let material = laws.material(&set.material);
        let mut body = HardBody::new(self.ball.x, self.ball.radius, self.mass(scene), material);
        (body.v, body.w) = (self.twist.v, self.twist.w);
        if set.motion != Motion::Free {
            body.inverse_mass = 0.0;
        }
        body
    }
}

/// The listed bodies of a set.
fn listed_of(index: usize, set: &BodySet) -> Vec<PlacedBody> {
    let Placement::Listed(list) = &set.placement else { return Vec::new() };
    let place = |sphere: &Sphere| PlacedBody {
        ball: BoundingSphere { x: sphere.position.into(), radius: 0.5 * sphere.diameter },
        twist: Twist { v: sphere.velocity.into(), w: sphere.angular_velocity.into() },
        set: index,
    };
    list.iter().map(place).collect()
}

/// The listed bodies of all sets.
pub fn listed(scene: &Scene) -> Vec<PlacedBody> {
    scene.bodies.iter().enumerate().flat_map(|(k, set)| listed_of(k, set)).collect()
}

/// All bodies, in the order of sets. Packings keep clear of all parts, of all listed bodies, and of
/// the packings before them.
///
/// # Errors
/// Packings that cannot be made, with what was reached.
pub fn place(scene: &Scene, parts: &[HardPart]) -> Result<Vec<PlacedBody>, Vec<Problem>> {
    let plane = |p: &tremie_messages::scene::Plane| Wall::through(p.point.into(), p.normal.into());
    let mut surroundings = PackingSurroundings {
        parts,
        bounds: PeriodicBox::new(&scene.domain),
        planes: scene.planes.iter().map(plane).collect(),
        balls: listed(scene).iter().map(|body| body.ball).collect(),
    };
    let (mut placed, mut problems) = (Vec::new(), Vec::new());
    for (index, set) in scene.bodies.iter().enumerate() {
        let Placement::Packed(packing) = &set.placement else {
            placed.extend(listed_of(index, set));
            continue;
        };
        match random_packing::pack(packing, 1.0, &surroundings) {
            Ok(balls) => {
                let at_rest = |&ball| PlacedBody { ball, twist: Twist::zero(), set: index };
                placed.extend(balls.iter().map(at_rest));
                surroundings.balls.extend(balls);
            }
            Err(reached) => {
                let key = format!("scene.bodies[{index}].placement.packed.fraction");
                let help = "lower the fraction or enlarge the region";
                problems.push(Problem::new(key, reached.to_string()).help(help));
            }
        }
    }
    if problems.is_empty() { Ok(placed) } else { Err(problems) }
}

/// Fastest speed of a body or a part at the start [m/s].
pub fn fastest(scene: &Scene) -> f64 {
    let bodies = listed(scene).into_iter().map(|body| body.twist.v.norm_squared().sqrt());
    let of_motion = |motion: &Motion| match motion {
        Motion::Prescribed(points) => points
            .iter()
            .map(|point| Vec3::from(point.velocity).norm_squared().sqrt())
            .fold(0.0, f64::max),
        Motion::Timed(timed) => Vec3::from(timed.velocity).norm_squared().sqrt(),
        Motion::Free | Motion::Fixed | Motion::Slider(_) => 0.0,
    };
    let sets = scene.bodies.iter().map(|set| of_motion(&set.motion));
    let parts = scene.parts.iter().map(|part| of_motion(&part.motion));
    bodies.chain(sets).chain(parts).fold(0.0, f64::max)
}
