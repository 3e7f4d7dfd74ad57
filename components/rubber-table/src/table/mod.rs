//! The table: force and shape of a seal over its compression.
//!
//! # The file
//!
//! One JSON object, in SI units:
//!
//! | key | meaning |
//! | --- | --- |
//! | `format` | `"tremie-rubber-table"` |
//! | `version` | 1 |
//! | `source` | where the numbers come from, in words |
//! | `material` | `shear_modulus_Pa` and `bulk_modulus_Pa` of a neo-Hookean solid, or null |
//! | `compression_m` | compression of each frame; the first is 0, then growing |
//! | `force_N` | force of the seat on the whole ring in each frame, upwards; the first is 0, then growing |
//! | `vertices_m` | for each frame, radius and height [r, z] of each vertex, seen from the carrier: what is bonded to it stands still |
//! | `facets` | edges [a, b] of the section's outline, the rubber on their left, a and b numbers of vertices from 0: `seat` touches the seat in the last frame (surface A), `exposed` stays free (surface B), `covered` lies against steel along which it slides (may be left out), `bonded` is held by steel |
//! | `quads` | quadrilaterals of the section, four vertices each, counter-clockwise; may be empty |
//! | `mises_stress_Pa` | for each frame, of each quadrilateral; may be empty |
//! | `energy_J` | stored energy in each frame; may be empty |
//! | `convergence` | how each frame was found; may be empty |
//!
//! Heights point away from the seat, so that the seal's free end has the smallest. Numbers are written
//! with all their digits: what is read equals what was written, bit for bit.
//!
//! # Between frames
//!
//! Force and vertices are both linear in the compression between two frames, with the same weight: so
//! shape and force always belong together. Below 0 the seal is at rest and pushes nothing; beyond the
//! last frame nothing is known, and asking is an error.

mod check;
mod file;
pub mod import_csv;
pub mod import_frd;
mod strain;
mod surface;

pub use check::TableError;
pub use file::FileError;
pub use surface::{Outline, Surface};
pub use tremie_messages::scene::FacetKind;

use crate::mesh::Point;
use serde::{Deserialize, Serialize};

/// Edges of the section's outline by what becomes of them; the rubber lies to their left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facets {
    /// A: touch the seat in the last frame.
    pub seat: Vec<[usize; 2]>,
    /// B: stay free.
    pub exposed: Vec<[usize; 2]>,
    /// Lie against steel, along which they slide.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covered: Vec<[usize; 2]>,
    /// Held by steel.
    pub bonded: Vec<[usize; 2]>,
}

/// Elastic constants of a neo-Hookean solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialRecord {
    /// Shear modulus [Pa].
    #[serde(rename = "shear_modulus_Pa")]
    pub shear_modulus: f64,
    /// Bulk modulus [Pa].
    #[serde(rename = "bulk_modulus_Pa")]
    pub bulk_modulus: f64,
}

/// How a frame was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Convergence {
    /// Increments since the frame before.
    pub increments: u32,
    /// Passes of Newton's method since the frame before.
    pub passes: u32,
    /// Forces out of balance over their size.
    pub residual: f64,
    /// Smallest ratio of an element's volumes, after over before.
    pub least_volume_ratio: f64,
    /// Whether the equilibrium is stable.
    pub stable: bool,
}

/// What a table holds, not checked yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Where the numbers come from.
    pub source: String,
    /// The material, if it is neo-Hookean.
    pub material: Option<MaterialRecord>,
    /// Compression of each frame [m].
    pub compressions: Vec<f64>,
    /// Force of the seat in each frame, upwards [N].
    pub forces: Vec<f64>,
    /// Vertices of each frame, seen from the carrier [m].
    pub vertices: Vec<Vec<Point>>,
    /// The outline.
    pub facets: Facets,
    /// The section's quadrilaterals.
    pub quads: Vec<[usize; 4]>,
    /// Mises stress of each quadrilateral in each frame [Pa].
    pub mises: Vec<Vec<f64>>,
    /// Stored energy in each frame [J].
    pub energies: Vec<f64>,
    /// How each frame was found.
    pub convergence: Vec<Convergence>,
}

/// Force and shape of a seal over its compression; all of it is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    contents: Contents,
}

/// A place between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// The frame before.
    pub frame: usize,
    /// Weight of the frame after, 0 to 1.
    pub weight: f64,
}

/// A compression beyond the table's last.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the seal is compressed by {:.4} mm, its table ends at {:.4} mm; make a table with a larger compression, or look for what presses so hard",
        1e3 * compression, 1e3 * last)]
pub struct BeyondTable {
    /// The compression [m].
    pub compression: f64,
    /// The table's last [m].
    pub last: f64,
}

impl Table {
    /// The table with these contents.
    ///
    /// # Errors
    /// If they are no table.
    pub fn new(contents: Contents) -> Result<Self, TableError> {
        check::check(&contents)?;
        Ok(Self { contents })
    }

    /// All that it holds.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.contents.compressions.len()
    }

    /// The largest compression [m].
    pub fn last_compression(&self) -> f64 {
        self.contents.compressions[self.frames() - 1]
    }

    /// Where `compression` [m] lies among the frames.
    ///
    /// # Errors
    /// If it lies beyond the last, or is no number.
    pub fn bracket(&self, compression: f64) -> Result<Bracket, BeyondTable> {
        let (all, last) = (&self.contents.compressions, self.last_compression());
        if compression > last || compression.is_nan() {
            return Err(BeyondTable { compression, last });
        }
        let after = all.partition_point(|c| *c <= compression).clamp(1, all.len() - 1);
        let (a, b) = (all[after - 1], all[after]);
        Ok(Bracket { frame: after - 1, weight: ((compression - a) / (b - a)).max(0.0) })
    }

    /// Force of the seat at a place between frames [N].
    pub fn force(&self, at: Bracket) -> f64 {
        mix(at.weight, self.contents.forces[at.frame], self.contents.forces[at.frame + 1])
    }

    /// Slope of the force between the two frames [N/m].
    pub fn slope(&self, at: Bracket) -> f64 {
        let rise = |values: &[f64]| values[at.frame + 1] - values[at.frame];
        rise(&self.contents.forces) / rise(&self.contents.compressions)
    }

    /// Writes the vertices at a place between frames into `out` [m], which must have room for each.
    pub fn vertices_into(&self, at: Bracket, out: &mut [Point]) {
        let (a, b) = (&self.contents.vertices[at.frame], &self.contents.vertices[at.frame + 1]);
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            *out = [mix(at.weight, a[0], b[0]), mix(at.weight, a[1], b[1])];
        }
    }

    /// As [`Table::vertices_into`], for these `vertices` alone.
    pub fn vertices_of_into(&self, at: Bracket, vertices: &[usize], out: &mut [Point]) {
        let (a, b) = (&self.contents.vertices[at.frame], &self.contents.vertices[at.frame + 1]);
        for (out, vertex) in out.iter_mut().zip(vertices) {
            let (a, b) = (a[*vertex], b[*vertex]);
            *out = [mix(at.weight, a[0], b[0]), mix(at.weight, a[1], b[1])];
        }
    }

    /// The vertices at a place between frames [m].
    pub fn vertices(&self, at: Bracket) -> Vec<Point> {
        let mut out = self.contents.vertices[at.frame].clone();
        self.vertices_into(at, &mut out);
        out
    }
}

fn mix(weight: f64, a: f64, b: f64) -> f64 {
    (1.0 - weight) * a + weight * b
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A square that is squeezed and widens, bonded above, in three frames.
    pub(crate) fn example() -> Contents {
        let frame = |c: f64| vec![[1.0, c], [2.0 + c, c], [2.0, 1.0], [1.0, 1.0]];
        Contents {
            source: "by hand".into(),
            compressions: vec![0.0, 0.1, 0.3],
            forces: vec![0.0, 5.0, 20.0],
            vertices: [0.0, 0.1, 0.3].map(frame).to_vec(),
            facets: Facets {
                seat: vec![[0, 1]],
                exposed: vec![[1, 2], [3, 0]],
                bonded: vec![[2, 3]],
                ..Facets::default()
            },
            quads: vec![[0, 1, 2, 3]],
            mises: vec![vec![0.0], vec![10.0], vec![30.0]],
            energies: vec![0.0, 0.25, 2.75],
            ..Contents::default()
        }
    }

    #[test]
    fn force_and_vertices_have_the_same_weight() {
        let table = Table::new(example()).unwrap();
        let at = table.bracket(0.15).unwrap();
        assert_eq!(at.frame, 1);
        assert!((table.force(at) - 8.75).abs() < 1e-12);
        assert!((table.slope(at) - 75.0).abs() < 1e-9);
        assert!((table.vertices(at)[1][0] - 2.15).abs() < 1e-12);
        let frame = table.bracket(0.1).unwrap();
        assert_eq!(
            (table.force(frame), table.vertices(frame)),
            (5.0, example().vertices[1].clone())
        );
        let last = table.bracket(0.3).unwrap();
        assert_eq!((last.frame, table.force(last)), (1, 20.0));
    }

    #[test]
    fn below_zero_it_rests_and_beyond_the_end_is_an_error() {
        let table = Table::new(example()).unwrap();
        for compression in [0.0, -1e-9, -5.0, f64::NEG_INFINITY] {
            let at = table.bracket(compression).unwrap();
            assert_eq!((table.force(at), table.vertices(at)), (0.0, example().vertices[0].clone()));
        }
        for compression in [0.300_001, f64::INFINITY, f64::NAN] {
            let error = table.bracket(compression).unwrap_err().to_string();
            assert!(error.contains("300.0000 mm"), "{error}");
        }
    }
}
