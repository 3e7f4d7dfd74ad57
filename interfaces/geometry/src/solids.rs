//! Corners of well-known convex solids.

use crate::Vec3;

/// Names of the solids that [`solid`] knows.
pub const SOLIDS: [&str; 5] = ["tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron"];

/// Corners of a regular solid by its name, of any size, centred in the origin.
pub fn solid(name: &str) -> Option<Vec<Vec3>> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corners = match name {
        "tetrahedron" => {
            vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
        }
        "cube" => signs(3).map(|s| [s[0], s[1], s[2]]).collect(),
        "octahedron" => {
            let axis = |a: usize, s: f64| std::array::from_fn(|k| if k == a { s } else { 0.0 });
            (0..3).flat_map(|a| [axis(a, 1.0), axis(a, -1.0)]).collect()
        }
        "dodecahedron" => {
            let cube = signs(3).map(|s| [s[0], s[1], s[2]]);
            cube.chain(turned_rectangles(1.0 / golden, golden)).collect()
        }
        "icosahedron" => turned_rectangles(1.0, golden).collect(),
        _ => return None,
    };
    Some(corners)
}

/// All ways to choose `n` signs, as three numbers of which the first `n` count.
fn signs(n: u32) -> impl Iterator<Item = Vec3> {
    (0..1u32 << n).map(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { -1.0 } else { 1.0 }))
}

/// Corners of the rectangles `(0, +-a, +-b)`, in each of the three planes of the axes.
fn turned_rectangles(a: f64, b: f64) -> impl Iterator<Item = Vec3> {
    signs(2).flat_map(move |s| {
        let (a, b) = (s[0] * a, s[1] * b);
        [[0.0, a, b], [b, 0.0, a], [a, b, 0.0]]
    })
}
