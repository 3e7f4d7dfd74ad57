//! Open fractions of faces and cells.
//!
//! Fractions that bodies close add up: bodies do not overlap but where they touch. What would be
//! more than a whole face is the whole face.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::pressure::body_coupling::{BodyCoupling, Wrench};
use crate::solids::ball_overlap::{disc_in_rectangle, segment_in_ball, sphere_in_box};
use crate::solids::rigid_body::RigidBody;
use std::f64::consts::PI;

/// Distance that particles keep from bodies and walls, in edges of cells.
pub const MARGIN: f64 = 1e-3;

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
    /// Of each entry of the coupling, covered part of the cell less the mean of the covered parts
    /// of its two faces across each axis.
    pub beyond_faces: Vec<[f64; D]>,
    /// Cells that bodies come near: only there fractions differ from those of the empty box.
    touched: Vec<u32>,
    is_touched: Vec<bool>,
    empty: [Vec<f64>; D],
    empty_volume: Vec<f64>,
}

impl<const D: usize> OpenFractions<D> {
    /// Of a box whose faces are closed, but where it is periodic or `is_open` (axis, side) says.
    pub fn new(grid: &StaggeredGrid<D>, is_open: impl Fn(usize, usize) -> bool) -> Self {
        let mut open: [Vec<f64>; D] = std::array::from_fn(|_| vec![0.0; grid.stored]);
        let mut volume = vec![0.0; grid.stored];
        for at in grid.all() {
            let place = grid.place(at);
            volume[place] = 1.0;
            for a in 0..D {
                let is_lowest = at[a] == 0;
                let is_highest = at[a] + 1 == grid.cells[a] as isize;
                let is_free = |side| grid.periodic[a] || is_open(a, side);
                open[a][place] = if is_lowest && !is_free(0) { 0.0 } else { 1.0 };
                if is_highest {
                    open[a][place + grid.stride[a]] = if is_free(1) { 1.0 } else { 0.0 };
                }
            }
        }
        Self {
            empty: open.clone(),
            empty_volume: volume.clone(),
            open,
            volume,
            pushed: vec![0.0; grid.stored],
            beyond_faces: Vec::new(),
            touched: Vec::new(),
            is_touched: vec![false; grid.stored],
        }
    }

    /// Takes the bodies in. Free ones are coupled to the pressure: `coupling` becomes theirs, in
    /// their order; `cell_mass` is the mass of a cell full of fluid [kg].
    pub fn place_bodies(
        &mut self,
        grid: &StaggeredGrid<D>,
        bodies: &[RigidBody<D>],
        cell_mass: f64,
        coupling: &mut BodyCoupling,
    ) {
        for &place in &self.touched {
            let place = place as usize;
            for a in 0..D {
                self.open[a][place] = self.empty[a][place];
            }
            self.volume[place] = self.empty_volume[place];
            self.pushed[place] = 0.0;
            self.is_touched[place] = false;
        }
        self.touched.clear();
        coupling.clear();
        self.beyond_faces.clear();
        for body in bodies {
            self.place_body(grid, body, cell_mass, coupling);
        }
    }

    /// True if a body comes as near to a cell as particles may.
    #[inline]
    pub fn is_near_a_body(&self, place: usize) -> bool {
        self.is_touched[place]
    }

    /// True if the face between a cell and the one `below` it across an axis is a wall of the box.
    #[inline]
    pub fn is_wall(&self, axis: usize, place: usize, below: usize) -> bool {
        let is_cell = |place: usize| self.empty_volume[place] > 0.0;
        self.empty[axis][place] == 0.0 && (is_cell(place) || is_cell(below))
    }

    fn place_body(
        &mut self,
        grid: &StaggeredGrid<D>,
        body: &RigidBody<D>,
        cell_mass: f64,
        coupling: &mut BodyCoupling,
    ) {
        let reach = |a: usize, side: f64| {
            let radius = body.radius + MARGIN * grid.spacing;
            let along = (body.centre[a] + side * radius - grid.origin[a]) / grid.spacing;
            (along.floor() as isize).clamp(-1, grid.cells[a] as isize)
        };
        let first: [isize; D] = std::array::from_fn(|a| reach(a, -1.0));
        let last: [isize; D] = std::array::from_fn(|a| reach(a, 1.0));
        let counts: [usize; D] = std::array::from_fn(|a| (last[a] - first[a] + 1) as usize);
        for mut number in 0..counts.iter().product::<usize>() {
            let at: [isize; D] = std::array::from_fn(|a| {
                let along = number % counts[a];
                number /= counts[a];
                first[a] + along as isize
            });
            self.close(grid, body, at, coupling);
        }
        if let Some(mass) = body.mass {
            let mut mobility = [[0.0; 6]; 6];
            for a in 0..D {
                mobility[a][a] = cell_mass / mass;
            }
            let volume = match D {
                2 => PI * body.radius.powi(2),
                _ => 4.0 / 3.0 * PI * body.radius.powi(3),
            };
            coupling.close_body(mobility, volume / grid.cell_volume());
        }
    }

    /// Closes what a body covers of a cell and its lower faces, and notes what the cell exerts on
    /// the body.
    fn close(
        &mut self,
        grid: &StaggeredGrid<D>,
        body: &RigidBody<D>,
        at: [isize; D],
        coupling: &mut BodyCoupling,
    ) {
        let place = grid.place(at);
        self.touched.push(place as u32);
        self.is_touched[place] = true;
        let is_inside = (0..D).all(|a| at[a] >= 0 && at[a] < grid.cells[a] as isize);
        let mut wrench: Wrench = [0.0; 6];
        let mut faces = [0.0; D];
        for a in 0..D {
            let lower = closed_face(grid, body, a, at);
            self.open[a][place] = (self.open[a][place] - lower).max(0.0);
            let mut beyond = at;
            beyond[a] += 1;
            // At closed faces of the box nothing presses on the body from beyond.
            let lower = lower * self.empty[a][place];
            let upper = closed_face(grid, body, a, beyond) * self.empty[a][place + grid.stride[a]];
            wrench[a] = upper - lower;
            faces[a] = 0.5 * (upper + lower);
        }
        if !is_inside {
            return;
        }
        let covered = closed_cell(grid, body, at);
        self.volume[place] = (self.volume[place] - covered).max(0.0);
        if wrench == [0.0; 6] {
            return;
        }
        if body.mass.is_some() {
            coupling.cells.push(place as u32);
            coupling.wrenches.push(wrench);
            self.beyond_faces.push(faces.map(|faces| covered - faces));
        } else {
            self.pushed[place] += (0..D).map(|a| wrench[a] * body.velocity[a]).sum::<f64>();
        }
    }
}

/// Fraction of the lower face of a cell that a body covers.
fn closed_face<const D: usize>(
    grid: &StaggeredGrid<D>,
    body: &RigidBody<D>,
    axis: usize,
    at: [isize; D],
) -> f64 {
    let h = grid.spacing;
    let centre = grid.face_centre(axis, at);
    let from: [f64; D] = std::array::from_fn(|a| centre[a] - body.centre[a]);
    let distance2 = from[axis] * from[axis];
    let across = |k: usize| (0..D).filter(|&a| a != axis).nth(k).map_or(0.0, |a| from[a]);
    match D {
        2 => {
            let middle = across(0);
            segment_in_ball(body.radius, distance2, middle - 0.5 * h, middle + 0.5 * h) / h
        }
        _ => {
            let radius2 = body.radius * body.radius - distance2;
            if radius2 <= 0.0 {
                return 0.0;
            }
            let lower = [across(0) - 0.5 * h, across(1) - 0.5 * h];
            disc_in_rectangle(radius2.sqrt(), lower, lower.map(|x| x + h)) / (h * h)
        }
    }
}

/// Fraction of a cell that a body covers.
fn closed_cell<const D: usize>(
    grid: &StaggeredGrid<D>,
    body: &RigidBody<D>,
    at: [isize; D],
) -> f64 {
    let h = grid.spacing;
    let centre = grid.centre(at);
    let lower: [f64; D] = std::array::from_fn(|a| centre[a] - 0.5 * h - body.centre[a]);
    match D {
        2 => {
            let lower = [lower[0], lower[1]];
            disc_in_rectangle(body.radius, lower, lower.map(|x| x + h)) / (h * h)
        }
        _ => {
            let lower = [lower[0], lower[1], lower[D - 1]];
            sphere_in_box(body.radius, lower, lower.map(|x| x + h)) / (h * h * h)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body in a uniform stream of its own velocity makes no divergence, and feels no force of a
    /// uniform pressure.
    #[test]
    fn a_body_that_goes_with_the_stream_leaves_it_alone() {
        let grid = StaggeredGrid::<3>::new([12; 3], 0.1, [0.0; 3], [false; 3]);
        let mut fractions = OpenFractions::new(&grid, |_, _| false);
        let body = RigidBody {
            centre: [0.61, 0.53, 0.57],
            radius: 0.33,
            velocity: [0.0; 3],
            mass: Some(1.0),
            force: [0.0; 3],
        };
        let mut coupling = BodyCoupling::default();
        fractions.place_bodies(&grid, std::slice::from_ref(&body), 1.0, &mut coupling);
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
        let volume = 4.0 / 3.0 * PI * body.radius.powi(3);
        assert!((lift / volume - 1.0).abs() < 0.01, "{}", lift / volume);
        let covered: f64 = fractions.volume.iter().map(|v| v * 1e-3).sum();
        assert!((1.728 - covered - volume).abs() < 1e-4 * volume);
    }
}
