//! Checks of `[[scene.profiles]]`.

use super::super::document::{AxisName, ProfilesTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::super::spec::RunOptions;
use super::probes;
use std::collections::BTreeSet;
use tremie_messages::scene::{BinnedAxis, Domain, GrainProfile, Scene};
use tremie_messages::units::Time;

/// Most rows of all tables of a profile: an observer keeps them in memory, 176 bytes each.
const MOST_ROWS: f64 = 2e6;

pub(super) fn profiles(
    scene: &SceneTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vec<GrainProfile>> {
    let of_probes = scene.probes.iter().map(|probe| &probe.name);
    let of_gaps = scene.gaps.iter().map(|gap| &gap.name);
    let mut names: BTreeSet<String> = of_probes.chain(of_gaps).flatten().cloned().collect();
    let profiles: Vec<_> = (scene.profiles.iter().enumerate())
        .map(|(i, table)| {
            profile(table, &path::item("scene.profiles", i), domain, &mut names, findings)
        })
        .collect();
    profiles.into_iter().collect()
}

fn profile(
    table: &ProfilesTable,
    at: &str,
    domain: Option<&Domain>,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<GrainProfile> {
    let taken = |name: &str| format!("a second probe, gap or profile with the name \"{name}\"");
    let name = findings.name(&table.name, at, &[], names, taken);
    let along = along(table, at, domain, findings);
    let times = times(table, at, findings);
    let counts = findings.only_one(
        &[("bins", table.bins.is_some()), ("bin_width", table.bin_width.is_some())],
        "how many bins there are",
        at,
    );
    let (domain, along) = (domain?, along?);
    let corners = corners(table, at, domain, findings)?;
    let axes = match counts? {
        "bins" => by_number(table.bins.as_deref()?, &along, at, findings)?,
        _ => by_width(table, &along, corners, at, findings)?,
    };
    let bins = axes.iter().fold(1usize, |all, axis| all.saturating_mul(axis.bins));
    if bins > GrainProfile::MOST_BINS {
        let message =
            format!("found {bins} bins in all, expected at most {}", GrainProfile::MOST_BINS);
        findings.problem(&path::join(at, counts?), message);
        return None;
    }
    let [from, every, average] = times?;
    Some(GrainProfile {
        name: name?,
        axes,
        min: corners[0],
        max: corners[1],
        from: from.unwrap_or(0.0),
        every,
        average,
        velocity: table.velocity.unwrap_or_default(),
    })
}

/// One axis or two, each once, none across a plane scene.
fn along(
    table: &ProfilesTable,
    at: &str,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vec<usize>> {
    let axes = findings.required(&table.along, at, "along")?;
    let key = path::join(at, "along");
    let numbers: Vec<usize> = axes.iter().map(|axis| AxisName::number(*axis)).collect();
    let message = match numbers[..] {
        [] => "found no axis, expected one or two of \"x\", \"y\" and \"z\"".into(),
        [a, b] if a == b => {
            format!("found the axis \"{}\" twice, expected two different ones", ["x", "y", "z"][a])
        }
        [_] | [_, _] => match domain.and_then(|domain| domain.across) {
            Some(across) if numbers.contains(&across) => {
                "found the axis across the plane scene, along which nothing varies; expected one in the plane".into()
            }
            _ => return Some(numbers),
        },
        _ => format!("found {} axes, expected one or two", numbers.len()),
    };
    findings.problem(&key, message);
    None
}

/// The box: not empty, in the domain; as deep as a plane scene.
fn corners(
    table: &ProfilesTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<[[f64; 3]; 2]> {
    let mut min = table.min.map_or(domain.min, |min| min.map(|x| x.0));
    let mut max = table.max.map_or(domain.max, |max| max.map(|x| x.0));
    if let Some(across) = domain.across {
        (min[across], max[across]) = (domain.min[across], domain.max[across]);
    }
    probes::holds(&min, &max, None, domain, at, findings).then_some([min, max])
}

fn by_number(
    bins: &[u32],
    along: &[usize],
    at: &str,
    findings: &mut Findings,
) -> Option<Vec<BinnedAxis>> {
    let key = path::join(at, "bins");
    if !as_many(bins.len(), along, &key, findings) {
        return None;
    }
    if bins.contains(&0) {
        findings.problem(&key, "found 0, expected one bin or more along each axis");
        return None;
    }
    let axis = |(&axis, &bins): (&usize, &u32)| BinnedAxis { axis, bins: bins as usize };
    Some(along.iter().zip(bins).map(axis).collect())
}

fn by_width(
    table: &ProfilesTable,
    along: &[usize],
    [min, max]: [[f64; 3]; 2],
    at: &str,
    findings: &mut Findings,
) -> Option<Vec<BinnedAxis>> {
    let (widths, key) = (table.bin_width.as_deref()?, path::join(at, "bin_width"));
    if !as_many(widths.len(), along, &key, findings) {
        return None;
    }
    let mut axes = Vec::new();
    for (&axis, &width) in along.iter().zip(widths) {
        if !findings.above_zero(width, &key) {
            return None;
        }
        let size = max[axis] - min[axis];
        if width.0 > size * (1.0 + 1e-9) {
            let message =
                format!("found {width}, more than the box, which is {size} m along that axis");
            findings.problem(&key, message);
            return None;
        }
        axes.push(BinnedAxis { axis, bins: (size / width.0).round().clamp(1.0, 1e9) as usize });
    }
    Some(axes)
}

fn as_many(found: usize, along: &[usize], key: &str, findings: &mut Findings) -> bool {
    let right = found == along.len();
    if !right {
        let expected = along.len();
        findings.problem(
            key,
            format!("found {found}, expected as many as there are axes in \"along\", {expected}"),
        );
    }
    right
}

/// `from`, `every` and `average` [s], where they are given.
fn times(table: &ProfilesTable, at: &str, findings: &mut Findings) -> Option<[Option<f64>; 3]> {
    let mut right =
        table.from.is_none_or(|from| findings.not_negative(from, &path::join(at, "from")));
    for (key, time) in [("every", table.every), ("average", table.average)] {
        right &= time.is_none_or(|time| findings.above_zero(time, &path::join(at, key)));
    }
    if let (Some(every), Some(average)) = (table.every, table.average)
        && right
        && average.0 < every.0 * (1.0 - 1e-9)
    {
        let message = format!("found {average}, shorter than the time between samples, {every}");
        findings.problem(&path::join(at, "average"), message);
        right = false;
    }
    let seconds = |time: Option<Time>| time.map(|time| time.0);
    right.then(|| [seconds(table.from), seconds(table.every), seconds(table.average)])
}

/// Checks profiles against the length of the run.
pub(super) fn fit(scene: &Scene, run: &RunOptions, findings: &mut Findings) {
    for (i, profile) in scene.profiles.iter().enumerate() {
        let at = path::item("scene.profiles", i);
        let rest = run.until - profile.from;
        if rest <= 0.0 || profile.every.is_some_and(|every| every > rest * (1.0 + 1e-9)) {
            let message = format!(
                "found sampling from {} s on, with a first sample after the run has ended, at {} s",
                profile.from, run.until
            );
            findings.problem(&at, message);
            continue;
        }
        let tables = profile.average.map_or(1.0, |average| (rest / average).ceil());
        let rows = tables * profile.bins() as f64;
        if rows > MOST_ROWS {
            let message = format!(
                "would have {rows:.3e} rows, of {tables:.3e} tables with {} bins; expected at most {MOST_ROWS:.0e}",
                profile.bins()
            );
            findings.problem_with_help(&at, message, "average longer, or take fewer bins");
        }
    }
}
