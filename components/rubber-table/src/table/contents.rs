//! Contents of a table: frames of force and vertices, the outline by kinds of facets, and extras.

use crate::mesh::Point;
use serde::{Deserialize, Serialize};

/// Edges of the section's outline by what becomes of them; the rubber lies to their left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facets {
    /// A: the foot, which touches the seat in the last frame, or in an earlier one that its maker chose.
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

/// Increments, passes and residual of a frame.
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
    /// True if the equilibrium is stable.
    pub stable: bool,
}

/// Contents of a table, not checked yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Origin of the numbers.
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
    /// Convergence of each frame.
    pub convergence: Vec<Convergence>,
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
}
