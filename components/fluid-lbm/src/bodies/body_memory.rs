//! Memory that bodies take in the fluid: what is kept of the cells and links around each.

use tremie_messages::scene::{BodySizes, Diameters, Inlet, Placement, Scene, SievePoint};

/// Measured on x86-64, in bytes, of bodies at rest and on the move: what each takes, whatever its
/// size; for each square of its diameter in cells, because links are on its surface; and for each
/// cube of it.
const SPHERE: [f64; 3] = [27e3, 1.2e3, 33.0];
/// Of a polyhedron links are found through its faces.
const POLYHEDRON: [f64; 3] = [25e3, 3.7e3, 33.0];

/// Memory of the bodies at the start, and of those that inlets feed, between as many as fill the
/// inlet and as fill the domain [bytes]; `cell` is the edge of a cell [m].
pub(crate) fn of_bodies(scene: &Scene, cell: f64) -> u64 {
    let of_set = |placement: &Placement| {
        let cost = match placement {
            Placement::Polyhedra(_) => POLYHEDRON,
            _ => SPHERE,
        };
        let of_one = |d: f64| of_diameter(cost, d / cell);
        match placement.sizes() {
            BodySizes::Listed(diameters) => diameters.into_iter().map(of_one).sum(),
            sizes @ BodySizes::Packed(packing) => {
                number(&packing.diameters, sizes.volume()) * mean(&packing.diameters, of_one)
            }
        }
    };
    let at_start: f64 = scene.bodies.iter().map(|set| of_set(&set.placement)).sum();
    let size = scene.domain.size();
    let domain = size[0] * size[1] * size[2];
    let of_inlet = |inlet: &Inlet| {
        let region: f64 = (0..3).map(|a| inlet.max[a] - inlet.min[a]).product();
        let number = number(&inlet.diameters, inlet.fraction * (region * domain).sqrt());
        number * mean(&inlet.diameters, |d| of_diameter(SPHERE, d / cell))
    };
    (at_start + scene.inlets.iter().map(of_inlet).fold(0.0, f64::max)) as u64
}

fn of_diameter([one, surface, volume]: [f64; 3], d: f64) -> f64 {
    one + d * d * (surface + d * volume)
}

/// Number of spheres of a distribution that have a volume together [m³].
fn number(diameters: &Diameters, volume: f64) -> f64 {
    volume / mean(diameters, |d| core::f64::consts::PI / 6.0 * d * d * d)
}

/// Mean over the number of spheres of a distribution.
fn mean(diameters: &Diameters, of: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mut add = |d: f64, weight: f64| {
        sum += weight * of(d);
        weights += weight;
    };
    match diameters {
        Diameters::Uniform { min, max } => between(*min, *max).for_each(|d| add(d, 1.0)),
        Diameters::Normal { mean, deviation, min, max } => {
            between(*min, *max).for_each(|d| add(d, bell((d - mean) / deviation)));
        }
        Diameters::LogNormal { median, spread, min, max } => {
            let width = spread.ln();
            for x in between(min.ln(), max.ln()) {
                add(x.exp(), bell((x - median.ln()) / width));
            }
        }
        Diameters::Sieve(points) => {
            for [a, b] in points.array_windows::<2>() {
                let SievePoint { size: from, passing } = a;
                let mass = (b.passing - passing) / f64::from(PARTS);
                // Mass is spread evenly over the logarithm of size.
                between(from.ln(), b.size.ln())
                    .map(f64::exp)
                    .for_each(|d| add(d, mass / (d * d * d)));
            }
        }
        Diameters::Listed(list) => list.iter().for_each(|&d| add(d, 1.0)),
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

const PARTS: u32 = 256;

/// Middles of equal parts of an interval.
fn between(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..PARTS).map(move |part| from + (to - from) * (f64::from(part) + 0.5) / f64::from(PARTS))
}

fn bell(z: f64) -> f64 {
    (-0.5 * z * z).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against closed forms: of a uniform distribution, of a log-normal one that is hardly cut, of
    /// a sieve curve of one stage (number density 1/d^4).
    #[test]
    fn mean_volumes_are_those_of_the_distributions() {
        let cube = |d: f64| d * d * d;
        let uniform = Diameters::Uniform { min: 1.0, max: 3.0 };
        assert!((mean(&uniform, cube) / 10.0 - 1.0).abs() < 1e-4);
        let sigma = 1.5_f64.ln();
        let wide = Diameters::LogNormal { median: 2.0, spread: 1.5, min: 0.1, max: 40.0 };
        let exact = 8.0 * (4.5 * sigma * sigma).exp();
        assert!((mean(&wide, cube) / exact - 1.0).abs() < 1e-3);
        let point = |size, passing| SievePoint { size, passing };
        let sieve = Diameters::Sieve(vec![point(1.0, 0.0), point(2.0, 1.0)]);
        let exact = 3.0 * 2.0_f64.ln() / (1.0 - 0.125);
        assert!((mean(&sieve, cube) / exact - 1.0).abs() < 1e-3);
    }
}
