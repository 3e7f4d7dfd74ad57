//! Probes against counts and volumes that are known.

use crate::common::*;
use std::f64::consts::PI;
use tremie_grains_dem::{GrainsDem, Parameters, debris::normalised_area, probe_signals};
use tremie_messages::scene::{Damping, Face, Motion, Probe, ProbeShape, Ring, Scene};

const D: f64 = 1e-3;
const SIDE: f64 = 8e-3;

fn region(name: &str, min: [f64; 3], max: [f64; 3]) -> Probe {
    Probe { name: name.into(), shape: ProbeShape::Region { min, max } }
}

fn section(name: &str, axis: usize, position: f64, max: [f64; 3]) -> Probe {
    let min = [0.0; 3];
    Probe { name: name.into(), shape: ProbeShape::Section { axis, position, min, max } }
}

/// A periodic box without weight.
fn flying(spheres: Vec<tremie_messages::scene::Sphere>, probes: Vec<Probe>) -> Scene {
    let mut scene = scene([SIDE; 3], PERIODIC, law(1e3, 0.0, Damping::Restitution(1.0)));
    scene.bodies = vec![set(Motion::Free, spheres)];
    scene.probes = probes;
    scene
}

fn value(scene: &Scene, dem: &mut GrainsDem, name: &str) -> f64 {
    let mut values = Vec::new();
    dem.read_probes(&mut values);
    let names = probe_signals(scene);
    assert_eq!(names.len(), values.len());
    values[names.iter().position(|(known, _)| known == name).expect(name)]
}

#[test]
fn a_region_holds_the_volumes_inside_it() {
    // One sphere whole inside, one cut in half by a face, one at the domain's edge that is seen in
    // the region through periodic faces by a quarter.
    let spheres = vec![
        sphere([2e-3, 2e-3, 2e-3], D, [1.0, 0.0, 0.0]),
        sphere([4e-3, 2e-3, 2e-3], D, [0.0, 2.0, 0.0]),
        sphere([8e-3 - 1e-9, 2e-3, 8e-3 - 1e-9], D, [0.0, 0.0, 4.0]),
    ];
    let probes = vec![region("box", [0.0; 3], [4e-3; 3])];
    let scene = flying(spheres, probes);
    let mut dem = make(&scene, 1e-9);
    let mut seen = |name| value(&scene, &mut dem, name);
    let (ball, volume) = (PI / 6.0 * D.powi(3), 4e-3f64.powi(3));
    assert!((seen("box.solid_fraction") * volume / ball - 1.75).abs() < 1e-4);
    assert_eq!(seen("box.number"), 1.0, "centres on the upper face belong to the next region");
    assert!((seen("box.velocity_x") - 1.0 / 1.75).abs() < 1e-3);
    assert!((seen("box.velocity_y") - 1.0 / 1.75).abs() < 1e-3);
    assert!((seen("box.velocity_z") - 1.0 / 1.75).abs() < 1e-3);
}

/// Spheres whose centres lie in half a ring, against the part of its area that they hide; those
/// above it, within its inner radius and outside do not count.
#[test]
fn a_ring_knows_how_much_of_it_spheres_hide() {
    let mut faces = WALLS;
    faces[0][0] = Face::Symmetry;
    let mut scene = scene([SIDE; 3], faces, law(1e3, 0.0, Damping::Restitution(1.0)));
    let at = |x: f64, y: f64, z: f64, d: f64| sphere([x * 1e-3, y * 1e-3, z * 1e-3], d, [0.0; 3]);
    scene.bodies = vec![set(
        Motion::Free,
        vec![
            at(2.0, 2.0, 4.0, D),
            at(1.0, 2.2, 6.0, 1.5 * D),
            at(2.0, 3.6, 4.0, D),
            at(0.6, 2.0, 4.2, D),
            at(3.5, 2.0, 4.0, D),
        ],
    )];
    let ring =
        Ring { axis: 1, through: [0.0, 2e-3, 4e-3], radii: [1e-3, 3e-3], heights: [-1e-3, 1e-3] };
    scene.probes = vec![Probe { name: "seat".into(), shape: ProbeShape::Ring(ring) }];
    let mut dem = make(&scene, 1e-9);
    let mut seen = |name| value(&scene, &mut dem, name);
    let (hidden, half) = (PI / 4.0 * (1.0 + 2.25) * D * D, 0.5 * PI * (9.0 - 1.0) * 1e-6);
    assert_eq!(seen("seat.number"), 2.0);
    assert!((seen("seat.projected_area") / hidden - 1.0).abs() < 1e-12);
    assert!((seen("seat.area_fraction") * half / hidden - 1.0).abs() < 1e-9);
    let stuck = normalised_area([D, 1.5 * D], half);
    assert!((seen("seat.area_fraction") / stuck - 1.0).abs() < 1e-9);
}

#[test]
fn a_section_counts_what_passes_and_what_passes_back() {
    let (v, steps) = (2.0, 100);
    let spheres = vec![
        sphere([3.95e-3, 2e-3, 2e-3], D, [v, 0.0, 0.0]),
        sphere([4.05e-3, 6e-3, 2e-3], D, [-v, 0.0, 0.0]),
        sphere([4.05e-3, 2e-3, 6e-3], 2.0 * D, [-v, 0.0, 0.0]),
        // Across the periodic face, where a section lies too.
        sphere([7.95e-3, 4e-3, 4e-3], D, [v, 0.0, 0.0]),
    ];
    let probes = vec![
        section("all", 0, 4e-3, [SIDE; 3]),
        section("low", 0, 4e-3, [SIDE, SIDE, 4e-3]),
        section("face", 0, SIDE, [SIDE; 3]),
        section("across", 1, 4e-3, [SIDE; 3]),
    ];
    let scene = flying(spheres, probes);
    let mut dem = make(&scene, 1e-6);
    dem.advance(steps, &[]).unwrap();
    let mut seen = |name| value(&scene, &mut dem, name);
    let duration = 1e-6 * f64::from(steps);
    assert_eq!((seen("all.crossings"), seen("low.crossings")), (-1.0, 0.0));
    assert!((seen("all.mass_passed") / -mass(2.0 * D) - 1.0).abs() < 1e-12);
    assert!((seen("all.mass_flow_rate") * duration / -mass(2.0 * D) - 1.0).abs() < 1e-12);
    assert_eq!((seen("face.crossings"), seen("across.crossings")), (1.0, 0.0));
    // Counts stay; the rate is a mean over the time since it was begun anew.
    dem.restart_means();
    dem.advance(steps, &[]).unwrap();
    let mut seen = |name| value(&scene, &mut dem, name);
    assert_eq!((seen("all.crossings"), seen("face.crossings")), (-1.0, 1.0));
    assert_eq!(seen("face.mass_flow_rate"), 0.0);
    assert!((seen("face.mass_passed") / mass(D) - 1.0).abs() < 1e-12);
}

/// Rates times the times between rows add up to the total that passed, however often rows are kept.
#[test]
fn rates_add_up_to_what_passed() {
    let fast = |x: f64, v: f64, d: f64| sphere([x, 2e-3, 2e-3], d, [v, 0.0, 0.0]);
    // They go around the periodic box, and one comes back after it met another.
    let spheres = vec![fast(0.5e-3, 3.0, D), fast(2.5e-3, 1.0, D), fast(6e-3, -2.0, 1.5 * D)];
    let probes = vec![section("gate", 0, 4e-3, [SIDE; 3])];
    let scene = flying(spheres, probes);
    for every in [1, 3, 7, 1000] {
        let mut dem = make(&scene, 1e-6);
        let (mut sum, mut since, mut crossings) = (0.0, 0.0, Vec::new());
        let (windows, substeps) = (100, 97);
        for window in 1..=windows {
            dem.advance(substeps, &[]).unwrap();
            since += 1e-6 * f64::from(substeps);
            if window % every == 0 || window == windows {
                sum += since * value(&scene, &mut dem, "gate.mass_flow_rate");
                crossings.push(value(&scene, &mut dem, "gate.crossings"));
                dem.restart_means();
                since = 0.0;
            }
        }
        let passed = value(&scene, &mut dem, "gate.mass_passed");
        assert!((sum - passed).abs() < 1e-12 * mass(D), "{every}: {sum} {passed}");
        // Two pass against the axis, one comes back, and again.
        assert_eq!(*crossings.last().unwrap(), -2.0, "{crossings:?}");
        let back = crossings.windows(2).any(|pair| pair[1] > pair[0]);
        assert!(every > 1 || back, "{crossings:?}");
    }
}

/// A section counts the spheres that regions on both sides lose and gain, and no thread enters a
/// bit.
#[test]
fn sections_agree_with_regions_on_any_number_of_threads() {
    let mut one = scene([SIDE, SIDE, 3.0 * SIDE], WALLS, law(1e3, 0.3, Damping::Restitution(0.6)));
    one.gravity = [0.0, 0.0, -9.81];
    let low = [SIDE, SIDE, SIDE];
    one.bodies = vec![packed([0.0, 0.0, SIDE], [SIDE, SIDE, 3.0 * SIDE], 0.35, (0.9e-3, 1e-3), 1)];
    one.probes = vec![
        region("below", [0.0; 3], low),
        region("above", [0.0, 0.0, SIDE], [SIDE, SIDE, 3.0 * SIDE]),
        section("middle", 2, SIDE, [SIDE; 3]),
    ];
    let run = |threads| {
        let mut dem = GrainsDem::new(&one, &Parameters::default(), 4e-6, threads).unwrap();
        let mut values = Vec::new();
        let mut fell = 0.0;
        for _ in 0..100 {
            dem.advance(60, &[]).unwrap();
            values.clear();
            dem.read_probes(&mut values);
            fell = -value(&one, &mut dem, "middle.crossings");
            assert_eq!(value(&one, &mut dem, "below.number"), fell);
        }
        let spheres = dem.body_count() as f64;
        assert!(spheres > 512.0, "more than a block");
        assert_eq!(value(&one, &mut dem, "below.number"), fell);
        assert_eq!(value(&one, &mut dem, "above.number"), spheres - fell);
        // Spheres fill what they fill, wherever the border cuts them.
        let filled = value(&one, &mut dem, "below.solid_fraction")
            + 2.0 * value(&one, &mut dem, "above.solid_fraction");
        let volume: f64 = dem.radii().map(|r| 4.0 / 3.0 * PI * r.powi(3)).sum();
        assert!((filled * SIDE.powi(3) / volume - 1.0).abs() < 1e-3, "{filled}");
        assert!(fell > 100.0, "{fell}");
        values
    };
    assert_eq!(run(1), run(3));
}
