//! STL and OBJ files, orderly and not.

use crate::bodies::*;
use proptest::prelude::*;
use std::fmt::Write;
use tempfile::TempDir;
use tremie_geometry::{GeometryError, Loaded, Mesh, load};
use tremie_messages::scene::Geometry;

pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Loads a file of this name with these bytes.
    pub fn load(&self, name: &str, bytes: &[u8], unit: f64) -> Result<Loaded, GeometryError> {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        load(&Geometry::File { path: path.to_str().unwrap().to_string(), unit })
    }
}

pub fn binary(mesh: &Mesh, unit: f64) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh.write_stl(&mut bytes, unit).unwrap();
    bytes
}

pub fn text(mesh: &Mesh, name: &str) -> String {
    let mut text = format!("solid{name}\n");
    for t in 0..mesh.triangles.len() {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for [x, y, z] in mesh.corners(t).map(<[f64; 3]>::from) {
            writeln!(text, "      vertex {x:e} {y} {z}").unwrap();
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid\n"
}

fn volume(loaded: Result<Loaded, GeometryError>) -> f64 {
    loaded.unwrap().mesh.moments().volume
}

pub fn why(loaded: Result<Loaded, GeometryError>) -> String {
    loaded.unwrap_err().to_string()
}

pub fn near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-6, "found {found}, expected {expected}");
}

#[test]
fn a_mesh_survives_a_binary_file_but_for_single_precision() {
    let mesh = torus(0.05, 0.02, 24, 16);
    let folder = Folder::new();
    let loaded = folder.load("ring.stl", &binary(&mesh, 1e-3), 1e-3).unwrap();
    assert_eq!(loaded.mesh.vertices.len(), mesh.vertices.len());
    assert_eq!(loaded.mesh.triangles.len(), mesh.triangles.len());
    assert_eq!((loaded.repairs.turned, loaded.repairs.dropped), (0, 0));
    for t in 0..mesh.triangles.len() {
        for (found, expected) in loaded.mesh.corners(t).iter().zip(mesh.corners(t)) {
            assert!((*found - expected).norm() < 1e-8);
        }
    }
}

#[test]
fn a_text_file_in_millimetres_or_inches_is_scaled() {
    let text = text(&cube(10.0), " part of a pump");
    let folder = Folder::new();
    near(volume(folder.load("a.stl", text.as_bytes(), 1e-3)), 1e-6);
    near(volume(folder.load("A.STL", text.as_bytes(), 0.0254)), 1e3 * 0.0254f64.powi(3));
    let loaded = folder.load("b.stl", text.as_bytes(), 1e-3).unwrap();
    assert_eq!(loaded.mesh.bounds().max, Vec3::from_element(0.005));
    assert!(why(folder.load("c.stl", text.as_bytes(), -1.0)).contains("unit is -1"));
}

#[test]
fn disorderly_stl_files_are_read() {
    let mesh = cube(1.0);
    let folder = Folder::new();
    let mut solid = binary(&mesh, 1.0);
    solid[..11].copy_from_slice(b"solid Pump ");
    near(volume(folder.load("solid.stl", &solid, 1.0)), 1.0);
    solid.extend(b"colours of some program");
    solid[..5].copy_from_slice(b"part ");
    near(volume(folder.load("more.stl", &solid, 1.0)), 1.0);
    let shouted = text(&mesh, "").to_ascii_uppercase().replace('\n', "\r\n\r\n");
    near(volume(folder.load("capitals.stl", shouted.as_bytes(), 1.0)), 1.0);
    let two = text(&mesh, " one") + &text(&moved(&mesh, Vec3::new(3.0, 0.0, 0.0)), " two");
    let loaded = folder.load("two.stl", two.as_bytes(), 1.0).unwrap();
    assert_eq!(loaded.repairs.shells, 2);
    near(loaded.mesh.moments().volume, 2.0);
}

#[test]
fn files_that_are_none_are_refused_with_a_reason() {
    let folder = Folder::new();
    let bytes = binary(&cube(1.0), 1.0);
    let cut = why(folder.load("cut.stl", &bytes[..bytes.len() - 1], 1.0));
    assert!(cut.contains("header says 12 triangles, but only 11 follow"), "{cut}");
    let short = why(folder.load("short.stl", b"nothing", 1.0));
    assert!(short.contains("7 bytes"), "{short}");
    let text = text(&cube(1.0), "").replacen("endloop", "end", 1);
    let bad = why(folder.load("bad.stl", text.as_bytes(), 1.0));
    assert!(bad.contains("line 7: \"end\": expected \"endloop\", found \"end\""), "{bad}");
    let huge = text.replacen("end\n", "endloop\n", 1).replacen("5e-1", "1e39", 1);
    let huge = why(folder.load("huge.stl", huge.as_bytes(), 1.0));
    assert!(huge.contains("triangle 1 has a corner at (-1e39"), "{huge}");
    assert!(why(folder.load("part.step", b"", 1.0)).contains("neither in .stl nor in .obj"));
    assert!(why(folder.load("bad.obj", b"v 1 2\nf 1 1 1\n", 1.0)).contains("OBJ"));
    assert!(why(folder.load("far.obj", b"v 0 0 0\nf 1 2 3\n", 1.0)).contains("OBJ"));
    let missing = load(&Geometry::File { path: "/no/such.stl".to_string(), unit: 1.0 });
    assert!(matches!(missing, Err(GeometryError::Read { .. })));
    assert!(matches!(folder.load("e.obj", b"# nothing\n", 1.0), Err(GeometryError::Empty { .. })));
    let nan = folder.load("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 1.0);
    assert!(matches!(nan, Err(GeometryError::NotFinite { triangle: 0, .. })));
}

#[test]
fn an_obj_file_of_polygons_in_objects_with_materials_is_read() {
    // An L extruded: two six-cornered ends, which are not convex, and quadrilaterals between.
    let profile = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]];
    let mut obj = String::from("mtllib none.mtl\no L\n");
    for z in [0, 1] {
        for [x, y] in profile {
            writeln!(obj, "v {x} {y} {z}.0").unwrap();
        }
    }
    obj += "vt 0 0\nvn 0 0 1\nusemtl steel\nf 6//1 5//1 4//1 3//1 2//1 1//1\n";
    obj += "g roof\nusemtl brass\nf 7/1/1 8/1/1 9/1/1 10/1/1 11/1/1 12/1/1\ng sides\n";
    for i in 0..6 {
        let j = (i + 1) % 6;
        // Counted from the end.
        writeln!(obj, "f {} {} {} {}", i - 12, j - 12, j - 6, i - 6).unwrap();
    }
    obj += "l 1 2\np 3\n";
    let loaded = Folder::new().load("l.obj", obj.as_bytes(), 0.1).unwrap();
    assert_eq!(loaded.mesh.vertices.len(), 12);
    assert_eq!(loaded.mesh.triangles.len(), 2 * 4 + 6 * 2);
    near(loaded.mesh.moments().volume, 4e-3);
    near(loaded.mesh.moments().area, 0.01 * (2.0 * 4.0 + 10.0));
}

#[test]
fn a_hole_in_a_file_is_told_in_metres() {
    let mut mesh = cube(10.0);
    mesh.triangles.pop();
    let text = why(Folder::new().load("open.stl", text(&mesh, "").as_bytes(), 1e-3));
    assert!(text.contains("not closed: 3 open edges in 1 hole"), "{text}");
    assert!(text.contains("0.005) m"), "{text}");
}

#[test]
fn what_single_precision_cannot_hold_is_not_written() {
    let error = cube(1e30).write_stl(&mut Vec::new(), 1e-9).unwrap_err();
    assert!(matches!(error, GeometryError::NotFinite { .. }));
    assert!(cube(1.0).write_stl(&mut Vec::new(), 0.0).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn damaged_files_make_errors_and_no_panics(
        kind in 0..3, at in any::<prop::sample::Index>(), with in any::<[u8; 3]>(), cut in 0..200usize,
    ) {
        let mesh = tetrahedron();
        let (name, mut bytes) = match kind {
            0 => ("a.stl", binary(&mesh, 1.0)),
            1 => ("a.stl", text(&mesh, " x").into_bytes()),
            _ => ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf -4 2 4\nf 1 4 3\nf 2/1/1 3 4\n".to_vec()),
        };
        let from = at.index(bytes.len());
        let until = (from + 3).min(bytes.len());
        bytes[from..until].copy_from_slice(&with[..until - from]);
        bytes.truncate(bytes.len() - cut.min(bytes.len() / 2) / 2);
        let _ = Folder::new().load(name, &bytes, 1.0);
    }

    #[test]
    fn obj_faces_with_any_numbers_make_errors_and_no_panics(
        faces in proptest::collection::vec(proptest::collection::vec(any::<i64>(), 0..7), 0..4),
    ) {
        let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n");
        for face in faces {
            obj += "f";
            for n in face {
                write!(obj, " {n}").unwrap();
            }
            obj += "\n";
        }
        let _ = Folder::new().load("a.obj", obj.as_bytes(), 1.0);
    }
}
