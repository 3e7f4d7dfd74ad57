//! Triangles of a surface that pass through each other.

use crate::exact::{Corners, agree, below, turn, turns};
use crate::surface::Surface;
use crate::tree::Walk;
use crate::{Bounds, Vec3};

/// Places where a surface passes through itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersections {
    /// Pairs of triangles with more in common than the edge or corner that they share.
    pub pairs: usize,
    /// The first pair.
    pub first: [u32; 2],
    /// The middle of that pair's common bounds [m].
    pub near: Vec3,
}

impl Surface {
    /// Looks for triangles that pass through or touch each other, with exact predicates. A second
    /// tree for the pairs to try (parry's `leaf_pairs`) would cost as much to build as it saves: 30
    /// ms of 100 ms on 102,400 triangles.
    ///
    /// Such a surface still has an inside: the union of its solids. But closest points may be on
    /// triangles within it, and distances inside are too small.
    pub fn intersections(&self) -> Option<Intersections> {
        let mut found: Option<Intersections> = None;
        let mut candidates = Vec::new();
        for one in 0..self.mesh.triangles.len() as u32 {
            let corners = self.mesh.corners(one as usize);
            let bounds = Bounds::of(corners);
            candidates.clear();
            self.tree.walk(
                |b| b.meets(&bounds),
                |other, theirs| {
                    if other > one && Bounds::of(*theirs).meets(&bounds) {
                        candidates.push((other, *theirs));
                    }
                    Walk::On
                },
            );
            candidates.sort_unstable_by_key(|(other, _)| *other);
            for (other, theirs) in &candidates {
                let names = [one, *other].map(|t| self.mesh.triangles[t as usize]);
                if !overlap(&corners, theirs, names) {
                    continue;
                }
                let both = Bounds::of(*theirs);
                let common = Bounds {
                    min: Vec3::from_fn(|k, _| bounds.min[k].max(both.min[k])),
                    max: Vec3::from_fn(|k, _| bounds.max[k].min(both.max[k])),
                };
                let start = Intersections { pairs: 0, first: [one, *other], near: common.centre() };
                found.get_or_insert(start).pairs += 1;
            }
        }
        found
    }
}

/// True if triangles have more in common than the vertices that they share by name.
fn overlap(one: &Corners, other: &Corners, names: [[u32; 3]; 2]) -> bool {
    let shared = |i: usize| names[1].contains(&names[0][i]);
    match (0..3).filter(|&i| shared(i)).count() {
        0 => edges_meet(one, other, |_| true, |_| true),
        1 => {
            // Only the edges opposite the shared corner can tell: the others start on both.
            let lone = |mine: [u32; 3], theirs: [u32; 3]| {
                (0..3).find(|&i| theirs.contains(&mine[i])).map_or(0, |i| (i + 1) % 3)
            };
            let (a, b) = (lone(names[0], names[1]), lone(names[1], names[0]));
            edges_meet(one, other, |i| i == a, |i| i == b)
        }
        _ => folded(one, other, names),
    }
}

/// True if a chosen edge of one triangle meets the other triangle.
fn edges_meet(
    one: &Corners,
    other: &Corners,
    mine: impl Fn(usize) -> bool,
    theirs: impl Fn(usize) -> bool,
) -> bool {
    let edge = |t: &Corners, i: usize| [t[i], t[(i + 1) % 3]];
    (0..3).any(|i| mine(i) && segment_meets(edge(one, i), other))
        || (0..3).any(|i| theirs(i) && segment_meets(edge(other, i), one))
}

/// True if a segment has a point in common with a triangle.
fn segment_meets([from, to]: [Vec3; 2], triangle: &Corners) -> bool {
    let (start, end) = (below(triangle, from), below(triangle, to));
    if (start > 0.0 && end > 0.0) || (start < 0.0 && end < 0.0) {
        return false;
    }
    let [a, b, c] = *triangle;
    if start == 0.0 && end == 0.0 {
        return meets_in_plane([from, to], triangle);
    }
    agree([below(&[from, to, a], b), below(&[from, to, b], c), below(&[from, to, c], a)])
}

/// The same for a segment in the triangle's plane, seen along an axis on which the triangle has an
/// area.
fn meets_in_plane([from, to]: [Vec3; 2], triangle: &Corners) -> bool {
    let [a, b, c] = *triangle;
    let Some(axis) = (0..3).find(|&axis| turn(axis, a, b, c) != 0.0) else { return false };
    let inside = |p: Vec3| agree(turns(axis, triangle, p));
    let crosses = |p: Vec3, q: Vec3| {
        let opposite = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
        opposite(turn(axis, from, to, p), turn(axis, from, to, q))
            && opposite(turn(axis, p, q, from), turn(axis, p, q, to))
    };
    inside(from) || inside(to) || crosses(a, b) || crosses(b, c) || crosses(c, a)
}

/// True if triangles that share an edge lie on each other: in one plane, on one side of it.
fn folded(one: &Corners, other: &Corners, names: [[u32; 3]; 2]) -> bool {
    let apex =
        |mine: usize, theirs: usize| (0..3).find(|&i| !names[theirs].contains(&names[mine][i]));
    let (Some(i), Some(j)) = (apex(0, 1), apex(1, 0)) else { return true };
    if below(one, other[j]) != 0.0 {
        return false;
    }
    let (a, b) = (one[(i + 1) % 3], one[(i + 2) % 3]);
    (0..3).any(|axis| {
        let (mine, theirs) = (turn(axis, a, b, one[i]), turn(axis, a, b, other[j]));
        (mine > 0.0 && theirs > 0.0) || (mine < 0.0 && theirs < 0.0)
    })
}
