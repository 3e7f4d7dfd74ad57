//! Parts that stand still: walls anywhere, thin walls, regions with velocity or pressure, forces.

use crate::common::*;
use tremie_fluid_lbm::{Precision, Walls};
use tremie_messages::scene::{Course, Face, Geometry, Motion, Outflow, PartBoundary, Pose};
use tremie_messages::{BodyState, Load};

fn cuboid(size: [f64; 3]) -> Geometry {
    Geometry::Box { size }
}

/// Two boxes that leave a channel of 12 cells are the walls of a channel: Poiseuille's profile,
/// exact (1e-11 of its peak) half-way between cells.
#[test]
fn boxes_are_walls() {
    // Through periodic faces each would come in again where the other is.
    let mut case = Case::new([3, 20, 3], [PERIODIC, WALL, PERIODIC], 0.8);
    let peak = 1e-4;
    case.acceleration[0] = 8.0 * case.viscosity() * peak / 144.0;
    let mut scene = case.scene();
    scene.parts.push(part("floor", cuboid([9.0, 8.0, 9.0]), [1.5, 0.0, 1.5]));
    scene.parts.push(part("roof", cuboid([9.0, 8.0, 9.0]), [1.5, 20.0, 1.5]));
    let mut fluid = case.fluid_of(&scene);
    for _ in 0..7000 {
        fluid.step(&[], &mut []).unwrap();
    }
    closes(&fluid, 1e-13);
    for k in 0..20 {
        let y = k as f64 + 0.5 - 4.0;
        let expected = if (4..16).contains(&k) { peak * y * (12.0 - y) / 36.0 } else { 0.0 };
        let error = (fluid.velocity_at([1, k, 1])[0] - expected).abs() / peak;
        assert!(error < 1e-11, "{k}: {error}");
        assert_eq!(fluid.node([1, k, 1]).solid, expected == 0.0);
    }
    // Each wall holds half of the fluid.
    let mut loads = Vec::new();
    fluid.loads_on_parts(&mut loads);
    let half = 0.5 * case.acceleration[0] * 12.0 * 9.0;
    assert_eq!(loads.iter().map(|load| load.id).collect::<Vec<_>>(), [0, 1]);
    for load in loads {
        assert!((load.force[0] / half - 1.0).abs() < 1e-9, "{} {half}", load.force[0]);
    }
}

/// The same channel at any height between cells: interpolated walls keep the error below 1.5 % of
/// the peak, half-way walls do not.
#[test]
fn interpolated_walls_lie_where_they_should() {
    let worst = |walls: Walls, shift: f64| {
        let mut case = Case::new([3, 16, 3], [PERIODIC; 3], 0.8);
        case.walls = walls;
        let peak = 1e-4;
        case.acceleration[0] = 8.0 * case.viscosity() * peak / 144.0;
        let mut scene = case.scene();
        scene.parts.push(part("walls", cuboid([9.0, 12.0, 9.0]), [1.5, 8.0 + shift, 1.5]));
        scene.parts[0].cavity = true;
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..7000 {
            fluid.step(&[], &mut []).unwrap();
        }
        closes(&fluid, 1e-13);
        let error = |k: usize| {
            let y = k as f64 + 0.5 - 2.0 - shift;
            let found = fluid.velocity_at([1, k, 1])[0] / peak;
            if fluid.node([1, k, 1]).solid { 0.0 } else { (found - y * (12.0 - y) / 36.0).abs() }
        };
        (0..16).map(error).fold(0.0, f64::max)
    };
    for shift in [0.1, 0.3, 0.5, 0.7, 0.9] {
        let (curved, straight) = (worst(Walls::Bouzidi, shift), worst(Walls::Halfway, shift));
        println!("shift {shift}: {curved:.1e}, half-way {straight:.1e}");
        assert!(curved < 0.015, "{shift}: {curved}");
        assert!(straight > 3.0 * curved, "{shift}: {straight} {curved}");
    }
}

/// Flow through a pipe of 10 cells' diameter, `Q = pi a R^4/(8 nu)`: 1.5 %; the wall carries the
/// weight of the fluid; the balance closes.
#[test]
fn a_pipe_is_round() {
    for (axis, threads) in [(2, 1), (2, 3)] {
        let mut case = Case::new([14, 14, 3], [PERIODIC; 3], 0.9);
        case.threads = threads;
        let a = 1e-6;
        case.acceleration[axis] = a;
        let mut scene = case.scene();
        let pipe = Geometry::Cylinder { radius: 5.0, length: 30.0 };
        scene.parts.push(part("pipe", pipe, [7.13, 6.94, 1.5]));
        scene.parts[0].cavity = true;
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..3000 {
            fluid.step(&[], &mut []).unwrap();
        }
        closes(&fluid, 1e-13);
        let rate: f64 = cells(&fluid).map(|c| fluid.velocity_at(c)[axis]).sum::<f64>() / 3.0;
        let expected = std::f64::consts::PI * a * 5.0_f64.powi(4) / (8.0 * case.viscosity());
        println!("flow rate {}", rate / expected);
        assert!((rate / expected - 1.0).abs() < 0.015, "{}", rate / expected);
        let mut loads = Vec::new();
        fluid.loads_on_parts(&mut loads);
        let weight = a * fluid.diagnostics().fluid_cells as f64;
        assert!((loads[0].force[axis] / weight - 1.0).abs() < 1e-3);
    }
}

/// The force on a sphere that is a part is that on a sphere that is a body, but for the facets of
/// the mesh: 1 %.
#[test]
fn a_sphere_is_a_sphere() {
    let mut case = Case::new([24, 20, 20], [PERIODIC, WALL, WALL], 0.8);
    case.acceleration[0] = 1e-5;
    let (at, radius) = ([12.2, 9.9, 10.3], 4.2);
    let mut scene = case.scene();
    let mut body = case.fluid();
    scene.parts.push(part("ball", Geometry::Sphere { radius }, at));
    let mut fixed = case.fluid_of(&scene);
    body.apply_events(&[added(1, radius)]).unwrap();
    let states = [BodyState::at_rest(1, at)];
    let mut loads = loads_of(&states);
    body.start(&states, &mut loads).unwrap();
    for _ in 0..600 {
        body.step(&states, &mut loads).unwrap();
        fixed.step(&[], &mut []).unwrap();
        closes(&fixed, 1e-12);
    }
    let mut on_parts: Vec<Load> = Vec::new();
    fixed.loads_on_parts(&mut on_parts);
    // Either with what the mean pressure gradient does.
    let drag = loads[0].force[0];
    println!("{} {}", on_parts[0].force[0], drag);
    assert!((on_parts[0].force[0] / drag - 1.0).abs() < 0.01);
    for a in 0..3 {
        let scale = drag * radius;
        assert!((on_parts[0].torque[a] - loads[0].torque[a]).abs() < 0.01 * scale);
    }
}

/// Under pressure, closed surfaces feel nothing and a body on a wall the pressure on what it shows:
/// within the walls of a cavity, a box on its floor, 1e-12.
#[test]
fn only_gauge_pressure_presses() {
    let case = Case::new([12, 12, 12], [WALL; 3], 0.8);
    let mut scene = case.scene();
    scene.fluid.as_mut().unwrap().pressure = 1e-3;
    scene.parts.push(part("free", cuboid([3.0, 3.0, 3.0]), [4.5, 4.5, 6.5]));
    scene.parts.push(part("seated", cuboid([2.0, 4.0, 6.0]), [9.0, 9.0, 0.0]));
    let mut fluid = case.fluid_of(&scene);
    for _ in 0..50 {
        fluid.step(&[], &mut []).unwrap();
        closes(&fluid, 1e-12);
    }
    let mut loads = Vec::new();
    fluid.loads_on_parts(&mut loads);
    assert!(norm(loads[0].force) < 1e-14);
    assert!((loads[1].force[2] + 8.0 * 1e-3).abs() < 1e-14, "{:?}", loads[1]);
    assert!(loads[1].force[0].abs() < 1e-14 && loads[1].force[1].abs() < 1e-14);
}

/// A wall of a third of a cell between two cells holds the fluid on either side apart.
#[test]
fn a_thin_wall_is_a_wall() {
    let case = Case::new([16, 5, 5], [PERIODIC; 3], 0.8);
    let mut scene = case.scene();
    scene.parts.push(part("foil", cuboid([0.3, 20.0, 20.0]), [5.0, 2.5, 2.5]));
    scene.parts.push(part("plate", cuboid([2.0, 20.0, 20.0]), [13.0, 2.5, 2.5]));
    let resolution = case.parameters().resolve(&scene).unwrap();
    assert_eq!(resolution.fluid_cells, 14 * 25);
    assert!(resolution.notes.iter().any(|n| n.contains("thinner than a cell, of foil")));
    assert!(
        resolution.notes.iter().any(|n| n.contains("1 pockets of 175 cells")),
        "{:?}",
        resolution.notes
    );
    scene.parts[0].motion = Motion::Prescribed(Vec::new());
    let moving = case.parameters().resolve(&scene).unwrap().notes;
    let about_foil = |notes: &[String]| notes.iter().find(|n| n.contains("of foil")).cloned();
    assert_eq!(about_foil(&moving), about_foil(&resolution.notes), "as of a part that moves");
    scene.parts[0].motion = Motion::Fixed;
    let mut fluid = case.fluid_of(&scene);
    fluid.set_state(|x| ([0.0; 3], if x[0] > 5.0 && x[0] < 12.0 { 1e-3 } else { 0.0 }));
    for _ in 0..100 {
        fluid.step(&[], &mut []).unwrap();
        closes(&fluid, 1e-13);
    }
    for cell in cells(&fluid).filter(|&c| !fluid.node(c).solid) {
        let expected = if (5..12).contains(&cell[0]) { 1e-3 } else { 0.0 };
        assert!((fluid.pressure_at(cell) - expected).abs() < 1e-14, "{cell:?}");
        assert!(norm(fluid.velocity_at(cell)) < 1e-14);
    }
    let mut loads = Vec::new();
    fluid.loads_on_parts(&mut loads);
    assert!((loads[0].force[0] + 25e-3).abs() < 1e-12, "{:?}", loads[0]);
}

/// A duct between two parts that prescribe pressures half-way between cells: Poiseuille's profile
/// in the middle, 2.5 %: the pressures hold within half a cell of the ends.
#[test]
fn parts_may_prescribe_pressures() {
    let case = Case::new([56, 11, 3], [WALL, WALL, PERIODIC], 0.8);
    let mut scene = case.scene();
    let drop = 2e-5;
    for (name, x, pressure) in [("inlet", 0.0, drop), ("outlet", 56.0, 0.0)] {
        let mut end = part(name, cuboid([6.0, 30.0, 30.0]), [x, 5.5, 1.5]);
        end.boundary = PartBoundary::Pressure { pressure, course: Course::default() };
        scene.parts.push(end);
    }
    let mut fluid = case.fluid_of(&scene);
    for _ in 0..9000 {
        fluid.step(&[], &mut []).unwrap();
    }
    closes(&fluid, 1e-12);
    let peak = drop / 50.0 * 121.0 / (8.0 * case.viscosity());
    for k in 0..11 {
        let y = k as f64 + 0.5;
        let error = fluid.velocity_at([28, k, 1])[0] / peak - 4.0 * y * (11.0 - y) / 121.0;
        assert!(error.abs() < 0.025, "{k}: {error}");
    }
}

/// A part that prescribes a velocity feeds what a face lets out: flow rate over the duct, 2e-3.
#[test]
fn parts_may_prescribe_velocities() {
    let case = Case::new([24, 8, 8], [WALL, SYMMETRY, SYMMETRY], 0.8);
    let mut scene = case.scene();
    scene.domain.faces[0][1] =
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
    let mut feed = part("feed", cuboid([6.0, 30.0, 30.0]), [0.2, 4.0, 4.0]);
    let velocity = [0.01, 0.0, 0.0];
    feed.boundary =
        PartBoundary::Velocity { velocity, course: Course::Points(vec![[0.0, 0.0], [600.0, 1.0]]) };
    scene.parts.push(feed);
    let mut fluid = case.fluid_of(&scene);
    for _ in 0..6000 {
        fluid.step(&[], &mut []).unwrap();
        closes(&fluid, 1e-12);
    }
    for cell in cells(&fluid).filter(|c| (6..22).contains(&c[0])) {
        let u = fluid.velocity_at(cell);
        assert!((u[0] / 0.01 - 1.0).abs() < 2e-3, "{cell:?} {u:?}");
    }
}

#[test]
fn only_what_a_way_leads_to_is_fluid() {
    let case = Case::new([16, 12, 12], [WALL; 3], 0.8);
    let mut scene = case.scene();
    let tank = cuboid([10.0, 8.0, 8.0]);
    scene.parts.push(part("tank", tank, [8.0, 6.0, 6.0]));
    scene.parts[0].cavity = true;
    scene.parts.push(part("wall", cuboid([2.0, 20.0, 20.0]), [8.0, 6.0, 6.0]));
    scene.fluid.as_mut().unwrap().inside = vec![[5.0, 6.0, 6.0]];
    scene.fluid.as_mut().unwrap().outside = vec![[12.0, 6.0, 6.0]];
    let parameters = case.parameters();
    let resolution = parameters.resolve(&scene).unwrap();
    assert_eq!(resolution.fluid_cells, 4 * 64);
    let fluid = case.fluid_of(&scene);
    assert!(!fluid.node([4, 6, 6]).solid && fluid.node([10, 6, 6]).solid);

    // A hole of 2 x 3 cells.
    scene.parts[1].geometry = cuboid([2.0, 20.0, 6.0]);
    scene.parts[1].pose = Pose { position: [8.0, 6.0, 4.0], ..Pose::IDENTITY };
    let problems = parameters.resolve(&scene).unwrap_err();
    assert_eq!(problems.len(), 1, "{problems:?}");
    let text = problems[0].to_string();
    assert!(text.starts_with("scene.fluid.outside[0]: the fluid leaks"), "{text}");
    assert!(text.contains("between") && text.contains("wall") && text.contains("tank"), "{text}");

    scene.fluid.as_mut().unwrap().inside = vec![[1.0, 1.0, 1.0], [40.0, 0.0, 0.0]];
    let problems = parameters.resolve(&scene).unwrap_err();
    assert!(problems[0].message.contains("outside the domain"), "{problems:?}");
    scene.fluid.as_mut().unwrap().inside.pop();
    let problems = parameters.resolve(&scene).unwrap_err();
    assert!(problems[0].message.contains("is in tank"), "{problems:?}");
}

/// Memory in all for each fluid cell: at most 200 bytes in f64 and 110 in f32 where 44 % of the box
/// are fluid, between a bore and the bolt in it.
#[test]
fn cells_take_little_memory() {
    for (precision, most) in [(Precision::F64, 200.0), (Precision::F32, 110.0)] {
        let mut case = Case::new([96, 96, 120], [WALL, WALL, SYMMETRY], 0.8);
        case.precision = precision;
        let mut scene = case.scene();
        for (name, radius, cavity) in [("bore", 42.0, true), ("bolt", 21.0, false)] {
            let cylinder = Geometry::Cylinder { radius, length: 300.0 };
            scene.parts.push(part(name, cylinder, [48.1, 47.8, 60.0]));
            scene.parts.last_mut().unwrap().cavity = cavity;
        }
        let fluid = case.fluid_of(&scene);
        let cells = fluid.diagnostics().fluid_cells as f64;
        let each = fluid.memory_bytes() as f64 / cells;
        println!(
            "{precision:?}: {:.3} fluid, {each:.1} bytes a cell",
            cells / (96.0 * 96.0 * 120.0)
        );
        assert!(each < most, "{each}");
    }
}
