//! Relaxation: the populations of a vector of cells become what a collision leaves of them.
//!
//! They are read for the second time here, from the first-level cache, pair by pair, so that nearly
//! all values stay in registers.

use super::central_relaxation::relax_central;
use super::operators::CollisionOperator;
use super::{Constants, Equilibrium, Populations, RelaxationRates};
use crate::lattice::populations::LatticeVector;

/// Along an axis and along a diagonal, which has half the weight.
macro_rules! both {
    ($diagonal:expr) => {{
        let diagonal = $diagonal;
        [diagonal + diagonal, diagonal]
    }};
}

/// The populations of a direction, in a function whose contract is that of [`Vector::at`].
macro_rules! at {
    ($vector:ident, $i:expr) => {
        // SAFETY: by contract.
        unsafe { $vector.at($i) }
    };
}

/// Replaces the populations of a direction, in a function whose contract is that of
/// [`Vector::put`].
macro_rules! put {
    ($vector:ident, $i:expr, $value:expr) => {
        // SAFETY: by contract.
        unsafe { $vector.put($i, $value) }
    };
}

/// Does something with each pair: its number, which of [`both`] it is, and `c.v`.
macro_rules! each_pair {
    ($relax:ident, $v:ident) => {{
        $relax!(0, 0, $v[0]);
        $relax!(1, 0, $v[1]);
        $relax!(2, 0, $v[2]);
        $relax!(3, 1, $v[0] + $v[1]);
        $relax!(4, 1, $v[0] - $v[1]);
        $relax!(5, 1, $v[0] + $v[2]);
        $relax!(6, 1, $v[0] - $v[2]);
        $relax!(7, 1, $v[1] + $v[2]);
        $relax!(8, 1, $v[1] - $v[2]);
    }};
}

/// Some lanes of the populations of a vector of cells.
pub(super) struct Vector<'a, V: LatticeVector, P, const WHOLE: bool> {
    populations: &'a P,
    mask: V::Mask,
}

impl<V: LatticeVector, P: Populations<V>, const WHOLE: bool> Vector<'_, V, P, WHOLE> {
    /// The populations of a direction.
    ///
    /// # Safety
    /// As for [`Populations::load`].
    #[inline(always)]
    unsafe fn at(&self, i: usize) -> V {
        // SAFETY: by contract.
        unsafe { self.populations.load(i) }
    }

    /// Replaces those of a direction; lanes that the mask lacks become zero.
    ///
    /// # Safety
    /// As for [`Populations::store`].
    #[inline(always)]
    pub(super) unsafe fn put(&self, i: usize, value: V) {
        let value = if WHOLE { value } else { value.keep(self.mask) };
        // SAFETY: by contract.
        unsafe { self.populations.store(i, value) }
    }
}

/// Replaces the populations of a vector of cells by their post-collision values, each in the place
/// of the opposite direction. Lanes that `mask` lacks become zero.
///
/// See [`super::measure`] for the operator and the flag; `WHOLE`: the mask lacks no lane.
///
/// # Safety
/// As for [`Populations::store`].
#[inline(always)]
pub unsafe fn relax<
    V: LatticeVector,
    O: CollisionOperator,
    const FORCED: bool,
    const WHOLE: bool,
>(
    populations: &impl Populations<V>,
    mask: V::Mask,
    (target, rates): (&Equilibrium<V, O::Stress<V>>, &RelaxationRates<V>),
    k: &Constants<V>,
) {
    let vector = Vector::<V, _, WHOLE> { populations, mask };
    // SAFETY: by contract.
    unsafe {
        if O::IS_CENTRAL {
            relax_central::<V, _, O, WHOLE>(&vector, target, k);
        } else if O::IS_LOCAL {
            relax_each::<V, _, O, FORCED, WHOLE>(&vector, target, rates, k);
        } else {
            relax_alike::<V, _, O, FORCED, WHOLE>(&vector, target, k);
        }
    }
}

/// `rho e 2 v.a`, in `S+ = w rho e [6 (c.v)(c.a) - 2 v.a]`; the density where there is no
/// acceleration.
#[inline(always)]
fn pull<V: LatticeVector, S, const FORCED: bool>(
    &Equilibrium { v, rho, .. }: &Equilibrium<V, S>,
    k: &Constants<V>,
) -> V {
    if !FORCED {
        return rho;
    }
    let [x, y, z] = k.even_force;
    rho * z.mul_add(v[2], y.mul_add(v[1], x * v[0]))
}

/// Gives the direction at rest and the diagonal ones their shares in what the trace relaxes otherwise.
#[inline(always)]
fn relax_trace<V: LatticeVector, O: CollisionOperator>(
    excess: V,
    rest: &mut V,
    balance: &mut [V; 2],
    k: &Constants<V>,
) {
    if O::HAS_BULK {
        *rest = k.twelve.mul_from(excess, *rest);
        balance[1] = balance[1] + excess;
    }
}

/// Relaxation with the same times in all cells. With `k+- = (1/tau+ +- 1/tau-)/2` a pair becomes
///
/// ```text
/// g_i = (1 - k+) h_i - k- h_i' + heq+_i/tau+ + heq-_i/tau- + e S+_i + o S-_i
/// ```
#[inline(always)]
unsafe fn relax_alike<
    V: LatticeVector,
    P: Populations<V>,
    O: CollisionOperator,
    const FORCED: bool,
    const WHOLE: bool,
>(
    vector: &Vector<V, P, WHOLE>,
    target: &Equilibrium<V, O::Stress<V>>,
    k: &Constants<V>,
) {
    let &Equilibrium { v, rho, rest, stress } = target;
    let rho_va = pull::<V, _, FORCED>(target, k);
    // What remains of a population and of its opposite.
    macro_rules! mixed {
        ($own:expr, $other:expr, $rest:expr) => {{
            let kept = k.keep.mul_add($own, $rest);
            if O::IS_SINGLE { kept } else { k.swap.mul_from($other, kept) }
        }};
    }
    let (mut g, mut balance) = (k.even[0] * rest, k.even[1] * rest);
    if FORCED {
        (g, balance) = (k.w0.mul_from(rho_va, g), k.w.mul_from(rho_va, balance));
    }
    let mut balance = both!(balance);
    relax_trace::<V, O>(O::kept(stress, rho).excess, &mut g, &mut balance, k);
    let flow = both!(k.twice[0] * rho);
    let flow_odd = if O::IS_SINGLE { flow } else { both!(k.twice[1] * rho) };
    let h = at!(vector, 0);
    put!(vector, 0, mixed!(h, h, g));
    macro_rules! relax {
        ($n:literal, $kind:literal, $cv:expr) => {{
            let cv = $cv;
            let mut grown = flow[$kind] * cv;
            let mut odd = if O::IS_SINGLE { grown } else { flow_odd[$kind] * cv };
            if FORCED {
                grown = k.even_pair[$n].mul_add(rho, grown);
                odd = k.odd_pair[$n].mul_add(rho, odd);
            }
            let even = grown.mul_add(cv, balance[$kind]);
            let (forth, back) = (at!(vector, $n + 10), at!(vector, $n + 1));
            let (to, fro) = (mixed!(forth, back, even + odd), mixed!(back, forth, even - odd));
            put!(vector, $n + 1, to);
            put!(vector, $n + 10, fro);
        }};
    }
    each_pair!(relax, v);
}

/// Relaxation with each cell's own times. These are ready last, so they enter the formula last:
///
/// ```text
/// g_i = h_i + S_i + [heq_i - h_i - S_i/2]/tau
/// ```
///
/// with one time, and so for even and odd parts with two.
#[inline(always)]
unsafe fn relax_each<
    V: LatticeVector,
    P: Populations<V>,
    O: CollisionOperator,
    const FORCED: bool,
    const WHOLE: bool,
>(
    vector: &Vector<V, P, WHOLE>,
    target: &Equilibrium<V, O::Stress<V>>,
    rates: &RelaxationRates<V>,
    k: &Constants<V>,
) {
    let &Equilibrium { v, rho, rest, stress } = target;
    let rho_va = pull::<V, _, FORCED>(target, k);
    let (mut balance, flow) = (both!(k.w * rest), both!(k.two_w * rho));
    let pull = both!(k.w * rho_va);
    let (half_even, half_odd) = (k.half * rates.even, k.half * rates.odd);
    let h = at!(vector, 0);
    let mut off = k.twelve.mul_sub(balance[1], h);
    relax_trace::<V, O>(O::kept(stress, rho).excess, &mut off, &mut balance, k);
    put!(
        vector,
        0,
        if FORCED {
            let source = k.twelve * pull[1];
            rates.even.mul_add(k.half.mul_add(source, off), h - source)
        } else {
            rates.even.mul_add(off, h)
        }
    );
    macro_rules! relax {
        ($n:literal, $kind:literal, $cv:expr) => {{
            let cv = $cv;
            let odd = flow[$kind] * cv;
            let even = odd.mul_add(cv, balance[$kind]);
            let (mut forth, mut back) = (at!(vector, $n + 10), at!(vector, $n + 1));
            let (even_source, odd_source) = if FORCED {
                let grown = k.even_pair[$n] * rho;
                (grown.mul_sub(cv, pull[$kind]), k.odd_pair[$n] * rho)
            } else {
                (even, odd)
            };
            if O::IS_SINGLE {
                let (mut more, mut less) = (even + odd - forth, even - odd - back);
                if FORCED {
                    let (sum, difference) = (even_source + odd_source, even_source - odd_source);
                    (forth, back) = (forth + sum, back + difference);
                    (more, less) = (k.half.mul_from(sum, more), k.half.mul_from(difference, less));
                }
                (forth, back) = (rates.even.mul_add(more, forth), rates.even.mul_add(less, back));
            } else {
                // Opposite directions share the even part and differ by the sign of the odd one.
                let mut more = k.two.mul_sub(even, forth + back);
                let mut less = k.two.mul_sub(odd, forth - back);
                if FORCED {
                    (more, less) = (more - even_source, less - odd_source);
                    forth = forth + (even_source + odd_source);
                    back = back + (even_source - odd_source);
                }
                (forth, back) = (half_odd.mul_add(less, forth), half_odd.mul_from(less, back));
                (forth, back) = (half_even.mul_add(more, forth), half_even.mul_add(more, back));
            }
            put!(vector, $n + 1, forth);
            put!(vector, $n + 10, back);
        }};
    }
    each_pair!(relax, v);
}
