//! A rigid body as the gas sees it.

use serde::{Deserialize, Serialize};

/// How a body's surface holds gas and heat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceHeat {
    /// It takes no heat.
    Adiabatic,
    /// It has a temperature [K].
    Isothermal(f64),
}

/// A rigid body whose surface the gas meets.
pub trait GasBody: Sync {
    /// Distance of a point from the surface, positive outside [m], and the outward normal there.
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]);
    /// Velocity of the body's material at a point [m/s].
    fn velocity(&self, at: [f64; 3]) -> [f64; 3];
    /// A point seen from the one that torques are about [m].
    fn arm(&self, at: [f64; 3]) -> [f64; 3];
    /// What becomes of heat.
    fn heat(&self) -> SurfaceHeat {
        SurfaceHeat::Adiabatic
    }
}

/// A disc or a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre [m]; 0 along axes that are not there.
    pub centre: [f64; 3],
    /// Radius [m].
    pub radius: f64,
    /// Velocity of the centre [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [1/s].
    pub spin: [f64; 3],
}

impl GasBody for Ball {
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]) {
        ball_height(self.arm(at), self.radius)
    }

    fn velocity(&self, at: [f64; 3]) -> [f64; 3] {
        let turn = cross(self.spin, self.arm(at));
        std::array::from_fn(|a| self.velocity[a] + turn[a])
    }

    fn arm(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| at[a] - self.centre[a])
    }
}

/// Everything below a plane: a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// A point of the plane [m].
    pub point: [f64; 3],
    /// Normal, of length 1, towards the gas.
    pub normal: [f64; 3],
    /// Velocity [m/s].
    pub velocity: [f64; 3],
    /// What becomes of heat.
    pub heat: SurfaceHeat,
}

impl GasBody for HalfSpace {
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]) {
        half_space_height(self.arm(at), self.normal)
    }

    fn velocity(&self, _: [f64; 3]) -> [f64; 3] {
        self.velocity
    }

    fn arm(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| at[a] - self.point[a])
    }

    fn heat(&self) -> SurfaceHeat {
        self.heat
    }
}

/// Distance of a point from a ball's surface, and the normal there; the point is seen from the
/// centre.
pub fn ball_height(apart: [f64; 3], radius: f64) -> (f64, [f64; 3]) {
    let distance = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
    // The centre has no direction, and nothing depends on one there.
    let normal = if distance > 0.0 { apart.map(|x| x / distance) } else { [1.0, 0.0, 0.0] };
    (distance - radius, normal)
}

/// Distance of a point from a half space's surface, and its normal; the point is seen from one of the
/// surface.
pub fn half_space_height(apart: [f64; 3], normal: [f64; 3]) -> (f64, [f64; 3]) {
    ((0..3).map(|a| apart[a] * normal[a]).sum(), normal)
}

/// Cross product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Force [N] and torque about a body's centre [N m]; in fewer dimensions for each metre across.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyLoad {
    /// Force.
    pub force: [f64; 3],
    /// Torque.
    pub torque: [f64; 3],
}

impl BodyLoad {
    /// Adds a force that acts at a point, seen from the centre.
    pub fn add(&mut self, force: [f64; 3], arm: [f64; 3]) {
        self.add_all(Self { force, torque: cross(arm, force) });
    }

    /// Adds another load about the same centre.
    pub fn add_all(&mut self, other: Self) {
        self.add_share(other, 1.0);
    }

    /// Adds a share of another load about the same centre.
    pub fn add_share(&mut self, other: Self, share: f64) {
        for a in 0..3 {
            self.force[a] += share * other.force[a];
            self.torque[a] += share * other.torque[a];
        }
    }
}
