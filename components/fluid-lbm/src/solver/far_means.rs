//! The density of cells that join the fluid far from any: inside a body that vanished, or in the middle of a gap that
//! opens. It is that of the nearest fluid, which another rank may have.

use crate::boundary::refill::{NearestFluid, PreCollision};
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::exact_sum::{ExactSum, LIMBS};
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::solver::execution::Execution;
use std::collections::BTreeMap;
use tremie_team::Cut;

/// A cell that looks for fluid.
#[derive(Clone, Copy, Debug)]
pub struct FarCell {
    /// Its number here.
    pub cell: u32,
    /// Cells along an axis up to which it looks.
    pub farthest: i32,
}

/// A cell that some rank asks for.
#[derive(Clone, Copy, Debug)]
struct Asked {
    at: [i32; 3],
    farthest: i32,
    /// The nearest fluid that this rank counts.
    found: Option<NearestFluid>,
}

/// Mean density minus 1 of the nearest fluid, by cell, of all cells that look for some, on any rank, and are stored here.
pub fn far_means<T: Real>(
    before: &PreCollision<'_, T>,
    flags: &CellFlags,
    numbers: &WholeNumbers,
    cells: impl Iterator<Item = FarCell>,
    exec: &mut Execution,
) -> BTreeMap<u32, f64> {
    let layout = before.layout;
    let own: Vec<FarCell> = cells.filter(|far| layout.is_own(far.cell)).collect();
    let mut count = [own.len() as i64];
    exec.ranks.count(&mut count);
    if count == [0] {
        return BTreeMap::new();
    }
    let telling = |far: &FarCell| {
        let [x, y, z] = layout.at(far.cell).map(i64::from);
        [numbers.in_whole(far.cell).into(), x, y, z, far.farthest.into()]
    };
    let told = exec.ranks.collect(&own.iter().flat_map(telling).collect::<Vec<i64>>());
    let asked = |told: &[i64]| Asked {
        at: std::array::from_fn(|a| told[1 + a] as i32),
        farthest: told[4] as i32,
        found: None,
    };
    let mut all: Vec<Asked> = told.chunks_exact(5).map(asked).collect();
    exec.team.for_pieces(Cut::every(&mut all, 1), |_, asked: &mut [Asked]| {
        let Asked { at, farthest, found } = &mut asked[0];
        let mut reaches = 2..=*farthest;
        *found = reaches.find_map(|reach| before.fluid_at(flags, *at, reach));
    });
    let mut nearest: BTreeMap<i64, NearestFluid> = BTreeMap::new();
    for (number, found) in answers(&all, exec) {
        nearest.entry(number).and_modify(|own| own.join(&found)).or_insert(found);
    }
    let mean = |(number, found): (i64, NearestFluid)| {
        Some((numbers.here(told[5 * number as usize] as u32)?, found.mean()))
    };
    nearest.into_iter().filter_map(mean).collect()
}

/// What all ranks found, with the number of the cell among all that are asked for.
fn answers(all: &[Asked], exec: &mut Execution) -> Vec<(i64, NearestFluid)> {
    let telling = |(number, asked): (i64, &Asked)| {
        let NearestFluid { reach, drho, count } = asked.found?;
        Some([number, reach.into(), count].into_iter().chain(drho.limbs()))
    };
    let own: Vec<i64> = (0..).zip(all).filter_map(telling).flatten().collect();
    let told = exec.ranks.collect(&own);
    let found = |told: &[i64]| {
        let drho = ExactSum::from_limbs(std::array::from_fn(|k| told[3 + k]));
        (told[0], NearestFluid { reach: told[1] as i32, drho, count: told[2] })
    };
    told.chunks_exact(3 + LIMBS).map(found).collect()
}
