//! From collision to collision, where nothing but gravity acts in between.
//!
//! Each body keeps its earliest collision and its next way into another cell; a tournament says
//! whose is the next of all (Alder & Wainwright 1959; Lubachevsky, *J. Comput. Phys.* 94, 1991; one
//! event a body as in Smallenburg's EDMD). A collision that was foreseen with a body that has
//! collided since does not come true, and is looked for anew.

use crate::Vec3;
use crate::bodies::hard_body::{HardBody, NEVER};
use crate::impact::approach::{Approach, first_landing};
use crate::impact::collision::{Collider, ImpactLaw};
use crate::impact::guards::Guard;
use crate::solver::event_queue::EventQueue;
use crate::solver::hard_system::HardSystem;
use serde::{Deserialize, Serialize};
use tremie_state::{StateError, StateExchange};

/// What a body meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Target {
    /// A body by its number.
    Body(u32),
    /// A plane wall by its number.
    Wall(u32),
    /// A triangle near a cell, by its place in the list of these.
    Triangle(u32),
    /// Nothing.
    Nothing,
}

/// The earliest collision of a body that is foreseen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Foreseen {
    time: f64,
    target: Target,
    /// That of the body it is with.
    stamp: u32,
}

/// The next cell of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Crossing {
    time: f64,
    axis: u8,
    is_up: bool,
}

const NOTHING: Foreseen = Foreseen { time: f64::INFINITY, target: Target::Nothing, stamp: 0 };

impl Foreseen {
    /// Takes another one if it is earlier; of equal times that with the smaller number.
    #[inline(always)]
    fn take(&mut self, other: Self) {
        if other.time < self.time || (other.time == self.time && other.target < self.target) {
            *self = other;
        }
    }
}

/// Part of the least speed of an impact with which what presses on it parts: a body at rest on a
/// floor collides at no speed, and would for ever.
const LEAST_PARTING: f64 = 0.1;

/// Foreseen events of all bodies.
pub struct EventDriver {
    queue: EventQueue,
    foreseen: Vec<Foreseen>,
    crossings: Vec<Crossing>,
    /// Events of any kind since the start.
    pub events: u64,
}

impl EventDriver {
    /// For the bodies of a system, which are in their cells and at moment 0.
    pub fn new(system: &HardSystem) -> Self {
        let n = system.bodies.len();
        let never = Crossing { time: f64::INFINITY, axis: 0, is_up: false };
        let mut driver = Self {
            queue: EventQueue::new(n),
            foreseen: vec![NOTHING; n],
            crossings: vec![never; n],
            events: 0,
        };
        for i in 0..n {
            driver.foresee(system, i);
        }
        driver
    }

    /// Lets a duration pass [s].
    pub fn advance(&mut self, system: &mut HardSystem, duration: f64) {
        loop {
            let (i, moment) = self.queue.first();
            if moment > duration {
                break;
            }
            self.events += 1;
            if self.crossings[i].time < self.foreseen[i].time {
                self.cross(system, i, moment);
            } else {
                self.come_true(system, i, moment);
            }
        }
        self.begin_anew(system, duration);
    }

    /// Keeps what is foreseen at a window's end, or puts it back.
    ///
    /// # Errors
    /// A state of other bodies.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let bodies = self.foreseen.len();
        state.value("foreseen", &mut self.foreseen)?;
        state.value("crossings", &mut self.crossings)?;
        state.value("events", &mut self.events)?;
        if [self.foreseen.len(), self.crossings.len()] != [bodies; 2] {
            return state
                .unfit(format!("the state foresees events of other bodies than these {bodies}"));
        }
        if state.restores() {
            self.queue = EventQueue::new(bodies);
            for (i, (foreseen, crossing)) in self.foreseen.iter().zip(&self.crossings).enumerate() {
                self.queue.set(i, foreseen.time.min(crossing.time));
            }
        }
        Ok(())
    }

    /// All bodies go on to the end of a window, from which moments count then.
    fn begin_anew(&mut self, system: &mut HardSystem, duration: f64) {
        for body in &mut system.bodies {
            body.advance(duration);
            body.time = 0.0;
            if body.last_hit != NEVER {
                body.last_hit -= duration;
            }
        }
        self.queue.shift(duration);
        self.foreseen.iter_mut().for_each(|foreseen| foreseen.time -= duration);
        self.crossings.iter_mut().for_each(|crossing| crossing.time -= duration);
    }

    /// A body goes into the next cell, and looks at those that come near.
    fn cross(&mut self, system: &mut HardSystem, i: usize, moment: f64) {
        let Crossing { axis, is_up, .. } = self.crossings[i];
        let axis = axis as usize;
        let mut cell = system.cells.home(i);
        let body = &mut system.bodies[i];
        body.advance(moment);
        if let Some((next, lengths)) = system.cells.step(cell[axis], axis, is_up) {
            body.x[axis] += lengths * system.cells.bounds.size[axis];
            cell[axis] = next;
        }
        system.cells.relocate(i, cell);
        let body = system.bodies[i];
        let mut best = self.foreseen[i];
        let has_weight = system.gravity != Vec3::zeros();
        system.cells.ahead(cell, axis, is_up, |j, shift| {
            if j != i {
                best.take(with_body(&body, (j, &system.bodies[j]), shift, has_weight));
            }
        });
        self.crossings[i] = next_crossing(system, i);
        best.take(self.with_triangles(system, i));
        self.keep(i, best);
    }

    /// A collision takes place, if its partner has had no other since it was foreseen.
    fn come_true(&mut self, system: &mut HardSystem, i: usize, moment: f64) {
        let Foreseen { target, stamp, .. } = self.foreseen[i];
        system.bodies[i].advance(moment);
        match target {
            Target::Body(j) => {
                let j = j as usize;
                if system.bodies[j].stamp == stamp {
                    system.bodies[j].advance(moment);
                    collide(system, i, j);
                    self.foresee(system, j);
                }
            }
            Target::Wall(wall) => bounce(system, i, wall as usize),
            Target::Triangle(place) => bounce_off_part(system, i, place as usize),
            Target::Nothing => {}
        }
        self.foresee(system, i);
    }

    /// Looks for the next collision of a body that is at its moment.
    fn foresee(&mut self, system: &HardSystem, i: usize) {
        let body = system.bodies[i];
        if !body.is_free() {
            return;
        }
        let mut best = with_walls(system, &body);
        let has_weight = system.gravity != Vec3::zeros();
        system.cells.around(system.cells.home(i), |j, shift| {
            if j != i {
                best.take(with_body(&body, (j, &system.bodies[j]), shift, has_weight));
            }
        });
        self.crossings[i] = next_crossing(system, i);
        best.take(self.with_triangles(system, i));
        self.keep(i, best);
    }

    fn keep(&mut self, i: usize, best: Foreseen) {
        self.foreseen[i] = best;
        self.queue.set(i, best.time.min(self.crossings[i].time));
    }

    /// The first touch of a part before the body leaves its cell.
    fn with_triangles(&self, system: &HardSystem, i: usize) -> Foreseen {
        if system.parts.is_empty() {
            return NOTHING;
        }
        let body = &system.bodies[i];
        let cell = system.cells.slot(system.cells.home(i));
        let until = self.crossings[i].time - body.time;
        let mut best = NOTHING;
        for place in system.parts.near_cell(cell) {
            if let Some((s, _)) = system.parts.touch_at_rest(place, body, until) {
                let (time, target) = (body.time + s, Target::Triangle(place as u32));
                best.take(Foreseen { time, target, stamp: 0 });
            }
        }
        best
    }
}

/// The first touch of two bodies; the other one is seen at a shift.
#[inline(always)]
fn with_body(
    body: &HardBody,
    (j, other): (usize, &HardBody),
    shift: Vec3,
    has_weight: bool,
) -> Foreseen {
    let moment = body.time;
    let reach = body.radius + other.radius;
    let s = moment - other.time;
    let approach = if has_weight {
        let (x, v) = (other.x + other.v * s + other.a * (0.5 * s * s), other.v + other.a * s);
        Approach { x: x + shift - body.x, v: v - body.v, a: other.a - body.a, reach }
    } else {
        // Only what comes first of the other body is read.
        let x = other.x + other.v * s;
        Approach { x: x + shift - body.x, v: other.v - body.v, a: Vec3::zeros(), reach }
    };
    match approach.first_touch(f64::INFINITY) {
        Some(s) => {
            Foreseen { time: moment + s, target: Target::Body(j as u32), stamp: other.stamp }
        }
        None => NOTHING,
    }
}

/// The first touch of a body and a plane wall.
fn with_walls(system: &HardSystem, body: &HardBody) -> Foreseen {
    let mut best = NOTHING;
    for (k, wall) in system.walls.walls.iter().enumerate() {
        let n = &wall.normal;
        let height = body.x.dot(n) - wall.offset - body.radius;
        if let Some(s) = first_landing(height, body.v.dot(n), body.a.dot(n), f64::INFINITY) {
            let (time, target) = (body.time + s, Target::Wall(k as u32));
            best.take(Foreseen { time, target, stamp: 0 });
        }
    }
    best
}

/// The next cell of a body, and when it comes there.
fn next_crossing(system: &HardSystem, i: usize) -> Crossing {
    let (body, cells) = (&system.bodies[i], &system.cells);
    let home = cells.home(i);
    let low = cells.corner(home);
    let mut next = Crossing { time: f64::INFINITY, axis: 0, is_up: false };
    for axis in 0..3 {
        if cells.count[axis] == 1 {
            continue;
        }
        let (x, v, a) = (body.x[axis] - low[axis], body.v[axis], body.a[axis]);
        let above = cells.edge[axis] - x;
        let sides = [(x, v, a, false), (above, -v, -a, true)];
        for (way, u, g, is_up) in sides {
            if (g == 0.0 && u >= 0.0) || cells.step(home[axis], axis, is_up).is_none() {
                continue;
            }
            if let Some(s) = first_landing(way, u, g, f64::INFINITY)
                && body.time + s < next.time
            {
                next = Crossing { time: body.time + s, axis: axis as u8, is_up };
            }
        }
    }
    next
}

/// Two bodies collide.
fn collide(system: &mut HardSystem, i: usize, j: usize) {
    let meeting = system.meeting(i, j);
    // By rounding they may part already.
    if meeting.speed < 0.0 {
        return;
    }
    let restitution = system.law(i, j).restitution;
    let (guard, parting) =
        parting(system, meeting.speed, meeting.since, meeting.press, restitution);
    system.collide((i, j), &meeting, parting);
    system.count.add(true, guard, restitution);
}

/// A body bounces off a plane wall.
fn bounce(system: &mut HardSystem, i: usize, k: usize) {
    let (n, partner) = (system.walls.walls[k].normal, system.walls.collider(k));
    let law = system.walls.law(k, system.bodies[i].material, &system.laws);
    let impulse = bounce_off(system, i, n, &partner, &law);
    system.walls.impulses[k] -= impulse;
}

/// A body bounces off a part that stands still.
fn bounce_off_part(system: &mut HardSystem, i: usize, place: usize) {
    let Some((_, n)) = system.parts.touch_at_rest(place, &system.bodies[i], f64::INFINITY) else {
        return;
    };
    let law = system.parts.law(place, system.bodies[i].material, &system.laws);
    let impulse = bounce_off(system, i, n, &Collider::STILL, &law);
    system.parts.push(place, &system.bodies[i], n, -impulse);
}

/// A body bounces off something that no impulse moves; the impulse that it gets.
fn bounce_off(
    system: &mut HardSystem,
    i: usize,
    n: Vec3,
    partner: &Collider,
    law: &ImpactLaw,
) -> Vec3 {
    let body = &system.bodies[i];
    let speed = (partner.v - body.v).dot(&n).max(0.0);
    let (since, press) = (body.time - body.last_hit, -body.a.dot(&n));
    let (guard, parting) = parting(system, speed, since, press, law.restitution);
    let impulse = system.bounce(i, (partner, n), law, parting);
    system.count.add(false, guard, law.restitution);
    impulse.vector(n)
}

/// The speed at which two part that approach at a speed [m/s], and the guard that had a say in it.
fn parting(
    system: &HardSystem,
    speed: f64,
    since: f64,
    press: f64,
    restitution: f64,
) -> (Guard, f64) {
    let guard = system.guards.of(speed, since);
    let parting = if guard == Guard::None { restitution * speed } else { speed };
    let least = if press > 0.0 { LEAST_PARTING * system.guards.elastic_speed } else { 0.0 };
    (guard, parting.max(least))
}
