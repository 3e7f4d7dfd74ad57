//! Faces of the box that fluid passes: it enters, leaves, and waves go out.
//!
//! A face with a velocity gives the flux of its cells. A face with a pressure holds `q` there, half
//! a cell from the centre of the cell inside; where waves leave, the pressure rises with the outward
//! velocity as in a long wave that goes out, `p' = rho c (u - mean u)` with `c = sqrt(g depth)`
//! (Schaeffer & Klopman, *J. Waterway Port Coastal Ocean Eng.* 126 (2000) 88):
//!
//! ```text
//! u = (u* + 2 (q - q_face) + 2 k mean u) / (1 + 2 k)        k = c dt / h,   u outward
//! ```
//!
//! Implicit in `q`, so no step is too long for it. Particles that pass are gone. Where fluid enters,
//! layers of particles follow each other at the distance that they have at the start.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::from_grid::FaceVelocity;
use crate::particles::particle_arrays::ParticleArrays;
use crate::pressure::stencil::Stencil;
use crate::solids::open_fractions::OpenFractions;
use crate::solver::extrapolation::FaceState;
use crate::solver::pic_settings::PicSettings;
use tremie_state::{StateError, StateExchange};

/// Times that a long wave crosses the box while the mean outflow of a face is found.
const MEMORY: f64 = 10.0;

/// Condition at a face that fluid passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaceFlow<const D: usize> {
    /// A velocity.
    Velocity {
        /// Everywhere, or in the middle of the face [m/s].
        velocity: [f64; D],
        /// True if it falls to zero at the edges, as the product of `4 s (1 - s)` along each axis
        /// of the face that does not wrap around.
        is_parabolic: bool,
    },
    /// A pressure.
    Pressure {
        /// At the level [Pa].
        pressure: f64,
        /// True if waves leave; else they are thrown back.
        absorbs: bool,
    },
}

/// A face of the box that fluid passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenFace<const D: usize> {
    /// Axis across it.
    pub axis: usize,
    /// 0 for the lower face across the axis, 1 for the upper one.
    pub side: usize,
    /// What holds there.
    pub flow: FaceFlow<D>,
    /// Height of the surface beyond it, on the axis along which gravity acts [m]. Without one, the
    /// fluid beyond reaches up to the end of the box.
    pub level: Option<f64>,
}

/// A cell at an open face.
#[derive(Clone, Copy, Debug)]
struct BorderCell {
    cell: usize,
    face: usize,
    /// Part of the face below the level.
    below_level: f64,
    /// Factor of the velocity's profile.
    profile: f64,
    /// Depth of the face below the level [m].
    depth: f64,
    /// Outward velocity before the pressure's gradient is taken [m/s].
    tentative: f64,
}

/// A place at which particles enter.
#[derive(Clone, Copy, Debug)]
struct Entry<const D: usize> {
    /// Number of its cell.
    cell: usize,
    /// On the face [m].
    at: [f64; D],
    profile: f64,
    /// Distance that fluid has entered since the last particle, less half of that between particles
    /// [m].
    entered: f64,
}

/// An open face, and what goes on there.
#[derive(Clone, Debug)]
struct OpenBorder<const D: usize> {
    face: OpenFace<D>,
    cells: Vec<BorderCell>,
    entries: Vec<Entry<D>>,
    /// Factor over time of velocity or pressure.
    factor: f64,
    /// Speed of the waves that leave; 0 if none do [m/s].
    wave_speed: f64,
    /// Mean outward velocity [m/s].
    mean: f64,
}

/// All open faces of a box.
#[derive(Clone, Debug)]
pub struct OpenFaces<const D: usize> {
    borders: Vec<OpenBorder<D>>,
    /// Distance between particles at the start [m].
    step: f64,
    density: f64,
    weight: f64,
    /// Particles that entered, and that left.
    passed: [u64; 2],
}

impl<const D: usize> OpenFace<D> {
    fn is_lower(&self) -> bool {
        self.side == 0
    }

    /// 1 where outward is along the axis, -1 where it is against it.
    fn outward(&self) -> f64 {
        if self.is_lower() { -1.0 } else { 1.0 }
    }
}

impl<const D: usize> OpenFaces<D> {
    /// Of a box with what solids at rest leave open.
    pub fn new(
        grid: &StaggeredGrid<D>,
        fractions: &OpenFractions<D>,
        settings: &PicSettings<D>,
        faces: Vec<OpenFace<D>>,
    ) -> Self {
        let gravity = settings.gravity;
        let up = (0..D).max_by(|&a, &b| gravity[a].abs().total_cmp(&gravity[b].abs())).unwrap_or(0);
        let weight = gravity[up].abs();
        let step = grid.spacing / settings.particles_per_axis as f64;
        let border = |face: OpenFace<D>| {
            let level = face.level.unwrap_or(match gravity[up] > 0.0 {
                true => grid.origin[up],
                false => grid.end()[up],
            });
            // Depth of a point below the level.
            let depth =
                |at: [f64; D]| (level - at[up]) * if gravity[up] > 0.0 { -1.0 } else { 1.0 };
            let cells = border_cells(grid, fractions, &face, depth, face.level.map(|_| up));
            let deepest = cells.iter().map(|cell| cell.depth).fold(0.0, f64::max);
            let absorbs = matches!(face.flow, FaceFlow::Pressure { absorbs: true, .. });
            let wave_speed = if absorbs { (weight * deepest).sqrt() } else { 0.0 };
            let entries = entries(grid, &face, &cells, settings.particles_per_axis, |at| {
                face.level.is_none() || depth(at) > 0.0
            });
            OpenBorder { face, cells, entries, factor: 1.0, wave_speed, mean: 0.0 }
        };
        Self {
            borders: faces.into_iter().map(border).collect(),
            step,
            density: settings.density,
            weight,
            passed: [0; 2],
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.borders.is_empty()
    }

    /// Sets the factors over time of velocities and pressures, in the order of the faces.
    pub fn set_factors(&mut self, factors: impl IntoIterator<Item = f64>) {
        for (border, factor) in self.borders.iter_mut().zip(factors) {
            border.factor = factor;
        }
    }

    /// Particles that entered, and that left, since the start.
    pub fn passed(&self) -> [u64; 2] {
        self.passed
    }

    /// Lower and upper corner of the box in which particles may be while they move, given that of
    /// walls [m].
    pub fn reach(&self, h: f64, [mut lower, mut upper]: [[f64; D]; 2]) -> [[f64; D]; 2] {
        for OpenBorder { face, .. } in &self.borders {
            let end = if face.is_lower() { &mut lower } else { &mut upper };
            // Ghosts have room for less than a cell.
            end[face.axis] += 0.9 * h * face.outward();
        }
        [lower, upper]
    }

    /// Gives faces with a velocity theirs.
    pub fn prescribe(&self, velocity: &mut FaceVelocity<D>) {
        for border in &self.borders {
            if matches!(border.face.flow, FaceFlow::Velocity { .. }) {
                for cell in &border.cells {
                    velocity[border.face.axis][cell.face] = border.given(cell);
                }
            }
        }
    }

    /// Adds open faces to the pressure's equations, whose right side has the velocities of all
    /// faces. True if a pressure is given anywhere.
    pub fn add_to_equations(
        &mut self,
        (dt, h): (f64, f64),
        open: &[Vec<f64>; D],
        velocity: &FaceVelocity<D>,
        is_wet: impl Fn(usize) -> bool,
        stencil: &mut Stencil<f64, D>,
        right: &mut [f64],
    ) -> bool {
        let head = self.density * self.weight;
        let unit = dt / (self.density * h);
        let mut any = false;
        for border in &mut self.borders {
            let axis = border.face.axis;
            let outward = border.face.outward();
            for k in 0..border.cells.len() {
                let BorderCell { cell, face, .. } = border.cells[k];
                border.cells[k].tentative = outward * velocity[axis][face];
                let share = open[axis][face];
                if !is_wet(cell) || share == 0.0 {
                    continue;
                }
                let own = &border.cells[k];
                let Some(flow) = border.response((dt, h), own, head, unit) else {
                    // Above its level a face with a velocity is closed.
                    right[cell] += share * (1.0 - own.below_level) * own.tentative;
                    continue;
                };
                stencil.diagonal[cell] += share * flow.per_q;
                right[cell] -= share * (flow.at_zero - own.tentative);
                any = true;
            }
        }
        any
    }

    /// Velocities of the open faces across an axis, once the pressure is known.
    pub fn set_velocities(
        &self,
        axis: usize,
        (dt, h): (f64, f64),
        (q, is_wet): (&[f64], impl Fn(usize) -> bool),
        velocity: &mut [f64],
        state: &mut [FaceState],
    ) {
        let head = self.density * self.weight;
        let unit = dt / (self.density * h);
        for border in self.borders.iter().filter(|border| border.face.axis == axis) {
            let outward = border.face.outward();
            for cell in &border.cells {
                match border.response((dt, h), cell, head, unit) {
                    // Above its level the face tells the fluid beside it nothing.
                    None if cell.below_level == 0.0 => state[cell.face] = FaceState::Unknown,
                    None => {
                        velocity[cell.face] = border.given(cell);
                        state[cell.face] = FaceState::Fluid;
                    }
                    Some(flow) if is_wet(cell.cell) => {
                        velocity[cell.face] = outward * (flow.at_zero + flow.per_q * q[cell.cell]);
                        state[cell.face] = FaceState::Fluid;
                    }
                    Some(_) => velocity[cell.face] = outward * cell.tentative,
                }
            }
        }
    }

    /// Takes from the open faces a displacement that is the particles' alone.
    pub fn hold_still(&self, displacement: &mut FaceVelocity<D>) {
        for border in &self.borders {
            border.cells.iter().for_each(|cell| displacement[border.face.axis][cell.face] = 0.0);
        }
    }

    /// Follows the mean outflow of faces where waves leave.
    pub fn follow(
        &mut self,
        dt: f64,
        grid: &StaggeredGrid<D>,
        velocity: &FaceVelocity<D>,
        is_wet: impl Fn(usize) -> bool,
    ) {
        for border in self.borders.iter_mut().filter(|border| border.wave_speed > 0.0) {
            let axis = border.face.axis;
            let wet = border.cells.iter().filter(|cell| is_wet(cell.cell));
            let (sum, count) =
                wet.fold((0.0, 0), |(sum, n), cell| (sum + velocity[axis][cell.face], n + 1));
            let now = border.face.outward() * sum / f64::from(count.max(1));
            let length = grid.cells[axis] as f64 * grid.spacing;
            let share = (dt * border.wave_speed / (MEMORY * length)).min(1.0);
            border.mean += share * (now - border.mean);
        }
    }

    /// Marks faces with a velocity as the fluid's, as every step leaves them, near particles or not.
    pub fn mark(&self, state: &mut [Vec<FaceState>; D]) {
        for border in &self.borders {
            if matches!(border.face.flow, FaceFlow::Velocity { .. }) {
                for cell in border.cells.iter().filter(|cell| cell.below_level > 0.0) {
                    state[border.face.axis][cell.face] = FaceState::Fluid;
                }
            }
        }
    }

    /// Keeps what has passed and what the faces remember, or puts it back. Factors over time are not
    /// kept.
    ///
    /// # Errors
    /// A state of other faces.
    pub fn keep(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("passed", &mut self.passed)?;
        for (number, border) in self.borders.iter_mut().enumerate() {
            state.within(&format!("face{number}"), |state| border.exchange(state))?;
        }
        Ok(())
    }

    /// Removes the particles that passed, and lets others enter.
    pub fn exchange(
        &mut self,
        dt: f64,
        grid: &StaggeredGrid<D>,
        velocity: &FaceVelocity<D>,
        particles: &mut ParticleArrays<D>,
        is_free: impl Fn([f64; D]) -> bool,
    ) {
        if self.is_empty() {
            return;
        }
        let (lower, upper) = (grid.origin, grid.end());
        let is_inside = |at: [f64; D]| (0..D).all(|a| lower[a] <= at[a] && at[a] <= upper[a]);
        let before = particles.len();
        particles.retain(is_inside);
        self.passed[1] += (before - particles.len()) as u64;
        for border in &mut self.borders {
            self.passed[0] += border.enter((dt, self.step), velocity, particles, &is_free);
        }
    }
}

/// Outward velocity of a face: `at_zero + per_q q`, with the `q` of the cell inside.
#[derive(Clone, Copy)]
struct FaceResponse {
    at_zero: f64,
    per_q: f64,
}

impl<const D: usize> OpenBorder<D> {
    /// Velocity along the axis that a face with a velocity has.
    fn given(&self, cell: &BorderCell) -> f64 {
        match self.face.flow {
            FaceFlow::Velocity { velocity, .. } => {
                velocity[self.face.axis] * self.factor * cell.profile
            }
            FaceFlow::Pressure { .. } => 0.0,
        }
    }

    /// What a face with a pressure does; nothing for one with a velocity. `head` is the weight of a
    /// unit of volume, and `unit` what makes `q` of a pressure.
    fn response(
        &self,
        (dt, h): (f64, f64),
        cell: &BorderCell,
        head: f64,
        unit: f64,
    ) -> Option<FaceResponse> {
        let FaceFlow::Pressure { pressure, .. } = self.face.flow else { return None };
        let k = self.wave_speed * dt / h;
        let q_face = unit * (pressure * self.factor + head * cell.depth.max(0.0));
        let per_q = 2.0 / (1.0 + 2.0 * k);
        let at_zero = (cell.tentative - 2.0 * q_face + 2.0 * k * self.mean) / (1.0 + 2.0 * k);
        Some(FaceResponse { at_zero, per_q })
    }

    fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("mean", &mut self.mean)?;
        state.column(
            "entered",
            &mut self.entries,
            |entry| entry.entered,
            |entry, entered| entry.entered = entered,
        )?;
        // Particles enter until it is negative.
        if !self.entries.iter().all(|entry| entry.entered < 0.0) {
            return state.unfit("the state has particles that should have entered at an open face");
        }
        Ok(())
    }

    /// Lets particles enter, and tells how many did.
    fn enter(
        &mut self,
        (dt, step): (f64, f64),
        velocity: &FaceVelocity<D>,
        particles: &mut ParticleArrays<D>,
        is_free: impl Fn([f64; D]) -> bool,
    ) -> u64 {
        let OpenFace { axis, flow, .. } = self.face;
        let inward = -self.face.outward();
        let mut count = 0;
        for entry in &mut self.entries {
            let own = match flow {
                FaceFlow::Velocity { velocity, .. } => {
                    velocity.map(|u| u * self.factor * entry.profile)
                }
                FaceFlow::Pressure { .. } => std::array::from_fn(|a| {
                    if a == axis { velocity[axis][self.cells[entry.cell].face] } else { 0.0 }
                }),
            };
            entry.entered += dt * inward * own[axis];
            // A layer that left need not come back as another one.
            if entry.entered < -step {
                entry.entered += step * (-entry.entered / step).floor();
            }
            while entry.entered >= 0.0 {
                let mut at = entry.at;
                at[axis] += inward * entry.entered;
                if is_free(at) {
                    particles.push(at, own);
                    count += 1;
                }
                entry.entered -= step;
            }
        }
        count
    }
}

/// The cells at a face that solids at rest do not close. `depth` is that of a point below the level,
/// on the axis `up` if the face has a level of its own.
fn border_cells<const D: usize>(
    grid: &StaggeredGrid<D>,
    fractions: &OpenFractions<D>,
    face: &OpenFace<D>,
    depth: impl Fn([f64; D]) -> f64,
    up: Option<usize>,
) -> Vec<BorderCell> {
    let OpenFace { axis, flow, .. } = *face;
    let end = if face.is_lower() { 0 } else { grid.cells[axis] as isize - 1 };
    let mut cells = Vec::new();
    for at in grid.all().filter(|at| at[axis] == end) {
        let cell = grid.place(at);
        let face_at = if face.is_lower() { cell } else { cell + grid.stride[axis] };
        if fractions.open[axis][face_at] == 0.0 {
            continue;
        }
        let mut centre = grid.centre(at);
        centre[axis] += 0.5 * grid.spacing * face.outward();
        let depth = depth(centre);
        // A face across the axis of gravity is below its level, or is not.
        let below_level = match up {
            None => 1.0,
            Some(up) if up == axis => f64::from(u8::from(depth > 0.0)),
            Some(_) => (depth / grid.spacing + 0.5).clamp(0.0, 1.0),
        };
        let profile = profile(grid, axis, flow, centre);
        cells.push(BorderCell { cell, face: face_at, below_level, profile, depth, tentative: 0.0 });
    }
    cells
}

/// Factor of a velocity's profile at a point of a face.
fn profile<const D: usize>(
    grid: &StaggeredGrid<D>,
    axis: usize,
    flow: FaceFlow<D>,
    at: [f64; D],
) -> f64 {
    let FaceFlow::Velocity { is_parabolic: true, .. } = flow else { return 1.0 };
    let across = (0..D).filter(|&a| a != axis && !grid.periodic[a]);
    across
        .map(|a| {
            let s = (at[a] - grid.origin[a]) / (grid.cells[a] as f64 * grid.spacing);
            4.0 * s * (1.0 - s)
        })
        .product()
}

/// Places at which particles enter: a lattice on each face, as cells have one at the start.
fn entries<const D: usize>(
    grid: &StaggeredGrid<D>,
    face: &OpenFace<D>,
    cells: &[BorderCell],
    per_axis: usize,
    is_below: impl Fn([f64; D]) -> bool,
) -> Vec<Entry<D>> {
    let OpenFace { axis, flow, .. } = *face;
    let step = grid.spacing / per_axis as f64;
    let mut all = Vec::new();
    for (number, border) in cells.iter().enumerate() {
        let middle = grid.centre(grid.cell_at(border.cell));
        for point in 0..per_axis.pow(D as u32 - 1) {
            let mut rest = point;
            let at: [f64; D] = std::array::from_fn(|a| {
                if a == axis {
                    return middle[a] + 0.5 * grid.spacing * face.outward();
                }
                let along = rest % per_axis;
                rest /= per_axis;
                middle[a] - 0.5 * grid.spacing + (along as f64 + 0.5) * step
            });
            if is_below(at) {
                let profile = profile(grid, axis, flow, at);
                all.push(Entry { cell: number, at, profile, entered: -0.5 * step });
            }
        }
    }
    all
}

#[cfg(test)]
mod tests;
