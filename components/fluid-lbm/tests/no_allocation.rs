//! A step allocates nothing while no body comes or goes.

mod common;

use common::*;
use tremie_fluid_lbm::Refill;
use tremie_messages::BodyState;
use tremie_messages::scene::{Course, Face, Geometry, Motion, Outflow, Reservoir};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    let mut case = Case::new([40, 24, 24], [PERIODIC, WALL, WALL], 0.7);
    case.threads = 2;
    case.average_force = true;
    case.refill = Refill::Mass;
    let mut scene = case.scene();
    scene.domain.faces[1] = [
        Face::Symmetry,
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Absorbing },
    ];
    scene.domain.faces[2][1] =
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Convective };
    scene.domain.faces[2][0] = Face::Reservoir(Reservoir::new(960.0, 96_000.0, 1e-3));
    scene.parts.push(part(
        "rod",
        Geometry::Cylinder { radius: 2.2, length: 30.0 },
        [20.0, 20.1, 12.0],
    ));
    let mut stirrer = part("stirrer", Geometry::Box { size: [5.0, 2.0, 3.0] }, [0.0; 3]);
    stirrer.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(stirrer);
    let mut fluid = case.fluid_of(&scene);
    let mut bodies: Vec<BodyState> = (0..8)
        .map(|id| {
            let mut state =
                BodyState::at_rest(id, [5.0 * id as f64, 6.0 + (id % 3) as f64 * 5.0, 12.0]);
            state.velocity = [0.06, 0.0, 0.03 * (id as f64 - 3.5) / 3.5];
            state.angular_velocity = [0.0, 0.0, 0.01];
            state
        })
        .collect();
    let mut events: Vec<_> = bodies.iter().map(|b| added(b.id, 3.0)).collect();
    let mut state = BodyState::at_rest(9, [12.0, 4.0, 4.0]);
    state.velocity = [0.04, 0.01, 0.02];
    bodies.push(state);
    events.push(added_part(9, 1));
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    advance(&mut bodies);
    fluid.step(&bodies, &mut loads).unwrap();

    let before = allocations();
    let mut covered = 0;
    for _ in 0..150 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        covered += fluid.diagnostics().covered;
    }
    assert_eq!(allocations() - before, 0);
    assert!(covered > 500, "{covered}");
}
