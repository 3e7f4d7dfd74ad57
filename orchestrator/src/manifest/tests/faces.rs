//! Faces of the domain, the fluid, gaps and probes.

use super::*;
use tremie_messages::scene::{
    Course, Face, GapRegion, GapRule, GapSide, GapWeight, OpenVelocity, Outflow, ProbeShape,
    Profile, Reservoir, Ring, Sine,
};

/// The good manifest with other lines for the domain's faces.
fn with_faces(lines: &str) -> String {
    GOOD.replace("x = \"periodic\"\n", &format!("{lines}\n"))
}

fn refused(lines: &str, words: &[&str]) {
    let text = with_faces(lines);
    one_problem(&text, words);
}

#[test]
fn each_face_can_be_what_a_fluid_meets() {
    let text = with_faces(
        r#"
x = { lower = "symmetry", upper = { wall = { velocity = ["0 m/s", "1 m/s", "0 m/s"] } } }
y = "symmetry"
z = { lower = { velocity = ["0 m/s", "0 m/s", "1 m/s"], profile = "parabolic", ramp = "0.1 s" }, upper = { pressure = "2 kPa", absorbing = true, course = [["0 s", 0.0], ["1 s", 1.0]] } }
"#,
    );
    let domain = read(&text).unwrap().spec.scene.domain;
    let [x, y, z] = &domain.faces;
    assert_eq!(*x, [Face::Symmetry, Face::moving([0.0, 1.0, 0.0])]);
    assert_eq!(*y, [Face::Symmetry, Face::Symmetry]);
    let inflow = OpenVelocity {
        velocity: [0.0, 0.0, 1.0],
        profile: Profile::Parabolic,
        course: Course::Points(vec![[0.0, 0.0], [0.1, 1.0]]),
    };
    let course = Course::Points(vec![[0.0, 0.0], [1.0, 1.0]]);
    let outflow = Face::Pressure { pressure: 2000.0, course, outflow: Outflow::Absorbing };
    assert_eq!(*z, [Face::Velocity(inflow), outflow]);
    reads_back(&text);
}

/// A manifest with a reservoir of the given keys.
fn with_reservoir(keys: &str) -> String {
    with_faces(&format!(
        "x = {{ lower = {{ reservoir = {{ {keys} }} }}, upper = {{ pressure = \"0 Pa\" }} }}"
    ))
}

#[test]
fn a_face_can_have_a_reservoir() {
    let cylinder = "area = \"70.9 mm2\", volume = \"4e-3 m3\"";
    let text = with_reservoir(&format!(
        "{cylinder}, piston = \"6 m/s\", ramp = \"0.2 ms\", stop = \"25 ms\", relaxation = 0.1"
    ));
    let face = |text: &str| read(text).unwrap().spec.scene.domain.faces[0][0].clone();
    let area = "70.9 mm2".parse::<tremie_messages::units::Area>().unwrap().0;
    let piston = Reservoir {
        course: Course::Points(vec![[0.0, 0.0], [0.2e-3, 1.0]]),
        stop: Some(25e-3),
        relaxation: 0.1,
        ..Reservoir::new(area, 4e-3, 6.0)
    };
    assert_eq!(face(&text), Face::Reservoir(piston));
    reads_back(&text);
    let still = with_reservoir(cylinder);
    assert_eq!(face(&still), Face::Reservoir(Reservoir::new(area, 4e-3, 0.0)));
    reads_back(&still);
    let wrong = |more: &str, words: &[&str]| {
        one_problem(&with_reservoir(&format!("{cylinder}, {more}")), words)
    };
    wrong("stop = \"0 s\"", &["reservoir.stop", "more than zero"]);
    wrong("relaxation = 1.5", &["reservoir.relaxation", "from 0 to 1"]);
    wrong("ramp = \"1 s\", course = [[\"0 s\", 1.0]]", &["both ramp and course"]);
    wrong("pistn = \"1 m/s\"", &["did you mean \"piston\"?"]);
    one_problem(&with_reservoir("area = \"70.9 mm2\""), &["volume"]);
    one_problem(&still.replace("70.9 mm2", "70.9 mm"), &["an area with a unit", "70.9 mm2"]);
    one_problem(&still.replace("70.9 mm2", "0 mm2"), &["reservoir.area", "more than zero"]);
    one_problem(
        &still.replace("m3\" }", "m3\" }, ramp = \"1 s\""),
        &["x.lower.ramp", "its piston may"],
    );
}

#[test]
fn a_face_that_is_left_out_is_a_wall() {
    let text = with_faces("x = { upper = { pressure = \"0 Pa\" } }");
    let faces = read(&text).unwrap().spec.scene.domain.faces;
    assert_eq!(faces[0][0], Face::WALL);
    let open = Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
    assert_eq!(faces[0][1], open);
    let text = with_faces("x = { upper = { pressure = \"0 Pa\", outflow = \"absorbing\" } }");
    let face = read(&text).unwrap().spec.scene.domain.faces[0][1].clone();
    assert!(matches!(face, Face::Pressure { outflow: Outflow::Absorbing, .. }));
}

#[test]
fn a_wrong_face_is_one_problem() {
    refused("x = 3", &["scene.domain.x", "found integer 3", "lower and upper"]);
    refused("x = { lower = \"periodic\" }", &["x.lower", "joins both", "x = \"periodic\""]);
    refused("x = { lowr = \"wall\" }", &["did you mean \"lower\"?"]);
    refused("x = { lower = \"open\" }", &["found \"open\"", "\"symmetry\""]);
    refused("x = { lower = {} }", &["what the face is", "wall, velocity, pressure, reservoir"]);
    let sliding = "x = { lower = { velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"] } }";
    refused(sliding, &["nothing passes", "wall = { velocity"]);
    let pushing = "x = { lower = { wall = { velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] } } }";
    refused(pushing, &["moves only along itself"]);
    let deaf = "x = { lower = { wall = { velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"] }, absorbing = true } }";
    refused(deaf, &["x.lower.absorbing", "only a pressure"]);
    let still = "x = { lower = { wall = { velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"] }, outflow = \"absorbing\" } }";
    refused(still, &["x.lower.outflow", "only a pressure"]);
    let both =
        "x = { lower = { pressure = \"1 Pa\", velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] } }";
    refused(both, &["found both velocity and pressure"]);
    let pressure = |more: &str| format!("x = {{ lower = {{ pressure = \"1 Pa\", {more} }} }}");
    refused(&pressure("profile = \"parabolic\""), &["has no profile"]);
    let twice = pressure("absorbing = true, outflow = \"fixed\"");
    refused(&twice, &["x.lower.outflow", "expected one of them"]);
    refused(&pressure("outflow = \"open\""), &["outflow", "fixed", "absorbing"]);
    refused(&pressure("ramp = \"0 s\""), &["x.lower.ramp", "more than zero"]);
    refused(&pressure("ramp = \"1 s\", course = [[\"0 s\", 1.0]]"), &["both ramp and course"]);
    refused(&pressure("course = []"), &["an empty list"]);
    refused(&pressure("course = [[\"0 s\", 1]]").replace("1 Pa", "1 m"), &["a pressure"]);
    refused(&pressure("course = [[\"1 s\", 0.0], [\"0 s\", 1.0]]"), &["course[1]", "ascend"]);
    refused(&pressure("course = [[\"1 s\"]]"), &["a list of length 2"]);
}

#[test]
fn a_fluid_has_a_pressure_and_places() {
    let text = GOOD.replace(
        "viscosity = \"0.373 Pa s\"",
        "viscosity = \"0.373 Pa s\"\npressure = \"1 bar\"\ninside = [[\"1 mm\", \"1 mm\", \"1 mm\"]]\noutside = [[\"9 cm\", \"9 cm\", \"9 cm\"]]",
    );
    let fluid = read(&text).unwrap().spec.scene.fluid.unwrap();
    assert_eq!(fluid.pressure, 1e5);
    assert_eq!((fluid.inside, fluid.outside), (vec![[1e-3; 3]], vec![[0.09; 3]]));
    reads_back(&text);
    one_problem(&text.replace("[\"9 cm\"", "[\"19 cm\""), &["outside[0]", "not inside the domain"]);
    let nowhere = text.replace("inside = [[\"1 mm\", \"1 mm\", \"1 mm\"]]\n", "");
    one_problem(&nowhere, &["scene.fluid.outside", "there is no `inside`", "add inside"]);
}

#[test]
fn gaps_are_read_and_checked() {
    let text = format!(
        "{GOOD}{}",
        r#"
[[scene.parts]]
name = "plug"
cylinder = { radius = "5 mm", length = "8 mm" }
position = ["50 mm", "50 mm", "50 mm"]

[[scene.probes]]
name = "tap"
point = ["1 mm", "2 mm", "3 mm"]

[[scene.gaps]]
name = "foot"
between = ["plug", "lower z"]

[[scene.gaps]]
name = "rim"
between = ["plug", "upper z"]
open_at = 2
close_at = 0.25
pressure_at = ["tap"]
slip_below = 3
ring = { axis = "z", through = ["50 mm", "50 mm", "0 mm"], radii = ["2 mm", "5 mm"] }
"#
    );
    let gaps = read(&text).unwrap().spec.scene.gaps;
    let face = |side| GapSide::Face { axis: 2, side };
    assert_eq!(gaps[0].between, [GapSide::Part("plug".into()), face(0)]);
    assert_eq!((gaps[0].open_at, gaps[0].close_at, gaps[0].slip_below), (1.5, 0.5, 0.0));
    assert_eq!((&gaps[0].pressure, gaps[0].region), (&GapRule::Nearest, None));
    assert_eq!((gaps[1].open_at, gaps[1].close_at, gaps[1].slip_below), (2.0, 0.25, 3.0));
    let weight = GapWeight { probe: "tap".into(), weight: 1.0 };
    assert_eq!(gaps[1].pressure, GapRule::Probes(vec![weight]));
    let (through, radii) = ([0.05, 0.05, 0.0], [2e-3, 5e-3]);
    assert_eq!(gaps[1].region, Some(GapRegion::Ring { axis: 2, through, radii }));
    reads_back(&text);
    for (from, to, words) in [
        ("[\"plug\", \"upper z\"]", "[\"plug\", \"top\"]", "name of a part or surface, or a face"),
        ("[\"plug\", \"upper z\"]", "[\"plug\", \"plug\"]", "twice"),
        ("close_at = 0.25", "close_at = 3", "from 0 to `open_at`"),
        ("pressure_at = [\"tap\"]", "pressure_at = [\"tip\"]", "name of a probe"),
        ("pressure_at = [\"tap\"]", "pressure_at = [\"tap\"]\nweights = [0]", "not all 0"),
        (
            "pressure_at = [\"tap\"]",
            "pressure_at = [\"tap\"]\npressure = \"zero\"",
            "leave one out",
        ),
        ("[\"2 mm\", \"5 mm\"]", "[\"5 mm\", \"2 mm\"]", "then a larger one"),
        ("\"rim\"", "\"foot\"", "a second probe or gap"),
    ] {
        assert!(text.contains(from), "{from}");
        one_problem(&text.replace(from, to), &[words]);
    }
}

#[test]
fn probes_are_read_in_each_shape() {
    let text = format!(
        "{GOOD}{}",
        r#"
[[scene.probes]]
name = "tap"
point = ["1 mm", "2 mm", "3 mm"]

[[scene.probes]]
name = "axis"
line = { from = ["0 mm", "0 mm", "0 mm"], to = ["0 mm", "0 mm", "100 mm"] }

[[scene.probes]]
name = "outlet"
section = { axis = "z", at = "150 mm" }

[[scene.probes]]
name = "bed"
region = { min = ["0 mm", "0 mm", "0 mm"], max = ["1 mm", "1 mm", "1 mm"] }
"#
    );
    let scene = read(&text).unwrap().spec.scene;
    let shapes: Vec<_> = scene.probes.iter().map(|probe| probe.shape.clone()).collect();
    assert_eq!(shapes[0], ProbeShape::Point([1e-3, 2e-3, 3e-3]));
    assert_eq!(shapes[1], ProbeShape::Line { from: [0.0; 3], to: [0.0, 0.0, 0.1] });
    let (min, max) = (scene.domain.min, scene.domain.max);
    assert_eq!(shapes[2], ProbeShape::Section { axis: 2, position: 0.15, min, max });
    assert_eq!(shapes[3], ProbeShape::Region { min: [0.0; 3], max: [1e-3; 3] });
    reads_back(&text);
    for (from, to, words) in [
        ("\"tap\"", "\"the tap\"", "letters, digits"),
        ("\"tap\"", "\"bed\"", "a second probe or gap"),
        ("[\"1 mm\", \"2 mm\"", "[\"1 mm\", \"2 m\"", "not inside the domain"),
        ("at = \"150 mm\"", "at = \"15 m\"", "outside the domain"),
        ("axis = \"z\"", "axis = \"w\"", "\"x\", \"y\" or \"z\""),
        (
            "max = [\"1 mm\", \"1 mm\", \"1 mm\"] }\n",
            "max = [\"0 mm\", \"1 mm\", \"1 mm\"] }\n",
            "more than the lower corner",
        ),
        (
            "name = \"tap\"\npoint = [\"1 mm\", \"2 mm\", \"3 mm\"]",
            "name = \"tap\"",
            "where the probe is",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        one_problem(&text.replace(from, to), &[words]);
    }
}

#[test]
fn a_probe_in_a_ring_is_read_and_checked() {
    let ring = r#"
[[scene.probes]]
name = "seat"
ring = { axis = "y", through = ["0 mm", "5 mm", "5 mm"], radii = ["1 mm", "4 mm"], heights = ["-1 mm", "2 mm"] }
"#;
    let text = format!("{GOOD}{ring}");
    let scene = read(&text).unwrap().spec.scene;
    let (radii, heights) = ([1e-3, 4e-3], [-1e-3, 2e-3]);
    let expected = Ring { axis: 1, through: [0.0, 5e-3, 5e-3], radii, heights };
    assert_eq!(scene.probes[0].shape, ProbeShape::Ring(expected));
    reads_back(&text);
    for (from, to, words) in [
        ("radii = [\"1 mm\"", "radii = [\"4 mm\"", "ring.radii: found 0.004 and 0.004 m"),
        ("heights = [\"-1 mm\"", "heights = [\"3 mm\"", "the lower end, then a higher one"),
        ("through = [\"0 mm\"", "through = [\"-1 m\"", "lies outside the domain"),
        ("axis = \"y\", through", "through", "ring.axis"),
    ] {
        assert!(text.contains(from), "{from}");
        one_problem(&text.replace(from, to), &[words]);
    }
}

/// A wall that moves, with a course.
fn wall_with(course: &str) -> String {
    with_faces(&format!(
        "x = {{ lower = {{ wall = {{ velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"], {course} }} }} }}"
    ))
}

/// Courses by formula say what is wrong with units and places.
#[test]
fn a_wrong_formula_of_a_course_is_told() {
    for (written, words) in [
        (
            "course = { sine = { frequency = \"2 s\" } }",
            ["wall.course.sine.frequency", "a frequency with a unit"],
        ),
        ("course = { sine = { frequency = 2 } }", ["sine.frequency", "bare number"]),
        ("course = { sine = { frequency = \"0 Hz\" } }", ["sine.frequency", "more than zero"]),
        ("course = { sine = {} }", ["course.sine", "frequency, period"]),
        (
            "course = { sine = { frequency = \"1 Hz\", period = \"1 s\" } }",
            ["course.sine.period", "both"],
        ),
        ("course = { ramp = { begin = \"2 s\", end = \"1 s\" } }", ["ramp.end", "after the begin"]),
        ("course = { ramp = { begin = \"2 s\" } }", ["ramp.end", "missing"]),
        ("course = { repeat = [[\"0 s\", 1]] }", ["course.repeat", "two points"]),
        ("course = { repeat = [[\"1 s\", 1], [\"0 s\", 1]] }", ["course.repeat[1]", "ascend"]),
        ("course = {}", ["wall.course", "sine, ramp, repeat"]),
        ("course = { sinus = 3 }", ["sinus", "did you mean \"sine\"?"]),
        (
            "ramp = \"1 s\", course = { ramp = { end = \"1 s\" } }",
            ["wall.course", "both ramp and course"],
        ),
        ("course = \"sine\"", ["wall.course", "a list of points, or a table"]),
    ] {
        one_problem(&wall_with(written), &words);
    }
}

/// Courses by formula stand wherever points do.
#[test]
fn a_course_can_be_a_formula() {
    let course_of = |text: &str| match &read(text).unwrap().spec.scene.domain.faces[0][0] {
        Face::Wall { course, .. } => course.clone(),
        other => panic!("{other:?}"),
    };
    let tau = std::f64::consts::TAU;
    let sine = Sine { frequency: 2.0, amplitude: 1.0, phase: 0.0, mean: 0.0 };
    for (written, course) in [
        ("course = { sine = { frequency = \"2 Hz\" } }", Course::Sine(sine)),
        (
            "course = { sine = { period = \"0.25 s\", amplitude = 0.5, phase = \"90 deg\", mean = 1 } }",
            Course::Sine(Sine { frequency: 4.0, amplitude: 0.5, phase: 0.25 * tau, mean: 1.0 }),
        ),
        ("course = { ramp = { end = \"2 s\" } }", Course::Points(vec![[0.0, 0.0], [2.0, 1.0]])),
        (
            "course = { ramp = { begin = \"1 s\", end = \"2 s\", from = 1, to = -0.5 } }",
            Course::Points(vec![[1.0, 1.0], [2.0, -0.5]]),
        ),
        (
            "course = { repeat = [[\"0 s\", 0], [\"1 s\", 1.5], [\"3 s\", 0]] }",
            Course::Repeat(vec![[0.0, 0.0], [1.0, 1.5], [3.0, 0.0]]),
        ),
        ("course = [[\"0 s\", 0.0], [\"1 s\", 1.0]]", Course::Points(vec![[0.0, 0.0], [1.0, 1.0]])),
        ("ramp = \"0.5 s\"", Course::Points(vec![[0.0, 0.0], [0.5, 1.0]])),
    ] {
        let text = wall_with(written);
        assert_eq!(course_of(&text), course, "{written}");
        reads_back(&text);
    }
    // Beside the wall's table, as with other faces.
    let beside =
        wall_with("").replace(",  } }", " }, course = { sine = { frequency = \"2 Hz\" } } }");
    assert_eq!(course_of(&beside), Course::Sine(sine));
    for face in [
        "pressure = \"2 kPa\", course = { sine = { frequency = \"3 Hz\" } }",
        "velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"], course = { repeat = [[\"0 s\", 0], [\"1 s\", 1]] }",
        "reservoir = { area = \"1 mm2\", volume = \"1 L\", piston = \"1 m/s\", course = { sine = { period = \"1 s\" } } }",
    ] {
        reads_back(&with_faces(&format!("x = {{ lower = {{ {face} }} }}")));
    }
}

#[test]
fn a_profile_is_a_section_in_strips() {
    let text = format!(
        "{GOOD}\n[[scene.probes]]\nname = \"u\"\nprofile = {{ axis = \"z\", at = \"150 mm\", along = \"x\", bins = 5 }}\n"
    );
    let scene = read(&text).unwrap().spec.scene;
    let (min, max) = (scene.domain.min, scene.domain.max);
    let expected = ProbeShape::Profile { axis: 2, position: 0.15, min, max, along: 0, bins: 5 };
    assert_eq!(scene.probes[0].shape, expected);
    reads_back(&text);
    for (from, to, words) in [
        ("bins = 5", "bins = 65", ["profile.bins", "1 to 64"]),
        ("along = \"x\"", "along = \"z\"", ["profile.along", "across it"]),
        ("along = \"x\", ", "", ["profile.along", "missing"]),
        ("at = \"150 mm\"", "at = \"15 m\"", ["profile.at", "outside the domain"]),
    ] {
        one_problem(&text.replace(from, to), &words);
    }
}

/// A sphere that a symmetry plane cuts is its own image, or stands still; one that moves freely is
/// neither.
#[test]
fn spheres_that_symmetry_planes_cut_obey_one_rule() {
    let with = |position: &str, rest: &str| {
        with_faces("x = { lower = \"symmetry\" }").replace(
            "[\"50 mm\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\" }]",
            &format!("[\"{position}\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\"{rest} }}]"),
        )
    };
    let held = |text: String| {
        text.replace("name = \"sphere\"\n", "name = \"sphere\"\nmotion = \"prescribed\"\n")
    };
    let moves = ", velocity = [\"0 m/s\", \"1 mm/s\", \"0 m/s\"]";
    let across = ", velocity = [\"1 mm/s\", \"0 m/s\", \"0 m/s\"]";
    one_problem(
        &with("3 mm", ""),
        &["the symmetry plane x_lower cuts", "moves freely", "half a diameter away"],
    );
    one_problem(&with("0 mm", ""), &["moves freely"]);
    one_problem(
        &held(with("3 mm", moves)),
        &["x_lower cuts", "not its own image", "centre on the plane"],
    );
    one_problem(&held(with("0 mm", across)), &["not its own image"]);
    for good in [with("8 mm", ""), held(with("3 mm", "")), held(with("0 mm", moves))] {
        read(&good).unwrap_or_else(|errors| panic!("{errors}"));
    }
}
