//! Between SI units and lattice units (cell = step = reference density = 1).

/// Scales between lattice and SI.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// Edge of a cell [m].
    pub cell: f64,
    /// Time step [s].
    pub time_step: f64,
    /// Density of the fluid [kg/m³].
    pub density: f64,
    /// Lower corner of the domain [m].
    pub min: [f64; 3],
}

impl Units {
    /// One lattice velocity [m/s].
    pub fn velocity(&self) -> f64 {
        self.cell / self.time_step
    }

    /// One lattice pressure [Pa].
    pub fn pressure(&self) -> f64 {
        self.density * self.velocity() * self.velocity()
    }

    /// One lattice force [N].
    pub fn force(&self) -> f64 {
        self.pressure() * self.cell * self.cell
    }

    /// One lattice mass [kg].
    pub fn mass(&self) -> f64 {
        self.density * self.cell * self.cell * self.cell
    }

    /// One lattice impulse [kg m/s].
    pub fn impulse(&self) -> f64 {
        self.mass() * self.velocity()
    }

    /// One lattice acceleration [m/s²].
    pub fn acceleration(&self) -> f64 {
        self.velocity() / self.time_step
    }

    /// A position in cells from the domain's lower corner.
    pub fn position_to_lattice(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (position[a] - self.min[a]) / self.cell)
    }

    /// Centre of a cell [m].
    pub fn centre(&self, at: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.min[a] + (f64::from(at[a]) + 0.5) * self.cell)
    }
}
