//! Checks of `[scene.domain]`: the box and its faces.

use super::super::document::{
    AxisEntry, DomainTable, FaceEntry, FaceName, FaceTable, ReservoirTable,
};
use super::super::path;
use super::super::read::Findings;
use super::course::course;
use tremie_messages::scene::{Domain, Face, OpenVelocity, Outflow, Profile, Reservoir};

const AXES: [&str; 3] = ["x", "y", "z"];

pub(super) fn domain(table: &DomainTable, findings: &mut Findings) -> Option<Domain> {
    let size = findings.required(&table.size, "scene.domain", "size");
    let mut right = true;
    for (axis, length) in size.iter().flatten().enumerate() {
        right &= findings.above_zero(*length, &path::item("scene.domain.size", axis));
    }
    let entries = [&table.x, &table.y, &table.z];
    let faces: [Option<[Face; 2]>; 3] = std::array::from_fn(|axis| {
        let at = path::join("scene.domain", AXES[axis]);
        entries[axis].as_ref().and_then(|entry| faces(entry, axis, &at, findings))
    });
    let (size, min) = (size?, table.origin?.map(|length| length.0));
    let [x, y, z] = faces;
    let faces = [x?, y?, z?];
    let levels = levels(&entries, &faces, findings);
    right.then(|| Domain {
        min,
        max: std::array::from_fn(|a| min[a] + size[a].0),
        faces,
        levels,
        across: table.across.map(|axis| axis.number()),
        material: table.material.clone().unwrap_or_else(|| Domain::MATERIAL.into()),
    })
}

/// Heights of the surface beyond open faces.
fn levels(
    entries: &[&Option<AxisEntry>; 3],
    faces: &[[Face; 2]; 3],
    findings: &mut Findings,
) -> [[Option<f64>; 2]; 3] {
    let mut levels = [[None; 2]; 3];
    for (axis, entry) in entries.iter().enumerate() {
        let Some(AxisEntry::Sides(sides)) = entry else { continue };
        for (side, (entry, end)) in
            [(&sides.lower, "lower"), (&sides.upper, "upper")].into_iter().enumerate()
        {
            let Some(FaceEntry::Table(table)) = entry else { continue };
            let Some(level) = table.level else { continue };
            if !matches!(faces[axis][side], Face::Velocity(_) | Face::Pressure { .. }) {
                let at = format!("scene.domain.{}.{end}.level", AXES[axis]);
                let message = "found a level at a face that is closed, or has a reservoir: only one with a velocity or a pressure has one";
                findings.problem(&at, message);
                continue;
            }
            levels[axis][side] = Some(level.0);
        }
    }
    levels
}

fn faces(entry: &AxisEntry, axis: usize, at: &str, findings: &mut Findings) -> Option<[Face; 2]> {
    let sides = match entry {
        AxisEntry::Both(name) => return Some([named(*name), named(*name)]),
        AxisEntry::Sides(sides) => sides,
    };
    let keys = [path::join(at, "lower"), path::join(at, "upper")];
    let lower = sides.lower.as_ref().and_then(|entry| face(entry, axis, &keys[0], findings));
    let upper = sides.upper.as_ref().and_then(|entry| face(entry, axis, &keys[1], findings));
    let pair = [lower?, upper?];
    let [lower_wraps, upper_wraps] = [0, 1].map(|side| pair[side] == Face::Periodic);
    if lower_wraps != upper_wraps {
        let name = AXES[axis];
        let message = "found \"periodic\" for one face, but it joins both";
        let help = format!("write {name} = \"periodic\", or give this face another kind");
        findings.problem_with_help(&keys[usize::from(upper_wraps)], message, help);
        return None;
    }
    Some(pair)
}

fn named(name: FaceName) -> Face {
    match name {
        FaceName::Wall => Face::WALL,
        FaceName::Periodic => Face::Periodic,
        FaceName::Symmetry => Face::Symmetry,
    }
}

fn face(entry: &FaceEntry, axis: usize, at: &str, findings: &mut Findings) -> Option<Face> {
    let table = match entry {
        FaceEntry::Name(name) => return Some(named(*name)),
        FaceEntry::Table(table) => table,
    };
    let kinds = [
        ("wall", table.wall.is_some()),
        ("velocity", table.velocity.is_some()),
        ("pressure", table.pressure.is_some()),
        ("reservoir", table.reservoir.is_some()),
    ];
    let kind = findings.only_one(&kinds, "what the face is", at)?;
    if kind != "pressure" && table.absorbing.is_some() {
        let message =
            format!("a face with a {kind} throws sound back; only a pressure can absorb it");
        findings.problem(&path::join(at, "absorbing"), message);
    }
    if kind != "pressure" && table.outflow.is_some() {
        let message = format!("found an outflow at a face with a {kind}; only a pressure has one");
        findings.problem(&path::join(at, "outflow"), message);
    }
    match kind {
        "wall" => moving_wall(table, axis, at, findings),
        "velocity" => open_velocity(table, axis, at, findings),
        "reservoir" => {
            let has_none = [
                ("profile", table.profile.is_some()),
                ("ramp", table.ramp.is_some()),
                ("course", table.course.is_some()),
            ];
            reservoir(table.reservoir.as_ref(), &has_none, at, findings).map(Face::Reservoir)
        }
        _ => {
            if table.profile.is_some() {
                let message = "a pressure is the same all over the face, and has no profile";
                findings.problem(&path::join(at, "profile"), message);
            }
            let course = course(table.ramp, table.course.as_ref(), at, findings);
            let outflow = outflow(table, at, findings)?;
            Some(Face::Pressure { pressure: table.pressure?.0, course: course?, outflow })
        }
    }
}

/// The outflow of a face with a pressure.
fn outflow(table: &FaceTable, at: &str, findings: &mut Findings) -> Option<Outflow> {
    let is_absorbing = table.absorbing == Some(true);
    if is_absorbing && table.outflow.is_some_and(|outflow| outflow != Outflow::Absorbing) {
        let message = "found absorbing = true and another outflow, expected one of them";
        findings.problem(&path::join(at, "outflow"), message);
        return None;
    }
    let otherwise = if is_absorbing { Outflow::Absorbing } else { Outflow::Fixed };
    Some(table.outflow.unwrap_or(otherwise))
}

fn moving_wall(table: &FaceTable, axis: usize, at: &str, findings: &mut Findings) -> Option<Face> {
    if table.profile.is_some() {
        findings.problem(&path::join(at, "profile"), "a moving wall has none");
    }
    let wall = table.wall.as_ref()?;
    let own = path::join(at, "wall");
    // The course may stand beside the wall, as with other faces, or in its table.
    let outside = table.ramp.is_some() || table.course.is_some();
    if outside && (wall.ramp.is_some() || wall.course.is_some()) {
        let message = "found a ramp or a course here and in the wall's table, expected one of them";
        findings.problem(at, message);
        return None;
    }
    let course = match outside {
        true => course(table.ramp, table.course.as_ref(), at, findings),
        false => course(wall.ramp, wall.course.as_ref(), &own, findings),
    };
    let velocity = findings.required(&wall.velocity, &own, "velocity")?;
    let velocity = velocity.map(|v| v.0);
    if velocity[axis] != 0.0 {
        let (name, normal) = (AXES[axis], velocity[axis]);
        findings.problem_with_help(
            &path::join(&own, "velocity"),
            format!(
                "found {normal} m/s along {name}, but a face across {name} moves only along itself"
            ),
            "for a fluid that enters or leaves, write velocity without wall",
        );
        return None;
    }
    Some(Face::Wall { velocity, course: course? })
}

/// The reservoir of a face or part at a path, which has none of the keys that are listed.
pub(super) fn reservoir(
    table: Option<&ReservoirTable>,
    has_none: &[(&str, bool)],
    at: &str,
    findings: &mut Findings,
) -> Option<Reservoir> {
    for (key, _) in has_none.iter().filter(|(_, is_there)| *is_there) {
        let message = "a reservoir has none; its piston may have a ramp or a course";
        findings.problem(&path::join(at, key), message);
    }
    let (at, table) = (path::join(at, "reservoir"), table?);
    let area = findings.positive(&table.area, &at, "area");
    let volume = findings.positive(&table.volume, &at, "volume");
    let course = course(table.ramp, table.course.as_ref(), &at, findings);
    let key = |name: &str| path::join(&at, name);
    let right = table.stop.is_none_or(|stop| findings.above_zero(stop, &key("stop")));
    let relaxation = table.relaxation.unwrap_or(Reservoir::RELAXATION);
    if !(0.0..=1.0).contains(&relaxation) {
        let message = format!("found {relaxation}, expected a number from 0 to 1");
        findings.problem(&key("relaxation"), message);
        return None;
    }
    let (area, volume, course) = (area?, volume?, course?);
    let piston = table.piston.map_or(0.0, |velocity| velocity.0);
    let stop = table.stop.map(|time| time.0);
    let reservoir = Reservoir::new(area, volume, piston);
    right.then_some(Reservoir { course, stop, relaxation, ..reservoir })
}

fn open_velocity(
    table: &FaceTable,
    axis: usize,
    at: &str,
    findings: &mut Findings,
) -> Option<Face> {
    let velocity = table.velocity?.map(|v| v.0);
    if velocity[axis] == 0.0 {
        let name = AXES[axis];
        findings.problem_with_help(
            &path::join(at, "velocity"),
            format!("found no velocity along {name}: nothing passes this face"),
            "for a wall that moves along itself, write wall = { velocity = [...] }",
        );
        return None;
    }
    let profile = table.profile.unwrap_or(Profile::Uniform);
    let course = course(table.ramp, table.course.as_ref(), at, findings)?;
    Some(Face::Velocity(OpenVelocity { velocity, profile, course }))
}
