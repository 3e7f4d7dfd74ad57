//! The nearly incompressible neo-Hookean solid.
//!
//! Stored energy per reference volume, with I1 = F:F and J = det F:
//!
//! Psi = G/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)²
//!
//! (Mutabaruka and Kamrin, sec. 2.4, with the exponent of the deviatoric stretches corrected from
//! +1/3 to -1/3.) The volumetric term is an element's business: its J is the mean over the element.
//! Here is the isochoric term, and the derivatives of J.

use nalgebra::{SMatrix, SVector};

/// Components (rr, rz, zr, zz, φφ) of a tensor whose other components vanish: the deformation
/// gradient of an axisymmetric or plane deformation, and stresses that go with it.
pub type Tensor = SVector<f64, 5>;

/// A derivative of a [`Tensor`] by another.
pub type Tangent = SMatrix<f64, 5, 5>;

/// The undeformed state.
pub const IDENTITY: Tensor = Tensor::new(1.0, 0.0, 0.0, 1.0, 1.0);

/// A nearly incompressible neo-Hookean solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Shear modulus G [Pa], positive.
    pub shear_modulus: f64,
    /// Bulk modulus K [Pa], positive.
    pub bulk_modulus: f64,
}

impl NeoHookean {
    /// Young's modulus at small strain, E = 9KG/(3K + G) [Pa].
    pub fn youngs_modulus(&self) -> f64 {
        let (g, k) = (self.shear_modulus, self.bulk_modulus);
        9.0 * k * g / (3.0 * k + g)
    }

    /// Poisson's ratio at small strain, (3K - 2G)/(6K + 2G).
    pub fn poisson_ratio(&self) -> f64 {
        let (g, k) = (self.shear_modulus, self.bulk_modulus);
        (3.0 * k - 2.0 * g) / (6.0 * k + 2.0 * g)
    }

    /// Stored energy of shape change per reference volume [J/m³].
    pub fn isochoric_energy(&self, f: &Tensor) -> f64 {
        0.5 * self.shear_modulus * (to_minus_two_thirds(volume_ratio(f)) * f.norm_squared() - 3.0)
    }

    /// First Piola-Kirchhoff stress of shape change [Pa]: G J^(-2/3) (F - I1/3 F^-T).
    pub fn isochoric_stress(&self, f: &Tensor) -> Tensor {
        let j = volume_ratio(f);
        let scale = self.shear_modulus * to_minus_two_thirds(j);
        let third = f.norm_squared() / (3.0 * j);
        (f - cofactor(f) * third) * scale
    }

    /// Derivative of [`isochoric_stress`](Self::isochoric_stress) by F [Pa].
    pub fn isochoric_tangent(&self, f: &Tensor) -> Tangent {
        let j = volume_ratio(f);
        let scale = self.shear_modulus * to_minus_two_thirds(j);
        let i1 = f.norm_squared();
        let (cof, hessian) = (cofactor(f), cofactor_tangent(f));
        let (mixed, pure, curved) = (2.0 / (3.0 * j), 5.0 * i1 / (9.0 * j * j), i1 / (3.0 * j));
        let (f_cof, cof_f) = (f * cof.transpose(), cof * f.transpose());
        (Tangent::identity() - (f_cof + cof_f) * mixed + cof * pure * cof.transpose()
            - hessian * curved)
            * scale
    }

    /// First Piola-Kirchhoff stress [Pa], volume change included, at a point by itself.
    pub fn stress(&self, f: &Tensor) -> Tensor {
        let pressure = self.bulk_modulus * (volume_ratio(f) - 1.0);
        self.isochoric_stress(f) + cofactor(f) * pressure
    }

    /// Stored energy per reference volume [J/m³], volume change included, at a point by itself.
    pub fn energy(&self, f: &Tensor) -> f64 {
        let change = volume_ratio(f) - 1.0;
        self.isochoric_energy(f) + 0.5 * self.bulk_modulus * change * change
    }

    /// Equivalent stress of von Mises [Pa] of the true stress.
    pub fn mises_stress(&self, f: &Tensor) -> f64 {
        let [rr, rz, zr, zz, hoop] = (*f).into();
        let j = volume_ratio(f);
        // The left Cauchy-Green tensor b = F F^T.
        let b = [rr * rr + rz * rz, zr * zr + zz * zz, hoop * hoop];
        let shear = rr * zr + rz * zz;
        let mean = (b[0] + b[1] + b[2]) / 3.0;
        let squares: f64 = b.iter().map(|b| (b - mean) * (b - mean)).sum();
        let scale = self.shear_modulus * to_minus_two_thirds(j) / j;
        scale * (1.5 * (squares + 2.0 * shear * shear)).sqrt()
    }
}

/// J, the ratio of volumes after and before.
pub fn volume_ratio(f: &Tensor) -> f64 {
    (f[0] * f[3] - f[1] * f[2]) * f[4]
}

/// Derivative of J by F: J F^-T.
pub fn cofactor(f: &Tensor) -> Tensor {
    let [rr, rz, zr, zz, hoop] = (*f).into();
    Tensor::new(zz * hoop, -zr * hoop, -rz * hoop, rr * hoop, rr * zz - rz * zr)
}

/// Second derivative of J by F.
pub fn cofactor_tangent(f: &Tensor) -> Tangent {
    let [rr, rz, zr, zz, hoop] = (*f).into();
    Tangent::from([
        [0.0, 0.0, 0.0, hoop, zz],
        [0.0, 0.0, -hoop, 0.0, -zr],
        [0.0, -hoop, 0.0, 0.0, -rz],
        [hoop, 0.0, 0.0, 0.0, rr],
        [zz, -zr, -rz, rr, 0.0],
    ])
}

fn to_minus_two_thirds(j: f64) -> f64 {
    let root = libm::cbrt(j);
    1.0 / (root * root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RUBBER: NeoHookean = NeoHookean { shear_modulus: 3e5, bulk_modulus: 8e6 };

    fn deformation() -> impl Strategy<Value = Tensor> {
        (0.7..1.4, -0.3..0.3, -0.3..0.3, 0.7..1.4, 0.7..1.4)
            .prop_map(|(rr, rz, zr, zz, hoop)| Tensor::new(rr, rz, zr, zz, hoop))
    }

    /// Central difference of `of` along each component of F.
    fn differences(f: &Tensor, of: impl Fn(&Tensor) -> f64) -> Tensor {
        const STEP: f64 = 1e-5;
        Tensor::from_fn(|i, _| {
            let (mut above, mut below) = (*f, *f);
            above[i] += STEP;
            below[i] -= STEP;
            (of(&above) - of(&below)) / (2.0 * STEP)
        })
    }

    proptest! {
        #[test]
        fn stress_is_the_derivative_of_energy(f in deformation()) {
            let stress = RUBBER.stress(&f);
            let slopes = differences(&f, |f| RUBBER.energy(f));
            for i in 0..5 {
                prop_assert!((stress[i] - slopes[i]).abs() < 1e-2, "{stress:?} {slopes:?}");
            }
        }

        #[test]
        fn tangent_is_the_derivative_of_stress(f in deformation()) {
            let tangent = RUBBER.isochoric_tangent(&f);
            let hessian = cofactor_tangent(&f);
            for a in 0..5 {
                let slopes = differences(&f, |f| RUBBER.isochoric_stress(f)[a]);
                let curves = differences(&f, |f| cofactor(f)[a]);
                for b in 0..5 {
                    prop_assert!((tangent[(a, b)] - slopes[b]).abs() < 1e-3, "{a} {b}");
                    prop_assert!((hessian[(a, b)] - curves[b]).abs() < 1e-9, "{a} {b}");
                    prop_assert!((tangent[(a, b)] - tangent[(b, a)]).abs() < 1e-6, "{a} {b}");
                }
            }
        }

        #[test]
        fn a_rotation_changes_no_energy_and_turns_the_stress(f in deformation(), angle in -3.0..3.0) {
            let (s, c) = libm::sincos(angle);
            let turn = |t: &Tensor| {
                let [rr, rz, zr, zz, hoop] = (*t).into();
                Tensor::new(c * rr - s * zr, c * rz - s * zz, s * rr + c * zr, s * rz + c * zz, hoop)
            };
            let turned = turn(&f);
            prop_assert!((RUBBER.energy(&f) - RUBBER.energy(&turned)).abs() < 1e-8 * RUBBER.bulk_modulus);
            let (expected, found) = (turn(&RUBBER.stress(&f)), RUBBER.stress(&turned));
            for i in 0..5 {
                prop_assert!((expected[i] - found[i]).abs() < 1e-8 * RUBBER.bulk_modulus);
            }
            prop_assert!((RUBBER.mises_stress(&f) - RUBBER.mises_stress(&turned)).abs() < 1e-4);
        }
    }

    #[test]
    fn no_deformation_is_no_stress_and_no_energy() {
        assert_eq!(RUBBER.stress(&IDENTITY), Tensor::zeros());
        assert_eq!(RUBBER.energy(&IDENTITY), 0.0);
        assert_eq!(RUBBER.mises_stress(&IDENTITY), 0.0);
    }

    /// Mises of uniaxial stress is that stress; the mean stress adds nothing.
    #[test]
    fn small_strain_gives_the_moduli_of_elasticity() {
        let (e, nu) = (RUBBER.youngs_modulus(), RUBBER.poisson_ratio());
        assert!((e - 8.8889e5).abs() < 2.0 && (nu - 0.481_48).abs() < 1e-4);
        let strain = 1e-6;
        let lateral = 1.0 - nu * strain;
        let f = Tensor::new(lateral, 0.0, 0.0, 1.0 + strain, lateral);
        let stress = RUBBER.stress(&f);
        assert!((stress[3] / (e * strain) - 1.0).abs() < 1e-5, "{stress:?}");
        assert!(stress[0].abs() < 1e-4 * stress[3] && stress[4].abs() < 1e-4 * stress[3]);
        assert!((RUBBER.mises_stress(&f) / stress[3] - 1.0).abs() < 1e-4);
        let shear = RUBBER.stress(&Tensor::new(1.0, strain, 0.0, 1.0, 1.0));
        assert!((shear[1] / (3e5 * strain) - 1.0).abs() < 1e-5);
    }

    /// Nominal stress of incompressible uniaxial stretch: G (s - 1/s²).
    #[test]
    fn stiff_in_volume_it_stretches_as_incompressible_rubber() {
        for (stretch, expected) in [(0.8, -0.7625), (0.9, -0.3346), (1.5, 1.0556), (2.0, 1.75)] {
            let side = 1.0 / f64::sqrt(stretch);
            let f = Tensor::new(side, 0.0, 0.0, stretch, side);
            let stress = RUBBER.isochoric_stress(&f);
            // The pressure that frees the sides.
            let pressure = stress[0] / cofactor(&f)[0];
            let nominal = (stress[3] - pressure * cofactor(&f)[3]) / RUBBER.shear_modulus;
            assert!((nominal - expected).abs() < 1e-4, "{stretch}: {nominal}");
        }
    }
}
