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
//! With Smagorinsky's closure `nu_t = (C dx)^2 |S|` the even time of each cell is
//!
//! ```text
//! tau* = [tau + sqrt(tau^2 + 18 sqrt(2) C^2 P/rho)]/2,   P = sqrt(Pi_ab Pi_ab)
//! Pi_ab = sum_i c_ia c_ib (h_i - heq_i) + (u_a F_b + F_a u_b)/2
//! ```
//!
//! the fixed point of the closure with the strain of the second-order expansion, `Pi_ab = -2 rho cs^2
//! tau* S_ab` (Hou et al. 1996; the force's share after Guo, Zheng & Shi 2002, eq. 18). The odd time
//! is the same for BGK, or follows from `tau*` by the magic number.

use crate::field::{Real, prefetch_early};
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
    /// Smagorinsky's constant `C`; 0 for none.
    pub smagorinsky: f64,
    /// `(tau+ - 1/2)(tau- - 1/2)`, or `None` for one relaxation time.
    pub magic: Option<f64>,
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
        }
    }

    /// One relaxation time for both parts.
    pub fn single(tau: f64, acceleration: [f64; 3]) -> Self {
        Self { even: 1.0 / tau, odd: 1.0 / tau, acceleration, smagorinsky: 0.0, magic: None }
    }

    /// With Smagorinsky's closure of constant `C`.
    pub fn with_smagorinsky(self, constant: f64) -> Self {
        Self { smagorinsky: constant, ..self }
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
    half: V,
    two: V,
    third: V,
    acceleration: [V; 3],
    /// `tau`, its square, and `18 sqrt(2) C^2`.
    tau: V,
    tau2: V,
    closure: V,
    magic: V,
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
        // With the closure these factors differ from cell to cell and come in later.
        let (e, o) =
            if r.smagorinsky == 0.0 { (1.0 - 0.5 * r.even, 1.0 - 0.5 * r.odd) } else { (1.0, 1.0) };
        let tau = 1.0 / r.even;
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
                half: V::splat(0.5),
                two: V::splat(2.0),
                third: V::splat(1.0 / 3.0),
                acceleration: [V::splat(a[0]), V::splat(a[1]), V::splat(a[2])],
                tau: V::splat(tau),
                tau2: V::splat(tau * tau),
                closure: V::splat(18.0 * std::f64::consts::SQRT_2 * r.smagorinsky * r.smagorinsky),
                magic: V::splat(r.magic.unwrap_or(0.0)),
            }
        }
    }

    /// The relaxation of all cells, without a closure.
    #[inline(always)]
    pub fn rates(&self) -> Rates<V> {
        let &Self { tau, even, half_even, half_odd, .. } = self;
        Rates { tau, even, half_even, half_odd }
    }
}

/// A vector of cells before their collision: what is measured of them, and what they relax to.
#[derive(Clone, Copy)]
pub struct Flow<V> {
    /// Density minus 1.
    pub drho: V,
    /// `sum_i h_i c_i`.
    pub j: [V; 3],
    /// `u.u`.
    pub speed2: V,
    /// What relaxes them.
    pub target: Target<V>,
    /// Their relaxation; of no meaning without the closure, where it is the same everywhere.
    pub rates: Rates<V>,
}

impl<V: Lanes> Flow<V> {
    /// The same with zeros in the lanes that `mask` lacks, in all that is summed up.
    #[inline(always)]
    pub fn keep(self, mask: V::Mask) -> Self {
        Self {
            drho: self.drho.keep(mask),
            j: [self.j[0].keep(mask), self.j[1].keep(mask), self.j[2].keep(mask)],
            speed2: self.speed2.keep(mask),
            rates: Rates { tau: self.rates.tau.keep(mask), ..self.rates },
            ..self
        }
    }
}

/// The equilibrium that a vector of cells relaxes to.
#[derive(Clone, Copy)]
pub struct Target<V> {
    /// Velocity.
    u: [V; 3],
    /// Density.
    rho: V,
    /// `drho - 3/2 rho u.u`.
    rest: V,
}

/// How many cache lines ahead of its use a place is fetched: a processor's window of instructions does not reach that
/// far by itself.
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

/// Measures a vector of cells, whose populations are those `x` numbers after `places`.
///
/// `FORCED`: there is an acceleration; `LES`: there is a closure; `SINGLE`: both times are the same.
///
/// # Safety
/// The processor has the variant's instructions; `N` numbers may be read `x` after each place.
#[inline(always)]
pub unsafe fn measure<V: Lanes, const FORCED: bool, const LES: bool, const SINGLE: bool>(
    places: &[*mut V::Scalar; Q],
    x: usize,
    k: &Constants<V>,
) -> Flow<V> {
    // Pair n is the directions n + 1 and n + 10: x, y, z, xy, x-y, xz, x-z, yz, y-z (positive one
    // last).
    macro_rules! at {
        ($i:expr) => {
            // SAFETY: by contract.
            unsafe { V::load(places[$i].add(x)) }
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
    let per_rho = k.one / rho;
    let mut u = [j[0] * per_rho, j[1] * per_rho, j[2] * per_rho];
    let mut momentum = j;
    if FORCED {
        let half = &k.half_acceleration;
        u = [u[0] + half[0], u[1] + half[1], u[2] + half[2]];
        momentum = [rho * u[0], rho * u[1], rho * u[2]];
    }
    let speed2 = u[2].mul_add(u[2], u[1].mul_add(u[1], u[0] * u[0]));
    let rates = if LES {
        let shear = [shear_xy, shear_xz, shear_yz];
        let square = stress2::<V, FORCED>(drho, normal, shear, &momentum, &u, k);
        closure::<V, SINGLE>(square, per_rho, k)
    } else {
        k.rates()
    };
    // heq_i + heq_i' = 2 w [drho - 3/2 rho u.u] + 9 w rho (c.u)^2,   heq_i - heq_i' = 6 w rho (c.u)
    let rest = (k.one_and_half * rho).mul_from(speed2, drho);
    Flow { drho, j, speed2, target: Target { u, rho, rest }, rates }
}

/// Replaces the populations of a vector of cells, those `x` numbers after `places`, by their post-collision values,
/// each in the place of the opposite direction. Lanes that `mask` lacks become zero.
///
/// Populations are read for the second time here, from the first-level cache, to be relaxed pair by pair: so nearly
/// all values stay in registers.
///
/// See [`measure`] for the flags; `WHOLE`: the mask lacks no lane.
///
/// # Safety
/// As for [`measure`], and as many numbers may be written.
#[inline(always)]
pub unsafe fn relax<
    V: Lanes,
    const FORCED: bool,
    const LES: bool,
    const SINGLE: bool,
    const WHOLE: bool,
>(
    places: &[*mut V::Scalar; Q],
    x: usize,
    mask: V::Mask,
    (target, rates): (&Target<V>, &Rates<V>),
    k: &Constants<V>,
) {
    macro_rules! at {
        ($i:expr) => {
            // SAFETY: by contract.
            unsafe { V::load(places[$i].add(x)) }
        };
    }
    macro_rules! put {
        ($i:expr, $value:expr) => {{
            let value = if WHOLE { $value } else { $value.keep(mask) };
            // SAFETY: by contract.
            unsafe { value.store(places[$i].add(x)) }
        }};
    }
    let Target { u, rho, rest } = *target;
    let even = [k.two_w[0] * rest, k.two_w[1] * rest];
    let square = [k.nine_w[0] * rho, k.nine_w[1] * rho];
    let linear = [k.six_w[0] * rho, k.six_w[1] * rho];
    // S+ = w rho [9 e (c.u)(c.a) - 3 e u.a],   S- = w rho 3 o (c.a)
    let (weight, ua) = if FORCED {
        let [x, y, z] = k.even_force;
        let ua = z.mul_add(u[2], y.mul_add(u[1], x * u[0]));
        ([k.w[0] * rho, k.w[1] * rho], ua)
    } else {
        (k.w, k.w0)
    };
    // The factors 1 - 1/(2 tau), which are in the constants where these are the same everywhere.
    let (e, o) = if FORCED && LES {
        (k.one - rates.half_even, k.one - rates.half_odd)
    } else {
        (k.one, k.one)
    };

    let h = at!(0);
    let mut g = rates.even.mul_from(k.w0.mul_from(rest, h), h);
    if FORCED {
        let source = k.w0 * rho * ua;
        g = g - if LES { e * source } else { source };
    }
    put!(0, g);
    // Each population into the place of the opposite direction.
    macro_rules! stream {
        ($n:literal, $forth:expr, $back:expr) => {
            put!($n + 1, $forth);
            put!($n + 10, $back);
        };
    }
    // Even and odd part apart.
    macro_rules! relax_parts {
        ($n:literal, $kind:literal, $cu:expr) => {{
            let cu = $cu;
            let (forth, back) = (at!($n + 10), at!($n + 1));
            // What is out of equilibrium in the even and in the odd part.
            let p = (square[$kind] * cu).mul_from(cu, (forth + back) - even[$kind]);
            let mut m = rates.half_odd * linear[$kind].mul_from(cu, forth - back);
            let (sum, difference) = if FORCED {
                let even = weight[$kind] * k.even_pair[$n].mul_sub(cu, ua);
                let odd = weight[$kind] * k.odd_pair[$n];
                let p = if LES {
                    m = o.mul_from(odd, m);
                    rates.half_even.mul_sub(p, e * even)
                } else {
                    m = m - odd;
                    rates.half_even.mul_sub(p, even)
                };
                (p + m, p - m)
            } else {
                (rates.half_even.mul_add(p, m), rates.half_even.mul_sub(p, m))
            };
            stream!($n, forth - sum, back - difference);
        }};
    }
    macro_rules! each_pair {
        ($relax:ident) => {{
            $relax!(0, 0, u[0]);
            $relax!(1, 0, u[1]);
            $relax!(2, 0, u[2]);
            $relax!(3, 1, u[0] + u[1]);
            $relax!(4, 1, u[0] - u[1]);
            $relax!(5, 1, u[0] + u[2]);
            $relax!(6, 1, u[0] - u[2]);
            $relax!(7, 1, u[1] + u[2]);
            $relax!(8, 1, u[1] - u[2]);
        }};
    }
    if SINGLE && !FORCED {
        let half = |[a, b]: [V; 2]| [k.half * a, k.half * b];
        let (even, square, linear) = (half(even), half(square), half(linear));
        // Both directions with one time, which takes fewer operations, and all but the last need no time.
        macro_rules! relax {
            ($n:literal, $kind:literal, $cu:expr) => {{
                let cu = $cu;
                let (forth, back) = (at!($n + 10), at!($n + 1));
                let balanced = (square[$kind] * cu).mul_add(cu, even[$kind]);
                let forth_off = forth - linear[$kind].mul_add(cu, balanced);
                let back_off = back - linear[$kind].mul_from(cu, balanced);
                let even = rates.even;
                stream!($n, even.mul_from(forth_off, forth), even.mul_from(back_off, back));
            }};
        }
        each_pair!(relax);
    } else {
        each_pair!(relax_parts);
    }
}

/// Relaxation of a vector of cells.
#[derive(Clone, Copy)]
pub struct Rates<V> {
    /// `tau+`.
    pub tau: V,
    /// `1/tau+`.
    even: V,
    /// `1/(2 tau+)`.
    half_even: V,
    /// `1/(2 tau-)`.
    half_odd: V,
}

/// `Pi_ab Pi_ab` from `sum_i c_ia c_ib h_i`, in equilibrium `drho/3 + rho u_a u_a` and `rho u_a u_b`.
#[inline(always)]
fn stress2<V: Lanes, const FORCED: bool>(
    drho: V,
    normal: [V; 3],
    shear: [V; 3],
    momentum: &[V; 3],
    u: &[V; 3],
    k: &Constants<V>,
) -> V {
    let mut normal = [
        momentum[0].mul_from(u[0], k.third.mul_from(drho, normal[0])),
        momentum[1].mul_from(u[1], k.third.mul_from(drho, normal[1])),
        momentum[2].mul_from(u[2], k.third.mul_from(drho, normal[2])),
    ];
    // xy, xz, yz
    let mut shear = [
        momentum[0].mul_from(u[1], shear[0]),
        momentum[0].mul_from(u[2], shear[1]),
        momentum[1].mul_from(u[2], shear[2]),
    ];
    if FORCED {
        let (a, half) = (&k.acceleration, &k.half_acceleration);
        normal = [
            momentum[0].mul_add(a[0], normal[0]),
            momentum[1].mul_add(a[1], normal[1]),
            momentum[2].mul_add(a[2], normal[2]),
        ];
        shear = [
            momentum[0].mul_add(half[1], momentum[1].mul_add(half[0], shear[0])),
            momentum[0].mul_add(half[2], momentum[2].mul_add(half[0], shear[1])),
            momentum[1].mul_add(half[2], momentum[2].mul_add(half[1], shear[2])),
        ];
    }
    let normal = normal[0].mul_add(normal[0], normal[1].mul_add(normal[1], normal[2] * normal[2]));
    let shear = shear[0].mul_add(shear[0], shear[1].mul_add(shear[1], shear[2] * shear[2]));
    k.two.mul_add(shear, normal)
}

/// Rates by Smagorinsky's closure from `Pi_ab Pi_ab`.
#[inline(always)]
fn closure<V: Lanes, const SINGLE: bool>(stress2: V, per_rho: V, k: &Constants<V>) -> Rates<V> {
    let twice = k.tau + (k.closure * per_rho).mul_add(stress2.sqrt(), k.tau2).sqrt();
    let half_even = k.one / twice;
    let even = half_even + half_even;
    let tau = k.half * twice;
    let half_odd = if SINGLE {
        half_even
    } else {
        // 1/tau- = 1/(1/2 + magic/(tau+ - 1/2))
        let over = tau - k.half;
        k.half * over / k.half.mul_add(over, k.magic)
    };
    Rates { tau, even, half_even, half_odd }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::lattice::{dot, equilibrium};

    type One = Portable<f64, 1>;

    /// Collides one cell.
    fn collided(h: &[f64; Q], r: &Relaxation, forced: bool) -> [f64; Q] {
        fn collide<const FORCED: bool, const LES: bool, const SINGLE: bool>(
            places: &[*mut f64; Q],
            r: &Relaxation,
        ) {
            // SAFETY: plain arrays need no instructions; each pointer is to one number.
            unsafe {
                let k = Constants::<One>::new(r);
                let flow = measure::<One, FORCED, LES, SINGLE>(places, 0, &k);
                let to = (&flow.target, &flow.rates);
                relax::<One, FORCED, LES, SINGLE, false>(places, 0, 1, to, &k);
            }
        }
        let mut g = *h;
        let first = g.as_mut_ptr();
        let places = std::array::from_fn(|i| first.wrapping_add(i));
        match (forced, r.smagorinsky != 0.0, r.magic.is_none()) {
            (false, false, false) => collide::<false, false, false>(&places, r),
            (false, false, true) => collide::<false, false, true>(&places, r),
            (false, true, false) => collide::<false, true, false>(&places, r),
            (false, true, true) => collide::<false, true, true>(&places, r),
            (true, false, false) => collide::<true, false, false>(&places, r),
            (true, false, true) => collide::<true, false, true>(&places, r),
            (true, true, false) => collide::<true, true, false>(&places, r),
            (true, true, true) => collide::<true, true, true>(&places, r),
        }
        std::array::from_fn(|i| g[OPPOSITE[i]])
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

    /// `tau*` by iteration of `tau* = tau + (C)^2 |S|/cs^2` with `S` from the stress out of
    /// equilibrium, itself dependent on `tau*`.
    fn iterated(h: &[f64; Q], tau: f64, constant: f64, a: [f64; 3]) -> f64 {
        let (drho, j) = moments(h);
        let rho = 1.0 + drho;
        let u: [f64; 3] = std::array::from_fn(|k| j[k] / rho + 0.5 * a[k]);
        let mut square = 0.0;
        for x in 0..3 {
            for y in 0..3 {
                let stress: f64 = (0..Q)
                    .map(|i| C_F64[i][x] * C_F64[i][y] * (h[i] - equilibrium(i, drho, u)))
                    .sum();
                square += (stress + 0.5 * rho * (u[x] * a[y] + u[y] * a[x])).powi(2);
            }
        }
        let mut found = tau;
        for _ in 0..200 {
            let strain = (2.0 * square).sqrt() / (2.0 * rho * found / 3.0);
            found = tau + 3.0 * constant * constant * strain;
        }
        found
    }

    #[test]
    fn the_closure_is_the_fixed_point_of_smagorinskys_viscosity() {
        let h = some_state();
        for (tau, constant) in [(0.500004, 0.4), (0.51264, 0.4), (0.6, 0.17), (0.8, 0.1)] {
            for a in [[0.0; 3], [1e-3, -2e-3, 5e-4]] {
                let expected = iterated(&h, tau, constant, a);
                assert!(expected > tau * 1.0001);
                let forced = a != [0.0; 3];
                let les = Relaxation::single(tau, a).with_smagorinsky(constant);
                let plain = Relaxation::single(expected, a);
                let (found, same) = (collided(&h, &les, forced), collided(&h, &plain, forced));
                let trt = Relaxation::with_magic(tau, 0.1875, a).with_smagorinsky(constant);
                let magic = Relaxation::with_magic(expected, 0.1875, a);
                let (trt, magic) = (collided(&h, &trt, forced), collided(&h, &magic, forced));
                for i in 0..Q {
                    assert!((found[i] - same[i]).abs() < 1e-15, "{i}: {} {}", found[i], same[i]);
                    assert!((trt[i] - magic[i]).abs() < 1e-15, "{i}: {} {}", trt[i], magic[i]);
                }
            }
        }
    }
}
