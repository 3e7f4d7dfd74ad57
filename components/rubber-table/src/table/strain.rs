//! Equivalent shear strain of the rubber, from the shapes of its section.
//!
//! The measure is the equivalent shear strain ε_q = √(2/3 e:e), e the deviator of the logarithmic
//! strain, as Mutabaruka and Kamrin (2018) colour their rubber by.
//!
//! If a table has quadrilaterals, each has the deformation gradient at its centre, the hoop r/R
//! among it, and a vertex the mean of those around it by area. Where a table has an outline alone,
//! an edge has the stretch along it and that of the hoop, and its thickness follows from a volume
//! that stays: on a surface that bears no shear, free or on a seat without friction, those are the
//! principal stretches of an isotropic solid. Bonded edges bear shear that no outline shows; they
//! count only at vertices that have no other edge.

use crate::mesh::Point;
use crate::table::contents::Contents;
use crate::table::interpolation::Table;

impl Table {
    /// Equivalent shear strain of these `vertices`, which lie on the outline, in each frame.
    pub fn strains_of(&self, vertices: &[usize]) -> Vec<Vec<f64>> {
        strains_of(self.contents(), vertices)
    }
}

fn strains_of(contents: &Contents, vertices: &[usize]) -> Vec<Vec<f64>> {
    let of_all = if contents.quads.is_empty() { of_outline } else { of_section };
    let frame = |points: &Vec<Point>| {
        let all = of_all(contents, points);
        vertices.iter().map(|vertex| all[*vertex].value()).collect()
    };
    contents.vertices.iter().map(frame).collect()
}

/// A weighted mean.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        self.sum += value * weight;
        self.weight += weight;
    }

    /// 0 where nothing was added.
    fn value(self) -> f64 {
        if self.weight > 0.0 { self.sum / self.weight } else { 0.0 }
    }
}

/// Of three principal stretches.
fn equivalent(stretches: [f64; 3]) -> f64 {
    let logarithms = stretches.map(libm::log);
    let mean = (logarithms[0] + logarithms[1] + logarithms[2]) / 3.0;
    let squares: f64 = logarithms.iter().map(|l| (l - mean) * (l - mean)).sum();
    (2.0 / 3.0 * squares).sqrt()
}

fn of_section(contents: &Contents, points: &[Point]) -> Vec<Mean> {
    let rest = &contents.vertices[0];
    let mut all = vec![Mean::default(); rest.len()];
    for quad in &contents.quads {
        let (then, now) = (quad.map(|v| rest[v]), quad.map(|v| points[v]));
        let (strain, area) = of_quad(then, now);
        quad.iter().for_each(|vertex| all[*vertex].add(strain, area));
    }
    all
}

/// Strain at the centre, and the area at rest [m²].
fn of_quad(then: [Point; 4], now: [Point; 4]) -> (f64, f64) {
    let ([a, b], [c, d]) = (diagonals(then), diagonals(now));
    // The gradient at the centre takes the diagonals of before to those of now.
    let twice_area = a[0] * b[1] - a[1] * b[0];
    let f = |i: usize| {
        [(c[i] * b[1] - d[i] * a[1]) / twice_area, (d[i] * a[0] - c[i] * b[0]) / twice_area]
    };
    let (r, z) = (f(0), f(1));
    let xx = r[0] * r[0] + z[0] * z[0];
    let yy = r[1] * r[1] + z[1] * z[1];
    let determinant = r[0] * z[1] - r[1] * z[0];
    let middle = 0.5 * (xx + yy);
    let larger = middle + (middle * middle - determinant * determinant).max(0.0).sqrt();
    let radius = |corners: [Point; 4]| corners.iter().map(|point| point[0]).sum::<f64>();
    let hoop = radius(now) / radius(then);
    let long = larger.sqrt();
    (equivalent([long, determinant / long, hoop]), 0.5 * twice_area)
}

fn diagonals([a, b, c, d]: [Point; 4]) -> [Point; 2] {
    [[c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]]
}

fn of_outline(contents: &Contents, points: &[Point]) -> Vec<Mean> {
    let rest = &contents.vertices[0];
    let length = |places: &[Point], [a, b]: [usize; 2]| {
        libm::hypot(places[b][0] - places[a][0], places[b][1] - places[a][1])
    };
    let facets = &contents.facets;
    let (mut free, mut bonded) =
        (vec![Mean::default(); rest.len()], vec![Mean::default(); rest.len()]);
    let add = |all: &mut [Mean], edge: [usize; 2]| {
        let (before, now) = (length(rest, edge), length(points, edge));
        for vertex in edge {
            let along = now / before;
            let at_rest = rest[vertex][0];
            // On the axis all directions across it are alike.
            let hoop = if at_rest > 0.0 { points[vertex][0] / at_rest } else { along };
            all[vertex].add(equivalent([along, hoop, 1.0 / (along * hoop)]), before);
        }
    };
    facets.seat.iter().chain(&facets.exposed).for_each(|edge| add(&mut free, *edge));
    facets.bonded.iter().for_each(|edge| add(&mut bonded, *edge));
    let choose = |(free, bonded): (Mean, Mean)| if free.weight > 0.0 { free } else { bonded };
    free.into_iter().zip(bonded).map(choose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::example;

    /// A square of radii 1 and 2 whose vertices move as `to` says, with its quadrilateral or
    /// without.
    fn strains(to: fn(Point) -> Point, has_quad: bool) -> Vec<f64> {
        let rest = vec![[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        let contents = Contents {
            vertices: vec![rest.clone(), rest.into_iter().map(to).collect()],
            quads: if has_quad { vec![[0, 1, 2, 3]] } else { Vec::new() },
            ..example()
        };
        let frames = strains_of(&contents, &[0, 1, 2, 3]);
        assert!(frames[0].iter().all(|strain| strain.abs() < 1e-12), "{frames:?}");
        frames[1].clone()
    }

    fn assert_all(found: &[f64], expected: f64) {
        assert!(
            found.iter().all(|strain| (strain - expected).abs() < 1e-7),
            "{found:?} {expected}"
        );
    }

    #[test]
    fn pressed_without_friction_it_is_the_logarithm_of_the_stretch() {
        let press = |[r, z]: Point| [r / 0.8f64.sqrt(), 0.8 * z];
        for has_quad in [true, false] {
            assert_all(&strains(press, has_quad), -0.8f64.ln());
        }
    }

    #[test]
    fn a_change_of_volume_is_no_shear() {
        assert_all(&strains(|[r, z]| [0.9 * r, 0.9 * z], true), 0.0);
    }

    #[test]
    fn simple_shear_is_seen_inside_the_section() {
        // Stretches exp(±asinh(γ/2)), the hoop's 1 far from the axis.
        let (strain, area) = of_quad(
            [[1e6, 0.0], [1e6 + 1.0, 0.0], [1e6 + 1.0, 1.0], [1e6, 1.0]],
            [[1e6, 0.0], [1e6 + 1.0, 0.0], [1e6 + 1.5, 1.0], [1e6 + 0.5, 1.0]],
        );
        assert!((strain - 2.0 / 3f64.sqrt() * 0.25f64.asinh()).abs() < 1e-6, "{strain}");
        assert!((area - 1.0).abs() < 1e-9);
    }
}
