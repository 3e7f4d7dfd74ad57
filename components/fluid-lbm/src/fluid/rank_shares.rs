//! What ranks have of a lattice each, before a run.

use crate::domain::parameters::Parameters;
use crate::fluid::lbm_fluid::{line_of, turned};
use crate::lattice::d3q19::Q;
use crate::lattice::layout::CELLS_PER_BLOCK;
use crate::ranks::cell_shares::{CellShares, depth};
use std::ops::Range;
use tremie_messages::Problem;
use tremie_messages::scene::{BodySet, Packing, Placement, PolyhedronPlacement, Scene};

/// What so many ranks have each: sentences for the user.
///
/// # Errors
/// What ranks cannot do, and more of them than there are blocks for.
pub fn shares_of_ranks(
    parameters: &Parameters,
    scene: &Scene,
    ranks: usize,
) -> Result<Vec<String>, Vec<Problem>> {
    let (resolution, ground) = parameters.survey(scene)?;
    let line = line_of(parameters.precision);
    let (axes, _, ground) = turned(scene, &resolution, ground, line);
    let obstacles = &ground.voxels.obstacles;
    let depth = depth(scene, obstacles);
    let shares = CellShares::new(&ground.grid, obstacles, (ranks, depth))
        .map_err(|text| vec![Problem::of_parameter("launch", text)])?;
    let all = resolution.fluid_cells as f64;
    let held = |rank: usize| {
        let own = shares.own(rank).len();
        let copies: usize = (0..ranks)
            .filter(|&other| other != rank)
            .map(|other| shares.copies(rank, other).count())
            .sum();
        [own, copies].map(|blocks| blocks as f64 * f64::from(CELLS_PER_BLOCK))
    };
    let held: Vec<[f64; 2]> = (0..ranks).map(held).collect();
    let most = |of: &dyn Fn(&[f64; 2]) -> f64| held.iter().map(of).fold(0.0, f64::max);
    let (own, copies) = (most(&|held| held[0]), most(&|held| held[1]));
    let together = most(&|held| held[0] + held[1]);
    let imbalance = 100.0 * (own * ranks as f64 / all - 1.0).max(0.0);
    let memory = resolution.memory_bytes as f64 * together / all * 1e-6;
    let sent = copies * Q as f64 * (64 / line) as f64 * 1e-6;
    let axis = axes.axis_to_world(2);
    let along = ["x", "y", "z"][axis];
    let height = |rank: usize| match rank {
        0 => f64::NEG_INFINITY,
        _ if rank == ranks => f64::INFINITY,
        _ => scene.domain.min[axis] + f64::from(shares.first_layer(rank)) * resolution.cell,
    };
    let of_ranks =
        (0..ranks).map(|rank| bodies_between(scene, axis, height(rank)..height(rank + 1)));
    let bodies = of_bodies(&of_ranks.collect::<Vec<f64>>());
    Ok(vec![format!(
        "{ranks} ranks, slices along {along}, each of up to {own:.0} cells ({imbalance:.1} % more than the mean) and copies of {copies:.0} \
         ({:.0} %), {memory:.0} MB; a rank takes up to {sent:.1} MB from others in a step{bodies}",
        100.0 * copies / own
    )])
}

/// Words on how the volume of the bodies at the start is shared among ranks; none where there are no bodies.
fn of_bodies(volumes: &[f64]) -> String {
    let all: f64 = volumes.iter().sum();
    let most = volumes.iter().copied().fold(0.0, f64::max);
    match all > 0.0 {
        true => format!(", and at the start has up to {:.0} % of the bodies", 100.0 * most / all),
        false => String::new(),
    }
}

/// Volume of the bodies that are between two heights along an axis at the start [m³]. Packed ones are everywhere alike.
fn bodies_between(scene: &Scene, axis: usize, heights: Range<f64>) -> f64 {
    let sphere = |diameter: f64| std::f64::consts::PI / 6.0 * diameter.powi(3);
    let listed = |position: &[f64; 3], diameter: f64| match heights.contains(&position[axis]) {
        true => sphere(diameter),
        false => 0.0,
    };
    let packed = |packing: &Packing| {
        let sides: [f64; 3] = std::array::from_fn(|a| packing.max[a] - packing.min[a]);
        let (low, high) = (packing.min[axis], packing.max[axis]);
        let inside = (heights.end.min(high) - heights.start.max(low)).max(0.0);
        packing.fraction * sides.iter().product::<f64>() * inside / sides[axis]
    };
    let of_set = |set: &BodySet| match &set.placement {
        Placement::Listed(list) => list.iter().map(|b| listed(&b.position, b.diameter)).sum(),
        Placement::Packed(packing) => packed(packing),
        Placement::Polyhedra(polyhedra) => match &polyhedra.placement {
            PolyhedronPlacement::Listed(list) => {
                list.iter().map(|b| listed(&b.position, b.diameter)).sum()
            }
            PolyhedronPlacement::Packed(packing) => packed(packing),
        },
    };
    scene.bodies.iter().map(of_set).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use tremie_messages::scene::{Domain, Face};

    #[test]
    fn bodies_are_shared_by_their_place() {
        let sphere = |z: f64| {
            json!({
                "position": [0.5, 0.5, z], "diameter": 0.1,
                "velocity": [0.0, 0.0, 0.0], "angular_velocity": [0.0, 0.0, 0.0],
            })
        };
        let placement = |placement: serde_json::Value| {
            json!({
                "name": "grains", "density": 1.0, "material": "glass", "motion": "free",
                "placement": placement,
            })
        };
        let scene = |sets: Vec<serde_json::Value>| {
            let faces = [0; 3].map(|_| [Face::Periodic, Face::Periodic]);
            let mut scene = Scene::empty(Domain::new([0.0; 3], [1.0; 3], faces));
            scene.bodies =
                sets.into_iter().map(|set| serde_json::from_value(set).unwrap()).collect();
            scene
        };
        let thirds = |scene: &Scene| {
            let heights = [f64::NEG_INFINITY, 0.25, 0.75, f64::INFINITY];
            let third = |k: usize| bodies_between(scene, 2, heights[k]..heights[k + 1]);
            of_bodies(&[third(0), third(1), third(2)])
        };
        let listed = scene(vec![placement(json!({
            "listed": [sphere(0.1), sphere(0.3), sphere(0.7), sphere(0.76)]
        }))]);
        assert_eq!(thirds(&listed), ", and at the start has up to 50 % of the bodies");
        let packed = scene(vec![placement(json!({ "packed": {
            "min": [0.0, 0.0, 0.5], "max": [1.0, 1.0, 1.0], "fraction": 0.3, "seed": 1,
            "diameters": { "uniform": { "min": 0.1, "max": 0.1 } },
        }}))]);
        assert!((bodies_between(&packed, 2, 0.5..0.625) - 0.0375).abs() < 1e-12);
        assert_eq!(thirds(&packed), thirds(&listed));
        assert_eq!(thirds(&scene(Vec::new())), "");
    }
}
