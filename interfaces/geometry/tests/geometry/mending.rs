//! Repairs, and refusals with their places.

use crate::bodies::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use tremie_geometry::{Bounds, EdgeKind, Fault, GeometryError, Mesh, Surface, mend};

fn faults(mesh: Mesh) -> Vec<Fault> {
    match mend(mesh) {
        Err(GeometryError::Faults(faults)) => faults,
        other => panic!("expected faults, found {other:?}"),
    }
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn triangles_turned_at_random_are_turned_back(
        mesh in any_body(),
        turn in proptest::collection::vec(any::<bool>(), 1..40),
    ) {
        let mut wrong = torn(&mesh);
        for (triangle, _) in wrong.triangles.iter_mut().zip(turn.iter().cycle()).filter(|(_, t)| **t) {
            triangle.swap(0, 1);
        }
        let (mended, repairs) = mend(wrong).unwrap();
        let (found, expected) = (mended.moments().volume, mesh.moments().volume);
        prop_assert!((found - expected).abs() < 1e-12, "{} {}", found, expected);
        prop_assert_eq!(repairs.welded, 3 * mesh.triangles.len() - mesh.vertices.len());
        let turned = turn.iter().cycle().take(mesh.triangles.len()).filter(|t| **t).count();
        prop_assert_eq!(repairs.turned, turned);
        Surface::new(mended).unwrap();
    }

    #[test]
    fn vertices_that_differ_by_single_precision_are_united(
        mesh in any_body(), noise in proptest::collection::vec(-1.0..1.0f64, 50),
    ) {
        let mut torn = torn(&mesh);
        for (x, n) in torn.vertices.iter_mut().flatten().zip(noise.iter().cycle()) {
            *x += 5e-8 * n;
        }
        let (mended, repairs) = mend(torn).unwrap();
        prop_assert_eq!(mended.vertices.len(), mesh.vertices.len());
        prop_assert!(repairs.tolerance > 0.0 && repairs.tolerance < 1e-6);
        prop_assert!((mended.moments().volume - mesh.moments().volume).abs() < 1e-6);
    }

    #[test]
    fn whatever_is_mended_has_an_inside(
        corners in proptest::collection::vec(proptest::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from), 7),
        solids in proptest::collection::btree_set(proptest::sample::subsequence((0..7u32).collect::<Vec<_>>(), 4), 1..9),
        points in proptest::collection::vec(point(), 20),
    ) {
        // Tetrahedra that may share sides, edges and corners, and cross: sides that two share go.
        let mut sides = BTreeSet::new();
        for t in &solids {
            for out in 0..4 {
                let mut side = t.clone();
                side.remove(out);
                if !sides.remove(&side) {
                    sides.insert(side);
                }
            }
        }
        let triangles = sides.iter().map(|s| [s[0], s[1], s[2]]).collect();
        let Ok((mended, _)) = mend(Mesh { vertices: corners, triangles }) else { return Ok(()) };
        let Ok(surface) = Surface::new(mended) else { return Ok(()) };
        for p in points {
            let winding = solid_angles(surface.mesh(), p);
            if (winding - winding.round()).abs() < 1e-6 && distance(surface.mesh(), p) > 1e-9 {
                prop_assert_eq!(surface.contains(p), winding > 0.5, "{:?} {}", p, winding);
            }
        }
    }

    #[test]
    fn any_triangles_are_mended_or_refused(
        triangles in proptest::collection::vec(proptest::array::uniform3(0u32..7), 0..30),
        corners in proptest::collection::vec(proptest::array::uniform3(-2i32..3), 6..8),
    ) {
        let vertices = corners.iter().map(|p| Vec3::from(p.map(f64::from))).collect();
        if let Ok((mended, _)) = mend(Mesh { vertices, triangles }) {
            let _ = Surface::new(mended).map(|surface| surface.intersections());
        }
    }
}

#[test]
fn a_missing_triangle_is_named_with_its_place() {
    let mut mesh = cube(2.0);
    mesh.triangles.remove(0);
    let found = faults(torn(&mesh));
    let [Fault::Open { edges: 3, holes: 1, first, hole }] = found[..] else { panic!("{found:?}") };
    assert!(first.iter().all(|p| p[2] == -1.0 || p[0] == -1.0));
    assert_eq!(hole, Bounds { min: Vec3::new(-1.0, -1.0, -1.0), max: Vec3::new(-1.0, 1.0, 1.0) });
    let text = GeometryError::Faults(found).problems("scene.parts[0].geometry")[0].to_string();
    assert!(
        text.starts_with(
            "scene.parts[0].geometry: the surface is not closed: 3 open edges in 1 hole"
        )
    );
    assert!(text.contains("(-1, -1, -1) m"), "{text}");
}

#[test]
fn holes_are_counted_and_crowded_edges_are_told_at_the_same_time() {
    let mut mesh = both(&cube(1.0), &moved(&cube(1.0), Vec3::new(5.0, 0.0, 0.0)));
    mesh.triangles.remove(23);
    mesh.triangles.remove(0);
    let extra = mesh.triangles[5];
    mesh.triangles.push(extra);
    let found = faults(mesh);
    assert!(matches!(found[0], Fault::Open { edges: 6, holes: 2, .. }), "{found:?}");
    assert!(matches!(found[1], Fault::Crowded { edges: 3, triangles: 3, .. }), "{found:?}");
}

#[test]
fn cubes_that_touch_along_an_edge_have_a_crowded_one() {
    let found = faults(both(&cube(1.0), &moved(&cube(1.0), Vec3::new(1.0, 1.0, 0.0))));
    let [Fault::Crowded { edges: 1, triangles: 4, first }] = found[..] else { panic!("{found:?}") };
    assert!(first.iter().all(|p| p[0] == 0.5 && p[1] == 0.5));
}

#[test]
fn a_surface_with_one_side_is_refused() {
    // The projective plane: an icosahedron with opposite points made one.
    let triangles = vec![
        [0, 2, 1],
        [0, 1, 3],
        [0, 4, 2],
        [0, 3, 5],
        [0, 5, 4],
        [1, 2, 5],
        [1, 4, 3],
        [1, 5, 4],
        [2, 4, 3],
        [2, 3, 5],
    ];
    let vertices = (0..6).map(|i| {
        let x = f64::from(i);
        Vec3::new(x, x * x, x * x * x)
    });
    let found = faults(Mesh { vertices: vertices.collect(), triangles });
    assert!(matches!(found[..], [Fault::OneSided { .. }]), "{found:?}");
}

#[test]
fn sheets_are_refused() {
    let mut sheet = cube(1.0);
    sheet.vertices.iter_mut().for_each(|v| v[1] = 0.25);
    // Pressed flat, opposite sides share all vertices: nothing but doubled triangles.
    assert!(matches!(faults(sheet)[..], [Fault::Crowded { .. }]));
    let pillow = Mesh {
        vertices: vec![
            Vec3::zeros(),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]],
    };
    assert!(matches!(faults(pillow)[..], [Fault::Flat { triangles: 4, .. }]));
}

#[test]
fn numbers_that_are_no_points_are_refused() {
    let mut mesh = cube(1.0);
    mesh.vertices[3][1] = f64::NAN;
    assert!(matches!(mend(mesh), Err(GeometryError::NotFinite { .. })));
    let mut mesh = cube(1.0);
    mesh.triangles[4][2] = 8;
    let error = mend(mesh.clone()).unwrap_err();
    assert_eq!(error, GeometryError::Index { triangle: 4, found: 8, vertices: 8 });
    assert_eq!(Surface::new(mesh).unwrap_err(), error);
    assert_eq!(mend(Mesh::default()), Err(GeometryError::Empty { found: 0 }));
    let point = Mesh { vertices: vec![Vec3::from_element(1.0); 3], triangles: vec![[0, 1, 2]] };
    assert_eq!(mend(point), Err(GeometryError::Empty { found: 1 }));
}

#[test]
fn shells_in_shells_are_solid_and_hollow_by_turns() {
    let nest = both(&both(&cube(1.0), &cube(3.0)), &cube(2.0));
    let (mesh, repairs) = mend(nest).unwrap();
    assert_eq!(repairs.shells, 3);
    near(mesh.moments().volume, 27.0 - 8.0 + 1.0, 1e-13);
    let surface = Surface::new(mesh).unwrap();
    let solid = |x: f64| surface.contains([x, 0.1, 0.2]);
    assert!(solid(0.4) && !solid(0.7) && solid(1.2) && !solid(1.6));
    // In the hollow the normal points away from the solid, towards the hollow's middle.
    let closest = surface.closest([0.9, 0.1, 0.2]);
    near(closest.distance, 0.1, 1e-15);
    assert_eq!(closest.normal, -Vec3::x());
}

#[test]
fn a_hollow_that_touches_its_shell_from_within_is_a_hollow() {
    let mut inner = tetrahedron();
    // One corner of it is in the middle of a side of the cube.
    inner.vertices.iter_mut().for_each(|v| v[2] = 1.0 - v[2]);
    let (mesh, _) = mend(both(&cube(4.0), &moved(&inner, Vec3::new(0.0, 0.0, 1.0)))).unwrap();
    near(mesh.moments().volume, 64.0 - 1.0 / 6.0, 1e-12);
}

#[test]
fn solids_that_overlap_are_one() {
    let (mesh, repairs) =
        mend(both(&cube(2.0), &moved(&cube(2.0), Vec3::new(1.0, 0.5, 0.25)))).unwrap();
    assert_eq!((repairs.shells, repairs.turned), (2, 0));
    let surface = Surface::new(mesh).unwrap();
    for p in [[-0.9, 0.0, 0.0], [0.5, 0.2, 0.3], [1.9, 1.4, 1.2], [1.0, 0.0, 0.0]] {
        assert!(surface.contains(p), "{p:?}");
    }
    assert!(!surface.contains([1.5, -0.9, 0.0]));
    let crossed = surface.intersections().unwrap();
    assert!(crossed.pairs > 0 && surface.bounds().contains(crossed.near));
}

#[test]
fn bodies_that_only_share_corners_and_edges_with_themselves_do_not_intersect() {
    for mesh in [cube(1.0), tetrahedron(), torus(0.5, 0.2, 12, 9), star(&[0.3, 0.9, 0.5, 0.7, 1.0])]
    {
        assert_eq!(Surface::new(mesh).unwrap().intersections(), None);
    }
}

#[test]
fn a_corner_pushed_through_the_far_side_is_found() {
    let mut mesh = cube(1.0);
    mesh.vertices[0] = Vec3::new(0.9, 0.1, 0.1);
    let crossed = Surface::new(mesh).unwrap().intersections().unwrap();
    assert!(crossed.pairs >= 1 && (crossed.near[0] - 0.5).abs() < 0.51, "{crossed:?}");
}

/// A cube with `n` vertices on one edge, joined on one side by triangles without height.
fn cube_with_caps(n: u32) -> Mesh {
    let mut mesh = cube(2.0);
    let on_edge = |t: &[u32; 3]| (0..3).find(|&i| [t[i], t[(i + 1) % 3]] == [0, 1]);
    let (split, i) =
        mesh.triangles.iter().enumerate().find_map(|(k, t)| Some((k, on_edge(t)?))).unwrap();
    let tip = mesh.triangles[split][(i + 2) % 3];
    let mut line = vec![0];
    for k in 1..=n {
        line.push(mesh.vertices.len() as u32);
        mesh.vertices.push(Vec3::new(2.0 * f64::from(k) / f64::from(n + 1) - 1.0, -1.0, -1.0));
    }
    line.push(1);
    mesh.triangles.remove(split);
    mesh.triangles.extend(line.windows(2).map(|w| [w[0], w[1], tip]));
    mesh.triangles.extend(line[1..].windows(2).map(|w| [0, w[1], w[0]]));
    mesh
}

#[test]
fn triangles_whose_corners_are_in_line_give_their_edges_to_their_neighbours() {
    for n in [1, 2, 7, 100] {
        let (mended, repairs) = mend(cube_with_caps(n)).unwrap();
        assert_eq!(repairs.flipped, n as usize);
        near(mended.moments().volume, 8.0, 1e-13);
        let surface = Surface::new(mended).unwrap();
        let all = 0..surface.mesh().triangles.len() as u32;
        assert!(all.clone().all(|t| surface.normal(t).norm() > 0.99));
        let convex = all.flat_map(|t| surface.edge_kinds(t)).filter(|&k| k == EdgeKind::Convex);
        assert_eq!(convex.count(), 24 + 2 * n as usize);
        assert_eq!(surface.intersections(), None);
    }
}

#[test]
fn a_low_triangle_that_nothing_can_raise_stays() {
    let mut mesh = tetrahedron();
    // The other diagonal of any two of its sides is an edge already.
    mesh.vertices[3] = Vec3::new(0.5, 1e-8, 1e-8);
    let (mended, repairs) = mend(mesh.clone()).unwrap();
    assert_eq!((repairs.flipped, mended.triangles), (0, mesh.triangles));
}

#[test]
fn a_surface_takes_no_mesh_that_needs_mending() {
    let mut wound = cube(1.0);
    wound.triangles[3].swap(0, 1);
    let error = Surface::new(wound).unwrap_err();
    assert!(
        matches!(&error, GeometryError::Faults(f) if matches!(f[..], [Fault::Winding { edges: 3, .. }]))
    );
    let mut inward = cube(1.0);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let error = Surface::new(inward.clone()).unwrap_err();
    assert!(matches!(&error, GeometryError::Faults(f) if matches!(f[..], [Fault::Inward { .. }])));
    let (mended, repairs) = mend(inward).unwrap();
    assert_eq!(repairs.turned, 12);
    assert_eq!(mended.moments().volume, 1.0);
    assert_eq!(repairs.to_string(), "12 triangles turned round");
    assert!(Surface::new(torn(&cube(1.0))).is_err());
}
