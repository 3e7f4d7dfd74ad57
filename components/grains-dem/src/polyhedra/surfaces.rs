//! Pressure of walls and parts on a polyhedron, all of them together.
//!
//! Pieces of surfaces that press in nearly one direction are one region, with one contact: one
//! dashpot, one spring of friction. If its owners differ in law, mass or motion, each kind of them
//! has a contact, and dashpots share what one would have over the whole region. Loads go to owners
//! by their shares of the pressure.

use super::{
    contact_geometry,
    contact_pair::{Around, MOST, SolidPairEntry, stiffness},
    hidden::{Cover, Covers, HiddenSearch, Whose},
    overlap_integrals::{OverlapRoom, Press},
    overlap_response::{self, OverlapHistory, Pair, Relative, Response},
    shape::Solid,
};
use crate::Vec3;
use crate::bodies::body_arrays::{Twist, Wrench};
use crate::bodies::mesh_contact::SAME;
use crate::math::tally::{Other, Tally};
use crate::walls::part_contacts::WallId;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::wall_triangle::Triangle;

/// A wall or part near a polyhedron.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Owner {
    pub met: WallId,
    pub rank: u32,
    pub law: u16,
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: f64,
    /// Triangles of a part near the body, with the images that see them.
    pub near: [u32; 2],
    /// Load on it at the last evaluation, about the reference point of a part, and of a wall the
    /// force alone.
    pub load: Wrench,
}

/// Pressure of one owner in a contact.
#[derive(Clone, Copy, Debug)]
struct SurfaceShare {
    contact: u8,
    owner: u32,
    press: Press,
}

/// Room to work in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bench {
    pub room: OverlapRoom,
    pub(super) covers: Covers,
    shares: Vec<SurfaceShare>,
    polygon: Vec<Vec3>,
}

impl Bench {
    /// Makes room for so many owners and triangles near one body.
    pub fn reserve(&mut self, owners: usize, triangles: usize) {
        if owners > 0 {
            self.covers.reserve(owners + triangles);
            self.polygon.reserve(4);
            self.shares.reserve((owners * MOST).saturating_sub(self.shares.len()));
        }
    }
}

/// A contact: the pressure in one direction, of owners that are alike.
#[derive(Clone, Copy, Debug)]
struct Touch {
    press: Press,
    /// The first of the owners.
    kind: u32,
    /// The first of the contacts of the region.
    region: u8,
}

/// A body beside walls and parts.
pub(super) struct SurfacesBeside<'a> {
    around: Around<'a>,
    i: usize,
    pub solid: Solid<'a>,
}

impl<'a> SurfacesBeside<'a> {
    pub fn new(around: &Around<'a>, i: usize) -> Self {
        let solid = around.polyhedra.solid(around.scenery.bodies.poly[i] as usize);
        Self { around: *around, i, solid }
    }

    /// Position of the body, seen from the image by which neighbours were listed [m].
    fn home(&self, image: u32) -> Vec3 {
        let (scenery, i) = (&self.around.scenery, self.i);
        let crossed = if scenery.crossed { scenery.bodies.crossed[i] } else { 0 };
        scenery.bodies.balls[i].x + scenery.shifts[(image as i32 + crossed) as usize]
    }

    /// Position of the body as an owner is met: of all images where that is closest. Velocities are
    /// the same for all but parts that turn, which do not reach across periodic faces.
    fn home_of(&self, owner: &Owner) -> Vec3 {
        let first = self.around.triangles[owner.near[0] as usize..owner.near[1] as usize].first();
        self.home(first.map_or(13, |&(_, image)| image))
    }

    /// The triangles of an owner, from the body's centroid.
    fn triangles(&self, owner: &Owner) -> impl Iterator<Item = Triangle> + '_ {
        let part = match owner.met {
            WallId::Part(part) => Some(&self.around.parts[part as usize]),
            WallId::Wall(_) => None,
        };
        let near = &self.around.triangles[owner.near[0] as usize..owner.near[1] as usize];
        part.into_iter().flat_map(move |part| {
            near.iter().map(move |&(triangle, image)| {
                let mut triangle = part.shape.placed_triangle(triangle);
                let home = self.home(image);
                triangle.corners = triangle.corners.map(|corner| corner - home);
                triangle
            })
        })
    }

    /// The wall that an owner is: normal, and height of the centroid over it.
    fn wall(&self, owner: &Owner) -> Option<(Vec3, f64)> {
        let WallId::Wall(number) = owner.met else { return None };
        let wall = &self.around.walls[number as usize];
        let x = self.around.scenery.bodies.balls[self.i].x;
        Some((wall.normal, x.dot(&wall.normal) - wall.offset))
    }

    /// True for a symmetry plane: it shares no contact with other owners.
    fn is_mirror(&self, owner: &Owner) -> bool {
        matches!(owner.met, WallId::Wall(number) if self.around.walls[number as usize].mirror)
    }

    fn whose(owners: &[Owner], owner: usize) -> Whose {
        let Owner { met, rank, .. } = owners[owner];
        Whose { owner: owner as u32, rank, wall: matches!(met, WallId::Wall(_)) }
    }

    /// Finds what is below owners; nothing of one alone.
    pub fn cover(&self, owners: &[Owner], covers: &mut Covers) {
        covers.list.clear();
        let is_real = |&o: &usize| !self.is_mirror(&owners[o]);
        if (0..owners.len()).filter(is_real).count() < 2 {
            return;
        }
        for o in (0..owners.len()).filter(is_real) {
            let (owner, whose) = (&owners[o], Self::whose(owners, o));
            if let Some((normal, height)) = self.wall(owner) {
                covers.list.extend(Cover::of_wall(whose, normal, -height, self.solid));
            }
            let below = |t: Triangle| Cover::of_triangle(whose, &t, self.solid);
            covers.list.extend(self.triangles(owner).filter_map(below));
        }
    }

    /// Visits polygons of an owner that press on the body: polygon and normal, what it presses, and
    /// the pieces of it that do not lie hidden, if any does.
    pub fn polygons(
        &self,
        (owners, o): (&[Owner], usize),
        bench: &mut Bench,
        mut visit: impl FnMut((&[Vec3], Vec3), &Press, Option<&Covers>, &mut OverlapRoom),
    ) {
        let Bench { room, covers, polygon, .. } = bench;
        let (owner, solid) = (&owners[o], self.solid);
        let is_mirror = self.is_mirror(owner);
        let mut one = |polygon: &[Vec3], normal: Vec3, press: &Press, room: &mut OverlapRoom| {
            if press.acts() {
                let inradius = solid.inradius();
                let looked = HiddenSearch { whose: Self::whose(owners, o), normal, inradius };
                let cut = !is_mirror && covers.cut(polygon, &looked);
                visit((polygon, normal), press, cut.then_some(&*covers), room);
            }
        };
        if let Some((normal, height)) = self.wall(owner) {
            let press = contact_geometry::of_plane(solid, normal, height, room);
            contact_geometry::square(
                normal,
                height,
                solid.shape.circumradius * solid.size,
                polygon,
            );
            one(polygon, normal, &press, room);
        }
        for triangle in self.triangles(owner) {
            let mut press = Press::NONE;
            contact_geometry::of_triangle(solid, &triangle, room, &mut press);
            one(&triangle.corners, triangle.normal, &press, room);
        }
    }

    /// Velocities of an owner, at the body's centroid.
    fn twist(&self, owner: &Owner) -> Twist {
        match owner.met {
            WallId::Wall(number) => {
                Twist { v: self.around.walls[number as usize].velocity, w: Vec3::zeros() }
            }
            WallId::Part(number) => {
                let part = &self.around.parts[number as usize];
                Twist { v: part.velocity_at(self.home_of(owner)), w: part.twist.w }
            }
        }
    }

    /// The first owner that is as this one: of one law, mass and velocity everywhere.
    fn kind(&self, owners: &[Owner], o: usize) -> u32 {
        let (owner, twist) = (&owners[o], self.twist(&owners[o]));
        let alike = |other: &Owner| {
            let moves = self.twist(other);
            other.law == owner.law
                && other.root_mass == owner.root_mass
                && moves.v == twist.v
                && moves.w == Vec3::zeros()
        };
        let is_plain = twist.w == Vec3::zeros() && !self.is_mirror(owner);
        let earlier =
            || owners[..o].iter().position(|other| !self.is_mirror(other) && alike(other));
        is_plain.then(earlier).flatten().unwrap_or(o) as u32
    }
}

/// The contacts of a body with walls and parts.
struct Touches {
    list: [Touch; MOST],
    count: usize,
}

impl Touches {
    /// Adds what a piece of an owner presses; the contact that it is of.
    fn add(&mut self, press: &Press, kind: u32, alone: bool) -> usize {
        let list = &self.list[..self.count];
        let known = list.iter().position(|t| t.kind == kind && alike(&t.press, press));
        let place = known.unwrap_or(self.count.min(MOST - 1));
        if place == self.count {
            let region = list.iter().find(|t| !alone && alike(&t.press, press));
            let region = region.map_or(place as u8, |t| t.region);
            self.list[place] = Touch { press: Press::NONE, kind, region };
            self.count += 1;
        }
        self.list[place].press.merge(press);
        place
    }

    fn all(&self) -> &[Touch] {
        &self.list[..self.count]
    }

    /// Part of the reference area that is loaded in the region of a contact, if there are others in
    /// it.
    fn region(&self, touch: &Touch, area: f64) -> Option<f64> {
        let own = || self.all().iter().filter(|t| t.region == touch.region);
        let sum = own().fold(Vec3::zeros(), |sum, t| sum + t.press.area);
        (own().count() > 1).then(|| sum.norm_squared().sqrt() / area)
    }
}

impl SolidPairEntry {
    /// Walls and parts: loads on the body and on these.
    pub(super) fn surfaces(
        &mut self,
        around: &Around<'_>,
        owners: &mut [Owner],
        memories: &mut [OverlapHistory],
        (bench, tally): (&mut Bench, &mut Tally),
    ) {
        let beside = SurfacesBeside::new(around, self.places[0] as usize);
        let touches = beside.touches(owners, bench);
        // A copy: new histories overwrite old ones that later contacts may still continue.
        let mut before = [OverlapHistory::NONE; MOST];
        before.copy_from_slice(memories);
        let known = self.touching as usize;
        let mut used = [false; MOST];
        self.touching = touches.count as u8;
        owners.iter_mut().for_each(|owner| owner.load = Wrench::zero());
        let predicted = &around.scenery.bodies.predicted[self.places[0] as usize];
        for (number, touch) in touches.all().iter().enumerate() {
            let owner = &owners[touch.kind as usize];
            let n = -touch.press.force / touch.press.force.norm_squared().sqrt();
            let heir = heir(&before[..known], &mut used, n, owner.rank);
            let mut memory = heir.map_or(OverlapHistory::NONE, |k| before[k]);
            memory.owner = owner.rank;
            let law = &around.scenery.laws[owner.law as usize];
            let kappa = stiffness(law) / self.area;
            let region = touches.region(touch, self.area);
            let pair = Pair { root_mass: owner.root_mass, kappa, region };
            let twist = beside.twist(owner);
            let (v, w) = (predicted.v - twist.v, predicted.w - twist.w);
            let relative = Relative { v, w, both: predicted.w + twist.w };
            let steps = (heir.is_some(), around.scenery.steps);
            let response =
                overlap_response::load(law, pair, &touch.press, &relative, &mut memory, steps);
            memories[number] = memory;
            self.loads[0].force += response.load.force;
            self.loads[0].torque += response.load.torque;
            let shares =
                || bench.shares.iter().filter(|share| usize::from(share.contact) == number);
            let alone = shares().count() == 1;
            for share in shares() {
                let of_share = |r: &Response| r.of_share(&share.press, &touch.press, kappa);
                // The load of a single owner is taken as it is: a share of one would round it.
                let load = if alone { response.load } else { of_share(&response) };
                beside.give(&mut owners[share.owner as usize], load);
            }
        }
        beside.count(&touches, owners, &bench.shares, tally);
    }
}

impl SurfacesBeside<'_> {
    /// Finds the contacts, and the owners' shares in them.
    fn touches(&self, owners: &[Owner], bench: &mut Bench) -> Touches {
        self.cover(owners, &mut bench.covers);
        // Taken out, as the bench is borrowed while polygons are visited.
        let mut shares = std::mem::take(&mut bench.shares);
        shares.clear();
        let none = Touch { press: Press::NONE, kind: 0, region: 0 };
        let mut touches = Touches { list: [none; MOST], count: 0 };
        for o in 0..owners.len() {
            let (first, mut kind) = (shares.len(), None);
            let alone = self.is_mirror(&owners[o]);
            let mut add = |press: &Press| {
                let kind = *kind.get_or_insert_with(|| self.kind(owners, o));
                let contact = touches.add(press, kind, alone) as u8;
                let known = shares[first..].iter().position(|share| share.contact == contact);
                let place = known.map_or(shares.len(), |k| first + k);
                if place == shares.len() {
                    shares.push(SurfaceShare { contact, owner: o as u32, press: Press::NONE });
                }
                shares[place].press.merge(press);
            };
            self.polygons((owners, o), bench, |(_, normal), press, covers, room| {
                let Some(covers) = covers else { return add(press) };
                for piece in covers.pieces() {
                    let press = contact_geometry::of_polygon(self.solid, piece, normal, room);
                    if press.acts() {
                        add(&press);
                    }
                }
            });
        }
        bench.shares = shares;
        touches
    }

    /// Puts the opposite of a load on the body, about its centroid, on an owner.
    fn give(&self, owner: &mut Owner, load: Wrench) {
        let lever = match owner.met {
            WallId::Wall(_) => Vec3::zeros(),
            WallId::Part(number) => {
                let part = &self.around.parts[number as usize];
                self.home_of(owner) - Vec3::from(part.pose.position)
            }
        };
        owner.load.force -= load.force;
        owner.load.torque -= load.torque + lever.cross(&load.force);
    }

    /// Counts the regions, each where it is deepest.
    fn count(
        &self,
        touches: &Touches,
        owners: &[Owner],
        shares: &[SurfaceShare],
        tally: &mut Tally,
    ) {
        for region in 0..touches.count as u8 {
            let own =
                |share: &&SurfaceShare| touches.list[usize::from(share.contact)].region == region;
            let mut own = shares.iter().filter(own);
            let Some(first) = own.next() else { continue };
            let deeper = |a: f64, b: f64| b > a;
            let deepest = own.fold(first, |best, share| {
                if deeper(best.press.deepest, share.press.deepest) { share } else { best }
            });
            let other = match owners[deepest.owner as usize].met {
                WallId::Part(part) => Other::Part(part),
                WallId::Wall(wall) => Other::Wall(wall),
            };
            tally.add(deepest.press.deepest / self.solid.inradius(), self.i as u32, other);
        }
    }
}

/// True if two press in nearly one direction.
fn alike(a: &Press, b: &Press) -> bool {
    let along = a.force.dot(&b.force);
    let squares = a.force.norm_squared() * b.force.norm_squared();
    along > 0.0 && along * along > SAME * SAME * squares
}

/// The memory that a contact with the normal `n` goes on with: one that turned by less than 10
/// degrees, if it can be one that no other contact has, of the same owner, and the closest.
fn heir(memories: &[OverlapHistory], used: &mut [bool], n: Vec3, owner: u32) -> Option<usize> {
    let along = |k: usize| memories[k].normal.dot(&n);
    let key = |k: usize| (!used[k], memories[k].owner == owner);
    let best = (0..memories.len())
        .filter(|&k| along(k) > SAME)
        .max_by(|&a, &b| key(a).cmp(&key(b)).then(along(a).total_cmp(&along(b))))?;
    used[best] = true;
    Some(best)
}
