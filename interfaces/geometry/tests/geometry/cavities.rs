//! Parts whose inside is free: pipes, tanks, housings.

use crate::bodies::*;
use proptest::prelude::*;
use tremie_geometry::{EdgeKind, Row, RowScratch, Surface};
use tremie_messages::scene::{Geometry, Motion, Part, PartBoundary, Pose};

fn part(geometry: Geometry, cavity: bool) -> Part {
    Part {
        name: "pipe".to_string(),
        geometry,
        pose: Pose::IDENTITY,
        cavity,
        material: "steel".to_string(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }
}

#[test]
fn a_pipe_is_free_inside_and_its_wall_is_solid() {
    let pipe = Surface::of_part(&part(Geometry::Box { size: [4.0, 1.0, 1.0] }, true)).unwrap();
    assert!(pipe.is_cavity());
    assert!(!pipe.contains([1.9, 0.0, 0.0]) && pipe.contains([2.1, 0.0, 0.0]));
    assert!(pipe.contains([0.0, 0.5, 0.1]), "the wall is solid");
    assert!(pipe.contains([100.0, 0.0, 0.0]));
    let closest = pipe.closest([0.3, 0.4, 0.0]);
    assert!((closest.distance - 0.1).abs() < 1e-15);
    assert_eq!(closest.normal, -Vec3::y());
    let crossing = pipe.first_crossing([0.3, 0.4, 0.0], [0.3, 0.8, 0.0]).unwrap();
    assert!((crossing.fraction - 0.25).abs() < 1e-15);
    // What touches the wall from inside cannot touch its edges alone.
    let kinds: Vec<EdgeKind> = (0..12).flat_map(|t| pipe.edge_kinds(t)).collect();
    assert_eq!(kinds.iter().filter(|&&k| k == EdgeKind::Concave).count(), 24);
    assert!(!kinds.contains(&EdgeKind::Convex));
    assert!(!Surface::of_part(&part(Geometry::Sphere { radius: 1.0 }, false)).unwrap().is_cavity());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_cavity_is_solid_where_the_body_is_not(stairs in stairs(), mesh in any_body()) {
        let solid = Surface::new(tremie_geometry::mend(stairs.mesh()).unwrap().0).unwrap();
        let cavity = solid.clone().inside_out();
        let mut row = [false; 14];
        for j in 0..14 {
            for k in 0..14 {
                let line = Row {
                    start: Vec3::new(-0.5, 0.5 * f64::from(j) - 0.5, 0.5 * f64::from(k) - 0.5),
                    step: Vec3::new(0.5, 0.0, 0.0),
                };
                cavity.fill_row(&line, &mut row, &mut RowScratch::default());
                for (i, &inside) in row.iter().enumerate() {
                    let p = line.point(i);
                    let on = solid.signed_distance(p) == 0.0;
                    prop_assert_eq!(inside, on || !solid.contains(p), "{:?}", p);
                }
            }
        }
        let solid = Surface::new(mesh).unwrap();
        let back = solid.clone().inside_out().inside_out();
        prop_assert_eq!(back.mesh(), solid.mesh());
        prop_assert!(!back.is_cavity());
    }
}
