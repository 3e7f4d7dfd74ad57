//! From a specification to a table.

use crate::fem::{Frame, Model, Stuck, compress};
use crate::spec::Spec;
use crate::table::{Contents, Convergence, Facets, MaterialRecord, Table, TableError};

/// Why no table came of a specification.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MakeError {
    /// The seal could not be compressed so far.
    #[error(transparent)]
    Stuck(#[from] Stuck),
    /// The result is no table.
    #[error("the compression gives no table: {0}")]
    Table(#[from] TableError),
}

/// Compresses the seal of a specification and tabulates it.
///
/// # Errors
/// If it cannot be compressed so far, or does not resist more and more.
pub fn make(spec: &Spec) -> Result<Table, MakeError> {
    let frames = compress(&spec.model, &spec.compression)?;
    let source = format!(
        "finite elements of tremie-rubber-table {} from {}:\n{}",
        env!("CARGO_PKG_VERSION"),
        spec.file(),
        spec.text()
    );
    let material = MaterialRecord {
        shear_modulus: spec.material.shear_modulus,
        bulk_modulus: spec.material.bulk_modulus,
    };
    Ok(tabulate(&spec.model, &frames, spec.foot_at, source, Some(material))?)
}

/// The table of a compression of `model`. Its foot is what touches the seat in the frame nearest to the compression
/// `foot_at` [m].
///
/// # Errors
/// If the force does not grow, or nothing touches the seat there.
pub fn tabulate(
    model: &Model,
    frames: &[Frame],
    foot_at: f64,
    source: String,
    material: Option<MaterialRecord>,
) -> Result<Table, TableError> {
    let from_carrier =
        |frame: &Frame| frame.points.iter().map(|[r, z]| [*r, z + frame.compression]).collect();
    let off = |frame: &&Frame| (frame.compression - foot_at).abs();
    let foot = frames.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    Table::new(Contents {
        source,
        material,
        compressions: frames.iter().map(|frame| frame.compression).collect(),
        // At rest nothing presses, whatever round-off says.
        forces: frames
            .iter()
            .enumerate()
            .map(|(k, frame)| if k == 0 { 0.0 } else { frame.force })
            .collect(),
        vertices: frames.iter().map(from_carrier).collect(),
        facets: facets(model, foot.map_or(&[], |frame| &frame.touching)),
        quads: model.mesh().quads().to_vec(),
        mises: frames.iter().map(|frame| frame.mises.clone()).collect(),
        energies: frames.iter().map(|frame| frame.energy).collect(),
        convergence: frames.iter().map(convergence).collect(),
    })
}

fn convergence(frame: &Frame) -> Convergence {
    let Frame { increments, passes, residual, least_volume_ratio, stable, .. } = *frame;
    Convergence { increments, passes, residual, least_volume_ratio, stable }
}

/// The outline but for what lies on the axis.
fn facets(model: &Model, touching: &[[usize; 2]]) -> Facets {
    let mut facets = Facets::default();
    let on_axis = |node: &usize| model.mesh().nodes()[*node][0] == 0.0;
    for edge in model.mesh().outline().iter().filter(|edge| !edge.iter().all(on_axis)) {
        let list = if model.held_edges().contains(edge) {
            &mut facets.bonded
        } else if model.guided_edges().contains(edge) {
            &mut facets.covered
        } else if touching.contains(edge) {
            &mut facets.seat
        } else {
            &mut facets.exposed
        };
        list.push(*edge);
    }
    facets
}
