//! Spheres on a lattice: `lattice` of `[[scene.bodies]]`, as a list.

use super::super::document::{Arrangement, LatticeTable};
use super::super::path;
use super::super::read::Findings;
use super::bodies::region_holds;
use tremie_messages::scene::Sphere;

/// Most spheres of a lattice: they are listed one by one.
const MOST: f64 = 1e6;
/// Part of a spacing by which the last sphere may reach beyond the region: rounding.
const ROUNDING: f64 = 1e-9;

/// Distances of a lattice over its spacing: of rows in a layer, and of layers.
fn distances(arrangement: Arrangement) -> [f64; 2] {
    match arrangement {
        Arrangement::Cubic => [1.0, 1.0],
        Arrangement::Hexagonal => [0.75_f64.sqrt(), (2.0_f64 / 3.0).sqrt()],
    }
}

/// Shifts of a row along itself and of a layer across its rows, over the spacing. Close packing
/// puts every second layer (ABAB) above the holes of the one below.
fn shifts(arrangement: Arrangement, row: usize, layer: usize) -> [f64; 2] {
    match arrangement {
        Arrangement::Cubic => [0.0; 2],
        Arrangement::Hexagonal => {
            let (row, layer) = (row % 2, layer % 2);
            [0.5 * ((row + layer) % 2) as f64, 0.75_f64.sqrt() / 3.0 * layer as f64]
        }
    }
}

/// The spheres, layer by layer and row by row.
pub(super) fn spheres(
    table: &LatticeTable,
    at: &str,
    findings: &mut Findings,
) -> Option<Vec<Sphere>> {
    let min = findings.required(&table.min, at, "min");
    let max = findings.required(&table.max, at, "max");
    let diameter = findings.positive(&table.diameter, at, "diameter");
    let spacing = match table.spacing {
        Some(_) => findings.positive(&table.spacing, at, "spacing"),
        None => diameter,
    };
    let (min, max) = (min?.map(|x| x.0), max?.map(|x| x.0));
    let (diameter, spacing) = (diameter?, spacing?);
    let (arrangement, normal) = (table.arrangement?, table.normal?.number());
    region_holds(&min, &max, diameter, at, findings);
    let (along, across) = ((normal + 1) % 3, (normal + 2) % 3);
    let room = |axis: usize| (max[axis] - min[axis] - diameter) / spacing + ROUNDING;
    let [of_rows, of_layers] = distances(arrangement);
    let most = [(along, 1.0), (across, of_rows), (normal, of_layers)]
        .map(|(axis, distance)| (room(axis) / distance).floor() + 1.0);
    if most.iter().any(|&most| most < 1.0) {
        return None;
    }
    let count: f64 = most.iter().product();
    if count > MOST {
        let message = format!("makes {count:.3e} spheres, expected {MOST:e} at most");
        let help = "make the region smaller, or the spacing larger";
        findings.problem_with_help(&path::join(at, "max"), message, help);
        return None;
    }
    let mut spheres = Vec::with_capacity(count as usize);
    let [most_along, most_rows, most_layers] = most.map(|most| most as usize);
    for (layer, row) in (0..most_layers).flat_map(|k| (0..most_rows).map(move |j| (k, j))) {
        let [shift, beside] = shifts(arrangement, row, layer);
        let over_rows = row as f64 * of_rows + beside;
        for i in (0..most_along).filter(|_| over_rows <= room(across)) {
            let over_spheres = i as f64 + shift;
            if over_spheres > room(along) {
                continue;
            }
            let mut position = min.map(|x| x + 0.5 * diameter);
            position[along] += spacing * over_spheres;
            position[across] += spacing * over_rows;
            position[normal] += spacing * (layer as f64 * of_layers);
            spheres.push(Sphere {
                position,
                diameter,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
            });
        }
    }
    Some(spheres)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::document::AxisName;
    use tremie_messages::units::Length;

    fn lattice(arrangement: Arrangement, normal: AxisName, size: [f64; 3]) -> Vec<Sphere> {
        let table = LatticeTable {
            min: Some([Length(0.0); 3]),
            max: Some(size.map(Length)),
            diameter: Some(Length(1.0)),
            spacing: None,
            arrangement: Some(arrangement),
            normal: Some(normal),
        };
        spheres(&table, "lattice", &mut Findings::default()).unwrap()
    }

    fn distance(a: &Sphere, b: &Sphere) -> f64 {
        (0..3).map(|k| (a.position[k] - b.position[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// No two overlap, inner ones touch twelve others, and all lie whole in the region.
    #[test]
    fn close_packing_is_close() {
        for normal in [AxisName::X, AxisName::Y, AxisName::Z] {
            let size = [7.0, 6.5, 6.2];
            let all = lattice(Arrangement::Hexagonal, normal, size);
            let mut most = 0;
            for a in &all {
                let near = all.iter().map(|b| distance(a, b)).filter(|&d| d > 0.0);
                let near: Vec<f64> = near.filter(|&d| d < 1.0 + 1e-9).collect();
                assert!(near.iter().all(|&d| d > 1.0 - 1e-9), "{near:?}");
                most = most.max(near.len());
                let is_inside =
                    |k: usize| a.position[k] > 0.5 - 1e-9 && a.position[k] < size[k] - 0.5 + 1e-9;
                assert!((0..3).all(is_inside), "{a:?}");
            }
            assert_eq!(most, 12);
        }
    }

    #[test]
    fn a_cubic_one_fills_its_region() {
        let all = lattice(Arrangement::Cubic, AxisName::Z, [4.0, 3.0, 2.0]);
        assert_eq!(all.len(), 24);
        assert_eq!(all[23].position, [3.5, 2.5, 1.5]);
    }

    /// One layer is a rough wall.
    #[test]
    fn a_thin_region_holds_one_layer() {
        let all = lattice(Arrangement::Hexagonal, AxisName::X, [1.5, 4.0, 4.0]);
        assert!(all.iter().all(|sphere| sphere.position[0] == 0.5));
        assert_eq!(all.len(), 4 + 3 + 4 + 3);
    }
}
