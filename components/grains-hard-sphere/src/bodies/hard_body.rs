//! A sphere or disc on a path of constant acceleration.

use crate::Vec3;
use crate::impact::collision::Collider;
use tremie_state::{StateError, StateExchange};

/// A body with its path: where it was at `time`, and how it goes on from there. What the search for
/// collisions reads comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct HardBody {
    /// Centre at `time` [m].
    pub x: Vec3,
    /// Velocity at `time` [m/s].
    pub v: Vec3,
    /// Moment from which the path runs, within the window or step [s].
    pub time: f64,
    /// Radius [m].
    pub radius: f64,
    /// Acceleration along the path [m/s²].
    pub a: Vec3,
    /// `1/m` [1/kg]; 0 of a body whose motion is given.
    pub inverse_mass: f64,
    /// Angular velocity at `time` [rad/s].
    pub w: Vec3,
    /// Moment of its last collision, on the clock of `time` [s].
    pub last_hit: f64,
    /// Angular acceleration along the path [rad/s²].
    pub alpha: Vec3,
    /// Number of its collisions: what was foreseen with another number does not come true.
    pub stamp: u32,
    /// Number of its material.
    pub material: u16,
    /// It had more collisions in this step than are resolved, and stays where it is until the step
    /// ends.
    pub is_stopped: bool,
    /// A contact that lasts carried it in this step.
    pub rests: bool,
}

/// No collision yet.
pub const NEVER: f64 = f64::NEG_INFINITY;

impl HardBody {
    /// A free body at rest, of a material.
    pub fn new(x: Vec3, radius: f64, mass: f64, material: u16) -> Self {
        Self {
            x,
            v: Vec3::zeros(),
            time: 0.0,
            radius,
            a: Vec3::zeros(),
            inverse_mass: 1.0 / mass,
            w: Vec3::zeros(),
            last_hit: NEVER,
            alpha: Vec3::zeros(),
            stamp: 0,
            material,
            is_stopped: false,
            rests: false,
        }
    }

    /// True if collisions move it.
    #[inline(always)]
    pub fn is_free(&self) -> bool {
        self.inverse_mass > 0.0
    }

    /// Velocity with which it goes along its path at `time` [m/s].
    #[inline(always)]
    pub fn path_velocity(&self) -> Vec3 {
        if self.is_stopped { Vec3::zeros() } else { self.v }
    }

    /// Centre at a moment [m].
    #[inline(always)]
    pub fn position(&self, moment: f64) -> Vec3 {
        let s = moment - self.time;
        self.x + self.path_velocity() * s + self.a * (0.5 * s * s)
    }

    /// Velocity along the path at a moment [m/s].
    #[inline(always)]
    pub fn velocity(&self, moment: f64) -> Vec3 {
        self.path_velocity() + self.a * (moment - self.time)
    }

    /// Goes on to a moment; what it does later does not change.
    #[inline]
    pub fn advance(&mut self, moment: f64) {
        let s = moment - self.time;
        self.x = self.position(moment);
        self.v += self.a * s;
        self.w += self.alpha * s;
        self.time = moment;
    }

    /// As a partner in a collision at `time`.
    #[inline(always)]
    pub fn collider(&self) -> Collider {
        Collider {
            v: self.v,
            w: self.w,
            radius: self.radius,
            lever: self.radius,
            inverse_mass: self.inverse_mass,
        }
    }

    /// Takes the velocities that a collision at a moment gave.
    #[inline(always)]
    pub fn take(&mut self, after: &Collider, moment: f64) {
        (self.v, self.w) = (after.v, after.w);
        self.last_hit = moment;
        self.stamp = self.stamp.wrapping_add(1);
    }
}

/// Keeps bodies, or puts them back.
///
/// # Errors
/// A state of other bodies.
pub fn exchange(bodies: &mut [HardBody], state: &mut StateExchange<'_>) -> Result<(), StateError> {
    state.column("position", bodies, |b| b.x.into(), |b, x: [f64; 3]| b.x = x.into())?;
    state.column("velocity", bodies, |b| b.v.into(), |b, v: [f64; 3]| b.v = v.into())?;
    state.column("time", bodies, |b| b.time, |b, time| b.time = time)?;
    state.column("radius", bodies, |b| b.radius, |b, radius| b.radius = radius)?;
    state.column("acceleration", bodies, |b| b.a.into(), |b, a: [f64; 3]| b.a = a.into())?;
    state.column("inverse_mass", bodies, |b| b.inverse_mass, |b, mass| b.inverse_mass = mass)?;
    state.column("angular_velocity", bodies, |b| b.w.into(), |b, w: [f64; 3]| b.w = w.into())?;
    state.column("last_hit", bodies, |b| b.last_hit, |b, moment| b.last_hit = moment)?;
    state.column(
        "angular_acceleration",
        bodies,
        |b| b.alpha.into(),
        |b, alpha: [f64; 3]| b.alpha = alpha.into(),
    )?;
    state.column("collisions", bodies, |b| b.stamp, |b, stamp| b.stamp = stamp)?;
    state.column("material", bodies, |b| b.material, |b, material| b.material = material)?;
    state.column(
        "stopped_rests",
        bodies,
        |b| [b.is_stopped, b.rests].map(u8::from),
        |b, flags: [u8; 2]| [b.is_stopped, b.rests] = flags.map(|flag| flag != 0),
    )
}
