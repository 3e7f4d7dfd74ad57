//! A surface beside parry3d's triangle mesh, on the same 102,400 triangles: build, closest points,
//! links, boxes, which triangles may cross, moments. One thread, in turns.
//!
//! `cargo bench -p tremie-geometry --bench beside_parry`. Parry rounds where this crate decides
//! exactly: of the links with exactly one end inside, it counts those on which parry finds no
//! crossing.

mod common;

use common::{scattered, timed, torus};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::mass_properties::MassProperties;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, Ray, RayCast};
use parry3d_f64::shape::TriMesh;
use tremie_geometry::{Bounds, Mesh, Surface, Vec3};

/// Edge of a lattice's link, and of a box [m].
const LINK: f64 = 0.02;

fn main() {
    let mesh = torus(320, 160);
    let (build, surface) = timed(|| Surface::new(mesh.clone()).expect("a closed ring"));
    let (theirs, parry) = timed(|| trimesh(&mesh));
    row("build", build, theirs, "ours with edges and normals");
    let points: Vec<Vec3> = (0..200_000).map(scattered).collect();
    closest(&surface, &parry, &points);
    links(&surface, &parry, &points);
    boxes(&surface, &parry, &points);
    crossing(&surface, &parry);
    moments(&mesh);
}

fn row(name: &str, ours: f64, theirs: f64, note: &str) {
    println!("{name:12} ours {:9.2} ms, parry {:9.2} ms: {note}", 1e3 * ours, 1e3 * theirs);
}

fn vector(v: Vec3) -> Vector {
    Vector::from_array(v.into())
}

fn trimesh(mesh: &Mesh) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|&v| vector(v)).collect();
    TriMesh::new(vertices, mesh.triangles.clone()).expect("triangles")
}

fn closest(surface: &Surface, parry: &TriMesh, points: &[Vec3]) {
    let (ours, near) =
        timed(|| points.iter().map(|&p| surface.closest(p).point).collect::<Vec<_>>());
    let project = |p: &Vec3| parry.project_local_point(vector(*p), false).point;
    let (theirs, far) = timed(|| points.iter().map(project).collect::<Vec<_>>());
    let off = |((p, a), b): ((&Vec3, &Vec3), &Vector)| {
        ((a - p).norm() - (Vec3::from(b.to_array()) - p).norm()).abs()
    };
    let most = points.iter().zip(&near).zip(&far).map(off).fold(0.0, f64::max);
    row(
        "closest",
        ours,
        theirs,
        &format!("200,000 points, distances differ by {most:.1e} at most"),
    );
}

fn links(surface: &Surface, parry: &TriMesh, points: &[Vec3]) {
    let end = |p: &Vec3| p.add_scalar(LINK);
    let found = |p: &&Vec3| surface.first_crossing(**p, end(p)).is_some();
    let (ours, count) = timed(|| points.iter().filter(found).count());
    let ray = |p: &Vec3| Ray::new(vector(*p), Vector::splat(LINK));
    let hit = |p: &&Vec3| parry.cast_local_ray(&ray(p), 1.0, false).is_some();
    let (theirs, hits) = timed(|| points.iter().filter(hit).count());
    let note = format!("200,000 links, {count} and {hits} crossings");
    row("links", ours, theirs, &note);
    println!("             {}", through_edges(surface, parry));
}

/// Links between cells that aim at edges and corners, as a lattice's do in a part that is in line
/// with it.
fn through_edges(surface: &Surface, parry: &TriMesh) -> String {
    let mesh = surface.mesh();
    let (mut all, mut missed) = (0, 0);
    for triangle in 0..mesh.triangles.len() {
        let [a, b, _] = mesh.corners(triangle);
        let normal = surface.normal(triangle as u32);
        let (from, to) = (a.lerp(&b, 0.5) + normal * LINK, a.lerp(&b, 0.5) - normal * LINK);
        if surface.contains(from) == surface.contains(to) {
            continue;
        }
        all += 1;
        assert!(surface.first_crossing(from, to).is_some(), "an exact predicate misses nothing");
        let ray = Ray::new(vector(from), vector(to - from));
        missed += usize::from(parry.cast_local_ray(&ray, 1.0, false).is_none());
    }
    format!(
        "of {all} links through edges with one end inside, parry misses {missed}, this crate none"
    )
}

fn boxes(surface: &Surface, parry: &TriMesh, points: &[Vec3]) {
    let mut near = Vec::new();
    let (ours, count) = timed(|| {
        let mut count = 0;
        for &p in points {
            surface.triangles_near(&Bounds { min: p, max: p.add_scalar(LINK) }, &mut near);
            count += near.len();
        }
        count
    });
    let (theirs, leaves) = timed(|| {
        let bounds = |p: &Vec3| Aabb::new(vector(*p), vector(p.add_scalar(LINK)));
        points.iter().map(|p| parry.bvh().intersect_aabb(&bounds(p)).count()).sum::<usize>()
    });
    row("boxes", ours, theirs, &format!("200,000 boxes, {count} and {leaves} triangles"));
}

fn crossing(surface: &Surface, parry: &TriMesh) {
    let (ours, found) = timed(|| surface.intersections());
    assert!(found.is_none());
    let bvh = parry.bvh();
    let (theirs, pairs) =
        timed(|| bvh.leaf_pairs(bvh, |a, b| a.intersects(b)).filter(|(a, b)| a < b).count());
    row("crossings", ours, theirs, &format!("ours decided exactly; {pairs} pairs to decide"));
}

fn moments(mesh: &Mesh) {
    let (ours, own) = timed(|| mesh.moments());
    let vertices: Vec<Vector> = mesh.vertices.iter().map(|&v| vector(v)).collect();
    let (theirs, other) = timed(|| MassProperties::from_trimesh(1.0, &vertices, &mesh.triangles));
    let inertia = other.reconstruct_inertia_matrix().to_cols_array();
    let off = own.inertia.iter().zip(inertia).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let scale = own.inertia.amax();
    let note = format!(
        "volumes differ by {:.1e}, inertia by {:.1e}",
        other.mass() / own.volume - 1.0,
        off / scale
    );
    row("moments", ours, theirs, &note);
}
