//! A step of the ring allocates nothing: neither its passes nor the shapes and forces that they
//! need.

mod common;

use common::{RUBBER, model, press, ring};
use tremie_geometry::Vec3;
use tremie_messages::scene::{DeformableSurface, Pose};
use tremie_messages::{BodyState, FacetLoad, SurfaceVertex};
use tremie_rubber_table::fem::Hold;
use tremie_rubber_table::fem::contact::Seat;
use tremie_rubber_table::make::tabulate;
use tremie_rubber_table::runtime::{Form, Impedance, Law, Seal, Start, effective_force, relax};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    let model = model(ring([6, 4]), RUBBER, &[Hold::bonded("top")], Some(Seat::flat(0.0)));
    let table = tabulate(&model, &press(&model, 0.6e-3, 41), 0.6e-3, "test".into(), None).unwrap();
    let surface = table.surface(24);
    let mut section = table.contents().vertices[0].clone();
    let mut places = surface.places(&section);
    let loads: Vec<Vec3> = places.iter().map(|place| Vec3::z() * (10.0 * place.x)).collect();
    let loads: Vec<Vec3> = loads.into_iter().cycle().take(surface.triangles.len()).collect();
    let start = Start {
        compression: 0.1e-3,
        rate: 0.0,
        dt: 1e-7,
        contact_stiffness: 1e6,
        impedance: Impedance(5.0),
    };
    let before = allocations();
    for form in [Form::Axial, Form::Pressure] {
        let settled = relax(&table, Law::default(), start, |at| {
            table.vertices_into(at, &mut section);
            surface.place_into(&section, &mut places);
            effective_force(form, &surface, &places, &loads).force
        });
        assert!(settled.unwrap().passes > 2);
    }
    assert_eq!(allocations() - before, 0);
    a_seal_allocates_nothing(table);
}

/// In the same test: others would count with it.
fn a_seal_allocates_nothing(table: tremie_rubber_table::table::Table) {
    let scene = DeformableSurface {
        name: "ring".into(),
        carrier: "disc".into(),
        table: "ring.json".into(),
        pose: Pose::IDENTITY,
        sectors: 60,
        material: "rubber".into(),
        seat_stiffness: 1e10,
        start: Default::default(),
        section: table.outline().section,
    };
    let mut seal = Seal::new(&scene, table, Law::default(), Form::Axial, None, 1e-7).unwrap();
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    let load =
        |facet| FacetLoad { facet, force: [0.0, 0.0, 0.1], stiffness: 1e5, ..FacetLoad::default() };
    let loads: Vec<FacetLoad> = (0..200).map(load).collect();
    let before = allocations();
    seal.begin_window(loads.iter().copied());
    for _ in 0..3 {
        seal.begin_substep(&BodyState::at_rest(0, [0.0; 3]));
        seal.write(&mut vertices);
        while !seal.pass(loads.iter().copied()).unwrap() {
            seal.write(&mut vertices);
        }
        assert!(seal.resultant().force[2] > 0.0);
    }
    assert_eq!(allocations() - before, 0);
}
