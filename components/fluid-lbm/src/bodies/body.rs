//! One body in the fluid: where it is, how its wall moves, which cells it covers.

mod kept_body;

use crate::bodies::deformable_shape::Hit;
use crate::bodies::mass_account::MassAccount;
use crate::bodies::mesh_body::MeshBody;
use crate::bodies::near_cells::{Near, NearCells};
use crate::bodies::sphere_raster::{RowSpans, wall_distance};
use crate::lattice::d3q19::{C, C_F64, cross};
use crate::lattice::layout::Layout;
use crate::lattice::units::Units;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::survey::displaced_volume::Displaced;
use tremie_messages::{BodyEvent, BodyState, SurfaceVertex};
use tremie_team::Team;

pub use self::kept_body::KeptBody;

/// A sphere, a part or a polyhedron in the fluid; lattice units.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its id.
    pub id: u64,
    /// What added it; none of a surface that deforms.
    pub event: Option<BodyEvent>,
    /// Its number in the map of owners.
    pub handle: u32,
    /// Radius of a sphere; of a part the distance of its farthest point from its origin.
    pub radius: f64,
    /// Its surface, unless it is a sphere.
    pub part: Option<Box<MeshBody>>,
    /// Centre or origin, in the box along periodic axes.
    pub position: [f64; 3],
    /// Mass of one that moves under the fluid's force alone and contacts; infinite of others.
    pub mass: f64,
    /// By how much the fluid's last force changes its velocity in a step.
    pub urged: [f64; 3],
    /// Velocity of its wall: what it was given, and further by what it is likely to change by.
    pub velocity: [f64; 3],
    /// Angular velocity, likewise.
    pub spin: [f64; 3],
    /// Velocity and angular velocity that it was given last.
    given: [[f64; 3]; 2],
    /// By how much the velocity changes in a step, where it is taken further than given; see
    /// [`crate::bodies::body::late`].
    pub change: [f64; 3],
    /// Cells inside.
    pub spans: RowSpans,
    /// Cells inside one step before.
    previous: RowSpans,
    /// The cells around a sphere.
    pub shell: NearCells,
    /// Lines in which links to a sphere can begin.
    lines: Vec<u32>,
    /// Its items of links among those of all bodies.
    pub items: std::ops::Range<usize>,
    /// True if it holds cells that another body holds too.
    pub shares: bool,
    /// True if it has a position yet.
    placed: bool,
    /// True if its cells must be found anew.
    pub moved: bool,
    /// Cells that it left and entered in the last move.
    pub left: Vec<u32>,
    /// Cells that it entered in the last move.
    pub entered: Vec<u32>,
    /// Force and torque that averaging holds back.
    pub carried: [[f64; 3]; 2],
    /// Force and torque of the pressure in gaps in the last step.
    pub pressed: [[f64; 3]; 2],
    /// Mass that it owes the fluid.
    pub account: MassAccount,
    /// Share of a union that it displaces; `None` where it displaces all of its volume.
    pub share: Option<UnionShare>,
}

/// Share of a union's volume that a piece of it displaces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnionShare {
    /// Volume [cells].
    pub volume: f64,
    /// Centre of that volume as seen from the body's, as the body stood first.
    pub middle: [f64; 3],
    /// Orientation in which the body came, once that is known, and its orientation now.
    pub first: Option<[f64; 4]>,
    /// See `first`.
    pub orientation: [f64; 4],
}

impl UnionShare {
    /// Takes note of how the body stands.
    fn turn(&mut self, orientation: [f64; 4]) {
        self.first.get_or_insert(orientation);
        self.orientation = orientation;
    }

    /// Centre of the volume as seen from the body's.
    fn middle(&self) -> [f64; 3] {
        let Some(first) = self.first else { return self.middle };
        let back = [-first[0], -first[1], -first[2], first[3]];
        rotated(self.orientation, rotated(back, self.middle))
    }
}

/// A vector turned by a unit quaternion.
fn rotated([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let u = [x, y, z];
    let t = cross(u, v).map(|c| 2.0 * c);
    let more = cross(u, t);
    std::array::from_fn(|a| v[a] + w * t[a] + more[a])
}

/// Delay of the reflection of a link that meets the wall at `q`, after half a step from the step's
/// start [steps]. The population that comes back to the cell at the step's end met the wall at
/// `1 - q` of the step, or at `q` where that is more.
///
/// The wall's velocity is that of this time. One and the same for all links would be late for all
/// but those that meet the wall half-way, and as a force that is late it would feed the sound
/// around the body: a plate on 30 cells of fluid swings by a factor of e more in some thousand
/// steps. (A surface that deforms answers the force with a velocity, not with a change of it: taken
/// further, that would swing from step to step.)
#[inline(always)]
pub fn late(q: f64) -> f64 {
    (q - 0.5).abs()
}

impl Body {
    /// One in a box that is nowhere yet.
    pub fn new(
        grid: &Grid,
        id: u64,
        handle: u32,
        radius: f64,
        part: Option<Box<MeshBody>>,
    ) -> Self {
        let spans = RowSpans::empty(if part.is_some() { 0.0 } else { radius });
        let side = (2.0 * radius).ceil() as usize + 4;
        let shell = NearCells::new(grid, if part.is_some() { 0 } else { spans.shell_side() });
        // A row's cells that are not covered lie in two lines, or at the end of one more.
        let lines = if part.is_some() { 0 } else { (side + 1) * (side + 1) * (2 + side / 8) };
        // A move by less than a cell changes less than this; a jump may allocate.
        let changes = part.as_ref().map_or(side * side, |part| {
            let ([a, b, c], side) = (part.size().map(|n| n as usize), side * side);
            side.max(a * b).max(b * c).max(c * a)
        });
        Self {
            id,
            event: None,
            handle,
            radius,
            part,
            mass: f64::INFINITY,
            urged: [0.0; 3],
            position: [0.0; 3],
            velocity: [0.0; 3],
            spin: [0.0; 3],
            given: [[0.0; 3]; 2],
            change: [0.0; 3],
            previous: spans.clone(),
            spans,
            lines: Vec::with_capacity(lines),
            shell,
            items: 0..0,
            shares: false,
            placed: false,
            moved: false,
            left: Vec::with_capacity(changes),
            entered: Vec::with_capacity(changes),
            carried: [[0.0; 3]; 2],
            pressed: [[0.0; 3]; 2],
            account: MassAccount::default(),
            share: None,
        }
    }

    /// Memory that the cells around a sphere take [bytes].
    pub fn bytes(&self) -> usize {
        self.shell.bytes() + size_of::<u32>() * self.lines.capacity()
    }

    /// True if it is a part of the scene or a surface that deforms, no sphere or polyhedron.
    pub fn is_part(&self) -> bool {
        self.part.as_ref().is_some_and(|part| part.index != MeshBody::NO_PART)
    }

    /// Squared radius.
    #[inline]
    pub fn r2(&self) -> f64 {
        self.radius * self.radius
    }

    /// Volume that it displaces [cells].
    pub fn volume(&self) -> f64 {
        if let Some(share) = &self.share {
            return share.volume;
        }
        match &self.part {
            Some(part) => part.volume,
            None => 4.0 / 3.0 * std::f64::consts::PI * self.radius * self.r2(),
        }
    }

    /// From its centre or origin to the centre of its volume.
    pub fn middle(&self) -> [f64; 3] {
        if let Some(share) = &self.share {
            return share.middle();
        }
        self.part.as_ref().map_or([0.0; 3], |part| part.middle())
    }

    /// Volume that it displaces, and first moments about its centre or origin. Of a part, the
    /// volume that lies in the domain.
    pub fn displaced(&self, grid: &Grid, mirrors: [bool; 3]) -> Displaced {
        let cut = || {
            let part = self.part.as_ref().filter(|part| self.is_part() && part.shape.is_none())?;
            part.displaced(grid, self.position, mirrors)
        };
        cut().unwrap_or_else(|| Displaced::whole(self.volume(), self.middle()))
    }

    /// Takes note of the force that it is given.
    pub fn urge(&mut self, force: [f64; 3]) {
        self.urged = force.map(|f| f / self.mass);
    }

    /// Direction away from the body at a point of its surface, seen from its centre or origin.
    pub fn outward(&self, arm: [f64; 3]) -> [f64; 3] {
        self.part.as_ref().map_or(arm, |part| part.outward(arm))
    }

    /// Cells that a move by less than a cell changes at most.
    pub fn most_changes(&self) -> usize {
        let [rows, layers] = self.shell_size().map(|n| n as usize);
        let sizes = self.part.as_ref().map_or([0; 3], |part| part.size().map(|n| n as usize));
        let [a, b, c] = sizes;
        (rows * layers).max(a * b).max(b * c).max(c * a)
    }

    /// Rows along y, and layers along z, in which links to it can begin.
    pub fn shell_size(&self) -> [i32; 2] {
        match &self.part {
            Some(part) => [1, 2].map(|a| {
                let [first, last] = part.near(a);
                last - first + 1
            }),
            None => [self.spans.shell_side(); 2],
        }
    }

    /// Coordinates `(y, z)` of row `j` of layer `k` of the shell, less than [`Body::shell_size`].
    pub fn shell_row(&self, j: i32, k: i32) -> [i32; 2] {
        match &self.part {
            Some(part) => [part.near(1)[0] + j, part.near(2)[0] + k],
            None => self.spans.shell_row(j, k),
        }
    }

    /// True if it covers a cell, given as seen from it.
    pub fn covers(&self, [x, y, z]: [i32; 3]) -> bool {
        match &self.part {
            None => self.spans.at(y, z).contains(x),
            Some(part) => part.inside(y, z, x, x) != 0,
        }
    }

    /// True if the other body is the part that carries this surface, or the other way round.
    pub fn is_bonded_to(&self, other: &Self) -> bool {
        let carrier = |body: &Self| Some(body.part.as_ref()?.shape.as_ref()?.carrier);
        let is = |body: &Self, index| body.part.as_ref().is_some_and(|part| part.index == index);
        carrier(self).is_some_and(|index| is(other, index))
            || carrier(other).is_some_and(|index| is(self, index))
    }

    /// Wall distance along the link `i` of a cell at `arm`, as part of the link's length; for a
    /// part, at the pose where its links were found.
    pub fn met_at(&self, arm: [f64; 3], i: usize) -> f64 {
        match &self.part {
            None => wall_distance(arm, C_F64[i], self.r2()),
            Some(part) => {
                // The cell as the part sees it.
                let at = std::array::from_fn(|a| (arm[a] + self.position[a] - 0.5).round() as i32);
                part.meet(at, C[i])
            }
        }
    }

    /// Point nearest to `arm` on a surface that can deform; [`Hit::NONE`] on others.
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
    pub fn take(&mut self, state: &BodyState, lead: f64, units: &Units, grid: &Grid) -> bool {
        if let Some(share) = &mut self.share {
            share.turn(state.orientation);
        }
        let velocity = state.velocity.map(|v| v / units.velocity());
        let spin = state.angular_velocity.map(|w| w * units.time_step);
        let before = if self.placed { self.given } else { [velocity, spin] };
        let change: [f64; 3] = std::array::from_fn(|a| velocity[a] - before[0][a]);
        let (change, spin_change) = if self.is_part() {
            (change, std::array::from_fn(|a| spin[a] - before[1][a]))
        } else {
            (std::array::from_fn(|a| lesser(change[a], self.urged[a])), [0.0; 3])
        };
        self.velocity = std::array::from_fn(|a| velocity[a] + lead * change[a]);
        self.spin = std::array::from_fn(|a| spin[a] + lead * spin_change[a]);
        self.change = if lead > 0.0 { change } else { [0.0; 3] };
        self.given = [velocity, spin];
        let position = match &self.part {
            Some(part) => part.home(state.position, units, grid),
            None => grid.canonical(units.position_to_lattice(state.position)),
        };
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
    pub fn take_shape(&mut self, vertices: &[SurfaceVertex], lead: f64, units: &Units) -> bool {
        let moved = self.part.as_mut().is_some_and(|part| part.deform(vertices, lead, units));
        (self.placed, self.moved) = (true, moved);
        moved
    }

    /// Finds the cells inside of a part that has moved. True if a surface outgrew its room.
    pub fn cover_part(&mut self, layout: &Layout, team: &mut Team) -> bool {
        let Some(part) = self.part.as_mut().filter(|_| self.moved) else { return false };
        let size = part.size();
        part.cover(&layout.grid, team);
        if part.shape.is_some() {
            self.radius = part.radius();
        }
        part.size() != size
    }

    /// Finds the cells inside at the new position, and which were left and entered; of a part, once
    /// it is covered.
    ///
    /// Lines are of `line` cells; true if links to a sphere can begin in others than before.
    pub fn cover(&mut self, layout: &Layout, line: usize) -> bool {
        self.left.clear();
        self.entered.clear();
        if !self.moved {
            return false;
        }
        if self.part.is_some() {
            self.note_changes(layout);
            return false;
        }
        if self.spans.hold_at(self.position) {
            return false;
        }
        std::mem::swap(&mut self.spans, &mut self.previous);
        let is_elsewhere = self.fit(layout, self.position);
        let is_changed = !self.spans.are(&self.previous);
        if is_changed {
            let (left, entered) = (&mut self.left, &mut self.entered);
            self.previous.minus(&self.spans, |at| left.extend(stored(layout, at)));
            self.spans.minus(&self.previous, |at| entered.extend(stored(layout, at)));
        }
        let finds_lines = is_elsewhere || is_changed;
        if finds_lines {
            self.shell.cover(&layout.grid, &self.spans);
            self.find_lines(line);
        }
        finds_lines
    }

    /// Finds the cells inside and around a sphere at a place; true if those around are others.
    fn fit(&mut self, layout: &Layout, centre: [f64; 3]) -> bool {
        self.spans.fit(&layout.grid, centre, self.radius);
        let origin = centre.map(|x| (x - self.radius).floor() as i32 - 1);
        self.shell.fit(layout, origin)
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

    /// Lists the lines of `line` cells in which links to a sphere can begin.
    fn find_lines(&mut self, line: usize) {
        self.lines.clear();
        let shell = &self.shell;
        for near in shell.near(0..self.spans.shell_side()) {
            let ends = shell.around(near).iter().fold(0, |all, ends| all | ends);
            let &Near { cells, number, free, .. } = near;
            let begin = (ends | ends >> 1 | ends >> 2) & cells & free;
            if begin != 0 {
                let number_at = |bit: u32| number + (cells & ((1 << bit) - 1)).count_ones();
                let first = number_at(begin.trailing_zeros()) / line as u32;
                let last = number_at(63 - begin.leading_zeros()) / line as u32;
                self.lines.extend(first..=last);
            }
        }
    }

    /// Wants the densities of all lines in which links to a sphere can begin; those of a part are
    /// known.
    pub fn want(&self, lines: &[AtomicU8]) {
        for &line in &self.lines {
            lines[line as usize].store(1, Relaxed);
        }
    }

    /// Leaves all its cells.
    pub fn leave(&mut self, layout: &Layout) {
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

/// Of two changes the lesser, if both go the same way.
fn lesser(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 { 0.0 } else { a.signum() * a.abs().min(b.abs()) }
}

/// The stored cell at coordinates that may lie beyond a periodic face.
fn stored(layout: &Layout, at: [i32; 3]) -> Option<u32> {
    layout.cell(std::array::from_fn(|a| layout.grid.wrap(a, at[a])))
}
