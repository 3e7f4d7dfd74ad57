//! Shared memory, private folders and open files that are too small for a run.

use crate::running::{Running, run_of};
use crate::tremie::{SMALL, tremie};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Shared memory that `check` plans [bytes], and its verdict.
fn planned(manifest: &Path) -> (u64, String) {
    let told = tremie().args(["check", "--json"]).arg(manifest).output().unwrap();
    let text = String::from_utf8(told.stdout).unwrap();
    let line = text.lines().find(|line| line.contains("\"event\":\"plan\"")).unwrap();
    let plan: serde_json::Value = serde_json::from_str(line).unwrap();
    let findings = plan["findings"].as_array().unwrap();
    let shared = findings.iter().find(|finding| finding["quantity"] == "shared memory").unwrap();
    (plan["plan"]["shared_memory"].as_u64().unwrap(), shared["verdict"].as_str().unwrap().into())
}

/// The small run: as it is, with frames to observers, with fields of a large lattice, with many
/// grains.
fn cases() -> [(&'static str, String); 4] {
    let frames = SMALL.replace("record = false", "frames = \"1 ms\"");
    let fields = SMALL
        .replace("cell = \"0.5 mm\"", "cell = \"0.2 mm\"")
        .replace("record = false", "record = false\nfields = \"2 ms\"");
    // Grains that rest.
    let packing = "packing = { min = [\"0 mm\", \"0 mm\", \"0 mm\"], max = [\"12 mm\", \"12 mm\", \"16 mm\"], fraction = 0.1, diameter = \"0.4 mm\" }\n\n[[scene.contacts]]";
    let frames_at_rest = frames.replace("-9.81", "0");
    let from = frames_at_rest.find("spheres = [").unwrap();
    let until = frames_at_rest.find("[[scene.contacts]]").unwrap() + "[[scene.contacts]]".len();
    let grains = format!("{}{packing}{}", &frames_at_rest[..from], &frames_at_rest[until..]);
    [("plain", SMALL.into()), ("frames", frames), ("fields", fields), ("grains", grains)]
}

/// Memory of a run in `/dev/shm` [bytes].
fn taken(run: &str) -> u64 {
    let entries = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let of_run = entries.filter(|entry| entry.file_name().to_string_lossy().contains(run));
    of_run.filter_map(|entry| Some(512 * entry.metadata().ok()?.blocks())).sum()
}

#[test]
fn the_plan_says_how_much_shared_memory_a_run_takes() {
    let home = tempfile::tempdir().unwrap();
    for (name, text) in cases() {
        let manifest = home.path().join(format!("{name}.toml"));
        std::fs::write(&manifest, text.replace("0.02 s", "100 s")).unwrap();
        let (need, _) = planned(&manifest);
        let mut command = tremie();
        command.args(["run", "--json", "--out"]).arg(home.path().join(name)).arg(&manifest);
        let mut running = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
        running.says("\"progress\"");
        // Its private folder is named as its memory.
        let Some(run) = run_of(running.id()) else {
            panic!("{name}: it ended: {}", running.errors());
        };
        let taken = taken(&run);
        assert!(need as f64 <= 1.3 * taken as f64, "{name}: {taken} bytes taken of {need} told");
        running.send("-INT");
        running.wait(Duration::from_secs(20));
        assert!(taken <= need, "{name}: {taken} bytes are taken, {need} were told");
    }
}

/// Runs `script` with another `/dev/shm` (or `/tmp`); `None`, said, where that is not permitted.
fn with_mount(mount: &str, script: &str, manifest: &Path) -> Option<Output> {
    let program = Path::new(env!("CARGO_BIN_EXE_tremie"));
    crate::mounts::with_mount(mount, script, &[program, manifest, &manifest.with_extension("out")])
}

#[test]
fn too_little_shared_memory_is_told_before_anything_starts() {
    // Not below /tmp, which one of the cases hides.
    let home = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let manifest = home.path().join("fields.toml");
    std::fs::write(&manifest, &cases()[2].1).unwrap();
    let (need, verdict) = planned(&manifest);
    assert_eq!(verdict, "ok");
    let run = "\"$1\" run \"$2\" --quiet --out \"$3\"";
    for (mount, parts) in [
        (
            "mount -t tmpfs -o size=64k tmpfs /dev/shm",
            &["/dev/shm is full: 66 kB of 66 kB", "--shm-size="][..],
        ),
        (
            "mount -t tmpfs -o size=4k tmpfs /dev/shm",
            &["/dev/shm is full: 4 kB of 4 kB", "remount,size="],
        ),
        (
            "mount -t tmpfs -o size=12m tmpfs /dev/shm",
            &["/dev/shm is full: 13 MB of 13 MB", "in-process"],
        ),
        (
            "mount -t tmpfs -o size=99m tmpfs /dev/shm && head -c 98M /dev/zero > /dev/shm/other",
            &["1049 kB of 104 MB are free"],
        ),
        (
            "mount -t tmpfs -o ro tmpfs /dev/shm",
            &["/dev/shm cannot be written (Read-only file system", "in-process"],
        ),
        (
            "mount -t tmpfs -o size=100m,nr_inodes=1 tmpfs /dev/shm",
            &["/dev/shm holds as many files as it may"],
        ),
        ("mount -t tmpfs -o size=64k tmpfs /tmp", &["below /tmp: No space left on device"]),
        ("mount -t tmpfs -o ro tmpfs /tmp", &["below /tmp: Read-only file system"]),
    ] {
        if mount.ends_with("/tmp") && home.path().starts_with("/tmp") {
            // It would hide the program, too.
            continue;
        }
        let begin = Instant::now();
        let Some(ran) = with_mount(mount, run, &manifest) else { return };
        let said = errors(&ran);
        assert_eq!(ran.status.code(), Some(1), "{mount}: {said}");
        assert_eq!(said.trim().lines().count(), 1, "{mount}: {said}");
        assert!(
            said.starts_with("error: ") && parts.iter().all(|part| said.contains(part)),
            "{mount}: {said}"
        );
        if parts[0].contains("is full: 13 MB") {
            assert!(
                said.contains(&format!("the run needs {} MB", (need as f64 / 1e6).round())),
                "{said}"
            );
        }
        assert!(!manifest.with_extension("out").exists(), "{mount}");
        assert!(begin.elapsed() < Duration::from_secs(20), "{mount}: {:?}", begin.elapsed());
    }
    // What is just enough is enough, and threads need none.
    let least = format!("mount -t tmpfs -o size={} tmpfs /dev/shm", need + 8192);
    for (mount, option) in
        [(least.as_str(), ""), ("mount -t tmpfs -o ro tmpfs /dev/shm", "--in-process")]
    {
        let script = format!("{run} {option} && rm -r \"$3\"");
        let Some(ran) = with_mount(mount, &script, &manifest) else { return };
        assert!(ran.status.success(), "{mount}: {}", errors(&ran));
    }
}

#[test]
fn too_few_open_files_are_told_before_anything_starts() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, &cases()[2].1).unwrap();
    let limited = |limit: &str| {
        let script = format!("ulimit {limit}; exec \"$1\" run \"$2\" --quiet --out \"$3\"");
        let mut command = Command::new("sh");
        command
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_tremie")])
            .arg(&manifest)
            .arg(home.path().join("out"));
        command.output().unwrap()
    };
    for limit in [40, 64] {
        let begin = Instant::now();
        let ran = limited(&format!("-n {limit}"));
        let said = errors(&ran);
        assert_eq!((ran.status.code(), said.trim().lines().count()), (Some(1), 1), "{said}");
        assert!(
            said.contains(&format!("a process may open {limit} files, and the run needs about ")),
            "{said}"
        );
        assert!(said.contains("ulimit -n 1024"), "{said}");
        assert!(begin.elapsed() < Duration::from_secs(20));
        assert!(!home.path().join("out").exists());
    }
    // What is said to be needed is enough.
    let said = errors(&limited("-n 64"));
    let need = said.split("needs about ").nth(1).unwrap().split(':').next().unwrap();
    let ran = limited(&format!("-n {need}"));
    assert!(ran.status.success(), "{need}: {}", errors(&ran));
    std::fs::remove_dir_all(home.path().join("out")).unwrap();
    // What a user may raise is raised.
    let ran = limited("-S -n 64");
    assert!(ran.status.success(), "{}", errors(&ran));
}
