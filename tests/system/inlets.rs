//! Grains that come and go.

use crate::tremie::run_text;

/// A stream that brings grains and takes them away.
const STREAM: &str = r#"
[run]
until = "6 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "0 m/s2"]

[scene.domain]
size = ["4 mm", "4 mm", "8 mm"]
x = "periodic"
y = "periodic"
z = { lower = { velocity = ["0 m/s", "0 m/s", "1 m/s"] }, upper = { pressure = "0 Pa" } }

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
velocity = ["0 m/s", "0 m/s", "1 m/s"]
expected_speed = "1.5 m/s"

[[scene.inlets]]
name = "feed"
density = "1200 kg/m3"
min = ["0 mm", "0 mm", "0 mm"]
max = ["4 mm", "4 mm", "3 mm"]
fraction = 0.08
diameter = "0.9 mm"
velocity = ["0 m/s", "0 m/s", "1 m/s"]

[[scene.outlets]]
name = "drain"
beyond = { axis = "z", at = "7 mm", side = "upper" }

[[scene.contacts]]
normal_stiffness = "500 N/m"
tangential_stiffness = "400 N/m"
friction = 0.3
restitution = 0.8

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.2 mm"
"#;

/// What came less what went is what lives, in number; processes and threads, and any number
/// of them, give the same bits.
#[test]
fn a_stream_brings_grains_and_takes_them_away() {
    let bits = |options: &[&str]| {
        let all = [&["--set", "outputs.record=false"], options].concat();
        run_text(STREAM, &all).succeeded()
    };
    let ran = bits(&[]);
    let signals = ran.signals();
    let column = |name: &str| &signals[&format!("grains.{name}")];
    let (came, went) = (column("feed.inserted"), column("drain.removed"));
    for (k, living) in column("bodies").iter().enumerate() {
        assert_eq!(came[k] - went[k], *living);
    }
    let (first, last) = (came[0], came.len() - 1);
    assert!(came[last] > first + 10.0 && went[last] > 1.0, "{came:?} {went:?}");
    assert_eq!(ran.signals_text(), bits(&["--in-process"]).signals_text());
    let threads = "components.grains={ program = \"grains-dem\", threads = 3 }";
    assert_eq!(ran.signals_text(), bits(&["--set", threads]).signals_text());
}
