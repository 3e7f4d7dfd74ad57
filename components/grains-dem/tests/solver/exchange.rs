//! Bodies that come and go between windows.

use crate::common::*;
use tremie_geometry::Mesh;
use tremie_grains_dem::{
    AddedSphere, DeformableSurface, GrainsDem, GrainsError, Parameters, SurfaceState,
};
use tremie_grains_kit::checks::loads::LoadError;
use tremie_messages::{
    body::{BodyEvent, BodyState, Load},
    scene::{
        Damping, Geometry, Motion, MotionPoint, Part, PartBoundary, Placement, Pose, Scene, Slider,
        SliderSpring, Sphere,
    },
};

/// Uniform in [0, 1), by number.
fn unit(k: u64) -> f64 {
    let mixed = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
}

/// Elastic and without friction: forces are those of places alone, and a solver that begins anew
/// finds the same.
fn elastic() -> Scene {
    let mut scene = scene([14e-3, 15e-3, 13e-3], FLOOR, law(1e4, 0.0, coefficients(0.0, 0.0)));
    scene.gravity = [0.5, 0.0, -2.0];
    gas(&mut scene, 0.2, 3);
    scene
}

fn diameters(dem: &GrainsDem) -> Vec<f64> {
    dem.radii().map(|radius| 2.0 * radius).collect()
}

/// A sphere at a random place where it touches nothing, if one is found soon.
fn newcomer(dem: &GrainsDem, size: [f64; 3], key: u64) -> Option<AddedSphere> {
    let diameter = 0.8e-3 + 0.4e-3 * unit(key);
    let (bodies, sizes) = (state(dem), diameters(dem));
    let place = |attempt: u64| -> [f64; 3] {
        std::array::from_fn(|a| {
            let unit = unit(key + 1000 * (attempt + 1) + a as u64);
            0.5 * diameter + (size[a] - diameter) * unit
        })
    };
    let clear = |x: &[f64; 3]| {
        let apart = |body: &BodyState, d: f64| {
            let way = std::array::from_fn(|a| {
                let way = x[a] - body.position[a];
                if a == 2 { way } else { way - size[a] * (way / size[a]).round() }
            });
            norm(way) > 0.5 * (d + diameter)
        };
        bodies.iter().zip(&sizes).all(|(body, &d)| apart(body, d))
    };
    let position = (0..200).map(place).find(clear)?;
    Some(AddedSphere { set: 0, position, diameter, velocity: [0.1, -0.1, 0.2] })
}

#[test]
fn survivors_go_on_as_in_a_solver_made_of_them() {
    let scene = elastic();
    let dt = 4e-7;
    let mut dem = make(&scene, dt);
    let (mut came, mut went, mut contacts) = (0, 0, 0);
    for round in 0..12 {
        dem.advance(150, &[]).unwrap();
        contacts += dem.diagnostics().contacts;
        let ids: Vec<u64> = state(&dem).iter().map(|body| body.id).collect();
        let gone: Vec<u64> =
            ids.iter().copied().filter(|id| unit(7 * round + 1000 * id) < 0.06).collect();
        let mut added = Vec::new();
        for k in 0..4 {
            let Some(sphere) = newcomer(&dem, scene.domain.max, 31 * round + k) else { continue };
            let apart = |other: &AddedSphere| norm(minus(sphere.position, other.position)) > 2e-3;
            if added.iter().all(apart) {
                added.push(sphere);
            }
        }
        dem.exchange(&gone, &added).unwrap();
        (came, went) = (came + added.len(), went + gone.len());
        check_events(&dem, &gone, &added);
        let mut survivors = scene.clone();
        let of =
            |(body, diameter): (&BodyState, f64)| sphere(body.position, diameter, body.velocity);
        let listed: Vec<Sphere> = state(&dem).iter().zip(diameters(&dem)).map(of).collect();
        survivors.bodies[0].placement = Placement::Listed(listed);
        let mut fresh = make(&survivors, dt);
        let mut go_on = |steps| {
            fresh.advance(steps, &[]).unwrap();
            dem.advance(steps, &[]).unwrap();
            for (a, b) in state(&dem).iter().zip(state(&fresh)) {
                assert_eq!((a.position, a.velocity), (b.position, b.velocity), "{round} {}", a.id);
            }
        };
        go_on(1);
        go_on(40);
        let (a, b) = (dem.diagnostics(), fresh.diagnostics());
        assert_eq!((a.contacts, a.elastic_energy), (b.contacts, b.elastic_energy));
    }
    assert!(came > 15 && went > 300 && contacts > 30, "{came} {went} {contacts}");
}

/// Removals first, then additions with the next ids; the state has the living, by ascending ids.
fn check_events(dem: &GrainsDem, gone: &[u64], added: &[AddedSphere]) {
    let kinds: Vec<(u32, u64)> = dem.events().iter().map(|event| (event.kind, event.id)).collect();
    let next = kinds.iter().find(|event| event.0 == BodyEvent::ADDED).map_or(0, |event| event.1);
    let removed = gone.iter().map(|&id| (BodyEvent::REMOVED, id));
    let came = (next..).take(added.len()).map(|id| (BodyEvent::ADDED, id));
    assert_eq!(kinds, removed.chain(came).collect::<Vec<_>>());
    let states = state(dem);
    assert!(states.windows(2).all(|pair| pair[0].id < pair[1].id));
    assert!(states.iter().all(|body| !gone.contains(&body.id)));
    for (sphere, event) in added.iter().zip(&dem.events()[gone.len()..]) {
        let body = states.iter().find(|body| body.id == event.id).unwrap();
        assert_eq!((body.position, body.velocity), (sphere.position, sphere.velocity));
        assert_eq!(event.size[0], 0.5 * sphere.diameter);
        assert!((event.mass / mass(sphere.diameter) - 1.0).abs() < 1e-12);
    }
}

/// A bed with friction on a floor, with a turning part, of more than two blocks.
fn crowd() -> Scene {
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law(1e3, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [10.0, 3.0, -100.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.4, (0.7e-3, 0.9e-3), 2)];
    let turning =
        MotionPoint { time: 0.0, velocity: [0.3, 0.0, 0.0], angular_velocity: [0.0, 0.0, 50.0] };
    scene.parts = vec![Part {
        name: "paddle".into(),
        geometry: Geometry::Box { size: [4e-3, 1e-3, 3e-3] },
        pose: Pose { position: [7e-3, 7e-3, 3e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Prescribed(vec![turning]),
        boundary: PartBoundary::Wall,
    }];
    scene
}

fn run_crowd(far: bool, threads: usize) -> (Vec<BodyState>, usize) {
    let mut scene = crowd();
    let spheres = make(&scene, 4e-6).radii().len();
    let place = |k: usize| [1e-3 + 1.5e-3 * (k % 8) as f64, 3e-3, 25e-3 + 1.5e-3 * (k / 8) as f64];
    let one = |k: usize| sphere(place(k), 0.8e-3, [0.5, 0.0, 0.0]);
    if far {
        scene.bodies.push(set(Motion::Free, (0..8).map(one).collect()));
    }
    let mut dem = GrainsDem::new(&scene, &Parameters::default(), 4e-6, threads).unwrap();
    let first_part = dem.radii().len() as u64;
    for window in 0..10 {
        dem.advance(120, &[]).unwrap();
        let added = |k: usize| AddedSphere {
            set: 1,
            position: place(8 + k),
            diameter: 0.8e-3,
            velocity: [0.0; 3],
        };
        match (far, window) {
            (true, 2) => dem.exchange(&[spheres as u64 + 1, spheres as u64 + 5], &[]).unwrap(),
            (true, 4) => dem.exchange(&[spheres as u64], &[added(0), added(3)]).unwrap(),
            (true, 7) => dem.exchange(&[first_part + 2], &[added(6)]).unwrap(),
            _ => {}
        }
    }
    assert!(dem.diagnostics().contacts > 500);
    (state(&dem), spheres)
}

#[test]
fn who_comes_and_goes_far_away_changes_no_bit_of_a_bed_with_friction() {
    let (alone, spheres) = run_crowd(false, 1);
    let with = run_crowd(true, 1).0;
    assert!(spheres > 1024, "more than two blocks");
    assert_eq!(alone[..spheres], with[..spheres]);
    for threads in [2, 3] {
        assert_eq!(with, run_crowd(true, threads).0, "{threads}");
    }
}

#[test]
fn loads_reach_the_bodies_they_name() {
    let mut scene = crowd();
    scene.gravity = [0.0; 3];
    let place = |k: usize| [1e-3 + 2e-3 * k as f64, 3e-3, 20e-3];
    scene.bodies =
        vec![set(Motion::Free, (0..5).map(|k| sphere(place(k), 1e-3, [0.0; 3])).collect())];
    let mut dem = make(&scene, 1e-6);
    dem.advance(1, &[]).unwrap();
    let added =
        AddedSphere { set: 0, position: [3e-3, 9e-3, 20e-3], diameter: 1e-3, velocity: [0.0; 3] };
    dem.exchange(&[1, 3], &[added]).unwrap();
    let ids: Vec<u64> = state(&dem).iter().map(|body| body.id).collect();
    assert_eq!(ids, [0, 2, 4, 5, 6], "5 is the part's");
    let force = |id: u64| mass(1e-3) * (1.0 + id as f64);
    let load = |&id: &u64| Load { id, force: [0.0, force(id), 0.0], torque: [0.0; 3] };
    let mut loads: Vec<Load> = ids.iter().map(load).collect();
    let dt = 10.0 * 1e-6;
    dem.advance(10, &loads).unwrap();
    for body in state(&dem).iter().filter(|body| body.id != 5) {
        let expected = (1.0 + body.id as f64) * dt;
        assert!((body.velocity[1] / expected - 1.0).abs() < 1e-9, "{body:?}");
    }
    loads[3].id = 7;
    let order = dem.advance(1, &loads);
    assert_eq!(order, Err(GrainsError::Load(LoadError::Order { index: 3, found: 7, expected: 5 })));
    let count = dem.advance(1, &loads[1..]);
    assert_eq!(count, Err(GrainsError::Load(LoadError::Count { found: 4, expected: 5 })));
}

#[test]
fn what_cannot_be_is_said_and_nothing_happens() {
    let scene = elastic();
    let mut dem = make(&scene, 4e-7);
    let before = state(&dem);
    let good = newcomer(&dem, scene.domain.max, 5).unwrap();
    for (removed, added) in [
        (&[4, 4][..], good),
        (&[1_000_000], good),
        (&[], AddedSphere { set: 1, ..good }),
        (&[], AddedSphere { diameter: 2e-3, ..good }),
        (&[], AddedSphere { position: [20e-3, 0.0, 0.0], ..good }),
        (&[], AddedSphere { velocity: [f64::NAN; 3], ..good }),
    ] {
        assert!(dem.exchange(removed, &[added]).is_err(), "{removed:?} {added:?}");
    }
    dem.begin_window(1, &[]).unwrap();
    assert!(matches!(dem.exchange(&[], &[good]), Err(GrainsError::OutOfOrder { .. })));
    assert_eq!(before, state(&dem));
}

#[test]
fn all_may_go_and_others_come() {
    let scene = elastic();
    let mut dem = make(&scene, 4e-7);
    let all: Vec<u64> = state(&dem).iter().map(|body| body.id).collect();
    dem.exchange(&all, &[]).unwrap();
    dem.advance(10, &[]).unwrap();
    assert_eq!((dem.body_count(), dem.diagnostics().kinetic_energy), (0, 0.0));
    let sphere = newcomer(&dem, scene.domain.max, 1).unwrap();
    dem.exchange(&[], &[sphere]).unwrap();
    dem.advance(10, &[]).unwrap();
    assert_eq!(state(&dem)[0].id, all.len() as u64);
}

/// Spheres that fall onto a surface which deforms, and one far away that goes and another that
/// comes.
fn run_on_surface(far: bool) -> Vec<BodyState> {
    let mut scene = scene([6e-3, 6e-3, 10e-3], WALLS, law(1e3, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [0.2, 0.0, 9.81];
    let near = (0..9).map(|k| [1.2e-3 * (k % 3) as f64 + 1.8e-3, 1.2e-3 * (k / 3) as f64 + 1.8e-3]);
    let spheres = near.map(|[x, y]| sphere([x, y, 2.6e-3], 0.6e-3, [0.0; 3])).collect();
    scene.bodies = vec![set(Motion::Free, spheres)];
    if far {
        let one = vec![sphere([0.4e-3, 0.4e-3, 6e-3], 0.6e-3, [0.0; 3])];
        scene.bodies.insert(0, set(Motion::Free, one));
    }
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass: 1e-2,
        lift: 0.0,
        velocity: 0.0,
        spring: SliderSpring::None,
        force: 0.0,
        stops: None,
    };
    let motion = Motion::Slider(Box::new(slider));
    let pose = Pose { position: [3e-3, 3e-3, 9e-3], ..Pose::IDENTITY };
    scene.parts = vec![Part {
        geometry: Geometry::Box { size: [1e-3; 3] },
        pose,
        motion,
        ..crowd().parts[0].clone()
    }];
    let block = Mesh::of(&Geometry::Box { size: [5e-3, 5e-3, 1e-3] }).unwrap();
    let vertices: Vec<[f64; 3]> =
        block.vertices.iter().map(|v| [v.x + 3e-3, v.y + 3e-3, v.z + 3.6e-3]).collect();
    let surface = DeformableSurface {
        triangles: block.triangles.clone(),
        vertices: vertices.clone(),
        carrier: 0,
        material: "wall".into(),
        seat_stiffness: 1e9,
    };
    let still = vec![[0.0; 3]; vertices.len()];
    let accepted =
        [SurfaceState { vertices: &vertices, velocities: &still, carrier_force: [0.0; 3] }];
    let mut dem =
        GrainsDem::with_surfaces(&scene, &Parameters::default(), 2e-6, 1, &[surface]).unwrap();
    let mut touched = 0;
    for window in 0..400 {
        dem.begin_window(20, &[]).unwrap();
        for _ in 0..20 {
            dem.begin_substep().unwrap();
            dem.finish_substep(&accepted).unwrap();
        }
        dem.end_window().unwrap();
        touched += usize::from(dem.diagnostics().contacts >= 9);
        let added = AddedSphere {
            set: 0,
            position: [5.6e-3, 5.6e-3, 6e-3],
            diameter: 0.6e-3,
            velocity: [0.0; 3],
        };
        match (far, window) {
            (true, 300) => dem.exchange(&[0], &[]).unwrap(),
            (true, 330) => dem.exchange(&[], &[added]).unwrap(),
            _ => {}
        }
    }
    assert!(touched > 100, "{touched}");
    state(&dem)
}

/// The first sphere goes, so that all others change their places while they lie on the surface.
#[test]
fn forces_of_surfaces_follow_the_bodies() {
    let (alone, with) = (run_on_surface(false), run_on_surface(true));
    for (a, b) in alone[..9].iter().zip(&with) {
        assert_eq!(BodyState { id: b.id, ..*a }, *b);
    }
}
