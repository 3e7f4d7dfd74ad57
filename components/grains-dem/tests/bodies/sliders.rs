//! Parts on an axis: springs, stops, and grains that hold them.

use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters, SliderState, findings};
use tremie_messages::{
    Problem, Verdict,
    body::{BodyEvent, Load},
    scene::{
        Damping, Face, Geometry, Motion, Part, PartBoundary, Pose, Scene, Slider, SliderSpring,
        Stops,
    },
};

const M: f64 = 9.2e-3;
const D: f64 = 1e-3;
const VALVE: SliderSpring = SliderSpring::Tangent { rate: 625.0, preload: 57.5, stroke: 4.5e-3 };

fn stops(restitution: f64) -> Option<Stops> {
    Some(Stops { lower: Some(0.0), upper: Some(4.5e-3), stiffness: 1e7, restitution })
}

fn slider(spring: SliderSpring, stops: Option<Stops>) -> Slider {
    Slider { axis: [0.0, 0.0, 2.0], mass: M, lift: 0.0, velocity: 0.0, spring, force: 0.0, stops }
}

/// A plate of 8 mm x 8 mm x 2 mm about `position`.
fn plate(position: [f64; 3], slider: Slider) -> Part {
    Part {
        name: "plate".into(),
        geometry: Geometry::Box { size: [8e-3, 8e-3, 2e-3] },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Slider(Box::new(slider)),
        boundary: PartBoundary::Wall,
    }
}

/// A box of 20 mm with a plate in the middle.
fn alone(slider: Slider) -> Scene {
    let mut scene = scene([20e-3; 3], WALLS, law(2e3, 0.5, Damping::Restitution(0.5)));
    scene.parts = vec![plate([10e-3; 3], slider)];
    scene
}

fn lift(dem: &GrainsDem) -> SliderState {
    dem.sliders().next().unwrap()
}

fn energy(dem: &mut GrainsDem) -> f64 {
    let d = dem.diagnostics();
    d.kinetic_energy + d.rotational_energy + d.potential_energy + d.elastic_energy
}

/// Error of the lift after 1.7 periods on a linear spring, with weight and a constant force, and
/// the largest error of the energy, over its scale.
fn oscillate(steps: u32) -> (f64, f64) {
    let (rate, preload, force, g) = (625.0, 0.4, 0.3, 9.81);
    let mut valve = slider(SliderSpring::Linear { rate, preload }, None);
    (valve.lift, valve.velocity, valve.force) = (0.5e-3, 0.2, force);
    let mut scene = alone(valve);
    scene.gravity = [3.0, 0.0, -g];
    let omega = (rate / M).sqrt();
    let time = 1.7 * std::f64::consts::TAU / omega;
    let mut dem = make(&scene, time / f64::from(steps));
    let start = energy(&mut dem);
    let mut off = 0.0f64;
    for _ in 0..10 {
        dem.advance(steps / 10, &[]).unwrap();
        off = off.max((energy(&mut dem) - start).abs());
    }
    let rest = (force - M * g - preload) / rate;
    let exact = rest + (0.5e-3 - rest) * (omega * time).cos() + 0.2 / omega * (omega * time).sin();
    ((lift(&dem).lift - exact).abs() / (0.2 / omega), off / (0.5 * M * 0.04))
}

#[test]
fn a_slider_on_a_spring_oscillates_as_it_should_with_order_two() {
    let (coarse, fine) = (oscillate(1_000), oscillate(2_000));
    assert!(coarse.0 < 2e-4 && coarse.1 < 2e-4, "{coarse:?}");
    assert!((coarse.0 / fine.0 - 4.0).abs() < 0.05, "{coarse:?} {fine:?}");
    assert!((coarse.1 / fine.1 - 4.0).abs() < 0.2, "{coarse:?} {fine:?}");
}

/// The published force, integrated by Simpson's rule.
fn work_of_the_tan_law(to: f64) -> f64 {
    let (a, n) = (4.5e-3, 2_000);
    let force = |y: f64| {
        let quarter = std::f64::consts::FRAC_PI_2;
        57.5 + 625.0 * a / quarter * (quarter * y / a).tan()
    };
    let h = to / f64::from(n);
    let at = |k: i32| h * f64::from(k);
    let of = |k| force(at(k)) + 4.0 * force(at(k) + 0.5 * h) + force(at(k) + h);
    (0..n).map(of).sum::<f64>() * h / 6.0
}

#[test]
fn the_tan_law_takes_the_energy_of_its_integral() {
    let mut valve = slider(VALVE, stops(1.0));
    valve.velocity = 7.4;
    let mut dem = make(&alone(valve), 1e-7);
    let (mut highest, mut seen) = (0.0f64, 0);
    let start = energy(&mut dem);
    while lift(&dem).velocity > 0.0 {
        dem.advance(500, &[]).unwrap();
        let s = lift(&dem);
        highest = highest.max(s.lift);
        let exact = 0.5 * M * 7.4 * 7.4 - work_of_the_tan_law(s.lift);
        assert!((0.5 * M * s.velocity * s.velocity - exact).abs() < 1e-6, "{s:?} {exact}");
        assert!((energy(&mut dem) - start).abs() < 1e-6);
        seen += 1;
    }
    assert!(highest > 4.0e-3 && highest < 4.5e-3 && seen > 10, "{highest} {seen}");
}

#[test]
fn a_slider_comes_back_from_a_stop_with_its_restitution() {
    for e in [0.2, 0.8, 1.0] {
        for speed in [0.5, -0.5] {
            let mut valve = slider(SliderSpring::None, stops(e));
            (valve.lift, valve.velocity) = (2e-3, speed);
            // A collision takes 95 us: 1,000 steps. Where the dashpot sets in between two of them
            // is of first order.
            let mut dem = make(&alone(valve), 1e-7);
            dem.advance(80_000, &[]).unwrap();
            let back = lift(&dem).velocity;
            assert!((back / (-e * speed) - 1.0).abs() < 3e-3, "{e} {speed}: {back}");
            assert_eq!(lift(&dem).stop_force, 0.0);
        }
    }
}

#[test]
fn a_valve_closes_on_its_stop_and_rests_there() {
    let mut valve = slider(VALVE, stops(0.2));
    (valve.lift, valve.force) = (1e-3, -3.96);
    let mut dem = make(&alone(valve), 1e-6);
    dem.advance(5_000, &[]).unwrap();
    let rest = lift(&dem);
    let depth = (57.5 + 3.96) / (1e7 + 625.0);
    assert!((rest.lift / -depth - 1.0).abs() < 1e-6, "{rest:?}");
    assert!(rest.velocity.abs() < 1e-6, "{rest:?}");
    assert!((rest.stop_force + rest.spring_force - 3.96).abs() < 1e-6, "{rest:?}");
}

/// A plate on a spring lies on a sphere that lies on the floor.
#[test]
fn a_grain_under_a_slider_carries_the_load() {
    let (k, load) = (2e5, 5.0);
    let mut valve = slider(SliderSpring::Linear { rate: 625.0, preload: load }, stops(0.2));
    // Light, so that the contacts' dashpots stop it soon.
    (valve.mass, valve.lift) = (1e-5, 1.2e-3);
    let mut scene = alone(valve);
    // At lift 0 the plate's face is on the floor.
    scene.parts[0].pose.position = [10e-3, 10e-3, 1e-3 + 1.2e-3];
    for pair in &mut scene.contacts {
        pair.law = law(k, 0.5, Damping::Restitution(0.3));
    }
    scene.bodies = vec![set(Motion::Free, vec![sphere([10.4e-3, 9.7e-3, 0.5 * D], D, [0.0; 3])])];
    let mut dem = make(&scene, 1e-7);
    dem.advance(200_000, &[]).unwrap();
    let rest = lift(&dem);
    // 2 f/k + y = D, f = load + 625 y.
    let y = (D - 2.0 * load / k) / (1.0 + 2.0 * 625.0 / k);
    let force = load + 625.0 * y;
    assert!((rest.lift - y).abs() < 1e-8 * D, "{rest:?} {y}");
    assert!((rest.contact_force / force - 1.0).abs() < 1e-7, "{rest:?} {force}");
    assert!((rest.spring_force / -force - 1.0).abs() < 1e-7, "{rest:?}");
    assert_eq!((rest.stop_force, rest.fluid_force), (0.0, 0.0));
    assert!((state(&dem)[0].position[2] - 0.5 * D + force / k).abs() < 1e-8 * D);
    let (on_part, _) = dem.part_loads().next().unwrap();
    assert!((on_part[2] / force - 1.0).abs() < 1e-7, "{on_part:?}");
}

#[test]
fn a_collision_keeps_momentum_and_has_its_restitution() {
    let mut block = slider(SliderSpring::None, None);
    (block.mass, block.velocity) = (3.0 * mass(D), -0.1);
    let mut scene = alone(block);
    scene.bodies = vec![set(Motion::Free, vec![sphere([10e-3, 10e-3, 8.4e-3], D, [0.0; 3])])];
    scene.parts[0].pose.position[2] = 10e-3;
    for pair in &mut scene.contacts {
        pair.law = law(2e3, 0.0, Damping::Restitution(0.6));
    }
    let mut dem = make(&scene, 2e-7);
    let before = dem.diagnostics().momentum[2];
    dem.advance(20_000, &[]).unwrap();
    let (v, w) = (state(&dem)[0].velocity[2], lift(&dem).velocity);
    // The centre of mass goes at three quarters of 0.1 m/s.
    assert!(((v - w) / -0.06 - 1.0).abs() < 3e-3, "{v} {w}");
    assert!((v / (-0.1 * 0.75 * 1.6) - 1.0).abs() < 1e-3, "{v}");
    let after = dem.diagnostics().momentum[2];
    assert!((after / before - 1.0).abs() < 1e-12, "{before} {after}");
}

#[test]
fn loads_come_by_the_parts_id_and_act_along_the_axis() {
    let mut scene = alone(slider(SliderSpring::None, None));
    scene.bodies = vec![set(Motion::Fixed, vec![sphere([3e-3; 3], D, [0.0; 3])])];
    let mut dem = make(&scene, 1e-5);
    let event = dem.events()[1];
    assert_eq!((event.id, event.shape, event.motion), (1, BodyEvent::PART, BodyEvent::SLIDER));
    assert_eq!((event.mass, event.table), (M, 0));
    let load = Load { id: 1, force: [7.0, -3.0, 0.5], torque: [1.0; 3] };
    dem.advance(100, &[Load { id: 0, ..Load::default() }, load]).unwrap();
    let (t, moved) = (1e-3, lift(&dem));
    assert!((moved.lift / (0.5 * 0.5 / M * t * t) - 1.0).abs() < 1e-9, "{moved:?}");
    assert_eq!(moved.fluid_force, 0.5);
    let seen = state(&dem)[1];
    assert_eq!(seen.position, [10e-3, 10e-3, 10e-3 + moved.lift]);
    assert_eq!(seen.velocity, [0.0, 0.0, moved.velocity]);
    assert!((dem.diagnostics().fluid_impulse[2] / 0.5e-3 - 1.0).abs() < 1e-12);
    // A dry window forgets the load.
    dem.advance(1, &[]).unwrap();
    assert_eq!(lift(&dem).fluid_force, 0.0);
    let nan = Load { id: 1, force: [f64::NAN; 3], torque: [0.0; 3] };
    assert!(dem.advance(1, &[Load::default(), nan]).is_err());
}

/// A plate falls on two spheres, the mirror images of each other; or half of it on one.
fn halved(cut: bool) -> (SliderState, f64, [f64; 3]) {
    let mut valve = slider(SliderSpring::Linear { rate: 625.0, preload: 1.0 }, None);
    valve.velocity = -0.3;
    let mut scene = alone(valve);
    for pair in &mut scene.contacts {
        pair.law = law(1e4, 0.3, Damping::Restitution(1.0));
    }
    let mut spheres = vec![sphere([12e-3, 10e-3, 8.3e-3], D, [0.0; 3])];
    if cut {
        scene.domain.min[0] = 10e-3;
        scene.domain.faces[0][0] = Face::Symmetry;
    } else {
        spheres.push(sphere([8e-3, 10e-3, 8.3e-3], D, [0.0; 3]));
    }
    scene.bodies = vec![set(Motion::Free, spheres)];
    let mut dem = make(&scene, 5e-7);
    let start = energy(&mut dem);
    while lift(&dem).contact_force == 0.0 {
        dem.advance(1, &[]).unwrap();
    }
    dem.advance(30, &[]).unwrap();
    let share = if cut { 2.0 } else { 1.0 };
    let scale = 0.5 * M * 0.09;
    // Energy of the half is that of the half: it is kept.
    assert!((energy(&mut dem) - start).abs() < 1e-4 * scale);
    let (force, _) = dem.part_loads().next().unwrap();
    (lift(&dem), share * energy(&mut dem), force)
}

#[test]
fn half_a_slider_at_a_mirror_moves_as_the_whole() {
    let ((whole, e, f), (half, e2, f2)) = (halved(false), halved(true));
    assert!((whole.lift - half.lift).abs() < 1e-13, "{whole:?} {half:?}");
    assert!((whole.contact_force / half.contact_force - 1.0).abs() < 1e-9, "{whole:?} {half:?}");
    assert!((e / e2 - 1.0).abs() < 1e-9, "{e} {e2}");
    assert!((f[2] / f2[2] - 1.0).abs() < 1e-9 && f2[0] == 0.0, "{f:?} {f2:?}");
}

/// A lid falls on a bed of several blocks of grains.
fn lidded(threads: usize, skin: f64) -> (SliderState, Vec<tremie_messages::body::BodyState>) {
    let mut lid = slider(SliderSpring::Linear { rate: 50.0, preload: 0.2 }, None);
    lid.mass = 2e-4;
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law(1e3, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [10.0, 3.0, -100.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.4, (0.7e-3, 0.9e-3), 2)];
    scene.parts = vec![plate([7e-3, 7e-3, 8e-3], lid)];
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(&scene, &parameters, 4e-6, threads).unwrap();
    assert!(dem.radii().len() > 1024, "more than two blocks");
    for _ in 0..10 {
        dem.advance(120, &[]).unwrap();
    }
    let lid = lift(&dem);
    assert!(lid.contact_force > 0.0, "{lid:?}");
    (lid, state(&dem))
}

#[test]
fn threads_and_skin_do_not_enter_the_motion_of_a_slider() {
    let one = lidded(1, 0.1);
    for (threads, skin) in [(2, 0.1), (4, 0.1), (2, 0.03), (1, 0.17)] {
        assert_eq!(one, lidded(threads, skin), "{threads} {skin}");
    }
}

fn problems(change: impl Fn(&mut Slider)) -> Vec<Problem> {
    let mut valve = slider(VALVE, stops(0.5));
    change(&mut valve);
    Parameters::default().resolve(&alone(valve)).map(|_| ()).expect_err("a problem")
}

/// The only problem's key, without that of the motion.
#[track_caller]
fn key(change: impl Fn(&mut Slider)) -> String {
    let found = problems(change);
    assert_eq!(found.len(), 1, "{found:?}");
    found[0].key.strip_prefix("scene.parts[0].motion.slider.").unwrap().to_string()
}

fn change_stops(slider: &mut Slider, change: impl Fn(&mut Stops)) {
    slider.stops.as_mut().into_iter().for_each(change);
}

#[test]
fn a_wrong_slider_is_one_problem() {
    assert_eq!(key(|s| s.axis = [0.0; 3]), "axis");
    assert_eq!(key(|s| s.axis[1] = f64::NAN), "axis");
    for mass in [0.0, -1.0, f64::NAN] {
        assert_eq!(key(|s| s.mass = mass), "mass");
    }
    assert_eq!(key(|s| s.velocity = f64::INFINITY), "velocity");
    // The spring presses it 6e-6 m into its stop; where that is twice as deep it did not get by
    // itself.
    assert_eq!(key(|s| s.lift = -2e-5), "lift");
    assert_eq!(key(|s| s.lift = 4.6e-3), "lift");
    assert_eq!(key(|s| change_stops(s, |stops| stops.upper = Some(-1e-3))), "stops.upper");
    assert_eq!(key(|s| change_stops(s, |stops| stops.lower = Some(f64::NAN))), "stops.lower");
    assert_eq!(key(|s| change_stops(s, |stops| stops.stiffness = 0.0)), "stops.stiffness");
    for e in [0.0, 1.1] {
        assert_eq!(key(|s| change_stops(s, |stops| stops.restitution = e)), "stops.restitution");
    }
    // The tan law ends at its stroke, and needs stops stiffer than itself.
    assert_eq!(key(|s| change_stops(s, |stops| stops.upper = Some(4.6e-3))), "spring.stroke");
    assert_eq!(key(|s| s.stops = None), "spring.stroke");
    // Nor does it begin beyond, however soft the stop.
    let beyond = |s: &mut Slider| {
        s.lift = 4.6e-3;
        change_stops(s, |stops| stops.stiffness = 1e5);
    };
    assert_eq!(key(beyond), "spring.stroke");
    assert_eq!(key(|s| change_stops(s, |stops| stops.stiffness = 600.0)), "spring.rate");
    let rate = SliderSpring::Linear { rate: -1.0, preload: 0.0 };
    assert_eq!(key(|s| s.spring = rate.clone()), "spring.rate");
    for points in [
        vec![],
        vec![[0.0, 1.0]],
        vec![[0.0, 1.0], [4e-3, 2.0]],
        vec![[1e-3, 1.0], [5e-3, 2.0]],
        vec![[0.0, 1.0], [0.0, 2.0], [5e-3, 3.0]],
        vec![[0.0, f64::NAN], [5e-3, 3.0]],
    ] {
        assert_eq!(key(|s| s.spring = SliderSpring::Table(points.clone())), "spring.table");
    }
    let covers = SliderSpring::Table(vec![[0.0, 1.0], [4.5e-3, 2.0]]);
    let good = alone(slider(covers, stops(0.5)));
    assert!(Parameters::default().resolve(&good).is_ok());
    let mut shut = slider(VALVE, stops(0.5));
    shut.lift = -6e-6;
    assert!(Parameters::default().resolve(&alone(shut)).is_ok());
}

#[test]
fn sliders_must_lie_along_mirrors_and_be_parts() {
    let mut scene = alone(slider(VALVE, stops(0.5)));
    scene.domain.faces[2][0] = Face::Symmetry;
    let found = |scene: &Scene| Parameters::default().resolve(scene).map(|_| ()).unwrap_err();
    scene.parts[0].pose.position[2] = 0.0;
    assert_eq!(found(&scene)[0].key, "scene.parts[0].motion.slider.axis");
    scene.parts[0].pose.position[2] = 0.5e-3;
    assert_eq!(found(&scene)[0].key, "scene.parts[0].position");
    let mut scene = alone(slider(VALVE, stops(0.5)));
    let motion = scene.parts[0].motion.clone();
    scene.bodies = vec![set(motion, vec![sphere([3e-3; 3], D, [0.0; 3])])];
    assert_eq!(found(&scene)[0].key, "scene.bodies[0].motion");
}

#[test]
fn the_step_follows_stops_and_spring_and_says_so() {
    let scene = alone(slider(VALVE, stops(0.5)));
    let step_of = |step: Option<f64>| {
        let time_step = step.map(tremie_messages::units::Time);
        let parameters = Parameters { time_step, ..Parameters::default() };
        parameters.resolve(&scene).map(|resolution| {
            let findings = findings(&scene, &parameters, &resolution);
            let doubtful = findings.iter().filter(|f| f.verdict == Verdict::Doubtful).count();
            (resolution.time_step.unwrap(), doubtful)
        })
    };
    let collision = std::f64::consts::PI * (M / 1e7f64).sqrt();
    let (step, doubtful) = step_of(None).unwrap();
    assert!((step / (collision / 20.0) - 1.0).abs() < 1e-12 && doubtful == 0, "{step} {doubtful}");
    // The stop's collision, the spring at its stiffest, and the shortest collision of all.
    assert_eq!(step_of(Some(collision / 10.0)).unwrap().1, 3);
    assert_eq!(step_of(Some(collision / 6.0)).unwrap_err()[0].key, "@time_step");
}
