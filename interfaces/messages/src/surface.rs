//! Deformable surfaces: positions of their vertices, and the loads on their facets.
//!
//! The vertices of a facet never change; they follow from the scene
//! ([`crate::scene::DeformableSurface`]). Where a scene has several surfaces, their vertices and
//! facets are numbered through, in the scene's order.

use crate::Message;

/// A vertex of a deformable surface, world frame. 48 bytes.
///
/// The `trial` and `surface` channels carry all vertices, in the order of their numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceVertex {
    /// Position [m].
    pub position: [f64; 3],
    /// Its velocity [m/s].
    pub velocity: [f64; 3],
}

/// Load on a facet of a deformable surface, world frame. 64 bytes.
///
/// The `contact` and `surface_load` channels carry as many as there are loads, at most
/// [`FacetLoad::MOST_PER_FACET`] times the number of facets; their order is the sender's. A facet
/// that is left out bears nothing; one that is named again bears the sum.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacetLoad {
    /// Number of the facet.
    pub facet: u64,
    /// Resultant force [N].
    pub force: [f64; 3],
    /// A point on its line of action, near the facet [m].
    pub point: [f64; 3],
    /// Rate at which the normal force of the contacts falls as the facet retreats through the
    /// substep [N/m]. It is the stiffness of their springs, and the coefficients of their dashpots
    /// over the substep's length; 0 from a fluid.
    pub stiffness: f64,
}

// SAFETY: 6 words of 8 bytes, no padding.
unsafe impl Message for SurfaceVertex {
    const TYPE_NAME: &'static str = "tremie.SurfaceVertex.1";
}
// SAFETY: 8 words of 8 bytes, no padding.
unsafe impl Message for FacetLoad {
    const TYPE_NAME: &'static str = "tremie.FacetLoad.1";
}

impl SurfaceVertex {
    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.position.iter().chain(&self.velocity).all(|x| x.is_finite())
    }
}

impl FacetLoad {
    /// Room of a message for each facet.
    pub const MOST_PER_FACET: usize = 4;

    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        let all = |v: &[f64]| v.iter().all(|x| x.is_finite());
        all(&self.force) && all(&self.point) && self.stiffness.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_that_the_type_names_stand_for() {
        assert_eq!(size_of::<SurfaceVertex>(), 48);
        assert_eq!(size_of::<FacetLoad>(), 64);
        assert_eq!(std::mem::offset_of!(FacetLoad, stiffness), 56);
        assert_eq!(std::mem::offset_of!(SurfaceVertex, velocity), 24);
    }

    #[test]
    fn a_number_that_is_none_is_found_wherever_it_stands() {
        assert!(SurfaceVertex::default().is_finite() && FacetLoad::default().is_finite());
        let vertex = SurfaceVertex { velocity: [0.0, f64::NAN, 0.0], ..Default::default() };
        let load = FacetLoad { stiffness: f64::INFINITY, ..Default::default() };
        assert!(!vertex.is_finite() && !load.is_finite());
    }
}
