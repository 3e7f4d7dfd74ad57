//! Vectors of space in registers of four numbers, the last of which means nothing unless it is
//! said.
//!
//! Arrays, and loops over them that compilers turn into one instruction where the function around
//! them is compiled for it. Every operation is rounded once, in the order in which formulae of
//! three numbers have them: the bits are the same.

use crate::Vec3;
use core::ops::{Add, Mul, Sub};

/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four(pub [f64; 4]);

/// Implements an operation number by number.
macro_rules! each {
    ($l:ident => $value:expr) => {{
        let mut out = [0.0; 4];
        let mut $l = 0;
        while $l < 4 {
            out[$l] = $value;
            $l += 1;
        }
        Four(out)
    }};
}

impl Four {
    pub const ZERO: Self = Self([0.0; 4]);

    /// A vector, with 0 as the fourth.
    #[inline(always)]
    pub fn of(v: &Vec3) -> Self {
        Self([v.x, v.y, v.z, 0.0])
    }

    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; 4])
    }

    #[inline(always)]
    pub fn vector(self) -> Vec3 {
        Vec3::new(self.0[0], self.0[1], self.0[2])
    }

    /// The numbers at these places.
    #[inline(always)]
    pub fn at<const A: usize, const B: usize, const C: usize, const D: usize>(self) -> Self {
        Self([self.0[A], self.0[B], self.0[C], self.0[D]])
    }

    /// The cross product, with its z, x and y as x, y and z: that spares an exchange, which may
    /// wait until many are summed up.
    #[inline(always)]
    pub fn cross_zxy(self, other: Self) -> Self {
        self * other.at::<1, 2, 0, 3>() - self.at::<1, 2, 0, 3>() * other
    }
}

impl Add for Four {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        each!(l => self.0[l] + other.0[l])
    }
}

impl Sub for Four {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        each!(l => self.0[l] - other.0[l])
    }
}

impl Mul for Four {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        each!(l => self.0[l] * other.0[l])
    }
}

impl Mul<f64> for Four {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::all(factor)
    }
}
