//! An inlet: the lacking volume, and the places of the next spheres.
//!
//! Spheres come while at least half of the next one's volume is lacking, so that the volume swings
//! about the wanted one. What leaves between two insertions is lacking in the mean until then; the
//! error of the mean is carried over, as fast as the region empties, so that the mean over time
//! comes out right.
//!
//! Spheres come whole: their centres start some way into the region, one to two radii in the mean
//! and more where it is crowded. What they fill, and what therefore holds the wanted fraction, is
//! the region from there on; with all of it filled as much the stream beyond would be denser, the
//! more so the shorter the region.

use super::{InletState, filled::Filled, upstream};
use crate::Vec3;
use crate::bodies::body_arrays::BoundingSphere;
use crate::bodies::placed_parts::PlacedPart;
use crate::solver::interaction_context::InteractionContext;
use crate::solver::placement;
use crate::solver::probes::volume_in_box;
use core::f64::consts::PI;
use tremie_grains_kit::math::random::Random;
use tremie_grains_kit::packing::random_packing::{self, Feeding, Sizes, Upstream};
use tremie_messages::scene::{Inlet, InletVelocity, Packing, Scene};
use tremie_state::{StateError, StateExchange};

/// Steps of the grains between two insertions, unless the scene says otherwise.
const STEPS: u64 = 50;

/// Weight of the last interval in the mean volume that leaves in one. Its own would not do: where
/// more leaves, less is held, and the mean of their product is not that of the means.
const RECENT: f64 = 0.05;

/// An inlet with its state.
pub(super) struct Feeder {
    pub name: String,
    /// Index of its set in the scene.
    pub set: usize,
    region: Packing,
    sizes: Sizes,
    largest: f64,
    /// Part of the region that spheres fill, and their mean volume [m³].
    filled: Filled,
    mean_volume: f64,
    pub from: InletVelocity,
    /// Velocity of the spheres that come [m/s].
    pub velocity: [f64; 3],
    /// Steps between insertions, and those since the start at the last one.
    every: u64,
    last: u64,
    until: f64,
    key: u64,
    tries: u32,
    /// Insertions that found no place for a sphere.
    failed: u64,
    /// Volume that the region held after the last one, that leaves between two in the mean, and the
    /// error of the mean to be made good [m³].
    held: f64,
    loss: f64,
    owed: f64,
    pub state: InletState,
}

impl Feeder {
    /// Inlet `index` of a scene that is right.
    pub fn new(
        scene: &Scene,
        inlet: &Inlet,
        index: u64,
        around: &InteractionContext,
        dt: f64,
    ) -> Option<Self> {
        let set = scene.bodies.iter().position(|set| set.name == inlet.bodies)?;
        let region = region(inlet);
        let sizes = Sizes::new(&inlet.diameters);
        let largest = 0.5 * inlet.diameters.extremes()[1];
        let empty = random_packing::PackingSurroundings {
            parts: &around.parts,
            bounds: around.bounds.clone(),
            planes: around.walls.clone(),
            balls: Vec::new(),
        };
        let upstream = from_side(inlet.velocity, largest)
            .filter(|upstream| !scene.domain.is_periodic(upstream.axis));
        let slices = upstream.map_or((2, 0), |upstream| (upstream.axis, upstream.side));
        let slices = Feeding::new(&region, &empty, largest).free_slices(slices.0, slices.1);
        let filled = Filled::new(&region, upstream, slices, &sizes);
        // A whole number of steps must not become one more by rounding.
        let every = inlet.every.map_or(STEPS, |time| (time / dt - 1e-9).ceil().max(1.0) as u64);
        Some(Self {
            name: inlet.name.clone(),
            set,
            mean_volume: sizes.mean_volume(),
            sizes,
            largest,
            from: inlet.velocity,
            velocity: match inlet.velocity {
                InletVelocity::Given(velocity) => velocity,
                InletVelocity::Face { .. } => [0.0; 3],
            },
            every,
            last: 0,
            until: inlet.until.unwrap_or(f64::INFINITY),
            // Multiples of 2^64 over the golden ratio: inlets of one seed get keys far apart.
            key: inlet.seed.wrapping_add((index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)),
            tries: inlet.tries,
            failed: 0,
            held: 0.0,
            loss: 0.0,
            owed: 0.0,
            state: InletState { deficit: filled.wanted(), ..InletState::default() },
            filled,
            region,
        })
    }

    /// Keeps the account of the inlet, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.array("velocity", &mut self.velocity)?;
        state.value("last", &mut self.last)?;
        state.value("failed", &mut self.failed)?;
        state.value("held", &mut self.held)?;
        state.value("loss", &mut self.loss)?;
        state.value("owed", &mut self.owed)?;
        self.filled.exchange(state)?;
        state.value("totals", &mut self.state)
    }

    /// True if spheres may come now.
    pub fn is_due(&self, steps: u64, time: f64) -> bool {
        steps - self.last >= self.every && time <= self.until
    }

    /// Spheres that come now, of ids from `next` on; random numbers are keyed by the id, and those
    /// of places by what failed before besides.
    pub fn feed(
        &mut self,
        around: &random_packing::PackingSurroundings<'_, PlacedPart>,
        steps: u64,
        mut next: u64,
    ) -> Vec<BoundingSphere> {
        let present: f64 = around.balls.iter().map(|ball| self.volume_of(ball, around)).sum();
        let mut lacking = self.lacking(present);
        (self.last, self.held) = (steps, present);
        let mut came = Vec::new();
        let mut feeding = None;
        self.state.deficit = 0.0;
        loop {
            let d = self.sizes.at(Random::new(self.key, next).unit());
            let volume = PI / 6.0 * d * d * d;
            if lacking < 0.5 * volume {
                break;
            }
            let feeding =
                feeding.get_or_insert_with(|| Feeding::new(&self.region, around, self.largest));
            // A sphere that found no place keeps its diameter, but gets other places next time. Bit
            // 63 separates the random numbers of places from those of diameters.
            let key = self.key.wrapping_add(self.failed.wrapping_mul(0xD134_2543_DE82_EF95));
            let mut random = Random::new(key, 1 << 63 | next);
            let upstream = from_side(self.from, self.largest);
            let Some(ball) = feeding.add(0.5 * d, upstream, self.tries, &mut random) else {
                self.state.deficit = lacking;
                self.failed += 1;
                break;
            };
            came.push(ball);
            self.filled.count(ball.x, volume);
            lacking -= volume;
            self.held += volume;
            next += 1;
        }
        came
    }

    /// Volume that is lacking, the error of the mean included [m³].
    fn lacking(&mut self, present: f64) -> f64 {
        self.loss += RECENT * (self.held - present - self.loss);
        let wanted = self.filled.wanted();
        let error = wanted - 0.5 * (self.held + present);
        let (loss, bound) = (self.loss.max(0.0), self.mean_volume + self.loss.max(0.0));
        self.owed = (self.owed + error * loss / wanted).clamp(-bound, bound);
        wanted - present + self.owed
    }

    /// Takes a sphere that came into account.
    pub fn count(&mut self, ball: BoundingSphere, density: f64) {
        self.state.inserted += 1;
        self.state.mass_inserted += placement::mass(density, 2.0 * ball.radius);
    }

    /// Volume of a sphere, or of its images, in the region [m³].
    fn volume_of(
        &self,
        ball: &BoundingSphere,
        around: &random_packing::PackingSurroundings<'_, PlacedPart>,
    ) -> f64 {
        let (min, max) = (Vec3::from(self.region.min), Vec3::from(self.region.max));
        let images = around.bounds.images();
        images.map(|shift| volume_in_box(ball.radius, ball.x + shift, min, max)).sum()
    }
}

/// The side from which spheres of such a velocity come, the largest of a radius [m].
fn from_side(velocity: InletVelocity, largest: f64) -> Option<Upstream> {
    let side = match velocity {
        InletVelocity::Given(velocity) => upstream(velocity.into()),
        InletVelocity::Face { axis, side } => Some((axis, side)),
    };
    side.map(|(axis, side)| Upstream { axis, side, depth: 2.0 * largest })
}

/// The region of an inlet, as that of a packing.
pub(crate) fn region(inlet: &Inlet) -> Packing {
    Packing {
        min: inlet.min,
        max: inlet.max,
        fraction: inlet.fraction,
        diameters: inlet.diameters.clone(),
        seed: inlet.seed,
    }
}
