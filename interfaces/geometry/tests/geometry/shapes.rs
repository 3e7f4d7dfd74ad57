//! Primitive shapes against formulas.

use std::f64::consts::PI;
use tremie_geometry::{EdgeKind, GeometryError, Mesh, Surface, Vec3, VertexKind};
use tremie_messages::scene::{Geometry, Pose};

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected}");
}

fn distance_from_axis(p: &Vec3) -> f64 {
    p[0].hypot(p[1])
}

#[test]
fn a_box_has_its_volume_area_and_inertia() {
    let [a, b, c] = [0.02, 0.03, 0.05];
    let mesh = Mesh::of(&Geometry::Box { size: [a, b, c] }).unwrap();
    let moments = mesh.moments();
    near(moments.volume, a * b * c, 1e-15 * a * b * c);
    near(moments.area, 2.0 * (a * b + b * c + c * a), 1e-17);
    let expected = [b * b + c * c, a * a + c * c, a * a + b * b].map(|s| a * b * c * s / 12.0);
    for i in 0..3 {
        near(moments.centroid[i], 0.0, 1e-17);
        for j in 0..3 {
            let inertia = if i == j { expected[i] } else { 0.0 };
            near(moments.inertia[(i, j)], inertia, 1e-14 * expected[i]);
        }
    }
    assert_eq!(mesh.bounds().max, Vec3::new(0.01, 0.015, 0.025));
    near(mesh.bounding_radius(), 0.5 * (a * a + b * b + c * c).sqrt(), 1e-17);
}

#[test]
fn a_cylinder_has_the_volume_of_the_round_one() {
    let (radius, length) = (0.004, 0.011);
    let mesh = Mesh::of(&Geometry::Cylinder { radius, length }).unwrap();
    let moments = mesh.moments();
    let volume = PI * radius * radius * length;
    near(moments.volume, volume, 1e-13 * volume);
    near(moments.area, 2.0 * PI * radius * (radius + length), 3e-5 * moments.area);
    near(moments.inertia[(2, 2)], 0.5 * volume * radius * radius, 1e-7 * volume * radius * radius);
    let across = volume * (3.0 * radius * radius + length * length) / 12.0;
    near(moments.inertia[(0, 0)], across, 1e-7 * across);
    let surface = Surface::new(mesh).unwrap();
    // The stated deviation from the radius, at corners and at the middles of sides.
    let corner = distance_from_axis(&surface.mesh().vertices[0]) / radius - 1.0;
    assert!(corner > 5.0e-5 && corner < 5.1e-5, "{corner:e}");
    let half = PI / 256.0;
    let middle = surface.signed_distance([radius * half.cos(), radius * half.sin(), 0.0]) / radius;
    assert!(middle > 2.5e-5 && middle < 2.6e-5, "{middle:e}");
}

#[test]
fn a_sphere_has_the_volume_of_the_round_one() {
    let radius = 0.003;
    let surface = Surface::of(&Geometry::Sphere { radius }).unwrap();
    let moments = surface.mesh().moments();
    let volume = 4.0 / 3.0 * PI * radius.powi(3);
    near(moments.volume, volume, 1e-13 * volume);
    near(moments.area, 4.0 * PI * radius * radius, 2e-4 * moments.area);
    for i in 0..3 {
        near(
            moments.inertia[(i, i)],
            0.4 * volume * radius * radius,
            1e-4 * moments.inertia[(i, i)],
        );
    }
    let out = surface.bounding_radius() / radius - 1.0;
    let deepest = (0..surface.mesh().triangles.len())
        .map(|t| {
            let [a, b, c] = surface.mesh().corners(t);
            let middle: Vec3 = Vec3::from_fn(|k, _| (a[k] + b[k] + c[k]) / 3.0);
            middle.iter().map(|x| x * x).sum::<f64>().sqrt() / radius
        })
        .fold(f64::INFINITY, f64::min);
    let ranges = (1.7e-4..1.9e-4).contains(&out) && (1.0e-4..1.1e-4).contains(&(1.0 - deepest));
    assert!(ranges, "{out:e}, {:e}", 1.0 - deepest);
}

#[test]
fn a_placed_mesh_keeps_its_volume_and_moves_its_centroid() {
    let mesh = Mesh::of(&Geometry::Box { size: [1.0, 2.0, 3.0] }).unwrap();
    let pose = Pose { position: [5.0, -1.0, 2.0], orientation: [0.5, 0.5, 0.5, 0.5] };
    let moments = mesh.placed(&pose).moments();
    near(moments.volume, 6.0, 1e-13);
    for k in 0..3 {
        near(moments.centroid[k], pose.position[k], 1e-14);
        // That turn takes x to y, y to z, z to x.
        near(moments.inertia[(k, k)], mesh.moments().inertia[((k + 2) % 3, (k + 2) % 3)], 1e-13);
    }
}

#[test]
fn shapes_without_size_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let shapes = [
            Geometry::Box { size: [1.0, bad, 1.0] },
            Geometry::Cylinder { radius: bad, length: 1.0 },
            Geometry::Cylinder { radius: 1.0, length: bad },
            Geometry::Sphere { radius: bad },
        ];
        for shape in shapes {
            let error = Mesh::of(&shape).unwrap_err();
            assert!(matches!(error, GeometryError::Length { .. }), "{error}");
        }
    }
}

#[test]
fn diagonals_of_a_box_are_no_edges_and_its_corners_are() {
    let surface = Surface::of(&Geometry::Box { size: [1.0, 2.0, 3.0] }).unwrap();
    let kinds: Vec<EdgeKind> = (0..12).flat_map(|t| surface.edge_kinds(t)).collect();
    assert_eq!(kinds.iter().filter(|&&k| k == EdgeKind::Convex).count(), 24);
    assert_eq!(kinds.iter().filter(|&&k| k == EdgeKind::Flat).count(), 12);
    assert!((0..8).all(|v| surface.vertex_kind(v) == VertexKind::Corner));
    for t in 0..12 {
        for (i, n) in surface.neighbours(t).into_iter().enumerate() {
            assert!(surface.neighbours(n).contains(&t));
            let kind = surface.edge_kinds(t)[i];
            let same_side = surface.normal(t) == surface.normal(n);
            assert_eq!(same_side, kind == EdgeKind::Flat);
        }
    }
}

/// A cone frustum with a bore: volume and centre by formula; and the same as a shape on the axis.
#[test]
fn a_turned_profile_has_the_volume_of_the_round_solid() {
    let (a, b, bore, height) = (4.75e-3, 6.5e-3, 2e-3, 0.991e-3);
    let frustum = PI * height / 3.0 * (a * a + a * b + b * b);
    let solid = |profile: &[[f64; 2]]| Geometry::Revolved { profile: profile.to_vec() };
    let whole = solid(&[[0.0, 0.0], [a, 0.0], [b, height], [0.0, height]]);
    let ring = solid(&[[bore, 0.0], [a, 0.0], [b, height], [bore, height]]);
    for (geometry, volume) in [(whole, frustum), (ring, frustum - PI * bore * bore * height)] {
        let surface = Surface::of(&geometry).unwrap();
        let moments = surface.mesh().moments();
        near(moments.volume, volume, 1e-13 * frustum);
        near(moments.centroid[0], 0.0, 1e-16);
        assert!(surface.contains([0.5 * (bore + a), 0.0, 0.5 * height]));
    }
    let why = |profile: &[[f64; 2]]| Mesh::of(&solid(profile)).unwrap_err().to_string();
    assert!(why(&[[0.0, 0.0], [1.0, 0.0]]).contains("three or more"));
    assert!(why(&[[1.0, 0.0], [-1.0, 0.0], [1.0, 1.0]]).contains("less than zero"));
    assert!(why(&[[1.0, 0.0], [0.0, 0.0], [1.0, 1.0]]).contains("on the axis"));
    assert!(why(&[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, 0.0]]).contains("are both at"));
}

/// A prism of an L along each axis: volume, place, and what is inside.
#[test]
fn an_outline_is_drawn_out_along_an_axis() {
    let outline = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    for (axis, [u, v]) in [(0, [1, 2]), (1, [0, 2]), (2, [0, 1])] {
        for turned in [false, true] {
            let mut outline = outline.clone();
            if turned {
                outline.reverse();
            }
            let surface = Surface::of(&Geometry::Extruded { outline, axis, length: 5.0 }).unwrap();
            let moments = surface.mesh().moments();
            near(moments.volume, 20.0, 1e-13);
            near(moments.area, 2.0 * 4.0 + 10.0 * 5.0, 1e-12);
            let point = |along: f64, a: f64, b: f64| {
                let mut x = [0.0; 3];
                (x[axis], x[u], x[v]) = (along, a, b);
                x
            };
            let has = |along, a, b| surface.contains(point(along, a, b));
            assert!(has(2.4, 2.9, 0.5) && has(-2.4, 0.5, 1.9), "{axis}");
            assert!(!has(2.6, 0.5, 0.5) && !has(0.0, 2.0, 1.5) && !has(0.0, -0.1, 0.5), "{axis}");
        }
    }
    let why = |outline: &[[f64; 2]], length: f64| {
        let outline = outline.to_vec();
        Mesh::of(&Geometry::Extruded { outline, axis: 2, length }).unwrap_err().to_string()
    };
    assert!(why(&[[0.0, 0.0], [1.0, 0.0]], 1.0).contains("three or more"));
    assert!(why(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.0).contains("length of the prism"));
    assert!(why(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]], 1.0).contains("no point"));
    assert!(why(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 1.0).contains("both at"));
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert!(why(&bow, 1.0).contains("corners 0 and 2 meet"));
    let spike = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert!(why(&spike, 1.0).contains("meet"));
    let pinched = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]];
    assert!(why(&pinched, 1.0).contains("meet"));
}
