//! A fluid that goes on from the file of a state ends with the bits of one that was never
//! interrupted, and tells the same on its way.

#[path = "common/mod.rs"]
mod common;

use common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{Collision, LbmFluid, OpenFaces, Precision, Refill};
use tremie_geometry::Turned;
use tremie_messages::scene::{
    BodySet, Course, Diameters, Face, Gap, GapRegion, GapRule, GapSide, GapWeight, Geometry, Inlet,
    InletVelocity, Motion, OpenVelocity, Outflow, Placement, Probe, ProbeShape, Profile, Reservoir,
    Scene, Shape, Sphere,
};
use tremie_messages::{BodyEvent, BodyState, FacetLoad, Load, SurfaceVertex};
use tremie_state::{SavedState, StateError};
use tremie_test_support::through_a_file;

/// A scene with bodies that come, move and go by the clock.
struct Story {
    case: Case,
    scene: Scene,
    bodies: Vec<Guest>,
    /// Step from which on all bodies stand still.
    rest: u64,
    ring: Option<Ring>,
}

/// A ring of rubber that its carrier lifts, and whose foot widens.
struct Ring {
    turned: Turned,
    points: Vec<[f64; 2]>,
    at: [f64; 3],
}

impl Ring {
    fn vertices(&self, step: u64) -> Vec<SurfaceVertex> {
        let (time, [x0, y0, z0]) = (step as f64, self.at);
        let vertex = |[x, y, z]: [f64; 3]| {
            let rate = 2e-3 * (1.6 - z) / 3.5;
            let wider = 1.0 + rate * time;
            SurfaceVertex {
                position: [x0 + wider * x, y0 + wider * y, z0 + z + 0.02 * time],
                velocity: [rate * x, rate * y, 0.02],
            }
        };
        self.turned.places(&self.points).into_iter().map(|place| vertex(place.into())).collect()
    }
}

/// A body.
struct Guest {
    event: BodyEvent,
    /// Steps in which it comes and goes.
    steps: [u64; 2],
    at: [f64; 3],
    /// Velocity, of which a half swings with a period of 40 steps; and angular velocity.
    velocity: [f64; 3],
    spin: [f64; 3],
}

impl Guest {
    fn new(event: BodyEvent, at: [f64; 3], velocity: [f64; 3]) -> Self {
        Self { event, steps: [0, u64::MAX], at, velocity, spin: [0.0; 3] }
    }

    fn is_there(&self, step: u64) -> bool {
        (self.steps[0]..self.steps[1]).contains(&step)
    }

    fn state(&self, step: u64) -> BodyState {
        let (time, swing) = (step as f64, 2.0 * PI / 40.0);
        let way = 0.5 * time + 0.5 * (1.0 - (swing * time).cos()) / swing;
        let speed = 0.5 + 0.5 * (swing * time).sin();
        let [x, y, z] = self.spin.map(|w| 0.5 * w * time);
        let half = norm([x, y, z]);
        let part = if half > 0.0 { half.sin() / half } else { 0.0 };
        BodyState {
            orientation: [x * part, y * part, z * part, half.cos()],
            velocity: self.velocity.map(|v| v * speed),
            angular_velocity: self.spin,
            ..BodyState::at_rest(
                self.event.id,
                std::array::from_fn(|a| self.at[a] + self.velocity[a] * way),
            )
        }
    }
}

impl Story {
    fn begin(&self, threads: usize) -> LbmFluid {
        Case { threads, ..self.case.clone() }.fluid_of(&self.scene)
    }

    /// Goes through steps; what the fluid tells at the end of each.
    fn go(&self, fluid: &mut LbmFluid, steps: std::ops::RangeInclusive<u64>) -> Vec<Vec<u64>> {
        let mut all = Vec::new();
        for step in steps {
            let mut events = Vec::new();
            for guest in &self.bodies {
                match guest.steps {
                    [first, _] if first == step => events.push(guest.event),
                    [_, last] if last == step => events.push(removed(guest.event.id)),
                    _ => {}
                }
            }
            fluid.apply_events(&events).unwrap();
            if let Some(ring) = &self.ring {
                fluid.set_surfaces(&ring.vertices(step.min(self.rest))).unwrap();
            }
            let there = self.bodies.iter().filter(|guest| guest.is_there(step));
            let mut states: Vec<_> = there.map(|guest| guest.state(step.min(self.rest))).collect();
            if step > self.rest {
                states.iter_mut().for_each(|body| body.velocity = [0.0; 3]);
            }
            let mut loads = loads_of(&states);
            if step == 0 {
                fluid.start(&states, &mut loads).unwrap();
            } else {
                fluid.step(&states, &mut loads).unwrap();
            }
            assert!(fluid.diagnostics().max_mach < 0.3, "step {step}");
            let mut told = bits(loads);
            told.extend(self.report(fluid));
            all.push(told);
            if step % 8 == 7 {
                fluid.restart_means();
            }
        }
        all
    }

    /// All that the fluid tells after a step.
    fn report(&self, fluid: &mut LbmFluid) -> Vec<u64> {
        let mut on_parts = Vec::new();
        fluid.loads_on_parts(&mut on_parts);
        let mut told = bits(on_parts);
        let mut values: Vec<f64> = fluid.wall_forces().into_iter().flatten().flatten().collect();
        fluid.probes(&mut values);
        values.extend(fluid.ports().iter().map(|port| port.velocity));
        let mut reservoirs = Vec::new();
        fluid.reservoirs(&mut reservoirs);
        values.extend(reservoirs.iter().flat_map(|reservoir| reservoir.values()));
        let facets = self.ring.as_ref().map_or(0, |ring| ring.turned.triangles.len());
        let mut on_facets = vec![FacetLoad::default(); facets];
        fluid.surface_loads(&mut on_facets);
        values.extend(on_facets.iter().flat_map(|load| load.force.into_iter().chain(load.point)));
        told.extend(values.into_iter().map(f64::to_bits));
        // These print as many digits as tell them apart.
        let counts = format!("{:?} {:?}", fluid.ledger(), fluid.diagnostics());
        told.extend(counts.bytes().map(u64::from));
        told
    }

    /// Stops after some steps and goes on from the file, to the last step.
    fn check(&self, stops: &[u64], last: u64) {
        let mut whole = self.begin(1);
        let expected = self.go(&mut whole, 0..=last);
        let ended = SavedState::of(&mut whole).unwrap();
        for &stop in stops {
            let mut first = self.begin(1);
            self.go(&mut first, 0..=stop);
            let mut second = self.begin(2);
            through_a_file(&mut first, &mut second);
            assert!(self.report(&mut second) == self.report(&mut first), "at step {stop}");
            let again = SavedState::of(&mut second).unwrap();
            let kept = SavedState::of(&mut first).unwrap();
            assert_eq!(again.first_difference(&kept), None, "at step {stop}");
            let told = self.go(&mut second, stop + 1..=last);
            let differs = told.iter().zip(&expected[stop as usize + 1..]).position(|(a, b)| a != b);
            assert_eq!(differs, None, "steps after step {stop}");
            let now = SavedState::of(&mut second).unwrap();
            assert_eq!(now.first_difference(&ended), None, "from step {stop}");
        }
    }
}

fn bits(loads: Vec<Load>) -> Vec<u64> {
    loads
        .iter()
        .flat_map(|load| load.force.into_iter().chain(load.torque))
        .map(f64::to_bits)
        .collect()
}

fn probe(name: &str, shape: ProbeShape) -> Probe {
    Probe { name: name.into(), shape }
}

fn moving(name: &str, geometry: Geometry) -> tremie_messages::scene::Part {
    let mut moving = part(name, geometry, [0.0; 3]);
    moving.motion = Motion::Prescribed(Vec::new());
    moving
}

fn pressure(pressure: f64, outflow: Outflow) -> Face {
    Face::Pressure { pressure, course: Course::default(), outflow }
}

/// A channel with an inlet and all kinds of outlets, a lid that slides, a rod and a stirrer, grains
/// of which one goes round through the periodic faces, sections, large eddies, and an inlet of
/// grains that looks at the flow.
fn channel(precision: Precision) -> Story {
    let mut case = Case::new([37, 20, 14], [WALL, WALL, PERIODIC], 0.62);
    case.precision = precision;
    case.average_force = true;
    case.acceleration = [2e-5, 0.0, -1e-5];
    case.gravity = [0.0, -1e-4, 0.0];
    case.velocity = [0.02, 0.0, 0.01];
    case.lid = (1, [0.02, 0.0, 0.01]);
    case.smagorinsky = 0.15;
    let mut scene = case.scene();
    let course = Course::Points(vec![[0.0, 0.5], [30.0, 1.0], [60.0, 0.7]]);
    let velocity = [0.02, 0.0, 0.0];
    scene.domain.faces[0] = [
        Face::Velocity(OpenVelocity { velocity, profile: Profile::Parabolic, course }),
        pressure(0.0, Outflow::Absorbing),
    ];
    scene.domain.faces[1][0] = pressure(1e-4, Outflow::Convective);
    let rod = Geometry::Cylinder { radius: 3.1, length: 40.0 };
    scene.parts.push(part("rod", rod, [26.2, 10.3, 9.0]));
    scene.parts.push(moving("stirrer", Geometry::Box { size: [4.2, 1.3, 2.2] }));
    let max = [37.0, 20.0, 14.0];
    let section = |axis, position| ProbeShape::Section { axis, position, min: [0.0; 3], max };
    scene.probes.push(probe("middle", section(0, 18.2)));
    scene.probes.push(probe("height", section(1, 7.0)));
    scene.probes.push(probe("part", ProbeShape::Region { min: [5.0; 3], max: [9.0; 3] }));
    let diameters = Diameters::Uniform { min: 1.0, max: 1.0 };
    let velocity = InletVelocity::Face { axis: 0, side: 0 };
    scene.inlets.push(Inlet {
        name: "feed".into(),
        bodies: "grains".into(),
        min: [0.0; 3],
        max: [1.0; 3],
        fraction: 0.1,
        diameters,
        every: None,
        velocity,
        until: None,
        seed: 1,
        tries: 1,
    });
    let mut bodies: Vec<_> = (0..6)
        .map(|id| {
            let k = id as f64;
            let at = [4.0 + 3.9 * k, 5.0 + (id * 7 % 10) as f64, 0.4 + 2.0 * k];
            let radius = 1.2 + 0.3 * k;
            let spin = [0.0, 0.003 * k, 0.001];
            Guest { spin, ..Guest::new(added(id, radius), at, [0.03, 0.02, -0.03]) }
        })
        .collect();
    let stirrer = Guest::new(added_part(100, 1), [17.3, 6.2, 7.1], [0.03, 0.02, 0.0]);
    bodies.push(Guest { spin: [0.0, 0.01, 0.03], ..stirrer });
    // One goes, and others come before and after the stops.
    bodies[2].steps = [0, 9];
    for (id, steps) in [(6, [12, 40]), (7, [31, u64::MAX])] {
        let at = [11.0 + 8.0 * (id - 6) as f64, 14.2, 3.3];
        bodies.insert(
            id,
            Guest { steps, ..Guest::new(added(id as u64, 1.7), at, [0.0, 0.01, 0.02]) },
        );
    }
    Story { case, scene, bodies, rest: u64::MAX, ring: None }
}

#[test]
fn a_channel_in_f64() {
    channel(Precision::F64).check(&[0, 1, 20, 33], 48);
}

#[test]
fn a_channel_in_f32() {
    channel(Precision::F32).check(&[0, 17], 36);
}

/// Grains and a cube that close up in a corner of a box, where cells are pinched and isolated, and
/// gaps press; a pair of grains displaces its shares of a union.
fn heap() -> Story {
    let mut case = Case::new([26, 22, 20], [SYMMETRY, WALL, WALL], 0.7);
    case.velocity = [2e-3, 1e-3, -2e-3];
    case.gravity = [0.0, 0.0, -1e-4];
    case.refill = Refill::Mass;
    let mut scene = case.scene();
    let corner = |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { 3.0 } else { -3.0 });
    scene.shapes.push(Shape { name: "cube".into(), vertices: (0..8).map(corner).collect() });
    let ball = |x: f64| Sphere {
        position: [x, 7.0, 11.0],
        diameter: 6.0,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
    };
    scene.bodies.push(BodySet {
        name: "pair".into(),
        density: 2.0,
        material: "pair".into(),
        motion: Motion::Free,
        clump: Some("pair".into()),
        placement: Placement::Listed(vec![ball(15.0), ball(18.0)]),
    });
    scene.unions.push("pair".into());
    let down = [0.0, 0.0, -0.02];
    let edge = 5.5 * (PI / 6.0).cbrt();
    let size = [0.5 * 3f64.sqrt() * edge, 5.5, 0.0];
    let cube = BodyEvent { shape: BodyEvent::POLYHEDRON, size, ..added(4, 0.0) };
    let other_set = |id| BodyEvent { set: 1, ..added(id, 4.0) };
    let mut bodies = vec![
        Guest::new(added(0, 3.0), [15.0, 7.0, 11.0], down),
        Guest::new(added(1, 3.0), [18.0, 7.0, 11.0], down),
        Guest::new(other_set(2), [3.6, 4.2, 5.4], down),
        Guest::new(other_set(3), [4.1, 12.5, 6.0], [0.0, -0.004, -0.02]),
        Guest::new(cube, [12.2, 12.7, 8.0], [-0.03, -0.02, -0.02]),
        Guest::new(other_set(5), [5.2, 8.1, 13.8], [0.0, 0.0, -0.03]),
        Guest { steps: [10, 30], ..Guest::new(other_set(6), [20.5, 17.0, 15.0], down) },
    ];
    bodies[0].spin = [0.0, 0.004, 0.0];
    bodies[1].spin = [0.0, 0.004, 0.0];
    bodies[4].spin = [0.003, 0.0, 0.002];
    Story { case, scene, bodies, rest: 61, ring: None }
}

#[test]
fn a_heap_of_grains() {
    heap().check(&[0, 1, 29, 64], 90);
}

/// A tube of large eddies behind a piston and up to an orifice, with another reservoir that keeps
/// no mass; grains come in the middle of the run, whose room goes back to the reservoirs.
fn behind_pistons() -> Story {
    let mut case = Case::new([24, 10, 10], [WALL; 3], 0.52);
    case.collision = Collision::Bgk;
    case.refill = Refill::Mass;
    case.open_faces = OpenFaces::Nebb;
    case.smagorinsky = 0.1;
    let mut scene = case.scene();
    let point = |k: u32| [f64::from(k), 0.5 * (1.0 - (PI * f64::from(k) / 20.0).cos())];
    let mut piston = Reservoir::new(100.0, 1200.0, 8e-3);
    piston.course = Course::Points((0..=20).map(point).collect());
    let mut other = Reservoir::new(100.0, 900.0, 2e-3);
    other.mode = tremie_messages::scene::ReservoirMode::Mk;
    scene.domain.faces[0] = [Face::Reservoir(piston), pressure(0.0, Outflow::Fixed)];
    scene.domain.faces[1][1] = Face::Reservoir(other);
    scene.parts.push(part("sill", Geometry::Box { size: [3.0, 5.0, 12.0] }, [14.0, 2.0, 5.0]));
    let bodies = vec![
        Guest::new(added(1, 2.2), [6.3, 4.4, 5.1], [0.05, 0.02, 0.0]),
        Guest { steps: [7, 60], ..Guest::new(added(2, 1.9), [3.3, 6.4, 6.1], [0.04, 0.0, 0.01]) },
        Guest { steps: [26, 60], ..Guest::new(added(3, 1.9), [18.3, 6.4, 4.1], [0.02, 0.0, 0.0]) },
    ];
    Story { case, scene, bodies, rest: u64::MAX, ring: None }
}

#[test]
fn fluid_behind_pistons() {
    behind_pistons().check(&[0, 1, 22, 25], 40);
}

/// A plate over a slot between two chambers, whose pressures act in it, and grains near by. The
/// plate begins at a height and moves on. The slot's middle may be left out, and be a pocket while
/// the rest is shut; its walls may slip.
fn slot(
    [height, speed]: [f64; 2],
    rule: GapRule,
    slip_below: f64,
    radii: Option<[f64; 2]>,
) -> Story {
    let mut case = Case::new([32, 8, 12], [WALL, SYMMETRY, WALL], 0.504);
    case.refill = Refill::Mass;
    case.average_force = true;
    case.smagorinsky = 0.2;
    let mut scene = case.scene();
    scene.domain.faces[0] = [pressure(3e-4, Outflow::Absorbing), pressure(0.0, Outflow::Absorbing)];
    let size = [12.0, 20.0, 16.0];
    scene.parts.push(moving("plate", Geometry::Box { size }));
    for (name, x) in [("before", 3.0), ("behind", 29.0)] {
        scene.probes.push(probe(name, ProbeShape::Point([x, 2.0, 6.0])));
    }
    scene.gaps.push(Gap {
        name: "slot".into(),
        between: [GapSide::Part("plate".into()), GapSide::Face { axis: 2, side: 0 }],
        open_at: 1.5,
        close_at: 0.5,
        pressure: rule,
        slip_below,
        region: radii.map(|radii| GapRegion::Ring { axis: 1, through: [16.0, 0.0, 0.0], radii }),
    });
    let plate = Guest::new(added_part(9, 0), [16.0, 4.0, 8.0 + height], [0.0, 0.0, speed]);
    let bodies = vec![
        Guest::new(added(1, 1.3), [8.2, 4.4, 3.1], [0.05, 0.0, -0.02]),
        Guest::new(added(2, 1.3), [24.2, 3.3, 2.6], [-0.06, 0.01, 0.0]),
        Guest { spin: [0.0, 3e-4, 0.0], ..plate },
    ];
    Story { case, scene, bodies, rest: u64::MAX, ring: None }
}

/// Numbers of frozen cells after each step.
fn frozen(story: &Story, steps: u64) -> Vec<usize> {
    let mut fluid = story.begin(1);
    let after = |step| {
        story.go(&mut fluid, step..=step);
        fluid.diagnostics().frozen
    };
    (0..=steps).map(after).collect()
}

const MIDDLE: [f64; 2] = [3.1, 20.0];

#[test]
fn a_slot_that_opens() {
    let weight = |(probe, weight): (&str, f64)| GapWeight { probe: probe.into(), weight };
    let probes = [("before", 0.7), ("behind", 0.3)].map(weight).to_vec();
    let up = [0.9, 0.02];
    let of_probes = slot(up, GapRule::Probes(probes), 4.0, None);
    of_probes.check(&[0, 1, 30, 73], 80);
    let with_pocket = slot(up, GapRule::Nearest, 0.0, Some(MIDDLE));
    with_pocket.check(&[30], 70);
    for story in [of_probes, with_pocket] {
        let frozen = frozen(&story, 73);
        assert!(frozen[30] == 12 * 8 && frozen[73] == 0, "{frozen:?}");
    }
}

#[test]
fn a_slot_that_stays_shut() {
    let mut story = slot([0.9, 0.02], GapRule::Nearest, 0.0, Some(MIDDLE));
    story.rest = 28;
    story.check(&[1, 29], 40);
    assert!(frozen(&story, 40)[29..].iter().all(|&cells| cells == 12 * 8));
}

/// It stays open down to half a cell.
#[test]
fn a_slot_that_closes() {
    let story = slot([1.6, -0.02], GapRule::Zero, 0.0, None);
    story.check(&[40], 80);
    let frozen = frozen(&story, 80);
    assert!(frozen[45] == 0, "{frozen:?}");
}

/// A ring on its carrier over a floor, in whose gap walls slip, and a sphere that nearly touches it.
fn ring() -> Story {
    let mut case = Case::new([26, 26, 16], [WALL, WALL, WALL], 0.51);
    case.average_force = true;
    case.refill = Refill::Mass;
    case.velocity = [0.01, 0.005, 0.0];
    let mut scene = case.scene();
    scene.parts.push(moving("carrier", Geometry::Cylinder { radius: 8.1, length: 3.0 }));
    let points = vec![[4.0, -1.7], [8.2, -1.9], [8.0, 1.6], [4.2, 1.6]];
    let surface = seal(&points);
    let turned = Turned::of(&surface);
    scene.surfaces.push(surface);
    scene.gaps.push(Gap {
        name: "foot".into(),
        between: [GapSide::Part("seal".into()), GapSide::Face { axis: 2, side: 0 }],
        open_at: 2.0,
        close_at: 0.5,
        pressure: GapRule::Nearest,
        slip_below: 4.0,
        region: None,
    });
    let bodies = vec![
        Guest::new(added_part(1, 0), [13.0, 13.0, 6.7], [0.0, 0.0, 0.02]),
        Guest::new(added(5, 2.0), [23.2, 13.0, 4.0], [-0.01, 0.0, 0.0]),
        Guest { steps: [10, 30], ..Guest::new(added(6, 1.5), [13.0, 13.0, 3.0], [0.0, 0.01, 0.0]) },
    ];
    let ring = Some(Ring { turned, points, at: [13.0, 13.0, 3.6] });
    Story { case, scene, bodies, rest: 62, ring }
}

#[test]
fn a_ring_that_deforms() {
    let story = ring();
    story.check(&[0, 17, 64], 70);
    let frozen = frozen(&story, 30);
    assert!(frozen[0] > 0 && frozen[30] == 0, "{frozen:?}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let story = channel(Precision::F64);
    let mut fluid = story.begin(1);
    story.go(&mut fluid, 0..=2);
    let state = SavedState::of(&mut fluid).unwrap();
    let refused = |other: &Story| state.restore(&mut other.begin(1)).unwrap_err();
    let mut larger = channel(Precision::F64);
    larger.case.cells[0] += 8;
    larger.scene.domain.max[0] += 8.0;
    assert!(matches!(refused(&larger), StateError::Shape { .. }));
    assert!(matches!(refused(&channel(Precision::F32)), StateError::Shape { .. }));
    let mut still = channel(Precision::F64);
    still.scene.parts[1].motion = Motion::Fixed;
    assert!(refused(&still).to_string().contains("is not the scene's"));
    let mut unseen = channel(Precision::F64);
    unseen.scene.probes.pop();
    assert!(refused(&unseen).to_string().contains("other probes"));
    fluid.apply_events(&[removed(0)]).unwrap();
    assert!(SavedState::of(&mut fluid).is_err());
}
