//! Rigid bodies in the fluid: shape, place, motion, and what they yield to.

use crate::pressure::body_coupling::Wrench;
use crate::solids::ball_overlap::{disc_in_rectangle, segment_in_ball, sphere_in_box};
use crate::solids::half_spaces::{Covered, HalfSpaces};
use crate::solids::surface_solid::SurfaceSolid;
use std::f64::consts::PI;

/// Shape of a body, where it is.
#[derive(Clone, Debug)]
pub enum BodyShape<const D: usize> {
    /// A disc (two dimensions) or sphere (three) about the body's centre, of a radius [m].
    Ball(f64),
    /// A convex solid.
    Convex {
        /// Its half spaces.
        solid: Box<HalfSpaces<D>>,
        /// Radius about the body's centre that holds it [m]; infinite if none does.
        reach: f64,
        /// Least distance of two planes that hold it [m].
        width: f64,
        /// Volume, in two dimensions area of the section [m³, m²].
        volume: f64,
    },
    /// A triangulated surface.
    Surface {
        /// The surface where it is.
        solid: SurfaceSolid<D>,
        /// Volume, in two dimensions area of the section [m³, m²].
        volume: f64,
    },
}

/// Answer of a body to a force.
#[derive(Clone, Debug, PartialEq)]
pub enum Freedom {
    /// None: it moves as prescribed.
    Prescribed,
    /// It moves with its mass [kg] (in two dimensions per metre of depth [kg/m]), and turns by the
    /// inverse of its inertia about its centre in the grid's frame [1/(kg m²)].
    Free {
        /// Mass.
        mass: f64,
        /// Inverse of the inertia.
        inverse_inertia: [[f64; 3]; 3],
    },
    /// It moves along an axis, with the mass of all that moves.
    Slider {
        /// Unit vector, in the grid's frame.
        axis: [f64; 3],
        /// Mass.
        mass: f64,
    },
}

/// A body in the fluid.
#[derive(Clone, Debug)]
pub struct RigidBody<const D: usize> {
    /// Its centre: of mass if it is free, else the point about which torques count [m].
    pub centre: [f64; D],
    /// Shape.
    pub shape: BodyShape<D>,
    /// Velocity of the centre [m/s].
    pub velocity: [f64; D],
    /// Angular velocity [rad/s]; in two dimensions the last component counts.
    pub spin: [f64; 3],
    /// Answer to forces.
    pub freedom: Freedom,
    /// Forces besides the fluid's, without weight [N], in two dimensions [N/m].
    pub force: [f64; D],
    /// Number by which it is known from one step to the next.
    pub id: u64,
}

/// `a x b` in three dimensions; in two, of which only the first components count, its last entry.
#[inline]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Vector with zeros for what is missing to three components.
#[inline]
pub fn padded<const D: usize>(v: [f64; D]) -> [f64; 3] {
    std::array::from_fn(|a| if a < D { v[a] } else { 0.0 })
}

impl<const D: usize> RigidBody<D> {
    /// A ball at rest that moves by no force.
    pub fn ball(centre: [f64; D], radius: f64) -> Self {
        Self::at(centre, BodyShape::Ball(radius))
    }

    /// A body of a shape, at rest, that moves by no force.
    pub fn at(centre: [f64; D], shape: BodyShape<D>) -> Self {
        Self {
            centre,
            shape,
            velocity: [0.0; D],
            spin: [0.0; 3],
            freedom: Freedom::Prescribed,
            force: [0.0; D],
            id: 0,
        }
    }

    /// The same ball, free to move, of a mass [kg], in two dimensions [kg/m].
    pub fn with_mass(mut self, mass: f64) -> Self {
        let BodyShape::Ball(radius) = self.shape else { return self };
        let factor = if D == 2 { 0.5 } else { 0.4 };
        let inverse = 1.0 / (factor * mass * radius * radius);
        let mut inverse_inertia = [[0.0; 3]; 3];
        (0..3).for_each(|k| inverse_inertia[k][k] = inverse);
        self.freedom = Freedom::Free { mass, inverse_inertia };
        self
    }

    /// True if forces move it.
    #[inline]
    pub fn is_free(&self) -> bool {
        self.freedom != Freedom::Prescribed
    }

    /// Mass of a body that forces move [kg].
    pub fn mass(&self) -> Option<f64> {
        match self.freedom {
            Freedom::Prescribed => None,
            Freedom::Free { mass, .. } | Freedom::Slider { mass, .. } => Some(mass),
        }
    }

    /// Velocities of the body, as a wrench has its entries.
    pub fn motion(&self) -> Wrench {
        let (u, w) = (padded(self.velocity), self.spin);
        [u[0], u[1], u[2], w[0], w[1], w[2]]
    }

    /// Velocity of the body at a point [m/s].
    #[inline]
    pub fn velocity_at(&self, point: [f64; D]) -> [f64; D] {
        let arm = padded::<D>(std::array::from_fn(|a| point[a] - self.centre[a]));
        let turn = cross(self.spin, arm);
        std::array::from_fn(|a| self.velocity[a] + turn[a])
    }

    /// What a wrench of `q` changes its velocities by, `full` being the mass of a cell full of
    /// fluid.
    pub fn mobility(&self, full: f64) -> [[f64; 6]; 6] {
        let mut mobility = self.mobility_by_shear(full);
        // A ball feels no torque of a pressure.
        if self.is_round() {
            mobility[3..].fill([0.0; 6]);
        }
        mobility
    }

    /// The same of a wrench of shear, which turns balls too.
    pub fn mobility_by_shear(&self, full: f64) -> [[f64; 6]; 6] {
        let mut mobility = [[0.0; 6]; 6];
        match &self.freedom {
            Freedom::Prescribed => {}
            Freedom::Free { mass, inverse_inertia } => {
                for a in 0..D {
                    mobility[a][a] = full / mass;
                }
                for i in 0..3 {
                    for j in 0..3 {
                        mobility[3 + i][3 + j] = full * inverse_inertia[i][j];
                    }
                }
            }
            Freedom::Slider { axis, mass } => {
                for i in 0..3 {
                    for j in 0..3 {
                        mobility[i][j] = full / mass * axis[i] * axis[j];
                    }
                }
            }
        }
        mobility
    }

    /// True if it is a ball.
    #[inline]
    pub fn is_round(&self) -> bool {
        matches!(self.shape, BodyShape::Ball(_))
    }

    /// Volume, in two dimensions area [m³, m²].
    pub fn volume(&self) -> f64 {
        match &self.shape {
            BodyShape::Ball(radius) if D == 2 => PI * radius * radius,
            BodyShape::Ball(radius) => 4.0 / 3.0 * PI * radius * radius * radius,
            BodyShape::Convex { volume, .. } | BodyShape::Surface { volume, .. } => *volume,
        }
    }

    /// Lower and upper corner of a box around it [m].
    pub fn bounds(&self) -> [[f64; D]; 2] {
        let about =
            |radius: f64| [self.centre.map(|x| x - radius), self.centre.map(|x| x + radius)];
        match &self.shape {
            BodyShape::Ball(radius) => about(*radius),
            BodyShape::Convex { reach, .. } => about(*reach),
            BodyShape::Surface { solid, .. } if solid.surface.is_cavity() => about(f64::INFINITY),
            BodyShape::Surface { solid, .. } => {
                let bounds = solid.bounds();
                [bounds.min, bounds.max].map(|corner| solid.section.along(corner.into()))
            }
        }
    }

    /// Distance of a point, negative inside, and the outward normal; `None` if the surface is
    /// farther than `reach`.
    #[inline]
    pub fn height(&self, point: [f64; D], reach: f64) -> Option<(f64, [f64; D])> {
        match &self.shape {
            BodyShape::Ball(radius) => {
                let arm: [f64; D] = std::array::from_fn(|a| point[a] - self.centre[a]);
                let distance = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
                let inverse = if distance > 0.0 { 1.0 / distance } else { 0.0 };
                Some((distance - radius, arm.map(|x| x * inverse)))
            }
            BodyShape::Convex { solid, .. } => Some(solid.height(point)),
            BodyShape::Surface { solid, .. } => solid.height(point, reach),
        }
    }

    /// True if a point is inside.
    #[inline]
    pub fn holds(&self, point: [f64; D]) -> bool {
        match &self.shape {
            BodyShape::Surface { solid, .. } => solid.holds(point),
            _ => self.height(point, 0.0).is_some_and(|(height, _)| height <= 0.0),
        }
    }

    /// Part of a segment from outside at which it enters the body, if it does and the body may be
    /// thinner than a cell of edge `h`.
    pub fn entered(&self, from: [f64; D], to: [f64; D], h: f64) -> Option<f64> {
        match &self.shape {
            BodyShape::Ball(_) => None,
            BodyShape::Convex { width, .. } if *width > 2.0 * h => None,
            BodyShape::Convex { solid, .. } => solid.span(from, to).map(|[first, _]| first),
            BodyShape::Surface { solid, .. } => solid.first_met(from, to),
        }
    }

    /// Covered part of the lower face across an axis of a cell with this lower corner. The centre
    /// of what a ball covers is not needed, and not told.
    pub fn face(&self, axis: usize, lower: [f64; D], h: f64) -> Covered<D> {
        match &self.shape {
            BodyShape::Ball(radius) => {
                let share = ball_on_face(*radius, self.centre, axis, lower, h);
                Covered { share, centre: self.centre }
            }
            BodyShape::Convex { solid, .. } => solid.face(axis, lower, h),
            BodyShape::Surface { solid, .. } => solid.face(axis, lower, h),
        }
    }

    /// Covered share of a cell with this lower corner.
    pub fn cell(&self, lower: [f64; D], h: f64) -> f64 {
        match &self.shape {
            BodyShape::Ball(radius) => ball_in_cell(*radius, self.centre, lower, h),
            BodyShape::Convex { solid, .. } => solid.cell(lower, h),
            BodyShape::Surface { solid, .. } => solid.cell(lower, h),
        }
    }
}

fn ball_on_face<const D: usize>(
    radius: f64,
    centre: [f64; D],
    axis: usize,
    lower: [f64; D],
    h: f64,
) -> f64 {
    let from: [f64; D] = std::array::from_fn(|a| lower[a] - centre[a]);
    let distance2 = from[axis] * from[axis];
    let across = |k: usize| (0..D).filter(|&a| a != axis).nth(k).map_or(0.0, |a| from[a]);
    match D {
        2 => segment_in_ball(radius, distance2, across(0), across(0) + h) / h,
        _ => {
            let radius2 = radius * radius - distance2;
            if radius2 <= 0.0 {
                return 0.0;
            }
            let lower = [across(0), across(1)];
            disc_in_rectangle(radius2.sqrt(), lower, lower.map(|x| x + h)) / (h * h)
        }
    }
}

fn ball_in_cell<const D: usize>(radius: f64, centre: [f64; D], lower: [f64; D], h: f64) -> f64 {
    let from: [f64; D] = std::array::from_fn(|a| lower[a] - centre[a]);
    match D {
        2 => {
            let lower = [from[0], from[1]];
            disc_in_rectangle(radius, lower, lower.map(|x| x + h)) / (h * h)
        }
        _ => {
            let lower = [from[0], from[1], from[D - 1]];
            sphere_in_box(radius, lower, lower.map(|x| x + h)) / (h * h * h)
        }
    }
}
