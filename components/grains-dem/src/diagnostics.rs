//! What the grains as a whole are doing.

use crate::{
    Vec3,
    bodies::Bodies,
    contact::Memory,
    contact_list::ContactList,
    forces::{Touch, touch_of_balls, touch_of_wall},
    law::Law,
    walls::Wall,
};
use serde::Serialize;
use tremie_messages::scene::Domain;

/// Sums over the free bodies and their contacts, at the end of the last substep.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnostics {
    /// Kinetic energy of translation [J].
    pub kinetic_energy: f64,
    /// Kinetic energy of rotation [J].
    pub rotational_energy: f64,
    /// Potential energy of weight, from the lowest point of the domain along gravity [J]. It jumps
    /// when a body crosses a periodic face across gravity.
    pub potential_energy: f64,
    /// Energy in the normal and tangential springs of contacts [J].
    pub elastic_energy: f64,
    /// Momentum [kg·m/s].
    pub momentum: [f64; 3],
    /// Largest speed [m/s].
    pub max_speed: f64,
    /// Mean height of centres against gravity, from the lowest point of the domain [m]; 0 without
    /// gravity.
    pub mean_height: f64,
    /// Contacts between bodies, and between bodies and walls.
    pub contacts: u64,
    /// Largest overlap since the start, over the smaller radius of its pair.
    pub max_overlap_ratio: f64,
    /// Contacts, summed over all substeps, whose overlap exceeded 5 % of the smaller radius.
    pub deep_overlaps: u64,
    /// Neighbour lists made since the start.
    pub list_rebuilds: u64,
    /// Impulse that the fluid's loads gave since the start [N·s].
    pub fluid_impulse: [f64; 3],
}

/// Sums over bodies into `out`.
pub(crate) fn add_bodies(out: &mut Diagnostics, bodies: &Bodies, domain: &Domain, gravity: Vec3) {
    let strength = gravity.norm_squared().sqrt();
    let up = if strength > 0.0 { -gravity / strength } else { Vec3::zeros() };
    let corner = |a: usize| {
        if up[a] > 0.0 { domain.min[a] } else { domain.max[a] }
    };
    let lowest = Vec3::from_fn(|a, _| corner(a)).dot(&up);
    let mut momentum = Vec3::zeros();
    let mut square = 0.0f64;
    let (mut height, mut free) = (0.0, 0usize);
    for i in 0..bodies.len() {
        let mobility = bodies.mobility[i];
        if !mobility.is_free() {
            continue;
        }
        let (mass, twist) = (bodies.mass[i], &bodies.twists[i]);
        let h = bodies.balls[i].x.dot(&up) - lowest;
        out.kinetic_energy += 0.5 * mass * twist.v.norm_squared();
        out.rotational_energy += 0.5 * twist.w.norm_squared() / mobility.inverse_inertia;
        out.potential_energy += mass * strength * h;
        momentum += twist.v * mass;
        square = square.max(twist.v.norm_squared());
        height += h;
        free += 1;
    }
    out.momentum = momentum.into();
    out.max_speed = square.sqrt();
    out.mean_height = if free > 0 { height / free as f64 } else { 0.0 };
}

/// Adds the springs between bodies; `dt` is the step that histories are ahead by a half of.
pub(crate) fn add_pairs(
    out: &mut Diagnostics,
    list: &ContactList,
    law: &Law,
    shifts: &[Vec3; 27],
    bodies: &Bodies,
    dt: f64,
) {
    for i in 0..bodies.len() {
        for k in list.row(i) {
            let (j, image) = (list.neighbours[k].other as usize, list.neighbours[k].image);
            let (a, b) = (&bodies.balls[i], &bodies.balls[j]);
            let d = b.x + shifts[image as usize] - a.x;
            let (of_i, of_j) = (&bodies.predicted[i], &bodies.predicted[j]);
            if let Some(touch) = touch_of_balls(d, a.radius, b.radius, of_i, of_j) {
                out.elastic_energy += elastic_energy(law, &touch, &list.memory[k], dt);
            }
        }
    }
}

/// Adds the springs between bodies and walls.
pub(crate) fn add_walls(
    out: &mut Diagnostics,
    list: &ContactList,
    law: &Law,
    walls: &[Wall],
    bodies: &Bodies,
    dt: f64,
) {
    for i in 0..bodies.len() {
        for k in list.row(i) {
            let wall = &walls[list.neighbours[k].other as usize];
            if let Some(touch) = touch_of_wall(&bodies.balls[i], &bodies.predicted[i], wall) {
                out.elastic_energy += elastic_energy(law, &touch, &list.memory[k], dt);
            }
        }
    }
}

/// `(k_n delta² + k_t xi²)/2`, with `xi` taken back the half step that it is ahead.
fn elastic_energy(law: &Law, touch: &Touch, memory: &Memory, dt: f64) -> f64 {
    let contact = &touch.contact;
    let normal = 0.5 * law.k_n * contact.overlap * contact.overlap;
    if law.mu == 0.0 {
        return normal;
    }
    let v_t = contact.velocity - contact.normal * contact.velocity.dot(&contact.normal);
    let xi = memory.xi - v_t * (0.5 * dt);
    normal + 0.5 * law.k_t * xi.norm_squared()
}
