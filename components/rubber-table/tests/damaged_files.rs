//! Damaged files of rubber: tables, meshes of Gmsh, results of CalculiX, CSV files, specifications. Each
//! is read or refused, soon and in little memory.

mod common;

use std::path::{Path, PathBuf};
use tremie_rubber_table::import::frd::Options;
use tremie_rubber_table::import::{csv, frd, gmsh};
use tremie_rubber_table::spec::Spec;
use tremie_rubber_table::table::Table;
use tremie_test_support::{Counting, DamagedInput, inputs};

#[global_allocator]
static COUNTING: Counting = Counting;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs").join(name)
}

/// What is said of a result.
fn told<T, E: std::fmt::Display>(read: Result<T, E>) -> String {
    read.map_or_else(|error| error.to_string(), |_| "it is read".into())
}

fn try_tables(count: u64) {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("ring.json");
    common::linear(1e5).write(&path).unwrap();
    let mut inputs = inputs(&folder("table"));
    inputs.push(std::fs::read(&path).unwrap());
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        told(Table::read(&path))
    };
    let words = [
        "\"format\"",
        "\"version\"",
        "\"force_N\"",
        "\"compression_m\"",
        "\"vertices_m\"",
        "\"facets\"",
        "\"quads\"",
        "\"seat\"",
        "\"exposed\"",
        "\"bonded\"",
        "\"covered\"",
        "[[",
        "]]",
        "[",
        "]",
        ",",
        "null",
        "0.003",
        "-1e-3",
    ];
    let memory = [1 << 16, 200];
    DamagedInput { name: "tables of rubber", inputs, words: &words, read: &read, memory }
        .try_many(count);
}

fn try_imports(count: u64) {
    let home = tempfile::tempdir().unwrap();
    let names = ["frames.csv", "vertices.csv", "facets.csv"];
    let options = Options { length: 1e-3, force: 1.0, seat: None, reach: None };
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        // Files of CSV follow each other in one input.
        let parts = text.split("----\n").chain(std::iter::repeat(""));
        for (name, part) in names.iter().zip(parts) {
            std::fs::write(home.path().join(name), part).unwrap();
        }
        let spec = Spec::parse(Path::new("ring.toml"), text.to_string());
        let said = [
            told(gmsh::read(&text, 1e-3)),
            told(frd::read(&text, &options)),
            told(csv::read(home.path())),
            told(spec),
        ];
        said.join("; ")
    };
    let words = [
        "$Nodes",
        "$EndNodes",
        "$Elements",
        "$PhysicalNames",
        "\n",
        " -1",
        " -2",
        " -3",
        "DISP",
        "FORC",
        "100CL",
        "rubber",
        "----\n",
        ",",
        "seat",
        "exposed",
        "[section.rectangle]",
        "height",
        "\"3 mm\"",
        "elements = [",
        "frames = ",
        "[rubber]",
        "1.0E+10",
    ];
    let inputs = inputs(&folder("import"));
    // Four readers, each with the whole text.
    let memory = [1 << 20, 600];
    DamagedInput { name: "imports of rubber", inputs, words: &words, read: &read, memory }
        .try_many(count);
}

#[test]
fn damaged_tables_are_read_or_refused() {
    try_tables(1000);
}

#[test]
fn damaged_imports_are_read_or_refused() {
    try_imports(500);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_tables_are_read_or_refused() {
    try_tables(1_000_000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_imports_are_read_or_refused() {
    try_imports(1_000_000);
}
