//! Boundary conditions of a section.

use crate::fem::element::Symmetry;
use crate::mesh::Mesh;

/// A boundary condition of edges of the outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// Name of the part of the outline.
    pub boundary: String,
    /// True if its radii are held: bonded, or a plane of symmetry upright.
    pub radial: bool,
    /// True if and where its heights are held.
    pub axial: Axial,
}

/// Condition on heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axial {
    /// The carrier, which comes down on the seat.
    Moves,
    /// Something that stays where it is.
    Stays,
    /// Nothing.
    Free,
}

impl Hold {
    /// Bonded to the carrier.
    pub fn bonded(boundary: &str) -> Self {
        Self { boundary: boundary.into(), radial: true, axial: Axial::Moves }
    }

    /// Pushed by the carrier, on which it slides freely.
    pub fn sliding(boundary: &str) -> Self {
        Self { boundary: boundary.into(), radial: false, axial: Axial::Moves }
    }

    /// Upright along the carrier, on which it slides without friction and which it does not leave.
    pub fn guided(boundary: &str) -> Self {
        Self { boundary: boundary.into(), radial: true, axial: Axial::Free }
    }

    /// Bonded to something that stays where it is.
    pub fn fixed(boundary: &str) -> Self {
        Self { boundary: boundary.into(), radial: true, axial: Axial::Stays }
    }

    /// On something flat that stays where it is, which it neither leaves nor sticks to.
    pub fn resting(boundary: &str) -> Self {
        Self { boundary: boundary.into(), radial: false, axial: Axial::Stays }
    }
}

/// Why there is no model of a section.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A name that the mesh does not know.
    #[error("the section has no boundary \"{name}\"; it has {}", list(known))]
    NoSuchBoundary {
        /// The name.
        name: String,
        /// Those that it has.
        known: Vec<String>,
    },
    /// Nothing pushes.
    #[error("no boundary of the section is held by the carrier; name at least one")]
    NothingMoves,
    /// A node held twice, by steel that moves and steel that stays.
    #[error("node {0} belongs to a boundary that moves and to one that stays")]
    Torn(usize),
    /// A modulus that is none.
    #[error("shear modulus {shear} Pa, bulk modulus {bulk} Pa: both must be positive")]
    Material {
        /// Shear modulus [Pa].
        shear: f64,
        /// Bulk modulus [Pa].
        bulk: f64,
    },
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none: name them in the mesh".into() } else { names.join(", ") }
}

/// Marks displacements that are no unknowns.
pub(super) const HELD: usize = usize::MAX;

/// Displacements that are held.
pub(super) struct Held {
    /// Edges of the outline that are held, or lie on the axis.
    pub edges: Vec<[usize; 2]>,
    /// Those that are held upright alone.
    pub guided: Vec<[usize; 2]>,
    fixed: Vec<bool>,
    /// Derivative of each displacement by the compression; 0 of those not held by the carrier.
    pub rates: Vec<f64>,
}

impl Held {
    pub fn new(mesh: &Mesh, symmetry: Symmetry, holds: &[Hold]) -> Result<Self, ModelError> {
        let count = 2 * mesh.nodes().len();
        let mut held = Self {
            edges: Vec::new(),
            guided: Vec::new(),
            fixed: vec![false; count],
            rates: vec![0.0; count],
        };
        for hold in holds {
            let edges =
                mesh.boundary(&hold.boundary).ok_or_else(|| ModelError::NoSuchBoundary {
                    name: hold.boundary.clone(),
                    known: mesh.names().map(str::to_string).collect(),
                })?;
            for &node in edges.iter().flatten() {
                held.fixed[2 * node] |= hold.radial;
                held.hold_axially(node, hold.axial)?;
            }
            match hold.axial {
                Axial::Free => held.guided.extend(edges),
                Axial::Moves | Axial::Stays => held.edges.extend(edges),
            }
        }
        if symmetry == Symmetry::Axisymmetric {
            held.hold_axis(mesh);
        }
        if held.rates.iter().all(|rate| *rate == 0.0) {
            return Err(ModelError::NothingMoves);
        }
        Ok(held)
    }

    /// True if an edge is held in any way.
    pub fn holds(&self, edge: &[usize; 2]) -> bool {
        self.edges.contains(edge) || self.guided.contains(edge)
    }

    fn hold_axially(&mut self, node: usize, axial: Axial) -> Result<(), ModelError> {
        let dof = 2 * node + 1;
        let rate = match axial {
            Axial::Free => return Ok(()),
            Axial::Moves => -1.0,
            Axial::Stays => 0.0,
        };
        if self.fixed[dof] && self.rates[dof] != rate {
            return Err(ModelError::Torn(node));
        }
        self.fixed[dof] = true;
        self.rates[dof] = rate;
        Ok(())
    }

    /// Holds nodes on the axis; their edges are no surface.
    fn hold_axis(&mut self, mesh: &Mesh) {
        let on_axis = |node: &usize| mesh.nodes()[*node][0] == 0.0;
        for node in (0..mesh.nodes().len()).filter(on_axis) {
            self.fixed[2 * node] = true;
        }
        self.edges.extend(mesh.outline().iter().filter(|edge| edge.iter().all(on_axis)));
    }

    /// The number of each displacement among the unknowns, or [`HELD`]; and how many there are.
    pub fn number_unknowns(&self, mesh: &Mesh) -> (Vec<usize>, usize) {
        let mut unknowns = vec![HELD; self.fixed.len()];
        let mut count = 0;
        for dof in mesh.order().into_iter().flat_map(|node| [2 * node, 2 * node + 1]) {
            if !self.fixed[dof] {
                unknowns[dof] = count;
                count += 1;
            }
        }
        (unknowns, count)
    }
}
