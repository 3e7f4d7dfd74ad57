//! Findings on declared gaps and moving parts before a run.

use crate::domain::parameters::Parameters;
use crate::lattice::d3q19::CS2;
use crate::report::resolution::Resolution;
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::{Gap, Motion, Scene};

/// The thinnest gap that a lattice of small viscosity lets flow [cells]: one layer of cells is held
/// by its walls.
const FLOWS: f64 = 1.5;
/// Largest motion of a part between two searches for its cells that forces do not show [cells].
const FINE: f64 = 1.0 / 16.0;
/// Lattice viscosity below which nothing damps sound that a late force feeds.
const UNDAMPED: f64 = 1e-3;

/// Findings of a scene's gaps, and of what moves under forces.
pub fn findings(parameters: &Parameters, scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let nu = (resolution.tau - 0.5) * CS2;
    let mut found: Vec<_> = scene.gaps.iter().map(|gap| opening(gap, nu)).collect();
    let slipping = scene.gaps.iter().filter(|gap| gap.slip_below > 0.0);
    found.extend(slipping.map(|gap| slip(gap, nu, parameters.slip_viscosity)));
    if scene.parts.iter().any(|part| part.motion != Motion::Fixed) {
        found.push(step(parameters.part_step));
    }
    let is_driven = |motion: &Motion| !matches!(motion, Motion::Fixed | Motion::Prescribed(_));
    if scene.parts.iter().any(|part| is_driven(&part.motion)) {
        found.push(lead(parameters.velocity_lead, nu));
    }
    found
}

fn opening(gap: &Gap, nu: f64) -> Finding {
    let name = format!("cells across {} as it opens", gap.name);
    Finding::new(name, gap.open_at, "1")
        .because("thinner, it holds no fluid and has the pressure of its rule")
        .doubtful_if(
            gap.open_at < FLOWS && nu < 0.01,
            format!(
                "below {FLOWS} it is one layer of cells, which its walls hold at a lattice viscosity of {}",
                short(nu)
            ),
            format!("open_at = {FLOWS} for a gap along the lattice, 2 for a slanted one"),
        )
}

fn slip(gap: &Gap, nu: f64, limit: f64) -> Finding {
    Finding::new(format!("lattice viscosity for slip in {}", gap.name), nu, "1")
        .because(format!("walls slip there below {limit}"))
        .doubtful_if(
            nu >= limit,
            format!("it is not below {limit}, so that walls do not slip whatever slip_below says"),
            "leave slip_below out, or raise slip_viscosity",
        )
}

fn step(cells: f64) -> Finding {
    Finding::new("cells that parts move before they are found anew", cells, "1")
        .because("wall distances follow them in between")
        .doubtful_if(
            cells > FINE,
            format!("beyond {FINE} cells are covered visibly late"),
            "part_step = 0.03125",
        )
}

fn lead(steps: f64, nu: f64) -> Finding {
    Finding::new("steps that walls of moving bodies are taken ahead", steps, "1")
        .because("the force on them comes a step late")
        .doubtful_if(
            steps < 1.0 && nu < UNDAMPED,
            format!(
                "a late force feeds sound between a part and walls, which a lattice viscosity of {} does not damp",
                short(nu)
            ),
            "velocity_lead = 1",
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{
        Domain, Face, FluidMaterial, GapRule, GapSide, Geometry, Part, PartBoundary, Pose,
    };

    /// Verdicts of a scene with a free part and a gap under it, at a viscosity.
    fn doubts(viscosity: f64, open_at: f64, parameters: Parameters) -> Vec<bool> {
        let part = Part {
            name: "lid".into(),
            geometry: Geometry::Box { size: [4.0; 3] },
            pose: Pose { position: [8.0, 8.0, 4.0], ..Pose::IDENTITY },
            cavity: false,
            material: "steel".into(),
            motion: Motion::Free,
            boundary: PartBoundary::Wall,
        };
        let gap = Gap {
            name: "foot".into(),
            between: [GapSide::Part("lid".into()), GapSide::Face { axis: 2, side: 0 }],
            open_at,
            close_at: 0.5,
            pressure: GapRule::Nearest,
            slip_below: 3.0,
            region: None,
        };
        let domain = Domain::new([0.0; 3], [16.0; 3], Face::WALLS);
        let fluid = Some(FluidMaterial::at_rest(1.0, viscosity));
        let scene = Scene { fluid, parts: vec![part], gaps: vec![gap], ..Scene::empty(domain) };
        let time_step = Some(tremie_messages::units::Time(1.0));
        let parameters = Parameters { time_step, smagorinsky: 0.1, ..parameters };
        let resolution = parameters.resolve(&scene).unwrap();
        let found = findings(&parameters, &scene, &resolution);
        found.iter().map(|finding| finding.verdict != tremie_messages::Verdict::Ok).collect()
    }

    #[test]
    fn gaps_that_cannot_flow_and_late_forces_are_doubtful() {
        let plain = Parameters::with_cell(1.0);
        assert_eq!(doubts(1e-4, 1.0, plain.clone()), [true, false, false, true]);
        let led = Parameters { velocity_lead: 1.0, part_step: 0.25, ..plain.clone() };
        assert_eq!(doubts(1e-4, 1.5, led), [false, false, true, false]);
        assert_eq!(doubts(0.1, 1.0, plain), [false, true, false, false]);
    }
}
