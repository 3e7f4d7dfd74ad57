//! Inside or outside, exactly.
//!
//! A ray from a point along an axis crosses the surface outward and inward; the difference is the
//! winding number of the surface around the point, one inside a solid and zero outside. Whether
//! the ray hits a triangle is decided with exact predicates, and a ray that hits an edge or corner
//! is thought of as moved aside by an infinitely small step, the same for all triangles
//! (Edelsbrunner & Mücke, *ACM Trans. Graphics* 9 (1990) 66). So every ray gives the same answer,
//! and the one that leaves the bounds soonest is taken.

use crate::exact::{Corners, agree, below, on_triangle, turns};
use crate::tree::{Tree, Walk};
use crate::{Bounds, Vec3};

/// Side of a surface that a point is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Winding {
    /// On it.
    On,
    /// Off it, and how often it goes around the point.
    Off(i32),
}

impl Winding {
    /// True if the point is in the solid, its surface included, if the surface goes `far` times
    /// around points far away. Where solids overlap, it goes around more than once: that is their
    /// union.
    pub fn is_solid(self, far: i32) -> bool {
        match self {
            Self::On => true,
            Self::Off(number) => number + far > 0,
        }
    }
}

/// Winding number of the surface around a point.
pub fn winding(tree: &Tree, point: Vec3) -> Winding {
    let bounds = tree.bounds();
    if !bounds.contains(point) {
        return Winding::Off(0);
    }
    let (axis, forward) = shortest_way_out(&bounds, point);
    winding_along(tree, point, axis, forward)
}

/// The same, along the ray of one's choice.
fn winding_along(tree: &Tree, point: Vec3, axis: usize, forward: bool) -> Winding {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let ahead = |b: &Bounds| {
        let beyond = if forward { b.max[axis] >= point[axis] } else { b.min[axis] <= point[axis] };
        beyond
            && b.min[u] <= point[u]
            && point[u] <= b.max[u]
            && b.min[v] <= point[v]
            && point[v] <= b.max[v]
    };
    let mut number = 0;
    let mut on = false;
    tree.walk(ahead, |_, triangle| match crossing(triangle, axis, forward, point) {
        Some(sign) => {
            number += sign;
            Walk::On
        }
        None => {
            on = true;
            Walk::Stop
        }
    });
    if on { Winding::On } else { Winding::Off(number) }
}

/// The axis, and whether forward along it, on which a point leaves the bounds soonest.
fn shortest_way_out(bounds: &Bounds, point: Vec3) -> (usize, bool) {
    let mut best = (f64::INFINITY, (0, true));
    for axis in 0..3 {
        let ways =
            [(bounds.max[axis] - point[axis], true), (point[axis] - bounds.min[axis], false)];
        for (way, forward) in ways {
            if way < best.0 {
                best = (way, (axis, forward));
            }
        }
    }
    best.1
}

/// Term of a triangle in the winding number around a point, on a ray along an axis: 1 if the ray
/// leaves through it, -1 if it enters, 0 if it misses. `None` if the point is on the triangle.
fn crossing(triangle: &Corners, axis: usize, forward: bool, point: Vec3) -> Option<i32> {
    let turns = turns(axis, triangle, point);
    if turns.contains(&0.0) && agree(turns) && on_triangle(triangle, point) {
        return None;
    }
    // All on the left: the triangle faces the positive direction of the axis. All on the right:
    // the negative one.
    let side = [0, 1, 2].map(|i| side(turns[i], axis, triangle[i], triangle[(i + 1) % 3]));
    if side[0] == 0 || side[0] != side[1] || side[1] != side[2] {
        return Some(0);
    }
    let leaves = (side[0] > 0) == forward;
    let below = below(triangle, point);
    if below == 0.0 {
        return None;
    }
    let is_ahead = (below > 0.0) == leaves;
    Some(if !is_ahead {
        0
    } else if leaves {
        1
    } else {
        -1
    })
}

/// On which side of an edge the ray passes, 1 for the left: if it hits the edge, after it moved by
/// a tiny step along the next axis and a much tinier one along the one after. 0 if the edge is
/// parallel to the ray; no ray hits its triangle.
fn side(turn: f64, axis: usize, from: Vec3, to: Vec3) -> i32 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let sign = |x: f64| i32::from(x > 0.0) - i32::from(x < 0.0);
    match (sign(turn), sign(from[v] - to[v])) {
        (0, 0) => sign(to[u] - from[u]),
        (0, aside) => aside,
        (plain, _) => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// An octahedron with corners on whole numbers: rays along the axes hit its corners and edges.
    fn octahedron() -> Tree {
        let corner = |axis: usize, sign: f64| Vec3::ith(axis, 2.0 * sign);
        let side = |i: u8| {
            let [x, y, z] = [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
            let [a, b, c] = [corner(0, x), corner(1, y), corner(2, z)];
            if x * y * z > 0.0 { [a, b, c] } else { [a, c, b] }
        };
        Tree::of((0..8).map(side))
    }

    proptest! {
        #[test]
        fn all_rays_agree(cells in proptest::array::uniform3(-8i32..=8), fine in any::<bool>()) {
            let p = cells.map(|i| f64::from(i) / if fine { 7.0 } else { 4.0 });
            let tree = octahedron();
            let found = winding(&tree, p.into());
            let across: f64 = p.iter().map(|x| x.abs()).sum();
            // The octahedron's sides are where the coordinates' magnitudes add up to two.
            if (across - 2.0).abs() > 1e-12 {
                prop_assert_eq!(found, Winding::Off(i32::from(across < 2.0)));
            } else if !fine {
                prop_assert_eq!(found, Winding::On);
            }
            for axis in 0..3 {
                for forward in [false, true] {
                    prop_assert_eq!(winding_along(&tree, p.into(), axis, forward), found);
                }
            }
        }
    }
}
