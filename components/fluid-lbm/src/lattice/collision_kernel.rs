//! Collide and stream in place, line by line: the only loop over all cells.
//!
//! A collision reads `f_i` of a cell from 19 places and writes `g_i` into the place of the opposite
//! direction (see `aa_pattern`). Every place belongs to one cell, so cells are independent of each
//! other. A step reads and writes each number once: 19 of them a cell, and in odd steps 8 bytes for
//! each line of 64 bytes and 76 bytes of the table of places for each run of lines.

use crate::lattice::aa_gather::{self, PIECES_AHEAD, Scratch};
use crate::lattice::aa_pattern::{AaPattern, Parity};
use crate::lattice::collision::operators::{
    CentralMoments, CollisionOperator, SingleTime, Smagorinsky, TwoTimes, WithBulk,
};
use crate::lattice::collision::{Constants, Relaxation};
use crate::lattice::contiguous_lines::{self, LineRun};
use crate::lattice::halfway_bounce_back::HalfwayLinks;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::{Field, Real};
use crate::lattice::reductions::{CellStatistics, StatisticsSums};
use crate::lattice::reflection_impulse::ReflectionImpulse;
use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use tremie_team::Variant;
#[cfg(target_arch = "x86_64")]
use tremie_team::simd::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};
use tremie_team::simd::{Portable, SimdVector};

/// Consecutive lines that are one item of work, and what their collision found.
#[derive(Clone, Debug)]
pub struct CellBlock {
    /// The lines.
    pub lines: Range<usize>,
    /// Sums over their cells.
    pub survey: CellStatistics,
    /// For each of the block's runs of reflecting links, the sum of the reflected populations.
    pub reflected: Vec<f64>,
    /// Links at walls at rest, and what these felt.
    pub halfway: HalfwayLinks,
}

/// Input of a kernel, the same for all blocks.
#[derive(Clone, Copy)]
pub struct Sweep<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Places of the populations.
    pub places: &'a AaPattern,
    /// One bit for each stored cell: whether it is fluid. Zero in padding.
    pub fluid: &'a [u8],
    /// Parity of the step.
    pub parity: Parity,
    /// Constants of the collision.
    pub relaxation: &'a Relaxation,
    /// Reflecting links.
    pub tally: &'a ReflectionImpulse,
    /// Lines whose densities somebody wants to know, and room for these.
    pub wanted: &'a DensityRequests<T>,
}

/// Densities that the links of bodies will need.
pub struct DensityRequests<T: Real> {
    /// For each line whether it is wanted; empty if none is.
    pub lines: Vec<AtomicU8>,
    /// Steps until it is asked anew which are.
    pub left: u32,
    /// For each cell of a wanted line the density minus 1 before the last collision, which keeps
    /// it.
    pub drho: Field<T>,
}

/// So many steps a line stays wanted at least.
const WANTED_FOR: u32 = 64;

impl<T: Real> DensityRequests<T> {
    /// Begins a step. True if everybody is to say which lines are wanted; else whoever wants others
    /// than in the step before, and what was wanted may still be: a density that nobody asks for
    /// costs next to nothing.
    pub fn begin(&mut self) -> bool {
        let is_fresh = self.left == 0;
        if is_fresh {
            self.left = WANTED_FOR;
            self.lines.iter_mut().for_each(|line| *line.get_mut() = 0);
        }
        self.left -= 1;
        is_fresh
    }

    /// Memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        self.lines.len() * (1 + 64)
    }

    /// Address to which the densities of a line are written; null if nobody asks for them.
    #[inline(always)]
    pub fn room(&self, line: usize) -> *mut T {
        if self.lines.get(line).is_some_and(|wanted| wanted.load(Relaxed) != 0) {
            self.drho.base().wrapping_add(line * T::LINE)
        } else {
            std::ptr::null_mut()
        }
    }
}

/// A kernel: collides and streams a block, the `usize`th of all, then adds up what its links
/// reflect.
///
/// # Safety
/// The processor has the variant's instructions; no other thread uses the places of the block's
/// cells at the same time; field, places, bits and tally were made for the same cells.
pub type Kernel<T> = unsafe fn(&Sweep<T>, usize, &mut CellBlock);

/// A number that has kernels.
pub trait CollisionKernel: Real {
    /// The kernel of a variant.
    ///
    /// # Panics
    /// If this processor lacks the variant's instructions.
    fn kernel(variant: Variant) -> Kernel<Self>;
}

/// Collides a run of lines, see [`contiguous_lines::collide`]; one function for each variant and
/// operator, with and without an acceleration.
type RunKernel<V> = unsafe fn(
    &Sweep<<V as SimdVector>::Scalar>,
    &LineRun<<V as SimdVector>::Scalar>,
    &Constants<V>,
    &mut StatisticsSums<V>,
);

macro_rules! kernels {
    ($real:ty, $portable:ty, $avx2:ty, $avx512:ty) => {
        impl CollisionKernel for $real {
            fn kernel(variant: Variant) -> Kernel<Self> {
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2,fma")]
                unsafe fn avx2(sweep: &Sweep<$real>, number: usize, block: &mut CellBlock) {
                    kernels!(run, $avx2, #[target_feature(enable = "avx2,fma")]);
                    let run = kernels!(choose, sweep.relaxation);
                    // SAFETY: by contract.
                    unsafe { work::<$avx2>(sweep, number, block, run) }
                }
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx512f,avx512vl")]
                unsafe fn avx512(sweep: &Sweep<$real>, number: usize, block: &mut CellBlock) {
                    kernels!(run, $avx512, #[target_feature(enable = "avx512f,avx512vl")]);
                    let run = kernels!(choose, sweep.relaxation);
                    // SAFETY: by contract.
                    unsafe { work::<$avx512>(sweep, number, block, run) }
                }
                unsafe fn portable(sweep: &Sweep<$real>, number: usize, block: &mut CellBlock) {
                    kernels!(run, $portable, #[inline(never)]);
                    let run = kernels!(choose, sweep.relaxation);
                    // SAFETY: by contract.
                    unsafe { work::<$portable>(sweep, number, block, run) }
                }
                assert!(variant.available(), "this processor has no {variant:?}");
                match variant {
                    #[cfg(target_arch = "x86_64")]
                    Variant::Avx2 => avx2,
                    #[cfg(target_arch = "x86_64")]
                    Variant::Avx512 => avx512,
                    _ => portable,
                }
            }
        }
    };
    (run, $lanes:ty, #[$($feature:tt)*]) => {
        #[$($feature)*]
        unsafe fn run<O: CollisionOperator, const FORCED: bool>(
            sweep: &Sweep<<$lanes as SimdVector>::Scalar>,
            run: &LineRun<<$lanes as SimdVector>::Scalar>,
            constants: &Constants<$lanes>,
            sums: &mut StatisticsSums<$lanes>,
        ) {
            // SAFETY: by contract.
            unsafe { contiguous_lines::collide::<$lanes, O, FORCED>(sweep, run, constants, sums) }
        }
    };
    (choose, $relaxation:expr) => {{
        let r = $relaxation;
        let (is_forced, has_eddies) = (r.acceleration != [0.0; 3], r.smagorinsky != 0.0);
        match (is_forced, has_eddies, r.magic.is_none()) {
            (false, false, _) if r.central => run::<CentralMoments<false>, false>,
            (false, true, _) if r.central => run::<CentralMoments<true>, false>,
            (true, false, _) if r.central => run::<CentralMoments<false>, true>,
            (true, true, _) if r.central => run::<CentralMoments<true>, true>,
            (false, false, _) if r.bulk.is_some() => run::<WithBulk<TwoTimes>, false>,
            (true, false, _) if r.bulk.is_some() => run::<WithBulk<TwoTimes>, true>,
            (false, true, false) if r.bulk.is_some() => {
                run::<WithBulk<Smagorinsky<false>>, false>
            }
            (false, true, true) if r.bulk.is_some() => run::<WithBulk<Smagorinsky<true>>, false>,
            (true, true, false) if r.bulk.is_some() => run::<WithBulk<Smagorinsky<false>>, true>,
            (true, true, true) if r.bulk.is_some() => run::<WithBulk<Smagorinsky<true>>, true>,
            (false, false, false) => run::<TwoTimes, false>,
            (false, false, true) => run::<SingleTime, false>,
            (false, true, false) => run::<Smagorinsky<false>, false>,
            (false, true, true) => run::<Smagorinsky<true>, false>,
            (true, false, _) => run::<TwoTimes, true>,
            (true, true, false) => run::<Smagorinsky<false>, true>,
            (true, true, true) => run::<Smagorinsky<true>, true>,
        }
    }};
}
kernels!(f64, Portable<f64, 2>, Avx2F64, Avx512F64);
kernels!(f32, Portable<f32, 4>, Avx2F32, Avx512F32);

/// The body of every kernel. See [`Kernel`] for the contract.
#[inline(always)]
unsafe fn work<V: LatticeVector>(
    sweep: &Sweep<V::Scalar>,
    number: usize,
    block: &mut CellBlock,
    run: RunKernel<V>,
) {
    // SAFETY: by contract.
    block.survey = unsafe { sweep_lines::<V>(sweep, block.lines.clone(), run) };
    // SAFETY: by contract; the block's cells have collided, and their reflecting links are in
    // places of their own.
    unsafe { sweep.tally.sum::<V>(sweep.field, sweep.fluid, number, &mut block.reflected) };
}

/// Collides and streams lines, in runs within which the places of a line follow those of the line
/// before.
#[inline(always)]
unsafe fn sweep_lines<V: LatticeVector>(
    sweep: &Sweep<V::Scalar>,
    lines: Range<usize>,
    run: RunKernel<V>,
) -> CellStatistics {
    // SAFETY: by contract.
    let constants = unsafe { Constants::<V>::new(sweep.relaxation) };
    // SAFETY: by contract.
    let mut sums = unsafe { StatisticsSums::<V>::new() };
    if sweep.parity == Parity::Even {
        // SAFETY: these are the lines' own places in even steps.
        unsafe { run(sweep, &LineRun::even(sweep, lines), &constants, &mut sums) };
    } else {
        let mut scratch = Scratch::new();
        let (mut start, mut asked) = (lines.start, lines.start);
        while start < lines.end {
            let end = if V::N == V::Scalar::LINE {
                sweep.places.run_end::<true>(start, lines.end)
            } else {
                sweep.places.run_end::<false>(start, lines.end)
            };
            let soon = (end + PIECES_AHEAD).min(lines.end);
            (asked.max(end)..soon).for_each(|line| aa_gather::ask(sweep, line));
            asked = soon;
            let is_in_pieces = sweep.places.kind(start).is_in_pieces();
            let is_row_end = sweep.places.way(start).row_end.is_some();
            // SAFETY: places and pieces are those of the lines in odd steps. A line that has to be
            // collected is a run of its own.
            unsafe {
                if !is_in_pieces || V::N == V::Scalar::LINE && is_row_end {
                    run(sweep, &LineRun::odd(sweep, start..end), &constants, &mut sums);
                } else if line_bits::<V>(sweep.fluid, start) != 0 {
                    let collected = scratch.gather::<V>(sweep, start);
                    run(sweep, &collected, &constants, &mut sums);
                    scratch.scatter::<V>(sweep, start);
                }
            }
            start = end;
        }
    }
    // SAFETY: by contract.
    unsafe { sums.survey() }
}

/// The bits of all lanes of a vector.
pub const fn all_lanes<V: LatticeVector>() -> u32 {
    u32::MAX >> (32 - V::N)
}

/// Bits of the fluid cells of a line.
///
/// # Safety
/// The line has bits.
#[inline(always)]
pub unsafe fn line_bits<V: LatticeVector>(fluid: &[u8], line: usize) -> u32 {
    debug_assert!((line + 1) * V::Scalar::LINE <= 8 * fluid.len());
    // SAFETY: by contract.
    unsafe {
        if V::Scalar::LINE == 8 {
            u32::from(*fluid.get_unchecked(line))
        } else {
            let both = fluid.as_ptr().add(2 * line).cast::<[u8; 2]>().read();
            u32::from(u16::from_le_bytes(both))
        }
    }
}
