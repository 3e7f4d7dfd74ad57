//! Checks of `[scene]`: domain, fluid, planes.

use super::super::document::{BodiesTable, DomainTable, FluidTable, PlaneTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::{bodies, contacts, placement};
use tremie_messages::scene::{ContactLaw, Domain, FluidMaterial, PairLaw, Plane, Scene};

pub(super) fn scene(table: &SceneTable, findings: &mut Findings) -> Option<Scene> {
    let domain = domain(&table.domain, findings);
    let fluid = table.fluid.as_ref().map(|fluid| material(fluid, findings));
    let planes = planes(&table.planes, findings);
    let bodies = bodies::bodies(&table.bodies, findings);
    let contacts = table.contacts.as_ref().map(|contacts| contacts::contacts(contacts, findings));
    if let Some(domain) = &domain {
        placement::check(domain, planes.as_deref().unwrap_or(&[]), &bodies, findings);
    }
    Some(Scene {
        gravity: table.gravity?.map(|g| g.0),
        domain: domain?,
        fluid: flatten(fluid)?,
        parts: Vec::new(),
        probes: Vec::new(),
        planes: planes?,
        contacts: pair_laws(&table.bodies, flatten(contacts)?),
        bodies: bodies.into_iter().collect::<Option<_>>()?,
    })
}

/// The two laws for every pair of materials.
fn pair_laws(sets: &[BodiesTable], laws: Option<[ContactLaw; 2]>) -> Vec<PairLaw> {
    let Some([body_body, body_wall]) = laws else { return Vec::new() };
    let names: Vec<&String> = sets.iter().filter_map(|set| set.name.as_ref()).collect();
    let mut pairs = Vec::new();
    for (i, one) in names.iter().enumerate() {
        for other in &names[i..] {
            pairs.push(PairLaw {
                between: [one.to_string(), other.to_string()],
                law: body_body.clone(),
            });
        }
        let between = [one.to_string(), Domain::MATERIAL.to_string()];
        pairs.push(PairLaw { between, law: body_wall.clone() });
    }
    pairs
}

/// `None` only where something is there and wrong.
fn flatten<T>(value: Option<Option<T>>) -> Option<Option<T>> {
    match value {
        Some(Some(value)) => Some(Some(value)),
        Some(None) => None,
        None => Some(None),
    }
}

fn domain(table: &DomainTable, findings: &mut Findings) -> Option<Domain> {
    let size = findings.required(&table.size, "scene.domain", "size")?;
    let mut right = true;
    for (axis, length) in size.iter().enumerate() {
        right &= findings.above_zero(*length, &path::item("scene.domain.size", axis));
    }
    let min = table.origin?.map(|length| length.0);
    let faces = [table.x?, table.y?, table.z?].map(|name| [name.into(), name.into()]);
    right.then(|| Domain::new(min, std::array::from_fn(|a| min[a] + size[a].0), faces))
}

fn material(table: &FluidTable, findings: &mut Findings) -> Option<FluidMaterial> {
    let at = "scene.fluid";
    let density = findings.positive(&table.density, at, "density");
    let viscosity = findings.positive(&table.viscosity, at, "viscosity");
    let expected =
        table.expected_speed.map(|speed| findings.above_zero(speed, "scene.fluid.expected_speed"));
    Some(FluidMaterial {
        density: density?,
        viscosity: viscosity?,
        acceleration: table.acceleration?.map(|a| a.0),
        velocity: table.velocity?.map(|v| v.0),
        pressure: 0.0,
        inside: Vec::new(),
        outside: Vec::new(),
        expected_speed: if expected == Some(false) {
            return None;
        } else {
            table.expected_speed.map(|v| v.0)
        },
    })
}

fn planes(tables: &[PlaneTable], findings: &mut Findings) -> Option<Vec<Plane>> {
    let planes: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| plane(table, &path::item("scene.planes", i), findings))
        .collect();
    planes.into_iter().collect()
}

fn plane(table: &PlaneTable, at: &str, findings: &mut Findings) -> Option<Plane> {
    let point = findings.required(&table.point, at, "point");
    let normal = findings.required(&table.normal, at, "normal")?;
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    if !(length.is_normal() && length.is_finite()) {
        findings.problem(
            &path::join(at, "normal"),
            format!("found {normal:?}, expected a direction, which has a length"),
        );
        return None;
    }
    Some(Plane {
        point: point?.map(|p| p.0),
        normal: normal.map(|n| n / length),
        material: Domain::MATERIAL.into(),
    })
}
