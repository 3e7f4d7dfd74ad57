//! The pressure at the free surface: zero where the surface is, not at the next cell's centre
//! (Gibou, Fedkiw, Cheng & Kang, *J. Comput. Phys.* 176 (2002) 205).

/// Where the surface is taken to be between a wet cell and one of air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceOrder {
    /// At the centre of the air cell.
    First,
    /// Where the distance to it passes zero.
    Second,
}

/// Least distance of the surface from a wet cell's centre, in edges of cells.
const NEAREST: f64 = 0.1;

impl SurfaceOrder {
    /// Distance of the surface from the centre of a wet cell in edges of cells, on the line to the
    /// centre of a cell of air. `wet` and `air` are their depths, the latter negative or 0.
    #[inline]
    pub fn distance(self, wet: f64, air: f64) -> f64 {
        match self {
            Self::First => 1.0,
            Self::Second => (wet / (wet - air)).clamp(NEAREST, 1.0),
        }
    }
}
