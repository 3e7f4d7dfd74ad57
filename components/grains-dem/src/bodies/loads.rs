//! Loads of the fluid, taken in the order of ids into the order of memory.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, Wrench};
use crate::bodies::message_order::MessageOrder;
use crate::math::error::GrainsError;
use tremie_grains_kit::checks::loads::LoadError;
use tremie_messages::body::Load;
use tremie_team::{Cut, Team};

/// Result of one block of loads: the sum of the forces on free bodies [N], or the error of the
/// first load that is not valid.
type LoadSum = Result<Vec3, GrainsError>;

/// Takes the loads of a window, one for each body of `roll`, and gives the sum of the forces on
/// free spheres [N]. `sums` is room to work in.
///
/// # Errors
/// Loads that do not match the bodies or are not finite.
pub(crate) fn take(
    team: &mut Team,
    bodies: &mut Bodies,
    loads: &[Load],
    roll: MessageOrder,
    sums: &mut Vec<LoadSum>,
) -> Result<Vec3, GrainsError> {
    let expected = roll.bodies(bodies);
    LoadError::check_count(loads, expected)?;
    sums.clear();
    sums.resize_with(loads.len().div_ceil(BLOCK), || Ok(Vec3::zeros()));
    let (slot, mobility, all) = (&bodies.slot, &bodies.mobility, &*bodies);
    team.for_each(sums, |b, sum| {
        *sum = (b * BLOCK..loads.len().min((b + 1) * BLOCK)).try_fold(Vec3::zeros(), |sum, k| {
            LoadError::check(k, &loads[k], roll.id(k, all))?;
            let slot = roll.rank(k).map(|rank| slot[rank] as usize);
            let free = slot.is_some_and(|slot| mobility[slot].is_free());
            Ok(if free { sum + Vec3::from(loads[k].force) } else { sum })
        });
    });
    // In the order of blocks: equal bits on any number of threads.
    let mut force = Vec3::zeros();
    for sum in sums.drain(..) {
        force += sum?;
    }
    // Loads come in the order of ids, and are stored in that of memory.
    let rank = &bodies.rank;
    team.for_pieces(Cut::every(&mut bodies.load, BLOCK), |b, own: &mut [Wrench]| {
        for (own, &rank) in own.iter_mut().zip(&rank[b * BLOCK..]) {
            let load = &loads[roll.place(rank as usize)];
            *own = Wrench { force: load.force.into(), torque: load.torque.into() };
        }
    });
    Ok(force)
}
