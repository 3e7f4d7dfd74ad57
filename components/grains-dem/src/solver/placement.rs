//! The bodies of a scene, placed.

use crate::bodies::body_arrays::PlacedSolid;
use crate::bodies::body_arrays::{BoundingSphere, Joined, PlacedSphere, Twist};
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::contact_law::Law;
use crate::polyhedra::Shape;
use crate::solver::clumps::{self, Whole};
use core::f64::consts::{PI, TAU};
use tremie_geometry::{ClumpPiece, clump};
use tremie_grains_kit::math::random::Random;
use tremie_grains_kit::packing::random_packing::{self, PackingSurroundings};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_messages::{
    Problem,
    scene::{BodySet, Placement, Polyhedra, Polyhedron, PolyhedronPlacement, Scene, Sphere},
};

/// Mass of a sphere [kg].
pub(crate) fn mass(density: f64, diameter: f64) -> f64 {
    density * (PI / 6.0 * diameter * diameter * diameter)
}

/// Mass of a round body of a scene [kg]: of a sphere, in a plane of a cylinder.
pub(crate) fn mass_in(scene: &Scene, density: f64, diameter: f64) -> f64 {
    density * scene.domain.body_volume(diameter)
}

/// Makes cylinders of the round bodies of a plane scene. Prisms are as long as it is deep.
fn lengthen(scene: &Scene, placed: &mut [PlacedSphere]) {
    let Some(depth) = scene.domain.depth() else { return };
    for body in placed.iter_mut().filter(|body| body.solid.is_none()) {
        body.length = Some(depth);
        body.mass = mass_in(scene, scene.bodies[body.set].density, 2.0 * body.ball.radius);
    }
}

/// Width of the spheres around the bodies of a set, over the diameters of spheres of equal volume.
pub(crate) fn around(scene: &Scene, set: &BodySet) -> f64 {
    shape_of(scene, set).map_or(1.0, |(_, around)| around)
}

/// Largest ratio of the motion of a body of the scene to that of a sphere, under a push beside the
/// centroid; at least 1.
pub(crate) fn lever(scene: &Scene) -> f64 {
    let used = scene.bodies.iter().filter_map(|set| shape_of(scene, set));
    let shapes = used.filter_map(|(shape, _)| Shape::of(&scene.shapes[shape as usize]).ok());
    shapes.map(|shape| shape.lever() / OF_SPHERE).fold(1.0, f64::max)
}

/// Lever of a sphere, a push at its surface over one through its centre: `1 + 5/2`.
pub(crate) const OF_SPHERE: f64 = 3.5;

/// Depth of a right-angled corner in a wall at a speed [m/s], over the radius of the sphere inside:
/// the largest of all polyhedra. Its force is `k h^3/(2 A)`, with the area of the largest face, so
/// that `h = (4 m v^2 A/k)^(1/4)`. 0 without polyhedra.
pub(crate) fn corner_depth(scene: &Scene, speed: f64) -> f64 {
    let of = |(set, whole): (&BodySet, Option<Whole>)| {
        let (shape, _) = shape_of(scene, set)?;
        let shape = Shape::of(&scene.shapes[shape as usize]).ok()?;
        let size = random_packing::diameters_of(set).into_iter().fold(0.0, f64::max);
        let laws = scene.contacts.iter().filter(|pair| pair.between.contains(&set.material));
        let stiffness =
            laws.filter_map(|pair| Some(Law::new(&pair.law).as_linear()?.normal_stiffness));
        let softest = stiffness.fold(f64::INFINITY, f64::min);
        let area = shape.largest_face * size * size;
        let mass = whole.map_or_else(|| mass(set.density, size), |whole| whole.mass);
        let energy = 4.0 * mass * speed * speed;
        Some((energy * area / softest).sqrt().sqrt() / (shape.inradius * size))
    };
    scene.bodies.iter().zip(clumps::wholes(scene)).filter_map(of).fold(0.0, f64::max)
}

/// The shape of a set of polyhedra, and the width of the spheres around them.
fn shape_of(scene: &Scene, set: &BodySet) -> Option<(u32, f64)> {
    let Placement::Polyhedra(own) = &set.placement else { return None };
    let number = scene.shapes.iter().position(|shape| shape.name == own.shape)?;
    let shape = Shape::of(&scene.shapes[number]).ok()?;
    Some((number as u32, 2.0 * shape.circumradius))
}

/// The listed bodies of all sets.
pub(crate) fn listed(scene: &Scene) -> Vec<PlacedSphere> {
    let sets = scene.bodies.iter().enumerate();
    let mut placed =
        sets.flat_map(|(set, bodies)| listed_of(set, bodies, scene)).collect::<Vec<_>>();
    lengthen(scene, &mut placed);
    join(scene, &mut placed);
    placed
}

/// Tells bodies to which clumps they belong.
fn join(scene: &Scene, placed: &mut [PlacedSphere]) {
    unite(scene, placed);
    let (numbers, count) = clumps::numbers(scene);
    let mut masses = vec![0.0; count];
    for body in &*placed {
        if let Some(number) = numbers[body.set] {
            masses[number as usize] += body.mass;
        }
    }
    for body in placed {
        let of = |number: u32| Joined { number, mass: masses[number as usize] };
        body.clump = numbers[body.set].map(of);
    }
}

/// Gives bodies of clumps that are unions their shares of these.
fn unite(scene: &Scene, placed: &mut [PlacedSphere]) {
    for name in &scene.unions {
        for ClumpPiece { set, index, share, .. } in clump(scene, name) {
            let first = placed.iter().position(|body| body.set == set);
            let body = first.and_then(|first| placed.get_mut(first + index));
            if let Some(body) = body.filter(|body| body.set == set) {
                body.mass = scene.bodies[set].density * share.volume;
                body.share = Some(share);
            }
        }
    }
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
    let mut surroundings = PackingSurroundings {
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
            Placement::Listed(_)
            | Placement::Polyhedra(Polyhedra {
                placement: PolyhedronPlacement::Listed(_), ..
            }) => placed.extend(listed_of(index, set, scene)),
            Placement::Polyhedra(Polyhedra {
                placement: PolyhedronPlacement::Packed(packing),
                ..
            }) => {
                let Some((shape, around)) = shape_of(scene, set) else { continue };
                // The spheres around polyhedra are packed, so that any orientation fits.
                match random_packing::pack(packing, around, &surroundings) {
                    Ok(balls) => {
                        let solid = |(k, ball): (usize, &BoundingSphere)| {
                            let orientation = random_orientation(packing.seed, k);
                            let size = 2.0 * ball.radius / around;
                            let solid = PlacedSolid { shape, size, orientation };
                            placed_solid(index, set, *ball, solid)
                        };
                        placed.extend(balls.iter().enumerate().map(solid));
                        surroundings.balls.extend(balls);
                    }
                    Err(reached) => {
                        let key = format!(
                            "scene.bodies[{index}].placement.polyhedra.placement.packed.fraction"
                        );
                        problems.push(Problem::new(key, reached.to_string()).help(
                            "lower the fraction, enlarge the region, or let the grains settle into it",
                        ));
                    }
                }
            }
            Placement::Packed(packing) => match random_packing::pack(packing, 1.0, &surroundings) {
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
    lengthen(scene, &mut placed);
    join(scene, &mut placed);
    if problems.is_empty() { Ok(placed) } else { Err(problems) }
}

fn listed_of(set: usize, bodies: &BodySet, scene: &Scene) -> Vec<PlacedSphere> {
    if let Some((shape, around)) = shape_of(scene, bodies)
        && let Placement::Polyhedra(own) = &bodies.placement
        && let PolyhedronPlacement::Listed(list) = &own.placement
    {
        let place = |body: &Polyhedron| {
            let ball =
                BoundingSphere { x: body.position.into(), radius: 0.5 * body.diameter * around };
            let solid = PlacedSolid { shape, size: body.diameter, orientation: body.orientation };
            PlacedSphere {
                twist: Twist { v: body.velocity.into(), w: body.angular_velocity.into() },
                ..placed_solid(set, bodies, ball, solid)
            }
        };
        return list.iter().map(place).collect();
    }
    let Placement::Listed(list) = &bodies.placement else {
        return Vec::new();
    };
    let place = |sphere: &Sphere| PlacedSphere {
        twist: Twist { v: sphere.velocity.into(), w: sphere.angular_velocity.into() },
        ..at_rest(
            set,
            bodies,
            BoundingSphere { x: sphere.position.into(), radius: 0.5 * sphere.diameter },
        )
    };
    list.iter().map(place).collect()
}

fn at_rest(set: usize, bodies: &BodySet, ball: BoundingSphere) -> PlacedSphere {
    PlacedSphere {
        ball,
        solid: None,
        length: None,
        twist: Twist::zero(),
        mass: mass(bodies.density, 2.0 * ball.radius),
        share: None,
        motion: bodies.motion.clone(),
        set,
        clump: None,
    }
}

fn placed_solid(
    set: usize,
    bodies: &BodySet,
    ball: BoundingSphere,
    solid: PlacedSolid,
) -> PlacedSphere {
    let mass = mass(bodies.density, solid.size);
    PlacedSphere { solid: Some(solid), mass, ..at_rest(set, bodies, ball) }
}

/// An orientation at random, all alike (Shoemake, *Graphics Gems III*, 1992).
fn random_orientation(seed: u64, index: usize) -> [f64; 4] {
    // Other streams than those of diameters and places.
    let mut random = Random::new(seed, (1 << 62) | index as u64);
    let [u, v, w] = [(); 3].map(|()| random.unit());
    let ((s1, c1), (s2, c2)) = (libm::sincos(TAU * v), libm::sincos(TAU * w));
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    [a * s1, a * c1, b * s2, b * c2]
}
