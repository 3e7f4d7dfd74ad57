//! Same bits on any number of threads.

use crate::common::gas;
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::body::BodyState;

fn states(
    scene: &tremie_messages::scene::Scene,
    detection: Detection,
    threads: usize,
) -> Vec<BodyState> {
    let parameters = Parameters { detection, ..Parameters::default() };
    let mut spheres = HardSpheres::new(scene, &parameters, 0.02, threads).unwrap();
    spheres.advance(100, &[]).unwrap();
    let mut out = vec![BodyState::at_rest(0, [0.0; 3]); spheres.body_count()];
    spheres.write_state(&mut out);
    out
}

#[test]
fn threads_change_no_bit() {
    // Enough for several threads to look for touches.
    let scene = gas(3, 7, 0.3, (0.9, 0.3), 4);
    for detection in [Detection::Events, Detection::Steps] {
        let one = states(&scene, detection, 1);
        for threads in [2, 8] {
            assert!(one == states(&scene, detection, threads), "{detection:?}, {threads} threads");
        }
    }
}

/// A lattice whose bodies all collide at the same moments: ids break the ties.
#[test]
fn ties_are_broken_by_ids() {
    let mut scene = crate::common::scene([16.0; 3], crate::common::PERIODIC, 0.9, 0.0);
    let bodies = (0..512).map(|k| {
        let place = [k % 8, k / 8 % 8, k / 64].map(|n| 2.0 * f64::from(n) + 0.5);
        let speed = if k % 2 == 0 { 1.0 } else { -1.0 };
        crate::common::sphere(place, 1.0, [speed, 0.0, 0.0])
    });
    scene.bodies = vec![crate::common::set(
        tremie_messages::scene::Motion::Free,
        crate::common::density(3),
        bodies.collect(),
    )];
    for detection in [Detection::Events, Detection::Steps] {
        let one = states(&scene, detection, 1);
        assert!(one == states(&scene, detection, 2));
        // All rows are alike, whoever comes first.
        for k in (0..512).step_by(8) {
            for n in 0..8 {
                assert_eq!(one[k + n].velocity, one[n].velocity, "{detection:?}, {k} {n}");
            }
        }
    }
}
