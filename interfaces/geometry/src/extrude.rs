//! Prisms: an outline drawn out along an axis.

use crate::exact::turn;
use crate::read::triangulate;
use crate::{GeometryError, Mesh, Vec3};

/// The surface of a prism along an axis (0, 1, 2 for x, y, z), its middle at the origin there, whose
/// section has the corners `outline` in the other two axes, in their order [m]. Triangles may face
/// either way.
pub fn extruded(outline: &[[f64; 2]], axis: usize, length: f64) -> Result<Mesh, GeometryError> {
    crate::shapes::positive("the length of the prism", length)?;
    let others = match axis {
        0 => [1, 2],
        1 => [0, 2],
        2 => [0, 1],
        _ => return wrong(format!("there is no axis {axis}")),
    };
    let ring = |along: f64| -> Vec<Vec3> {
        let place = |corner: &[f64; 2]| {
            let mut point = Vec3::zeros();
            (point[axis], point[others[0]], point[others[1]]) = (along, corner[0], corner[1]);
            point
        };
        outline.iter().map(place).collect()
    };
    let (mut vertices, high) = (ring(-0.5 * length), ring(0.5 * length));
    check(outline, axis, &vertices)?;
    let n = outline.len() as u32;
    let mut triangles = Vec::with_capacity(4 * outline.len() - 4);
    for cap in triangulate(&vertices) {
        let [a, b, c] = cap.map(|k| k as u32);
        triangles.extend([[b, a, c], [a + n, b + n, c + n]]);
    }
    for k in 0..n {
        let next = (k + 1) % n;
        triangles.extend([[k, next, next + n], [k, next + n, k + n]]);
    }
    vertices.extend(high);
    Ok(Mesh { vertices, triangles })
}

fn wrong<T>(why: String) -> Result<T, GeometryError> {
    Err(GeometryError::Outline { why })
}

fn check(outline: &[[f64; 2]], axis: usize, corners: &[Vec3]) -> Result<(), GeometryError> {
    let n = outline.len();
    if n < 3 {
        return wrong(format!("it has {n} corners, but needs three or more"));
    }
    if let Some(k) = outline.iter().position(|corner| !corner.iter().all(|x| x.is_finite())) {
        return wrong(format!("corner {k} is at {:?} m, which is no point", outline[k]));
    }
    if let Some(k) = (0..n).find(|&k| outline[k] == outline[(k + 1) % n]) {
        return wrong(format!("corner {k} and the next are both at {:?} m", outline[k]));
    }
    let edge = |k: usize| [corners[k], corners[(k + 1) % n]];
    for a in 0..n {
        for b in a + 1..n {
            let follows = b == a + 1 || (a == 0 && b == n - 1);
            let meets = if follows {
                let (first, second) = if b == a + 1 { (a, b) } else { (b, a) };
                turns_back(axis, edge(first), edge(second)[1])
            } else {
                cross(axis, edge(a), edge(b))
            };
            if meets {
                return wrong(format!("its edges from corners {a} and {b} meet"));
            }
        }
    }
    Ok(())
}

/// True if an edge goes on into its own line, backwards, to a corner.
fn turns_back(axis: usize, [from, to]: [Vec3; 2], next: Vec3) -> bool {
    turn(axis, from, to, next) == 0.0 && (to - from).dot(&(next - to)) < 0.0
}

/// True if two edges have a point in common.
fn cross(axis: usize, [a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> bool {
    let sides = |p: Vec3, q: Vec3, one: Vec3, other: Vec3| {
        let (one, other) = (turn(axis, p, q, one), turn(axis, p, q, other));
        (one >= 0.0 && other <= 0.0) || (one <= 0.0 && other >= 0.0)
    };
    // Of edges in one line the boxes tell.
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    sides(a, b, c, d) && sides(c, d, a, b) && !(0..3).any(apart)
}
