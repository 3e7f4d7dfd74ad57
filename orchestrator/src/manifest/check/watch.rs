//! Checks of `[watch]`.

use super::super::document::{WatchEntry, WatchTable};
use super::super::path;
use super::super::read::Findings;
use super::super::spec::WatchLimit;
use std::collections::BTreeMap;
use tremie_messages::WatchedQuantity;

pub(super) fn watch(
    table: &WatchTable,
    findings: &mut Findings,
) -> Option<BTreeMap<WatchedQuantity, WatchLimit>> {
    let entry = |quantity: WatchedQuantity| match quantity {
        WatchedQuantity::Mach => table.mach,
        WatchedQuantity::Density => table.density,
        WatchedQuantity::Overlap => table.overlap,
        WatchedQuantity::Speed => table.speed,
        WatchedQuantity::Mass => table.mass,
        WatchedQuantity::Energy => table.energy,
        WatchedQuantity::Compression => table.compression,
    };
    let given = WatchedQuantity::ALL.into_iter().filter_map(|quantity| {
        let limit = match entry(quantity)? {
            WatchEntry::Off => Some(WatchLimit::Off),
            WatchEntry::Limit(limit) => {
                let key = path::join("watch", quantity.name());
                let is_right = is_limit(limit, &key, findings);
                is_right.then_some(WatchLimit::Above(limit))
            }
        };
        Some(limit.map(|limit| (quantity, limit)))
    });
    // All of them are checked, also where one is wrong.
    let given: Vec<_> = given.collect();
    given.into_iter().collect()
}

fn is_limit(limit: f64, key: &str, findings: &mut Findings) -> bool {
    let is_right = limit > 0.0 && limit.is_finite();
    if !is_right {
        let message = format!("found {limit}, expected a finite number above zero, or \"off\"");
        let help = "without the key the default holds; \"off\" takes the watchdog away";
        findings.problem_with_help(key, message, help);
    }
    is_right
}
