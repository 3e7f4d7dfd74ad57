//! Spheres on a lattice.

use super::*;

const PACKING: &str = "packing = { min = [\"0 mm\", \"0 mm\", \"2 mm\"], max = [\"1 cm\", \"1 cm\", \"1 cm\"], fraction = 0.1, diameter = [\"1 mm\", \"1.5 mm\"] }";

/// The good manifest, its packing on a lattice instead.
fn with(lattice: &str) -> String {
    assert!(GOOD.contains(PACKING));
    GOOD.replacen(PACKING, &format!("motion = \"fixed\"\nlattice = {lattice}"), 1)
}

#[test]
fn a_lattice_is_a_list_of_spheres() {
    let text = with(
        "{ min = [\"0 mm\", \"0 mm\", \"2 mm\"], max = [\"8 mm\", \"8 mm\", \"4 mm\"], diameter = \"2 mm\", arrangement = \"cubic\" }",
    );
    let scene = read(&text).unwrap().spec.scene;
    let Placement::Listed(spheres) = &scene.bodies[1].placement else { panic!() };
    assert_eq!(spheres.len(), 16);
    assert!(spheres.iter().all(|sphere| sphere.position[2] == 3e-3 && sphere.diameter == 2e-3));
    reads_back(&text);
}

#[test]
fn what_makes_no_lattice_is_one_problem() {
    let region = "min = [\"0 mm\", \"0 mm\", \"2 mm\"], max = [\"1 cm\", \"1 cm\", \"1 cm\"]";
    let fine = format!("{{ {region}, diameter = \"10 um\" }}");
    one_problem(&with(&fine), &["lattice.max", "spheres, expected 1e6"]);
    let wide = format!("{{ {region}, diameter = \"9 mm\" }}");
    one_problem(&with(&wide), &["lattice.max", "too narrow"]);
    let flat = format!("{{ {region}, diameter = \"1 mm\", spacing = \"0 mm\" }}");
    one_problem(&with(&flat), &["lattice.spacing", "more than zero"]);
    let both = format!("{{ {region}, diameter = \"1 mm\" }}\n{PACKING}");
    one_problem(&with(&both), &["lattice", "both packing and a lattice"]);
}
