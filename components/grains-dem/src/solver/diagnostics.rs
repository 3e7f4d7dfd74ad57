//! Diagnostics of the grains as a whole.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use crate::bodies::placed_parts::PlacedPart;
use crate::bodies::slider::Slider;
use crate::contact::contact_force::touch_of_balls;
use crate::contact::contact_force::{Contact, ContactHistory};
use crate::contact::contact_law::Law;
use crate::contact::springs::Reduced;
use crate::forces::pair_forces::ContactContext;
use crate::neighbours::neighbour_list::{NeighbourList, TOUCHING};
use crate::polyhedra::Polyhedra;
use crate::solver::clumps::{Clump, Clumps};
use crate::solver::neighbour_search::Contacts;
use crate::walls::wall_forces::touch_of_wall;
use serde::Serialize;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_messages::scene::Domain;
use tremie_team::{Cut, Team};

/// Sums over the free bodies, the sliders and their contacts, at the end of the last substep. Of
/// sliders that symmetry planes cut, they hold what belongs to the domain.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Diagnostics {
    /// Kinetic energy of translation [J].
    pub kinetic_energy: f64,
    /// Kinetic energy of rotation [J].
    pub rotational_energy: f64,
    /// Potential energy of weight, from the lowest point of the domain along gravity [J]. It jumps
    /// when a body crosses a periodic face across gravity. Of a slider that of weight and constant
    /// force, from lift 0.
    pub potential_energy: f64,
    /// Energy in the normal and tangential springs of contacts, in springs and stops of sliders
    /// [J].
    pub elastic_energy: f64,
    /// Momentum [kg·m/s].
    pub momentum: [f64; 3],
    /// Largest speed [m/s].
    pub max_speed: f64,
    /// Mean height of centres against gravity, from the lowest point of the domain [m], of clumps
    /// that of their centroids; 0 without gravity.
    pub mean_height: f64,
    /// Mean position of their centres [m].
    pub mean_place: [f64; 3],
    /// Contacts between bodies, and between bodies and walls.
    pub contacts: u64,
    /// Largest overlap since the start, over the smaller radius of its pair.
    pub max_overlap_ratio: f64,
    /// Contacts, summed over all substeps, whose overlap exceeded 5 % of the smaller radius.
    pub deep_overlaps: u64,
    /// Neighbour lists made since the start.
    pub list_rebuilds: u64,
    /// Impulse that the fluid's loads gave since the start, to sliders along their axes [N·s].
    pub fluid_impulse: [f64; 3],
}

/// Input of the diagnostics.
pub(crate) struct Seen<'a> {
    /// Bodies and laws.
    pub scenery: ContactContext<'a>,
    /// Contacts of all kinds.
    pub contacts: Contacts<'a>,
    /// The walls.
    pub walls: &'a [Wall],
    /// The domain.
    pub domain: &'a Domain,
    /// Acceleration of weight [m/s²].
    pub gravity: Vec3,
    /// The parts, sliders among them.
    pub parts: &'a [PlacedPart],
    /// The polyhedra.
    pub polyhedra: &'a Polyhedra,
    /// Bodies that are joined.
    pub clumps: &'a Clumps,
}

/// Sums over bodies, in the order of their ids: in fixed blocks, and these in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    /// Energy in the springs that count as a body's, in the order of memory [J].
    springs: Vec<f64>,
    blocks: Vec<Sums>,
}

/// Sums over free bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    kinetic: f64,
    rotational: f64,
    potential: f64,
    elastic: f64,
    momentum: Vec3,
    /// Of the centres [m].
    place: Vec3,
    /// Square of the largest speed [m²/s²].
    square: f64,
    height: f64,
    free: usize,
}

impl Survey {
    /// Energies, momentum, largest speed and mean height.
    pub fn sums(&mut self, team: &mut Team, seen: &Seen) -> Diagnostics {
        let (bodies, gravity) = (seen.scenery.bodies, seen.gravity);
        self.springs.resize(bodies.len(), 0.0);
        team.for_pieces(Cut::every(&mut self.springs, BLOCK), |b, springs: &mut [f64]| {
            add_springs(springs, b, seen);
        });
        let strength = gravity.norm_squared().sqrt();
        let up = if strength > 0.0 { -gravity / strength } else { Vec3::zeros() };
        let domain = seen.domain;
        let corner = |a: usize| if up[a] > 0.0 { domain.min[a] } else { domain.max[a] };
        let lowest = Vec3::from_fn(|a, _| corner(a)).dot(&up);
        self.blocks.resize(bodies.len().div_ceil(BLOCK), Sums::default());
        let springs = &self.springs;
        team.for_each(&mut self.blocks, |b, sums| {
            *sums = Sums::default();
            // By rank, the order of ids: the same bits wherever bodies stand in memory.
            for &slot in &bodies.slot[b * BLOCK..bodies.len().min((b + 1) * BLOCK)] {
                let slot = slot as usize;
                sums.elastic += springs[slot];
                sums.add(bodies, slot, bodies.balls[slot].x.dot(&up) - lowest, strength);
            }
        });
        let mut all = self.blocks.iter().fold(Sums::default(), |all, sums| all.and(sums));
        for clump in seen.clumps.all() {
            let place = clump.centroid(bodies);
            all.join(clump, place, place.dot(&up) - lowest, strength);
        }
        seen.parts.iter().filter_map(PlacedPart::slider).for_each(|slider| all.slide(slider));
        for surface in &seen.contacts.surfaces.held {
            all.elastic += surface.elastic_energy(seen.scenery.laws);
        }
        let surfaces = (seen.walls, seen.parts);
        all.rotational += seen.polyhedra.rotational_energy(bodies);
        all.elastic += seen.contacts.solids.elastic_energy(seen.polyhedra, seen.scenery, surfaces);
        all.diagnostics()
    }
}

impl Sums {
    fn add(&mut self, bodies: &Bodies, slot: usize, height: f64, gravity: f64) {
        let (mobility, twist) = (bodies.mobility[slot], &bodies.twists[slot]);
        if !mobility.is_free() {
            return;
        }
        let (mass, square) = (1.0 / mobility.inverse_mass, twist.v.norm_squared());
        self.square = self.square.max(square);
        if mobility.is_joined() {
            // Clumps are added up by themselves.
            return;
        }
        self.kinetic += 0.5 * mass * square;
        // Polyhedra have three moments of inertia, and are added up by themselves.
        if mobility.inverse_inertia > 0.0 {
            self.rotational += 0.5 * twist.w.norm_squared() / mobility.inverse_inertia;
        }
        self.potential += mass * gravity * height;
        self.momentum += twist.v * mass;
        self.place += bodies.balls[slot].x;
        self.height += height;
        self.free += 1;
    }

    /// Adds a clump, whose centroid is at a place and a height.
    fn join(&mut self, clump: &Clump, place: Vec3, height: f64, gravity: f64) {
        let [kinetic, rotational] = clump.energies();
        self.kinetic += kinetic;
        self.rotational += rotational;
        self.potential += clump.mass * gravity * height;
        self.momentum += clump.v * clump.mass;
        self.place += place;
        self.height += height;
        self.free += 1;
    }

    /// Adds a slider: of one that symmetry planes cut, what belongs to the domain.
    fn slide(&mut self, slider: &Slider) {
        let share = 1.0 / slider.whole;
        self.kinetic += share * slider.kinetic();
        self.potential += share * slider.potential();
        self.elastic += share * slider.elastic();
        self.momentum += slider.axis * (share * slider.mass * slider.velocity);
        self.square = self.square.max(slider.velocity * slider.velocity);
    }

    fn and(self, other: &Self) -> Self {
        Self {
            kinetic: self.kinetic + other.kinetic,
            rotational: self.rotational + other.rotational,
            potential: self.potential + other.potential,
            elastic: self.elastic + other.elastic,
            momentum: self.momentum + other.momentum,
            square: self.square.max(other.square),
            place: self.place + other.place,
            height: self.height + other.height,
            free: self.free + other.free,
        }
    }

    fn diagnostics(self) -> Diagnostics {
        Diagnostics {
            kinetic_energy: self.kinetic,
            rotational_energy: self.rotational,
            potential_energy: self.potential,
            elastic_energy: self.elastic,
            momentum: self.momentum.into(),
            max_speed: self.square.sqrt(),
            mean_height: if self.free > 0 { self.height / self.free as f64 } else { 0.0 },
            mean_place: (self.place / self.free.max(1) as f64).into(),
            ..Diagnostics::default()
        }
    }
}

/// Energies in the springs of a block of bodies: those between bodies count as the one's with the
/// smaller id.
fn add_springs(springs: &mut [f64], b: usize, seen: &Seen) {
    let Contacts { pairs, walls, parts, .. } = seen.contacts;
    let (at, first) = (&seen.scenery, b * BLOCK);
    for (i, energy) in (first..).zip(&mut *springs) {
        let of_pair = |&place: &u32| spring_of_pair(pairs, at, i, place);
        *energy = pairs.places_of(i).iter().filter_map(of_pair).sum();
    }
    for p in walls.rows.on.bounds[b] as usize..walls.rows.on.bounds[b + 1] as usize {
        let i = walls.rows.on.bodies[p] as usize;
        let (ball, twist) = (&at.bodies.balls[i], &at.bodies.predicted[i]);
        for entry in walls.rows.row(p) {
            let (contact, _) = touch_of_wall(ball, twist, &seen.walls[entry.wall as usize]);
            let (law, pair) = (&at.laws[entry.law as usize], entry.reduced);
            if contact.overlap > -law.gap || entry.touching {
                springs[i - first] +=
                    elastic_energy(law, pair, &contact, &entry.memory, at.steps.after);
            }
        }
    }
    for p in parts.rows.on.bounds[b] as usize..parts.rows.on.bounds[b + 1] as usize {
        springs[parts.rows.on.bodies[p] as usize - first] += parts.elastic_energy(p, at.laws);
    }
}

/// The spring of body i's contact at a place, if it touches and the other body's id is larger.
fn spring_of_pair(pairs: &NeighbourList, at: &ContactContext, i: usize, place: u32) -> Option<f64> {
    let k = (place / 2) as usize;
    if pairs.state[k] & TOUCHING == 0 {
        return None;
    }
    let (entry, bodies) = (pairs.entries[k], at.bodies);
    // Seen from the other side all vectors are the opposite, and the energy is the same.
    let (i, j, d, memory) = if place.is_multiple_of(2) {
        let j = entry.other as usize;
        (i, j, at.through(i, j, entry.image() as usize), pairs.memory(k))
    } else {
        let j = pairs.body_of(k);
        (i, j, -at.through(j, i, entry.image() as usize), pairs.memory(k).of_other_side())
    };
    if bodies.rank[j] < bodies.rank[i] {
        return None;
    }
    let (a, b) = (&bodies.balls[i], &bodies.balls[j]);
    let (of_i, of_j) = (&bodies.predicted[i], &bodies.predicted[j]);
    let contact = touch_of_balls(d, a.radius, b.radius, of_i, of_j);
    let law = &at.laws[entry.law()];
    Some(elastic_energy(law, pairs.reduced[k], &contact, &memory, at.steps.after))
}

/// Normal, tangential and rolling spring; displacements are taken back the half step that they are
/// ahead.
fn elastic_energy(
    law: &Law,
    pair: Reduced,
    contact: &Contact,
    memory: &ContactHistory,
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
