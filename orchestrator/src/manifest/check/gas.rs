//! Checks of `[scene.fluid.gas]`.

use super::super::document::{
    AxisDirection, FluidTable, GasRegionTable, GasTable, ShockTable, VortexTable,
};
use super::super::path;
use super::super::read::Findings;
use super::{fluid, probes};
use std::collections::BTreeMap;
use tremie_messages::scene::{Domain, GasMaterial, GasRegion, Shock, Vortex};
use tremie_messages::units::{Temperature, Velocity};

const AT: &str = "scene.fluid.gas";

/// The gas, if the fluid is one; inside it is `None` where it is wrong.
pub(super) fn gas(
    table: &FluidTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Option<GasMaterial>> {
    table.gas.as_ref().map(|gas| material(table, gas, domain, findings))
}

fn material(
    fluid: &FluidTable,
    table: &GasTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<GasMaterial> {
    let pressure = findings.positive(&table.pressure, AT, "pressure");
    let temperature = findings.positive(&table.temperature, AT, "temperature");
    let sutherland = table.sutherland?;
    let is_warm = findings.not_negative(sutherland, &path::join(AT, "sutherland"));
    let heat_ratio = above("heat_ratio", table.heat_ratio?, 1.0, findings);
    let prandtl = above("prandtl", table.prandtl?, 0.0, findings);
    let surface_temperatures = surfaces(table, findings);
    let regions: Vec<_> = (table.regions.iter().enumerate())
        .map(|(k, region)| {
            let at = path::item(&path::join(AT, "regions"), k);
            region_of(fluid, table, region, &at, domain, findings)
        })
        .collect();
    let shock = table.shock.as_ref().map(|shock| shock_of(shock, domain, findings));
    let vortex = table.vortex.as_ref().map(|vortex| vortex_of(vortex, domain, findings));
    Some(GasMaterial {
        pressure: pressure?,
        temperature: temperature?,
        heat_ratio: heat_ratio?,
        prandtl: prandtl?,
        sutherland: is_warm.then_some(sutherland.0)?,
        surface_temperatures: surface_temperatures?,
        regions: regions.into_iter().collect::<Option<_>>()?,
        shock: if_there(shock)?,
        vortex: if_there(vortex)?,
    })
}

fn surfaces(table: &GasTable, findings: &mut Findings) -> Option<BTreeMap<String, f64>> {
    let at = path::join(AT, "surface_temperatures");
    let one = |(material, temperature): (&String, &Temperature)| {
        let found = findings.positive(&Some(*temperature), &at, material);
        Some((material.clone(), found?))
    };
    // All are looked at, so that each wrong one is told.
    let found: Vec<_> = table.surface_temperatures.iter().map(one).collect();
    found.into_iter().collect()
}

/// What a table came to: nothing where there is none, `None` where it is wrong.
pub(super) fn if_there<T>(of: Option<Option<T>>) -> Option<Option<T>> {
    of.map_or(Some(None), |found| found.map(Some))
}

fn above(key: &str, value: f64, least: f64, findings: &mut Findings) -> Option<f64> {
    if value.is_finite() && value > least {
        return Some(value);
    }
    findings.problem(&path::join(AT, key), format!("found {value}, expected more than {least}"));
    None
}

fn region_of(
    fluid: &FluidTable,
    gas: &GasTable,
    table: &GasRegionTable,
    at: &str,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<GasRegion> {
    let density = findings.positive(&table.density.or(fluid.density), at, "density");
    let pressure = findings.positive(&table.pressure.or(gas.pressure), at, "pressure");
    let domain = domain?;
    let min = table.min.map_or(domain.min, |min| min.map(|x| x.0));
    let max = table.max.map_or(domain.max, |max| max.map(|x| x.0));
    if !fluid::holds_points([&min, &max], domain, at, findings) {
        return None;
    }
    let velocity = table.velocity.or(fluid.velocity).unwrap_or([Velocity(0.0); 3]);
    Some(GasRegion {
        min,
        max,
        density: density?,
        pressure: pressure?,
        velocity: velocity.map(|v| v.0),
    })
}

fn shock_of(table: &ShockTable, domain: Option<&Domain>, findings: &mut Findings) -> Option<Shock> {
    let at = path::join(AT, "shock");
    let axis = findings.required(&table.axis, &at, "axis");
    let position = findings.required(&table.position, &at, "position");
    let mach = findings.required(&table.mach, &at, "mach");
    let (axis, position, mach, domain) = (axis?.number(), position?.0, mach?, domain?);
    let name = ["x", "y", "z"][axis];
    if domain.across == Some(axis) {
        let message =
            format!("found \"{name}\", the axis across the plane, along which nothing varies");
        findings.problem(&path::join(&at, "axis"), message);
        return None;
    }
    let (low, high) = (domain.min[axis], domain.max[axis]);
    if !(low < position && position < high) {
        let message = format!(
            "the shock begins outside of the domain: found {position} m, expected a place between {low} m and {high} m along {name}"
        );
        findings.problem(&path::join(&at, "position"), message);
        return None;
    }
    if !(mach.is_finite() && mach > 1.0) {
        let message = format!("found {mach}, expected more than 1");
        let help = "a shock runs faster than sound ahead of it";
        findings.problem_with_help(&path::join(&at, "mach"), message, help);
        return None;
    }
    let direction = match table.direction.unwrap_or_default() {
        AxisDirection::Up => 1.0,
        AxisDirection::Down => -1.0,
    };
    Some(Shock { axis, position, direction, mach })
}

fn vortex_of(
    table: &VortexTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vortex> {
    let at = path::join(AT, "vortex");
    let centre = findings.required(&table.centre, &at, "centre");
    let radius = findings.positive(&table.radius, &at, "radius");
    let speed = findings.required(&table.speed, &at, "speed");
    let domain = domain?;
    let centre = centre?.map(|x| x.0);
    if !probes::inside(&centre, domain, &path::join(&at, "centre"), findings) {
        return None;
    }
    let axis = table.axis.map_or(domain.across.unwrap_or(2), |axis| axis.number());
    if domain.across.is_some_and(|across| across != axis) {
        let message = "a vortex of a plane scene turns about the axis across the plane";
        findings.problem(&path::join(&at, "axis"), message);
        return None;
    }
    Some(Vortex { axis, centre, radius: radius?, speed: speed?.0 })
}
