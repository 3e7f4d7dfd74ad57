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

use crate::lanes::Lanes;
use crate::lattice::{C_F64, OPPOSITE, Q, W};

/// Constants of a collision.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// `1/tau+`.
    pub even: f64,
    /// `1/tau-`.
    pub odd: f64,
    /// Acceleration `a` of the fluid.
    pub acceleration: [f64; 3],
}

impl Relaxation {
    /// From `tau+` and `(tau+ - 1/2)(tau- - 1/2)`.
    pub fn with_magic(tau: f64, magic: f64, acceleration: [f64; 3]) -> Self {
        Self { even: 1.0 / tau, odd: 1.0 / (0.5 + magic / (tau - 0.5)), acceleration }
    }

    /// One relaxation time for both parts.
    pub fn single(tau: f64, acceleration: [f64; 3]) -> Self {
        Self { even: 1.0 / tau, odd: 1.0 / tau, acceleration }
    }
}

/// What a collision needs in every lane.
#[derive(Clone, Copy)]
pub struct Constants<V> {
    one: V,
    w0: V,
    two_w: [V; 2],
    six_w: [V; 2],
    nine_w: [V; 2],
    one_and_half: V,
    even: V,
    half_even: V,
    half_odd: V,
    half_acceleration: [V; 3],
    /// `3 (1 - 1/(2 tau+)) a`.
    even_force: [V; 3],
    /// `9 (1 - 1/(2 tau+)) (c_i.a)` for each pair.
    even_pair: [V; 9],
    /// `3 (1 - 1/(2 tau-)) (c_i.a)` for each pair.
    odd_pair: [V; 9],
    w: [V; 2],
}

impl<V: Lanes> Constants<V> {
    /// The constants in vectors.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn new(r: &Relaxation) -> Self {
        // Products are rounded in f64 first: the same for every variant.
        let a = r.acceleration;
        let (e, o) = (1.0 - 0.5 * r.even, 1.0 - 0.5 * r.odd);
        let (axis, diagonal) = (W[1], W[4]);
        // SAFETY: by contract.
        unsafe {
            let mut even_pair = [V::splat(0.0); 9];
            let mut odd_pair = [V::splat(0.0); 9];
            let mut k = 0;
            while k < 9 {
                let c = C_F64[OPPOSITE[k + 1]];
                let ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2];
                even_pair[k] = V::splat(9.0 * e * ca);
                odd_pair[k] = V::splat(3.0 * o * ca);
                k += 1;
            }
            Self {
                one: V::splat(1.0),
                w0: V::splat(W[0]),
                w: [V::splat(axis), V::splat(diagonal)],
                two_w: [V::splat(2.0 * axis), V::splat(2.0 * diagonal)],
                six_w: [V::splat(6.0 * axis), V::splat(6.0 * diagonal)],
                nine_w: [V::splat(9.0 * axis), V::splat(9.0 * diagonal)],
                one_and_half: V::splat(1.5),
                even: V::splat(r.even),
                half_even: V::splat(0.5 * r.even),
                half_odd: V::splat(0.5 * r.odd),
                half_acceleration: [
                    V::splat(0.5 * a[0]),
                    V::splat(0.5 * a[1]),
                    V::splat(0.5 * a[2]),
                ],
                even_force: [
                    V::splat(3.0 * e * a[0]),
                    V::splat(3.0 * e * a[1]),
                    V::splat(3.0 * e * a[2]),
                ],
                even_pair,
                odd_pair,
            }
        }
    }
}

/// Moments of a vector of cells before their collision.
#[derive(Clone, Copy)]
pub struct Moments<V> {
    /// Density minus 1.
    pub drho: V,
    /// `sum_i h_i c_i`.
    pub j: [V; 3],
    /// `u.u`.
    pub speed2: V,
}

/// Replaces the populations `h` of a vector of cells by their post-collision values and returns the
/// moments before.
#[inline(always)]
pub fn collide<V: Lanes, const FORCED: bool>(h: &mut [V; Q], k: &Constants<V>) -> Moments<V> {
    // Pair n is the directions n + 1 and n + 10: x, y, z, xy, x-y, xz, x-z, yz, y-z (positive one
    // last).
    macro_rules! pairs {
        ($op:tt) => {
            [
                h[10] $op h[1], h[11] $op h[2], h[12] $op h[3], h[13] $op h[4], h[14] $op h[5],
                h[15] $op h[6], h[16] $op h[7], h[17] $op h[8], h[18] $op h[9],
            ]
        };
    }
    let sum: [V; 9] = pairs!(+);
    let diff: [V; 9] = pairs!(-);

    let drho = h[0]
        + (((sum[0] + sum[1]) + (sum[2] + sum[3]))
            + ((sum[4] + sum[5]) + (sum[6] + sum[7]))
            + sum[8]);
    let j = [
        (diff[0] + (diff[3] + diff[4])) + (diff[5] + diff[6]),
        (diff[1] + (diff[3] - diff[4])) + (diff[7] + diff[8]),
        (diff[2] + (diff[5] - diff[6])) + (diff[7] - diff[8]),
    ];
    let rho = k.one + drho;
    let per_rho = k.one / rho;
    let mut u = [j[0] * per_rho, j[1] * per_rho, j[2] * per_rho];
    if FORCED {
        u = [
            u[0] + k.half_acceleration[0],
            u[1] + k.half_acceleration[1],
            u[2] + k.half_acceleration[2],
        ];
    }
    let speed2 = (u[0] * u[0] + u[1] * u[1]) + u[2] * u[2];

    // heq_i + heq_i' = 2 w [drho - 3/2 rho u.u] + 9 w rho (c.u)^2,   heq_i - heq_i' = 6 w rho (c.u)
    let rest = drho - k.one_and_half * rho * speed2;
    let even = [k.two_w[0] * rest, k.two_w[1] * rest];
    let square = [k.nine_w[0] * rho, k.nine_w[1] * rho];
    let linear = [k.six_w[0] * rho, k.six_w[1] * rho];
    // S+ = w rho [9 e (c.u)(c.a) - 3 e u.a],   S- = w rho 3 o (c.a)
    let (weight, ua) = if FORCED {
        let ua = (k.even_force[0] * u[0] + k.even_force[1] * u[1]) + k.even_force[2] * u[2];
        ([k.w[0] * rho, k.w[1] * rho], ua)
    } else {
        (k.w, k.w0)
    };

    h[0] = h[0] - k.even * (h[0] - k.w0 * rest);
    if FORCED {
        h[0] = h[0] - k.w0 * rho * ua;
    }
    macro_rules! relax {
        ($n:literal, $kind:literal, $cu:expr) => {{
            let cu = $cu;
            let mut p = k.half_even * (sum[$n] - (even[$kind] + square[$kind] * cu * cu));
            let mut m = k.half_odd * (diff[$n] - linear[$kind] * cu);
            if FORCED {
                p = p - weight[$kind] * (k.even_pair[$n] * cu - ua);
                m = m - weight[$kind] * k.odd_pair[$n];
            }
            h[$n + 10] = h[$n + 10] - (p + m);
            h[$n + 1] = h[$n + 1] - (p - m);
        }};
    }
    relax!(0, 0, u[0]);
    relax!(1, 0, u[1]);
    relax!(2, 0, u[2]);
    relax!(3, 1, u[0] + u[1]);
    relax!(4, 1, u[0] - u[1]);
    relax!(5, 1, u[0] + u[2]);
    relax!(6, 1, u[0] - u[2]);
    relax!(7, 1, u[1] + u[2]);
    relax!(8, 1, u[1] - u[2]);
    Moments { drho, j, speed2 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::lattice::{dot, equilibrium};

    type One = Portable<f64, 1>;

    /// Collides one cell.
    fn collided(h: &[f64; Q], r: &Relaxation, forced: bool) -> [f64; Q] {
        // SAFETY: plain arrays need no instructions; each pointer is to one number.
        unsafe {
            let k = Constants::<One>::new(r);
            let mut v = h.map(|x| One::splat(x));
            if forced {
                collide::<One, true>(&mut v, &k);
            } else {
                collide::<One, false>(&mut v, &k);
            }
            v.map(|v| {
                let mut out = 0.0;
                v.store(&mut out);
                out
            })
        }
    }

    fn some_state() -> [f64; Q] {
        std::array::from_fn(|i| {
            equilibrium(i, 0.01, [0.03, -0.05, 0.02]) + 1e-3 * ((i * 7 + 3) % 11) as f64 - 5e-3
        })
    }

    fn moments(h: &[f64; Q]) -> (f64, [f64; 3]) {
        let j = std::array::from_fn(|a| (0..Q).map(|i| h[i] * C_F64[i][a]).sum());
        (h.iter().sum(), j)
    }

    #[test]
    fn mass_and_momentum_are_kept_without_a_force() {
        let h = some_state();
        for r in [Relaxation::single(0.7, [0.0; 3]), Relaxation::with_magic(0.7, 0.1875, [0.0; 3])]
        {
            let g = collided(&h, &r, false);
            let ((m0, j0), (m1, j1)) = (moments(&h), moments(&g));
            assert!((m0 - m1).abs() < 1e-16);
            for a in 0..3 {
                assert!((j0[a] - j1[a]).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn a_force_adds_rho_a_to_the_momentum_and_nothing_to_the_mass() {
        let h = some_state();
        let a = [1e-4, -3e-4, 2e-4];
        for r in [Relaxation::single(0.7, a), Relaxation::with_magic(0.7, 0.1875, a)] {
            let g = collided(&h, &r, true);
            let ((m0, j0), (m1, j1)) = (moments(&h), moments(&g));
            assert!((m0 - m1).abs() < 1e-16);
            for k in 0..3 {
                assert!((j1[k] - j0[k] - (1.0 + m0) * a[k]).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn it_is_the_formula_of_the_single_relaxation_time() {
        let h = some_state();
        let (tau, a) = (0.8, [1e-3, -2e-3, 5e-4]);
        let (drho, j) = moments(&h);
        let u: [f64; 3] = std::array::from_fn(|k| j[k] / (1.0 + drho) + 0.5 * a[k]);
        let g = collided(&h, &Relaxation::single(tau, a), true);
        for i in 0..Q {
            let c = C_F64[i];
            let force = (0..3)
                .map(|k| (3.0 * (c[k] - u[k]) + 9.0 * dot(c, u) * c[k]) * (1.0 + drho) * a[k])
                .sum::<f64>();
            let expected =
                h[i] - (h[i] - equilibrium(i, drho, u)) / tau + (1.0 - 0.5 / tau) * W[i] * force;
            assert!((g[i] - expected).abs() < 1e-16, "{i}: {} {expected}", g[i]);
        }
    }

    #[test]
    fn the_equilibrium_is_a_fixed_point() {
        let h: [f64; Q] = std::array::from_fn(|i| equilibrium(i, -0.02, [0.05, 0.02, -0.07]));
        let g = collided(&h, &Relaxation::with_magic(0.6, 0.1875, [0.0; 3]), false);
        for i in 0..Q {
            assert!((g[i] - h[i]).abs() < 1e-16);
        }
    }
}
