//! Times of questions to a surface of 100,000 triangles.
//!
//! `cargo bench -p tremie-geometry`. Times depend on the machine; the ratios to asking
//! point by point, in the same run, much less.

mod common;

use common::{scattered, timed, torus};
use tremie_geometry::{Bounds, Mesh, Row, RowScratch, Surface, Vec3, mend};

fn main() {
    let mesh = torus(320, 160);
    let triangles = mesh.triangles.len();
    let (build, surface) = timed(|| Surface::new(mesh.clone()).expect("a closed ring"));
    println!("{triangles} triangles");
    println!("build                 {:9.1} ms", 1e3 * build);
    let (mending, _) = timed(|| mend(torn(&mesh)).expect("a closed ring"));
    println!("mend                  {:9.1} ms, all vertices apart", 1e3 * mending);
    let (crossed, found) = timed(|| surface.intersections());
    assert!(found.is_none());
    println!("intersections         {:9.1} ms", 1e3 * crossed);

    let n = 100;
    let (each, one_by_one) = timed(|| voxels_one_by_one(&surface, n));
    let (rows, filled) = timed(|| voxels_by_rows(&surface, n, Vec3::x(), Vec3::y()));
    assert_eq!(one_by_one, filled);
    println!(
        "contains              {:9.1} ms for {} points, {} in the solid",
        1e3 * each,
        n * n * n,
        filled
    );
    println!("fill_row              {:9.1} ms, {:.3} of contains", 1e3 * rows, rows / each);
    let (axis, across) = (Vec3::new(0.6, 0.64, 0.48), Vec3::new(-0.8, 0.48, 0.36));
    let (oblique, _) = timed(|| voxels_by_rows(&surface, n, axis, across));
    println!("fill_row, turned      {:9.1} ms, {:.3} of contains", 1e3 * oblique, oblique / each);

    let points: Vec<Vec3> = (0..200_000).map(scattered).collect();
    let per = |time: f64| 1e6 * time / points.len() as f64;
    let (contains, _) = timed(|| points.iter().filter(|&&p| surface.contains(p)).count());
    println!("contains, scattered   {:9.3} us each", per(contains));
    let (closest, _) = timed(|| points.iter().map(|&p| surface.signed_distance(p)).sum::<f64>());
    println!(
        "signed_distance       {:9.3} us each, {:.1} of contains",
        per(closest),
        closest / contains
    );
    let (beside, _) = timed(|| {
        let row = |j: usize| {
            (0..400).map(move |i| [i as f64 / 300.0 - 0.7, j as f64 / 500.0 - 0.5, 0.05])
        };
        (0..500).flat_map(row).map(|p| surface.signed_distance(p)).sum::<f64>()
    });
    println!(
        "signed_distance, rows {:9.3} us each, {:.1} of contains",
        per(beside),
        beside / contains
    );
    let link = |p: &Vec3| surface.first_crossing(*p, p.map(|x| x + 0.02));
    let (links, crossings) = timed(|| points.iter().filter_map(link).count());
    println!(
        "first_crossing        {:9.3} us each, {:.1} of contains, {crossings} crossings",
        per(links),
        links / contains
    );
    let mut near = Vec::new();
    let (boxes, met) = timed(|| {
        let mut met = 0;
        for &p in &points {
            surface.triangles_near(&Bounds { min: p, max: p.map(|x| x + 0.02) }, &mut near);
            met += near.len();
        }
        met
    });
    println!(
        "triangles_near        {:9.3} us each, {:.1} of contains, {met} triangles",
        per(boxes),
        boxes / contains
    );
}

fn voxels_one_by_one(surface: &Surface, n: usize) -> usize {
    rows(n, Vec3::x(), Vec3::y())
        .map(|row| (0..n).filter(|&i| surface.contains(row.point(i))).count())
        .sum()
}

fn voxels_by_rows(surface: &Surface, n: usize, along: Vec3, across: Vec3) -> usize {
    let mut scratch = RowScratch::default();
    let mut inside = vec![false; n];
    rows(n, along, across)
        .map(|row| {
            surface.fill_row(&row, &mut inside, &mut scratch);
            inside.iter().filter(|&&x| x).count()
        })
        .sum()
}

/// Rows of a cube of `n` points a side about the origin, its edges 1.5 long.
fn rows(n: usize, u: Vec3, v: Vec3) -> impl Iterator<Item = Row> {
    let w = u.cross(&v);
    let step = 1.5 / n as f64;
    let at = move |i: usize| (i as f64 + 0.5) * step - 0.75;
    let start = move |j, k| u * at(0) + v * at(j) + w * at(k);
    let row = move |j, k| Row { start: start(j, k), step: u * step };
    (0..n).flat_map(move |k| (0..n).map(move |j| row(j, k)))
}

fn torn(mesh: &Mesh) -> Mesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Mesh { vertices, triangles: triangles.collect() }
}
