//! Questions allocate nothing.

use tremie_geometry::{Bounds, Row, RowScratch, Surface, Vec3};
use tremie_messages::scene::Geometry;
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn questions_allocate_nothing() {
    let surface = Surface::of(&Geometry::Sphere { radius: 1.0 }).unwrap();
    let mut near = Vec::with_capacity(surface.mesh().triangles.len());
    let mut scratch = RowScratch::default();
    let mut row = [false; 64];
    let mut ask = |shift: f64| {
        let p = Vec3::new(0.7, shift, 0.3);
        surface.triangles_near(&Bounds { min: p, max: p.add_scalar(0.2) }, &mut near);
        surface.fill_row(
            &Row { start: Vec3::new(-1.1, shift, 0.1), step: Vec3::new(0.03, 0.0, 0.01) },
            &mut row,
            &mut scratch,
        );
        let distance = surface.signed_distance(p);
        let crossing = surface.first_crossing(p, p.add_scalar(1.0)).unwrap();
        distance + crossing.fraction + near.len() as f64
    };
    ask(0.0);
    let before = allocations();
    let sum: f64 = (0..100).map(|i| ask(0.004 * f64::from(i))).sum();
    assert_eq!(allocations() - before, 0);
    assert!(sum.is_finite() && row.contains(&true));
}
