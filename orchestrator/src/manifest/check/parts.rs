//! Checks of `[[scene.parts]]`.

use super::super::document::{
    BoundaryTable, MotionCourseEntry, MotionName, PartMotionEntry, PartMotionTable, PartTable,
    RotationTable,
};
use super::super::path;
use super::super::read::Findings;
use super::course::{course, motion};
use super::domain::reservoir;
use super::slider;
use std::collections::BTreeSet;
use tremie_messages::scene::{Domain, Geometry, Motion, MotionPoint, Part, PartBoundary, Pose};

pub(super) fn parts(tables: &[PartTable], findings: &mut Findings) -> Vec<Option<Part>> {
    let mut names = BTreeSet::new();
    (tables.iter().enumerate())
        .map(|(i, table)| part(table, &path::item("scene.parts", i), &mut names, findings))
        .collect()
}

fn part(
    table: &PartTable,
    at: &str,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<Part> {
    let name = name(&table.name, "part", at, names, findings);
    let geometry = geometry(table, at, findings);
    let orientation = match &table.rotation {
        Some(rotation) => orientation(rotation, &path::join(at, "rotation"), findings),
        None => Some(Pose::IDENTITY.orientation),
    };
    let motion = part_motion(table, at, findings);
    let boundary = match &table.boundary {
        Some(boundary) => part_boundary(boundary, &path::join(at, "boundary"), findings),
        None => Some(PartBoundary::Wall),
    };
    let (position, motion) = (table.position?.map(|x| x.0), motion?);
    Some(Part {
        name: name?,
        geometry: geometry?,
        pose: Pose { position: start(position, &motion), orientation: orientation? },
        cavity: table.cavity?,
        material: table.material.clone().unwrap_or_else(|| Domain::MATERIAL.into()),
        motion,
        boundary: boundary?,
    })
}

/// The name of a `what`, which becomes part of the names of signals.
pub(super) fn name(
    name: &Option<String>,
    what: &str,
    at: &str,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<String> {
    let taken = |name: &str| format!("a second {what} with the name \"{name}\"");
    findings.name(name, at, &['-'], names, taken)
}

fn geometry(table: &PartTable, at: &str, findings: &mut Findings) -> Option<Geometry> {
    let kinds = [
        ("file", table.file.is_some()),
        ("box", table.box_.is_some()),
        ("cylinder", table.cylinder.is_some()),
        ("sphere", table.sphere.is_some()),
        ("revolved", table.revolved.is_some()),
        ("extrusion", table.extrusion.is_some()),
    ];
    let kind = findings.only_one(&kinds, "the part's surface", at)?;
    if kind != "file" && table.unit.is_some() {
        let message = "only a file has a unit; lengths here have their own";
        findings.problem(&path::join(at, "unit"), message);
    }
    let key = path::join(at, kind);
    match kind {
        "file" => {
            let unit = table.unit.map(|unit| unit.0);
            if unit.is_none() && !findings.is_unreadable(&path::join(at, "unit")) {
                let message = "missing: what one unit of the file is; triangles are bare numbers";
                let help = "add unit = \"mm\" where the file was drawn in millimetres";
                findings.problem_with_help(&path::join(at, "unit"), message, help);
            }
            let unit = findings.positive(&Some(unit?), at, "unit")?;
            Some(Geometry::File { path: table.file.clone()?, unit })
        }
        "box" => {
            let size = findings.required(&table.box_.as_ref()?.size, &key, "size")?;
            let key = path::join(&key, "size");
            let right: Vec<bool> = (size.iter().enumerate())
                .map(|(axis, edge)| findings.above_zero(*edge, &path::item(&key, axis)))
                .collect();
            right.iter().all(|right| *right).then(|| Geometry::Box { size: size.map(|x| x.0) })
        }
        "cylinder" => {
            let cylinder = table.cylinder.as_ref()?;
            let radius = findings.positive(&cylinder.radius, &key, "radius");
            let length = findings.positive(&cylinder.length, &key, "length");
            Some(Geometry::Cylinder { radius: radius?, length: length? })
        }
        "revolved" => {
            let profile = findings.required(&table.revolved.as_ref()?.profile, &key, "profile")?;
            Some(Geometry::Revolved { profile: profile.iter().map(|p| p.map(|x| x.0)).collect() })
        }
        "extrusion" => {
            let table = table.extrusion.as_ref()?;
            let outline = findings.required(&table.outline, &key, "outline");
            let axis = findings.required(&table.axis, &key, "axis");
            let length = findings.positive(&table.length, &key, "length");
            let outline = outline?.iter().map(|p| p.map(|x| x.0)).collect();
            Some(Geometry::Extruded { outline, axis: axis?.number(), length: length? })
        }
        _ => {
            let radius = findings.positive(&table.sphere.as_ref()?.radius, &key, "radius");
            Some(Geometry::Sphere { radius: radius? })
        }
    }
}

/// The unit quaternion `(x, y, z, w)` of a rotation by an angle about an axis. By `libm`, so that
/// it has the same bits on every machine.
pub(super) fn orientation(
    table: &RotationTable,
    at: &str,
    findings: &mut Findings,
) -> Option<[f64; 4]> {
    let axis = findings.required(&table.axis, at, "axis");
    let angle = findings.required(&table.angle, at, "angle");
    let axis = axis?;
    let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    if !(length.is_normal() && length.is_finite()) {
        let message = format!("found {axis:?}, expected a direction, which has a length");
        findings.problem(&path::join(at, "axis"), message);
        return None;
    }
    let (sine, cosine) = libm::sincos(0.5 * angle?.0);
    let [x, y, z] = axis.map(|a| sine * a / length);
    Some([x, y, z, cosine])
}

fn part_motion(table: &PartTable, at: &str, findings: &mut Findings) -> Option<Motion> {
    let constant = table.velocity.is_some() || table.angular_velocity.is_some();
    let key = path::join(at, "motion");
    let name = match table.motion.as_ref()? {
        PartMotionEntry::Name(name) => *name,
        PartMotionEntry::Table(motion) => return sliding(table, motion, at, findings),
    };
    match name {
        MotionName::Free => {
            findings.problem_with_help(
                &key,
                "found \"free\", expected \"fixed\" or \"prescribed\", or a slider: parts have one degree of freedom at most",
                "write motion = { slider = { axis = [0, 0, 1], mass = \"9.2 g\" } }, or give the part's velocity with motion = \"prescribed\"",
            );
            return None;
        }
        MotionName::Fixed if constant => {
            let message = "found \"fixed\", but the part has a velocity";
            findings.problem_with_help(&key, message, "write motion = \"prescribed\"");
            return None;
        }
        MotionName::Prescribed
            if constant && matches!(table.course, Some(MotionCourseEntry::Points(_))) =>
        {
            let message = "found a constant velocity too, expected one of them";
            findings.problem(&path::join(at, "course"), message);
            return None;
        }
        _ => {}
    }
    let velocity = table.velocity.unwrap_or_default().map(|v| v.0);
    let angular_velocity = table.angular_velocity.unwrap_or_default().map(|w| w.0);
    if name == MotionName::Prescribed && table.course.is_none() {
        let point = MotionPoint { time: 0.0, velocity, angular_velocity };
        return Some(Motion::Prescribed(vec![point]));
    }
    let mut motion = motion(name, table.course.as_ref(), at, findings)?;
    if let Motion::Timed(timed) = &mut motion {
        if !constant {
            let message = "found a formula for a factor, but no velocity that it could multiply";
            let help = "give the part a velocity or an angular_velocity";
            findings.problem_with_help(&path::join(at, "course"), message, help);
            return None;
        }
        (timed.velocity, timed.angular_velocity) = (velocity, angular_velocity);
    }
    if matches!(&motion, Motion::Prescribed(points) if points.is_empty()) {
        findings
            .problem(&path::join(at, "course"), "found an empty list, expected a point in time");
        return None;
    }
    Some(motion)
}

/// A motion under forces, where no velocity is given besides.
fn sliding(
    table: &PartTable,
    motion: &PartMotionTable,
    at: &str,
    findings: &mut Findings,
) -> Option<Motion> {
    let key = path::join(at, "motion");
    let given = [
        ("velocity", table.velocity.is_some()),
        ("angular_velocity", table.angular_velocity.is_some()),
        ("course", table.course.is_some()),
    ];
    if let Some((name, _)) = given.iter().find(|(_, given)| *given) {
        let message = "only a prescribed motion has it; a slider moves under forces";
        findings.problem(&path::join(at, name), message);
        return None;
    }
    let Some(given) = &motion.slider else {
        if !findings.is_unreadable(&key) {
            let message = "found an empty table, expected slider";
            findings.problem(&key, message);
        }
        return None;
    };
    slider::slider(given, &path::join(&key, "slider"), findings)
        .map(|slider| Motion::Slider(Box::new(slider)))
}

/// Position of a part at the start: a slider away from lift 0 is further along its axis.
fn start(position: [f64; 3], motion: &Motion) -> [f64; 3] {
    let Motion::Slider(slider) = motion else { return position };
    let length = slider.axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    std::array::from_fn(|a| position[a] + slider.lift * (slider.axis[a] / length))
}

fn part_boundary(table: &BoundaryTable, at: &str, findings: &mut Findings) -> Option<PartBoundary> {
    let kinds = [
        ("velocity", table.velocity.is_some()),
        ("pressure", table.pressure.is_some()),
        ("reservoir", table.reservoir.is_some()),
    ];
    let kind = findings.only_one(&kinds, "what the part is to the fluid", at);
    if kind == Some("reservoir") {
        let has_none = [("ramp", table.ramp.is_some()), ("course", table.course.is_some())];
        let reservoir = reservoir(table.reservoir.as_ref(), &has_none, at, findings);
        return reservoir.map(PartBoundary::Reservoir);
    }
    let course = course(table.ramp, table.course.as_ref(), at, findings);
    match kind? {
        "velocity" => {
            let velocity = table.velocity?.map(|v| v.0);
            Some(PartBoundary::Velocity { velocity, course: course? })
        }
        _ => Some(PartBoundary::Pressure { pressure: table.pressure?.0, course: course? }),
    }
}
