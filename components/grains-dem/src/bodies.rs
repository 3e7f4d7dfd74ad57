//! The state of all bodies, as arrays in the order of their ids, grouped by who reads them together.

use crate::Vec3;
use tremie_messages::scene::Motion;

/// A sphere in space: what the search for contacts reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    /// Centre [m].
    pub x: Vec3,
    /// Radius [m].
    pub radius: f64,
}

/// Velocity and angular velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Twist {
    /// Velocity of the centre [m/s].
    pub v: Vec3,
    /// Angular velocity [rad/s].
    pub w: Vec3,
}

impl Twist {
    pub fn zero() -> Self {
        Self { v: Vec3::zeros(), w: Vec3::zeros() }
    }
}

/// Force and torque about the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wrench {
    /// Force [N].
    pub force: Vec3,
    /// Torque [N·m].
    pub torque: Vec3,
}

impl Wrench {
    pub fn zero() -> Self {
        Self { force: Vec3::zeros(), torque: Vec3::zeros() }
    }
}

/// What resists acceleration; both 0 for a body whose motion is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mobility {
    /// `1/m` [1/kg].
    pub inverse_mass: f64,
    /// `1/(2/5 m R²)` [1/(kg·m²)].
    pub inverse_inertia: f64,
}

impl Mobility {
    /// That of a wall, or of a body whose motion is given.
    pub const NONE: Self = Self { inverse_mass: 0.0, inverse_inertia: 0.0 };

    /// Whether forces move the body.
    pub fn is_free(self) -> bool {
        self.inverse_mass > 0.0
    }
}

/// A sphere as it is placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedSphere {
    pub ball: Ball,
    pub twist: Twist,
    /// Mass [kg].
    pub mass: f64,
    pub motion: Motion,
    /// Index of its set in the scene.
    pub set: usize,
}

impl PlacedSphere {
    /// Its response to forces.
    pub fn mobility(&self) -> Mobility {
        if self.motion != Motion::Free {
            return Mobility::NONE;
        }
        let radius = self.ball.radius;
        Mobility {
            inverse_mass: 1.0 / self.mass,
            inverse_inertia: 1.0 / (0.4 * self.mass * radius * radius),
        }
    }
}

/// All bodies. Every array has one entry a body, in the order of ids.
#[derive(Clone, Debug)]
pub(crate) struct Bodies {
    /// Where they are. Between rebuilds of the neighbour lists a body may stand a little outside a
    /// periodic domain.
    pub balls: Vec<Ball>,
    /// Velocities: of the full step between substeps, of the half step within one.
    pub twists: Vec<Twist>,
    /// Velocities predicted for the end of the substep: those that forces see.
    pub predicted: Vec<Twist>,
    /// Contact forces of the last evaluation.
    pub contact: Vec<Wrench>,
    /// Fluid loads of this window.
    pub load: Vec<Wrench>,
    /// Inertia.
    pub mobility: Vec<Mobility>,
    /// Unit quaternions `(x, y, z, w)` from body to world frame.
    pub orientation: Vec<[f64; 4]>,
    /// Masses [kg].
    pub mass: Vec<f64>,
}

impl Bodies {
    pub fn new(spheres: &[PlacedSphere]) -> Self {
        let n = spheres.len();
        let twists: Vec<Twist> = spheres.iter().map(|s| s.twist).collect();
        Self {
            balls: spheres.iter().map(|s| s.ball).collect(),
            predicted: twists.clone(),
            twists,
            contact: vec![Wrench::zero(); n],
            load: vec![Wrench::zero(); n],
            mobility: spheres.iter().map(PlacedSphere::mobility).collect(),
            orientation: vec![[0.0, 0.0, 0.0, 1.0]; n],
            mass: spheres.iter().map(|s| s.mass).collect(),
        }
    }

    pub fn len(&self) -> usize {
        self.balls.len()
    }
}
