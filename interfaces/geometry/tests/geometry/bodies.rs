//! Meshes to test with, and answers by brute force.

use proptest::prelude::*;
use tremie_geometry::Mesh;
use tremie_messages::scene::{Geometry, Pose};

pub use tremie_geometry::Vec3;

pub fn cube(size: f64) -> Mesh {
    Mesh::of(&Geometry::Box { size: [size; 3] }).unwrap()
}

pub fn moved(mesh: &Mesh, by: Vec3) -> Mesh {
    mesh.placed(&Pose { position: by.into(), ..Pose::IDENTITY })
}

/// Two meshes as one list of triangles.
pub fn both(one: &Mesh, other: &Mesh) -> Mesh {
    let shift = one.vertices.len() as u32;
    let mut mesh = one.clone();
    mesh.vertices.extend(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
    mesh
}

/// The same triangles, each with vertices of its own, as in an STL file.
pub fn torn(mesh: &Mesh) -> Mesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Mesh { vertices, triangles: triangles.collect() }
}

pub fn tetrahedron() -> Mesh {
    Mesh {
        vertices: vec![
            Vec3::zeros(),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(0.0, 0.0, 1.0),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}

/// A ring about z with circles of `around` corners, `along` of them.
pub fn torus(major: f64, minor: f64, along: u32, around: u32) -> Mesh {
    let corner = |i: u32, j: u32| {
        let turn = std::f64::consts::TAU;
        let (sin, cos) = libm::sincos(turn * f64::from(i) / f64::from(along));
        let (up, out) = libm::sincos(turn * f64::from(j) / f64::from(around));
        let r = major + minor * out;
        Vec3::new(r * cos, r * sin, minor * up)
    };
    let name = |i: u32, j: u32| (i % along) * around + j % around;
    let all = || (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    let quad = |(i, j)| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        vertices: all().map(|(i, j)| corner(i, j)).collect(),
        triangles: all().flat_map(quad).collect(),
    }
}

/// Corners of a coarse sphere, each at a distance of its own from the middle: a body with bumps
/// and hollows, but never one that crosses itself.
pub fn star(radii: &[f64]) -> Mesh {
    let mut mesh = ball();
    for (vertex, r) in mesh.vertices.iter_mut().zip(radii.iter().cycle()) {
        *vertex = vertex.map(|x| x * r);
    }
    mesh
}

/// A sphere of 8 by 12.
fn ball() -> Mesh {
    const RINGS: u32 = 8;
    const SIDES: u32 = 12;
    let mut vertices = vec![-Vec3::z(), Vec3::z()];
    for i in 1..RINGS {
        let (out, up) = libm::sincos(std::f64::consts::PI * f64::from(i) / f64::from(RINGS));
        for j in 0..SIDES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(j) / f64::from(SIDES));
            vertices.push(Vec3::new(out * cos, out * sin, -up));
        }
    }
    let name = |i: u32, j: u32| 2 + (i - 1) * SIDES + j % SIDES;
    let mut triangles = Vec::new();
    for j in 0..SIDES {
        triangles.push([0, name(1, j + 1), name(1, j)]);
        triangles.push([1, name(RINGS - 1, j), name(RINGS - 1, j + 1)]);
        for i in 1..RINGS - 1 {
            let [a, b, c, d] = [name(i, j), name(i, j + 1), name(i + 1, j + 1), name(i + 1, j)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh { vertices, triangles }
}

/// Stacks of unit cubes in a corner, `heights[i][j]` of them, no stack higher than those nearer to
/// the corner. Everything about it is known exactly, and all of it is in line with something.
#[derive(Debug)]
pub struct Stairs(pub [[u32; 4]; 4]);

impl Stairs {
    pub fn full(&self, [i, j, k]: [i32; 3]) -> bool {
        let inside = |n: i32| (0..4).contains(&n);
        inside(i) && inside(j) && k >= 0 && (k as u32) < self.0[i as usize][j as usize]
    }

    /// True if a point is in a cube or on its sides.
    pub fn contains(&self, p: Vec3) -> bool {
        let cells = p.map(|x| {
            let floor = x.floor();
            if floor == x { vec![floor as i32 - 1, floor as i32] } else { vec![floor as i32] }
        });
        cells[0]
            .iter()
            .any(|&i| cells[1].iter().any(|&j| cells[2].iter().any(|&k| self.full([i, j, k]))))
    }

    pub fn volume(&self) -> f64 {
        f64::from(self.0.iter().flatten().sum::<u32>())
    }

    /// Squares between full and empty cells, each with vertices of its own.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        let cells = (0..4).flat_map(|i| (0..4).flat_map(move |j| (0..6).map(move |k| [i, j, k])));
        for cell in cells.filter(|&c| self.full(c)) {
            for axis in 0..3 {
                for up in [false, true] {
                    let mut next = cell;
                    next[axis] += if up { 1 } else { -1 };
                    if !self.full(next) {
                        self.square(&mut mesh, cell, axis, up);
                    }
                }
            }
        }
        mesh
    }

    fn square(&self, mesh: &mut Mesh, cell: [i32; 3], axis: usize, up: bool) {
        let first = mesh.vertices.len() as u32;
        for (u, v) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            let mut p = cell.map(f64::from);
            p[axis] += f64::from(u8::from(up));
            p[(axis + 1) % 3] += f64::from(u);
            p[(axis + 2) % 3] += f64::from(v);
            mesh.vertices.push(p.into());
        }
        let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
        mesh.triangles.extend(if up { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
    }
}

pub fn stairs() -> impl Strategy<Value = Stairs> {
    proptest::array::uniform4(proptest::array::uniform4(1u32..6)).prop_map(|mut h| {
        for i in 0..4 {
            for j in 0..4 {
                let before = if i > 0 { h[i - 1][j] } else { 9 };
                let beside = if j > 0 { h[i][j - 1] } else { 9 };
                h[i][j] = h[i][j].min(before).min(beside);
            }
        }
        Stairs(h)
    })
}

/// Bodies of every kind, about as large as one.
pub fn any_body() -> impl Strategy<Value = Mesh> {
    let bumpy = proptest::collection::vec(0.2..1.0f64, 10..90).prop_map(|r| star(&r));
    let ring = (0.1..0.45f64, 3u32..20, 3u32..14).prop_map(|(r, n, m)| torus(0.5, r, n, m));
    let squashed =
        (proptest::array::uniform3(-1.0..1.0f64), proptest::array::uniform3(-1.0..1.0f64))
            .prop_map(|(x, y)| sheared(&tetrahedron(), x.into(), y.into()));
    let hollow = proptest::collection::vec(0.5..1.0f64, 10..90).prop_map(|r| {
        let mut inner = star(&r);
        inner.vertices.iter_mut().flatten().for_each(|x| *x *= 0.3);
        inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        both(&star(&r), &inner)
    });
    prop_oneof![bumpy, ring, squashed, hollow]
}

/// A mesh with its second and third axes leaning over; never inside out.
fn sheared(mesh: &Mesh, y: Vec3, z: Vec3) -> Mesh {
    let mut mesh = mesh.clone();
    for p in &mut mesh.vertices {
        let [a, b, c] = (*p).into();
        *p = Vec3::new(a + b * y[0] + c * z[0], b + c * z[1], c);
    }
    mesh
}

pub fn point() -> impl Strategy<Value = Vec3> {
    proptest::array::uniform3(-1.1..1.1f64).prop_map(Vec3::from)
}

/// Winding number of a mesh around a point, as the sum of solid angles (Van Oosterom & Strackee,
/// *IEEE Trans. Biomed. Eng.* 30 (1983) 125): near a whole number unless the point is on the
/// surface.
pub fn solid_angles(mesh: &Mesh, point: Vec3) -> f64 {
    let angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|p| p - point);
        let [x, y, z] = [a, b, c].map(|v| v.norm());
        let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Distance from a point to a mesh, looking at every triangle.
pub fn distance(mesh: &Mesh, point: Vec3) -> f64 {
    (0..mesh.triangles.len()).map(|t| to_triangle(mesh.corners(t), point)).fold(f64::MAX, f64::min)
}

/// Distance to a triangle by regions (Ericson, *Real-Time Collision Detection*, 2005, 5.1.5).
fn to_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let at = |u: f64, v: f64| (a + ab * u + ac * v - p).norm();
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    let (bp, cp) = (p - b, p - c);
    let (d3, d4, d5, d6) = (ab.dot(&bp), ac.dot(&bp), ab.dot(&cp), ac.dot(&cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        at(0.0, 0.0)
    } else if d3 >= 0.0 && d4 <= d3 {
        at(1.0, 0.0)
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        at(d1 / (d1 - d3), 0.0)
    } else if d6 >= 0.0 && d5 <= d6 {
        at(0.0, 1.0)
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        at(0.0, d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        at(1.0 - t, t)
    } else {
        at(vb / (va + vb + vc), vc / (va + vb + vc))
    }
}
