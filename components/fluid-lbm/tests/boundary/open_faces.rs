//! Faces with given pressure and velocity, in both schemes, across each axis.

use crate::common::*;
use tremie_fluid_lbm::{LbmFluid, OpenFaces};
use tremie_messages::scene::{Course, Face, OpenVelocity, Outflow, Profile, Scene};

const SCHEMES: [OpenFaces; 2] = [OpenFaces::Nee, OpenFaces::Nebb];

fn pressure(pressure: f64) -> Face {
    Face::Pressure { pressure, course: Course::default(), outflow: Outflow::Fixed }
}

fn velocity(velocity: [f64; 3], profile: Profile) -> Face {
    Face::Velocity(OpenVelocity { velocity, profile, course: Course::default() })
}

/// A channel with walls across `axis`, open along the next axis, periodic along the third.
fn channel(axis: usize, height: usize, length: usize, ends: [Face; 2]) -> (Case, Scene) {
    let (along, across) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut case = Case::new([1; 3], [PERIODIC; 3], 0.8);
    (case.cells[axis], case.cells[along], case.cells[across]) = (height, length, 3);
    (case.faces[axis], case.faces[along]) = (WALL, WALL);
    let mut scene = case.scene();
    scene.domain.faces[along] = ends;
    (case, scene)
}

/// Checks that the balance of momentum and mass closes to 1e-12 and 1e-10.
fn closes(fluid: &LbmFluid) {
    closes_to(fluid, 1e-12, 1e-10);
}

fn closes_to(fluid: &LbmFluid, momentum: f64, mass: f64) {
    let ledger = fluid.ledger();
    let terms = ledger.momentum_terms();
    for a in 0..3 {
        assert!((ledger.momentum_change[a] - terms[a]).abs() < momentum, "{ledger:?}");
    }
    assert!((ledger.mass_change - ledger.mass_terms()).abs() < mass, "{ledger:?}");
}

/// Flow between walls by a difference of pressure, `u = dp/dx y (H - y)/(2 mu)`, the pressures
/// holding on the end faces: to 0.5 % of the peak in the middle of the channel, which is the effect
/// of compressibility and of the ends.
#[test]
fn poiseuille_by_pressure() {
    for scheme in SCHEMES {
        for axis in 0..3 {
            let (height, length) = (11, 24);
            let drop = 2e-5;
            let ends = [pressure(drop), pressure(0.0)];
            let (mut case, scene) = channel(axis, height, length, ends);
            case.open_faces = scheme;
            let mut fluid = case.fluid_of(&scene);
            for _ in 0..4000 {
                fluid.step(&[], &mut []).unwrap();
            }
            closes(&fluid);
            let along = (axis + 1) % 3;
            let (h, gradient) = (height as f64, drop / length as f64);
            let peak = gradient * h * h / (8.0 * case.viscosity());
            for k in 0..height {
                let mut cell = [1; 3];
                (cell[axis], cell[along]) = (k, length / 2);
                let y = k as f64 + 0.5;
                let expected = gradient / (2.0 * case.viscosity()) * y * (h - y);
                let error = (fluid.velocity_at(cell)[along] - expected).abs() / peak;
                assert!(error < 5e-3, "{scheme:?} axis {axis} y {y}: {error}");
            }
        }
    }
}

/// A parabola enters, the flow leaves at a pressure: the same mass everywhere (1e-4), the
/// parabola in the middle (1 %), and the pressure drop that drives it (2 %).
#[test]
fn a_parabola_passes_through() {
    for scheme in SCHEMES {
        for axis in 0..3 {
            let (height, length, peak) = (16, 30, 0.01);
            let along = (axis + 1) % 3;
            let mut u = [0.0; 3];
            u[along] = peak;
            let ends = [velocity(u, Profile::Parabolic), pressure(0.0)];
            let (mut case, scene) = channel(axis, height, length, ends);
            case.open_faces = scheme;
            let mut fluid = case.fluid_of(&scene);
            for _ in 0..12_000 {
                fluid.step(&[], &mut []).unwrap();
            }
            closes(&fluid);
            let at = |k: usize, x: usize| {
                let mut cell = [1; 3];
                (cell[axis], cell[along]) = (k, x);
                cell
            };
            // Of mass: the density is 1 + 3 p.
            let flux =
                |cell| (1.0 + 3.0 * fluid.pressure_at(cell)) * fluid.velocity_at(cell)[along];
            let rate = |x| (0..height).map(|k| flux(at(k, x))).sum::<f64>();
            assert!((rate(4) / rate(25) - 1.0).abs() < 1e-4, "{} {}", rate(4), rate(25));
            let h = height as f64;
            for k in 0..height {
                let s = (k as f64 + 0.5) / h;
                let error = fluid.velocity_at(at(k, 15))[along] / peak - 4.0 * s * (1.0 - s);
                assert!(error.abs() < 0.01, "{scheme:?} axis {axis} {k}: {error}");
            }
            let drop = fluid.pressure_at(at(8, 10)) - fluid.pressure_at(at(8, 20));
            let expected = 10.0 * 8.0 * case.viscosity() * peak / (h * h);
            assert!((drop / expected - 1.0).abs() < 0.02, "{scheme:?}: {drop} {expected}");
        }
    }
}

/// Values hold on the faces, not in the middle of their first cells. A channel twice as long as
/// high, with 6 and with 12 cells across, the same Reynolds number: the flow between two pressures,
/// and the pressure on an inlet through which a parabola enters. Half a cell would be a twelfth of
/// the first channel, and half of that of the second; the errors are below 2 %, and fall by more
/// than three times from one to the other.
#[test]
fn faces_are_of_second_order() {
    for scheme in SCHEMES {
        let [coarse, fine] = [6, 12].map(|height| errors_of_faces(scheme, height));
        println!("{scheme:?}: {coarse:?} {fine:?}");
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            assert!(coarse < 0.02 && fine < coarse / 3.0, "{scheme:?}: {coarse} {fine}");
        }
    }
}

/// Relative errors of the flow rate that two pressures drive, and of the pressure that a parabolic
/// inlet needs.
fn errors_of_faces(scheme: OpenFaces, height: usize) -> [f64; 2] {
    let (h, length) = (height as f64, 2 * height);
    let peak = 0.012 / h;
    let steady = |ends: [Face; 2]| {
        let (mut case, scene) = channel(0, height, length, ends);
        case.open_faces = scheme;
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..100 * height * height {
            fluid.step(&[], &mut []).unwrap();
        }
        fluid
    };
    let viscosity = Case::new([1; 3], [PERIODIC; 3], 0.8).viscosity();
    let drop = 8.0 * viscosity * peak / (h * h) * length as f64;
    let rows = |fluid: &LbmFluid, x: usize, f: fn(&LbmFluid, [usize; 3]) -> f64| {
        (0..height).map(|y| f(fluid, [y, x, 1])).sum::<f64>() / h
    };
    let driven = steady([pressure(drop), pressure(0.0)]);
    let rate = rows(&driven, length / 2, |fluid, cell| fluid.velocity_at(cell)[1]);
    let inlet = velocity([0.0, peak, 0.0], Profile::Parabolic);
    let fed = steady([inlet, pressure(0.0)]);
    let [first, second] = [1, 2].map(|x| rows(&fed, x, LbmFluid::pressure_at));
    let on_face = 2.5 * first - 1.5 * second;
    [(rate / (peak * 2.0 / 3.0) - 1.0).abs(), (on_face / drop - 1.0).abs()]
}

/// A lid that is an open face, moving along itself, drags fluid between it and a wall: the profile
/// is straight from the wall to the face, to 1e-6 of the lid's speed.
#[test]
fn a_face_that_moves_along_itself_drags_from_where_it_stands() {
    for scheme in SCHEMES {
        let (height, speed) = (8, 0.01);
        let mut case = Case::new([3, height, 3], [PERIODIC, WALL, PERIODIC], 0.8);
        case.open_faces = scheme;
        let mut scene = case.scene();
        scene.domain.faces[1][1] = velocity([speed, 0.0, 0.0], Profile::Uniform);
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..6000 {
            fluid.step(&[], &mut []).unwrap();
        }
        for k in 0..height {
            let found = fluid.velocity_at([1, k, 1])[0] / speed;
            let expected = (k as f64 + 0.5) / height as f64;
            assert!((found - expected).abs() < 1e-6, "{scheme:?} {k}: {found} {expected}");
        }
    }
}

/// A stream through a box of open faces, along each axis in either direction, stays what it is: to
/// 1e-12, mirrors along its sides.
#[test]
fn a_uniform_stream_stays() {
    for scheme in SCHEMES {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut case = Case::new([9, 8, 10], [SYMMETRY; 3], 0.7);
                case.open_faces = scheme;
                case.velocity[axis] = 0.02 * sign;
                let mut scene = case.scene();
                let ends = [velocity(case.velocity, Profile::Uniform), pressure(0.0)];
                scene.domain.faces[axis] = ends;
                if sign < 0.0 {
                    scene.domain.faces[axis].reverse();
                }
                let mut fluid = case.fluid_of(&scene);
                for _ in 0..100 {
                    fluid.step(&[], &mut []).unwrap();
                    closes(&fluid);
                }
                for cell in cells(&fluid) {
                    let u = fluid.velocity_at(cell);
                    for a in 0..3 {
                        assert!((u[a] - case.velocity[a]).abs() < 1e-12, "{scheme:?} {u:?}");
                    }
                }
                assert_eq!(fluid.diagnostics().entering, 0);
            }
        }
    }
}

/// Faces follow their courses: the pressure of a closed pipe comes to that of its end, 1e-6 after
/// the waves have died down.
#[test]
fn a_course_is_followed() {
    let mut case = Case::new([20, 4, 4], [WALL, PERIODIC, PERIODIC], 1.5);
    case.open_faces = OpenFaces::Nee;
    let mut scene = case.scene();
    let course = Course::Points(vec![[0.0, 0.0], [100.0, 1.0]]);
    scene.domain.faces[0][1] = Face::Pressure { pressure: 1e-3, course, outflow: Outflow::Fixed };
    let mut fluid = case.fluid_of(&scene);
    for step in 0..20_000 {
        fluid.step(&[], &mut []).unwrap();
        if step == 49 {
            let found = 1.5 * fluid.pressure_at([19, 2, 2]) - 0.5 * fluid.pressure_at([18, 2, 2]);
            assert!((found - 0.5e-3).abs() < 1e-12, "{found}");
        }
    }
    assert!((fluid.pressure_at([2, 1, 1]) - 1e-3).abs() < 1e-9);
    closes(&fluid);
}

/// Fluid that enters through a pressure face enters straight, and the cells are counted.
#[test]
fn fluid_that_enters_at_a_pressure_enters_straight() {
    for scheme in SCHEMES {
        let mut case = Case::new([12, 10, 10], [WALL, PERIODIC, PERIODIC], 0.8);
        case.open_faces = scheme;
        case.velocity = [-0.01, 0.02, 0.01];
        let mut scene = case.scene();
        scene.domain.faces[0] = [velocity([-0.01, 0.0, 0.0], Profile::Uniform), pressure(0.0)];
        let mut fluid = case.fluid_of(&scene);
        fluid.step(&[], &mut []).unwrap();
        assert_eq!(fluid.diagnostics().entering, 100);
        let u = fluid.velocity_at([11, 3, 3]);
        assert!(u[0] < -0.009 && u[1].abs() < 1e-12 && u[2].abs() < 1e-12, "{u:?}");
    }
}

/// A pulse of sound runs into the end of a pipe: a pressure throws all of it back, inverted (more
/// than 90 % of its height, viscosity taking a little), one that absorbs less than 3 %, a
/// convective one less than a third; along each axis and in either direction, in both schemes.
#[test]
fn sound_leaves_through_an_absorbing_face() {
    let (sound, height, length) = ((1.0_f64 / 3.0).sqrt(), 1e-4, 160);
    for (scheme, axis, side) in [
        (OpenFaces::Nee, 0, 1),
        (OpenFaces::Nee, 0, 0),
        (OpenFaces::Nebb, 1, 1),
        (OpenFaces::Nee, 2, 1),
    ] {
        let returned = [Outflow::Fixed, Outflow::Absorbing, Outflow::Convective].map(|outflow| {
            let mut case = Case::new([3; 3], [PERIODIC; 3], 0.51);
            case.cells[axis] = length;
            case.faces[axis] = WALL;
            case.open_faces = scheme;
            let mut scene = case.scene();
            scene.domain.faces[axis][side] =
                Face::Pressure { pressure: 0.0, course: Course::default(), outflow };
            let mut fluid = case.fluid_of(&scene);
            let sign = [-1.0, 1.0][side];
            fluid.set_state(|x| {
                let d = x[axis] - 80.0;
                let drho = height * (-d * d / 128.0).exp();
                let mut u = [0.0; 3];
                u[axis] = sign * sound * drho;
                (u, drho / 3.0)
            });
            // To the face and back again.
            for _ in 0..(160.0 / sound) as usize {
                fluid.step(&[], &mut []).unwrap();
                closes(&fluid);
            }
            let pressure = cells(&fluid).map(|cell| 3.0 * fluid.pressure_at(cell) / height);
            pressure.fold(0.0, |most: f64, p| if p.abs() > most.abs() { p } else { most })
        });
        println!("{scheme:?} {axis} {side}: {returned:?}");
        assert!(returned[0] < -0.9, "{returned:?}");
        assert!(returned[1].abs() < 0.03 && returned[2].abs() < 1.0 / 3.0, "{returned:?}");
    }
}

/// A stream that starts at once rings between its inlet and a pressure for long; with an absorbing
/// face it has come to rest at the given pressure and speed, to 1 % of the sound at the start, when
/// the plain one still has half of that.
#[test]
fn a_channel_with_an_absorbing_end_does_not_ring() {
    let (speed, given) = (0.01, 2e-3);
    let sound = speed / 3.0_f64.sqrt();
    let ringing = [Outflow::Fixed, Outflow::Absorbing].map(|outflow| {
        let case = Case::new([80, 3, 3], [WALL, PERIODIC, PERIODIC], 0.51);
        let mut scene = case.scene();
        scene.domain.faces[0] = [
            velocity([speed, 0.0, 0.0], Profile::Uniform),
            Face::Pressure { pressure: given, course: Course::default(), outflow },
        ];
        scene.fluid.as_mut().unwrap().pressure = given;
        let mut fluid = case.fluid_of(&scene);
        let mut most = 0.0_f64;
        for step in 0..4000 {
            fluid.step(&[], &mut []).unwrap();
            if step >= 3400 {
                most = most.max((fluid.pressure_at([40, 1, 1]) - given).abs() / sound);
            }
        }
        most
    });
    println!("{ringing:?}");
    assert!(ringing[0] > 0.5 && ringing[1] < 0.01, "{ringing:?}");
}

/// A vortex that a stream carries out of the domain leaves behind less than 3 % of its largest
/// velocity and of its depth in pressure if the face is convective, against what a domain three
/// times as long has in the same cells; through a face that holds the pressure, or absorbs sound,
/// more than ten times as much velocity and five times the pressure.
#[test]
fn a_vortex_leaves_through_a_convective_face() {
    let (speed, swirl, radius, length, height) = (0.05, 0.02, 6.0, 80, 64);
    let run = |length: usize, outflow: Outflow| {
        let case = Case::new([length, height, 1], [WALL, PERIODIC, PERIODIC], 0.55);
        let mut scene = case.scene();
        scene.domain.faces[0] = [
            velocity([speed, 0.0, 0.0], Profile::Uniform),
            Face::Pressure { pressure: 0.0, course: Course::default(), outflow },
        ];
        let mut fluid = case.fluid_of(&scene);
        // Taylor's vortex: u_theta = swirl r/R exp((1 - r2/R2)/2), in balance with its pressure.
        fluid.set_state(|x| {
            let (dx, dy) = ((x[0] - 50.0) / radius, (x[1] - 32.0) / radius);
            let factor = swirl * (0.5 * (1.0 - dx * dx - dy * dy)).exp();
            ([speed - factor * dy, factor * dx, 0.0], -0.5 * factor * factor)
        });
        let mut seen = Vec::new();
        for step in 1..=1600 {
            fluid.step(&[], &mut []).unwrap();
            // Rounding of sums over so many cells.
            let rounding = 1e-14 * fluid.ledger().mass;
            closes_to(&fluid, rounding, rounding);
            if step % 20 == 0 {
                seen.extend((20..78).map(|x| {
                    let [u, v, _] = fluid.velocity_at([x, 32, 0]);
                    [u, v, fluid.pressure_at([x, 32, 0])]
                }));
            }
        }
        seen
    };
    let reference = run(3 * length, Outflow::Absorbing);
    let depth = 0.5 * swirl * swirl * 1.0_f64.exp();
    let left = |outflow: Outflow| {
        let own = run(length, outflow);
        let mut most = [0.0_f64; 2];
        for (own, wanted) in own.iter().zip(&reference) {
            let u = (own[0] - wanted[0]).hypot(own[1] - wanted[1]) / swirl;
            most = [most[0].max(u), most[1].max((own[2] - wanted[2]).abs() / depth)];
        }
        most
    };
    let all = [Outflow::Fixed, Outflow::Absorbing, Outflow::Convective].map(left);
    println!("fixed, absorbing, convective: {all:?}");
    let [fixed, absorbing, convective] = all;
    assert!(convective.iter().all(|&left| left < 0.03), "{all:?}");
    for other in [fixed, absorbing] {
        assert!(other[0] > 10.0 * convective[0] && other[1] > 5.0 * convective[1], "{all:?}");
    }
}

/// A stream between walls that enters as a parabola leaves as one, with the given pressure at the
/// end to 1e-4: velocities to 1 % of the peak, one cell inside the face as in the middle, mass in
/// and out alike to 1e-6.
#[test]
fn a_channel_ends_at_a_convective_face() {
    let (height, length, peak, given) = (12, 40, 0.02, 1e-3);
    for axis in 0..3 {
        let along = (axis + 1) % 3;
        let mut u = [0.0; 3];
        u[along] = peak;
        let outlet = Face::Pressure {
            pressure: given,
            course: Course::default(),
            outflow: Outflow::Convective,
        };
        let (case, mut scene) =
            channel(axis, height, length, [velocity(u, Profile::Parabolic), outlet]);
        scene.fluid.as_mut().unwrap().pressure = given;
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..12_000 {
            fluid.step(&[], &mut []).unwrap();
        }
        closes(&fluid);
        let cell = |x: usize, y: usize| {
            let mut at = [1; 3];
            (at[along], at[axis]) = (x, y);
            at
        };
        for x in [length / 2, length - 2, length - 1] {
            for y in 0..height {
                let s = (y as f64 + 0.5) / height as f64;
                let found = fluid.velocity_at(cell(x, y))[along] / peak;
                let wanted = 4.0 * s * (1.0 - s);
                assert!((found - wanted).abs() < 0.01, "{axis} {x} {y}: {found} {wanted}");
            }
        }
        let mean = |x: usize| {
            (0..height).map(|y| fluid.pressure_at(cell(x, y))).sum::<f64>() / height as f64
        };
        let end = 1.5 * mean(length - 1) - 0.5 * mean(length - 2);
        let ledger = fluid.ledger();
        println!("axis {axis}: pressure {end}, mass gained {:e}", ledger.mass_open);
        assert!((end / given - 1.0).abs() < 1e-4, "{end}");
        assert!(ledger.mass_open.abs() < 1e-6 * peak * height as f64, "{}", ledger.mass_open);
    }
}
