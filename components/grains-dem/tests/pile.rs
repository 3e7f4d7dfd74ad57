//! A settled pile stays where it is.

mod common;
use common::*;
use tremie_grains_dem::Parameters;
use tremie_messages::scene::{ContactLaw, Damping};

/// At the time step that the solver itself chooses; four times as much and dashpots, which are
/// explicit, would keep the pile shaking.
#[test]
fn a_pile_at_rest_does_not_drift() {
    // Without friction of rolling a loose sphere may go on rolling for long.
    let rough = ContactLaw { rolling_friction: 0.05, ..law(1e3, 0.5, Damping::Restitution(0.4)) };
    let mut scene = scene([4e-3, 4e-3, 8e-3], WALLS, rough);
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![packed([0.0; 3], [4e-3, 4e-3, 5e-3], 0.42, (0.8e-3, 1.2e-3), 11)];
    let dt = Parameters::default().resolve(&scene).unwrap().time_step.unwrap();
    let mut dem = make(&scene, dt);
    dem.advance((0.15 / dt) as u32, &[]).unwrap();
    let (settled, early) = (dem.diagnostics(), state(&dem));
    dem.advance((0.05 / dt) as u32, &[]).unwrap();
    let (later, late) = (dem.diagnostics(), state(&dem));
    println!("{settled:?}\n{later:?}");
    assert!(later.max_speed < 1e-6, "{}", later.max_speed);
    assert!((later.mean_height - settled.mean_height).abs() < 1e-12);
    for (a, b) in early.iter().zip(&late) {
        assert!(norm(minus(a.position, b.position)) < 1e-7, "body {}", a.id);
    }
    assert!(later.max_overlap_ratio < 0.05 && later.deep_overlaps == 0);
    assert!(later.contacts as usize >= 2 * dem.body_count());
}
