//! Clumps: bodies that are joined rigidly, and move as one.
//!
//! Each body of a clump stays a body: contacts and fluid act on it as on any other, but for contacts within
//! the clump, which are none. The clump sums up what acts on its bodies, moves by that as a polyhedron does,
//! and tells each body how fast to go: so that lists and periodic faces need to know no more of clumps than that.

use crate::Vec3;
use crate::bodies::body_arrays::{Bodies, PlacedSphere, Twist, Wrench};
use crate::polyhedra::{Inertia, Shape, to_world, turned_axes};
use crate::solver::force_sum::ForceSum;
use crate::solver::integrate::AppliedForces;
use crate::solver::placement::{self, OF_SPHERE};
use std::collections::BTreeMap;
use tremie_geometry::principal;
#[cfg(feature = "component")]
use tremie_messages::BodyState;
use tremie_messages::scene::{BodySet, Scene};

/// The number of the clump of each set, in the order in which sets name them, and how many there are.
pub(crate) fn numbers(scene: &Scene) -> (Vec<Option<u32>>, usize) {
    let mut known = BTreeMap::new();
    let of = |set: &BodySet| {
        let next = known.len() as u32;
        Some(*known.entry(set.clump.clone()?).or_insert(next))
    };
    let numbers = scene.bodies.iter().map(of).collect();
    (numbers, known.len())
}

/// A clump, as those see it who bound time steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Whole {
    /// Its number.
    pub number: u32,
    /// Mass [kg].
    pub mass: f64,
    /// Mass that one of the contacts of its bodies has to move, at least [kg]: less than the mass where a push is beside
    /// the centroid, and where all of its bodies touch something at once.
    pub felt: f64,
}

/// The clump of each set of a scene that is right.
pub(crate) fn wholes(scene: &Scene) -> Vec<Option<Whole>> {
    let (numbers, count) = numbers(scene);
    if count == 0 {
        return vec![None; numbers.len()];
    }
    let placed = placement::listed(scene);
    let (clumps, shapes) = (Clumps::of_placed(scene, &placed), shapes(scene));
    let felt: Vec<f64> = clumps.all.iter().map(|clump| clump.felt(&placed, &shapes)).collect();
    let of = |number: Option<u32>| {
        let number = number?;
        let clump = clumps.all.get(number as usize)?;
        Some(Whole { number, mass: clump.mass, felt: felt[number as usize] })
    };
    numbers.into_iter().map(of).collect()
}

/// The clumps of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clumps {
    all: Vec<Clump>,
}

/// Bodies that move as one.
#[derive(Clone, Debug)]
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
    /// Of the contacts of all its bodies, about the centroid, at the last evaluation.
    contact: Wrench,
}

/// How a body of a clump begins, beside the rigid motion that has the momenta of all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Misfit {
    /// Rank of the body.
    pub rank: u32,
    /// Velocity of its centre in the rigid motion [m/s].
    pub expected: Vec3,
    /// Largest difference of velocities, at the centre or of a turn at the surface [m/s].
    pub apart: f64,
    /// Largest velocity that was compared [m/s].
    pub scale: f64,
}

/// A body of a clump.
#[derive(Clone, Copy, Debug)]
struct Member {
    rank: u32,
    /// From the centroid, in the frame of the clump [m].
    arm: Vec3,
    /// Unit quaternion from the body's frame to the clump's.
    orientation: [f64; 4],
    /// Where it is, as the clump's centroid counts.
    x: Vec3,
}

impl Clumps {
    /// Those that bodies were placed in; masses and moments of inertia are sums over the bodies, or over their shares of
    /// the union. They begin with the momentum and the angular momentum of their bodies.
    pub fn of_placed(scene: &Scene, placed: &[PlacedSphere]) -> Self {
        let shapes = shapes(scene);
        let (_, count) = numbers(scene);
        let mut bodies = vec![Vec::new(); count];
        for (rank, body) in (0..).zip(placed) {
            if let Some(clump) = body.clump {
                bodies[clump.number as usize].push((rank, body));
            }
        }
        Self { all: bodies.iter().filter_map(|own| Clump::of(own, &shapes)).collect() }
    }

    /// All of them.
    pub fn all(&self) -> &[Clump] {
        &self.all
    }

    /// Sums up what contacts do, after these were evaluated.
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

    /// Moves them through a substep, and gives their bodies the mean velocities of it: half kick, drift and
    /// prediction; with `finish` the half kick that ends the substep before comes first.
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

    /// Gives their bodies orientations, velocities, and those that are predicted, once these have moved.
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
    /// Of bodies with their ranks; `None` without any.
    fn of(placed: &[(u32, &PlacedSphere)], shapes: &[Shape]) -> Option<Self> {
        let mass: f64 = placed.iter().map(|(_, body)| body.mass).sum();
        let sum = |of: &dyn Fn(&PlacedSphere) -> Vec3| {
            placed.iter().fold(Vec3::zeros(), |sum, (_, body)| sum + of(body))
        };
        let x = sum(&|body| middle(body) * body.mass) / mass;
        let v = sum(&|body| velocity(body) * body.mass) / mass;
        let momentum = sum(&|body| {
            own_momentum(body, shapes) + (middle(body) - x).cross(&(velocity(body) * body.mass))
        });
        let mut tensor = [[0.0; 3]; 3];
        for (_, body) in placed {
            for (a, row) in tensor.iter_mut().enumerate() {
                let unit = Vec3::from_fn(|b, _| f64::from(a == b));
                let arm = middle(body) - x;
                let around = (unit * arm.norm_squared() - arm * arm[a]) * body.mass;
                let own = own_inertia(body, shapes, unit) + around;
                row.iter_mut().zip(own.iter()).for_each(|(sum, more)| *sum += more);
            }
        }
        let (moments, axes) = principal(tensor);
        let inertia = Inertia { moments, axes: axes.map(Vec3::from) };
        let member = |&(rank, body): &(u32, &PlacedSphere)| Member {
            rank,
            arm: body.ball.x - x,
            orientation: body.solid.map_or(UNTURNED, |solid| solid.orientation),
            x: body.ball.x,
        };
        let w = inertia.spin(UNTURNED, momentum);
        (mass > 0.0).then(|| Self {
            members: placed.iter().map(member).collect(),
            mass,
            inertia,
            x,
            orientation: UNTURNED,
            v,
            momentum,
            predicted: Twist { v, w },
            contact: Wrench::zero(),
        })
    }

    /// See [`Whole::felt`]. A push along n at r moves its place `1 + M (r x n) . I^-1 (r x n)` times as much as one at
    /// the centroid. Pushes on spheres are along their radii, those on polyhedra may have any direction, over which this is
    /// an eigenvalue, and is largest at a corner; so are those of friction, which a sphere by itself answers
    /// with 3.5. Each further body that touches at once adds as much as a push at the centroid.
    fn felt(&self, placed: &[PlacedSphere], shapes: &[Shape]) -> f64 {
        let along = |r: Vec3, n: Vec3| {
            let arm = r.cross(&n);
            1.0 + self.mass * arm.dot(&self.inertia.spin(UNTURNED, arm))
        };
        let worst = |r: Vec3| {
            let columns = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| r.cross(&n));
            let turned = columns.map(|column| self.inertia.spin(UNTURNED, column));
            let (most, _) = principal(columns.map(|a| turned.map(|b| a.dot(&b))));
            1.0 + self.mass * most.into_iter().fold(0.0, f64::max)
        };
        let (mut normal, mut any) = (1.0f64, 1.0f64);
        for member in &self.members {
            let body = &placed[member.rank as usize];
            for point in surface_points(body, shapes) {
                let r = member.arm + point;
                any = any.max(worst(r));
                let length = point.norm_squared().sqrt();
                let pushed = if body.solid.is_some() { any } else { along(r, point / length) };
                normal = normal.max(pushed);
            }
        }
        let at_once = self.members.len() as f64 - 1.0;
        self.mass / (normal + at_once).max(any / OF_SPHERE)
    }

    /// Which of its bodies begins least like a part of a rigid motion, and how far from it.
    pub fn misfit(&self, placed: &[PlacedSphere]) -> Misfit {
        let of = |member: &Member| {
            let (expected, body) =
                (self.at(member, self.velocities()), &placed[member.rank as usize]);
            let radius = body.ball.radius;
            let size = |twist: &Twist| {
                let [v, w] = [twist.v, twist.w].map(|u| u.norm_squared().sqrt());
                v.max(w * radius)
            };
            let apart = Twist { v: expected.v - body.twist.v, w: expected.w - body.twist.w };
            Misfit {
                rank: member.rank,
                expected: expected.v,
                apart: size(&apart),
                scale: size(&expected).max(size(&body.twist)),
            }
        };
        let worst = |a: Misfit, b: Misfit| if b.apart > a.apart { b } else { a };
        self.members[1..].iter().map(of).fold(of(&self.members[0]), worst)
    }

    /// How far its bodies reach along an axis, from centre to centre [m].
    pub fn extent(&self, axis: usize) -> f64 {
        let ends =
            self.members.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], member| {
                [a.min(member.arm[axis]), b.max(member.arm[axis])]
            });
        ends[1] - ends[0]
    }

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

    /// Pose and velocities of its centroid, in the image of its first body that is inside periodic faces.
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

    /// What a fluid does to it, about its centroid.
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

    /// What a body of it does, where it moves so.
    fn at(&self, member: &Member, Twist { v, w }: Twist) -> Twist {
        Twist { v: v + w.cross(&(member.x - self.x)), w }
    }

    /// Contacts, loads and weight, about the centroid.
    fn push(&self, bodies: &Bodies, forces: AppliedForces<'_>) -> Wrench {
        let mut sum = self.contact;
        sum.force += forces.gravity * self.mass;
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

fn shapes(scene: &Scene) -> Vec<Shape> {
    scene.shapes.iter().filter_map(|shape| Shape::of(shape).ok()).collect()
}

/// Corners of a polyhedron from its centroid, or points on a sphere [m].
fn surface_points(body: &PlacedSphere, shapes: &[Shape]) -> Vec<Vec3> {
    if let Some(solid) = body.solid {
        let axes = turned_axes(solid.orientation);
        let corners = shapes[solid.shape as usize].vertices.iter();
        return corners.map(|v| to_world(&axes, *v * solid.size)).collect();
    }
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let ways = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    let ways = ways.map(Vec3::from).filter(|way| way.norm_squared() > 0.0);
    ways.map(|way| way * (body.ball.radius / way.norm_squared().sqrt())).collect()
}

/// Centre of a body's mass [m]: of its share of a union, where it is one's.
fn middle(body: &PlacedSphere) -> Vec3 {
    body.share.map_or(body.ball.x, |share| body.ball.x + Vec3::from(share.centroid))
}

/// Velocity there [m/s].
fn velocity(body: &PlacedSphere) -> Vec3 {
    body.twist.v + body.twist.w.cross(&(middle(body) - body.ball.x))
}

/// Inertia of a body about the centre of its mass, times a vector [kg·m²].
fn own_inertia(body: &PlacedSphere, shapes: &[Shape], v: Vec3) -> Vec3 {
    if let Some(share) = body.share {
        let rows = share.inertia.map(|row| Vec3::from(row).dot(&v));
        return Vec3::from(rows) * (body.mass / share.volume);
    }
    match body.solid {
        None => v * (0.4 * body.mass * body.ball.radius * body.ball.radius),
        Some(solid) => {
            let inertia = shapes[solid.shape as usize].inertia_of(body.mass, solid.size);
            inertia.momentum(solid.orientation, v)
        }
    }
}

fn own_momentum(body: &PlacedSphere, shapes: &[Shape]) -> Vec3 {
    own_inertia(body, shapes, body.twist.w)
}

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
    use crate::bodies::prescribed_motion::turn;

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
