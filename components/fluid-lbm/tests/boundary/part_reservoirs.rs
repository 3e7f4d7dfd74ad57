//! Reservoirs behind the surfaces of parts, square to the cells and aslant: flow, mass, sound, stability.

use crate::common::only_reservoir as state;
use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid};
use tremie_messages::scene::{Course, Face, Geometry, Outflow, PartBoundary, Reservoir, Scene};

const OUTLET: Face =
    Face::Pressure { pressure: 0.0, course: Course::CONSTANT, outflow: Outflow::Fixed };

/// A duct along x of 60 x 12 x 6 cells, its sides periodic along z and walls or periodic along y, that a
/// wedge closes at the lower end: its face is at x = 8 in the middle and turned by an angle about z.
struct Duct {
    tau: f64,
    angle: f64,
    sides: Face,
    end: Face,
}

/// Height of the duct.
const HEIGHT: f64 = 12.0;
/// Its depth.
const DEPTH: f64 = 6.0;

impl Duct {
    /// Area of the wedge's face.
    fn area(&self) -> f64 {
        HEIGHT * DEPTH / self.angle.cos()
    }

    fn scene(&self, reservoir: Reservoir) -> (Case, Scene) {
        let mut case =
            Case::new([60, HEIGHT as usize, DEPTH as usize], [WALL, WALL, PERIODIC], self.tau);
        case.faces[1] = self.sides.clone();
        case.collision = Collision::Bgk;
        case.smagorinsky = if self.tau < 0.5005 { 0.4 } else { 0.0 };
        let mut scene = case.scene();
        scene.domain.faces[0][1] = self.end.clone();
        let reach = 0.5 * HEIGHT + 2.0;
        let at = |y: f64| 8.0 + y * self.angle.tan();
        let outline = vec![[-4.0, -reach], [at(-reach), -reach], [at(reach), reach], [-4.0, reach]];
        let wedge = Geometry::Extruded { outline, axis: 2, length: 3.0 * DEPTH };
        let mut wedge = part("feed", wedge, [0.0, 0.5 * HEIGHT, 0.5 * DEPTH]);
        wedge.boundary = PartBoundary::Reservoir(reservoir);
        scene.parts.push(wedge);
        (case, scene)
    }

    /// With a reservoir that is `length` cells long at the start.
    fn fluid(&self, length: f64, choose: impl Fn(&mut Reservoir)) -> LbmFluid {
        let mut reservoir = Reservoir::new(self.area(), self.area() * length, 0.0);
        choose(&mut reservoir);
        let (case, scene) = self.scene(reservoir);
        case.fluid_of(&scene)
    }
}

/// Flow along x through the duct at a place.
fn flow(fluid: &LbmFluid, x: usize) -> f64 {
    let [_, ny, nz] = fluid.cells();
    let across = (0..ny * nz).map(|k| [x, k % ny, k / ny]);
    across.map(|cell| fluid.velocity_at(cell)[0]).sum()
}

/// Whatever way the surface looks, what the piston displaces passes the duct, within 0.5 %. Reservoir and
/// domain keep their mass to rounding.
#[test]
fn a_piston_behind_a_slanted_surface_feeds_a_duct() {
    for degrees in [0.0_f64, 14.0, 30.0, 45.0] {
        let duct = Duct { tau: 0.6, angle: degrees.to_radians(), sides: WALL, end: OUTLET };
        let speed = 2e-3;
        let mut fluid = duct.fluid(200.0, |r| {
            (r.piston, r.course) = (speed, ramp(1000.0));
        });
        let total = |fluid: &LbmFluid| fluid.ledger().mass + state(fluid).mass;
        let (mut gone, before) = (0.0, total(&fluid));
        let (mut mean, mut steps) = (0.0, 0.0);
        for step in 0..16_000 {
            fluid.step(&[], &mut []).unwrap();
            closes(&fluid, 1e-11);
            gone -= fluid.ledger().mass_open;
            if step >= 10_000 {
                (mean, steps) = (mean + flow(&fluid, 40), steps + 1.0);
            }
        }
        let error = mean / steps / (speed * duct.area()) - 1.0;
        let lost = (total(&fluid) + gone) / before - 1.0;
        println!("{degrees} degrees: flow {error:+.2e}, mass {lost:+.1e}");
        assert!(error.abs() < 0.005, "{degrees}: {error}");
        assert!(lost.abs() < 1e-11, "{degrees}: {lost}");
    }
}

/// A closed duct that a slow piston compresses has the density of all that is left, within 1e-3 of the
/// compression.
#[test]
fn a_slow_piston_behind_a_slanted_surface_compresses_a_closed_duct() {
    let duct = Duct { tau: 1.0, angle: 0.5, sides: WALL, end: WALL };
    let (length, speed) = (83.0, 1e-4);
    let mut fluid = duct.fluid(length, |r| {
        (r.piston, r.course) = (speed, ramp(20_000.0));
    });
    let [inside, reservoir] = [fluid.ledger().mass, state(&fluid).mass];
    for _ in 0..60_000 {
        fluid.step(&[], &mut []).unwrap();
    }
    let gone = reservoir * speed * 50_000.0 / length;
    let expected = (inside + reservoir) / (inside + reservoir - gone) - 1.0;
    let last = state(&fluid);
    let error = (last.density - 1.0) / expected - 1.0;
    println!("compressed by {expected}: {error:e}");
    assert!(expected > 0.02 && error.abs() < 1e-3, "{error}");
}

/// A short reservoir of nearly inviscid fluid, square and aslant, with the closure of the valve: the flow
/// comes to the piston's speed, and nothing grows. No cell is faster than four times the piston. (With a
/// closure of a sixteenth the jets of such a duct run wild behind a face with a velocity, too.)
#[test]
fn a_surface_is_stable_where_viscosity_is_next_to_none() {
    for degrees in [0.0_f64, 30.0] {
        let duct = Duct { tau: 0.500_004, angle: degrees.to_radians(), sides: WALL, end: OUTLET };
        let speed = 7.2e-4;
        let mut fluid = duct.fluid(83.0, |r| {
            (r.piston, r.course) = (speed, ramp(5000.0));
        });
        let mut mean = 0.0;
        for step in 0..20_000 {
            fluid.step(&[], &mut []).unwrap();
            if step >= 10_000 {
                mean += state(&fluid).velocity / 10_000.0;
            }
        }
        let fastest = fluid.diagnostics().max_speed;
        println!("{degrees} degrees: {}, fastest {}", mean / speed, fastest / speed);
        assert!((mean / speed - 1.0).abs() < 0.02, "{degrees}: {mean}");
        assert!(fastest < 4.0 * speed, "{degrees}: {fastest}");
    }
}

/// The same reservoir behind a face and behind a box that ends there half-way between cells: the same
/// steady flow and pressure, within 2 %.
#[test]
fn a_square_surface_is_like_a_face() {
    let piston = |r: &mut Reservoir| (r.piston, r.course) = (2e-3, ramp(1000.0));
    let duct = Duct { tau: 0.8, angle: 0.0, sides: WALL, end: OUTLET };
    let mut of_part = duct.fluid(100.0, piston);
    let mut reservoir = Reservoir::new(duct.area(), duct.area() * 100.0, 0.0);
    piston(&mut reservoir);
    let (mut case, mut scene) = duct.scene(reservoir.clone());
    scene.parts.clear();
    case.cells[0] = 52;
    scene.domain.max[0] = 52.0;
    scene.domain.faces[0][0] = Face::Reservoir(reservoir);
    let mut of_face = case.fluid_of(&scene);
    for _ in 0..8000 {
        of_part.step(&[], &mut []).unwrap();
        of_face.step(&[], &mut []).unwrap();
    }
    let [part, face] = [state(&of_part), state(&of_face)];
    println!("{part:?}\n{face:?}");
    assert!((part.velocity / face.velocity - 1.0).abs() < 0.02);
    assert!((part.pressure / face.pressure - 1.0).abs() < 0.02);
}

/// A part that the fluid touches on both sides has no one way to look; nor has a ball.
#[test]
fn a_surface_that_looks_several_ways_is_refused() {
    let duct = Duct { tau: 0.8, angle: 0.0, sides: WALL, end: OUTLET };
    let (case, scene) = duct.scene(Reservoir::new(72.0, 720.0, 0.0));
    for geometry in [Geometry::Sphere { radius: 2.2 }, Geometry::Box { size: [3.0, 20.0, 20.0] }] {
        let mut scene = scene.clone();
        scene.parts[0].geometry = geometry;
        scene.parts[0].pose.position = [30.0, 6.0, 3.0];
        let problems = case.parameters().resolve(&scene).unwrap_err();
        let text = problems[0].to_string();
        assert!(text.contains("scene.parts[0].boundary") && text.contains("one way"), "{text}");
    }
}
