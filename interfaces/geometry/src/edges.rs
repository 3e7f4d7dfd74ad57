//! Edges that triangles share.

use crate::junctions::{self, Junctions};
use crate::{Bounds, Fault, Mesh};

/// No half-edge.
pub const NONE: u32 = u32::MAX;

/// The edges of a mesh. Half-edge `3 t + i` runs from corner `i` of triangle `t` to the next.
pub struct Edges {
    /// For each half-edge the one of the neighbour across it; [`NONE`] where there is not exactly
    /// one.
    pub twins: Vec<u32>,
    /// Half-edges without a neighbour, ascending.
    pub open: Vec<u32>,
    /// First half-edge of each edge with more than two triangles, and how many it has; ascending.
    pub crowded: Vec<(u32, usize)>,
}

/// Vertices at the ends of a half-edge.
pub fn ends(triangles: &[[u32; 3]], half_edge: u32) -> [u32; 2] {
    let (triangle, i) = (half_edge as usize / 3, half_edge as usize % 3);
    [triangles[triangle][i], triangles[triangle][(i + 1) % 3]]
}

/// Pairs of edges by sorting them: the same order on every machine.
pub fn pair(triangles: &[[u32; 3]]) -> Edges {
    let count = 3 * triangles.len() as u32;
    let mut keyed: Vec<(u64, u32)> = (0..count)
        .map(|h| {
            let [a, b] = ends(triangles, h);
            ((u64::from(a.min(b)) << 32) | u64::from(a.max(b)), h)
        })
        .collect();
    keyed.sort_unstable();
    let mut edges =
        Edges { twins: vec![NONE; count as usize], open: Vec::new(), crowded: Vec::new() };
    for group in keyed.chunk_by(|x, y| x.0 == y.0) {
        match group {
            [(_, h)] => edges.open.push(*h),
            [(_, h), (_, g)] => {
                edges.twins[*h as usize] = *g;
                edges.twins[*g as usize] = *h;
            }
            more => edges.crowded.push((more[0].1, more.len())),
        }
    }
    edges.open.sort_unstable();
    edges.crowded.sort_unstable();
    edges
}

impl Edges {
    /// Faults that keep the mesh from being closed. Corners within `tolerance` [m] of an edge lie
    /// on it.
    pub fn faults(&self, mesh: &Mesh, tolerance: f64) -> Vec<Fault> {
        let place = |h| ends(&mesh.triangles, h).map(|v| mesh.vertices[v as usize]);
        let Junctions { fault: junction, others: open } = junctions::find(mesh, self, tolerance);
        let open = open.first().map(|&first| {
            let (holes, hole) = holes(&open, mesh);
            Fault::Open { edges: open.len(), holes, first: place(first), hole }
        });
        let crowded = self.crowded.first().map(|&(first, triangles)| Fault::Crowded {
            edges: self.crowded.len(),
            triangles,
            first: place(first),
        });
        junction.into_iter().chain(open).chain(crowded).collect()
    }

    /// Gives half-edges of edges with more than two triangles twins that run the other way, in
    /// their order.
    pub fn pair_crowded(&mut self, triangles: &[[u32; 3]]) {
        let crowded = std::mem::take(&mut self.crowded);
        for (first, _) in crowded {
            let [a, b] = ends(triangles, first);
            let run = |from: u32, to: u32| {
                (0..self.twins.len() as u32).filter(move |&h| ends(triangles, h) == [from, to])
            };
            let (forth, back): (Vec<u32>, Vec<u32>) = (run(a, b).collect(), run(b, a).collect());
            for (h, g) in forth.into_iter().zip(back) {
                self.twins[h as usize] = g;
                self.twins[g as usize] = h;
            }
        }
    }

    /// Edges across which triangles wind in opposite ways: both run along them in one direction.
    pub fn winding_fault(&self, mesh: &Mesh) -> Option<Fault> {
        let disagree = |h: &u32| {
            let twin = self.twins[*h as usize];
            twin > *h && twin != NONE && ends(&mesh.triangles, *h) == ends(&mesh.triangles, twin)
        };
        let mut wrong = (0..self.twins.len() as u32).filter(disagree);
        let first = wrong.next()?;
        let first = ends(&mesh.triangles, first).map(|v| mesh.vertices[v as usize]);
        Some(Fault::Winding { edges: 1 + wrong.count(), first })
    }
}

/// Number of connected sets of open edges, and the box around that of the first.
fn holes(open: &[u32], mesh: &Mesh) -> (usize, Bounds) {
    let mut sets = Sets::new(mesh.vertices.len());
    for &h in open {
        let [a, b] = ends(&mesh.triangles, h);
        sets.unite(a, b);
    }
    let mut roots: Vec<u32> =
        open.iter().map(|&h| sets.root(ends(&mesh.triangles, h)[0])).collect();
    let first = roots[0];
    let points = open.iter().zip(&roots).filter(|(_, root)| **root == first);
    let hole = Bounds::of(
        points.flat_map(|(&h, _)| ends(&mesh.triangles, h)).map(|v| mesh.vertices[v as usize]),
    );
    roots.sort_unstable();
    roots.dedup();
    (roots.len(), hole)
}

/// Disjoint sets of numbers; each is known by its least member.
pub struct Sets(Vec<u32>);

impl Sets {
    /// Every number by itself.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The least member of a number's set.
    pub fn root(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            let parent = self.0[x as usize];
            self.0[x as usize] = self.0[parent as usize];
            x = parent;
        }
        x
    }

    /// Makes one set of two.
    pub fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
