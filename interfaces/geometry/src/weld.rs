//! Vertices that are meant to be one.
//!
//! An STL file repeats every vertex in each of its triangles. Exporters write them equal, or round
//! each for itself; the second are united only where the first do not make a closed surface.

use crate::edges::Sets;
use crate::{Mesh, Vec3};

/// Unites equal vertices, and drops vertices that no triangle uses. Returns how many were united.
pub fn weld_equal(mesh: &mut Mesh) -> usize {
    // Adding zero makes the two zeros one.
    mesh.vertices.iter_mut().flatten().for_each(|x| *x += 0.0);
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let bits = |v: u32| -> [u64; 3] { mesh.vertices[v as usize].map(f64::to_bits).into() };
    order.sort_unstable_by_key(|&v| (bits(v), v));
    let mut first = vec![0; mesh.vertices.len()];
    for same in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
        same.iter().for_each(|&v| first[v as usize] = same[0]);
    }
    rename(mesh, |v| first[v as usize])
}

/// Unites vertices nearer to each other than `tolerance` [m], also along chains of such, at the
/// place of the first. Returns how many were united.
pub fn weld_near(mesh: &mut Mesh, tolerance: f64) -> usize {
    let cells = Cells::new(&mesh.vertices, tolerance);
    let mut sets = Sets::new(mesh.vertices.len());
    for (v, &point) in mesh.vertices.iter().enumerate() {
        cells.each_near(point, |w| {
            let near = (point - mesh.vertices[w as usize]).norm_squared() <= tolerance * tolerance;
            if (w as usize) < v && near {
                sets.unite(w, v as u32);
            }
        });
    }
    rename(mesh, |v| sets.root(v))
}

/// Drops triangles that name a vertex twice. Returns how many.
pub fn drop_collapsed(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    before - mesh.triangles.len()
}

/// Gives each used vertex the name of its representative, and numbers those that remain in their
/// old order. Returns how many used vertices became another.
fn rename(mesh: &mut Mesh, mut representative: impl FnMut(u32) -> u32) -> usize {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut kept = vec![false; mesh.vertices.len()];
    for triangle in &mut mesh.triangles {
        *triangle = triangle.map(&mut representative);
        triangle.iter().for_each(|&v| kept[v as usize] = true);
    }
    let mut number = Vec::with_capacity(kept.len());
    let mut count = 0;
    for &keep in &kept {
        number.push(count);
        count += u32::from(keep);
    }
    let mut keep = kept.iter();
    mesh.vertices.retain(|_| *keep.next().expect("one mark for each vertex"));
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
    used.iter().filter(|&&u| u).count() - mesh.vertices.len()
}

/// Vertices sorted by the cell of a coarse grid that they are in.
struct Cells {
    sorted: Vec<([i64; 3], u32)>,
    tolerance: f64,
}

/// Cells are this many tolerances wide, so that a vertex rarely has to look into a second one.
const CELL: f64 = 32.0;

impl Cells {
    fn new(points: &[Vec3], tolerance: f64) -> Self {
        let cell = |p: &Vec3| p.map(|x| index(x, tolerance)).into();
        let mut sorted: Vec<_> =
            points.iter().enumerate().map(|(v, p)| (cell(p), v as u32)).collect();
        sorted.sort_unstable();
        Self { sorted, tolerance }
    }

    /// Calls `visit` with every vertex in the cells within the tolerance of a point.
    fn each_near(&self, point: Vec3, mut visit: impl FnMut(u32)) {
        let low = point.map(|x| index(x - self.tolerance, self.tolerance));
        let high = point.map(|x| index(x + self.tolerance, self.tolerance));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let start = self.sorted.partition_point(|(cell, _)| *cell < [x, y, z]);
                    let here = self.sorted[start..].iter().take_while(|(c, _)| *c == [x, y, z]);
                    here.for_each(|(_, v)| visit(*v));
                }
            }
        }
    }
}

fn index(x: f64, tolerance: f64) -> i64 {
    (x / (CELL * tolerance)).floor() as i64
}
