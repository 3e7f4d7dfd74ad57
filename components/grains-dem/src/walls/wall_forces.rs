//! Contact forces of walls on all bodies near them.

use crate::bodies::body_arrays::{BoundingSphere, Twist, Wrench};
use crate::contact::contact_force::{self, Contact};
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::{Other, Tally};
use crate::walls::wall_contacts::{WallContacts, WallEntry};
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_team::{Cut, Team};

/// The contact of a sphere with a wall, and the distance of its point from the centre.
#[inline(always)]
pub(crate) fn touch_of_wall(ball: &BoundingSphere, twist: &Twist, wall: &Wall) -> (Contact, f64) {
    let overlap = wall.overlap(ball);
    let normal = -wall.normal;
    let arm = ball.radius - 0.5 * overlap;
    let contact = Contact {
        normal,
        overlap,
        velocity: (twist.v - wall.velocity) + twist.w.cross(&normal) * arm,
        twist: 0.5 * twist.w.dot(&normal),
        rolling: twist.w,
    };
    (contact, arm)
}

/// Evaluates the contacts with walls, and adds the contacts of each block to `tallies`.
pub(crate) fn evaluate(
    team: &mut Team,
    list: &mut WallContacts,
    walls: &[Wall],
    scenery: ContactContext<'_>,
    tallies: &mut [Tally],
) {
    let pieces = (
        Cut::at(&mut list.rows.entries, &list.rows.entry_bounds),
        Cut::at(&mut list.rows.on.wrench, &list.rows.on.bounds),
        Cut::every(tallies, 1),
    );
    let (bodies, start, bounds) = (&list.rows.on.bodies, &list.rows.start, &list.rows.on.bounds);
    team.for_pieces(pieces, |b, (entries, wrench, tally)| {
        let mut entries = entries.iter_mut();
        for (p, wrench) in (bounds[b] as usize..).zip(wrench) {
            *wrench = Wrench::zero();
            let count = (start[p + 1] - start[p]) as usize;
            for entry in entries.by_ref().take(count) {
                of_wall(entry, walls, bodies[p] as usize, &scenery, wrench, &mut tally[0]);
            }
        }
    });
}

fn of_wall(
    entry: &mut WallEntry,
    walls: &[Wall],
    i: usize,
    scenery: &ContactContext<'_>,
    wrench: &mut Wrench,
    tally: &mut Tally,
) {
    let ball = &scenery.bodies.balls[i];
    let predicted = &scenery.bodies.predicted[i];
    let (contact, arm) = touch_of_wall(ball, predicted, &walls[entry.wall as usize]);
    let law = &scenery.laws[entry.law as usize];
    let holds = law.holds(contact.overlap, entry.reduced, entry.touching);
    let touched = std::mem::replace(&mut entry.touching, holds);
    let n = contact.normal;
    let squeezed = n * scenery.lubrication(&contact, entry.reduced);
    wrench.force -= squeezed;
    entry.force = squeezed;
    if !holds {
        return;
    }
    let (memory, steps) = (&mut entry.memory, scenery.steps);
    let f = contact_force::force(law, entry.reduced, &contact, memory, touched, steps);
    let touch = f.tangential - n * f.normal;
    wrench.force += touch;
    entry.force -= touch;
    wrench.torque += n.cross(&f.tangential) * arm + f.rolling;
    tally.add(contact.overlap / ball.radius, i as u32, Other::Wall(entry.wall));
}
