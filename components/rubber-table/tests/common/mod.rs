//! Sections that several tests press.
#![allow(dead_code, reason = "each test uses some of them")]

use tremie_rubber_table::fem::contact::Seat;
use tremie_rubber_table::fem::element::Symmetry;
use tremie_rubber_table::fem::material::NeoHookean;
use tremie_rubber_table::fem::{Compression, Frame, Hold, Model, compress};
use tremie_rubber_table::mesh::{self, Mesh};
use tremie_rubber_table::table::{Contents, Facets, Table};

/// Rubber as in Mutabaruka and Kamrin, but for its bulk modulus in units of the shear modulus.
pub fn rubber(bulk_over_shear: f64) -> NeoHookean {
    NeoHookean { shear_modulus: 3e5, bulk_modulus: 3e5 * bulk_over_shear }
}

/// Their rubber.
pub const RUBBER: NeoHookean = NeoHookean { shear_modulus: 3e5, bulk_modulus: 8e6 };

/// A ring of radii 6.5 and 11 mm, 3 mm high.
pub fn ring(elements: [usize; 2]) -> Mesh {
    mesh::rectangle(6.5e-3, 11e-3, 3e-3, elements).unwrap()
}

/// A ring whose force is `slope` times its compression, its foot flat.
pub fn linear(slope: f64) -> Table {
    let compressions = vec![0.0, 0.3e-3, 0.6e-3];
    let frame = |c: &f64| vec![[6.5e-3, *c], [11e-3, *c], [11e-3, 3e-3], [6.5e-3, 3e-3]];
    Table::new(Contents {
        forces: compressions.iter().map(|c| slope * c).collect(),
        vertices: compressions.iter().map(frame).collect(),
        compressions,
        facets: Facets {
            seat: vec![[0, 1]],
            exposed: vec![[1, 2], [3, 0]],
            bonded: vec![[2, 3]],
            ..Facets::default()
        },
        ..Contents::default()
    })
    .unwrap()
}

/// An axisymmetric section.
pub fn model(mesh: Mesh, material: NeoHookean, holds: &[Hold], seat: Option<Seat>) -> Model {
    Model::new(mesh, Symmetry::Axisymmetric, material, holds, seat, 1000.0).unwrap()
}

/// All frames of a compression from rest to `largest` [m].
pub fn press(model: &Model, largest: f64, frames: usize) -> Vec<Frame> {
    compress(model, &Compression { largest, frames, tolerance: 1e-9 }).unwrap()
}

/// Stiffness at rest [N/m]: of the first nanometres.
pub fn first_slope(model: &Model) -> f64 {
    press(model, 1e-8, 2)[1].force / 1e-8
}
