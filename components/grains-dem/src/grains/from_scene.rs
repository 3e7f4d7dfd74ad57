//! Making the grains of a scene that is checked.

use crate::bodies::deformable_surface::{DeformableSurface, SurfaceState};
use crate::bodies::placed_parts;
use crate::contact::contact_force::Steps;
use crate::math::parameters::Parameters;
use crate::setup::check_surface;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::{overlaps, placement};
use tremie_messages::{Problem, scene::Scene};
use tremie_team::Team;

impl GrainsDem {
    /// Makes the bodies of `scene`, packings included, ready to advance by `time_step` [s] on
    /// `threads` threads, whose number has no effect on any result.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, the parameters or the time step.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        Self::with_surfaces(scene, parameters, time_step, threads, &[])
    }

    /// Solver of a scene with surfaces that deform on its sliders. Packings do not keep clear of
    /// them.
    ///
    /// # Errors
    /// As [`new`](Self::new), and surfaces that are none or do not fit the scene.
    pub fn with_surfaces(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
        surfaces: &[DeformableSurface],
    ) -> Result<Self, Vec<Problem>> {
        let resolution = parameters.resolve(scene)?;
        resolution.check_time_step(time_step).map_err(|problem| vec![problem])?;
        let problems = check_surface::check(scene, surfaces, time_step);
        if !problems.is_empty() {
            return Err(problems);
        }
        let parts = placed_parts::load(scene)?;
        let spheres = placement::place(scene, &parts)?;
        let mut team = Team::new("grains", threads).map_err(|error| {
            let message = format!("the system does not give {threads} threads: {error}");
            vec![Problem::new("threads", message)]
        })?;
        overlaps::check(scene, &spheres, &parts, &mut team)?;
        let placed = (&spheres[..], parts, surfaces);
        let mut solver = Self::of_bodies(scene, parameters, time_step, placed, team);
        // Their room is needed for the lists.
        drop(spheres);
        solver.rebuild_lists();
        let still = surfaces.iter().map(|s| vec![[0.0; 3]; s.vertices.len()]).collect::<Vec<_>>();
        let states = surfaces.iter().zip(&still).map(|(surface, velocities)| SurfaceState {
            vertices: &surface.vertices,
            velocities,
            carrier_force: [0.0; 3],
        });
        let steps = Steps { before: 0.0, after: time_step };
        let begun = solver.evaluate_forces(steps, &states.collect::<Vec<_>>());
        begun
            .and_then(|()| if surfaces.is_empty() { Ok(()) } else { solver.check_overlap() })
            .map_err(|error| vec![Problem::new("surfaces", error.to_string())])?;
        Ok(solver)
    }
}
