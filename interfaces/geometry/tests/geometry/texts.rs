//! STL and OBJ files as programs of all kinds write them, and cut them off.

use crate::bodies::*;
use crate::files::{Folder, binary, near, text, why};
use proptest::prelude::*;
use tremie_geometry::{Fault, GeometryError};

/// The text of a cube of 2, with a name.
fn plain() -> String {
    text(&cube(2.0), " part")
}

#[test]
fn any_encoding_case_and_end_of_line_is_read() {
    let text = plain();
    let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(order).collect()
    };
    let named = |name: &[u8]| {
        let at = text.find("part").unwrap();
        [&text.as_bytes()[..at], name, &text.as_bytes()[at + 4..]].concat()
    };
    let cases: [(&str, Vec<u8>); 15] = [
        ("Latin-1 name", named(b"Geh\xe4use \xd83")),
        ("Shift-JIS name", named(b"\x83o\x83\x8b\x83u")),
        ("no name", named(b"")),
        ("a name of the grammar's words", named(b"facet endsolid 1,5")),
        ("mark of UTF-8", [b"\xef\xbb\xbf".as_slice(), text.as_bytes()].concat()),
        ("UTF-16, low byte first", wide(u16::to_le_bytes)),
        ("UTF-16, high byte first", wide(u16::to_be_bytes)),
        ("capitals", text.to_ascii_uppercase().into_bytes()),
        ("lines of DOS", text.replace('\n', "\r\n").into_bytes()),
        ("lines of an old Macintosh", text.replace('\n', "\r").into_bytes()),
        ("no lines at all", text.replace('\n', " ").into_bytes()),
        ("tabs and blank lines", text.replace('\n', "\n\t \n").replace(' ', "\t").into_bytes()),
        ("lines joined", text.replace("\n      vertex", " vertex").into_bytes()),
        (
            "normals that are none",
            text.replace("normal 0 0 0", "normal nan -1.#IND 0,5").into_bytes(),
        ),
        ("signs and exponents", text.replace("vertex 1e0", "vertex +1.0E+00").into_bytes()),
    ];
    for (about, bytes) in cases {
        let loaded = Folder::new().load("a.stl", &bytes, 1.0);
        let loaded = loaded.unwrap_or_else(|error| panic!("{about}: {error}"));
        assert_eq!(loaded.mesh.moments().volume, 8.0, "{about}");
        assert_eq!(loaded.mesh.triangles.len(), 12, "{about}");
    }
}

#[test]
fn what_is_wrong_with_a_text_is_told_with_its_line() {
    let text = plain();
    let half = &text[..text.len() / 2];
    let comma = text.replacen("vertex -1e0", "vertex 1,0", 1);
    for (name, bytes, parts) in [
        (
            "comma.stl",
            comma.clone(),
            &["line 4", "\"1,0\" is no number", "with a point", "vertex 1,0 "][..],
        ),
        (
            "word.stl",
            text.replacen("vertex -1e0", "vertex one", 1),
            &["line 4", "\"one\" is no number"],
        ),
        (
            "short.stl",
            text.replacen("vertex -1e0 ", "vertex ", 1),
            &["line 5", "\"vertex\" is no number"],
        ),
        (
            "infinite.stl",
            text.replacen("vertex -1e0", "vertex inf", 1),
            &["line 4", "\"inf\" is not finite"],
        ),
        (
            "large.stl",
            text.replacen("vertex -1e0", "vertex 1e400", 1),
            &["line 4", "\"1e400\" is not finite"],
        ),
        (
            "nan.stl",
            text.replacen("vertex -1e0", "vertex NaN", 1),
            &["line 4", "\"NaN\" is not finite"],
        ),
        (
            "four.stl",
            text.replacen("    endloop", "vertex 0 0 0\n    endloop", 1),
            &["line 7", "expected \"endloop\""],
        ),
        ("cut.stl", half.into(), &["cut off"]),
        (
            "no end.stl",
            text.replace("endsolid\n", ""),
            &["after 12 triangles", "\"endsolid\" of the solid of line 1"],
        ),
        ("name.stl", "solid par".into(), &["ends at line 1", "cut off"]),
        ("twice.stl", format!("{text}garbage"), &["expected \"solid\", found \"garbage\""]),
        (
            "comma.obj",
            "v 0 0 0\nv 1,5 0 0\nf 1 2 2\n".into(),
            &["line 2", "\"1,5\" is no number", "with a point"],
        ),
        ("corner.obj", "v 0 0 0\nv 1 0 0\nf 1 2 x\n".into(), &["line 3", "\"x\" names no corner"]),
    ] {
        let found = why(Folder::new().load(name, bytes.as_bytes(), 1.0));
        assert!(parts.iter().all(|part| found.contains(part)), "{name}: {found}");
    }
    let marked = b"\xef\xbb\xbf# n\xe4me\rv 0 0 0\rv 1 0 0\rv 0 1 0\rv 0 0 1\rf 1 3 2\rf 1 2 4\rf 2 3 4\rf 1 4 3\r";
    near(Folder::new().load("marked.obj", marked, 1.0).unwrap().mesh.moments().volume, 1.0 / 6.0);
}

#[test]
fn a_file_of_another_kind_is_called_what_it_looks_like() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 8\n".repeat(9);
    for (bytes, part) in [
        (&b"# a cube\no cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"[..], "an OBJ file"),
        (b"mtllib a.mtl\nv 0 0 0\n", "an OBJ file"),
        (ply.as_bytes(), "a PLY file"),
        (b"PK\x03\x04\x14\0\x06\0 and so on for more than eighty-four bytes, which a header of STL has, and more", "3MF"),
        (b"ISO-10303-21;\nHEADER;", "a STEP file"),
        (b"<?xml version=\"1.0\"?><amf>", "AMF"),
        (b"OFF\n8 6 0\n", "an OFF file"),
        (b"glTF\x02\0\0\0", "a glTF file"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n", "git lfs pull"),
        (b"<!DOCTYPE html><html>", "a page of the web"),
        (b"", "it is empty"),
    ] {
        let found = why(Folder::new().load("a.stl", bytes, 1.0));
        assert!(found.contains(part), "{part}: {found}");
    }
    let found = why(Folder::new().load("a.obj", plain().as_bytes(), 1.0));
    assert!(found.contains("an STL file in text"), "{found}");
}

#[test]
fn a_binary_file_is_known_by_its_length_whatever_its_header_says() {
    let mut bytes = binary(&cube(2.0), 1.0);
    bytes[..80].fill(b' ');
    bytes[..22].copy_from_slice(b"solid facet endsolid 1");
    near(Folder::new().load("a.stl", &bytes, 1.0).unwrap().mesh.moments().volume, 8.0);
    let cut = why(Folder::new().load("a.stl", &bytes[..bytes.len() - 1], 1.0));
    assert!(cut.contains("header says 12 triangles, but only 11 follow"), "{cut}");
    let short = why(Folder::new().load("a.stl", &bytes[..84], 1.0));
    assert!(short.contains("header says 12 triangles, but only 0 follow"), "{short}");
    bytes[80..84].fill(0);
    let none = why(Folder::new().load("a.stl", &bytes, 1.0));
    assert!(none.contains("header says 0 triangles"), "{none}");
}

#[test]
fn a_damaged_corner_is_named_and_not_what_it_does_to_the_rest() {
    for (number, name) in [("1e30", "1e30"), ("-4e12", "-4e12"), ("7e7", "7e7")] {
        // In one triangle of the surface, and in all.
        for count in [1, usize::MAX] {
            let text = plain().replacen("vertex 1e0 1 1", &format!("vertex {number} 1 1"), count);
            let found = why(Folder::new().load("a.stl", text.as_bytes(), 1e3));
            let is_named = found.contains("has a corner at") && found.contains(name);
            assert!(is_named, "{number}, {count}: {found}");
        }
    }
    let mut mesh = torn(&cube(2.0));
    mesh.vertices[7][2] = 3e38;
    let found = why(Folder::new().load("a.stl", &binary(&mesh, 1.0), 1e-3));
    assert!(found.contains("triangle 3 has a corner at") && found.contains("damaged"), "{found}");
    // Large and small in one part are no damage.
    let fine = both(&cube(1e4), &moved(&cube(1.0), Vec3::new(3e4, 0.0, 0.0)));
    near(
        Folder::new().load("a.stl", &binary(&fine, 1.0), 1.0).unwrap().mesh.moments().volume,
        1e12,
    );
}

#[test]
fn a_part_far_from_its_files_origin_keeps_its_shape() {
    let ring = torus(5.0, 2.0, 48, 24);
    let there = Vec3::new(1e6, -2e6, 3e5);
    let loaded =
        Folder::new().load("a.stl", text(&moved(&ring, there), "").as_bytes(), 1e-3).unwrap();
    let repairs = loaded.repairs;
    assert_eq!(
        (repairs.welded_near, repairs.dropped, repairs.turned, repairs.flipped),
        (0, 0, 0, 0)
    );
    assert_eq!(loaded.mesh.vertices.len(), ring.vertices.len());
    for expected in &ring.vertices {
        let expected = (expected + there) * 1e-3;
        let nearest =
            loaded.mesh.vertices.iter().map(|v| (*v - expected).norm()).fold(1.0, f64::min);
        assert!(nearest < 1e-12, "{nearest}");
    }
    let said = repairs.to_string();
    assert!(said.contains("it lies 2.0") && said.contains("from the origin of its file"), "{said}");
    // A binary file has lost what it cannot hold, and the same words say so.
    let said = Folder::new().load("b.stl", &binary(&moved(&ring, there), 1.0), 1e-3);
    let said = said.map_or_else(|error| error.to_string(), |loaded| loaded.repairs.to_string());
    assert!(said.contains("single precision"), "{said}");
    // What is near its origin is said to be nowhere.
    let near = Folder::new()
        .load("c.stl", text(&moved(&ring, Vec3::from_element(50.0)), "").as_bytes(), 1e-3)
        .unwrap();
    assert_eq!(near.repairs.to_string(), "nothing");
}

/// A cube one side of which has one corner more than its neighbours, on an edge between them.
fn with_junction(fraction: f64) -> tremie_geometry::Mesh {
    let mut mesh = cube(2.0);
    let on_edge = |t: &[u32; 3]| (0..3).find(|&i| [t[i], t[(i + 1) % 3]] == [0, 1]);
    let (split, i) =
        mesh.triangles.iter().enumerate().find_map(|(k, t)| Some((k, on_edge(t)?))).unwrap();
    let tip = mesh.triangles[split][(i + 2) % 3];
    let [a, b] = [mesh.vertices[0], mesh.vertices[1]];
    mesh.vertices.push(Vec3::from_fn(|k, _| a[k] + fraction * (b[k] - a[k])));
    mesh.triangles.remove(split);
    mesh.triangles.extend([[0, 8, tip], [8, 1, tip]]);
    mesh
}

#[test]
fn t_junctions_are_told_from_holes() {
    let faults =
        |mesh: &tremie_geometry::Mesh| match Folder::new().load("a.stl", &binary(mesh, 1.0), 1.0) {
            Err(GeometryError::Faults(faults)) => faults,
            other => panic!("{other:?}"),
        };
    for fraction in [0.5, 0.01, 0.999] {
        let found = faults(&with_junction(fraction));
        let [Fault::Junction { corners: 1, first, .. }] = found[..] else { panic!("{found:?}") };
        assert!((first[0] - (2.0 * fraction - 1.0)).abs() < 1e-6, "{first:?}");
        let said = found[0].to_string();
        assert!(said.contains("1 T-junction") && said.contains("on the edge from"), "{said}");
    }
    // Two cubes, one with a junction, one with a hole.
    let mut holed = moved(&cube(2.0), Vec3::new(9.0, 0.0, 0.0));
    holed.triangles.pop();
    let found = faults(&both(&with_junction(0.3), &holed));
    assert!(
        matches!(
            found[..],
            [Fault::Junction { corners: 1, .. }, Fault::Open { edges: 3, holes: 1, .. }]
        ),
        "{found:?}"
    );
    // A missing triangle is no junction, also where corners are in line with its edges.
    let mut holed = torus(1.0, 0.3, 12, 8);
    holed.triangles.drain(5..8);
    assert!(matches!(faults(&holed)[..], [Fault::Open { .. }]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bytes_are_a_mesh_or_an_error(
        bytes in proptest::collection::vec(any::<u8>(), 0..300), kind in 0..4, at in any::<prop::sample::Index>(),
    ) {
        let mut file = match kind {
            0 => Vec::new(),
            1 => plain().into_bytes(),
            2 => b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0 ".to_vec(),
            _ => b"\xff\xfes\0o\0l\0i\0d\0\n\0".to_vec(),
        };
        let at = at.index(file.len() + 1);
        file.splice(at..at, bytes);
        let folder = Folder::new();
        let _ = folder.load("a.stl", &file, 1.0);
        let _ = folder.load("a.obj", &file, 1.0);
    }

    #[test]
    fn numbers_keep_all_their_digits(x in -1e8..1e8f64, y in -1e-9..1e-9f64, z in -1e3..1e3f64) {
        let shape = tetrahedron();
        let size = 1e3 * (1.0 + x.abs());
        let corner = |v: &Vec3| Vec3::new(x, y, z) + v * size;
        let mesh = tremie_geometry::Mesh { vertices: shape.vertices.iter().map(corner).collect(), ..shape };
        let loaded = Folder::new().load("a.stl", text(&mesh, "").as_bytes(), 1e-3).unwrap();
        let mut found: Vec<_> = loaded.mesh.vertices.clone();
        let mut expected: Vec<_> = mesh.vertices.iter().map(|v| v.map(|x| x * 1e-3)).collect();
        let order = |a: &Vec3, b: &Vec3| a.iter().zip(b.iter()).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal);
        found.sort_by(order);
        expected.sort_by(order);
        prop_assert_eq!(found, expected);
    }
}
