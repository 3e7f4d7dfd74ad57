//! Small scenes of all kinds of components, each with all outputs that it can have.

use crate::hard_spheres::GAS;
use crate::inlets::STREAM;
use crate::rubber::Valve;
use crate::tremie::{SMALL, root};
use std::path::Path;

/// A scene to be disturbed.
#[derive(Clone, Copy, Debug)]
pub struct Disturbable {
    /// What is in it.
    pub name: &'static str,
    /// Writes `manifest.toml`, and what it names, into a folder.
    write: fn(&Path),
    /// Components of the physics, each with its program.
    pub physics: &'static [(&'static str, &'static str)],
    /// One that makes substeps of its own.
    pub makes_substeps: Option<&'static str>,
    /// Fluid and grains may advance at the same time.
    pub has_schedules: bool,
    /// Its windows, about.
    pub windows: u64,
    /// Windows between checkpoints.
    pub every: u64,
}

impl Disturbable {
    /// Writes the scene's files into `folder`.
    pub fn write(&self, folder: &Path) {
        (self.write)(folder);
    }
}

const LATTICE: [(&str, &str); 2] = [("fluid", "fluid-lbm"), ("grains", "grains-dem")];
const PARTICLES: [(&str, &str); 2] = [("fluid", "fluid-pic"), ("grains", "grains-dem")];
const GAS_AND_DISC: [(&str, &str); 2] =
    [("fluid", "fluid-wavelet"), ("grains", "grains-hard-sphere")];
const RING: [(&str, &str); 2] = [("grains", "grains-dem"), ("rubber", "rubber-table")];
const HARD: [(&str, &str); 1] = [("grains", "grains-hard-sphere")];

/// All scenes.
pub const SCENES: [Disturbable; 6] = [
    Disturbable {
        name: "lattice with grains and a post",
        write: |folder| manifest(folder, &lattice()),
        physics: &LATTICE,
        makes_substeps: Some("grains"),
        has_schedules: true,
        windows: 160,
        every: 20,
    },
    Disturbable {
        name: "dam break onto spheres",
        write: |folder| manifest(folder, &dam()),
        physics: &PARTICLES,
        makes_substeps: Some("grains"),
        has_schedules: true,
        windows: 33,
        every: 5,
    },
    Disturbable {
        name: "shock and disc",
        write: |folder| manifest(folder, &shock()),
        physics: &GAS_AND_DISC,
        makes_substeps: None,
        has_schedules: true,
        windows: 20,
        every: 3,
    },
    Disturbable {
        name: "hard spheres by themselves",
        write: |folder| manifest(folder, &hard_spheres()),
        physics: &HARD,
        makes_substeps: None,
        has_schedules: false,
        windows: 11_000,
        every: 1500,
    },
    Disturbable {
        name: "rubber ring on spheres",
        write: |folder| {
            Valve::on_rough_spheres()
                .write(folder, &[["record = false", "frames = \"0.1 ms\""], ["4 ms", "1.2 ms"]]);
        },
        physics: &RING,
        makes_substeps: Some("grains"),
        has_schedules: false,
        windows: 300,
        every: 40,
    },
    Disturbable {
        name: "lattice with grains that come and go",
        write: |folder| manifest(folder, STREAM),
        physics: &LATTICE,
        makes_substeps: Some("grains"),
        has_schedules: true,
        windows: 780,
        every: 100,
    },
];

fn manifest(folder: &Path, text: &str) {
    std::fs::write(folder.join("manifest.toml"), text).unwrap();
}

fn lattice() -> String {
    let post = r#"
[[scene.parts]]
name = "post"
box = { size = ["2 mm", "2 mm", "6 mm"] }
position = ["9 mm", "3 mm", "3 mm"]

[[scene.contacts]]"#;
    SMALL
        .replace("0.02 s", "0.08 s")
        .replace("\n[[scene.contacts]]", post)
        .replace("record = false", "frames = \"1 ms\"\nfields = \"8 ms\"")
}

fn dam() -> String {
    let text = std::fs::read_to_string(root().join("examples/dam-break/short.toml")).unwrap();
    text.replace("until = \"0.4 s\"", "until = \"0.12 s\"")
        .replace("frames = \"20 ms\"", "frames = \"20 ms\"\nfields = \"50 ms\"")
}

fn shock() -> String {
    std::fs::read_to_string(root().join("examples/shock-and-disc/short.toml")).unwrap()
}

fn hard_spheres() -> String {
    GAS.replace("signals = \"20 ms\"\nrecord = false", "signals = \"2 ms\"\nframes = \"5 ms\"")
}
