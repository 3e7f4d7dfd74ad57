//! Bodies that lie across a reservoir's face, and what they mean to the reservoir.
//!
//! What a piston displaces is slurry: fluid and bodies that enter the domain have its volume together.
//! The cylinder counts all of it as fluid.
//!
//! A body that appears in the domain needs no account. It comes from the reservoir, and the fluid whose
//! place it takes goes there: as much leaves the cylinder as comes back, and the flow through the face
//! stays the piston's. (To give that fluid back to the cylinder would let it enter again, on top of the
//! piston's flow.) A body that vanishes is the same the other way round.
//!
//! One that moves in through the face pushes the fluid before it out of the domain, through the face into
//! the cylinder, so the body itself has to leave there; and the other way round for one that moves out:
//!
//! ```text
//! M -= mass of the cells that it covers - mass of those that it uncovers
//! ```
//!
//! Spheres alone are counted. A part that stands still lets no body pass.

use crate::bodies::body_list::Bodies;
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::open_boundaries::OpenBoundaries;

/// Faces that can have a reservoir.
const FACES: usize = 6;

/// Lets reservoirs lose what bodies across their faces have covered or cut off in this step, and gain
/// what these have uncovered. Returns true if there were such bodies.
pub fn count_crossing<T: Real>(
    faces: &mut OpenBoundaries<T>,
    bodies: &Bodies,
    gaps: &GapModel,
    lattice: &LatticeState<T>,
    ranks: &mut Ranks,
) -> bool {
    if faces.reservoirs.is_empty() {
        return false;
    }
    let (flags, before) = (&lattice.flags, lattice.before());
    let covered = flags.covered.iter().chain(&flags.enclosed);
    let covered = covered.map(|&cell| (cell, gaps.holder_of(lattice, bodies, cell), -1.0));
    let uncovered = flags.vacated.iter().map(|vacated| (vacated.cell, Some(vacated.handle), 1.0));
    let (mut taken, mut cells) = ([ExactSum::default(); FACES], [0]);
    let own = |cell: u32| lattice.layout.is_own(cell);
    for (cell, holder, sign) in covered.chain(uncovered).filter(|(cell, ..)| own(*cell)) {
        let Some(body) = holder.and_then(|handle| bodies.find_living(handle)) else { continue };
        // The radius of a part reaches to its farthest point, which says nothing of a face beside it.
        if body.is_part() || bodies.newcomers.contains(&body.handle) {
            continue;
        }
        let across = faces.crossed_by(body.position, body.radius, &lattice.layout.grid);
        if let Some(face) = across {
            taken[face].add(sign * (1.0 + before.content(cell).drho));
            cells[0] += 1;
        }
    }
    ranks.add_up(&mut taken);
    ranks.count(&mut cells);
    for (face, mass) in faces.reservoirs.iter_mut().zip(taken) {
        face.take_back(mass.value());
    }
    cells[0] > 0
}
