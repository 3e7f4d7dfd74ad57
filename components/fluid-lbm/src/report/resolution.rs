//! Resolution by the user's parameters and the scene: cells, time step, memory, warnings.

use crate::bodies::body_memory;
use crate::boundary::virtual_piston::part_surface::{ONE_WAY, area_of_link};
use crate::boundary::virtual_piston::reservoir_state::reservoirs_of;
use crate::domain::parameters::{Parameters, Precision};
use crate::lattice::aa_pattern;
use crate::lattice::d3q19::{C, CS2, LINKS, Q, dot};
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::Field;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::report::scene_check::check_scene;
use serde::{Deserialize, Serialize};
use tremie_fluid_kit::cells::grid::Reach;
use tremie_fluid_kit::cells::whole_cells::whole_cells;
use tremie_fluid_kit::checks::gap_width_check::{Narrow, narrowest};
use tremie_fluid_kit::checks::grain_space_check::{DryRegion, Throat, dry_regions, throat};
use tremie_fluid_kit::checks::mended_part::{MendedPart, mended_parts};
use tremie_fluid_kit::checks::part_extent::{PartExtent, rounded, thin_parts};
use tremie_fluid_kit::checks::smallest_body::{smallest_diameter, thinnest_width};
use tremie_fluid_kit::survey::static_geometry::{GridAxes, StaticGeometry};
use tremie_messages::Problem;
use tremie_messages::finding::short;
use tremie_messages::scene::{FluidMaterial, Scene};

/// Resolution that follows from parameters and scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edge of a cell [m].
    pub cell: f64,
    /// Time step [s]; a shorter one may be assigned.
    pub time_step: f64,
    /// Relaxation time [time steps].
    pub tau: f64,
    /// Mach number of the scene's expected speed.
    pub expected_mach: Option<f64>,
    /// Diameter of the smallest sphere of the scene [cells].
    pub cells_per_smallest_sphere: Option<f64>,
    /// The least width of the thinnest polyhedron of the scene [cells].
    pub cells_per_thinnest_polyhedron: Option<f64>,
    /// Parts that are thinner than 16 cells somewhere in the fluid.
    pub thin_parts: Vec<PartExtent>,
    /// Memory that the fluid will take [bytes].
    pub memory_bytes: u64,
    /// Cells that the fluid may fill.
    pub fluid_cells: usize,
    /// The narrowest gap between parts and walls of the domain, within 8 cells.
    pub narrowest_gap: Option<Narrow>,
    /// The narrowest gap between a listed body and anything at the start, within 8 cells.
    pub narrowest_gap_of_bodies: Option<Narrow>,
    /// Regions in which grains start or come, with space that no fluid reaches.
    pub dry_regions: Vec<DryRegion>,
    /// The narrowest place on the way of grains to where they leave.
    pub throat: Option<Throat>,
    /// Area of each face or surface that has a reservoir, in the order of reservoirs [cells].
    pub reservoir_areas: Vec<f64>,
    /// Parts whose files had to be mended.
    pub mended: Vec<MendedPart>,
    /// Notes on the geometry in cells; sentences.
    pub notes: Vec<String>,
    /// Warnings that a user should read before trusting results; sentences.
    pub warnings: Vec<String>,
}

impl Parameters {
    /// Checks everything that can be known before the run and derives the resolution.
    ///
    /// # Errors
    /// Every problem found, not only the first.
    pub fn resolve(&self, scene: &Scene) -> Result<Resolution, Vec<Problem>> {
        self.survey(scene).map(|(resolution, _)| resolution)
    }

    /// As [`Parameters::resolve`], with the geometry in cells.
    pub(crate) fn survey(
        &self,
        scene: &Scene,
    ) -> Result<(Resolution, StaticGeometry), Vec<Problem>> {
        let mut problems = Vec::new();
        self.check_own(&mut problems);
        check_scene(scene, &mut problems);
        let fluid = match &scene.fluid {
            Some(fluid) if problems.is_empty() => fluid,
            _ => return Err(problems),
        };
        let cells = whole_cells(&scene.domain, self.cell.0, &mut problems);
        let time_step = self.choose_time_step(fluid);
        let tau = self.tau_of(time_step, fluid.viscosity / fluid.density);
        self.check_step(fluid, time_step, &mut problems);
        let boxed = cells.iter().try_fold(1_u64, |n, &k| n.checked_mul(k as u64));
        // The map of the box alone; what is stored in it is counted once it is known.
        if boxed.is_none_or(|boxed| boxed >= u64::from(u32::MAX)) {
            problems.push(too_many(cells));
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let ground = StaticGeometry::new(scene, GridAxes::WORLD, LINKS, cells, self.cell.0)?;
        let fluid_cells = ground.voxels.fluid;
        let of_bodies =
            body_memory::of_bodies(scene, self.cell.0) + ground.triangles() * OF_TRIANGLE;
        let memory_bytes = match self.memory(cells, fluid_cells as u64) {
            Some(bytes) if bytes <= Self::MEMORY_LIMIT => bytes + of_bodies,
            _ => return Err(vec![too_many(cells)]),
        };
        let reservoir_areas = reservoir_areas(scene, &ground)?;
        let smallest = smallest_diameter(scene).map(|d| d / self.cell.0);
        let [narrowest_gap, narrowest_gap_of_bodies] = narrowest(scene, &ground);
        let resolution = Resolution {
            cells,
            cell: self.cell.0,
            time_step,
            tau,
            expected_mach: fluid.expected_speed.map(|speed| self.mach_of(speed, time_step)),
            cells_per_smallest_sphere: smallest,
            cells_per_thinnest_polyhedron: thinnest_width(scene)
                .map(|width| rounded(width / self.cell.0)),
            thin_parts: thin_parts(scene, &ground),
            memory_bytes,
            fluid_cells,
            narrowest_gap,
            narrowest_gap_of_bodies,
            dry_regions: dry_regions(scene, &ground),
            throat: throat(scene, &ground),
            reservoir_areas,
            mended: mended_parts(scene, &ground),
            notes: ground.notes(),
            warnings: warnings(memory_bytes),
        };
        Ok((resolution, ground))
    }

    /// Checks a time step [s] that was assigned: its relaxation time and Mach number.
    pub(crate) fn check_step(
        &self,
        fluid: &FluidMaterial,
        time_step: f64,
        problems: &mut Vec<Problem>,
    ) {
        let nu = fluid.viscosity / fluid.density;
        let tau = self.tau_of(time_step, nu);
        let key = if self.relaxation_time.is_some() { "relaxation_time" } else { "time_step" };
        if !(tau.is_finite() && tau >= self.smallest_tau()) {
            let least = self.time_step_of(self.smallest_tau(), nu);
            problems.push(
                Problem::of_parameter(
                    key,
                    format!(
                        "the time step {time_step:.4e} s makes the relaxation time {tau:.6}, \
                         too close to the stability limit 1/2 (least {})",
                        self.smallest_tau()
                    ),
                )
                .help(format!(
                    "take a time step of at least {least:.4e} s, or a smaller cell, or a turbulence model (smagorinsky)"
                )),
            );
        }
        let Some(speed) = fluid.expected_speed else {
            return;
        };
        let mach = self.mach_of(speed, time_step);
        // A time step chosen to meet the limit may exceed it by rounding.
        if mach > self.mach_limit * (1.0 + 1e-9) {
            let most = time_step * self.mach_limit / mach;
            problems.push(
                Problem::of_parameter(
                    key,
                    format!(
                        "the expected speed {speed} m/s is Mach {mach:.3} with the time step {time_step:.4e} s, \
                         over the limit {}",
                        self.mach_limit
                    ),
                )
                .help(format!("a time step of {most:.4e} s would do")),
            );
        }
    }

    /// Cause that the time step is as short as it is, in words.
    pub fn step_limit(&self, fluid: &FluidMaterial) -> String {
        let cell = short(self.cell.0);
        let viscosity = short(fluid.viscosity / fluid.density);
        let step = self.choose_time_step(fluid);
        match (self.time_step, self.relaxation_time, fluid.expected_speed) {
            (Some(_), ..) => "time_step in its settings".into(),
            (None, Some(tau), _) => format!(
                "relaxation_time {} in its settings, with a cell of {cell} m and {viscosity} m2/s",
                short(tau)
            ),
            (None, None, Some(speed))
                if self.tau_of(step, fluid.viscosity / fluid.density)
                    < Self::DEFAULT_TAU * (1.0 - 1e-9) =>
            {
                format!(
                    "Mach {} at expected_speed {} m/s, with a cell of {cell} m",
                    short(self.mach_of(speed, step)),
                    short(speed)
                )
            }
            _ => format!(
                "a relaxation time of {}, with a cell of {cell} m and a viscosity of {viscosity} m2/s",
                Self::DEFAULT_TAU
            ),
        }
    }

    /// The time step [s] that parameters and scene ask for.
    fn choose_time_step(&self, fluid: &FluidMaterial) -> f64 {
        let nu = fluid.viscosity / fluid.density;
        match (self.time_step, self.relaxation_time) {
            (Some(time_step), _) => time_step.0,
            (None, Some(tau)) => self.time_step_of(tau, nu),
            (None, None) => {
                let viscous = self.time_step_of(Self::DEFAULT_TAU, nu);
                match fluid.expected_speed {
                    Some(speed) if speed > 0.0 => {
                        let mach = Self::DEFAULT_MACH.min(self.mach_limit);
                        viscous.min(mach * CS2.sqrt() * self.cell.0 / speed)
                    }
                    _ => viscous,
                }
            }
        }
    }

    /// Memory of the lattice and its maps [bytes], if `stored` of the box's cells are stored;
    /// `None` if there are more than can be numbered.
    fn memory(&self, cells: [usize; 3], stored: u64) -> Option<u64> {
        let boxed = cells.iter().try_fold(1_u64, |n, &k| n.checked_mul(k as u64))?;
        if boxed >= u64::from(u32::MAX) {
            return None;
        }
        let (line, bytes): (u64, fn(u64) -> u64) = match self.precision {
            Precision::F64 => (8, Field::<f64>::bytes),
            Precision::F32 => (16, Field::<f32>::bytes),
        };
        let stride = aa_pattern::stride(stored, line);
        // Places are numbers of 32 bits.
        if stride * Q as u64 > u64::from(u32::MAX) {
            return None;
        }
        // Populations; which cells of the box are stored; index and owner of each; one bit a cell;
        // the table of places.
        Some(bytes(stride) + boxed / 4 + 8 * stored + stored / 8 + 4 * Q as u64 * stride / line)
    }
}

/// Area of each face or surface that has a reservoir [cells].
fn reservoir_areas(scene: &Scene, ground: &StaticGeometry) -> Result<Vec<f64>, Vec<Problem>> {
    let of = |(place, _): (ReservoirPlace, _)| {
        let area = match place {
            ReservoirPlace::Face { axis, side } => cells_at_face(ground, (axis, side)) as f64,
            ReservoirPlace::Part(part) => area_of_part(ground, part).map_err(|found| {
                let help = "let the fluid touch one side of the part alone";
                vec![Problem::new(place.key(), found).help(help)]
            })?,
        };
        if area > 0.0 {
            return Ok(area);
        }
        let found = "the reservoir reaches no fluid: solids cover all cells there";
        let help = "let the bore end at the face of the domain, or at the part";
        Err(vec![Problem::new(place.key(), found).help(help)])
    };
    reservoirs_of(scene).map(of).collect()
}

/// Cells of the fluid at a face.
fn cells_at_face(ground: &StaticGeometry, face: (usize, usize)) -> usize {
    let own = |index: &usize| ground.grid.open_faces(ground.grid.at(*index)).next() == Some(face);
    let solid = &ground.voxels.obstacles.solid;
    (0..ground.grid.len()).filter(|k| solid.get(*k).is_none_or(|&s| s == 0)).filter(own).count()
}

/// Area of the side of a part that the fluid touches [cells].
fn area_of_part(ground: &StaticGeometry, part: usize) -> Result<f64, &'static str> {
    let number = ground.solids.iter().position(|solid| solid.part == Some(part));
    let Some(own) = number.map(|number| number as u16 + 1) else { return Ok(0.0) };
    let (grid, solid) = (&ground.grid, &ground.voxels.obstacles.solid);
    let (mut whole, mut amounts) = ([0.0; 3], 0.0);
    for index in (0..solid.len()).filter(|&k| solid[k] == 0) {
        let at = grid.at(index);
        let mut area = [0.0; 3];
        for i in 1..Q {
            let to = std::array::from_fn(|a| at[a] + C[i][a]);
            if let Reach::Cell { at: end, .. } = grid.reach(to)
                && solid[grid.index(end)] == own
            {
                add_scaled(&mut area, area_of_link(i), 1.0);
            }
        }
        add_scaled(&mut whole, area, 1.0);
        amounts += dot(area, area).sqrt();
    }
    let area = dot(whole, whole).sqrt();
    if area < ONE_WAY * amounts {
        return Err("a reservoir's surface must look one way, and this part's looks several");
    }
    Ok(area)
}

fn too_many(cells: [usize; 3]) -> Problem {
    Problem::of_parameter("cell", format!("makes {cells:?} cells, more than fit in memory"))
        .help("choose a larger cell or a smaller domain")
}

/// Memory of a triangle of a part, with what is kept to find it [bytes]; measured on x86-64.
const OF_TRIANGLE: u64 = 340;

/// Warnings that a user should read before trusting results; numbers with a verdict are in
/// [`crate::findings`].
fn warnings(memory_bytes: u64) -> Vec<String> {
    let mut warnings = Vec::new();
    if memory_bytes > 16 << 30 {
        warnings.push(format!(
            "the fluid takes {:.1} GiB of memory",
            memory_bytes as f64 / f64::from(1 << 30)
        ));
    }
    warnings
}
