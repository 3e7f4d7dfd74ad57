//! Loads on facets of surfaces that deform, and their sums.

/// Facets that one thread finishes together; their sums are added up first.
pub const FACETS_PER_PIECE: usize = 128;

/// Force and torque about the surface's reference, on a facet.
pub type OnFacet = [[f64; 3]; 2];

/// Sums over facets of a piece.
#[derive(Clone, Copy, Debug, Default)]
pub struct FacetSums {
    /// Force with that of the mirrored half.
    pub whole: [f64; 3],
    /// Of that, what averaging holds back.
    pub carried: [f64; 3],
    pub delivered: [f64; 3],
    pub buoyancy: [f64; 3],
}
