//! The part of an inlet's region that its spheres fill.

use crate::Vec3;
use tremie_grains_kit::packing::random_packing::{Sizes, Upstream};
use tremie_messages::scene::Packing;
use tremie_state::{StateError, StateExchange};

/// Entry of spheres into a region, and the region's volume from there on.
///
/// A stream of spheres that come at a mean distance x from where it enters and leave at the
/// region's end L, at one speed, holds the volume A (L - x) f in the mean over time, f its solid
/// fraction: a sphere counts whole as soon as it comes, and as it leaves as much as is inside, half
/// of it when its centre is at L.
pub(super) struct Filled {
    fraction: f64,
    upstream: Option<Upstream>,
    /// Lower and upper end of the region along the stream [m].
    ends: [f64; 2],
    /// Free volume of slices of the region, from upstream on [m³].
    slices: Vec<f64>,
    /// Volume of the spheres that came, and its product with their distances from upstream, with a
    /// guess to begin with [m³, m⁴].
    came: [f64; 2],
}

/// Number of spheres that the guess counts as.
const GUESS: f64 = 10.0;

impl Filled {
    /// Keeps the account of what came, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.array("came", &mut self.came)
    }

    /// Filled part of a region with these free `slices` along the stream; without a stream all of
    /// it is filled.
    pub fn new(
        region: &Packing,
        upstream: Option<Upstream>,
        slices: Vec<f64>,
        sizes: &Sizes,
    ) -> Self {
        let axis = upstream.map_or(2, |upstream| upstream.axis);
        let ends = [region.min[axis], region.max[axis]];
        let radius = 0.5 * sizes.at(0.5);
        let guess =
            upstream.map_or(0.0, |upstream| upstream.mean_distance(radius, ends[1] - ends[0]));
        let volume = GUESS * sizes.mean_volume();
        Self { fraction: region.fraction, upstream, ends, slices, came: [volume, volume * guess] }
    }

    /// Volume of spheres that the region shall hold [m³].
    pub fn wanted(&self) -> f64 {
        let [low, high] = self.ends;
        let before = self.came[1] / self.came[0] / (high - low) * self.slices.len() as f64;
        let share =
            |(slice, volume): (usize, &f64)| volume * (slice as f64 + 1.0 - before).clamp(0.0, 1.0);
        self.fraction * self.slices.iter().enumerate().map(share).sum::<f64>()
    }

    /// A sphere of a volume [m³] came at a place.
    pub fn count(&mut self, x: Vec3, volume: f64) {
        if let Some(Upstream { axis, side, .. }) = self.upstream {
            let distance = if side == 0 { x[axis] - self.ends[0] } else { self.ends[1] - x[axis] };
            self.came[0] += volume;
            self.came[1] += volume * distance;
        }
    }
}
