use super::*;
use tremie_messages::Role;
use tremie_messages::scene::{Damping, Diameters, Face, Motion, Placement};

mod contacts;
mod drag_bands;
mod faces;
mod hoppers;
mod inlets;
mod lattice;
mod parts;
mod planes;
mod polyhedra;
mod profiles;
mod seals;
mod watch;

/// A manifest that is right; tests break one line of it.
const GOOD: &str = r#"[run]
until = "1.5 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["100 mm", "100 mm", "160 mm"]
x = "periodic"

[scene.fluid]
density = "970 kg/m3"
viscosity = "0.373 Pa s"

[[scene.planes]]
point = ["0 mm", "0 mm", "1 mm"]
normal = [0, 0, 2.0]

[[scene.bodies]]
name = "sphere"
density = "1120 kg/m3"
spheres = [{ position = ["50 mm", "50 mm", "127.5 mm"], diameter = "15 mm" }]

[[scene.bodies]]
name = "bed"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "2 mm"], max = ["1 cm", "1 cm", "1 cm"], fraction = 0.1, diameter = ["1 mm", "1.5 mm"] }

[[scene.contacts]]
normal_stiffness = "1e4 N/m"
tangential_stiffness = "8e3 N/m"
friction = 0.3
restitution = 0.8

[components]
fluid = "fluid-lbm"
grains = { program = "grains-dem", sync_iter = 3 }

[settings.fluid-lbm]
cell = "1 mm"

[settings.minimal-fluid]
anything = true

[[stop_when]]
signal = "grains.max_speed"
below = 1e-4
hold = "10 ms"
"#;

fn read(text: &str) -> Result<Manifest, ManifestErrors> {
    parse(Path::new("manifest.toml"), text.to_string(), &[])
}

fn with(sets: &[(&str, &str)]) -> Result<Manifest, ManifestErrors> {
    let sets: Vec<_> = sets.iter().map(|(k, v)| ((*k).to_string(), (*v).to_string())).collect();
    parse(Path::new("manifest.toml"), GOOD.to_string(), &sets)
}

/// Replaces `old` in the good manifest and expects exactly one problem: in the line that holds
/// `old`, with all of `words` in its rendering.
fn broken(old: &str, new: &str, words: &[&str]) {
    assert_eq!(GOOD.matches(old).count(), 1, "\"{old}\" must be in the manifest once");
    let text = GOOD.replace(old, new);
    let errors = read(&text).map(|manifest| manifest.spec).expect_err(new);
    let rendered = errors.render(false);
    assert_eq!(errors.problems.len(), 1, "{rendered}");
    let line = GOOD[..GOOD.find(old).unwrap()].matches('\n').count() + 1;
    assert!(rendered.contains(&format!("--> manifest.toml:{line}:")), "line {line}: {rendered}");
    for word in words {
        assert!(rendered.contains(word), "\"{word}\" is not in: {rendered}");
    }
}

/// Expects exactly one problem of the text, with all of `words` in its rendering.
#[track_caller]
fn one_problem(text: &str, words: &[&str]) {
    let errors = read(text).map(|manifest| manifest.spec).expect_err(text);
    let rendered = errors.render(false);
    assert_eq!(errors.problems.len(), 1, "{rendered}");
    for word in words {
        assert!(rendered.contains(word), "\"{word}\" is not in: {rendered}");
    }
}

/// Expects that the resolved manifest of the text says the same, and the same again.
#[track_caller]
fn reads_back(text: &str) {
    let manifest = read(text).unwrap_or_else(|errors| panic!("{errors}"));
    let resolved = manifest.resolved();
    let again = parse(Path::new("elsewhere/again.toml"), resolved.clone(), &[])
        .unwrap_or_else(|errors| panic!("{errors}\n{resolved}"));
    assert_eq!(again.spec, manifest.spec);
    assert_eq!(again.resolved(), resolved);
}

#[test]
fn a_good_manifest_is_read_in_si_with_defaults() {
    let manifest = read(GOOD).unwrap();
    let Spec { run, scene, components, outputs, stop_when, .. } = &manifest.spec;
    assert_eq!((run.until, run.deadline, run.seed), (1.5, 30.0, 1));
    assert_eq!(scene.gravity, [0.0, 0.0, -9.81]);
    assert_eq!(scene.domain.faces[0], [Face::Periodic, Face::Periodic]);
    assert_eq!(scene.planes[0].normal, [0.0, 0.0, 1.0]);
    assert_eq!(scene.bodies[0].motion, Motion::Free);
    let Placement::Packed(packing) = &scene.bodies[1].placement else { panic!() };
    assert_eq!(packing.seed, 1);
    assert_eq!(packing.diameters, Diameters::Uniform { min: 1e-3, max: 1.5e-3 });
    assert_eq!(scene.domain.faces[2], [Face::WALL, Face::WALL]);
    assert_eq!(scene.contacts[1].law, scene.contacts[0].law);
    assert_eq!(scene.contacts[0].law.damping, Damping::Restitution(0.8));
    assert_eq!(components[0].role, Role::Fluid);
    assert_eq!(components[0].settings["cell"], "1 mm");
    assert_eq!(components[1].sync_iter, Some(3));
    assert_eq!((outputs.frames, outputs.signals, outputs.record), (1.5 / 200.0, None, true));
    assert_eq!(stop_when[0].limit, Limit::Below(1e-4));
    assert_eq!(manifest.notes.len(), 1);
    assert!(manifest.notes[0].contains("settings.minimal-fluid"));
    assert_eq!(manifest.source.text()[manifest.source.span("run.until").unwrap()], *"\"1.5 s\"");
}

#[test]
fn one_wrong_value_is_one_problem_in_its_line() {
    broken("until = \"1.5 s\"", "until = \"0 s\"", &["run.until", "more than zero"]);
    broken(
        "until = \"1.5 s\"",
        "until = \"1.5 m\"",
        &["a time with a unit", "\"20 ms\"", "\"1.5 m\""],
    );
    broken("\"-9.81 m/s2\"", "-9.81", &["bare number -9.81"]);
    broken("\"160 mm\"", "\"-160 mm\"", &["scene.domain.size[2]"]);
    broken(
        "x = \"periodic\"",
        "x = \"periodc\"",
        &["did you mean \"periodic\"?", "expected \"wall\""],
    );
    broken("density = \"970 kg/m3\"", "density = \"-970 kg/m3\"", &["-970 kg/m3"]);
    broken("viscosity = \"0.373 Pa s\"", "viscosity = \"0 Pa s\"", &["more than zero"]);
    broken("normal = [0, 0, 2.0]", "normal = [0, 0, 0]", &["a direction"]);
    broken("normal = [0, 0, 2.0]", "normal = [0, 0]", &["a list of length 2", "length 3"]);
    broken("diameter = \"15 mm\"", "diameter = \"-15 mm\"", &["-0.015 m"]);
    broken("\"127.5 mm\"", "\"159 mm\"", &["not inside the domain"]);
    broken("\"127.5 mm\"", "\"8 mm\"", &["reaches through scene.planes[0]"]);
    broken("\"1e4 N/m\"", "\"-1e4 N/m\"", &["normal_stiffness"]);
    broken("restitution = 0.8", "restitution = 1.2", &["at most 1"]);
    broken("restitution = 0.8", "restitution = 0.0", &["more than 0"]);
    broken("restitution = 0.8", "restitution = 0.8\nnormal_damping = \"1 kg/s\"", &["either"]);
    broken("friction = 0.3", "friction = -0.3", &["zero or more"]);
    broken("fraction = 0.1", "fraction = 0.8", &["densest"]);
    broken("[\"1 mm\", \"1.5 mm\"]", "[\"2 mm\", \"1.5 mm\"]", &["smaller one first"]);
    broken("[\"1 mm\", \"1.5 mm\"]", "\"2 kg\"", &["a length"]);
    broken("[\"1 mm\", \"1.5 mm\"]", "\"20 mm\"", &["too narrow"]);
    broken("sync_iter = 3", "sync_iter = 0", &["a whole number"]);
    broken("sync_iter = 3", "sync_iter = 2000", &["at most 1000"]);
    broken("sync_iter = 3", "role = \"grain\"", &["did you mean \"grains\"?"]);
    broken("sync_iter = 3", "lossless = true", &["only an observer"]);
    broken("below = 1e-4", "below = \"slow\"", &["expected a number"]);
}

#[test]
fn one_wrong_key_is_one_problem_with_the_nearest() {
    broken("viscosity =", "viscocity =", &["did you mean \"viscosity\"?", "^^^^^^^^^"]);
    broken("until =", "untill =", &["did you mean \"until\"?"]);
    broken("[scene.fluid]", "[scene.flud]", &["did you mean \"fluid\"?"]);
    broken("signal =", "signl =", &["did you mean \"signal\"?"]);
}

#[test]
fn what_is_missing_is_said_at_its_table() {
    broken("[run]\nuntil = \"1.5 s\"", "[run]", &["run.until: missing"]);
    broken("[scene.fluid]\ndensity = \"970 kg/m3\"", "[scene.fluid]", &["scene.fluid.density"]);
    broken(
        "[[scene.contacts]]\nnormal_stiffness = \"1e4 N/m\"\ntangential_stiffness = \"8e3 N/m\"\nfriction = 0.3\nrestitution = 0.8",
        "[[scene.contacts]]\nnormal_stiffness = \"1e4 N/m\"\ntangential_stiffness = \"8e3 N/m\"",
        &["missing: damping"],
    );
    broken(
        "[[stop_when]]\nsignal = \"grains.max_speed\"\nbelow = 1e-4",
        "[[stop_when]]\nsignal = \"grains.v\"",
        &["a bound"],
    );
    let errors = read("").unwrap_err();
    assert_eq!(errors.problems.len(), 1);
    assert_eq!(errors.problems[0].message, "the manifest is empty");
    let errors = read("[run]\n").unwrap_err();
    let keys: Vec<_> = errors.problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["run.until", "scene.domain.size", "components"]);
}

#[test]
fn what_does_not_fit_together_is_a_problem() {
    broken("name = \"bed\"", "name = \"sphere\"", &["a second set of bodies"]);
    broken(
        "signal = \"grains.max_speed\"",
        "signal = \"grain.max_speed\"",
        &["did you mean \"grains\"?"],
    );
    broken(
        "signal = \"grains.max_speed\"",
        "signal = \"max_speed\"",
        &["a component and its signal"],
    );
    let twice = read(
        &GOOD.replace("fluid = \"fluid-lbm\"", "other = { program = \"x\", role = \"grains\" }"),
    );
    assert!(twice.unwrap_err().to_string().contains("a second component with the role grains"));
    let watcher = "{ program = \"grains-dem\", role = \"observer\", sync_iter = 3 }";
    let watcher = GOOD.replace("{ program = \"grains-dem\", sync_iter = 3 }", watcher);
    assert!(read(&watcher).unwrap_err().to_string().contains("makes no substeps"));
    let dry = "[scene.fluid]\ndensity = \"970 kg/m3\"\nviscosity = \"0.373 Pa s\"\n";
    assert!(
        read(&GOOD.replace(dry, "")).unwrap_err().to_string().contains("a fluid needs a material")
    );
    let bounds = read(&GOOD.replace("below = 1e-4", "below = 1e-4\nabove = 1.0")).unwrap_err();
    assert!(bounds.to_string().contains("both below and above"));
    let extra =
        "spheres = [{ position = [\"50 mm\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\" }]";
    let both = format!(
        "{extra}\npacking = {{ min = [\"0 m\", \"0 m\", \"2 mm\"], max = [\"1 cm\", \"1 cm\", \"1 cm\"], fraction = 0.1, diameter = \"1 mm\" }}"
    );
    let errors = read(&GOOD.replace(extra, &both)).unwrap_err();
    assert_eq!(errors.problems.len(), 1, "{errors}");
    assert!(errors.to_string().contains("both spheres and a packing"));
}

#[test]
fn listed_spheres_must_be_apart() {
    let second = |x: &str| {
        let one = "diameter = \"15 mm\" }]";
        let two = format!(
            "diameter = \"15 mm\" }}, {{ position = [\"{x}\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\" }}]"
        );
        read(&GOOD.replace(one, &two))
    };
    assert!(second("65 mm").is_ok());
    assert!(second("64.9 mm").is_ok(), "bodies at rest on each other overlap a little");
    let errors = second("64 mm").unwrap_err();
    assert_eq!(errors.problems.len(), 1, "{errors}");
    assert_eq!(errors.problems[0].key, "scene.bodies[0].spheres[1]");
    assert!(errors.to_string().contains("overlaps scene.bodies[0].spheres[0]"));
    let across = GOOD.replace(
        "\"50 mm\", \"50 mm\", \"127.5 mm\"], diameter",
        "\"2 mm\", \"50 mm\", \"127.5 mm\"], diameter",
    );
    let across = across.replace("diameter = \"15 mm\" }]", "diameter = \"15 mm\" }, { position = [\"95 mm\", \"50 mm\", \"127.5 mm\"], diameter = \"15 mm\" }]");
    assert!(read(&across).unwrap_err().to_string().contains("overlaps"), "x is periodic");
}

/// Spheres of one clump may overlap, across periodic faces too; those of others, of none and fixed
/// ones may not.
#[test]
fn spheres_of_one_clump_may_overlap() {
    let bed = "[[scene.bodies]]\nname = \"bed\"";
    let with = |first: &str, second: &str, place: &str| {
        let more = format!(
            "[[scene.bodies]]\nname = \"more\"\ndensity = \"1120 kg/m3\"\n{second}\nspheres = [{{ position = [{place}], diameter = \"15 mm\" }}]\n\n{bed}"
        );
        let named = format!("name = \"sphere\"\n{first}");
        read(&GOOD.replace(bed, &more).replace("name = \"sphere\"", &named))
    };
    let near = "\"55 mm\", \"50 mm\", \"127.5 mm\"";
    let (one, other) = ("clump = \"h\"", "clump = \"g\"");
    assert!(with(one, one, near).is_ok());
    for (first, second) in [("", ""), (one, ""), ("", one), (one, other)] {
        let errors = with(first, second, near).unwrap_err().to_string();
        assert!(errors.contains("this sphere overlaps"), "{first} {second}: {errors}");
    }
    let united = "clump = \"h\"\nmass = \"union\"";
    for (first, second) in [(one, united), (united, one), (united, united)] {
        assert_eq!(with(first, second, near).unwrap().spec.scene.unions, ["h"]);
    }
    let summed = "clump = \"h\"\nmass = \"sum\"";
    assert_eq!(with(one, summed, near).unwrap().spec.scene.unions, [""; 0]);
    let manifest = with(united, one, near).unwrap().resolved();
    let again = parse(Path::new("again.toml"), manifest, &[]).unwrap();
    assert_eq!(again.spec.scene.unions, ["h"]);
    for (first, second, words) in [
        (united, summed, "says otherwise"),
        ("mass = \"union\"", "", "are in none"),
        ("clump = \"h\"\nmass = \"hull\"", one, "union"),
    ] {
        let errors = with(first, second, "\"20 mm\", \"50 mm\", \"127.5 mm\"").unwrap_err();
        assert!(errors.to_string().contains(words), "{errors}");
    }
}

#[test]
fn all_problems_come_at_once_in_the_order_of_the_file() {
    let text = GOOD
        .replace("until = \"1.5 s\"", "until = \"1.5 m\"")
        .replace("density = \"970 kg/m3\"", "density = -970")
        .replace("restitution = 0.8", "restitution = 8")
        .replace("signal = \"grains.max_speed\"", "signal = 3");
    let errors = read(&text).unwrap_err();
    assert_eq!(errors.problems.len(), 4, "{errors}");
    let rendered = errors.render(false);
    let place = |key: &str| rendered.find(key).unwrap();
    assert!(place("run.until") < place("scene.fluid.density"));
    assert!(place("scene.fluid.density") < place("restitution"));
    assert!(rendered.ends_with("4 problems\n"));
    assert!(errors.render(true).contains("\x1b[1;31m"));
    assert_eq!(errors.json_lines().lines().count(), 4);
    let first: Value = serde_json::from_str(errors.json_lines().lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["key"], &first["line"], &first["column"]),
        (&"run.until".into(), &2.into(), &9.into())
    );
}

#[test]
fn every_syntax_error_has_its_line() {
    let text =
        GOOD.replace("until = \"1.5 s\"", "until = 1.5 s").replace("below = 1e-4", "below = = 1");
    let errors = read(&text).unwrap_err();
    let rendered = errors.render(false);
    assert!(rendered.contains("manifest.toml:2:"), "{rendered}");
    let line = text[..text.find("below").unwrap()].matches('\n').count() + 1;
    assert!(rendered.contains(&format!("manifest.toml:{line}:")), "{rendered}");
    assert!(
        read("[run]\nuntil = \"1 s\"\nuntil = \"2 s\"")
            .unwrap_err()
            .to_string()
            .contains("duplicate key")
    );
}

#[test]
fn values_of_the_command_line_win_and_have_their_own_place() {
    let manifest = with(&[
        ("scene.bodies[0].density", "1200 kg/m3"),
        ("run.until", "\"2 s\""),
        ("components.fluid", "minimal-fluid"),
        ("components.grains.threads", "2"),
        ("settings.minimal-fluid.drag", "1.5"),
        ("outputs.record", "false"),
    ])
    .unwrap();
    assert_eq!(manifest.spec.scene.bodies[0].density, 1200.0);
    assert_eq!(manifest.spec.run.until, 2.0);
    assert_eq!(manifest.spec.components[0].program, "minimal-fluid");
    assert_eq!(manifest.spec.components[0].settings["drag"], 1.5);
    assert_eq!(manifest.spec.components[1].threads, Some(2));
    assert!(!manifest.spec.outputs.record);
    let fluid = with(&[("components.fluid.threads", "4")]).unwrap();
    assert_eq!(fluid.spec.components[0].program, "fluid-lbm");

    let wrong = |key: &str, value: &str, words: &str| {
        let errors = with(&[(key, value)]).unwrap_err();
        assert_eq!(errors.problems.len(), 1, "{errors}");
        let rendered = errors.render(false);
        assert!(rendered.contains(&format!("--> --set {key}={value}")), "{rendered}");
        assert!(rendered.contains(words), "{rendered}");
    };
    wrong("scene.fluid.viscocity", "1 Pa s", "did you mean \"viscosity\"?");
    wrong("scene.fluid.viscosity", "-1 Pa s", "more than zero");
    wrong("scene.bodies[5].density", "1 kg/m3", "has 2 entries");
    wrong(
        "run.until.x",
        "1",
        "run.until is a value, and has nothing below it: write run.until=VALUE",
    );
    wrong(
        "scene.bodies.0.density",
        "1 kg/m3",
        "scene.bodies is a list: write scene.bodies[0].density",
    );
    wrong(
        "scene.bodies.7.density",
        "1 kg/m3",
        "a list of 2 entries, counted from 0: scene.bodies[7] is not there",
    );
    wrong("scene.bodies.nobody.density", "1 kg/m3", "write scene.bodies[0].density for the first");
    wrong("scene.bodies.0.spheres.0.diameter", "1 mm", "write scene.bodies[0].spheres[0].diameter");
    wrong("scene.bodies.0", "1", "write scene.bodies[0]");
    wrong("scene.domain[0]", "1", "scene.domain is not a list; its keys are");
    wrong("run..x", "1", "is not a key");
    wrong("run.seed", "nan", "a finite number");
    wrong("run.deadline", "1e20 s", "expected at most 86400 s (a day)");
}

#[test]
fn the_resolved_manifest_reads_back_equal() {
    let sets =
        [("run.schedule", "parallel"), ("components.grains.settings", "{ time_step = \"1 us\" }")];
    for manifest in [read(GOOD).unwrap(), with(&sets).unwrap()] {
        let text = manifest.resolved();
        let again = parse(Path::new("again.toml"), text.clone(), &[])
            .unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(again.spec, manifest.spec);
        assert_eq!(again.resolved(), text);
    }
}

#[test]
fn problems_of_components_find_their_lines() {
    let manifest = with(&[("components.grains.settings.skin", "0.2")]).unwrap();
    let rendered = |component: &str, key: &str| {
        let problems = manifest.absolute(component, vec![Problem::of_parameter(key, "wrong")]);
        manifest.source.render(&problems, false)
    };
    let cell = GOOD[..GOOD.find("cell =").unwrap()].matches('\n').count() + 1;
    assert!(
        rendered("fluid", "cell")
            .contains(&format!("settings.fluid-lbm.cell: wrong\n  --> manifest.toml:{cell}:8"))
    );
    assert!(rendered("fluid", "absent").contains(&format!("manifest.toml:{}:1", cell - 1)));
    assert!(rendered("grains", "skin").contains("--> --set components.grains.settings.skin=0.2"));
}

#[test]
fn observers_are_added_once_with_their_settings() {
    let mut spec = with(&[("settings.viewer.port", "9000")]).unwrap().spec;
    spec.add_observer("viewer");
    spec.add_observer("viewer");
    spec.add_observer("recorder");
    let names: Vec<_> = spec.components.iter().map(|c| (c.name.as_str(), c.lossless)).collect();
    assert_eq!(names, [("fluid", false), ("grains", false), ("recorder", true), ("viewer", false)]);
    assert_eq!(spec.component("viewer").unwrap().settings["port"], 9000);
}

#[test]
fn a_missing_file_is_said() {
    let errors = load(Path::new("no/such/manifest.toml"), &[]).unwrap_err();
    assert!(errors.to_string().contains("cannot read no/such/manifest.toml"), "{errors}");
}

#[test]
fn the_schema_names_every_table_and_no_null() {
    let schema = schema_text();
    for word in [
        "until",
        "viscosity",
        "between",
        "sync_iter",
        "stop_when",
        "0.3 mm",
        "symmetry",
        "ramp",
        "youngs_modulus",
        "sieve",
        "cavity",
        "rotation",
        "probes",
        "slip_below",
        "inlets",
        "polyhedra",
        "shapes",
        "z_upper",
        "section",
        "relaxation_time",
        "steps_per_contact",
    ] {
        assert!(schema.contains(word), "{word}");
    }
    assert!(!schema.contains("null"), "{schema}");
}

/// After a change of the tables: `tremie schema --markdown > MANIFEST-REFERENCE.md`.
#[test]
fn the_reference_page_is_that_of_the_schema() {
    let page = include_str!("../../../MANIFEST-REFERENCE.md");
    assert!(page == reference_page(), "write MANIFEST-REFERENCE.md anew");
}

#[test]
fn the_manifests_of_the_pages_are_right() {
    for page in [include_str!("../../../README.md"), include_str!("../../../MANIFEST.md")] {
        let blocks: Vec<&str> =
            page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
        assert!(!blocks.is_empty(), "the page lost its manifests");
        for block in blocks {
            reads_back(block);
        }
    }
}

#[test]
fn odd_texts_are_rendered_too() {
    for text in [
        "= µ",
        "µ = \"µ\"",
        "[run]\nuntil = [\n 1,\n 2 ]",
        "\"",
        "a = '''",
        "[",
        "\u{feff}x = 1",
        "\tx = 1",
    ] {
        let errors = read(text).unwrap_err();
        assert!(errors.to_string().contains("error: "), "{text}");
        assert!(!errors.json_lines().is_empty());
    }
}

#[test]
fn a_problem_of_the_command_line_is_said_to_be_there() {
    let source = read(GOOD).unwrap().source;
    let rendered = source.render(&[Problem::new("--inject", "there is no component")], false);
    assert!(rendered.contains("--> command line"), "{rendered}");
}

#[test]
fn inside_without_outside_is_said_to_find_no_leak() {
    let says = |outside: &str| {
        let inside = "viscosity = \"0.373 Pa s\"\ninside = [[\"50 mm\", \"50 mm\", \"50 mm\"]]";
        let text = GOOD.replacen("viscosity = \"0.373 Pa s\"", &format!("{inside}\n{outside}"), 1);
        let notes = read(&text).unwrap_or_else(|errors| panic!("{errors}")).notes;
        notes.iter().any(|note| note.contains("leaks"))
    };
    assert!(says(""));
    assert!(!says("outside = [[\"10 mm\", \"50 mm\", \"150 mm\"]]"));
}
