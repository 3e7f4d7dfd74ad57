//! Meshes of simple sections. All touch z = 0 with their lowest point.

use crate::mesh::quadrilaterals::{Mesh, MeshError, Point};
use std::collections::BTreeMap;

/// A rectangle from radius `inner` to `outer`, `height` high [m], of `elements` (along r, along z).
/// Its boundaries are `bottom`, `top`, `inner` and `outer`.
///
/// # Errors
/// If the lengths make no rectangle.
pub fn rectangle(
    inner: f64,
    outer: f64,
    height: f64,
    elements: [usize; 2],
) -> Result<Mesh, MeshError> {
    let [columns, rows] = elements;
    let node = |i: usize, j: usize| j * (columns + 1) + i;
    let mut nodes = Vec::new();
    let mut quads = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let (x, y) = (i as f64 / columns as f64, j as f64 / rows as f64);
            nodes.push([inner + x * (outer - inner), y * height]);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            quads.push([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
        }
    }
    let along = |j: usize| (0..columns).map(|i| [node(i, j), node(i + 1, j)]).collect();
    let up = |i: usize| (0..rows).map(|j| [node(i, j), node(i, j + 1)]).collect();
    let boundaries = BTreeMap::from([
        ("bottom".to_string(), along(0)),
        ("top".to_string(), along(rows)),
        ("inner".to_string(), up(0)),
        ("outer".to_string(), up(columns)),
    ]);
    Mesh::new(nodes, quads, boundaries)
}

/// A disc of diameter `thickness` whose centre lies at radius `radius` [m]: a square of `n` by `n`
/// elements in the middle, and on each of its sides a quarter of the rim with `n` elements along
/// it. `n` is rounded up to an even number, so that a node lies at the very bottom. Its boundaries
/// are the quarters `lower`, `upper`, `inner` and `outer`.
///
/// # Errors
/// If the lengths make no such section.
pub fn o_ring(radius: f64, thickness: f64, n: usize) -> Result<Mesh, MeshError> {
    let n = n.next_multiple_of(2);
    let disc = Disc::new(radius, 0.5 * thickness, n);
    let boundaries = ["lower", "outer", "upper", "inner"]
        .into_iter()
        .enumerate()
        .map(|(side, name)| (name.to_string(), disc.rim(side, 0..n)))
        .collect();
    Mesh::new(disc.nodes, disc.quads, boundaries)
}

/// The lower half of an [`o_ring`]: flat above, round below.
/// Its boundaries are `top` (flat) and `round`.
///
/// # Errors
/// If the lengths make no such section.
pub fn d_ring(radius: f64, width: f64, n: usize) -> Result<Mesh, MeshError> {
    let n = n.next_multiple_of(2);
    let disc = Disc::new(radius, 0.5 * width, n);
    let middle = 0.5 * width;
    let height = |node: usize| disc.nodes[node][1];
    let below =
        |quad: &&[usize; 4]| quad.iter().map(|node| height(*node)).sum::<f64>() < 4.0 * middle;
    let quads: Vec<[usize; 4]> = disc.quads.iter().filter(below).copied().collect();
    let flat =
        |edge: &[usize; 2]| edge.iter().all(|node| (height(*node) - middle).abs() < 1e-9 * middle);
    let edges = |quad: &[usize; 4]| [0, 1, 2, 3].map(|i| [quad[i], quad[(i + 1) % 4]]);
    let top = quads.iter().flat_map(edges).filter(flat).collect();
    let mut round = disc.rim(0, 0..n);
    round.extend(disc.rim(1, 0..n / 2));
    round.extend(disc.rim(3, n / 2..n));
    let boundaries = BTreeMap::from([("top".to_string(), top), ("round".to_string(), round)]);
    Mesh::new(disc.nodes, quads, boundaries)
}

/// A disc in parts: a square, and four sectors between its sides and the rim.
struct Disc {
    nodes: Vec<Point>,
    quads: Vec<[usize; 4]>,
    n: usize,
    layers: usize,
}

impl Disc {
    fn new(radius: f64, a: f64, n: usize) -> Self {
        // Half the square's side over the disc's radius: elements of about equal size everywhere.
        const SQUARE: f64 = 0.45;
        let layers = n.div_ceil(2);
        let mut disc = Self { nodes: Vec::new(), quads: Vec::new(), n, layers };
        let even = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
        for j in 0..=n {
            for i in 0..=n {
                disc.nodes.push([radius + SQUARE * a * even(i), a + SQUARE * a * even(j)]);
            }
        }
        for layer in 1..=layers {
            for k in 0..4 * n {
                let q = layer as f64 / layers as f64;
                let [r, z] = disc.nodes[disc.square_edge(k)];
                // From the lower left corner on, counter-clockwise.
                let angle = core::f64::consts::FRAC_PI_4 * (2.0 * k as f64 / n as f64 - 3.0);
                let rim = [radius + a * libm::cos(angle), a + a * libm::sin(angle)];
                disc.nodes.push([r + q * (rim[0] - r), z + q * (rim[1] - z)]);
            }
        }
        disc.mesh();
        disc
    }

    fn mesh(&mut self) {
        let n = self.n;
        let node = |i: usize, j: usize| j * (n + 1) + i;
        for j in 0..n {
            for i in 0..n {
                self.quads.push([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
        for layer in 0..self.layers {
            for k in 0..4 * n {
                let (near, far) = (self.around(layer, k), self.around(layer + 1, k));
                let (far_next, near_next) =
                    (self.around(layer + 1, k + 1), self.around(layer, k + 1));
                self.quads.push([near, far, far_next, near_next]);
            }
        }
    }

    /// Node `k` around layer `layer`; layer 0 is the square's edge.
    fn around(&self, layer: usize, k: usize) -> usize {
        let (n, k) = (self.n, k % (4 * self.n));
        match layer {
            0 => self.square_edge(k),
            layer => (n + 1) * (n + 1) + (layer - 1) * 4 * n + k,
        }
    }

    /// Node `k` around the square, counter-clockwise from its lower left corner.
    fn square_edge(&self, k: usize) -> usize {
        let n = self.n;
        let (i, j) = match (k / n, k % n) {
            (0, along) => (along, 0),
            (1, along) => (n, along),
            (2, along) => (n - along, n),
            (_, along) => (0, n - along),
        };
        j * (n + 1) + i
    }

    /// Edges of the rim on one side, 0 to 3: below, outside, above, inside.
    fn rim(&self, side: usize, along: std::ops::Range<usize>) -> Vec<[usize; 2]> {
        let edge = |k: usize| [self.around(self.layers, k), self.around(self.layers, k + 1)];
        along.map(|k| edge(side * self.n + k)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::element::{Element, Symmetry};

    fn volume(mesh: &Mesh) -> f64 {
        let quads = 0..mesh.quads().len();
        quads.map(|quad| Element::new(&mesh.corners(quad), Symmetry::Axisymmetric).volume()).sum()
    }

    #[test]
    fn rings_have_their_volume() {
        use core::f64::consts::PI;
        let ring = rectangle(6.5, 11.0, 3.0, [9, 6]).unwrap();
        let exact = PI * (121.0 - 42.25) * 3.0;
        assert!((volume(&ring) / exact - 1.0).abs() < 1e-12);
        // Pappus; the rim is a polygon of 4n sides, sin(x)/x of the circle's area with x = 2π/4n.
        let exact = 2.0 * PI * 20.0 * PI;
        for n in [4, 10, 16] {
            let x = PI / (2.0 * n as f64);
            let polygon = exact * libm::sin(x) / x;
            let found = volume(&o_ring(20.0, 2.0, n).unwrap());
            assert!((found / polygon - 1.0).abs() < 1e-12, "{n}: {found} {polygon}");
        }
        let half = d_ring(20.0, 2.0, 7).unwrap();
        let whole = o_ring(20.0, 2.0, 8).unwrap();
        assert!((volume(&half) / volume(&whole) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn boundaries_cover_the_outline() {
        let meshes = [
            rectangle(6.5, 11.0, 3.0, [9, 6]).unwrap(),
            o_ring(20.0, 2.0, 5).unwrap(),
            d_ring(20.0, 2.0, 6).unwrap(),
        ];
        for mesh in meshes {
            let mut named: Vec<[usize; 2]> =
                mesh.names().flat_map(|name| mesh.boundary(name).unwrap().to_vec()).collect();
            named.sort_unstable();
            assert_eq!(named, mesh.outline());
            assert!(mesh.bounds()[0][1].abs() < 1e-12, "the lowest point is at z = 0");
        }
        let half = d_ring(20.0, 2.0, 6).unwrap();
        assert!((half.bounds()[1][1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_lengths_are_refused() {
        assert!(matches!(rectangle(1.0, 1.0, 1.0, [2, 2]), Err(MeshError::Folded { .. })));
        assert!(matches!(o_ring(1.0, 3.0, 4), Err(MeshError::BeyondAxis { .. })));
    }
}
