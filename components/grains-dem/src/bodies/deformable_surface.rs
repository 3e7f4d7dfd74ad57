//! Surfaces that deform.

use crate::Vec3;

/// A closed surface of triangles whose vertices somebody else moves, as those of a rubber seal on a
/// slider. Spheres meet its facets under the law of their materials. Parts that stand still and
/// walls are its seat: they push its vertices out by a stiffness for each area, without friction.
///
/// Its connectivity stays. It is the whole surface, also where symmetry planes cut its carrier:
/// what spheres do to a facet counts with what their images do, the seat acts on the vertices on
/// both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct DeformableSurface {
    /// Vertices of each triangle, counterclockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices at the start [m], in the world's frame; their shape is the one that areas are of.
    pub vertices: Vec<[f64; 3]>,
    /// Index into the scene's list of parts of the slider that carries it.
    pub carrier: usize,
    /// Its material.
    pub material: String,
    /// Pressure of the seat over the depth of a vertex in it [N/m³]: a vertex has the third of the
    /// area of each facet at it, as far as the facet faces the seat.
    pub seat_stiffness: f64,
}

/// A surface at the end of a substep.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceState<'a> {
    /// Vertices [m], in the world's frame.
    pub vertices: &'a [[f64; 3]],
    /// Their velocities [m/s].
    pub velocities: &'a [[f64; 3]],
    /// Force on the carrier besides that of contacts, as that of a fluid on the surface [N].
    pub carrier_force: [f64; 3],
}

/// A force on a facet, one for each contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetLoad {
    /// Index of the triangle.
    pub facet: u32,
    /// Force [N]; of spheres at a carrier that symmetry planes cut, that of their images besides.
    pub force: [f64; 3],
    /// Point of action of the force [m].
    pub point: [f64; 3],
    /// Stiffness [N/m]: fall of the normal force as the facet retreats through the substep, by the
    /// spring and by the dashpot over the substep's length. For spheres at a carrier that symmetry
    /// planes cut, that of their images is included.
    pub stiffness: f64,
}

/// Mean length of its edges [m].
pub(crate) fn mean_edge(surface: &DeformableSurface) -> f64 {
    let edges = surface.triangles.iter().map(|triangle| {
        let [a, b, _] = triangle.map(|v| Vec3::from(surface.vertices[v as usize]));
        (b - a).norm_squared().sqrt()
    });
    edges.sum::<f64>() / surface.triangles.len() as f64
}

/// Area of each triangle times its normal [m²].
pub(crate) fn area_vectors(surface: &DeformableSurface) -> impl Iterator<Item = Vec3> + '_ {
    surface.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|v| Vec3::from(surface.vertices[v as usize]));
        (b - a).cross(&(c - a)) * 0.5
    })
}
