//! Scenes of polyhedra.

use super::*;
use tremie_messages::scene::{Polyhedra, Polyhedron, PolyhedronPlacement, Shape};

/// A regular solid as a shape of a scene.
pub fn shape(name: &str) -> Shape {
    Shape { name: name.into(), vertices: tremie_geometry::solid(name).unwrap() }
}

/// A slender wedge, whose moments of inertia all differ.
pub fn wedge() -> Shape {
    let vertices = vec![
        [0.0, 0.0, 0.0],
        [2.2, 0.0, 0.0],
        [0.0, 1.2, 0.0],
        [0.3, 0.2, 0.9],
        [1.8, 0.1, 0.8],
        [0.2, 1.0, 0.7],
    ];
    let hull = tremie_geometry::Convex::hull(&vertices).unwrap();
    let vertices = hull.vertices().iter().map(|&corner| corner.into()).collect();
    Shape { name: "wedge".into(), vertices }
}

/// The diameter of a sphere as large as a cube of an edge.
pub fn of_cube(edge: f64) -> f64 {
    edge * (6.0 / std::f64::consts::PI).cbrt()
}

pub fn solid(position: [f64; 3], diameter: f64, velocity: [f64; 3]) -> Polyhedron {
    Polyhedron {
        position,
        orientation: [0.0, 0.0, 0.0, 1.0],
        diameter,
        velocity,
        angular_velocity: [0.0; 3],
    }
}

/// A unit quaternion of an axis, of any length but zero, and an angle.
pub fn turned(axis: [f64; 3], angle: f64) -> [f64; 4] {
    let (s, c) = (0.5 * angle).sin_cos();
    let s = s / norm(axis);
    [axis[0] * s, axis[1] * s, axis[2] * s, c]
}

/// Free polyhedra of a shape.
pub fn solids(shape: &str, list: Vec<Polyhedron>) -> BodySet {
    BodySet {
        name: shape.into(),
        placement: Placement::Polyhedra(Polyhedra {
            shape: shape.into(),
            placement: PolyhedronPlacement::Listed(list),
        }),
        ..set(Motion::Free, Vec::new())
    }
}

/// Energy in motion and springs, without weight.
pub fn energy(dem: &mut GrainsDem) -> f64 {
    let d = dem.diagnostics();
    d.kinetic_energy + d.rotational_energy + d.elastic_energy
}

/// All of it.
pub fn whole_energy(dem: &mut GrainsDem) -> f64 {
    energy(dem) + dem.diagnostics().potential_energy
}

/// A vector of a body in the world.
pub fn to_world(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let u = [q[0], q[1], q[2]];
    let t = cross(u, v).map(|x| 2.0 * x);
    let more = cross(u, t);
    std::array::from_fn(|a| v[a] + q[3] * t[a] + more[a])
}
