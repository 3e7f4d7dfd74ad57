//! Tests of whole steps.

use super::*;
use crate::particles::particle_arrays::Transfer;
use crate::particles::seeding::seed;
use std::f64::consts::PI;

/// A box of `cells` of one edge [m], full of fluid where `is_wet`.
fn full<const D: usize>(
    cells: [usize; D],
    edge: f64,
    settings: PicSettings<D>,
    threads: usize,
    is_wet: impl Fn([f64; D]) -> bool,
) -> PicSolver<D> {
    boxed(StaggeredGrid::new(cells, edge, [0.0; D], [false; D]), settings, threads, is_wet)
}

/// A grid full of fluid where `is_wet`.
fn boxed<const D: usize>(
    grid: StaggeredGrid<D>,
    settings: PicSettings<D>,
    threads: usize,
    is_wet: impl Fn([f64; D]) -> bool,
) -> PicSolver<D> {
    let mut solver = PicSolver::new(grid, settings, threads, Vec::new(), Vec::new()).unwrap();
    seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |_| [0.0; D]);
    solver
}

/// Water at rest stays at rest under its own weight, whatever the level, and its pressure is that
/// of its depth.
#[test]
fn a_tank_at_rest_stays_at_rest() {
    for level in [0.5, 0.55] {
        let mut solver =
            full([20, 30], 0.05, PicSettings::water([0.0, -9.81]), 1, |x: [f64; 2]| x[1] < level);
        let mut forces = Vec::new();
        for _ in 0..50 {
            assert!(solver.step(2e-3, &[], &mut forces).converged);
        }
        assert!(solver.max_speed() < 1e-8, "{}", solver.max_speed());
        let bottom = solver.pressure([7, 0], 2e-3);
        assert!((bottom / (1000.0 * 9.81 * (level - 0.025)) - 1.0).abs() < 1e-6, "{bottom}");
    }
}

/// A disc that is let go in a box moves by its weight, its buoyancy and the fluid that it moves
/// along, however light it is. Exact is the disc in a round tank: added mass (b^2 + 1) / (b^2 - 1)
/// of the displaced one, b = 10 (the box holds that tank).
#[test]
fn a_released_disc_moves_with_its_added_mass() {
    let (radius, centre) = (0.05, [0.503, 0.502]);
    let displaced = 1000.0 * PI * radius * radius;
    for ratio in [2.0, 0.5, 0.1, 0.01, 0.001] {
        let is_wet = |x: [f64; 2]| (x[0] - centre[0]).hypot(x[1] - centre[1]) > radius;
        let mut solver = full([200, 200], 0.005, PicSettings::water([0.0, -9.81]), 1, is_wet);
        let mass = ratio * displaced;
        let body = RigidBody::ball(centre, radius).with_mass(mass);
        let mut forces = Vec::new();
        assert!(solver.step(1e-4, &[body], &mut forces).converged);
        let acceleration = forces[0][1] / mass - 9.81;
        let exact = -9.81 * (ratio - 1.0) / (ratio + 1.02);
        assert!((acceleration / exact - 1.0).abs() < 0.02, "{ratio}: {acceleration} {exact}");
        assert!(forces[0][0].abs() < 0.01 * forces[0][1].abs());
    }
}

/// The same of a sphere: half of the displaced mass moves along.
#[test]
fn a_released_sphere_moves_with_half_of_its_displaced_fluid() {
    let (radius, centre) = (0.1, [0.501, 0.503, 0.498]);
    let displaced = 1000.0 * 4.0 / 3.0 * PI * radius * radius * radius;
    for ratio in [2.0, 0.1] {
        let is_wet =
            |x: [f64; 3]| (0..3).map(|a| (x[a] - centre[a]).powi(2)).sum::<f64>() > radius * radius;
        let mut solver =
            full([64; 3], 1.0 / 64.0, PicSettings::water([0.0, 0.0, -9.81]), 2, is_wet);
        let mass = ratio * displaced;
        let body = RigidBody::ball(centre, radius).with_mass(mass);
        let mut forces = Vec::new();
        assert!(solver.step(1e-4, &[body], &mut forces).converged);
        let acceleration = forces[0][2] / mass - 9.81;
        // In a round tank of five radii: (b^3 + 2) / (b^3 - 1) / 2.
        let exact = -9.81 * (ratio - 1.0) / (ratio + 0.512);
        assert!((acceleration / exact - 1.0).abs() < 0.03, "{ratio}: {acceleration} {exact}");
    }
}

/// A body that is as heavy as the fluid that it displaces stays where it is.
#[test]
fn a_neutrally_buoyant_disc_stays() {
    let (radius, centre) = (0.1, [0.5, 0.4]);
    let is_wet = |x: [f64; 2]| x[1] < 0.8 && (x[0] - centre[0]).hypot(x[1] - centre[1]) > radius;
    let mut solver = full([50, 50], 0.02, PicSettings::water([0.0, -9.81]), 1, is_wet);
    let mass = 1000.0 * PI * radius * radius;
    let body = RigidBody::ball(centre, radius).with_mass(mass);
    let mut forces = Vec::new();
    solver.step(1e-3, &[body], &mut forces);
    assert!((forces[0][1] / (9.81 * mass) - 1.0).abs() < 2e-3, "{forces:?}");
}

/// A column that collapses stays ahead of the experiment of Martin & Moyce (1952), whose gate
/// delays it, and then keeps its pace; and no fluid is lost.
#[test]
fn a_column_collapses_at_the_pace_of_the_experiment() {
    let (a, n) = (0.05715, 20);
    let mut solver = full(
        [10 * n, 2 * n + 10],
        a / n as f64,
        PicSettings::water([0.0, -9.81]),
        1,
        |x: [f64; 2]| x[0] < a && x[1] < 2.0 * a,
    );
    let particles = solver.particles.len();
    let scale = (2.0 * 9.81 / a).sqrt();
    let (mut time, mut passed) = (0.0, Vec::new());
    let mut forces = Vec::new();
    while passed.len() < 2 {
        let dt = 0.5 * solver.grid.spacing / solver.max_speed().max(0.2);
        assert!(solver.step(dt, &[], &mut forces).converged);
        time += dt * scale;
        let front = solver.particles.position[0].iter().copied().fold(0.0, f64::max) / a;
        if front >= [4.134, 7.945][passed.len()] {
            passed.push(time);
        }
    }
    // The front passed there at 3.345 and 5.685.
    assert!(passed[0] < 3.345 && passed[0] > 2.7, "{passed:?}");
    let pace = (passed[1] - passed[0]) / (5.685 - 3.345);
    assert!((pace - 1.0).abs() < 0.1, "{passed:?}");
    assert_eq!(solver.particles.len(), particles);
}

#[test]
fn threads_change_no_bit() {
    let collapsed = |threads| {
        let is_wet = |x: [f64; 3]| x[0] < 0.3 && x[2] < 0.5;
        let mut solver =
            full([20, 6, 14], 0.05, PicSettings::water([0.0, 0.0, -9.81]), threads, is_wet);
        let body = RigidBody::ball([0.5, 0.15, 0.1], 0.1).with_mass(2.0);
        let mut forces = Vec::new();
        for _ in 0..20 {
            solver.step(5e-3, std::slice::from_ref(&body), &mut forces);
        }
        (solver.particles.position, forces)
    };
    assert!(collapsed(1) == collapsed(3));
}

/// Water under a lid is not held there by suction once air is beneath: it falls.
#[test]
fn water_lets_go_of_a_lid() {
    let mut solver =
        full([20, 40], 0.05, PicSettings::water([0.0, -9.81]), 1, |x: [f64; 2]| x[1] > 1.5);
    let mut forces = Vec::new();
    for _ in 0..10 {
        assert!(solver.step(5e-3, &[], &mut forces).converged);
    }
    let mass = solver.particles.mass * solver.particles.len() as f64;
    let fall = solver.particles.momentum()[1] / mass;
    assert!((fall / (-9.81 * 0.05) - 1.0).abs() < 0.05, "{fall} m/s");
}

/// Positions keep the volume in a splash that would lose a tenth of it.
#[test]
fn a_splash_keeps_its_volume() {
    let change = |relaxation: f64| {
        let settings = PicSettings { relaxation, ..PicSettings::water([0.0, -9.81]) };
        let mut solver = full([60, 40], 0.02, settings, 1, |x: [f64; 2]| x[0] < 0.4 && x[1] < 0.6);
        let mut forces = Vec::new();
        solver.step(1e-6, &[], &mut forces);
        let first = solver.sums().volume;
        for _ in 0..600 {
            let dt = 0.5 * solver.grid.spacing / solver.max_speed().max(2.0);
            assert!(solver.step(dt, &[], &mut forces).converged);
        }
        (solver.sums().volume / first - 1.0).abs()
    };
    let (with, without) = (change(0.1), change(0.0));
    assert!(with < 0.02 && without > 2.0 * with, "{with} {without}");
}

/// Where an axis wraps around, nothing tells its ends from other places: a column with a disc in it
/// collapses there as it does in the middle, with even and odd numbers of cells.
#[test]
fn the_ends_of_a_periodic_axis_are_no_places_of_their_own() {
    for cells in [48, 51, 49] {
        let edge = 1.0 / 48.0;
        let length = f64::from(cells) * edge;
        let collapsed = |shift: f64| {
            let middle = 24.0 * edge + shift;
            let off = |x: f64| {
                let off = x - middle;
                off - length * (off / length).round()
            };
            let disc = [middle + 2.3 * edge, 0.21];
            let is_wet = |x: [f64; 2]| {
                off(x[0]).abs() < 0.2
                    && x[1] < 0.5
                    && (off(x[0]) - 2.3 * edge).hypot(x[1] - disc[1]) > 0.1
            };
            let grid = StaggeredGrid::new([cells as usize, 40], edge, [0.0; 2], [true, false]);
            let settings = PicSettings {
                viscosity: 1e-3,
                bodies_stick: true,
                relaxation: 0.1,
                ..PicSettings::water([0.3, -9.81])
            };
            let mut solver = boxed(grid, settings, 2, is_wet);
            let disc = RigidBody::ball(disc, 0.1).with_mass(5.0);
            let mut loads = Vec::new();
            for _ in 0..30 {
                let outcome = solver.step(4e-3, std::slice::from_ref(&disc), &mut loads);
                assert!(outcome.converged && outcome.iterations < 20, "{cells}: {outcome:?}");
            }
            let sums = solver.sums();
            (sums.kinetic, sums.momentum, sums.volume, loads[0])
        };
        let middle = collapsed(0.0);
        for shift in [-24.0 * edge, 11.0 * edge, f64::from(cells / 2) * edge] {
            let shifted = collapsed(shift);
            assert!((shifted.0 / middle.0 - 1.0).abs() < 1e-4, "{cells}: {middle:?} {shifted:?}");
            assert!((shifted.2 / middle.2 - 1.0).abs() < 1e-5, "{cells}: {middle:?} {shifted:?}");
            for k in 0..2 {
                assert!((shifted.1[k] - middle.1[k]).abs() < 0.02, "{middle:?} {shifted:?}");
                assert!((shifted.3[k] - middle.3[k]).abs() < 0.1, "{middle:?} {shifted:?}");
            }
        }
    }
}

/// A disc that is as heavy as the fluid turns with half of the shear around it, in steps much longer
/// than it needs to follow the fluid; it stays at rest in the middle, and the walls feel opposite
/// forces.
#[test]
fn a_disc_in_a_shear_flow_turns_with_half_of_the_shear() {
    let edge = 1.0 / 40.0;
    let grid = StaggeredGrid::new([80, 40], edge, [0.0; 2], [true, false]);
    let stick = |speed: f64| BoxWall::Stick([speed, 0.0]);
    let settings = PicSettings {
        density: 1.0,
        viscosity: 1.0,
        walls: [[BoxWall::Slip; 2], [stick(-0.5), stick(0.5)]],
        bodies_stick: true,
        fills_all: true,
        transfer: Transfer::Affine,
        ..PicSettings::water([0.0; 2])
    };
    let radius = 0.1;
    let mut disc = RigidBody::ball([1.0, 0.5], radius).with_mass(PI * radius * radius);
    let mut solver = PicSolver::new(grid, settings, 1, Vec::new(), Vec::new()).unwrap();
    let is_wet = |x: [f64; 2]| (x[0] - 1.0).hypot(x[1] - 0.5) > radius;
    seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |x| [x[1] - 0.5, 0.0]);
    let mut loads = Vec::new();
    // dt nu / h^2 = 16.
    let dt = 1e-2;
    let mass = PI * radius * radius;
    for _ in 0..100 {
        let outcome = solver.step(dt, std::slice::from_ref(&disc), &mut loads);
        assert!(outcome.converged, "{outcome:?}");
        for a in 0..2 {
            disc.velocity[a] += dt * loads[0][a] / mass;
        }
        disc.spin[2] += dt * loads[0][5] / (0.5 * mass * radius * radius);
    }
    assert!((disc.spin[2] / -0.5 - 1.0).abs() < 0.05, "{:?}", disc.spin);
    assert!(disc.velocity.iter().all(|u| u.abs() < 1e-3), "{:?}", disc.velocity);
    let [lower, upper] = solver.wall_forces(dt)[1].map(|force| force[0]);
    assert!((lower / upper + 1.0).abs() < 1e-3 && upper < 0.0, "{lower} {upper}");
}

/// Without viscosity the flux out of every cell is found to the solution's tolerance, bodies
/// included: at 1e-12 the largest divergence over the edge is below 1e-10.
#[test]
fn nothing_is_made_in_a_cell() {
    let mut settings = PicSettings::water([0.0, -9.81]);
    settings.tolerance = crate::pressure::conjugate_gradients::Tolerance {
        relative: 1e-14,
        absolute: 1e-13,
        iterations: 100,
    };
    let disc = RigidBody::ball([0.4, 0.3], 0.12).with_mass(20.0);
    let is_wet = |x: [f64; 2]| x[0] < 0.7 && x[1] < 0.6 && !disc.holds(x);
    let mut solver = full([40, 40], 0.025, settings, 1, is_wet);
    let mut loads = Vec::new();
    for _ in 0..10 {
        assert!(solver.step(4e-3, std::slice::from_ref(&disc), &mut loads).converged);
        assert!(solver.divergence() < 1e-10, "{}", solver.divergence());
    }
}

/// Momentum is accounted for by name, step by step: what particles gain is gravity, less what walls
/// and bodies get.
#[test]
fn momentum_changes_by_weight_walls_and_bodies() {
    let settings = PicSettings::water([0.0, -9.81]);
    let disc = RigidBody::ball([0.75, 0.25], 0.11).with_mass(25.0);
    let is_wet = |x: [f64; 2]| x[1] < 0.5 && !disc.holds(x);
    let mut solver = full([60, 40], 0.025, settings, 1, is_wet);
    let mut loads = Vec::new();
    let dt = 2e-3;
    for step in 0..40 {
        solver.find_loads(dt, std::slice::from_ref(&disc), &mut loads);
        let before = solver.particles.momentum();
        solver.move_particles(dt, std::slice::from_ref(&disc));
        let mass = solver.particles.mass * solver.particles.len() as f64;
        let walls = solver.wall_forces(dt);
        for a in 0..2 {
            let gained = (solver.particles.momentum()[a] - before[a]) / dt;
            let weight = mass * [0.0, -9.81][a];
            let of_walls: f64 = walls.iter().flatten().map(|force| force[a]).sum();
            let left = gained - weight + of_walls + loads[0][a];
            // Beside surfaces particles fill cells by parts: the weight is that of what they fill.
            assert!(left.abs() < 0.003 * mass * 9.81, "step {step}, axis {a}: {left} N");
        }
    }
}

/// A scene that is its own mirror image stays so: a column in the middle of a box, with a disc on
/// the axis.
#[test]
fn a_symmetric_scene_stays_symmetric() {
    let disc = RigidBody::ball([0.5, 0.15], 0.08).with_mass(15.0);
    let is_wet = |x: [f64; 2]| (x[0] - 0.5).abs() < 0.2 && x[1] < 0.5 && !disc.holds(x);
    let settings = PicSettings { relaxation: 0.1, ..PicSettings::water([0.0, -9.81]) };
    let mut solver = full([40, 30], 0.025, settings, 1, is_wet);
    let mut loads = Vec::new();
    for _ in 0..60 {
        solver.step(3e-3, std::slice::from_ref(&disc), &mut loads);
        assert!(loads[0][0].abs() < 1e-6 * loads[0][1].abs().max(1.0), "{:?}", loads[0]);
    }
    let sums = solver.sums();
    assert!(sums.momentum[0].abs() < 1e-6 * sums.momentum[1].abs().max(1.0), "{sums:?}");
}

/// Axes that change places change nothing but the order of sums.
#[test]
fn axes_that_change_places_change_nothing() {
    let collapsed = |across: usize, down: usize| {
        let mut gravity = [0.0; 3];
        gravity[down] = -9.81;
        let mut cells = [6; 3];
        (cells[across], cells[down]) = (24, 16);
        let settings = PicSettings { relaxation: 0.1, ..PicSettings::water(gravity) };
        let is_wet = |x: [f64; 3]| x[across] < 0.3 && x[down] < 0.5;
        let mut solver = full(cells, 0.05, settings, 1, is_wet);
        let mut centre = [0.15; 3];
        (centre[across], centre[down]) = (0.6, 0.1);
        let ball = RigidBody::ball(centre, 0.08).with_mass(2.0);
        let mut loads = Vec::new();
        for _ in 0..30 {
            solver.step(4e-3, std::slice::from_ref(&ball), &mut loads);
        }
        let sums = solver.sums();
        [sums.kinetic, sums.momentum[across], sums.momentum[down], loads[0][across], loads[0][down]]
    };
    let first = collapsed(0, 2);
    for (across, down) in [(1, 2), (2, 0), (0, 1)] {
        for (a, b) in collapsed(across, down).into_iter().zip(first) {
            assert!((a - b).abs() < 1e-5 * b.abs().max(1.0), "{across} {down}: {a} {b}");
        }
    }
}

/// Polyhedra in water: a cube that is half as heavy as it, released under water, rises with the
/// added mass of a cube, 0.64 of the displaced one (Brennen 1982 gives 0.638 for a cube).
#[test]
fn a_released_cube_moves_with_its_added_mass() {
    use crate::solids::half_spaces::HalfSpaces;
    use crate::solids::rigid_body::{BodyShape, Freedom};
    use crate::solids::section::Section;
    use tremie_messages::scene::Pose;
    let (edge, at) = (0.2, [0.502, 0.503, 0.498]);
    let corners: Vec<[f64; 3]> =
        (0..8).map(|k| std::array::from_fn(|a| (f64::from(k >> a & 1) - 0.5) * edge)).collect();
    let convex = tremie_geometry::Convex::hull(&corners).unwrap();
    let frame = tremie_geometry::Frame::of(&Pose { position: at, ..Pose::IDENTITY });
    let shape = BodyShape::Convex {
        solid: Box::new(HalfSpaces::<3>::of(&convex, 1.0, &frame, &Section::SPACE)),
        reach: edge,
        width: edge,
        volume: edge.powi(3),
    };
    let displaced = 1000.0 * edge.powi(3);
    let mass = 0.5 * displaced;
    let mut cube = RigidBody::at(at, shape);
    let inverse = 6.0 / (mass * edge * edge);
    let inverse_inertia =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { inverse } else { 0.0 }));
    cube.freedom = Freedom::Free { mass, inverse_inertia };
    let mut solver =
        full([64; 3], 1.0 / 64.0, PicSettings::water([0.0, 0.0, -9.81]), 2, |x| !cube.holds(x));
    let mut loads = Vec::new();
    assert!(solver.step(1e-4, &[cube], &mut loads).converged);
    let acceleration = loads[0][2] / mass - 9.81;
    let exact = 9.81 * 0.5 / (0.5 + 0.638);
    assert!((acceleration / exact - 1.0).abs() < 0.05, "{acceleration} {exact}");
    // It is let go an eighth of a cell off the middle of the box.
    let torque = (3..6).map(|k| loads[0][k].abs()).fold(0.0, f64::max);
    assert!(torque < 0.05 / 64.0 * loads[0][2], "{:?}", loads[0]);
}

/// Water without viscosity slides down a slope as a block without friction does: the slope presses
/// on it along its normal alone.
#[test]
fn water_slides_down_a_slope_without_friction() {
    use crate::solids::half_spaces::HalfSpaces;
    use crate::solids::rigid_body::BodyShape;
    use crate::solids::section::Section;
    let plane = Section::<2> { axes: [0, 1], through: [0.0; 3] };
    for degrees in [15.0_f64, 30.0, 45.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let top = [0.4, 1.5];
        // Along the slope, and out of it.
        let place = |x: [f64; 2]| {
            let arm = [x[0] - top[0], x[1] - top[1]];
            [arm[0] * cosine - arm[1] * sine, arm[0] * sine + arm[1] * cosine]
        };
        let slope = RigidBody::at(
            [1.0, 0.5],
            BodyShape::Convex {
                solid: Box::new(HalfSpaces::beyond(
                    [top[0], top[1], 0.0],
                    [sine, cosine, 0.0],
                    &plane,
                )),
                reach: 4.0,
                width: 8.0,
                volume: 1.0,
            },
        );
        let grid = StaggeredGrid::new([100, 100], 0.02, [0.0; 2], [false; 2]);
        let settings = PicSettings::water([0.0, -9.81]);
        let mut solver = PicSolver::new(grid, settings, 1, Vec::new(), vec![slope]).unwrap();
        let is_wet = |x: [f64; 2]| {
            let [along, out] = place(x);
            (0.1..0.9).contains(&along) && out > 0.0 && out < 0.16
        };
        seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |_| [0.0; 2]);
        let (dt, steps) = (1e-3, 200);
        let mut loads = Vec::new();
        for _ in 0..steps {
            solver.step(dt, &[], &mut loads);
        }
        let count = solver.particles.len() as f64;
        let mean: [f64; 2] =
            std::array::from_fn(|a| solver.particles.velocity[a].iter().sum::<f64>() / count);
        let along = mean[0] * cosine - mean[1] * sine;
        let free = 9.81 * sine * dt * f64::from(steps);
        eprintln!("{degrees}: {along} {free} {}", along / free);
        assert!((along / free - 1.0).abs() < 0.02, "{degrees}: {along}, {free}");
    }
}

/// Bodies that stay push the fluid out, whichever of the others went and whoever came.
#[test]
fn bodies_that_stay_push_the_fluid_out() {
    let disc = |id: u64, x: f64, y: f64| RigidBody { id, ..RigidBody::ball([x, y], 0.1) };
    let row = |y: f64| [(2, 0.2), (4, 0.5), (6, 0.8)].map(|(id, x)| disc(id, x, y));
    for gone in 0..3 {
        for new in [None, Some(1), Some(5), Some(7)] {
            let settings = PicSettings::water([0.0, -9.81]);
            let mut solver = full([40, 32], 0.025, settings, 1, |x: [f64; 2]| x[1] < 0.5);
            solver.remove_inside(&row(0.3));
            assert!(solver.find_loads(1e-3, &row(0.3), &mut Vec::new()).converged);
            let mut bodies = row(0.29).to_vec();
            bodies.remove(gone);
            let stay = bodies.clone();
            bodies.extend(new.map(|id| disc(id, 0.5, 0.7)));
            bodies.sort_by_key(|body| body.id);
            solver.move_particles(1e-3, &bodies);
            let (particles, margin) = (&solver.particles, 0.999 * MARGIN * solver.grid.spacing);
            let is_out = |body: &RigidBody<2>, k: usize| {
                body.height(particles.at(k), 1.0).is_none_or(|(height, _)| height >= margin)
            };
            for body in &stay {
                let inside = (0..particles.len()).filter(|&k| !is_out(body, k)).count();
                assert_eq!(inside, 0, "in body {} without number {gone}, {new:?} new", body.id);
            }
            assert!(solver.find_loads(1e-3, &bodies, &mut Vec::new()).converged);
        }
    }
}
