//! The state of all bodies, as arrays grouped by the passes that read them together.
//!
//! Arrays are in the order of places in space, which changes as bodies move: what is near in space
//! is near in memory. Ids never change, and no result depends on the order in memory.
//!
//! Ids are 64-bit and never used again; inside, a body goes by its rank among the living, which
//! orders them as ids do and is a place in dense arrays.

use crate::Vec3;
use serde::{Deserialize, Serialize};
use tremie_geometry::Share;
use tremie_messages::scene::{BodySet, Motion, Scene};

pub(crate) use tremie_grains_kit::space::rigid_body::{ALONE, BoundingSphere, Mobility, Twist};

/// Previous place in memory of a body that is new.
pub(crate) const NEW: u32 = u32::MAX;

/// Force and torque about the centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Wrench {
    /// Force [N].
    pub force: Vec3,
    /// Torque [N·m].
    pub torque: Vec3,
}

impl Wrench {
    pub fn zero() -> Self {
        Self { force: Vec3::zeros(), torque: Vec3::zeros() }
    }
}

/// Marks a body that is a sphere.
pub(crate) const SPHERE: u32 = u32::MAX;

/// A polyhedron as it is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlacedSolid {
    /// Index of the shape in the scene.
    pub shape: u32,
    /// Diameter of a sphere of equal volume [m].
    pub size: f64,
    /// Unit quaternion from body to world.
    pub orientation: [f64; 4],
}

/// A body as it is placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedSphere {
    pub ball: BoundingSphere,
    /// Shape and orientation, if the body is a polyhedron.
    pub solid: Option<PlacedSolid>,
    pub twist: Twist,
    /// Mass [kg].
    pub mass: f64,
    /// Length of a cylinder across a plane scene [m]; none of a sphere.
    pub length: Option<f64>,
    /// Its share of the union of its clump's bodies, where that is what the clump is; the mass is
    /// that of the share.
    pub share: Option<Share>,
    pub motion: Motion,
    /// Index of its set in the scene.
    pub set: usize,
    /// The clump that the body is part of, if any.
    pub clump: Option<Joined>,
}

/// The clump that a body belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joined {
    /// Its number.
    pub number: u32,
    /// Its mass [kg].
    pub mass: f64,
}

impl PlacedSphere {
    /// Part of its volume that is its own: of a piece of a union its share.
    pub fn part(&self) -> f64 {
        let diameter = self.solid.map_or(2.0 * self.ball.radius, |solid| solid.size);
        let whole = core::f64::consts::PI / 6.0 * diameter * diameter * diameter;
        self.share.map_or(1.0, |share| share.volume / whole)
    }

    /// Its response to forces.
    pub fn mobility(&self) -> Mobility {
        if self.motion != Motion::Free {
            return Mobility::NONE;
        }
        if let Some(Joined { number, mass }) = self.clump {
            return Mobility { inverse_mass: 1.0 / mass, inverse_inertia: 0.0, clump: number };
        }
        let radius = self.ball.radius;
        Mobility {
            inverse_mass: 1.0 / self.mass,
            inverse_inertia: match self.solid {
                Some(_) => 0.0,
                None if self.length.is_some() => 1.0 / (0.5 * self.mass * radius * radius),
                None => 1.0 / (0.4 * self.mass * radius * radius),
            },
            clump: ALONE,
        }
    }
}

/// Properties that the spheres of a set share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SphereSet {
    /// Density [kg/m³].
    pub density: f64,
    /// Number of the material.
    pub material: u16,
    /// True if forces move the spheres, each by itself.
    pub free: bool,
}

impl SphereSet {
    /// Sets of a scene, in its order, with the numbers of materials.
    pub fn of_scene(scene: &Scene, number_of: impl Fn(&str) -> u16) -> Vec<Self> {
        let of = |set: &BodySet| Self {
            density: set.density,
            material: number_of(&set.material),
            free: set.motion == Motion::Free && set.clump.is_none(),
        };
        scene.bodies.iter().map(of).collect()
    }
}

/// Bodies that are one item of work.
pub(crate) const BLOCK: usize = 512;

/// All bodies. Every array but `ids` and `slot` has one entry a body, in the order of memory.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Bodies {
    /// Their ranks among the living, by ids.
    pub rank: Vec<u32>,
    /// Ids by rank, ascending.
    pub ids: Vec<u64>,
    /// Slot, the place in the other arrays, of the body of each rank.
    pub slot: Vec<u32>,
    /// Bounding spheres of the bodies; centres are always inside the periodic faces.
    pub balls: Vec<BoundingSphere>,
    /// Velocities: of the full step between substeps, of the half step within one.
    pub twists: Vec<Twist>,
    /// Velocities predicted for the end of the substep: those that forces see.
    pub predicted: Vec<Twist>,
    /// Fluid loads of this window.
    pub load: Vec<Wrench>,
    /// Inertia.
    pub mobility: Vec<Mobility>,
    /// Unit quaternions `(x, y, z, w)` from body to world frame.
    pub orientation: Vec<[f64; 4]>,
    /// Positions when neighbours were last listed, moved along with bodies across periodic faces.
    pub reference: Vec<Vec3>,
    /// Across which periodic faces each went since: the difference of its image's number.
    pub crossed: Vec<i32>,
    /// Index of the set in the scene.
    pub set: Vec<u32>,
    /// Number of the material.
    pub material: Vec<u16>,
    /// Number of the polyhedron, or [`SPHERE`].
    pub poly: Vec<u32>,
    /// Radii of spheres of equal volume, by the numbers of polyhedra [m].
    pub equal_radii: Vec<f64>,
    #[serde(skip)]
    spare: Spare,
}

/// Second set of arrays: the sort writes into them in the new order, then both sets are swapped.
#[derive(Clone, Debug, Default)]
struct Spare {
    rank: Vec<u32>,
    balls: Vec<BoundingSphere>,
    twists: Vec<Twist>,
    wrenches: Vec<Wrench>,
    mobility: Vec<Mobility>,
    orientation: Vec<[f64; 4]>,
    set: Vec<u32>,
    material: Vec<u16>,
    poly: Vec<u32>,
}

impl Bodies {
    /// Bodies in the order of ids; `material` gives the number of a set's material.
    pub fn new(spheres: &[PlacedSphere], material: impl Fn(usize) -> u16) -> Self {
        let n = spheres.len();
        let twists: Vec<Twist> = spheres.iter().map(|s| s.twist).collect();
        let solids = spheres.iter().filter_map(|s| s.solid);
        let mut numbers = 0..;
        Self {
            rank: (0..n as u32).collect(),
            ids: (0..n as u64).collect(),
            slot: (0..n as u32).collect(),
            balls: spheres.iter().map(|s| s.ball).collect(),
            predicted: twists.clone(),
            twists,
            load: vec![Wrench::zero(); n],
            mobility: spheres.iter().map(PlacedSphere::mobility).collect(),
            orientation: spheres
                .iter()
                .map(|s| s.solid.map_or([0.0, 0.0, 0.0, 1.0], |solid| solid.orientation))
                .collect(),
            reference: spheres.iter().map(|s| s.ball.x).collect(),
            crossed: vec![0; n],
            set: spheres.iter().map(|s| s.set as u32).collect(),
            material: spheres.iter().map(|s| material(s.set)).collect(),
            poly: spheres
                .iter()
                .map(|s| s.solid.and_then(|_| numbers.next()).unwrap_or(SPHERE))
                .collect(),
            equal_radii: solids.map(|solid| 0.5 * solid.size).collect(),
            spare: Spare::default(),
        }
    }

    pub fn len(&self) -> usize {
        self.balls.len()
    }

    /// Puts the body now at `order[s]` to place `s`. References and crossings are not kept: bodies
    /// are put in order only when neighbours are listed anew.
    pub fn reorder(&mut self, order: &[u32]) {
        let spare = &mut self.spare;
        permute(&mut self.rank, order, &mut spare.rank);
        permute(&mut self.balls, order, &mut spare.balls);
        permute(&mut self.twists, order, &mut spare.twists);
        permute(&mut self.predicted, order, &mut spare.twists);
        permute(&mut self.load, order, &mut spare.wrenches);
        permute(&mut self.mobility, order, &mut spare.mobility);
        permute(&mut self.orientation, order, &mut spare.orientation);
        permute(&mut self.set, order, &mut spare.set);
        permute(&mut self.material, order, &mut spare.material);
        permute(&mut self.poly, order, &mut spare.poly);
        self.find_slots();
    }

    fn find_slots(&mut self) {
        self.slot.resize(self.rank.len(), 0);
        for (slot, &rank) in (0..).zip(&self.rank) {
            self.slot[rank as usize] = slot;
        }
    }

    /// Radius of a sphere of a body's volume, by its place in memory [m].
    pub fn equal_radius(&self, slot: usize) -> f64 {
        match self.poly[slot] {
            SPHERE => self.balls[slot].radius,
            grain => self.equal_radii[grain as usize],
        }
    }

    /// Id of the body at a place in memory.
    pub fn id_at(&self, slot: usize) -> u64 {
        self.ids[self.rank[slot] as usize]
    }

    /// Room for so many bodies.
    pub fn reserve(&mut self, bodies: usize) {
        let more = bodies.saturating_sub(self.len());
        self.rank.reserve(more);
        self.ids.reserve(more);
        self.slot.reserve(more);
        self.balls.reserve(more);
        self.twists.reserve(more);
        self.predicted.reserve(more);
        self.load.reserve(more);
        self.mobility.reserve(more);
        self.orientation.reserve(more);
        self.reference.reserve(more);
        self.crossed.reserve(more);
        self.set.reserve(more);
        self.material.reserve(more);
        self.poly.reserve(more);
    }

    /// Takes out the bodies of the ranks `gone`, which ascend; the others keep their order. Writes
    /// to `from` where in memory each of them stood.
    pub fn remove(&mut self, gone: &[u32], from: &mut Vec<u32>) {
        let stays = |rank: &u32| gone.binary_search(rank).is_err();
        from.clear();
        from.extend((0..).zip(&self.rank).filter(|(_, rank)| stays(rank)).map(|(slot, _)| slot));
        gather(&mut self.rank, from);
        gather(&mut self.balls, from);
        gather(&mut self.twists, from);
        gather(&mut self.predicted, from);
        gather(&mut self.load, from);
        gather(&mut self.mobility, from);
        gather(&mut self.orientation, from);
        gather(&mut self.reference, from);
        gather(&mut self.crossed, from);
        gather(&mut self.set, from);
        gather(&mut self.material, from);
        gather(&mut self.poly, from);
        for rank in &mut self.rank {
            *rank -= gone.partition_point(|gone| gone < rank) as u32;
        }
        take_out(&mut self.ids, gone);
        self.find_slots();
    }

    /// Adds a body at the end; its id is larger than all others.
    pub fn add(&mut self, id: u64, sphere: &PlacedSphere, material: u16) {
        let n = self.len() as u32;
        self.rank.push(n);
        self.ids.push(id);
        self.slot.push(n);
        self.balls.push(sphere.ball);
        self.twists.push(sphere.twist);
        self.predicted.push(sphere.twist);
        self.load.push(Wrench::zero());
        self.mobility.push(sphere.mobility());
        self.orientation.push([0.0, 0.0, 0.0, 1.0]);
        self.reference.push(sphere.ball.x);
        self.crossed.push(0);
        self.set.push(sphere.set as u32);
        self.material.push(material);
        self.poly.push(SPHERE);
    }
}

/// Keeps the values at the places `from`, which ascend.
fn gather<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
    for (to, &from) in from.iter().enumerate() {
        values[to] = values[from as usize];
    }
    values.truncate(from.len());
}

/// Takes out the values at the places `gone`, which ascend.
pub(crate) fn take_out<T>(values: &mut Vec<T>, gone: &[u32]) {
    let mut place = 0..;
    values.retain(|_| place.next().is_none_or(|place| gone.binary_search(&place).is_err()));
}

fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>) {
    spare.clear();
    spare.extend(order.iter().map(|&from| values[from as usize]));
    std::mem::swap(values, spare);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_keep_their_ids_in_another_order() {
        let sphere = |k: f64| PlacedSphere {
            length: None,
            ball: BoundingSphere { x: Vec3::repeat(k), radius: k },
            solid: None,
            twist: Twist { v: Vec3::repeat(-k), w: Vec3::zeros() },
            mass: 1.0 + k,
            share: None,
            motion: Motion::Free,
            set: k as usize,
            clump: None,
        };
        let mut bodies = Bodies::new(&[0.0, 1.0, 2.0, 3.0].map(sphere), |set| set as u16);
        for order in [[2, 0, 3, 1], [1, 2, 3, 0]] {
            bodies.reorder(&order);
            for id in 0..4 {
                let slot = bodies.slot[id] as usize;
                assert_eq!(bodies.id_at(slot), id as u64);
                assert_eq!(bodies.balls[slot].radius, id as f64);
                assert_eq!(bodies.predicted[slot].v.x, -(id as f64));
                assert_eq!((bodies.set[slot], bodies.material[slot]), (id as u32, id as u16));
            }
        }
        let mut from = Vec::new();
        bodies.remove(&[0, 2], &mut from);
        bodies.add(9, &sphere(4.0), 4);
        assert_eq!(bodies.ids, [1, 3, 9]);
        for (rank, radius) in [1.0, 3.0, 4.0].into_iter().enumerate() {
            let slot = bodies.slot[rank] as usize;
            assert_eq!((bodies.balls[slot].radius, bodies.twists[slot].v.x), (radius, -radius));
            assert_eq!((bodies.set[slot], bodies.rank[slot]), (radius as u32, rank as u32));
        }
    }
}
