//! A settled bed advances without a single allocation.

mod common;
use common::*;
use tremie_grains_dem::{GrainsDem, Integrator, Parameters};
use tremie_messages::scene::{
    BinnedAxis, Damping, DragBand, Geometry, GrainProfile, Motion, Part, PartBoundary, Pose,
    ProfileVelocity,
};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_substep_allocates_nothing() {
    let mut scene = scene([6e-3, 6e-3, 10e-3], WALLS, law(1e3, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    // More bodies than a block, on two threads, around a part.
    scene.bodies = vec![packed([0.0; 3], [6e-3; 3], 0.45, (0.6e-3, 0.6e-3), 4)];
    scene.parts = vec![Part {
        name: "post".into(),
        geometry: Geometry::Box { size: [1e-3, 1e-3, 3e-3] },
        pose: Pose { position: [3e-3, 3e-3, 1.5e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }];
    scene.drag_bands = vec![DragBand {
        name: "band".into(),
        min: [0.0; 3],
        max: [6e-3, 6e-3, 2e-3],
        terminal_speed: 0.1,
    }];
    scene.profiles = vec![GrainProfile {
        name: "seen".into(),
        axes: vec![BinnedAxis { axis: 0, bins: 3 }, BinnedAxis { axis: 2, bins: 10 }],
        min: [0.0; 3],
        max: [6e-3, 6e-3, 10e-3],
        from: 0.0,
        every: Some(4.0 * 6e-6),
        average: Some(12.0 * 6e-6),
        velocity: ProfileVelocity::Displacement,
    }];
    for integrator in [Integrator::Verlet, Integrator::Heun, Integrator::Chen] {
        let parameters = Parameters { integrator, ..Parameters::default() };
        let mut dem = GrainsDem::new(&scene, &parameters, 2e-6, 2).unwrap();
        assert!(dem.body_count() > 512);
        dem.advance(8_000, &[]).unwrap();
        dem.measure_profiles(&scene, 6e-6);
        let mut loads = vec![tremie_messages::Load::default(); dem.body_count()];
        for (id, load) in (0..).zip(&mut loads) {
            load.id = id;
        }
        let before = allocations();
        for _ in 0..200 {
            dem.advance(3, &loads).unwrap();
        }
        assert_eq!(allocations() - before, 0, "{integrator:?}");
    }
}
