//! From a specification to a table, its file and its pictures.

use std::path::Path;
use tremie_rubber_table::make::{MakeError, make};
use tremie_rubber_table::picture::{draw_force, draw_shapes};
use tremie_rubber_table::spec::Spec;
use tremie_rubber_table::table::Table;

const RING: &str = r#"
[section.rectangle]
inner_radius = "6.5 mm"
outer_radius = "11 mm"
height = "3 mm"
elements = [18, 12]

[rubber]
shear_modulus = "0.3 MPa"
bulk_modulus = "8 MPa"

[table]
compression = "0.6 mm"
"#;

fn parse(text: &str) -> Spec {
    Spec::parse(Path::new("ring.toml"), text.into()).unwrap()
}

fn table(text: &str) -> Table {
    make(&parse(text)).unwrap()
}

fn refused(text: &str) -> String {
    Spec::parse(Path::new("ring.toml"), text.into()).unwrap_err().to_string()
}

/// A ring on a hub: its inner side cannot bulge, and is neither exposed nor bonded. So its outer
/// side gives as much way as its foot takes, but for what the rubber shrinks; where the inner side
/// is free, by a third less.
#[test]
fn a_side_on_a_hub_is_covered_and_does_not_bulge() {
    let guided = "[carrier]\nbonded = [\"top\"]\nguided = [\"inner\"]\n\n[table]";
    let on_hub = table(&RING.replace("[table]", guided));
    let facets = &on_hub.contents().facets;
    assert_eq!((facets.covered.len(), facets.exposed.len(), facets.bonded.len()), (12, 12, 18));
    // Volume that the outer side sweeps, over that of the foot, in the first frame.
    let swept = |table: &Table| {
        let [rest, next] = [0, 1].map(|frame| &table.contents().vertices[frame]);
        let outer = |edge: &&[usize; 2]| edge.iter().all(|&v| rest[v][0] > 10e-3);
        let of = |&[a, b]: &[usize; 2]| {
            let out = 0.5 * (next[a][0] - rest[a][0] + next[b][0] - rest[b][0]);
            2.0 * rest[a][0] * (rest[b][1] - rest[a][1]).abs() * out
        };
        let swept: f64 = table.contents().facets.exposed.iter().filter(outer).map(of).sum();
        swept / ((11e-3f64.powi(2) - 6.5e-3f64.powi(2)) * table.contents().compressions[1])
    };
    let [on_hub_, free] = [&on_hub, &table(RING)].map(swept);
    assert!((on_hub_ - 0.9).abs() < 0.05 && (free - 0.69).abs() < 0.02, "{on_hub_} {free}");
    for vertices in &on_hub.contents().vertices {
        let is_on_hub = |&v: &usize| (vertices[v][0] - 6.5e-3).abs() < 1e-15;
        assert!(facets.covered.iter().flatten().all(is_on_hub));
    }
}

#[test]
fn the_ring_of_the_valve_becomes_a_table() {
    let table = table(RING);
    let contents = table.contents();
    assert_eq!((table.frames(), table.last_compression()), (41, 0.6e-3));
    let at = table.bracket(0.48e-3).unwrap();
    assert!((table.force(at) / 66.76 - 1.0).abs() < 1e-3, "{}", table.force(at));
    assert_eq!(contents.facets.bonded.len(), 18);
    assert_eq!(contents.facets.seat.len(), 18);
    assert_eq!(contents.facets.exposed.len(), 24);
    assert!(contents.source.contains("inner_radius = \"6.5 mm\""));
    assert!(contents.convergence.iter().all(|frame| frame.stable && frame.residual <= 1e-9));
    // Simpson's rule over the frames.
    let work: f64 =
        contents.forces.windows(3).step_by(2).map(|f| (f[0] + 4.0 * f[1] + f[2]) * 5e-6).sum();
    assert!((work / contents.energies[40] - 1.0).abs() < 1e-6, "{work} {}", contents.energies[40]);
}

/// Pressed by half its height, the ring has lifted its outer rim off the seat. `foot_at` keeps the rim with the
/// foot, and changes nothing else.
#[test]
fn a_longer_table_keeps_the_foot_of_a_shorter_one() {
    let ring = RING
        .replace("[18, 12]", "[9, 6]")
        .replace("[table]", "[carrier]\nbonded = [\"top\"]\nguided = [\"inner\"]\n\n[table]");
    let short = table(&ring.replace("0.6 mm", "0.9 mm"));
    let long = ring.replace("0.6 mm", "1.5 mm");
    let (without, with) = (table(&long), table(&format!("{long}foot_at = \"0.9 mm\"\n")));
    let foot = |table: &Table| table.contents().facets.seat.clone();
    assert!(foot(&without).len() < foot(&short).len(), "{:?}", foot(&without));
    assert_eq!(foot(&with), foot(&short));
    assert_eq!(with.contents().forces, without.contents().forces);
    assert_eq!(with.contents().vertices, without.contents().vertices);
}

/// A table that is read equals that which was made, bit for bit.
#[test]
fn a_table_is_written_read_and_drawn() {
    let table = table(&RING.replace("[18, 12]", "[6, 4]"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ring.json");
    table.write(&file).unwrap();
    assert_eq!(Table::read(&file).unwrap(), table);
    let (force, shapes) = (folder.path().join("force.svg"), folder.path().join("shapes.svg"));
    draw_force(&table, &force).unwrap();
    draw_shapes(&table, &shapes).unwrap();
    let text = std::fs::read_to_string(&force).unwrap();
    assert_eq!(text.matches("<circle").count(), 41, "a mark for each frame");
    let text = std::fs::read_to_string(&shapes).unwrap();
    assert_eq!(
        text.matches("<polygon").count(),
        4 * 24,
        "a polygon for each quadrilateral of four frames"
    );
    assert!(draw_force(&table, Path::new("/no/such/force.svg")).is_err());
}

/// Bonded above, an O-ring and a D-ring roll onto a flat seat; so does the ring onto a cone.
#[test]
fn other_sections_and_seats_become_tables() {
    let section = |table: &str| {
        let (before, after) = (RING.find("[section").unwrap(), RING.find("[rubber").unwrap());
        format!("{}{table}\n{}", &RING[..before], &RING[after..])
    };
    let o_ring =
        section("[section.o_ring]\ndiameter = \"20 mm\"\nthickness = \"3 mm\"\nelements = 6\n");
    let d_ring =
        section("[section.d_ring]\ndiameter = \"20 mm\"\nwidth = \"4 mm\"\nelements = 6\n");
    let cone = "[seat]\nmeridian = [[\"5 mm\", \"1 mm\"], [\"8 mm\", \"0 mm\"], [\"12 mm\", \"0.8 mm\"]]\nrounding = \"0.4 mm\"\n";
    for text in [o_ring, d_ring, format!("{}{cone}", RING.replace("[18, 12]", "[9, 6]"))] {
        let table = table(&text);
        let seat = &table.contents().facets.seat;
        assert!(!seat.is_empty() && seat.len() < 12, "part of the outline touches: {seat:?}");
    }
}

#[test]
fn a_mesh_from_a_file_is_found_beside_the_specification() {
    let folder = tempfile::tempdir().unwrap();
    let msh =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 5 \"steel\"\n$EndPhysicalNames
$Nodes\n6\n1 6.5 0 0\n2 8.7 0 0\n3 11 0 0\n4 6.5 3 0\n5 8.8 3 0\n6 11 3 0\n$EndNodes
$Elements\n4\n1 1 2 5 1 5 4\n2 1 2 5 1 6 5\n3 3 2 7 1 1 2 5 4\n4 3 2 7 1 2 3 6 5\n$EndElements\n";
    std::fs::write(folder.path().join("seal.msh"), msh).unwrap();
    let text = "section.mesh = { file = \"seal.msh\", unit = \"1 mm\" }\ncarrier.bonded = [\"steel\"]\n\
                rubber = { shear_modulus = \"0.3 MPa\", bulk_modulus = \"8 MPa\" }\ntable.compression = \"0.3 mm\"\n";
    let path = folder.path().join("seal.toml");
    std::fs::write(&path, text).unwrap();
    let table = make(&Spec::read(&path).unwrap()).unwrap();
    assert_eq!(table.contents().quads.len(), 2);
    std::fs::write(&path, text.replace("seal.msh", "soul.msh")).unwrap();
    let error = Spec::read(&path).unwrap_err().to_string();
    assert!(error.contains("soul.msh") && error.contains("seal.toml:1:"), "{error}");
    std::fs::write(&path, text.replace("steel", "stele")).unwrap();
    let error = Spec::read(&path).unwrap_err().to_string();
    assert!(error.contains("\"stele\"; it has steel") && error.contains("seal.toml:2:"), "{error}");
}

#[test]
fn slips_are_shown_with_line_and_remedy() {
    let error = refused(&RING.replace("shear_modulus", "shera_modulus"));
    assert!(error.contains("unknown key \"shera_modulus\""), "{error}");
    assert!(
        error.contains("ring.toml:9:1") && error.contains("did you mean \"shear_modulus\"?"),
        "{error}"
    );
    let error = refused(&RING.replace("[rubber]", "[steel]"));
    assert!(error.contains("valid keys: section, rubber"), "{error}");
    let error = refused(&RING.replace("rectangle", "rectagle"));
    assert!(error.contains("did you mean \"rectangle\"?"), "{error}");
    let error = refused(&RING.replace("\"0.6 mm\"", "0.6"));
    assert!(error.contains("a length with a unit") && error.contains("ring.toml:13:15"), "{error}");
    let error = refused(&RING.replace("compression", "#"));
    assert!(error.contains("\"compression\" is missing"), "{error}");
    let error = refused(&format!("{RING}\n[section.o_ring]\ndiameter = \"1 mm\"\n"));
    assert!(error.contains("expected one") && error.contains("section.rectangle"), "{error}");
    assert!(refused("x = = 1").contains("ring.toml:1:"));
    let error = Spec::read(Path::new("/no/such.toml")).unwrap_err().to_string();
    assert!(error.contains("cannot read /no/such.toml"), "{error}");
}

#[test]
fn values_that_make_no_sense_are_all_told_at_once() {
    let text = RING.replace("11 mm", "5 mm").replace("8 MPa", "-8 MPa")
        + "frames = 20\n[seat]\nstiffness = 0\n";
    let error = refused(&text.replace("stiffness = 0", "stiffness = 0.0"));
    for part in [
        "section.rectangle.outer_radius: found 0.005 m, expected more than inner_radius",
        "rubber.bulk_modulus: found -8000000 Pa",
        "table.frames: found 20, expected 33 to 2000",
        "seat.stiffness: found 0",
        "4 problems",
        "ring.toml:14:10",
    ] {
        assert!(error.contains(part), "{part}\n{error}");
    }
    let error = refused(&RING.replace("[18, 12]", "[400, 101]"));
    assert!(error.contains("40400 quadrilaterals"), "{error}");
    let error = refused(&(RING.replace("[18, 12]", "[200, 200]") + "frames = 400\n"));
    assert!(error.contains("at most 250") && error.contains("ring.toml:14:"), "{error}");
    for foot_at in ["0.014 mm", "0.61 mm"] {
        let error = refused(&format!("{RING}foot_at = \"{foot_at}\"\n"));
        assert!(error.contains("table.foot_at") && error.contains("ring.toml:14:"), "{error}");
    }
    let error = refused(&RING.replace("0.6 mm", "3 mm"));
    assert!(error.contains("less than the section's height"), "{error}");
    let error = refused(&format!(
        "{RING}[seat]\nmeridian = [[\"2 mm\", \"0 mm\"], [\"1 mm\", \"0 mm\"]]\n"
    ));
    assert!(error.contains("seat.meridian: point 1") && error.contains("ring.toml:15:"), "{error}");
    let error =
        refused(&format!("{RING}[carrier]\nbonded = [\"top\"]\nsliding = [\"inner\", \"roof\"]\n"));
    assert!(error.contains("\"roof\"; it has bottom, inner, outer, top"), "{error}");
}

#[test]
fn what_cannot_be_compressed_so_far_says_how_far_it_went() {
    let spec = parse(&RING.replace("0.6 mm", "2.99 mm").replace("[18, 12]", "[6, 4]"));
    let Err(MakeError::Stuck(stuck)) = make(&spec) else { panic!("that cannot be") };
    assert!(stuck.reached > 0.6e-3, "{stuck}");
}
