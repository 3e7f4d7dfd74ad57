//! Non-equilibrium bounce-back at open faces (Zou & He 1997; Hecht & Harting 2010).
//!
//! With sums over the directions along the face (0) and out of the fluid (-), `n` the normal into
//! the fluid,
//!
//! ```text
//! NEBB  u.n = 1 - (S_0 + 2 S_-)/rho     (pressure)      rho = (S_0 + 2 S_-)/(1 - u.n)     (velocity)
//!       N_t = 1/2 sum_{c_j.n = 0} c_j,t f_j - rho u_t/3
//!       f_i = f_i' + 6 w_i rho (c_i.u) - (c_i - (c_i.n) n).N_t                      for c_i.n > 0
//! ```

use crate::lattice::d3q19::{C, C_F64, OPPOSITE, Q, W, dot};

/// A face across an axis: 1 where the normal into the fluid points along it, else -1.
#[derive(Clone, Copy, Debug)]
pub struct Inward {
    /// The axis.
    pub axis: usize,
    /// The sign.
    pub sign: i32,
}

impl Inward {
    /// Of a face, `2 axis + side`.
    pub fn of(face: usize) -> Self {
        Self { axis: face / 2, sign: [1, -1][face % 2] }
    }

    /// `S_0 + 2 S_-` of populations as deviations from rest, less what it is at rest, which is 1:
    /// the density less the momentum along the normal, whatever comes from beyond the face.
    #[inline]
    pub fn known_sum(self, h: &[f64; Q]) -> f64 {
        let mut s = 0.0;
        for i in 0..Q {
            match C[i][self.axis] * self.sign {
                0 => s += h[i],
                -1 => s += 2.0 * h[i],
                _ => {}
            }
        }
        s
    }

    /// Populations of a cell with a density, less 1, and a momentum over density `u`, from those
    /// that it has.
    pub fn zou_he(self, old: &[f64; Q], drho: f64, u: [f64; 3]) -> [f64; Q] {
        let rho = 1.0 + drho;
        let transverse: [f64; 3] = std::array::from_fn(|a| {
            if a == self.axis {
                return 0.0;
            }
            let along = (0..Q).filter(|&j| C[j][self.axis] == 0).map(|j| C_F64[j][a] * old[j]);
            0.5 * along.sum::<f64>() - rho * u[a] / 3.0
        });
        let mut new = *old;
        for i in (0..Q).filter(|&i| C[i][self.axis] == self.sign) {
            new[i] =
                old[OPPOSITE[i]] + 6.0 * W[i] * rho * dot(C_F64[i], u) - dot(C_F64[i], transverse);
        }
        new
    }
}
