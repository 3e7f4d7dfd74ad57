//! Assembly of clumps from the bodies that a scene joins, with their numbers for bounds of time
//! steps and for checks.

use super::{Clump, Clumps, Member, UNTURNED};
use crate::Vec3;
use crate::bodies::body_arrays::{PlacedSphere, Twist, Wrench};
use crate::polyhedra::{Inertia, Shape, to_world, turned_axes};
use crate::solver::placement::{self, OF_SPHERE};
use nalgebra::Matrix3;
use tremie_geometry::principal;
use tremie_grains_kit::signals::followed::clump_numbers;
use tremie_messages::scene::Scene;

/// A clump as it bounds time steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Whole {
    /// Its number.
    pub number: u32,
    /// Mass [kg].
    pub mass: f64,
    /// Mass that one of the contacts of its bodies has to move, at least [kg]: less than the mass
    /// where a push is beside the centroid, and where all of its bodies touch something at once.
    pub felt: f64,
}

/// The clump of each set of a scene that is right.
pub(crate) fn wholes(scene: &Scene) -> Vec<Option<Whole>> {
    let (numbers, count) = clump_numbers(scene);
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

/// Deviation of a body of a clump, at the start, from the rigid motion with the momenta of all.
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

impl Clumps {
    /// Clumps that bodies were placed in; masses and moments of inertia are sums over the bodies,
    /// or over their shares of the union. They begin with the momentum and the angular momentum of
    /// their bodies.
    pub fn of_placed(scene: &Scene, placed: &[PlacedSphere]) -> Self {
        let shapes = shapes(scene);
        let (_, count) = clump_numbers(scene);
        let mut bodies = vec![Vec::new(); count];
        for (rank, body) in (0..).zip(placed) {
            if let Some(clump) = body.clump {
                bodies[clump.number as usize].push((rank, body));
            }
        }
        Self { all: bodies.iter().filter_map(|own| Clump::of(own, &shapes)).collect() }
    }
}

impl Clump {
    /// Clump of bodies with their ranks; `None` without any.
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
                // Parallel-axis theorem.
                let around = (unit * arm.norm_squared() - arm * arm[a]) * body.mass;
                let own = own_inertia(body, shapes, unit) + around;
                row.iter_mut().zip(own.iter()).for_each(|(sum, more)| *sum += more);
            }
        }
        let (moments, axes) = principal(&Matrix3::from(tensor).transpose());
        let inertia = Inertia { moments, axes };
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

    /// See [`Whole::felt`]. A push along n at r moves its place `1 + M (r x n) . I^-1 (r x n)`
    /// times as much as one at the centroid. Pushes on spheres are along their radii, those on
    /// polyhedra may have any direction, over which this is an eigenvalue, and is largest at a
    /// corner; so are those of friction, which a sphere by itself answers with 3.5. Each further
    /// body that touches at once adds as much as a push at the centroid.
    fn felt(&self, placed: &[PlacedSphere], shapes: &[Shape]) -> f64 {
        let along = |r: Vec3, n: Vec3| {
            let arm = r.cross(&n);
            1.0 + self.mass * arm.dot(&self.inertia.spin(UNTURNED, arm))
        };
        let worst = |r: Vec3| {
            let columns = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| r.cross(&n));
            let turned = columns.map(|column| self.inertia.spin(UNTURNED, column));
            let (most, _) = principal(&Matrix3::from_fn(|a, b| columns[a].dot(&turned[b])));
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

    /// Body whose start deviates most from the rigid motion, with that deviation.
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

    /// Extent of its bodies along an axis, from centre to centre [m].
    pub fn extent(&self, axis: usize) -> f64 {
        let ends =
            self.members.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], member| {
                [a.min(member.arm[axis]), b.max(member.arm[axis])]
            });
        ends[1] - ends[0]
    }
}

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
        return share.inertia * v * (body.mass / share.volume);
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
