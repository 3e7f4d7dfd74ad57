//! Findings: what the numbers of a run mean for its results.

use crate::domain::parameters::Parameters;
use crate::report::resolution::Resolution;
use tremie_fluid_kit::checks::cell_findings::CellFindings;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Motion, Scene};
use tremie_messages::{Finding, Limit, WatchedQuantity};

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
    if let (Some(sponge), false) =
        (parameters.sponge, scene.domain.faces.iter().flatten().any(Face::is_open))
    {
        all.push(Finding::new("width of the sponge", sponge.width.0, "m").doubtful_if(
            true,
            "it lies along open faces, and no face is open",
            "leave the sponge out",
        ));
    }
    all
}

/// Mach numbers that a gas has where it is all but empty, doubtful and wrong.
const EMPTY: [f64; 2] = [8.0, 20.0];
/// How far densities leave the range at the start: a strong shock makes 6 times, and a vacuum behind
/// a body more.
const SPREAD: [f64; 2] = [20.0, 200.0];
/// Change of the energy of a gas to which nothing happens.
const HEATED: [f64; 2] = [0.01, 0.1];

/// True if nothing gives energy to the gas or takes any.
fn keeps_energy(scene: &Scene) -> bool {
    let is_still = |face: &Face| match face {
        Face::Wall { velocity, .. } => *velocity == [0.0; 3],
        face => !face.is_open(),
    };
    let of_gas = scene.fluid.as_ref().and_then(|fluid| fluid.gas.as_ref());
    scene.bodies.is_empty()
        && scene.parts.iter().all(|part| part.motion == Motion::Fixed)
        && scene.domain.faces.iter().flatten().all(is_still)
        && scene.fluid.as_ref().is_some_and(|fluid| fluid.acceleration == [0.0; 3])
        && of_gas.is_some_and(|gas| gas.surface_temperatures.is_empty())
}

/// Limits of signals, by which they are judged, and by which a run watches them.
pub fn limits(scene: &Scene) -> Vec<Limit> {
    let energy = keeps_energy(scene).then(|| Limit {
        signal: "energy_drift".into(),
        quantity: "greatest change of the gas's energy".into(),
        unit: "1".into(),
        doubtful: HEATED[0],
        wrong: Some(HEATED[1]),
        why: "nothing gives energy or takes any in this scene: it is the method's error".into(),
        remedy: "a smaller tolerance, or a smaller cell".into(),
        watch: Some(WatchedQuantity::Energy),
    });
    numbers().into_iter().chain(energy).collect()
}

fn numbers() -> Vec<Limit> {
    vec![
        Limit {
            signal: "max_mach".into(),
            quantity: "largest Mach number of the gas".into(),
            unit: "1".into(),
            doubtful: EMPTY[0],
            wrong: Some(EMPTY[1]),
            why: format!(
                "above {} there is hardly any heat left beside the motion, as where the gas is all but empty: small errors \
                 make its pressure negative",
                EMPTY[0]
            ),
            remedy: "a smaller cell or tolerance; a gentler start where the scene asks for a vacuum".into(),
            watch: Some(WatchedQuantity::Mach),
        },
        Limit {
            signal: "density_deviation".into(),
            quantity: "largest deviation of the density from its range at the start".into(),
            unit: "1".into(),
            doubtful: SPREAD[0],
            wrong: Some(SPREAD[1]),
            why: "no shock compresses a gas so much, and where so little of it is left nothing is resolved".into(),
            remedy: "a smaller cell or tolerance; a gentler start where the scene asks for a vacuum".into(),
            watch: Some(WatchedQuantity::Density),
        },
        Limit {
            signal: "mass_drift".into(),
            quantity: "greatest change of the gas's mass between closed faces".into(),
            unit: "1".into(),
            doubtful: 0.01,
            wrong: Some(0.1),
            why: "nothing takes or brings gas: it is the method's error, at moving surfaces and by the tolerance".into(),
            remedy: "a smaller tolerance, or a smaller cell".into(),
            watch: Some(WatchedQuantity::Mass),
        },
        Limit {
            signal: "steps".into(),
            quantity: "steps of the gas in a window".into(),
            unit: "1".into(),
            doubtful: MANY_STEPS,
            wrong: None,
            why: format!("above {MANY_STEPS} bodies feel a mean over much that happened while they moved on"),
            remedy: "a shorter time_step in the fluid's settings, or a larger expected_speed".into(),
            watch: None,
        },
    ]
}
