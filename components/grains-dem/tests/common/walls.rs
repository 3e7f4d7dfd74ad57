//! Walls of scenes: blocks, planes, reliefs, and one wall cut in several ways.

use std::fmt::Write;
use tempfile::NamedTempFile;
use tremie_grains_dem::DeformableSurface;
use tremie_messages::scene::{Geometry, Motion, MotionPoint, Part, PartBoundary, Plane, Pose};

/// Height of the walls of [`cuts`] [m].
pub const TOP: f64 = 10e-3;

/// A part that stands still.
pub fn part(geometry: Geometry, position: [f64; 3]) -> Part {
    Part {
        name: format!("part at {position:?}"),
        geometry,
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }
}

/// A box from `min` to `max` [mm].
pub fn block(min: [f64; 3], max: [f64; 3]) -> Part {
    let size = [0, 1, 2].map(|a| 1e-3 * (max[a] - min[a]));
    part(Geometry::Box { size }, [0, 1, 2].map(|a| 0.5e-3 * (max[a] + min[a])))
}

/// A block of rubber between two corners [mm], its faces cut into squares of two triangles, so many
/// along each edge.
pub fn rubber(low: [f64; 3], high: [f64; 3], cuts: usize) -> DeformableSurface {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (axis, side) in (0..6).map(|k| (k / 2, k % 2)) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let at = |i: usize, j: usize| {
            let mut x = if side == 1 { high } else { low };
            for (a, k) in [(u, i), (v, j)] {
                x[a] = low[a] + (high[a] - low[a]) * k as f64 / cuts as f64;
            }
            x.map(|x| 1e-3 * x)
        };
        for (i, j) in (0..cuts * cuts).map(|k| (k / cuts, k % cuts)) {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let mut number = |x: [f64; 3]| {
                let known = vertices.iter().position(|&y| y == x);
                known.unwrap_or_else(|| {
                    vertices.push(x);
                    vertices.len() - 1
                }) as u32
            };
            let [a, b, c, d] = corners.map(&mut number);
            let turned = |[a, b, c]: [u32; 3]| if side == 1 { [a, b, c] } else { [a, c, b] };
            triangles.extend([turned([a, b, c]), turned([a, c, d])]);
        }
    }
    DeformableSurface {
        triangles,
        vertices,
        carrier: 0,
        material: "wall".into(),
        seat_stiffness: 1e10,
    }
}

/// A box of 4 x 1 x 3 mm about a place, which goes along x and turns.
pub fn paddle(position: [f64; 3]) -> Part {
    let velocities =
        MotionPoint { time: 0.0, velocity: [0.3, 0.0, 0.0], angular_velocity: [0.0, 0.0, 50.0] };
    Part {
        name: "paddle".into(),
        motion: Motion::Prescribed(vec![velocities]),
        ..part(Geometry::Box { size: [4e-3, 1e-3, 3e-3] }, position)
    }
}

pub fn floor(height: f64) -> Plane {
    Plane { point: [0.0, 0.0, height], normal: [0.0, 0.0, 1.0], material: "wall".into() }
}

/// Flush parts, planes and faces of the domain at the height `TOP`, with a seam below (20, 20) mm
/// in most.
pub fn cuts() -> Vec<(&'static str, Vec<Part>, Vec<Plane>)> {
    let one = block([-2.0, -2.0, -10.0], [42.0, 42.0, 10.0]);
    let left = block([-2.0, -2.0, -10.0], [20.0, 42.0, 10.0]);
    let right = block([20.0, -2.0, -10.0], [42.0, 42.0, 10.0]);
    let quarter = |x: f64, y: f64| block([x, y, -10.0], [x + 22.0, y + 22.0, 10.0]);
    let four = [(-2.0, -2.0), (20.0, -2.0), (-2.0, 20.0), (20.0, 20.0)].map(|(x, y)| quarter(x, y));
    let strips = (0..44).map(|k| {
        let x = f64::from(k) - 2.0;
        block([x, -2.0, 5.0], [x + 1.0, 42.0, 10.0])
    });
    let mut turned = right.clone();
    turned.pose.orientation = [0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()];
    turned.geometry = Geometry::Box { size: [44e-3, 22e-3, 20e-3] };
    let hole = part(Geometry::Cylinder { radius: 5e-3, length: 20e-3 }, [20e-3, 20e-3, 0.0]);
    vec![
        ("one", vec![one.clone()], vec![]),
        ("two", vec![left.clone(), right.clone()], vec![]),
        ("two, one turned", vec![left.clone(), turned], vec![]),
        ("four", four.to_vec(), vec![]),
        ("four and a plane", four.to_vec(), vec![floor(TOP)]),
        ("strips", strips.collect(), vec![]),
        ("a half and a plane", vec![left.clone()], vec![floor(TOP)]),
        ("one thrice", vec![one.clone(); 3], vec![]),
        (
            "one in another",
            vec![one.clone(), block([15.0; 3].map(|x| x - 6.0), [20.0, 20.0, 10.0])],
            vec![],
        ),
        ("a disc in a block", vec![one, hole], vec![]),
        ("a plane twice", vec![], vec![floor(TOP), floor(TOP)]),
        ("planes a little apart", vec![], vec![floor(TOP), floor(TOP - 1e-9)]),
    ]
}

/// A body with a height over a square of `n` x `n` pieces about the origin, down to `bottom`;
/// inside, corners are moved along both by `uneven` parts of a piece.
pub fn relief(
    n: usize,
    size: f64,
    uneven: f64,
    bottom: f64,
    height: impl Fn(f64, f64) -> f64,
) -> NamedTempFile {
    let mut text = String::new();
    for top in [true, false] {
        for k in 0..=n {
            for i in 0..=n {
                let inside = i > 0 && i < n && k > 0 && k < n;
                let shift = |a: usize, b: usize| {
                    let of = ((a * 7 + b * 13) % 11) as f64 / 5.0 - 1.0;
                    if inside { uneven * of } else { 0.0 }
                };
                let at = |c: usize, s: f64| size * ((c as f64 + s) / n as f64 - 0.5);
                let (x, y) = (at(i, shift(i, k)), at(k, shift(k, i)));
                writeln!(text, "v {x} {y} {}", if top { height(x, y) } else { bottom }).unwrap();
            }
        }
    }
    let vertex = |i: usize, k: usize, low: usize| low * (n + 1) * (n + 1) + k * (n + 1) + i + 1;
    let mut quad = |a: usize, b: usize, c: usize, d: usize| {
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
    };
    for k in 0..n {
        for i in 0..n {
            let square = |z| {
                [vertex(i, k, z), vertex(i + 1, k, z), vertex(i + 1, k + 1, z), vertex(i, k + 1, z)]
            };
            let ([a, b, c, d], [e, f, g, h]) = (square(0), square(1));
            quad(a, b, c, d);
            quad(h, g, f, e);
        }
        let side = |i: usize, k: usize, j: usize, l: usize| {
            [vertex(i, k, 1), vertex(j, l, 1), vertex(j, l, 0), vertex(i, k, 0)]
        };
        for [a, b, c, d] in
            [side(k, 0, k + 1, 0), side(n, k, n, k + 1), side(k + 1, n, k, n), side(0, k + 1, 0, k)]
        {
            quad(a, b, c, d);
        }
    }
    let file = tempfile::Builder::new().suffix(".obj").tempfile().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}

/// A part of a file.
pub fn of_file(file: &NamedTempFile, position: [f64; 3]) -> Part {
    let path = file.path().to_string_lossy().into_owned();
    part(Geometry::File { path, unit: 1.0 }, position)
}
