//! Net flow in and out through the domain's faces.

use tremie_messages::Finding;
use tremie_messages::scene::{
    Course, Face, OpenVelocity, Part, PartBoundary, Profile, Reservoir, Scene,
};

/// The net rate of flow through faces with a given velocity, where no pressure lets it balance.
pub(super) fn findings(scene: &Scene) -> Option<Finding> {
    // A free surface rises and falls by what flows in and out.
    scene.fluid.as_ref().filter(|fluid| fluid.fill.is_empty())?;
    let faces = || scene.domain.faces.iter().flatten();
    // A pressure at a face, or a part that lets fluid through, lets any rate in or out.
    let is_free = |part: &Part| {
        matches!(part.boundary, PartBoundary::Velocity { .. } | PartBoundary::Pressure { .. })
    };
    let balanced = faces().any(|face| matches!(face, Face::Pressure { .. }))
        || scene.parts.iter().any(is_free);
    if !balanced && let Some(finding) = pistons(scene) {
        return Some(finding);
    }
    let driven = faces().any(|face| matches!(face, Face::Velocity(_)));
    if balanced || !driven {
        return None;
    }
    let (mut net, mut gross) = (0.0, 0.0);
    for axis in 0..3 {
        for (side, inward) in [(0, 1.0), (1, -1.0)] {
            if let Face::Velocity(open) = &scene.domain.faces[axis][side] {
                let rate = inward * rate(scene, axis, open);
                net += rate;
                gross += rate.abs();
            }
        }
    }
    let courses: Vec<&Course> = faces()
        .filter_map(|face| match face {
            Face::Velocity(open) => Some(&open.course),
            _ => None,
        })
        .collect();
    let apart = courses.windows(2).any(|pair| pair[0] != pair[1]);
    let finding = Finding::new("net flow into the domain", net, "m3/s");
    let finding = finding.doubtful_if(
        apart,
        "faces with a given velocity have different courses and no face has a pressure, so the pressure rises or falls \
         while they do not balance",
        "give them one course, or one face a pressure, as { pressure = \"0 Pa\" }",
    );
    Some(finding.wrong_if(
        // Velocities that balance by hand may differ in their last digits.
        net.abs() > 1e-6 * gross,
        "faces with a given velocity do not balance and no face has a pressure, so the pressure rises or falls without end",
        "give one face a pressure, as { pressure = \"0 Pa\" }",
    ))
}

/// Flow that the pistons of reservoirs displace where it has no way out [m³/s]. A reservoir gives
/// way, so the pressure rises only as long as a piston moves.
fn pistons(scene: &Scene) -> Option<Finding> {
    let of_faces = scene.domain.faces.iter().flatten().filter_map(|face| match face {
        Face::Reservoir(reservoir) => Some(reservoir),
        _ => None,
    });
    let of_parts = scene.parts.iter().filter_map(|part| match &part.boundary {
        PartBoundary::Reservoir(reservoir) => Some(reservoir),
        _ => None,
    });
    let reservoirs: Vec<&Reservoir> = of_faces.chain(of_parts).collect();
    let net = reservoirs.iter().map(|r| r.piston * r.area).reduce(|a, b| a + b)?;
    let is_endless = |r: &&Reservoir| r.stop.is_none() && r.piston != 0.0;
    let finding = Finding::new("flow displaced by pistons", net, "m3/s");
    Some(finding.doubtful_if(
        reservoirs.iter().any(is_endless),
        "a piston moves without end and no face has a pressure, so it compresses the fluid until the run fails",
        "give one face a pressure, as { pressure = \"0 Pa\" }, or the piston a stop",
    ))
}

/// Rate of flow along the axis through a face, at the course's factor 1 [m³/s].
fn rate(scene: &Scene, axis: usize, open: &OpenVelocity) -> f64 {
    let size = scene.domain.size();
    let across = (0..3).filter(|a| *a != axis);
    let mean = |a: usize| match open.profile {
        // The mean of 4 s (1 - s).
        Profile::Parabolic if !scene.domain.is_periodic(a) => 2.0 / 3.0,
        _ => 1.0,
    };
    across.fold(open.velocity[axis], |rate, a| rate * mean(a) * size[a])
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Verdict;
    use tremie_messages::scene::{Domain, FluidMaterial, Outflow};

    fn scene(lower: Face, upper: Face) -> Scene {
        let domain = Domain::new(
            [0.0; 3],
            [1.0, 2.0, 3.0],
            [[lower, upper], [Face::WALL, Face::WALL], [Face::Periodic, Face::Periodic]],
        );
        Scene { fluid: Some(FluidMaterial::at_rest(1e3, 1e-3)), ..Scene::empty(domain) }
    }

    fn open(velocity: f64, profile: Profile) -> Face {
        let velocity = [velocity, 0.0, 0.0];
        Face::Velocity(OpenVelocity { velocity, profile, course: Course::default() })
    }

    #[test]
    fn what_flows_in_must_flow_out() {
        let inflow = open(0.3, Profile::Parabolic);
        let closed = findings(&scene(inflow.clone(), Face::WALL)).unwrap();
        assert_eq!(closed.verdict, Verdict::Wrong);
        assert!((closed.value - 0.3 * 2.0 / 3.0 * 6.0).abs() < 1e-12, "{}", closed.value);
        let through = findings(&scene(inflow.clone(), open(0.2, Profile::Uniform))).unwrap();
        assert_eq!(through.verdict, Verdict::Ok, "{through:?}");
        let mut late = open(0.2, Profile::Uniform);
        if let Face::Velocity(open) = &mut late {
            open.course = Course::Points(vec![[0.0, 0.0], [1.0, 1.0]]);
        }
        let apart = findings(&scene(inflow.clone(), late)).unwrap();
        assert_eq!(apart.verdict, Verdict::Doubtful, "{apart:?}");
        let pressure =
            Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
        assert_eq!(findings(&scene(inflow, pressure)), None);
        assert_eq!(findings(&scene(Face::WALL, Face::WALL)), None);
    }

    #[test]
    fn a_piston_needs_a_way_out_or_an_end() {
        let mut reservoir = Reservoir::new(6.0, 1.0, 0.5);
        let endless = findings(&scene(Face::Reservoir(reservoir.clone()), Face::WALL)).unwrap();
        assert_eq!((endless.verdict, endless.value), (Verdict::Doubtful, 3.0));
        reservoir.stop = Some(1.0);
        let stroke = findings(&scene(Face::Reservoir(reservoir.clone()), Face::WALL)).unwrap();
        assert_eq!(stroke.verdict, Verdict::Ok);
        let outlet =
            Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
        assert_eq!(findings(&scene(Face::Reservoir(reservoir), outlet)), None);
    }
}
