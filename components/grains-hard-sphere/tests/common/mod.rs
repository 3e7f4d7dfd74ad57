//! Small scenes for the tests. Unless it says otherwise lengths are diameters, masses those of a
//! body, and the temperature at the start is 1.
#![allow(dead_code)] // Each test uses some of these.

use std::f64::consts::{PI, TAU};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Domain, Face, Geometry, Motion, PairLaw, Part, PartBoundary,
    Placement, Pose, Scene, Sphere, Spring,
};
use tremie_messages::units::{Time, Velocity};

pub const PERIODIC: [[Face; 2]; 3] = [const { [Face::Periodic, Face::Periodic] }; 3];

pub fn law(restitution: f64, friction: f64) -> ContactLaw {
    ContactLaw {
        spring: Spring::Linear { normal_stiffness: 1e5, tangential_stiffness: 1e5 },
        friction,
        rolling_friction: 0.0,
        damping: Damping::Restitution(restitution),
        tension: false,
    }
}

/// A box from the origin, dry, without weight, with one law for all.
pub fn scene(size: [f64; 3], faces: [[Face; 2]; 3], restitution: f64, friction: f64) -> Scene {
    let pair = |other: &str| PairLaw {
        between: ["grains".into(), other.into()],
        law: law(restitution, friction),
    };
    let contacts = vec![pair("grains"), pair("wall")];
    Scene { contacts, ..Scene::empty(Domain::new([0.0; 3], size, faces)) }
}

pub fn set(motion: Motion, density: f64, spheres: Vec<Sphere>) -> BodySet {
    BodySet {
        name: format!("{motion:?}").chars().take(5).collect(),
        density,
        material: "grains".into(),
        motion,
        clump: None,
        placement: Placement::Listed(spheres),
    }
}

pub fn sphere(position: [f64; 3], diameter: f64, velocity: [f64; 3]) -> Sphere {
    Sphere { position, diameter, velocity, angular_velocity: [0.0; 3] }
}

/// Density at which a sphere of diameter 1, or a disc in a plane of depth 1, has the mass 1.
pub fn density(dimensions: usize) -> f64 {
    if dimensions == 3 { 6.0 / PI } else { 4.0 / PI }
}

/// A block of triangles.
pub fn block(size: [f64; 3], position: [f64; 3], motion: Motion) -> Part {
    Part {
        name: "block".into(),
        geometry: Geometry::Box { size },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

/// Parameters that say how collisions are found.
pub fn by(detection: Detection) -> Parameters {
    Parameters { detection, ..Parameters::default() }
}

/// A number from 0 to 1 that follows from a key.
pub fn unit(seed: u64, key: u64) -> f64 {
    let mixed =
        (seed.wrapping_mul(0xD134_2543_DE82_EF95) ^ (key + 1)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((mixed ^ (mixed >> 32)).wrapping_mul(0x94D0_49BB_1331_11EB) >> 11) as f64 / (1u64 << 53) as f64
}

/// A normal number.
pub fn normal(seed: u64, key: u64) -> f64 {
    let (a, b) = (unit(seed, 2 * key), unit(seed, 2 * key + 1));
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

/// Velocities of a gas of temperature 1 and no momentum.
pub fn velocities(count: usize, dimensions: usize, seed: u64) -> Vec<[f64; 3]> {
    let of = |k: usize| {
        std::array::from_fn(|a| if a < dimensions { normal(seed, (3 * k + a) as u64) } else { 0.0 })
    };
    let mut all: Vec<[f64; 3]> = (0..count).map(of).collect();
    for a in 0..dimensions {
        let mean = all.iter().map(|v| v[a]).sum::<f64>() / count as f64;
        all.iter_mut().for_each(|v| v[a] -= mean);
    }
    let energy: f64 = all.iter().flatten().map(|v| v * v).sum();
    let factor = (dimensions as f64 * count as f64 / energy).sqrt();
    all.iter_mut().flatten().for_each(|v| *v *= factor);
    all
}

/// A gas in a periodic box, in space or in a plane across z, from a lattice.
pub fn gas(
    dimensions: usize,
    edge: usize,
    fraction: f64,
    (restitution, friction): (f64, f64),
    seed: u64,
) -> Scene {
    let (sites, size) = lattice(dimensions, edge, fraction);
    let bodies: Vec<Sphere> = sites
        .iter()
        .zip(velocities(sites.len(), dimensions, seed))
        .map(|(&site, v)| sphere(site, 1.0, v))
        .collect();
    let mut scene = scene(size, PERIODIC, restitution, friction);
    if dimensions == 2 {
        scene.domain.across = Some(2);
        scene.domain.faces[2] = [Face::WALL, Face::WALL];
    }
    scene.bodies = vec![set(Motion::Free, density(dimensions), bodies)];
    scene
}

/// Sites of a face-centred cubic lattice, or of a triangular one, and the box around them.
fn lattice(dimensions: usize, edge: usize, fraction: f64) -> (Vec<[f64; 3]>, [f64; 3]) {
    let mut sites = Vec::new();
    if dimensions == 3 {
        let cell = (4.0 * PI / 6.0 / fraction).cbrt();
        let base = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
        for k in 0..edge * edge * edge {
            let n = [k % edge, k / edge % edge, k / (edge * edge)];
            sites.extend(base.map(|b| std::array::from_fn(|a| cell * (n[a] as f64 + b[a] + 0.2))));
        }
        return (sites, [cell * edge as f64; 3]);
    }
    let across = (PI / 2.0 / fraction / 3f64.sqrt()).sqrt();
    let up = across * 3f64.sqrt();
    let rows = (edge as f64 / 3f64.sqrt()).round() as usize;
    for k in 0..edge * rows {
        let (x, y) = ((k % edge) as f64, (k / edge) as f64);
        sites.push([across * (x + 0.2), up * (y + 0.2), 0.5]);
        sites.push([across * (x + 0.7), up * (y + 0.7), 0.5]);
    }
    (sites, [across * edge as f64, up * rows as f64, 1.0])
}

/// Parameters without guards.
pub fn bare(detection: Detection) -> Parameters {
    Parameters {
        detection,
        contact_time: Some(Time(0.0)),
        elastic_speed: Some(Velocity(0.0)),
        ..Parameters::default()
    }
}

pub fn make(scene: &Scene, parameters: &Parameters, step: f64) -> HardSpheres {
    HardSpheres::new(scene, parameters, step, 1).unwrap()
}

/// Kinetic energy of translation over that at temperature 1.
pub fn temperature(spheres: &HardSpheres, dimensions: usize) -> f64 {
    2.0 * spheres.diagnostics().kinetic_energy / (dimensions * spheres.sphere_count()) as f64
}

/// Angular momentum about the origin, of bodies of mass 1 and diameter 1.
pub fn angular_momentum(spheres: &HardSpheres, kappa: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for id in 0..spheres.sphere_count() {
        let state = spheres.sphere(id);
        let (x, v, w) = (state.position, state.velocity, state.angular_velocity);
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            sum[a] += x[b] * v[c] - x[c] * v[b] + kappa * 0.25 * w[a];
        }
    }
    sum
}
