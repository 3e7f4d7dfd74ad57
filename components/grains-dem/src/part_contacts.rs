//! Bodies near parts, with what each contact remembers and the sum of the parts' forces.

use crate::{
    Vec3,
    bodies::{Bodies, Wrench},
    contact::{self, Contact, Memory},
    forces::Scenery,
    law::{Law, Reduced},
    mesh_contact::{self, Looked, MOST, SAME, Seeker},
    pairs::BLOCK,
    part_finder::{Found, Nearness, SOME},
    parts::PlacedPart,
    slider::Along,
    tally::{Other, Tally},
};
use tremie_team::{Cut, Team};

/// A body near a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub part: u32,
    pub law: u16,
    /// Number of contacts at the last evaluation; as many memories count.
    pub touching: u8,
    /// Reduced mass, that of a head-on collision along the axis of a slider; the body's radius.
    pub reduced: Reduced,
    pub memories: [Memory; MOST],
    /// Where the body was, as the part sees it, when it looked at all triangles near it.
    pub looked: Looked,
}

/// Rows of entries, one for each body near a part, in the order of memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartContacts {
    /// Indices of the bodies.
    pub bodies: Vec<u32>,
    /// Sum of the parts' forces on each.
    pub wrench: Vec<Wrench>,
    /// Which of `bodies` belong to each block of bodies.
    pub bounds: Vec<u32>,
    /// `start[p]..start[p + 1]` are the entries of `bodies[p]`.
    start: Vec<u32>,
    entries: Vec<Entry>,
    entry_bounds: Vec<u32>,
    /// `near[e]..near[e + 1]` are the triangles of entry e, with the images that see them.
    near: Vec<u32>,
    triangles: Vec<(u32, u32)>,
    /// How far each was when the body looked at all.
    distances: Vec<f32>,
    triangle_bounds: Vec<u32>,
    /// Forces on the parts and torques about their reference points, at the last evaluation.
    pub on_parts: Vec<Wrench>,
    /// The same block by block.
    loads: Vec<Wrench>,
    /// Forces along the axes of sliders, by part; others have none.
    pub pushes: Vec<Along>,
    /// The same block by block.
    block_pushes: Vec<Along>,
}

impl PartContacts {
    /// Makes the list anew. `before` is the list before; `found` is room to work in.
    pub fn make(
        &mut self,
        before: &Self,
        found: &mut Vec<Found>,
        team: &mut Team,
        bodies: &Bodies,
        at: &Nearness,
    ) {
        self.clear();
        found.resize_with(bodies.len().div_ceil(BLOCK), Found::default);
        if !at.parts.is_empty() {
            self.bodies.reserve(SOME);
            self.start.reserve(SOME);
            self.entries.reserve(SOME);
            self.near.reserve(SOME);
            self.triangles.reserve(8 * SOME);
            self.wrench.reserve(SOME);
            team.for_each(found, |b, found| found.find(b, before, bodies, at));
        }
        for found in found {
            let (first, triangles) = (self.entries.len() as u32, self.triangles.len() as u32);
            self.bodies.extend(&found.bodies);
            self.start.extend(found.ends.iter().map(|end| first + end));
            self.entries.extend(&found.entries);
            self.near.extend(found.near.iter().map(|end| triangles + end));
            self.triangles.extend(&found.triangles);
            self.end_block();
        }
        self.distances.clear();
        self.distances.resize(self.triangles.len(), 0.0);
        let previous = |&body: &u32| before.force_on(at.previous[body as usize]);
        self.wrench.clear();
        self.wrench.extend(self.bodies.iter().map(previous));
        self.on_parts.clear();
        self.on_parts.extend(&before.on_parts);
        self.pushes.clear();
        self.pushes.extend(&before.pushes);
        self.on_parts.resize(at.parts.len(), Wrench::zero());
        self.pushes.resize(at.parts.len(), Along::default());
        let blocks = self.bounds.len() - 1;
        self.loads.resize(blocks * at.parts.len(), Wrench::zero());
        self.block_pushes.resize(blocks * at.parts.len(), Along::default());
    }

    fn clear(&mut self) {
        self.bodies.clear();
        self.start.clear();
        self.start.push(0);
        self.entries.clear();
        self.bounds.clear();
        self.entry_bounds.clear();
        self.near.clear();
        self.near.push(0);
        self.triangles.clear();
        self.triangle_bounds.clear();
        self.end_block();
    }

    fn end_block(&mut self) {
        self.bounds.push(self.bodies.len() as u32);
        self.entry_bounds.push(self.entries.len() as u32);
        self.triangle_bounds.push(self.triangles.len() as u32);
    }

    /// The parts' force on a body, by its place in this list.
    fn force_on(&self, body: u32) -> Wrench {
        self.bodies.binary_search(&body).map_or(Wrench::zero(), |p| self.wrench[p])
    }

    /// What the contacts of a body, by its place in this list, with a part remember.
    pub fn remembered(&self, body: u32, part: u32) -> Option<(u8, [Memory; MOST])> {
        let p = self.bodies.binary_search(&body).ok()?;
        let row = &self.entries[self.start[p] as usize..self.start[p + 1] as usize];
        row.iter().find(|entry| entry.part == part).map(|entry| (entry.touching, entry.memories))
    }

    /// Evaluates the contacts; adds what each block saw to `tallies`, and sums the forces on the parts.
    pub fn evaluate(
        &mut self,
        team: &mut Team,
        parts: &[PlacedPart],
        scenery: Scenery<'_>,
        tallies: &mut [Tally],
    ) {
        if parts.is_empty() || tallies.is_empty() {
            return;
        }
        let pieces = (
            Cut::at(&mut self.entries, &self.entry_bounds),
            Cut::at(&mut self.distances, &self.triangle_bounds),
            Cut::at(&mut self.wrench, &self.bounds),
            Cut::every(&mut self.loads, parts.len()),
            Cut::every(&mut self.block_pushes, parts.len()),
            Cut::every(tallies, 1),
        );
        let (bodies, start, bounds) = (&self.bodies, &self.start, &self.bounds);
        let (near, triangles, first) = (&self.near, &self.triangles, &self.entry_bounds);
        let of_block = &self.triangle_bounds;
        team.for_pieces(pieces, |b, (entries, distances, wrench, loads, pushes, tally)| {
            loads.fill(Wrench::zero());
            pushes.fill(Along::default());
            for (p, wrench) in (bounds[b] as usize..).zip(wrench) {
                *wrench = Wrench::zero();
                for e in start[p] as usize..start[p + 1] as usize {
                    let entry = &mut entries[e - first[b] as usize];
                    let number = entry.part as usize;
                    let part = &parts[number];
                    let own = near[e] as usize..near[e + 1] as usize;
                    let begin = of_block[b] as usize;
                    let distances = &mut distances[own.start - begin..own.end - begin];
                    let near = &triangles[own];
                    let place = Place { body: bodies[p] as usize, part, near, scenery: &scenery };
                    let mut load = Wrench::zero();
                    place.evaluate((entry, distances), wrench, &mut load, &mut tally[0]);
                    loads[number].force += load.force;
                    loads[number].torque += load.torque;
                    if let Some(slider) = part.slider() {
                        pushes[number].add(Along::of(load.force.dot(&slider.axis)));
                    }
                }
            }
        });
        self.sum_blocks(parts.len());
    }
}

impl PartContacts {
    fn sum_blocks(&mut self, parts: usize) {
        self.on_parts.fill(Wrench::zero());
        for block in self.loads.chunks(parts) {
            for (sum, load) in self.on_parts.iter_mut().zip(block) {
                sum.force += load.force;
                sum.torque += load.torque;
            }
        }
        self.pushes.fill(Along::default());
        for block in self.block_pushes.chunks(parts) {
            for (sum, &push) in self.pushes.iter_mut().zip(block) {
                sum.add(push);
            }
        }
    }

    /// Energy in the springs of the contacts of a body, by its place in this list [J], tangential ones
    /// at the displacement that they will have half a step later.
    pub fn elastic_energy(&self, p: usize, laws: &[Law]) -> f64 {
        let mut energy = 0.0;
        for entry in &self.entries[self.start[p] as usize..self.start[p + 1] as usize] {
            let law = &laws[entry.law as usize];
            for memory in &entry.memories[..entry.touching as usize] {
                energy += law.remembered_energy(memory, entry.reduced);
            }
        }
        energy
    }
}

/// A body and a part near it.
struct Place<'a> {
    body: usize,
    part: &'a PlacedPart,
    near: &'a [(u32, u32)],
    scenery: &'a Scenery<'a>,
}

impl Place<'_> {
    fn evaluate(
        &self,
        (entry, distances): (&mut Entry, &mut [f32]),
        on_body: &mut Wrench,
        on_part: &mut Wrench,
        tally: &mut Tally,
    ) {
        let (part, scenery) = (self.part, self.scenery);
        let ball = &scenery.bodies.balls[self.body];
        let crossed = if scenery.crossed { scenery.bodies.crossed[self.body] } else { 0 };
        let law: &Law = &scenery.laws[entry.law as usize];
        let (known, old) = (entry.touching as usize, entry.memories);
        entry.touching = 0;
        let mut used = [false; MOST];
        // Almost always there is one image; then all triangles are seen together, as they must be.
        let image = |seen: u32| (seen as i32 + crossed) as usize;
        let Some(&(_, seen)) = self.near.first() else { return };
        let home = ball.x + scenery.shifts[image(seen)];
        let centre = part.to_part(home);
        let triangle = |k: usize| {
            let (triangle, other) = self.near[k];
            let mut triangle = part.triangle(triangle);
            if other != seen {
                // The surface as this image sees it, moved to where the first one does.
                let apart = scenery.shifts[image(seen)] - scenery.shifts[image(other)];
                let apart = part.to_part(apart) - part.to_part(Vec3::zeros());
                triangle.corners = triangle.corners.map(|corner| corner + apart);
            }
            triangle
        };
        let radius = ball.radius;
        let sphere = Seeker { centre, radius, reach: radius + scenery.reach() };
        // As the part sees it, only the body moves.
        let found = mesh_contact::find(sphere, 0.0, &mut entry.looked, distances, triangle);
        for near in found.contacts() {
            let n = -part.to_world(near.normal);
            let overlap = ball.radius - near.distance;
            let arm = ball.radius - 0.5 * overlap;
            let twist = &scenery.bodies.predicted[self.body];
            let contact = Contact {
                normal: n,
                overlap,
                velocity: (twist.v - part.velocity_at(home + n * arm)) + twist.w.cross(&n) * arm,
                twist: 0.5 * (twist.w + part.twist.w).dot(&n),
                rolling: twist.w - part.twist.w,
            };
            let squeezed = scenery.lubrication(&contact, entry.reduced);
            if overlap <= 0.0 {
                on_body.force -= n * squeezed;
                on_part.force += n * squeezed;
                let lever = home + n * arm - Vec3::from(part.pose.position);
                on_part.torque += lever.cross(&n) * squeezed;
                continue;
            }
            let heir =
                closest(&old[..known], n).filter(|&k| !std::mem::replace(&mut used[k], true));
            let mut memory = heir.map_or(Memory::default(), |k| old[k]);
            let touched = heir.is_some();
            let f =
                contact::force(law, entry.reduced, &contact, &mut memory, touched, scenery.steps);
            entry.memories[entry.touching as usize] = memory;
            entry.touching += 1;
            let force = f.tangential - n * (f.normal + squeezed);
            on_body.force += force;
            on_body.torque += n.cross(&f.tangential) * arm + f.rolling;
            let lever = home + n * arm - Vec3::from(part.pose.position);
            on_part.force -= force;
            on_part.torque -= lever.cross(&force) + f.rolling;
            tally.add(overlap / ball.radius, self.body as u32, Other::Part(entry.part));
        }
    }
}

/// The memory whose normal is closest to `n`, if it turned by less than 10 degrees.
pub(crate) fn closest(memories: &[Memory], n: Vec3) -> Option<usize> {
    let along = |k: usize| memories[k].normal.dot(&n);
    let best = (0..memories.len()).max_by(|&a, &b| along(a).total_cmp(&along(b)))?;
    (along(best) > SAME).then_some(best)
}
