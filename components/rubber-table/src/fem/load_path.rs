//! The whole way: from rest to the largest compression, frame by frame.

use crate::fem::assembly::{Model, State};
use crate::fem::newton::{Equilibrium, Failure, settle};
use crate::mesh::Point;

/// Length and steps of a compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compression {
    /// Largest compression [m].
    pub largest: f64,
    /// Number of frames, the first at rest.
    pub frames: usize,
    /// Forces out of balance, over their size, at which an increment is done.
    pub tolerance: f64,
}

/// A state on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Compression [m].
    pub compression: f64,
    /// Force of the carrier, downwards [N].
    pub force: f64,
    /// Force of seat and steel that stays, upwards [N]: equal but for what is out of balance.
    pub seat_force: f64,
    /// Stored energy [J].
    pub energy: f64,
    /// Positions of the nodes where the seat stands still [m].
    pub points: Vec<Point>,
    /// Mises stress of each quadrilateral [Pa].
    pub mises: Vec<f64>,
    /// Edges of the outline that touch the seat's surface.
    pub touching: Vec<[usize; 2]>,
    /// Smallest ratio of volumes, after over before.
    pub least_volume_ratio: f64,
    /// Increments since the frame before.
    pub increments: u32,
    /// Passes of Newton's method since the frame before.
    pub passes: u32,
    /// Forces out of balance, over their size.
    pub residual: f64,
    /// True if the equilibrium is stable: one that is not would buckle.
    pub stable: bool,
}

/// A compression that did not go all the way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no equilibrium beyond a compression of {:.4} mm of {:.4} mm, in steps down to {:.1e} mm: {why}; compress less, refine the mesh, \
         or round the seat's corners more", 1e3 * reached, 1e3 * wanted, 1e3 * step)]
pub struct Stuck {
    /// Compression that was reached [m].
    pub reached: f64,
    /// Compression that was wanted [m].
    pub wanted: f64,
    /// The last step tried [m].
    pub step: f64,
    /// The failure in it.
    pub why: Failure,
}

/// Steps are halved this often before the way counts as blocked.
const MOST_HALVINGS: i32 = 12;

/// Compresses `model` from rest. Frames are uniform; a step from frame to frame is halved where it
/// finds no equilibrium, and doubled again after it does.
///
/// # Errors
/// If no step leads on.
pub fn compress(model: &Model, way: &Compression) -> Result<Vec<Frame>, Stuck> {
    let spacing = way.largest / (way.frames.max(2) - 1) as f64;
    let mut walk = Walk { model, way, state: model.rest(), known_good: Vec::new(), step: spacing };
    walk.known_good.clone_from(&walk.state.displacements);
    // The undeformed section is not inside out: its mesh was checked.
    let _ = model.assemble(&mut walk.state);
    let mut frames = vec![walk.frame(0.0, 0, Equilibrium::default())];
    for number in 1..way.frames {
        frames.push(walk.to(number as f64 * spacing, (number - 1) as f64 * spacing, spacing)?);
    }
    Ok(frames)
}

struct Walk<'a> {
    model: &'a Model,
    way: &'a Compression,
    state: State,
    /// Displacements of the last equilibrium.
    known_good: Vec<f64>,
    step: f64,
}

impl Walk<'_> {
    fn to(&mut self, target: f64, from: f64, spacing: f64) -> Result<Frame, Stuck> {
        let shortest = spacing * 2f64.powi(-MOST_HALVINGS);
        let (mut at, mut increments, mut passes) = (from, 0, 0);
        loop {
            let left = target - at;
            let last = self.step >= left * (1.0 - 1e-9);
            let step = if last { left } else { self.step };
            match settle(self.model, &mut self.state, step, self.way.tolerance) {
                Ok(settled) => {
                    self.known_good.clone_from(&self.state.displacements);
                    (increments, passes) = (increments + 1, passes + settled.passes);
                    self.step = (2.0 * self.step).min(spacing);
                    if last {
                        return Ok(self.frame(
                            target,
                            increments,
                            Equilibrium { passes, ..settled },
                        ));
                    }
                    at += step;
                }
                Err(why) if 0.5 * step < shortest => {
                    return Err(Stuck { reached: at, wanted: self.way.largest, step, why });
                }
                Err(_) => {
                    self.state.displacements.clone_from(&self.known_good);
                    let _ = self.model.assemble(&mut self.state);
                    self.step = 0.5 * step;
                }
            }
        }
    }

    fn frame(&self, compression: f64, increments: u32, settled: Equilibrium) -> Frame {
        let (model, state) = (self.model, &self.state);
        let moved = |(node, at): (usize, &Point)| {
            [at[0] + state.displacements[2 * node], at[1] + state.displacements[2 * node + 1]]
        };
        Frame {
            compression,
            force: model.carrier_force(state),
            seat_force: model.seat_force(state),
            energy: state.energy,
            points: model.mesh().nodes().iter().enumerate().map(moved).collect(),
            mises: model.mises_stresses(state),
            touching: model.touching(state),
            least_volume_ratio: model.least_volume_ratio(state),
            increments,
            passes: settled.passes,
            residual: settled.residual,
            stable: settled.negative_pivots == 0,
        }
    }
}
