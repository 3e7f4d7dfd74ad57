//! Collide and stream in place, row by row: the only loop over all cells.
//!
//! The pattern "AA" of Bailey et al. 2009: a collision reads `f_i` of a cell from 19 places and
//! writes `g_i` into the place of the opposite direction. In even steps these are the cell's own
//! places, in odd steps those of its neighbours (see [`Parity::place`]); either way every place
//! belongs to one cell, so cells are independent of each other.

use crate::collision::{Constants, Relaxation, collide};
use crate::field::{Field, Real, prefetch};
use crate::grid::{Grid, Parity};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};
use crate::lanes::{Lanes, Portable, Variant};
use crate::lattice::{C, OPPOSITE, Q};

/// Sums over the fluid cells of a block of rows, before their collision.
#[derive(Clone, Copy, Debug)]
pub struct Survey {
    /// Sum of the densities minus 1.
    pub excess: f64,
    /// Sum of `h_i c_i` (without the half force of a step).
    pub j: [f64; 3],
    /// Largest `u.u`.
    pub speed2: f64,
    /// Smallest density minus 1.
    pub min_drho: f64,
    /// Largest density minus 1.
    pub max_drho: f64,
}

impl Survey {
    /// Of no cells.
    pub const NONE: Self = Self {
        excess: 0.0,
        j: [0.0; 3],
        speed2: 0.0,
        min_drho: f64::INFINITY,
        max_drho: f64::NEG_INFINITY,
    };

    /// Adds another block.
    pub fn join(&mut self, other: &Self) {
        self.excess += other.excess;
        for a in 0..3 {
            self.j[a] += other.j[a];
        }
        self.speed2 = self.speed2.max(other.speed2);
        self.min_drho = self.min_drho.min(other.min_drho);
        self.max_drho = self.max_drho.max(other.max_drho);
    }
}

/// What a kernel works on, the same for all blocks.
#[derive(Clone, Copy)]
pub struct Sweep<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Shape of the box.
    pub grid: &'a Grid,
    /// One bit for each cell of an array over the grid: whether it is fluid. Zero in padding and
    /// ghosts.
    pub fluid: &'a [u8],
    /// Which step.
    pub parity: Parity,
    /// Constants of the collision.
    pub relaxation: &'a Relaxation,
}

/// A kernel: collides and streams the rows `rows` of the box.
///
/// # Safety
/// The processor has the variant's instructions; no other thread uses the places of these rows at
/// the same time; the field and the bits have the grid's size.
pub type Kernel<T> = unsafe fn(&Sweep<T>, std::ops::Range<usize>) -> Survey;

/// A number that has kernels.
pub trait Collides: Real {
    /// The kernel of a variant.
    ///
    /// # Panics
    /// If this processor lacks the variant's instructions.
    fn kernel(variant: Variant) -> Kernel<Self>;
}

macro_rules! kernels {
    ($real:ty, $portable:ty, $avx2:ty, $avx512:ty) => {
        impl Collides for $real {
            fn kernel(variant: Variant) -> Kernel<Self> {
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2")]
                unsafe fn avx2(sweep: &Sweep<$real>, rows: std::ops::Range<usize>) -> Survey {
                    // SAFETY: by contract.
                    unsafe { sweep_rows::<$avx2>(sweep, rows) }
                }
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx512f,avx512vl")]
                unsafe fn avx512(sweep: &Sweep<$real>, rows: std::ops::Range<usize>) -> Survey {
                    // SAFETY: by contract.
                    unsafe { sweep_rows::<$avx512>(sweep, rows) }
                }
                assert!(variant.available(), "this processor has no {variant:?}");
                match variant {
                    #[cfg(target_arch = "x86_64")]
                    Variant::Avx2 => avx2,
                    #[cfg(target_arch = "x86_64")]
                    Variant::Avx512 => avx512,
                    _ => sweep_rows::<$portable>,
                }
            }
        }
    };
}
kernels!(f64, Portable<f64, 2>, Avx2F64, Avx512F64);
kernels!(f32, Portable<f32, 4>, Avx2F32, Avx512F32);

/// The body of every kernel. See [`Kernel`] for the contract.
#[inline(always)]
unsafe fn sweep_rows<V: Lanes>(sweep: &Sweep<V::Scalar>, rows: std::ops::Range<usize>) -> Survey {
    if sweep.relaxation.acceleration == [0.0; 3] {
        // SAFETY: by contract.
        unsafe { sweep_forced::<V, false>(sweep, rows) }
    } else {
        // SAFETY: by contract.
        unsafe { sweep_forced::<V, true>(sweep, rows) }
    }
}

/// [`sweep_rows`] with or without an acceleration.
#[inline(always)]
unsafe fn sweep_forced<V: Lanes, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    rows: std::ops::Range<usize>,
) -> Survey {
    let grid = sweep.grid;
    let wraps = grid.periodic[0] && sweep.parity == Parity::Odd;
    // SAFETY: by contract.
    let constants = unsafe { Constants::<V>::new(sweep.relaxation) };
    // SAFETY: by contract.
    let mut sums = unsafe { Sums::<V>::new() };
    for row in rows {
        let [y, z] = grid.row_at(row);
        let bits = grid.row_start(y, z) / 8;
        let bits = &sweep.fluid[bits..bits + (grid.n[0] as usize).div_ceil(8)];
        let places = row_places(sweep, y, z);
        // SAFETY: the places belong to this row, which is this thread's; along x they reach one
        // cell beyond the row on either side and, in the last vector, into the padding, both of
        // which exist (`Grid::stride`). Pointers made in `row_places` are inside the field.
        unsafe {
            if wraps {
                wrap_in::<V::Scalar>(&places, grid.n[0] as usize);
            }
            sweep_row::<V, FORCED>(&places, bits, &constants, &mut sums);
            if wraps {
                wrap_out::<V::Scalar>(&places, grid.n[0] as usize);
            }
        }
    }
    // SAFETY: by contract.
    unsafe { sums.survey() }
}

/// For each direction, where `f_i` of the cell `x = 0` of a row is.
#[inline(always)]
fn row_places<T: Real>(sweep: &Sweep<T>, y: i32, z: i32) -> [*mut T; Q] {
    let grid = sweep.grid;
    let mut places = [sweep.field.base(); Q];
    let mut i = 0;
    while i < Q {
        let (plane, start) = match sweep.parity {
            Parity::Even => (i, grid.row_start(y, z) as isize),
            Parity::Odd => {
                let o = OPPOSITE[i];
                let (y, z) = (grid.wrap(1, y + C[o][1]), grid.wrap(2, z + C[o][2]));
                (o, grid.row_start(y, z) as isize + C[o][0] as isize)
            }
        };
        places[i] = places[i].wrapping_offset((plane * sweep.field.plane()) as isize + start);
        i += 1;
    }
    places
}

/// Copies what the row reads through the periodic faces of x into the ghosts at its ends.
///
/// # Safety
/// The places are an odd step's, of a row of `n` cells.
#[inline(always)]
unsafe fn wrap_in<T: Real>(places: &[*mut T; Q], n: usize) {
    for i in 1..Q {
        // SAFETY: by contract; for `c_x = 1` the place of `x = 0` is the ghost `-1` and that of `x
        // = n` the cell `n - 1`, for `c_x = -1` the place of `x = n - 1` is the ghost `n` and that
        // of `x = -1` the cell 0.
        unsafe {
            match C[i][0] {
                1 => *places[i] = *places[i].add(n),
                -1 => *places[i].add(n - 1) = *places[i].sub(1),
                _ => {}
            }
        }
    }
}

/// Copies what the row wrote into the ghosts at its ends through the periodic faces of x; undoes
/// [`wrap_in`].
///
/// # Safety
/// As for [`wrap_in`].
#[inline(always)]
unsafe fn wrap_out<T: Real>(places: &[*mut T; Q], n: usize) {
    for i in 1..Q {
        // SAFETY: as in `wrap_in`.
        unsafe {
            match C[i][0] {
                1 => *places[i].add(n) = *places[i],
                -1 => *places[i].sub(1) = *places[i].add(n - 1),
                _ => {}
            }
        }
    }
}

/// Collides one row, a vector at a time. Vectors without fluid are left alone; lanes without fluid
/// become zero, which is a fluid at rest, so that nothing odd can grow inside solids.
///
/// # Safety
/// As for [`Kernel`]; `bits` covers the row.
#[inline(always)]
unsafe fn sweep_row<V: Lanes, const FORCED: bool>(
    places: &[*mut V::Scalar; Q],
    bits: &[u8],
    constants: &Constants<V>,
    sums: &mut Sums<V>,
) {
    let all = u32::MAX >> (32 - V::N);
    let mut x = 0;
    while x < 8 * bits.len() {
        let lanes = lanes_at(bits, x) & all;
        if lanes != 0 {
            // SAFETY: by contract; `x + N` is at most the row's length rounded up to a vector of
            // the longest kind.
            unsafe {
                let mut h = [V::splat(0.0); Q];
                let mut i = 0;
                while i < Q {
                    h[i] = V::load(places[i].add(x));
                    prefetch(places[i].wrapping_add(x + AHEAD * V::Scalar::LINE));
                    i += 1;
                }
                let mut moments = collide::<V, FORCED>(&mut h, constants);
                if lanes != all {
                    let mask = V::mask(lanes);
                    let mut i = 0;
                    while i < Q {
                        h[i] = h[i].keep(mask);
                        i += 1;
                    }
                    moments.drho = moments.drho.keep(mask);
                    moments.j =
                        [moments.j[0].keep(mask), moments.j[1].keep(mask), moments.j[2].keep(mask)];
                    moments.speed2 = moments.speed2.keep(mask);
                }
                let mut i = 0;
                while i < Q {
                    h[OPPOSITE[i]].store(places[i].add(x));
                    i += 1;
                }
                sums.add(x, &moments);
            }
        }
        x += V::N;
    }
}

/// How many cache lines ahead of its use a place is fetched. The collision of a vector fills the
/// processor's window of instructions, so that it does not reach the next vector's loads by itself;
/// two vectors take about as long as memory does.
const AHEAD: usize = 4;

/// The bits of cell `x` and those after it, at least as many as a vector of this kind is long.
#[inline(always)]
fn lanes_at(bits: &[u8], x: usize) -> u32 {
    let low = u32::from(bits[x / 8]) >> (x % 8);
    if x.is_multiple_of(8) && x / 8 + 1 < bits.len() {
        low | u32::from(bits[x / 8 + 1]) << 8
    } else {
        low
    }
}

/// Running sums, one for each place of a 64-byte line, so that the order of additions is the same
/// for vectors of any length.
struct Sums<V> {
    excess: [f64; 16],
    j: [[f64; 16]; 3],
    speed2: V,
    min_drho: V,
    max_drho: V,
}

impl<V: Lanes> Sums<V> {
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    unsafe fn new() -> Self {
        // SAFETY: by contract.
        let zero = unsafe { V::splat(0.0) };
        Self { excess: [0.0; 16], j: [[0.0; 16]; 3], speed2: zero, min_drho: zero, max_drho: zero }
    }

    /// Adds the moments of the vector at `x`.
    #[inline(always)]
    fn add(&mut self, x: usize, m: &crate::collision::Moments<V>) {
        let lane = x % V::Scalar::LINE;
        debug_assert!(lane + V::N <= 16);
        // SAFETY: `x` is a multiple of N, which divides LINE, so `lane + N <= LINE <= 16`.
        unsafe {
            m.drho.add_to(self.excess.as_mut_ptr().add(lane));
            m.j[0].add_to(self.j[0].as_mut_ptr().add(lane));
            m.j[1].add_to(self.j[1].as_mut_ptr().add(lane));
            m.j[2].add_to(self.j[2].as_mut_ptr().add(lane));
        }
        self.speed2 = m.speed2.max(self.speed2);
        self.min_drho = m.drho.min(self.min_drho);
        self.max_drho = m.drho.max(self.max_drho);
    }

    /// Adds up the lanes, in their order.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    unsafe fn survey(&self) -> Survey {
        let mut survey = Survey { min_drho: 0.0, max_drho: 0.0, ..Survey::NONE };
        let mut k = 0;
        while k < V::Scalar::LINE {
            survey.excess += self.excess[k];
            survey.j[0] += self.j[0][k];
            survey.j[1] += self.j[1][k];
            survey.j[2] += self.j[2][k];
            k += 1;
        }
        let mut lanes = [V::Scalar::from_f64(0.0); 16];
        // SAFETY: a vector has at most 16 lanes.
        unsafe {
            self.speed2.store(lanes.as_mut_ptr());
            survey.speed2 = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
            self.min_drho.store(lanes.as_mut_ptr());
            survey.min_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().min(m));
            self.max_drho.store(lanes.as_mut_ptr());
            survey.max_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
        }
        survey
    }
}
