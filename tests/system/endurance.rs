//! Very many windows: memory of every process, open files and shared memory stay what they are.

use crate::running::{Running, children_of, run_of};
use crate::tremie::{SMALL, small_with_fluid, tremie};
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// What a process has at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Holdings {
    /// Memory that is its own, shared memory left out [kB].
    kilobytes: u64,
    /// Open files.
    files: u64,
}

/// Holdings of a process; `None` once it has ended.
fn holdings(process: u32) -> Option<Holdings> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    let kilobytes = line.trim().trim_end_matches(" kB").parse().ok()?;
    let files = std::fs::read_dir(format!("/proc/{process}/fd")).ok()?.count() as u64;
    Some(Holdings { kilobytes, files })
}

/// Shared memory of a run [bytes].
fn shared(run: &str) -> u64 {
    let entries = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_name().to_string_lossy().contains(run));
    own.filter_map(|entry| Some(512 * entry.metadata().ok()?.blocks())).sum()
}

fn name(process: u32) -> String {
    let line = std::fs::read_to_string(format!("/proc/{process}/cmdline")).unwrap_or_default();
    let words: Vec<&str> = line.split('\0').filter(|word| !word.is_empty()).collect();
    let last = words.last().map_or("", |word| word.rsplit('/').next().unwrap_or(word));
    if words.get(1) == Some(&"run") { "orchestrator".into() } else { last.into() }
}

/// Most growth of a process in the second half of the run [kB]: pages of its allocator, no more.
const MOST_GROWTH: u64 = 1024;

/// Runs so many windows, and looks at all processes again and again.
fn endure(windows: u64, look: Duration) {
    const STEP: f64 = 1e-5;
    let home = tempfile::tempdir().unwrap();
    let text = small_with_fluid(Path::new("minimal-fluid"))
        .replace("until = \"0.02 s\"", &format!("until = \"{} s\"", STEP * windows as f64))
        .replace(
            "[settings.fluid-lbm]\ncell = \"0.5 mm\"",
            "[settings.grains-dem]\ntime_step = \"1e-5 s\"",
        )
        .replace(
            "record = false",
            &format!("signals = \"{} s\"\nframes = \"{0} s\"", 1e-3 * STEP * windows as f64),
        );
    assert!(text.contains("time_step") && !SMALL.contains("time_step"));
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let mut command = tremie();
    command.arg("run").arg(&manifest).arg("--out").arg(home.path().join("out")).arg("--json");
    let every = format!("run.checkpoints={{ windows = {}, keep = 2 }}", windows / 10);
    let begin = Instant::now();
    let mut running =
        Running::start(command.args(["--set", &every]).stdout(Stdio::null()).stderr(Stdio::null()));
    let mut seen: Vec<Seen> = Vec::new();
    let (mut names, mut run) = (BTreeMap::new(), None);
    while !running.has_ended() {
        let ids: Vec<u32> =
            std::iter::once(running.id()).chain(children_of(running.id())).collect();
        for id in &ids {
            // One that has ended has no name.
            names.extend(Some((*id, name(*id))).filter(|(_, name)| !name.is_empty()));
        }
        run = run.or_else(|| run_of(running.id()));
        let all = ids.iter().filter_map(|id| Some((*id, holdings(*id)?))).collect();
        if let Some(run) = run.as_ref().filter(|_| home.path().join("out/log.jsonl").exists()) {
            seen.push((all, shared(run)));
        }
        std::thread::sleep(look);
    }
    assert_eq!(running.wait(Duration::from_secs(1)), Some(0));
    let summary = std::fs::read_to_string(home.path().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["windows"].as_u64(), Some(windows));
    println!(
        "{windows} windows in {:.1} s, looked at {} times",
        begin.elapsed().as_secs_f64(),
        seen.len()
    );
    nothing_grew(&seen, &names);
}

/// What all processes have at one time, and the shared memory of the run [bytes].
type Seen = (BTreeMap<u32, Holdings>, u64);

/// Compares what was held after half of the run with what was held before its end. In the first half
/// processes begin, and the recorder takes 1 MB more, with 100,000 windows as with 300,000.
fn nothing_grew(seen: &[Seen], names: &BTreeMap<u32, String>) {
    assert!(seen.len() >= 10, "the run was over too soon: {}", seen.len());
    // Not the very ends, at which processes begin and end.
    let (early, late) = (&seen[seen.len() / 2], &seen[seen.len() - 1 - seen.len() / 10]);
    assert!(early.0.len() >= 4, "{names:?}");
    for (process, begin) in &early.0 {
        let all = seen.iter().filter_map(|(all, _)| all.get(process));
        let most = all.clone().skip(seen.len() / 2).max().unwrap();
        let end = late.0.get(process).expect("a process that goes on");
        let name = &names[process];
        println!("  {name}: {begin:?} after half, {end:?} before the end, {most:?} at most");
        let growth = end.kilobytes.saturating_sub(begin.kilobytes);
        assert!(growth <= MOST_GROWTH, "{name} grew by {growth} kB");
        // A checkpoint that is being written has a file or two open.
        assert!(end.files <= begin.files + 2, "{name}: {begin:?} {end:?}");
    }
    println!("  shared memory: {} bytes after half, {} before the end", early.1, late.1);
    assert!(early.1 > 0);
    assert_eq!(early.1, late.1);
}

#[test]
fn many_windows_take_no_more_than_few() {
    endure(300_000, Duration::from_millis(20));
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_windows_take_no_more_than_few() {
    endure(1_000_000, Duration::from_millis(200));
}
