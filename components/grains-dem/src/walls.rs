//! Walls: planes that never move.

use crate::{Vec3, bodies::Ball};
use tremie_messages::scene::{Domain, Face, Scene};

/// A wall; bodies are on the side to which the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    /// Unit normal, into the space of the bodies.
    pub normal: Vec3,
    /// `x.normal` of the points of the wall [m].
    pub offset: f64,
}

impl Wall {
    pub fn through(point: Vec3, normal: Vec3) -> Self {
        let normal = normal.unscale(normal.norm_squared().sqrt());
        Self { normal, offset: point.dot(&normal) }
    }

    /// How far `ball` reaches into the wall [m]; negative while it does not touch.
    #[inline(always)]
    pub fn overlap(&self, ball: &Ball) -> f64 {
        ball.radius - (ball.x.dot(&self.normal) - self.offset)
    }
}

/// The walls of a scene: first the domain's faces, `(lower, upper)` by axis, then its planes.
pub(crate) fn of_scene(scene: &Scene) -> Vec<Wall> {
    let mut walls = of_box(scene.domain.min, scene.domain.max, |axis, side| {
        scene.domain.faces[axis][side] != Face::Periodic
    });
    walls.extend(scene.planes.iter().map(|p| Wall::through(p.point.into(), p.normal.into())));
    walls
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

/// What a user calls wall number `index` of [`of_scene`].
pub(crate) fn name(domain: &Domain, index: usize) -> String {
    let faces = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    let mut walls = faces.filter(|&(axis, side)| domain.faces[axis][side] != Face::Periodic);
    let count = walls.clone().count();
    match walls.nth(index) {
        Some((axis, side)) => {
            let (side, axis) = (["lower", "upper"][side], ["x", "y", "z"][axis]);
            format!("the domain's {side} wall in {axis}")
        }
        None => format!("plane {}", index - count),
    }
}
