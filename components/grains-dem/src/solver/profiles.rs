//! Profiles of the scene: the grains as they are where a sample is due.
//!
//! A pass over the contacts, after forces were evaluated and before bodies come and go. Windows
//! without a sample do nothing here.
//!
//! A sphere's part of a contact's branch leads from its centre to the point half way between the
//! two surfaces. The parts of a pair are together the vector from centre to centre, and a sphere's
//! virial over its own volume is its mean stress, whatever the sizes (Christoffersen, Mehrabadi and
//! Nemat-Nasser, *J. Appl. Mech.* 48, 1981).

use crate::Vec3;
use crate::bodies::body_arrays::{BLOCK, Bodies};
use crate::neighbours::neighbour_list::{NeighbourList, TOUCHING};
use crate::solver::neighbour_search::Contacts;
use crate::walls::wall_contacts::WallContacts;
use tremie_grains_kit::profiles::{GrainSample, ProfileSampler};
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::{Domain, Scene};
use tremie_state::{StateError, StateExchange};
use tremie_team::{Cut, Team};

/// The profiles of a run.
#[derive(Default)]
pub(crate) struct Profiles {
    samplers: Vec<ProfileSampler>,
    /// Windows that have ended.
    windows: u64,
    /// The bodies by rank, where a sample is due.
    samples: Vec<GrainSample>,
}

impl Profiles {
    /// The profiles of a scene in a run whose windows have a length [s], with room for so many
    /// grains.
    pub fn new(scene: &Scene, window: f64, room: usize) -> Self {
        let of = |profile| ProfileSampler::new(profile, &scene.domain, window, room);
        Self {
            samplers: scene.profiles.iter().map(of).collect(),
            windows: 0,
            samples: Vec::with_capacity(if scene.profiles.is_empty() { 0 } else { room }),
        }
    }

    /// Keeps the tables that were begun, or puts them back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("windows", &mut self.windows)?;
        for sampler in &mut self.samplers {
            let name = sampler.name().to_string();
            state.within(&name, |state| sampler.exchange(state))?;
        }
        Ok(())
    }

    /// True if a sample is due at the end of the window that goes on.
    pub fn are_due(&self) -> bool {
        self.samplers.iter().any(|sampler| sampler.wants(self.windows + 1))
    }

    /// Counts a window that has ended.
    pub fn end_window(&mut self) {
        self.windows += 1;
    }

    /// Gives the grains to the profiles that want them at the end of the last window.
    pub fn take(&mut self, team: &mut Team, seen: &SampledGrains<'_>) {
        let window = self.windows;
        if !self.samplers.iter().any(|sampler| sampler.wants(window)) {
            return;
        }
        self.look_at(team, seen);
        let Self { samplers, samples, .. } = self;
        for sampler in samplers.iter_mut().filter(|sampler| sampler.wants(window)) {
            let are_moved = |sample: &&GrainSample| sample.mass > 0.0;
            sampler.take(window, samples.iter().filter(are_moved).copied());
        }
    }

    /// True if there is a table of the profile of a name, as
    /// [`GrainsDem::has_profile`](crate::GrainsDem::has_profile) tells.
    pub fn has_table(&self, name: &str, is_last: bool) -> bool {
        self.named(name).is_some_and(|sampler| sampler.has_table(self.windows, is_last))
    }

    /// Writes the table of the profile of a name.
    pub fn table(&self, name: &str, bins: &mut [ProfileBin]) -> ProfileHeader {
        self.named(name).map_or_else(ProfileHeader::default, |sampler| sampler.table(bins))
    }

    fn named(&self, name: &str) -> Option<&ProfileSampler> {
        self.samplers.iter().find(|sampler| sampler.name() == name)
    }

    /// Writes all bodies by rank; those that forces do not move have no mass.
    fn look_at(&mut self, team: &mut Team, seen: &SampledGrains<'_>) {
        let SampledGrains { bodies, contacts, walls, domain } = *seen;
        let samples = &mut self.samples;
        samples.clear();
        samples.resize(bodies.len(), GrainSample::new(0));
        team.for_pieces(Cut::every(samples, BLOCK), |b, samples: &mut [GrainSample]| {
            for (rank, sample) in (b * BLOCK..).zip(samples) {
                let slot = bodies.slot[rank] as usize;
                let (mobility, ball) = (bodies.mobility[slot], &bodies.balls[slot]);
                if mobility.is_free() {
                    *sample = GrainSample {
                        position: ball.x.into(),
                        velocity: bodies.twists[slot].v.into(),
                        volume: domain.body_volume(2.0 * ball.radius),
                        mass: 1.0 / mobility.inverse_mass,
                        ..GrainSample::new(bodies.ids[rank])
                    };
                    add_contacts(sample, slot, bodies, (contacts, walls));
                }
            }
        });
    }
}

/// What profiles see of the grains.
pub(crate) struct SampledGrains<'a> {
    pub bodies: &'a Bodies,
    pub contacts: Contacts<'a>,
    pub walls: &'a [Wall],
    pub domain: &'a Domain,
}

/// Adds the contacts of the body at a place in memory: those with bodies, in the order of their
/// ids, then those with walls, then those with parts.
fn add_contacts(
    sample: &mut GrainSample,
    slot: usize,
    bodies: &Bodies,
    (contacts, walls): (Contacts<'_>, &[Wall]),
) {
    add_pairs(sample, slot, bodies.balls[slot].radius, contacts.pairs);
    add_walls(sample, slot, bodies, (contacts.walls, walls));
    let parts = contacts.parts;
    let of_parts = parts.rows.on.place(slot as u32).and_then(|place| parts.virials.get(place));
    if let Some(of_parts) = of_parts {
        sample.contacts += of_parts.contacts;
        for (sum, virial) in sample.virial.iter_mut().zip(of_parts.virial) {
            *sum += virial;
        }
    }
}

fn add_pairs(sample: &mut GrainSample, slot: usize, radius: f64, pairs: &NeighbourList) {
    for &place in pairs.acting_on(slot) {
        let k = (place / 2) as usize;
        sample.contacts += u32::from(pairs.state[k] & TOUCHING != 0);
        let record = &pairs.records[k];
        // From the other side both arm and force are the opposite, and their product is the same.
        let arm: Vec3 = record.normal * (radius - 0.5 * record.overlap);
        sample.push(arm.into(), record.on(1.0, radius).force.into());
    }
}

fn add_walls(
    sample: &mut GrainSample,
    slot: usize,
    bodies: &Bodies,
    (contacts, walls): (&WallContacts, &[Wall]),
) {
    let ball = &bodies.balls[slot];
    for entry in contacts.rows.of(slot as u32) {
        sample.contacts += u32::from(entry.touching);
        let wall = &walls[entry.wall as usize];
        let arm = wall.normal * (0.5 * wall.overlap(ball) - ball.radius);
        sample.push(arm.into(), (-entry.force).into());
    }
}
