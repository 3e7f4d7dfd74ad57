//! Small scenes for the tests.
#![allow(dead_code)] // Each test uses some of these.

pub mod solids;
pub mod walls;

use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{
        BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
        Scene, Sphere, Spring,
    },
};

pub const DENSITY: f64 = 2500.0;

pub fn mass(diameter: f64) -> f64 {
    DENSITY * std::f64::consts::PI / 6.0 * diameter.powi(3)
}

pub fn inertia(diameter: f64) -> f64 {
    0.4 * mass(diameter) * (0.5 * diameter).powi(2)
}

pub fn coefficients(normal: f64, tangential: f64) -> Damping {
    Damping::Coefficients { normal, tangential }
}

/// A law without tension whose tangential spring is 0.8 of the normal one.
pub fn law(stiffness: f64, friction: f64, damping: Damping) -> ContactLaw {
    ContactLaw {
        spring: Spring::Linear {
            normal_stiffness: stiffness,
            tangential_stiffness: 0.8 * stiffness,
        },
        friction,
        rolling_friction: 0.0,
        damping,
        tension: false,
    }
}

pub const PERIODIC: [[Face; 2]; 3] = [const { [Face::Periodic, Face::Periodic] }; 3];
pub const WALLS: [[Face; 2]; 3] = Face::WALLS;
/// Periodic along x and y, between walls along z.
pub const FLOOR: [[Face; 2]; 3] =
    [[Face::Periodic, Face::Periodic], [Face::Periodic, Face::Periodic], [Face::WALL, Face::WALL]];

/// A box from the origin, dry, without weight, with one law for all contacts.
pub fn scene(size: [f64; 3], faces: [[Face; 2]; 3], law: ContactLaw) -> Scene {
    let contacts = ["grains", "wall"]
        .map(|other| PairLaw { between: ["grains".into(), other.into()], law: law.clone() });
    Scene { contacts: contacts.to_vec(), ..Scene::empty(Domain::new([0.0; 3], size, faces)) }
}

pub fn sphere(position: [f64; 3], diameter: f64, velocity: [f64; 3]) -> Sphere {
    Sphere { position, diameter, velocity, angular_velocity: [0.0; 3] }
}

pub fn set(motion: Motion, spheres: Vec<Sphere>) -> BodySet {
    BodySet {
        name: format!("{motion:?}").to_lowercase(),
        density: DENSITY,
        material: "grains".into(),
        motion,
        clump: None,
        placement: Placement::Listed(spheres),
    }
}

pub fn packed(
    min: [f64; 3],
    max: [f64; 3],
    fraction: f64,
    diameters: (f64, f64),
    seed: u64,
) -> BodySet {
    BodySet {
        name: "packed".into(),
        density: DENSITY,
        material: "grains".into(),
        motion: Motion::Free,
        clump: None,
        placement: Placement::Packed(Packing {
            min,
            max,
            fraction,
            diameters: Diameters::Uniform { min: diameters.0, max: diameters.1 },
            seed,
        }),
    }
}

/// Spheres at random, moving at random: a gas.
pub fn gas(scene: &mut Scene, speed: f64, seed: u64) {
    let size = scene.domain.max;
    let filled = packed([0.0; 3], size, 0.2, (0.8e-3, 1.2e-3), seed);
    scene.bodies = vec![filled];
    let dem = GrainsDem::new(scene, &Parameters::default(), 1e-9, 1).unwrap();
    let hash = |k: u64| {
        let mixed = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11
    };
    let unit = |k: u64| hash(k) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0;
    let spheres = state(&dem)
        .iter()
        .zip(dem.radii())
        .map(|(s, radius)| {
            let v = |a: u64| speed * unit(3 * s.id + a);
            sphere(s.position, 2.0 * radius, [v(0), v(1), v(2)])
        })
        .collect();
    scene.bodies = vec![set(Motion::Free, spheres)];
}

pub fn make(scene: &Scene, time_step: f64) -> GrainsDem {
    GrainsDem::new(scene, &Parameters::default(), time_step, 1).unwrap()
}

pub fn state(dem: &GrainsDem) -> Vec<BodyState> {
    let mut out = vec![BodyState::at_rest(0, [0.0; 3]); dem.body_count()];
    dem.write_state(&mut out);
    out
}

pub fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
