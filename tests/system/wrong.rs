//! What users of such programs do wrong most: each manifest of `wrong/` has one such mistake, and the
//! text file beside it says what `tremie check` answers. `TREMIE_ACCEPT=1` writes the answers anew.

use crate::tremie::{root, tremie};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time of an answer on a machine that is busy; on one that is not, it is some milliseconds.
const LONGEST: Duration = Duration::from_secs(20);

/// Mistakes that are none of a line: there is no line to point at.
const WITHOUT_A_LINE: [&str; 2] = ["components-missing", "empty"];
/// Mistakes of which each part must be mended: two pairs of materials without a law.
const WITH_MORE_ERRORS: [&str; 1] = ["contacts-missing"];

fn manifests() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("tests/system/wrong")).unwrap();
    let files = entries.map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        files.filter(|file| file.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    files
}

/// What `tremie check` says of a manifest: errors, then findings that are wrong.
fn answer(manifest: &Path) -> (Option<i32>, String) {
    let folder = manifest.parent().unwrap();
    let mut command = tremie();
    let name = manifest.file_name().unwrap();
    let ran = command.current_dir(folder).arg("check").arg(name).output().unwrap();
    let said = String::from_utf8(ran.stderr).unwrap();
    let findings = String::from_utf8(ran.stdout).unwrap();
    let of = |verdict: &str| -> String {
        let mut takes = false;
        let mut belongs = |line: &&str| {
            takes = line.starts_with(verdict) || takes && line.starts_with("  ");
            takes
        };
        findings.lines().filter(|line| belongs(line)).map(|line| format!("{line}\n")).collect()
    };
    let mut text = said + &of("wrong: ");
    if text.is_empty() {
        text = of("doubtful: run: ");
    }
    // Where programs are looked for differs from machine to machine.
    let beside = Path::new(env!("CARGO_BIN_EXE_tremie")).parent().unwrap().display().to_string();
    let text = text.replace(&format!("{}/", folder.display()), "").replace(&beside, "PROGRAMS");
    (ran.status.code(), text)
}

#[test]
fn every_common_mistake_is_answered_with_its_line_and_a_remedy() {
    let manifests = manifests();
    assert!(manifests.len() >= 60, "{}", manifests.len());
    let accepts = std::env::var_os("TREMIE_ACCEPT").is_some();
    let mut wrong = Vec::new();
    for manifest in manifests {
        let name = manifest.file_stem().unwrap().to_str().unwrap();
        let begin = Instant::now();
        let (code, said) = answer(&manifest);
        assert!(begin.elapsed() < LONGEST, "{name}: {:?}", begin.elapsed());
        let expected = manifest.with_extension("txt");
        if accepts {
            std::fs::write(&expected, &said).unwrap();
        }
        let known = std::fs::read_to_string(&expected).unwrap_or_default();
        if said != known {
            wrong.push(format!("{name}, expected:\n{known}found:\n{said}"));
        }
        let is_doubtful = code == Some(0) && said.starts_with("doubtful: ");
        if !matches!(code, Some(1 | 2)) && !is_doubtful {
            wrong.push(format!("{name}: the mistake passes: {code:?}\n{said}"));
        }
        let is_of_a_line = said.starts_with("error: ") && !WITHOUT_A_LINE.contains(&name);
        if is_of_a_line && !said.contains(&format!("{name}.toml:")) {
            wrong.push(format!("{name}: no line is named\n{said}"));
        }
        let remedies = ["= help: ", "  remedy: ", ", expected ", ": must be "];
        if !remedies.iter().any(|words| said.contains(words)) {
            wrong.push(format!("{name}: no remedy is named\n{said}"));
        }
        let is_one = !WITH_MORE_ERRORS.contains(&name);
        if is_one && said.lines().filter(|line| line.starts_with("error: ")).count() > 1 {
            wrong.push(format!("{name}: one mistake, more than one error\n{said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
