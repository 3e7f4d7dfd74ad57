//! Demands of a scene that this fluid cannot meet.

use crate::boundary::virtual_piston::reservoir_state::reservoirs_of;
use crate::lattice::reservoir_place::ReservoirPlace;
use tremie_fluid_kit::checks::material_check::check_material;
use tremie_messages::Problem;
use tremie_messages::scene::{
    Course, DeformableSurface, Domain, Face, FluidMaterial, Gap, GapRegion, GapRule, GapSide,
    GapWeight, Motion, PartBoundary, ProbeShape, Reservoir, Ring, Scene,
};

/// Checks of the scene that concern a fluid.
pub fn check_scene(scene: &Scene, problems: &mut Vec<Problem>) {
    let Some(fluid) = check_material(scene, problems) else { return };
    check_kind(scene, fluid, problems);
    check_domain(&scene.domain, problems);
    check_open(scene, problems);
    check_reservoirs(scene, problems);
    for (index, gap) in scene.gaps.iter().enumerate() {
        check_gap(scene, gap, &format!("scene.gaps[{index}]"), problems);
    }
    for (index, surface) in scene.surfaces.iter().enumerate() {
        check_surface(scene, surface, &format!("scene.surfaces[{index}]"), problems);
    }
    for (index, part) in scene.parts.iter().enumerate() {
        if part.motion != Motion::Fixed && part.cavity {
            problems.push(
                Problem::new(
                    format!("scene.parts[{index}].cavity"),
                    format!("{} moves; the lattice-Boltzmann fluid knows cavities only of parts that stand still", part.name),
                )
                .help("fix the part, or make it a solid"),
            );
        }
        if part.motion != Motion::Fixed && part.boundary != PartBoundary::Wall {
            problems.push(
                Problem::new(
                    format!("scene.parts[{index}].boundary"),
                    format!(
                        "{} moves; the lattice-Boltzmann fluid knows velocity, pressure and reservoirs only of parts that stand still",
                        part.name
                    ),
                )
                .help("fix the part, or make it a wall"),
            );
        }
    }
}

/// Checks that the scene is one in space whose fluid has no surface.
fn check_kind(scene: &Scene, fluid: &FluidMaterial, problems: &mut Vec<Problem>) {
    if !fluid.fill.is_empty() {
        let found = "the lattice-Boltzmann fluid fills all its space: it has no free surface";
        let help = "leave the regions out, or take a fluid with a surface: fluid = \"fluid-pic\"";
        problems.push(Problem::new("scene.fluid.fill[0]", found).help(help));
    }
    if let Some(axis) = (0..3).find(|&a| scene.domain.levels[a].iter().any(Option::is_some)) {
        let name = ["x", "y", "z"][axis];
        let found = "an open face has a level, but the lattice-Boltzmann fluid has no free surface";
        let help = "leave the level out, or take a fluid with a surface: fluid = \"fluid-pic\"";
        problems.push(Problem::new(format!("scene.domain.{name}"), found).help(help));
    }
    if scene.domain.across.is_some() {
        let found =
            "the scene is plane, but the lattice-Boltzmann fluid knows scenes in space only";
        let help = "leave it out and take spheres, or take fluid = \"fluid-pic\"";
        problems.push(Problem::new("scene.domain.across", found).help(help));
    }
}

/// Checks of a deformable surface.
fn check_surface(
    scene: &Scene,
    surface: &DeformableSurface,
    key: &str,
    problems: &mut Vec<Problem>,
) {
    if !scene.parts.iter().any(|part| part.name == surface.carrier) {
        let found = format!("no part is named {}", surface.carrier);
        let problem = Problem::new(format!("{key}.carrier"), found);
        problems.push(problem.help("name the part that carries it"));
    }
    if surface.sectors < 3 {
        let found = format!("needs at least 3, found {}", surface.sectors);
        problems.push(Problem::new(format!("{key}.sectors"), found).help("60 suits a round seal"));
    }
    let (edges, points) = (&surface.section.edges, surface.section.points.len());
    if let Some(point) = edges.iter().flat_map(|edge| edge.points).find(|&p| p as usize >= points) {
        let found = format!("an edge names point {point}, but there are {points}");
        let problem = Problem::new(format!("{key}.section"), found);
        problems.push(problem.help("points are numbered from 0"));
    }
}

/// Checks of what open faces and parts prescribe.
fn check_open(scene: &Scene, problems: &mut Vec<Problem>) {
    let mut check = |key: String, numbers: &[f64], course: &Course| {
        if !numbers.iter().all(|x| x.is_finite()) {
            problems.push(Problem::new(key, "holds a number that is not finite"));
        } else if let Some(flaw) = course.flaw() {
            problems.push(Problem::new(key, flaw));
        }
    };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for face in &scene.domain.faces[axis] {
            let key = format!("scene.domain.faces.{name}");
            match face {
                Face::Velocity(open) => check(key, &open.velocity, &open.course),
                Face::Pressure { pressure, course, .. } => check(key, &[*pressure], course),
                Face::Wall { velocity, course } => check(key, velocity, course),
                Face::Reservoir(reservoir) => {
                    check(key, &reservoir_numbers(reservoir), &reservoir.course);
                }
                Face::Periodic | Face::Symmetry => {}
            }
        }
    }
    for (index, part) in scene.parts.iter().enumerate() {
        let key = format!("scene.parts[{index}].boundary");
        match &part.boundary {
            PartBoundary::Wall => {}
            PartBoundary::Velocity { velocity, course } => check(key, velocity, course),
            PartBoundary::Pressure { pressure, course } => check(key, &[*pressure], course),
            PartBoundary::Reservoir(reservoir) => {
                check(key, &reservoir_numbers(reservoir), &reservoir.course);
            }
        }
    }
    check_probes(scene, problems);
}

/// Checks probes and planes.
fn check_probes(scene: &Scene, problems: &mut Vec<Problem>) {
    for (index, probe) in scene.probes.iter().enumerate() {
        let numbers: Vec<f64> = match &probe.shape {
            ProbeShape::Point(point) => point.to_vec(),
            ProbeShape::Line { from, to } => [*from, *to].concat(),
            ProbeShape::Section { position, min, max, .. }
            | ProbeShape::Profile { position, min, max, .. } => {
                [&[*position][..], min, max].concat()
            }
            ProbeShape::Region { min, max } => [*min, *max].concat(),
            ProbeShape::Ring(ring) => [&ring.through[..], &ring.radii, &ring.heights].concat(),
        };
        let key = format!("scene.probes[{index}]");
        if !numbers.iter().all(|x| x.is_finite()) {
            problems.push(Problem::new(key, "holds a number that is not finite"));
        } else if matches!(&probe.shape, ProbeShape::Section { axis, .. } | ProbeShape::Ring(Ring { axis, .. }) if *axis > 2)
        {
            problems.push(Problem::new(key, "its axis must be 0, 1 or 2 for x, y or z"));
        } else if let ProbeShape::Profile { axis, min, max, along, bins, .. } = &probe.shape
            && (*axis > 2
                || *along > 2
                || axis == along
                || min[*along] >= max[*along]
                || !(1..=ProbeShape::MOST_BINS).contains(bins))
        {
            let message = format!(
                "its two axes must be different ones of 0, 1 and 2, its corners in order, its strips 1 to {}",
                ProbeShape::MOST_BINS
            );
            problems.push(Problem::new(key, message));
        }
    }
    for (index, plane) in scene.planes.iter().enumerate() {
        let length = plane.normal.iter().map(|x| x * x).sum::<f64>();
        // Asked this way round, numbers that are not finite fail, too.
        if !((length - 1.0).abs() < 1e-6 && plane.point.iter().all(|x| x.is_finite())) {
            problems.push(Problem::new(
                format!("scene.planes[{index}].normal"),
                format!("must have length 1, found {:?}", plane.normal),
            ));
        }
    }
}

/// All numbers of a reservoir but those of its course.
fn reservoir_numbers(reservoir: &Reservoir) -> [f64; 5] {
    let Reservoir { area, volume, piston, relaxation, stop, .. } = *reservoir;
    [area, volume, piston, relaxation, stop.unwrap_or(0.0)]
}

/// Checks of what only makes sense within bounds.
fn check_reservoirs(scene: &Scene, problems: &mut Vec<Problem>) {
    let at_faces: Vec<String> = reservoirs_of(scene)
        .filter(|(place, _)| matches!(place, ReservoirPlace::Face { .. }))
        .map(|(place, _)| place.name(scene))
        .collect();
    for (place, reservoir) in reservoirs_of(scene) {
        let key = place.key();
        if let ReservoirPlace::Part(index) = place
            && at_faces.contains(&scene.parts[index].name)
        {
            let found = "the reservoir at the face of this name has the same signals";
            let key = format!("scene.parts[{index}].name");
            problems.push(Problem::new(key, found).help("give the part another name"));
        }
        for (what, value, unit) in
            [("area", reservoir.area, "m²"), ("volume", reservoir.volume, "m³")]
        {
            if value <= 0.0 {
                let found =
                    format!("the reservoir's {what} must be positive, found {value} {unit}");
                problems.push(Problem::new(&key, found));
            }
        }
        if !(0.0..=1.0).contains(&reservoir.relaxation) {
            let found = format!(
                "the reservoir's relaxation must be from 0 to 1, found {}",
                reservoir.relaxation
            );
            problems.push(Problem::new(&key, found).help("0.02 is the default; 0 switches it off"));
        }
    }
}

/// Thickest gap that may be frozen or slip [cells]: beyond, a lattice resolves it.
const THICKEST_GAP: f64 = 8.0;

/// Checks of a gap that opens and closes.
fn check_gap(scene: &Scene, gap: &Gap, key: &str, problems: &mut Vec<Problem>) {
    let mut problem = |what: &str, message: String, help: &str| {
        problems.push(Problem::new(format!("{key}.{what}"), message).help(help));
    };
    for side in &gap.between {
        match side {
            GapSide::Part(name)
                if !scene.parts.iter().any(|part| part.name == *name)
                    && !scene.surfaces.iter().any(|surface| surface.name == *name) =>
            {
                let help = "name a part, a surface or a face";
                problem("between", format!("no part or surface is named {name}"), help);
            }
            GapSide::Face { axis, side }
                if !(*axis < 3
                    && *side < 2
                    && matches!(scene.domain.faces[*axis][*side], Face::Wall { .. })) =>
            {
                let help = "a gap is between parts and walls of the domain";
                problem("between", format!("face {side} of axis {axis} is no wall"), help);
            }
            GapSide::Part(_) | GapSide::Face { .. } => {}
        }
    }
    if gap.between[0] == gap.between[1] {
        problem("between", "both sides are the same".into(), "name two");
    }
    let ordered = 0.0 <= gap.close_at && gap.close_at <= gap.open_at;
    if !(ordered && gap.open_at > 0.0 && gap.open_at <= THICKEST_GAP) {
        let found = format!(
            "needs 0 <= close_at <= open_at <= {THICKEST_GAP} cells, found {} and {}",
            gap.close_at, gap.open_at
        );
        problem("open_at", found, "1.5 and 0.5 suit a flat gap, 2 and 0.5 a slanted one");
    }
    if !(0.0..=THICKEST_GAP).contains(&gap.slip_below) {
        let found = format!("must be from 0 to {THICKEST_GAP} cells, found {}", gap.slip_below);
        problem("slip_below", found, "3 suits a gap that closes; 0 keeps the walls rough");
    }
    if let GapRule::Probes(weights) = &gap.pressure {
        for GapWeight { probe, weight } in weights {
            if !scene.probes.iter().any(|known| known.name == *probe) {
                problem("pressure", format!("no probe is named {probe}"), "add it to the scene");
            }
            if !(weight.is_finite() && *weight >= 0.0) {
                let found = format!("weights must not be negative, found {weight}");
                problem("pressure", found, "equal weights give the mean");
            }
        }
        if weights.iter().map(|w| w.weight).sum::<f64>() <= 0.0 {
            problem("pressure", "no probe has a weight".into(), "name at least one probe");
        }
    }
    let (finite, ascend) = match gap.region {
        None => (true, true),
        Some(GapRegion::Box { min, max }) => {
            (min.iter().chain(&max).all(|x| x.is_finite()), (0..3).all(|a| min[a] < max[a]))
        }
        Some(GapRegion::Ring { axis, through, radii }) => (
            through.iter().chain(&radii).all(|x| x.is_finite()),
            axis < 3 && 0.0 <= radii[0] && radii[0] < radii[1],
        ),
    };
    if !(finite && ascend) {
        let help = "a box needs min below max, a ring an inner radius below the outer";
        problem("region", "holds no point".into(), help);
    }
}

/// Checks of the box and its faces.
fn check_domain(domain: &Domain, problems: &mut Vec<Problem>) {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let size = domain.size()[axis];
        if !(size.is_finite() && size > 0.0) {
            problems.push(Problem::new(
                "scene.domain.max",
                format!("the domain's edge along {name} must be positive, found {size} m"),
            ));
        }
        let [lower, upper] = &domain.faces[axis];
        if (*lower == Face::Periodic) != (*upper == Face::Periodic) {
            problems.push(Problem::new(
                format!("scene.domain.faces.{name}"),
                "one face is periodic and the other is not; a periodic face needs its opposite",
            ));
        }
    }
}
