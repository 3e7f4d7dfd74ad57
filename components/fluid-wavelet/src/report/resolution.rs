//! Resolution by the user's parameters and the scene: points, levels, time step, memory.

use crate::domain::initial_gas::InitialGas;
use crate::domain::parameters::{MOST_LEVELS, Parameters};
use crate::domain::world_axes::WorldAxes;
use crate::gas::gas_law::GasState;
use crate::report::scene_check::check_scene;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use tremie_fluid_kit::cells::whole_cells::common_cell;
use tremie_fluid_kit::checks::smallest_body::{smallest_diameter, thinnest_width};
use tremie_messages::Problem;
use tremie_messages::scene::{BodySizes, Scene};

/// Bytes of a point in a plane and in space: fields, those with ghosts, rates, those of the step's
/// start, and their share of coarser blocks.
const BYTES_PER_POINT: [u64; 2] = [210, 380];
/// Memory beyond which a grid is refused [bytes].
const MEMORY_LIMIT: f64 = (1_u64 << 40) as f64;
/// Points that an observer sees at most in a plane.
const MOST_OBSERVED: f64 = 1e5;
/// Points across a body below which what stands inside it has no room.
const LEAST_ACROSS: f64 = 6.0;

/// Resolution that follows from parameters and scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Spacing of the finest points [m].
    pub cell: f64,
    /// Points of the finest grid along each axis of the world, of which few are kept.
    pub points: [usize; 3],
    /// Levels above the coarsest.
    pub levels: u8,
    /// Blocks of the coarsest level along each axis of the grid.
    pub roots: [u32; 3],
    /// Level of the points that observers see.
    pub observed_level: u8,
    /// Time step of the run's windows [s]; a shorter one may be assigned.
    pub time_step: f64,
    /// Cause of it, a few words.
    pub step_limit: String,
    /// Points at the start, roughly.
    pub first_points: f64,
    /// Mach number of the expected speed, and of what the gas has at the start.
    pub mach: f64,
    /// Diameter of the smallest body [points].
    pub across_smallest: Option<f64>,
    /// Least width of the thinnest polyhedron [points].
    pub across_thinnest: Option<f64>,
    /// Points in the boundary layer of the smallest body, `D/sqrt(Re)` thick.
    pub in_layer: Option<f64>,
    /// Memory [bytes].
    pub memory_bytes: u64,
}

impl Parameters {
    /// Checks parameters and scene against each other.
    ///
    /// # Errors
    /// Every problem of both.
    pub fn resolve(&self, scene: &Scene) -> Result<Resolution, Vec<Problem>> {
        let mut problems = Vec::new();
        self.check_own(&mut problems);
        check_scene(scene, self.inviscid, &mut problems);
        let initial = match InitialGas::of(scene, self.inviscid) {
            Some(initial) if problems.is_empty() => initial,
            _ => return Err(problems),
        };
        let axes = WorldAxes::of(scene);
        let Some(levels) = self.fitting_levels(scene, axes, &mut problems) else {
            return Err(problems);
        };
        let h = self.cell.0;
        let across = |width: Option<f64>| width.map(|width| width / h);
        let (across_smallest, across_thinnest) =
            (across(smallest_diameter(scene)), across(thinnest_width(scene)));
        for (what, found) in [("body", across_smallest), ("polyhedron", across_thinnest)] {
            if let Some(found) = found.filter(|found| *found < LEAST_ACROSS) {
                let message = format!(
                    "found {found:.1} points across the smallest {what}, expected at least {LEAST_ACROSS}: the gas around it would not see it"
                );
                let fits = h * found / LEAST_ACROSS;
                let help =
                    format!("a cell of {fits:.3e} m makes it {LEAST_ACROSS}; 16 are a good number");
                problems.push(Problem::of_parameter("cell", message).help(help));
            }
        }
        let first_points = self.first_points(scene, axes, levels, &initial);
        let per_point = BYTES_PER_POINT[axes.dims - 2];
        let memory = first_points * per_point as f64;
        if memory > MEMORY_LIMIT {
            let message = format!(
                "{h} m makes about {first_points:.2e} points at the start, {:.2e} GB: more than can be had",
                memory * 1e-9
            );
            problems.push(Problem::of_parameter("cell", message).help("take a larger cell"));
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let across = [across_smallest, across_thinnest];
        Ok(self.come_to(scene, axes, levels, &initial, across, (first_points, memory)))
    }

    fn come_to(
        &self,
        scene: &Scene,
        axes: WorldAxes,
        levels: u8,
        initial: &InitialGas,
        [across_smallest, across_thinnest]: [Option<f64>; 2],
        (first_points, memory): (f64, f64),
    ) -> Resolution {
        let h = self.cell.0;
        let along = |axis: usize| (scene.domain.size()[axis] / h).round();
        let points = std::array::from_fn(|axis| {
            if scene.domain.across == Some(axis) { 1 } else { along(axis) as usize }
        });
        let block = (self.block_edge(axes.dims) << levels) as f64;
        let roots = std::array::from_fn(|a| {
            if a < axes.dims { (along(axes.order[a]) / block).round() as u32 } else { 1 }
        });
        let (stable, mach) = self.stable_step(scene, axes, initial);
        let (time_step, step_limit) = match self.time_step {
            Some(step) => (step.0, "time_step".to_string()),
            None => stable,
        };
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let speed = fluid.expected_speed.filter(|speed| *speed > 0.0);
        let in_layer = (!self.inviscid).then_some(()).and(speed).zip(across_smallest);
        let in_layer = in_layer.map(|(speed, across)| {
            across / (speed * across * h * fluid.density / fluid.viscosity).sqrt()
        });
        // Of the largest plane.
        let counts: Vec<f64> = (0..axes.dims).map(|a| along(axes.order[a])).collect();
        let plane = counts.iter().product::<f64>()
            / if axes.dims == 3 {
                counts.iter().copied().fold(f64::INFINITY, f64::min)
            } else {
                1.0
            };
        let coarser = (0.5 * (plane / MOST_OBSERVED).log2()).ceil().max(0.0) as u8;
        Resolution {
            cell: h,
            points,
            levels,
            roots,
            observed_level: levels.saturating_sub(coarser),
            time_step,
            step_limit,
            first_points,
            mach,
            across_smallest,
            across_thinnest,
            in_layer,
            memory_bytes: memory as u64,
        }
    }

    /// The number of levels that the user wants, or the most that the domain's edges allow.
    fn fitting_levels(
        &self,
        scene: &Scene,
        axes: WorldAxes,
        problems: &mut Vec<Problem>,
    ) -> Option<u8> {
        let size = scene.domain.size();
        let edges = || (0..axes.dims).map(|a| (axes.order[a], size[axes.order[a]]));
        let block = |levels: u8| self.cell.0 * (self.block_edge(axes.dims) << levels) as f64;
        let misfit = |levels: u8| {
            edges().find(|&(_, size)| {
                let exact = size / block(levels);
                (exact - exact.round()).abs() > 1e-6 * exact || exact < 0.5
            })
        };
        let found = match self.levels {
            Some(levels) => Some(levels).filter(|&levels| misfit(levels).is_none()),
            None => (0..=MOST_LEVELS).rev().find(|&levels| misfit(levels).is_none()),
        };
        if found.is_none() {
            let levels = self.levels.unwrap_or(0);
            let (axis, size) = misfit(levels)?;
            let edge = self.block_edge(axes.dims);
            let message = format!(
                "the domain is {size} m along {}, {:.4} blocks of {edge} points of the coarsest level, {:.4e} m each; it must be a whole number",
                ["x", "y", "z"][axis],
                size / block(levels),
                block(levels)
            );
            let mut all = [edges().next()?.1; 3];
            edges().zip(&mut all).for_each(|((_, size), all)| *all = size);
            let help = match common_cell(all, block(levels)) {
                Some(fits) => format!(
                    "a cell of {:.9e} m fits all edges; so may fewer levels",
                    fits / (edge << levels) as f64
                ),
                None => "take edges in the ratio of small whole numbers, fewer levels, or a smaller block".into(),
            };
            problems.push(Problem::of_parameter("cell", message).help(help));
        }
        found
    }

    /// The longest step at the start, with its cause, and the largest Mach number.
    fn stable_step(
        &self,
        scene: &Scene,
        axes: WorldAxes,
        initial: &InitialGas,
    ) -> ((f64, String), f64) {
        let h = self.cell.0;
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let expected = fluid.expected_speed.unwrap_or(0.0);
        let law = &initial.law;
        let (mut fastest, mut mach) = (0.0_f64, expected / initial.sound_speed());
        let mut warmest = 0.0_f64;
        for GasState { density, velocity, pressure } in
            initial.others().chain(std::iter::once(initial.rest))
        {
            let sound = law.sound_speed(density, pressure);
            let speed: f64 = velocity.iter().map(|u| u.abs()).sum();
            fastest = fastest.max(speed.max(expected) + axes.dims as f64 * sound);
            mach = mach.max(speed / sound);
            let temperature = pressure / (density * law.gas_constant);
            warmest = warmest.max(law.viscosity_at(temperature) / density);
        }
        for temperature in initial.surface_temperatures() {
            let density = initial.rest.pressure / (law.gas_constant * temperature);
            warmest = warmest.max(law.viscosity_at(temperature) / density);
        }
        let acoustic = self.courant * h / fastest;
        let spread = warmest * (law.heat_ratio / law.prandtl).max(4.0 / 3.0);
        let viscous = 0.4 * h * h / (spread * axes.dims as f64);
        let sound = initial.sound_speed();
        let step = if viscous < acoustic {
            (viscous, "friction and heat, which spread over the finest points".to_string())
        } else {
            (acoustic, format!("{} points at {fastest:.4} m/s, sound {sound:.4} m/s", self.courant))
        };
        (step, mach)
    }

    /// About as many points as there are at the start: two whole levels, and bands around surfaces.
    fn first_points(
        &self,
        scene: &Scene,
        axes: WorldAxes,
        levels: u8,
        initial: &InitialGas,
    ) -> f64 {
        let (h, size) = (self.cell.0, scene.domain.size());
        let edge = self.block_edge(axes.dims) as f64;
        let full: f64 = (0..axes.dims).map(|a| size[axes.order[a]] / h).product();
        let whole = full / 2.0_f64.powi(i32::from(levels.saturating_sub(1)) * axes.dims as i32);
        let band = 12.0 + 1.5 * edge;
        let of_body = |diameter: f64| {
            let across = diameter / h;
            let surface = if axes.dims == 2 { PI * across } else { PI * across * across };
            1.5 * (surface * band + edge.powi(axes.dims as i32))
        };
        let of_set = |sizes: BodySizes<'_>| match sizes {
            BodySizes::Listed(list) => list.into_iter().map(of_body).sum::<f64>(),
            BodySizes::Packed(packing) => {
                let mean = packing.diameters.extremes().iter().sum::<f64>() / 2.0;
                let space: f64 = (0..axes.dims)
                    .map(|a| packing.max[axes.order[a]] - packing.min[axes.order[a]])
                    .product();
                let of_one =
                    if axes.dims == 2 { PI / 4.0 * mean * mean } else { PI / 6.0 * mean.powi(3) };
                packing.fraction * space / of_one * of_body(mean)
            }
        };
        let bodies: f64 = scene.bodies.iter().map(|set| of_set(set.placement.sizes())).sum();
        // Fronts: a face of the whole domain each.
        let fronts = initial.others().count() as f64;
        let face = full.powf(1.0 - 1.0 / axes.dims as f64);
        let parts = scene.parts.len() as f64;
        (whole + bodies + 2.0 * (fronts + parts) * face * band).min(full)
    }
}
