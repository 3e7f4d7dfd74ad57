//! The seam of collision operators: how fast the populations of a cell relax.
//!
//! An operator is a type, chosen once for all cells (`collision_kernel`), so that each has loops of
//! its own. A new one, a turbulence model or a fluid whose viscosity depends on the rate of strain,
//! says its rates here, gets an arm where kernels are chosen, and its constants in [`Constants`].

use super::{Constants, RelaxationRates};
use crate::lattice::populations::LatticeVector;

/// A collision operator.
pub trait CollisionOperator {
    /// True if rates differ from cell to cell; else they are those of [`Constants`].
    const IS_LOCAL: bool;
    /// True if both times are the same.
    const IS_SINGLE: bool;
    /// True if populations follow from density, velocity and the relaxed stress alone.
    const IS_CENTRAL: bool = false;
    /// True if the trace of the stress has a rate of its own.
    const HAS_BULK: bool = false;
    /// What relaxation needs of the stress.
    type Stress<V: LatticeVector>: Copy;

    /// What relaxation needs of a stress.
    fn keep<V: LatticeVector>(stress: RelaxedStress<V>) -> Self::Stress<V>;

    /// The stress that was kept; `any` where there is none.
    fn kept<V: LatticeVector>(stress: Self::Stress<V>, any: V) -> RelaxedStress<V>;

    /// Rates of cells with a stress `Pi_ab Pi_ab` and `3/(2 rho)`; asked where rates differ.
    fn rates<V: LatticeVector>(_stress2: V, _per_rho: V, k: &Constants<V>) -> RelaxationRates<V> {
        k.rates
    }
}

/// Density minus 1, and the relaxed stress.
#[derive(Clone, Copy)]
pub struct RelaxedStress<V> {
    /// Density minus 1.
    pub drho: V,
    /// On the diagonal: xx, yy, zz.
    pub normal: [V; 3],
    /// Beside it: xy, xz, yz.
    pub shear: [V; 3],
    /// Share of a diagonal direction in what the trace relaxes otherwise; the direction at rest has -12 times
    /// as much.
    pub excess: V,
}

/// Of operators whose populations do not follow from the stress alone.
macro_rules! needs_no_stress {
    () => {
        type Stress<V: LatticeVector> = ();

        #[inline(always)]
        fn keep<V: LatticeVector>(_: RelaxedStress<V>) {}

        #[inline(always)]
        fn kept<V: LatticeVector>((): (), any: V) -> RelaxedStress<V> {
            RelaxedStress { drho: any, normal: [any; 3], shear: [any; 3], excess: any }
        }
    };
}

/// One relaxation time (Bhatnagar, Gross & Krook 1954; Qian, d'Humieres & Lallemand 1992).
pub struct SingleTime;

impl CollisionOperator for SingleTime {
    const IS_LOCAL: bool = false;
    const IS_SINGLE: bool = true;
    needs_no_stress!();
}

/// Two relaxation times (Ginzburg, Verhaeghe & d'Humieres 2008).
pub struct TwoTimes;

impl CollisionOperator for TwoTimes {
    const IS_LOCAL: bool = false;
    const IS_SINGLE: bool = false;
    needs_no_stress!();
}

/// Smagorinsky's model `nu_t = (C dx)^2 |S|`:
///
/// ```text
/// tau* = [tau + sqrt(tau^2 + 18 sqrt(2) C^2 P/rho)]/2,   P = sqrt(Pi_ab Pi_ab)
/// ```
///
/// the fixed point of the model with the strain that the stress says (Hou et al. 1996). The odd
/// time is the same if `SINGLE`, or follows from `tau*` by the magic number.
pub struct Smagorinsky<const SINGLE: bool>;

impl<const SINGLE: bool> CollisionOperator for Smagorinsky<SINGLE> {
    const IS_LOCAL: bool = true;
    const IS_SINGLE: bool = SINGLE;
    needs_no_stress!();

    #[inline(always)]
    fn rates<V: LatticeVector>(stress2: V, per_rho: V, k: &Constants<V>) -> RelaxationRates<V> {
        let twice_tau =
            k.tau + (k.smagorinsky_rates * per_rho).mul_add(stress2.sqrt(), k.tau2).sqrt();
        let even = k.two / twice_tau;
        let odd = if SINGLE {
            even
        } else {
            // 1/tau- = 1/(1/2 + magic/(tau+ - 1/2))
            let over = k.half * twice_tau - k.half;
            over / k.half.mul_add(over, k.magic)
        };
        RelaxationRates { twice_tau, even, odd }
    }
}

/// Another operator, with a rate of its own for the trace of the stress.
pub struct WithBulk<O>(std::marker::PhantomData<O>);

impl<O: CollisionOperator> CollisionOperator for WithBulk<O> {
    const IS_LOCAL: bool = O::IS_LOCAL;
    const IS_SINGLE: bool = O::IS_SINGLE;
    const HAS_BULK: bool = true;
    type Stress<V: LatticeVector> = V;

    #[inline(always)]
    fn keep<V: LatticeVector>(stress: RelaxedStress<V>) -> V {
        stress.excess
    }

    #[inline(always)]
    fn kept<V: LatticeVector>(excess: V, any: V) -> RelaxedStress<V> {
        RelaxedStress { drho: any, normal: [any; 3], shear: [any; 3], excess }
    }

    #[inline(always)]
    fn rates<V: LatticeVector>(stress2: V, per_rho: V, k: &Constants<V>) -> RelaxationRates<V> {
        O::rates(stress2, per_rho, k)
    }
}

/// Central moments (Geier, Greiner & Korvink 2006; on D3Q19 De Rosis & Coreixas 2020): moments about the
/// velocity of the fluid. The second ones relax, by the viscosity and by that of the bulk; those of third
/// and fourth order go to their equilibrium in each step. With `EDDIES` the viscosity has a share by
/// [`Smagorinsky`].
pub struct CentralMoments<const EDDIES: bool>;

impl<const EDDIES: bool> CollisionOperator for CentralMoments<EDDIES> {
    const IS_LOCAL: bool = EDDIES;
    const IS_SINGLE: bool = true;
    const IS_CENTRAL: bool = true;
    const HAS_BULK: bool = true;
    type Stress<V: LatticeVector> = RelaxedStress<V>;

    #[inline(always)]
    fn keep<V: LatticeVector>(stress: RelaxedStress<V>) -> RelaxedStress<V> {
        stress
    }

    #[inline(always)]
    fn kept<V: LatticeVector>(stress: RelaxedStress<V>, _: V) -> RelaxedStress<V> {
        stress
    }

    #[inline(always)]
    fn rates<V: LatticeVector>(stress2: V, per_rho: V, k: &Constants<V>) -> RelaxationRates<V> {
        Smagorinsky::<true>::rates(stress2, per_rho, k)
    }
}
