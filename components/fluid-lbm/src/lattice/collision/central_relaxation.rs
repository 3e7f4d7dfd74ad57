//! Relaxation of central moments: populations from density, velocity and relaxed stress.
//!
//! With `k_ab = rho/3 delta_ab + Pi'_ab` of the relaxed stress, `k_a = F_a/2` (the velocity has half of the
//! force), `k_aab = F_b/6` and `k_aabb = rho/9`, moments about the origin follow as of any sum:
//!
//! ```text
//! m_a    = k_a + rho u_a
//! m_ab   = k_ab + u_a k_b + u_b k_a + rho u_a u_b
//! m_aab  = k_aab + 2 u_a k_ab + u_b k_aa + u_a^2 k_b + 2 u_a u_b k_a + rho u_a^2 u_b
//! m_aabb = k_aabb + 2 u_a k_abb + 2 u_b k_aab + u_a^2 k_bb + u_b^2 k_aa + 4 u_a u_b k_ab
//!          + 2 u_a^2 u_b k_b + 2 u_a u_b^2 k_a + rho u_a^2 u_b^2
//! ```
//!
//! and 19 populations from these 19 moments: on the diagonals of a plane `(m_aabb +- m_abb +- m_aab +- +-
//! m_ab)/4`, on an axis `(m_aa - m_aabb - m_aacc +- (m_a - m_abb - m_acc))/2` (De Rosis & Coreixas 2020, whose
//! force is that of Guo, Zheng & Shi 2002 up to second order).

use super::operators::{CollisionOperator, RelaxedStress};
use super::relaxation::Vector;
use super::{Constants, Equilibrium, Populations};
use crate::lattice::populations::LatticeVector;

/// Moments of a plane with the axes `a` and `b`.
struct Plane<V> {
    /// `m_aab`, `m_abb`.
    thirds: [V; 2],
    /// `m_aabb`.
    fourth: V,
    /// `m_ab`.
    shear: V,
}

/// Replaces the populations of a vector of cells, see [`super::relax`].
///
/// # Safety
/// As for [`Populations::store`].
#[inline(always)]
pub(super) unsafe fn relax_central<
    V: LatticeVector,
    P: Populations<V>,
    O: CollisionOperator,
    const WHOLE: bool,
>(
    vector: &Vector<V, P, WHOLE>,
    target: &Equilibrium<V, O::Stress<V>>,
    k: &Constants<V>,
) {
    let stress = O::kept(target.stress, target.rho);
    let moved = Moved::new(target, &stress, k);
    let [xy, xz, yz] =
        [(0, 1, 0), (0, 2, 1), (1, 2, 2)].map(|(a, b, ab)| moved.plane(a, b, stress.shear[ab], k));
    macro_rules! put {
        ($n:literal, $forth:expr, $back:expr) => {
            // SAFETY: by contract.
            unsafe {
                vector.put($n + 1, $forth);
                vector.put($n + 10, $back);
            }
        };
    }
    let squares = [0, 1, 2].map(|a| moved.square(a));
    let fourths = xy.fourth + (xz.fourth + yz.fourth);
    let rest = stress.drho - (squares[0] + (squares[1] + squares[2])) + fourths;
    // SAFETY: by contract.
    unsafe { vector.put(0, rest) };
    macro_rules! axis {
        ($n:literal, $one:expr, $other:expr, $thirds:expr) => {{
            let even = squares[$n] - ($one.fourth + $other.fourth);
            let odd = moved.momentum[$n] - $thirds;
            put!($n, k.half * (even + odd), k.half * (even - odd));
        }};
    }
    // With one index of the axis and two of another.
    axis!(0, xy, xz, xy.thirds[1] + xz.thirds[1]);
    axis!(1, xy, yz, xy.thirds[0] + yz.thirds[1]);
    axis!(2, xz, yz, xz.thirds[0] + yz.thirds[0]);
    macro_rules! plane {
        ($n:literal, $m:literal, $plane:expr) => {{
            let Plane { thirds: [aab, abb], fourth, shear } = $plane;
            let (along, across) = (fourth + shear, fourth - shear);
            let (sum, difference) = (abb + aab, abb - aab);
            put!($n, k.quarter * (along + sum), k.quarter * (along - sum));
            put!($m, k.quarter * (across + difference), k.quarter * (across - difference));
        }};
    }
    plane!(3, 4, xy);
    plane!(5, 6, xz);
    plane!(7, 8, yz);
}

/// Central moments of up to second order, about to be moved to the origin.
struct Moved<V> {
    u: [V; 3],
    /// `k_a = F_a/2`.
    pull: [V; 3],
    /// `m_a`.
    momentum: [V; 3],
    /// `k_aa - 1/3`, and `k_aa`.
    normal: [V; 3],
    whole: [V; 3],
    rho: V,
    drho: V,
}

impl<V: LatticeVector> Moved<V> {
    #[inline(always)]
    fn new(
        target: &Equilibrium<V, impl Copy>,
        stress: &RelaxedStress<V>,
        k: &Constants<V>,
    ) -> Self {
        let rho = target.rho;
        let u = target.v.map(|v| k.two_thirds * v);
        let two_thirds_rho = k.two_thirds * rho;
        let pull = k.lead.map(|lead| two_thirds_rho * lead);
        let momentum = [0, 1, 2].map(|a| rho.mul_add(u[a], pull[a]));
        let normal = stress.normal.map(|normal| k.third.mul_add(stress.drho, normal));
        let whole = normal.map(|normal| normal + k.third);
        Self { u, pull, momentum, normal, whole, rho, drho: stress.drho }
    }

    /// `m_aa - 1/3`.
    #[inline(always)]
    fn square(&self, a: usize) -> V {
        self.u[a].mul_add(self.momentum[a] + self.pull[a], self.normal[a])
    }

    /// The moments of a plane with the stress `k_ab`; of the fourth order beyond 1/9.
    #[inline(always)]
    fn plane(&self, a: usize, b: usize, shear: V, k: &Constants<V>) -> Plane<V> {
        let Self { u, pull, momentum, whole, rho, drho, .. } = self;
        let [ua, ub] = [u[a], u[b]];
        let [a2, b2] = [ua * ua, ub * ub];
        // u_a k_b + u_b k_a
        let turned = ua.mul_add(pull[b], ub * pull[a]);
        // 2 u_a k_ab + 2 u_a u_b k_a and so on
        let third =
            |own: V, squared: V, other: V, whole: V, momentum: V, [pull, across]: [V; 2]| {
                let twice = k.two * own;
                let shift = twice.mul_add(other.mul_add(across, shear), k.third * pull);
                squared.mul_add(momentum, other.mul_add(whole, shift))
            };
        let aab = third(ua, a2, ub, whole[a], momentum[b], [pull[b], pull[a]]);
        let abb = third(ub, b2, ua, whole[b], momentum[a], [pull[a], pull[b]]);
        let flat = a2.mul_add(whole[b], b2.mul_add(whole[a], k.ninth * *drho));
        let product = ua * ub;
        let mixed = (k.four * product).mul_add(shear, flat);
        let square = (a2 * b2).mul_add(*rho, mixed);
        let pushed = ua.mul_add(pull[a], ub * pull[b]);
        let fourth = (k.two * product).mul_add(turned, k.two_thirds.mul_add(pushed, square));
        let shear = ua.mul_add(momentum[b], ub.mul_add(pull[a], shear));
        Plane { thirds: [aab, abb], fourth, shear }
    }
}
