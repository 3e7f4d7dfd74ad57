//! Materials, contact laws of pairs, diameters and motions of bodies.

use super::*;
use tremie_messages::scene::{ContactLaw, MotionPoint, SievePoint, Spring, Tangential};

/// Two sets of bodies in a box, with what a test adds.
const TWO: &str = r#"[run]
until = "1 s"

[scene.domain]
size = ["1 m", "1 m", "1 m"]

[scene.materials.glass]
density = "2500 kg/m3"
youngs_modulus = "70 GPa"
poisson_ratio = 0.22

[scene.materials.steel]
density = "7800 kg/m3"
youngs_modulus = "200 GPa"
poisson_ratio = 0.3

[[scene.bodies]]
name = "beads"
material = "glass"
packing = { min = ["0 m", "0 m", "0 m"], max = ["1 m", "1 m", "0.5 m"], fraction = 0.1, diameter = "0.1 m" }

[[scene.bodies]]
name = "ball"
material = "steel"
spheres = [{ position = ["0.5 m", "0.5 m", "0.8 m"], diameter = "0.1 m" }]

[[scene.contacts]]
normal_stiffness = "1e4 N/m"
tangential_stiffness = "8e3 N/m"
friction = 0.3
restitution = 0.8

[[scene.contacts]]
between = ["steel", "glass"]
normal_stiffness = "2e4 N/m"
tangential_stiffness = "1e4 N/m"
rolling_friction = 0.02
normal_damping = "1 kg/s"
tangential_damping = "0 kg/s"
tension = true

[components]
grains = "grains-dem"
"#;

fn refused(from: &str, to: &str, words: &[&str]) {
    assert!(TWO.contains(from), "{from}");
    one_problem(&TWO.replacen(from, to, 1), words);
}

fn law<'a>(scene: &'a tremie_messages::scene::Scene, one: &str, other: &str) -> &'a ContactLaw {
    scene.law(one, other).unwrap_or_else(|| panic!("no law between {one} and {other}"))
}

#[test]
fn a_pair_has_its_law_and_all_others_the_common_one() {
    let scene = read(TWO).unwrap().spec.scene;
    assert_eq!((scene.bodies[0].density, scene.bodies[1].density), (2500.0, 7800.0));
    assert_eq!(scene.bodies[0].material, "glass");
    let common = law(&scene, "glass", "glass");
    assert_eq!(common.damping, Damping::Restitution(0.8));
    for pair in [["steel", "steel"], ["glass", "wall"], ["steel", "wall"]] {
        assert_eq!(law(&scene, pair[0], pair[1]), common);
    }
    let own = law(&scene, "glass", "steel");
    assert_eq!(own.rolling_friction, 0.02);
    assert_eq!(own.damping, Damping::Coefficients { normal: 1.0, tangential: 0.0 });
    assert!(own.tension && own.friction == 0.0);
    assert_eq!(scene.contacts.len(), 5, "each pair once");
    reads_back(TWO);
}

#[test]
fn hertz_takes_the_moduli_of_the_pair() {
    let text = TWO.replace(
        "normal_stiffness = \"1e4 N/m\"\ntangential_stiffness = \"8e3 N/m\"",
        "hertz = true",
    );
    // The walls need moduli too.
    let errors = read(&text).unwrap_err();
    let keys: Vec<_> = errors.problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(
        keys,
        ["scene.materials.wall.youngs_modulus", "scene.materials.wall.poisson_ratio"],
        "{errors}"
    );
    let text = text.replace("[scene.domain]\n", "[scene.domain]\nmaterial = \"steel\"\n");
    let scene = read(&text).unwrap().spec.scene;
    let Spring::Hertz { effective_modulus, effective_shear_modulus } =
        law(&scene, "glass", "glass").spring
    else {
        panic!()
    };
    // Equal materials: E* = E / (2 (1 - nu^2)), G* = G / (2 (2 - nu)), G = E / (2 (1 + nu)).
    let (e, nu) = (70e9, 0.22);
    assert!((effective_modulus / (e / (2.0 * (1.0 - nu * nu))) - 1.0_f64).abs() < 1e-14);
    let g = e / (2.0 * (1.0 + nu));
    assert!((effective_shear_modulus / (g / (2.0 * (2.0 - nu))) - 1.0_f64).abs() < 1e-14);
    assert!(matches!(law(&scene, "glass", "steel").spring, Spring::Linear { .. }));
    reads_back(&text);
    one_problem(
        &text.replace("youngs_modulus = \"70 GPa\"\n", ""),
        &["scene.materials.glass.youngs_modulus", "Hertz", "\"glass\""],
    );
    one_problem(
        &text.replace(
            "restitution = 0.8",
            "normal_damping = \"1 kg/s\"\ntangential_damping = \"1 kg/s\"",
        ),
        &["Hertz", "restitution"],
    );
    one_problem(
        &text.replace("hertz = true", "hertz = true\nnormal_stiffness = \"1 N/m\""),
        &["takes its stiffness from the materials"],
    );
    let adhering = text.replace("hertz = true", "hertz = true\nwork_of_adhesion = \"50 mN/m\"");
    let scene = read(&adhering).unwrap().spec.scene;
    let spring = law(&scene, "glass", "glass").spring;
    let work_of_adhesion = 0.05;
    assert_eq!(
        spring,
        Spring::Jkr { effective_modulus, effective_shear_modulus, work_of_adhesion }
    );
    reads_back(&adhering);
    one_problem(&adhering.replace("50 mN/m", "0 N/m"), &["work_of_adhesion", "more than zero"]);
    refused(
        "friction = 0.3",
        "friction = 0.3\nwork_of_adhesion = \"0.05 N/m\"",
        &["work_of_adhesion", "hertz = true"],
    );
}

#[test]
fn wrong_materials_and_pairs_are_one_problem_each() {
    refused(
        "material = \"glass\"",
        "material = \"glas\"",
        &["no material \"glas\"", "did you mean \"glass\"?"],
    );
    refused(
        "between = [\"steel\", \"glass\"]",
        "between = [\"steel\", \"ice\"]",
        &["no material \"ice\"", "between[1]"],
    );
    refused("between = [\"steel\", \"glass\"]\n", "", &["a second law for all pairs"]);
    refused("between = [\"steel\", \"glass\"]", "between = [\"steel\"]", &["a list of length 1"]);
    refused(
        "density = \"2500 kg/m3\"",
        "density = \"-1 kg/m3\"",
        &["scene.materials.glass.density"],
    );
    refused(
        "density = \"2500 kg/m3\"\n",
        "",
        &["scene.bodies[0].density", "[scene.materials.glass]"],
    );
    refused("poisson_ratio = 0.3", "poisson_ratio = 0.6", &["at most 0.5"]);
    refused("rolling_friction = 0.02", "rolling_friction = -1", &["zero or more"]);
    refused(
        "[scene.domain]\n",
        "[scene.domain]\nmaterial = \"stel\"\n",
        &["did you mean \"steel\"?"],
    );
    let twice = TWO.replacen(
        "[[scene.contacts]]\n",
        "[[scene.contacts]]\nbetween = [\"glass\", \"steel\"]\n",
        1,
    );
    let errors = read(&twice).unwrap_err().to_string();
    assert!(errors.contains("a second law between"), "{errors}");
    assert!(errors.contains("no law between \"glass\" and \"glass\""), "{errors}");
}

#[test]
fn the_command_line_reaches_all_of_it() {
    let set = |key: &str, value: &str| {
        let sets = [(key.to_string(), value.to_string())];
        let manifest = parse(Path::new("manifest.toml"), TWO.to_string(), &sets);
        manifest.unwrap_or_else(|errors| panic!("{errors}")).spec.scene
    };
    assert_eq!(set("scene.materials.glass.density", "2600 kg/m3").bodies[0].density, 2600.0);
    assert_eq!(law(&set("scene.contacts[0].friction", "0.1"), "glass", "wall").friction, 0.1);
    let open = set("scene.domain.z.upper.pressure", "1 Pa");
    assert!(open.domain.faces[2][1].is_open() && open.domain.faces[2][0] == Face::WALL);
    assert_eq!(set("scene.domain.x", "symmetry").domain.faces[0], [Face::Symmetry, Face::Symmetry]);
    let sizes = set("scene.bodies[0].packing.diameter", "[\"1 cm\", \"2 cm\"]");
    let Placement::Packed(packing) = &sizes.bodies[0].placement else { panic!() };
    assert_eq!(packing.diameters, Diameters::Uniform { min: 0.01, max: 0.02 });
}

#[test]
fn bodies_that_never_meet_need_no_law() {
    let fixed =
        TWO.replace("material = \"glass\"", "material = \"glass\"\nmotion = \"fixed\"").replacen(
            "[[scene.contacts]]\n",
            "[[scene.contacts]]\nbetween = [\"steel\", \"wall\"]\n",
            1,
        );
    let errors = read(&fixed).unwrap_err();
    let messages: Vec<_> = errors.problems.iter().map(|p| p.message.clone()).collect();
    assert_eq!(messages, ["there is no law between \"steel\" and \"steel\", which may meet"]);
}

#[test]
fn the_old_form_of_contacts_comes_with_the_new_one() {
    let old = "[scene.contacts]\nbody_body = { normal_stiffness = \"1e4 N/m\", tangential_stiffness = \"8e3 N/m\", friction = 0.3, restitution = 0.8 }\n";
    let start = TWO.find("[[scene.contacts]]").unwrap();
    let end = TWO.find("[components]").unwrap();
    let text = format!("{}{old}{}", &TWO[..start], &TWO[end..]);
    one_problem(&text, &["[[scene.contacts]]", "body_body", "between ="]);
}

#[test]
fn diameters_follow_each_distribution() {
    let with = |diameters: &str| {
        TWO.replace(
            "fraction = 0.1, diameter = \"0.1 m\" }",
            &format!("fraction = 0.1, {diameters} }}"),
        )
    };
    let drawn = |diameters: &str| {
        let text = with(diameters);
        reads_back(&text);
        match &read(&text).unwrap().spec.scene.bodies[0].placement {
            Placement::Packed(packing) => packing.diameters.clone(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(
        drawn(
            "diameters = { normal = { mean = \"10 mm\", deviation = \"1 mm\", min = \"5 mm\", max = \"15 mm\" } }"
        ),
        Diameters::Normal { mean: 0.01, deviation: 1e-3, min: 5e-3, max: 15e-3 }
    );
    assert_eq!(
        drawn(
            "diameters = { log_normal = { median = \"10 mm\", spread = 1.2, min = \"5 mm\", max = \"15 mm\" } }"
        ),
        Diameters::LogNormal { median: 0.01, spread: 1.2, min: 5e-3, max: 15e-3 }
    );
    let point = |size: f64, passing: f64| SievePoint { size, passing };
    assert_eq!(
        drawn("diameters = { sieve = [[\"5 mm\", 0.0], [\"10 mm\", 0.4], [\"20 mm\", 1.0]] }"),
        Diameters::Sieve(vec![point(5e-3, 0.0), point(0.01, 0.4), point(0.02, 1.0)])
    );
    assert_eq!(drawn("diameters = [\"1 cm\", \"2 cm\"]"), Diameters::Listed(vec![0.01, 0.02]));

    let wrong = |diameters: &str, words: &[&str]| one_problem(&with(diameters), words);
    let normal = |more: &str| format!("diameters = {{ normal = {{ mean = \"10 mm\", {more} }} }}");
    wrong(
        &normal("deviation = \"1 mm\", min = \"5 mm\", max = \"4 mm\""),
        &["normal.max", "more than min"],
    );
    wrong(&normal("deviation = \"0 mm\", min = \"5 mm\", max = \"14 mm\""), &["more than zero"]);
    wrong(&normal("deviation = \"1 mm\", min = \"5 mm\""), &["normal.max: missing"]);
    wrong(&normal("deviation = \"1 mm\", min = \"50 mm\", max = \"60 mm\""), &["there are none"]);
    wrong(
        "diameters = { log_normal = { median = \"10 mm\", spread = 0.9, min = \"5 mm\", max = \"15 mm\" } }",
        &["more than 1"],
    );
    wrong(
        "diameters = { sieve = [[\"5 mm\", 0.1], [\"10 mm\", 1.0]] }",
        &["sieve[0]", "expected 0"],
    );
    wrong("diameters = { sieve = [[\"5 mm\", 0.0], [\"4 mm\", 1.0]] }", &["sieve[1]", "ascend"]);
    wrong("diameters = { sieve = [[\"5 mm\", 0.0]] }", &["two or more"]);
    wrong("diameters = {}", &["a distribution"]);
    wrong("diameters = { gauss = 1 }", &["valid keys: normal, log_normal, sieve"]);
    wrong("diameters = \"1 mm\"", &["a list of lengths"]);
}

#[test]
fn bodies_can_follow_a_course() {
    let course = "motion = \"prescribed\"\ncourse = [{ time = \"0 s\" }, { time = \"1 s\", velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] }]";
    let text = TWO.replace("material = \"steel\"\n", &format!("material = \"steel\"\n{course}\n"));
    let still = MotionPoint { time: 0.0, velocity: [0.0; 3], angular_velocity: [0.0; 3] };
    let points = vec![still, MotionPoint { time: 1.0, velocity: [1.0, 0.0, 0.0], ..still }];
    assert_eq!(read(&text).unwrap().spec.scene.bodies[1].motion, Motion::Prescribed(points));
    reads_back(&text);
    one_problem(&text.replace("motion = \"prescribed\"\n", ""), &["only a prescribed motion"]);
    one_problem(&text.replace("time = \"1 s\"", "time = \"0 s\""), &["course[1]", "ascend"]);
    one_problem(&text.replace("{ time = \"0 s\" }", "{}"), &["course[0].time"]);
    let placed = "diameter = \"0.1 m\", velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] }]";
    one_problem(&text.replace("diameter = \"0.1 m\" }]", placed), &["spheres[0]", "has a course"]);
}

#[test]
fn friction_without_history_has_no_tangential_spring() {
    let springs = "tangential_stiffness = \"8e3 N/m\"\n";
    let text = TWO.replacen(springs, "friction_history = false\n", 1);
    let scene = read(&text).unwrap().spec.scene;
    let spring = Spring::LinearNoHistory { normal_stiffness: 1e4 };
    assert_eq!(law(&scene, "glass", "wall").spring, spring);
    reads_back(&text);
    let both = TWO.replacen(springs, &format!("{springs}friction_history = false\n"), 1);
    one_problem(&both, &["tangential_stiffness", "friction_history = false"]);
    let rolling = text.replacen("friction = 0.3\n", "friction = 0.3\nrolling_friction = 0.1\n", 1);
    one_problem(&rolling, &["rolling_friction", "friction_history = false"]);
}

/// The law of Chen et al. in place of the common law.
fn by_chen(more: &str) -> String {
    let common = "normal_stiffness = \"1e4 N/m\"\ntangential_stiffness = \"8e3 N/m\"\nfriction = 0.3\nrestitution = 0.8\n";
    assert!(TWO.contains(common));
    let weight = "[scene]\ngravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]\n\n[scene.domain]\n";
    TWO.replacen(common, more, 1).replacen("[scene.domain]\n", weight, 1)
}

#[test]
fn chen_takes_gravity_and_the_cell() {
    let text = by_chen("chen = { cell = \"0.5 mm\", gap = \"1 mm\" }\n");
    let scene = read(&text).unwrap().spec.scene;
    let found = law(&scene, "glass", "wall");
    let Spring::Chen { stiffness_per_mass, gap, psi, tangential } = found.spring else { panic!() };
    assert!((stiffness_per_mass / (9.81 / (0.01 * 0.5e-3)) - 1.0_f64).abs() < 1e-14);
    assert_eq!((gap, psi, tangential), (1e-3, 0.3, Tangential::Spring));
    assert_eq!((found.damping, found.friction, found.tension), (Damping::Ratio(0.4), 0.3, true));
    reads_back(&text);
    let text = by_chen(
        "chen = { cell = \"1 mm\", theta = 0.02, alpha = 0.2, psi = 0, tangential = \"one-step\" }\nfriction = 0.1\ntension = false\n",
    );
    let scene = read(&text).unwrap().spec.scene;
    let found = law(&scene, "glass", "glass");
    let tangential = Tangential::OneStep;
    let stiffness_per_mass = 9.81 / (0.02 * 1e-3);
    assert_eq!(found.spring, Spring::Chen { stiffness_per_mass, gap: 0.0, psi: 0.0, tangential });
    assert_eq!((found.damping, found.friction, found.tension), (Damping::Ratio(0.2), 0.1, false));
    reads_back(&text);
}

#[test]
fn what_does_not_go_with_chen_is_one_problem() {
    let chen = "chen = { cell = \"0.5 mm\" }\n";
    for (key, value) in [
        ("normal_stiffness", "\"1 N/m\""),
        ("hertz", "true"),
        ("restitution", "0.5"),
        ("normal_damping", "\"1 kg/s\""),
    ] {
        one_problem(&by_chen(&format!("{chen}{key} = {value}\n")), &[key, "found chen too"]);
    }
    one_problem(&by_chen(&format!("{chen}rolling_friction = 0.1\n")), &["rolling_friction"]);
    one_problem(&by_chen("chen = {}\n"), &["chen.cell"]);
    one_problem(&by_chen("chen = { cell = \"0 mm\" }\n"), &["chen.cell", "more than zero"]);
    one_problem(&by_chen("chen = { cell = \"1 mm\", alpha = -1 }\n"), &["chen.alpha"]);
    let weightless = by_chen(chen).replacen("-9.81", "0", 1);
    one_problem(&weightless, &["scene.contacts[0].chen", "gravity"]);
}
