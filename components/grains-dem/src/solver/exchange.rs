//! Bodies that come and go between windows.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{BoundingSphere, NEW, PlacedSphere, Twist};
use crate::bodies::events;
use crate::math::error::GrainsError;
use crate::math::tally::Tally;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::integrate::StepDisplacement;
use crate::solver::placement;
use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::scene::Motion;

/// A free sphere that comes into a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AddedSphere {
    /// Index of its set in the scene, which has free bodies.
    pub set: usize,
    /// Centre [m], in the domain.
    pub position: [f64; 3],
    /// Diameter [m], at most that of the scene's largest sphere.
    pub diameter: f64,
    /// Velocity [m/s].
    pub velocity: [f64; 3],
}

impl GrainsDem {
    /// Takes out the bodies of the ids `removed`, which ascend, and lets `added` in, which get the
    /// next ids; [`events`](Self::events) then tell of them. Contacts between those that stay go on
    /// as if nothing had happened. A sphere that overlaps another is pushed from the next substep
    /// on.
    ///
    /// # Errors
    /// Ids of no sphere, spheres that the run is not made for; nothing has happened then. Calls
    /// within a window.
    pub fn exchange(&mut self, removed: &[u64], added: &[AddedSphere]) -> Result<(), GrainsError> {
        self.stepping.progress.expect("exchange", false, false)?;
        self.check_exchange(removed, added)?;
        self.swap(removed, added);
        Ok(())
    }

    /// Exchanges spheres that are known to be valid.
    pub(crate) fn swap(&mut self, removed: &[u64], added: &[AddedSphere]) {
        self.population.events.clear();
        let rank =
            |id: &u64| self.population.bodies.ids.binary_search(id).map(|rank| rank as u32).ok();
        let gone: Vec<u32> = removed.iter().filter_map(rank).collect();
        let placed: Vec<PlacedSphere> = added.iter().map(|sphere| self.place(sphere)).collect();
        if gone.is_empty() && placed.is_empty() {
            return;
        }
        // Before the removal: ranks and slots change with it.
        for &rank in &gone {
            let slot = self.population.bodies.slot[rank as usize] as usize;
            let set = self.population.bodies.set[slot];
            let radius = self.population.bodies.balls[slot].radius;
            let mass = placement::mass(self.population.sets[set as usize].density, 2.0 * radius);
            let id = self.population.bodies.ids[rank as usize];
            self.population.events.push(events::removed(id, set, radius, mass));
        }
        let mut from = Vec::with_capacity(self.population.bodies.len() + placed.len());
        self.population.bodies.remove(&gone, &mut from);
        self.population.driven.remove(&gone);
        for sphere in &placed {
            self.population.events.push(events::added(self.population.next_id, sphere));
            self.population.bodies.add(
                self.population.next_id,
                sphere,
                self.population.sets[sphere.set].material,
            );
            self.population.next_id += 1;
            from.push(NEW);
        }
        self.probes.exchange(
            &gone,
            placed.iter().map(|sphere| sphere.mass),
            &self.population.bodies,
        );
        self.population.roll.count(&self.population.bodies);
        self.list_after_exchange(from);
    }

    /// Lists neighbours anew; `from` tells where in memory each body stood.
    fn list_after_exchange(&mut self, from: Vec<u32>) {
        let blocks = self.population.bodies.len().div_ceil(BLOCK);
        self.record.tallies.resize(blocks, Tally::default());
        self.record.reaches.resize(blocks, StepDisplacement::default());
        self.search.moved = Some(from);
        self.rebuild_lists();
    }

    fn place(&self, added: &AddedSphere) -> PlacedSphere {
        let x = self.around.bounds.wrap(added.position.into());
        PlacedSphere {
            length: None,
            ball: BoundingSphere { x, radius: 0.5 * added.diameter },
            solid: None,
            twist: Twist { v: added.velocity.into(), w: Vec3::zeros() },
            mass: placement::mass(self.population.sets[added.set].density, added.diameter),
            share: None,
            motion: Motion::Free,
            clump: None,
            set: added.set,
        }
    }

    fn check_exchange(&self, removed: &[u64], added: &[AddedSphere]) -> Result<(), GrainsError> {
        if let Some(pair) = removed.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(GrainsError::NotRemovable { id: pair[1], why: "the ids do not ascend" });
        }
        let unknown = |id: &&u64| self.population.bodies.ids.binary_search(id).is_err();
        if let Some(&id) = removed.iter().find(unknown) {
            return Err(GrainsError::NotRemovable { id, why: "no living sphere has this id" });
        }
        let is_solid = |id: &&u64| {
            let rank = self.population.bodies.ids.binary_search(id).unwrap_or_default();
            self.population.bodies.poly[self.population.bodies.slot[rank] as usize] != SPHERE
        };
        if let Some(&id) = removed.iter().find(is_solid) {
            return Err(GrainsError::NotRemovable { id, why: "it is a polyhedron" });
        }
        if let (Some(&id), Some(_)) = (removed.first(), self.population.clumps.all().first()) {
            return Err(GrainsError::NotRemovable { id, why: "there are clumps, which stay" });
        }
        for (index, sphere) in added.iter().enumerate() {
            let why = match self.population.sets.get(sphere.set) {
                None => "the scene has no such set",
                Some(set) if !set.free => "its set is not free",
                _ if !sphere.velocity.iter().all(|v| v.is_finite()) => "its velocity is not finite",
                _ if !self.around.bounds.contains(sphere.position.into()) => {
                    "its centre lies outside the domain"
                }
                _ if !is_positive(sphere.diameter) => "its diameter is not positive",
                _ if sphere.diameter > self.population.largest => {
                    "it is larger than any sphere that the run is made for"
                }
                _ => continue,
            };
            return Err(GrainsError::NotAddable { index, why });
        }
        Ok(())
    }
}
