//! Contact forces of all bodies, summed in the order of the lists.

use crate::{
    Vec3,
    bodies::{Ball, Twist, Wrench},
    contact::{self, Contact},
    contact_list::ContactList,
    law::Law,
    walls::Wall,
};

/// Overlap over the smaller radius beyond which a contact is counted as too soft.
const DEEP: f64 = 0.05;

/// What one evaluation of the forces saw.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Contacts.
    pub contacts: u64,
    /// Contacts with an overlap beyond 5 % of the smaller radius.
    pub deep: u64,
    /// The contact with the largest overlap in terms of its smaller radius.
    pub deepest: Deepest,
}

/// The deepest contact of an evaluation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deepest {
    /// Overlap [m].
    pub overlap: f64,
    /// Smaller radius [m].
    pub radius: f64,
    /// Index of the body.
    pub body: usize,
    /// Index of the other body, or of the wall.
    pub other: usize,
    /// Whether the other is a wall.
    pub wall: bool,
}

impl Default for Deepest {
    fn default() -> Self {
        Self { overlap: 0.0, radius: 1.0, body: 0, other: 0, wall: false }
    }
}

impl Deepest {
    /// Overlap over the smaller radius.
    pub fn ratio(&self) -> f64 {
        self.overlap / self.radius
    }
}

impl Tally {
    #[inline(always)]
    fn add(&mut self, seen: Deepest) {
        self.contacts += 1;
        self.deep += u64::from(seen.overlap > DEEP * seen.radius);
        // Compared without a division, because this runs for every contact.
        if seen.overlap * self.deepest.radius > self.deepest.overlap * seen.radius {
            self.deepest = seen;
        }
    }
}

/// A contact and the distances of its point from the centres along the normal.
pub(crate) struct Touch {
    pub contact: Contact,
    pub arm_i: f64,
    pub arm_j: f64,
}

/// The contact of two spheres with centres `d` apart, if they overlap. Its point lies half way
/// between the two surfaces, so that both torques refer to the same point.
#[inline(always)]
pub(crate) fn touch_of_balls(
    d: Vec3,
    radius_i: f64,
    radius_j: f64,
    i: &Twist,
    j: &Twist,
) -> Option<Touch> {
    let reach = radius_i + radius_j;
    let square = d.norm_squared();
    if square >= reach * reach {
        return None;
    }
    let distance = square.sqrt();
    let normal = d * (1.0 / distance);
    let overlap = reach - distance;
    let (arm_i, arm_j) = (radius_i - 0.5 * overlap, radius_j - 0.5 * overlap);
    let velocity = i.v - j.v + (i.w * arm_i + j.w * arm_j).cross(&normal);
    let contact = Contact { normal, overlap, velocity, twist: 0.5 * (i.w + j.w).dot(&normal) };
    Some(Touch { contact, arm_i, arm_j })
}

/// The contact of a sphere with a wall, if they overlap.
#[inline(always)]
pub(crate) fn touch_of_wall(ball: &Ball, twist: &Twist, wall: &Wall) -> Option<Touch> {
    let overlap = wall.overlap(ball);
    if overlap <= 0.0 {
        return None;
    }
    let normal = -wall.normal;
    let arm_i = ball.radius - 0.5 * overlap;
    let contact = Contact {
        normal,
        overlap,
        velocity: twist.v + twist.w.cross(&normal) * arm_i,
        twist: 0.5 * twist.w.dot(&normal),
    };
    Some(Touch { contact, arm_i, arm_j: 0.0 })
}

/// Steps before and after an evaluation [s]: `before` is 0 for the one that starts all histories.
#[derive(Clone, Copy)]
pub(crate) struct Steps {
    pub before: f64,
    pub after: f64,
}

/// Adds the forces between bodies to `out`.
pub(crate) fn between_bodies(
    list: &mut ContactList,
    law: &Law,
    shifts: &[Vec3; 27],
    balls: &[Ball],
    twists: &[Twist],
    steps: Steps,
    out: &mut [Wrench],
) -> Tally {
    let mut tally = Tally::default();
    for i in 0..balls.len() {
        let ball = balls[i];
        let mut on_i = out[i];
        for k in list.row(i) {
            let neighbour = list.neighbours[k];
            let j = neighbour.other as usize;
            let d = balls[j].x + shifts[neighbour.image as usize] - ball.x;
            let touch = touch_of_balls(d, ball.radius, balls[j].radius, &twists[i], &twists[j]);
            let touched = std::mem::replace(&mut list.touching[k], touch.is_some());
            let Some(touch) = touch else { continue };
            let (before, after) = (steps.before, steps.after);
            let (mass, memory) = (list.root_mass[k], &mut list.memory[k]);
            let f = contact::force(law, mass, &touch.contact, memory, touched, before, after);
            let n = touch.contact.normal;
            let force = f.tangential - n * f.normal;
            let moment = n.cross(&f.tangential);
            on_i.force += force;
            on_i.torque += moment * touch.arm_i;
            out[j].force -= force;
            out[j].torque += moment * touch.arm_j;
            tally.add(Deepest {
                overlap: touch.contact.overlap,
                radius: ball.radius.min(balls[j].radius),
                body: i,
                other: j,
                wall: false,
            });
        }
        out[i] = on_i;
    }
    tally
}

/// Adds the forces of walls to `out`, and what was seen to `tally`.
#[allow(clippy::too_many_arguments)] // The same as between bodies, and the tally.
pub(crate) fn of_walls(
    list: &mut ContactList,
    law: &Law,
    walls: &[Wall],
    balls: &[Ball],
    twists: &[Twist],
    steps: Steps,
    out: &mut [Wrench],
    tally: &mut Tally,
) {
    for i in 0..balls.len() {
        for k in list.row(i) {
            let other = list.neighbours[k].other as usize;
            let touch = touch_of_wall(&balls[i], &twists[i], &walls[other]);
            let touched = std::mem::replace(&mut list.touching[k], touch.is_some());
            let Some(touch) = touch else { continue };
            let (before, after) = (steps.before, steps.after);
            let (mass, memory) = (list.root_mass[k], &mut list.memory[k]);
            let f = contact::force(law, mass, &touch.contact, memory, touched, before, after);
            let n = touch.contact.normal;
            out[i].force += f.tangential - n * f.normal;
            out[i].torque += n.cross(&f.tangential) * touch.arm_i;
            tally.add(Deepest {
                overlap: touch.contact.overlap,
                radius: balls[i].radius,
                body: i,
                other,
                wall: true,
            });
        }
    }
}
