//! Runs of the program as a user makes them, and their outputs.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// The program, to be given arguments.
pub fn tremie() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tremie"));
    command.current_dir(root()).stdin(Stdio::null());
    command
}

/// The project's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A run that has ended.
pub struct Ran {
    pub output: Output,
    pub out: PathBuf,
    /// When it had ended, in ticks as of [`crate::running::now`].
    pub ended: u64,
    _home: TempDir,
}

/// Runs `manifest` with `options`, outputs in a folder that is gone with the result.
pub fn run(manifest: &str, options: &[&str]) -> Ran {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let output =
        tremie().arg("run").arg(manifest).arg("--out").arg(&out).args(options).output().unwrap();
    Ran { output, out, ended: crate::running::now(), _home: home }
}

/// Runs the text of a manifest.
pub fn run_text(text: &str, options: &[&str]) -> Ran {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let mut ran = run(manifest.to_str().unwrap(), options);
    ran.output.stderr = ran.errors().replace(home.path().to_str().unwrap(), "").into_bytes();
    ran
}

/// A program in `folder` that is a shell script of these lines.
pub fn script(folder: &Path, name: &str, lines: &str) -> PathBuf {
    let program = folder.join(name);
    std::fs::write(&program, format!("#!/bin/sh\n{lines}\n")).unwrap();
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&program, mode).unwrap();
    program
}

/// The small manifest with another program as its fluid.
pub fn small_with_fluid(program: &Path) -> String {
    SMALL.replace("fluid = \"fluid-lbm\"", &format!("fluid = {program:?}"))
}

/// A line in which a fluid that needs nothing describes itself.
pub fn description(interface: u32) -> String {
    format!(
        r#"{{"description":{{"interface":{interface},"program":"script","step":null,"bodies":0,"signals":[],"slices":[],"work":"","notes":[],"warnings":[],"resolution":{{}}}}}}"#
    )
}

impl Ran {
    pub fn errors(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    pub fn code(&self) -> Option<i32> {
        self.output.status.code()
    }

    /// The run, if it succeeded; else the test fails with the run's errors.
    #[track_caller]
    pub fn succeeded(self) -> Self {
        assert!(self.output.status.success(), "{}", self.errors());
        self
    }

    pub fn summary(&self) -> Value {
        let text = std::fs::read_to_string(self.out.join("summary.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// No component outlives the run, and nothing of it stays in shared memory or in its private
    /// folder.
    #[track_caller]
    pub fn left_nothing(&self, about: &str) {
        left_nothing(&self.summary(), self.ended, about);
    }

    pub fn signals_text(&self) -> String {
        std::fs::read_to_string(self.out.join("signals.csv")).unwrap()
    }

    /// Columns of the table of signals, by name without unit.
    pub fn signals(&self) -> BTreeMap<String, Vec<f64>> {
        let text = self.signals_text();
        let mut lines = text.lines().map(|line| line.split(','));
        let names: Vec<_> = lines.next().unwrap().map(|n| n.split(" [").next().unwrap()).collect();
        let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for line in lines {
            for (name, value) in names.iter().zip(line) {
                columns.entry((*name).to_string()).or_default().push(value.parse().unwrap());
            }
        }
        columns
    }
}

/// See [`Ran::left_nothing`]; of a run with this summary that had ended at `ended`.
#[track_caller]
pub fn left_nothing(summary: &Value, ended: u64, about: &str) {
    assert_eq!(processes_of(summary, ended), Vec::<u32>::new(), "{about}");
    let run = summary["run"].as_str().unwrap();
    let user = std::os::unix::fs::MetadataExt::uid(&std::fs::metadata("/proc/self").unwrap());
    for place in ["/dev/shm".to_string(), format!("/tmp/tremie-{user}")] {
        let left: Vec<_> = std::fs::read_dir(&place)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.contains(run))
            .collect();
        assert_eq!(left, Vec::<String>::new(), "{about}");
    }
}

/// Components of the run that are still there. A process that started after the run's end is
/// another one with the same number.
fn processes_of(summary: &Value, ended: u64) -> Vec<u32> {
    let ids = summary["processes"].as_object().unwrap().values();
    ids.filter_map(|id| u32::try_from(id.as_u64()?).ok())
        .filter(|id| crate::running::started(*id).is_some_and(|start| start <= ended))
        .collect()
}

/// A small run of few windows, to be changed by replacing words.
pub const SMALL: &str = r#"
[run]
until = "0.02 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["12 mm", "12 mm", "16 mm"]

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"

[[scene.bodies]]
name = "grains"
density = "2500 kg/m3"
spheres = [
    { position = ["4 mm", "4 mm", "4 mm"], diameter = "3 mm" },
    { position = ["8 mm", "8 mm", "8 mm"], diameter = "4 mm" },
    { position = ["4.5 mm", "4 mm", "9 mm"], diameter = "3 mm" },
]

[[scene.contacts]]
normal_stiffness = "50 N/m"
tangential_stiffness = "40 N/m"
friction = 0.3
restitution = 0.5

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.5 mm"

[outputs]
record = false
"#;
