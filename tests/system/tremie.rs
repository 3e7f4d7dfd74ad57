//! Running the program as a user does, and reading what it leaves.

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
    _home: TempDir,
}

/// Runs `manifest` with `options`, outputs in a folder that is gone with the result.
pub fn run(manifest: &str, options: &[&str]) -> Ran {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let output =
        tremie().arg("run").arg(manifest).arg("--out").arg(&out).args(options).output().unwrap();
    Ran { output, out, _home: home }
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

impl Ran {
    pub fn errors(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    pub fn code(&self) -> Option<i32> {
        self.output.status.code()
    }

    /// The run, if it succeeded; else the test fails with what it said.
    #[track_caller]
    pub fn succeeded(self) -> Self {
        assert!(self.output.status.success(), "{}", self.errors());
        self
    }

    pub fn summary(&self) -> Value {
        let text = std::fs::read_to_string(self.out.join("summary.json")).unwrap();
        serde_json::from_str(&text).unwrap()
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
