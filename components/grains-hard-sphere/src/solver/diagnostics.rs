//! Sums over the free bodies.

use crate::Vec3;
use crate::bodies::hard_body::HardBody;
use serde::Serialize;
use tremie_messages::scene::Domain;

/// Sums over the free bodies at the end of the last step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HardDiagnostics {
    /// Kinetic energy of translation [J].
    pub kinetic_energy: f64,
    /// Kinetic energy of rotation [J].
    pub rotational_energy: f64,
    /// Potential energy of weight, from the lowest point of the domain along gravity [J].
    pub potential_energy: f64,
    /// Momentum [kg·m/s].
    pub momentum: [f64; 3],
    /// Largest speed [m/s].
    pub max_speed: f64,
    /// Mean height of centres against gravity, from the lowest point of the domain [m]; 0 without
    /// gravity.
    pub mean_height: f64,
    /// Mean position of their centres [m].
    pub mean_place: [f64; 3],
    /// Collisions of bodies with each other since the start.
    pub collisions: u64,
    /// Collisions of bodies with walls and parts since the start.
    pub wall_collisions: u64,
    /// Collisions since the start that were made elastic because a partner had just collided.
    pub guarded_by_time: u64,
    /// Collisions since the start that were made elastic because they were slow.
    pub guarded_by_speed: u64,
    /// Bodies that were held for the rest of a step, because they collided too often in it; summed
    /// over all steps.
    pub crowded: u64,
}

/// Sums over bodies, in the order of their ids, with their velocities as others see them.
pub fn sums<'a>(
    bodies: impl Iterator<Item = (&'a HardBody, Vec3)>,
    kappa: f64,
    gravity: Vec3,
    domain: &Domain,
) -> HardDiagnostics {
    let strength = gravity.norm_squared().sqrt();
    let up = if strength > 0.0 { -gravity / strength } else { Vec3::zeros() };
    let corner = |a: usize| if up[a] > 0.0 { domain.min[a] } else { domain.max[a] };
    let lowest = Vec3::from_fn(|a, _| corner(a)).dot(&up);
    let mut all = HardDiagnostics::default();
    let (mut momentum, mut place, mut square, mut free) = (Vec3::zeros(), Vec3::zeros(), 0.0f64, 0);
    for (body, v) in bodies.filter(|(body, _)| body.is_free()) {
        let (mass, height) = (1.0 / body.inverse_mass, body.x.dot(&up) - lowest);
        let inertia = kappa * mass * body.radius * body.radius;
        all.kinetic_energy += 0.5 * mass * v.norm_squared();
        all.rotational_energy += 0.5 * inertia * body.w.norm_squared();
        all.potential_energy += mass * strength * height;
        all.mean_height += height;
        momentum += v * mass;
        place += body.x;
        square = square.max(v.norm_squared());
        free += 1;
    }
    let share = 1.0 / f64::from(free.max(1));
    all.momentum = momentum.into();
    all.mean_place = (place * share).into();
    all.mean_height *= share;
    all.max_speed = square.sqrt();
    all
}
