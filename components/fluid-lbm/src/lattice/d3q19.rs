//! The D3Q19 lattice: directions, weights and opposites.
//!
//! Everything else about the lattice is derived from the directions [`C`], whose order is that of
//! Mutabaruka & Kamrin 2018, Table 1: the opposite of direction `i` in `1..=9` is `i + 9`.

use tremie_fluid_kit::cells::links::Links;
pub use tremie_fluid_kit::cells::vector::{cross, dot};

/// Number of directions.
pub const Q: usize = 19;

/// Directions `c_i` [cells per step].
pub const C: [[i32; 3]; Q] = [
    [0, 0, 0],
    [-1, 0, 0],
    [0, -1, 0],
    [0, 0, -1],
    [-1, -1, 0],
    [-1, 1, 0],
    [-1, 0, -1],
    [-1, 0, 1],
    [0, -1, -1],
    [0, -1, 1],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
];

/// The directions, as ways from a cell to its neighbours.
pub const LINKS: Links = Links(&C);

/// Directions as floating-point numbers.
pub const C_F64: [[f64; 3]; Q] = {
    let mut c = [[0.0; 3]; Q];
    let mut i = 0;
    while i < Q {
        c[i] = [C[i][0] as f64, C[i][1] as f64, C[i][2] as f64];
        i += 1;
    }
    c
};

/// Squared speed of sound [cells² per step²].
pub const CS2: f64 = 1.0 / 3.0;

/// Weights `w_i`: 1/3 at rest, 1/18 along an axis, 1/36 along a diagonal of a face.
pub const W: [f64; Q] = {
    let mut w = [0.0; Q];
    let mut i = 0;
    while i < Q {
        let c = C[i];
        w[i] = match c[0] * c[0] + c[1] * c[1] + c[2] * c[2] {
            0 => 1.0 / 3.0,
            1 => 1.0 / 18.0,
            _ => 1.0 / 36.0,
        };
        i += 1;
    }
    w
};

/// Index of the opposite direction: `C[OPPOSITE[i]] == -C[i]`.
pub const OPPOSITE: [usize; Q] = {
    let mut opposite = [Q; Q];
    let mut i = 0;
    while i < Q {
        let mut j = 0;
        while j < Q {
            if C[j][0] == -C[i][0] && C[j][1] == -C[i][1] && C[j][2] == -C[i][2] {
                opposite[i] = j;
            }
            j += 1;
        }
        i += 1;
    }
    opposite
};

/// Directions mirrored at a plane across an axis: `C[MIRROR[a][i]]` is `C[i]` with component `a`
/// reversed.
pub const MIRROR: [[usize; Q]; 3] = {
    let mut mirror = [[Q; Q]; 3];
    let mut a = 0;
    while a < 3 {
        let mut i = 0;
        while i < Q {
            let mut c = C[i];
            c[a] = -c[a];
            let mut j = 0;
            while j < Q {
                if C[j][0] == c[0] && C[j][1] == c[1] && C[j][2] == c[2] {
                    mirror[a][i] = j;
                }
                j += 1;
            }
            i += 1;
        }
        a += 1;
    }
    mirror
};

/// Direction `i` mirrored across every axis whose bit is set in `mirrors`.
#[inline]
pub fn mirrored(mut i: usize, mirrors: u8) -> usize {
    for axis in 0..3 {
        if mirrors >> axis & 1 == 1 {
            i = MIRROR[axis][i];
        }
    }
    i
}

/// A value for each direction, as `std::array::from_fn` makes it, which is not unrolled for so
/// many.
#[inline(always)]
pub fn each(mut value: impl FnMut(usize) -> f64) -> [f64; Q] {
    let mut all = [0.0; Q];
    for (i, one) in all.iter_mut().enumerate() {
        *one = value(i);
    }
    all
}

/// Deviation of the equilibrium from rest, `feq_i - w_i`, for `rho = 1 + drho` (second order in the
/// velocity).
#[inline]
pub fn equilibrium(i: usize, drho: f64, u: [f64; 3]) -> f64 {
    let cu = dot(C_F64[i], u);
    let rho = 1.0 + drho;
    W[i] * (drho + rho * (3.0 * cu + 4.5 * cu * cu - 1.5 * dot(u, u)))
}

/// [`equilibrium`] in all directions, to rounding; pair by pair, which takes a quarter of the time.
#[inline(always)]
pub fn equilibria(drho: f64, u: [f64; 3]) -> [f64; Q] {
    let [x, y, z] = u;
    let rho = 1.0 + drho;
    let rest = drho - 1.5 * rho * dot(u, u);
    let along = [x, y, z, x + y, x - y, x + z, x - z, y + z, y - z];
    let mut all = [W[0] * rest; Q];
    for (n, cu) in along.into_iter().enumerate() {
        let even = W[n + 10] * (rest + 4.5 * rho * cu * cu);
        let odd = W[n + 10] * (3.0 * rho * cu);
        (all[n + 1], all[n + 10]) = (even - odd, even + odd);
    }
    all
}

/// Sum of populations and their momentum `sum_i h_i c_i`.
#[inline(always)]
pub fn moments(h: &[f64; Q]) -> (f64, [f64; 3]) {
    // Pairs of opposite directions, see `C`.
    let sum: [f64; 9] = std::array::from_fn(|n| h[n + 10] + h[n + 1]);
    let d: [f64; 9] = std::array::from_fn(|n| h[n + 10] - h[n + 1]);
    let mass = h[0]
        + (((sum[0] + sum[1]) + (sum[2] + sum[3]))
            + ((sum[4] + sum[5]) + (sum[6] + sum[7]))
            + sum[8]);
    let momentum = [
        (d[0] + (d[3] + d[4])) + (d[5] + d[6]),
        (d[1] + (d[3] - d[4])) + (d[7] + d[8]),
        (d[2] + (d[5] - d[6])) + (d[7] - d[8]),
    ];
    (mass, momentum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_equilibria_and_moments_at_once_are_those_one_by_one() {
        let (drho, u) = (0.013, [0.04, -0.07, 0.02]);
        let all = equilibria(drho, u);
        for (i, &one) in all.iter().enumerate() {
            assert!((one - equilibrium(i, drho, u)).abs() < 1e-16, "{i}");
        }
        let (mass, momentum) = moments(&all);
        assert!((mass - drho).abs() < 1e-16);
        for a in 0..3 {
            assert!((momentum[a] - (1.0 + drho) * u[a]).abs() < 1e-16);
        }
    }

    #[test]
    fn the_moments_of_the_weights_are_isotropic_to_fourth_order() {
        let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
        let moment = |axes: &[usize]| -> f64 {
            (0..Q).map(|i| W[i] * axes.iter().map(|&a| C_F64[i][a]).product::<f64>()).sum()
        };
        assert!((moment(&[]) - 1.0).abs() < 1e-15);
        for a in 0..3 {
            assert!(moment(&[a]).abs() < 1e-16);
            for b in 0..3 {
                assert!((moment(&[a, b]) - CS2 * delta(a, b)).abs() < 1e-16);
                for c in 0..3 {
                    assert!(moment(&[a, b, c]).abs() < 1e-16);
                    for d in 0..3 {
                        let pairs = delta(a, b) * delta(c, d)
                            + delta(a, c) * delta(b, d)
                            + delta(a, d) * delta(b, c);
                        assert!((moment(&[a, b, c, d]) - CS2 * CS2 * pairs).abs() < 1e-16);
                    }
                }
            }
        }
    }

    #[test]
    fn opposites_are_nine_apart() {
        assert_eq!(OPPOSITE[0], 0);
        for i in 1..=9 {
            assert_eq!(OPPOSITE[i], i + 9);
            assert_eq!(OPPOSITE[i + 9], i);
        }
    }

    #[test]
    fn a_mirror_reverses_one_component() {
        for a in 0..3 {
            for i in 0..Q {
                let m = MIRROR[a][i];
                for b in 0..3 {
                    assert_eq!(C[m][b], if a == b { -C[i][b] } else { C[i][b] });
                }
                assert_eq!(MIRROR[a][m], i);
            }
        }
        // A mirror at all three axes is the opposite.
        assert!((0..Q).all(|i| mirrored(i, 7) == OPPOSITE[i] && mirrored(i, 0) == i));
    }

    #[test]
    fn the_equilibrium_has_the_moments_it_was_made_from() {
        let (drho, u) = (0.02, [0.05, -0.03, 0.08]);
        let h: Vec<f64> = (0..Q).map(|i| equilibrium(i, drho, u)).collect();
        assert!((h.iter().sum::<f64>() - drho).abs() < 1e-16);
        for a in 0..3 {
            let j: f64 = (0..Q).map(|i| h[i] * C_F64[i][a]).sum();
            assert!((j - (1.0 + drho) * u[a]).abs() < 1e-16);
        }
    }
}
