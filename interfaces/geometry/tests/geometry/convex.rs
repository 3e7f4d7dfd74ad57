//! Convex polyhedra: faces, volumes and inertia of known solids, and points that make none.

use nalgebra::Matrix3;
use std::f64::consts::PI;
use tremie_geometry::{Convex, ConvexError, Mesh, SOLIDS, Vec3, principal, solid};

fn edge_one(name: &str) -> Convex {
    let any = Convex::hull(&solid(name).unwrap()).unwrap();
    let factor = 1.0 / any.longest_edge();
    let scaled: Vec<_> = any.vertices().iter().map(|v| v.map(|x| x * factor)).collect();
    Convex::hull(&scaled).unwrap()
}

/// Corners, faces, volume and moment of inertia over `m a^2` of the regular solids of edge 1
/// (Coxeter, *Regular Polytopes*; the moments follow from the integral of `r^2`).
#[test]
fn regular_solids_have_their_faces_volumes_and_inertia() {
    let s5 = 5f64.sqrt();
    for (name, corners, faces, volume, inertia) in [
        ("tetrahedron", 4, 4, 2f64.sqrt() / 12.0, 1.0 / 20.0),
        ("cube", 8, 6, 1.0, 1.0 / 6.0),
        ("octahedron", 6, 8, 2f64.sqrt() / 3.0, 1.0 / 10.0),
        ("dodecahedron", 20, 12, (15.0 + 7.0 * s5) / 4.0, (95.0 + 39.0 * s5) / 300.0),
        ("icosahedron", 12, 20, 5.0 * (3.0 + s5) / 12.0, (3.0 + s5) / 20.0),
    ] {
        let solid = edge_one(name);
        assert_eq!((solid.vertices().len(), solid.faces().len()), (corners, faces), "{name}");
        let moments = solid.moments();
        assert!((moments.volume / volume - 1.0).abs() < 1e-12, "{name}: {}", moments.volume);
        for i in 0..3 {
            for j in 0..3 {
                let expected = if i == j { inertia } else { 0.0 };
                let found = moments.inertia[(i, j)] / moments.volume;
                assert!((found - expected).abs() < 1e-12, "{name} {i}{j}: {found} {expected}");
            }
        }
        let edges = solid.edges().count();
        assert_eq!(corners + faces, edges + 2, "Euler: {name}");
    }
    assert_eq!(SOLIDS.len(), 5);
    assert!(solid("brick").is_none());
}

#[test]
fn a_unit_shape_is_as_large_as_a_sphere_of_diameter_one() {
    // A wedge far from the origin.
    let wedge = [
        [9.0, 0.0, 0.0],
        [11.0, 0.0, 0.0],
        [9.0, 3.0, 0.0],
        [9.0, 0.0, 1.0],
        [11.0, 0.0, 1.0],
        [9.0, 3.0, 1.0],
    ];
    let unit = Convex::hull(&wedge).unwrap().unit();
    let moments = unit.moments();
    assert!((moments.volume - PI / 6.0).abs() < 1e-14);
    assert!(moments.centroid.iter().all(|x| x.abs() < 1e-14));
    for face in unit.faces() {
        for &corner in &face.corners {
            let v = unit.vertices()[corner as usize];
            let height: f64 = (0..3).map(|a| v[a] * face.normal[a]).sum::<f64>() - face.offset;
            assert!(height.abs() < 1e-15, "{height}");
        }
        assert!(face.offset > 0.0);
    }
    assert!(unit.inradius() < 0.5 && unit.circumradius() > 0.5);
}

#[test]
fn points_on_faces_and_edges_are_no_corners() {
    let mut points = solid("cube").unwrap();
    let more = [[0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.3, -1.0, 0.2], [1.0, 1.0, 1.0]];
    points.extend(more);
    let cube = Convex::hull(&points).unwrap();
    assert_eq!((cube.vertices().len(), cube.faces().len()), (8, 6));
    assert!((cube.largest_face() - 4.0).abs() < 1e-14);
}

#[test]
fn what_is_no_convex_solid_is_refused() {
    let mut inside = solid("cube").unwrap();
    inside.push([0.2, 0.1, 0.9]);
    let refused = Convex::hull(&inside);
    assert!(matches!(refused, Err(ConvexError::Inside { vertex: 8, .. })), "{refused:?}");
    let flat: Vec<_> = solid("cube").unwrap().iter().map(|v| [v[0], v[1], 0.0]).collect();
    assert!(matches!(Convex::hull(&flat), Err(ConvexError::Flat { .. })));
    assert!(matches!(Convex::hull(&[[0.0; 3]; 9]), Err(ConvexError::Flat { .. })));
    let nan = [[0.0, f64::NAN, 0.0]; 4];
    assert_eq!(Convex::hull(&nan), Err(ConvexError::NotFinite { vertex: 0 }));
    let ball = |k: usize| {
        let z = -1.0 + (2 * k + 1) as f64 / 40.0;
        let (r, angle) = ((1.0 - z * z).sqrt(), 2.4 * k as f64);
        [r * angle.cos(), r * angle.sin(), z]
    };
    let many: Vec<_> = (0..40).map(ball).collect();
    assert_eq!(Convex::hull(&many), Err(ConvexError::TooManyFaces { found: 76, most: 60 }));
    // A prism of thirty sides is the largest; one more has two corners too many.
    let outline = |sides: u32| -> Vec<[f64; 2]> {
        let corner = |k: u32| (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
        (0..sides).map(|k| corner(k).into()).collect()
    };
    assert!(Convex::prism(&outline(30), 1, 1.0).is_ok());
    let error = Err(ConvexError::TooMany { found: 62, most: 60 });
    assert_eq!(Convex::prism(&outline(31), 1, 1.0), error);
    // All corners of a cube, and a pyramid cut out of one side: every vertex but one is a corner.
    let cube = Convex::hull(&solid("cube").unwrap()).unwrap();
    let same = Convex::of_mesh(&cube.mesh()).unwrap();
    assert_eq!((same.vertices(), same.faces().len()), (cube.vertices(), 6));
    let half = Mesh { triangles: cube.mesh().triangles[2..].to_vec(), ..cube.mesh() };
    assert!(matches!(Convex::of_mesh(&half), Err(ConvexError::NotConvex { .. })));
}

#[test]
fn principal_axes_diagonalise() {
    let matrix = Matrix3::new(4.0, 1.0, -0.5, 1.0, 3.0, 0.25, -0.5, 0.25, 5.0);
    let (values, axes) = principal(&matrix);
    for (value, axis) in values.iter().zip(axes) {
        assert!((matrix * axis - axis * *value).amax() < 1e-13);
    }
    let diagonal = Matrix3::from_diagonal(&Vec3::new(2.0, 3.0, 2.0));
    assert_eq!(principal(&diagonal), ([2.0, 3.0, 2.0], [Vec3::x(), Vec3::y(), Vec3::z()]));
}

/// The least width of a regular solid lies between two faces, that of the tetrahedron between two
/// edges; a flake's between its two sides.
#[test]
fn the_least_width_lies_between_faces_or_edges() {
    let s5 = 5f64.sqrt();
    for (name, width) in [
        ("tetrahedron", 0.5f64.sqrt()),
        ("cube", 1.0),
        ("octahedron", (2.0f64 / 3.0).sqrt()),
        ("dodecahedron", ((25.0 + 11.0 * s5) / 10.0).sqrt()),
        ("icosahedron", 3f64.sqrt() * (3.0 + s5) / 6.0),
    ] {
        let found = edge_one(name).least_width();
        assert!((found / width - 1.0).abs() < 1e-12, "{name}: {found} {width}");
    }
    let corner = |k: usize| Vec3::from_fn(|a, _| [3.0, 0.1, 2.0][a] * (k >> a & 1) as f64);
    let flake = Convex::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap();
    assert!((flake.least_width() / 0.1 - 1.0).abs() < 1e-12);
}
