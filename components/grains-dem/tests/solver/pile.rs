//! A settled pile stays where it is.

use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{BodySet, ContactLaw, Damping, Scene};

/// Without friction of rolling a loose sphere may go on rolling for long.
fn rough() -> ContactLaw {
    ContactLaw { rolling_friction: 0.1, ..law(300.0, 0.5, Damping::Restitution(0.4)) }
}

fn at_the_own_step(mut scene: Scene, bodies: BodySet) -> GrainsDem {
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![bodies];
    // Four times as much and dashpots, which are explicit, would keep the pile shaking.
    let dt = Parameters::default().resolve(&scene).unwrap().time_step.unwrap();
    make(&scene, dt)
}

/// Leaves a pile for `settling` and then for `resting` [s]: no centre creeps by a millionth of a
/// diameter in tens of thousands of steps, and nothing is left of the kinetic energy but rounding.
fn rests(dem: &mut GrainsDem, settling: f64, resting: f64) {
    let dt = dem.time_step();
    dem.advance((settling / dt) as u32, &[]).unwrap();
    let (settled, early) = (dem.diagnostics(), state(dem));
    let steps = (resting / dt) as u32;
    assert!(steps > 10_000);
    dem.advance(steps, &[]).unwrap();
    let (later, late) = (dem.diagnostics(), state(dem));
    println!("{steps} steps: {settled:?}\n{later:?}");
    // The energy of one sphere's fall through its diameter.
    let fall = mass(1e-3) * 9.81 * 1e-3;
    assert!(later.kinetic_energy < 1e-16 * fall, "{}", later.kinetic_energy);
    assert!((later.mean_height - settled.mean_height).abs() < 1e-10);
    for (a, b) in early.iter().zip(&late) {
        let crept = norm(minus(a.position, b.position));
        assert!(crept < 1e-9, "body {} crept by {crept} m", a.id);
    }
    assert!(later.max_overlap_ratio < 0.05 && later.deep_overlaps == 0);
}

#[test]
fn a_bed_between_walls_does_not_drift() {
    let bed = packed([0.0; 3], [4e-3, 4e-3, 5e-3], 0.42, (0.8e-3, 1.2e-3), 11);
    let mut dem = at_the_own_step(scene([4e-3, 4e-3, 8e-3], WALLS, rough()), bed);
    rests(&mut dem, 0.12, 0.04);
    assert!(dem.diagnostics().contacts as usize >= 2 * dem.body_count());
}

/// A ridge left of a wall of spheres that fell apart: its slopes are held by friction alone.
#[test]
fn a_ridge_with_free_slopes_does_not_creep() {
    let column = packed([7e-3, 0.0, 0.0], [13e-3, 3e-3, 7e-3], 0.5, (0.9e-3, 1.1e-3), 3);
    let mut dem = at_the_own_step(scene([20e-3, 3e-3, 9e-3], FLOOR, rough()), column);
    rests(&mut dem, 0.26, 0.04);
    let ridge = state(&dem);
    let top = ridge.iter().map(|s| s.position[2]).fold(0.0, f64::max);
    let low = ridge.iter().filter(|s| s.position[2] < 1e-3).count();
    assert!(top > 2.4e-3, "several layers high: {top}");
    assert!(low * 5 > ridge.len() * 2, "and not the column any more: {low} of {}", ridge.len());
}
