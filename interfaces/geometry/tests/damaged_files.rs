//! Damaged files of triangles: each is a mesh or an error, soon and in little memory.

use std::path::Path;
use tremie_geometry::{Mesh, load};
use tremie_messages::scene::Geometry;
use tremie_test_support::{Counting, DamagedInput, inputs};

#[global_allocator]
static COUNTING: Counting = Counting;

/// Tries so many damaged files with this ending.
fn try_files(ending: &str, count: u64) {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join(format!("part.{ending}"));
    let geometry = Geometry::File { path: path.display().to_string(), unit: 1e-3 };
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        match load(&geometry) {
            Ok(loaded) => format!("a mesh; {:?}", loaded.repairs),
            Err(error) => error.to_string(),
        }
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs").join(ending);
    let mut inputs = inputs(&folder);
    if ending == "stl" {
        // Binary files are made here, so that the folder holds text alone.
        for geometry in [
            Geometry::Box { size: [0.001, 0.002, 0.003] },
            Geometry::Cylinder { radius: 0.002, length: 0.004 },
        ] {
            let mut bytes = Vec::new();
            Mesh::of(&geometry).unwrap().write_stl(&mut bytes, 1e-3).unwrap();
            inputs.push(bytes);
        }
    }
    let words = [
        "solid", "endsolid", "facet", "normal", "outer", "loop", "vertex", "endloop", "endfacet",
        "v ", "f ", "vn ", "vt ", "o ", "g ", "s ", "usemtl ", "mtllib ", "l ", "p ", "1/1/1",
        "-1", "#", "\n", "\\\n", "\u{feff}",
    ];
    let name = format!("files ending in {ending}");
    // A mesh has a tree, edges and neighbours: some hundred bytes for a triangle of nine.
    let memory = [1 << 20, 400];
    DamagedInput { name: &name, inputs, words: &words, read: &read, memory }.try_many(count);
}

#[test]
fn damaged_stl_files_are_meshes_or_errors() {
    try_files("stl", 1000);
}

#[test]
fn damaged_obj_files_are_meshes_or_errors() {
    try_files("obj", 1000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_stl_files_are_meshes_or_errors() {
    try_files("stl", 1_000_000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_obj_files_are_meshes_or_errors() {
    try_files("obj", 1_000_000);
}
