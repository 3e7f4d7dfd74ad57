//! Corners that lie on the edge of another triangle, which does not have them: T-junctions.
//!
//! Seen from afar such a surface is closed, but the edges on the two sides of the seam are not the
//! same ones. It is told apart from a hole, because what helps is another.

use crate::edges::{Edges, ends};
use crate::{Fault, Mesh, Vec3};

/// Open edges that are looked at, at most: each is held against all corners of its neighbourhood.
const MOST: usize = 20_000;

/// T-junctions among open edges.
pub struct Junctions {
    /// The fault, if there are any.
    pub fault: Option<Fault>,
    /// Open edges that they do not explain.
    pub others: Vec<u32>,
}

/// Finds corners at open edges that lie on other open edges, within `tolerance` [m] of them.
pub fn find(mesh: &Mesh, edges: &Edges, tolerance: f64) -> Junctions {
    let open = &edges.open;
    let none = || Junctions { fault: None, others: open.clone() };
    if open.len() > MOST {
        return none();
    }
    let at = |v: u32| mesh.vertices[v as usize];
    let mut corners: Vec<u32> = open.iter().flat_map(|&h| ends(&mesh.triangles, h)).collect();
    corners.sort_unstable();
    corners.dedup();
    // Along the axis on which they lie farthest apart.
    let bounds = crate::Bounds::of(corners.iter().map(|&v| at(v)));
    let size = bounds.size();
    let axis = (1..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    corners.sort_by(|&a, &b| at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(&b)));
    let mut found: Vec<(u32, u32)> = Vec::new();
    // Edges whose seam is closed from the other side, as pairs of corners in order.
    let mut seams: Vec<[u32; 2]> = Vec::new();
    let mut is_split = vec![false; open.len()];
    for (k, &h) in open.iter().enumerate() {
        let [a, b] = ends(&mesh.triangles, h);
        let (low, high) = (at(a)[axis].min(at(b)[axis]), at(a)[axis].max(at(b)[axis]));
        let from = corners.partition_point(|&v| at(v)[axis] < low - tolerance);
        let near = corners[from..].iter().take_while(|&&v| at(v)[axis] <= high + tolerance);
        let mut on: Vec<(f64, u32)> = near
            .filter(|&&v| v != a && v != b)
            .filter_map(|&v| Some((along(at(v), at(a), at(b), tolerance)?, v)))
            .collect();
        if on.is_empty() {
            continue;
        }
        is_split[k] = true;
        on.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        found.extend(on.iter().map(|&(_, v)| (v, h)));
        let line: Vec<u32> = [a].into_iter().chain(on.iter().map(|x| x.1)).chain([b]).collect();
        // Corners on one line: any two of them may be an edge of the other side.
        for (i, &p) in line.iter().enumerate() {
            seams.extend(line[i + 1..].iter().map(|&q| [p.min(q), p.max(q)]));
        }
    }
    let Some(&(corner, edge)) = found.first() else { return none() };
    seams.sort_unstable();
    let explained = |k: usize, h: u32| {
        let [a, b] = ends(&mesh.triangles, h);
        is_split[k] || seams.binary_search(&[a.min(b), a.max(b)]).is_ok()
    };
    let others = open.iter().enumerate().filter(|&(k, &h)| !explained(k, h)).map(|(_, &h)| h);
    let mut at_corners: Vec<u32> = found.iter().map(|&(v, _)| v).collect();
    at_corners.sort_unstable();
    at_corners.dedup();
    let fault = Fault::Junction {
        corners: at_corners.len(),
        first: at(corner),
        edge: ends(&mesh.triangles, edge).map(at),
    };
    Junctions { fault: Some(fault), others: others.collect() }
}

/// Place of a point on an edge as a fraction of its length; `None` for one that is off the edge.
fn along(point: Vec3, a: Vec3, b: Vec3, tolerance: f64) -> Option<f64> {
    let (edge, to) = (b - a, point - a);
    let length = edge.norm();
    let fraction = to.dot(&edge) / (length * length);
    let off = to.cross(&edge).norm() / length;
    let inside = fraction * length > tolerance && (1.0 - fraction) * length > tolerance;
    (inside && off <= tolerance).then_some(fraction)
}
