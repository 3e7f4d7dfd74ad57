//! What ranks have of a lattice each, before a run.

use crate::domain::parameters::Parameters;
use crate::fluid::lbm_fluid::{line_of, turned};
use crate::lattice::d3q19::Q;
use crate::lattice::layout::CELLS_PER_BLOCK;
use crate::ranks::cell_shares::{CellShares, depth};
use tremie_messages::Problem;
use tremie_messages::scene::Scene;

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
    let along = ["x", "y", "z"][axes.axis_to_world(2)];
    let bodies = if scene.bodies.is_empty() { "" } else { ", and each knows all bodies" };
    Ok(vec![format!(
        "{ranks} ranks, slices along {along}, each of up to {own:.0} cells ({imbalance:.1} % more than the mean) and copies of {copies:.0} \
         ({:.0} %), {memory:.0} MB; a rank takes up to {sent:.1} MB from others in a step{bodies}",
        100.0 * copies / own
    )])
}
