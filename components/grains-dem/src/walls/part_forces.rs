//! Contact forces of all parts and walls near one body.

use crate::Vec3;
use crate::bodies::body_arrays::{BoundingSphere, Twist, Wrench};
use crate::bodies::mesh_contact::{self, MOST, ReachedPoints, Seeker, WallPoint, WallPoints};
use crate::bodies::placed_parts::PlacedPart;
use crate::bodies::slider::Along;
use crate::contact::contact_force::{self, Contact, ContactHistory};
use crate::contact::contact_history::{Remembered, WallContactHistory};
use crate::contact::region_shares::{of_one_region, shares};
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::{Other, Tally};
use crate::walls::part_contacts::{ListedWall, PartLoad, WallId, WallVirial};
use crate::walls::reached_walls::{Reached, is_soft, together};
use tremie_grains_kit::profiles::add_virial;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_grains_kit::space::wall_triangle::Triangle;

/// A body beside parts and walls.
pub(crate) struct SphereAtWalls<'a> {
    pub body: usize,
    pub parts: &'a [PlacedPart],
    pub walls: &'a [Wall],
    pub scenery: &'a ContactContext<'a>,
}

/// Sums of the contacts of bodies: loads on parts, contacts, and what is asked for of the body's
/// own.
pub(crate) type PartSums<'a> = (&'a mut [PartLoad], &'a mut Tally, Option<&'a mut WallVirial>);

impl WallVirial {
    /// Adds the force of a contact on the body [N].
    fn push(&mut self, contact: &WallPoint, radius: f64, force: Vec3) {
        // To the point half way between the two surfaces, as torques.
        let arm = contact.normal * (-0.5 * (radius + contact.distance));
        add_virial(&mut self.virial, arm.into(), force.into());
    }
}

/// Parts, walls and triangles near the body.
pub(crate) struct NearWalls<'a> {
    pub entries: &'a mut [ListedWall],
    /// `ends[e]..ends[e + 1]`, less `ends[0]`, are the triangles of entry e.
    pub ends: &'a [u32],
    /// Distance of each triangle at the body's last full search [m].
    pub distances: &'a mut [f32],
    /// The triangles, with the images that see them.
    pub triangles: &'a [(u32, u32)],
}

impl NearWalls<'_> {
    /// Range of an entry's triangles in `triangles`.
    fn own(&self, e: usize) -> core::ops::Range<usize> {
        let place = |e: usize| (self.ends[e] - self.ends[0]) as usize;
        place(e)..place(e + 1)
    }
}

impl SphereAtWalls<'_> {
    /// Finds the reach of the body.
    pub fn reach(&self, near: &mut NearWalls<'_>, reached: &mut Reached) {
        for contact in self.find(near).contacts() {
            let entry = &near.entries[contact.owner as usize];
            reached.add(*contact, (entry.law, entry.reduced));
        }
    }

    /// The contacts, of parts and walls alone.
    fn find(&self, near: &mut NearWalls<'_>) -> WallPoints {
        let mut candidates = ReachedPoints::NONE;
        for e in 0..near.entries.len() {
            self.look(e, near, &mut candidates);
        }
        candidates.contacts(self.scenery.bodies.balls[self.body].radius)
    }

    /// The contacts, and the share of each spring; with those of `soft` surfaces, where there are
    /// any.
    fn find_with(
        &self,
        near: &mut NearWalls<'_>,
        soft: Option<&Reached>,
    ) -> (WallPoints, [f64; MOST]) {
        let radius = self.scenery.bodies.balls[self.body].radius;
        match soft.filter(|soft| !soft.is_empty()) {
            Some(soft) => {
                let mut rigid = Reached::NONE;
                self.reach(near, &mut rigid);
                together(&rigid, soft, radius, self.scenery.laws)
            }
            None => {
                let found = self.find(near);
                (found, self.springs(found.contacts(), near.entries))
            }
        }
    }

    /// The force on the body, whose contacts with `soft` surfaces are evaluated elsewhere; those on
    /// parts are added to the loads, and what is asked for of the body's contacts to its virial.
    pub fn evaluate(
        &self,
        mut near: NearWalls<'_>,
        soft: Option<&Reached>,
        history: &mut WallContactHistory,
        (loads, tally, mut virial): PartSums<'_>,
    ) -> Wrench {
        virial.iter_mut().for_each(|virial| **virial = WallVirial::default());
        let ball = &self.scenery.bodies.balls[self.body];
        near.entries.iter_mut().for_each(|entry| entry.on_wall = Vec3::zeros());
        let (found, springs) = self.find_with(&mut near, soft);
        let found = found.contacts();
        let mut on_body = Wrench::zero();
        if found.is_empty() {
            history.clear();
            return on_body;
        }
        let before = *history;
        history.clear();
        let shares = self.shares(found, springs);
        let mut regions = Regions::default();
        // Those of surfaces are counted there.
        for (contact, share) in found.iter().zip(shares).filter(|(contact, _)| is_soft(contact)) {
            if share.spring > 0.0 {
                regions.is_new(contact.normal);
            }
        }
        let memories = Memories { own: &before, of_surfaces: soft.map(|soft| &soft.history) };
        let rigid = found.iter().zip(shares).filter(|(contact, _)| !is_soft(contact));
        for (contact, share) in rigid {
            let e = contact.owner as usize;
            let met = Meeting { entry: &near.entries[e], contact, share };
            let home = ball.x + self.shift(&near, e);
            let force = self.meet(&met, home, (&memories, history), loads);
            on_body.force += force.force;
            on_body.torque += force.torque;
            if let Some(virial) = &mut virial {
                virial.push(contact, ball.radius, force.force);
            }
            let other = match met.entry.met {
                WallId::Part(part) => Other::Part(part),
                WallId::Wall(wall) => {
                    near.entries[e].on_wall -= force.force;
                    Other::Wall(wall)
                }
            };
            if share.spring > 0.0 {
                let ratio = 1.0 - contact.distance / ball.radius;
                if regions.is_new(contact.normal) {
                    virial.iter_mut().for_each(|virial| virial.contacts += 1);
                    tally.add(ratio, self.body as u32, other);
                } else {
                    tally.deepen(ratio, self.body as u32, other);
                }
            }
        }
        on_body
    }

    /// Vector from the body to the image of it that an entry's part sees.
    fn shift(&self, near: &NearWalls<'_>, e: usize) -> Vec3 {
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
    fn look(&self, e: usize, near: &mut NearWalls<'_>, candidates: &mut ReachedPoints) {
        let BoundingSphere { x, radius } = self.scenery.bodies.balls[self.body];
        let reach = radius + self.scenery.reach;
        let number = match near.entries[e].met {
            WallId::Part(number) => number as usize,
            WallId::Wall(number) => {
                let wall = &self.walls[number as usize];
                let distance = x.dot(&wall.normal) - wall.offset;
                if distance < reach {
                    // Parts come before walls.
                    let rank = self.parts.len() as u32 + number;
                    let point = WallPoint::of_plane(wall.normal, distance);
                    candidates.take(WallPoint { owner: e as u32, rank, ..point });
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
            let mut triangle = part.shape.triangle(triangle);
            if other != seen {
                // The surface as this image sees it, moved to where the first one does.
                let apart = part.shape.to_part(shift(seen) - shift(other))
                    - part.shape.to_part(Vec3::zeros());
                triangle.corners = triangle.corners.map(|corner| corner + apart);
            }
            triangle
        };
        let sphere = Seeker { centre: part.shape.to_part(x + shift(seen)), radius, reach };
        let looked = (&mut near.entries[e].looked, &mut near.distances[own]);
        // As the part sees it, only the body moves.
        mesh_contact::look(sphere, 0.0, looked, triangle, |found| {
            let normal = part.shape.to_world(found.normal);
            let point = normal * -found.distance;
            candidates.take(WallPoint { normal, point, owner: e as u32, rank: part.rank, ..found });
        });
    }

    /// Shares of the springs of the contacts.
    fn springs(&self, found: &[WallPoint], entries: &[ListedWall]) -> [f64; MOST] {
        let radius = self.scenery.bodies.balls[self.body].radius;
        shares(found, |contact| {
            let entry = &entries[contact.owner as usize];
            let law = &self.scenery.laws[entry.law as usize];
            law.normal_root(radius - contact.distance, entry.reduced)
        })
    }

    /// Shares of the contacts: those of the springs as given, and those of the fluid films.
    /// Surfaces that deform have no film.
    fn shares(&self, found: &[WallPoint], springs: [f64; MOST]) -> [WallShare; MOST] {
        let radius = self.scenery.bodies.balls[self.body].radius;
        let mut all = springs.map(|spring| WallShare { spring, film: 0.0 });
        if self.scenery.squeeze.is_some() {
            let reach = radius + self.scenery.reach;
            let films =
                shares(
                    found,
                    |contact| {
                        if is_soft(contact) { 0.0 } else { reach - contact.distance }
                    },
                );
            all.iter_mut().zip(films).for_each(|(share, film)| share.film = film);
        }
        all
    }

    /// One contact: the force on the body. That on a part is added to `loads`.
    fn meet(
        &self,
        met: &Meeting<'_>,
        home: Vec3,
        (before, history): (&Memories<'_>, &mut WallContactHistory),
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
            WallId::Part(part) => {
                let part = &self.parts[part as usize];
                Twist { v: part.velocity_at(place), w: part.twist.w }
            }
            WallId::Wall(wall) => Twist { v: self.walls[wall as usize].velocity, w: Vec3::zeros() },
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
        let law = &scenery.laws[entry.law as usize];
        let heir = if share > 0.0 { before.heir(n) } else { None };
        if share > 0.0 && law.holds(overlap, entry.reduced, heir.is_some()) {
            let mut memory = heir.unwrap_or_default();
            let (touched, steps) = (heir.is_some(), scenery.steps);
            let f = contact_force::force(law, entry.reduced, &contact, &mut memory, touched, steps);
            history.add(Remembered { memory, share, law: entry.law, reduced: entry.reduced });
            rolling = f.rolling * share;
            on_body.force += (f.tangential - n * f.normal) * share;
            on_body.torque = n.cross(&f.tangential) * (arm * share) + rolling;
        }
        if let WallId::Part(number) = entry.met {
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

/// Share of a contact that counts: of its spring, and of the fluid film in its gap.
#[derive(Clone, Copy, Debug)]
struct WallShare {
    spring: f64,
    film: f64,
}

/// Histories of the body's contacts: with parts and walls, and with surfaces that it touches.
struct Memories<'a> {
    own: &'a WallContactHistory,
    of_surfaces: Option<&'a WallContactHistory>,
}

impl Memories<'_> {
    fn heir(&self, n: Vec3) -> Option<ContactHistory> {
        self.own.heir(n).or_else(|| self.of_surfaces?.heir(n))
    }
}

/// A contact with its wall or part.
struct Meeting<'a> {
    entry: &'a ListedWall,
    contact: &'a WallPoint,
    share: WallShare,
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
