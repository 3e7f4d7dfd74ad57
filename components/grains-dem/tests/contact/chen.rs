//! The law of Chen et al.: stiffness by the mean mass, contact from a gap on.

use crate::common::solids::*;
use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters, restitution};
use tremie_messages::{
    body::BodyState,
    scene::{
        ContactLaw, Damping, Geometry, Motion, MotionPoint, Part, PartBoundary, Pose, Scene,
        Spring, Tangential,
    },
};

const D: f64 = 1e-3;
const G: f64 = 9.81;
/// Gravity over theta = 0.01 times a cell of 0.5 mm.
const KAPPA: f64 = G / (0.01 * 0.5e-3);
const GAP: f64 = 0.1e-3;
const PSI: f64 = 0.3;

fn chen(gap: f64, alpha: f64, tangential: Tangential) -> ContactLaw {
    ContactLaw {
        spring: Spring::Chen { stiffness_per_mass: KAPPA, gap, psi: PSI, tangential },
        friction: 0.3,
        rolling_friction: 0.0,
        damping: Damping::Ratio(alpha),
        tension: true,
    }
}

fn spring(gap: f64, alpha: f64) -> ContactLaw {
    chen(gap, alpha, Tangential::Spring)
}

/// Speed after over speed before: of two equal spheres, and of one against the floor.
fn rebounds(gap: f64) -> [f64; 2] {
    let speed = 0.05;
    let dt = std::f64::consts::PI / (2.0 * KAPPA).sqrt() / 4000.0;
    let run = |spheres| {
        let mut scene = scene([4e-3; 3], WALLS, spring(gap, 0.4));
        scene.bodies = vec![set(Motion::Free, spheres)];
        let mut dem = make(&scene, dt);
        dem.advance(20_000, &[]).unwrap();
        state(&dem)
    };
    let apart = 0.5 * (D + gap) + 1e-9;
    let pair = run(vec![
        sphere([2e-3 - apart, 2e-3, 2e-3], D, [0.5 * speed, 0.0, 0.0]),
        sphere([2e-3 + apart, 2e-3, 2e-3], D, [-0.5 * speed, 0.0, 0.0]),
    ]);
    let floor = run(vec![sphere([2e-3, 2e-3, 0.5 * D + gap + 1e-9], D, [0.0, 0.0, -speed])]);
    [(pair[1].velocity[0] - pair[0].velocity[0]) / speed, floor[0].velocity[2] / speed]
}

/// As their damping ratio is sqrt(2) alpha of equal bodies, and alpha at a wall.
#[test]
fn restitution_of_a_pair_and_at_a_wall() {
    for gap in [0.0, GAP] {
        let [pair, wall] = rebounds(gap);
        println!("gap {gap}: {pair} {wall}");
        assert!((pair - 0.116).abs() < 1e-3 && (wall - 0.254).abs() < 1e-3, "{pair} {wall}");
    }
    assert!((restitution(0.4 * 2f64.sqrt(), true) - 0.116).abs() < 1e-3);
    assert!((restitution(0.4, true) - 0.254).abs() < 1e-3);
}

fn floor_part(motion: Motion) -> Part {
    Part {
        name: "floor".into(),
        geometry: Geometry::Box { size: [3e-3, 3e-3, 1e-3] },
        pose: Pose { position: [2e-3, 2e-3, 0.5e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

/// A sphere above a floor: a wall, a part, or another sphere that is fixed.
fn above(floor: &str, height: f64, law: ContactLaw) -> (Scene, f64) {
    let mut scene = scene([4e-3; 3], WALLS, law);
    let top = match floor {
        "wall" => 0.0,
        "part" => {
            scene.parts = vec![floor_part(Motion::Fixed)];
            1e-3
        }
        _ => {
            scene.bodies = vec![set(Motion::Fixed, vec![sphere([2e-3, 2e-3, D], D, [0.0; 3])])];
            1.5 * D
        }
    };
    let grain = sphere([2e-3, 2e-3, top + 0.5 * D + height], D, [0.0; 3]);
    scene.bodies.push(set(Motion::Free, vec![grain]));
    (scene, top + 0.5 * D)
}

fn grain(dem: &GrainsDem) -> BodyState {
    *state(dem).last().unwrap()
}

#[test]
fn contact_begins_at_the_gap_and_rests_below_it() {
    let dt = 2e-6;
    for floor in ["wall", "part", "sphere"] {
        // Not yet in reach, and just in it, at rest and without weight.
        for (height, touches) in [(GAP + 1e-7, false), (GAP - 1e-7, true)] {
            let (scene, _) = above(floor, height, spring(GAP, 0.4));
            let mut dem = make(&scene, dt);
            dem.advance(1, &[]).unwrap();
            let v = grain(&dem).velocity[2];
            assert_eq!(v > 0.0, touches, "{floor} {height}: {v}");
            if touches {
                // One step of the spring's force, a whole one less what it gives way.
                assert!((v / (KAPPA * 1e-7 * dt) - 1.0).abs() < 1e-2, "{floor}: {v}");
            }
        }
        let (mut scene, touch) = above(floor, GAP + 1e-5, spring(GAP, 0.4));
        scene.gravity = [0.0, 0.0, -G];
        let mut dem = make(&scene, dt);
        dem.advance(40_000, &[]).unwrap();
        let now = grain(&dem);
        let rest = touch + GAP - G / KAPPA;
        assert!((now.position[2] - rest).abs() < 1e-10, "{floor}: {}", now.position[2] - rest);
        assert!(norm(now.velocity) < 1e-9);
        let seen = dem.diagnostics();
        let expected = 0.5 * mass(D) * KAPPA * (G / KAPPA) * (G / KAPPA);
        assert_eq!((seen.contacts, seen.max_overlap_ratio), (1, 0.0), "{floor}");
        assert!((seen.elastic_energy / expected - 1.0).abs() < 1e-4, "{floor} {seen:?}");
    }
}

/// The spring of a pair is that of the mean mass: an undamped head-on collision of unequal spheres
/// lasts pi sqrt(m*/k).
#[test]
fn unequal_masses() {
    let (a, b) = (D, 0.5 * D);
    let (m, n) = (mass(a), mass(b));
    let time = std::f64::consts::PI * (m * n / (m + n) / (KAPPA * 0.5 * (m + n))).sqrt();
    let mut scene = scene([4e-3; 3], WALLS, spring(GAP, 0.0));
    let start = 2e-3 + 0.5 * (a + b) + GAP;
    let still = sphere([2e-3; 3], a, [0.0; 3]);
    let moving = sphere([start + 1e-10, 2e-3, 2e-3], b, [-0.02, 0.0, 0.0]);
    scene.bodies = vec![set(Motion::Free, vec![still, moving])];
    let resolution = Parameters::default().resolve(&scene).unwrap();
    let known = resolution.contact_time.unwrap();
    assert!((known / time - 1.0).abs() < 1e-12, "{known} {time}");
    let dt = time / 2000.0;
    let mut dem = make(&scene, dt);
    dem.advance(1_995, &[]).unwrap();
    assert_eq!(dem.diagnostics().contacts, 1);
    dem.advance(10, &[]).unwrap();
    assert_eq!(dem.diagnostics().contacts, 0);
    let states = state(&dem);
    let relative = states[1].velocity[0] - states[0].velocity[0];
    assert!((relative / 0.02 - 1.0).abs() < 1e-5, "{relative}");
}

/// The lightest with the heaviest is the quickest contact, not the two lightest.
#[test]
fn the_time_step_knows_the_most_unequal_pair() {
    let mut scene = scene([10e-3; 3], WALLS, spring(0.0, 0.4));
    let at = |x: f64, d: f64| sphere([x, 5e-3, 5e-3], d, [0.0; 3]);
    let spheres = vec![at(2e-3, 0.5e-3), at(3.5e-3, 0.5e-3), at(5e-3, 1e-3), at(7.5e-3, 2e-3)];
    scene.bodies = vec![set(Motion::Free, spheres)];
    let (m, n) = (mass(2e-3), mass(0.5e-3));
    let time = std::f64::consts::PI * (m * n / (m + n) / (KAPPA * 0.5 * (m + n))).sqrt();
    let resolution = Parameters::default().resolve(&scene).unwrap();
    let found = resolution.contact_time.unwrap();
    assert!((found / time - 1.0).abs() < 1e-12, "{found} {time}");
    assert!(!resolution.hertz);
}

fn momenta(states: &[BodyState], diameters: [f64; 2]) -> [[f64; 3]; 2] {
    let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
    for (s, d) in states.iter().zip(diameters) {
        let p = s.velocity.map(|v| mass(d) * v);
        let turning = cross(s.position, p);
        for a in 0..3 {
            linear[a] += p[a];
            angular[a] += turning[a] + inertia(d) * s.angular_velocity[a];
        }
    }
    [linear, angular]
}

#[test]
fn a_pair_keeps_its_momenta() {
    for tangential in [Tangential::Spring, Tangential::OneStep] {
        let mut scene = scene([8e-3; 3], WALLS, chen(GAP, 0.4, tangential));
        let diameters = [1e-3, 0.7e-3];
        let mut one = sphere([3e-3, 4e-3, 4e-3], diameters[0], [0.1, 0.02, 0.0]);
        one.angular_velocity = [30.0, -20.0, 50.0];
        let other = sphere([4.1e-3, 4.4e-3, 3.9e-3], diameters[1], [-0.1, 0.0, 0.03]);
        scene.bodies = vec![set(Motion::Free, vec![one, other])];
        let mut dem = make(&scene, 2e-6);
        let start = momenta(&state(&dem), diameters);
        let spin = state(&dem)[1].angular_velocity;
        dem.advance(3_000, &[]).unwrap();
        let states = state(&dem);
        assert!(norm(minus(states[1].angular_velocity, spin)) > 1.0, "they rubbed");
        let end = momenta(&states, diameters);
        let [linear, angular] = [0, 1].map(|k| norm(minus(end[k], start[k])) / norm(start[k]));
        println!("{tangential:?}: {linear} {angular}");
        assert!(linear < 1e-13 && angular < 1e-12, "{linear} {angular}");
    }
}

/// The printed tangential force knows one step: it is that of a dashpot.
#[test]
fn one_step_is_a_dashpot() {
    let dt = 2e-6;
    let k = KAPPA * mass(D);
    let c = 2.0 * 0.4 * mass(D) * KAPPA.sqrt();
    let across = 2.0 * (1.0 + PSI);
    let dashpot = k / across * dt + c / across.sqrt();
    let plain = ContactLaw {
        spring: Spring::Linear { normal_stiffness: k, tangential_stiffness: 0.0 },
        damping: Damping::Coefficients { normal: c, tangential: dashpot },
        ..chen(0.0, 0.4, Tangential::OneStep)
    };
    let run = |law: ContactLaw| {
        let mut scene = scene([4e-3; 3], WALLS, law);
        scene.gravity = [0.5, 0.0, -G];
        let mut grain = sphere([1e-3, 2e-3, 0.5 * D + 1e-5], D, [0.02, 0.0, 0.0]);
        grain.angular_velocity = [10.0, -20.0, 3.0];
        scene.bodies = vec![set(Motion::Free, vec![grain])];
        let mut dem = make(&scene, dt);
        dem.advance(10_000, &[]).unwrap();
        state(&dem)[0]
    };
    let (one, other) = (run(chen(0.0, 0.4, Tangential::OneStep)), run(plain));
    let apart = norm(minus(one.velocity, other.velocity)) / norm(other.velocity);
    let turned = norm(minus(one.angular_velocity, other.angular_velocity));
    println!("apart by {apart} {turned}");
    assert!(apart < 1e-10 && turned < 1e-10 * norm(other.angular_velocity), "{apart} {turned}");
    // A spring that remembers is something else.
    let sprung = run(spring(0.0, 0.4));
    assert!(norm(minus(one.velocity, sprung.velocity)) > 1e-4 * norm(other.velocity));
}

/// Grains that fall through periodic sides onto a floor with a turning part.
fn crowd(threads: usize) -> Vec<BodyState> {
    let law = chen(0.05e-3, 0.4, Tangential::Spring);
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law);
    scene.gravity = [2.0, 1.0, -20.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.3, (0.7e-3, 0.9e-3), 2)];
    let turning =
        MotionPoint { time: 0.0, velocity: [0.1, 0.0, 0.0], angular_velocity: [0.0, 0.0, 20.0] };
    scene.parts = vec![floor_part(Motion::Prescribed(vec![turning]))];
    scene.parts[0].pose.position = [7e-3, 7e-3, 2e-3];
    let mut dem = GrainsDem::new(&scene, &Parameters::default(), 1e-5, threads).unwrap();
    dem.advance(1_500, &[]).unwrap();
    let seen = dem.diagnostics();
    assert!(seen.list_rebuilds > 2 && seen.contacts > 500, "{seen:?}");
    state(&dem)
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let one = crowd(1);
    assert!(one.len() > 1024);
    assert_eq!(one, crowd(2));
}

/// A body that the gap carries has no overlap.
#[test]
fn no_overlap_is_expected_within_the_gap() {
    let (mut scene, _) = above("wall", 1e-3, spring(GAP, 0.4));
    scene.gravity = [0.0, 0.0, -G];
    let softness = Parameters::default().resolve(&scene).unwrap().softness;
    assert_eq!(softness.rest.unwrap().ratio, 0.0);
    let impact = softness.impact.unwrap().ratio;
    assert!(impact >= 0.0, "{impact}");
    let (mut close, _) = above("wall", 1e-3, spring(0.0, 0.4));
    close.gravity = scene.gravity;
    let softness = Parameters::default().resolve(&close).unwrap().softness;
    assert!((softness.rest.unwrap().ratio / (G / KAPPA / (0.5 * D)) - 1.0).abs() < 1e-12);
}

fn refused(change: impl Fn(&mut Scene), key: &str, words: &str) {
    let (mut scene, _) = above("wall", 1e-3, spring(GAP, 0.4));
    change(&mut scene);
    let problems = Parameters::default().resolve(&scene).expect_err(key);
    let found = problems.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert!(problems.len() == 1 && problems[0].key == key, "{key}: {found:?}");
    assert!(found[0].contains(words), "{found:?}");
}

#[test]
fn what_the_law_cannot_do_is_refused() {
    let law = |scene: &mut Scene, change: &dyn Fn(&mut ContactLaw)| {
        change(&mut scene.contacts[1].law);
    };
    let of = |name: &str| format!("scene.contacts[1].law.{name}");
    let rolls = of("rolling_friction");
    refused(|s| law(s, &|law| law.rolling_friction = 0.1), &rolls, "no form with rolling");
    let ratio = |damping| move |s: &mut Scene| s.contacts[1].law.damping = damping;
    refused(ratio(Damping::Restitution(0.5)), &of("damping"), "gives the restitution");
    refused(ratio(coefficients(1.0, 1.0)), &of("damping"), "by coefficients");
    refused(ratio(Damping::Ratio(-0.1)), &of("damping.ratio"), "0 or more");
    let numbers = |kappa: f64, gap: f64, psi: f64| {
        let tangential = Tangential::Spring;
        let spring = Spring::Chen { stiffness_per_mass: kappa, gap, psi, tangential };
        move |s: &mut Scene| s.contacts[1].law.spring = spring
    };
    refused(numbers(0.0, 0.0, 0.3), &of("stiffness_per_mass"), "positive");
    refused(numbers(KAPPA, -1e-4, 0.3), &of("gap"), "0 or more");
    refused(numbers(KAPPA, 0.0, -0.5), &of("psi"), "0 or more");
    let cube = |scene: &mut Scene| {
        scene.shapes = vec![shape("cube")];
        scene.bodies = vec![solids("cube", vec![solid([2e-3; 3], D, [0.0; 3])])];
        // One law that polyhedra cannot have, not two.
        scene.contacts[0].law = crate::common::law(1e3, 0.3, Damping::Restitution(0.5));
    };
    refused(cube, &of("spring"), "no form for polyhedra");
}
