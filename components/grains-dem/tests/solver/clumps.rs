//! Clumps: bodies that are joined rigidly.

use crate::common::{solids::*, *};
use tremie_grains_dem::{GrainsDem, GrainsError, Parameters};
use tremie_messages::{
    body::{BodyState, Load},
    scene::{BodySet, BodySizes, Damping, Motion, Outlet, Placement, Scene, Sphere},
};

const D: f64 = 2e-3;
const STIFF: f64 = 1e5;

fn joined(clump: &str, set: BodySet) -> BodySet {
    BodySet { name: format!("{} of {clump}", set.name), clump: Some(clump.into()), ..set }
}

fn spheres(list: Vec<Sphere>) -> BodySet {
    set(Motion::Free, list)
}

fn open_space(friction: f64, damping: Damping) -> Scene {
    scene([40e-3; 3], WALLS, law(STIFF, friction, damping))
}

/// Three spheres in a line, `2 arm` from end to end.
fn bar(middle: [f64; 3], arm: f64) -> BodySet {
    let at = |x: f64| sphere([middle[0] + x, middle[1], middle[2]], D, [0.0; 3]);
    joined("bar", spheres(vec![at(-arm), at(0.0), at(arm)]))
}

/// A ball strikes the end of a bar without friction: both go away as impact of rigid bodies has it,
/// `J = (1 + e) v/(1/m + 1/M + r^2/I)`.
#[test]
fn a_struck_clump_leaves_as_a_rigid_body_does() {
    let (arm, speed) = (5e-3, 0.5);
    for e in [1.0, 0.6] {
        let mut scene = open_space(0.0, Damping::Restitution(e));
        let ball = sphere([25e-3, 20e-3, 20e-3 - 1.2 * D], D, [0.0, 0.0, speed]);
        scene.bodies = vec![bar([20e-3; 3], arm), spheres(vec![ball])];
        let mut dem = make(&scene, 2.5e-7);
        dem.advance(4_800, &[]).unwrap();
        let (m, whole) = (mass(D), 3.0 * mass(D));
        let moment = 3.0 * inertia(D) + 2.0 * m * arm * arm;
        // A spring with a dashpot gives the restitution of the masses that it is made for: here the
        // turning bar is lighter.
        let after = state(&dem);
        let ends = |k: usize| after[k].velocity[2];
        let (v, spin) = (ends(1), after[1].angular_velocity[1]);
        let impulse = m * (speed - after[3].velocity[2]);
        assert!((impulse / (whole * v) - 1.0).abs() < 1e-9, "momentum");
        assert!(
            (impulse * arm / (moment * -spin) - 1.0).abs() < 1e-3,
            "{} {}",
            impulse * arm,
            moment * spin
        );
        assert!((ends(2) - v + spin * arm).abs() < 1e-3 * v, "rigid");
        let apart = (ends(2) - after[3].velocity[2]) / speed;
        let mobility = 1.0 / m + 1.0 / whole + arm * arm / moment;
        let expected = (1.0 + apart) * speed / mobility;
        assert!((impulse / expected - 1.0).abs() < 2e-3, "{impulse} {expected}");
        let bound = if e == 1.0 { 1e-3 } else { 0.1 };
        assert!((apart - e).abs() < bound, "restitution {apart} {e}");
    }
}

/// Head on the whole of a clump meets the ball: the restitution is that of its law.
#[test]
fn a_clump_that_is_struck_in_the_middle_gives_the_restitution_of_its_law() {
    let (speed, e) = (0.5, 0.6);
    let mut scene = open_space(0.5, Damping::Restitution(e));
    let ball = sphere([20e-3, 20e-3, 20e-3 - 1.2 * D], D, [0.0, 0.0, speed]);
    scene.bodies = vec![bar([20e-3; 3], 3e-3), spheres(vec![ball])];
    let mut dem = make(&scene, 2.5e-7);
    dem.advance(4_800, &[]).unwrap();
    let after = state(&dem);
    let apart = (after[1].velocity[2] - after[3].velocity[2]) / speed;
    // The contact ends at a whole step: of two spheres alike.
    assert!((apart - e).abs() < 5e-3, "{apart}");
    assert!(after[0].angular_velocity.iter().all(|w| w.abs() < 1e-9));
}

/// A brick at the first place, two cubes beside each other at the second, and a slab on a slab at
/// the third: 2 x 1 x 1 edges each, spinning at `w`.
fn boxes(edge: f64, w: [f64; 3], [whole, halves, layers]: [[f64; 3]; 3]) -> Scene {
    let spinning = |at: [f64; 3], diameter| {
        let mut body = solid(at, diameter, [0.1, 0.2, -0.1]);
        body.angular_velocity = w;
        body
    };
    let mut scene = open_space(0.5, Damping::Restitution(1.0));
    let corner = |k: usize, a: usize| f64::from(k as u32 >> a & 1) - 0.5;
    let block = |stretch: [f64; 3]| -> Vec<[f64; 3]> {
        (0..8).map(|k| std::array::from_fn(|a| stretch[a] * corner(k, a))).collect()
    };
    let shape_of =
        |name: &str, vertices| tremie_messages::scene::Shape { name: name.into(), vertices };
    scene.shapes = vec![
        shape("cube"),
        shape_of("brick", block([2.0, 1.0, 1.0])),
        shape_of("slab", block([2.0, 1.0, 0.5])),
    ];
    let with = |diameter: f64, factor: f64| diameter * factor.cbrt();
    let moved =
        |at: [f64; 3], by: [f64; 3]| -> [f64; 3] { std::array::from_fn(|a| at[a] + by[a] * edge) };
    let turning = |at: [f64; 3], by: [f64; 3], diameter| {
        // The velocity that the piece has as one of a rigid body.
        let mut body = spinning(moved(at, by), diameter);
        let more = cross(w, by.map(|x| x * edge));
        body.velocity = std::array::from_fn(|a| body.velocity[a] + more[a]);
        body
    };
    let size = of_cube(edge);
    scene.bodies = vec![
        solids("brick", vec![spinning(whole, with(size, 2.0))]),
        joined(
            "halves",
            solids(
                "cube",
                vec![
                    turning(halves, [-0.5, 0.0, 0.0], size),
                    turning(halves, [0.5, 0.0, 0.0], size),
                ],
            ),
        ),
        joined(
            "layers",
            solids(
                "slab",
                vec![
                    turning(layers, [0.0, 0.0, -0.25], size),
                    turning(layers, [0.0, 0.0, 0.25], size),
                ],
            ),
        ),
    ];
    scene
}

/// Two halves of a box turn as the box does.
#[test]
fn a_box_of_two_pieces_turns_as_one_of_one_piece() {
    let (edge, w) = (2e-3, [30.0, 400.0, -20.0]);
    let [whole, halves, layers] = [[10e-3; 3], [10e-3, 20e-3, 20e-3], [20e-3, 20e-3, 10e-3]];
    let scene = boxes(edge, w, [whole, halves, layers]);
    let mut dem = make(&scene, 1e-6);
    let before = whole_energy(&mut dem);
    dem.advance(20_000, &[]).unwrap();
    let after = state(&dem);
    let alike = |a: [f64; 4], b: [f64; 4]| (0..4).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    for piece in &after[1..] {
        let error = alike(after[0].orientation, piece.orientation);
        assert!(error < 1e-9, "{error}");
        assert!(norm(minus(after[0].angular_velocity, piece.angular_velocity)) < 1e-6);
    }
    let middle: [f64; 3] =
        std::array::from_fn(|a| 0.5 * (after[1].position[a] + after[2].position[a]));
    let way = minus(middle, minus(halves, whole));
    assert!(norm(minus(way, after[0].position)) < 1e-13);
    assert!(alike(after[0].orientation, [0.0, 0.0, 0.0, 1.0]) > 0.3, "it turned");
    assert!((whole_energy(&mut dem) / before - 1.0).abs() < 1e-6);
}

/// A tangle of clumps of spheres and polyhedra among loose ones.
fn crowd(stiffness: f64, friction: f64, damping: Damping) -> Scene {
    let mut scene = scene([16e-3; 3], FLOOR, law(stiffness, friction, damping));
    scene.shapes = vec![shape("cube"), shape("tetrahedron")];
    let hash = |k: u64| (k.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64 / (1u64 << 24) as f64;
    let (mut k, mut loose) = (0, Vec::new());
    for place in 0..64 {
        let at: [f64; 3] = std::array::from_fn(|a| 2e-3 + 4e-3 * f64::from(place >> (2 * a) & 3));
        let mut next = || {
            k += 1;
            2.0 * hash(k) - 1.0
        };
        let v: [f64; 3] = std::array::from_fn(|_| next());
        let other = [at[0] + 0.9e-3, at[1] + 0.3e-3, at[2]];
        match place % 4 {
            0 => {
                let pair = vec![sphere(at, 1.4e-3, v), sphere(other, 1e-3, v)];
                scene.bodies.push(joined(&format!("pair {place}"), spheres(pair)));
            }
            1 => {
                let name = format!("block {place}");
                let cube = solids("cube", vec![solid(at, 1.2e-3, v)]);
                scene.bodies.push(joined(&name, cube));
                let mut tip = solid(other, 1e-3, v);
                tip.orientation = turned([1.0, 2.0, 0.5], 0.7);
                scene.bodies.push(joined(&name, solids("tetrahedron", vec![tip])));
            }
            _ => loose.push(sphere(at, 1.3e-3, v)),
        }
    }
    scene.bodies.push(BodySet { name: "loose".into(), ..spheres(loose) });
    scene
}

/// Without friction and dashpots nothing is lost, and nothing made.
#[test]
fn clumps_keep_energy_and_momentum() {
    let mut scene = crowd(1e4, 0.0, Damping::Restitution(1.0));
    scene.domain.faces = PERIODIC;
    let mut dem = make(&scene, 1e-6);
    let (energy, momentum) = (whole_energy(&mut dem), dem.diagnostics().momentum);
    let mut touched = 0;
    for _ in 0..200 {
        dem.advance(100, &[]).unwrap();
        touched += dem.diagnostics().contacts;
        let error = (whole_energy(&mut dem) / energy - 1.0).abs();
        assert!(error < 3e-3, "{error}");
    }
    assert!(touched > 20, "{touched}");
    let scale = 64.0 * mass(1.3e-3);
    assert!(norm(minus(dem.diagnostics().momentum, momentum)) < 1e-9 * scale);
}

fn fallen(threads: usize, windows: u32, substeps: u32, skin: f64) -> (Scene, Vec<BodyState>) {
    let mut scene = crowd(3e3, 0.5, Damping::Restitution(0.4));
    scene.gravity = [0.5, 0.0, -200.0];
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(&scene, &parameters, 4e-7, threads).unwrap();
    for _ in 0..windows {
        dem.advance(substeps, &[]).unwrap();
    }
    let after = state(&dem);
    (scene, after)
}

/// Bodies of a clump keep their places to each other, also across periodic faces; nothing depends
/// on threads, windows or lists.
#[test]
fn clumps_fall_and_stay_whole_with_equal_bits() {
    let (scene, after) = fallen(1, 1, 60_000, 0.1);
    for (threads, windows, substeps, skin) in
        [(2, 1, 60_000, 0.1), (1, 20_000, 3, 0.1), (3, 20, 3_000, 0.02)]
    {
        assert_eq!(after, fallen(threads, windows, substeps, skin).1);
    }
    let mut id = 0;
    let mut places = Vec::new();
    for set in &scene.bodies {
        let listed: Vec<[f64; 3]> = match &set.placement {
            Placement::Listed(list) => list.iter().map(|body| body.position).collect(),
            Placement::Polyhedra(own) => match &own.placement {
                tremie_messages::scene::PolyhedronPlacement::Listed(list) => {
                    list.iter().map(|body| body.position).collect()
                }
                _ => unreachable!(),
            },
            Placement::Packed(_) => unreachable!(),
        };
        for at in listed {
            places.push((set.clump.clone(), at, after[id].position));
            id += 1;
        }
    }
    let mut checked = 0;
    for pair in places.windows(2).filter(|pair| pair[0].0.is_some() && pair[0].0 == pair[1].0) {
        let first = norm(minus(pair[0].1, pair[1].1));
        let mut way = minus(pair[0].2, pair[1].2);
        for a in 0..2 {
            way[a] -= 16e-3 * (way[a] / 16e-3).round();
        }
        assert!((norm(way) - first).abs() < 1e-12, "{} {first}", norm(way));
        checked += 1;
    }
    assert_eq!(checked, 32);
    let lowest = after.iter().map(|body| body.position[2]).fold(1.0, f64::min);
    assert!(lowest < 1.5e-3, "some lie on the floor");
}

/// Loads of a fluid act where they are given: a couple turns a clump, and a force at its end moves
/// it too.
#[test]
fn loads_on_the_bodies_of_a_clump_move_it() {
    let (arm, force) = (5e-3, 1e-4);
    let mut scene = open_space(0.0, Damping::Restitution(1.0));
    scene.bodies = vec![bar([20e-3; 3], arm)];
    let mut dem = make(&scene, 1e-6);
    let load = |id, f: f64| Load { id, force: [0.0, 0.0, f], torque: [0.0; 3] };
    let loads = [load(0, -force), load(1, 0.0), load(2, 2.0 * force)];
    let steps = 100;
    dem.advance(steps, &loads).unwrap();
    let (time, after) = (f64::from(steps) * 1e-6, state(&dem));
    let moment = 3.0 * inertia(D) + 2.0 * mass(D) * arm * arm;
    let (v, w) = (force * time / (3.0 * mass(D)), -3.0 * force * arm * time / moment);
    assert!((after[1].velocity[2] / v - 1.0).abs() < 1e-6, "{} {v}", after[1].velocity[2]);
    assert!((after[1].angular_velocity[1] / w - 1.0).abs() < 1e-6);
    assert_eq!(dem.diagnostics().fluid_impulse, [0.0, 0.0, force * time]);
}

#[test]
fn what_makes_no_clump_is_named() {
    let good = || {
        let mut scene = open_space(0.0, Damping::Restitution(1.0));
        scene.bodies = vec![bar([20e-3; 3], 3e-3)];
        scene
    };
    let found = |change: &dyn Fn(&mut Scene)| {
        let mut scene = good();
        change(&mut scene);
        let problems = Parameters::default().resolve(&scene).expect_err("a problem");
        (problems[0].key.clone(), problems[0].to_string())
    };
    let of_set = "scene.bodies[0].clump";
    let (key, text) = found(&|s| s.bodies[0].clump = Some(String::new()));
    assert!(key == of_set && text.contains("empty"), "{text}");
    let (key, text) = found(&|s| s.bodies[0].motion = Motion::Fixed);
    assert!(key == of_set && text.contains("not free"), "{text}");
    let (key, text) = found(&|s| {
        s.bodies[0].placement = packed([5e-3; 3], [30e-3; 3], 0.1, (D, D), 1).placement;
    });
    assert!(key == of_set && text.contains("packed"), "{text}");
    let (key, text) = found(&|s| {
        s.outlets = vec![Outlet { name: "drain".into(), axis: 2, at: 2e-3, side: 0 }];
    });
    assert!(key == "scene.outlets[0].name" && text.contains("come and go"), "{text}");
    let (key, text) = found(&|s| match &mut s.bodies[0].placement {
        Placement::Listed(list) => list[2].angular_velocity = [0.0, 5.0, 0.0],
        _ => unreachable!(),
    });
    assert!(key == of_set && text.contains("rigid motion"), "{text}");
    let (key, text) = found(&|s| {
        s.domain.faces = PERIODIC;
        s.bodies = vec![bar([20e-3; 3], 15e-3)];
    });
    assert!(key == of_set && text.contains("wraps around"), "{text}");
    let mut dem = make(&good(), 1e-6);
    let error = dem.exchange(&[0], &[]).unwrap_err();
    assert!(matches!(error, GrainsError::NotRemovable { id: 0, .. }), "{error}");
}

/// A clump of one sphere is that sphere, to the last bit where it does not turn.
#[test]
fn a_clump_of_one_sphere_moves_as_the_sphere_does() {
    let velocities = |clump: bool| {
        let mut scene = open_space(0.5, Damping::Restitution(0.6));
        let ball = sphere([20e-3, 20e-3, 20e-3 - 1.2 * D], D, [0.0, 0.0, 0.5]);
        let struck = spheres(vec![sphere([20e-3; 3], D, [0.0; 3])]);
        let struck = if clump { joined("one", struck) } else { struck };
        scene.bodies = vec![struck, BodySet { name: "ball".into(), ..spheres(vec![ball]) }];
        let mut dem = make(&scene, 1e-6);
        dem.advance(1_200, &[]).unwrap();
        state(&dem).iter().map(|body| body.velocity).collect::<Vec<_>>()
    };
    assert_eq!(velocities(true), velocities(false));
}

/// A raft of many spheres that all touch at once, and a ball with a light handle that is struck at
/// its tip: the default time step follows both.
#[test]
fn the_time_step_follows_rafts_and_long_handles() {
    let mut scene = open_space(0.3, Damping::Restitution(0.5));
    let raft = (0..100).map(|k| {
        let at = [5e-3 + D * f64::from(k % 10), 5e-3 + D * f64::from(k / 10), 0.6 * D];
        sphere(at, D, [0.0, 0.0, -0.3])
    });
    scene.bodies = vec![joined("raft", spheres(raft.collect()))];
    let parameters = Parameters::default();
    let step = parameters.resolve(&scene).unwrap().time_step.unwrap();
    let mut dem = GrainsDem::new(&scene, &parameters, step, 1).unwrap();
    let mut fastest = 0.0f64;
    for _ in 0..200 {
        dem.advance(((4e-3 / step) / 200.0) as u32 + 1, &[]).unwrap();
        fastest = fastest.max(state(&dem)[0].velocity[2]);
    }
    assert!(fastest > 1e-3 && fastest < 0.3 * 0.5, "{fastest}");

    let mut scene = open_space(0.0, Damping::Restitution(1.0));
    let middle = [20e-3; 3];
    let head = joined("mallet", spheres(vec![sphere(middle, 10e-3, [0.0; 3])]));
    let beads = (0..5).map(|k| sphere([27e-3 + 2e-3 * f64::from(k), 20e-3, 20e-3], D, [0.0; 3]));
    let handle = joined("mallet", spheres(beads.collect()));
    let ball = sphere([35e-3, 20e-3, 20e-3 - 1.2 * D], D, [0.0, 0.0, 0.5]);
    scene.bodies = vec![
        head,
        BodySet { name: "handle".into(), ..handle },
        BodySet { name: "ball".into(), ..spheres(vec![ball]) },
    ];
    let step = parameters.resolve(&scene).unwrap().time_step.unwrap();
    let mut dem = GrainsDem::new(&scene, &parameters, step, 1).unwrap();
    let before = whole_energy(&mut dem);
    dem.advance((2e-3 / step) as u32, &[]).unwrap();
    assert!(dem.diagnostics().max_overlap_ratio > 0.0, "they met");
    let after = whole_energy(&mut dem);
    assert!((after / before - 1.0).abs() < 0.02, "{after} {before}");
}

/// A clump by itself needs no law for bodies with each other, for they never touch.
#[test]
fn a_clump_does_not_meet_itself() {
    let mut scene = open_space(0.0, Damping::Restitution(1.0));
    scene.bodies = vec![bar([20e-3; 3], 3e-3)];
    scene.contacts.retain(|pair| pair.between.contains(&"wall".to_string()));
    assert!(Parameters::default().resolve(&scene).is_ok());
    scene.bodies.push(BodySet { name: "other".into(), ..bar([20e-3, 20e-3, 30e-3], 3e-3) });
    scene.bodies[1].clump = Some("other".into());
    let problems = Parameters::default().resolve(&scene).expect_err("no law");
    assert!(problems[0].to_string().contains("no law"), "{}", problems[0]);
}

/// A clump whose mass is that of the union of its bodies.
fn united(bodies: Vec<BodySet>, size: f64) -> Scene {
    let mut scene = scene([size; 3], PERIODIC, law(1e4, 0.0, Damping::Restitution(1.0)));
    scene.shapes = vec![shape("cube")];
    scene.bodies = bodies;
    scene.unions = vec!["bar".into()];
    scene
}

/// Volume of the lens of two spheres of radii `r` and `s`, `d` apart.
fn lens(r: f64, s: f64, d: f64) -> f64 {
    let sum = r + s - d;
    let rest = d * d + 2.0 * d * (r + s) - 3.0 * (r - s) * (r - s);
    std::f64::consts::PI / (12.0 * d) * sum * sum * rest
}

/// Weight and momentum of a dumbbell are those of its lens formula, its spin under a couple that of
/// its inertia: two equal spheres in a thousand slices.
#[test]
fn a_union_is_as_heavy_as_its_lens_says() {
    let (r, d) = (0.5 * D, 0.6 * D);
    let at = |x: f64| sphere([10e-3 + x, 10e-3, 10e-3], D, [0.3, 0.0, 0.0]);
    let mut scene = united(vec![joined("bar", spheres(vec![at(-0.5 * d), at(0.5 * d)]))], 20e-3);
    let mut dem = make(&scene, 1e-6);
    let volume = 2.0 * mass(D) / DENSITY - lens(r, r, d);
    let momentum = dem.diagnostics().momentum;
    assert!((momentum[0] / (0.3 * DENSITY * volume) - 1.0).abs() < 1e-12, "{momentum:?}");
    let (n, end) = (200_000, 0.5 * d + r);
    let across: f64 = (0..n)
        .map(|k| {
            let x = end * (f64::from(k) + 0.5) / f64::from(n);
            let square = r * r - (x - 0.5 * d) * (x - 0.5 * d);
            2.0 * DENSITY * std::f64::consts::PI * square * (0.25 * square + x * x) * end
                / f64::from(n)
        })
        .sum();
    let load = |id, f: f64| Load { id, force: [0.0, 0.0, f], torque: [0.0; 3] };
    let (force, steps) = (1e-5, 100);
    dem.advance(steps, &[load(0, force), load(1, -force)]).unwrap();
    let spin = state(&dem)[0].angular_velocity[1];
    assert!((spin / (force * d * f64::from(steps) * 1e-6 / across) - 1.0).abs() < 1e-6, "{spin}");
    // Without the word it is as heavy as both.
    scene.unions.clear();
    let twice = make(&scene, 1e-6).diagnostics().momentum[0];
    assert!((twice / (0.3 * 2.0 * mass(D)) - 1.0).abs() < 1e-12, "{twice}");
}

/// Number of bodies that a set lists.
fn pieces_of(set: &BodySet) -> usize {
    match set.placement.sizes() {
        BodySizes::Listed(list) => list.len(),
        BodySizes::Packed(_) => 0,
    }
}

/// A ball strikes unions of all kinds, from every side: what moves keeps energy, momentum and
/// angular momentum, and a struck union turns about its own centroid.
#[test]
fn unions_keep_energy_and_momenta() {
    let v = [0.0; 3];
    let three = || {
        let at = |x: f64, y: f64, d: f64| sphere([20e-3 + x, 20e-3 + y, 20e-3], d, v);
        vec![at(0.0, 0.0, D), at(0.9e-3, 0.2e-3, 1.4e-3), at(0.3e-3, 0.8e-3, 1.6e-3)]
    };
    let cube = || joined("bar", solids("cube", vec![solid([20e-3; 3], D, v)]));
    let ball =
        |x: f64, d: f64| joined("bar", spheres(vec![sphere([20e-3 + x, 20e-3, 20e-3], d, v)]));
    let all: [Vec<BodySet>; 4] = [
        vec![joined("bar", spheres(three()))],
        vec![cube(), ball(0.8e-3, 1.5e-3)],
        vec![ball(0.0, D), ball(0.2e-3, 1e-3)],
        vec![cube(), joined("bar", solids("cube", vec![solid([20.7e-3, 20.3e-3, 20e-3], D, v)]))],
    ];
    for (k, bodies) in all.into_iter().enumerate() {
        let pieces: usize = bodies.iter().map(pieces_of).sum();
        for way in [[0.0, 0.0, 1.0], [0.2, -1.0, 0.1], [0.9, 0.3, 0.2]] {
            let from: [f64; 3] = std::array::from_fn(|a| 20.1e-3 - 2.8e-3 * way[a]);
            let speed = way.map(|w| 0.4 * w);
            let mut scene = united(bodies.clone(), 40e-3);
            let shot = spheres(vec![sphere(from, D, speed)]);
            scene.bodies.push(BodySet { name: "shot".into(), ..shot });
            let mut dem = make(&scene, 5e-7);
            let (energy, momentum) = (whole_energy(&mut dem), dem.diagnostics().momentum);
            dem.advance(24_000, &[]).unwrap();
            assert_eq!(dem.diagnostics().contacts, 0, "{k}: they are apart again");
            let after = state(&dem);
            assert!(norm(minus(after[pieces].velocity, speed)) > 0.05, "{k}: they met");
            let error = (whole_energy(&mut dem) / energy - 1.0).abs();
            assert!(error < 3e-3, "{k}: {error}");
            let lost = norm(minus(dem.diagnostics().momentum, momentum));
            assert!(lost < 1e-9 * norm(momentum), "{k}: {lost}");
        }
    }
}

/// Overlaps are told, with how much they count twice; a union is not doubted, and names what is in
/// no clump.
#[test]
fn overlaps_in_clumps_are_told() {
    let at = |x: f64, d: f64| sphere([10e-3 + x, 10e-3, 10e-3], d, [0.0; 3]);
    let with = |list: Vec<Sphere>, unions: &[&str]| {
        let mut scene = united(vec![joined("bar", spheres(list))], 20e-3);
        scene.unions = unions.iter().map(|name| name.to_string()).collect();
        scene
    };
    let told = |scene: &Scene| {
        let parameters = Parameters::default();
        let resolution = parameters.resolve(scene).unwrap();
        let found = tremie_grains_dem::findings(scene, &parameters, &resolution);
        found.into_iter().find(|finding| finding.quantity.contains("overlaps in a clump"))
    };
    let pair = || vec![at(0.0, D), at(0.5 * D, D)];
    let excess = lens(0.5 * D, 0.5 * D, 0.5 * D) * DENSITY / mass(D);
    let excess = excess / (2.0 - excess);
    let doubted = told(&with(pair(), &[])).unwrap();
    assert_eq!(doubted.verdict, tremie_messages::Verdict::Doubtful);
    assert!((doubted.value - excess).abs() < 1e-9, "{}", doubted.value);
    assert!(doubted.why.contains("18.5 %") && doubted.remedy.contains("union"), "{doubted:?}");
    let right = told(&with(pair(), &["bar"])).unwrap();
    assert_eq!((right.verdict, right.value), (tremie_messages::Verdict::Ok, doubted.value));
    assert_eq!(told(&with(vec![at(0.0, D), at(1.001 * D, D)], &[])), None);
    let problems = Parameters::default().resolve(&with(pair(), &["rod"])).unwrap_err();
    assert!(problems[0].to_string().contains("\"rod\""), "{problems:?}");
}

/// A region's solid fraction of a union is that of its volume.
#[test]
fn a_region_holds_a_union_once() {
    let at = |x: f64| sphere([10e-3 + x, 10e-3, 10e-3], D, [0.0; 3]);
    let mut scene = united(vec![joined("bar", spheres(vec![at(0.0), at(0.5 * D)]))], 20e-3);
    let shape = tremie_messages::scene::ProbeShape::Region { min: [0.0; 3], max: [20e-3; 3] };
    scene.probes = vec![tremie_messages::scene::Probe { name: "all".into(), shape }];
    let mut values = Vec::new();
    make(&scene, 1e-6).read_probes(&mut values);
    let volume = 2.0 * mass(D) / DENSITY - lens(0.5 * D, 0.5 * D, 0.5 * D);
    assert!((values[0] * 20e-3f64.powi(3) / volume - 1.0).abs() < 1e-9, "{values:?}");
}
