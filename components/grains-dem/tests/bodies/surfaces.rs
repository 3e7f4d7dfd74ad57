//! Surfaces that deform: as rigid ones they are parts, trials leave no trace, seats push by area.

use crate::common::*;
use tremie_geometry::Mesh;
use tremie_grains_dem::{
    DeformableSurface, FacetLoad, GrainsDem, GrainsError, Parameters, SurfaceState,
};
use tremie_messages::{
    body::BodyState,
    scene::{
        Damping, Face, Geometry, Motion, MotionPoint, Part, PartBoundary, Pose, Scene, Slider,
        SliderSpring, Spring,
    },
};

const D: f64 = 1e-3;
const DT: f64 = 1e-7;

/// A plate of 6 mm x 6 mm x 1 mm that slides along z, far above.
fn carrier(z: f64, mass: f64) -> Part {
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass,
        lift: 0.0,
        velocity: 0.0,
        spring: SliderSpring::None,
        force: 0.0,
        stops: None,
    };
    part("carrier", [6e-3, 6e-3, 1e-3], [10e-3, 10e-3, z], Motion::Slider(Box::new(slider)))
}

fn part(name: &str, size: [f64; 3], position: [f64; 3], motion: Motion) -> Part {
    Part {
        name: name.into(),
        geometry: Geometry::Box { size },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

/// A ring of rubber.
#[derive(Default)]
struct Ring {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A ring about z through the domain's middle, `rounds` x (`wide` and `high` segments) of squares
/// in two triangles, its lower face at `z`.
fn ring(rounds: usize, [wide, high]: [usize; 2], [r, outer, z, top]: [f64; 4]) -> Ring {
    let mut section = Vec::new();
    let between = |a: f64, b: f64, k: usize, n: usize| a + (b - a) * k as f64 / n as f64;
    section.extend((0..wide).map(|k| [between(r, outer, k, wide), z]));
    section.extend((0..high).map(|k| [outer, between(z, top, k, high)]));
    section.extend((0..wide).map(|k| [between(outer, r, k, wide), top]));
    section.extend((0..high).map(|k| [r, between(top, z, k, high)]));
    let n = section.len();
    let mut mesh = Ring::default();
    for i in 0..rounds {
        let (sine, cosine) = (std::f64::consts::TAU * i as f64 / rounds as f64).sin_cos();
        let place = |[r, z]: [f64; 2]| [10e-3 + r * cosine, 10e-3 + r * sine, z];
        mesh.vertices.extend(section.iter().map(|&corner| place(corner)));
        for k in 0..n {
            let at = |i: usize, k: usize| ((i % rounds) * n + k % n) as u32;
            let (a, b, c, d) = (at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
            mesh.triangles.extend([[a, d, b], [b, d, c]]);
        }
    }
    mesh
}

fn surface(mesh: &Ring) -> DeformableSurface {
    DeformableSurface {
        triangles: mesh.triangles.clone(),
        vertices: mesh.vertices.clone(),
        carrier: 0,
        material: "wall".into(),
        seat_stiffness: 1e10,
    }
}

fn shifted(vertices: &[[f64; 3]], z: f64) -> Vec<[f64; 3]> {
    vertices.iter().map(|&[x, y, h]| [x, y, h + z]).collect()
}

/// Spheres on the floor under a ring that is pressed on them and turned away sideways.
fn pressed() -> (Scene, Ring) {
    let mut scene = scene([20e-3; 3], WALLS, law(2e3, 0.4, Damping::Restitution(0.5)));
    scene.gravity = [0.0, 0.0, -9.81];
    let at = |k: usize| {
        let (sine, cosine) = (0.3 + 0.7 * k as f64).sin_cos();
        let r = 5.2e-3 + 0.3e-3 * k as f64;
        sphere([10e-3 + r * cosine, 10e-3 + r * sine, 0.5 * D], D, [0.0; 3])
    };
    scene.bodies = vec![set(Motion::Free, (0..8).map(at).collect())];
    scene.parts = vec![carrier(15e-3, 1.0)];
    (scene, ring(40, [5, 2], [4e-3, 8e-3, 1.001e-3, 3e-3]))
}

fn held(scene: &Scene, mesh: &Ring, threads: usize) -> GrainsDem {
    let parameters = Parameters::default();
    GrainsDem::with_surfaces(scene, &parameters, DT, threads, &[surface(mesh)]).unwrap()
}

const VELOCITY: [f64; 3] = [0.02, 0.01, -0.03];

/// Moves the ring with one velocity through so many substeps; trials of other shapes come between.
fn drag(dem: &mut GrainsDem, mesh: &Ring, steps: u32, trials: u32) -> Vec<FacetLoad> {
    let velocities = vec![VELOCITY; mesh.vertices.len()];
    let mut loads = Vec::new();
    dem.begin_window(steps, &[]).unwrap();
    for k in 1..=steps {
        let time = f64::from(k) * DT;
        let vertices: Vec<[f64; 3]> = mesh
            .vertices
            .iter()
            .map(|x| std::array::from_fn(|a| x[a] + time * VELOCITY[a]))
            .collect();
        dem.begin_substep().unwrap();
        for trial in 0..trials {
            let other = shifted(&vertices, 3e-5 * (f64::from(trial) - 1.3));
            dem.contact_on_surface(0, &other, &velocities, &mut loads).unwrap();
        }
        dem.contact_on_surface(0, &vertices, &velocities, &mut loads).unwrap();
        let carrier_force = [0.0; 3];
        let state = SurfaceState { vertices: &vertices, velocities: &velocities, carrier_force };
        dem.finish_substep(&[state]).unwrap();
    }
    dem.end_window().unwrap();
    loads
}

#[test]
fn a_rigid_surface_is_a_part_of_the_same_shape() {
    let (scene, mesh) = pressed();
    let mut soft = held(&scene, &mesh, 1);
    let loads = drag(&mut soft, &mesh, 10_000, 0);

    let mut file = tempfile::Builder::new().suffix(".stl").tempfile().unwrap();
    let vertices = mesh.vertices.iter().map(|&vertex| vertex.into()).collect();
    let solid = Mesh { vertices, triangles: mesh.triangles.clone() };
    solid.write_stl(&mut file, 1e-3).unwrap();
    let mut rigid = scene.clone();
    let course = vec![MotionPoint { time: 0.0, velocity: VELOCITY, angular_velocity: [0.0; 3] }];
    let path = file.path().to_string_lossy().into_owned();
    let mut part = part("ring", [1.0; 3], [0.0; 3], Motion::Prescribed(course));
    part.geometry = Geometry::File { path, unit: 1e-3 };
    rigid.parts.push(part);
    let mut hard = make(&rigid, DT);
    hard.advance(10_000, &[]).unwrap();

    let (a, b) = (state(&soft), state(&hard));
    for (a, b) in a.iter().zip(&b[..8]) {
        // The file holds coordinates as f32: 1e-9 m.
        assert!(norm(minus(a.position, b.position)) < 2e-9, "{a:?} {b:?}");
        assert!(norm(minus(a.velocity, b.velocity)) < 1e-4 * 0.03, "{a:?} {b:?}");
        let turning = norm(minus(a.angular_velocity, b.angular_velocity));
        assert!(turning < 1e-4 * norm(a.angular_velocity), "{a:?} {b:?}");
        // Friction makes them roll at half the speed of the ring, squeezed by three hundredths of
        // D.
        let rolling = norm(a.angular_velocity) * D / norm([0.02, 0.01, 0.0]);
        assert!((rolling - 1.0).abs() < 0.03, "{rolling}");
    }
    let (force, _) = hard.part_loads().nth(1).unwrap();
    let total = sum(&loads);
    assert!(force[2] > 0.2, "{force:?}");
    assert!(norm(minus(force, total)) < 1e-4 * norm(force), "{force:?} {total:?}");
}

fn sum(loads: &[FacetLoad]) -> [f64; 3] {
    std::array::from_fn(|a| loads.iter().map(|load| load.force[a]).sum())
}

/// Momentum of spheres between two ends of substeps against the impulse of the facets: one sphere
/// in the air.
#[test]
fn what_facets_get_the_sphere_and_the_carrier_give() {
    let (mut scene, mesh) = pressed();
    scene.gravity = [0.0; 3];
    let start = [16.1e-3, 10.2e-3, 0.6e-3];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, 0.8e-3, [0.1, 0.0, 0.3])])];
    let mut dem = held(&scene, &mesh, 1);
    let velocities = vec![[0.0; 3]; mesh.vertices.len()];
    let (mut impulse, mut loads) = ([0.0; 3], Vec::new());
    let before = state(&dem);
    let carrier_force = [0.5, 0.0, 0.25];
    dem.begin_window(4_000, &[]).unwrap();
    for k in 0..4_000 {
        dem.begin_substep().unwrap();
        dem.contact_on_surface(0, &mesh.vertices, &velocities, &mut loads).unwrap();
        // Half kicks: the first force of a contact acts in both halves but at the very ends.
        let last = if k == 3_999 { 0.5 } else { 1.0 };
        let force = sum(&loads);
        (0..3).for_each(|a| impulse[a] += last * DT * force[a]);
        let vertices = &mesh.vertices;
        let accepted = SurfaceState { vertices, velocities: &velocities, carrier_force };
        dem.finish_substep(&[accepted]).unwrap();
        let slider = dem.sliders().next().unwrap();
        assert_eq!((slider.surface_force, slider.carrier_force), (force[2], 0.25));
    }
    dem.end_window().unwrap();
    let after = state(&dem);
    let m = mass(0.8e-3);
    let gained = minus(after[0].velocity, before[0].velocity).map(|v| m * v);
    let scale = norm(gained);
    assert!(scale > 0.3 * m && loads.is_empty(), "it came and went: {gained:?}");
    let rest: [f64; 3] = std::array::from_fn(|a| gained[a] + impulse[a]);
    assert!(norm(rest) < 1e-12 * scale, "{rest:?} {gained:?}");
    // The first half kick of all was without the carrier's force.
    let carried = impulse[2] + 0.25 * 3_999.5 * DT;
    assert!((after[1].velocity[2] / carried - 1.0).abs() < 1e-12, "{after:?} {carried}");
}

#[test]
fn a_trial_leaves_no_trace_and_tells_what_acceptance_gives() {
    let (scene, mesh) = pressed();
    let run = |trials, threads| {
        let mut dem = held(&scene, &mesh, threads);
        let loads = drag(&mut dem, &mesh, 3_000, trials);
        let slider = dem.sliders().next().unwrap();
        let share = (slider.surface_force - sum(&loads)[2]).abs();
        assert!(share < 1e-15 * slider.surface_force, "{slider:?}");
        (state(&dem), slider, loads, dem.diagnostics())
    };
    let one = run(0, 1);
    assert!(one.1.surface_force > 0.01, "{:?}", one.1);
    assert_eq!(one, run(3, 1));
    assert_eq!(one, run(1, 2));
    assert_eq!(one, run(0, 4));
}

#[test]
fn a_patch_on_a_flat_seat_is_pushed_by_its_area() {
    let mesh = ring(60, [6, 3], [4e-3, 7e-3, 1e-3, 3e-3]);
    let area: f64 =
        0.5 * 60.0 * (std::f64::consts::TAU / 60.0).sin() * (7e-3f64.powi(2) - 4e-3f64.powi(2));
    let depth = 2.5e-5;
    let empty = scene([20e-3; 3], WALLS, law(2e3, 0.4, Damping::Restitution(0.5)));
    let seats: [(&str, Scene); 3] = [
        ("wall", empty.clone()),
        (
            "part",
            Scene {
                parts: vec![part(
                    "seat",
                    [18e-3, 18e-3, 2e-3],
                    [10e-3, 10e-3, 1e-3],
                    Motion::Fixed,
                )],
                ..empty.clone()
            },
        ),
        (
            "cylinder",
            Scene {
                parts: vec![Part {
                    geometry: Geometry::Cylinder { radius: 9e-3, length: 2e-3 },
                    ..part("seat", [1.0; 3], [10e-3, 10e-3, 1e-3], Motion::Fixed)
                }],
                ..empty
            },
        ),
    ];
    for (name, mut scene) in seats {
        let top = if name == "wall" { 0.0 } else { 2e-3 };
        scene.parts.insert(0, carrier(15e-3, 1.0));
        let mut dem = held(&scene, &mesh, 1);
        let vertices = shifted(&mesh.vertices, top - 1e-3 - depth);
        let velocities = vec![[0.0; 3]; vertices.len()];
        let mut loads = Vec::new();
        dem.begin_window(1, &[]).unwrap();
        dem.begin_substep().unwrap();
        dem.contact_on_surface(0, &vertices, &velocities, &mut loads).unwrap();
        let force = sum(&loads);
        assert!((force[2] / (1e10 * area * depth) - 1.0).abs() < 1e-9, "{name}: {force:?}");
        assert!(norm([force[0], force[1], 0.0]) < 1e-9 * force[2], "{name}: {force:?}");
        // Above the seat there is none.
        let above = shifted(&vertices, 2.0 * depth);
        dem.contact_on_surface(0, &above, &velocities, &mut loads).unwrap();
        assert_eq!(loads, [], "{name}");
    }
}

/// A ring on its slider falls on a seat without dashpots and comes back as fast.
#[test]
fn a_seat_gives_back_the_energy_of_a_fall() {
    let mesh = ring(40, [4, 2], [4e-3, 7e-3, 2e-3, 4e-3]);
    let mut scene = scene([20e-3; 3], WALLS, law(2e3, 0.4, Damping::Restitution(0.5)));
    scene.parts = vec![carrier(15e-3, 9.2e-3)];
    let Motion::Slider(slider) = &mut scene.parts[0].motion else { panic!() };
    slider.velocity = -1.0;
    let mut dem = held(&scene, &mesh, 1);
    let energy = |dem: &mut GrainsDem| {
        let d = dem.diagnostics();
        d.kinetic_energy + d.elastic_energy
    };
    let start = energy(&mut dem);
    let mut deepest = 0.0f64;
    for _ in 0..450 {
        dem.begin_window(100, &[]).unwrap();
        for _ in 0..100 {
            dem.begin_substep().unwrap();
            let carrier = dem.carrier_state(0).unwrap();
            let vertices = shifted(&mesh.vertices, carrier.position[2] - 15e-3);
            let velocities = vec![carrier.velocity; vertices.len()];
            let carrier_force = [0.0; 3];
            let vertices = &vertices[..];
            let state = SurfaceState { vertices, velocities: &velocities, carrier_force };
            dem.finish_substep(&[state]).unwrap();
        }
        dem.end_window().unwrap();
        deepest = deepest.min(dem.sliders().next().unwrap().lift);
        let off = (energy(&mut dem) - start) / start;
        assert!(off.abs() < 1e-4, "{off}");
    }
    let end = dem.sliders().next().unwrap();
    assert!((end.velocity - 1.0).abs() < 1e-4 && end.surface_force == 0.0, "{end:?}");
    // m v^2 = k A d^2.
    let area = 0.5 * 40.0 * (std::f64::consts::TAU / 40.0).sin() * 33e-6;
    let depth = (9.2e-3 / (1e10 * area)).sqrt();
    assert!((deepest / (-2e-3 - depth) - 1.0).abs() < 1e-3, "{deepest} {depth}");
}

/// Half a domain at a mirror, with one sphere, and the whole with two.
#[test]
fn spheres_at_a_mirror_count_with_their_images() {
    let press = |cut: bool| {
        let (mut scene, mesh) = pressed();
        let mut spheres = vec![sphere([15.5e-3, 10.4e-3, 0.5 * D], D, [0.0; 3])];
        if cut {
            scene.domain.min[0] = 10e-3;
            scene.domain.faces[0][0] = Face::Symmetry;
        } else {
            spheres.push(sphere([4.5e-3, 10.4e-3, 0.5 * D], D, [0.0; 3]));
        }
        scene.bodies = vec![set(Motion::Free, spheres)];
        let mut dem = held(&scene, &mesh, 1);
        let velocities = vec![[0.0, 0.0, -0.03]; mesh.vertices.len()];
        dem.begin_window(2_000, &[]).unwrap();
        for k in 1..=2_000 {
            dem.begin_substep().unwrap();
            let vertices = &shifted(&mesh.vertices, -0.03 * DT * f64::from(k))[..];
            let carrier_force = [0.0; 3];
            let state = SurfaceState { vertices, velocities: &velocities, carrier_force };
            dem.finish_substep(&[state]).unwrap();
        }
        dem.end_window().unwrap();
        dem.sliders().next().unwrap()
    };
    let (whole, half) = (press(false), press(true));
    assert!(whole.surface_force > 1e-3, "{whole:?}");
    assert!((whole.surface_force / half.surface_force - 1.0).abs() < 1e-9, "{whole:?} {half:?}");
    assert!((whole.velocity / half.velocity - 1.0).abs() < 1e-9, "{whole:?} {half:?}");
}

#[test]
fn without_surfaces_the_substeps_are_those_of_advance() {
    let mut scene = scene([6e-3, 6e-3, 12e-3], WALLS, law(1e4, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [1.0, 0.0, -9.81];
    scene.bodies = vec![packed([0.0; 3], [6e-3; 3], 0.35, (0.8e-3, 1.2e-3), 2)];
    scene.parts =
        vec![part("lid", [4e-3, 4e-3, 1e-3], [3e-3, 3e-3, 7e-3], carrier(0.0, 1e-4).motion)];
    let (mut whole, mut parts) = (make(&scene, 1e-6), make(&scene, 1e-6));
    for _ in 0..300 {
        whole.advance(7, &[]).unwrap();
        parts.begin_window(7, &[]).unwrap();
        for _ in 0..7 {
            parts.begin_substep().unwrap();
            parts.finish_substep(&[]).unwrap();
        }
        parts.end_window().unwrap();
    }
    assert_eq!(state(&whole), state(&parts));
    assert_eq!(whole.diagnostics(), parts.diagnostics());
}

#[test]
fn wrong_surfaces_and_shapes_are_told() {
    let (scene, mesh) = pressed();
    let refused = |scene: &Scene, change: &dyn Fn(&mut DeformableSurface)| {
        let mut surface = surface(&mesh);
        change(&mut surface);
        let made = GrainsDem::with_surfaces(scene, &Parameters::default(), DT, 1, &[surface]);
        let problems = made.map(|_| ()).unwrap_err();
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems[0].key.clone()
    };
    assert_eq!(refused(&scene, &|s| s.carrier = 1), "surfaces[0].carrier");
    assert_eq!(refused(&scene, &|s| s.seat_stiffness = 0.0), "surfaces[0].seat_stiffness");
    assert_eq!(refused(&scene, &|s| s.material = "rubber".into()), "scene.contacts");
    assert_eq!(refused(&scene, &|s| s.triangles.truncate(30)), "surfaces[0].triangles");
    assert_eq!(refused(&scene, &|s| s.triangles[0] = [0, 1, 99_999]), "surfaces[0].triangles");
    // Too stiff for the step.
    assert_eq!(refused(&scene, &|s| s.seat_stiffness = 1e18), "surfaces[0]");
    let mut sticky = scene.clone();
    for pair in &mut sticky.contacts {
        pair.law.spring = Spring::Jkr {
            effective_modulus: 1e4,
            effective_shear_modulus: 3e3,
            work_of_adhesion: 1e-3,
        };
        pair.law.damping = Damping::Restitution(0.5);
    }
    assert_eq!(refused(&sticky, &|_| {}), "surfaces[0]");
    let mut periodic = scene.clone();
    periodic.domain.faces[0] = [Face::Periodic, Face::Periodic];
    assert_eq!(refused(&periodic, &|_| {}), "scene.domain");

    let mut dem = held(&scene, &mesh, 1);
    let (still, mut loads) = (vec![[0.0; 3]; mesh.vertices.len()], Vec::new());
    let begin = GrainsError::OutOfOrder { call: "begin_substep", first: "begin_window" };
    assert_eq!(dem.begin_substep(), Err(begin));
    dem.begin_window(1, &[]).unwrap();
    let trial = dem.contact_on_surface(0, &mesh.vertices, &still, &mut loads);
    let early = GrainsError::OutOfOrder { call: "contact_on_surface", first: "begin_substep" };
    assert_eq!(trial, Err(early));
    dem.begin_substep().unwrap();
    let trial = dem.contact_on_surface(1, &mesh.vertices, &still, &mut loads);
    assert_eq!(trial, Err(GrainsError::NoSurface { surface: 1, surfaces: 1 }));
    let trial = dem.contact_on_surface(0, &mesh.vertices[1..], &still, &mut loads);
    assert!(matches!(trial, Err(GrainsError::SurfaceVertices { surface: 0, .. })));
    let mut nowhere = mesh.vertices.clone();
    nowhere[7][1] = f64::NAN;
    let trial = dem.contact_on_surface(0, &nowhere, &still, &mut loads);
    assert_eq!(trial, Err(GrainsError::SurfaceNotFinite { surface: 0, vertex: 7 }));
    assert_eq!(dem.finish_substep(&[]), Err(GrainsError::SurfaceCount { found: 0, expected: 1 }));
    let unfinished = GrainsError::OutOfOrder { call: "end_window", first: "finish_substep" };
    assert_eq!(dem.end_window(), Err(unfinished));
    let mut dem = held(&scene, &mesh, 1);
    assert!(dem.advance(1, &[]).is_err());
    let _: Vec<BodyState> = state(&dem);
}
