//! Contacts of linear springs side by side: the formulae of [`crate::contact`] and
//! [`crate::forces::touch_of_balls`] in the same order of operations, so that the bits are the same.

use crate::{
    contact::Steps,
    lanes::{Lane, Lane3},
    law::Law,
};
use tremie_messages::scene::Spring;

/// What the formula takes of contacts side by side.
#[derive(Clone, Copy)]
pub(crate) struct Batch {
    /// From centre to centre [m].
    pub d: Lane3,
    /// Radii [m].
    pub radius_i: Lane,
    pub radius_j: Lane,
    /// Velocities [m/s] and angular velocities [rad/s].
    pub v_i: Lane3,
    pub v_j: Lane3,
    pub w_i: Lane3,
    pub w_j: Lane3,
    /// History: displacement [m], normal, and 1 where they touched before, else 0.
    pub xi: Lane3,
    pub old: Lane3,
    pub touching: Lane,
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: Lane,
}

/// What it gives.
#[derive(Clone, Copy)]
pub(crate) struct Outcome {
    pub normal: Lane3,
    pub tangential: Lane3,
    pub force: Lane,
    pub overlap: Lane,
    /// Overlap over the smaller radius.
    pub ratio: Lane,
    /// Displacement to remember [m].
    pub xi: Lane3,
}

/// The law of all contacts of a run, where it is one and a linear one without rolling friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearLaw {
    k_n: f64,
    k_t: f64,
    inverse_k_t: f64,
    mu: f64,
    tension: bool,
    gamma_n: [f64; 2],
    gamma_t: [f64; 2],
    /// How batches are computed.
    pub kernel: Kernel,
}

impl LinearLaw {
    /// The law in this form, if it has it.
    pub fn of(law: &Law) -> Option<Self> {
        let Spring::Linear { normal_stiffness, tangential_stiffness } = law.spring else {
            return None;
        };
        if law.mu_rolling > 0.0 {
            return None;
        }
        let (gamma_n, gamma_t) = law.dashpots();
        Some(Self {
            k_n: normal_stiffness,
            k_t: tangential_stiffness,
            inverse_k_t: law.inverse_k_t(),
            mu: law.mu,
            tension: law.tension,
            gamma_n,
            gamma_t,
            kernel: kernel(),
        })
    }

    /// Forces and histories of a batch.
    #[inline(always)]
    pub fn forces(&self, b: &Batch, steps: Steps) -> Outcome {
        let all = Lane::all;
        let half = all(0.5);
        let distance = b.d.dot(b.d).sqrt();
        let n = b.d * all(1.0).over(distance);
        let overlap = b.radius_i + b.radius_j - distance;
        let (arm_i, arm_j) = (b.radius_i - half * overlap, b.radius_j - half * overlap);
        let velocity = (b.v_i - b.v_j) + (b.w_i * arm_i + b.w_j * arm_j).cross(n);
        let twist = half * (b.w_i + b.w_j).dot(n);

        let v_n = velocity.dot(n);
        let gamma = |[fixed, per]: [f64; 2]| all(fixed) + all(per) * b.root_mass;
        let mut f_n = all(self.k_n) * overlap + gamma(self.gamma_n) * v_n;
        if !self.tension {
            f_n = f_n.positive();
        }
        let smaller = b.radius_i.less(b.radius_j, b.radius_i, b.radius_j);
        let mut out = Outcome {
            normal: n,
            tangential: Lane3::ZERO,
            force: f_n,
            overlap,
            ratio: overlap.over(smaller),
            xi: b.xi,
        };
        if self.mu > 0.0 {
            let v = velocity - n * v_n;
            let limit = all(self.mu) * f_n.positive();
            let dt = all(steps.before);
            let reach = v_n * dt;
            let since = overlap.less(reach, overlap.over(v_n), dt);
            let kept = turned(b.xi, b.old, n, twist * dt) + v * all(0.5 * steps.before);
            let xi = Lane3::at_most(b.touching, Lane::ZERO, v * since, kept);
            let xi = xi - n * xi.dot(n);
            let damping = v * gamma(self.gamma_t);
            let trial = -(xi * all(self.k_t) + damping);
            let square = trial.dot(trial);
            let slipping = trial * limit.over(square.sqrt());
            let pulled = (slipping + damping) * all(-self.inverse_k_t);
            let capacity = limit * limit;
            out.tangential = Lane3::at_most(square, capacity, trial, slipping);
            let xi = Lane3::at_most(square, capacity, xi, pulled);
            out.xi = xi + v * all(0.5 * steps.after);
        }
        out
    }
}

/// See [`crate::contact`]'s function of this name.
#[inline(always)]
fn turned(xi: Lane3, old: Lane3, n: Lane3, angle: Lane) -> Lane3 {
    let one = Lane::all(1.0);
    let xi = xi - (old + n) * xi.dot(n).over(one + old.dot(n));
    let t = Lane::all(0.5) * angle;
    let cross = n.cross(xi);
    xi + (cross - xi * t) * (Lane::all(2.0) * t).over(one + t * t)
}

/// A batch's function, compiled for the instructions that a processor has.
pub(crate) type Kernel = fn(&LinearLaw, &Batch, Steps) -> Outcome;

/// The fastest that this processor can run; all give the same bits.
fn kernel() -> Kernel {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") {
            return x86::avx512;
        }
        if is_x86_feature_detected!("avx2") {
            return x86::avx2;
        }
    }
    LinearLaw::portable
}

impl LinearLaw {
    fn portable(&self, batch: &Batch, steps: Steps) -> Outcome {
        self.forces(batch, steps)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::*;

    pub fn avx512(law: &LinearLaw, batch: &Batch, steps: Steps) -> Outcome {
        #[target_feature(enable = "avx512f,avx512vl")]
        fn inside(law: &LinearLaw, batch: &Batch, steps: Steps) -> Outcome {
            law.forces(batch, steps)
        }
        // SAFETY: `kernel`, the only way to this function, has looked whether the processor has the
        // instructions.
        unsafe { inside(law, batch, steps) }
    }

    pub fn avx2(law: &LinearLaw, batch: &Batch, steps: Steps) -> Outcome {
        #[target_feature(enable = "avx2")]
        fn inside(law: &LinearLaw, batch: &Batch, steps: Steps) -> Outcome {
            law.forces(batch, steps)
        }
        // SAFETY: as above.
        unsafe { inside(law, batch, steps) }
    }
}

impl Batch {
    pub const ZERO: Self = Self {
        d: Lane3::ZERO,
        radius_i: Lane::ZERO,
        radius_j: Lane::ZERO,
        v_i: Lane3::ZERO,
        v_j: Lane3::ZERO,
        w_i: Lane3::ZERO,
        w_j: Lane3::ZERO,
        xi: Lane3::ZERO,
        old: Lane3::ZERO,
        touching: Lane::ZERO,
        root_mass: Lane::ZERO,
    };
}
