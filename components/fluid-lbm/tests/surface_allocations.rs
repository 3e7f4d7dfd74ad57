//! A step with a deformable surface allocates nothing unless its links are found anew.

mod common;

use common::*;
use tremie_fluid_lbm::Refill;
use tremie_geometry::Turned;
use tremie_messages::scene::{
    DeformableSurface, FacetKind, Gap, GapRule, GapSide, Geometry, Motion, Pose, Section,
    SectionEdge,
};
use tremie_messages::{BodyState, FacetLoad, SurfaceVertex};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_without_a_search_allocates_nothing() {
    let mut case = Case::new([26, 26, 18], [WALL, WALL, WALL], 0.51);
    case.threads = 2;
    case.average_force = true;
    case.refill = Refill::Mass;
    case.gravity = [0.0, 0.0, -1e-4];
    let mut scene = case.scene();
    let mut carrier = part("disc", Geometry::Cylinder { radius: 8.1, length: 3.0 }, [0.0; 3]);
    carrier.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(carrier);
    let points = vec![[4.0, -1.7], [8.2, -1.9], [8.0, 1.6], [4.2, 1.6]];
    let edge = |k: u32| SectionEdge { points: [k, (k + 1) % 4], kind: FacetKind::Exposed };
    let seal = DeformableSurface {
        name: "seal".into(),
        carrier: "disc".into(),
        table: "seal.json".into(),
        pose: Pose::IDENTITY,
        sectors: 40,
        material: "wall".into(),
        seat_stiffness: 1.0,
        start: Default::default(),
        section: Section { points, edges: (0..4).map(edge).collect() },
    };
    let turned = Turned::of(&seal);
    let places = turned.places(&seal.section.points);
    scene.surfaces.push(seal);
    scene.gaps.push(Gap {
        name: "foot".into(),
        between: [GapSide::Part("seal".into()), GapSide::Face { axis: 2, side: 0 }],
        open_at: 2.0,
        close_at: 0.5,
        pressure: GapRule::Nearest,
        slip_below: 4.0,
        region: None,
    });
    let mut fluid = case.fluid_of(&scene);
    let bodies = [BodyState::at_rest(1, [13.0, 13.0, 6.3])];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&bodies);
    let mut on_facets = vec![FacetLoad::default(); turned.triangles.len()];
    let mut vertices = vec![SurfaceVertex::default(); places.len()];
    let mut counts = [0; 2];
    for step in 0..60 {
        // From step 20 to 40 the ring spreads by a quarter of a cell and finds links anew; then it
        // creeps.
        let wider = 1.0 + (f64::from(step.clamp(20, 40)) - 20.0) * 0.0015;
        let creep = 1e-4 * f64::from(step);
        for (vertex, place) in vertices.iter_mut().zip(&places) {
            let [x, y, z] = (*place).into();
            vertex.position = [13.0 + wider * x, 13.0 + wider * y, 3.2 + creep + z];
            vertex.velocity = [0.0, 0.0, 1e-4];
        }
        let before = allocations();
        fluid.set_surfaces(&vertices).unwrap();
        match step {
            0 => fluid.start(&bodies, &mut loads).unwrap(),
            _ => fluid.step(&bodies, &mut loads).unwrap(),
        }
        fluid.surface_loads(&mut on_facets);
        let made = allocations() - before;
        if (3..20).contains(&step) || step > 41 {
            counts[0] += made;
        } else {
            counts[1] += made;
        }
    }
    println!("without a search {}, with some {}", counts[0], counts[1]);
    assert_eq!(counts[0], 0);
    assert!(counts[1] > 0 && on_facets.iter().any(|load| load.force[2] != 0.0));
}
