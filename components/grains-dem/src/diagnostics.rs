//! What the grains as a whole are doing.

use crate::{
    Vec3,
    bodies::Bodies,
    contact::{Contact, Memory},
    forces::{Scenery, touch_of_balls, touch_of_wall},
    law::{Law, Reduced},
    pairs::{BLOCK, Pairs, TOUCHING},
    wall_contacts::WallContacts,
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
        let (mass, twist) = (1.0 / mobility.inverse_mass, &bodies.twists[i]);
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

/// Adds the springs between bodies.
pub(crate) fn add_pairs(out: &mut Diagnostics, pairs: &Pairs, at: Scenery<'_>) {
    let bodies = at.bodies;
    for (b, own) in pairs.bounds.windows(2).enumerate() {
        for k in own[0] as usize..own[1] as usize {
            if pairs.state[k] & TOUCHING == 0 {
                continue;
            }
            let entry = pairs.entries[k];
            let (i, j) = (entry.body(b * BLOCK), entry.other as usize);
            let (a, b) = (&bodies.balls[i], &bodies.balls[j]);
            let (of_i, of_j) = (&bodies.predicted[i], &bodies.predicted[j]);
            let d = at.between(i, j, entry.image());
            let contact = touch_of_balls(d, a.radius, b.radius, of_i, of_j);
            let law = &at.laws[entry.law()];
            let memory = pairs.memory(k);
            out.elastic_energy +=
                elastic_energy(law, pairs.reduced[k], &contact, &memory, at.steps.after);
        }
    }
}

/// Adds the springs between bodies and walls.
pub(crate) fn add_walls(
    out: &mut Diagnostics,
    list: &WallContacts,
    walls: &[Wall],
    at: Scenery<'_>,
) {
    for (p, &i) in list.bodies.iter().enumerate() {
        let (ball, twist) = (&at.bodies.balls[i as usize], &at.bodies.predicted[i as usize]);
        for entry in &list.entries[list.start[p] as usize..list.start[p + 1] as usize] {
            let (contact, _) = touch_of_wall(ball, twist, &walls[entry.wall as usize]);
            if contact.overlap > 0.0 {
                let (law, pair) = (&at.laws[entry.law as usize], entry.reduced);
                out.elastic_energy +=
                    elastic_energy(law, pair, &contact, &entry.memory, at.steps.after);
            }
        }
    }
}

/// Normal, tangential and rolling spring; displacements are taken back the half step that they are
/// ahead.
pub(crate) fn elastic_energy(
    law: &Law,
    pair: Reduced,
    contact: &Contact,
    memory: &Memory,
    dt: f64,
) -> f64 {
    let n = contact.normal;
    let across = |v: Vec3| v - n * v.dot(&n);
    let k_t = law.at(contact.overlap, contact.overlap, pair).k_t;
    let spring = |xi: Vec3, v: Vec3| 0.5 * k_t * (xi - v * (0.5 * dt)).norm_squared();
    let mut energy = law.normal_energy(contact.overlap, pair);
    if law.mu > 0.0 {
        energy += spring(memory.xi, across(contact.velocity));
    }
    if law.mu_rolling > 0.0 {
        energy += spring(memory.rolling, across(contact.rolling) * pair.radius);
    }
    energy
}
