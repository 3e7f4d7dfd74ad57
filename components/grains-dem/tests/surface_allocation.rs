//! Trials of a surface that deforms, and substeps with one, make no allocation.

mod common;
use common::*;
use tremie_geometry::Mesh;
use tremie_grains_dem::{DeformableSurface, GrainsDem, Parameters, SurfaceState};
use tremie_messages::scene::{
    Damping, Geometry, Motion, Part, PartBoundary, Pose, Slider, SliderSpring,
};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

fn part(size: [f64; 3], position: [f64; 3], motion: Motion) -> Part {
    Part {
        name: format!("{motion:?}").chars().take(5).collect(),
        geometry: Geometry::Box { size },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

#[test]
fn neither_a_trial_nor_a_substep_with_a_surface_allocates() {
    let mut scene = scene([6e-3, 6e-3, 10e-3], WALLS, law(1e3, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, 9.81];
    scene.bodies = vec![packed([0.0; 3], [6e-3, 6e-3, 2.8e-3], 0.3, (0.6e-3, 0.6e-3), 4)];
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass: 1e-2,
        lift: 0.0,
        velocity: 0.0,
        spring: SliderSpring::None,
        force: 0.0,
        stops: None,
    };
    let carrier = Motion::Slider(Box::new(slider));
    scene.parts = vec![
        part([1e-3; 3], [3e-3, 3e-3, 9e-3], carrier),
        part([5.6e-3, 0.6e-3, 2.5e-3], [3e-3, 0.5e-3, 1.25e-3], Motion::Fixed),
    ];
    // A block to which the grains fall up, moved to and fro, two of its edges onto a beam.
    let block = Mesh::of(&Geometry::Box { size: [5e-3, 5e-3, 1e-3] }).unwrap();
    let vertices: Vec<[f64; 3]> =
        block.vertices.iter().map(|v| [v.x + 3e-3, v.y + 3e-3, v.z + 3.4e-3]).collect();
    let surface = DeformableSurface {
        triangles: block.triangles.clone(),
        vertices: vertices.clone(),
        carrier: 0,
        material: "wall".into(),
        seat_stiffness: 1e9,
    };
    let mut dem =
        GrainsDem::with_surfaces(&scene, &Parameters::default(), 2e-6, 2, &[surface]).unwrap();
    let (mut now, mut loads) = (vertices.clone(), Vec::new());
    let velocities = vec![[0.0; 3]; vertices.len()];
    let mut before = 0;
    let mut contacts = 0;
    dem.begin_window(4_000, &[]).unwrap();
    for k in 0..4_000 {
        if k == 3_000 {
            before = allocations();
        }
        let phase = f64::from(k % 500) / 250.0;
        let down = 0.5e-3 * if phase < 1.0 { phase } else { 2.0 - phase };
        dem.begin_substep().unwrap();
        for trial in 0..3 {
            for (now, x) in now.iter_mut().zip(&vertices) {
                now[2] = x[2] - down - 1e-5 * f64::from(trial);
            }
            dem.contact_on_surface(0, &now, &velocities, &mut loads).unwrap();
            contacts += loads.len();
        }
        let carrier_force = [0.0; 3];
        let state = SurfaceState { vertices: &now, velocities: &velocities, carrier_force };
        dem.finish_substep(&[state]).unwrap();
    }
    assert_eq!(allocations() - before, 0);
    assert!(contacts > 1_000, "{contacts}");
    dem.end_window().unwrap();
}
