//! Walls: planes that stay where they are. A face of the domain may slide along itself.

use crate::Vec3;
use crate::space::rigid_body::BoundingSphere;
use tremie_messages::scene::{Course, Face, Scene};

/// A wall; bodies are on the side to which the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
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
    /// The wall through a point [m], bodies on the side of its normal.
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

/// True if a face of the domain is a wall or symmetry plane: neither periodic nor an outlet, nor
/// across a plane scene, in which nothing moves that way.
pub fn holds(scene: &Scene, axis: usize, side: usize) -> bool {
    scene.domain.across != Some(axis)
        && scene.domain.faces[axis][side] != Face::Periodic
        && !scene.is_way_out(axis, side)
}

/// Axis and side of the domain's faces that hold grains, in the order of their walls.
pub fn faces(scene: &Scene) -> impl Iterator<Item = (usize, usize)> {
    let sides = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    sides.filter(|&(axis, side)| holds(scene, axis, side))
}

/// The walls of a scene: first the domain's faces, `(lower, upper)` by axis, those left out through
/// which spheres leave, then its planes.
pub fn of_scene(scene: &Scene) -> Vec<Wall> {
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
pub struct Sliding {
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
pub fn sliding(scene: &Scene) -> Vec<Sliding> {
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
pub fn without_mirrors(scene: &Scene) -> Vec<Wall> {
    of_scene(scene).into_iter().filter(|wall| !wall.mirror).collect()
}

/// Walls on those faces of a box that `is_wall(axis, side)` names.
pub fn of_box(min: [f64; 3], max: [f64; 3], is_wall: impl Fn(usize, usize) -> bool) -> Vec<Wall> {
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

/// Names of the walls of [`of_scene`], in its order, for messages.
pub fn names(scene: &Scene) -> Vec<String> {
    let face = |(axis, side): (usize, usize)| {
        let (side, axis) = (["lower", "upper"][side], ["x", "y", "z"][axis]);
        format!("the domain's {side} face in {axis}")
    };
    let planes = (0..scene.planes.len()).map(|plane| format!("plane {plane}"));
    faces(scene).map(face).chain(planes).collect()
}

/// Materials of the walls of [`of_scene`], in its order.
pub fn materials(scene: &Scene) -> impl Iterator<Item = &str> {
    let of_faces = faces(scene).map(|_| scene.domain.material.as_str());
    of_faces.chain(scene.planes.iter().map(|plane| plane.material.as_str()))
}
