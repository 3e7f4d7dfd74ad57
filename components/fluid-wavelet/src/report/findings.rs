//! Findings: what the numbers of a run mean for its results.

use crate::domain::parameters::Parameters;
use crate::report::resolution::Resolution;
use tremie_fluid_kit::checks::cell_findings::CellFindings;
use tremie_messages::finding::short;
use tremie_messages::scene::Scene;
use tremie_messages::{Finding, Limit};

/// Points across a body's layer below which its friction is a guess.
const LAYER: f64 = 2.0;
/// Mach number below which steps are much shorter than what the flow needs.
const SLOW: f64 = 0.05;
/// Steps of the gas in a window beyond which loads come late for light bodies.
const MANY_STEPS: f64 = 200.0;

/// Findings before a run.
pub fn findings(parameters: &Parameters, scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let cells = CellFindings { cell: resolution.cell };
    let mut all = vec![
        Finding::new("largest Mach number of start and expected speed", resolution.mach, "1")
            .doubtful_if(
                resolution.mach > 0.0 && resolution.mach < SLOW,
                format!("below {SLOW} nearly all steps follow sound, which such a flow hardly has"),
                "an incompressible fluid: fluid = \"fluid-lbm\" or \"fluid-pic\"",
            ),
    ];
    all.extend(resolution.across_smallest.map(|across| cells.sphere(across)));
    all.extend(resolution.across_thinnest.map(|across| cells.polyhedron(across)));
    all.extend(resolution.in_layer.map(|layer| {
        Finding::new("points in the boundary layer of the smallest body", layer, "1")
            .because("D over the root of its Reynolds number at the expected speed")
            .doubtful_if(
                layer < LAYER,
                format!(
                    "below {LAYER} friction and separation are guesses; pressure and shocks are not"
                ),
                format!("a cell of {} m makes it {LAYER}", short(resolution.cell * layer / LAYER)),
            )
    }));
    if let (Some(sponge), false) = (
        parameters.sponge,
        scene.domain.faces.iter().flatten().any(tremie_messages::scene::Face::is_open),
    ) {
        all.push(Finding::new("width of the sponge", sponge.width.0, "m").doubtful_if(
            true,
            "it lies along open faces, and no face is open",
            "leave the sponge out",
        ));
    }
    all
}

/// Limits of signals, judged when the run is over.
pub fn limits() -> Vec<Limit> {
    vec![
        Limit {
            signal: "mass_drift".into(),
            quantity: "greatest change of the gas's mass between closed faces".into(),
            unit: "1".into(),
            doubtful: 0.01,
            wrong: Some(0.1),
            why: "nothing takes or brings gas: it is the method's error, at moving surfaces and by the tolerance".into(),
            remedy: "a smaller tolerance, or a smaller cell".into(),
        },
        Limit {
            signal: "steps".into(),
            quantity: "steps of the gas in a window".into(),
            unit: "1".into(),
            doubtful: MANY_STEPS,
            wrong: None,
            why: format!("above {MANY_STEPS} bodies feel a mean over much that happened while they moved on"),
            remedy: "a shorter time_step in the fluid's settings, or a larger expected_speed".into(),
        },
    ]
}
