//! Where a link that leaves the fluid meets a solid.

use crate::lattice::aa_pattern::Blocked;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C, mirrored};
use tremie_fluid_kit::cells::grid::Reach;
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;

/// Solid that a blocked link meets first, and `q`, the part of its length up to there; half-way
/// if it meets none.
pub fn meet(ground: &StaticGeometry, at: [i32; 3], blocked: &Blocked) -> (Blocked, f64) {
    let (grid, i) = (&ground.grid, usize::from(blocked.dir));
    let to = std::array::from_fn(|a| at[a] + C[i][a]);
    let (mut ways, mut count) = ([(at, to); 2], 1);
    if let Reach::Cell { at: end, mirrors } = grid.reach(to)
        && end != to
    {
        // As seen beyond the periodic face or in the mirror.
        let c = C[mirrored(i, mirrors)];
        (ways[1], count) = ((std::array::from_fn(|a| end[a] - c[a]), end), 2);
    }
    let mut first = (*blocked, f64::INFINITY);
    for (number, solid) in ground.solids.iter().enumerate() {
        for &(from, to) in &ways[..count] {
            if let Some(q) = solid.crossing(&ground.centres(), from, to)
                && q < first.1
            {
                first = (Blocked { fixture: BoundaryId::solid(number as u16), ..*blocked }, q);
            }
        }
    }
    if first.1.is_finite() { first } else { (*blocked, 0.5) }
}
