//! Deformable surfaces as boundaries.

use crate::common::*;
use std::f64::consts::PI;
use std::fmt::Write;
use tremie_fluid_lbm::{FluidError, LbmFluid, Refill};
use tremie_geometry::Turned;
use tremie_messages::scene::{
    DeformableSurface, FacetKind, Gap, GapRule, GapSide, Geometry, Motion, Pose, Scene, Section,
    SectionEdge,
};
use tremie_messages::{BodyState, FacetLoad, SurfaceVertex};

/// A seal in a scene.
struct Seal {
    turned: Turned,
    points: Vec<[f64; 2]>,
    loads: Vec<FacetLoad>,
}

impl Seal {
    /// Adds one with the section `points`, closed unless it begins and ends on the axis, and a part
    /// that carries it.
    fn new(scene: &mut Scene, points: &[[f64; 2]], sectors: u32, at: [f64; 3]) -> Self {
        let count = points.len() as u32;
        let open = points[0][0] == 0.0 && points[points.len() - 1][0] == 0.0;
        let edges = (0..if open { count - 1 } else { count })
            .map(|k| SectionEdge { points: [k, (k + 1) % count], kind: FacetKind::Exposed });
        let section = Section { points: points.to_vec(), edges: edges.collect() };
        let mut carrier = part("carrier", Geometry::Box { size: [1.0; 3] }, at);
        carrier.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(carrier);
        let surface = DeformableSurface {
            name: "seal".into(),
            carrier: "carrier".into(),
            table: "seal.json".into(),
            pose: Pose::IDENTITY,
            sectors,
            material: "wall".into(),
            seat_stiffness: 1.0,
            start: Default::default(),
            section,
        };
        let turned = Turned::of(&surface);
        scene.surfaces.push(surface);
        let loads = vec![FacetLoad::default(); turned.triangles.len()];
        Self { turned, points: points.to_vec(), loads }
    }

    /// Vertices where `place` puts them, with the velocity that `velocity` says there.
    fn vertices(
        &self,
        place: impl Fn([f64; 3]) -> [f64; 3],
        velocity: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Vec<SurfaceVertex> {
        let places = self.turned.places(&self.points).into_iter().map(|x| place(x.into()));
        places.map(|position| SurfaceVertex { position, velocity: velocity(position) }).collect()
    }

    fn loads(&mut self, fluid: &mut LbmFluid) -> [[f64; 3]; 2] {
        fluid.surface_loads(&mut self.loads);
        let mut sum = [[0.0; 3]; 2];
        for load in &self.loads {
            let (p, f) = (load.point, load.force);
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                sum[0][a] += f[a];
                sum[1][a] += p[b] * f[c] - p[c] * f[b];
            }
        }
        sum
    }
}

/// A thick disc on the axis.
const DISC: [[f64; 2]; 4] = [[0.0, -2.1], [5.3, -2.4], [4.7, 2.2], [0.0, 2.6]];

fn plus(a: [f64; 3], b: [f64; 3], scale: f64) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + scale * b[k])
}

/// The path of a file with the seal's triangles.
fn written(seal: &Seal) -> String {
    let mut text = String::new();
    for [x, y, z] in seal.turned.places(&seal.points).into_iter().map(<[f64; 3]>::from) {
        writeln!(text, "v {x:?} {y:?} {z:?}").unwrap();
    }
    for [a, b, c] in &seal.turned.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let path = format!("{}/seal.obj", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, text).unwrap();
    path
}

/// A surface that moves as a whole is the moving part of the same shape, if no edge of it is so
/// sharp that it cuts links (which are not looked for at surfaces that deform): same cells, same
/// force to 1e-12, same torque to 2 % of force times radius (a facet's load has a point near it,
/// and no torque of its own); also where it turns at its place, and with forces that are averaged,
/// buoyancy, and accounts of mass.
#[test]
fn a_surface_moved_as_a_whole_is_a_moving_part() {
    let mut case = Case::new([26, 22, 20], [PERIODIC, WALL, WALL], 0.8);
    case.average_force = true;
    case.gravity = [0.0, 0.0, -1e-4];
    case.refill = Refill::Mass;
    let mut scene = case.scene();
    let begin = [9.03, 10.61, 9.87];
    let flat = |[radius, height]: [f64; 2]| [radius, 0.9 * height];
    let round: Vec<_> = half_circle(4.9).into_iter().map(flat).collect();
    let mut seal = Seal::new(&mut scene, &round, 36, begin);
    let path = written(&seal);
    let mut rigid = case.scene();
    let mut mover = part("mover", Geometry::File { path, unit: 1.0 }, begin);
    mover.motion = Motion::Prescribed(Vec::new());
    rigid.parts.push(mover);

    let parameters = tremie_fluid_lbm::Parameters { part_step: 0.0, ..case.parameters() };
    let build = |scene: &Scene| LbmFluid::new(scene, &parameters, 1.0, 2).unwrap();
    let (mut soft, mut hard) = (build(&scene), build(&rigid));
    hard.apply_events(&[added_part(1, 0)]).unwrap();
    let mut body = [BodyState::at_rest(1, begin)];
    let mut load = loads_of(&body);
    let (mut most, mut far) = (0.0_f64, 0.0_f64);
    for step in 0..90 {
        body[0].velocity = if step < 60 { [0.031, -0.02, 0.012] } else { [0.0; 3] };
        body[0].angular_velocity = if step < 60 { [0.0; 3] } else { [0.001, 0.002, 0.003] };
        let (at, v, w) = (body[0].position, body[0].velocity, body[0].angular_velocity);
        let at = if step == 0 { at } else { plus(at, v, 1.0) };
        body[0].position = at;
        let velocity = |x: [f64; 3]| {
            let r = plus(x, at, -1.0);
            std::array::from_fn(|a| {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                v[a] + w[b] * r[c] - w[c] * r[b]
            })
        };
        soft.set_surfaces(&seal.vertices(|x| plus(x, at, 1.0), velocity)).unwrap();
        if step == 0 {
            soft.start(&[], &mut []).unwrap();
            hard.start(&body, &mut load).unwrap();
        } else {
            soft.step(&[], &mut []).unwrap();
            hard.step(&body, &mut load).unwrap();
        }
        closes(&soft, 1e-11);
        for cell in cells(&soft) {
            assert_eq!(soft.node(cell).solid, hard.node(cell).solid, "step {step}: {cell:?}");
        }
        let [force, mut torque] = seal.loads(&mut soft);
        let size = norm(load[0].force);
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            torque[a] -= at[b] * force[c] - at[c] * force[b];
            most = most.max((force[a] - load[0].force[a]).abs() / size);
            far = far.max((torque[a] - load[0].torque[a]).abs() / (5.0 * size));
        }
        let (left, given) = (soft.ledger(), hard.ledger());
        assert!((left.mass_owed - given.mass_owed).abs() < 1e-10);
        for a in 0..3 {
            assert!((left.delivered[a] - given.delivered[a]).abs() < 1e-11);
            assert!((left.buoyancy[a] - given.buoyancy[a]).abs() < 1e-12);
        }
    }
    println!("largest difference of forces {most:.2e}, of torques {far:.2e}");
    assert!(most < 1e-12 && far < 0.02, "{most} {far}");
}

/// Uniform pressure: no resultant on the whole, pressure times area on a face, to the cells that
/// the face covers exactly, and to 4 % of its true area.
#[test]
fn uniform_pressure_gives_pressure_times_area() {
    let case = Case::new([24, 24, 24], [WALL, WALL, WALL], 0.8);
    let mut scene = case.scene();
    let side = 12.3;
    let radius = side / PI.sqrt();
    let section = [[0.0, -3.8], [radius, -3.8], [radius, 3.8], [0.0, 3.8]];
    let mut seal = Seal::new(&mut scene, &section, 4, [12.0; 3]);
    let mut fluid = case.fluid_of(&scene);
    // A square of four sectors, turned so that its sides lie along the axes.
    let turn = |x: [f64; 3]| {
        let s = 0.5_f64.sqrt();
        [12.0 + s * (x[0] - x[1]), 12.0 + s * (x[0] + x[1]), 12.0 + x[2]]
    };
    fluid.set_surfaces(&seal.vertices(turn, |_| [0.0; 3])).unwrap();
    let pressure = 1e-3;
    fluid.set_state(|_| ([0.0; 3], pressure));
    fluid.start(&[], &mut []).unwrap();
    for _ in 0..5 {
        fluid.step(&[], &mut []).unwrap();
    }
    let [force, torque] = seal.loads(&mut fluid);
    assert!(norm(force) < 1e-13 && norm(torque) < 2e-3 * pressure * side.powi(3), "{torque:?}");
    let corners =
        |k: usize| seal.turned.triangles[k].map(|v| seal.turned.place(&section, v as usize));
    let mut faces = [0.0; 2];
    for (k, load) in seal.loads.iter().enumerate() {
        let heights = corners(k).map(|corner| corner[2]);
        for (face, at) in [(0, -3.8), (1, 3.8)] {
            if heights == [at; 3] {
                faces[face] += load.force[2];
                assert!((load.point[2] - 12.0 - at).abs() < 0.5);
            }
        }
    }
    let expected = pressure * 144.0;
    println!("faces {faces:?}, by cells {expected}, by area {}", pressure * side * side);
    assert!((faces[0] - expected).abs() < 1e-12 && (faces[1] + expected).abs() < 1e-12);
    assert!((faces[1] / (pressure * side * side) + 1.0).abs() < 0.05);
}

/// The outline of half a sphere, from its lowest point to its highest.
fn half_circle(radius: f64) -> Vec<[f64; 2]> {
    let ring = |k: u32| {
        let angle = PI * f64::from(k) / 16.0;
        let r = if k == 0 || k == 16 { 0.0 } else { radius * angle.sin() };
        [r, -radius * angle.cos()]
    };
    (0..=16).map(ring).collect()
}

/// A sphere in a closed box that breathes.
struct Breathing {
    seal: Seal,
    fluid: LbmFluid,
}

impl Breathing {
    const RADIUS: f64 = 6.0;
    const MIDDLE: [f64; 3] = [15.02, 14.93, 15.07];

    fn new(refill: Refill) -> Self {
        let mut case = Case::new([30, 30, 30], [WALL, WALL, WALL], 0.8);
        case.refill = refill;
        case.threads = 2;
        let mut scene = case.scene();
        let seal = Seal::new(&mut scene, &half_circle(Self::RADIUS), 32, Self::MIDDLE);
        Self { fluid: case.fluid_of(&scene), seal }
    }

    /// Its vertices, grown by a factor, its radius growing with `speed`.
    fn at(&self, scale: f64, speed: f64) -> Vec<SurfaceVertex> {
        let rate = speed / (Self::RADIUS * scale);
        let place = |x: [f64; 3]| plus(Self::MIDDLE, x, scale);
        self.seal.vertices(place, |x| plus(x, Self::MIDDLE, -1.0).map(|x| x * rate))
    }

    fn volume(&self, scale: f64) -> f64 {
        let vertices = self.at(scale, 0.0).iter().map(|vertex| vertex.position.into()).collect();
        let triangles = self.seal.turned.triangles.clone();
        tremie_geometry::Mesh { vertices, triangles }.moments().volume
    }
}

/// Walls that move push what they sweep: area times velocity to 3 %, in the mean over 200 steps.
#[test]
fn links_push_what_the_surface_sweeps() {
    let mut case = Breathing::new(Refill::Eqneq);
    let speed = 1e-4;
    let vertices = case.at(1.0, speed);
    case.fluid.set_surfaces(&vertices).unwrap();
    case.fluid.start(&[], &mut []).unwrap();
    let mut pushed = 0.0;
    for step in 0..300 {
        case.fluid.step(&[], &mut []).unwrap();
        pushed += if step < 100 { 0.0 } else { case.fluid.ledger().mass_bodies / 200.0 };
    }
    // For similar shapes dV/dR = 3 V/R.
    let swept = 3.0 * case.volume(1.0) / Breathing::RADIUS * speed;
    println!("links push {pushed:.6}, the surface sweeps {swept:.6}");
    assert!((pushed / swept - 1.0).abs() < 0.03);
}

/// A sphere that grows by a fifth in a closed box pushes out what it sweeps: the mean density grows
/// as the room shrinks, to 1 % of the growth. (The cells that it covers are those of its volume to
/// 4 % only.)
#[test]
fn a_sphere_that_grows_keeps_the_mass() {
    let mut case = Breathing::new(Refill::Mass);
    let (speed, steps, radius) = (0.004, 300, Breathing::RADIUS);
    let vertices = case.at(1.0, 0.0);
    case.fluid.set_surfaces(&vertices).unwrap();
    case.fluid.start(&[], &mut []).unwrap();
    case.fluid.step(&[], &mut []).unwrap();
    let density = |fluid: &LbmFluid| {
        let free = cells(fluid).filter(|&cell| !fluid.node(cell).solid).count();
        fluid.ledger().mass / free as f64
    };
    let before = density(&case.fluid);
    let last = 1.0 + speed * f64::from(steps) / radius;
    for step in 1..=steps + 300 {
        let scale = (1.0 + speed * f64::from(step) / radius).min(last);
        let vertices = case.at(scale, if step > steps { 0.0 } else { speed });
        case.fluid.set_surfaces(&vertices).unwrap();
        case.fluid.step(&[], &mut []).unwrap();
        closes(&case.fluid, 1e-10);
    }
    case.fluid.check().unwrap();
    let room = |scale: f64| 27e3 - case.volume(scale);
    let expected = room(1.0) / room(last) - 1.0;
    let growth = density(&case.fluid) / before - 1.0;
    println!("density grows by {growth:.6}, room says {expected:.6}");
    assert!(expected > 0.02 && (growth / expected - 1.0).abs() < 0.01);
}

/// A ring between a carrier, a sphere that nearly touches it, and a seat, that deforms: the same
/// bits on any number of threads.
#[test]
fn the_same_bits_on_any_number_of_threads() {
    let ring = [[4.0, -1.7], [8.2, -1.9], [8.0, 1.6], [4.2, 1.6]];
    let run = |threads: usize| {
        let mut case = Case::new([26, 26, 20], [WALL, WALL, WALL], 0.51);
        case.threads = threads;
        case.average_force = true;
        case.refill = Refill::Mass;
        let mut scene = case.scene();
        let begin = [13.0, 13.0, 4.1];
        let mut seal = Seal::new(&mut scene, &ring, 40, begin);
        scene.parts[0].geometry = Geometry::Cylinder { radius: 8.1, length: 3.0 };
        scene.gaps.push(Gap {
            name: "foot".into(),
            between: [GapSide::Part("seal".into()), GapSide::Face { axis: 2, side: 0 }],
            open_at: 2.0,
            close_at: 0.5,
            pressure: GapRule::Nearest,
            slip_below: 4.0,
            region: None,
        });
        let mut fluid = case.fluid_of(&scene);
        fluid.set_state(|x| ([0.0; 3], 1e-3 * x[2]));
        let mut bodies =
            [BodyState::at_rest(1, [13.0, 13.0, 7.2]), BodyState::at_rest(5, [23.2, 13.0, 4.0])];
        bodies[1].velocity = [-0.002, 0.0, 0.0];
        fluid.apply_events(&[added_part(1, 0), added(5, 2.0)]).unwrap();
        let mut loads = loads_of(&bodies);
        let mut all = Vec::new();
        for step in 0..80 {
            let t = f64::from(step);
            bodies[0].velocity = [0.0, 0.0, 0.01];
            let place = |x: [f64; 3]| {
                let wider = 1.0 + 0.0008 * t * (1.6 - x[2]) / 3.5;
                [13.0 + wider * x[0], 13.0 + wider * x[1], 4.1 + 0.01 * t + x[2]]
            };
            let grow = |x: [f64; 3]| [8e-4 * (x[0] - 13.0), 8e-4 * (x[1] - 13.0), 0.01];
            fluid.set_surfaces(&seal.vertices(place, grow)).unwrap();
            match step {
                0 => fluid.start(&bodies, &mut loads).unwrap(),
                _ => fluid.step(&bodies, &mut loads).unwrap(),
            }
            advance(&mut bodies);
            closes(&fluid, 1e-10);
            let [force, _] = seal.loads(&mut fluid);
            all.extend(loads.iter().flat_map(|load| load.force));
            all.extend(force);
            all.extend(seal.loads.iter().flat_map(|load| load.force.into_iter().chain(load.point)));
        }
        fluid.check().unwrap();
        assert!(all.iter().all(|x| x.is_finite()));
        (all.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), seal.loads)
    };
    let (one, loads) = run(1);
    for threads in [2, 4] {
        assert!(run(threads).0 == one, "{threads} threads");
    }
    // The foot feels its gap, which held no fluid at first.
    assert!(loads.iter().any(|load| load.force[2] > 0.0));
}

#[test]
fn wrong_surfaces_are_refused() {
    let case = Case::new([20, 20, 20], [WALL, WALL, WALL], 0.8);
    let mut scene = case.scene();
    let seal = Seal::new(&mut scene, &DISC, 12, [10.0; 3]);
    let mut fluid = case.fluid_of(&scene);
    let mut vertices = seal.vertices(|x| plus(x, [10.0; 3], 1.0), |_| [0.0; 3]);
    let expected = vertices.len();
    let missing = FluidError::Vertices { expected, found: 0 };
    assert_eq!(fluid.start(&[], &mut []), Err(missing));
    let found = expected - 1;
    let few = fluid.set_surfaces(&vertices[1..]);
    assert_eq!(few, Err(FluidError::Vertices { expected, found }));
    let inward: Vec<_> = (vertices.iter())
        .map(|v| SurfaceVertex { position: v.position.map(|x| 20.0 - x), ..*v })
        .collect();
    let turned = fluid.set_surfaces(&inward).unwrap_err();
    assert!(matches!(&turned, FluidError::Surface { name, .. } if name == "seal"), "{turned}");
    vertices[3].velocity[1] = f64::NAN;
    let broken = fluid.set_surfaces(&vertices);
    assert_eq!(broken, Err(FluidError::NonFiniteVertex { vertex: 3 }));
    vertices[3].velocity[1] = 0.0;
    fluid.set_surfaces(&vertices).unwrap();
    fluid.start(&[], &mut []).unwrap();
    let refused = |change: fn(&mut DeformableSurface), key: &str| {
        let mut scene = scene.clone();
        change(&mut scene.surfaces[0]);
        match LbmFluid::new(&scene, &case.parameters(), 1.0, 1) {
            Ok(_) => panic!("{key} is taken"),
            Err(problems) => assert!(problems[0].key.ends_with(key), "{problems:?}"),
        }
    };
    refused(|seal| seal.carrier = "nobody".into(), "carrier");
    refused(|seal| seal.sectors = 2, "sectors");
    refused(|seal| seal.section.edges[1].points[0] = 9, "section");
}

/// A surface on a symmetry plane counts whole: along the plane its facets' loads in half a box add
/// up to those in the whole box.
#[test]
fn a_surface_that_a_mirror_cuts_counts_whole() {
    let run = |depth: usize, lower: tremie_messages::scene::Face, y: f64| {
        let mut case = Case::new([24, depth, 20], [WALL, WALL, WALL], 0.8);
        case.gravity = [0.0, 0.0, -1e-4];
        let mut scene = case.scene();
        scene.domain.faces[1][0] = lower;
        let begin = [9.07, y, 9.87];
        let mut seal = Seal::new(&mut scene, &DISC, 26, begin);
        let mut fluid = case.fluid_of(&scene);
        let mut all = Vec::new();
        for step in 0..40 {
            let v = [0.03, 0.0, 0.011];
            let at = plus(begin, v, f64::from(step));
            fluid.set_surfaces(&seal.vertices(|x| plus(x, at, 1.0), |_| v)).unwrap();
            match step {
                0 => fluid.start(&[], &mut []).unwrap(),
                _ => fluid.step(&[], &mut []).unwrap(),
            }
            closes(&fluid, 1e-10);
            let [force, _] = seal.loads(&mut fluid);
            all.push([force[0], force[2]]);
        }
        all
    };
    let (whole, half) = (run(20, WALL, 10.0), run(10, SYMMETRY, 0.0));
    let mut most = 0.0_f64;
    for (whole, half) in whole.iter().zip(&half) {
        let size = whole[0].hypot(whole[1]);
        let off = (whole[0] - half[0]).hypot(whole[1] - half[1]);
        most = most.max(off / size);
    }
    println!("half a box differs by {most:.2e}");
    assert!(most < 1e-10, "{most}");
}

/// A disc close above the floor and below a part, in a fluid at uniform pressure: the pressure in
/// the gap at the floor acts on its facets, that in the gap at the part too, unless it is bonded to
/// it: pressure times area to 10 %, by the cells at its rim.
#[test]
fn pressure_in_gaps_acts_on_facets_but_not_where_they_are_bonded() {
    let disc = [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [0.0, 4.0]];
    let pressure = 1e-3;
    let run = |is_bonded: bool| {
        let case = Case::new([24, 24, 20], [WALL, WALL, WALL], 0.8);
        let mut scene = case.scene();
        let mut seal = Seal::new(&mut scene, &disc, 48, [12.0, 12.0, 0.3]);
        let geometry = Geometry::Cylinder { radius: 6.0, length: 5.0 };
        let mut cover = part("cover", geometry, [0.0; 3]);
        cover.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(cover);
        if is_bonded {
            scene.surfaces[0].carrier = "cover".into();
        }
        let mut fluid = case.fluid_of(&scene);
        fluid.apply_events(&[added_part(3, 1)]).unwrap();
        let bodies = [BodyState::at_rest(3, [12.0, 12.0, 6.98])];
        let mut loads = loads_of(&bodies);
        let place = |x: [f64; 3]| plus(x, [12.0, 12.0, 0.3], 1.0);
        fluid.set_surfaces(&seal.vertices(place, |_| [0.0; 3])).unwrap();
        fluid.set_state(|_| ([0.0; 3], pressure));
        fluid.start(&bodies, &mut loads).unwrap();
        fluid.step(&bodies, &mut loads).unwrap();
        closes(&fluid, 1e-12);
        let [force, _] = seal.loads(&mut fluid);
        let area = PI * 36.0 * pressure;
        (force[2] / area, loads[0].force[2] / area)
    };
    let (bonded, apart) = (run(true), run(false));
    println!("bonded: disc {bonded:?}; apart: {apart:?} of pressure times area");
    assert!((bonded.0 - 1.0).abs() < 0.1 && (bonded.1 + 1.0).abs() < 0.1);
    assert!(apart.0.abs() < 0.1 && apart.1.abs() < 0.1);
}
