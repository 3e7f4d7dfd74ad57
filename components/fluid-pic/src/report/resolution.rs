//! Resolution by the user's parameters and the scene: cells, time step, memory.

use crate::domain::parameters::{Parameters, WallName};
use crate::report::scene_check::check_scene;
use serde::{Deserialize, Serialize};
use tremie_fluid_kit::cells::flattened::flattened;
use tremie_fluid_kit::cells::links::Links;
use tremie_fluid_kit::cells::whole_cells::whole_cells;
use tremie_fluid_kit::checks::gap_width_check::{Narrow, narrowest};
use tremie_fluid_kit::checks::part_extent::{PartExtent, thin_parts};
use tremie_fluid_kit::checks::smallest_body::{smallest_diameter, thinnest_width};
use tremie_fluid_kit::survey::static_geometry::{GridAxes, StaticGeometry};
use tremie_messages::Problem;
use tremie_messages::scene::{Face, Fill, Scene};

/// Reynolds number of a cell below which cells resolve the layer beside a wall.
const RESOLVED_LAYER: f64 = 20.0;
/// Bytes of a stored cell: arrays of double precision of the solver, and its coarser levels.
const BYTES_PER_CELL: u64 = 570;
/// Bytes of a particle, with room to sort them.
const BYTES_PER_PARTICLE: u64 = 80;
/// Memory beyond which a grid is refused [bytes].
const MEMORY_LIMIT: u64 = 1 << 40;
/// Cells that places in memory can number.
const MOST_CELLS: f64 = 2e9;

/// Resolution that follows from parameters and scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edge of a cell [m].
    pub cell: f64,
    /// Time step [s]; a shorter one may be assigned.
    pub time_step: f64,
    /// The speed that it was made for [m/s].
    pub expected_speed: f64,
    /// Cells that hold fluid at the start.
    pub wet_cells: u64,
    /// Particles at the start.
    pub particles: u64,
    /// Cells between the lowest and the highest fluid at the start.
    pub depth: f64,
    /// True if the fluid fills its space.
    pub fills_all: bool,
    /// True if walls and bodies hold the fluid back.
    pub sticks: bool,
    /// Reynolds number of a cell at the expected speed.
    pub cell_reynolds: f64,
    /// Diameter of the smallest sphere of the scene [cells].
    pub cells_per_smallest_sphere: Option<f64>,
    /// The least width of the thinnest polyhedron of the scene [cells].
    pub cells_per_thinnest_polyhedron: Option<f64>,
    /// Parts that are thinner than some cells somewhere in the fluid.
    pub thin_parts: Vec<PartExtent>,
    /// The narrowest gap between parts and walls, if it is narrow.
    pub narrowest_gap: Option<Narrow>,
    /// The narrowest gap of a body at the start, if it is narrow.
    pub narrowest_film: Option<Narrow>,
    /// Least density of a free body over that of the fluid.
    pub lightest_body: Option<f64>,
    /// Memory [bytes].
    pub memory_bytes: u64,
    /// Notes for a user; sentences.
    pub notes: Vec<String>,
}

/// The axis along which gravity is strongest, and its sign.
pub fn down(scene: &Scene) -> Option<(usize, f64)> {
    let g = scene.gravity;
    let axis = (0..3).max_by(|&a, &b| g[a].abs().total_cmp(&g[b].abs()))?;
    (g[axis] != 0.0).then(|| (axis, g[axis]))
}

impl Parameters {
    /// Checks parameters and scene against each other.
    ///
    /// # Errors
    /// Every problem of both.
    pub fn resolve(&self, scene: &Scene) -> Result<Resolution, Vec<Problem>> {
        self.survey(scene).map(|(resolution, _)| resolution)
    }

    /// As [`Parameters::resolve`], with the scene in cells.
    pub(crate) fn survey(
        &self,
        scene: &Scene,
    ) -> Result<(Resolution, StaticGeometry), Vec<Problem>> {
        let mut problems = Vec::new();
        self.check_own(&mut problems);
        check_scene(scene, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        let h = self.cell.0;
        let flat = flattened(scene, h);
        let scene = &flat;
        let cells = whole_cells(&scene.domain, h, &mut problems);
        let per_cell = self.particles_per_axis.pow(dimensions(scene)) as f64;
        let stored = stored_cells(cells, scene) as f64;
        let memory = stored * (BYTES_PER_CELL as f64 + per_cell * BYTES_PER_PARTICLE as f64);
        if stored > MOST_CELLS || memory > MEMORY_LIMIT as f64 {
            let found = format!(
                "{h} m makes {stored:.3e} cells and up to {:.3e} particles, {:.3e} GB: more than can be had",
                stored * per_cell,
                memory * 1e-9
            );
            problems.push(Problem::of_parameter("cell", found).help("take a larger cell"));
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let ground = StaticGeometry::new(scene, GridAxes::WORLD, Links::FACES, cells, h)?;
        let wet = Wet::of(scene, &ground)?;
        let own = self.come_to(scene, &ground, cells, &wet)?;
        Ok((own, ground))
    }

    fn come_to(
        &self,
        scene: &Scene,
        ground: &StaticGeometry,
        cells: [usize; 3],
        wet: &Wet,
    ) -> Result<Resolution, Vec<Problem>> {
        let h = self.cell.0;
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let expected_speed = fluid.expected_speed.filter(|speed| *speed > 0.0);
        let by_itself =
            || [fall_speed(scene, wet), inflow_speed(scene)].into_iter().flatten().reduce(f64::max);
        let expected_speed = match expected_speed.or_else(by_itself) {
            Some(speed) => speed,
            None if self.time_step.is_some() => 0.0,
            None => {
                let found = "neither gravity, nor a velocity at a face, nor an expected speed says how long a time step may be";
                let help = "write expected_speed = \"1 m/s\", or time_step in the fluid's settings";
                return Err(vec![Problem::new("scene.fluid.expected_speed", found).help(help)]);
            }
        };
        let time_step = self.time_step.map_or(self.courant * h / expected_speed, |step| step.0);
        let cell_reynolds = expected_speed * h * fluid.density / fluid.viscosity;
        let sticks =
            self.walls.map_or(cell_reynolds < RESOLVED_LAYER, |walls| walls == WallName::Stick);
        let diameter = smallest_diameter(scene);
        let per_cell = self.particles_per_axis.pow(dimensions(scene)) as u64;
        let stored = stored_cells(cells, scene);
        let particles = wet.cells * per_cell;
        let free = |set: &&tremie_messages::scene::BodySet| {
            set.motion == tremie_messages::scene::Motion::Free
        };
        let lightest_body = scene
            .bodies
            .iter()
            .filter(free)
            .map(|set| set.density / fluid.density)
            .reduce(f64::min);
        // These look at bodies and parts as things in space.
        let is_plane = scene.domain.across.is_some();
        let [narrowest_gap, narrowest_film] =
            if is_plane { [None, None] } else { narrowest(scene, ground) };
        let thin_parts = if is_plane { Vec::new() } else { thin_parts(scene, ground) };
        let mut notes = ground.notes();
        let walls = if sticks { "hold the fluid back" } else { "let the fluid slip" };
        notes.push(format!(
            "walls and bodies {walls} (Reynolds number of a cell {cell_reynolds:.3})"
        ));
        Ok(Resolution {
            cells,
            cell: h,
            time_step,
            expected_speed,
            wet_cells: wet.cells,
            particles,
            depth: wet.depth,
            fills_all: fluid.fill.is_empty(),
            sticks,
            cell_reynolds,
            cells_per_smallest_sphere: diameter.map(|d| d / h),
            cells_per_thinnest_polyhedron: thinnest_width(scene).map(|width| width / h),
            thin_parts,
            narrowest_gap,
            narrowest_film,
            lightest_body,
            memory_bytes: stored * BYTES_PER_CELL + particles * BYTES_PER_PARTICLE,
            notes,
        })
    }
}

/// Axes of a scene's grid.
pub fn dimensions(scene: &Scene) -> u32 {
    if scene.domain.across.is_some() { 2 } else { 3 }
}

fn stored_cells(cells: [usize; 3], scene: &Scene) -> u64 {
    let across = scene.domain.across;
    (0..3).filter(|&a| across != Some(a)).map(|a| cells[a] as u64 + 2).product()
}

/// Cells that hold fluid at the start.
struct Wet {
    cells: u64,
    /// Number of layers of cells between the lowest and the highest.
    depth: f64,
    /// The highest, over the domain's lower end [m].
    top: f64,
}

impl Wet {
    fn of(scene: &Scene, ground: &StaticGeometry) -> Result<Self, Vec<Problem>> {
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let (axis, _) = down(scene).unwrap_or((2, -1.0));
        let (mut count, mut lowest, mut highest) = (0, f64::INFINITY, f64::NEG_INFINITY);
        let holds = FillRegions::new(scene, ground);
        for index in 0..ground.grid.len() {
            let at = ground.grid.at(index);
            let centre = ground.centres().of(at);
            if ground.voxels.is_fluid(&ground.grid, at) && holds.region_of(centre).is_some() {
                count += 1;
                lowest = centre[axis].min(lowest);
                highest = centre[axis].max(highest);
            }
        }
        if count == 0 {
            let found =
                "the regions hold no water: solids cover them, or they are thinner than a cell";
            let key = if fluid.fill.is_empty() { "scene.fluid" } else { "scene.fluid.fill[0]" };
            let help = "make them larger than a cell, in space that the fluid can reach";
            return Err(vec![Problem::new(key, found).help(help)]);
        }
        let cell = ground.centres().cell;
        let depth = (highest - lowest) / cell + 1.0;
        Ok(Self { cells: count, depth, top: highest + 0.5 * cell - scene.domain.min[axis] })
    }
}

/// Speed of a fall from the highest fluid [m/s].
fn fall_speed(scene: &Scene, wet: &Wet) -> Option<f64> {
    let (_, g) = down(scene)?;
    Some((2.0 * g.abs() * wet.top).sqrt())
}

/// Largest speed that a face of the domain gives the fluid [m/s].
fn inflow_speed(scene: &Scene) -> Option<f64> {
    let of = |face: &Face| match face {
        Face::Velocity(open) => {
            let speed = open.velocity.iter().map(|u| u * u).sum::<f64>().sqrt();
            Some(speed * open.course.largest())
        }
        Face::Wall { velocity, course } => {
            let speed = velocity.iter().map(|u| u * u).sum::<f64>().sqrt();
            Some(speed * course.largest()).filter(|speed| *speed > 0.0)
        }
        _ => None,
    };
    scene.domain.faces.iter().flatten().filter_map(of).reduce(f64::max)
}

/// The regions that hold fluid at the start.
pub struct FillRegions<'a> {
    fills: &'a [Fill],
    /// Surfaces of the parts that regions name, with their frames.
    parts: Vec<Option<(&'a tremie_geometry::Surface, tremie_geometry::Frame)>>,
}

impl<'a> FillRegions<'a> {
    /// Of a scene.
    pub fn new(scene: &'a Scene, ground: &'a StaticGeometry) -> Self {
        let fills = scene.fluid.as_ref().map_or(&[][..], |fluid| &fluid.fill);
        let part = |fill: &Fill| {
            let name = fill.part.as_ref()?;
            let (index, surface) =
                ground.part_surfaces().find(|(k, _)| scene.parts[*k].name == *name)?;
            let frame = tremie_fluid_kit::survey::solids::start_frame(&scene.parts[index], surface);
            Some((surface, frame))
        };
        Self { fills, parts: fills.iter().map(part).collect() }
    }

    /// Velocity that the region gives which holds a point, if one does: nothing of its own where it
    /// has none. Without regions every point is held.
    pub fn region_of(&self, point: [f64; 3]) -> Option<Option<[f64; 3]>> {
        if self.fills.is_empty() {
            return Some(None);
        }
        let holds = |(fill, part): &(
            &Fill,
            &Option<(&tremie_geometry::Surface, tremie_geometry::Frame)>,
        )| {
            // Inside a part's surface, whichever of its sides is solid.
            let inside = part.as_ref().is_none_or(|(surface, frame)| {
                surface.contains(frame.to_part(point)) != surface.is_cavity()
            });
            fill.box_holds(point) && inside
        };
        let held = self.fills.iter().zip(&self.parts).find(holds);
        held.map(|(fill, _)| fill.velocity)
    }
}
