//! The sum of contact forces on a body.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Wrench;
use crate::math::simd::prefetch::fetch_ahead;
use crate::math::simd::vec4::Four;
use crate::neighbours::neighbour_list::{ContactState, NeighbourList};
use crate::solver::neighbour_search::Contacts;
use crate::walls::contact_rows::LoadedBodies;
use tremie_team::Variant;

/// Number of bodies by which records are fetched ahead: few enough to stay in the cache.
const AHEAD: usize = 8;

/// Sum of the forces on the bodies of one block, one body after the other.
pub(crate) struct ForceSum<'a> {
    pairs: &'a NeighbourList,
    surfaces: [Few<'a>; 4],
    /// True if surfaces push any of its bodies.
    any: bool,
    /// True if registers of AVX2 may be used.
    wide: bool,
    /// Index of the block's last body, and one more.
    end: usize,
}

/// Forces of surfaces on few of the bodies of a block.
struct Few<'a> {
    bodies: &'a [u32],
    wrench: &'a [Wrench],
}

impl<'a> Few<'a> {
    fn of_block(on: &'a LoadedBodies, b: usize) -> Self {
        let own = on.bounds[b] as usize..on.bounds[b + 1] as usize;
        Self { bodies: &on.bodies[own.clone()], wrench: &on.wrench[own] }
    }

    /// Leaves out bodies before `i`.
    fn skip_to(&mut self, i: usize) {
        let before = self.bodies.partition_point(|&body| (body as usize) < i);
        (self.bodies, self.wrench) = (&self.bodies[before..], &self.wrench[before..]);
    }

    /// The force on body `i`, later than all asked for before.
    #[inline(always)]
    fn on(&mut self, i: usize) -> Option<&'a Wrench> {
        let (&first, bodies) = self.bodies.split_first()?;
        if first as usize != i {
            return None;
        }
        let (wrench, rest) = self.wrench.split_first()?;
        (self.bodies, self.wrench) = (bodies, rest);
        Some(wrench)
    }
}

impl<'a> ForceSum<'a> {
    /// The forces of block `b`, whose bodies are `range`.
    pub fn new(contacts: Contacts<'a>, b: usize, range: std::ops::Range<usize>) -> Self {
        let Contacts { walls, parts, surfaces: soft, solids, .. } = contacts;
        let surfaces = [
            Few::of_block(&walls.rows.on, b),
            Few::of_block(&parts.rows.on, b),
            Few::of_block(&soft.on, b),
            Few::of_block(&solids.rows.on, b),
        ];
        let any = surfaces.iter().any(|few| !few.bodies.is_empty());
        Self { pairs: contacts.pairs, surfaces, any, wide: false, end: range.end }
    }

    /// The sum in the instructions of a variant, if the processor has them; fast where the caller
    /// is compiled for them.
    #[inline(always)]
    pub fn with(self, variant: Variant) -> Self {
        let wide = variant != Variant::Portable && variant.available();
        Self { wide, ..self }
    }

    /// Contact force and torque on one body, as [`on`](Self::on) sums them up.
    pub fn alone(contacts: Contacts<'a>, i: usize, radius: f64) -> Wrench {
        let mut own = Self::new(contacts, i / BLOCK, i..i + 1);
        own.surfaces.iter_mut().for_each(|few| few.skip_to(i));
        own.on(i, radius)
    }

    /// Contact force and torque on body `i` of the block, each in its turn: first those of bodies,
    /// in the order of their ids, then those of walls, of parts, of surfaces that deform, and all
    /// of polyhedra.
    #[inline(always)]
    pub fn on(&mut self, i: usize, radius: f64) -> Wrench {
        if i + AHEAD < self.end {
            for &place in self.pairs.acting_on(i + AHEAD) {
                fetch_ahead(&self.pairs.records, (place / 2) as usize);
            }
        }
        let mut sum = if !self.pairs.rolling.is_empty() {
            self.rolling(i, radius)
        } else if self.wide {
            self.in_registers(i, radius)
        } else {
            self.plain(i, radius)
        };
        if self.any {
            for few in &mut self.surfaces {
                if let Some(wrench) = few.on(i) {
                    sum.force += wrench.force;
                    sum.torque += wrench.torque;
                }
            }
        }
        sum
    }

    /// Wrench on body i without rolling friction:
    /// [`ContactState::on`](crate::neighbours::neighbour_list::Record::on), in registers.
    #[inline(always)]
    fn plain(&self, i: usize, radius: f64) -> Wrench {
        let (mut force, mut torque) = (Four::ZERO, Four::ZERO);
        for &place in self.pairs.acting_on(i) {
            let ContactState { normal: n, tangential: t, force: f, overlap } =
                self.pairs.records[(place / 2) as usize];
            // What stands behind each vector is read along with it.
            let (n, t) = (Four([n.x, n.y, n.z, t.x]), Four([t.x, t.y, t.z, f]));
            let sign = 1.0 - 2.0 * f64::from(place % 2);
            force = force + (t - n * f) * sign;
            torque = torque + n.cross_zxy(t) * (radius - 0.5 * overlap);
        }
        Wrench { force: force.vector(), torque: torque.at::<1, 2, 0, 3>().vector() }
    }

    /// As [`plain`](Self::plain), by instructions of AVX2: compilers that make them from the other
    /// take twice as many.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn in_registers(&self, i: usize, radius: f64) -> Wrench {
        use core::arch::x86_64::*;
        const SIGNS: [f64; 2] = [1.0, -1.0];
        /// y, z, x, and what stands last.
        const YZX: i32 = 0b11_00_10_01;
        const { assert!(size_of::<ContactState>() == 64) };
        let (mut sums, places) = ([0.0; 8], self.pairs.acting_on(i));
        // SAFETY: `wide` says that the processor has the instructions; a record is eight numbers.
        unsafe {
            let (mut force, mut torque) = (_mm256_setzero_pd(), _mm256_setzero_pd());
            let (half, radius) = (_mm256_set1_pd(0.5), _mm256_set1_pd(radius));
            for &place in places {
                let record = std::ptr::from_ref(&self.pairs.records[(place / 2) as usize]).cast();
                // Normal, tangential force, force, overlap; what stands behind each vector is read
                // along with it.
                let (n, t) = (_mm256_loadu_pd(record), _mm256_loadu_pd(record.add(3)));
                let f = _mm256_broadcast_sd(&*record.add(6));
                let overlap = _mm256_broadcast_sd(&*record.add(7));
                let sign = _mm256_broadcast_sd(&SIGNS[place as usize % 2]);
                let on_body = _mm256_sub_pd(t, _mm256_mul_pd(n, f));
                force = _mm256_add_pd(force, _mm256_mul_pd(on_body, sign));
                let (n_yzx, t_yzx) =
                    (_mm256_permute4x64_pd::<YZX>(n), _mm256_permute4x64_pd::<YZX>(t));
                let cross = _mm256_sub_pd(_mm256_mul_pd(n, t_yzx), _mm256_mul_pd(n_yzx, t));
                let arm = _mm256_sub_pd(radius, _mm256_mul_pd(half, overlap));
                torque = _mm256_add_pd(torque, _mm256_mul_pd(cross, arm));
            }
            _mm256_storeu_pd(sums.as_mut_ptr(), force);
            _mm256_storeu_pd(sums.as_mut_ptr().add(4), _mm256_permute4x64_pd::<YZX>(torque));
        }
        let vector = |a: usize| Vec3::new(sums[a], sums[a + 1], sums[a + 2]);
        Wrench { force: vector(0), torque: vector(4) }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn in_registers(&self, i: usize, radius: f64) -> Wrench {
        self.plain(i, radius)
    }

    /// Wrench on body i with rolling friction.
    #[inline(never)]
    fn rolling(&self, i: usize, radius: f64) -> Wrench {
        let mut sum = Wrench::zero();
        for &place in self.pairs.acting_on(i) {
            let (k, sign) = ((place / 2) as usize, 1.0 - 2.0 * f64::from(place % 2));
            let wrench = self.pairs.records[k].on(sign, radius);
            sum.force += wrench.force;
            sum.torque += wrench.torque;
            sum.torque += self.pairs.rolling[k].torque * sign;
        }
        sum
    }
}
