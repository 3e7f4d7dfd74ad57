//! The bodies in the fluid: who lives, where they are.

use crate::bodies::body::{Body, KeptBody, UnionShare};
use crate::bodies::body_shapes::BodyShapes;
use crate::bodies::deformable_surface::SoftSurface;
use crate::bodies::events::check;
use crate::bodies::mesh_body::MeshBody;
use crate::lattice::error::FluidError;
use crate::lattice::layout::Layout;
use crate::lattice::units::Units;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::{BodyEvent, BodyState, SurfaceVertex};
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// What finding the cells of bodies takes.
pub struct BodySite<'a> {
    /// Units of the lattice.
    pub units: &'a Units,
    /// Layout of the cells.
    pub layout: &'a Layout,
    /// Cells of a line.
    pub line: usize,
    /// Threads.
    pub team: &'a mut Team,
}

/// All bodies.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// The living, sorted by id.
    pub living: Vec<Body>,
    /// Those removed since the last step, whose cells are not fluid yet.
    pub leaving: Vec<Body>,
    /// Handles of those that came since the last step.
    pub newcomers: Vec<u32>,
    /// Handles that nobody has.
    free: Vec<u32>,
    /// For each handle, the place of its body among the living.
    places: Vec<u32>,
    /// Deformable surfaces, the last of the living; none before their first vertices came.
    softs: Vec<SoftSurface>,
    /// Their vertices at the end of the coming step.
    pub vertices: Vec<SurfaceVertex>,
    /// True if bodies were added or removed since the last step.
    pub changed: bool,
    /// Shapes that they can have besides spheres.
    catalogue: BodyShapes,
    /// Number of steps that velocities are taken ahead.
    lead: f64,
    /// Shares of unions that bodies of the scene's sets displace, in the order in which they come;
    /// none for sets whose bodies displace all of their volume. And the number of bodies of each
    /// set that have come.
    shares: Vec<Vec<UnionShare>>,
    came: Vec<usize>,
}

impl Bodies {
    /// None, in a scene with a catalogue of what they can be; velocities of parts are taken `lead`
    /// steps ahead.
    pub fn of(catalogue: BodyShapes, lead: f64) -> Self {
        Self { catalogue, lead, ..Self::default() }
    }

    /// Tells what bodies of the scene's sets displace, in the order in which they come; nothing of
    /// a set whose bodies displace all of their volume.
    pub fn share_unions(&mut self, shares: Vec<Vec<UnionShare>>) {
        self.came = vec![0; shares.len()];
        self.shares = shares;
    }

    /// Share of a union that the next body of a set displaces.
    fn next_share(&mut self, event: &BodyEvent) -> Option<UnionShare> {
        if event.shape == BodyEvent::PART {
            return None;
        }
        let came = self.came.get_mut(event.set as usize)?;
        *came += 1;
        self.shares[event.set as usize].get(*came - 1).copied()
    }

    /// Adds deformable surfaces, once.
    pub fn add_softs(&mut self, softs: Vec<SoftSurface>, parts: Vec<MeshBody>, grid: &Grid) {
        let handles: Vec<u32> = softs.iter().map(|_| self.new_handle()).collect();
        self.place_softs(softs, parts, &handles, grid);
        self.changed = true;
    }

    /// Adds them with these handles, which nobody else has.
    pub fn place_softs(
        &mut self,
        softs: Vec<SoftSurface>,
        parts: Vec<MeshBody>,
        handles: &[u32],
        grid: &Grid,
    ) {
        let first = u64::MAX - softs.len() as u64;
        for (k, (mut part, &handle)) in (1..).zip(parts.into_iter().zip(handles)) {
            let position = grid.canonical(part.reference());
            part.place(position, [0.0, 0.0, 0.0, 1.0]);
            let (radius, part) = (part.radius(), Some(Box::new(part)));
            let mut body = Body::new(grid, first + k, handle, radius, part);
            body.position = position;
            self.living.push(body);
        }
        self.softs = softs;
        self.renumber();
    }

    /// Number of the living but for deformable surfaces.
    pub fn rigid(&self) -> usize {
        self.living.len() - self.softs.len()
    }

    /// A handle that nobody has.
    fn new_handle(&mut self) -> u32 {
        let handle = self.free.pop().unwrap_or(self.places.len() as u32);
        if handle as usize == self.places.len() {
            self.places.push(0);
        }
        handle
    }

    fn renumber(&mut self) {
        for (place, body) in (0..).zip(&self.living) {
            self.places[body.handle as usize] = place;
        }
    }

    /// Place among the living of the body with a handle.
    #[inline]
    pub fn place_of(&self, handle: u32) -> usize {
        self.places[handle as usize] as usize
    }

    /// The items of links of all bodies but spheres, from the first to the last, and those of
    /// spheres in between.
    pub fn items_with_surface(&self) -> std::ops::Range<usize> {
        let mut others = self.living.iter().filter(|body| body.part.is_some());
        let Some(first) = others.next() else { return 0..0 };
        let last = others.next_back().unwrap_or(first);
        first.items.start..last.items.end
    }

    /// The living body with a handle.
    #[inline]
    pub fn with_handle(&self, handle: u32) -> &Body {
        &self.living[self.place_of(handle)]
    }

    /// The body with a handle, if it lives.
    pub fn living_with_handle(&mut self, handle: u32) -> Option<&mut Body> {
        let place = *self.places.get(handle as usize)? as usize;
        self.living.get_mut(place).filter(|body| body.handle == handle)
    }

    /// The body with a handle, if it lives.
    pub fn find_living(&self, handle: u32) -> Option<&Body> {
        let place = *self.places.get(handle as usize)? as usize;
        self.living.get(place).filter(|body| body.handle == handle)
    }

    /// The body with a handle, living or leaving.
    pub fn any_with_handle(&self, handle: u32) -> &Body {
        match self.leaving.iter().find(|b| b.handle == handle) {
            Some(body) => body,
            None => self.with_handle(handle),
        }
    }

    /// Adds and removes bodies; nothing is changed if any event is wrong.
    ///
    /// # Errors
    /// See [`FluidError`].
    pub fn apply(
        &mut self,
        events: &[BodyEvent],
        units: &Units,
        layout: &Layout,
    ) -> Result<(), FluidError> {
        let mut ids: Vec<u64> = self.living.iter().map(|b| b.id).collect();
        // All are checked before any is applied: an error leaves the bodies as they were.
        for event in events {
            check(event, &mut ids, units, &layout.grid, &self.catalogue)?;
        }
        for event in events {
            let place = self.living.partition_point(|b| b.id < event.id);
            if event.kind == BodyEvent::ADDED {
                let handle = self.new_handle();
                self.newcomers.push(handle);
                let mut body = self.body(event, handle, units, layout);
                body.share = self.next_share(event);
                self.living.insert(place, body);
            } else {
                let mut body = self.living.remove(place);
                body.leave(layout);
                self.leaving.push(body);
            }
        }
        self.renumber();
        self.changed |= !events.is_empty();
        Ok(())
    }

    /// The body that an event adds, which was checked.
    fn body(&self, event: &BodyEvent, handle: u32, units: &Units, layout: &Layout) -> Body {
        let part = self.catalogue.body(event, units.cell);
        let radius = part.as_ref().map_or(event.size[0] / units.cell, |part| part.radius());
        let mut body = Body::new(&layout.grid, event.id, handle, radius, part);
        body.event = Some(*event);
        if event.motion == BodyEvent::FREE {
            body.mass = event.mass / units.mass();
        }
        body
    }

    /// Keeps the rigid bodies, or puts them back with their cells. Returns the handles of surfaces
    /// that deform, which [`Bodies::place_softs`] is to give back to them.
    ///
    /// # Errors
    /// Bodies that the scene does not have.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        site: &mut BodySite<'_>,
    ) -> Result<Vec<u32>, StateError> {
        let sets = self.came.len();
        let mut of_softs: Vec<_> =
            self.living[self.rigid()..].iter().map(|body| body.handle).collect();
        let mut kept: Vec<_> = self.living.iter().filter_map(KeptBody::of).collect();
        state.value("living", &mut kept)?;
        state.list("handles_of_surfaces", &mut of_softs)?;
        state.list("free_handles", &mut self.free)?;
        state.value("came", &mut self.came)?;
        if state.restores() {
            if let Err(error) = self.check_kept(&kept, site) {
                state.unfit(format!("a body of the state is not the scene's: {error}"))?;
            }
            if !self.have_handles(&kept, &of_softs) || self.came.len() != sets {
                state.unfit("the bodies of the state are not those of one scene")?;
            }
            self.put_back(&kept, of_softs.len(), site);
        }
        Ok(of_softs)
    }

    /// Keeps the surfaces that deform, or puts them back with their cells.
    ///
    /// # Errors
    /// A state of other surfaces.
    pub fn exchange_softs(
        &mut self,
        state: &mut StateExchange<'_>,
        site: &mut BodySite<'_>,
    ) -> Result<(), StateError> {
        let mut places: Vec<_> = self.vertices.iter().map(|vertex| vertex.position).collect();
        let mut velocities: Vec<_> = self.vertices.iter().map(|vertex| vertex.velocity).collect();
        state.list("places", &mut places)?;
        state.list("velocities", &mut velocities)?;
        if state.restores() {
            let expected = self.softs.last().map_or(0, |soft| soft.vertices().end);
            if [places.len(), velocities.len()] != [expected; 2] {
                return state.unfit("the vertices of the state are not those of its surfaces");
            }
            let vertex = |(position, velocity)| SurfaceVertex { position, velocity };
            self.vertices = places.into_iter().zip(velocities).map(vertex).collect();
        }
        let first = self.rigid();
        let (grid, team) = (&site.layout.grid, &mut *site.team);
        for (k, body) in self.living[first..].iter_mut().enumerate() {
            state.within(&format!("{k}"), |state| body.exchange_shape(state, grid, team))?;
        }
        Ok(())
    }

    /// Checks that events can have added the bodies of a state.
    fn check_kept(&self, kept: &[KeptBody], site: &BodySite<'_>) -> Result<(), FluidError> {
        let mut ids = Vec::with_capacity(kept.len());
        for body in kept {
            check(&body.event, &mut ids, site.units, &site.layout.grid, &self.catalogue)?;
        }
        match kept.iter().find(|body| !body.is_placed()) {
            Some(body) => Err(FluidError::NonFiniteBody { id: body.event.id }),
            None => Ok(()),
        }
    }

    /// True if each handle is one body's or free, and the bodies are sorted by id.
    fn have_handles(&self, kept: &[KeptBody], of_softs: &[u32]) -> bool {
        let mut handles: Vec<u32> = kept.iter().map(|body| body.handle).collect();
        handles.extend(self.free.iter().chain(of_softs));
        handles.sort_unstable();
        handles.iter().copied().eq(0..handles.len() as u32)
            && kept.is_sorted_by(|a, b| a.event.id < b.event.id)
            && kept.iter().all(|body| body.event.kind == BodyEvent::ADDED)
    }

    /// Makes the rigid bodies of a state that was checked, beside so many surfaces.
    fn put_back(&mut self, kept: &[KeptBody], softs: usize, site: &mut BodySite<'_>) {
        let BodySite { units, layout, line, team } = site;
        self.living.clear();
        for kept in kept {
            let mut body = self.body(&kept.event, kept.handle, units, layout);
            kept.put_back(&mut body, layout, *line, team);
            self.living.push(body);
        }
        self.places = vec![0; kept.len() + softs + self.free.len()];
        self.renumber();
    }

    /// True if there was ever a body.
    pub fn had_any(&self) -> bool {
        !self.places.is_empty()
    }

    /// True if bodies came or went since the last step.
    pub fn come_or_go(&self) -> bool {
        self.changed || !self.leaving.is_empty()
    }

    /// True if the body with a handle lives.
    pub fn is_alive(&self, handle: u32) -> bool {
        let place = self.places.get(handle as usize).map(|&place| place as usize);
        place.and_then(|place| self.living.get(place)).is_some_and(|body| body.handle == handle)
    }

    /// Checks that states are those of the living bodies, finite, and have a load each.
    ///
    /// # Errors
    /// See [`FluidError`].
    pub fn check(&self, states: &[BodyState], loads: usize) -> Result<(), FluidError> {
        if loads != states.len() {
            return Err(FluidError::Room { room: loads, bodies: states.len() });
        }
        let count = self.rigid();
        let name = |id: Option<u64>| id.map_or("the end of the list".into(), |id| id.to_string());
        for place in 0..count.max(states.len()) {
            let expected = self.living[..count].get(place).map(|b| b.id);
            let found = states.get(place).map(|s| s.id);
            if expected != found {
                let (expected, found) = (name(expected), name(found));
                return Err(FluidError::Bodies { place, count, expected, found });
            }
        }
        match states.iter().find(|s| !s.is_finite()) {
            Some(state) => Err(FluidError::NonFiniteBody { id: state.id }),
            None => Ok(()),
        }
    }

    /// Takes over checked states; true if any body is elsewhere than before, or came or went.
    pub fn take(&mut self, states: &[BodyState], units: &Units, grid: &Grid) -> bool {
        let mut moved = std::mem::take(&mut self.changed);
        for (body, state) in self.living.iter_mut().zip(states) {
            moved |= body.take(state, self.lead, units, grid);
        }
        let first = self.rigid();
        for (body, soft) in self.living[first..].iter_mut().zip(&self.softs) {
            moved |= body.take_shape(&self.vertices[soft.vertices()], self.lead, units);
        }
        moved
    }

    /// Takes note of which bodies hold cells with others, whose handles these are.
    pub fn note_sharing(&mut self, handles: impl Iterator<Item = u32>) {
        for body in &mut self.living {
            body.shares = false;
        }
        for handle in handles {
            self.living[self.places[handle as usize] as usize].shares = true;
        }
    }

    /// True if a part has come, gone or moved by a step.
    pub fn parts_moved(&self) -> bool {
        self.living.iter().any(|body| body.moved && body.is_part())
            || self.leaving.iter().any(Body::is_part)
    }

    /// Forgets who came and who left, once nobody needs it.
    pub fn forget_events(&mut self) {
        self.newcomers.clear();
        self.free.extend(self.leaving.drain(..).map(|b| b.handle));
    }
}
