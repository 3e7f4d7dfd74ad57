//! Contact forces of all parts and walls near one body.

use crate::{
    Vec3,
    bodies::{Ball, Twist, Wrench},
    contact::{self, Contact},
    forces::Scenery,
    history::{History, Remembered},
    mesh_contact::{self, Candidates, MOST, Nearest, Seeker, Triangle},
    part_contacts::{Entry, Met, PartLoad},
    parts::PlacedPart,
    shares::{of_one_region, shares},
    slider::Along,
    tally::{Other, Tally},
    walls::Wall,
};

/// A body beside parts and walls.
pub(crate) struct Place<'a> {
    pub body: usize,
    pub parts: &'a [PlacedPart],
    pub walls: &'a [Wall],
    pub scenery: &'a Scenery<'a>,
}

/// What it is near to.
pub(crate) struct Near<'a> {
    pub entries: &'a mut [Entry],
    /// `ends[e]..ends[e + 1]`, less `ends[0]`, are the triangles of entry e.
    pub ends: &'a [u32],
    /// How far each was when the body looked at all.
    pub distances: &'a mut [f32],
    /// The triangles, with the images that see them.
    pub triangles: &'a [(u32, u32)],
}

impl Near<'_> {
    /// Which triangles are those of an entry.
    fn own(&self, e: usize) -> core::ops::Range<usize> {
        let place = |e: usize| (self.ends[e] - self.ends[0]) as usize;
        place(e)..place(e + 1)
    }
}

impl Place<'_> {
    /// The force on the body; those on parts are added to `loads`.
    pub fn evaluate(
        &self,
        mut near: Near<'_>,
        history: &mut History,
        loads: &mut [PartLoad],
        tally: &mut Tally,
    ) -> Wrench {
        let ball = &self.scenery.bodies.balls[self.body];
        let mut candidates = Candidates::NONE;
        for e in 0..near.entries.len() {
            near.entries[e].on_wall = Vec3::zeros();
            self.look(e, &mut near, &mut candidates);
        }
        let found = candidates.contacts(ball.radius);
        let found = found.contacts();
        let mut on_body = Wrench::zero();
        if found.is_empty() {
            history.clear();
            return on_body;
        }
        let before = *history;
        history.clear();
        let shares = self.shares(found, near.entries);
        let mut regions = Regions::default();
        for (contact, share) in found.iter().zip(shares) {
            let e = contact.owner as usize;
            let met = Meeting { entry: &near.entries[e], contact, share };
            let home = ball.x + self.shift(&near, e);
            let force = self.meet(&met, home, (&before, history), loads);
            on_body.force += force.force;
            on_body.torque += force.torque;
            let other = match met.entry.met {
                Met::Part(part) => Other::Part(part),
                Met::Wall(wall) => {
                    near.entries[e].on_wall -= force.force;
                    Other::Wall(wall)
                }
            };
            if share.spring > 0.0 {
                let ratio = 1.0 - contact.distance / ball.radius;
                if regions.is_new(contact.normal) {
                    tally.add(ratio, self.body as u32, other);
                } else {
                    tally.deepen(ratio, self.body as u32, other);
                }
            }
        }
        on_body
    }

    /// From the body to the image of it that an entry's part sees.
    fn shift(&self, near: &Near<'_>, e: usize) -> Vec3 {
        let first = near.triangles[near.own(e)].first();
        first.map_or(Vec3::zeros(), |&(_, image)| self.scenery.shifts[self.image(image)])
    }

    /// The image that was `seen` when neighbours were listed, as it is now.
    fn image(&self, seen: u32) -> usize {
        let bodies = self.scenery.bodies;
        let crossed = if self.scenery.crossed { bodies.crossed[self.body] } else { 0 };
        (seen as i32 + crossed) as usize
    }

    /// Adds the points of an entry that are in reach, with the body's centre as their origin.
    fn look(&self, e: usize, near: &mut Near<'_>, candidates: &mut Candidates) {
        let Ball { x, radius } = self.scenery.bodies.balls[self.body];
        let reach = radius + self.scenery.reach();
        let number = match near.entries[e].met {
            Met::Part(number) => number as usize,
            Met::Wall(number) => {
                let wall = &self.walls[number as usize];
                let distance = x.dot(&wall.normal) - wall.offset;
                if distance < reach {
                    // Parts come before walls.
                    let rank = self.parts.len() as u32 + number;
                    let point = Nearest::of_plane(wall.normal, distance);
                    candidates.take(Nearest { owner: e as u32, rank, ..point });
                }
                return;
            }
        };
        let part = &self.parts[number];
        let own = near.own(e);
        let triangles = &near.triangles[own.clone()];
        // Almost always there is one image; then all triangles are seen together, as they must be.
        let Some(&(_, seen)) = triangles.first() else { return };
        let shift = |image: u32| self.scenery.shifts[self.image(image)];
        let triangle = |k: usize| -> Triangle {
            let (triangle, other) = triangles[k];
            let mut triangle = part.triangle(triangle);
            if other != seen {
                // The surface as this image sees it, moved to where the first one does.
                let apart = part.to_part(shift(seen) - shift(other)) - part.to_part(Vec3::zeros());
                triangle.corners = triangle.corners.map(|corner| corner + apart);
            }
            triangle
        };
        let sphere = Seeker { centre: part.to_part(x + shift(seen)), radius, reach };
        let looked = (&mut near.entries[e].looked, &mut near.distances[own]);
        // As the part sees it, only the body moves.
        mesh_contact::look(sphere, 0.0, looked, triangle, |found| {
            let normal = part.to_world(found.normal);
            let point = normal * -found.distance;
            candidates.take(Nearest { normal, point, owner: e as u32, rank: part.rank, ..found });
        });
    }

    /// How much of each contact counts.
    fn shares(&self, found: &[Nearest], entries: &[Entry]) -> [Share; MOST] {
        let radius = self.scenery.bodies.balls[self.body].radius;
        let springs = shares(found, |contact| {
            let entry = &entries[contact.owner as usize];
            let overlap = (radius - contact.distance).max(0.0);
            let law = &self.scenery.laws[entry.law as usize];
            (2.0 * law.normal_energy(overlap, entry.reduced)).sqrt()
        });
        let mut all = springs.map(|spring| Share { spring, film: 0.0 });
        if self.scenery.squeeze.is_some() {
            let reach = radius + self.scenery.reach();
            let films = shares(found, |contact| reach - contact.distance);
            all.iter_mut().zip(films).for_each(|(share, film)| share.film = film);
        }
        all
    }

    /// One contact: the force on the body. That on a part is added to `loads`.
    fn meet(
        &self,
        met: &Meeting<'_>,
        home: Vec3,
        (before, history): (&History, &mut History),
        loads: &mut [PartLoad],
    ) -> Wrench {
        let (scenery, entry) = (self.scenery, met.entry);
        let n = -met.contact.normal;
        let radius = scenery.bodies.balls[self.body].radius;
        let overlap = radius - met.contact.distance;
        let arm = radius - 0.5 * overlap;
        let twist = &scenery.bodies.predicted[self.body];
        let place = home + n * arm;
        let other = match entry.met {
            Met::Part(part) => {
                let part = &self.parts[part as usize];
                Twist { v: part.velocity_at(place), w: part.twist.w }
            }
            Met::Wall(wall) => Twist { v: self.walls[wall as usize].velocity, w: Vec3::zeros() },
        };
        let contact = Contact {
            normal: n,
            overlap,
            velocity: (twist.v - other.v) + twist.w.cross(&n) * arm,
            twist: 0.5 * (twist.w + other.w).dot(&n),
            rolling: twist.w - other.w,
        };
        let squeezed = scenery.lubrication(&contact, entry.reduced) * met.share.film;
        let mut on_body = Wrench { force: n * -squeezed, torque: Vec3::zeros() };
        let mut rolling = Vec3::zeros();
        let share = met.share.spring;
        if overlap > 0.0 && share > 0.0 {
            let law = &scenery.laws[entry.law as usize];
            let heir = before.heir(n);
            let mut memory = heir.unwrap_or_default();
            let (touched, steps) = (heir.is_some(), scenery.steps);
            let f = contact::force(law, entry.reduced, &contact, &mut memory, touched, steps);
            history.add(Remembered { memory, share, law: entry.law, reduced: entry.reduced });
            rolling = f.rolling * share;
            on_body.force += (f.tangential - n * f.normal) * share;
            on_body.torque = n.cross(&f.tangential) * (arm * share) + rolling;
        }
        if let Met::Part(number) = entry.met {
            let (part, load) = (&self.parts[number as usize], &mut loads[number as usize]);
            let lever = place - Vec3::from(part.pose.position);
            load.wrench.force -= on_body.force;
            load.wrench.torque -= lever.cross(&on_body.force) + rolling;
            if let Some(slider) = part.slider() {
                load.push.add(Along::of(-on_body.force.dot(&slider.axis)));
            }
        }
        on_body
    }
}

/// How much of a contact counts: of its springs, and of the fluid in its gap.
#[derive(Clone, Copy, Debug)]
struct Share {
    spring: f64,
    film: f64,
}

/// A contact with what is met there.
struct Meeting<'a> {
    entry: &'a Entry,
    contact: &'a Nearest,
    share: Share,
}

/// Directions of the regions that a body touches, for these are what is counted as contacts.
#[derive(Default)]
struct Regions {
    normals: [Vec3; MOST],
    count: usize,
}

impl Regions {
    fn is_new(&mut self, normal: Vec3) -> bool {
        if self.normals[..self.count].iter().any(|&known| of_one_region(known, normal)) {
            return false;
        }
        self.normals[self.count] = normal;
        self.count += 1;
        true
    }
}
