//! Places of the cells.

/// The centres of the cells.
#[derive(Clone, Copy, Debug, Default)]
pub struct Centres {
    /// Edge of a cell [m].
    pub cell: f64,
    /// Lower corner of the domain [m].
    pub min: [f64; 3],
}

impl Centres {
    /// Centre of a cell, which may lie outside the box [m].
    pub fn of(&self, at: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.min[a] + (f64::from(at[a]) + 0.5) * self.cell)
    }
}
