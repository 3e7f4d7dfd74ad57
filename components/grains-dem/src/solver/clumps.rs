//! Clumps: bodies that are joined rigidly, and move as one.
//!
//! Each body of a clump stays a body: contacts and fluid act on it as on any other, but for
//! contacts within the clump, which are none. The clump sums up what acts on its bodies, moves by
//! that as a polyhedron does, and tells each body how fast to go: so that lists and periodic faces
//! need to know no more of clumps than that.

mod assembly;

use crate::Vec3;
use crate::bodies::body_arrays::{Bodies, Twist, Wrench};
use crate::bodies::drag_bands::BrakedClump;
use crate::polyhedra::{Inertia, to_world, turned_axes};
use crate::solver::force_sum::ForceSum;
use crate::solver::integrate::AppliedForces;
pub(crate) use assembly::{Misfit, Whole, wholes};
use serde::{Deserialize, Serialize};
pub(crate) use tremie_grains_kit::signals::followed::clump_numbers as numbers;
#[cfg(feature = "component")]
use tremie_messages::BodyState;
use tremie_state::{StateError, StateExchange};

/// The clumps of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clumps {
    all: Vec<Clump>,
}

/// Bodies that move as one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Clump {
    members: Vec<Member>,
    /// Mass [kg].
    pub mass: f64,
    /// About the centroid, in the frame that is the world's at the start.
    inertia: Inertia,
    /// Centroid [m]; it goes on beyond periodic faces.
    x: Vec3,
    orientation: [f64; 4],
    /// Velocity of the centroid, and angular momentum about it [kg·m²/s]: of the full step between
    /// substeps, of the half step within one.
    pub v: Vec3,
    momentum: Vec3,
    /// Velocities predicted for the end of the substep.
    predicted: Twist,
    /// Wrench of the contacts of all its bodies, about the centroid, at the last evaluation.
    contact: Wrench,
}

/// A body of a clump.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Member {
    rank: u32,
    /// Vector from the centroid, in the frame of the clump [m].
    arm: Vec3,
    /// Unit quaternion from the body's frame to the clump's.
    orientation: [f64; 4],
    /// Position, as an image beside the clump's centroid [m].
    x: Vec3,
}

impl Clumps {
    /// Keeps where they are and how they move, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("clumps", &mut self.all)
    }

    /// All of them.
    pub fn all(&self) -> &[Clump] {
        &self.all
    }

    /// Where they are and how fast forces see them, for the account of drag bands.
    pub fn braked(&self) -> impl Iterator<Item = BrakedClump> + '_ {
        let of = |clump: &Clump| BrakedClump { mass: clump.mass, x: clump.x, v: clump.predicted.v };
        self.all.iter().map(of)
    }

    /// Sums up the contact forces, after these were evaluated.
    pub fn evaluate(&mut self, bodies: &Bodies, forces: AppliedForces<'_>) {
        for clump in &mut self.all {
            let mut sum = Wrench::zero();
            for member in &clump.members {
                let slot = bodies.slot[member.rank as usize] as usize;
                let wrench = ForceSum::alone(forces.contacts, slot, bodies.balls[slot].radius);
                sum.force += wrench.force;
                sum.torque += wrench.torque + (member.x - clump.x).cross(&wrench.force);
            }
            clump.contact = sum;
        }
    }

    /// Moves them through a substep, and gives their bodies the mean velocities of it: half kick,
    /// drift and prediction; with `finish` the half kick that ends the substep before comes first.
    pub fn begin(
        &mut self,
        bodies: &mut Bodies,
        forces: AppliedForces<'_>,
        (dt, finish): (f64, bool),
    ) {
        for clump in &mut self.all {
            let push = clump.push(bodies, forces);
            if finish {
                clump.kick(&push, 0.5 * dt);
            }
            clump.kick(&push, 0.5 * dt);
            let ahead = clump.momentum + push.torque * (0.5 * dt);
            clump.x += clump.v * dt;
            clump.orientation = clump.inertia.drift(clump.orientation, clump.momentum, dt);
            clump.predicted = Twist {
                v: clump.v + push.force * (0.5 * dt / clump.mass),
                w: clump.inertia.spin(clump.orientation, ahead),
            };
            let (axes, w) = (turned_axes(clump.orientation), clump.spin());
            for member in &mut clump.members {
                let to = clump.x + to_world(&axes, member.arm);
                let slot = bodies.slot[member.rank as usize] as usize;
                bodies.twists[slot] = Twist { v: (to - member.x) / dt, w };
                member.x = to;
            }
        }
    }

    /// Gives their bodies orientations, velocities, and those that are predicted, once these have
    /// moved.
    pub fn end(&self, bodies: &mut Bodies) {
        for clump in &self.all {
            for member in &clump.members {
                let slot = bodies.slot[member.rank as usize] as usize;
                bodies.orientation[slot] = product(clump.orientation, member.orientation);
                bodies.twists[slot] = clump.at(member, clump.velocities());
                bodies.predicted[slot] = clump.at(member, clump.predicted);
            }
        }
    }

    /// Half kick that ends a substep.
    pub fn second_half(&mut self, bodies: &mut Bodies, forces: AppliedForces<'_>, dt: f64) {
        for clump in &mut self.all {
            let push = clump.push(bodies, forces);
            clump.kick(&push, 0.5 * dt);
            for member in &clump.members {
                let slot = bodies.slot[member.rank as usize] as usize;
                bodies.twists[slot] = clump.at(member, clump.velocities());
            }
        }
    }
}

impl Clump {
    /// Rank of its first body.
    pub fn first(&self) -> u32 {
        self.members[0].rank
    }

    /// Centroid, in the image of its first body that is inside periodic faces [m].
    pub fn centroid(&self, bodies: &Bodies) -> Vec3 {
        let first = &self.members[0];
        self.x + (bodies.balls[bodies.slot[first.rank as usize] as usize].x - first.x)
    }

    /// Kinetic energy of translation and of rotation [J].
    pub fn energies(&self) -> [f64; 2] {
        [0.5 * self.mass * self.v.norm_squared(), 0.5 * self.momentum.dot(&self.spin())]
    }

    /// Pose and velocities of its centroid, in the image of its first body that is inside periodic
    /// faces.
    #[cfg(feature = "component")]
    pub fn state(&self, bodies: &Bodies) -> BodyState {
        BodyState {
            id: u64::from(self.first()),
            position: self.centroid(bodies).into(),
            orientation: self.orientation,
            velocity: self.v.into(),
            angular_velocity: self.spin().into(),
        }
    }

    /// Fluid load on the clump, about its centroid.
    #[cfg(feature = "component")]
    pub fn load(&self, bodies: &Bodies) -> Wrench {
        let mut sum = Wrench::zero();
        for member in &self.members {
            let load = &bodies.load[bodies.slot[member.rank as usize] as usize];
            sum.force += load.force;
            sum.torque += load.torque + (member.x - self.x).cross(&load.force);
        }
        sum
    }

    fn spin(&self) -> Vec3 {
        self.inertia.spin(self.orientation, self.momentum)
    }

    fn velocities(&self) -> Twist {
        Twist { v: self.v, w: self.spin() }
    }

    /// Velocities of one of its bodies, where the clump moves so.
    fn at(&self, member: &Member, Twist { v, w }: Twist) -> Twist {
        Twist { v: v + w.cross(&(member.x - self.x)), w }
    }

    /// Contacts, loads, weight and the drag of bands, about the centroid.
    fn push(&self, bodies: &Bodies, forces: AppliedForces<'_>) -> Wrench {
        let mut sum = self.contact;
        sum.force += forces.gravity * self.mass;
        if forces.bands.is_any() {
            let drag = forces.bands.acceleration_of_clump(self.x, self.predicted.v);
            sum.force += drag * self.mass;
        }
        for member in self.members.iter().filter(|_| forces.loaded) {
            let load = &bodies.load[bodies.slot[member.rank as usize] as usize];
            sum.force += load.force;
            sum.torque += load.torque + (member.x - self.x).cross(&load.force);
        }
        sum
    }

    fn kick(&mut self, push: &Wrench, dt: f64) {
        self.v += push.force * (dt / self.mass);
        self.momentum += push.torque * dt;
    }
}

/// The orientation of clumps at the start.
const UNTURNED: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// The rotation `b` and then `a`, as unit quaternions `(x, y, z, w)`.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let [ax, ay, az, aw] = a;
    let [bx, by, bz, bw] = b;
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::motion::prescribed_motion::turn;

    #[test]
    fn the_product_of_rotations_is_one_after_the_other() {
        let (first, then) = (Vec3::new(0.3, -0.2, 0.9), Vec3::new(-0.5, 0.4, 0.1));
        let unit = [0.0, 0.0, 0.0, 1.0];
        let expected = turn(turn(unit, first), then);
        let found = product(turn(unit, then), turn(unit, first));
        let error = (0..4).map(|a| (found[a] - expected[a]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-15, "{error}");
    }
}
