//! One possible contact of a polyhedron, and its evaluation.

use super::{
    Polyhedra, SPHERE,
    press::{Press, Room},
    respond::{self, Memory, Pair, Relative},
    touch,
};
use crate::{
    Vec3,
    bodies::Wrench,
    contact::{self, Contact},
    forces::Scenery,
    law::{Law, Reduced},
    mesh_contact::SAME,
    parts::PlacedPart,
    tally::{Other, Tally},
    walls::Wall,
};

/// Most contacts with a part: directions in which it presses.
pub(super) const MOST: usize = 8;

/// What a polyhedron may touch, in the order in which loads are added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Body,
    Wall,
    Part,
}

/// A possible contact: of the body with the smaller id with another, or of a polyhedron with a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Id of the body, kind and number (an id) of the other: in this order they stand in the list.
    pub key: (u64, Kind, u64),
    /// Where both stand in memory; the other may be a wall or a part.
    pub places: [u32; 2],
    /// Image through which the other body is seen.
    pub image: u32,
    pub law: u16,
    /// `sqrt(m*)` [kg^(1/2)], and the area that stiffness is for [m²].
    pub root_mass: f64,
    pub area: f64,
    /// Triangles of a part near it, with the images that see them.
    pub near: [u32; 2],
    /// How many contacts there were at the last evaluation.
    pub touching: u8,
    /// Loads on both at the last evaluation, about their reference points.
    pub loads: [Wrench; 2],
}

/// What contacts are evaluated from.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub scenery: Scenery<'a>,
    pub polyhedra: &'a Polyhedra,
    pub walls: &'a [Wall],
    pub parts: &'a [PlacedPart],
    pub triangles: &'a [(u32, u32)],
}

impl Entry {
    /// Number of memories that it needs.
    pub fn memories(&self) -> usize {
        if self.key.1 == Kind::Part { MOST } else { 1 }
    }

    /// Finds the loads.
    pub fn evaluate(
        &mut self,
        around: &Around<'_>,
        memories: &mut [Memory],
        room: &mut Room,
        tally: &mut Tally,
    ) {
        self.loads = [Wrench::zero(); 2];
        match self.key.1 {
            Kind::Body => {
                let [i, j] = self.places.map(|place| place as usize);
                let grains = [i, j].map(|place| around.scenery.bodies.poly[place]);
                let way = around.scenery.between(i, j, self.image);
                match grains {
                    [a, b] if a != SPHERE && b != SPHERE => {
                        self.solids(around, [a, b], way, (&mut memories[0], room, tally));
                    }
                    [a, SPHERE] => {
                        let loads = self.ball(around, (a, i, j), way, &mut memories[0], tally);
                        self.loads = loads;
                    }
                    [_, b] => {
                        let [on_b, on_a] =
                            self.ball(around, (b, j, i), -way, &mut memories[0], tally);
                        self.loads = [on_a, on_b];
                    }
                }
            }
            Kind::Wall => self.wall(around, (&mut memories[0], room, tally)),
            Kind::Part => self.part(around, memories, room, tally),
        }
    }

    /// Two polyhedra, the second `way` from the first.
    fn solids(
        &mut self,
        around: &Around<'_>,
        [a, b]: [u32; 2],
        way: Vec3,
        (memory, room, tally): (&mut Memory, &mut Room, &mut Tally),
    ) {
        let solids = [a, b].map(|grain| around.polyhedra.solid(grain as usize));
        let press = touch::of_solids(solids[0], solids[1], way, room);
        let twists = self.places.map(|place| &around.scenery.bodies.predicted[place as usize]);
        let relative = Relative {
            v: (twists[0].v - twists[1].v) + twists[1].w.cross(&way),
            w: twists[0].w - twists[1].w,
            both: twists[0].w + twists[1].w,
        };
        // Two bodies press on each other, each with half of the stiffness.
        let load = self.respond(around, (&press, 0.5), &relative, memory);
        self.touching = u8::from(press.acts());
        self.loads =
            [load, Wrench { force: -load.force, torque: way.cross(&load.force) - load.torque }];
        if press.acts() {
            let least = solids[0].inradius().min(solids[1].inradius());
            let ratio = press.deepest / least;
            tally.add(ratio, self.places[0], Other::Body(self.places[1]));
        }
    }

    fn respond(
        &self,
        around: &Around<'_>,
        (press, share): (&Press, f64),
        relative: &Relative,
        memory: &mut Memory,
    ) -> Wrench {
        let law = &around.scenery.laws[self.law as usize];
        let pair = Pair { root_mass: self.root_mass, kappa: share * stiffness(law) / self.area };
        let touched = self.touching > 0;
        respond::load(law, pair, press, relative, memory, (touched, around.scenery.steps))
    }

    /// A polyhedron, the number `grain`, standing at `i`, and a sphere at `j`, `way` from it: loads on both.
    fn ball(
        &mut self,
        around: &Around<'_>,
        (grain, i, j): (u32, usize, usize),
        way: Vec3,
        memory: &mut Memory,
        tally: &mut Tally,
    ) -> [Wrench; 2] {
        let bodies = around.scenery.bodies;
        let (radius, solid) = (bodies.balls[j].radius, around.polyhedra.solid(grain as usize));
        let touched = std::mem::replace(&mut self.touching, 0) > 0;
        let near = touch::closest(solid, way);
        let overlap = radius - near.distance;
        if overlap <= 0.0 {
            return [Wrench::zero(); 2];
        }
        self.touching = 1;
        let n = near.normal;
        let point = way - n * (radius - 0.5 * overlap);
        let (a, b) = (&bodies.predicted[i], &bodies.predicted[j]);
        let contact = Contact {
            normal: n,
            overlap,
            velocity: (a.v + a.w.cross(&point)) - (b.v + b.w.cross(&(point - way))),
            twist: 0.5 * (a.w + b.w).dot(&n),
            rolling: a.w - b.w,
        };
        let mut plain = contact::Memory {
            xi: memory.xi,
            rolling: memory.rolling,
            normal: memory.normal,
            overlap: memory.overlap,
        };
        let law = &around.scenery.laws[self.law as usize];
        let reduced = Reduced { root_mass: self.root_mass, radius };
        let steps = around.scenery.steps;
        let f = contact::force(law, reduced, &contact, &mut plain, touched, steps);
        *memory = Memory {
            xi: plain.xi,
            rolling: plain.rolling,
            normal: n,
            overlap,
            energy: {
                let across = contact.velocity - n * contact.velocity.dot(&n);
                let now = plain.xi - across * (0.5 * steps.after);
                0.5 * law.at(overlap, overlap, reduced).k_t * now.norm_squared()
            },
            ..Memory::NONE
        };
        let force = f.tangential - n * f.normal;
        let ratio = overlap / radius.min(solid.inradius());
        tally.add(ratio, i as u32, Other::Body(j as u32));
        [
            Wrench { force, torque: point.cross(&force) + f.rolling },
            Wrench { force: -force, torque: -(point - way).cross(&force) - f.rolling },
        ]
    }

    fn wall(
        &mut self,
        around: &Around<'_>,
        (memory, room, tally): (&mut Memory, &mut Room, &mut Tally),
    ) {
        let (i, bodies) = (self.places[0] as usize, around.scenery.bodies);
        let solid = around.polyhedra.solid(bodies.poly[i] as usize);
        let wall = &around.walls[self.places[1] as usize];
        let height = bodies.balls[i].x.dot(&wall.normal) - wall.offset;
        let press = touch::of_plane(solid, wall.normal, height, room);
        let twist = &bodies.predicted[i];
        let relative = Relative { v: twist.v - wall.velocity, w: twist.w, both: twist.w };
        self.loads[0] = self.respond(around, (&press, 1.0), &relative, memory);
        self.touching = u8::from(press.acts());
        if press.acts() {
            tally.add(press.deepest / solid.inradius(), i as u32, Other::Wall(self.places[1]));
        }
    }

    /// A part: its triangles press in directions, each of which is a contact.
    fn part(
        &mut self,
        around: &Around<'_>,
        memories: &mut [Memory],
        room: &mut Room,
        tally: &mut Tally,
    ) {
        let (i, bodies) = (self.places[0] as usize, around.scenery.bodies);
        let solid = around.polyhedra.solid(bodies.poly[i] as usize);
        let part = &around.parts[self.places[1] as usize];
        let mut presses = [Press::NONE; MOST];
        let mut count = 0;
        let crossed = if around.scenery.crossed { bodies.crossed[i] } else { 0 };
        for &(triangle, image) in &around.triangles[self.near[0] as usize..self.near[1] as usize] {
            let shift = around.scenery.shifts[(image as i32 + crossed) as usize];
            let home = bodies.balls[i].x + shift;
            let mut triangle = part.placed_triangle(triangle);
            triangle.corners = triangle.corners.map(|corner| corner - home);
            let mut press = Press::NONE;
            touch::of_triangle(solid, &triangle, room, &mut press);
            if press.acts() {
                // The load knows nothing of images: it is about the centroid, wherever that is seen.
                let known = presses[..count].iter().position(|p| alike(p, &press));
                let place = known.unwrap_or(count.min(MOST - 1));
                count = count.max(place + 1);
                presses[place].merge(&press);
            }
        }
        let (known, before) = (self.touching as usize, copy(memories));
        let mut used = [false; MOST];
        self.touching = 0;
        // Of all images the part is met where it is closest; velocities are the same for all but parts that
        // turn, which do not reach across periodic faces.
        let seen = around.triangles.get(self.near[0] as usize).map_or(13, |&(_, image)| image);
        let home = bodies.balls[i].x + around.scenery.shifts[(seen as i32 + crossed) as usize];
        let (v, w) = (part.velocity_at(home), part.twist.w);
        let twist = &bodies.predicted[i];
        let relative = Relative { v: twist.v - v, w: twist.w - w, both: twist.w + w };
        let lever = home - Vec3::from(part.pose.position);
        for press in &presses[..count] {
            let n = -press.force / press.force.norm_squared().sqrt();
            let heir =
                closest(&before[..known], n).filter(|&k| !std::mem::replace(&mut used[k], true));
            let mut memory = heir.map_or(Memory::NONE, |k| before[k]);
            let law = &around.scenery.laws[self.law as usize];
            let pair = Pair { root_mass: self.root_mass, kappa: stiffness(law) / self.area };
            let touch = (heir.is_some(), around.scenery.steps);
            let load = respond::load(law, pair, press, &relative, &mut memory, touch);
            memories[self.touching as usize] = memory;
            self.touching += 1;
            self.loads[0].force += load.force;
            self.loads[0].torque += load.torque;
            self.loads[1].force -= load.force;
            self.loads[1].torque -= load.torque + lever.cross(&load.force);
            let ratio = press.deepest / solid.inradius();
            tally.add(ratio, i as u32, Other::Part(self.places[1]));
        }
    }
}

/// Normal stiffness of a linear law [N/m]; others are refused where there are polyhedra.
pub(super) fn stiffness(law: &Law) -> f64 {
    law.normal_slope(0.0, Reduced { root_mass: 0.0, radius: 0.0 })
}

/// Whether two press in nearly one direction.
fn alike(a: &Press, b: &Press) -> bool {
    let along = a.force.dot(&b.force);
    let squares = a.force.norm_squared() * b.force.norm_squared();
    along > 0.0 && along * along > SAME * SAME * squares
}

fn copy(memories: &[Memory]) -> [Memory; MOST] {
    let mut all = [Memory::NONE; MOST];
    all.copy_from_slice(memories);
    all
}

/// The memory whose normal is closest to `n`, if it turned by less than 10 degrees.
fn closest(memories: &[Memory], n: Vec3) -> Option<usize> {
    let along = |k: usize| memories[k].normal.dot(&n);
    let best = (0..memories.len()).max_by(|&a, &b| along(a).total_cmp(&along(b)))?;
    (along(best) > SAME).then_some(best)
}
