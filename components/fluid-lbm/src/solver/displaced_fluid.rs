//! The fluid that bodies displace when they appear in the middle of a run.
//!
//! It goes back to the reservoir whose face is nearest: so what enters there in the mean, bodies
//! and fluid together, is what the piston displaces. Without a reservoir it is lost, as the ledger
//! says.

use crate::bodies::body_list::Bodies;
use crate::lattice::populations::Real;
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::open_boundaries::OpenBoundaries;

/// Gives reservoirs the mass of the cells that newcomers have covered or cut off in this step.
pub fn return_displaced<T: Real>(
    faces: &mut OpenBoundaries<T>,
    bodies: &mut Bodies,
    gaps: &GapModel,
    lattice: &LatticeState<T>,
) {
    if !faces.reservoirs.is_empty() && !bodies.newcomers.is_empty() {
        for &cell in lattice.flags.covered.iter().chain(&lattice.flags.enclosed) {
            let holder = gaps.holder_of(lattice, bodies, cell);
            let newcomer = holder.filter(|handle| bodies.newcomers.contains(handle));
            let Some(body) = newcomer.and_then(|handle| bodies.living_with_handle(handle)) else {
                continue;
            };
            let mass = 1.0 + lattice.before().content(cell).drho;
            faces.take_back(body.position, mass, &lattice.layout.grid);
        }
    }
    bodies.newcomers.clear();
}
