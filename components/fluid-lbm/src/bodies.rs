//! The bodies in the fluid: who lives, where they are, which cells they cover.

use crate::catalogue::Catalogue;
use crate::error::FluidError;
use crate::events::check;
use crate::grid::Grid;
use crate::lattice::cross;
use crate::layout::Layout;
use crate::mass::Account;
use crate::part_body::PartBody;
use crate::shape::Hit;
use crate::sphere::Spans;
use crate::surfaces::Soft;
use crate::units::Units;
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use tremie_messages::{BodyEvent, BodyState, SurfaceVertex};
use tremie_team::Team;

/// A sphere, a part or a polyhedron in the fluid; lattice units.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its id.
    pub id: u64,
    /// Its number in the map of owners.
    pub handle: u32,
    /// Radius of a sphere; of a part the distance of its farthest point from its origin.
    pub radius: f64,
    /// Its surface, unless it is a sphere.
    pub part: Option<Box<PartBody>>,
    /// Centre or origin, in the box along periodic axes.
    pub position: [f64; 3],
    /// Velocity of its wall: what it was given, and further by what it changed by since the last step.
    pub velocity: [f64; 3],
    /// Angular velocity, likewise.
    pub spin: [f64; 3],
    /// Velocity and angular velocity that it was given last.
    given: [[f64; 3]; 2],
    /// Cells inside.
    pub spans: Spans,
    /// Cells inside one step before.
    previous: Spans,
    /// Whether it has a position yet.
    placed: bool,
    /// Whether its cells must be found anew.
    moved: bool,
    /// Cells that it left and entered in the last move.
    pub left: Vec<u32>,
    /// Cells that it entered in the last move.
    pub entered: Vec<u32>,
    /// Force and torque that averaging holds back.
    pub carried: [[f64; 3]; 2],
    /// Force and torque of the pressure in gaps in the last step.
    pub pressed: [[f64; 3]; 2],
    /// What it owes the fluid.
    pub account: Account,
}

impl Body {
    fn new(id: u64, handle: u32, radius: f64, part: Option<Box<PartBody>>) -> Self {
        let spans = Spans::empty(if part.is_some() { 0.0 } else { radius });
        let side = (2.0 * radius).ceil() as usize + 4;
        // A move by less than a cell changes less than this; a jump may allocate.
        let changes = side * side;
        Self {
            id,
            handle,
            radius,
            part,
            position: [0.0; 3],
            velocity: [0.0; 3],
            spin: [0.0; 3],
            given: [[0.0; 3]; 2],
            previous: spans.clone(),
            spans,
            placed: false,
            moved: false,
            left: Vec::with_capacity(changes),
            entered: Vec::with_capacity(changes),
            carried: [[0.0; 3]; 2],
            pressed: [[0.0; 3]; 2],
            account: Account::default(),
        }
    }

    /// Whether it is a part of the scene or a surface that deforms, no sphere or polyhedron.
    pub fn is_part(&self) -> bool {
        self.part.as_ref().is_some_and(|part| part.index != PartBody::NO_PART)
    }

    /// Squared radius.
    #[inline]
    pub fn r2(&self) -> f64 {
        self.radius * self.radius
    }

    /// Volume [cells].
    pub fn volume(&self) -> f64 {
        match &self.part {
            Some(part) => part.volume,
            None => 4.0 / 3.0 * std::f64::consts::PI * self.radius * self.r2(),
        }
    }

    /// From its centre or origin to the centre of its volume.
    pub fn middle(&self) -> [f64; 3] {
        self.part.as_ref().map_or([0.0; 3], |part| part.middle())
    }

    /// Direction away from the body at a point of its surface, seen from its centre or origin.
    pub fn outward(&self, arm: [f64; 3]) -> [f64; 3] {
        self.part.as_ref().map_or(arm, |part| part.outward(arm))
    }

    /// Rows along y or z in which links to it can begin.
    pub fn shell_side(&self) -> i32 {
        self.part.as_ref().map_or(self.spans.shell_side(), |part| part.side() + 2)
    }

    /// Coordinates `(y, z)` of row `(j, k)` of the shell, `0 <= j, k < shell_side()`.
    pub fn shell_row(&self, j: i32, k: i32) -> [i32; 2] {
        match &self.part {
            Some(part) => [part.origin()[0] - 1 + j, part.origin()[1] - 1 + k],
            None => self.spans.shell_row(j, k),
        }
    }

    /// Whether it covers a cell, given as seen from it.
    pub fn covers(&self, [x, y, z]: [i32; 3]) -> bool {
        match &self.part {
            None => self.spans.at(y, z).contains(x),
            Some(part) => part.inside(y, z, x, x) != 0,
        }
    }

    /// Whether the other body is the part that carries this surface, or the other way round.
    pub fn is_bonded_to(&self, other: &Self) -> bool {
        let carrier = |body: &Self| Some(body.part.as_ref()?.shape.as_ref()?.carrier);
        let is = |body: &Self, index| body.part.as_ref().is_some_and(|part| part.index == index);
        carrier(self).is_some_and(|index| is(other, index))
            || carrier(other).is_some_and(|index| is(self, index))
    }

    /// Where on a surface that can deform the point nearest to `arm` is; [`Hit::NONE`] on others.
    pub fn hit_near(&self, arm: [f64; 3]) -> Hit {
        let part = self.part.as_ref().filter(|part| part.shape.is_some());
        part.map_or(Hit::NONE, |part| part.hit_near(arm))
    }

    /// Velocity of the wall at `arm` from the centre, which is `hit` on a surface that can deform.
    #[inline]
    pub fn velocity_of(&self, hit: Hit, arm: [f64; 3]) -> [f64; 3] {
        match self.part.as_ref().and_then(|part| part.shape.as_ref()) {
            Some(shape) => shape.velocity_at(hit),
            None => self.velocity_at(arm),
        }
    }

    /// Velocity of the point at `arm` from the centre, of a rigid body.
    #[inline]
    pub fn velocity_at(&self, arm: [f64; 3]) -> [f64; 3] {
        let turn = cross(self.spin, arm);
        std::array::from_fn(|a| self.velocity[a] + turn[a])
    }

    /// Takes over a state; true if the body is now elsewhere.
    fn take(&mut self, state: &BodyState, lead: f64, units: &Units, grid: &Grid) -> bool {
        let velocity = state.velocity.map(|v| v / units.velocity());
        let spin = state.angular_velocity.map(|w| w * units.time_step);
        let before = if self.placed { self.given } else { [velocity, spin] };
        let further = |now: [f64; 3], before: [f64; 3]| {
            std::array::from_fn(|a| now[a] + lead * (now[a] - before[a]))
        };
        (self.velocity, self.spin) = (further(velocity, before[0]), further(spin, before[1]));
        self.given = [velocity, spin];
        let position = grid.canonical(units.position_to_lattice(state.position));
        let elsewhere = match &mut self.part {
            Some(part) => part.place(position, state.orientation),
            None => position != self.position,
        };
        let moved = !self.placed || elsewhere;
        if moved && self.placed {
            // The old cells, seen from the same side of a periodic face as the new ones.
            let turns = std::array::from_fn(|a| {
                let n = f64::from(grid.n[a]);
                let turns = ((position[a] - self.position[a]) / n).round();
                if grid.periodic[a] { turns as i32 * grid.n[a] } else { 0 }
            });
            if turns != [0; 3] {
                self.spans.shift(turns);
                if let Some(part) = &mut self.part {
                    part.shift(turns);
                }
            }
        }
        self.position = position;
        self.placed = true;
        self.moved = moved;
        moved
    }

    /// Takes over the vertices of a surface; true if it is now elsewhere.
    fn take_shape(&mut self, vertices: &[SurfaceVertex], lead: f64, units: &Units) -> bool {
        let moved = self.part.as_mut().is_some_and(|part| part.deform(vertices, lead, units));
        (self.placed, self.moved) = (true, moved);
        moved
    }

    /// Finds the cells inside of a part that has moved. True if a surface outgrew its room.
    pub fn cover_part(&mut self, layout: &Layout, team: &mut Team) -> bool {
        let Some(part) = self.part.as_mut().filter(|_| self.moved) else { return false };
        let side = part.side();
        part.cover(&layout.grid, team);
        if part.shape.is_some() {
            self.radius = part.radius();
        }
        part.side() != side
    }

    /// Finds the cells inside at the new position, and which were left and entered; of a part, once it
    /// is covered.
    pub fn cover(&mut self, layout: &Layout) {
        self.left.clear();
        self.entered.clear();
        if !self.moved {
            return;
        }
        if self.part.is_some() {
            return self.note_changes(layout);
        }
        std::mem::swap(&mut self.spans, &mut self.previous);
        self.spans.fit(&layout.grid, self.position, self.radius);
        let (left, entered) = (&mut self.left, &mut self.entered);
        self.previous.minus(&self.spans, |at| left.extend(stored(layout, at)));
        self.spans.minus(&self.previous, |at| entered.extend(stored(layout, at)));
    }

    /// Lists the cells that a part's last move changed.
    fn note_changes(&mut self, layout: &Layout) {
        let (left, entered) = (&mut self.left, &mut self.entered);
        left.clear();
        entered.clear();
        if let Some(part) = &self.part {
            part.changes(
                |at| left.extend(stored(layout, at)),
                |at| entered.extend(stored(layout, at)),
            );
        }
    }

    /// Wants the densities of all lines of `line` cells in which links to a sphere can begin; those of a
    /// part are known.
    pub fn want(&self, layout: &Layout, line: usize, lines: &[AtomicU8]) {
        if self.part.is_some() {
            return;
        }
        let grid = &layout.grid;
        // Links are at most the square root of 2 long.
        let reach = self.radius + 1.5;
        let side = self.shell_side();
        for k in 0..side * side {
            let [y, z] = self.shell_row(k % side, k / side);
            let (real_y, real_z) = (grid.wrap(1, y), grid.wrap(2, z));
            let d = [f64::from(y) + 0.5 - self.position[1], f64::from(z) + 0.5 - self.position[2]];
            let square = reach * reach - (d[0] * d[0] + d[1] * d[1]);
            if square <= 0.0 || !grid.contains([0, real_y, real_z]) {
                continue;
            }
            let half = square.sqrt();
            let first = (self.position[0] - half).floor() as i32;
            let last = (self.position[0] + half).floor() as i32;
            if !grid.periodic[0] {
                want_range(
                    layout,
                    line,
                    lines,
                    [first.max(0), last.min(grid.n[0] - 1)],
                    [real_y, real_z],
                );
            } else if first < 0 || last >= grid.n[0] {
                want_range(layout, line, lines, [0, grid.n[0] - 1], [real_y, real_z]);
            } else {
                want_range(layout, line, lines, [first, last], [real_y, real_z]);
            }
        }
    }

    /// Leaves all its cells.
    fn leave(&mut self, layout: &Layout) {
        if let Some(part) = &mut self.part {
            part.leave();
            return self.note_changes(layout);
        }
        self.previous.clear();
        std::mem::swap(&mut self.spans, &mut self.previous);
        let (left, previous, spans) = (&mut self.left, &self.previous, &self.spans);
        left.clear();
        self.entered.clear();
        previous.minus(spans, |at| left.extend(stored(layout, at)));
    }
}

/// Wants the lines of the stored cells from `first` to `last` of a row.
fn want_range(
    layout: &Layout,
    line: usize,
    lines: &[AtomicU8],
    [first, last]: [i32; 2],
    [y, z]: [i32; 2],
) {
    let mut stored = (first..=last).filter_map(|x| layout.cell([x, y, z]));
    let Some(begin) = stored.next() else { return };
    let end = stored.next_back().unwrap_or(begin);
    for wanted in &lines[begin as usize / line..=end as usize / line] {
        wanted.store(1, Relaxed);
    }
}

/// The stored cell at coordinates that may lie beyond a periodic face.
fn stored(layout: &Layout, at: [i32; 3]) -> Option<u32> {
    layout.cell(std::array::from_fn(|a| layout.grid.wrap(a, at[a])))
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
    softs: Vec<Soft>,
    /// Their vertices at the end of the coming step.
    pub vertices: Vec<SurfaceVertex>,
    /// Whether bodies were added or removed since the last step.
    pub changed: bool,
    /// What they can be besides spheres.
    catalogue: Catalogue,
    /// How many steps ahead velocities are taken.
    lead: f64,
}

impl Bodies {
    /// None, in a scene with a catalogue of what they can be; velocities of parts are taken `lead` steps
    /// ahead.
    pub fn of(catalogue: Catalogue, lead: f64) -> Self {
        Self { catalogue, lead, ..Self::default() }
    }

    /// Adds deformable surfaces, once.
    pub fn add_softs(&mut self, softs: Vec<Soft>, parts: Vec<PartBody>, grid: &Grid) {
        let first = u64::MAX - softs.len() as u64;
        for (k, mut part) in (1..).zip(parts) {
            let handle = self.new_handle();
            let position = grid.canonical(part.reference());
            part.place(position, [0.0, 0.0, 0.0, 1.0]);
            let mut body = Body::new(first + k, handle, part.radius(), Some(Box::new(part)));
            body.position = position;
            self.living.push(body);
        }
        self.softs = softs;
        self.renumber();
        self.changed = true;
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
        for event in events {
            check(event, &mut ids, units, &layout.grid, &self.catalogue)?;
        }
        for event in events {
            let place = self.living.partition_point(|b| b.id < event.id);
            if event.kind == BodyEvent::ADDED {
                let handle = self.new_handle();
                let part = self.catalogue.body(event, units.cell);
                let radius = part.as_ref().map_or(event.size[0] / units.cell, |part| part.radius());
                self.newcomers.push(handle);
                self.living.insert(place, Body::new(event.id, handle, radius, part));
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
            let lead = if body.is_part() { self.lead } else { 0.0 };
            moved |= body.take(state, lead, units, grid);
        }
        let first = self.rigid();
        for (body, soft) in self.living[first..].iter_mut().zip(&self.softs) {
            moved |= body.take_shape(&self.vertices[soft.vertices()], self.lead, units);
        }
        moved
    }

    /// Whether a part has come, gone or moved by a step.
    pub fn parts_moved(&self) -> bool {
        self.living.iter().any(|body| body.moved && body.is_part())
            || self.leaving.iter().any(Body::is_part)
    }

    /// Forgets the bodies that left, once nobody needs them.
    pub fn forget_leaving(&mut self) {
        self.free.extend(self.leaving.drain(..).map(|b| b.handle));
    }
}
