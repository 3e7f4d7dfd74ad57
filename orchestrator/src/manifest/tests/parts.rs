//! Parts.

use super::*;
use tremie_geometry::Mesh;
use tremie_messages::scene::{
    Course, Geometry, MotionPoint, PartBoundary, Reservoir, Sine, SliderSpring, Stops, TimedMotion,
};
use tremie_messages::units::Length;

fn with_part(lines: &str) -> String {
    format!("{GOOD}\n[[scene.parts]]\nname = \"valve\"\n{lines}\n")
}

fn refused(lines: &str, words: &[&str]) {
    one_problem(&with_part(lines), words);
}

/// A box in the middle of the domain.
const BOX: &str = "box = { size = [\"10 mm\", \"20 mm\", \"30 mm\"] }\nposition = [\"50 mm\", \"50 mm\", \"60 mm\"]";

#[test]
fn a_part_is_a_wall_at_rest_unless_it_says_otherwise() {
    let text = with_part(BOX);
    let part = &read(&text).unwrap().spec.scene.parts[0];
    assert_eq!(part.geometry, Geometry::Box { size: [0.01, 0.02, 0.03] });
    assert_eq!(part.pose.position, [0.05, 0.05, 0.06]);
    assert_eq!(part.pose.orientation, [0.0, 0.0, 0.0, 1.0]);
    assert_eq!((part.cavity, part.material.as_str()), (false, "wall"));
    assert_eq!((&part.motion, &part.boundary), (&Motion::Fixed, &PartBoundary::Wall));
    reads_back(&text);
}

#[test]
fn a_part_can_turn_move_and_drive_the_fluid() {
    let text = with_part(&format!(
        "{BOX}\nrotation = {{ axis = [0, 0, 2], angle = \"90 deg\" }}\nmotion = \"prescribed\"\nangular_velocity = [\"0 rad/s\", \"0 rad/s\", \"60 rpm\"]\nboundary = {{ pressure = \"5 bar\", ramp = \"1 ms\" }}"
    ));
    let part = &read(&text).unwrap().spec.scene.parts[0];
    let root = std::f64::consts::FRAC_1_SQRT_2;
    let [x, y, z, w] = part.pose.orientation;
    assert_eq!((x, y), (0.0, 0.0));
    assert!((z - root).abs() < 1e-15 && (w - root).abs() < 1e-15, "{z} {w}");
    let Motion::Prescribed(points) = &part.motion else { panic!() };
    let MotionPoint { time, velocity, angular_velocity } = points[0];
    assert_eq!((points.len(), time, velocity), (1, 0.0, [0.0; 3]));
    assert!((angular_velocity[2] - std::f64::consts::TAU).abs() < 1e-12);
    let course = Course::Points(vec![[0.0, 0.0], [1e-3, 1.0]]);
    assert_eq!(part.boundary, PartBoundary::Pressure { pressure: 5e5, course });
    reads_back(&text);
}

#[test]
fn a_part_can_have_a_reservoir() {
    let with =
        |keys: &str, more: &str| format!("{BOX}\nboundary = {{ reservoir = {{ {keys} }}{more} }}");
    let keys = "area = \"2 cm2\", volume = \"1 L\", piston = \"0.5 m/s\", stop = \"2 s\"";
    let text = with_part(&with(keys, ""));
    let part = &read(&text).unwrap().spec.scene.parts[0];
    let reservoir = Reservoir { stop: Some(2.0), ..Reservoir::new(2e-4, 1e-3, 0.5) };
    assert_eq!(part.boundary, PartBoundary::Reservoir(reservoir));
    reads_back(&text);
    refused(&with("volume = \"1 L\"", ""), &["boundary.reservoir", "area"]);
    refused(&with(keys, ", ramp = \"1 s\""), &["boundary.ramp", "its piston may have a ramp"]);
    refused(&with(keys, ", pressure = \"1 Pa\""), &["pressure", "reservoir"]);
}

#[test]
fn a_part_can_be_turned_on_a_lathe() {
    let at = "position = [\"50 mm\", \"50 mm\", \"60 mm\"]";
    let profile = "[[\"0 mm\", \"0 mm\"], [\"5 mm\", \"0 mm\"], [\"0 mm\", \"8 mm\"]]";
    let text = with_part(&format!("revolved = {{ profile = {profile} }}\n{at}"));
    let part = &read(&text).unwrap().spec.scene.parts[0];
    let profile = vec![[0.0, 0.0], [5e-3, 0.0], [0.0, 8e-3]];
    assert_eq!(part.geometry, Geometry::Revolved { profile });
    reads_back(&text);
    let wrong = "[[\"1 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"], [\"1 mm\", \"1 mm\"]]";
    refused(
        &format!("revolved = {{ profile = {wrong} }}\n{at}"),
        &["makes no solid", "on the axis"],
    );
}

#[test]
fn a_part_can_be_drawn_out_along_an_axis() {
    let at = "position = [\"50 mm\", \"50 mm\", \"60 mm\"]";
    let outline = "[[\"0 mm\", \"0 mm\"], [\"5 mm\", \"0 mm\"], [\"0 mm\", \"8 mm\"]]";
    let with = |rest: &str| format!("extrusion = {{ outline = {outline}{rest} }}\n{at}");
    let text = with_part(&with(", axis = \"y\", length = \"2 cm\""));
    let part = &read(&text).unwrap().spec.scene.parts[0];
    let outline = vec![[0.0, 0.0], [5e-3, 0.0], [0.0, 8e-3]];
    assert_eq!(part.geometry, Geometry::Extruded { outline, axis: 1, length: 0.02 });
    reads_back(&text);
    refused(&with(", axis = \"y\""), &["extrusion.length", "missing"]);
    refused(&with(", length = \"2 cm\""), &["extrusion.axis", "missing"]);
    let bow =
        "[[\"0 mm\", \"0 mm\"], [\"5 mm\", \"5 mm\"], [\"5 mm\", \"0 mm\"], [\"0 mm\", \"8 mm\"]]";
    refused(
        &format!("extrusion = {{ outline = {bow}, axis = \"z\", length = \"1 cm\" }}\n{at}"),
        &["makes no solid", "corners 0 and 2 meet"],
    );
}

#[test]
fn a_wrong_part_is_one_problem() {
    refused("", &["the part's surface", "file, box, cylinder, sphere, revolved, extrusion"]);
    refused(&format!("{BOX}\nsphere = {{ radius = \"1 mm\" }}"), &["found both box and sphere"]);
    refused(&BOX.replace("\"20 mm\"", "\"0 mm\""), &["box.size[1]", "more than zero"]);
    refused(&format!("{BOX}\nunit = \"mm\""), &["only a file has a unit"]);
    refused(&format!("{BOX}\nmotion = \"free\""), &["\"fixed\" or \"prescribed\"", "slider = {"]);
    refused(
        &format!("{BOX}\nvelocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"]"),
        &["found \"fixed\"", "motion = \"prescribed\""],
    );
    refused(
        &format!("{BOX}\nrotation = {{ axis = [0, 0, 0], angle = \"1 rad\" }}"),
        &["a direction"],
    );
    refused(&format!("{BOX}\nrotation = {{ axis = [0, 0, 1], angle = \"1 m\" }}"), &["an angle"]);
    refused(&format!("{BOX}\nboundary = {{}}"), &["what the part is to the fluid"]);
    refused(&format!("{BOX}\nmaterial = \"stone\""), &["no material \"stone\""]);
    refused("cylinder = { radius = \"1 mm\" }", &["cylinder.length: missing"]);
    one_problem(&with_part(BOX).replace("\"valve\"", "\"a.b\""), &["letters, digits"]);
    let twice = format!("{}\n[[scene.parts]]\nname = \"valve\"\n{BOX}\n", with_part(BOX));
    one_problem(&twice, &["a second part"]);
}

/// A prescribed part is at rest unless it is told to move, and moves by a formula if it is told to.
#[test]
fn a_prescribed_part_rests_or_follows_a_formula() {
    let motion = |lines: &str| {
        let text = with_part(&format!("{BOX}\nmotion = \"prescribed\"\n{lines}"));
        reads_back(&text);
        read(&text).unwrap().spec.scene.parts[0].motion.clone()
    };
    let still = MotionPoint { time: 0.0, velocity: [0.0; 3], angular_velocity: [0.0; 3] };
    assert_eq!(motion(""), Motion::Prescribed(vec![still]));
    let swings = motion(
        "velocity = [\"0 m/s\", \"2 m/s\", \"0 m/s\"]\ncourse = { sine = { frequency = \"5 Hz\" } }",
    );
    let timed = TimedMotion {
        velocity: [0.0, 2.0, 0.0],
        angular_velocity: [0.0; 3],
        course: Course::Sine(Sine::new(5.0)),
    };
    assert_eq!(swings, Motion::Timed(Box::new(timed)));
    let formula = "course = { sine = { frequency = \"5 Hz\" } }";
    refused(
        &format!("{BOX}\nmotion = \"prescribed\"\n{formula}"),
        &["parts[0].course", "no velocity", "give the part a velocity"],
    );
    refused(&format!("{BOX}\n{formula}"), &["only a prescribed motion"]);
    refused(
        &format!("{BOX}\nmass = \"1 kg\""),
        &["unknown key \"mass\"", "leave it out", "slider"],
    );
}

/// A folder with the file `cube.stl`, an edge of 20 units long, and `open.stl`, which lacks one
/// triangle of it.
fn files() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    let mut cube = Mesh::of(&Geometry::Box { size: [20.0; 3] }).unwrap();
    let file = |name: &str| std::fs::File::create(home.path().join(name)).unwrap();
    cube.write_stl(&mut file("cube.stl"), 1.0).unwrap();
    cube.triangles.pop();
    cube.write_stl(&mut file("open.stl"), 1.0).unwrap();
    home
}

#[test]
fn a_file_is_found_from_the_manifest_and_its_surface_checked() {
    let home = files();
    let read = |lines: &str| {
        let text = with_part(&format!("position = [\"50 mm\", \"50 mm\", \"60 mm\"]\n{lines}"));
        parse(&home.path().join("manifest.toml"), text, &[])
    };
    let manifest = read("file = \"cube.stl\"\nunit = \"mm\"").unwrap();
    let Geometry::File { path, unit } = &manifest.spec.scene.parts[0].geometry else { panic!() };
    assert_eq!((Path::new(path), *unit), (home.path().join("cube.stl").as_path(), 1e-3));
    let again = parse(Path::new("elsewhere/again.toml"), manifest.resolved(), &[]).unwrap();
    assert_eq!(again.spec, manifest.spec);
    assert_eq!(read("file = \"cube.stl\"\nunit = \"0.5 mm\"").unwrap().spec.scene.parts.len(), 1);

    let wrong = |lines: &str, key: &str, words: &[&str]| {
        let errors = read(lines).map(|manifest| manifest.spec).expect_err(lines);
        assert_eq!(errors.problems.len(), 1, "{errors}");
        assert_eq!(errors.problems[0].key, format!("scene.parts[0]{key}"), "{errors}");
        for word in words {
            assert!(errors.to_string().contains(word), "\"{word}\" is not in: {errors}");
        }
    };
    wrong("file = \"cube.stl\"", ".unit", &["what one unit of the file is", "unit = \"mm\""]);
    wrong("file = \"cube.stl\"\nunit = \"kg\"", ".unit", &["a unit of length"]);
    wrong("file = \"cube.stl\"\nunit = \"m\"", ".unit", &["20 m long", "is its unit right?"]);
    wrong("file = \"cube.stl\"\nunit = \"um\"", ".unit", &["2e-5 m long"]);
    wrong("file = \"open.stl\"\nunit = \"mm\"", ".file", &["not closed", "hole within"]);
    wrong("file = \"none.stl\"\nunit = \"mm\"", ".file", &["cannot read", "none.stl"]);
}

#[test]
fn a_part_outside_the_domain_is_a_problem_unless_it_comes_in() {
    let outside = BOX.replace("\"60 mm\"]", "\"600 mm\"]");
    refused(&outside, &["wholly outside the domain"]);
    let comes = format!(
        "{outside}\nmotion = \"prescribed\"\nvelocity = [\"0 m/s\", \"0 m/s\", \"-1 m/s\"]"
    );
    assert!(read(&with_part(&comes)).is_ok());
}

#[test]
fn a_part_that_moves_needs_grains() {
    let text = with_part(&format!(
        "{BOX}\nmotion = \"prescribed\"\nvelocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"]"
    ));
    assert!(read(&text).is_ok());
    let alone = text.replace("grains = { program = \"grains-dem\", sync_iter = 3 }\n", "");
    let alone = alone.replace("grains.max_speed", "fluid.max_speed");
    one_problem(&alone, &["scene.parts[0].motion", "the role grains"]);
}

/// The valve of Mutabaruka and Kamrin, in the box of the other tests.
const VALVE: &str = "slider = { axis = [0, 0, 2], mass = \"9.2 g\", lift = \"1 mm\", spring = { rate = \"625 N/m\", preload = \"92 mm\", stroke = \"4.5 mm\" }, stops = { lower = \"0 mm\", upper = \"4.5 mm\", stiffness = \"1e7 N/m\", restitution = 0.2 } }";

fn sliding(old: &str, new: &str) -> String {
    assert_eq!(VALVE.matches(old).count(), 1, "{old}");
    with_part(&format!("{BOX}\nmotion = {{ {} }}", VALVE.replace(old, new)))
}

#[test]
fn a_part_can_slide_on_a_spring_between_stops() {
    let text = sliding("\"9.2 g\"", "\"9.2 g\"");
    let part = &read(&text).unwrap().spec.scene.parts[0];
    let Motion::Slider(slider) = &part.motion else { panic!() };
    assert_eq!((slider.axis, slider.mass, slider.lift), ([0.0, 0.0, 2.0], 9.2e-3, 1e-3));
    assert_eq!((slider.velocity, slider.force), (0.0, 0.0));
    let SliderSpring::Tangent { rate, preload, stroke } = slider.spring else { panic!() };
    let end = "4.5 mm".parse::<Length>().unwrap().0;
    assert_eq!((rate, stroke), (625.0, end));
    assert!((preload - 57.5).abs() < 1e-12);
    let stops = Stops { lower: Some(0.0), upper: Some(end), stiffness: 1e7, restitution: 0.2 };
    assert_eq!(slider.stops, Some(stops));
    // The position is that at lift 0, and the part begins a lift further.
    assert!((part.pose.position[2] - 0.061).abs() < 1e-15);
    reads_back(&text);
}

#[test]
fn a_spring_has_a_preload_by_force_or_a_table() {
    let spring = |text: &str| {
        let manifest = read(text).unwrap();
        let Motion::Slider(slider) = &manifest.spec.scene.parts[0].motion else { panic!() };
        reads_back(text);
        slider.spring.clone()
    };
    let linear = sliding("\"92 mm\", stroke = \"4.5 mm\"", "\"57.5 N\"");
    assert_eq!(spring(&linear), SliderSpring::Linear { rate: 625.0, preload: 57.5 });
    let tan = "rate = \"625 N/m\", preload = \"92 mm\", stroke = \"4.5 mm\"";
    let table = sliding(tan, "table = [[\"0 mm\", \"50 N\"], [\"5 mm\", \"60 N\"]]");
    assert_eq!(spring(&table), SliderSpring::Table(vec![[0.0, 50.0], [5e-3, 60.0]]));
    let none = sliding(&format!("spring = {{ {tan} }}, "), "force = \"-2 N\", ");
    assert_eq!(spring(&none), SliderSpring::None);
}

#[test]
fn a_wrong_slider_is_one_problem() {
    let refused = |old: &str, new: &str, words: &[&str]| one_problem(&sliding(old, new), words);
    refused("axis = [0, 0, 2], ", "", &["slider.axis: missing"]);
    refused("[0, 0, 2]", "[0, 0, 0]", &["slider.axis", "a direction"]);
    refused("\"9.2 g\"", "\"9.2 mm\"", &["a mass"]);
    refused("\"9.2 g\"", "\"0 g\"", &["slider.mass", "more than zero"]);
    refused("\"92 mm\"", "\"92 s\"", &["a force or a length", "92 s"]);
    refused("\"625 N/m\", ", "\"625 N/m\", table = [], ", &["found both rate and table"]);
    refused("rate = \"625 N/m\"", "table = [[\"0 mm\", \"1 N\"]]", &["only a spring with a rate"]);
    refused("restitution = 0.2", "", &["stops.restitution: missing"]);
    refused("lower = \"0 mm\", upper = \"4.5 mm\", ", "", &["neither lower nor upper"]);
    refused("mass =", "mas =", &["unknown key \"mas\"", "\"mass\""]);
    let motion = |lines: &str| with_part(&format!("{BOX}\n{lines}"));
    one_problem(&motion("motion = {}"), &["expected slider"]);
    one_problem(&motion("motion = 3"), &["\"fixed\", \"prescribed\", or a table with slider"]);
    let course = format!("motion = {{ {VALVE} }}\nvelocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"]");
    one_problem(&motion(&course), &["only a prescribed motion has it"]);
    let alone = sliding("9.2 g", "9.2 g")
        .replace("grains = { program = \"grains-dem\", sync_iter = 3 }\n", "")
        .replace("grains.max_speed", "fluid.max_speed");
    one_problem(&alone, &["scene.parts[0].motion", "the role grains"]);
}
