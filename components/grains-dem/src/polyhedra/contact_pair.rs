//! One possible contact of a polyhedron, and its evaluation.

use super::{
    Polyhedra, contact_geometry,
    overlap_integrals::OverlapRoom,
    overlap_response::{self, OverlapHistory, Pair, Relative},
    surfaces::{Bench, Owner},
};
use crate::Vec3;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::Wrench;
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::contact_force::{self, Contact};
use crate::contact::contact_law::Law;
use crate::contact::springs::Reduced;
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::{Other, Tally};
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::plane_walls::Wall;

/// Most contacts with walls and parts: directions in which they press.
pub(super) const MOST: usize = 8;

/// Partner of a polyhedron in a pair, in the order in which loads are added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum SolidPairKind {
    Body,
    /// All walls and parts.
    Surfaces,
}

/// A possible contact: of the body with the smaller id with another, or of a polyhedron with a
/// surface.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct SolidPairEntry {
    /// Id of the body, kind and id of the other: in this order they stand in the list.
    pub key: (u64, SolidPairKind, u64),
    /// Places of both in memory.
    pub places: [u32; 2],
    /// Image through which the other body is seen.
    pub image: u32,
    pub law: u16,
    /// `sqrt(m*)` [kg^(1/2)], and the area that stiffness is for [m²].
    pub root_mass: f64,
    pub area: f64,
    /// Walls and parts near it.
    pub owners: u32,
    /// Number of contacts at the last evaluation.
    pub touching: u8,
    /// Loads on both at the last evaluation, about their reference points.
    pub loads: [Wrench; 2],
}

/// Input of the evaluation of contacts.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub scenery: ContactContext<'a>,
    pub polyhedra: &'a Polyhedra,
    pub walls: &'a [Wall],
    pub parts: &'a [PlacedPart],
    pub triangles: &'a [(u32, u32)],
}

impl SolidPairEntry {
    /// Number of memories that it needs.
    pub fn memories(&self) -> usize {
        if self.key.1 == SolidPairKind::Surfaces { MOST } else { 1 }
    }

    /// Finds the loads.
    pub fn evaluate(
        &mut self,
        around: &Around<'_>,
        (owners, memories): (&mut [Owner], &mut [OverlapHistory]),
        bench: &mut Bench,
        tally: &mut Tally,
    ) {
        self.loads = [Wrench::zero(); 2];
        match self.key.1 {
            SolidPairKind::Body => {
                let [i, j] = self.places.map(|place| place as usize);
                let grains = [i, j].map(|place| around.scenery.bodies.poly[place]);
                let way = around.scenery.between(i, j, self.image);
                match grains {
                    [a, b] if a != SPHERE && b != SPHERE => {
                        self.solids(
                            around,
                            [a, b],
                            way,
                            (&mut memories[0], &mut bench.room, tally),
                        );
                    }
                    [a, SPHERE] => {
                        let loads = self.ball(around, (a, i, j), way, &mut memories[0], tally);
                        self.loads = loads;
                    }
                    [_, b] => {
                        // `ball` takes the polyhedron first, so both are swapped, and the loads
                        // back.
                        let [on_b, on_a] =
                            self.ball(around, (b, j, i), -way, &mut memories[0], tally);
                        self.loads = [on_a, on_b];
                    }
                }
            }
            SolidPairKind::Surfaces => self.surfaces(around, owners, memories, (bench, tally)),
        }
    }

    /// Two polyhedra, the second `way` from the first.
    fn solids(
        &mut self,
        around: &Around<'_>,
        [a, b]: [u32; 2],
        way: Vec3,
        (memory, room, tally): (&mut OverlapHistory, &mut OverlapRoom, &mut Tally),
    ) {
        let solids = [a, b].map(|grain| around.polyhedra.solid(grain as usize));
        let press = contact_geometry::of_solids(solids[0], solids[1], way, room);
        let twists = self.places.map(|place| &around.scenery.bodies.predicted[place as usize]);
        let relative = Relative {
            v: (twists[0].v - twists[1].v) + twists[1].w.cross(&way),
            w: twists[0].w - twists[1].w,
            both: twists[0].w + twists[1].w,
        };
        // Two bodies press on each other, each with half of the stiffness.
        let law = &around.scenery.laws[self.law as usize];
        let kappa = 0.5 * stiffness(law) / self.area;
        let pair = Pair { root_mass: self.root_mass, kappa, region: None };
        let steps = (self.touching > 0, around.scenery.steps);
        let load = overlap_response::load(law, pair, &press, &relative, memory, steps).load;
        self.touching = u8::from(press.acts());
        self.loads =
            [load, Wrench { force: -load.force, torque: way.cross(&load.force) - load.torque }];
        if press.acts() {
            let least = solids[0].inradius().min(solids[1].inradius());
            let ratio = press.deepest / least;
            tally.add(ratio, self.places[0], Other::Body(self.places[1]));
        }
    }

    /// A polyhedron, the number `grain`, standing at `i`, and a sphere at `j`, `way` from it: loads
    /// on both.
    fn ball(
        &mut self,
        around: &Around<'_>,
        (grain, i, j): (u32, usize, usize),
        way: Vec3,
        memory: &mut OverlapHistory,
        tally: &mut Tally,
    ) -> [Wrench; 2] {
        let bodies = around.scenery.bodies;
        let (radius, solid) = (bodies.balls[j].radius, around.polyhedra.solid(grain as usize));
        let touched = std::mem::replace(&mut self.touching, 0) > 0;
        let near = contact_geometry::closest(solid, way);
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
        let mut plain = contact_force::ContactHistory {
            xi: memory.xi,
            rolling: memory.rolling,
            normal: memory.normal,
            overlap: memory.overlap,
        };
        let law = &around.scenery.laws[self.law as usize];
        let reduced = Reduced { root_mass: self.root_mass, radius, ..Reduced::NONE };
        let steps = around.scenery.steps;
        let f = contact_force::force(law, reduced, &contact, &mut plain, touched, steps);
        *memory = OverlapHistory {
            xi: plain.xi,
            rolling: plain.rolling,
            normal: n,
            overlap,
            energy: {
                let across = contact.velocity - n * contact.velocity.dot(&n);
                // `xi` is half a step ahead; the energy is that of the evaluation.
                let now = plain.xi - across * (0.5 * steps.after);
                0.5 * law.at(overlap, overlap, reduced).k_t * now.norm_squared()
            },
            ..OverlapHistory::NONE
        };
        let force = f.tangential - n * f.normal;
        let ratio = overlap / radius.min(solid.inradius());
        tally.add(ratio, i as u32, Other::Body(j as u32));
        [
            Wrench { force, torque: point.cross(&force) + f.rolling },
            Wrench { force: -force, torque: -(point - way).cross(&force) - f.rolling },
        ]
    }
}

/// Normal stiffness where faces touch over the reference area [N/m].
pub(super) fn stiffness(law: &Law) -> f64 {
    law.over_faces().normal_stiffness
}
