//! What the probes of a scene measure in the gas.

use crate::domain::world_axes::WorldAxes;
use crate::solver::wavelet_solver::WaveletSolver;
use std::cell::RefCell;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::cells::flattened::flattened;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::probes::probe_plan::{ProbePlan, ProbeSum};
use tremie_fluid_kit::probes::probe_signals::{ProbeValues, append};
use tremie_messages::scene::{ProbeShape, Scene};
use tremie_team::Team;

/// The probes of a scene, which read the finest points.
pub struct GasProbes {
    plan: ProbePlan,
    /// The cells between points that they read, along the grid's axes.
    cells: Vec<[usize; 3]>,
    reader: Team,
    axes: WorldAxes,
    /// Area of the face of a cell across a section [m²].
    area: f64,
    /// Points along the grid's axes.
    points: [usize; 3],
    periodic: [bool; 3],
}

impl GasProbes {
    /// Of a scene, with the points of the finest grid along the world's axes, their spacing [m].
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn new(
        scene: &Scene,
        axes: WorldAxes,
        points: [usize; 3],
        spacing: f64,
    ) -> std::io::Result<Self> {
        let flat = flattened(scene, spacing);
        let periodic = [0, 1, 2].map(|axis| flat.domain.is_periodic(axis));
        let grid = Grid::walled(points, periodic);
        let centres = Centres { cell: spacing, min: flat.domain.min };
        let cells = RefCell::new(Vec::new());
        let own = |world: [i32; 3]| -> [usize; 3] {
            std::array::from_fn(|a| if a < axes.dims { world[axes.order[a]] as usize } else { 0 })
        };
        let stored = |at: [i32; 3]| {
            let mut cells = cells.borrow_mut();
            cells.push(own(at));
            u32::try_from(cells.len() - 1).ok()
        };
        let plan = ProbePlan::new(&scene.probes, &grid, &centres, stored);
        Ok(Self {
            plan,
            cells: cells.into_inner(),
            reader: Team::new("fluid-wavelet-probes", 1)?,
            axes,
            area: scene.domain.depth().unwrap_or(spacing) * spacing,
            points: own(points.map(|n| n as i32)).map(|n| n.max(1)),
            periodic: std::array::from_fn(|a| a < axes.dims && periodic[axes.order[a]]),
        })
    }

    /// Appends the values of the probes; ghosts are filled.
    pub fn measure(&mut self, solver: &WaveletSolver, out: &mut Vec<f64>) {
        let Self { plan, cells, reader, axes, area, points, periodic } = self;
        let finest = solver.settings.deepest;
        let rest = solver.settings.rest_pressure;
        let corner_of = |cell: [usize; 3], corner: usize| -> [usize; 3] {
            std::array::from_fn(|a| {
                let at = cell[a] + (corner >> a & 1);
                if at < points[a] {
                    at
                } else if periodic[a] {
                    0
                } else {
                    points[a] - 1
                }
            })
        };
        plan.measure(reader, |samples, sum| {
            let corners = 1_usize << axes.dims;
            for &(number, weight) in samples {
                let cell = cells[number as usize];
                let weight = weight / corners as f64;
                for corner in 0..corners {
                    let seen = solver.observed(finest, corner_of(cell, corner));
                    if seen.body.is_some() {
                        sum.covered += weight;
                        continue;
                    }
                    let velocity = axes.vector_to_world(seen.state.velocity);
                    let pressure = seen.state.pressure - rest;
                    sum.add_dense(weight, pressure, velocity, seen.state.density);
                }
            }
        });
        plan.tell(|_, shape, sum| append(shape, &values(shape, sum, *area), out));
    }
}

fn values(shape: &ProbeShape, sum: &ProbeSum, area: f64) -> ProbeValues {
    let across = if let ProbeShape::Section { axis, .. } = shape { *axis } else { 0 };
    ProbeValues {
        pressure: sum.mean(sum.pressure),
        velocity: sum.velocity.map(|u| sum.mean(u)),
        solid_fraction: sum.solid_fraction(),
        flow_rate: sum.velocity[across] * area,
        mass_flow_rate: sum.momentum[across] * area,
    }
}
