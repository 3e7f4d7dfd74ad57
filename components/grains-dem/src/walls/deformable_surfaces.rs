//! All surfaces that deform, and the bodies near any of them.

use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Wrench;
use crate::bodies::deformable_surface::{DeformableSurface, FacetLoad, SurfaceState};
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::material_laws::Laws;
use crate::forces::pair_forces::ContactContext;
use crate::math::error::GrainsError;
use crate::math::tally::Tally;
use crate::walls::contact_rows::LoadedBodies;
use crate::walls::part_contacts::PartContacts;
use crate::walls::reached_walls::Reached;
use crate::walls::surface_contacts::{SurfaceContacts, SurfaceSurroundings, WallsBeside};
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_state::{StateError, StateExchange};

/// The surfaces of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces {
    pub held: Vec<SurfaceContacts>,
    /// The bodies near any.
    pub on: LoadedBodies,
    /// Reach of each body into rigid walls, and into surfaces.
    rigid: Vec<Reached>,
    soft: Vec<Reached>,
    /// True if bodies moved, or others came near, since rigid walls were searched.
    moved: bool,
}

/// Rigid walls: contacts with them, parts, and faces of the domain.
pub(crate) struct RigidWalls<'a> {
    pub contacts: &'a mut PartContacts,
    pub parts: &'a [PlacedPart],
    pub walls: &'a [Wall],
}

impl Surfaces {
    /// Surfaces that are right, and the number of all bodies.
    pub fn new(
        surfaces: &[DeformableSurface],
        laws: &Laws,
        parts: &[PlacedPart],
        bodies: usize,
    ) -> Self {
        let hold = |surface: &DeformableSurface| {
            let whole = parts[surface.carrier].slider().map_or(1.0, |slider| slider.whole);
            SurfaceContacts::new(surface, laws.material(&surface.material), whole)
        };
        let mut own = Self { held: surfaces.iter().map(hold).collect(), ..Self::default() };
        own.fit(bodies);
        own
    }

    /// Gives each block of so many bodies its place in the list of those near.
    fn fit(&mut self, bodies: usize) {
        self.on.bounds.resize(bodies.div_ceil(BLOCK) + 1, 0);
        self.on.give_bounds();
    }

    /// Keeps what surfaces remember and do to bodies at a window's end, or puts it back, beside
    /// bodies and seats that are back already.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        around: &SurfaceSurroundings<'_>,
    ) -> Result<(), StateError> {
        for (number, held) in self.held.iter_mut().enumerate() {
            let name = format!("surface{number}");
            state.within(&name, |state| held.exchange(state, around))?;
        }
        if !self.held.is_empty() {
            state.list("near_surfaces", &mut self.on.bodies)?;
            state.value("by_surfaces", &mut self.on.wrench)?;
        }
        if state.restores() {
            let bodies = around.bodies.len();
            if !self.has_places(bodies) {
                return state.unfit("the state has contacts of other bodies with surfaces");
            }
            self.fit(bodies);
            self.give_room();
        }
        Ok(())
    }

    /// True if each of so many bodies that is near a surface has its place.
    fn has_places(&self, bodies: usize) -> bool {
        let near = &self.on.bodies;
        let ascend = near.is_sorted_by(|a, b| a < b);
        let exist = near.last().is_none_or(|&last| (last as usize) < bodies);
        let placed = |held: &SurfaceContacts| {
            let mut entries = held.entries.iter();
            held.is_stale() || entries.all(|e| near.get(e.place as usize) == Some(&e.body))
        };
        ascend && exist && near.len() == self.on.wrench.len() && self.held.iter().all(placed)
    }

    /// Bodies moved, and what they reach with them.
    pub fn follow_bodies(&mut self) {
        self.moved = true;
    }

    /// Reach of a body, by its place in memory, into the shapes of the last search.
    pub fn reached_by(&self, body: u32) -> Option<&Reached> {
        if self.on.bodies.is_empty() {
            return None;
        }
        self.on.place(body).and_then(|place| self.soft.get(place))
    }

    /// Bodies changed their places in memory: what is near must be listed anew.
    pub fn spoil(&mut self) {
        self.held.iter_mut().for_each(SurfaceContacts::spoil);
    }

    /// Follows bodies that came and went: `previous` holds the place in memory of each, `ids` their
    /// ids. Forces stay as they are until the next shape.
    pub fn follow(&mut self, previous: &[u32], ids: &[u64]) {
        self.held.iter_mut().for_each(|held| held.forget(ids));
        let (old, wrench) =
            (std::mem::take(&mut self.on.bodies), std::mem::take(&mut self.on.wrench));
        for (body, before) in (0..).zip(previous) {
            if let Ok(place) = old.binary_search(before) {
                self.on.bodies.push(body);
                self.on.wrench.push(wrench[place]);
            }
        }
        self.fit(previous.len());
        self.give_room();
    }

    /// Tries a shape of a surface beside rigid walls, without a trace; `out` is cleared and gets
    /// the loads on facets. Other surfaces are where they were looked at last.
    ///
    /// # Errors
    /// Shapes that do not fit the surface.
    pub fn try_shape(
        &mut self,
        surface: usize,
        state: (&[[f64; 3]], &[[f64; 3]]),
        (scenery, around): (&ContactContext<'_>, &SurfaceSurroundings<'_>),
        walls: RigidWalls<'_>,
        out: &mut Vec<FacetLoad>,
    ) -> Result<(), GrainsError> {
        self.prepare(surface, state, around)?;
        self.held[surface].look(state.0, scenery);
        self.reach(walls, scenery);
        out.clear();
        let beside = WallsBeside { number: surface, rigid: &self.rigid, soft: &self.soft };
        self.held[surface].try_shape(state, &beside, scenery, out);
        Ok(())
    }

    /// Finds the reach of bodies into the shapes of all surfaces, and of rigid walls beside them.
    ///
    /// # Errors
    /// Shapes that do not fit the surfaces.
    pub fn look(
        &mut self,
        states: &[SurfaceState<'_>],
        (scenery, around): (&ContactContext<'_>, &SurfaceSurroundings<'_>),
        walls: RigidWalls<'_>,
    ) -> Result<(), GrainsError> {
        if states.len() != self.held.len() {
            let (found, expected) = (states.len(), self.held.len());
            return Err(GrainsError::SurfaceCount { found, expected });
        }
        for (surface, state) in states.iter().enumerate() {
            self.prepare(surface, (state.vertices, state.velocities), around)?;
        }
        for (held, state) in self.held.iter_mut().zip(states) {
            held.look(state.vertices, scenery);
        }
        self.reach(walls, scenery);
        Ok(())
    }

    /// Takes the shapes that were looked at as they are: forces on bodies are in `wrench`, and on
    /// carriers with the surfaces.
    pub fn accept(
        &mut self,
        states: &[SurfaceState<'_>],
        scenery: &ContactContext<'_>,
        tally: &mut Tally,
    ) {
        self.on.wrench.fill(Wrench::zero());
        for (number, (held, state)) in self.held.iter_mut().zip(states).enumerate() {
            let beside = WallsBeside { number, rigid: &self.rigid, soft: &self.soft };
            let shape = (state.vertices, state.velocities);
            held.accept(shape, &beside, scenery, &mut self.on.wrench, tally);
        }
    }

    /// Finds the reach of bodies into surfaces at the shapes of the last search, and into rigid
    /// walls.
    fn reach(&mut self, walls: RigidWalls<'_>, scenery: &ContactContext<'_>) {
        self.soft.iter_mut().for_each(Reached::clear);
        for (number, held) in self.held.iter().enumerate() {
            held.give_reached(number, scenery, &mut self.soft);
        }
        if std::mem::replace(&mut self.moved, false) {
            let RigidWalls { contacts, parts, walls } = walls;
            for (&body, reached) in self.on.bodies.iter().zip(&mut self.rigid) {
                contacts.reach(body, (parts, walls), scenery, reached);
            }
        }
    }

    /// Lists bodies and seats near a surface, if the present lists do not hold.
    fn prepare(
        &mut self,
        surface: usize,
        (vertices, velocities): (&[[f64; 3]], &[[f64; 3]]),
        around: &SurfaceSurroundings<'_>,
    ) -> Result<(), GrainsError> {
        let held = &mut self.held[surface];
        if held.needs_list(surface, vertices, velocities)? {
            held.list(vertices, around);
            self.give_places();
        }
        Ok(())
    }

    /// Gives each body near any surface one place.
    fn give_places(&mut self) {
        self.on.bodies.clear();
        for held in &self.held {
            self.on.bodies.extend(held.entries.iter().map(|entry| entry.body));
        }
        self.on.bodies.sort_unstable();
        self.on.bodies.dedup();
        for entry in self.held.iter_mut().flat_map(|held| &mut held.entries) {
            // Every body of an entry is among them.
            entry.place = self.on.bodies.partition_point(|&body| body < entry.body) as u32;
        }
        self.on.wrench.clear();
        self.on.wrench.resize(self.on.bodies.len(), Wrench::zero());
        self.on.give_bounds();
        self.give_room();
    }

    /// Room for the reach of each body.
    fn give_room(&mut self) {
        self.rigid.resize(self.on.bodies.len(), Reached::NONE);
        self.soft.resize(self.on.bodies.len(), Reached::NONE);
        self.moved = true;
    }
}
