//! Deformable surfaces.

use super::*;
use std::path::PathBuf;
use tremie_messages::scene::FacetKind;
use tremie_rubber_table::table::{Contents, Facets, Table};

/// A ring 1 mm high and wide whose sides stay upright, in a folder of its own.
fn contents() -> Contents {
    let frame = |c: f64| vec![[2e-3, c], [3e-3, c], [3e-3, 1e-3], [2e-3, 1e-3]];
    Contents {
        source: "by hand".into(),
        compressions: vec![0.0, 1e-4, 2e-4],
        forces: vec![0.0, 5.0, 11.0],
        vertices: [0.0, 1e-4, 2e-4].map(frame).to_vec(),
        facets: Facets {
            seat: vec![[0, 1]],
            exposed: vec![[1, 2], [3, 0]],
            bonded: vec![[2, 3]],
            ..Facets::default()
        },
        ..Contents::default()
    }
}

struct Folder {
    _home: tempfile::TempDir,
    table: PathBuf,
}

fn folder(contents: Contents) -> Folder {
    let home = tempfile::tempdir().unwrap();
    let table = home.path().join("ring.json");
    Table::new(contents).unwrap().write(&table).unwrap();
    Folder { _home: home, table }
}

/// The good manifest with a part, a surface on it with `lines`, and a rubber.
fn text(lines: &str) -> String {
    let part = "[[scene.parts]]\nname = \"disc\"\ncylinder = { radius = \"3 mm\", length = \"1 mm\" }\nposition = [\"50 mm\", \"50 mm\", \"60 mm\"]";
    let good = GOOD.replace("[components]\n", "[components]\nrubber = \"rubber-table\"\n");
    format!("{good}\n{part}\n[[scene.surfaces]]\nname = \"ring\"\n{lines}\n")
}

fn on_disc(folder: &Folder, lines: &str) -> String {
    text(&format!("carrier = \"disc\"\ntable = {:?}\n{lines}", folder.table))
}

#[test]
fn a_surface_is_its_table_turned_on_its_carrier() {
    let folder = folder(contents());
    let text = on_disc(&folder, "position = [\"0 mm\", \"0 mm\", \"-1 mm\"]\nstart = \"0.12 mm\"");
    let spec = read(&text).unwrap().spec;
    let surface = &spec.scene.surfaces[0];
    assert_eq!((surface.name.as_str(), surface.carrier.as_str()), ("ring", "disc"));
    assert_eq!((surface.sectors, surface.material.as_str()), (60, "wall"));
    assert_eq!(surface.pose.position, [0.0, 0.0, -1e-3]);
    assert_eq!(surface.start.compression, 1.2e-4);
    // The foot at 0.12 mm, in a section 1 mm high.
    let heights: Vec<f64> = surface.start_points().iter().map(|point| point[1]).collect();
    let expected = [1.2e-4, 1.2e-4, 1e-3, 1e-3];
    assert!(heights.iter().zip(expected).all(|(z, e)| (z - e).abs() < 1e-15), "{heights:?}");
    assert_eq!(surface.section.points, contents().vertices[0]);
    let kinds: Vec<_> = surface.section.edges.iter().map(|edge| edge.kind).collect();
    use FacetKind::{Bonded, Exposed, Seat};
    assert_eq!(kinds, [Seat, Exposed, Exposed, Bonded]);
    assert_eq!((surface.vertex_count(), surface.facet_count()), (240, 480));
    // A hundred times 5 N over 0.1 mm, over the foot's area.
    let foot = std::f64::consts::PI * (9.0 - 4.0) * 1e-6;
    assert!((surface.seat_stiffness * foot / 5e6 - 1.0).abs() < 1e-12);
    assert_eq!(spec.component("rubber").unwrap().role, Role::Rubber);
    reads_back(&text);
}

#[test]
fn what_is_wrong_with_a_surface_is_said_with_its_key() {
    let good = folder(contents());
    let refused = |text: &str, words: &[&str]| one_problem(text, words);
    refused(&on_disc(&good, "sectors = 2"), &["scene.surfaces[0].sectors", "found 2"]);
    refused(&on_disc(&good, "seat_stiffness = \"0 N/m\""), &["seat_stiffness", "more than zero"]);
    refused(&on_disc(&good, "compression = \"0.25 mm\""), &["compression", "2.5e-4 m", "2e-4 m"]);
    refused(&on_disc(&good, "start = \"0.25 mm\""), &["start", "2.5e-4 m", "larger compression"]);
    refused(&on_disc(&good, "start = \"-1 um\""), &["start", "-1e-6 m", "zero or more"]);
    refused(&on_disc(&good, "material = \"rubbr\""), &["there is no material \"rubbr\""]);
    refused(
        &on_disc(&good, "").replace("carrier = \"disc\"", "carrier = \"disk\""),
        &["there is no part \"disk\"", "did you mean \"disc\"?"],
    );
    refused(
        &text("carrier = \"disc\"\ntable = \"nowhere.json\""),
        &["scene.surfaces[0].table", "nowhere.json", "tremie rubber make-table"],
    );
    refused(&text("carrier = \"disc\""), &["missing", "\"table\""]);
    refused(
        &on_disc(&good, "").replace("name = \"ring\"", "name = \"disc\""),
        &["a second part or surface with the name \"disc\""],
    );
    let mut bare = contents();
    bare.facets.exposed.clear();
    refused(&on_disc(&folder(bare), ""), &["no facets are \"exposed\""]);
    // A and B overlap.
    let overlapping = std::fs::read_to_string(&good.table).unwrap();
    let overlapping = overlapping.replace("\"exposed\":[[1,2]", "\"exposed\":[[0,1],[1,2]");
    std::fs::write(&good.table, overlapping).unwrap();
    refused(&on_disc(&good, ""), &["scene.surfaces[0].table", "two facets begin or end at vertex"]);
}

#[test]
fn surfaces_rubber_and_grains_need_each_other() {
    let folder = folder(contents());
    let whole = on_disc(&folder, "");
    one_problem(
        &whole.replace("rubber = \"rubber-table\"\n", ""),
        &["scene.surfaces[0]", "nobody shapes this surface", "rubber = \"rubber-table\""],
    );
    one_problem(
        &GOOD.replace("[components]\n", "[components]\nrubber = \"rubber-table\"\n"),
        &["components.rubber", "a rubber needs a surface", "[[scene.surfaces]]"],
    );
    let alone = whole
        .replace("grains = { program = \"grains-dem\", sync_iter = 3 }\n", "")
        .replace("signal = \"grains.max_speed\"", "signal = \"fluid.max_speed\"");
    one_problem(&alone, &["a rubber needs grains", "grains = \"grains-dem\""]);
    one_problem(
        &whole.replace(
            "[components]\n",
            "[components]\nother = { program = \"x\", role = \"rubber\" }\n",
        ),
        &["a second component with the role rubber"],
    );
    one_problem(
        &whole.replace(
            "rubber = \"rubber-table\"",
            "rubber = { program = \"rubber-table\", sync_iter = 2 }",
        ),
        &["sync_iter", "the substeps of the grains"],
    );
}
