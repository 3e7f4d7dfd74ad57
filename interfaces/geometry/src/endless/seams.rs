//! Joins the cross-sections of a patch at two opposite faces, and puts three periods in a row.

use super::patch::Patch;
use super::{EndlessFault, in_line};
use crate::Vec3;
use std::collections::BTreeMap;

/// Largest distance of a corner that is left out from the line between its neighbours, over the
/// tolerance: a cross-section that is cut through triangles has corners that are none.
const NO_CORNER: f64 = 1e-3;

/// Corners that two cross-sections have in common, as seen along the axis.
struct Outline {
    corners: Vec<Vec3>,
    /// Corner that each vertex is.
    of_vertex: BTreeMap<u32, usize>,
    /// Its pieces, from corner to corner, in the direction of the lower cross-section's open edges.
    pieces: Vec<[usize; 2]>,
}

/// Joins a patch that ends in the planes across `axis` at the two faces, and makes three periods of
/// it.
pub fn join(
    patch: &mut Patch,
    axis: usize,
    faces: [f64; 2],
    straight: bool,
    tolerance: f64,
) -> Result<(), EndlessFault> {
    let open = patch.open_edges();
    let edges = faces.map(|at| {
        let on = |v: u32| patch.vertices[v as usize][axis] == at;
        open.iter().copied().filter(|&[a, b]| on(a) && on(b)).collect::<Vec<_>>()
    });
    let outline = outline(patch, axis, &edges, tolerance)?;
    if straight {
        extrude(patch, axis, faces, &outline, tolerance);
    } else {
        repeat(patch, axis, faces, &edges, &outline, tolerance);
    }
    Ok(())
}

fn outline(
    patch: &Patch,
    axis: usize,
    edges: &[Vec<[u32; 2]>; 2],
    tolerance: f64,
) -> Result<Outline, EndlessFault> {
    let flat = |v: u32| {
        let mut x = patch.vertices[v as usize];
        x[axis] = 0.0;
        x
    };
    let (mut corners, mut of_vertex) = (Vec::<Vec3>::new(), BTreeMap::new());
    for &v in edges.iter().flatten().flatten() {
        of_vertex.entry(v).or_insert_with(|| {
            let here = flat(v);
            let known = corners.iter().position(|&c| (c - here).norm() <= tolerance);
            known.unwrap_or_else(|| {
                corners.push(here);
                corners.len() - 1
            })
        });
    }
    let outline = Outline { corners, of_vertex, pieces: Vec::new() };
    let [mut lower, mut upper] = [0, 1].map(|side: usize| {
        let pieces = edges[side].iter().flat_map(|&edge| outline.pieces(edge, tolerance));
        pieces.collect::<Vec<_>>()
    });
    upper.iter_mut().for_each(|piece| piece.reverse());
    lower.sort_unstable();
    upper.sort_unstable();
    if lower != upper || lower.is_empty() {
        return Err(mismatch(patch, axis, edges));
    }
    Ok(Outline { pieces: lower, ..outline })
}

/// The place where two cross-sections differ most.
fn mismatch(patch: &Patch, axis: usize, edges: &[Vec<[u32; 2]>; 2]) -> EndlessFault {
    let flat = |v: u32| {
        let mut x = patch.vertices[v as usize];
        x[axis] = 0.0;
        x
    };
    let mut worst = (0.0, Vec3::zeros(), false);
    for (side, upper) in [(0, false), (1, true)] {
        for &v in edges[side].iter().flatten() {
            let off = edges[1 - side]
                .iter()
                .map(|&[a, b]| distance(flat(v), flat(a), flat(b)))
                .fold(f64::INFINITY, f64::min);
            if off > worst.0 {
                worst = (off, patch.vertices[v as usize], upper);
            }
        }
    }
    EndlessFault::Section { axis, off: worst.0, at: worst.1, upper: worst.2 }
}

/// Distance of a point from a piece of a line.
fn distance(p: Vec3, a: Vec3, b: Vec3) -> f64 {
    let (along, to) = (b - a, p - a);
    let square = along.dot(&along);
    let s = if square > 0.0 { (along.dot(&to) / square).clamp(0.0, 1.0) } else { 0.0 };
    (to - along * s).norm()
}

impl Outline {
    /// The corners along an edge, its ends included.
    fn along(&self, edge: [u32; 2], tolerance: f64) -> Vec<usize> {
        let [from, to] = edge.map(|v| self.of_vertex[&v]);
        let (a, b) = (self.corners[from], self.corners[to]);
        let mut between: Vec<(f64, usize)> = (0..self.corners.len())
            .filter(|&c| c != from && c != to && in_line(a, self.corners[c], b, tolerance))
            .map(|c| ((self.corners[c] - a).dot(&(b - a)), c))
            .collect();
        between.sort_by(|x, y| x.0.total_cmp(&y.0));
        let between = between.into_iter().map(|(_, c)| c);
        std::iter::once(from).chain(between).chain([to]).collect()
    }

    fn pieces(&self, edge: [u32; 2], tolerance: f64) -> Vec<[usize; 2]> {
        let along = self.along(edge, tolerance);
        along.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[a, b]| a != b).collect()
    }

    /// Its pieces with the corners left out that are none. Those on another plane across which it
    /// is open stay.
    fn simple(&self, tolerance: f64) -> Vec<[usize; 2]> {
        let mut next = BTreeMap::<usize, Vec<usize>>::new();
        let mut before = BTreeMap::<usize, Vec<usize>>::new();
        for &[a, b] in &self.pieces {
            next.entry(a).or_default().push(b);
            before.entry(b).or_default().push(a);
        }
        for corner in 0..self.corners.len() {
            let ([a], [c]) = (
                before.get(&corner).map_or(&[][..], Vec::as_slice),
                next.get(&corner).map_or(&[][..], Vec::as_slice),
            ) else {
                continue;
            };
            let (a, c) = (*a, *c);
            let [p, q, r] = [a, corner, c].map(|k| self.corners[k]);
            if a != c && in_line(p, q, r, NO_CORNER * tolerance) {
                for (map, end, new) in [(&mut next, a, c), (&mut before, c, a)] {
                    let list = map.entry(end).or_default();
                    list.iter_mut().filter(|k| **k == corner).for_each(|k| *k = new);
                }
                next.remove(&corner);
                before.remove(&corner);
            }
        }
        next.iter().flat_map(|(&a, ends)| ends.iter().map(move |&b| [a, b])).collect()
    }
}

/// Draws the outline along the axis, from a period below the domain to one above.
fn extrude(
    patch: &mut Patch,
    axis: usize,
    [low, high]: [f64; 2],
    outline: &Outline,
    tolerance: f64,
) {
    let period = high - low;
    let pieces = outline.simple(tolerance);
    let mut used: Vec<usize> = pieces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |corner: usize| used.partition_point(|&k| k < corner) as u32;
    let count = used.len() as u32;
    let ring = |at: f64| {
        used.iter().map(move |&k| {
            let mut x = outline.corners[k];
            x[axis] = at;
            x
        })
    };
    patch.vertices = ring(low - period).chain(ring(high + period)).collect();
    let face = |&[a, b]: &[usize; 2]| {
        let (a, b) = (number(a), number(b));
        vec![a, b, b + count, a + count]
    };
    patch.faces = pieces.iter().map(face).collect();
}

/// Puts three copies of the patch in a row, joined where the outline is.
fn repeat(
    patch: &mut Patch,
    axis: usize,
    faces: [f64; 2],
    edges: &[Vec<[u32; 2]>; 2],
    outline: &Outline,
    tolerance: f64,
) {
    // A vertex of its own for each corner at each face: that of the lower, moved by a period.
    let first = patch.vertices.len() as u32;
    for at in faces {
        patch.vertices.extend(outline.corners.iter().map(|corner| {
            let mut x = *corner;
            x[axis] = at;
            x
        }));
    }
    let count = outline.corners.len() as u32;
    let mut inserted = BTreeMap::new();
    for (side, list) in (0..).zip(edges) {
        for &edge in list {
            let along = outline.along(edge, tolerance);
            let along: Vec<u32> = along.iter().map(|&c| first + side * count + c as u32).collect();
            inserted.insert(edge, along);
        }
    }
    let at_face = |v: u32| {
        let corner = *outline.of_vertex.get(&v)? as u32;
        let side = u32::from(patch.vertices[v as usize][axis] == faces[1]);
        Some(first + side * count + corner)
    };
    let (mut faces_of_one, mut middles) = (Vec::new(), Vec::new());
    let total = patch.vertices.len() as u32;
    for face in &patch.faces {
        let (corners, gained) = joined(face, &inserted, at_face);
        if corners.len() < 3 {
            continue;
        }
        if gained {
            // From its middle no corner on an edge is out of sight.
            let middle = total + middles.len() as u32;
            let share = 1.0 / corners.len() as f64;
            let shares = corners.iter().map(|&v| patch.vertices[v as usize] * share);
            middles.push(shares.fold(Vec3::zeros(), |sum, part| sum + part));
            let n = corners.len();
            faces_of_one.extend((0..n).map(|k| vec![corners[k], corners[(k + 1) % n], middle]));
        } else {
            faces_of_one.push(corners);
        }
    }
    patch.vertices.extend(middles);
    copy_thrice(patch, &faces_of_one, axis, faces[1] - faces[0], first..first + count);
}

/// Corners of a face with those of the outline along its edges, and whether it gained any.
fn joined(
    face: &[u32],
    inserted: &BTreeMap<[u32; 2], Vec<u32>>,
    at_face: impl Fn(u32) -> Option<u32>,
) -> (Vec<u32>, bool) {
    let mut corners: Vec<u32> = Vec::new();
    let mut gained = false;
    for (k, &from) in face.iter().enumerate() {
        let to = face[(k + 1) % face.len()];
        match inserted.get(&[from, to]) {
            Some(along) => {
                gained |= along.len() > 2;
                corners.extend(&along[..along.len() - 1]);
            }
            None => corners.push(at_face(from).unwrap_or(from)),
        }
    }
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    (corners, gained)
}

/// Puts copies of the patch a period before and after it; upper corners of a copy are the `lower`
/// ones of the next.
fn copy_thrice(
    patch: &mut Patch,
    faces_of_one: &[Vec<u32>],
    axis: usize,
    period: f64,
    lower: std::ops::Range<u32>,
) {
    let count = lower.end - lower.start;
    let size = patch.vertices.len() as u32;
    let one = std::mem::take(&mut patch.vertices);
    for copy in -1..=1 {
        patch.vertices.extend(one.iter().map(|&x| {
            let mut x = x;
            if copy != 0 {
                x[axis] += f64::from(copy) * period;
            }
            x
        }));
    }
    let upper = lower.end..lower.end + count;
    let named = |v: u32, copy: u32| {
        if copy < 2 && upper.contains(&v) { (copy + 1) * size + v - count } else { copy * size + v }
    };
    patch.faces = (0..3)
        .flat_map(|copy| {
            let faces = faces_of_one.iter();
            faces
                .map(move |face| face.iter().map(|&v| named(v, copy)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        })
        .collect();
}
