//! Reservoirs with a piston beyond a face: mass, pressure, sound and stability against what one
//! dimension says, at each of the six faces.

use crate::common::only_reservoir as state;
use crate::common::*;
use tremie_fluid_lbm::{Collision, FluidError, LbmFluid, ReservoirState};
use tremie_messages::scene::{Course, Face, Geometry, Outflow, Reservoir, ReservoirMode, Scene};

/// A tube of `length` cells and one across, with a reservoir of `cells` cells at one end of the
/// axis.
struct Tube {
    axis: usize,
    side: usize,
    length: usize,
    width: usize,
    tau: f64,
    sides: Face,
    end: Face,
}

const OUTLET: Face =
    Face::Pressure { pressure: 0.0, course: Course::CONSTANT, outflow: Outflow::Fixed };

impl Tube {
    fn new(length: usize, tau: f64, end: Face) -> Self {
        Self { axis: 0, side: 0, length, width: 1, tau, sides: PERIODIC, end }
    }

    fn case(&self) -> (Case, Scene) {
        let mut case = Case::new([self.width; 3], [PERIODIC; 3], self.tau);
        case.cells[self.axis] = self.length;
        case.faces = [const { PERIODIC }; 3].map(|_| self.sides.clone());
        case.collision = Collision::Bgk;
        let scene = case.scene();
        (case, scene)
    }

    /// With a reservoir that is `length` cells long at the start.
    fn fluid(&self, length: f64, choose: impl Fn(&mut Reservoir)) -> LbmFluid {
        let (mut case, mut scene) = self.case();
        let area = (self.width * self.width) as f64;
        let mut reservoir = Reservoir::new(area, area * length, 0.0);
        choose(&mut reservoir);
        let faces = &mut scene.domain.faces[self.axis];
        faces[self.side] = Face::Reservoir(reservoir);
        faces[1 - self.side] = self.end.clone();
        // The closure permits the smallest relaxation times; so small, it does nothing else.
        case.smagorinsky = if self.tau < 0.5005 { 1e-6 } else { 0.0 };
        case.fluid_of(&scene)
    }
}

fn step(fluid: &mut LbmFluid) -> Result<ReservoirState, FluidError> {
    fluid.step(&[], &mut [])?;
    Ok(state(fluid))
}

/// Reservoir and domain together keep their mass: to 1e-11 of it over 1e4 steps, the piston at full
/// speed, fluid leaving through a wall-bound, sheared flow.
#[test]
fn nothing_is_lost_between_piston_and_domain() {
    let tube = Tube { width: 6, sides: WALL, ..Tube::new(20, 0.52, WALL) };
    let mut fluid = tube.fluid(30.0, |r| {
        (r.piston, r.course) = (2e-4, ramp(1000.0));
    });
    let total = |fluid: &LbmFluid| fluid.ledger().mass + state(fluid).mass;
    let before = total(&fluid);
    for _ in 0..10_000 {
        fluid.step(&[], &mut []).unwrap();
        closes(&fluid, 1e-12);
    }
    let now = state(&fluid);
    let entered = fluid.ledger().mass - 20.0 * 36.0;
    assert!(entered > 10.0 && (now.entered / entered - 1.0).abs() < 1e-10, "{now:?}");
    let error = (total(&fluid) / before - 1.0).abs();
    println!("mass: {error:e}");
    assert!(error < 1e-11, "{error:e}");
}

/// A closed column that a slow piston compresses: the density is `(V_dom + V_0)/(V_dom + V_0 - A
/// H)`, within 1e-4 of the compression, everywhere, while the piston moves.
#[test]
fn a_slow_piston_compresses_a_closed_column() {
    let (length, reservoir, speed) = (60, 83.0, 1e-4);
    let mut fluid = Tube::new(length, 1.0, WALL).fluid(reservoir, |r| {
        (r.piston, r.course) = (speed, ramp(20_000.0));
    });
    let mut last = ReservoirState::default();
    for _ in 0..80_000 {
        last = step(&mut fluid).unwrap();
    }
    let whole = length as f64 + reservoir;
    let expected = whole / (whole - speed * 70_000.0) - 1.0;
    let error = (last.density - 1.0) / expected - 1.0;
    println!("compressed by {expected}: {error:e}");
    assert!(expected > 0.05 && error.abs() < 1e-4, "{error}");
    assert!((last.volume - (reservoir - 7.0)).abs() < 1e-9, "{last:?}");
    for cell in cells(&fluid) {
        let error = 3.0 * fluid.pressure_at(cell) / expected - 1.0;
        assert!(error.abs() < 1e-4, "{cell:?}: {error}");
    }
}

/// A tube that is open at the far end passes what the piston displaces: the mean velocity at the
/// face is the piston's within 0.1 %.
#[test]
fn a_steady_flow_is_as_fast_as_the_piston() {
    let mut fluid = Tube::new(40, 0.6, OUTLET).fluid(200.0, |r| {
        (r.piston, r.course) = (2e-3, ramp(4000.0));
    });
    let mut mean = 0.0;
    for k in 0..40_000 {
        let now = step(&mut fluid).unwrap();
        if k >= 20_000 {
            mean += now.velocity / 20_000.0;
        }
    }
    println!("{}", mean / 2e-3);
    assert!((mean / 2e-3 - 1.0).abs() < 1e-3, "{mean}");
}

/// The reservoir's fluid is a spring, that of the tube a mass on it: `k L tan(k L) = L/L_v`, `T = 2
/// pi L/(k L c_s)`, the period within 0.5 %.
#[test]
fn a_tube_resonates_with_its_reservoir() {
    for reservoir in [240.0, 830.0] {
        // From the middle of the reservoir's cells to the face at the other end.
        let length = 59.5_f64;
        let ratio = length / reservoir;
        // Bisection; the left side rises from 0 to infinity.
        let (mut low, mut high) = (0.0, core::f64::consts::FRAC_PI_2);
        for _ in 0..60 {
            let kl: f64 = 0.5 * (low + high);
            if kl * kl.tan() < ratio { low = kl } else { high = kl }
        }
        let expected = core::f64::consts::TAU * length / low * 3.0_f64.sqrt();
        let mut fluid = Tube::new(60, 0.501, OUTLET).fluid(reservoir, |_| {});
        let k = low / length;
        fluid.set_state(|x| ([0.0; 3], 1e-5 * (k * (60.0 - x[0])).sin()));
        let (mut crossings, mut last) = (Vec::new(), state(&fluid).pressure);
        for step_number in 1.. {
            let now = step(&mut fluid).unwrap().pressure;
            if last > 0.0 && now <= 0.0 {
                crossings.push(f64::from(step_number) - now / (now - last));
            }
            last = now;
            if crossings.len() == 4 {
                break;
            }
        }
        let period = (crossings[3] - crossings[0]) / 3.0;
        println!("L_v {reservoir}: {period} steps, expected {expected}");
        assert!((period / expected - 1.0).abs() < 5e-3, "{period} {expected}");
    }
}

/// The same histories at each of the six faces: to 1e-12 of the largest value.
#[test]
fn all_faces_are_alike() {
    let history = |axis: usize, side: usize| {
        let mut tube = Tube { axis, side, width: 5, ..Tube::new(12, 0.51, OUTLET) };
        tube.sides = WALL;
        let mut fluid = tube.fluid(50.0, |r| (r.piston, r.course) = (1e-3, ramp(200.0)));
        (0..600).map(|_| step(&mut fluid).unwrap().values()).collect::<Vec<_>>()
    };
    let reference = history(0, 0);
    for (axis, side) in [(0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        for (one, other) in reference.iter().zip(history(axis, side)) {
            for k in 0..6 {
                let largest = reference.iter().fold(0.0, |m: f64, v| m.max(v[k].abs()));
                let error = (one[k] - other[k]).abs() / largest;
                assert!(error < 1e-12, "axis {axis} side {side} value {k}: {one:?} {other:?}");
            }
        }
    }
}

/// Fluid at rest stays at rest, to the last bit, under any pressure, beside a piston that stands.
#[test]
fn rest_is_kept() {
    let tube = Tube { width: 4, sides: WALL, ..Tube::new(10, 0.7, WALL) };
    let mut fluid = tube.fluid(20.0, |_| {});
    let at_rest = state(&fluid);
    for _ in 0..500 {
        assert_eq!(step(&mut fluid).unwrap(), at_rest);
    }
    fluid.set_state(|_| ([0.0; 3], 0.01));
    let mut last = state(&fluid);
    assert!((last.density - 1.03).abs() < 1e-14);
    for _ in 0..500 {
        last = step(&mut fluid).unwrap();
    }
    assert!(last.velocity.abs() < 1e-15 && (last.density - 1.03).abs() < 1e-13, "{last:?}");
    assert!(fluid.diagnostics().max_speed < 1e-14);
}

/// A short reservoir of nearly inviscid fluid (`L_v` 83, tau 0.500004): the published form grows an
/// oscillation of two steps without bound; the conservative one keeps the second difference of the
/// face's velocity below 1e-7 and brings the flow to the piston's speed.
#[test]
fn the_conservative_form_is_stable_where_the_published_one_is_not() {
    let roughest = |mode: ReservoirMode| {
        let mut fluid = Tube::new(60, 0.500004, OUTLET).fluid(83.0, |r| {
            (r.piston, r.course, r.mode) = (7.2e-4, smooth_ramp(2500.0), mode);
        });
        let (mut history, mut most) = ([0.0; 3], 0.0_f64);
        for k in 0..20_000 {
            match step(&mut fluid) {
                Err(_) => return f64::INFINITY,
                Ok(now) => history = [history[1], history[2], now.velocity],
            }
            if k > 2 {
                most = most.max((history[0] - 2.0 * history[1] + history[2]).abs());
            }
        }
        most
    };
    let (published, conservative) =
        (roughest(ReservoirMode::Mk), roughest(ReservoirMode::Conservative));
    println!("second differences: published {published:e}, conservative {conservative:e}");
    assert!(published > 1e-2, "{published:e}");
    assert!(conservative < 1e-7, "{conservative:e}");
}

/// Half a cosine, in straight pieces.
fn smooth_ramp(steps: f64) -> Course {
    let point = |k: u32| {
        let s = f64::from(k) / 200.0;
        [s * steps, 0.5 * (1.0 - (core::f64::consts::PI * s).cos())]
    };
    Course::Points((0..=200).map(point).collect())
}

/// A piston that has stopped leaves a compliance `V/(rho c_s^2)`: what flows out lowers the
/// pressure by its volume over that (within 1 %, the square of the compression), and flow stops
/// with the pressure.
#[test]
fn a_piston_at_rest_is_a_spring() {
    let tube = Tube { width: 8, sides: WALL, ..Tube::new(30, 0.8, OUTLET) };
    let mut fluid = tube.fluid(400.0, |r| {
        (r.piston, r.course, r.stop) = (4e-3, ramp(500.0), Some(1000.0));
    });
    let mut stopped = ReservoirState::default();
    for _ in 0..1000 {
        stopped = step(&mut fluid).unwrap();
    }
    let mut last = stopped;
    for _ in 0..4000 {
        let now = step(&mut fluid).unwrap();
        assert_eq!((now.piston, now.volume), (0.0, stopped.volume));
        last = now;
    }
    assert!(stopped.pressure > 10.0 * last.pressure, "{stopped:?} {last:?}");
    let compliance = stopped.volume * 3.0;
    let outflow = last.entered - stopped.entered;
    let error = outflow / (compliance * (stopped.pressure - last.pressure)) - 1.0;
    println!("{stopped:?} {last:?}: {error:e}");
    assert!(error.abs() < 0.01, "{error}");
    for _ in 0..60_000 {
        last = step(&mut fluid).unwrap();
    }
    assert!(last.pressure.abs() < 1e-4 * stopped.pressure, "{last:?}");
    assert!(last.velocity.abs() < 1e-4 * stopped.velocity, "{last:?}");
}

/// Half of a bore, cut by a mirror, behaves as the whole: the length of the cylinder counts alone.
#[test]
fn half_a_model_is_the_whole() {
    let run = |half: bool| {
        let mut case = Case::new([if half { 5 } else { 10 }, 10, 16], [WALL; 3], 0.55);
        case.collision = Collision::Bgk;
        let mut scene = case.scene();
        let mut reservoir = Reservoir::new(60.0, 3000.0, 2e-3);
        reservoir.course = ramp(300.0);
        scene.domain.faces[2] = [Face::Reservoir(reservoir), OUTLET];
        if half {
            scene.domain.faces[0][1] = SYMMETRY;
        }
        // A bore, of which about 60 cells are left.
        let bore = Geometry::Cylinder { radius: 4.4, length: 40.0 };
        let mut bore = part("bore", bore, [5.0, 5.0, 8.0]);
        bore.cavity = true;
        scene.parts.push(bore);
        let mut fluid = case.fluid_of(&scene);
        (0..1500).map(|_| step(&mut fluid).unwrap()).collect::<Vec<_>>()
    };
    let [whole, half] = [false, true].map(run);
    for (one, other) in whole.iter().zip(&half) {
        assert!((one.velocity - other.velocity).abs() < 1e-12, "{one:?} {other:?}");
        assert!((one.pressure - other.pressure).abs() < 1e-12, "{one:?} {other:?}");
        assert!((one.entered - 2.0 * other.entered).abs() < 1e-9, "{one:?} {other:?}");
        assert_eq!(one.volume, other.volume);
    }
    assert!(whole.last().unwrap().velocity > 1e-3);
}

/// With a relaxation of one a whole face moves as its mean; with none, walls hold its rim back.
#[test]
fn relaxation_levels_a_face() {
    let spread = |relaxation: f64| {
        let tube = Tube { width: 8, sides: WALL, ..Tube::new(16, 0.6, OUTLET) };
        let mut fluid = tube.fluid(100.0, |r| {
            (r.piston, r.course, r.relaxation) = (2e-3, ramp(200.0), relaxation);
        });
        for _ in 0..1000 {
            fluid.step(&[], &mut []).unwrap();
        }
        let face = cells(&fluid).filter(|cell| cell[0] == 0);
        let u: Vec<f64> = face.map(|cell| fluid.velocity_at(cell)[0]).collect();
        let (least, most) = u.iter().fold((f64::MAX, f64::MIN), |(l, m), &u| (l.min(u), m.max(u)));
        let mean = u.iter().sum::<f64>() / u.len() as f64;
        assert!((state(&fluid).velocity - mean).abs() < 1e-12);
        (most - least) / mean
    };
    let [free, some, level] = [0.0, 0.02, 1.0].map(spread);
    println!("{free} {some} {level}");
    assert!(level < 1e-10 && some < free && free > 0.1, "{free} {some} {level}");
}

/// A piston that comes to the face ends the run with a sentence, as does one that is too fast.
#[test]
fn a_run_ends_before_the_piston_breaks_through() {
    let mut fluid = Tube::new(20, 0.8, OUTLET).fluid(10.0, |r| r.piston = 0.01);
    let mut steps = 0;
    let error = loop {
        match step(&mut fluid) {
            Ok(_) => steps += 1,
            Err(error) => break error,
        }
    };
    // 95 % of ten cells, a hundredth of a cell a step; rounding may take one.
    assert!((949..=950).contains(&steps), "{steps}");
    assert!(error.to_string().contains("x_lower is spent at"), "{error}");
    let mut fluid = Tube::new(20, 0.8, OUTLET).fluid(1000.0, |r| r.piston = 0.3);
    let error = (0..1000).find_map(|_| step(&mut fluid).err()).unwrap();
    assert!(error.to_string().contains("passes the reservoir at x_lower"), "{error}");
}

/// The same bits on any number of threads, at a face of several items of work, with a body at it.
#[test]
fn threads_change_no_bit() {
    let run = |threads: usize| {
        let mut case = Case::new([12, 30, 31], [WALL; 3], 0.55);
        case.threads = threads;
        let mut scene = case.scene();
        let mut reservoir = Reservoir::new(930.0, 93_000.0, 2e-3);
        reservoir.course = ramp(50.0);
        scene.domain.faces[0] = [Face::Reservoir(reservoir), OUTLET];
        let mut fluid = case.fluid_of(&scene);
        let mut bodies = vec![tremie_messages::BodyState::at_rest(1, [2.0, 14.3, 15.2])];
        bodies[0].velocity = [0.0, 0.02, 0.01];
        fluid.apply_events(&[added(1, 4.1)]).unwrap();
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        let mut bits = Vec::new();
        for _ in 0..120 {
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads).unwrap();
            closes(&fluid, 1e-10);
            bits.extend(state(&fluid).values().map(f64::to_bits));
            bits.extend(loads[0].force.map(f64::to_bits));
        }
        bits
    };
    let reference = run(1);
    assert!([2, 3].map(run).iter().all(|bits| *bits == reference));
}
