//! A free body that the fluid's shear drags along, eliminated from the equations of the faces.
//!
//! The links to the body pull it with `g - K U`, where `g = sum k a u` over links of stiffness `k`
//! and arms `a`, and `K = sum k a a^T`. So its velocities at the end of the step are
//!
//! ```text
//! U = U0 + S (g - K U)        U = B (U0 + S g),   B = (1 + S K)^-1
//! ```
//!
//! with the mobility `S`. What faces feel of `B S g` makes their equations a Schur complement, which
//! stays symmetric and positive.

use crate::pressure::body_coupling::{Wrench, dot6};
use nalgebra::{Matrix6, Vector6};

/// A free body, and its links of one component.
#[derive(Clone, Copy, Debug)]
pub struct DraggedBody {
    /// Velocity and angular velocity.
    pub motion: Wrench,
    /// `g`, and then what follows from it.
    pub pull: Wrench,
    mobility: Matrix6<f64>,
    stiffness: Matrix6<f64>,
    /// `B`.
    slowed: Matrix6<f64>,
}

impl DraggedBody {
    /// Of a motion, and a mobility by which impulses change it.
    pub fn new(motion: Wrench, mobility: [[f64; 6]; 6]) -> Self {
        Self {
            motion,
            pull: [0.0; 6],
            mobility: Matrix6::from_fn(|row, column| mobility[row][column]),
            stiffness: Matrix6::zeros(),
            slowed: Matrix6::identity(),
        }
    }

    /// Forgets all links; `rotation` drags its rotation besides.
    pub fn begin(&mut self, rotation: f64) {
        self.stiffness = Matrix6::zeros();
        (3..6).for_each(|k| self.stiffness[(k, k)] = rotation);
    }

    /// Adds a link of a stiffness and an arm.
    pub fn add_link(&mut self, stiffness: f64, arm: &Wrench) {
        let arm = Vector6::from(*arm);
        self.stiffness += stiffness * arm * arm.transpose();
    }

    /// Eliminates the body, once all links are known.
    pub fn eliminate(&mut self) {
        let whole = Matrix6::identity() + self.mobility * self.stiffness;
        self.slowed = whole.try_inverse().unwrap_or_else(Matrix6::identity);
    }

    /// Velocity at a link by the body's own motion alone.
    pub fn velocity_without_fluid(&self, arm: &Wrench) -> f64 {
        let own: Wrench = (self.slowed * Vector6::from(self.motion)).into();
        dot6(arm, &own)
    }

    /// Adds a pull at an arm.
    #[inline]
    pub fn add_pull(&mut self, pull: f64, arm: &Wrench) {
        (0..6).for_each(|k| self.pull[k] += pull * arm[k]);
    }

    /// Makes of the pull the velocities that follow from it alone.
    pub fn follow(&mut self) {
        self.pull = (self.slowed * self.mobility * Vector6::from(self.pull)).into();
    }

    /// Takes the motion at the end of the step.
    pub fn take_motion(&mut self) {
        let gained = Vector6::from(self.motion) + self.mobility * Vector6::from(self.pull);
        self.motion = (self.slowed * gained).into();
    }
}
