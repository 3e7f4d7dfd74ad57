//! The collision of D3Q19 with two relaxation times and a body force, for a vector of cells.
//!
//! With `h+- = (h_i +- h_i')/2` of each pair of opposite directions,
//!
//! ```text
//! g+- = h+- - (h+- - heq+-)/tau+- + (1 - 1/(2 tau+-)) S+-
//! S_i = w_i [3 (c_i - u) + 9 (c_i.u) c_i].F,   F = rho a,   rho u = sum_i h_i c_i + F/2
//! ```
//!
//! (Ginzburg, Verhaeghe & d'Humieres 2008; forcing of Guo, Zheng & Shi 2002 split into its even and
//! odd parts). Equal times give the BGK collision. Each step adds `F` to a cell's momentum.
//!
//! The trace of the stress may relax at a rate of its own, `1/tau_b`: its difference from the rate `1/tau+`
//!
//! ```text
//! D = (1/tau+ - 1/tau_b) Pi_aa,   g_i += 3/2 w_i (c_i.c_i - 1) D
//! ```
//!
//! changes the trace alone, neither mass, momentum nor shear (d'Humieres et al. 2002; of all directions,
//! those along axes have no share in it). It gives the lattice a bulk viscosity `2/9 (tau_b - 1/2)`; without
//! it that is two thirds of the shear viscosity.
//!
//! A viscosity that follows from a cell's flow (see `operators`) follows from the stress
//!
//! ```text
//! Pi_ab = sum_i c_ia c_ib (h_i - heq_i) + (u_a F_b + F_a u_b)/2 = -2 rho cs^2 tau+ S_ab
//! ```
//!
//! (the strain rate `S_ab` of the second-order expansion; the force's share after Guo, Zheng & Shi
//! 2002, eq. 18).

mod central_relaxation;
pub mod operators;
mod relaxation;
mod stress;

use crate::lattice::d3q19::{C_F64, OPPOSITE, Q, W, dot};
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::{Real, prefetch_early};
use operators::CollisionOperator;
pub use relaxation::relax;
use stress::stress_and_rates;

/// Constants of a collision.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// `1/tau+`.
    pub even: f64,
    /// `1/tau-`.
    pub odd: f64,
    /// Acceleration `a` of the fluid.
    pub acceleration: [f64; 3],
    /// Smagorinsky's constant `C`; 0 for none.
    pub smagorinsky: f64,
    /// `(tau+ - 1/2)(tau- - 1/2)`, or `None` for one relaxation time.
    pub magic: Option<f64>,
    /// True if moments about the velocity relax, those of higher order than the stress in one step.
    pub central: bool,
    /// `1/tau_b` of the trace of the stress, or `None` where it relaxes as all of the stress.
    pub bulk: Option<f64>,
}

impl Relaxation {
    /// From `tau+` and `(tau+ - 1/2)(tau- - 1/2)`.
    pub fn with_magic(tau: f64, magic: f64, acceleration: [f64; 3]) -> Self {
        Self {
            even: 1.0 / tau,
            odd: 1.0 / (0.5 + magic / (tau - 0.5)),
            acceleration,
            smagorinsky: 0.0,
            magic: Some(magic),
            central: false,
            bulk: None,
        }
    }

    /// One relaxation time for both parts.
    pub fn single(tau: f64, acceleration: [f64; 3]) -> Self {
        let (even, odd) = (1.0 / tau, 1.0 / tau);
        let (magic, bulk) = (None, None);
        Self { even, odd, acceleration, smagorinsky: 0.0, magic, central: false, bulk }
    }

    /// Of central moments: one time for the stress.
    pub fn central(tau: f64, acceleration: [f64; 3]) -> Self {
        Self { central: true, ..Self::single(tau, acceleration) }
    }

    /// With Smagorinsky's closure of constant `C`.
    pub fn with_smagorinsky(self, constant: f64) -> Self {
        Self { smagorinsky: constant, ..self }
    }

    /// With a relaxation time of the trace of the stress.
    pub fn with_bulk(self, tau: Option<f64>) -> Self {
        Self { bulk: tau.map(|tau| 1.0 / tau), ..self }
    }

    /// See the constants' `bulk`: shares of `3/2 w (c.c - 1) = 1/24` of a diagonal direction.
    fn bulk_shares(&self) -> [f64; 2] {
        match self.bulk {
            None => [0.0, 0.0],
            Some(rate) if self.smagorinsky == 0.0 => [(self.even - rate) / 24.0, 0.0],
            Some(rate) => [1.0 / 24.0, rate / 48.0],
        }
    }
}

/// Constants of the collision, the same in every lane. `w` is the weight of a diagonal direction;
/// those along an axis have twice, the one at rest twelve times as much.
#[derive(Clone, Copy)]
pub struct Constants<V> {
    half: V,
    one: V,
    one_and_half: V,
    two: V,
    twelve: V,
    third: V,
    two_thirds: V,
    four_ninths: V,
    five_thirds: V,
    quarter: V,
    four: V,
    eight: V,
    ninth: V,
    w: V,
    two_w: V,
    w0: V,
    /// The relaxation of all cells, without a closure.
    pub rates: RelaxationRates<V>,
    /// Factors of a population and of its opposite in its post-collision value: `1 - k+` and `k-`.
    keep: V,
    swap: V,
    /// `w_0/tau+` and `w/tau+`.
    even: [V; 2],
    /// `2 w/tau+` and `2 w/tau-`.
    twice: [V; 2],
    /// `3/4 a` and `3/2 a`.
    lead: [V; 3],
    pull: [V; 3],
    /// `2 e a`, `6 w_i e (c_i.a)` and `3 w_i o (c_i.a)` of each pair, with `e = 1 - 1/(2 tau+)` and
    /// `o = 1 - 1/(2 tau-)` where these are the same everywhere, else 1.
    even_force: [V; 3],
    even_pair: [V; 9],
    odd_pair: [V; 9],
    /// `tau+`, its square, and `12 sqrt(2) C^2`.
    tau: V,
    tau2: V,
    smagorinsky_rates: V,
    magic: V,
    /// `a` and `b` of `(a - b 2 tau+) Pi_aa`, the share of a diagonal direction in `D`; where each cell has
    /// its own times, in `tau+ D`. Both are 0 where the trace has no rate of its own.
    bulk: [V; 2],
}

impl<V: LatticeVector> Constants<V> {
    /// The constants in vectors.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn new(r: &Relaxation) -> Self {
        // Products are rounded in f64 first: the same for every variant.
        let a = r.acceleration;
        // With the closure these factors differ from cell to cell and come in later.
        let (e, o) =
            if r.smagorinsky == 0.0 { (1.0 - 0.5 * r.even, 1.0 - 0.5 * r.odd) } else { (1.0, 1.0) };
        let rounded = |x: f64| V::Scalar::from_f64(x).to_f64();
        let w = W[4];
        let (keep, swap) = (rounded(1.0 - 0.5 * (r.even + r.odd)), rounded(0.5 * (r.even - r.odd)));
        let even = rounded(w * r.even);
        // All weights together, so that rounding them loses no mass.
        let even0 = 1.0 - (keep - swap) - 24.0 * even;
        let tau = 1.0 / r.even;
        // SAFETY: by contract.
        unsafe {
            let each = |a: [f64; 3], factor: f64| {
                [V::splat(factor * a[0]), V::splat(factor * a[1]), V::splat(factor * a[2])]
            };
            let mut even_pair = [V::splat(0.0); 9];
            let mut odd_pair = [V::splat(0.0); 9];
            let mut n = 0;
            while n < 9 {
                let i = OPPOSITE[n + 1];
                let wca = W[i] * dot(C_F64[i], a);
                even_pair[n] = V::splat(6.0 * e * wca);
                odd_pair[n] = V::splat(3.0 * o * wca);
                n += 1;
            }
            let rates = RelaxationRates {
                twice_tau: V::splat(2.0 * tau),
                even: V::splat(r.even),
                odd: V::splat(r.odd),
            };
            Self {
                half: V::splat(0.5),
                one: V::splat(1.0),
                one_and_half: V::splat(1.5),
                two: V::splat(2.0),
                twelve: V::splat(12.0),
                third: V::splat(1.0 / 3.0),
                two_thirds: V::splat(2.0 / 3.0),
                four_ninths: V::splat(4.0 / 9.0),
                five_thirds: V::splat(5.0 / 3.0),
                quarter: V::splat(0.25),
                four: V::splat(4.0),
                eight: V::splat(8.0),
                ninth: V::splat(1.0 / 9.0),
                w: V::splat(w),
                two_w: V::splat(2.0 * w),
                w0: V::splat(W[0]),
                rates,
                keep: V::splat(keep),
                swap: V::splat(swap),
                even: [V::splat(even0), V::splat(even)],
                twice: [V::splat(2.0 * even), V::splat(2.0 * w * r.odd)],
                lead: each(a, 0.75),
                pull: each(a, 1.5),
                even_force: each(a, 2.0 * e),
                even_pair,
                odd_pair,
                tau: V::splat(tau),
                tau2: V::splat(tau * tau),
                smagorinsky_rates: V::splat(
                    12.0 * std::f64::consts::SQRT_2 * r.smagorinsky * r.smagorinsky,
                ),
                magic: V::splat(r.magic.unwrap_or(0.0)),
                bulk: r.bulk_shares().map(|share| V::splat(share)),
            }
        }
    }
}

/// A vector of cells before their collision: what is measured of them, and what they relax to.
#[derive(Clone, Copy)]
pub struct Moments<V, S = ()> {
    /// Density minus 1.
    pub drho: V,
    /// `sum_i h_i c_i`.
    pub j: [V; 3],
    /// `9/4 u.u`.
    pub v2: V,
    /// Equilibrium to which they relax.
    pub target: Equilibrium<V, S>,
    /// Their relaxation; of no meaning without the closure, where it is the same everywhere.
    pub rates: RelaxationRates<V>,
}

impl<V: LatticeVector, S> Moments<V, S> {
    /// The same with zeros in the lanes that `mask` lacks, in all that is summed up.
    #[inline(always)]
    pub fn keep(self, mask: V::Mask) -> Self {
        Self {
            drho: self.drho.keep(mask),
            j: [self.j[0].keep(mask), self.j[1].keep(mask), self.j[2].keep(mask)],
            v2: self.v2.keep(mask),
            rates: RelaxationRates { twice_tau: self.rates.twice_tau.keep(mask), ..self.rates },
            ..self
        }
    }
}

/// The equilibrium that a vector of cells relaxes to: `heq_i = w_i [rest + 2 rho (c_i.v) (1 +
/// c_i.v)]`.
#[derive(Clone, Copy)]
pub struct Equilibrium<V, S = ()> {
    /// `v = 3/2 u`.
    v: [V; 3],
    /// Density.
    rho: V,
    /// `drho - 3/2 rho u.u`.
    rest: V,
    /// The relaxed stress, as far as the operator needs it.
    stress: S,
}

/// Places of the populations of a vector of cells.
pub trait Populations<V: LatticeVector> {
    /// Those of a direction.
    ///
    /// # Safety
    /// The processor has the variant's instructions, and the populations are there.
    unsafe fn load(&self, i: usize) -> V;
    /// Replaces them.
    ///
    /// # Safety
    /// As for `load`, and nobody else uses them.
    unsafe fn store(&self, i: usize, value: V);
}

/// So many numbers after these places.
pub struct After<'a, T>(pub &'a [*mut T; Q], pub usize);

impl<V: LatticeVector> Populations<V> for After<'_, V::Scalar> {
    #[inline(always)]
    unsafe fn load(&self, i: usize) -> V {
        // SAFETY: by contract.
        unsafe { V::load(self.0[i].add(self.1)) }
    }
    #[inline(always)]
    unsafe fn store(&self, i: usize, value: V) {
        // SAFETY: by contract.
        unsafe { value.store(self.0[i].add(self.1)) }
    }
}

/// Number of cache lines ahead of its use at which a place is fetched. A processor's window of
/// instructions does not reach that far by itself.
pub const AHEAD: usize = 16;

/// Asks memory for the places that lie a while after those of a vector.
#[inline(always)]
pub fn ask_ahead<T: Real>(places: &[*mut T; Q], x: usize) {
    let mut i = 0;
    while i < Q {
        prefetch_early(places[i].wrapping_add(x + AHEAD * T::LINE));
        i += 1;
    }
}

/// Measures a vector of cells with some populations.
///
/// `FORCED`: there is an acceleration.
///
/// # Safety
/// As for [`Populations::load`].
#[inline(always)]
pub unsafe fn measure<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    populations: &impl Populations<V>,
    k: &Constants<V>,
) -> Moments<V, O::Stress<V>> {
    // Pair n is the directions n + 1 and n + 10: x, y, z, xy, x-y, xz, x-z, yz, y-z (positive one
    // last).
    macro_rules! at {
        ($i:expr) => {
            // SAFETY: by contract.
            unsafe { populations.load($i) }
        };
    }
    macro_rules! pair {
        ($n:literal) => {{
            let (forth, back) = (at!($n + 10), at!($n + 1));
            (forth + back, forth - back)
        }};
    }
    // Sums and differences of two diagonals of a plane: of their even and of their odd parts.
    macro_rules! plane {
        ($n:literal, $m:literal) => {{
            let ((a, c), (b, d)) = (pair!($n), pair!($m));
            (a + b, a - b, c + d, c - d)
        }};
    }
    let (xy, shear_xy, j_xy, j_yx) = plane!(3, 4);
    let (xz, shear_xz, j_xz, j_zx) = plane!(5, 6);
    let (yz, shear_yz, j_yz, j_zy) = plane!(7, 8);
    let ((xx, j_x), (yy, j_y), (zz, j_z)) = (pair!(0), pair!(1), pair!(2));
    let j = [j_x + (j_xy + j_xz), j_y + (j_yx + j_yz), j_z + (j_zx + j_zy)];
    // sum_i c_ia c_ia h_i
    let normal = [xx + (xy + xz), yy + (xy + yz), zz + (xz + yz)];
    let drho = at!(0) + (normal[0] + ((yy + zz) + yz));

    let rho = k.one + drho;
    // v = 3/2 u
    let per_rho = k.one_and_half / rho;
    let (v, v2, rest);
    if FORCED {
        let lead = &k.lead;
        v = [
            j[0].mul_add(per_rho, lead[0]),
            j[1].mul_add(per_rho, lead[1]),
            j[2].mul_add(per_rho, lead[2]),
        ];
        v2 = square(&v);
        rest = (k.two_thirds * rho).mul_from(v2, drho);
    } else {
        v = [j[0] * per_rho, j[1] * per_rho, j[2] * per_rho];
        // 3/2 rho u.u, without waiting for v
        let kinetic = square(&j) * per_rho;
        v2 = kinetic * per_rho;
        rest = drho - kinetic;
    }
    let shear = [shear_xy, shear_xz, shear_yz];
    let target = Equilibrium { v, rho, rest, stress: () };
    let (stress, rates) =
        stress_and_rates::<V, O, FORCED>((drho, j, per_rho), normal, shear, &target, k);
    Moments { drho, j, v2, target: Equilibrium { v, rho, rest, stress }, rates }
}

/// `a.a`.
#[inline(always)]
fn square<V: LatticeVector>(a: &[V; 3]) -> V {
    a[2].mul_add(a[2], a[1].mul_add(a[1], a[0] * a[0]))
}

/// Relaxation of a vector of cells.
#[derive(Clone, Copy)]
pub struct RelaxationRates<V> {
    /// `2 tau+`.
    pub twice_tau: V,
    /// `1/tau+`.
    even: V,
    /// `1/tau-`.
    odd: V,
}

#[cfg(test)]
mod tests;
