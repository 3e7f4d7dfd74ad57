//! Thousand polyhedron-steps per second of a settled heap, and microseconds a contact, on one
//! thread.
//!
//! `cargo bench -p tremie-grains-dem --no-default-features --bench solid_steps`

use std::time::Instant;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
    Polyhedra, PolyhedronPlacement, Scene, Shape, Spring,
};

const D: f64 = 1e-3;

fn heap(name: &str) -> Scene {
    let law = ContactLaw {
        spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 800.0 },
        friction: 0.5,
        rolling_friction: 0.0,
        damping: Damping::Restitution(0.3),
        tension: false,
    };
    let size = [8e-3, 8e-3, 20e-3];
    let vertices = tremie_geometry::solid(name).expect("a regular solid");
    let packing = Packing {
        min: [0.0; 3],
        max: size,
        fraction: 0.15,
        diameters: Diameters::Uniform { min: D, max: D },
        seed: 1,
    };
    Scene {
        gravity: [0.0, 0.0, -9.81],
        shapes: vec![Shape { name: name.into(), vertices }],
        bodies: vec![BodySet {
            name: "heap".into(),
            density: 2500.0,
            material: "heap".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Polyhedra(Polyhedra {
                shape: name.into(),
                placement: PolyhedronPlacement::Packed(packing),
            }),
        }],
        contacts: ["heap", "wall"]
            .map(|other| PairLaw { between: ["heap".into(), other.into()], law: law.clone() })
            .to_vec(),
        ..Scene::empty(Domain::new([0.0; 3], size, Face::WALLS))
    }
}

fn main() {
    for name in ["tetrahedron", "cube", "octahedron", "dodecahedron"] {
        let (scene, parameters) = (heap(name), Parameters::default());
        let dt = parameters.resolve(&scene).expect("a valid scene").time_step.expect("contacts");
        let mut dem = GrainsDem::new(&scene, &parameters, dt, 1).expect("a packing");
        dem.advance((0.08 / dt) as u32, &[]).expect("settling");
        let steps = 2000;
        let start = Instant::now();
        dem.advance(steps, &[]).expect("a settled heap");
        let took = start.elapsed().as_secs_f64();
        let (bodies, contacts) = (dem.body_count() as f64, dem.diagnostics().contacts as f64);
        println!(
            "{bodies} {name}s, {:.2} contacts each: {:.0} thousand steps/s, {:.2} us a contact, step {dt:.2e} s",
            contacts / bodies,
            1e-3 * bodies * f64::from(steps) / took,
            1e6 * took / (f64::from(steps) * contacts),
        );
    }
}
