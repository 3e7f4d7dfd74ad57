//! Walls: planes that stay where they are. A face of the domain may slide along itself.

use crate::Vec3;
use crate::bodies::body_arrays::BoundingSphere;
use crate::contact::material_laws::Laws;
use crate::contact::region_shares::in_common;
use tremie_messages::scene::{Course, Face, Scene};

/// A wall; bodies are on the side to which the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    /// Unit normal, into the space of the bodies.
    pub normal: Vec3,
    /// `x.normal` of the points of the wall [m].
    pub offset: f64,
    /// Velocity along itself [m/s].
    pub velocity: Vec3,
    /// True for a symmetry plane, which stands for its mirrored side.
    pub mirror: bool,
}

impl Wall {
    pub fn through(point: Vec3, normal: Vec3) -> Self {
        let normal = normal.unscale(normal.norm_squared().sqrt());
        Self { normal, offset: point.dot(&normal), velocity: Vec3::zeros(), mirror: false }
    }

    /// Overlap of `ball` with the wall [m]; negative while they do not touch.
    #[inline(always)]
    pub fn overlap(&self, ball: &BoundingSphere) -> f64 {
        ball.radius - (ball.x.dot(&self.normal) - self.offset)
    }
}

/// Number of each wall's law with each material: `of[wall][material]`.
pub(crate) type WallLaws = Vec<Vec<u16>>;

/// True if a face of the domain is a wall or symmetry plane: neither periodic nor an outlet, nor
/// across a plane scene, in which nothing moves that way.
pub(crate) fn holds(scene: &Scene, axis: usize, side: usize) -> bool {
    scene.domain.across != Some(axis)
        && scene.domain.faces[axis][side] != Face::Periodic
        && !scene.is_way_out(axis, side)
}

/// Axis and side of the domain's faces that hold grains, in the order of their walls.
pub(crate) fn faces(scene: &Scene) -> impl Iterator<Item = (usize, usize)> {
    let sides = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    sides.filter(|&(axis, side)| holds(scene, axis, side))
}

/// The walls of a scene: first the domain's faces, `(lower, upper)` by axis, those left out through
/// which spheres leave, then its planes.
pub(crate) fn of_scene(scene: &Scene) -> Vec<Wall> {
    let domain = &scene.domain;
    let mut walls = of_box(domain.min, domain.max, |axis, side| holds(scene, axis, side));
    for (wall, (axis, side)) in walls.iter_mut().zip(faces(scene)) {
        wall.mirror = domain.faces[axis][side] == Face::Symmetry;
    }
    for sliding in sliding(scene) {
        sliding.set(&mut walls, 0.0);
    }
    walls.extend(scene.planes.iter().map(|p| Wall::through(p.point.into(), p.normal.into())));
    walls
}

/// A wall that slides along itself.
#[derive(Clone, Debug)]
pub(crate) struct Sliding {
    /// The wall, with its velocity at the factor 1.
    wall: Wall,
    course: Course,
}

impl Sliding {
    /// Gives it, among others, its velocity at a time [s].
    pub fn set(&self, walls: &mut [Wall], time: f64) {
        let Wall { normal, offset, velocity, .. } = self.wall;
        let is_it = |wall: &&mut Wall| wall.normal == normal && wall.offset == offset;
        for wall in walls.iter_mut().filter(is_it) {
            wall.velocity = velocity * self.course.at(time);
        }
    }

    /// True if the velocity of the wall changes with time.
    pub fn changes(&self) -> bool {
        self.course != Course::CONSTANT
    }
}

/// The faces of a scene's domain that slide along themselves.
pub(crate) fn sliding(scene: &Scene) -> Vec<Sliding> {
    let domain = &scene.domain;
    let mut all = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let Face::Wall { velocity, course } = &domain.faces[axis][side] else { continue };
        let only = |a: usize, s: usize| (a, s) == (axis, side);
        let velocity = Vec3::from(*velocity);
        for mut wall in of_box(domain.min, domain.max, only) {
            wall.velocity = velocity - wall.normal * velocity.dot(&wall.normal);
            if wall.velocity != Vec3::zeros() {
                all.push(Sliding { wall, course: course.clone() });
            }
        }
    }
    all
}

/// Walls of a scene without its symmetry planes.
pub(crate) fn without_mirrors(scene: &Scene) -> Vec<Wall> {
    of_scene(scene).into_iter().filter(|wall| !wall.mirror).collect()
}

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

/// Walls on those faces of a box that `is_wall(axis, side)` names.
pub(crate) fn of_box(
    min: [f64; 3],
    max: [f64; 3],
    is_wall: impl Fn(usize, usize) -> bool,
) -> Vec<Wall> {
    let mut walls = Vec::new();
    for axis in 0..3 {
        for (side, point, sign) in [(0, min, 1.0), (1, max, -1.0)] {
            if is_wall(axis, side) {
                let mut normal = Vec3::zeros();
                normal[axis] = sign;
                walls.push(Wall::through(point.into(), normal));
            }
        }
    }
    walls
}
