//! Linear interpolation of a link that meets a wall at `x_f + q c_i` (Bouzidi, Firdaouss &
//! Lallemand 2001; of a wall that moves with velocity `u_w`, with `rho` at `x_f`: Lallemand & Luo
//! 2003):
//!
//! ```text
//! q < 1/2 :  f_i'(x_f) = 2q g_i(x_f) + (1-2q) g_i(x_f - c_i)               - 6 w_i rho (c_i.u_w)
//! q >= 1/2:  f_i'(x_f) = g_i(x_f)/(2q) + (2q-1)/(2q) g_i'(x_f)             - 3 (w_i/q) rho (c_i.u_w)
//! ```
//!
//! One home for bodies, edges of bodies, and static walls. Where the other population is none of
//! the fluid the wall is taken half-way: `f_i' = g_i - 6 w_i rho (c_i.u_w)`.

/// Coefficients of a link that meets the wall at `q`.
#[derive(Clone, Copy, Debug)]
pub struct Bouzidi {
    /// Factor of `g_i`.
    pub own: f64,
    /// Factor of the other population: `g_i(x_f - c_i)` if `q < 1/2`, else `g_i'(x_f)`.
    pub other: f64,
    /// Factor of `6 w_i rho (c_i.u_w)`.
    pub push: f64,
}

impl Bouzidi {
    /// At a part of the link, over 0 and up to 1.
    #[inline(always)]
    pub fn at(q: f64) -> Self {
        let part = 0.5 / q;
        let far = q >= 0.5;
        Self {
            own: if far { part } else { 2.0 * q },
            other: if far { 1.0 - part } else { 1.0 - 2.0 * q },
            push: if far { part } else { 1.0 },
        }
    }

    /// Population that comes back, from `g_i`, the other population, and `push = 6 w_i rho
    /// (c_i.u_w)`.
    #[inline(always)]
    pub fn reflect(self, g: f64, other: f64, push: f64) -> f64 {
        self.own * g + self.other * other - self.push * push
    }
}
