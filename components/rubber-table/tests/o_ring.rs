//! An O-ring between plates, against Lindley 1967: F/(π d D E) = 1.25 C^1.5 + 50 C^6.

mod common;

use common::{RUBBER, model, press};
use tremie_rubber_table::fem::Hold;
use tremie_rubber_table::fem::contact::Seat;
use tremie_rubber_table::mesh::d_ring;

/// Half of it: the plane in the middle comes down by half the compression. Lindley's formula is a
/// fit for compressions of a tenth and more; at 5 % these elements are 28 % above it, and finer
/// ones 29 %.
#[test]
fn an_o_ring_is_as_stiff_as_lindley_measured() {
    let (thickness, diameter) = (5e-3, 50e-3);
    let mesh = d_ring(0.5 * diameter, thickness, 16).unwrap();
    let model = model(mesh, RUBBER, &[Hold::sliding("top")], Some(Seat::flat(0.0)));
    let frames = press(&model, 0.125 * thickness, 51);
    let size = core::f64::consts::PI * thickness * diameter * RUBBER.youngs_modulus();
    for frame in &frames[20..] {
        let c = 2.0 * frame.compression / thickness;
        let expected = 1.25 * c.powf(1.5) + 50.0 * c.powi(6);
        let found = frame.force / size;
        assert!((found / expected - 1.0).abs() < 0.15, "{c}: {found} {expected}");
    }
    for two in frames.windows(2) {
        assert!(two[1].force > two[0].force);
        assert!(two[1].touching.len() >= two[0].touching.len(), "contact only grows");
    }
}
