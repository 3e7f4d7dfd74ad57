//! Impulse that walls and mirrors give to the fluid by reflecting it.
//!
//! Reflection half-way and at mirrors costs no work: the places of the populations see to it. The
//! momentum that it takes is `2 c_i f_i` at a wall and `(c_i - c_m(i)) f_i` at a mirror for each
//! reflected population `f_i`, in deviations from the fluid at rest. They are added up by block of
//! cells, directly after the block's collision; those at mirrors that another block's collision may
//! leave, when all blocks are done.

use crate::lattice::aa_pattern::Reflection;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C_F64, OPPOSITE, mirrored};
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::{Field, Real};
use std::ops::Range;

/// Reflecting links of a block that share direction and fixture.
#[derive(Clone, Debug)]
pub struct ReflectionRun {
    /// Whom they meet.
    pub fixture: BoundaryId,
    /// True if it is a mirror.
    pub is_mirror: bool,
    /// True if another block's collision may leave what is reflected.
    pub is_late: bool,
    /// Momentum to the fluid for each unit of the reflected populations.
    pub impulse: [f64; 3],
    items: Range<usize>,
}

/// Reflecting links of one line.
#[derive(Clone, Copy, Debug)]
struct Item {
    place: u32,
    line: u32,
    /// The cell in whose plane the place of the first lane is: the line's own first at a wall.
    other: i32,
    lanes: u16,
}

/// All reflecting links, by block.
#[derive(Clone, Debug, Default)]
pub struct ReflectionImpulse {
    items: Vec<Item>,
    runs: Vec<ReflectionRun>,
    /// For each block its runs.
    blocks: Vec<Range<usize>>,
}

impl ReflectionImpulse {
    /// Of links sorted by line, for blocks of lines of `line` cells.
    pub fn new(reflections: &[Reflection], blocks: &[Range<usize>], line: usize) -> Self {
        let mut tally = Self::default();
        let mut rest = reflections;
        let mut own = Vec::new();
        for block in blocks {
            let count = rest.partition_point(|r| (r.line as usize) < block.end);
            own.clear();
            own.extend_from_slice(&rest[..count]);
            rest = &rest[count..];
            let cells = (block.start * line) as i32..=((block.end - 1) * line) as i32;
            let is_late = |r: &Reflection| r.mirrors != 0 && !cells.contains(&r.mirror_cell);
            let kind = |r: &Reflection| (r.mirrors, is_late(r), r.fixture, r.dir);
            own.sort_by_key(|r| (kind(r), r.line, r.place));
            let first = tally.runs.len();
            for group in own.chunk_by(|a, b| kind(a) == kind(b)) {
                tally.add_run(group, is_late(&group[0]));
            }
            tally.blocks.push(first..tally.runs.len());
        }
        tally
    }

    fn add_run(&mut self, group: &[Reflection], is_late: bool) {
        let Reflection { dir, mirrors, fixture, .. } = group[0];
        let i = usize::from(dir);
        let out = if mirrors == 0 { OPPOSITE[i] } else { mirrored(i, mirrors) };
        let first = self.items.len();
        self.items.extend(group.iter().map(|r| Item {
            place: r.place,
            line: r.line,
            other: r.mirror_cell,
            lanes: r.lanes,
        }));
        self.runs.push(ReflectionRun {
            fixture,
            is_mirror: mirrors != 0,
            is_late,
            impulse: std::array::from_fn(|a| C_F64[i][a] - C_F64[out][a]),
            items: first..self.items.len(),
        });
    }

    /// True if any link has to wait for all blocks.
    pub fn is_late(&self) -> bool {
        self.runs.iter().any(|run| run.is_late)
    }

    /// The runs of a block.
    pub fn runs(&self, block: usize) -> &[ReflectionRun] {
        &self.runs[self.blocks[block].clone()]
    }

    /// Adds up the reflected populations that a block's collision leaves, for each run of it, as
    /// deviations from rest, of cells that are fluid.
    ///
    /// # Safety
    /// The processor has the variant's instructions; field and bits are those of the cells that the
    /// tally was made for; no other thread writes to the places.
    #[inline(always)]
    pub unsafe fn sum<V: LatticeVector>(
        &self,
        field: &Field<V::Scalar>,
        fluid: &[u8],
        block: usize,
        sums: &mut [f64],
    ) {
        for (run, sum) in self.runs(block).iter().zip(sums) {
            if run.is_late {
                continue;
            }
            let mut lanes_sum = [0.0; 16];
            for item in &self.items[run.items.clone()] {
                let line = item.line as usize * V::Scalar::LINE;
                let mut lanes = u32::from(item.lanes) & bits_at::<V::Scalar>(fluid, line as i32);
                if run.is_mirror {
                    lanes &= bits_at::<V::Scalar>(fluid, item.other);
                }
                let mut x = 0;
                while x < V::Scalar::LINE {
                    // SAFETY: by contract; the lanes of an item are places of the field.
                    unsafe {
                        let mask = V::mask(lanes >> x & (u32::MAX >> (32 - V::N)));
                        let from = field.base().wrapping_add(item.place as usize + x);
                        V::splat(0.0).load_lanes(from, mask).add_to(lanes_sum.as_mut_ptr().add(x));
                    }
                    x += V::N;
                }
            }
            *sum = lanes_sum.iter().sum();
        }
    }

    /// The same for the others, once all cells have collided.
    pub fn sum_late<T: Real>(
        &self,
        field: &Field<T>,
        fluid: &[u8],
        block: usize,
        sums: &mut [f64],
    ) {
        for (run, sum) in self.runs(block).iter().zip(sums).filter(|(run, _)| run.is_late) {
            *sum = 0.0;
            for item in &self.items[run.items.clone()] {
                let line = (item.line as usize * T::LINE) as i32;
                let both = bits_at::<T>(fluid, line) & bits_at::<T>(fluid, item.other);
                let mut lanes = u32::from(item.lanes) & both;
                while lanes != 0 {
                    *sum += field.get(item.place as usize + lanes.trailing_zeros() as usize);
                    lanes &= lanes - 1;
                }
            }
        }
    }

    /// Adds the impulse of a block's runs at mirrors to the face's in `mirrors`, `2 axis + side`, along its axis,
    /// into the fluid; and calls `at_fixture` with that of each other run.
    pub fn share(
        &self,
        block: usize,
        reflected: &[f64],
        mirrors: &mut [[ExactSum; 3]; 6],
        mut at_fixture: impl FnMut(BoundaryId, [f64; 3]),
    ) {
        for (run, &sum) in self.runs(block).iter().zip(reflected) {
            if !run.is_mirror {
                at_fixture(run.fixture, run.impulse.map(|impulse| impulse * sum));
                continue;
            }
            for axis in 0..3 {
                let impulse = run.impulse[axis];
                mirrors[2 * axis + usize::from(impulse < 0.0)][axis].add(impulse * sum);
            }
        }
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.items.as_slice()) + size_of_val(self.runs.as_slice())
    }
}

/// Bits of the fluid cells among the `LINE` cells from `cell` on.
#[inline(always)]
fn bits_at<T: Real>(fluid: &[u8], cell: i32) -> u32 {
    let byte = |k: usize| fluid.get(k).map_or(0, |&b| u32::from(b));
    let (first, before) = (cell.max(0) as usize, (-cell).max(0));
    let bits = byte(first / 8) | byte(first / 8 + 1) << 8 | byte(first / 8 + 2) << 16;
    bits >> (first % 8) << before & (u32::MAX >> (32 - T::LINE))
}
