//! Mistakes of a user in parameters, and the messages on them.

use crate::common::*;
use tremie_fluid_lbm::{Collision, Extreme, FluidError, LbmFluid, Parameters, Precision, findings};
use tremie_messages::scene::{BodySet, Geometry, Motion, Placement, Plane, Scene, Sphere};
use tremie_messages::units::Time;
use tremie_messages::{BodyEvent, BodyState, Problem, Verdict};

/// Water in a box of 20 x 10 x 10 mm.
fn water() -> Scene {
    let mut scene = Case::new([1; 3], [PERIODIC, WALL, WALL], 0.8).scene();
    scene.domain.max = [20e-3, 10e-3, 10e-3];
    let fluid = scene.fluid.as_mut().unwrap();
    (fluid.density, fluid.viscosity) = (1000.0, 1e-3);
    scene
}

fn problems(parameters: &Parameters, scene: &Scene) -> Vec<Problem> {
    parameters.resolve(scene).unwrap_err()
}

/// The only problem, as text.
fn problem(parameters: &Parameters, scene: &Scene) -> String {
    let problems = problems(parameters, scene);
    assert_eq!(problems.len(), 1, "{problems:?}");
    problems[0].to_string()
}

#[test]
fn defaults_resolve() {
    let resolution = Parameters::with_cell(0.5e-3).resolve(&water()).unwrap();
    assert_eq!(resolution.cells, [40, 20, 20]);
    assert!((resolution.tau - 0.8).abs() < 1e-12);
    // dt = (tau - 1/2) dx^2 / (3 nu)
    assert!((resolution.time_step - 0.3 * 0.25e-6 / 3e-6).abs() < 1e-12);
    assert_eq!(resolution.expected_mach, None);
    assert!(resolution.warnings.is_empty(), "{:?}", resolution.warnings);
}

#[test]
fn an_expected_speed_shortens_the_default_step() {
    let mut scene = water();
    scene.fluid.as_mut().unwrap().expected_speed = Some(0.01);
    let resolution = Parameters::with_cell(0.5e-3).resolve(&scene).unwrap();
    assert!((resolution.expected_mach.unwrap() - 0.1).abs() < 1e-12);
    assert!(resolution.tau < 0.8);
}

#[test]
fn the_step_follows_from_tau_and_tau_from_the_step() {
    let by_tau = Parameters { relaxation_time: Some(0.65), ..Parameters::with_cell(0.5e-3) };
    let resolution = by_tau.resolve(&water()).unwrap();
    let by_step =
        Parameters { time_step: Some(Time(resolution.time_step)), ..Parameters::with_cell(0.5e-3) };
    assert!((by_step.resolve(&water()).unwrap().tau - 0.65).abs() < 1e-12);
}

#[test]
fn each_wrong_parameter_is_named() {
    let good = Parameters::with_cell(0.5e-3);
    for (parameters, key) in [
        (Parameters::with_cell(0.0), "cell"),
        (Parameters::with_cell(f64::NAN), "cell"),
        (Parameters { time_step: Some(Time(-1.0)), ..good.clone() }, "time_step"),
        (Parameters { relaxation_time: Some(0.5), ..good.clone() }, "relaxation_time"),
        (Parameters { magic: 0.0, ..good.clone() }, "magic"),
        (Parameters { mach_limit: 2.0, ..good.clone() }, "mach_limit"),
    ] {
        let found = problems(&parameters, &water());
        assert_eq!(found[0].key, format!("{}{key}", Problem::PARAMETER_PREFIX));
    }
    let both =
        Parameters { time_step: Some(Time(1e-3)), relaxation_time: Some(0.8), ..good.clone() };
    assert!(problem(&both, &water()).contains("together with time_step"));
}

#[test]
fn each_wrong_part_of_the_scene_is_named() {
    let parameters = Parameters::with_cell(0.5e-3);
    let mut scene = water();
    let fluid = scene.fluid.as_mut().unwrap();
    (fluid.density, fluid.viscosity) = (0.0, -1.0);
    scene.domain.faces[0][1] = WALL;
    scene.planes.push(Plane { point: [0.0; 3], normal: [0.0, 0.0, 2.0], material: "wall".into() });
    let keys: Vec<_> = problems(&parameters, &scene).into_iter().map(|p| p.key).collect();
    assert_eq!(
        keys,
        [
            "scene.fluid.density",
            "scene.fluid.viscosity",
            "scene.domain.faces.x",
            "scene.planes[0].normal"
        ]
    );
    let mut dry = water();
    dry.fluid = None;
    assert!(problem(&parameters, &dry).contains("scene.fluid"));
}

#[test]
fn a_cell_that_does_not_fit_is_answered_with_those_that_do() {
    let text = problem(&Parameters::with_cell(0.3e-3), &{
        let mut scene = water();
        scene.domain.max = [9.1e-3, 9e-3, 9e-3];
        scene
    });
    assert!(text.contains("along x") && text.contains("30.3333"), "{text}");
    assert!(text.contains("2.935484e-4") && text.contains("3.033333e-4"), "{text}");
}

#[test]
fn a_step_too_short_or_too_long_is_answered_with_one_that_would_do() {
    let mut scene = water();
    let short = Parameters { time_step: Some(Time(1e-9)), ..Parameters::with_cell(0.5e-3) };
    let text = problem(&short, &scene);
    assert!(text.contains("stability limit") && text.contains("at least"), "{text}");
    scene.fluid.as_mut().unwrap().expected_speed = Some(1.0);
    let fast = Parameters { relaxation_time: Some(0.8), ..Parameters::with_cell(0.5e-3) };
    let text = problem(&fast, &scene);
    assert!(text.contains("Mach") && text.contains("would do"), "{text}");
}

#[test]
fn a_lattice_beyond_memory_is_refused() {
    for cell in [1e-6, 1e-7, 1e-12] {
        let text = problem(&Parameters::with_cell(cell), &water());
        assert!(text.contains("more than fit in memory"), "{text}");
    }
    assert!(!problems(&Parameters::with_cell(1e-300), &water()).is_empty());
}

#[test]
fn small_spheres_are_found() {
    for (diameter, expected) in [(0.6e-3, Verdict::Wrong), (2e-3, Verdict::Doubtful)] {
        let mut scene = water();
        scene.bodies.push(BodySet {
            name: "grains".into(),
            density: 2500.0,
            material: "grains".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(vec![Sphere {
                position: [5e-3; 3],
                diameter,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
            }]),
        });
        let parameters = Parameters::with_cell(0.5e-3);
        let resolution = parameters.resolve(&scene).unwrap();
        assert!((resolution.cells_per_smallest_sphere.unwrap() - diameter / 0.5e-3).abs() < 1e-9);
        let findings = findings(&parameters, &scene, &resolution);
        let sphere = findings.iter().find(|f| f.quantity == "cells across the smallest sphere");
        assert_eq!(sphere.unwrap().verdict, expected, "{findings:?}");
    }
}

#[test]
fn an_assigned_step_may_be_shorter_but_not_too_short() {
    let parameters = Parameters::with_cell(0.5e-3);
    let step = parameters.resolve(&water()).unwrap().time_step;
    let fluid = LbmFluid::new(&water(), &parameters, 0.5 * step, 1).unwrap();
    assert!((fluid.tau() - 0.65).abs() < 1e-12);
    assert_eq!(fluid.time_step(), 0.5 * step);
    for wrong in [1e-6 * step, 0.0, -step, f64::NAN] {
        assert!(LbmFluid::new(&water(), &parameters, wrong, 1).is_err());
    }
}

#[test]
fn parameters_read_from_a_table() {
    let parameters: Parameters =
        serde_json::from_str(r#"{"cell": "0.5 mm", "collision": "bgk", "precision": "f32"}"#)
            .unwrap();
    let expected = Parameters {
        collision: Collision::Bgk,
        precision: Precision::F32,
        ..Parameters::with_cell("0.5 mm".parse::<tremie_messages::units::Length>().unwrap().0)
    };
    assert_eq!(parameters, expected);
    assert!(
        serde_json::from_str::<Parameters>(r#"{"cell": "0.5 mm", "colision": "bgk"}"#).is_err()
    );
}

#[test]
fn wrong_events_and_states_are_refused_and_change_nothing() {
    let mut fluid = Case::new([16; 3], [PERIODIC; 3], 0.8).fluid();
    fluid.apply_events(&[added(4, 2.0)]).unwrap();
    type Expected = fn(&FluidError) -> bool;
    let wrong: [(BodyEvent, Expected); 6] = [
        (added(4, 2.0), |e| matches!(e, FluidError::AddedTwice { id: 4 })),
        (removed(5), |e| matches!(e, FluidError::NotThere { id: 5 })),
        (added(5, 0.0), |e| matches!(e, FluidError::Radius { .. })),
        (added(5, 8.1), |e| matches!(e, FluidError::TooWide { .. })),
        (BodyEvent { shape: 9, ..added(5, 1.0) }, |e| matches!(e, FluidError::UnknownEvent { .. })),
        (BodyEvent { kind: 9, ..added(5, 1.0) }, |e| matches!(e, FluidError::UnknownEvent { .. })),
    ];
    for (event, expected) in wrong {
        let error = fluid.apply_events(&[added(6, 1.0), event]).unwrap_err();
        assert!(expected(&error), "{error}");
    }
    let body = BodyState::at_rest(4, [8.0; 3]);
    let step = |fluid: &mut LbmFluid, bodies: &[BodyState]| {
        fluid.step(bodies, &mut loads_of(bodies)).map_err(|e| e.to_string())
    };
    assert!(step(&mut fluid, &[]).unwrap_err().contains("found the end of the list"));
    assert!(step(&mut fluid, &[BodyState { id: 3, ..body }]).unwrap_err().contains("body 4"));
    let lost = BodyState { position: [f64::NAN; 3], ..body };
    assert!(step(&mut fluid, &[lost]).unwrap_err().contains("not finite"));
    assert!(fluid.step(&[body], &mut []).is_err());
    step(&mut fluid, &[body]).unwrap();
}

#[test]
fn a_fluid_out_of_hand_is_found() {
    let mut fluid = Case::new([8; 3], [PERIODIC; 3], 0.8).fluid();
    fluid.set_state(|x| {
        ([if x[0] == 2.5 && x[1] == 3.5 && x[2] == 4.5 { 0.2 } else { 0.0 }, 0.0, 0.0], 0.0)
    });
    assert!(matches!(fluid.check(), Err(FluidError::Mach { cell: [2, 3, 4], .. })));
    assert_eq!(fluid.place_of(Extreme::Speed), Some([2.5, 3.5, 4.5]));
    fluid.allow_any_speed();
    assert!(fluid.check().is_ok(), "what runs it watches the Mach number");
    fluid.set_state(|x| ([if x[2] == 6.5 { f64::NAN } else { 0.0 }, 0.0, 0.0], 0.0));
    assert!(matches!(fluid.check(), Err(FluidError::NonFinite { cell: [0, 0, 6], .. })));
    // A rarefied cell deviates more than a compressed one.
    fluid.set_state(|x| {
        let pressure = match x.map(|x| x as usize) {
            [1, 2, 3] => 1e-3,
            [5, 6, 7] => -2e-3,
            _ => 0.0,
        };
        ([0.0; 3], pressure)
    });
    assert_eq!(fluid.place_of(Extreme::DensityDeviation), Some([5.5, 6.5, 7.5]));
}

#[test]
fn a_slice_shows_velocity_pressure_and_solids() {
    let mut fluid = Case::new([6, 5, 4], [PERIODIC; 3], 0.8).fluid();
    fluid.set_state(|x| ([1e-3 * x[0], 0.0, 0.0], 1e-4 * x[1]));
    let body = [BodyState::at_rest(1, [1.5, 2.5, 1.5])];
    fluid.apply_events(&[added(1, 0.6)]).unwrap();
    fluid.start(&body, &mut loads_of(&body)).unwrap();
    let mut nodes = Vec::new();
    assert_eq!(fluid.slice(2, 1.7, &mut nodes), [6, 5]);
    assert_eq!(nodes.len(), 30);
    for (k, node) in nodes.iter().enumerate() {
        let (x, y) = (k % 6, k / 6);
        assert_eq!(node.solid, (x, y) == (1, 2));
        if !node.solid {
            assert!((node.velocity[0] - 1e-3 * (x as f64 + 0.5)).abs() < 1e-15);
            assert!((node.pressure - 1e-4 * (y as f64 + 0.5)).abs() < 1e-15);
        }
    }
    assert_eq!(fluid.slice(0, -3.0, &mut nodes), [5, 4]);
    assert_eq!(fluid.slice(1, 99.0, &mut nodes), [6, 4]);
}

#[test]
fn a_fluid_may_change_its_thread() {
    fn send<T: Send>(_: &T) {}
    send(&Case::new([4; 3], [PERIODIC; 3], 0.8).fluid());
}

/// A file with a triangle turned round says so.
#[test]
fn what_was_mended_is_told() {
    let file = std::env::temp_dir().join(format!("tremie-turned-{}.obj", std::process::id()));
    // A tetrahedron whose last face winds the wrong way.
    let text = "v 2 2 2\nv 6 2 2\nv 2 6 2\nv 2 2 6\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n";
    std::fs::write(&file, text).unwrap();
    let case = Case::new([12; 3], [WALL; 3], 0.8);
    let mut scene = case.scene();
    let path = file.to_str().unwrap().into();
    scene.parts.push(part("wedge", Geometry::File { path, unit: 1.0 }, [1.0; 3]));
    let parameters = case.parameters();
    let resolution = parameters.resolve(&scene);
    std::fs::remove_file(&file).unwrap();
    let resolution = resolution.unwrap();
    let findings = findings(&parameters, &scene, &resolution);
    let found = findings.iter().find(|f| f.quantity == "repairs of wedge").unwrap();
    assert_eq!((found.value, found.verdict), (1.0, Verdict::Doubtful));
    assert!(found.why.contains("1 triangles turned round"), "{found:?}");
    // The wedge is three cells from three walls.
    let gap = findings.iter().find(|f| f.quantity == "cells across the narrowest gap").unwrap();
    assert_eq!((gap.value, gap.verdict), (3.0, Verdict::Doubtful));
    assert!(gap.why.starts_with("between wedge and the lower x face"), "{gap:?}");
    assert!(gap.remedy.contains("0.75 m"), "{gap:?}");
}
