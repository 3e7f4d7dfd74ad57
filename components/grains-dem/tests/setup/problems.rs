//! Errors in inputs name the key, and a remedy.

use crate::common::*;
use tremie_grains_dem::{GrainsDem, GrainsError, Parameters};
use tremie_messages::{
    Problem,
    scene::{
        Damping, Diameters, Face, Geometry, Motion, MotionPoint, Part, PartBoundary, Placement,
        Plane, Pose, Scene, SievePoint, Spring,
    },
    units::{Time, Velocity},
};

fn good() -> Scene {
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.8)));
    let (a, b) = ([3e-3, 5e-3, 5e-3], [5e-3, 5e-3, 5e-3]);
    scene.bodies =
        vec![set(Motion::Free, vec![sphere(a, 1e-3, [0.0; 3]), sphere(b, 1e-3, [0.0; 3])])];
    scene
}

fn problems(change: impl Fn(&mut Scene, &mut Parameters)) -> Vec<Problem> {
    let (mut scene, mut parameters) = (good(), Parameters::default());
    change(&mut scene, &mut parameters);
    let problems = parameters.resolve(&scene).expect_err("a problem");
    for problem in &problems {
        println!("{problem}");
    }
    problems
}

fn key(change: impl Fn(&mut Scene, &mut Parameters)) -> String {
    problems(change)[0].key.clone()
}

fn spheres(scene: &mut Scene) -> &mut Vec<tremie_messages::scene::Sphere> {
    match &mut scene.bodies[0].placement {
        Placement::Listed(list) => list,
        _ => unreachable!(),
    }
}

fn law_of(scene: &mut Scene) -> &mut tremie_messages::scene::ContactLaw {
    &mut scene.contacts[0].law
}

#[test]
fn laws() {
    let of = "scene.contacts[0].law";
    let found = key(|s, _| {
        law_of(s).spring = Spring::Linear { normal_stiffness: -1.0, tangential_stiffness: 1.0 }
    });
    assert_eq!(found, format!("{of}.normal_stiffness"));
    assert_eq!(key(|s, _| law_of(s).friction = -0.1), format!("{of}.friction"));
    for e in [0.0, -0.5, 1.1, f64::NAN] {
        let found = key(|s, _| law_of(s).damping = Damping::Restitution(e));
        assert_eq!(found, format!("{of}.damping.restitution"));
    }
    let found = key(|s, _| law_of(s).damping = coefficients(-1.0, 0.0));
    assert_eq!(found, format!("{of}.damping.coefficients.normal"));
    assert_eq!(key(|s, _| s.contacts.clear()), "scene.contacts");
}

#[test]
fn bodies() {
    assert_eq!(key(|s, _| s.bodies[0].density = 0.0), "scene.bodies[0].density");
    let of = "scene.bodies[0].placement.listed[1]";
    assert_eq!(key(|s, _| spheres(s)[1].diameter = -1e-3), format!("{of}.diameter"));
    for z in [0.4e-3, 9.9e-3, -1.0, f64::NAN] {
        assert_eq!(key(|s, _| spheres(s)[1].position[2] = z), format!("{of}.position"));
    }
    let found = key(|s, _| {
        s.bodies[0].motion = Motion::Fixed;
        spheres(s)[1].velocity[0] = 1.0;
    });
    assert_eq!(found, format!("{of}.velocity"));
}

#[test]
fn overlaps_name_both_bodies_and_the_overlap() {
    let found = problems(|s, _| spheres(s)[1].position[0] = 3.9e-3);
    assert_eq!(found[0].key, "scene.bodies[0].placement");
    for part in ["body 0", "body 1", "1.000e-4 m"] {
        assert!(found[0].message.contains(part), "{}", found[0].message);
    }
}

#[test]
fn domain_and_planes() {
    assert_eq!(key(|s, _| s.domain.max[1] = -1.0), "scene.domain");
    let small = |s: &mut Scene| {
        s.domain.faces[2] = [Face::Periodic, Face::Periodic];
        (s.domain.min[2], s.domain.max[2]) = (4.2e-3, 6.2e-3);
    };
    assert_eq!(key(|s, _| small(s)), "scene.domain");
    let plane = |normal| Plane { point: [0.0; 3], normal, material: "wall".into() };
    assert_eq!(key(|s, _| s.planes = vec![plane([0.0; 3])]), "scene.planes[0].normal");
    let across = |s: &mut Scene| {
        s.domain.faces[0] = [Face::Periodic, Face::Periodic];
        s.planes = vec![plane([1.0, 0.0, 0.0])];
    };
    assert_eq!(key(|s, _| across(s)), "scene.planes[0].normal");
}

#[test]
fn packings() {
    let pack = |min, max, fraction| {
        key(move |s, _| s.bodies = vec![packed(min, max, fraction, (1e-3, 1e-3), 1)])
    };
    let of = "scene.bodies[0].placement";
    assert_eq!(pack([0.0; 3], [9e-3; 3], 0.0), format!("{of}.packed.fraction"));
    assert_eq!(pack([0.0; 3], [9e-3, 9e-3, 0.5e-3], 0.3), format!("{of}.packed.max"));
    assert_eq!(pack([-1e-3; 3], [9e-3; 3], 0.3), format!("{of}.packed.min"));
    assert_eq!(pack([0.0; 3], [2e-3; 3], 0.01), of);
}

#[test]
fn own_parameters() {
    let step = |t: f64| key(move |_, p| p.time_step = Some(Time(t)));
    for t in [0.0, -1.0, f64::NAN, 1e-3] {
        assert_eq!(step(t), "@time_step");
    }
    assert_eq!(key(|_, p| p.steps_per_contact = 2.0), "@steps_per_contact");
    assert_eq!(key(|_, p| p.skin = Some(0.0)), "@skin");
    let found = problems(|_, p| p.time_step = Some(Time(1e-4)));
    assert!(found[0].help.as_ref().unwrap().contains("use"), "says what would do");
    assert!(GrainsDem::new(&good(), &Parameters::default(), 1e-3, 1).is_err());
}

#[test]
fn a_good_scene_resolves_to_a_time_step() {
    let resolution = Parameters::default().resolve(&good()).unwrap();
    let contact = std::f64::consts::PI * (0.5 * mass(1e-3) / 1e4).sqrt();
    assert!((resolution.contact_time.unwrap() / contact - 1.0).abs() < 1e-12);
    assert!((resolution.time_step.unwrap() * 20.0 / contact - 1.0).abs() < 1e-12);
    assert_eq!((resolution.bodies, resolution.free_bodies), (2, 2));
    assert!(resolution.pairs.iter().all(|p| (p.restitution - 0.8).abs() < 1e-9));
    assert!(resolution.warnings.is_empty(), "{:?}", resolution.warnings);
}

#[test]
fn parameters_read_with_units_and_refuse_unknown_keys() {
    let read = |text| serde_json::from_str::<Parameters>(text);
    let parameters = read(r#"{"time_step": "2 us", "skin": 0.2}"#).unwrap();
    assert_eq!(parameters.time_step, Some(Time(2e-6)));
    assert_eq!(parameters.steps_per_contact, 20.0);
    assert!(read(r#"{"time_stop": "2 us"}"#).is_err());
}

#[test]
fn a_contact_that_is_much_too_soft_ends_the_run() {
    let mut scene = good();
    spheres(&mut scene)[0].velocity[0] = 60.0;
    let mut dem = make(&scene, 1e-7);
    let error = dem.advance(2000, &[]).unwrap_err();
    println!("{error}");
    assert!(matches!(error, GrainsError::Overlap { id: 0, .. }), "{error}");
    assert!(dem.diagnostics().max_overlap_ratio > 0.5 && dem.diagnostics().deep_overlaps > 0);
}

#[test]
fn a_prescribed_body_may_not_leave() {
    let mut scene = good();
    let leaving = sphere([5e-3, 5e-3, 9e-3], 1e-3, [0.0, 0.0, 1.0]);
    scene.bodies.push(set(Motion::Prescribed(vec![]), vec![leaving]));
    let error = make(&scene, 1e-6).advance(5000, &[]).unwrap_err();
    println!("{error}");
    assert!(matches!(error, GrainsError::LeftDomain { id: 2, .. }), "{error}");
}

#[test]
fn pairs_of_materials_without_a_law() {
    let other = |s: &mut Scene, placed| {
        let mut more = set(Motion::Free, vec![placed]);
        more.material = "glass".into();
        s.bodies.push(more);
    };
    let found = problems(|s, _| other(s, sphere([7e-3, 5e-3, 5e-3], 1e-3, [0.0; 3])));
    let said: Vec<&str> = found.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(found.len(), 2, "{said:?}");
    assert!(found.iter().all(|p| p.key == "scene.contacts"));
    assert!(said[0].contains("\"grains\" and \"glass\""), "{said:?}");
    assert!(said[1].contains("\"glass\" and \"wall\"") && said[1].contains("lower face in x"));
    assert!(found[0].help.as_ref().unwrap().contains("[[scene.contacts]]"));
    // A plane of another material asks for a law of its own.
    let plane = Plane { point: [5e-3; 3], normal: [0.0, 0.0, 1.0], material: "steel".into() };
    let found = problems(|s, _| {
        let mut plane = plane.clone();
        plane.point[2] = 0.0;
        s.planes.push(plane);
    });
    assert!(found[0].message.contains("\"steel\"") && found[0].message.contains("plane 0"));
}

#[test]
fn hertz_takes_no_coefficients() {
    let hertz = Spring::Hertz { effective_modulus: 1e9, effective_shear_modulus: 3e8 };
    let found = key(|s, _| {
        law_of(s).spring = hertz;
        law_of(s).damping = coefficients(1.0, 1.0);
    });
    assert_eq!(found, "scene.contacts[0].law.damping");
    let soft = Spring::Hertz { effective_modulus: 0.0, effective_shear_modulus: 3e8 };
    let found = key(|s, _| law_of(s).spring = soft);
    assert_eq!(found, "scene.contacts[0].law.effective_modulus");
    assert_eq!(
        key(|s, _| law_of(s).rolling_friction = -1.0),
        "scene.contacts[0].law.rolling_friction"
    );
    assert_eq!(key(|_, p| p.expected_speed = Some(Velocity(0.0))), "@expected_speed");
}

#[test]
fn distributions_of_diameters() {
    let found = |diameters: Diameters| {
        problems(move |s, _| {
            let mut bodies = packed([0.0; 3], [9e-3; 3], 0.2, (1e-3, 1e-3), 1);
            if let Placement::Packed(packing) = &mut bodies.placement {
                packing.diameters = diameters.clone();
            }
            s.bodies = vec![bodies];
        })
    };
    let of = "scene.bodies[0].placement.packed.diameters";
    let normal = |mean, deviation| Diameters::Normal { mean, deviation, min: 1e-3, max: 2e-3 };
    assert_eq!(found(normal(1e-3, 0.0))[0].key, format!("{of}.normal.deviation"));
    assert_eq!(found(normal(1.0, 1e-3))[0].key, of);
    let spread = Diameters::LogNormal { median: 1e-3, spread: 1.0, min: 1e-3, max: 2e-3 };
    assert_eq!(found(spread)[0].key, format!("{of}.lognormal.spread"));
    let sieve = |points: &[(f64, f64)]| {
        let point = |&(size, passing): &(f64, f64)| SievePoint { size, passing };
        found(Diameters::Sieve(points.iter().map(point).collect()))[0].key.clone()
    };
    assert_eq!(sieve(&[(1e-3, 0.0), (1e-3, 1.0)]), format!("{of}.sieve[1].size"));
    assert_eq!(
        sieve(&[(1e-3, 0.0), (2e-3, 0.5), (3e-3, 0.4), (4e-3, 1.0)]),
        format!("{of}.sieve[2].passing")
    );
    assert_eq!(sieve(&[(1e-3, 0.1), (2e-3, 1.0)]), format!("{of}.sieve"));
}

#[test]
fn parts_and_motions() {
    let part = |motion| Part {
        name: "post".into(),
        geometry: Geometry::Box { size: [1e-3; 3] },
        pose: Pose { position: [3e-3, 5e-3, 4.2e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    };
    let found = problems(|s, _| s.parts = vec![part(Motion::Fixed)]);
    assert_eq!(found[0].key, "scene.bodies[0].placement");
    assert!(found[0].message.contains("into part \"post\""), "{}", found[0]);
    assert_eq!(key(|s, _| s.parts = vec![part(Motion::Free)]), "scene.parts[0].motion");
    let at = |time| MotionPoint { time, velocity: [0.0; 3], angular_velocity: [0.0; 3] };
    let back = Motion::Prescribed(vec![at(1.0), at(1.0)]);
    let found = key(|s, _| s.parts = vec![part(back.clone())]);
    assert_eq!(found, "scene.parts[0].motion.prescribed[1].time");
    let lost = Geometry::File { path: "/nowhere/at.stl".into(), unit: 1.0 };
    let found = key(|s, _| s.parts = vec![Part { geometry: lost.clone(), ..part(Motion::Fixed) }]);
    assert_eq!(found, "scene.parts[0].geometry");
}
