//! The collision of lines that follow each other.

use crate::lattice::aa_row_ends::{self, AtEnd};
use crate::lattice::aa_rows::{RowEnd, Way};
use crate::lattice::collision::operators::CollisionOperator;
use crate::lattice::collision::{
    After, Constants, Equilibrium, Moments, Populations, RelaxationRates, ask_ahead, measure, relax,
};
use crate::lattice::collision_kernel::{Sweep, all_lanes, line_bits};
use crate::lattice::d3q19::Q;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::Real;
use crate::lattice::reductions::{Held, StatisticsSums};
use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{Ordering::SeqCst, compiler_fence};

/// Lines whose places follow each other.
pub struct LineRun<T> {
    /// Numbers of the lines.
    pub lines: Range<usize>,
    /// Places of the populations of the first line.
    pub places: [*mut T; Q],
    /// True if there may be ends of rows among them.
    has_ends: bool,
}

impl<T: Real> LineRun<T> {
    /// Lines in even steps.
    #[inline(always)]
    pub fn even(sweep: &Sweep<T>, lines: Range<usize>) -> Self {
        let first = sweep.field.base().wrapping_add(lines.start * T::LINE);
        let stride = sweep.places.stride();
        let places = std::array::from_fn(|i| first.wrapping_add(i * stride));
        Self { lines, places, has_ends: false }
    }

    /// Lines whose places are whole in odd steps.
    #[inline(always)]
    pub fn odd(sweep: &Sweep<T>, lines: Range<usize>) -> Self {
        let base = sweep.field.base();
        let mut places =
            sweep.places.lines()[lines.start].map(|entry| base.wrapping_add(entry as usize));
        places[0] = base.wrapping_add(lines.start * T::LINE);
        Self { lines, places, has_ends: true }
    }

    /// A line in odd steps; whoever calls this lets places of directions in pieces point to where
    /// these were collected.
    #[inline(always)]
    pub fn collected(sweep: &Sweep<T>, line: usize) -> Self {
        Self { has_ends: false, ..Self::odd(sweep, line..line + 1) }
    }

    /// Distance of a line from the first [numbers].
    #[inline(always)]
    fn reach(&self, line: usize) -> usize {
        (line - self.lines.start) * T::LINE
    }
}

/// Collides lines that follow each other, a vector at a time. Vectors without fluid are left alone;
/// lanes without fluid become zero, which is a fluid at rest, so that nothing odd can grow inside
/// solids.
///
/// # Safety
/// As for [`crate::lattice::collision_kernel::Kernel`]; so many lines of numbers may be read and
/// written from each place on, and in lanes of cells these belong to the line.
#[inline(always)]
pub unsafe fn collide<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    run: &LineRun<V::Scalar>,
    k: &Constants<V>,
    sums: &mut StatisticsSums<V>,
) {
    let mut held = sums.held();
    // SAFETY: by contract.
    unsafe {
        if V::N == V::Scalar::LINE {
            for line in run.lines.clone() {
                let lanes = line_bits::<V>(sweep.fluid, line);
                let reach = run.reach(line);
                let at = After(&run.places, reach);
                let mut row_end = None;
                if run.has_ends {
                    row_end = sweep.places.way(line).row_end;
                    if sweep.places.way(line + Way::AHEAD).row_end.is_some() {
                        aa_row_ends::ask(sweep, line + Way::AHEAD);
                    }
                }
                if lanes == 0 {
                    continue;
                }
                ask_ahead(&run.places, reach);
                let this = (line, lanes);
                match row_end {
                    None => {
                        collide_line::<V, O, FORCED>(sweep, this, &at, k, sums, &mut held);
                    }
                    Some(RowEnd::Lower) => {
                        let at = AtEnd::<V, false>::new(sweep, line, at);
                        collide_line::<V, O, FORCED>(sweep, this, &at, k, sums, &mut held);
                    }
                    Some(RowEnd::Upper) => {
                        let at = AtEnd::<V, true>::new(sweep, line, at);
                        collide_line::<V, O, FORCED>(sweep, this, &at, k, sums, &mut held);
                    }
                }
            }
        } else {
            let mut measured = Measured::new();
            let mut start = run.lines.start;
            while start < run.lines.end {
                let lines = start..run.lines.end.min(start + LINES_TOGETHER);
                start = lines.end;
                measure_lines::<V, O, FORCED>(
                    sweep,
                    run,
                    lines.clone(),
                    k,
                    sums,
                    &mut held,
                    &mut measured,
                );
                relax_lines::<V, O, FORCED>(sweep, run, lines, k, &measured);
            }
        }
    }
    sums.hold(&held);
}

/// Collides a line that is one vector, with fluid in some lanes.
///
/// # Safety
/// As for [`collide`].
#[inline(always)]
pub unsafe fn collide_line<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    (line, lanes): (usize, u32),
    populations: &impl Populations<V>,
    k: &Constants<V>,
    sums: &mut StatisticsSums<V>,
    held: &mut Held<V>,
) {
    // SAFETY: by contract.
    unsafe {
        let flow = measure_vector::<V, O, FORCED>(sweep, (line, 0, lanes), populations, k, held);
        sums.end_line(held);
        // The compiler is to read populations a second time: to keep all takes more registers than
        // there are.
        compiler_fence(SeqCst);
        relax_vector::<V, O, FORCED>(lanes, populations, (&flow.target, &flow.rates), k);
    }
}

/// Measures the vector `x` cells from the beginning of a line, with fluid in some lanes.
#[inline(always)]
unsafe fn measure_vector<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    (line, x, lanes): (usize, usize, u32),
    populations: &impl Populations<V>,
    k: &Constants<V>,
    held: &mut Held<V>,
) -> Moments<V, O::Stress<V>> {
    // SAFETY: by contract of [`collide`].
    unsafe {
        let mut flow = measure::<V, O, FORCED>(populations, k);
        if lanes != all_lanes::<V>() {
            flow = flow.keep(V::mask(lanes));
        }
        held.add(x, &flow, O::IS_LOCAL);
        let drho = sweep.wanted.room(line);
        if !drho.is_null() {
            flow.drho.store(drho.add(x));
        }
        flow
    }
}

/// Relaxes a vector with fluid in some lanes.
#[inline(always)]
unsafe fn relax_vector<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    lanes: u32,
    populations: &impl Populations<V>,
    to: (&Equilibrium<V, O::Stress<V>>, &RelaxationRates<V>),
    k: &Constants<V>,
) {
    // SAFETY: by contract of [`collide`].
    unsafe {
        let mask = V::mask(lanes);
        if lanes == all_lanes::<V>() {
            relax::<V, O, FORCED, true>(populations, mask, to, k);
        } else {
            relax::<V, O, FORCED, false>(populations, mask, to, k);
        }
    }
}

/// Lines that are measured before the first of them relaxes, where registers hold less than a line.
/// Relaxation waits for a chain of sums, a quotient and roots; a processor whose window of
/// instructions one vector fills would wait with it, and measures other vectors in the meantime
/// instead. Registers that hold a whole line make half as many instructions, which leave room in
/// the window.
const LINES_TOGETHER: usize = 4;

/// Vectors of so many lines at most.
const VECTORS: usize = 16;

/// Equilibria of the vectors, and rates of relaxation where each cell has its own.
struct Measured<V, S> {
    targets: [MaybeUninit<Equilibrium<V, S>>; VECTORS],
    rates: [MaybeUninit<RelaxationRates<V>>; VECTORS],
}

impl<V: LatticeVector, S: Copy> Measured<V, S> {
    fn new() -> Self {
        const { assert!(LINES_TOGETHER * V::Scalar::LINE <= VECTORS * V::N) };
        Self { targets: [MaybeUninit::uninit(); VECTORS], rates: [MaybeUninit::uninit(); VECTORS] }
    }
}

/// Measures lines of a run, see [`collide`].
#[inline(always)]
unsafe fn measure_lines<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    run: &LineRun<V::Scalar>,
    lines: Range<usize>,
    k: &Constants<V>,
    sums: &mut StatisticsSums<V>,
    held: &mut Held<V>,
    measured: &mut Measured<V, O::Stress<V>>,
) {
    let mut vector = 0;
    for line in lines {
        // SAFETY: by contract.
        let bits = unsafe { line_bits::<V>(sweep.fluid, line) };
        if bits != 0 {
            ask_ahead(&run.places, run.reach(line));
        }
        let mut x = 0;
        while x < V::Scalar::LINE {
            let lanes = bits >> x & all_lanes::<V>();
            if lanes != 0 {
                let at = After(&run.places, run.reach(line) + x);
                // SAFETY: by contract; there is room for all vectors of the lines.
                unsafe {
                    let flow =
                        measure_vector::<V, O, FORCED>(sweep, (line, x, lanes), &at, k, held);
                    measured.targets.get_unchecked_mut(vector).write(flow.target);
                    if O::IS_LOCAL {
                        measured.rates.get_unchecked_mut(vector).write(flow.rates);
                    }
                }
            }
            x += V::N;
            vector += 1;
        }
        if bits != 0 {
            sums.end_line(held);
        }
    }
}

/// Relaxes lines of a run that were measured, see [`collide`].
#[inline(always)]
unsafe fn relax_lines<V: LatticeVector, O: CollisionOperator, const FORCED: bool>(
    sweep: &Sweep<V::Scalar>,
    run: &LineRun<V::Scalar>,
    lines: Range<usize>,
    k: &Constants<V>,
    measured: &Measured<V, O::Stress<V>>,
) {
    let mut vector = 0;
    for line in lines {
        // SAFETY: by contract.
        let bits = unsafe { line_bits::<V>(sweep.fluid, line) };
        let mut x = 0;
        while x < V::Scalar::LINE {
            let lanes = bits >> x & all_lanes::<V>();
            if lanes != 0 {
                let at = After(&run.places, run.reach(line) + x);
                // SAFETY: by contract; the vector was measured.
                unsafe {
                    let target = measured.targets.get_unchecked(vector).assume_init_ref();
                    let rates = if O::IS_LOCAL {
                        measured.rates.get_unchecked(vector).assume_init()
                    } else {
                        k.rates
                    };
                    relax_vector::<V, O, FORCED>(lanes, &at, (target, &rates), k);
                }
            }
            x += V::N;
            vector += 1;
        }
    }
}
