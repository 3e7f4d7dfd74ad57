//! Bodies, walls and parts of a run, and what a collision does to them.

use crate::Vec3;
use crate::bodies::hard_body::{self, HardBody};
use crate::bodies::hard_parts::HardParts;
use crate::bodies::hard_walls::HardWalls;
use crate::cells::body_cells::BodyCells;
use crate::impact::collision::{Collider, ImpactLaw, Impulse};
use crate::impact::guards::{CollisionCount, Guards};
use crate::impact::impact_laws::ImpactLaws;
use tremie_state::{StateError, StateExchange};

/// What moves, what it meets, and what it cost so far.
pub struct HardSystem {
    /// Spheres or discs, in the order of their ids.
    pub bodies: Vec<HardBody>,
    /// Where they are.
    pub cells: BodyCells,
    /// Plane walls.
    pub walls: HardWalls,
    /// Triangulated parts.
    pub parts: HardParts,
    /// Laws by materials.
    pub laws: ImpactLaws,
    /// Guards against collapse.
    pub guards: Guards,
    /// Moment of inertia over `m r²`: 2/5 of spheres, 1/2 of discs.
    pub kappa: f64,
    /// Acceleration of weight [m/s²].
    pub gravity: Vec3,
    /// Collisions since the start.
    pub count: CollisionCount,
    /// Sum over the collisions of bodies of normal impulse times distance [J·s]: over `d N T t` the
    /// excess of the pressure over that of an ideal gas.
    pub virial: f64,
}

/// Two bodies at the moment of a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Unit vector from the first to the second.
    pub n: Vec3,
    /// Distance of their centres [m].
    pub distance: f64,
    /// Speed at which their paths approach [m/s].
    pub speed: f64,
    /// Acceleration that presses them together [m/s²]; negative where it pulls them apart.
    pub press: f64,
    /// Time since either collided [s].
    pub since: f64,
}

impl HardSystem {
    /// The meeting of two bodies that are at the same moment of their paths.
    pub fn meeting(&self, i: usize, j: usize) -> Meeting {
        let (one, other) = (&self.bodies[i], &self.bodies[j]);
        let way = self.cells.bounds.shortest(other.x - one.x);
        let distance = way.norm_squared().sqrt();
        let n = if distance > 0.0 { way / distance } else { Vec3::x() };
        Meeting {
            n,
            distance,
            speed: (one.path_velocity() - other.path_velocity()).dot(&n),
            press: (one.a - other.a).dot(&n),
            since: one.time - one.last_hit.max(other.last_hit),
        }
    }

    /// The law between two bodies.
    pub fn law(&self, i: usize, j: usize) -> ImpactLaw {
        *self.laws.between(self.bodies[i].material, self.bodies[j].material)
    }

    /// Lets two bodies collide that meet so, to part at a speed [m/s].
    pub fn collide(&mut self, (i, j): (usize, usize), meeting: &Meeting, parting: f64) {
        let (law, n, moment) = (self.law(i, j), meeting.n, self.bodies[i].time);
        let mut pair = [self.bodies[i].collider(), self.bodies[j].collider()];
        // Where they overlap they touch between their surfaces: so no angular momentum is lost.
        let part = meeting.distance / (pair[0].radius + pair[1].radius);
        pair.iter_mut().for_each(|body| body.lever *= part);
        // What is stopped goes nowhere: its velocity waits for the next step.
        let paths = [i, j].map(|k| self.bodies[k].path_velocity());
        let seen = [0, 1].map(|k| Collider { v: paths[k], ..pair[k] });
        let impulse = law.impulse(n, [&seen[0], &seen[1]], parting, self.kappa);
        impulse.kick(&mut pair[0], n, -1.0, self.kappa);
        impulse.kick(&mut pair[1], n, 1.0, self.kappa);
        for (k, after) in [(i, &pair[0]), (j, &pair[1])] {
            if self.bodies[k].is_free() {
                self.bodies[k].take(after, moment);
            }
        }
        self.virial += impulse.normal * meeting.distance;
    }

    /// Lets a body collide with a wall or part whose point moves as `partner` does; `n` points from
    /// it to the body. Gives the impulse on the body.
    pub fn bounce(
        &mut self,
        i: usize,
        (partner, n): (&Collider, Vec3),
        law: &ImpactLaw,
        parting: f64,
    ) -> Impulse {
        let mut body = self.bodies[i].collider();
        let impulse = law.impulse(n, [partner, &body], parting, self.kappa);
        impulse.kick(&mut body, n, 1.0, self.kappa);
        let moment = self.bodies[i].time;
        self.bodies[i].take(&body, moment);
        impulse
    }

    /// Puts all bodies into their cells.
    pub fn fill_cells(&mut self) {
        for (i, body) in self.bodies.iter().enumerate() {
            self.cells.insert(i, self.cells.cell_of(body.x));
        }
    }

    /// Keeps the system at a window's end, or puts it back there.
    ///
    /// # Errors
    /// A state of another system.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { bodies, cells, parts, count, virial, .. } = self;
        state.within("bodies", |state| hard_body::exchange(bodies, state))?;
        state.within("cells", |state| cells.exchange(state))?;
        state.within("parts", |state| parts.exchange(state))?;
        state.value("collisions", count)?;
        state.value("virial", virial)
    }

    /// Largest acceleration of a body [m/s²].
    pub fn strength(&self, i: usize) -> f64 {
        self.bodies[i].a.norm_squared().sqrt()
    }
}
