//! Probes in a flow that is known.

use crate::common::*;
use tremie_fluid_lbm::{LbmFluid, probe_signals};
use tremie_messages::BodyState;
use tremie_messages::scene::{Probe, ProbeShape, Ring, Scene};

#[test]
fn probes_read_a_linear_flow() {
    let case = Case::new([12, 10, 8], [WALL; 3], 0.8);
    let mut scene = case.scene();
    let shapes = [
        ("point", ProbeShape::Point([4.3, 5.1, 2.7])),
        ("line", ProbeShape::Line { from: [2.0, 3.0, 4.0], to: [8.0, 7.0, 5.0] }),
        (
            "section",
            ProbeShape::Section {
                axis: 0,
                position: 6.2,
                min: [0.0, 2.0, 1.0],
                max: [0.0, 8.0, 7.0],
            },
        ),
        ("region", ProbeShape::Region { min: [1.0, 1.0, 1.0], max: [7.0, 7.0, 5.0] }),
    ];
    for (name, shape) in shapes {
        scene.probes.push(Probe { name: name.into(), shape });
    }
    let names: Vec<_> = probe_signals(&scene).into_iter().map(|(name, ..)| name).collect();
    assert_eq!(names.len(), 4 + 4 + 3 + 5);
    assert_eq!(
        [&names[0], &names[8], &names[15]],
        ["point.pressure", "section.flow_rate", "region.solid_fraction"]
    );
    let mut fluid = case.fluid_of(&scene);
    let pressure = |x: [f64; 3]| 1e-4 * (x[0] + 2.0 * x[1] - x[2]);
    let speed = |x: [f64; 3]| 1e-3 * (x[0] - 0.5 * x[1] + 0.25 * x[2]);
    fluid.set_state(|x| ([speed(x), 0.0, -speed(x)], pressure(x)));
    let mut found = Vec::new();
    fluid.probes(&mut found);
    let (point, line, region) = ([4.3, 5.1, 2.7], [5.0, 5.0, 4.5], [4.0, 4.0, 3.0]);
    let layer = [6.5, 5.0, 4.0];
    let expected = [
        [pressure(point), speed(point), 0.0, -speed(point)].to_vec(),
        [pressure(line), speed(line), 0.0, -speed(line)].to_vec(),
        [36.0 * speed(layer), pressure(layer), 36.0 * speed(layer) * (1.0 + 3.0 * pressure(layer))]
            .to_vec(),
        [pressure(region), speed(region), 0.0, -speed(region), 0.0].to_vec(),
    ]
    .concat();
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() < 1e-14, "{}: {found} {expected}", names[k]);
    }
    // A body covers 8 of the region's 144 cells, and all cells around the point.
    let body = [BodyState::at_rest(1, [4.0, 5.0, 3.0])];
    fluid.apply_events(&[added(1, 1.0)]).unwrap();
    fluid.start(&body, &mut loads_of(&body)).unwrap();
    found.clear();
    fluid.probes(&mut found);
    assert_eq!(found[15], 8.0 / 144.0);
    let near: f64 = found[0];
    assert!(near == 0.0 || (near - pressure(point)).abs() < 1e-3, "{near}");
}

/// The rate of mass through a section is the mean since means began: of a fluid that falls freely,
/// that of half the way; and a profile cuts a section into strips, each with its mean velocity.
#[test]
fn rates_are_means_and_profiles_are_strips() {
    let mut case = Case::new([220, 8, 4], [PERIODIC, SYMMETRY, PERIODIC], 0.8);
    case.acceleration[0] = 1e-6;
    let mut scene = case.scene();
    let (min, max) = ([0.0; 3], [220.0, 8.0, 4.0]);
    let section = ProbeShape::Section { axis: 0, position: 20.2, min, max };
    let profile = ProbeShape::Profile { axis: 0, position: 20.2, min, max, along: 1, bins: 4 };
    for (name, shape) in [("section", section), ("profile", profile)] {
        scene.probes.push(Probe { name: name.into(), shape });
    }
    let names: Vec<_> = probe_signals(&scene).into_iter().map(|(name, ..)| name).collect();
    assert_eq!(
        names[2..],
        ["section.mass_flow_rate", "profile.u0", "profile.u1", "profile.u2", "profile.u3"]
    );
    let mut fluid = case.fluid_of(&scene);
    let mut steps = 0.0;
    for count in [40, 25] {
        fluid.restart_means();
        for _ in 0..count {
            fluid.step(&[], &mut []).unwrap();
        }
        let mut found = Vec::new();
        fluid.probes(&mut found);
        // The flow in a step has the velocity in the step's middle.
        let mean = 1e-6 * (steps + 0.5 * f64::from(count));
        steps += f64::from(count);
        assert!((found[2] / (32.0 * mean) - 1.0).abs() < 1e-6, "{found:?} {mean}");
        assert!((found[0] / (32.0 * 1e-6 * steps) - 1.0).abs() < 0.02, "{found:?}");
    }
    let speed = |y: f64| 1e-3 * y;
    fluid.set_state(|x| ([speed(x[1]), 0.0, 0.0], 0.0));
    let mut found = Vec::new();
    fluid.probes(&mut found);
    for (k, u) in found[3..].iter().enumerate() {
        assert!((u - speed(2.0 * k as f64 + 1.0)).abs() < 1e-12, "{found:?}");
    }
}

/// In a linear flow the mean over a ring is what its middle has.
#[test]
fn a_ring_reads_the_mean_of_its_cells() {
    let case = Case::new([12; 3], [WALL; 3], 0.8);
    let mut scene = case.scene();
    let ring = Ring { axis: 2, through: [6.0; 3], radii: [2.0, 5.0], heights: [-1.0, 4.0] };
    scene.probes.push(Probe { name: "ring".into(), shape: ProbeShape::Ring(ring) });
    let mut fluid = case.fluid_of(&scene);
    let along = |x: [f64; 3]| 1e-3 * (x[0] - 0.5 * x[1] + 0.25 * x[2]);
    fluid.set_state(|x| ([along(x), 0.0, -along(x)], 1e-2 * along(x)));
    let mut found = Vec::new();
    fluid.probes(&mut found);
    let mean = along([6.0, 6.0, 7.5]);
    for (found, expected) in found.iter().zip([1e-2 * mean, mean, 0.0, -mean, 0.0]) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
    // A body in the hole covers none of its cells.
    let body = [BodyState::at_rest(1, [6.0; 3])];
    fluid.apply_events(&[added(1, 1.0)]).unwrap();
    fluid.start(&body, &mut loads_of(&body)).unwrap();
    found.clear();
    fluid.probes(&mut found);
    assert_eq!(found[4], 0.0);
}

#[test]
fn a_probe_outside_the_fluid_is_refused() {
    let case = Case::new([8; 3], [PERIODIC; 3], 0.8);
    let mut scene = case.scene();
    scene.probes.push(Probe {
        name: "nowhere".into(),
        shape: ProbeShape::Region { min: [9.0; 3], max: [10.0; 3] },
    });
    scene.probes.push(Probe {
        name: "slanted".into(),
        shape: ProbeShape::Section { axis: 0, position: 1.0, min: [f64::NAN; 3], max: [1.0; 3] },
    });
    let problems = case.parameters().resolve(&scene).unwrap_err();
    assert_eq!(problems[0].key, "scene.probes[1]");
    scene.probes.pop();
    let problems = case.parameters().resolve(&scene).unwrap_err();
    assert!(problems[0].message.contains("nowhere lies on no cell"), "{problems:?}");
}

/// Flow through a section, mean over the last steps, in cells at density 1.
fn crossing(fluid: &mut LbmFluid, steps: usize, mut step: impl FnMut(&mut LbmFluid)) -> f64 {
    fluid.restart_means();
    (0..steps).for_each(|_| step(fluid));
    let mut found = Vec::new();
    fluid.probes(&mut found);
    found[2]
}

fn with_section(case: &Case, n: [usize; 3]) -> Scene {
    let mut scene = case.scene();
    let (min, max) = ([0.0; 3], n.map(|n| n as f64));
    let shape = ProbeShape::Section { axis: 0, position: 0.5 * max[0] + 0.1, min, max };
    scene.probes.push(Probe { name: "section".into(), shape });
    scene
}

/// A fluid that flows along with the spheres in it passes a section as fast as they do: of what is
/// there, the part that is no sphere. Walls of bodies carry their share, and what they displace is
/// not counted.
#[test]
fn what_bodies_carry_along_passes_a_section() {
    let n = [27, 16, 16];
    let mut case = Case::new(n, [PERIODIC; 3], 0.8);
    let speed = 0.018;
    case.velocity = [speed, 0.0, 0.0];
    let scene = with_section(&case, n);
    let mut fluid = case.fluid_of(&scene);
    let at = [[4.2, 4.1, 4.4], [12.7, 11.6, 3.9], [20.3, 4.8, 11.7], [8.1, 12.2, 11.9]];
    let mut bodies: Vec<_> = (1..).zip(at).map(|(id, at)| BodyState::at_rest(id, at)).collect();
    let events: Vec<_> = bodies.iter().map(|body| added(body.id, 3.3)).collect();
    bodies.iter_mut().for_each(|body| body.velocity = [speed, 0.0, 0.0]);
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let cells = fluid.diagnostics().fluid_cells as f64;
    // Once through the domain.
    let passed = crossing(&mut fluid, 1500, |fluid| {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
    });
    let wanted = speed * cells / 27.0;
    println!("{passed} of {wanted}");
    assert!((passed / wanted - 1.0).abs() < 0.01, "{passed} {wanted}");
}

/// A lid drags half of its speed times the height through a channel, half a cell beside it as well.
#[test]
fn what_a_lid_drags_passes_a_section() {
    let n = [9, 4, 10];
    let mut case = Case::new(n, [PERIODIC, PERIODIC, WALL], 0.9);
    case.lid = (2, [0.02, 0.0, 0.0]);
    let scene = with_section(&case, n);
    let mut fluid = case.fluid_of(&scene);
    (0..2000).for_each(|_| fluid.step(&[], &mut []).unwrap());
    let passed = crossing(&mut fluid, 10, |fluid| fluid.step(&[], &mut []).unwrap());
    let wanted = 0.5 * 0.02 * 40.0;
    println!("{passed} of {wanted}");
    assert!((passed / wanted - 1.0).abs() < 1e-3, "{passed} {wanted}");
}
