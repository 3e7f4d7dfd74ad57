//! Corners of well-known convex solids.

use crate::Vec3;

/// Names of the solids that [`solid`] knows.
pub const SOLIDS: [&str; 5] = ["tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron"];

/// Corners of a regular solid by its name, as a scene has them: of any size, centred in the origin.
pub fn solid(name: &str) -> Option<Vec<[f64; 3]>> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corners: Vec<Vec3> = match name {
        "tetrahedron" => {
            let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
            corners.map(|corner| Vec3::from(corner.map(f64::from))).to_vec()
        }
        "cube" => signs(3).collect(),
        "octahedron" => (0..3).flat_map(|a| [Vec3::ith(a, 1.0), Vec3::ith(a, -1.0)]).collect(),
        "dodecahedron" => signs(3).chain(turned_rectangles(1.0 / golden, golden)).collect(),
        "icosahedron" => turned_rectangles(1.0, golden).collect(),
        _ => return None,
    };
    Some(corners.into_iter().map(Into::into).collect())
}

/// All ways to choose `n` signs, as three numbers of which the first `n` count.
fn signs(n: u32) -> impl Iterator<Item = Vec3> {
    (0..1u32 << n).map(|k| Vec3::from_fn(|a, _| if k >> a & 1 == 0 { -1.0 } else { 1.0 }))
}

/// Corners of the rectangles `(0, +-a, +-b)`, in each of the three planes of the axes.
fn turned_rectangles(a: f64, b: f64) -> impl Iterator<Item = Vec3> {
    signs(2).flat_map(move |s| {
        let (a, b) = (s[0] * a, s[1] * b);
        [Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a), Vec3::new(a, b, 0.0)]
    })
}
