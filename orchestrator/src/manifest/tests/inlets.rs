//! Inlets and outlets of grains.

use super::*;
use tremie_messages::scene::{Inlet, InletVelocity, Outlet};

/// The good manifest with two inlets and two outlets.
fn with_ports() -> String {
    let ports = r#"
[[scene.inlets]]
name = "feed"
bodies = "bed"
min = ["0 mm", "0 mm", "2 mm"]
max = ["1 cm", "1 cm", "6 mm"]
fraction = 0.05
diameter = "1 mm"
every = "1 ms"
velocity = ["0 m/s", "0 m/s", "0.1 m/s"]

[[scene.inlets]]
name = "sand"
density = "2650 kg/m3"
min = ["0 mm", "0 mm", "2 mm"]
max = ["1 cm", "1 cm", "6 mm"]
fraction = 0.02
diameters = { log_normal = { median = "1 mm", spread = 1.2, min = "0.7 mm", max = "1.5 mm" } }
velocity = { face = "y_lower" }
until = "2 s"
seed = 9
tries = 50

[[scene.outlets]]
name = "drain"
beyond = { axis = "y", at = "14 mm", side = "upper" }

[[scene.outlets]]
name = "top"
beyond = { face = "z_upper" }

[[scene.contacts]]
"#;
    GOOD.replace("\n[[scene.contacts]]\n", ports)
}

fn refused(from: &str, to: &str, words: &[&str]) {
    let text = with_ports();
    assert!(text.contains(from), "{from}");
    one_problem(&text.replacen(from, to, 1), words);
}

#[test]
fn inlets_and_outlets_are_read_in_si_with_defaults() {
    let text = with_ports();
    let scene = read(&text).unwrap_or_else(|errors| panic!("{errors}")).spec.scene;
    let [feed, sand] = &scene.inlets[..] else { panic!("{:?}", scene.inlets) };
    let given = InletVelocity::Given([0.0, 0.0, 0.1]);
    assert_eq!((feed.bodies.as_str(), feed.every, feed.velocity), ("bed", Some(1e-3), given));
    assert_eq!((feed.seed, feed.tries, feed.until), (1, Inlet::TRIES, None));
    assert_eq!(sand.velocity, InletVelocity::Face { axis: 1, side: 0 });
    assert_eq!((sand.seed, sand.tries, sand.until, sand.every), (9, 50, Some(2.0), None));
    let set = scene.bodies.iter().find(|set| set.name == sand.bodies).unwrap();
    assert_eq!((set.density, set.material.as_str(), &set.motion), (2650.0, "sand", &Motion::Free));
    assert_eq!(set.placement, Placement::Listed(vec![]));
    let outlet = |name: &str, axis, at, side| Outlet { name: name.into(), axis, at, side };
    assert_eq!(scene.outlets, [outlet("drain", 1, 14e-3, 1), outlet("top", 2, 160e-3, 1)]);
    reads_back(&text);
}

#[test]
fn problems_of_inlets_and_outlets_are_told_at_their_keys() {
    refused("bodies = \"bed\"", "bodies = \"beds\"", &["inlets[0].bodies", "expected the name"]);
    refused("bodies = \"bed\"", "", &["inlets[0].density", "missing"]);
    refused("name = \"sand\"", "name = \"sphere\"", &["inlets[1].name", "set of bodies"]);
    refused("name = \"sand\"", "name = \"feed\"", &["inlets[1].name", "another inlet"]);
    refused("name = \"top\"", "name = \"a b\"", &["outlets[1].name", "letters"]);
    refused("\"6 mm\"]\nfraction = 0.05", "\"2.5 mm\"]\nfraction = 0.05", &["too narrow"]);
    refused("fraction = 0.02", "fraction = 0", &["inlets[1].fraction", "more than zero"]);
    refused("every = \"1 ms\"", "every = \"0 s\"", &["inlets[0].every", "more than zero"]);
    refused("velocity = [\"0 m/s\", \"0 m/s\", \"0.1 m/s\"]", "", &["inlets[0].velocity"]);
    refused("\"y_lower\"", "\"w_lower\"", &["w_lower", "z_upper"]);
    refused("face = \"z_upper\"", "face = \"z_upper\", side = \"lower\"", &["both face and side"]);
    refused(", side = \"upper\" }", " }", &["beyond.side", "missing"]);
}
