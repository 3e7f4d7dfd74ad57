//! The compressible gas in whole runs: shocks, moving bodies, and what it refuses.

use crate::tremie::{Ran, run, run_text, tremie};

/// A shock of Mach 1.66 in a channel of 64 x 8 mm.
const SHOCK: &str = r#"
[run]
until = "120 us"

[scene.domain]
size = ["64 mm", "10 mm", "8 mm"]
across = "y"
x = { lower = { pressure = "0 Pa", outflow = "absorbing" }, upper = "wall" }
z = "symmetry"

[scene.fluid]
density = "1.2 kg/m3"
viscosity = "18 uPa s"

[scene.fluid.gas]
pressure = "100 kPa"
shock = { axis = "x", position = "12 mm", mach = 1.66 }

[[scene.probes]]
name = "ahead"
point = ["40 mm", "5 mm", "4 mm"]

[components]
fluid = "fluid-wavelet"

[settings.fluid-wavelet]
cell = "0.25 mm"

[outputs]
signals = "1 us"
record = false
"#;

#[test]
fn a_shock_runs_at_its_mach_number_and_comes_back_from_a_wall() {
    let signals = run_text(SHOCK, &[]).succeeded().signals();
    let (time, pressure) = (&signals["time"], &signals["fluid.ahead.pressure"]);
    let sound = (1.4 * 1e5 / 1.2_f64).sqrt();
    // Halfway up to the pressure behind, 3.048 of that ahead.
    let passes = (0..time.len()).find(|&k| pressure[k] > 1.024e5).expect("the shock passes");
    let speed = 28e-3 / time[passes];
    assert!((speed / (1.66 * sound) - 1.0).abs() < 0.03, "{speed} m/s");
    let behind = pressure[passes + 6];
    assert!((behind / 2.048e5 - 1.0).abs() < 0.02, "{behind} Pa");
    // On the wall 7.879 times the pressure ahead, by the theory of reflection.
    let wall = signals["fluid.x_upper.wall_force_x"].last().unwrap() / (0.01 * 0.008);
    assert!((wall / 6.879e5 - 1.0).abs() < 0.02, "{wall} Pa");
}

#[test]
fn discs_in_a_gas_are_the_same_however_it_is_run() {
    let path = "examples/two-discs/short.toml";
    let short = |options: &[&str]| {
        let all = [&["--until", "0.8 s", "--quiet"], options].concat();
        run(path, &all).succeeded().signals_text()
    };
    let threads =
        |n: &str| format!("components.fluid={{ program = \"fluid-wavelet\", threads = {n} }}");
    let once = short(&["--set", &threads("1")]);
    assert!(short(&["--in-process"]) == once);
    assert!(short(&["--set", &threads("2")]) == once);
    assert!(short(&["--set", "outputs.record=false"]) == once);
}

/// The discs meet and go apart as fast as they came but for the drag, with either grains.
#[test]
fn two_discs_meet_in_a_gas_with_either_grains() {
    let hard = std::fs::read_to_string("examples/two-discs/short.toml").unwrap();
    let soft = hard.replacen("grains = \"grains-hard-sphere\"", "grains = \"grains-dem\"", 1);
    assert_eq!(soft.lines().zip(hard.lines()).filter(|(a, b)| a != b).count(), 1);
    let end = |text: &str| {
        let signals = run_text(text, &["--until", "2.5 s"]).succeeded().signals();
        assert!(signals["grains.body0_vx"][0] < 0.0);
        ["grains.body0_x", "grains.body0_vx"].map(|name| *signals[name].last().unwrap())
    };
    let [soft, hard] = [soft, hard].map(|text| end(&text));
    assert!(hard[1] > 0.2 && (soft[1] / hard[1] - 1.0).abs() < 0.01, "{soft:?} {hard:?}");
    // While the spring of two discs of 785 kg is compressed, hard ones are under way again.
    let contact = std::f64::consts::PI * (785.4 / 2.0 / 1e6_f64).sqrt();
    let late = hard[0] - soft[0] - 0.2121 * contact;
    assert!(late.abs() < 0.002, "{soft:?} {hard:?}");
}

/// A light disc that is braked in a closed periodic box gives its momentum to the gas.
#[test]
fn gas_and_disc_exchange_momentum_and_none_is_lost() {
    let closed = r#"
[run]
until = "4 s"

[scene.domain]
size = ["4 m", "1 m", "4 m"]
across = "y"
x = "periodic"
z = "periodic"

[scene.fluid]
density = "1 kg/m3"
viscosity = "0.01 Pa s"

[scene.fluid.gas]
pressure = "0.7142857142857143 Pa"
temperature = "1 K"
sutherland = "0.368 K"

[[scene.bodies]]
name = "disc"
density = "8 kg/m3"
cylinders = [{ position = ["2 m", "0 m", "2 m"], diameter = "1 m", velocity = ["0.2 m/s", "0 m/s", "0 m/s"] }]

[[scene.contacts]]
normal_stiffness = "1 MN/m"
tangential_stiffness = "0.8 MN/m"
friction = 0.0
restitution = 1.0

[components]
fluid = "fluid-wavelet"
grains = "grains-dem"

[settings.fluid-wavelet]
cell = "0.0625 m"

[outputs]
signals = "0.1 s"
record = false
"#;
    let signals = run_text(closed, &[]).succeeded().signals();
    let of = |name: &str, k: usize| signals[name][k];
    let last = signals["time"].len() - 1;
    let lost = of("grains.momentum_x", 0) - of("grains.momentum_x", last);
    let won = of("fluid.momentum_x", last) - of("fluid.momentum_x", 1);
    assert!(lost > 0.02 * of("grains.momentum_x", 0), "{lost}");
    // The gas between the surface and the points inside is counted by half here and there.
    assert!((won / lost - 1.0).abs() < 0.1, "lost {lost}, won {won}");
    assert!(signals["fluid.mass_drift"].iter().all(|drift| *drift < 2e-3));
    let estimates = ["fluid.body_force_x", "fluid.body_momentum_x"]
        .map(|name| signals[name].iter().skip(5).sum::<f64>());
    assert!((estimates[0] / estimates[1] - 1.0).abs() < 0.05, "{estimates:?}");
}

#[test]
fn the_gas_conforms() {
    let output = tremie().args(["conform", "fluid-wavelet"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
}

/// What a run of the shock says after a change of its text.
#[track_caller]
fn refused(from: &str, to: &str) -> String {
    assert!(SHOCK.contains(from), "{from}");
    let ran: Ran = run_text(&SHOCK.replace(from, to), &[]);
    assert!(!ran.output.status.success(), "{to} passed");
    ran.errors()
}

#[test]
fn what_a_gas_cannot_do_is_told_at_its_key() {
    let gas = "[scene.fluid.gas]\npressure = \"100 kPa\"\nshock = { axis = \"x\", position = \"12 mm\", mach = 1.66 }\n";
    let disc = "[[scene.bodies]]\nname = \"disc\"\ndensity = \"8 kg/m3\"\ncylinders = [{ position = [\"32 mm\", \"0 mm\", \"4 mm\"], diameter = \"1 mm\" }]\n\n[[scene.contacts]]\nnormal_stiffness = \"1 kN/m\"\ntangential_stiffness = \"1 kN/m\"\nfriction = 0.0\nrestitution = 1.0\n\n[components]\ngrains = \"grains-dem\"\n";
    for (from, to, words) in [
        (gas, "", ["scene.fluid.gas", "pressure = \"101325 Pa\""]),
        ("\"100 kPa\"", "\"-1 Pa\"", ["scene.fluid.gas.pressure", "more than zero"]),
        ("\"12 mm\"", "\"80 mm\"", ["shock.position", "outside of the domain"]),
        ("mach = 1.66", "mach = 0.9", ["shock.mach", "more than 1"]),
        ("axis = \"x\", position", "axis = \"y\", position", ["shock.axis", "across the plane"]),
        ("\"100 kPa\"", "\"100 kPa\"\nheat_ratio = 1.0", ["gas.heat_ratio", "more than 1"]),
        ("cell = \"0.25 mm\"", "cell = \"0.3 mm\"", ["cell", "must be a whole number"]),
        ("cell = \"0.25 mm\"", "cell = \"0.25 mm\"\nlevels = 4", ["cell", "coarsest level"]),
        ("cell = \"0.25 mm\"", "cell = \"0.25 mm\"\nblock = 7", ["block", "an even number"]),
        ("cell = \"0.25 mm\"", "cell = \"1 nm\"", ["cell", "take a larger cell"]),
        ("[components]\n", disc, ["cell", "points across the smallest body"]),
        (
            "\"100 kPa\"",
            "\"100 kPa\"\nsurface_temperatures = { steel = \"350 K\" }",
            ["surface_temperatures.steel", "no body and no part"],
        ),
        (
            "\"100 kPa\"",
            "\"100 kPa\"\nsurface_temperatures = { steel = \"-1 K\" }",
            ["surface_temperatures.steel", "more than zero"],
        ),
        (
            "viscosity = ",
            "fill = [{ max = [\"1 mm\", \"1 mm\", \"1 mm\"] }]\nviscosity = ",
            ["fill[0]", "no free surface"],
        ),
    ] {
        let said = refused(from, to);
        for words in words {
            assert!(said.contains(words), "expected \"{words}\" in: {said}");
        }
    }
}

#[test]
fn a_gas_that_is_torn_apart_says_where() {
    let torn = SHOCK
        .replace("mach = 1.66", "mach = 1.01")
        .replace("[[scene.probes]]", "[[scene.fluid.gas.regions]]\nmax = [\"10 mm\", \"10 mm\", \"8 mm\"]\nvelocity = [\"-9000 m/s\", \"0 m/s\", \"0 m/s\"]\n\n[[scene.fluid.gas.regions]]\nmin = [\"13 mm\", \"0 mm\", \"0 mm\"]\nvelocity = [\"9000 m/s\", \"0 m/s\", \"0 m/s\"]\n\n[[scene.probes]]");
    let fails = |options: &[&str], words: &[&str]| {
        let ran = run_text(&torn, options);
        assert!(!ran.output.status.success());
        let said = ran.errors();
        words.iter().for_each(|word| assert!(said.contains(word), "no \"{word}\" in: {said}"));
    };
    fails(&[], &["at window 0", "watch.mach", "no checkpoint is from before"]);
    let unwatched = ["--set", "watch.mach=off", "--set", "watch.density=off"];
    fails(&unwatched, &["density", "pressure", "both must be positive", "a smaller tolerance"]);
}
