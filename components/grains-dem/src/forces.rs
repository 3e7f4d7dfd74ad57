//! Contact forces of all bodies: blocks of bodies at once, each contact once.

use crate::{
    Vec3,
    bodies::{Ball, Bodies, Twist, Wrench},
    contact::{self, Contact, Steps},
    law::{Law, Reduced},
    lubrication::Squeeze,
    pairs::{ACTING, BLOCK, Hit, Pairs, Record, Rolling, TOUCHING},
    tally::{Deepest, Other, Tally},
    wall_contacts::{WallContacts, WallEntry},
    walls::Wall,
};
use tremie_team::{Cut, Team};

/// The contact of two spheres with centres `d` apart. Its point lies half way between the two
/// surfaces; the overlap is negative where they do not touch.
#[inline(always)]
pub(crate) fn touch_of_balls(
    d: Vec3,
    radius_i: f64,
    radius_j: f64,
    i: &Twist,
    j: &Twist,
) -> Contact {
    let distance = d.norm_squared().sqrt();
    let normal = d * (1.0 / distance);
    let overlap = radius_i + radius_j - distance;
    let (arm_i, arm_j) = (radius_i - 0.5 * overlap, radius_j - 0.5 * overlap);
    Contact {
        normal,
        overlap,
        velocity: (i.v - j.v) + (i.w * arm_i + j.w * arm_j).cross(&normal),
        twist: 0.5 * (i.w + j.w).dot(&normal),
        rolling: i.w - j.w,
    }
}

/// The contact of a sphere with a wall, and the distance of its point from the centre.
#[inline(always)]
pub(crate) fn touch_of_wall(ball: &Ball, twist: &Twist, wall: &Wall) -> (Contact, f64) {
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

/// What the forces between bodies are made from, besides the list.
#[derive(Clone, Copy)]
pub(crate) struct Scenery<'a> {
    /// Laws by number.
    pub laws: &'a [Law],
    /// Displacements of images.
    pub shifts: &'a [Vec3; 27],
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Whether any body crossed a periodic face since neighbours were listed.
    pub crossed: bool,
    /// Lengths of steps.
    pub steps: Steps,
    /// Lubrication, if there is any.
    pub squeeze: Option<Squeeze>,
}

impl Scenery<'_> {
    /// Gap up to which surfaces feel each other [m].
    #[inline(always)]
    pub fn reach(&self) -> f64 {
        self.squeeze.map_or(0.0, |squeeze| squeeze.cutoff)
    }

    /// Normal force of lubrication [N].
    #[inline(always)]
    pub fn lubrication(&self, contact: &Contact, pair: Reduced) -> f64 {
        let Some(squeeze) = self.squeeze else { return 0.0 };
        squeeze.resistance(-contact.overlap, pair.radius) * contact.velocity.dot(&contact.normal)
    }

    /// From centre to centre of a pair.
    #[inline(always)]
    pub fn between(&self, i: usize, j: usize, image: u16) -> Vec3 {
        let bodies = self.bodies;
        let mut image = i32::from(image);
        if self.crossed {
            image += bodies.crossed[j] - bodies.crossed[i];
        }
        // The difference first: the other way round it is then exactly the opposite.
        (bodies.balls[j].x - bodies.balls[i].x) + self.shifts[image as usize]
    }
}

/// Evaluates the contacts between bodies; what they give stands in the records of `pairs`. Adds what
/// each block saw to `tallies`.
pub(crate) fn between_bodies(
    team: &mut Team,
    pairs: &mut Pairs,
    scenery: Scenery<'_>,
    tallies: &mut [Tally],
) {
    let bounds = &pairs.bounds;
    let pieces = (
        Cut::at(&mut pairs.state, bounds),
        Cut::at(&mut pairs.hits, bounds),
        Cut::at(&mut pairs.xi, bounds),
        Cut::at(&mut pairs.records, bounds),
        Cut::at(&mut pairs.rolling, &pairs.rolling_bounds),
        Cut::every(tallies, 1),
    );
    let (start, entries, reduced) = (&pairs.start, &pairs.entries, &pairs.reduced);
    let (balls, gap) = (&scenery.bodies.balls, scenery.reach());
    team.for_pieces(pieces, |b, (state, hits, xi, records, rolling, tally)| {
        let bodies = b * BLOCK..balls.len().min((b + 1) * BLOCK);
        let first = bounds[b] as usize;
        let mut found = 0;
        for i in bodies {
            let radius = balls[i].radius;
            let row = start[i] as usize..start[i + 1] as usize;
            for (k, entry) in row.clone().zip(&entries[row]) {
                let j = entry.other as usize;
                let reach = radius + balls[j].radius + gap;
                let touches = scenery.between(i, j, entry.image).norm_squared() < reach * reach;
                // Without a branch: which pairs of a list touch cannot be foretold.
                hits[found] = Hit { body: i as u32, entry: k as u32 };
                found += usize::from(touches);
                state[k - first] &= u8::from(touches).wrapping_neg();
            }
        }
        for hit in &hits[..found] {
            let (i, k) = (hit.body as usize, hit.entry as usize);
            let entry = entries[k];
            let k = k - first;
            let j = entry.other as usize;
            let (a, b) = (&balls[i], &balls[j]);
            let predicted = &scenery.bodies.predicted;
            let d = scenery.between(i, j, entry.image);
            let contact = touch_of_balls(d, a.radius, b.radius, &predicted[i], &predicted[j]);
            let (record, pair) = (&mut records[k], reduced[first + k]);
            let squeezed = scenery.lubrication(&contact, pair);
            if contact.overlap <= 0.0 {
                state[k] = ACTING;
                *record = Record::at_a_distance(&contact, squeezed);
                if let Some(rolling) = rolling.get_mut(k) {
                    *rolling = Rolling::NONE;
                }
                continue;
            }
            let mut memory = contact::Memory {
                xi: xi[k],
                rolling: rolling.get(k).map_or(Vec3::zeros(), |r| r.displacement),
                normal: record.normal,
                overlap: record.overlap,
            };
            let touching = state[k] & TOUCHING != 0;
            state[k] = ACTING | TOUCHING;
            let law = &scenery.laws[entry.law as usize];
            let force = contact::force(law, pair, &contact, &mut memory, touching, scenery.steps);
            xi[k] = memory.xi;
            *record = Record {
                normal: contact.normal,
                tangential: force.tangential,
                force: force.normal + squeezed,
                overlap: contact.overlap,
            };
            if let Some(rolling) = rolling.get_mut(k) {
                *rolling = Rolling { displacement: memory.rolling, torque: force.rolling };
            }
            tally[0].add(Deepest {
                overlap: contact.overlap,
                radius: a.radius.min(b.radius),
                body: i as u32,
                other: Other::Body(j as u32),
            });
        }
    });
}

/// Evaluates the contacts with walls, and adds what each block saw to `tallies`.
pub(crate) fn of_walls(
    team: &mut Team,
    list: &mut WallContacts,
    walls: &[Wall],
    scenery: Scenery<'_>,
    tallies: &mut [Tally],
) {
    let pieces = (
        Cut::at(&mut list.entries, &list.entry_bounds),
        Cut::at(&mut list.wrench, &list.bounds),
        Cut::every(tallies, 1),
    );
    let (bodies, start, bounds) = (&list.bodies, &list.start, &list.bounds);
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
    scenery: &Scenery<'_>,
    wrench: &mut Wrench,
    tally: &mut Tally,
) {
    let ball = &scenery.bodies.balls[i];
    let predicted = &scenery.bodies.predicted[i];
    let (contact, arm) = touch_of_wall(ball, predicted, &walls[entry.wall as usize]);
    let touched = std::mem::replace(&mut entry.touching, contact.overlap > 0.0);
    let n = contact.normal;
    wrench.force -= n * scenery.lubrication(&contact, entry.reduced);
    if contact.overlap <= 0.0 {
        return;
    }
    let law = &scenery.laws[entry.law as usize];
    let (memory, steps) = (&mut entry.memory, scenery.steps);
    let f = contact::force(law, entry.reduced, &contact, memory, touched, steps);
    wrench.force += f.tangential - n * f.normal;
    wrench.torque += n.cross(&f.tangential) * arm + f.rolling;
    let other = Other::Wall(entry.wall);
    tally.add(Deepest { overlap: contact.overlap, radius: ball.radius, body: i as u32, other });
}
