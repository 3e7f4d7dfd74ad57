//! From step to step under the loads of a fluid: retrospective detection (Goetsch 2015,
//! Sec. 2.3.3).
//!
//! All bodies go through a step under constant accelerations. Those that overlap at its end are
//! taken back to the moment of their touch, the earliest first; the pair collides, goes through the
//! rest of the step, and is looked at anew. Pairs that touch and part within the step are missed: of
//! a gas the part `(2/3) T dt²/(m d²)` in space and `(1/4) T dt²/(m d²)` in a plane, all grazing.
//!
//! What touches more slowly than its accelerations could undo in a step rests: it parts at the speed
//! that brings it back at the step's end, so that the impulse of the step is that of the force that
//! presses it. A body that collides more often in a step than is resolved stays where it is until
//! the step ends, and is counted.

use crate::Vec3;
use crate::bodies::hard_body::{HardBody, NEVER};
use crate::bodies::hard_parts::PartTouch;
use crate::cells::end_rows::EndRows;
use crate::impact::approach::{Approach, first_landing};
use crate::impact::collision::{Collider, ImpactLaw};
use crate::impact::guards::Guard;
use crate::solver::hard_system::HardSystem;
use core::cmp::Ordering;
use std::collections::BinaryHeap;
use tremie_grains_kit::space::rigid_body::Twist;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Bodies to an item of work; their rows of cells are shared out evenly among as many items.
const BLOCK: usize = 256;

/// What a body touches in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Touched {
    /// A body by its number, and the number of its collisions so far.
    Body(u32, u32),
    Wall(u32),
    Part(PartTouch),
}

impl Touched {
    /// Orders touches of equal moments.
    fn order(&self) -> (u32, u32, u32) {
        match self {
            Self::Body(j, _) => (0, *j, 0),
            Self::Wall(k) => (1, *k, 0),
            Self::Part(touch) => (2, touch.part, touch.triangle),
        }
    }
}

/// A touch that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StepEvent {
    moment: f64,
    body: u32,
    /// Number of the body's collisions when it was found.
    stamp: u32,
    touched: Touched,
}

impl Eq for StepEvent {}

impl Ord for StepEvent {
    /// The earliest is the greatest: a heap gives that first. Ties are broken by numbers.
    fn cmp(&self, other: &Self) -> Ordering {
        let of = |event: &Self| (event.body, event.touched.order());
        other.moment.total_cmp(&self.moment).then_with(|| of(other).cmp(&of(self)))
    }
}

impl PartialOrd for StepEvent {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Touches that were found in one item of work, and room to work in.
#[derive(Default)]
struct DetectionBlock {
    found: Vec<StepEvent>,
    triangles: Vec<u32>,
}

/// Bodies that go from step to step.
pub struct StepDriver {
    /// Length of a step [s].
    step: f64,
    /// Most collisions of a body in a step.
    most: u16,
    /// Accelerations of each body in this window: of weight and fluid.
    pub accelerations: Vec<Twist>,
    /// Where each body stood when the step began, and where it ends it [m].
    starts: Vec<Vec3>,
    ends: Vec<Vec3>,
    /// The latter by cells.
    rows: EndRows,
    /// Collisions of each body in this step.
    hits: Vec<u16>,
    /// Mean velocity through the last step of bodies that a lasting contact carried [m/s].
    shown: Vec<Vec3>,
    blocks: Vec<DetectionBlock>,
    events: BinaryHeap<StepEvent>,
    triangles: Vec<u32>,
}

impl StepDriver {
    /// For the bodies of a system, in steps of a length [s] with at most so many collisions of a
    /// body.
    pub fn new(system: &HardSystem, step: f64, most: u16) -> Self {
        let n = system.bodies.len();
        let weight = |body: &HardBody| Twist {
            v: if body.is_free() { system.gravity } else { Vec3::zeros() },
            w: Vec3::zeros(),
        };
        Self {
            step,
            most,
            accelerations: system.bodies.iter().map(weight).collect(),
            starts: vec![Vec3::zeros(); n],
            ends: vec![Vec3::zeros(); n],
            rows: EndRows::new(&system.cells, n),
            hits: vec![0; n],
            shown: vec![Vec3::zeros(); n],
            blocks: (0..n.div_ceil(BLOCK)).map(|_| DetectionBlock::default()).collect(),
            events: BinaryHeap::with_capacity(n),
            triangles: Vec::new(),
        }
    }

    /// Velocity of a body for others [m/s]: where a contact carried it through the last step, the
    /// mean of the step.
    pub fn velocity(&self, system: &HardSystem, i: usize) -> Vec3 {
        if system.bodies[i].rests { self.shown[i] } else { system.bodies[i].v }
    }

    /// Keeps what is left of the last step at its end, or puts it back.
    ///
    /// # Errors
    /// A state of other bodies.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { accelerations, shown, .. } = self;
        state.column(
            "acceleration",
            accelerations,
            |a| a.v.into(),
            |a, v: [f64; 3]| a.v = v.into(),
        )?;
        state.column(
            "angular_acceleration",
            accelerations,
            |a| a.w.into(),
            |a, w: [f64; 3]| a.w = w.into(),
        )?;
        state.column("shown", shown, |v| (*v).into(), |v, shown: [f64; 3]| *v = shown.into())
    }

    /// One step.
    pub fn advance(&mut self, system: &mut HardSystem, team: &mut Team) {
        self.begin(system);
        self.detect(system, team);
        while let Some(event) = self.events.pop() {
            self.come_true(system, &event);
        }
        self.end(system);
    }

    /// Bodies get their accelerations, and go through the step.
    fn begin(&mut self, system: &mut HardSystem) {
        let HardSystem { bodies, cells, .. } = system;
        for (i, body) in bodies.iter_mut().enumerate() {
            let Twist { v, w } = self.accelerations[i];
            (body.a, body.alpha) = (v, w);
            (body.is_stopped, body.rests) = (false, false);
            self.hits[i] = 0;
            self.starts[i] = body.x;
            self.ends[i] = cells.bounds.wrap(body.position(self.step));
            cells.relocate(i, cells.cell_of(self.ends[i]));
        }
        self.rows.fill(cells, &self.ends, |i| bodies[i].radius);
    }

    /// Finds all that touch in the step.
    fn detect(&mut self, system: &HardSystem, team: &mut Team) {
        let (ends, step, rows) = (&self.ends, self.step, &self.rows);
        let (count, blocks) = (EndRows::rows(&system.cells), self.blocks.len());
        team.work_alone(ends.len() < ALONE);
        team.for_each(&mut self.blocks, |b, block| {
            let DetectionBlock { found, triangles } = block;
            found.clear();
            for row in b * count / blocks..(b + 1) * count / blocks {
                rows.overlaps(&system.cells, row, |i, j| {
                    found.extend(touch_of_pair(system, i, j, step));
                });
            }
            for i in b * BLOCK..ends.len().min((b + 1) * BLOCK) {
                look_at_solids(system, (ends, step), i, triangles, |event| found.push(event));
            }
        });
        for block in &self.blocks {
            self.events.extend(block.found.iter().copied());
        }
    }

    /// A touch comes true, unless one of both collided since it was found.
    fn come_true(&mut self, system: &mut HardSystem, event: &StepEvent) {
        let i = event.body as usize;
        if system.bodies[i].stamp != event.stamp {
            return;
        }
        match event.touched {
            Touched::Body(j, stamp) => {
                let j = j as usize;
                if system.bodies[j].stamp == stamp {
                    self.collide(system, (i, j), event.moment);
                }
            }
            Touched::Wall(k) => self.bounce_off_wall(system, i, k as usize, event.moment),
            Touched::Part(touch) => self.bounce_off_part(system, i, &touch),
        }
    }

    fn collide(&mut self, system: &mut HardSystem, (i, j): (usize, usize), moment: f64) {
        for k in [i, j] {
            system.bodies[k].advance(moment);
        }
        let meeting = system.meeting(i, j);
        if meeting.speed < 0.0 || (system.bodies[i].is_stopped && system.bodies[j].is_stopped) {
            return;
        }
        let law = system.law(i, j);
        let strength = system.strength(i).max(system.strength(j));
        let touch = Touch { speed: meeting.speed, press: meeting.press, since: meeting.since };
        let (guard, parting) = self.parting(system, &touch, strength, moment, &law);
        let is_crowded = self.count(system, i) | self.count(system, j);
        system.collide((i, j), &meeting, if is_crowded { 0.0 } else { parting });
        system.count.add(true, guard, law.restitution);
        for k in [i, j] {
            self.settle(system, k, guard);
        }
        for k in [i, j] {
            self.look_again(system, k);
        }
    }

    fn bounce_off_wall(&mut self, system: &mut HardSystem, i: usize, k: usize, moment: f64) {
        system.bodies[i].advance(moment);
        let (n, partner) = (system.walls.walls[k].normal, system.walls.collider(k));
        let law = system.walls.law(k, system.bodies[i].material, &system.laws);
        if let Some(impulse) = self.bounce(system, i, (&partner, n), &law) {
            system.walls.impulses[k] -= impulse;
        }
    }

    fn bounce_off_part(&mut self, system: &mut HardSystem, i: usize, touch: &PartTouch) {
        system.bodies[i].advance(touch.moment);
        let law = system.parts.law_of(touch.part, system.bodies[i].material, &system.laws);
        let (partner, at) = system.parts.collider(touch, &system.bodies[i], self.step);
        if let Some(impulse) = self.bounce(system, i, (&partner, touch.n), &law) {
            system.parts.receive(touch.part, at, touch.moment / self.step, -impulse);
        }
    }

    /// A body bounces off something that no impulse moves; the impulse that it gets.
    fn bounce(
        &mut self,
        system: &mut HardSystem,
        i: usize,
        (partner, n): (&Collider, Vec3),
        law: &ImpactLaw,
    ) -> Option<Vec3> {
        let body = &system.bodies[i];
        let speed = (partner.v - body.v).dot(&n);
        if speed < 0.0 || body.is_stopped {
            return None;
        }
        let touch = Touch { speed, press: -body.a.dot(&n), since: body.time - body.last_hit };
        let (strength, moment) = (system.strength(i), body.time);
        let (guard, parting) = self.parting(system, &touch, strength, moment, law);
        let parting = if self.count(system, i) { 0.0 } else { parting };
        let impulse = system.bounce(i, (partner, n), law, parting);
        system.count.add(false, guard, law.restitution);
        self.settle(system, i, guard);
        self.look_again(system, i);
        Some(impulse.vector(n))
    }

    /// The speed at which two part, and the guard that had a say in it.
    fn parting(
        &self,
        system: &HardSystem,
        touch: &Touch,
        strength: f64,
        moment: f64,
        law: &ImpactLaw,
    ) -> (Guard, f64) {
        // Twice: of two that fall together one may have been turned round.
        if touch.speed <= 2.0 * strength * self.step {
            let rest = self.step - moment;
            let parting = if touch.press > 0.0 { 0.5 * touch.press * rest } else { touch.speed };
            return (Guard::ElasticSpeed, parting);
        }
        let guard = system.guards.of(touch.speed, touch.since);
        let is_elastic = guard != Guard::None;
        (guard, if is_elastic { touch.speed } else { law.restitution * touch.speed })
    }

    /// Counts a collision of a body; true if it has more than are resolved.
    fn count(&mut self, system: &HardSystem, i: usize) -> bool {
        if !system.bodies[i].is_free() {
            return false;
        }
        self.hits[i] = self.hits[i].saturating_add(1);
        self.hits[i] > self.most
    }

    /// What a collision leaves behind: a body that rests, or one that stays where it is.
    fn settle(&mut self, system: &mut HardSystem, i: usize, guard: Guard) {
        let is_crowded = self.hits[i] > self.most;
        let body = &mut system.bodies[i];
        if !body.is_free() {
            return;
        }
        body.rests |= guard == Guard::ElasticSpeed;
        if is_crowded && !body.is_stopped {
            body.is_stopped = true;
            (body.a, body.alpha) = (Vec3::zeros(), Vec3::zeros());
            system.count.crowded += 1;
        }
    }

    /// Looks for touches of a body in the rest of the step.
    fn look_again(&mut self, system: &mut HardSystem, i: usize) {
        if !system.bodies[i].is_free() {
            return;
        }
        self.ends[i] = system.cells.bounds.wrap(system.bodies[i].position(self.step));
        system.cells.relocate(i, system.cells.cell_of(self.ends[i]));
        let Self { ends, events, triangles, step, .. } = self;
        look_at_bodies(system, (ends, *step), i, |event| events.push(event));
        look_at_solids(system, (ends, *step), i, triangles, |event| events.push(event));
    }

    /// Bodies are where the step ends.
    fn end(&mut self, system: &mut HardSystem) {
        for (i, body) in system.bodies.iter_mut().enumerate() {
            body.advance(self.step);
            if body.rests {
                self.shown[i] = (body.x - self.starts[i]) / self.step;
            }
            body.x = system.cells.bounds.wrap(body.x);
            body.time = 0.0;
            if body.last_hit != NEVER {
                body.last_hit -= self.step;
            }
        }
    }
}

/// Fewer bodies are one thread's work.
const ALONE: usize = 1000;

/// How two surfaces meet.
#[derive(Clone, Copy, Debug)]
struct Touch {
    /// Speed of approach [m/s].
    speed: f64,
    /// Acceleration that presses them together [m/s²].
    press: f64,
    /// Time since either collided [s].
    since: f64,
}

/// A touch of a body as it is now.
fn event_of(system: &HardSystem, i: usize, moment: f64, touched: Touched) -> StepEvent {
    StepEvent { moment, body: i as u32, stamp: system.bodies[i].stamp, touched }
}

/// The touch of two bodies that overlap at the end of a step, if one of them is free.
fn touch_of_pair(system: &HardSystem, i: usize, j: usize, step: f64) -> Option<StepEvent> {
    let is_free = |k: usize| system.bodies[k].is_free();
    // It is that of the body with the smaller number, or of the free one.
    let (i, j) = if is_free(i) && (i < j || !is_free(j)) { (i, j) } else { (j, i) };
    if !is_free(i) {
        return None;
    }
    let (body, other) = (&system.bodies[i], &system.bodies[j]);
    let moment = touch_of(system, body, other, step)?;
    Some(event_of(system, i, moment, Touched::Body(j as u32, other.stamp)))
}

/// Finds the bodies that a body touches in the rest of a step.
fn look_at_bodies(
    system: &HardSystem,
    (ends, step): (&[Vec3], f64),
    i: usize,
    mut found: impl FnMut(StepEvent),
) {
    let body = &system.bodies[i];
    system.cells.around(system.cells.home(i), |j, shift| {
        let other = &system.bodies[j];
        let reach = body.radius + other.radius;
        if (ends[j] + shift - ends[i]).norm_squared() >= reach * reach || j == i {
            return;
        }
        if let Some(moment) = touch_of(system, body, other, step) {
            found(event_of(system, i, moment, Touched::Body(j as u32, other.stamp)));
        }
    });
}

/// Finds the walls and parts that a body touches in the rest of a step.
#[inline(always)]
fn look_at_solids(
    system: &HardSystem,
    (ends, step): (&[Vec3], f64),
    i: usize,
    triangles: &mut Vec<u32>,
    mut found: impl FnMut(StepEvent),
) {
    let body = &system.bodies[i];
    if !body.is_free() {
        return;
    }
    for (k, wall) in system.walls.walls.iter().enumerate() {
        let n = &wall.normal;
        let height = |x: Vec3| x.dot(n) - wall.offset - body.radius;
        if height(body.position(step)) >= 0.0 {
            continue;
        }
        let (h, u, g) = (height(body.x), body.path_velocity().dot(n), body.a.dot(n));
        if let Some(s) = first_landing(h, u, g, step - body.time) {
            found(event_of(system, i, body.time + s, Touched::Wall(k as u32)));
        }
    }
    if !system.parts.is_empty()
        && let Some(touch) = system.parts.first_in_step(body, ends[i], step, triangles)
    {
        found(event_of(system, i, touch.moment, Touched::Part(touch)));
    }
}

/// The moment at which two bodies touch that overlap at the end of a step.
fn touch_of(system: &HardSystem, body: &HardBody, other: &HardBody, step: f64) -> Option<f64> {
    let from = body.time.max(other.time);
    let approach = Approach {
        x: system.cells.bounds.shortest(other.position(from) - body.position(from)),
        v: other.velocity(from) - body.velocity(from),
        a: other.a - body.a,
        reach: body.radius + other.radius,
    };
    approach.first_touch(step - from).map(|s| from + s)
}
