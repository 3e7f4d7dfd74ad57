//! What is refused, and how it is said.

use crate::common::{PERIODIC, make, scene, set, sphere};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters, findings};
use tremie_messages::finding::Verdict;
use tremie_messages::scene::*;
use tremie_messages::units::Time;
use tremie_messages::{Load, Problem};

fn valid() -> Scene {
    let mut scene = scene([10.0; 3], Face::WALLS, 0.9, 0.3);
    scene.bodies = vec![set(Motion::Free, 1000.0, vec![sphere([5.0; 3], 1.0, [1.0, 0.0, 0.0])])];
    scene
}

fn problems(scene: &Scene, parameters: &Parameters) -> Vec<Problem> {
    parameters.resolve(scene).err().unwrap_or_default()
}

/// A change of the valid scene gives one problem, at a key, with these words.
fn refused(change: impl Fn(&mut Scene), key: &str, words: &[&str]) {
    let mut scene = valid();
    change(&mut scene);
    let found = problems(&scene, &Parameters::default());
    assert_eq!(found.len(), 1, "{key}: {found:?}");
    let said = found[0].to_string();
    assert!(found[0].key.starts_with(key), "{said}");
    for word in words {
        assert!(said.contains(word), "expected \"{word}\" in: {said}");
    }
    assert!(found[0].help.is_some(), "{said}");
}

#[test]
fn a_valid_scene_is_taken() {
    assert_eq!(problems(&valid(), &Parameters::default()), []);
}

#[test]
fn laws_that_need_a_contact_that_lasts_are_refused() {
    let law =
        |change: fn(&mut ContactLaw)| move |scene: &mut Scene| change(&mut scene.contacts[0].law);
    refused(
        law(|law| {
            law.spring = Spring::Jkr {
                effective_modulus: 1e7,
                effective_shear_modulus: 1e7,
                work_of_adhesion: 0.1,
            };
        }),
        "scene.contacts[0].law.spring",
        &["adhesion of 0.1 J/m2", "cannot hold each other", "grains-dem"],
    );
    refused(
        law(|law| law.damping = Damping::Coefficients { normal: 1.0, tangential: 1.0 }),
        "scene.contacts[0].law.damping",
        &["coefficients of dashpots", "expected a restitution", "grains-dem"],
    );
    refused(
        law(|law| law.rolling_friction = 0.1),
        "scene.contacts[0].law.rolling_friction",
        &["is 0.1, expected 0", "grains-dem"],
    );
    refused(
        |scene| scene.contacts.iter_mut().for_each(|pair| pair.law.rolling_friction = 0.1),
        "scene.contacts[0].law.rolling_friction",
        &["a torque needs a contact that lasts"],
    );
}

#[test]
fn what_else_hard_spheres_do_not_have_is_said() {
    refused(
        |scene| scene.bodies[0].clump = Some("pair".into()),
        "scene.bodies[0].clump",
        &["clump \"pair\"", "one by one", "grains-dem"],
    );
    refused(
        |scene| {
            scene.drag_bands = vec![DragBand {
                name: "band".into(),
                min: [0.0; 3],
                max: [1.0; 3],
                terminal_speed: 1.0,
            }];
        },
        "scene.drag_bands[0]",
        &["brakes grains", "leave the band out"],
    );
    refused(
        |scene| {
            scene.probes = vec![Probe {
                name: "middle".into(),
                shape: ProbeShape::Region { min: [0.0; 3], max: [1.0; 3] },
            }];
        },
        "scene.probes[0]",
        &["region", "grains-dem"],
    );
    refused(
        |scene| {
            scene.parts = vec![Part {
                name: "gate".into(),
                geometry: Geometry::Box { size: [1.0; 3] },
                pose: Pose { position: [2.0; 3], ..Pose::IDENTITY },
                cavity: false,
                material: "wall".into(),
                motion: Motion::Free,
                boundary: PartBoundary::Wall,
            }];
        },
        "scene.parts[0].motion",
        &["moved by forces", "grains-dem"],
    );
}

#[test]
fn numbers_that_make_no_sense_are_said() {
    let of = |parameters: Parameters| {
        let found = problems(&valid(), &parameters);
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].to_string()
    };
    let beta = of(Parameters { tangential_restitution: 1.5, ..Parameters::default() });
    assert!(beta.contains("is 1.5, expected a number from -1 to 1"), "{beta}");
    let step = of(Parameters { time_step: Some(Time(-1.0)), ..Parameters::default() });
    assert!(step.contains("is -1 s, expected more than 0"), "{step}");
    let most = of(Parameters { most_collisions: 0, ..Parameters::default() });
    assert!(most.contains("expected at least 1"), "{most}");
    let mut zero = valid();
    zero.contacts[0].law.damping = Damping::Restitution(0.0);
    let found = problems(&zero, &Parameters::default());
    assert!(found[0].to_string().contains("is 0, expected a coefficient of restitution in (0, 1]"));
}

#[test]
fn events_need_that_nothing_acts_in_between() {
    let mut wet = valid();
    wet.fluid = Some(FluidMaterial::at_rest(1000.0, 1e-3));
    let found =
        problems(&wet, &Parameters { detection: Detection::Events, ..Parameters::default() });
    let said = found[0].to_string();
    assert!(said.contains("\"events\", but the fluid acts between collisions"), "{said}");
    let resolution = Parameters::default().resolve(&wet).unwrap();
    assert!(!resolution.by_events && resolution.because.as_deref() == Some("the fluid"));
    assert!(Parameters::default().resolve(&valid()).unwrap().by_events);
}

#[test]
fn a_periodic_box_must_hold_three_diameters() {
    refused(
        |scene| {
            scene.domain.faces = PERIODIC;
            scene.domain.max[0] = 2.5;
            scene.bodies[0].placement =
                Placement::Listed(vec![sphere([1.0, 5.0, 5.0], 1.0, [0.0; 3])]);
        },
        "scene.domain",
        &["is 2.5 m long in x", "at least 3 of the largest diameter", "make it 3.0"],
    );
}

#[test]
fn bodies_that_overlap_are_refused_and_those_that_touch_pushed_apart() {
    let mut scene = valid();
    let pair = |gap: f64| {
        Placement::Listed(vec![
            sphere([5.0; 3], 1.0, [0.0; 3]),
            sphere([6.0 + gap, 5.0, 5.0], 1.0, [0.0; 3]),
        ])
    };
    scene.bodies[0].placement = pair(-0.2);
    let said = problems(&scene, &Parameters::default())[0].to_string();
    assert!(said.contains("overlap by 2.000e-1 m") && said.contains("body 0"), "{said}");
    scene.bodies[0].placement = pair(-0.002);
    let spheres = make(&scene, &Parameters::default(), 0.1);
    let distance = spheres.sphere(1).position[0] - spheres.sphere(0).position[0];
    assert!((distance - 1.0).abs() < 1e-11, "{distance}");
}

#[test]
fn a_scene_that_is_too_dense_is_said_before_the_run() {
    let verdict = |edge: usize, diameter: f64| {
        let mut scene = scene([edge as f64; 3], PERIODIC, 0.9, 0.0);
        let place =
            |k: usize| [k % edge, k / edge % edge, k / (edge * edge)].map(|n| n as f64 + 0.5);
        let all = (0..edge.pow(3)).map(|k| sphere(place(k), diameter, [0.0; 3])).collect();
        scene.bodies = vec![set(Motion::Free, 1000.0, all)];
        let resolution = Parameters::default().resolve(&scene).unwrap();
        let all = findings(&scene, &resolution);
        (all[0].verdict, all[0].why.clone())
    };
    assert_eq!(verdict(4, 0.7).0, Verdict::Ok);
    let (dense, why) = verdict(4, 0.999);
    assert_eq!(dense, Verdict::Doubtful);
    assert!(why.contains("two by two"), "{why}");
    let mut packed = valid();
    packed.bodies[0].placement = Placement::Packed(Packing {
        min: [0.0; 3],
        max: [10.0; 3],
        fraction: 0.62,
        diameters: Diameters::Uniform { min: 1.0, max: 1.0 },
        seed: 1,
    });
    let resolution = Parameters::default().resolve(&packed).unwrap();
    let found = &findings(&packed, &resolution)[0];
    assert_eq!(found.verdict, Verdict::Wrong);
    assert!(
        found.why.contains("too dense for hard spheres") && found.remedy.contains("grains-dem")
    );
}

#[test]
fn loads_must_be_those_of_the_bodies() {
    let mut scene = valid();
    scene.fluid = Some(FluidMaterial::at_rest(1000.0, 1e-3));
    let fresh = || HardSpheres::new(&scene, &Parameters::default(), 1e-3, 1).unwrap();
    let load = |id: u64, force: f64| Load { id, force: [force, 0.0, 0.0], torque: [0.0; 3] };
    let said = |loads: &[Load]| fresh().advance(1, loads).unwrap_err().to_string();
    assert!(said(&[load(0, 0.0); 2]).contains("2 loads for 1 bodies"));
    assert!(said(&[load(4, 0.0)]).contains("load 0 is for body 4, expected body 0"));
    assert!(said(&[load(0, f64::NAN)]).contains("is not finite"));
    // A force of a mass gives an acceleration of one.
    let mut spheres = fresh();
    let mass = 1000.0 * std::f64::consts::PI / 6.0;
    spheres.advance(500, &[load(0, 2.0 * mass)]).unwrap();
    assert!((spheres.sphere(0).velocity[0] - 2.0).abs() < 1e-12);
    assert!((spheres.sphere(0).position[0] - 5.75).abs() < 1e-12);
}
