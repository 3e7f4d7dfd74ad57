//! Drag on bodies in boxes of the scene: their fall tends to a terminal speed.
//!
//! ```text
//! F = -(m g / v_T^2) |v| v        a body whose centre is in the box, v as contact forces see it
//! ```
//!
//! (Goetsch, thesis, Iowa State University, 2015, sec. 3.2.5.) A body at rest that falls in a band from the start has
//! the speed `v_T tanh(g t / v_T)`.
//!
//! The account has what each band took: the sum over bodies and kicks of `-F dt`, the very kicks
//! that moved them, and `-F.v dt` with the velocity that the force sees, which is the work to second
//! order in the step. Sums go by the order of ids, in fixed blocks.

use crate::Vec3;
use crate::bodies::body_arrays::{BLOCK, Bodies};
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_messages::scene::Scene;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// What a band took from the bodies since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DragBandState {
    /// Momentum [kg·m/s].
    pub momentum_removed: [f64; 3],
    /// Energy [J].
    pub energy_removed: f64,
}

/// The boxes, as the motion of bodies asks them.
#[derive(Clone, Debug)]
pub(crate) struct DragBands {
    bands: Vec<Band>,
    bounds: PeriodicBox,
    taken: Vec<Taken>,
    /// Sums of each block of ids, one for each band in turn.
    blocks: Vec<Taken>,
}

#[derive(Clone, Copy, Debug)]
struct Band {
    min: Vec3,
    max: Vec3,
    /// `g / v_T^2` [1/m].
    strength: f64,
}

/// Sum of `-F` and `-F.v`, or of these over time.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Taken {
    momentum: Vec3,
    energy: f64,
}

impl Taken {
    fn add(&mut self, other: &Self, factor: f64) {
        self.momentum += other.momentum * factor;
        self.energy += other.energy * factor;
    }
}

/// A body of several pieces, which the arrays do not have as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrakedClump {
    /// Mass [kg].
    pub mass: f64,
    /// Centroid; it may lie beyond periodic faces [m].
    pub x: Vec3,
    /// Velocity that forces see [m/s].
    pub v: Vec3,
}

impl Band {
    #[inline(always)]
    fn has(&self, x: Vec3) -> bool {
        (0..3).all(|a| x[a] >= self.min[a] && x[a] < self.max[a])
    }

    /// Acceleration of what is in the band [m/s²].
    #[inline(always)]
    fn on(&self, v: Vec3) -> Vec3 {
        v * (-self.strength * v.norm_squared().sqrt())
    }

    /// What it takes in a second from a body that is there.
    fn takes(&self, mass: f64, v: Vec3) -> Taken {
        let momentum = self.on(v) * -mass;
        Taken { momentum, energy: momentum.dot(&v) }
    }
}

impl DragBands {
    /// Keeps what the bands have taken, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("taken", &mut self.taken)
    }

    /// The bands of a scene for a run of so many bodies at most.
    pub fn of_scene(scene: &Scene, bounds: &PeriodicBox, capacity: usize) -> Self {
        let gravity = Vec3::from(scene.gravity).norm_squared().sqrt();
        let bands: Vec<Band> = (scene.drag_bands.iter())
            .map(|band| Band {
                min: band.min.into(),
                max: band.max.into(),
                strength: gravity / (band.terminal_speed * band.terminal_speed),
            })
            .collect();
        let blocks = capacity.div_ceil(BLOCK) * bands.len();
        Self {
            taken: vec![Taken::default(); bands.len()],
            blocks: Vec::with_capacity(blocks),
            bands,
            bounds: bounds.clone(),
        }
    }

    /// True if a body must ask.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        !self.bands.is_empty()
    }

    /// Acceleration at a place in the domain [m], at a velocity [m/s]; of bands that overlap the
    /// sum.
    #[inline(never)]
    pub fn acceleration(&self, x: Vec3, v: Vec3) -> Vec3 {
        let there = self.bands.iter().filter(|band| band.has(x));
        there.fold(Vec3::zeros(), |sum, band| sum + band.on(v))
    }

    /// The same at a place that may lie beyond periodic faces.
    pub fn acceleration_of_clump(&self, x: Vec3, v: Vec3) -> Vec3 {
        self.acceleration(self.bounds.wrap(x), v)
    }

    /// Notes what a kick of this `duration` [s] takes from the bodies where they are.
    pub fn account(
        &mut self,
        team: &mut Team,
        bodies: &Bodies,
        clumps: impl Iterator<Item = BrakedClump>,
        duration: f64,
    ) {
        let Self { bands, bounds, taken, blocks } = self;
        if bands.is_empty() {
            return;
        }
        blocks.resize(bodies.len().div_ceil(BLOCK) * bands.len(), Taken::default());
        // Of every band and block by itself, in the order of ids: nothing depends on where bodies
        // stand in memory.
        let count = bands.len();
        team.for_each(blocks, |k, sum| {
            *sum = of_block(&bands[k % count], bodies, k / count);
        });
        for (k, sum) in blocks.iter().enumerate() {
            taken[k % count].add(sum, duration);
        }
        for BrakedClump { mass, x, v } in clumps {
            let x = bounds.wrap(x);
            for (band, taken) in bands.iter().zip(&mut *taken).filter(|(band, _)| band.has(x)) {
                taken.add(&band.takes(mass, v), duration);
            }
        }
    }

    /// What each took since the start, in the order of the scene.
    pub fn states(&self) -> impl ExactSizeIterator<Item = DragBandState> + '_ {
        self.taken.iter().map(|taken| DragBandState {
            momentum_removed: taken.momentum.into(),
            energy_removed: taken.energy,
        })
    }
}

/// What a band takes in a second from the free bodies of a block of ids.
fn of_block(band: &Band, bodies: &Bodies, block: usize) -> Taken {
    let mut sum = Taken::default();
    let own = block * BLOCK..bodies.len().min((block + 1) * BLOCK);
    for &slot in &bodies.slot[own] {
        let slot = slot as usize;
        let mobility = bodies.mobility[slot];
        if mobility.is_free() && !mobility.is_joined() && band.has(bodies.balls[slot].x) {
            let mass = 1.0 / mobility.inverse_mass;
            sum.add(&band.takes(mass, bodies.predicted[slot].v), 1.0);
        }
    }
    sum
}
