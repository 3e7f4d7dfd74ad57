//! Sections that turn about an axis.

use tremie_geometry::{Mesh, Surface, Turned};
use tremie_messages::scene::{DeformableSurface, FacetKind, Pose, Section, SectionEdge};

/// A rectangle from radius `inner` to 2, of height 1; one that begins on the axis has no edge
/// there.
fn rectangle(inner: f64) -> Section {
    let edge = |points, kind| SectionEdge { points, kind };
    let mut edges = vec![edge([0, 1], FacetKind::Seat), edge([1, 2], FacetKind::Exposed)];
    if inner > 0.0 {
        edges.push(edge([3, 0], FacetKind::Exposed));
    }
    edges.push(edge([2, 3], FacetKind::Bonded));
    Section { points: vec![[inner, 0.0], [2.0, 0.0], [2.0, 1.0], [inner, 1.0]], edges }
}

fn surface(section: Section, sectors: u32) -> DeformableSurface {
    DeformableSurface {
        name: "seal".into(),
        carrier: "disc".into(),
        table: "seal.json".into(),
        pose: Pose::IDENTITY,
        sectors,
        material: "rubber".into(),
        seat_stiffness: 1e10,
        start: Default::default(),
        section,
    }
}

#[test]
fn rings_and_discs_are_closed_outward_and_have_their_volume() {
    let pi = std::f64::consts::PI;
    for (inner, exact) in [(1.0, 3.0 * pi), (0.0, 4.0 * pi)] {
        for sectors in [3, 12, 48] {
            let surface = surface(rectangle(inner), sectors);
            let turned = Turned::of(&surface);
            assert_eq!(turned.vertex_count(), surface.vertex_count());
            assert_eq!(turned.triangles.len(), surface.facet_count());
            let vertices = turned.places(&surface.section.points);
            // Refuses what is open or inward.
            let mesh =
                Surface::new(Mesh { vertices, triangles: turned.triangles.clone() }).unwrap();
            let volume = mesh.mesh().moments().volume;
            assert!((volume / exact - 1.0).abs() < 1e-12, "{inner} {sectors}: {volume}");
        }
    }
}

#[test]
fn facets_come_kind_by_kind_and_vertices_follow_their_points() {
    let section = rectangle(1.0);
    let turned = Turned::new(&section, 12);
    let count = |kind| turned.kinds.iter().filter(|k| **k == kind).count();
    assert_eq!([FacetKind::Seat, FacetKind::Exposed, FacetKind::Bonded].map(count), [24, 48, 24]);
    assert!(turned.kinds.is_sorted());
    let mut moved = section.points.clone();
    moved[1] = [2.5, 0.25];
    for vertex in 0..turned.vertex_count() {
        let [x, y, z] = turned.place(&moved, vertex).into();
        let [r, height] = moved[turned.section[vertex] as usize];
        assert_eq!(z, height);
        // The polygon's stretch: equal areas.
        let stretch = (std::f64::consts::PI / 6.0 / 0.5f64).sqrt();
        assert!(((x * x + y * y).sqrt() - stretch * r).abs() < 1e-12);
    }
}

#[test]
fn points_that_no_edge_names_make_no_vertices() {
    let mut section = rectangle(1.0);
    section.points.insert(4, [1.5, 0.5]);
    assert_eq!(Turned::new(&section, 6).vertex_count(), 24);
    assert_eq!(surface(section, 6).vertex_count(), 24);
}

/// A surface whose vertices were moved answers as one that was built there.
#[test]
fn a_reshaped_surface_is_the_one_built_anew() {
    let section = rectangle(1.0);
    let turned = Turned::new(&section, 24);
    let at = |points: &[[f64; 2]]| Mesh {
        vertices: turned.places(points),
        triangles: turned.triangles.clone(),
    };
    let mut surface = Surface::new(at(&section.points)).unwrap();
    let mut points = section.points.clone();
    (points[1], points[2]) = ([2.6, -0.4], [2.1, 0.7]);
    let moved = at(&points);
    surface.reshape(&moved.vertices);
    let anew = Surface::new(moved).unwrap();
    assert_eq!(surface.bounds(), anew.bounds());
    assert_eq!(surface.bounding_radius(), anew.bounding_radius());
    for triangle in 0..turned.triangles.len() as u32 {
        assert_eq!(surface.normal(triangle), anew.normal(triangle));
        assert_eq!(surface.edge_kinds(triangle), anew.edge_kinds(triangle));
    }
    let steps = || (-14..=14).map(|k| f64::from(k) * 0.2037);
    let (mut solid, mut before) = (0, [0.0; 3]);
    for x in steps() {
        for (y, z) in steps().zip(steps().skip(9).cycle()) {
            let point = [x, y, 0.4 * z];
            assert_eq!(surface.contains(point), anew.contains(point));
            assert_eq!(surface.closest(point), anew.closest(point));
            assert_eq!(surface.first_crossing(before, point), anew.first_crossing(before, point));
            solid += u32::from(surface.contains(point));
            before = point;
        }
    }
    assert!(solid > 50, "{solid}");
}
