//! Checks of `[scene.fluid]`: the material, the points, and the regions that hold it.

use super::super::document::{FillTable, FluidTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::{gas, probes};
use tremie_messages::scene::{Domain, Fill, FluidMaterial};
use tremie_messages::units::Length;

/// The fluid, if the scene has one; inside it is `None` where it is wrong.
pub(super) fn fluid(
    scene: &SceneTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Option<FluidMaterial>> {
    scene.fluid.as_ref().map(|fluid| material(scene, fluid, domain, findings))
}

fn material(
    scene: &SceneTable,
    table: &FluidTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<FluidMaterial> {
    let at = "scene.fluid";
    let fill = fills(scene, table, domain, findings);
    let gas = gas::gas(table, domain, findings);
    let density = findings.positive(&table.density, at, "density");
    let viscosity = findings.positive(&table.viscosity, at, "viscosity");
    let expected =
        table.expected_speed.map(|speed| findings.above_zero(speed, "scene.fluid.expected_speed"));
    for (key, points) in [("inside", &table.inside), ("outside", &table.outside)] {
        for (i, point) in points.iter().enumerate() {
            let key = path::item(&path::join(at, key), i);
            if let Some(domain) = domain {
                probes::inside(&point.map(|x| x.0), domain, &key, findings);
            }
        }
    }
    if table.inside.is_empty() && !table.outside.is_empty() {
        let key = path::join(at, "outside");
        let message = "there is no `inside`: a leak is a way from a point inside to one outside";
        findings.problem_with_help(&key, message, "add inside = [[X, Y, Z]], a point in the fluid");
    }
    let points = |list: &[[_; 3]]| list.iter().map(|point| point.map(metres)).collect();
    Some(FluidMaterial {
        density: density?,
        viscosity: viscosity?,
        acceleration: table.acceleration?.map(|a| a.0),
        velocity: table.velocity?.map(|v| v.0),
        pressure: table.pressure?.0,
        inside: points(&table.inside),
        outside: points(&table.outside),
        fill: fill?,
        gas: gas::if_there(gas)?,
        expected_speed: if expected == Some(false) {
            return None;
        } else {
            table.expected_speed.map(|v| v.0)
        },
    })
}

fn metres(length: Length) -> f64 {
    length.0
}

fn fills(
    scene: &SceneTable,
    table: &FluidTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vec<Fill>> {
    let all: Vec<_> = (table.fill.iter().enumerate())
        .map(|(k, fill)| {
            fill_region(scene, fill, &path::item("scene.fluid.fill", k), domain, findings)
        })
        .collect();
    all.into_iter().collect()
}

fn fill_region(
    scene: &SceneTable,
    table: &FillTable,
    at: &str,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Fill> {
    let is_box = table.min.is_some() || table.max.is_some();
    if !(is_box || table.level.is_some() || table.part.is_some()) {
        let message = "found no region, expected a box (min, max), a level or a part";
        findings.problem_with_help(at, message, "for a tank filled to a level: level = \"12 cm\"");
        return None;
    }
    if let Some(name) = &table.part
        && !scene.parts.iter().any(|part| part.name.as_ref() == Some(name))
    {
        let message = format!("found \"{name}\", expected the name of a part of the scene");
        findings.problem(&path::join(at, "part"), message);
        return None;
    }
    let domain = domain?;
    let min = table.min.map_or(domain.min, |min| min.map(metres));
    let mut max = table.max.map_or(domain.max, |max| max.map(metres));
    if let Some(level) = table.level {
        let up = up_axis(scene, at, findings)?;
        max[up] = max[up].min(level.0);
        if level.0 <= domain.min[up] {
            let message = format!(
                "found {} m, at or below the bottom of the domain, {} m: expected a level above it",
                level.0, domain.min[up]
            );
            findings.problem(&path::join(at, "level"), message);
            return None;
        }
    }
    if !holds_points([&min, &max], domain, at, findings) {
        return None;
    }
    Some(Fill {
        min,
        max,
        part: table.part.clone(),
        velocity: table.velocity.map(|v| v.map(|v| v.0)),
    })
}

/// True if a region of these corners has points in the domain; a problem if not.
pub(super) fn holds_points(
    [min, max]: [&[f64; 3]; 2],
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> bool {
    let is_empty =
        |a: usize| min[a] >= max[a] || max[a] <= domain.min[a] || min[a] >= domain.max[a];
    let Some(axis) = (0..3).find(|&a| is_empty(a)) else { return true };
    let name = ["x", "y", "z"][axis];
    let message = format!(
        "holds no point: along {name} it goes from {} m to {} m, in a domain from {} m to {} m",
        min[axis], max[axis], domain.min[axis], domain.max[axis]
    );
    findings.problem(at, message);
    false
}

/// The axis along which gravity acts downwards, for a level.
fn up_axis(scene: &SceneTable, at: &str, findings: &mut Findings) -> Option<usize> {
    let gravity = scene.gravity?.map(|g| g.0);
    let down: Vec<usize> = (0..3).filter(|&a| gravity[a] != 0.0).collect();
    match down[..] {
        [axis] if gravity[axis] < 0.0 => Some(axis),
        _ => {
            let message = format!(
                "a level needs gravity down one axis, as [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]; found {gravity:?} m/s2"
            );
            let help = "give gravity, or write the region as a box: min and max";
            findings.problem_with_help(&path::join(at, "level"), message, help);
            None
        }
    }
}
