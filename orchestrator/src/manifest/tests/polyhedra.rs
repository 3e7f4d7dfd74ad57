//! Shapes, and the polyhedra that have them.

use super::*;
use tremie_messages::scene::PolyhedronPlacement;

/// The good manifest with polyhedra in place of the spheres, without a fluid.
fn with_polyhedra() -> String {
    let sets = r#"
[[scene.shapes]]
name = "wedge"
vertices = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 1], [2, 0, 1], [0, 2, 1]]

[[scene.bodies]]
name = "cubes"
density = "2500 kg/m3"
shape = "cube"
polyhedra = [
    { position = ["50 mm", "50 mm", "50 mm"], edge = "4 mm", rotation = { axis = [0, 0, 2], angle = "90 deg" } },
    { position = ["50 mm", "50 mm", "80 mm"], diameter = "5 mm", velocity = ["0 m/s", "0 m/s", "1 m/s"] },
]

[[scene.bodies]]
name = "wedges"
density = "2500 kg/m3"
shape = "wedge"
packing = { min = ["0 mm", "0 mm", "2 mm"], max = ["1 cm", "1 cm", "1 cm"], fraction = 0.1, diameter = "1 mm" }

[[scene.contacts]]
"#;
    GOOD.replace("\n[[scene.contacts]]\n", sets)
}

fn refused(from: &str, to: &str, words: &[&str]) {
    let text = with_polyhedra();
    assert!(text.contains(from), "{from}");
    one_problem(&text.replacen(from, to, 1), words);
}

#[test]
fn polyhedra_are_read_in_si() {
    let text = with_polyhedra();
    let scene = read(&text).unwrap_or_else(|errors| panic!("{errors}")).spec.scene;
    let names: Vec<&str> = scene.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["cube", "wedge"]);
    assert_eq!((scene.shapes[0].vertices.len(), scene.shapes[1].vertices.len()), (8, 6));
    let Placement::Polyhedra(cubes) = &scene.bodies[2].placement else { panic!() };
    let PolyhedronPlacement::Listed(list) = &cubes.placement else { panic!() };
    // As large as a sphere of `pi/6 d^3 = a^3`.
    let equal = 4e-3 * (6.0 / std::f64::consts::PI).cbrt();
    assert!((list[0].diameter / equal - 1.0).abs() < 1e-14);
    let half = 0.5f64.sqrt();
    assert!((list[0].orientation[2] - half).abs() + (list[0].orientation[3] - half).abs() < 1e-15);
    assert_eq!((list[1].diameter, list[1].velocity), (5e-3, [0.0, 0.0, 1.0]));
    let Placement::Polyhedra(wedges) = &scene.bodies[3].placement else { panic!() };
    let PolyhedronPlacement::Packed(packing) = &wedges.placement else { panic!() };
    assert_eq!((wedges.shape.as_str(), packing.fraction, packing.seed), ("wedge", 0.1, 1));
    reads_back(&text);
}

#[test]
fn problems_of_polyhedra_are_told_at_their_keys() {
    let inside = &["shapes[0].vertices", "vertex 6 lies inside"];
    refused("[0, 2, 1]]", "[0, 2, 1], [0.4, 0.4, 0.5]]", inside);
    refused("[0, 0, 1], [2, 0, 1], [0, 2, 1]]", "[1, 1, 0]]", &["shapes[0].vertices", "plane"]);
    let twice = with_polyhedra().replace("\"wedge\"", "\"cube\"");
    one_problem(&twice, &["shapes[0].name", "second shape"]);
    refused("shape = \"cube\"", "shape = \"cuboid\"", &["bodies[2].shape", "tetrahedron"]);
    refused("shape = \"cube\"\n", "", &["bodies[2].shape", "missing"]);
    refused("edge = \"4 mm\",", "", &["polyhedra[0]", "edge", "diameter"]);
    refused("diameter = \"5 mm\"", "diameter = \"5 mm\", edge = \"1 mm\"", &["both an edge"]);
    refused("\"80 mm\"]", "\"800 mm\"]", &["polyhedra[1].position", "domain"]);
    refused("vertices = [", "file = \"a.stl\"\nvertices = [", &["shapes[0].file", "both"]);
    let spheres =
        "spheres = [{ position = [\"50 mm\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\" }]";
    refused(spheres, &format!("{spheres}\nshape = \"cube\""), &["bodies[0].shape", "spheres"]);
}
