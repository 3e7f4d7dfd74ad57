//! A section as quadrilaterals, checked, and named parts of its outline.

use crate::mesh::bilinear::least_jacobian;
use crate::mesh::reverse_cuthill_mckee::reverse_cuthill_mckee;
use std::collections::{BTreeMap, BTreeSet};

/// A point of the section: distance from the axis r, and z along it, upwards [m].
pub type Point = [f64; 2];

/// The section of a seal. Made by [`Mesh::new`], so all of it is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    nodes: Vec<Point>,
    quads: Vec<[usize; 4]>,
    outline: Vec<[usize; 2]>,
    boundaries: BTreeMap<String, Vec<[usize; 2]>>,
}

/// Why nodes and quadrilaterals are no section.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Nothing there.
    #[error("the mesh has no quadrilaterals; a section needs at least one")]
    Empty,
    /// A number that is none.
    #[error("node {node} lies at ({r}, {z}) m; coordinates must be finite")]
    NotFinite {
        /// Number of the node, from 0.
        node: usize,
        /// Its radius.
        r: f64,
        /// Its height.
        z: f64,
    },
    /// A node beyond the axis.
    #[error(
        "node {node} lies at radius {r} m; the section must lie at radii of 0 or more: is x the radius and y the height?"
    )]
    BeyondAxis {
        /// Number of the node, from 0.
        node: usize,
        /// Its radius.
        r: f64,
    },
    /// A quadrilateral names a node that is not there.
    #[error("quadrilateral {quad} names node {node}, but there are {count}")]
    NoSuchNode {
        /// Number of the quadrilateral, from 0.
        quad: usize,
        /// The node that it names.
        node: usize,
        /// Number of them.
        count: usize,
    },
    /// A quadrilateral with an angle of 180 degrees or more.
    #[error(
        "quadrilateral {quad} near ({r}, {z}) m is folded or has an angle of 180 degrees or more; mesh that place anew"
    )]
    Folded {
        /// Number of the quadrilateral, from 0.
        quad: usize,
        /// A coordinate of its place [m].
        r: f64,
        /// A coordinate of its place [m].
        z: f64,
    },
    /// An edge of three or more quadrilaterals, or of two that overlap.
    #[error(
        "the edge between nodes {a} and {b} belongs to quadrilaterals that overlap; each edge may have one on each side"
    )]
    EdgeShared {
        /// One end.
        a: usize,
        /// The other.
        b: usize,
    },
    /// Parts of the outline that touch in a point.
    #[error("the outline meets itself at node {node}; parts that touch must share an edge there")]
    Pinched {
        /// The node.
        node: usize,
    },
    /// A name given to an edge inside.
    #[error(
        "boundary \"{name}\" names the edge between nodes {a} and {b}, which is not on the outline"
    )]
    NotOutside {
        /// Name of the boundary.
        name: String,
        /// One end.
        a: usize,
        /// The other.
        b: usize,
    },
}

impl Mesh {
    /// The section of `quads` over `nodes`, with edges of the outline under names. Nodes that no
    /// quadrilateral uses are dropped; clockwise quadrilaterals are turned.
    ///
    /// # Errors
    /// If that is no section.
    pub fn new(
        mut nodes: Vec<Point>,
        mut quads: Vec<[usize; 4]>,
        boundaries: BTreeMap<String, Vec<[usize; 2]>>,
    ) -> Result<Self, MeshError> {
        check_finite(&nodes)?;
        snap_to_axis(&mut nodes);
        check_quads(&nodes, &mut quads)?;
        let outline = outline(&quads)?;
        let mut mesh = Self { nodes, quads, outline, boundaries };
        mesh.orient_boundaries()?;
        mesh.drop_unused();
        match mesh.nodes.iter().position(|point| point[0] < 0.0) {
            Some(node) => Err(MeshError::BeyondAxis { node, r: mesh.nodes[node][0] }),
            None => Ok(mesh),
        }
    }

    /// Points of the nodes.
    pub fn nodes(&self) -> &[Point] {
        &self.nodes
    }

    /// Nodes of each quadrilateral, counter-clockwise.
    pub fn quads(&self) -> &[[usize; 4]] {
        &self.quads
    }

    /// Edges of the outline; the solid lies to the left of each.
    pub fn outline(&self) -> &[[usize; 2]] {
        &self.outline
    }

    /// Edges of the named part of the outline.
    pub fn boundary(&self, name: &str) -> Option<&[[usize; 2]]> {
        self.boundaries.get(name).map(Vec::as_slice)
    }

    /// The names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.boundaries.keys().map(String::as_str)
    }

    /// Corners of a quadrilateral.
    pub fn corners(&self, quad: usize) -> [Point; 4] {
        self.quads[quad].map(|node| self.nodes[node])
    }

    /// Smallest and largest corner of the box around all nodes.
    pub fn bounds(&self) -> [Point; 2] {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for node in &self.nodes {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(node[axis]);
                bounds[1][axis] = bounds[1][axis].max(node[axis]);
            }
        }
        bounds
    }

    /// Nodes in an order that keeps neighbours close (reverse Cuthill-McKee).
    pub fn order(&self) -> Vec<usize> {
        reverse_cuthill_mckee(self.nodes.len(), &self.quads)
    }

    /// Gives each named edge the direction of the outline.
    fn orient_boundaries(&mut self) -> Result<(), MeshError> {
        let outside: BTreeSet<[usize; 2]> = self.outline.iter().copied().collect();
        for (name, edges) in &mut self.boundaries {
            for edge in edges.iter_mut() {
                let [a, b] = *edge;
                if outside.contains(&[b, a]) {
                    *edge = [b, a];
                } else if !outside.contains(&[a, b]) {
                    return Err(MeshError::NotOutside { name: name.clone(), a, b });
                }
            }
        }
        Ok(())
    }

    fn drop_unused(&mut self) {
        let mut new = vec![usize::MAX; self.nodes.len()];
        for node in self.quads.iter().flatten() {
            new[*node] = 0;
        }
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for (old, number) in new.iter_mut().enumerate() {
            if *number == 0 {
                *number = nodes.len();
                nodes.push(self.nodes[old]);
            }
        }
        self.nodes = nodes;
        let renumber = |node: &mut usize| *node = new[*node];
        self.quads.iter_mut().flatten().for_each(renumber);
        self.outline.iter_mut().flatten().for_each(renumber);
        self.boundaries.values_mut().flatten().flatten().for_each(renumber);
    }
}

fn check_finite(nodes: &[Point]) -> Result<(), MeshError> {
    match nodes.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
        Some(node) => Err(MeshError::NotFinite { node, r: nodes[node][0], z: nodes[node][1] }),
        None => Ok(()),
    }
}

/// Puts nodes onto the axis that miss it by round-off.
fn snap_to_axis(nodes: &mut [Point]) {
    let outermost = nodes.iter().map(|point| point[0]).fold(0.0, f64::max);
    for point in nodes.iter_mut().filter(|point| point[0].abs() < 1e-9 * outermost) {
        point[0] = 0.0;
    }
}

fn check_quads(nodes: &[Point], quads: &mut [[usize; 4]]) -> Result<(), MeshError> {
    if quads.is_empty() {
        return Err(MeshError::Empty);
    }
    for (number, quad) in quads.iter_mut().enumerate() {
        if let Some(&node) = quad.iter().find(|node| **node >= nodes.len()) {
            return Err(MeshError::NoSuchNode { quad: number, node, count: nodes.len() });
        }
        let corners = quad.map(|node| nodes[node]);
        let [a, b, c, d] = corners;
        let twice_area = (c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0]);
        if twice_area < 0.0 {
            quad.reverse();
        }
        if least_jacobian(&quad.map(|node| nodes[node])) <= 0.0 {
            return Err(MeshError::Folded { quad: number, r: a[0], z: a[1] });
        }
    }
    Ok(())
}

/// Edges with a quadrilateral on one side only.
fn outline(quads: &[[usize; 4]]) -> Result<Vec<[usize; 2]>, MeshError> {
    let edges = |quad: &[usize; 4]| [0, 1, 2, 3].map(|i| [quad[i], quad[(i + 1) % 4]]);
    let mut seen = BTreeSet::new();
    for [a, b] in quads.iter().flat_map(edges) {
        if !seen.insert([a, b]) {
            return Err(MeshError::EdgeShared { a, b });
        }
    }
    let outline: Vec<[usize; 2]> =
        seen.iter().copied().filter(|&[a, b]| !seen.contains(&[b, a])).collect();
    let mut starts = BTreeSet::new();
    match outline.iter().find(|[a, _]| !starts.insert(*a)) {
        Some(&[node, _]) => Err(MeshError::Pinched { node }),
        None => Ok(outline),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Vec<Point> {
        vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [9.0, 9.0]]
    }

    #[test]
    fn clockwise_is_turned_and_unused_nodes_are_dropped() {
        let names = BTreeMap::from([("top".to_string(), vec![[2, 3]])]);
        let mesh = Mesh::new(unit(), vec![[3, 2, 1, 0]], names).unwrap();
        assert_eq!(mesh.quads(), [[0, 1, 2, 3]]);
        assert_eq!(mesh.nodes().len(), 4);
        assert_eq!(mesh.outline().len(), 4);
        assert_eq!(mesh.boundary("top"), Some(&[[2, 3]][..]));
        assert_eq!(mesh.bounds(), [[0.0, 0.0], [1.0, 1.0]]);
    }

    #[test]
    fn what_is_no_section_is_refused() {
        let none = BTreeMap::new;
        let new = |nodes, quads| Mesh::new(nodes, quads, none()).unwrap_err();
        assert_eq!(new(unit(), vec![]), MeshError::Empty);
        assert!(matches!(new(unit(), vec![[0, 1, 2, 7]]), MeshError::NoSuchNode { node: 7, .. }));
        assert!(matches!(new(unit(), vec![[0, 2, 1, 3]]), MeshError::Folded { .. }));
        let twice = vec![[0, 1, 2, 3], [0, 1, 2, 3]];
        assert!(matches!(new(unit(), twice), MeshError::EdgeShared { .. }));
        let shifted = unit().into_iter().map(|[r, z]| [r - 0.5, z]).collect();
        assert!(matches!(new(shifted, vec![[0, 1, 2, 3]]), MeshError::BeyondAxis { node: 0, .. }));
        let mut rounded = unit();
        rounded[0][0] = -1e-16;
        assert_eq!(Mesh::new(rounded, vec![[0, 1, 2, 3]], none()).unwrap().nodes()[0][0], 0.0);
        let mut nan = unit();
        nan[0][0] = f64::NAN;
        assert!(matches!(new(nan, vec![[0, 1, 2, 3]]), MeshError::NotFinite { node: 0, .. }));
        let names = BTreeMap::from([("cut".to_string(), vec![[0, 2]])]);
        let error = Mesh::new(unit(), vec![[0, 1, 2, 3]], names).unwrap_err();
        assert!(error.to_string().contains("\"cut\""), "{error}");
    }

    #[test]
    fn two_quadrilaterals_may_not_meet_in_a_point() {
        let mut nodes = unit();
        nodes[4] = [2.0, 1.0];
        nodes.extend([[2.0, 2.0], [1.0, 2.0]]);
        let error =
            Mesh::new(nodes, vec![[0, 1, 2, 3], [2, 4, 5, 6]], BTreeMap::new()).unwrap_err();
        assert_eq!(error, MeshError::Pinched { node: 2 });
    }
}
