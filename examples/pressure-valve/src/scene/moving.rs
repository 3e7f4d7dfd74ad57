//! Moving parts: plug, hub and disc of steel, and the rubber ring on them.
//!
//! Profiles of corners `[r, y]` [m] at a lift of zero, where metal touches metal.

use super::dimensions::Dimensions;

/// Plug, hub and disc. The plug's cone lies on the seat's.
pub fn steel(valve: &Dimensions) -> Vec<[f64; 2]> {
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    let (hub, top) = (valve.hub_height(), valve.hub_height() + valve.disc_thickness());
    let mut profile = vec![
        [0.0, -valve.cone_depth()],
        [valve.bore_radius.0, -valve.cone_depth()],
        [inner, 0.0],
        [inner, hub],
        [outer, hub],
        [outer, top],
        [0.0, top],
    ];
    // A lip as high as the ring leaves no hub.
    profile.dedup();
    profile
}

/// The undeformed ring.
pub fn ring(valve: &Dimensions) -> Vec<[f64; 2]> {
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    let (low, high) = (-valve.lip.0, valve.hub_height());
    vec![[inner, low], [outer, low], [outer, high], [inner, high]]
}

/// Steel and undeformed ring as one solid, for runs in which the rubber is rigid: there must be no
/// seam between them.
pub fn steel_and_ring(valve: &Dimensions) -> Vec<[f64; 2]> {
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    let top = valve.hub_height() + valve.disc_thickness();
    let mut profile = vec![
        [0.0, -valve.cone_depth()],
        [valve.bore_radius.0, -valve.cone_depth()],
        [inner, 0.0],
        [inner, -valve.lip.0],
        [outer, -valve.lip.0],
        [outer, top],
        [0.0, top],
    ];
    profile.dedup();
    profile
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_geometry::Mesh;
    use tremie_messages::scene::Geometry;

    fn volume(profile: Vec<[f64; 2]>) -> f64 {
        Mesh::of(&Geometry::Revolved { profile }).unwrap().moments().volume
    }

    #[test]
    fn the_moving_mass_is_that_of_steel_and_rubber() {
        let valve = Dimensions::default();
        let (steel, ring) = (volume(steel(&valve)), volume(ring(&valve)));
        let mass = valve.steel.0 * steel + valve.rubber.0 * ring;
        assert!((mass / valve.moving_mass.0 - 1.0).abs() < 1e-12, "{mass}");
        assert!((volume(steel_and_ring(&valve)) / (steel + ring) - 1.0).abs() < 1e-12);
    }
}
