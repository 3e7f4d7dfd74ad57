//! The ring of Mutabaruka and Kamrin's valve: reference numbers, energy, locking, convergence.

mod common;

use common::{RUBBER, first_slope, model, press, ring, rubber};
use tremie_rubber_table::fem::contact::Seat;
use tremie_rubber_table::fem::{Hold, Model};
use tremie_rubber_table::make::tabulate;
use tremie_rubber_table::table::{Contents, Table};

/// Bonded above, on a plane that it cannot leave.
fn on_plane(elements: [usize; 2], bulk_over_shear: f64) -> Model {
    let holds = [Hold::bonded("top"), Hold::resting("bottom")];
    model(ring(elements), rubber(bulk_over_shear), &holds, None)
}

/// Bonded above, on a seat that it touches where it is pressed.
fn on_seat(elements: [usize; 2]) -> Model {
    model(ring(elements), RUBBER, &[Hold::bonded("top")], Some(Seat::flat(0.0)))
}

/// Elements; slope at rest [N/m]; force [N] at each of `COMPRESSIONS`.
type Row = ([usize; 2], f64, [f64; 6]);

/// In units of 0.03 mm.
const COMPRESSIONS: [usize; 6] = [4, 8, 11, 12, 14, 16];

/// From an independent program with the same elements (numpy).
const REFERENCE: [Row; 3] = [
    ([9, 6], 1.1170e5, [14.18, 30.05, 43.20, 47.84, 57.52, 67.76]),
    ([18, 12], 1.1092e5, [14.06, 29.76, 42.72, 47.28, 56.76, 66.76]),
    ([36, 24], 1.1057e5, [14.01, 29.62, 42.46, 46.97, 56.34, 66.20]),
];

#[test]
fn forces_are_those_of_an_independent_program() {
    for (elements, slope, forces) in REFERENCE {
        for model in [on_plane(elements, 8.0 / 0.3), on_seat(elements)] {
            let found = first_slope(&model);
            assert!((found / slope - 1.0).abs() < 1e-3, "{elements:?}: {found}");
            let frames = press(&model, 0.48e-3, 17);
            for (at, expected) in COMPRESSIONS.into_iter().zip(forces) {
                let found = frames[at].force;
                assert!(
                    (found / expected - 1.0).abs() < 1e-3,
                    "{elements:?} {at}: {found} {expected}"
                );
            }
            assert!(frames.iter().all(|frame| frame.stable));
        }
    }
}

#[test]
fn the_outer_side_bulges_and_volumes_shrink_as_published() {
    let frames = press(&on_seat([36, 24]), 0.48e-3, 17);
    let last = frames.last().unwrap();
    let bulge = last.points.iter().map(|point| point[0]).fold(0.0, f64::max) - 11e-3;
    assert!((bulge - 0.61e-3).abs() < 0.005e-3, "{bulge}");
    assert!((last.least_volume_ratio - 0.93).abs() < 0.005, "{}", last.least_volume_ratio);
}

/// Simpson's rule over pairs of frames; the contact's energy counts.
#[test]
fn force_is_the_derivative_of_the_stored_energy() {
    for model in [on_plane([9, 6], 8.0 / 0.3), on_seat([9, 6])] {
        let frames = press(&model, 0.6e-3, 41);
        let spacing = 0.6e-3 / 40.0;
        for three in frames.windows(3) {
            let work = spacing / 3.0 * (three[0].force + 4.0 * three[1].force + three[2].force);
            let stored = three[2].energy - three[0].energy;
            assert!((work - stored).abs() < 1e-6 * stored, "{work} {stored}");
        }
    }
}

#[test]
fn carrier_and_seat_push_alike() {
    for frame in press(&on_seat([9, 6]), 0.6e-3, 41) {
        assert!((frame.force - frame.seat_force).abs() <= 1e-8 * frame.force, "{frame:?}");
        assert_eq!(
            frame.touching.len(),
            if frame.compression > 0.0 { 9 } else { frame.touching.len() }
        );
    }
}

/// Full integration gives 5.27, 2.28, 1.51 and 1.29 here.
#[test]
fn nearly_incompressible_rubber_does_not_lock() {
    let elements = [[6, 4], [12, 8], [24, 16], [48, 32]];
    for (bulk_over_shear, expected) in
        [(8.0 / 0.3, [1.125, 1.113, 1.107, 1.105]), (1000.0, [1.198, 1.183, 1.175, 1.172])]
    {
        for (elements, expected) in elements.into_iter().zip(expected) {
            let found = first_slope(&on_plane(elements, bulk_over_shear)) / 1e5;
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "{bulk_over_shear} {elements:?}: {found}"
            );
        }
    }
}

/// The edge of the bond is singular: the order is about 1.2, not 2.
#[test]
fn the_slope_converges_with_the_mesh() {
    let slopes: Vec<f64> = [[9, 6], [18, 12], [36, 24]]
        .into_iter()
        .map(|n| first_slope(&on_plane(n, 8.0 / 0.3)))
        .collect();
    let (coarse, fine) = (slopes[0] - slopes[1], slopes[1] - slopes[2]);
    assert!(coarse > 0.0 && (2.0..2.6).contains(&(coarse / fine)), "{slopes:?}");
}

/// The penalty's error falls with its stiffness, and is far below the mesh's.
#[test]
fn the_contact_is_stiff_enough() {
    let with = |stiffness: f64| {
        let symmetry = tremie_rubber_table::fem::element::Symmetry::Axisymmetric;
        let seat = Some(Seat::flat(0.0));
        let holds = [Hold::bonded("top")];
        let model = Model::new(ring([9, 6]), symmetry, RUBBER, &holds, seat, stiffness).unwrap();
        press(&model, 0.48e-3, 17)[16].force
    };
    let hard = press(&on_plane([9, 6], 8.0 / 0.3), 0.48e-3, 17)[16].force;
    let errors = [100.0, 1000.0].map(|stiffness| 1.0 - with(stiffness) / hard);
    assert!(errors[0] > 0.0 && errors[0] < 5e-3, "{errors:?}");
    assert!(errors[1] > 0.0 && errors[1] < 5e-4, "{errors:?}");
}

#[test]
fn the_same_bits_every_time() {
    let run = || press(&on_seat([9, 6]), 0.48e-3, 17);
    assert_eq!(run(), run());
}

/// Pressed flat it cannot be: the error says how far it went and what to do.
#[test]
fn too_much_is_an_error_with_the_way_gone() {
    use tremie_rubber_table::fem::{Compression, compress};
    let way = Compression { largest: 3.2e-3, frames: 33, tolerance: 1e-9 };
    let stuck = compress(&on_plane([6, 4], 8.0 / 0.3), &way).unwrap_err();
    assert!(stuck.reached > 0.6e-3 && stuck.reached < 3e-3, "{stuck}");
    assert!(stuck.to_string().contains("compress less"), "{stuck}");
}

/// Guided on both sides it is strained along the axis alone: (K + 4/3 G) A/t.
#[test]
fn a_ring_in_a_groove_has_the_stiffness_of_uniaxial_strain() {
    let holds = [Hold::bonded("top"), Hold::guided("inner"), Hold::guided("outer")];
    let model = model(ring([9, 6]), RUBBER, &holds, Some(Seat::flat(0.0)));
    let area = std::f64::consts::PI * (11e-3f64.powi(2) - 6.5e-3f64.powi(2));
    let modulus = RUBBER.bulk_modulus + 4.0 / 3.0 * RUBBER.shear_modulus;
    let found = first_slope(&model) / (modulus * area / 3e-3);
    // The seat's penalty gives way.
    assert!((found - 1.0).abs() < 5e-3, "{found}");
}

#[test]
fn strain_from_the_outline_agrees_with_that_from_the_section() {
    let model = on_seat([36, 24]);
    let frames = press(&model, 0.48e-3, 17);
    let whole = tabulate(&model, &frames, 0.48e-3, String::new(), None).unwrap();
    let alone = Table::new(Contents { quads: vec![], mises: vec![], ..whole.contents().clone() });
    let rest = &whole.contents().vertices[0];
    // The outer side, off its corners: what the outline does not see, the change of volume, is
    // small there.
    let is_side = |v: &usize| rest[*v][0] > 10.999e-3 && (0.5e-3..2.0e-3).contains(&rest[*v][1]);
    let side: Vec<usize> = (0..rest.len()).filter(is_side).collect();
    let (inside, outside) = (whole.strains_of(&side), alone.unwrap().strains_of(&side));
    assert!(side.len() > 8);
    for (a, b) in inside[16].iter().zip(&outside[16]) {
        assert!((a / b - 1.0).abs() < 0.15 && *a > 0.05, "{a} {b}");
    }
}
