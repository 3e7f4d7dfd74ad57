//! Points, segments and rows against brute force, and against each other.

use crate::bodies::*;
use proptest::prelude::*;
use tremie_geometry::{Bounds, Feature, Mesh, Row, RowScratch, Surface, mend};

fn surface(mesh: &Mesh) -> Surface {
    Surface::new(mesh.clone()).unwrap()
}

/// A row's flags, point by point and at once.
fn check_row(surface: &Surface, row: &Row, points: usize) -> Result<(), TestCaseError> {
    let mut filled = vec![false; points];
    surface.fill_row(row, &mut filled, &mut RowScratch::default());
    let one_by_one: Vec<bool> = (0..points).map(|i| surface.contains(row.point(i))).collect();
    prop_assert_eq!(filled, one_by_one, "{:?}", row);
    Ok(())
}

/// Properties of any segment.
fn check_segment(surface: &Surface, from: Vec3, to: Vec3) -> Result<(), TestCaseError> {
    let crossing = surface.first_crossing(from, to);
    if surface.contains(from) != surface.contains(to) {
        prop_assert!(crossing.is_some(), "{from:?} {to:?}");
    }
    // Few triangles hold part of the segment's box, and among them is the one.
    let mut near = Vec::new();
    prop_assert!(surface.triangles_in(&Bounds::of([from, to]), usize::MAX, &mut near));
    let among = surface.first_crossing_among(&near, from, to);
    prop_assert_eq!(among.is_some(), crossing.is_some());
    if let (Some(a), Some(b)) = (among, crossing) {
        prop_assert!((a.fraction - b.fraction).abs() < 1e-12, "{a:?} {b:?}");
    }
    if let Some(crossing) = crossing {
        let t = crossing.fraction;
        prop_assert!((0.0..=1.0).contains(&t), "{t}");
        let place: Vec3 = Vec3::from_fn(|k, _| from[k] + t * (to[k] - from[k]));
        let off = surface.signed_distance(place).abs();
        prop_assert!(
            off < 1e-12 * (1.0 + (to - from).norm()),
            "{from:?} {to:?} {crossing:?} {off}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn inside_and_distance_agree_with_brute_force(
        mesh in any_body(),
        points in proptest::collection::vec(point(), 40),
    ) {
        let surface = surface(&mesh);
        for p in points {
            let winding = solid_angles(&mesh, p);
            let far = distance(&mesh, p);
            let closest = surface.closest(p);
            prop_assert!((closest.distance.abs() - far).abs() < 1e-13);
            prop_assert!(((p - closest.point).norm() - far).abs() < 1e-13);
            if far > 1e-9 {
                prop_assert_eq!(surface.contains(p), winding > 0.5, "{:?} {}", p, winding);
                let outward = (p - closest.point).dot(&closest.normal);
                prop_assert_eq!(outward > 0.0, closest.distance > 0.0, "{:?}", closest);
            }
            prop_assert_eq!(surface.contains(p), closest.distance <= 0.0);
            prop_assert!((closest.normal.norm() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_closest_feature_is_where_the_point_is(mesh in any_body(), p in point()) {
        let surface = surface(&mesh);
        let closest = surface.closest(p);
        let corners = mesh.corners(closest.triangle as usize);
        match closest.feature {
            Feature::Vertex(i) => prop_assert_eq!(corners[i as usize], closest.point),
            Feature::Edge(i) => {
                let (a, b) = (corners[i as usize], corners[(i as usize + 1) % 3]);
                let off = (closest.point - a).cross(&(b - a)).norm() / (b - a).norm();
                prop_assert!(off < 1e-14);
            }
            Feature::Face => {
                let off = (closest.point - corners[0]).dot(&surface.normal(closest.triangle));
                prop_assert!(off.abs() < 1e-14);
            }
        }
        let reach = closest.distance.abs();
        prop_assert_eq!(surface.closest_within(p, reach * 1.0001), Some(closest));
        prop_assert_eq!(surface.closest_within(p, reach * 0.9999), None);
    }

    #[test]
    fn segments_and_rows_agree_with_points(
        mesh in any_body(),
        ends in proptest::collection::vec((point(), point()), 20),
    ) {
        let surface = surface(&mesh);
        for (from, to) in ends {
            check_segment(&surface, from, to)?;
            if let Some(crossing) = surface.first_crossing(from, to) {
                // Nothing before it: a little less of the segment meets nothing.
                let t = 0.999 * crossing.fraction;
                let short = std::array::from_fn(|k| from[k] + t * (to[k] - from[k]));
                prop_assert_eq!(surface.first_crossing(from, short), None);
            }
            let row = Row { start: from, step: Vec3::from_fn(|k, _| (to[k] - from[k]) / 37.0) };
            check_row(&surface, &row, 41)?;
        }
    }

    #[test]
    fn segments_through_corners_and_edges_agree_with_points(
        mesh in any_body(),
        pick in proptest::collection::vec((any::<u32>(), any::<u32>(), 0.0..=1.0f64), 20),
    ) {
        let surface = surface(&mesh);
        let n = mesh.vertices.len() as u32;
        for (a, b, t) in pick {
            // From one vertex towards and past another, in halves and multiples.
            let (a, b) = (mesh.vertices[(a % n) as usize], mesh.vertices[(b % n) as usize]);
            let at = |s: f64| -> Vec3 { Vec3::from_fn(|k, _| a[k] + s * (b[k] - a[k])) };
            for (from, to) in [(a, b), (at(-1.0), at(2.0)), (at(0.5), at(3.0)), (at(t), at(4.0 * t))] {
                check_segment(&surface, from, to)?;
                check_segment(&surface, to, from)?;
            }
            check_row(&surface, &Row { start: at(-1.0), step: (at(0.125) - a) }, 33)?;
        }
    }

    #[test]
    fn every_point_of_a_lattice_in_line_with_the_surface_is_right(stairs in stairs()) {
        let (mesh, _) = mend(stairs.mesh()).unwrap();
        let surface = surface(&mesh);
        prop_assert!((mesh.moments().volume - stairs.volume()).abs() < 1e-12);
        let mut scratch = RowScratch::default();
        // Points at cubes' corners, on edges and sides, and in their middles.
        let n = 14i32;
        for axis in 0..3 {
            for i in 0..n {
                for j in 0..n {
                    let mut start = [-0.5; 3];
                    start[(axis + 1) % 3] += 0.5 * f64::from(i);
                    start[(axis + 2) % 3] += 0.5 * f64::from(j);
                    let step = Vec3::ith(axis, 0.5);
                    let row = Row { start: start.into(), step };
                    let mut filled = vec![false; n as usize];
                    surface.fill_row(&row, &mut filled, &mut scratch);
                    for (k, &inside) in filled.iter().enumerate() {
                        let p = row.point(k);
                        prop_assert_eq!(inside, stairs.contains(p), "{:?}", p);
                        prop_assert_eq!(surface.contains(p), inside);
                        let distance = surface.signed_distance(p);
                        // Half a step is the least distance that a point off the surface can have.
                        let on = inside && !all_around_full(&stairs, p);
                        prop_assert_eq!(distance == 0.0, on, "{:?} {}", p, distance);
                    }
                }
            }
        }
    }

    #[test]
    fn lattice_links_between_points_in_line_with_the_surface_cross_it(
        stairs in stairs(),
        links in proptest::collection::vec(
            (proptest::array::uniform3(-1i32..12), proptest::array::uniform3(-2i32..=2)), 60),
    ) {
        let surface = surface(&mend(stairs.mesh()).unwrap().0);
        for (at, link) in links {
            let from = at.map(|i| 0.5 * f64::from(i));
            let to: Vec3 = Vec3::from_fn(|k, _| from[k] + 0.5 * f64::from(link[k]));
            check_segment(&surface, from.into(), to)?;
            let crossing = surface.first_crossing(from, to);
            if !stairs.contains(from.into()) && stairs.contains(to) {
                // All of it in exact numbers: the first point in the solid is a half or a whole.
                let first = (1..=12).map(|i| f64::from(i) / 12.0).find(|&t| {
                    let q = 12.0;
                    let p: Vec3 = Vec3::from_fn(|k, _| {
                        ((from[k] + t * (to[k] - from[k])) * q).round() / q
                    });
                    stairs.contains(p)
                });
                let found = crossing.unwrap().fraction;
                prop_assert!(found <= first.unwrap() + 1e-15, "{found} {first:?}");
                prop_assert!(found > first.unwrap() - 1.0 / 12.0, "{found} {first:?}");
            }
        }
    }

    #[test]
    fn triangles_near_a_box_are_those_whose_boxes_meet_it(
        mesh in any_body(), a in point(), b in point(),
    ) {
        let surface = surface(&mesh);
        let bounds = Bounds::of([a, b]);
        let mut near = vec![7; 3];
        surface.triangles_near(&bounds, &mut near);
        let expected: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&t| Bounds::of(mesh.corners(t as usize)).meets(&bounds))
            .collect();
        prop_assert_eq!(near, expected);
    }
}

/// True if all cubes at a point are full.
fn all_around_full(stairs: &Stairs, p: Vec3) -> bool {
    let cells = p.map(|x| [(x - 0.25).floor() as i32, (x + 0.25).floor() as i32]);
    (0..8).all(|i| stairs.full([cells[0][i & 1], cells[1][i >> 1 & 1], cells[2][i >> 2]]))
}

#[test]
fn a_wall_thinner_than_a_link_is_not_missed() {
    let mut plate = cube(1.0);
    plate.vertices.iter_mut().for_each(|v| v[2] *= 1e-9);
    let surface = surface(&plate);
    let crossing = surface.first_crossing([0.1, 0.2, -0.5], [0.1, 0.2, 0.5]).unwrap();
    assert!((crossing.fraction - 0.5).abs() < 1e-9 && crossing.fraction < 0.5);
    assert!(!surface.contains([0.1, 0.2, 0.5]) && !surface.contains([0.1, 0.2, -0.5]));
}

#[test]
fn a_segment_that_starts_on_the_surface_crosses_it_at_once() {
    let surface = surface(&cube(2.0));
    for to in [[3.0, 0.1, 0.1], [0.0, 0.1, 0.1], [1.0, 0.5, 0.1], [1.0, 3.0, 0.1]] {
        let crossing = surface.first_crossing([1.0, 0.1, 0.1], to).unwrap();
        assert_eq!(crossing.fraction, 0.0, "{to:?}");
    }
    let grazing = surface.first_crossing([1.0, -3.0, 0.1], [1.0, 3.0, 0.1]).unwrap();
    assert!((grazing.fraction - 1.0 / 3.0).abs() < 1e-15);
    assert!(surface.first_crossing([1.0 + 1e-15, -3.0, 0.1], [1.0 + 1e-15, 3.0, 0.1]).is_none());
}

#[test]
fn points_that_are_none_do_no_harm() {
    let surface = surface(&cube(1.0));
    for bad in [[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0], [0.0, f64::NEG_INFINITY, f64::NAN]] {
        assert!(!surface.contains(bad));
        let _ = surface.closest(bad);
        let _ = surface.first_crossing([0.0; 3], bad);
        let _ = surface.first_crossing(bad, [0.0; 3]);
        let mut row = [true; 5];
        surface.fill_row(
            &Row { start: bad.into(), step: Vec3::from_element(0.1) },
            &mut row,
            &mut RowScratch::default(),
        );
        surface.fill_row(
            &Row { start: Vec3::zeros(), step: bad.into() },
            &mut row,
            &mut RowScratch::default(),
        );
        surface.triangles_near(&Bounds { min: bad.into(), max: bad.into() }, &mut Vec::new());
    }
    assert!(surface.closest([f64::NAN; 3]).distance.is_nan());
    assert!(surface.closest([1e300, 0.0, 0.0]).distance > 0.0);
    surface.fill_row(
        &Row { start: Vec3::zeros(), step: Vec3::from_element(1.0) },
        &mut [],
        &mut RowScratch::default(),
    );
}

#[test]
fn equal_meshes_give_equal_bits_in_any_order_of_triangles() {
    // Nothing about it is symmetric: no point has two closest ones.
    let radii: Vec<f64> = (0..86).map(|i| 0.4 + 0.6 * (f64::from(i) * 0.618).fract()).collect();
    let mesh = star(&radii);
    let mut turned = mesh.clone();
    turned.triangles.reverse();
    let (one, other) = (surface(&mesh), surface(&turned));
    for i in 0..500 {
        let p = [0.7, 0.3, 0.11].map(|x: f64| (x * f64::from(i)).fract() * 1.6 - 0.8);
        let (a, b) = (one.closest(p), other.closest(p));
        assert_eq!((a.distance, a.point), (b.distance, b.point));
        assert_eq!(one.contains(p), other.contains(p));
    }
}
