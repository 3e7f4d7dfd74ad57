//! Vectors of several contacts side by side: what one formula does to all of them at once.
//!
//! A formula is written once over [`SimdLane`]: single numbers, plain arrays, and loops over them
//! that compilers turn into vector instructions where the function around them is compiled with
//! these, or registers. So contacts side by side give the bits that they give one by one.

use crate::Vec3;
#[cfg(target_arch = "x86_64")]
use core::ops::Div;
use core::ops::{Add, Mul, Neg, Sub};
use tremie_team::simd::{Portable, SimdLane};

/// Contacts side by side.
pub(crate) const LANES: usize = 8;

/// A vector of each contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane3<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

/// Numbers in a plain array.
pub(crate) type Plain = Portable<f64, LANES>;

/// Numbers of twice as many contacts: where one half waits for a root or a quotient, the other goes
/// on.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Both<L>(pub L, pub L);

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> SimdLane for Both<L> {
    #[inline(always)]
    fn all(self, value: f64) -> Self {
        Self(self.0.all(value), self.1.all(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn positive(self) -> Self {
        Self(self.0.positive(), self.1.positive())
    }
    #[inline(always)]
    fn less(self, other: Self, yes: Self, no: Self) -> Self {
        Self(self.0.less(other.0, yes.0, no.0), self.1.less(other.1, yes.1, no.1))
    }
    #[inline(always)]
    fn at_most(self, other: Self, yes: Self, no: Self) -> Self {
        Self(self.0.at_most(other.0, yes.0, no.0), self.1.at_most(other.1, yes.1, no.1))
    }
}

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> Add for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> Sub for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }
}

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> Mul for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0, self.1 * other.1)
    }
}

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> Div for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0, self.1 / other.1)
    }
}

#[cfg(target_arch = "x86_64")]
impl<L: SimdLane> Neg for Both<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl From<Vec3> for Lane3<f64> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Lane3<f64>> for Vec3 {
    #[inline(always)]
    fn from(v: Lane3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl Lane3<Plain> {
    pub const ZERO: Self = Self { x: Plain::ZERO, y: Plain::ZERO, z: Plain::ZERO };

    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: &Vec3) {
        (self.x.0[lane], self.y.0[lane], self.z.0[lane]) = (v.x, v.y, v.z);
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }
}

#[cfg(target_arch = "x86_64")]
impl<L> Lane3<L> {
    /// Vectors of these contacts, and of others.
    #[inline(always)]
    pub fn beside(self, other: Self) -> Lane3<Both<L>> {
        let (a, b) = (self, other);
        Lane3 { x: Both(a.x, b.x), y: Both(a.y, b.y), z: Both(a.z, b.z) }
    }
}

#[cfg(target_arch = "x86_64")]
impl<L> Lane3<Both<L>> {
    /// Vectors of either half.
    #[inline(always)]
    pub fn halves(self) -> [Lane3<L>; 2] {
        let Self { x, y, z } = self;
        [Lane3 { x: x.0, y: y.0, z: z.0 }, Lane3 { x: x.1, y: y.1, z: z.1 }]
    }
}

impl<L: SimdLane> Lane3<L> {
    /// The same vector of each contact, from three numbers.
    #[inline(always)]
    pub fn repeat(value: L) -> Self {
        Self { x: value, y: value, z: value }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// `yes` where `a` is no more than `b`, else `no`.
    #[inline(always)]
    pub fn at_most(a: L, b: L, yes: Self, no: Self) -> Self {
        Self {
            x: a.at_most(b, yes.x, no.x),
            y: a.at_most(b, yes.y, no.y),
            z: a.at_most(b, yes.z, no.z),
        }
    }
}

impl<L: SimdLane> Add for Lane3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<L: SimdLane> Sub for Lane3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<L: SimdLane> Mul<L> for Lane3<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: L) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<L: SimdLane> Neg for Lane3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
