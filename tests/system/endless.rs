//! Parts that go through periodic faces, as a manifest has them: fluid and grains see the same
//! walls, and what cannot go on is refused once, with what to do.

use crate::tremie::{Ran, run_text};
use std::f64::consts::PI;

/// A plate that moves along itself, far longer than the domain along two periodic axes: Stokes'
/// first problem.
const PLATE: &str = r#"
[run]
until = "1 s"
[scene.domain]
size = ["0.0625 m", "10 m", "0.0625 m"]
x = "periodic"
z = "periodic"
[scene.fluid]
density = "1 kg/m3"
viscosity = "1 Pa s"
expected_speed = "1 m/s"
[[scene.parts]]
name = "plate"
box = { size = ["4 m", "1 m", "4 m"] }
position = ["0.03 m", "-0.4 m", "0.03 m"]
motion = "prescribed"
velocity = ["1 m/s", "0 m/s", "0 m/s"]
[components]
fluid = "fluid-lbm"
grains = "grains-dem"
[settings.fluid-lbm]
cell = "0.0625 m"
"#;

/// A tube longer than the domain, and a grain that flies along its axis.
const TUBE: &str = r#"
[run]
until = "4 s"
[scene.domain]
size = ["1.05 m", "1.05 m", "1.5 m"]
z = "periodic"
[[scene.parts]]
name = "tube"
cylinder = { radius = "0.5 m", length = "4 m" }
position = ["0.525 m", "0.525 m", "0.75 m"]
cavity = true
[[scene.bodies]]
name = "s"
density = "1 kg/m3"
spheres = [{ position = ["0.525 m", "0.525 m", "0.75 m"], diameter = "0.2 m", velocity = ["0 m/s", "0 m/s", "1 m/s"] }]
[[scene.contacts]]
normal_stiffness = "50 N/m"
tangential_stiffness = "40 N/m"
restitution = 0.9
[components]
grains = "grains-dem"
[outputs]
signals = "0.1 s"
"#;

/// Fluid in a box that is periodic along x, 20 mm long and 21 mm wide, with parts to be added.
const BOX: &str = r#"
[run]
until = "UNTIL"
[scene.domain]
size = ["20 mm", "20 mm", "20 mm"]
x = "periodic"
[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.2 Pa s"
expected_speed = "0.05 m/s"
PARTS
[[scene.bodies]]
name = "s"
density = "1000 kg/m3"
spheres = [{ position = ["4 mm", "10 mm", "15.5 mm"], diameter = "4 mm" }]
[[scene.contacts]]
normal_stiffness = "50 N/m"
tangential_stiffness = "40 N/m"
friction = 0.3
restitution = 0.5
[components]
fluid = "fluid-lbm"
grains = "grains-dem"
[settings.fluid-lbm]
cell = "0.5 mm"
"#;

fn ran(text: &str) -> Ran {
    run_text(text, &["--set", "outputs.record=false"]).succeeded()
}

fn last(ran: &Ran, name: &str) -> f64 {
    *ran.signals()[name].last().unwrap()
}

fn boxed(until: &str, parts: &str) -> Ran {
    ran(&BOX.replace("UNTIL", until).replace("PARTS", parts))
}

/// Drag of `mu U / sqrt(pi nu t)` on each area, within 1 %.
#[test]
fn a_plate_slides_along_itself_through_a_periodic_domain() {
    let found = last(&ran(PLATE), "fluid.plate.force_x");
    let wanted = -0.0625 * 0.0625 / PI.sqrt();
    assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
}

#[test]
fn a_grain_does_not_meet_the_cap_of_a_tube_beyond_the_domain() {
    let ran = ran(TUBE);
    assert!(ran.signals()["grains.body0_vz"].iter().all(|&v| v == 1.0));
    assert_eq!(last(&ran, "grains.contacts"), 0.0);
}

/// A rod along the axis, longer than the domain, turns and slides. It drags fluid and grain along,
/// as a rod does that is just as long as the domain.
#[test]
fn a_rod_drags_fluid_and_grains_along_however_long_it_is() {
    let rod = |length: &str, x: &str| {
        let parts = format!(
            r#"[[scene.parts]]
name = "rod"
cylinder = {{ radius = "3 mm", length = "{length}" }}
rotation = {{ axis = [0, 1, 0], angle = "90 deg" }}
position = ["{x}", "10 mm", "10 mm"]
motion = "prescribed"
velocity = ["0.05 m/s", "0 m/s", "0 m/s"]
angular_velocity = ["4 rad/s", "0 rad/s", "0 rad/s"]"#
        );
        let ran = boxed("0.2 s", &parts);
        ["fluid.rod.force_x", "fluid.rod.torque_x", "grains.s.vx", "grains.s.y", "grains.s.x"]
            .map(|name| last(&ran, name))
    };
    let long = rod("90 mm", "1 mm");
    let [force, torque, vx, y, _] = long;
    assert!(force < -1e-4 && torque < 0.0 && vx > 0.005 && y < 9.99e-3, "{long:?}");
    for other in [rod("20 mm", "10 mm"), rod("300 mm", "-70 mm")] {
        for (a, b) in long.iter().zip(other) {
            assert!((a - b).abs() < 1e-6 * a.abs(), "{long:?} {other:?}");
        }
    }
}

/// A plug in a tube, both through the faces: it takes the fluid with it, and the grain before it.
#[test]
fn a_plug_moves_round_and_round_in_a_tube() {
    let parts = r#"[[scene.parts]]
name = "tube"
box = { size = ["20 mm", "12 mm", "40 mm"] }
rotation = { axis = [0, 1, 0], angle = "90 deg" }
position = ["10 mm", "10 mm", "14.3 mm"]
cavity = true
[[scene.parts]]
name = "plug"
box = { size = ["4 mm", "9 mm", "9 mm"] }
position = ["10 mm", "10 mm", "14.3 mm"]
motion = "prescribed"
velocity = ["0.1 m/s", "0 m/s", "0 m/s"]"#;
    let ran = boxed("0.3 s", parts);
    let [grain, plug] = ["grains.s.x", "grains.plug.x"].map(|name| last(&ran, name));
    let speed = ran.signals()["grains.s.vx"].iter().sum::<f64>()
        / ran.signals()["grains.s.vx"].len() as f64;
    // 30 mm on: one and a half times through the domain.
    assert!(plug.min(20e-3 - plug) < 1e-4, "{plug}");
    assert!(speed > 0.03, "{speed}");
    let ahead = (grain - plug).rem_euclid(20e-3);
    assert!(ahead > 3.9e-3 && ahead < 16.1e-3, "{ahead}");
}

/// A bar of a file, cut askew at its ends, one flat face up: the grain rests on it as on a floor of
/// its own.
#[test]
fn a_bar_of_a_file_goes_on_whatever_its_ends_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.stl");
    // A prism along x whose ends are slanted: corners (y, z) of its section, the ends at x = -7 - z
    // and 31 + y.
    let section = [[-4.0, -2.0], [4.0, -2.0], [4.0, 2.0], [-4.0, 2.0]];
    let low = section.map(|[y, z]: [f64; 2]| [-7.0 - z, y, z]);
    let high = section.map(|[y, z]| [31.0 + y, y, z]);
    let mut triangles = vec![[low[0], low[2], low[1]], [low[0], low[3], low[2]]];
    triangles.extend([[high[0], high[1], high[2]], [high[0], high[2], high[3]]]);
    for k in 0..4 {
        let n = (k + 1) % 4;
        triangles.extend([[low[k], low[n], high[n]], [low[k], high[n], high[k]]]);
    }
    let mut text = String::from("solid bar\n");
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    std::fs::write(&path, text + "endsolid bar\n").unwrap();
    let parts = format!(
        r#"[[scene.parts]]
name = "bar"
file = {path:?}
unit = "mm"
position = ["0 mm", "10 mm", "10 mm"]
motion = "prescribed"
velocity = ["0.06 m/s", "0 m/s", "0 m/s"]"#
    );
    let text = BOX
        .replace(
            "[scene.domain]",
            "[scene]\ngravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]\n[scene.domain]",
        )
        .replace("density = \"1000 kg/m3\"\nspheres", "density = \"2000 kg/m3\"\nspheres")
        .replace("UNTIL", "0.5 s")
        .replace("PARTS", &parts);
    let ran = ran(&text);
    let height = last(&ran, "grains.s.z");
    assert!((height - 14e-3).abs() < 0.1e-3, "it rests on the bar: {height}");
    // It went with the bar, further than the domain is long; nothing stopped it at an end.
    let vx = &ran.signals()["grains.s.vx"];
    assert!(vx[vx.len() / 2..].iter().all(|&v| v > 0.04 && v < 0.065), "{vx:?}");
}

#[test]
fn what_does_not_go_on_is_refused_once_with_a_remedy() {
    let parts = r#"[[scene.parts]]
name = "cone"
revolved = { profile = [["0 mm", "-20 mm"], ["4 mm", "-20 mm"], ["1 mm", "40 mm"], ["0 mm", "40 mm"]] }
rotation = { axis = [0, 1, 0], angle = "90 deg" }
position = ["5 mm", "5 mm", "5 mm"]
[[scene.parts]]
name = "plate"
box = { size = ["90 mm", "2 mm", "2 mm"] }
position = ["10 mm", "15 mm", "5 mm"]
rotation = { axis = [0, 0, 1], angle = "1 deg" }
[[scene.parts]]
name = "bar"
box = { size = ["90 mm", "2 mm", "2 mm"] }
position = ["10 mm", "15 mm", "12 mm"]
motion = "prescribed"
angular_velocity = ["0 rad/s", "0 rad/s", "1 rad/s"]
[[scene.parts]]
name = "long"
box = { size = ["25 mm", "2 mm", "2 mm"] }
position = ["14 mm", "15 mm", "18 mm"]"#;
    let ran = run_text(&BOX.replace("UNTIL", "1 s").replace("PARTS", parts), &[]);
    let errors = ran.errors();
    assert_eq!(ran.code(), Some(2), "{errors}");
    assert_eq!(errors.matches("error: ").count(), 4, "fluid and grains say it once:\n{errors}");
    for said in [
        "scene.parts[0].geometry: the part reaches from one periodic x face to the other, but its cross-sections there differ",
        "scene.parts[1].geometry",
        "same cross-section at both x faces",
        "scene.parts[2].motion: the part goes through both periodic x faces, but turns about another axis",
        "let it turn about x alone",
        "scene.parts[3].geometry: the part is 0.025 m long along the periodic x axis, more than the domain's 0.02 m, but does not reach the lower face",
        "move it so that it reaches beyond both x faces",
    ] {
        assert!(errors.contains(said), "expected \"{said}\" in:\n{errors}");
    }
    assert!(!ran.out.exists());
}
