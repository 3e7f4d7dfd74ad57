//! The four-node element with mean dilatation (Q1P0).
//!
//! One pressure for the element, K (J_e - 1) with J_e the mean of J over it: full integration of
//! the volumetric term locks where K is far above G (Nagtegaal, Parks and Rice 1974; Simo, Taylor
//! and Pister 1985). Shape change is integrated at 2 by 2 Gauss points.

use crate::fem::material::{self, NeoHookean, Tensor};
use crate::mesh::bilinear::map;
use nalgebra::{SMatrix, SVector};

/// The solid that a section stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// A ring: the first coordinate is the distance from the axis, forces are those all round.
    Axisymmetric,
    /// A long strip that does not change its length: forces are those on a metre of it.
    PlaneStrain,
}

impl Symmetry {
    /// Depth of the solid behind a point of the section, by radius [m].
    pub fn depth(self, r: f64) -> f64 {
        match self {
            Self::Axisymmetric => core::f64::consts::TAU * r,
            Self::PlaneStrain => 1.0,
        }
    }
}

/// Positions of the Gauss points along an edge, each with weight 1.
const GAUSS: [f64; 2] = [-0.577_350_269_189_625_8, 0.577_350_269_189_625_8];

/// Displacements (u_r, u_z) of node 0, then of node 1, ...; and what belongs to each.
pub type Displacements = SVector<f64, 8>;

/// A Gauss point of an element.
#[derive(Clone, Copy, Debug)]
struct GaussPoint {
    /// Reference volume that it stands for [m³].
    volume: f64,
    /// Derivatives of each node's shape function by the two reference coordinates [1/m].
    gradients: [[f64; 2]; 4],
    /// Each node's share of the hoop stretch: N/R, or 0 in plane strain [1/m].
    hoop: [f64; 4],
}

/// An element in its reference configuration.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    points: [GaussPoint; 4],
    volume: f64,
}

/// Energy, force and stiffness of an element.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Stored energy [J].
    pub energy: f64,
    /// Derivative of the energy by the displacements [N].
    pub force: Displacements,
    /// Its second derivative [N/m].
    pub stiffness: SMatrix<f64, 8, 8>,
}

/// An element that has been turned inside out at a Gauss point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inverted;

impl Element {
    /// The element with these corners (r, z) [m], counter-clockwise.
    pub fn new(corners: &[[f64; 2]; 4], symmetry: Symmetry) -> Self {
        let point = |x: f64, y: f64| {
            let (values, slopes, j) = map(corners, x, y);
            let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
            let gradients = slopes.map(|[a, b]| {
                [(j[1][1] * a - j[0][1] * b) / det, (j[0][0] * b - j[1][0] * a) / det]
            });
            let radius: f64 = (0..4).map(|n| values[n] * corners[n][0]).sum();
            let hoop = match symmetry {
                Symmetry::Axisymmetric => values.map(|value| value / radius),
                Symmetry::PlaneStrain => [0.0; 4],
            };
            GaussPoint { volume: det * symmetry.depth(radius), gradients, hoop }
        };
        let [a, b] = GAUSS;
        let points = [point(a, a), point(b, a), point(b, b), point(a, b)];
        Self { points, volume: points.iter().map(|point| point.volume).sum() }
    }

    /// Volume as meshed [m³].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Size of the derivative of the volume by the displacements, undeformed [m²].
    pub fn dilatation_size(&self) -> f64 {
        let cof = material::cofactor(&material::IDENTITY);
        let entries: Displacements =
            self.points.iter().map(|p| p.by_displacements().tr_mul(&cof) * p.volume).sum();
        // In order: the norm of nalgebra adds eight numbers in pairs.
        entries.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
    }

    /// Ratio of the element's volumes after and before.
    ///
    /// # Errors
    /// If a Gauss point is inside out.
    pub fn volume_ratio(&self, u: &Displacements) -> Result<f64, Inverted> {
        let mut sum = 0.0;
        for point in &self.points {
            sum += point.volume * checked_volume(&point.gradient(u))?;
        }
        Ok(sum / self.volume)
    }

    /// Mises stress [Pa], mean over the element.
    pub fn mises_stress(&self, material: &NeoHookean, u: &Displacements) -> f64 {
        let stress = |point: &GaussPoint| point.volume * material.mises_stress(&point.gradient(u));
        self.points.iter().map(stress).sum::<f64>() / self.volume
    }

    /// Energy, force and stiffness at displacements `u` [m].
    ///
    /// # Errors
    /// If a Gauss point is inside out.
    pub fn respond(&self, material: &NeoHookean, u: &Displacements) -> Result<Response, Inverted> {
        let change = self.volume_ratio(u)? - 1.0;
        let pressure = material.bulk_modulus * change;
        let mut out =
            Response { energy: 0.0, force: Displacements::zeros(), stiffness: SMatrix::zeros() };
        let mut dilatation = Displacements::zeros();
        for point in &self.points {
            let f = point.gradient(u);
            let cof = material::cofactor(&f);
            let stress = material.isochoric_stress(&f) + cof * pressure;
            let tangent =
                material.isochoric_tangent(&f) + material::cofactor_tangent(&f) * pressure;
            let b = point.by_displacements();
            out.energy += point.volume * material.isochoric_energy(&f);
            out.force += b.tr_mul(&stress) * point.volume;
            dilatation += b.tr_mul(&cof) * point.volume;
            out.stiffness += tangent.tr_mul(&b).tr_mul(&b) * point.volume;
        }
        out.energy += 0.5 * pressure * change * self.volume;
        let bulk = material.bulk_modulus / self.volume;
        out.stiffness += dilatation * bulk * dilatation.transpose();
        // Symmetric to the last bit, which products are not.
        out.stiffness.fill_upper_triangle_with_lower_triangle();
        Ok(out)
    }
}

impl GaussPoint {
    /// The deformation gradient.
    fn gradient(&self, u: &Displacements) -> Tensor {
        let mut f = material::IDENTITY;
        f.gemv(1.0, &self.by_displacements(), u, 1.0);
        f
    }

    /// Derivative of the deformation gradient by the displacements [1/m].
    fn by_displacements(&self) -> SMatrix<f64, 5, 8> {
        let column = |dof: usize| {
            let [by_r, by_z] = self.gradients[dof / 2];
            match dof % 2 {
                0 => Tensor::new(by_r, by_z, 0.0, 0.0, self.hoop[dof / 2]),
                _ => Tensor::new(0.0, 0.0, by_r, by_z, 0.0),
            }
        };
        SMatrix::from_columns(&std::array::from_fn::<_, 8, _>(column))
    }
}

fn checked_volume(f: &Tensor) -> Result<f64, Inverted> {
    // The section and the hoop may not both be inside out either.
    let section = f[0] * f[3] - f[1] * f[2];
    if section > 0.0 && f[4] > 0.0 { Ok(section * f[4]) } else { Err(Inverted) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUBBER: NeoHookean = NeoHookean { shear_modulus: 3e5, bulk_modulus: 8e6 };
    const CORNERS_OF_RING: [[f64; 2]; 4] = [[1.0, 0.1], [1.9, -0.1], [2.1, 1.0], [0.8, 1.2]];
    const BENT: Displacements = SVector::from_array_storage(nalgebra::ArrayStorage([[
        0.03, -0.02, 0.05, 0.01, -0.04, 0.06, 0.02, -0.05,
    ]]));

    #[test]
    fn force_and_stiffness_are_derivatives_of_energy() {
        const STEP: f64 = 1e-5;
        for symmetry in [Symmetry::Axisymmetric, Symmetry::PlaneStrain] {
            let element = Element::new(&CORNERS_OF_RING, symmetry);
            let here = element.respond(&RUBBER, &BENT).unwrap();
            for i in 0..8 {
                let at = |sign: f64| {
                    let mut u = BENT;
                    u[i] += sign * STEP;
                    element.respond(&RUBBER, &u).unwrap()
                };
                let (above, below) = (at(1.0), at(-1.0));
                let slope = (above.energy - below.energy) / (2.0 * STEP);
                assert!((slope - here.force[i]).abs() < 1e-2, "{slope} {}", here.force[i]);
                for j in 0..8 {
                    let slope = (above.force[j] - below.force[j]) / (2.0 * STEP);
                    let found = here.stiffness[(i, j)];
                    assert!((slope - found).abs() < 1.0, "{i} {j}: {slope} {found}");
                }
            }
        }
    }

    #[test]
    fn a_ring_has_its_volume() {
        let ring =
            Element::new(&[[1.0, 0.0], [2.0, 0.0], [2.0, 0.5], [1.0, 0.5]], Symmetry::Axisymmetric);
        assert!((ring.volume() - core::f64::consts::PI * 3.0 * 0.5).abs() < 1e-14);
    }

    #[test]
    fn what_is_inside_out_is_refused() {
        let element = Element::new(&CORNERS_OF_RING, Symmetry::Axisymmetric);
        let mut u = Displacements::zeros();
        u[5] = -2.0;
        u[7] = -2.0;
        assert_eq!(element.respond(&RUBBER, &u).unwrap_err(), Inverted);
        // Through the axis and mirrored: the volume would be positive again.
        let u = Displacements::from([-3.0, 0.0, -4.0, 0.0, -4.2, 0.0, -2.6, 0.0]);
        assert_eq!(element.respond(&RUBBER, &u).unwrap_err(), Inverted);
    }
}
