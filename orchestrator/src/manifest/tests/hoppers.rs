//! Hoppers become parts and bodies.

use super::*;
use tremie_geometry::{Frame, Surface};
use tremie_messages::scene::{Part, Scene, Sphere};

const HOPPER: &str = r#"
[[scene.hoppers]]
name = "outlet"
flow = "-z"
across = "y"
angle = "60 deg"
slit = "20 mm"
exit = "20 mm"
"#;

/// The good manifest with a hopper; along x, its depth, the domain wraps around.
fn with(more: &str) -> String {
    let text = format!("{HOPPER}{more}\n\n[[scene.contacts]]\n");
    GOOD.replace("\n[[scene.contacts]]\n", &text)
}

fn scene(text: &str) -> Scene {
    read(text).unwrap_or_else(|errors| panic!("{errors}")).spec.scene
}

fn refused(from: &str, to: &str, words: &[&str]) {
    let text = with("");
    assert!(text.contains(from), "{from}");
    one_problem(&text.replacen(from, to, 1), words);
}

fn surface(part: &Part) -> Surface {
    Surface::of(&part.geometry).unwrap()
}

/// True if a place of the world is solid.
fn is_solid(part: &Part, x: [f64; 3]) -> bool {
    surface(part).contains(Frame::of(&part.pose).to_part(x))
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
}

fn distance(a: &Sphere, b: &Sphere, period: f64) -> f64 {
    let mut square = 0.0;
    for k in 0..3 {
        let mut d = a.position[k] - b.position[k];
        if k == 0 {
            d -= period * (d / period).round();
        }
        square += d * d;
    }
    square.sqrt()
}

#[test]
fn a_hopper_is_two_wedges() {
    let text = with("");
    let scene = scene(&text);
    let [lower, upper] = &scene.parts[..] else { panic!("{:?}", scene.parts) };
    assert_eq!((lower.name.as_str(), upper.name.as_str()), ("outlet-lower", "outlet-upper"));
    let tangent = 3.0_f64.sqrt();
    let height = 0.04 * tangent;
    for (part, side) in [(lower, -1.0), (upper, 1.0)] {
        let moments = surface(part).mesh().moments();
        near(moments.volume, 0.5 * 0.04 * height * 0.1);
        let mesh = surface(part).mesh().placed(&part.pose);
        near(mesh.bounds().min[2], 0.02);
        near(mesh.bounds().max[2], 0.02 + height);
        near(mesh.bounds().min[0], 0.0);
        near(mesh.bounds().max[0], 0.1);
        // A hair to both sides of the leaning wall, half way up, and of the slit.
        let (across, up) = (0.05 + side * 0.03, 0.02 + 0.5 * height);
        assert!(is_solid(part, [0.01, across + side * 1e-6, up]));
        assert!(!is_solid(part, [0.01, across - side * 1e-6, up]));
        assert!(is_solid(part, [0.01, 0.05 + side * (0.01 + 1e-5), 0.02 + 1e-6]));
        assert!(!is_solid(part, [0.01, 0.05 + side * (0.01 - 1e-9), 0.02 + 1e-6]));
        assert!(!is_solid(part, [0.01, 0.05 + side * 0.03, 0.02 - 1e-6]));
    }
    reads_back(&text);
}

#[test]
fn a_hopper_flows_either_way_of_any_axis() {
    let text =
        with("").replace("\"-z\"", "\"+z\"").replace("exit = \"20 mm\"", "exit = \"140 mm\"");
    for part in scene(&text).parts {
        let mesh = surface(&part).mesh().placed(&part.pose);
        near(mesh.bounds().max[2], 0.14);
        near(mesh.bounds().min[2], 0.14 - 0.04 * 3.0_f64.sqrt());
    }
}

/// A channel that is narrower than the domain has walls up to its height.
#[test]
fn a_narrow_channel_has_walls() {
    let text = with("width = \"60 mm\"\ncentre = \"40 mm\"\nheight = \"100 mm\"");
    let scene = scene(&text);
    let tangent = 3.0_f64.sqrt();
    let wedge = 0.5 * 0.02 * 0.02 * tangent;
    for (part, beyond, wall) in [(&scene.parts[0], 0.01, 0.01), (&scene.parts[1], 0.03, 0.07)] {
        near(surface(part).mesh().moments().volume, (wedge + beyond * 0.1) * 0.1);
        let inward = if wall < 0.04 { 1.0 } else { -1.0 };
        assert!(is_solid(part, [0.01, wall - inward * 1e-6, 0.119]));
        assert!(!is_solid(part, [0.01, wall + inward * 1e-6, 0.119]));
        assert!(!is_solid(part, [0.01, wall - inward * 1e-6, 0.121]));
    }
    reads_back(&text);
}

/// Spheres of a rough wall touch its plane from behind and each other, and overlap nowhere; slit and
/// channel are as wide as they are said to be.
#[test]
fn rough_walls_leave_slit_width_and_angle() {
    let text = with("rough = { diameter = \"4 mm\" }\nheight = \"120 mm\"");
    let scene = scene(&text);
    let set = scene.bodies.iter().find(|set| set.name == "outlet-rough").unwrap();
    assert_eq!((&set.motion, set.material.as_str()), (&Motion::Fixed, "wall"));
    let Placement::Listed(spheres) = &set.placement else { panic!() };
    let (sine, cosine, d) = (0.75_f64.sqrt(), 0.5, 4e-3);
    // The channel's width is what the layers leave: 92 mm.
    let mut widest = f64::INFINITY;
    let mut narrowest = f64::INFINITY;
    for sphere in spheres {
        let [_, y, z] = sphere.position;
        let (a, h) = ((y - 0.05).abs(), z - 0.02);
        // Distance from the planes of the leaning wall and of the channel's.
        let leaning = (a - 0.01) * sine - h * cosine;
        let upright = a - 0.046;
        let front = leaning.max(upright);
        near(front, 0.5 * d);
        narrowest = narrowest.min(a - 0.5 * d);
        if h > 0.036 * 3.0_f64.sqrt() + d {
            widest = widest.min(a - 0.5 * d);
        }
    }
    near(narrowest, 0.01);
    near(widest, 0.046);
    // 25 in each row; rows are 3.46 mm apart along 72 mm and 57 mm of wall.
    assert_eq!(spheres.len() % 50, 0);
    assert!((spheres.len() as f64 / 50.0 - (0.072 + 0.120 - 0.0624) / 3.464e-3).abs() < 2.0);
    let mut touching = 0;
    for (i, one) in spheres.iter().enumerate() {
        for other in &spheres[..i] {
            let distance = distance(one, other, 0.1);
            assert!(distance > d * (1.0 - 1e-9), "{one:?} {other:?}");
            touching += usize::from((distance / d - 1.0).abs() < 1e-9);
        }
    }
    assert!(touching > 5 * spheres.len() / 2, "most have six neighbours: {touching}");
    reads_back(&text);
}

#[test]
fn problems_of_hoppers_are_told_at_their_keys() {
    refused("slit = \"20 mm\"", "", &["hoppers[0].slit", "missing"]);
    refused("slit = \"20 mm\"", "slit = \"100 mm\"", &["hoppers[0].slit", "width of the channel"]);
    refused("\"60 deg\"", "\"90 deg\"", &["hoppers[0].angle", "90 deg"]);
    refused("\"60 deg\"", "\"0 deg\"", &["hoppers[0].angle", "more than 0"]);
    refused("\"60 deg\"", "\"80 deg\"", &["hoppers[0]", "the domain has 0.14 m"]);
    refused("across = \"y\"", "across = \"z\"", &["hoppers[0].across", "axis of the flow"]);
    refused("across = \"y\"", "across = \"x\"", &["hoppers[0].across", "wraps around"]);
    refused("exit = \"20 mm\"", "exit = \"20 cm\"", &["hoppers[0].exit", "outside the domain"]);
    refused("\"-z\"", "\"z\"", &["hoppers[0].flow", "expected"]);
    let more = |line: &str| format!("exit = \"20 mm\"\n{line}");
    let refused_with = |line: &str, words: &[&str]| refused("exit = \"20 mm\"", &more(line), words);
    refused_with("width = \"11 cm\"", &["hoppers[0].width", "room for 0.1 m"]);
    refused_with(
        "width = \"95 mm\"\nrough = { diameter = \"4 mm\" }",
        &["width", "beside the spheres"],
    );
    refused_with("width = \"0 mm\"", &["hoppers[0].width", "more than zero"]);
    refused_with("centre = \"12 cm\"", &["hoppers[0].centre", "outside the domain"]);
    refused_with("height = \"50 mm\"", &["hoppers[0].height", "leaning walls"]);
    refused_with("height = \"150 mm\"", &["hoppers[0].height", "the domain has 0.14 m"]);
    refused_with("rough = {}", &["hoppers[0].rough.diameter", "missing"]);
    refused_with("rough = { diameter = \"10 um\" }", &["hoppers[0].rough", "spheres"]);
    refused_with("material = \"steel\"", &["hoppers[0].material", "no material"]);
    let part = "\n[[scene.parts]]\nname = \"outlet-upper\"\nsphere = { radius = \"1 mm\" }\nposition = [\"5 cm\", \"5 cm\", \"5 cm\"]";
    refused_with(part, &["hoppers[0].name", "makes a part"]);
}

/// In a plane scene walls are prisms through the plane, and rough ones are covered by cylinders.
#[test]
fn hoppers_narrow_plane_scenes_too() {
    let text = r#"
[run]
until = "1 s"
[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]
[scene.domain]
size = ["20 cm", "1 cm", "40 cm"]
across = "y"
z = "periodic"
[[scene.hoppers]]
name = "slot"
flow = "-z"
across = "x"
angle = "50 deg"
slit = "3 cm"
exit = "6 cm"
rough = { diameter = "1 cm" }
[[scene.bodies]]
name = "logs"
density = "2500 kg/m3"
cylinders = [{ position = ["10 cm", "0 cm", "30 cm"], diameter = "1 cm" }]
[[scene.contacts]]
normal_stiffness = "1e5 N/m"
tangential_stiffness = "0 N/m"
restitution = 0.9
[components]
grains = "grains-dem"
"#;
    let scene = scene(text);
    assert_eq!(scene.parts.len(), 2);
    let Placement::Listed(cylinders) = &scene.bodies[1].placement else { panic!() };
    assert!(cylinders.len() > 40, "{}", cylinders.len());
    assert!(cylinders.iter().all(|cylinder| cylinder.position[1] == 5e-3));
    for pair in cylinders.chunks(2).collect::<Vec<_>>().windows(2) {
        let apart = distance(&pair[0][0], &pair[1][0], 1.0);
        assert!((apart / 0.01 - 1.0).abs() < 1e-9, "{apart}");
    }
    one_problem(
        &text.replace("flow = \"-z\"\nacross = \"x\"", "flow = \"-z\"\nacross = \"y\""),
        &["hoppers[0].across", "the scene is plane across y"],
    );
    reads_back(text);
}
