//! The section with what holds it, and its energy, forces and stiffness at a state.

use crate::fem::boundary_conditions::{HELD, Held, Hold, ModelError};
use crate::fem::contact::{Contact, ContactPoint, Seat};
use crate::fem::element::{Displacements, Element, Inverted, Symmetry};
use crate::fem::material::NeoHookean;
use crate::fem::skyline::Skyline;
use crate::mesh::Mesh;

/// A section, its material, what holds it and what it is pressed on.
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) mesh: Mesh,
    pub(super) material: NeoHookean,
    pub(super) elements: Vec<Element>,
    /// Number of each displacement (u_r, u_z of node 0, ...) among the unknowns; `HELD` if it is
    /// none.
    pub(super) unknowns: Vec<usize>,
    pub(super) unknown_count: usize,
    /// Derivative of each held displacement by the compression; 0 of unknowns.
    pub(super) rates: Vec<f64>,
    held: Vec<[usize; 2]>,
    guided: Vec<[usize; 2]>,
    contact: Option<Contact>,
    /// Forces at a volume strain of 1e-6, below which round-off would pass for imbalance [N].
    least_scale: f64,
}

/// Energy, forces and stiffness of a model at displacements.
#[derive(Clone, Debug)]
pub struct State {
    /// Displacements: u_r and u_z of node 0, ... [m].
    pub displacements: Vec<f64>,
    /// Stored energy, that of the contact included [J].
    pub energy: f64,
    /// Derivative of the energy by each displacement [N].
    pub forces: Vec<f64>,
    /// Upward force of the seat's surface on the rubber [N].
    pub contact_force: f64,
    /// Size of the forces that balance each other, to measure what is left against [N].
    pub(super) scale: f64,
    /// Forces on the unknowns by the rate of the held displacements [N/m].
    pub(super) pull: Vec<f64>,
    pub(super) stiffness: Skyline,
}

impl Model {
    /// The model of a section that is pressed on `seat` (if there is one) by what moves. The seat
    /// is raised or lowered until it touches. `contact_stiffness`: pressure by depth of the
    /// contact, in units of Young's modulus over the length of an edge.
    ///
    /// # Errors
    /// If a boundary is not there or nothing moves.
    pub fn new(
        mesh: Mesh,
        symmetry: Symmetry,
        material: NeoHookean,
        holds: &[Hold],
        seat: Option<Seat>,
        contact_stiffness: f64,
    ) -> Result<Self, ModelError> {
        let (shear, bulk) = (material.shear_modulus, material.bulk_modulus);
        if !(shear > 0.0 && bulk > 0.0 && shear.is_finite() && bulk.is_finite()) {
            return Err(ModelError::Material { shear, bulk });
        }
        let held = Held::new(&mesh, symmetry, holds)?;
        let (unknowns, unknown_count) = held.number_unknowns(&mesh);
        let corners = (0..mesh.quads().len()).map(|quad| mesh.corners(quad));
        let elements = corners.map(|corners| Element::new(&corners, symmetry)).collect();
        let free: Vec<[usize; 2]> =
            mesh.outline().iter().copied().filter(|edge| !held.holds(edge)).collect();
        let stiffness = contact_stiffness * material.youngs_modulus();
        let contact = seat.map(|seat| Contact::new(seat, &free, mesh.nodes(), symmetry, stiffness));
        let mut model = Self {
            mesh,
            material,
            elements,
            unknowns,
            unknown_count,
            rates: held.rates,
            held: held.edges,
            guided: held.guided,
            contact,
            least_scale: 0.0,
        };
        model.least_scale = 1e-6 * model.bulk_force();
        Ok(model)
    }

    /// Size of the forces at a volume strain of 1 [N].
    fn bulk_force(&self) -> f64 {
        let force = |element: &Element| self.material.bulk_modulus * element.dilatation_size();
        self.elements.iter().map(|element| force(element) * force(element)).sum::<f64>().sqrt()
    }

    /// The section.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The seat where it touches, if there is one.
    pub fn seat(&self) -> Option<&Seat> {
        self.contact.as_ref().map(|contact| &contact.seat)
    }

    /// Edges that steel holds.
    pub fn held_edges(&self) -> &[[usize; 2]] {
        &self.held
    }

    /// Edges that slide along steel.
    pub fn guided_edges(&self) -> &[[usize; 2]] {
        &self.guided
    }

    /// The undeformed state.
    pub fn rest(&self) -> State {
        let count = 2 * self.mesh.nodes().len();
        let groups: Vec<Vec<usize>> = (0..self.elements.len())
            .map(|quad| {
                self.unknowns_of(quad).into_iter().filter(|unknown| *unknown != HELD).collect()
            })
            .collect();
        State {
            displacements: vec![0.0; count],
            energy: 0.0,
            forces: vec![0.0; count],
            contact_force: 0.0,
            scale: 0.0,
            pull: vec![0.0; self.unknown_count],
            stiffness: Skyline::new(self.unknown_count, groups.iter().map(Vec::as_slice)),
        }
    }

    /// Net force of the carrier on the rubber, downwards [N]: the derivative of the energy by the
    /// compression.
    pub fn carrier_force(&self, state: &State) -> f64 {
        self.rates.iter().zip(&state.forces).map(|(rate, force)| rate * force).sum()
    }

    /// Upward force on the rubber of all that stays: the seat's surface and steel that does not
    /// move [N].
    pub fn seat_force(&self, state: &State) -> f64 {
        let stays = |dof: &usize| self.unknowns[*dof] == HELD && self.rates[*dof] == 0.0;
        let axial = (1..state.forces.len()).step_by(2);
        let held: f64 = axial.filter(stays).map(|dof| state.forces[dof]).sum();
        held + state.contact_force
    }

    /// Edges of the outline whose middles touch the seat's surface.
    pub fn touching(&self, state: &State) -> Vec<[usize; 2]> {
        let Some(contact) = &self.contact else { return Vec::new() };
        let touches = |point: &&ContactPoint| {
            point.is_middle() && contact.touch(point, self.place(point, state)).is_some()
        };
        contact.points.iter().filter(touches).map(|point| point.nodes).collect()
    }

    /// Smallest ratio of an element's volumes, after over before.
    pub fn least_volume_ratio(&self, state: &State) -> f64 {
        let ratio = |quad: usize| {
            self.elements[quad]
                .volume_ratio(&self.displacements_of(quad, state))
                .unwrap_or(f64::NEG_INFINITY)
        };
        (0..self.elements.len()).map(ratio).fold(f64::INFINITY, f64::min)
    }

    /// Mises stress of each quadrilateral [Pa].
    pub fn mises_stresses(&self, state: &State) -> Vec<f64> {
        let stress = |quad: usize| {
            self.elements[quad].mises_stress(&self.material, &self.displacements_of(quad, state))
        };
        (0..self.elements.len()).map(stress).collect()
    }

    /// Fills in all of `state` from its displacements.
    ///
    /// # Errors
    /// The number of a quadrilateral that is inside out.
    pub(super) fn assemble(&self, state: &mut State) -> Result<(), usize> {
        state.energy = 0.0;
        state.contact_force = 0.0;
        state.forces.fill(0.0);
        state.pull.fill(0.0);
        state.stiffness.clear();
        let mut squares = 0.0;
        for quad in 0..self.elements.len() {
            let response = self.elements[quad]
                .respond(&self.material, &self.displacements_of(quad, state))
                .map_err(|Inverted| quad)?;
            let dofs = self.dofs_of(quad);
            state.energy += response.energy;
            for i in 0..8 {
                state.forces[dofs[i]] += response.force[i];
                squares += response.force[i] * response.force[i];
                self.add_row(state, dofs[i], &dofs, response.stiffness.column(i).as_slice());
            }
        }
        state.scale = squares.sqrt().max(self.least_scale);
        self.add_contact(state);
        Ok(())
    }

    fn add_contact(&self, state: &mut State) {
        let Some(contact) = &self.contact else { return };
        for point in &contact.points {
            let Some(touch) = contact.touch(point, self.place(point, state)) else { continue };
            state.energy += touch.energy;
            state.contact_force -= touch.force[1];
            let dofs: [usize; 4] = std::array::from_fn(|i| 2 * point.nodes[i / 2] + i % 2);
            for i in 0..4 {
                state.forces[dofs[i]] += point.shares[i / 2] * touch.force[i % 2];
                let row: [f64; 4] = std::array::from_fn(|j| {
                    point.shares[i / 2] * point.shares[j / 2] * touch.stiffness[i % 2 + j % 2]
                });
                self.add_row(state, dofs[i], &dofs, &row);
            }
        }
    }

    /// Adds a row of stiffnesses between displacement `dof` and `dofs`.
    fn add_row(&self, state: &mut State, dof: usize, dofs: &[usize], row: &[f64]) {
        let unknown = self.unknowns[dof];
        if unknown == HELD {
            return;
        }
        for (other, value) in dofs.iter().zip(row) {
            match self.unknowns[*other] {
                HELD => state.pull[unknown] += value * self.rates[*other],
                column => state.stiffness.add(unknown, column, *value),
            }
        }
    }

    fn place(&self, point: &ContactPoint, state: &State) -> [f64; 2] {
        let [a, b] = point.nodes;
        let coordinate = |axis: usize| {
            let of =
                |node: usize| self.mesh.nodes()[node][axis] + state.displacements[2 * node + axis];
            point.shares[0] * of(a) + point.shares[1] * of(b)
        };
        [coordinate(0), coordinate(1)]
    }

    fn dofs_of(&self, quad: usize) -> [usize; 8] {
        let nodes = self.mesh.quads()[quad];
        std::array::from_fn(|i| 2 * nodes[i / 2] + i % 2)
    }

    fn unknowns_of(&self, quad: usize) -> [usize; 8] {
        self.dofs_of(quad).map(|dof| self.unknowns[dof])
    }

    fn displacements_of(&self, quad: usize, state: &State) -> Displacements {
        self.dofs_of(quad).map(|dof| state.displacements[dof]).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::material::Tensor;
    use crate::mesh::rectangle;

    const RUBBER: NeoHookean = NeoHookean { shear_modulus: 3e5, bulk_modulus: 8e6 };

    /// A rectangle whose inner nodes are moved about, by up to a third of an element.
    fn distorted() -> Mesh {
        let even = rectangle(1.0, 3.0, 1.0, [6, 4]).unwrap();
        let inside = |node: &usize| !even.outline().iter().flatten().any(|other| other == node);
        let mut nodes = even.nodes().to_vec();
        for node in (0..nodes.len()).filter(inside) {
            nodes[node][0] += 0.11 * libm::sin(5.0 * node as f64);
            nodes[node][1] += 0.08 * libm::cos(7.0 * node as f64);
        }
        let named = |name: &str| (name.to_string(), even.boundary(name).unwrap().to_vec());
        Mesh::new(nodes, even.quads().to_vec(), ["top", "bottom"].map(named).into()).unwrap()
    }

    /// The model at displacements that are a function of the place.
    fn displaced(symmetry: Symmetry, u: impl Fn([f64; 2]) -> [f64; 2]) -> (Model, State) {
        let model =
            Model::new(distorted(), symmetry, RUBBER, &[Hold::bonded("top")], None, 1.0).unwrap();
        let mut state = model.rest();
        for (node, at) in model.mesh.nodes().iter().enumerate() {
            let [r, z] = u(*at);
            (state.displacements[2 * node], state.displacements[2 * node + 1]) = (r, z);
        }
        model.assemble(&mut state).unwrap();
        (model, state)
    }

    #[test]
    fn patch_test_a_uniform_stress_balances_on_distorted_elements() {
        let uniform = |[r, z]: [f64; 2]| [0.1 * r - 0.2 * z, 0.15 * r - 0.12 * z];
        let (model, state) = displaced(Symmetry::PlaneStrain, uniform);
        let stress = RUBBER.stress(&Tensor::new(1.1, -0.2, 0.15, 0.88, 1.0));
        let outline = model.mesh.outline();
        for node in 0..model.mesh.nodes().len() {
            // P N over half of each edge of the outline at the node.
            let mut expected = [0.0; 2];
            for [a, b] in outline.iter().filter(|edge| edge.contains(&node)) {
                let (a, b) = (model.mesh.nodes()[*a], model.mesh.nodes()[*b]);
                let normal = [0.5 * (b[1] - a[1]), -0.5 * (b[0] - a[0])];
                expected[0] += stress[0] * normal[0] + stress[1] * normal[1];
                expected[1] += stress[2] * normal[0] + stress[3] * normal[1];
            }
            for axis in 0..2 {
                let found = state.forces[2 * node + axis];
                assert!(
                    (found - expected[axis]).abs() < 1e-9 * state.scale,
                    "{node}: {found} {expected:?}"
                );
            }
        }
        let energy = RUBBER.energy(&Tensor::new(1.1, -0.2, 0.15, 0.88, 1.0)) * 2.0;
        assert!((state.energy / energy - 1.0).abs() < 1e-12, "two square metres, a metre deep");
    }

    #[test]
    fn moving_as_a_whole_costs_nothing() {
        let (s, c) = libm::sincos(0.7);
        let turned = |[r, z]: [f64; 2]| [c * r - s * z - r + 0.4, s * r + c * z - z - 0.9];
        for (symmetry, state) in [
            (Symmetry::PlaneStrain, displaced(Symmetry::PlaneStrain, turned).1),
            (Symmetry::Axisymmetric, displaced(Symmetry::Axisymmetric, |_| [0.0, 1.3]).1),
        ] {
            let largest = state.forces.iter().fold(0.0f64, |a, b| a.max(b.abs()));
            assert!(largest < 1e-14 * RUBBER.bulk_modulus * 20.0, "{symmetry:?}: {largest} N");
            assert!(state.energy.abs() < 1e-14 * RUBBER.bulk_modulus * 20.0, "{symmetry:?}");
        }
    }

    #[test]
    fn what_cannot_be_held_so_is_refused() {
        let model = |holds: &[Hold]| {
            Model::new(distorted(), Symmetry::Axisymmetric, RUBBER, holds, None, 1.0)
                .map(|_| ())
                .unwrap_err()
        };
        assert_eq!(model(&[Hold::fixed("bottom")]), ModelError::NothingMoves);
        let error = model(&[Hold::bonded("tpo")]).to_string();
        assert!(error.contains("\"tpo\"") && error.contains("bottom, top"), "{error}");
        assert!(matches!(model(&[Hold::bonded("top"), Hold::fixed("top")]), ModelError::Torn(_)));
        let soft = NeoHookean { shear_modulus: 0.0, bulk_modulus: 1.0 };
        let error = Model::new(distorted(), Symmetry::Axisymmetric, soft, &[], None, 1.0);
        assert!(matches!(error, Err(ModelError::Material { .. })));
    }
}
