//! Blocks whose solution is known: homogeneous compression, and Gent and Lindley's bonded block.

mod common;

use common::{RUBBER, first_slope, model, press, ring, rubber};
use std::collections::BTreeMap;
use tremie_rubber_table::fem::element::Symmetry;
use tremie_rubber_table::fem::material::{NeoHookean, Tensor};
use tremie_rubber_table::fem::{Compression, Hold, Model, compress};
use tremie_rubber_table::mesh::{self, Mesh};

/// Force on a bar of section `area` at axial stretch `stretch`, its sides free: the side stretch
/// that leaves them without stress is found by bisection.
fn uniaxial(material: &NeoHookean, area: f64, stretch: f64) -> f64 {
    let stress = |side: f64| material.stress(&Tensor::new(side, 0.0, 0.0, stretch, side));
    let (mut low, mut high) = (0.5, 2.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if stress(middle)[0] < 0.0 { low = middle } else { high = middle }
    }
    -area * stress(low)[3]
}

/// The ring with its inner nodes moved about.
fn distorted_ring() -> Mesh {
    let even = ring([9, 6]);
    let inside = |node: &usize| !even.outline().iter().flatten().any(|other| other == node);
    let mut nodes = even.nodes().to_vec();
    for node in (0..nodes.len()).filter(inside) {
        nodes[node][0] += 0.15e-3 * libm::sin(5.0 * node as f64);
        nodes[node][1] += 0.15e-3 * libm::cos(7.0 * node as f64);
    }
    let named = |name: &str| (name.to_string(), even.boundary(name).unwrap().to_vec());
    let boundaries = BTreeMap::from(["top", "bottom"].map(named));
    Mesh::new(nodes, even.quads().to_vec(), boundaries).unwrap()
}

#[test]
fn without_friction_a_ring_is_compressed_homogeneously() {
    let area = core::f64::consts::PI * (121.0 - 42.25) * 1e-6;
    let holds = [Hold::sliding("top"), Hold::resting("bottom")];
    for mesh in [ring([9, 6]), distorted_ring()] {
        let model = model(mesh, RUBBER, &holds, None);
        let way = Compression { largest: 0.48e-3, frames: 17, tolerance: 1e-11 };
        let frames = compress(&model, &way).unwrap();
        for frame in &frames[1..] {
            let expected = uniaxial(&RUBBER, area, 1.0 - frame.compression / 3e-3);
            assert!((frame.force / expected - 1.0).abs() < 1e-10, "{} {expected}", frame.force);
        }
        assert!((frames[16].force - 42.3785).abs() < 1e-4);
    }
}

/// Apparent modulus of a disc of radius `shape` × 2 × height, bonded on both faces [Pa].
fn bonded_disc(shape: f64, material: NeoHookean, rows: usize) -> f64 {
    let (radius, height) = (10e-3, 10e-3 / (2.0 * shape));
    let columns = (2.0 * shape * rows as f64) as usize;
    let mesh = mesh::rectangle(0.0, radius, height, [columns, rows]).unwrap();
    let model = model(mesh, material, &[Hold::bonded("top"), Hold::fixed("bottom")], None);
    first_slope(&model) * height / (core::f64::consts::PI * radius * radius)
}

/// Gent and Lindley 1959: E (1 + 2 S²) with E = 3G, in series with the bulk modulus; shape factor
/// S, a loaded face over the free surface, of a disc R/2t.
#[test]
fn a_bonded_block_is_as_stiff_as_gent_and_lindley_say() {
    let cases = [(0.75, 1000.0), (1.0, 1000.0), (1.5, 1000.0), (2.0, 1000.0), (3.0, 1000.0)];
    for (shape, bulk_over_shear) in cases.into_iter().chain([(1.5, 8.0 / 0.3), (2.0, 8.0 / 0.3)]) {
        let material = rubber(bulk_over_shear);
        let incompressible = 3.0 * material.shear_modulus * (1.0 + 2.0 * shape * shape);
        let expected = 1.0 / (1.0 / incompressible + 1.0 / material.bulk_modulus);
        let found = bonded_disc(shape, material, 16);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{shape} {bulk_over_shear}: {}",
            found / expected
        );
    }
}

/// Gent and Lindley's infinite strip: 4/3 E (1 + S²), S = width/2t. Half of it, up to its middle.
#[test]
fn a_bonded_strip_is_as_stiff_as_gent_and_lindley_say() {
    let material = rubber(1000.0);
    let (half_width, height) = (10e-3, 10e-3);
    let mesh = mesh::rectangle(0.0, half_width, height, [32, 32]).unwrap();
    let middle = Hold {
        boundary: "inner".into(),
        radial: true,
        axial: tremie_rubber_table::fem::Axial::Free,
    };
    let holds = [Hold::bonded("top"), Hold::fixed("bottom"), middle];
    let model = Model::new(mesh, Symmetry::PlaneStrain, material, &holds, None, 1.0).unwrap();
    let found = press(&model, 1e-8, 2)[1].force / 1e-8 * height / half_width;
    let incompressible = 4.0 * material.shear_modulus * (1.0 + 1.0);
    let expected = 1.0 / (1.0 / incompressible + 1.0 / material.bulk_modulus);
    assert!((found / expected - 1.0).abs() < 0.03, "{}", found / expected);
}
