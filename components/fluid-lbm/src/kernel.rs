//! Collide and stream in place, line by line: the only loop over all cells.
//!
//! A collision reads `f_i` of a cell from 19 places and writes `g_i` into the place of the opposite
//! direction (see `places`). Every place belongs to one cell, so cells are independent of each
//! other. A step reads and writes each number once: 19 of them a cell, and in odd steps 8 bytes for
//! each line of 64 bytes and 76 bytes of the table of places for each run of lines.

use crate::collision::{AHEAD, Constants, Rates, Relaxation, Target, ask_ahead, measure, relax};
use crate::field::{Field, Real, prefetch};
use crate::halfway::HalfwayLinks;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};
use crate::lanes::{Lanes, Portable};
use crate::lattice::Q;
use crate::places::{Parity, Places};
use crate::survey::{Sums, Survey};
use crate::tally::Tally;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use tremie_team::Variant;

/// Consecutive lines that are one item of work, and what their collision found.
#[derive(Clone, Debug)]
pub struct Block {
    /// The lines.
    pub lines: Range<usize>,
    /// Sums over their cells.
    pub survey: Survey,
    /// For each of the block's runs of reflecting links, the sum of the reflected populations.
    pub reflected: Vec<f64>,
    /// Links at walls at rest, and what these felt.
    pub halfway: HalfwayLinks,
}

/// What a kernel works on, the same for all blocks.
#[derive(Clone, Copy)]
pub struct Sweep<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Where they are.
    pub places: &'a Places,
    /// One bit for each stored cell: whether it is fluid. Zero in padding.
    pub fluid: &'a [u8],
    /// Which step.
    pub parity: Parity,
    /// Constants of the collision.
    pub relaxation: &'a Relaxation,
    /// Reflecting links.
    pub tally: &'a Tally,
    /// Lines whose densities somebody wants to know, and room for these.
    pub wanted: &'a Wanted<T>,
}

/// Densities that the links of bodies will need.
pub struct Wanted<T: Real> {
    /// For each line whether it is wanted; empty if none is.
    pub lines: Vec<AtomicU8>,
    /// Steps until it is asked anew which are.
    pub left: u32,
    /// For each cell of a wanted line the density minus 1 before the last collision, which keeps it.
    pub drho: Field<T>,
}

/// So many steps a line stays wanted at least.
const WANTED_FOR: u32 = 64;

impl<T: Real> Wanted<T> {
    /// Begins a step. True if everybody is to say which lines are wanted; else whoever wants others than in the step
    /// before, and what was wanted may still be: a density that nobody asks for costs next to nothing.
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

    /// Where the densities of a line go; nowhere if nobody wants them.
    #[inline(always)]
    fn room(&self, line: usize) -> *mut T {
        if self.lines.get(line).is_some_and(|wanted| wanted.load(Relaxed) != 0) {
            self.drho.base().wrapping_add(line * T::LINE)
        } else {
            std::ptr::null_mut()
        }
    }
}

/// A kernel: collides and streams a block, the `usize`th of all, then adds up what its links reflect.
///
/// # Safety
/// The processor has the variant's instructions; no other thread uses the places of the block's
/// cells at the same time; field, places, bits and tally were made for the same cells.
pub type Kernel<T> = unsafe fn(&Sweep<T>, usize, &mut Block);

/// A number that has kernels.
pub trait Collides: Real {
    /// The kernel of a variant.
    ///
    /// # Panics
    /// If this processor lacks the variant's instructions.
    fn kernel(variant: Variant) -> Kernel<Self>;
}

/// Collides a run of lines, see [`collide_run`]; one function for each variant, with and without an acceleration,
/// with and without a closure, and for one and two times.
type RunKernel<V> = unsafe fn(
    &Sweep<<V as Lanes>::Scalar>,
    Range<usize>,
    &[*mut <V as Lanes>::Scalar; Q],
    &Constants<V>,
    &mut Sums<V>,
);

macro_rules! kernels {
    ($real:ty, $portable:ty, $avx2:ty, $avx512:ty) => {
        impl Collides for $real {
            fn kernel(variant: Variant) -> Kernel<Self> {
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2,fma")]
                unsafe fn avx2(sweep: &Sweep<$real>, number: usize, block: &mut Block) {
                    kernels!(run, $avx2, #[target_feature(enable = "avx2,fma")]);
                    let run = kernels!(choose, sweep.relaxation);
                    // SAFETY: by contract.
                    unsafe { work::<$avx2>(sweep, number, block, run) }
                }
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx512f,avx512vl")]
                unsafe fn avx512(sweep: &Sweep<$real>, number: usize, block: &mut Block) {
                    kernels!(run, $avx512, #[target_feature(enable = "avx512f,avx512vl")]);
                    let run = kernels!(choose, sweep.relaxation);
                    // SAFETY: by contract.
                    unsafe { work::<$avx512>(sweep, number, block, run) }
                }
                unsafe fn portable(sweep: &Sweep<$real>, number: usize, block: &mut Block) {
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
        unsafe fn run<const FORCED: bool, const LES: bool, const SINGLE: bool>(
            sweep: &Sweep<<$lanes as Lanes>::Scalar>,
            lines: Range<usize>,
            places: &[*mut <$lanes as Lanes>::Scalar; Q],
            constants: &Constants<$lanes>,
            sums: &mut Sums<$lanes>,
        ) {
            // SAFETY: by contract.
            unsafe {
                collide_run::<$lanes, FORCED, LES, SINGLE>(sweep, lines, places, constants, sums)
            }
        }
    };
    (choose, $relaxation:expr) => {{
        let r = $relaxation;
        match (r.acceleration != [0.0; 3], r.smagorinsky != 0.0, r.magic.is_none()) {
            (false, false, false) => run::<false, false, false>,
            (false, false, true) => run::<false, false, true>,
            (false, true, false) => run::<false, true, false>,
            (false, true, true) => run::<false, true, true>,
            (true, false, _) => run::<true, false, false>,
            (true, true, false) => run::<true, true, false>,
            (true, true, true) => run::<true, true, true>,
        }
    }};
}
kernels!(f64, Portable<f64, 2>, Avx2F64, Avx512F64);
kernels!(f32, Portable<f32, 4>, Avx2F32, Avx512F32);

/// The body of every kernel. See [`Kernel`] for the contract.
#[inline(always)]
unsafe fn work<V: Lanes>(
    sweep: &Sweep<V::Scalar>,
    number: usize,
    block: &mut Block,
    run: RunKernel<V>,
) {
    // SAFETY: by contract.
    block.survey = unsafe { sweep_lines::<V>(sweep, block.lines.clone(), run) };
    // SAFETY: by contract; the block's cells have collided, and their reflecting links are in
    // places of their own.
    unsafe { sweep.tally.sum::<V>(sweep.field, sweep.fluid, number, &mut block.reflected) };
}

/// Collides and streams lines, in runs within which the places of a line follow those of the line before.
#[inline(always)]
unsafe fn sweep_lines<V: Lanes>(
    sweep: &Sweep<V::Scalar>,
    lines: Range<usize>,
    run: RunKernel<V>,
) -> Survey {
    // SAFETY: by contract.
    let constants = unsafe { Constants::<V>::new(sweep.relaxation) };
    // SAFETY: by contract.
    let mut sums = unsafe { Sums::<V>::new() };
    let base = sweep.field.base();
    if sweep.parity == Parity::Even {
        let first = lines.start * V::Scalar::LINE;
        let stride = sweep.places.stride();
        let places = std::array::from_fn(|i| base.wrapping_add(i * stride + first));
        // SAFETY: these are the first line's own places in even steps.
        unsafe { run(sweep, lines, &places, &constants, &mut sums) };
    } else {
        let mut scratch = Scratch([[V::Scalar::from_f64(0.0); 16]; Q]);
        let (mut start, mut asked) = (lines.start, lines.start);
        while start < lines.end {
            let end = sweep.places.run_end(start, lines.end);
            let soon = (end + PIECES_AHEAD).min(lines.end);
            (asked.max(end)..soon).for_each(|line| ask_for_pieces(sweep, line));
            asked = soon;
            let entries = &sweep.places.lines()[start];
            let mut places = [base.wrapping_add(start * V::Scalar::LINE); Q];
            let mut i = 1;
            while i < Q {
                places[i] = base.wrapping_add(entries[i] as usize);
                i += 1;
            }
            // SAFETY: these are the first line's own places in odd steps, and those of the others follow. A line that has
            // some in pieces is a run of its own: these are collected in the scratch and written back, lane by lane.
            unsafe {
                if !sweep.places.kind(start).is_in_pieces() {
                    run(sweep, start..end, &places, &constants, &mut sums);
                } else if line_bits::<V>(sweep.fluid, start) != 0 {
                    gather::<V>(sweep, start, &mut places, &mut scratch);
                    run(sweep, start..end, &places, &constants, &mut sums);
                    scatter::<V>(sweep, start, &scratch);
                }
            }
            start = end;
        }
    }
    // SAFETY: by contract.
    unsafe { sums.survey() }
}

/// Room for a line in each direction.
#[repr(align(64))]
struct Scratch<T>([[T; 16]; Q]);

/// Does some work with the pieces of each direction of a line that is in pieces.
macro_rules! of_pieces {
    ($sweep:ident, $line:ident, |$pieces:ident| $work:block) => {
        let kind = $sweep.places.kind($line);
        // SAFETY: the table's lines point to pieces of its own; so many are there as is said here.
        let mut rest = unsafe { $sweep.places.pieces().get_unchecked(kind.first as usize..) };
        of_pieces!(rest, kind.two, 2, |$pieces| $work);
        of_pieces!(rest, kind.three, 3, |$pieces| $work);
        for _ in 0..kind.others {
            let $pieces;
            ($pieces, rest) =
                rest.split_at(rest.iter().take_while(|piece| !piece.last).count() + 1);
            $work
        }
    };
    ($rest:ident, $times:expr, $count:literal, |$pieces:ident| $work:block) => {
        for _ in 0..$times {
            let $pieces;
            // SAFETY: as above.
            ($pieces, $rest) = unsafe { $rest.split_at_unchecked($count) };
            $work
        }
    };
}

/// Lines after a run whose pieces are asked for before it. Lines in one piece need no such help: the lines before ask
/// for what follows their own places.
const PIECES_AHEAD: usize = 4;

/// Asks memory for what a line will collect from pieces.
#[inline(always)]
fn ask_for_pieces<T: Real>(sweep: &Sweep<T>, line: usize) {
    // The table itself is read first here.
    prefetch(sweep.places.lines().as_ptr().wrapping_add(line + 4 * PIECES_AHEAD));
    of_pieces!(sweep, line, |pieces| {
        prefetch(pieces.as_ptr().wrapping_add(64));
        for piece in pieces {
            let lane = piece.lanes.trailing_zeros() as usize;
            prefetch(sweep.field.base().wrapping_add(piece.place as usize + lane));
        }
    });
}

/// Collects the directions of a line that are in pieces, and lets their places point there.
///
/// # Safety
/// As for [`Kernel`]; the line is one of the sweep.
#[inline(always)]
unsafe fn gather<V: Lanes>(
    sweep: &Sweep<V::Scalar>,
    line: usize,
    places: &mut [*mut V::Scalar; Q],
    scratch: &mut Scratch<V::Scalar>,
) {
    let base = sweep.field.base();
    of_pieces!(sweep, line, |pieces| {
        let i = usize::from(pieces[0].dir);
        places[i] = scratch.0[i].as_mut_ptr();
        // Lines after this go on from one of them.
        for piece in pieces {
            prefetch(base.wrapping_add(piece.place as usize + AHEAD * V::Scalar::LINE));
        }
        let mut x = 0;
        while x < V::Scalar::LINE {
            // SAFETY: by contract; the lanes of a piece are places of the field.
            unsafe {
                let mut v = V::splat(0.0);
                for piece in pieces {
                    let lanes = u32::from(piece.lanes) >> x & all_lanes::<V>();
                    let from = base.wrapping_add(piece.place as usize + x);
                    v = v.load_lanes(from, V::mask(lanes));
                }
                v.store(places[i].add(x));
            }
            x += V::N;
        }
    });
}

/// Writes the directions of a line that are in pieces from where [`gather`] had put them.
///
/// # Safety
/// As for [`gather`].
#[inline(always)]
unsafe fn scatter<V: Lanes>(sweep: &Sweep<V::Scalar>, line: usize, scratch: &Scratch<V::Scalar>) {
    let base = sweep.field.base();
    of_pieces!(sweep, line, |pieces| {
        let i = usize::from(pieces[0].dir);
        let mut x = 0;
        while x < V::Scalar::LINE {
            // SAFETY: by contract.
            unsafe {
                let v = V::load(scratch.0[i].as_ptr().add(x));
                for piece in pieces {
                    let lanes = u32::from(piece.lanes) >> x & all_lanes::<V>();
                    let to = base.wrapping_add(piece.place as usize + x);
                    v.store_lanes(to, lanes);
                }
            }
            x += V::N;
        }
    });
}

/// Lines that are measured before the first of them relaxes. Relaxation waits for a chain of sums, a quotient and
/// roots; a processor whose window of instructions one vector fills would wait with it, and measures other vectors in the
/// meantime instead. Registers that hold a whole line make half as many instructions, which leave room in the window.
const fn lines_together<V: Lanes>() -> usize {
    if V::N == V::Scalar::LINE { 1 } else { 4 }
}

/// Vectors of so many lines at most.
const VECTORS: usize = 32;

/// What vectors relax to, and how fast those do that have rates of their own.
struct Measured<V> {
    targets: [MaybeUninit<Target<V>>; VECTORS],
    rates: [MaybeUninit<Rates<V>>; VECTORS],
}

/// Collides lines that follow each other, the first of them at `places`, a vector at a time. Vectors without fluid
/// are left alone; lanes without fluid become zero, which is a fluid at rest, so that nothing odd can grow inside
/// solids.
///
/// # Safety
/// As for [`Kernel`]; so many lines of numbers may be read and written from each place on, and in lanes of cells
/// these belong to the line.
#[inline(always)]
unsafe fn collide_run<V: Lanes, const FORCED: bool, const LES: bool, const SINGLE: bool>(
    sweep: &Sweep<V::Scalar>,
    lines: Range<usize>,
    places: &[*mut V::Scalar; Q],
    k: &Constants<V>,
    sums: &mut Sums<V>,
) {
    const { assert!(lines_together::<V>() * V::Scalar::LINE <= VECTORS * V::N) };
    let mut measured = Measured {
        targets: [MaybeUninit::uninit(); VECTORS],
        rates: [MaybeUninit::uninit(); VECTORS],
    };
    let first = lines.start;
    let mut start = first;
    while start < lines.end {
        let end = lines.end.min(start + lines_together::<V>());
        let some = Lines { sweep, places, first, lines: [start, end] };
        // SAFETY: by contract; what is relaxed was measured.
        unsafe {
            measure_lines::<V, FORCED, LES, SINGLE>(some, k, sums, &mut measured);
            relax_lines::<V, FORCED, LES, SINGLE>(some, k, &measured);
        }
        start = end;
    }
}

/// Some lines of a run.
#[derive(Clone, Copy)]
struct Lines<'a, T: Real> {
    sweep: &'a Sweep<'a, T>,
    /// Where the run's first line is, and which that is.
    places: &'a [*mut T; Q],
    first: usize,
    /// The first of the lines, and the one after the last.
    lines: [usize; 2],
}

impl<T: Real> Lines<'_, T> {
    /// How far the first of the lines is from the run's, and the one after the last.
    #[inline(always)]
    fn reach(&self) -> [usize; 2] {
        [(self.lines[0] - self.first) * T::LINE, (self.lines[1] - self.first) * T::LINE]
    }
}

/// Measures lines of a run, see [`collide_run`].
#[inline(always)]
unsafe fn measure_lines<V: Lanes, const FORCED: bool, const LES: bool, const SINGLE: bool>(
    some: Lines<V::Scalar>,
    k: &Constants<V>,
    sums: &mut Sums<V>,
    measured: &mut Measured<V>,
) {
    let Lines { sweep, places, first, .. } = some;
    let [mut at, end] = some.reach();
    let mut vector = 0;
    while at < end {
        let (line, x) = (first + at / V::Scalar::LINE, at % V::Scalar::LINE);
        let bits = line_bits::<V>(sweep.fluid, line);
        if x == 0 && bits != 0 {
            ask_ahead(places, at);
        }
        let lanes = bits >> x & all_lanes::<V>();
        if lanes != 0 {
            // SAFETY: by contract; there is room for all vectors of the lines.
            unsafe {
                let mut flow = measure::<V, FORCED, LES, SINGLE>(places, at, k);
                measured.targets.get_unchecked_mut(vector).write(flow.target);
                if LES {
                    measured.rates.get_unchecked_mut(vector).write(flow.rates);
                }
                if lanes != all_lanes::<V>() {
                    flow = flow.keep(V::mask(lanes));
                }
                sums.add::<LES>(x, &flow);
                let drho = sweep.wanted.room(line);
                if !drho.is_null() {
                    flow.drho.store(drho.add(x));
                }
            }
        }
        if x + V::N == V::Scalar::LINE && bits != 0 {
            sums.end_line();
        }
        at += V::N;
        vector += 1;
    }
}

/// Relaxes lines of a run that were measured, see [`collide_run`].
#[inline(always)]
unsafe fn relax_lines<V: Lanes, const FORCED: bool, const LES: bool, const SINGLE: bool>(
    some: Lines<V::Scalar>,
    k: &Constants<V>,
    measured: &Measured<V>,
) {
    let Lines { sweep, places, first, .. } = some;
    let [mut at, end] = some.reach();
    let mut vector = 0;
    while at < end {
        let (line, x) = (first + at / V::Scalar::LINE, at % V::Scalar::LINE);
        let lanes = line_bits::<V>(sweep.fluid, line) >> x & all_lanes::<V>();
        if lanes != 0 {
            // SAFETY: by contract; the vector was measured.
            unsafe {
                let target = measured.targets.get_unchecked(vector).assume_init_ref();
                let rates = if LES {
                    measured.rates.get_unchecked(vector).assume_init()
                } else {
                    k.rates()
                };
                let (to, mask) = ((target, &rates), V::mask(lanes));
                if lanes == all_lanes::<V>() {
                    relax::<V, FORCED, LES, SINGLE, true>(places, at, mask, to, k);
                } else {
                    relax::<V, FORCED, LES, SINGLE, false>(places, at, mask, to, k);
                }
            }
        }
        at += V::N;
        vector += 1;
    }
}

/// The bits of all lanes of a vector.
const fn all_lanes<V: Lanes>() -> u32 {
    u32::MAX >> (32 - V::N)
}

/// Which cells of a line are fluid.
#[inline(always)]
fn line_bits<V: Lanes>(fluid: &[u8], line: usize) -> u32 {
    if V::Scalar::LINE == 8 {
        u32::from(fluid[line])
    } else {
        u32::from(fluid[2 * line]) | u32::from(fluid[2 * line + 1]) << 8
    }
}
