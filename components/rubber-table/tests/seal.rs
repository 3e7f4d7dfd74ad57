//! A seal of a scene: the one-dimensional law in space, on a carrier that is turned and moves.

mod common;

use tremie_geometry::Frame;
use tremie_messages::scene::{DeformableSurface, FacetKind, Pose, SurfaceStart};
use tremie_messages::{BodyState, FacetLoad, SurfaceVertex};
use tremie_rubber_table::runtime::{
    Eta, Form, Impedance, Law, Seal, SealError, Start, StepError, Water, relax,
};
use tremie_rubber_table::table::{Surface, Table};

const DT: f64 = 1e-7;
const STIFFNESS: f64 = 1e5;
/// h' of the ring [N/m].
const SLOPE: f64 = 1.194e5;

fn ring() -> Table {
    common::linear(SLOPE)
}

/// The ring below its carrier's origin, its axis along the carrier's y.
fn scene() -> DeformableSurface {
    let quarter = 0.5f64.sqrt();
    DeformableSurface {
        name: "ring".into(),
        carrier: "disc".into(),
        table: "ring.json".into(),
        pose: Pose { position: [0.0, -3e-3, 0.0], orientation: [-quarter, 0.0, 0.0, quarter] },
        sectors: 12,
        material: "rubber".into(),
        seat_stiffness: 1e10,
        start: Default::default(),
        section: ring().outline().section,
    }
}

fn seal(law: Law, water: Option<Water>) -> Seal {
    Seal::new(&scene(), ring(), law, Form::Axial, water, DT).unwrap()
}

fn carrier(height: f64) -> BodyState {
    BodyState { velocity: [0.0, -0.2, 0.0], ..BodyState::at_rest(0, [1e-3, height, -2e-3]) }
}

/// Springs on the plane y = 0 below each vertex of the foot, as loads on the first facet of each.
fn springs(surface: &Surface, vertices: &[SurfaceVertex]) -> Vec<FacetLoad> {
    let mut loads = Vec::new();
    for sector in 0..12 {
        let facet = 2 * sector;
        assert_eq!(surface.kinds[facet], FacetKind::Seat);
        let point = vertices[surface.triangles[facet][0] as usize].position;
        let depth = -point[1];
        if depth > 0.0 {
            let force = [0.0, STIFFNESS * depth, 0.0];
            loads.push(FacetLoad { facet: facet as u64, force, point, stiffness: STIFFNESS });
        }
    }
    loads
}

/// A substep of the seal above the plane; the vertices that were accepted, and the passes.
fn substep(seal: &mut Seal, height: f64) -> (Vec<SurfaceVertex>, u32) {
    let surface = Surface::of(&scene());
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    seal.begin_substep(&carrier(height));
    for pass in 1.. {
        assert!(!seal.is_settled());
        seal.write(&mut vertices);
        if seal.pass(springs(&surface, &vertices).into_iter()).unwrap() {
            seal.write(&mut vertices);
            return (vertices, pass);
        }
    }
    unreachable!()
}

#[test]
fn a_seal_in_space_obeys_the_law_of_one_number() {
    for eta in [Eta::Fixed(10.0), Eta::AtLeast(10.0)] {
        let law = Law { eta, ..Law::default() };
        let mut seal = seal(law, None);
        let (mut compression, mut rate) = (0.0, 0.0);
        seal.follow(&carrier(1e-4));
        for step in 0..200 {
            // It comes down through the plane; the foot is 3 mm below the carrier's origin.
            let gap = 1e-5 - 0.2 * DT * f64::from(step) - 1e-5;
            seal.begin_window(std::iter::empty());
            let (vertices, passes) = substep(&mut seal, 3e-3 + gap);
            let start = Start {
                compression,
                rate,
                dt: DT,
                contact_stiffness: if gap + compression < 0.0 { 12.0 * STIFFNESS } else { 0.0 },
                impedance: Impedance::default(),
            };
            let force = |at: tremie_rubber_table::table::Bracket| {
                12.0 * STIFFNESS * (-(gap + (at.frame as f64 + at.weight) * 0.3e-3)).max(0.0)
            };
            let expected = relax(&ring(), law, start, force).unwrap();
            let found = seal.readings();
            assert!((found.compression - expected.compression).abs() < 1e-12, "{step}: {found:?}");
            assert!(passes.abs_diff(expected.passes) <= 1, "{step}: {passes} {expected:?}");
            (compression, rate) = (expected.compression, expected.rate);
            // The foot moves with the carrier and retreats from it.
            let foot = vertices[0];
            assert!((foot.position[1] - gap - compression).abs() < 1e-12);
            assert!((foot.velocity[1] - (rate - 0.2)).abs() < 1e-4, "{foot:?} {rate}");
            assert_eq!(found.most_passes, passes);
        }
        assert!(seal.readings().compression > 1e-7 && seal.readings().seat_pressure > 0.0);
    }
}

/// Loads of a pressure on all facets.
fn pressed(surface: &Surface, vertices: &[SurfaceVertex], pressure: f64) -> Vec<FacetLoad> {
    let load = |(facet, triangle): (usize, &[u32; 3])| {
        let [a, b, c] = triangle.map(|v| vertices[v as usize].position);
        let (u, v): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
        let cross =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let point = std::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
        let force = cross.map(|n| -0.5 * pressure * n);
        FacetLoad { facet: facet as u64, force, point, stiffness: 0.0 }
    };
    surface.triangles.iter().enumerate().map(load).collect()
}

#[test]
fn a_fluid_at_rest_compresses_nothing_and_one_below_lifts_seal_and_carrier() {
    let surface = Surface::of(&scene());
    let mut seal = seal(Law::default(), None);
    seal.follow(&carrier(0.1));
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    seal.write(&mut vertices);
    let mut loads = pressed(&surface, &vertices, 4.65e5);
    seal.begin_window(loads.iter().copied());
    let resultant = seal.resultant();
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(size(resultant.force) < 1e-9 && size(resultant.torque) < 1e-11, "{resultant:?}");
    substep(&mut seal, 0.1);
    let still = seal.readings();
    assert!(still.force.abs() < 1e-9 && still.compression < 1e-15, "{still:?}");
    // The same below alone: pressure times the foot's area lifts, and compresses.
    loads.retain(|load| surface.kinds[load.facet as usize] == FacetKind::Seat);
    seal.begin_window(loads.iter().copied());
    let area = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2));
    let lift = 4.65e5 * area;
    let found = seal.resultant();
    assert!((found.force[1] / lift - 1.0).abs() < 1e-12, "{found:?} {lift}");
    assert!(found.force[0].abs() + found.force[2].abs() < 1e-9 * lift);
    // About its own axis, which the carrier's origin lies on.
    assert!(size(found.torque) < 1e-9 * lift, "{found:?}");
    substep(&mut seal, 0.1);
    assert!((seal.readings().force / lift - 1.0).abs() < 1e-12);
    assert!(seal.readings().compression > 0.0);
}

/// A ring on a hub, in a fluid at rest that cannot get between the two: it compresses nothing, for
/// what surrounds the ring is where the fluid is. A side that is free but dry would give way, and
/// counts.
#[test]
fn a_fluid_at_rest_compresses_nothing_on_a_hub_either() {
    let area = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2));
    for (is_covered, expected) in [(false, 6.5 / 17.5), (true, 0.0)] {
        let mut contents = ring().contents().clone();
        if is_covered {
            contents.facets.covered = vec![contents.facets.exposed.pop().unwrap()];
            assert_eq!(contents.facets.covered, [[3, 0]]);
        }
        let table = Table::new(contents).unwrap();
        let scene = DeformableSurface { section: table.outline().section, ..scene() };
        for form in [Form::Axial, Form::Pressure] {
            let law = Law::default();
            let mut seal = Seal::new(&scene, table.clone(), law, form, None, DT).unwrap();
            seal.follow(&carrier(0.1));
            let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
            seal.write(&mut vertices);
            let mut loads = pressed(&Surface::of(&scene), &vertices, 4.65e5);
            // The foot and the outer side, two facets in each of twelve sectors each.
            loads.truncate(2 * 24);
            seal.begin_window(loads.into_iter());
            substep(&mut seal, 0.1);
            let found = seal.readings().force / (4.65e5 * area);
            assert!((found - expected).abs() < 1e-9, "{is_covered} {form:?}: {found}");
        }
    }
}

#[test]
fn loads_of_contacts_are_seen_along_the_turned_axis() {
    let surface = Surface::of(&scene());
    let mut seal = seal(Law::default(), None);
    // The carrier lies on its side: its y axis along the world's x.
    let half = 0.5f64.sqrt();
    let body =
        BodyState { orientation: [0.0, 0.0, -half, half], ..BodyState::at_rest(0, [0.0; 3]) };
    let frame = Frame::of(&Pose { position: [0.0; 3], orientation: body.orientation });
    let towards = frame.turn_to_world([0.0, 1.0, 0.0]);
    seal.begin_window(std::iter::empty());
    seal.begin_substep(&body);
    let force = (towards * 7.0).into();
    let load = FacetLoad { facet: 3, force, stiffness: 1.0, ..FacetLoad::default() };
    assert_eq!(surface.kinds[3], FacetKind::Seat);
    while !seal.pass([load].into_iter()).unwrap() {}
    let found = seal.readings();
    assert!((found.force - 7.0).abs() < 1e-12, "{found:?}");
    // On one of 24 facets of the foot.
    let facet = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2)) / 24.0;
    assert!((found.seat_pressure * 24.0 * facet / 7.0 - 1.0).abs() < 1e-9);
    assert!(found.peak_seat_pressure > found.seat_pressure * 12.0, "{found:?}");
}

#[test]
fn a_seal_in_a_fluid_feels_its_impedance() {
    let water = Water { density: 1000.0, sound_speed: 2500.0, added_mass: None, exchange: 1.2e-7 };
    let wet = seal(Law::default(), Some(water));
    let area = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2));
    let expected = 2.5e6 * area + 1000.0 * area.powf(1.5) / 1.2e-7;
    let [free, seated] = wet.impedance();
    assert!((free.0 / expected - 1.0).abs() < 1e-12);
    assert!((seated.0 / (2.5e6 * area) - 1.0).abs() < 1e-12);
    // The valve of the prototype: 617 N s/m, and 4 g of added mass chosen by hand.
    assert!(
        (2.5e6 * area / 617.0 - 1.0).abs() < 0.01 && (1e3 * area.powf(1.5) - 3.9e-3).abs() < 1e-4
    );
    let rate = |force: f64, touching: u64| {
        let mut seal = wet.clone();
        let push = |facet: u64, force: f64, stiffness: f64| FacetLoad {
            facet,
            force: [0.0, force, 0.0],
            stiffness,
            ..FacetLoad::default()
        };
        // By the fluid where nothing touches.
        let of_fluid = (touching == 0).then(|| push(0, force, 0.0));
        seal.begin_window(of_fluid.into_iter());
        seal.begin_substep(&carrier(0.0));
        let share = force / touching.max(1) as f64;
        while !seal.pass((0..touching).map(|facet| push(facet, share, 1e4))).unwrap() {}
        seal.readings().rate
    };
    // From rest: (nu + Z + h' dt) d' = F. On its seat without the mass; one of the foot's twelve
    // sectors keeps the fluid off that much of it.
    let seated = 2.5e6 * area;
    let one = expected + (seated - expected) / 12.0;
    for (touching, z) in [(0, expected), (2, one), (24, seated)] {
        let law = 5.0 / (80.0 + z + SLOPE * DT);
        assert!((rate(5.0, touching) / law - 1.0).abs() < 1e-6, "{touching}");
    }
}

/// A seal that rests on a seat, in a fluid that answers a window late: its side bulges by part of
/// its rate, against plane waves. What shakes it dies away; without impedance it grows, because
/// within a step the seat's 1e7 N/m are 5 N s/m only, less than the 123 N s/m of the side, as are
/// the rubber's 80.
#[test]
fn a_seal_on_its_seat_is_stable_in_a_fluid_that_answers_late() {
    const WINDOW: f64 = 4.8e-7;
    let area = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2));
    let side = 0.4 * 1e3 * 1250.0 * area;
    let water = Water { density: 1e3, sound_speed: 1250.0, added_mass: None, exchange: WINDOW };
    // Largest rate in the first and the last hundred windows.
    let shaken = |water: Option<Water>, substeps: u32| {
        let dt = WINDOW / f64::from(substeps);
        let mut seal = Seal::new(&scene(), ring(), Law::default(), Form::Axial, water, dt).unwrap();
        let surface = Surface::of(&scene());
        assert_eq!(surface.kinds[0], FacetKind::Seat);
        let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
        let (mut rates, mut rate) = ([0.0f64; 2], 0.0f64);
        for window in 0..3000 {
            // The carrier lies still, the seat is 0.2 mm above the foot at rest. A knock at the
            // start.
            let knock = if window < 20 { 5.0 } else { 0.0 };
            let force = [0.0, knock - side * rate, 0.0];
            let facet = FacetLoad { facet: 0, force, ..FacetLoad::default() };
            seal.begin_window([facet].into_iter());
            let before = seal.readings().compression;
            for _ in 0..substeps {
                seal.begin_substep(&carrier(0.0));
                loop {
                    seal.write(&mut vertices);
                    // Twelve springs of 1e7 N/m in all.
                    let depth = 2e-4 - (vertices[0].position[1] + 3e-3);
                    let load = |sector: u64| FacetLoad {
                        facet: 2 * sector,
                        force: [0.0, 1e7 / 12.0 * depth.max(0.0), 0.0],
                        stiffness: 1e7 / 12.0,
                        ..FacetLoad::default()
                    };
                    match seal.pass((0..12).map(load)) {
                        Ok(true) => break,
                        Ok(false) => {}
                        // Beyond the table.
                        Err(_) => return [rates[0], f64::INFINITY],
                    }
                }
            }
            rate = (seal.readings().compression - before) / WINDOW;
            let rate = rate.abs();
            if window < 100 {
                rates[0] = rates[0].max(rate);
            } else if window >= 2900 {
                rates[1] = rates[1].max(rate);
            }
        }
        rates
    };
    let firsts = [1, 10].map(|substeps| {
        let [first, last] = shaken(Some(water), substeps);
        println!("with impedance {first:.2e} m/s, at last {last:.2e} m/s");
        assert!(first > 1e-3 && last < 1e-3 * first, "{substeps}: {first} {last}");
        first
    });
    // However many substeps a window has: the fluid answers windows.
    assert!((firsts[1] / firsts[0] - 1.0).abs() < 0.05, "{firsts:?}");
    let [first, last] = shaken(None, 1);
    println!("without {first:.2e} m/s, at last {last:.2e} m/s");
    assert!(last > 10.0 * first, "{first} {last}");
}

/// A seal that begins compressed is where its table says, and stays there under the force of the
/// table.
#[test]
fn a_seal_begins_as_compressed_as_the_scene_says() {
    let mut scene = scene();
    let table = ring();
    let at = table.bracket(0.45e-3).unwrap();
    let section = table.vertices(at);
    let points = table.outline().vertices.iter().map(|vertex| section[*vertex]).collect();
    scene.start = SurfaceStart { compression: 0.45e-3, points };
    let mut seal = Seal::new(&scene, ring(), Law::default(), Form::Axial, None, DT).unwrap();
    seal.follow(&carrier(0.0));
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    seal.write(&mut vertices);
    // The foot is 3 mm below the carrier's origin when it is not compressed.
    assert!((vertices[0].position[1] - (0.45e-3 - 3e-3)).abs() < 1e-15);
    assert_eq!(vertices[0].velocity, [0.0, -0.2, 0.0]);
    let force = seal.readings().table_force;
    assert!((force / (SLOPE * 0.45e-3) - 1.0).abs() < 1e-12 && seal.readings().rate == 0.0);
    seal.begin_window(std::iter::empty());
    seal.begin_substep(&carrier(0.0));
    let load =
        FacetLoad { facet: 0, force: [0.0, force, 0.0], stiffness: 1e5, ..FacetLoad::default() };
    while !seal.pass([load].into_iter()).unwrap() {}
    assert!((seal.readings().compression - 0.45e-3).abs() < 1e-12);
    scene.start.compression = 0.7e-3;
    let error = Seal::new(&scene, ring(), Law::default(), Form::Axial, None, DT).unwrap_err();
    assert!(error.to_string().contains("\"ring\""), "{error}");
}

#[test]
fn what_cannot_go_on_is_said_with_the_seals_name() {
    let mut other = scene();
    other.section.points[0][0] += 1e-9;
    let error = Seal::new(&other, ring(), Law::default(), Form::Axial, None, DT).unwrap_err();
    assert!(matches!(error, SealError::OtherTable { .. }), "{error}");
    assert!(error.to_string().contains("ring.json"), "{error}");
    let mut seal = seal(Law { damping: 1e-3, ..Law::default() }, None);
    seal.begin_window(std::iter::empty());
    seal.begin_substep(&carrier(0.0));
    let load = FacetLoad { facet: 0, force: [0.0, 1e6, 0.0], ..FacetLoad::default() };
    let error = loop {
        if let Err(error) = seal.pass([load].into_iter()) {
            break error;
        }
    };
    assert!(matches!(error, SealError::Step { error: StepError::Beyond(_), .. }), "{error}");
    assert!(error.to_string().contains("\"ring\"") && error.to_string().contains("table"));
}
