//! Findings: what the numbers of a run mean for its results.

use crate::domain::parameters::Parameters;
use crate::report::resolution::{Resolution, dimensions};
use tremie_fluid_kit::checks::cell_findings::CellFindings;
use tremie_messages::finding::short;
use tremie_messages::scene::Scene;
use tremie_messages::{Finding, Limit, WatchedQuantity};

/// Cells of depth below which the fluid is a film.
const SHALLOW: f64 = 8.0;

/// Cells in a step at the expected speed, and at the greatest of a run, beyond which particles that
/// cross them splash apart. A few drops may be faster than all others.
const FAST: f64 = 1.0;
const FASTEST: f64 = 1.5;

/// Findings before a run.
pub fn findings(parameters: &Parameters, scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let cells = CellFindings { cell: resolution.cell };
    let courant = resolution.expected_speed * resolution.time_step / resolution.cell;
    let mut all = vec![
        Finding::new("cells in a time step at the expected speed", courant, "1")
            .because(format!("the expected speed is {} m/s", short(resolution.expected_speed)))
            .doubtful_if(
                courant > FAST,
                format!("above {FAST} particles cross a cell in a step, and splash apart"),
                format!(
                    "a time step of {} s makes it 0.5",
                    short(resolution.time_step * 0.5 / courant)
                ),
            ),
        Finding::new(
            "particles in a cell",
            parameters.particles_per_axis.pow(dimensions(scene)) as f64,
            "1",
        )
        .doubtful_if(
            parameters.particles_per_axis < 2,
            "with one particle along an axis cells run empty at random",
            "particles_per_axis = 2",
        ),
    ];
    if !resolution.fills_all {
        all.push(
            Finding::new("cells in the depth of the fluid", resolution.depth, "1").doubtful_if(
                resolution.depth < SHALLOW,
                format!("below {SHALLOW} waves are damped by the grid"),
                format!(
                    "a cell of {} m makes it {SHALLOW}",
                    short(resolution.cell * resolution.depth / SHALLOW)
                ),
            ),
        );
    }
    all.extend(resolution.cells_per_smallest_sphere.map(|across| cells.sphere(across)));
    all.extend(resolution.cells_per_thinnest_polyhedron.map(|across| cells.polyhedron(across)));
    all.extend(resolution.thin_parts.iter().flat_map(|part| cells.part(part)));
    all.extend(resolution.narrowest_gap.iter().map(|gap| cells.gap(gap)));
    all.extend(resolution.narrowest_film.iter().map(|gap| cells.film(gap)));
    if let (true, Some(across), Some(fluid)) =
        (resolution.sticks, resolution.cells_per_smallest_sphere, &scene.fluid)
    {
        all.extend(cells.layer(across, fluid));
    }
    all.extend(resolution.lightest_body.map(|ratio| {
        Finding::new("density of the lightest body over the fluid's", ratio, "1")
            .because("bodies are solved for together with the pressure, however light")
    }));
    all
}

/// Limits of signals, judged when the run is over.
pub fn limits() -> Vec<Limit> {
    vec![
        Limit {
            signal: "courant".into(),
            quantity: "cells in a time step at the greatest speed".into(),
            unit: "1".into(),
            doubtful: FASTEST,
            wrong: Some(20.0),
            why: format!("above {FASTEST} particles skip cells in a step, and splash apart"),
            remedy: "a larger expected_speed, or a shorter time_step".into(),
            watch: Some(WatchedQuantity::Speed),
        },
        Limit {
            signal: "volume_drift".into(),
            quantity: "greatest change of the fluid's volume".into(),
            unit: "1".into(),
            doubtful: 0.02,
            wrong: Some(0.2),
            why: "the fluid is incompressible: what its volume changes by is the method's error"
                .into(),
            remedy: "a shorter time step, a larger relaxation, or smaller cells".into(),
            watch: Some(WatchedQuantity::Mass),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_limit_name_its_bound() {
        for limit in limits().into_iter().filter(|limit| limit.why.starts_with("above")) {
            let bound = format!("above {} ", limit.doubtful);
            assert!(limit.why.starts_with(&bound), "{}", limit.why);
        }
    }
}
