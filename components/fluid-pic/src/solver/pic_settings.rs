//! Settings of the solver.

use crate::particles::particle_arrays::Transfer;
use crate::pressure::conjugate_gradients::Tolerance;
use crate::solver::free_surface::SurfaceOrder;
use crate::solver::gap_damping::GapDamping;

/// A face of the box, as the fluid's shear feels it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxWall<const D: usize> {
    /// It holds the fluid back, at its own velocity [m/s].
    Stick([f64; D]),
    /// It does not.
    Slip,
}

/// Settings of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PicSettings<const D: usize> {
    /// Density of the fluid [kg/m³].
    pub density: f64,
    /// Kinematic viscosity [m²/s]; 0 for none.
    pub viscosity: f64,
    /// Acceleration of gravity, and whatever else drives the fluid [m/s²].
    pub gravity: [f64; D],
    /// Acceleration that drives the fluid but no bodies [m/s²].
    pub drive: [f64; D],
    /// Transfer between particles and grid.
    pub transfer: Transfer,
    /// Order of the free surface.
    pub surface: SurfaceOrder,
    /// End of the pressure's iteration.
    pub tolerance: Tolerance,
    /// Particles along each axis of a cell at the start.
    pub particles_per_axis: usize,
    /// True for a fluid that fills its space, whatever its particles say.
    pub fills_all: bool,
    /// Faces of the box, lower and upper along each axis.
    pub walls: [[BoxWall<D>; 2]; D],
    /// True if bodies and parts hold the fluid back.
    pub bodies_stick: bool,
    /// Share of a cell's excess of mass that is moved away in a step in which the fastest fluid
    /// crosses half a cell.
    pub relaxation: f64,
    /// Damping in narrow gaps, if there is any.
    pub gap_damping: Option<GapDamping>,
}

impl<const D: usize> PicSettings<D> {
    /// Water without viscosity, by FLIP with a share of 0.01 of PIC, with a surface of second
    /// order.
    pub fn water(gravity: [f64; D]) -> Self {
        Self {
            density: 1000.0,
            viscosity: 0.0,
            gravity,
            drive: [0.0; D],
            transfer: Transfer::Blend { pic: 0.01 },
            surface: SurfaceOrder::Second,
            tolerance: Tolerance { relative: 1e-8, absolute: 1e-12, iterations: 100 },
            particles_per_axis: 2,
            fills_all: false,
            walls: [[BoxWall::Slip; 2]; D],
            bodies_stick: false,
            relaxation: 0.0,
            gap_damping: None,
        }
    }

    /// True if shear acts on walls or bodies.
    pub fn sticks(&self) -> bool {
        let sticks = |wall: &BoxWall<D>| matches!(wall, BoxWall::Stick(_));
        self.bodies_stick || self.walls.iter().flatten().any(sticks)
    }
}
