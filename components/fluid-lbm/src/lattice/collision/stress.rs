//! The stress of a vector of cells: what it is, what is left of it after a step, and rates that follow
//! from it.

use super::operators::{CollisionOperator, RelaxedStress};
use super::{Constants, Equilibrium, RelaxationRates, square};
use crate::lattice::populations::LatticeVector;

/// The relaxed stress, as far as the operator needs it, and the rates, from density minus 1, `sum_i h_i c_i`,
/// `3/(2 rho)` and `sum_i c_ia c_ib h_i` (xx, yy, zz; xy, xz, yz).
#[inline(always)]
pub(super) fn stress_and_rates<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    (drho, j, per_rho): (V, [V; 3], V),
    normal: [V; 3],
    shear: [V; 3],
    &Equilibrium { v, rho, rest, .. }: &Equilibrium<V>,
    k: &Constants<V>,
) -> (O::Stress<V>, RelaxationRates<V>) {
    let mut stress = ([drho; 3], [drho; 3]);
    if O::IS_LOCAL || O::IS_CENTRAL {
        // 2/3 rho u
        let momentum = if FORCED {
            let factor = k.four_ninths * rho;
            [factor * v[0], factor * v[1], factor * v[2]]
        } else {
            [k.two_thirds * j[0], k.two_thirds * j[1], k.two_thirds * j[2]]
        };
        stress = stress_of::<V, FORCED>(drho, normal, shear, &momentum, &v, k);
    }
    let rates = if O::IS_LOCAL {
        O::rates(k.two.mul_add(square(&stress.1), square(&stress.0)), per_rho, k)
    } else {
        k.rates
    };
    let mut excess = drho;
    if O::HAS_BULK {
        let trace = trace::<V, FORCED>((drho, rho, rest), normal, &v, k);
        let tau = rates.twice_tau;
        let share = if O::IS_LOCAL { k.bulk[1].mul_from(tau, k.bulk[0]) } else { k.bulk[0] };
        excess = share * trace;
    }
    if O::IS_CENTRAL {
        stress = relaxed::<V, O>(stress, excess, &rates, k);
    }
    let (normal, shear) = stress;
    let stress = O::keep(RelaxedStress { drho, normal, shear, excess });
    (stress, rates)
}

/// `Pi_aa`, in equilibrium `drho + rho u.u`, from `sum_i c_ia c_ia h_i`; see [`Equilibrium`].
#[inline(always)]
fn trace<V: LatticeVector, const FORCED: bool>(
    (drho, rho, rest): (V, V, V),
    normal: [V; 3],
    v: &[V; 3],
    k: &Constants<V>,
) -> V {
    let sum = normal[0] + (normal[1] + normal[2]);
    let trace = k.two_thirds.mul_add(rest, k.five_thirds.mul_from(drho, sum));
    if !FORCED {
        return trace;
    }
    // u.F
    let pulled = v[2].mul_add(k.pull[2], v[1].mul_add(k.pull[1], v[0] * k.pull[0]));
    (k.four_ninths * rho).mul_add(pulled, trace)
}

/// A stress after a step, see [`CollisionOperator::IS_CENTRAL`]; `excess` is that of [`RelaxedStress`].
#[inline(always)]
fn relaxed<V: LatticeVector, O: CollisionOperator>(
    (normal, shear): ([V; 3], [V; 3]),
    excess: V,
    rates: &RelaxationRates<V>,
    k: &Constants<V>,
) -> ([V; 3], [V; 3]) {
    let keep = k.one - rates.even;
    // A third of D: the trace has three parts.
    let bulk = k.eight * if O::IS_LOCAL { rates.even * excess } else { excess };
    let [x, y, z] = normal;
    let normal = [keep.mul_add(x, bulk), keep.mul_add(y, bulk), keep.mul_add(z, bulk)];
    (normal, [keep * shear[0], keep * shear[1], keep * shear[2]])
}

/// `Pi_ab` (xx, yy, zz; xy, xz, yz) from `sum_i c_ia c_ib h_i`, in equilibrium `drho/3 + rho u_a u_a` and `rho u_a
/// u_b`; `momentum` is `2/3 rho u`.
#[inline(always)]
fn stress_of<V: LatticeVector, const FORCED: bool>(
    drho: V,
    normal: [V; 3],
    shear: [V; 3],
    momentum: &[V; 3],
    v: &[V; 3],
    k: &Constants<V>,
) -> ([V; 3], [V; 3]) {
    let mut normal = [
        momentum[0].mul_from(v[0], k.third.mul_from(drho, normal[0])),
        momentum[1].mul_from(v[1], k.third.mul_from(drho, normal[1])),
        momentum[2].mul_from(v[2], k.third.mul_from(drho, normal[2])),
    ];
    // xy, xz, yz
    let mut shear = [
        momentum[0].mul_from(v[1], shear[0]),
        momentum[0].mul_from(v[2], shear[1]),
        momentum[1].mul_from(v[2], shear[2]),
    ];
    if FORCED {
        let (pull, lead) = (&k.pull, &k.lead);
        normal = [
            momentum[0].mul_add(pull[0], normal[0]),
            momentum[1].mul_add(pull[1], normal[1]),
            momentum[2].mul_add(pull[2], normal[2]),
        ];
        shear = [
            momentum[0].mul_add(lead[1], momentum[1].mul_add(lead[0], shear[0])),
            momentum[0].mul_add(lead[2], momentum[2].mul_add(lead[0], shear[1])),
            momentum[1].mul_add(lead[2], momentum[2].mul_add(lead[1], shear[2])),
        ];
    }
    (normal, shear)
}
