//! Open fractions of faces and cells, and what cells exert on bodies.
//!
//! Fractions that bodies close add up: bodies do not overlap but where they touch. What would be
//! more than a whole face is the whole face. A wall thinner than a cell closes the faces between
//! cells whose centres it parts, so that it does not leak.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::pressure::body_coupling::{BodyCoupling, Wrench};
use crate::solids::rigid_body::{RigidBody, cross, padded};
use std::collections::BTreeMap;

/// Distance that particles keep from bodies and walls, in edges of cells.
pub const MARGIN: f64 = 1e-3;
/// Fractions that are less are none: rounding leaves as much of what is covered.
const LEAST: f64 = 1e-9;
/// No solid.
pub const NONE: u32 = u32::MAX;

/// Cells that border on some bodies, and what they exert.
#[derive(Clone, Debug, Default)]
pub struct BorderCells<const D: usize> {
    /// The entries, body by body.
    pub coupling: BodyCoupling,
    /// Of each entry, covered part of the cell less the mean of the covered parts of its two faces
    /// across each axis.
    pub beyond_faces: Vec<[f64; D]>,
}

impl<const D: usize> BorderCells<D> {
    fn clear(&mut self) {
        self.coupling.clear();
        self.beyond_faces.clear();
    }

    fn truncate(&mut self, bodies: usize) {
        self.coupling.truncate(bodies);
        self.beyond_faces.truncate(self.coupling.cells.len());
    }
}

/// Fractions of a box without the bodies that move.
#[derive(Clone, Debug)]
struct AtRest<const D: usize> {
    open: [Vec<f64>; D],
    volume: Vec<f64>,
    holder: [Vec<u32>; D],
    is_near: Vec<bool>,
    near: Vec<(u32, u32)>,
    /// Faces that are walls of the box.
    is_wall: [Vec<bool>; D],
}

/// Open parts of faces and cells, and the flux that moving walls push into the fluid.
#[derive(Clone, Debug)]
pub struct OpenFractions<const D: usize> {
    /// Open fraction of the lower face of each cell, across each axis.
    pub open: [Vec<f64>; D],
    /// Open fraction of each cell.
    pub volume: Vec<f64>,
    /// Flux through the surfaces of bodies with prescribed motion out of each cell, as the sum of
    /// its faces' fractions times velocities [m/s].
    pub pushed: Vec<f64>,
    /// The same of free bodies, with the velocities that they have.
    pub pushed_by_free: Vec<f64>,
    /// Number of the solid that holds the centre of each face; [`NONE`] if none does. Solids at
    /// rest come first.
    pub holder: [Vec<u32>; D],
    /// Free bodies.
    pub free: BorderCells<D>,
    /// Solids at rest, then bodies that move as prescribed.
    pub held: BorderCells<D>,
    /// Solids that never move.
    pub at_rest: Vec<RigidBody<D>>,
    /// Covered shares of the box's own walls: axis, side, cell and share.
    pub on_walls: Vec<(u8, u8, u32, f64)>,
    walls_at_rest: usize,
    /// True if the last step's fractions are not those of the step before.
    pub has_changed: bool,
    /// Cells that moving bodies come near: only there fractions differ from those at rest.
    touched: Vec<u32>,
    is_near: Vec<bool>,
    /// Pairs of a cell and a solid near it, sorted: solids at rest.
    near: Vec<(u32, u32)>,
    /// By what the bodies are known that have these numbers, in their order.
    placed: Vec<u64>,
    rest: AtRest<D>,
    is_closed: [[bool; 2]; D],
}

impl<const D: usize> OpenFractions<D> {
    /// Of a box whose faces are closed, but where it is periodic or `is_open` (axis, side) says,
    /// with solids that never move.
    pub fn new(
        grid: &StaggeredGrid<D>,
        is_open: impl Fn(usize, usize) -> bool,
        solids: Vec<RigidBody<D>>,
    ) -> Self {
        let is_closed: [[bool; 2]; D] =
            std::array::from_fn(|a| [0, 1].map(|side| !(grid.periodic[a] || is_open(a, side))));
        let mut open: [Vec<f64>; D] = std::array::from_fn(|_| vec![0.0; grid.stored]);
        let mut volume = vec![0.0; grid.stored];
        let mut is_wall: [Vec<bool>; D] = std::array::from_fn(|_| vec![false; grid.stored]);
        for at in grid.all() {
            let place = grid.place(at);
            volume[place] = 1.0;
            for a in 0..D {
                let is_highest = at[a] + 1 == grid.cells[a] as isize;
                is_wall[a][place] = at[a] == 0 && is_closed[a][0];
                open[a][place] = if is_wall[a][place] { 0.0 } else { 1.0 };
                if is_highest {
                    let beyond = place + grid.stride[a];
                    is_wall[a][beyond] = is_closed[a][1];
                    open[a][beyond] = if is_closed[a][1] { 0.0 } else { 1.0 };
                }
            }
        }
        let none: [Vec<u32>; D] = std::array::from_fn(|_| vec![NONE; grid.stored]);
        let rest = AtRest {
            open: open.clone(),
            volume: volume.clone(),
            holder: none.clone(),
            is_near: vec![false; grid.stored],
            near: Vec::new(),
            is_wall,
        };
        let mut own = Self {
            open,
            volume,
            pushed: vec![0.0; grid.stored],
            pushed_by_free: vec![0.0; grid.stored],
            holder: none,
            free: BorderCells::default(),
            held: BorderCells::default(),
            at_rest: Vec::new(),
            on_walls: Vec::new(),
            walls_at_rest: 0,
            has_changed: true,
            touched: Vec::new(),
            is_near: vec![false; grid.stored],
            near: Vec::new(),
            placed: Vec::new(),
            rest,
            is_closed,
        };
        own.free.clear();
        own.held.clear();
        for (number, solid) in solids.iter().enumerate() {
            own.place_body(grid, solid, number as u32, 1.0);
        }
        own.near.sort_unstable();
        own.near.dedup();
        own.fill_ghosts(grid);
        own.rest.open.clone_from(&own.open);
        own.rest.volume.clone_from(&own.volume);
        own.rest.holder.clone_from(&own.holder);
        own.rest.is_near.clone_from(&own.is_near);
        own.rest.near = std::mem::take(&mut own.near);
        own.touched.clear();
        own.walls_at_rest = own.on_walls.len();
        own.at_rest = solids;
        own
    }

    /// Takes the bodies in, as the free ones are coupled to the pressure; `full` is the mass of a
    /// cell full of fluid [kg].
    pub fn place_bodies(&mut self, grid: &StaggeredGrid<D>, bodies: &[RigidBody<D>], full: f64) {
        self.has_changed = !self.touched.is_empty();
        for &place in &self.touched {
            let place = place as usize;
            for a in 0..D {
                self.open[a][place] = self.rest.open[a][place];
                self.holder[a][place] = self.rest.holder[a][place];
            }
            self.volume[place] = self.rest.volume[place];
            self.pushed[place] = 0.0;
            self.pushed_by_free[place] = 0.0;
            self.is_near[place] = self.rest.is_near[place];
        }
        self.touched.clear();
        self.near.clear();
        self.free.clear();
        self.held.truncate(self.at_rest.len());
        self.on_walls.truncate(self.walls_at_rest);
        for (number, body) in bodies.iter().enumerate() {
            self.place_body(grid, body, (self.at_rest.len() + number) as u32, full);
        }
        self.has_changed |= !self.touched.is_empty();
        self.near.sort_unstable();
        self.placed.clear();
        self.placed.extend(bodies.iter().map(|body| body.id));
        self.fill_ghosts(grid);
    }

    /// Gives the bodies near cells the numbers that they have in another list, before the bodies of
    /// that list are placed: those that went are near no cell any more, and those that came not yet.
    pub fn follow(&mut self, bodies: &[RigidBody<D>]) {
        if self.placed.iter().eq(bodies.iter().map(|body| &body.id)) {
            return;
        }
        let first = self.at_rest.len() as u32;
        let mut numbers = BTreeMap::new();
        for (number, body) in (first..).zip(bodies) {
            numbers.entry(body.id).or_insert(number);
        }
        self.near.retain_mut(|(_, number)| {
            let id = self.placed[(*number - first) as usize];
            let now = numbers.get(&id).copied();
            *number = now.unwrap_or(NONE);
            now.is_some()
        });
        self.near.sort_unstable();
        self.placed.clear();
        self.placed.extend(bodies.iter().map(|body| body.id));
    }

    fn fill_ghosts(&mut self, grid: &StaggeredGrid<D>) {
        grid.ghosts.fill(&mut self.volume);
        for a in 0..D {
            grid.ghosts.fill(&mut self.open[a]);
            grid.ghosts.fill(&mut self.holder[a]);
        }
    }

    /// True if a face of the box is a wall: neither open, nor joined to the opposite one.
    pub fn is_closed(&self, axis: usize, side: usize) -> bool {
        self.is_closed[axis][side]
    }

    /// True if a solid comes as near to a cell as particles may.
    #[inline]
    pub fn is_near_a_body(&self, place: usize) -> bool {
        self.is_near[place]
    }

    /// Numbers of the solids near a cell.
    #[inline]
    pub fn near(&self, place: usize) -> impl Iterator<Item = usize> + '_ {
        let cell = place as u32;
        let of = |near: &[(u32, u32)]| near.partition_point(|pair| pair.0 < cell);
        let (first, second) = (of(&self.rest.near), of(&self.near));
        let at_rest = self.rest.near[first..].iter().take_while(move |pair| pair.0 == cell);
        let moving = self.near[second..].iter().take_while(move |pair| pair.0 == cell);
        at_rest.chain(moving).map(|pair| pair.1 as usize)
    }

    /// Pairs of a cell and the number of a solid that moves near it, by cell.
    pub fn near_solids(&self) -> &[(u32, u32)] {
        &self.near
    }

    /// Pairs of a cell and the number of a solid at rest near it, by cell.
    pub fn near_rest(&self) -> &[(u32, u32)] {
        &self.rest.near
    }

    /// A solid by its number.
    #[inline]
    pub fn solid<'a>(&'a self, bodies: &'a [RigidBody<D>], number: usize) -> &'a RigidBody<D> {
        let moving = number.checked_sub(self.at_rest.len());
        moving.map_or_else(|| &self.at_rest[number], |number| &bodies[number])
    }

    /// A solid by its number, and a point as that solid sees it: where axes wrap around, the image
    /// that is nearest to it.
    #[inline]
    pub fn seen_by<'a>(
        &'a self,
        grid: &StaggeredGrid<D>,
        bodies: &'a [RigidBody<D>],
        number: usize,
        point: [f64; D],
    ) -> (&'a RigidBody<D>, [f64; D]) {
        let body = self.solid(bodies, number);
        if !grid.is_periodic() {
            return (body, point);
        }
        (body, grid.nearest_image(point, body.bounds()))
    }

    /// True if a stored cell is in the box, and not wholly in a solid at rest.
    #[inline]
    pub fn is_cell(&self, place: usize) -> bool {
        self.rest.volume[place] > 0.0
    }

    /// True if the lower face of a cell, across an axis, is a wall of the box.
    #[inline]
    pub fn is_wall(&self, axis: usize, place: usize) -> bool {
        self.rest.is_wall[axis][place]
    }

    /// True if a wall of the box, or a solid at rest, closes the face between a cell and the one
    /// `below` it across an axis.
    #[inline]
    pub fn is_shut(&self, axis: usize, place: usize, below: usize) -> bool {
        self.rest.open[axis][place] == 0.0 && (self.is_cell(place) || self.is_cell(below))
    }

    fn place_body(&mut self, grid: &StaggeredGrid<D>, body: &RigidBody<D>, number: u32, full: f64) {
        let bounds = body.bounds();
        // Cells beyond an axis that wraps around stand for others, unless the body is that long.
        let wraps = |a: usize| {
            let length = grid.cells[a] as f64 * grid.spacing;
            grid.periodic[a] && bounds[1][a] - bounds[0][a] < length * (1.0 - 2.0 * MARGIN)
        };
        let reach = |a: usize, end: usize| {
            let margin = [-1.0, 1.0][end] * MARGIN * grid.spacing;
            let along = ((bounds[end][a] + margin - grid.origin[a]) / grid.spacing).floor();
            let most = grid.cells[a] as f64;
            match (wraps(a), grid.periodic[a]) {
                (true, _) => along as isize,
                (false, true) => along.clamp(0.0, most - 1.0) as isize,
                (false, false) => along.clamp(-1.0, most) as isize,
            }
        };
        let first: [isize; D] = std::array::from_fn(|a| reach(a, 0));
        let last: [isize; D] = std::array::from_fn(|a| {
            let end = reach(a, 1);
            if wraps(a) { end.min(first[a] + grid.cells[a] as isize - 1) } else { end }
        });
        let counts: [usize; D] = std::array::from_fn(|a| (last[a] - first[a] + 1) as usize);
        for mut k in 0..counts.iter().product::<usize>() {
            let at: [isize; D] = std::array::from_fn(|a| {
                let along = k % counts[a];
                k /= counts[a];
                first[a] + along as isize
            });
            self.close(grid, body, number, at);
        }
        let volume = body.volume() / grid.cell_volume();
        let border = if body.is_free() { &mut self.free } else { &mut self.held };
        border.coupling.close_body(body.mobility(full), volume);
    }

    /// Closes what a body covers of the lower faces of a cell. Gives what the cell exerts on the
    /// body, and the mean of the covered parts of its two faces across each axis.
    fn close_faces(
        &mut self,
        grid: &StaggeredGrid<D>,
        body: &RigidBody<D>,
        number: u32,
        (at, is_inside): ([isize; D], bool),
    ) -> (Wrench, [f64; D]) {
        let h = grid.spacing;
        let (place, centre) = (grid.place(grid.wrapped(at)), grid.centre(at));
        let lower_corner = centre.map(|x| x - 0.5 * h);
        let mut wrench: Wrench = [0.0; 6];
        let mut faces = [0.0; D];
        for a in 0..D {
            if body.holds(grid.face_centre(a, at)) {
                self.holder[a][place] = number;
            }
            let (mut upper_corner, mut beyond) = (lower_corner, centre);
            upper_corner[a] += h;
            beyond[a] += h;
            let mut below = centre;
            below[a] -= h;
            let lower = covered(body, a, lower_corner, [below, centre], h);
            let upper = covered(body, a, upper_corner, [centre, beyond], h);
            self.open[a][place] = left(self.open[a][place], lower.0);
            // At closed faces of the box nothing presses on the body from beyond.
            let is_wall = [
                at[a] == 0 && self.is_closed[a][0],
                at[a] + 1 == grid.cells[a] as isize && self.is_closed[a][1],
            ];
            for (side, (share, middle)) in [lower, upper].into_iter().enumerate() {
                if is_wall[side] {
                    if is_inside && share > 0.0 {
                        self.on_walls.push((a as u8, side as u8, place as u32, share));
                    }
                    continue;
                }
                let sign = [-1.0, 1.0][side];
                wrench[a] += sign * share;
                faces[a] += 0.5 * share;
                if !body.is_round() {
                    let arm = padded::<D>(std::array::from_fn(|k| middle[k] - body.centre[k]));
                    let unit = std::array::from_fn(|k| if k == a { sign * share } else { 0.0 });
                    let turn = cross(arm, unit);
                    (0..3).for_each(|k| wrench[3 + k] += turn[k]);
                }
            }
        }
        (wrench, faces)
    }

    /// Closes what a body covers of a cell and its lower faces, and notes what the cell exerts on
    /// the body.
    fn close(&mut self, grid: &StaggeredGrid<D>, body: &RigidBody<D>, number: u32, at: [isize; D]) {
        let h = grid.spacing;
        let centre = grid.centre(at);
        // No part of a cell is farther from its centre than this.
        let far = 0.5 * h * (D as f64).sqrt() + MARGIN * h;
        if body.height(centre, 2.0 * far).is_none_or(|(height, _)| height > far)
            && !body.holds(centre)
        {
            return;
        }
        let place = grid.place(grid.wrapped(at));
        self.touched.push(place as u32);
        self.is_near[place] = true;
        self.near.push((place as u32, number));
        let lower_corner = centre.map(|x| x - 0.5 * h);
        let is_inside =
            (0..D).all(|a| grid.periodic[a] || (at[a] >= 0 && at[a] < grid.cells[a] as isize));
        let (wrench, faces) = self.close_faces(grid, body, number, (at, is_inside));
        if !is_inside {
            return;
        }
        let share = body.cell(lower_corner, h);
        self.volume[place] = left(self.volume[place], share);
        if wrench == [0.0; 6] {
            return;
        }
        let border = if body.is_free() { &mut self.free } else { &mut self.held };
        border.coupling.cells.push(place as u32);
        border.coupling.wrenches.push(wrench);
        border.beyond_faces.push(faces.map(|faces| share - faces));
        let motion = body.motion();
        let pushed = (0..6).map(|k| wrench[k] * motion[k]).sum::<f64>();
        if body.is_free() {
            self.pushed_by_free[place] += pushed;
        } else {
            self.pushed[place] += pushed;
        }
    }
}

/// What a covered share leaves of a fraction.
#[inline]
fn left(fraction: f64, covered: f64) -> f64 {
    let left = fraction - covered;
    if left < LEAST { 0.0 } else { left }
}

/// Share of a face that a body covers, and the middle of what is covered. Of a face between two
/// cells that a thin wall parts it is the whole. `corner` is the face's lower corner, `beside` are
/// the centres of its two cells.
fn covered<const D: usize>(
    body: &RigidBody<D>,
    axis: usize,
    corner: [f64; D],
    beside: [[f64; D]; 2],
    h: f64,
) -> (f64, [f64; D]) {
    let [below, above] = beside;
    if body.entered(below, above, h).is_some() && !body.holds(below) && !body.holds(above) {
        return (1.0, std::array::from_fn(|a| 0.5 * (below[a] + above[a])));
    }
    let covered = body.face(axis, corner, h);
    (covered.share, covered.centre)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A body in a uniform stream of its own velocity makes no divergence, and feels no force of a
    /// uniform pressure.
    #[test]
    fn a_body_that_goes_with_the_stream_leaves_it_alone() {
        let grid = StaggeredGrid::<3>::new([12; 3], 0.1, [0.0; 3], [false; 3]);
        let mut fractions = OpenFractions::new(&grid, |_, _| false, Vec::new());
        let radius = 0.33_f64;
        let body = RigidBody::ball([0.61, 0.53, 0.57], radius).with_mass(1.0);
        fractions.place_bodies(&grid, std::slice::from_ref(&body), 1.0);
        let coupling = fractions.free.coupling.clone();
        let stream = [0.3, -0.2, 0.5];
        let mut divergence = vec![0.0; grid.stored];
        for at in grid.all() {
            let place = grid.place(at);
            if at.iter().any(|&x| x == 0 || x == 11) {
                continue;
            }
            for a in 0..3 {
                divergence[place] += stream[a]
                    * (fractions.open[a][place + grid.stride[a]] - fractions.open[a][place]);
            }
        }
        let velocity = [stream[0], stream[1], stream[2], 0.0, 0.0, 0.0];
        coupling.add_flux(0, &velocity, &mut divergence, |_| 1.0);
        assert!(divergence.iter().all(|d| d.abs() < 1e-14));
        let force = coupling.wrench(0, &vec![1.0; grid.stored]);
        assert!(force.iter().all(|f| f.abs() < 1e-13), "{force:?}");
        // Hydrostatic pressure lifts it by its volume.
        let pressure: Vec<f64> =
            (0..grid.stored).map(|place| -grid.centre(grid.cell_at(place))[2] / 0.1).collect();
        let lift = coupling.wrench(0, &pressure)[2] * grid.cell_volume();
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        assert!((lift / volume - 1.0).abs() < 0.01, "{}", lift / volume);
        let covered: f64 = fractions.volume.iter().map(|v| v * 1e-3).sum();
        assert!((1.728 - covered - volume).abs() < 1e-4 * volume);
    }
}
