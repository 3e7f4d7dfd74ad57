//! One cell against the formulas.

use super::operators::{CentralMoments, SingleTime, Smagorinsky, TwoTimes, WithBulk};
use super::*;
use crate::lattice::d3q19::equilibrium;
use tremie_team::simd::Portable;

type One = Portable<f64, 1>;

/// Collides one cell.
fn collided(h: &[f64; Q], r: &Relaxation, forced: bool) -> [f64; Q] {
    fn collide<O: CollisionOperator, const FORCED: bool>(places: &[*mut f64; Q], r: &Relaxation) {
        // SAFETY: plain arrays need no instructions; each pointer is to one number.
        unsafe {
            let k = Constants::<One>::new(r);
            let flow = measure::<One, O, FORCED>(&After(places, 0), &k);
            let to = (&flow.target, &flow.rates);
            relax::<One, O, FORCED, false>(&After(places, 0), 1, to, &k);
        }
    }
    fn with_bulk<const FORCED: bool>(places: &[*mut f64; Q], r: &Relaxation) {
        match (r.smagorinsky != 0.0, r.magic.is_none()) {
            (false, false) => collide::<WithBulk<TwoTimes>, FORCED>(places, r),
            (false, true) => collide::<WithBulk<SingleTime>, FORCED>(places, r),
            (true, false) => collide::<WithBulk<Smagorinsky<false>>, FORCED>(places, r),
            (true, true) => collide::<WithBulk<Smagorinsky<true>>, FORCED>(places, r),
        }
    }
    let mut g = *h;
    let first = g.as_mut_ptr();
    let places = std::array::from_fn(|i| first.wrapping_add(i));
    match (forced, r.smagorinsky != 0.0, r.magic.is_none()) {
        (false, false, _) if r.central => collide::<CentralMoments<false>, false>(&places, r),
        (false, true, _) if r.central => collide::<CentralMoments<true>, false>(&places, r),
        (true, false, _) if r.central => collide::<CentralMoments<false>, true>(&places, r),
        (true, true, _) if r.central => collide::<CentralMoments<true>, true>(&places, r),
        (false, _, _) if r.bulk.is_some() => with_bulk::<false>(&places, r),
        (true, _, _) if r.bulk.is_some() => with_bulk::<true>(&places, r),
        (false, false, false) => collide::<TwoTimes, false>(&places, r),
        (false, false, true) => collide::<SingleTime, false>(&places, r),
        (false, true, false) => collide::<Smagorinsky<false>, false>(&places, r),
        (false, true, true) => collide::<Smagorinsky<true>, false>(&places, r),
        (true, false, false) => collide::<TwoTimes, true>(&places, r),
        (true, false, true) => collide::<SingleTime, true>(&places, r),
        (true, true, false) => collide::<Smagorinsky<false>, true>(&places, r),
        (true, true, true) => collide::<Smagorinsky<true>, true>(&places, r),
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
    for r in [Relaxation::single(0.7, [0.0; 3]), Relaxation::with_magic(0.7, 0.1875, [0.0; 3])] {
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
            let stress: f64 =
                (0..Q).map(|i| C_F64[i][x] * C_F64[i][y] * (h[i] - equilibrium(i, drho, u))).sum();
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

/// `sum_i c_ia c_ib h_i`.
fn second_moment(h: &[f64; Q], a: usize, b: usize) -> f64 {
    (0..Q).map(|i| C_F64[i][a] * C_F64[i][b] * h[i]).sum()
}

#[test]
fn the_trace_of_the_stress_relaxes_at_its_own_rate_and_nothing_else_does() {
    let h = some_state();
    let bulk = 0.9;
    for a in [[0.0; 3], [1e-3, -2e-3, 5e-4]] {
        for without in [
            Relaxation::single(0.7, a),
            Relaxation::with_magic(0.55, 0.1875, a),
            Relaxation::single(0.6, a).with_smagorinsky(0.2),
            Relaxation::with_magic(0.6, 0.1875, a).with_smagorinsky(0.2),
            Relaxation::central(0.6, a),
            Relaxation::central(0.6, a).with_smagorinsky(0.2),
        ] {
            let forced = a != [0.0; 3];
            let with = collided(&h, &without.with_bulk(Some(bulk)), forced);
            let without = collided(&h, &without, forced);
            let (drho, j) = moments(&h);
            let rho = 1.0 + drho;
            let u: [f64; 3] = std::array::from_fn(|k| j[k] / rho + 0.5 * a[k]);
            let pulled = rho * dot(u, a);
            let trace = |h: &[f64; Q]| (0..3).map(|k| second_moment(h, k, k)).sum::<f64>();
            let excess = trace(&h) - drho - rho * dot(u, u);
            let expected = trace(&h) - excess / bulk + (2.0 - 1.0 / bulk) * pulled;
            assert!((trace(&with) - expected).abs() < 1e-15, "{} {expected}", trace(&with));
            assert!((moments(&with).0 - moments(&without).0).abs() < 1e-15);
            for k in 0..3 {
                assert!((moments(&with).1[k] - moments(&without).1[k]).abs() < 1e-15);
                let other = (k + 1) % 3;
                let shear = |h: &[f64; Q]| second_moment(h, k, other);
                assert!((shear(&with) - shear(&without)).abs() < 1e-15);
                let difference =
                    |h: &[f64; Q]| second_moment(h, k, k) - second_moment(h, other, other);
                assert!((difference(&with) - difference(&without)).abs() < 1e-15);
            }
        }
    }
}

/// `sum_i (c_ix - u_x)^p_x (c_iy - u_y)^p_y (c_iz - u_z)^p_z f_i`.
fn central_moment(h: &[f64; Q], u: [f64; 3], powers: [i32; 3]) -> f64 {
    let factor = |i: usize| (0..3).map(|a| (C_F64[i][a] - u[a]).powi(powers[a])).product::<f64>();
    (0..Q).map(|i| factor(i) * (h[i] + W[i])).sum()
}

#[test]
fn central_moments_relax_as_they_are_said_to() {
    let h = some_state();
    let tau = 0.7;
    for a in [[0.0; 3], [1e-3, -2e-3, 5e-4]] {
        let forced = a != [0.0; 3];
        let (drho, j) = moments(&h);
        let rho = 1.0 + drho;
        let u: [f64; 3] = std::array::from_fn(|k| j[k] / rho + 0.5 * a[k]);
        let relaxation = Relaxation::central(tau, a);
        let g = collided(&h, &relaxation, forced);
        let is = |powers: [i32; 3], expected: f64| {
            let found = central_moment(&g, u, powers);
            assert!((found - expected).abs() < 1e-15, "{powers:?}: {found} {expected}");
        };
        is([0; 3], rho);
        for one in 0..3 {
            let own = |p: i32| std::array::from_fn(|k| if k == one { p } else { 0 });
            is(own(1), 0.5 * rho * a[one]);
            for other in (0..3).filter(|other| *other != one) {
                let both = |p: i32, q: i32| {
                    let mut powers = own(p);
                    powers[other] = q;
                    powers
                };
                // The force is a part of the stress before.
                let force = 0.5 * rho * (u[one] * a[other] + u[other] * a[one]);
                let before = second_moment(&h, one, other) - rho * u[one] * u[other] + force;
                is(both(1, 1), (1.0 - 1.0 / tau) * before);
                is(both(2, 1), rho * a[other] / 6.0);
                is(both(2, 2), rho / 9.0);
            }
            let normal = second_moment(&h, one, one) + 1.0 / 3.0 - rho * u[one] * u[one];
            let excess = normal - rho / 3.0 + rho * u[one] * a[one];
            is(own(2), rho / 3.0 + (1.0 - 1.0 / tau) * excess);
        }
    }
}

#[test]
fn central_moments_relax_with_the_closures_time() {
    let h = some_state();
    for a in [[0.0; 3], [1e-3, -2e-3, 5e-4]] {
        let forced = a != [0.0; 3];
        let eddies = Relaxation::central(0.500004, a).with_smagorinsky(0.3);
        let plain = Relaxation::central(iterated(&h, 0.500004, 0.3, a), a);
        let (eddies, plain) = (collided(&h, &eddies, forced), collided(&h, &plain, forced));
        assert!(eddies.iter().zip(&plain).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
