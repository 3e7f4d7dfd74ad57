//! Checks of `[[scene.drag_bands]]`.

use super::super::document::{DragBandTable, RegionTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::{inlets::Names, probes};
use tremie_messages::scene::{Domain, DragBand, ProbeShape};

pub(super) fn drag_bands(
    scene: &SceneTable,
    domain: Option<&Domain>,
    names: &mut Names,
    findings: &mut Findings,
) -> Option<Vec<DragBand>> {
    let weightless = scene.gravity.is_some_and(|g| g.iter().all(|g| g.0 == 0.0));
    if let (true, false) = (weightless, scene.drag_bands.is_empty()) {
        let message = "a drag band brakes by the weight of grains, but there is no gravity";
        let help = "give the scene gravity, or leave the band out";
        findings.problem_with_help(&path::item("scene.drag_bands", 0), message, help);
    }
    let bands: Vec<_> = (scene.drag_bands.iter().enumerate())
        .map(|(i, table)| {
            let at = path::item("scene.drag_bands", i);
            let name = names.take(&table.name, &at, findings);
            let speed = findings.positive(&table.terminal_speed, &at, "terminal_speed");
            let [min, max] = corners(table, domain?, &at, findings)?;
            Some(DragBand { name: name?, min, max, terminal_speed: speed? })
        })
        .collect();
    bands.into_iter().collect()
}

/// The corners of a box in the domain.
fn corners(
    table: &DragBandTable,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> Option<[[f64; 3]; 2]> {
    let region = RegionTable { min: table.min, max: table.max };
    match probes::region(&region, at, domain, findings)? {
        ProbeShape::Region { min, max } => Some([min, max]),
        _ => None,
    }
}
