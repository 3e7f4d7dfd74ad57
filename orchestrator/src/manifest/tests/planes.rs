//! Plane scenes: cylinders and prisms across them.

use super::*;
use tremie_messages::scene::PolyhedronPlacement;

/// A plane of x and z: a cylinder, and two barges of 4 x 2 cm.
const PLANE: &str = r#"[run]
until = "1 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["20 cm", "5 cm", "20 cm"]
across = "y"

[[scene.shapes]]
name = "barge"
outline = [["-1 cm", "0 cm"], ["3 cm", "0 cm"], ["3 cm", "2 cm"], ["-1 cm", "2 cm"]]

[[scene.bodies]]
name = "cylinders"
density = "2500 kg/m3"
cylinders = [{ position = ["5 cm", "7 cm", "2 cm"], diameter = "1 cm" }]

[[scene.bodies]]
name = "barges"
density = "500 kg/m3"
shape = "barge"
prisms = [
    { position = ["8 cm", "0 cm", "10 cm"] },
    { position = ["8 cm", "0 cm", "15 cm"], turn = "90 deg", velocity = ["0 m/s", "0 m/s", "1 m/s"], angular_velocity = ["0 rad/s", "2 rad/s", "0 rad/s"] },
]

[[scene.contacts]]
normal_stiffness = "1e4 N/m"
tangential_stiffness = "8e3 N/m"
friction = 0.3
restitution = 0.8

[components]
grains = "grains-dem"
"#;

fn refused(from: &str, to: &str, words: &[&str]) {
    assert!(PLANE.contains(from), "{from}");
    one_problem(&PLANE.replacen(from, to, 1), words);
}

/// A prism is as large as its outline, as long as the domain is deep, and in its middle; its
/// centroid is where the manifest says.
#[test]
fn prisms_lie_across_the_plane() {
    let scene = read(PLANE).unwrap_or_else(|errors| panic!("{errors}")).spec.scene;
    let Placement::Listed(cylinders) = &scene.bodies[0].placement else { panic!() };
    assert_eq!(cylinders[0].position, [0.05, 0.025, 0.02]);
    let Placement::Polyhedra(barges) = &scene.bodies[1].placement else { panic!() };
    let PolyhedronPlacement::Listed(list) = &barges.placement else { panic!() };
    assert_eq!(list[0].position, [0.08, 0.025, 0.1]);
    let volume = std::f64::consts::PI / 6.0 * list[0].diameter.powi(3);
    assert!((volume / (0.04 * 0.02 * 0.05) - 1.0).abs() < 1e-12, "{volume}");
    let half = 0.5f64.sqrt();
    let orientation = [0.0, half, 0.0, half];
    assert!((0..4).all(|k| (list[1].orientation[k] - orientation[k]).abs() < 1e-15));
    assert_eq!(list[1].angular_velocity, [0.0, 2.0, 0.0]);
    assert_eq!(scene.shapes[0].vertices.len(), 8);
    reads_back(PLANE);
}

#[test]
fn problems_of_plane_scenes_are_told_at_their_keys() {
    refused("cylinders = [", "spheres = [", &["bodies[0].spheres", "cylinders or prisms"]);
    refused("shape = \"barge\"\n", "", &["bodies[1].shape", "missing"]);
    refused("shape = \"barge\"", "shape = \"cube\"", &["bodies[1].shape", "no outline"]);
    refused("\"2 rad/s\", \"0 rad/s\"]", "\"2 rad/s\", \"1 rad/s\"]", &["prisms[1]", "about y"]);
    refused("[\"0 m/s\", \"0 m/s\", \"1 m/s\"]", "[\"0 m/s\", \"3 m/s\", \"1 m/s\"]", &["along y"]);
    refused(", [\"3 cm\", \"2 cm\"], [\"-1 cm\", \"2 cm\"]", "", &["shapes[0].outline", "no area"]);
    let inner = "[\"-1 cm\", \"2 cm\"], [\"0 cm\", \"1 cm\"]]";
    refused("[\"-1 cm\", \"2 cm\"]]", inner, &["shapes[0].outline", "vertex 4 lies inside"]);
    refused("name = \"barge\"\n", "name = \"barge\"\nfile = \"a.stl\"\n", &["outline", "a file"]);
    refused("\"15 cm\"]", "\"25 cm\"]", &["prisms[1].position", "domain"]);
    let corners: Vec<String> = (0..31)
        .map(|k| {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / 31.0).sin_cos();
            format!("[\"{c} cm\", \"{s} cm\"]")
        })
        .collect();
    let square =
        "[\"-1 cm\", \"0 cm\"], [\"3 cm\", \"0 cm\"], [\"3 cm\", \"2 cm\"], [\"-1 cm\", \"2 cm\"]";
    refused(square, &corners.join(", "), &["found 31 corners, expected at most 30"]);
}

/// What only a plane scene has is refused in space, at its key.
#[test]
fn prisms_and_cylinders_need_a_plane() {
    let errors = read(&PLANE.replace("across = \"y\"\n", "")).unwrap_err().render(false);
    for key in ["shapes[0].outline", "bodies[0].cylinders", "bodies[1].prisms"] {
        assert!(errors.contains(key), "{key} is not in: {errors}");
    }
}
