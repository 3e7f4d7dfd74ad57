//! Nanoseconds of a trial of a deforming surface, and of a whole substep with one: a ring of 1,176
//! vertices and 2,352 facets, seated or lifted, with 0, 20 and 100 spheres of 0.8 mm under it.
//!
//! The processor's time counts: other programs do not enter it.
//!
//! `cargo bench -p tremie-grains-dem --no-default-features --bench surface_trials`

use tremie_grains_dem::{DeformableSurface, GrainsDem, Parameters, SurfaceState};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Domain, Face, Geometry, Motion, PairLaw, Part, PartBoundary,
    Placement, Pose, Scene, Slider, SliderSpring, Sphere, Spring,
};
use tremie_test_support::processor_seconds;

const D: f64 = 0.8e-3;
/// Time step of the grains of a valve [s].
const DT: f64 = 4e-8;
const STEPS: u32 = 1_000;
const TRIALS: u32 = 10_000;

/// A ring from 6.5 mm to 11 mm, 3 mm high, its lower face at z = 0, about the axis of the domain.
fn ring() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (rounds, wide, high) = (84, 4, 3);
    let at = |a: f64, b: f64, k: usize, n: usize| a + (b - a) * k as f64 / n as f64;
    let mut section = Vec::new();
    section.extend((0..wide).map(|k| [at(6.5e-3, 11e-3, k, wide), 0.0]));
    section.extend((0..high).map(|k| [11e-3, at(0.0, 3e-3, k, high)]));
    section.extend((0..wide).map(|k| [at(11e-3, 6.5e-3, k, wide), 3e-3]));
    section.extend((0..high).map(|k| [6.5e-3, at(3e-3, 0.0, k, high)]));
    let n = section.len();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..rounds {
        let angle = std::f64::consts::TAU * i as f64 / rounds as f64;
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        vertices.extend(section.iter().map(|[r, z]| [r * cosine, r * sine, *z]));
        for k in 0..n {
            let at = |i: usize, k: usize| ((i % rounds) * n + k % n) as u32;
            let (a, b, c, d) = (at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
            triangles.extend([[a, d, b], [b, d, c]]);
        }
    }
    (vertices, triangles)
}

fn part(name: &str, geometry: Geometry, z: f64, motion: Motion) -> Part {
    Part {
        name: name.into(),
        geometry,
        pose: Pose { position: [0.0, 0.0, z], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

/// A seat with its top at z = 0, a carrier above, and spheres on the seat.
fn scene(spheres: usize) -> Scene {
    let law = |stiffness: f64, damping: f64| ContactLaw {
        spring: Spring::Linear {
            normal_stiffness: stiffness,
            tangential_stiffness: 0.8 * stiffness,
        },
        friction: 0.4,
        rolling_friction: 0.0,
        damping: Damping::Coefficients { normal: damping, tangential: 0.0 },
        tension: false,
    };
    let place = |k: usize| {
        let angle = std::f64::consts::TAU * (k / 2) as f64 / (spheres.max(60) / 2) as f64;
        let r = 7.5e-3 + 1.5e-3 * (k % 2) as f64;
        Sphere {
            position: [r * libm::cos(angle), r * libm::sin(angle), 0.5 * D],
            diameter: D,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        }
    };
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass: 9.2e-3,
        lift: 0.0,
        velocity: 0.0,
        spring: SliderSpring::None,
        force: 0.0,
        stops: None,
    };
    let pairs =
        [("sand", "sand", 1e7, 3.0), ("sand", "wall", 1e7, 3.0), ("sand", "rubber", 1e5, 0.0)];
    Scene {
        bodies: [BodySet {
            name: "sand".into(),
            density: 2500.0,
            material: "sand".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed((0..spheres).map(place).collect()),
        }]
        .into_iter()
        .take(usize::from(spheres > 0))
        .collect(),
        parts: vec![
            part(
                "carrier",
                Geometry::Cylinder { radius: 11e-3, length: 1e-3 },
                8e-3,
                Motion::Slider(Box::new(slider)),
            ),
            part("seat", Geometry::Cylinder { radius: 14e-3, length: 2e-3 }, -1e-3, Motion::Fixed),
        ],
        contacts: pairs
            .map(|(a, b, stiffness, damping)| PairLaw {
                between: [a.into(), b.into()],
                law: law(stiffness, damping),
            })
            .to_vec(),
        ..Scene::empty(Domain::new([-15e-3, -15e-3, -5e-3], [15e-3, 15e-3, 15e-3], Face::WALLS))
    }
}

fn main() {
    for (name, spheres, height) in [
        ("seated, no sphere", 0, -1e-5),
        ("lifted, no sphere", 0, 1e-3),
        ("on 20 spheres", 20, D - 1e-5),
        ("on 100 spheres", 100, D - 1e-5),
    ] {
        let (at_zero, triangles) = ring();
        let vertices: Vec<_> = at_zero.iter().map(|&[x, y, z]| [x, y, z + height]).collect();
        let surface = DeformableSurface {
            triangles,
            vertices: vertices.clone(),
            carrier: 0,
            material: "rubber".into(),
            seat_stiffness: 1e7 / 2.47e-4,
        };
        let (parameters, facets) = (Parameters::default(), surface.triangles.len());
        let scene = scene(spheres);
        let mut dem = GrainsDem::with_surfaces(&scene, &parameters, DT, 1, &[surface])
            .expect("a right scene");
        let velocities = vec![[0.0; 3]; vertices.len()];
        let mut loads = Vec::new();
        let mut try_often = |dem: &mut GrainsDem, trials: u32| {
            let start = processor_seconds();
            for _ in 0..trials {
                dem.contact_on_surface(0, &vertices, &velocities, &mut loads).expect("a shape");
            }
            (processor_seconds() - start, loads.len())
        };
        let carrier_force = [0.0; 3];
        let accepted = SurfaceState { vertices: &vertices, velocities: &velocities, carrier_force };
        dem.begin_window(STEPS, &[]).expect("a window");
        let start = processor_seconds();
        for _ in 0..STEPS {
            dem.begin_substep().expect("a substep");
            try_often(&mut dem, 1);
            dem.finish_substep(&[accepted]).expect("contacts");
        }
        let whole = (processor_seconds() - start) / f64::from(STEPS);
        dem.begin_substep().expect("a substep");
        let (trying, loads) = try_often(&mut dem, TRIALS);
        println!(
            "{} vertices, {facets} facets, {name}: {:.0} ns a trial, {:.0} ns a substep with one; {loads} loads",
            vertices.len(),
            1e9 * trying / f64::from(TRIALS),
            1e9 * whole,
        );
    }
}
