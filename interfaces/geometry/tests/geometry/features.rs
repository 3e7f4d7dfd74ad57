//! Edges and corners that are real.

use crate::bodies::*;
use tremie_geometry::{EdgeKind, Surface, VertexKind, mend};
use tremie_messages::scene::Geometry;

fn count(surface: &Surface, kind: EdgeKind) -> usize {
    let all = (0..surface.mesh().triangles.len() as u32).flat_map(|t| surface.edge_kinds(t));
    // Each edge belongs to two triangles.
    all.filter(|&k| k == kind).count() / 2
}

fn kind_at(surface: &Surface, place: Vec3) -> VertexKind {
    let vertex = surface.mesh().vertices.iter().position(|&v| v == place).unwrap();
    surface.vertex_kind(vertex as u32)
}

#[test]
fn a_step_has_a_groove() {
    let mut heights = [[1; 4]; 4];
    heights[0] = [2; 4];
    heights[1] = [2; 4];
    let (mesh, _) = mend(Stairs(heights).mesh()).unwrap();
    let surface = Surface::new(mesh).unwrap();
    // The groove is four squares long. An L has 2 x (2 + 4 + 1 + 2 + 2 + 1) unit edges less the
    // groove's two ends, and five more lines of four.
    assert_eq!(count(&surface, EdgeKind::Concave), 4);
    assert_eq!(count(&surface, EdgeKind::Convex), 2 * 12 + 5 * 4);
    assert_eq!(kind_at(&surface, Vec3::new(2.0, 2.0, 1.0)), VertexKind::Ridge);
    assert_eq!(kind_at(&surface, Vec3::new(2.0, 0.0, 1.0)), VertexKind::Corner);
    assert_eq!(kind_at(&surface, Vec3::new(3.0, 2.0, 1.0)), VertexKind::Flat);
    assert_eq!(kind_at(&surface, Vec3::new(0.0, 1.0, 2.0)), VertexKind::Ridge);
    assert_eq!(kind_at(&surface, Vec3::new(0.0, 0.0, 0.0)), VertexKind::Corner);
}

#[test]
fn a_cylinder_is_convex_all_around_and_its_roofs_are_flat() {
    let surface = Surface::of(&Geometry::Cylinder { radius: 1.0, length: 3.0 }).unwrap();
    // Two rims and the sides' edges; flat: the roofs' spokes and the sides' diagonals.
    assert_eq!(count(&surface, EdgeKind::Convex), 3 * 256);
    assert_eq!(count(&surface, EdgeKind::Flat), 3 * 256);
    assert_eq!(count(&surface, EdgeKind::Concave), 0);
    assert_eq!(kind_at(&surface, Vec3::new(0.0, 0.0, 1.5)), VertexKind::Flat);
    assert_eq!(surface.vertex_kind(0), VertexKind::Corner);
}

#[test]
fn the_inside_of_a_ring_is_concave_along_it() {
    let surface = Surface::new(torus(1.0, 0.3, 40, 24)).unwrap();
    let inner = surface.closest([0.69, 0.0, 0.0]);
    assert!(inner.normal[0] < -0.99);
    assert!(count(&surface, EdgeKind::Concave) > 100);
    assert!(count(&surface, EdgeKind::Convex) > 1000);
}

#[test]
fn a_wall_in_single_precision_is_flat() {
    // A plate of a thousand squares, tilted, rounded as an STL file rounds it.
    let (sin, cos) = libm::sincos(0.3);
    let mut plate = cube(1.0);
    plate.vertices.clear();
    plate.triangles.clear();
    let n = 32u32;
    let name = |i: u32, j: u32, k: u32| (k * (n + 1) + i) * (n + 1) + j;
    for k in 0..2 {
        for i in 0..=n {
            for j in 0..=n {
                let [x, y] = [i, j].map(|i| f64::from(i) / f64::from(n));
                let z = 0.1 * f64::from(k);
                let turned = [x * cos - z * sin, y, x * sin + z * cos];
                plate.vertices.push(turned.map(|x| f64::from(x as f32)).into());
            }
        }
    }
    for i in 0..n {
        for j in 0..n {
            let quad =
                |k| [name(i, j, k), name(i + 1, j, k), name(i + 1, j + 1, k), name(i, j + 1, k)];
            let [a, b, c, d] = quad(1);
            plate.triangles.extend([[a, b, c], [a, c, d]]);
            let [a, b, c, d] = quad(0);
            plate.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    for i in 0..n {
        for [x, y] in
            [[[i, 0], [i + 1, 0]], [[i + 1, n], [i, n]], [[0, i + 1], [0, i]], [[n, i], [n, i + 1]]]
        {
            let [a, b, c, d] = [
                name(x[0], x[1], 0),
                name(y[0], y[1], 0),
                name(y[0], y[1], 1),
                name(x[0], x[1], 1),
            ];
            plate.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let (mesh, repairs) = mend(plate).unwrap();
    assert_eq!((repairs.turned, repairs.flipped), (0, 0));
    let surface = Surface::new(mesh).unwrap();
    assert_eq!(count(&surface, EdgeKind::Concave), 0);
    assert_eq!(count(&surface, EdgeKind::Convex), 2 * 4 * n as usize + 4);
}
