//! The solver: adaptation, ghosts, and steps of third order in time.

use crate::bodies::body_mask::{BlockPlaces, BodyMask, blocks_at_surfaces};
use crate::bodies::gas_body::{BodyLoad, GasBody};
use crate::bodies::inside_points::InsidePoints;
use crate::gas::block_rates::{GasRoom, NoGas};
use crate::gas::gas_law::{Gas, GasState, MOST_FIELDS, field_count};
use crate::grid::adaptation::{BlockMarks, carry_over, find_marks, integral, wanted_blocks};
use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockDomain, BlockTree, spacing_of_level};
use crate::grid::block_values::{BlockValues, FillRoom};
use crate::solver::block_scales::BlockScales;
use crate::solver::domain_faces::{DomainFace, DomainFaces};
use crate::solver::part_times::PartTimes;
use crate::solver::rates_pass::{OfBlock, RatesPass};
use crate::solver::sponge::Sponge;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};
use tremie_team::{Cut, Team, Variant};

/// Weights of the steps of Shu and Osher (1988): of the start, of what the step before gave, and of
/// its rates times the time step.
const STAGES: [[f64; 3]; 3] =
    [[0.0, 1.0, 1.0], [0.75, 0.25, 0.25], [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]];

/// How a gas is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveletSettings {
    /// Dimensions, 1 to 3.
    pub dims: usize,
    /// Points of a block along each axis.
    pub block_edge: usize,
    /// Blocks of level 0 along each axis.
    pub roots: [u32; 3],
    /// Finest level.
    pub deepest: u8,
    /// Spacing of level 0 [m].
    pub coarsest: f64,
    /// Lower corner of the domain [m].
    pub origin: [f64; 3],
    /// Faces of the domain.
    pub faces: DomainFaces,
    /// Detail that is significant, as a share of each field's scale.
    pub tolerance: f64,
    /// Detail from which on a face is rough, as a share of each field's scale.
    pub roughness: f64,
    /// Steps from one adaptation to the next.
    pub adapt_every: usize,
    /// Way of the fastest signal in a step, in points.
    pub courant: f64,
    /// Layer at the faces in which what runs out dies, if any.
    pub sponge: Option<Sponge>,
    /// Acceleration that drives the gas [m/s^2].
    pub acceleration: [f64; 3],
    /// Pressure from which that on bodies counts [Pa].
    pub rest_pressure: f64,
    /// The gas.
    pub gas: Gas,
}

impl WaveletSettings {
    /// A periodic square or cube of one block, with tolerances for most purposes.
    pub fn new(dims: usize, gas: Gas) -> Self {
        Self {
            dims,
            block_edge: if dims < 3 { 16 } else { 8 },
            roots: [1; 3],
            deepest: 4,
            coarsest: 1.0 / 16.0,
            origin: [0.0; 3],
            faces: [[DomainFace::Periodic; 2]; 3],
            tolerance: 1e-3,
            roughness: 5e-3,
            adapt_every: 4,
            courant: 0.5,
            sponge: None,
            acceleration: [0.0; 3],
            rest_pressure: gas.gas_constant * gas.reference,
            gas,
        }
    }

    fn domain(&self) -> BlockDomain {
        let is_periodic = |a: usize| a >= self.dims || self.faces[a][0] == DomainFace::Periodic;
        BlockDomain {
            shape: BlockShape::new(self.dims, self.block_edge),
            roots: std::array::from_fn(|a| if a < self.dims { self.roots[a] } else { 1 }),
            periodic: [0, 1, 2].map(is_periodic),
            deepest: self.deepest,
        }
    }

    /// Spacing of a level [m].
    pub fn spacing(&self, level: u8) -> f64 {
        spacing_of_level(self.coarsest, level)
    }
}

/// Where a gas has no density or no pressure, or moves without bound.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the gas has density {density:.3e} kg/m3 and pressure {pressure:.3e} Pa at ({:.6}, {:.6}, {:.6}) m; \
     both must be positive: a finer grid, a smaller tolerance, or shorter steps",
    at[0], at[1], at[2]
)]
pub struct NoGasError {
    /// The place [m].
    pub at: [f64; 3],
    /// Density there [kg/m^3].
    pub density: f64,
    /// Pressure there [Pa].
    pub pressure: f64,
}

/// Loads on a body by two estimators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwoLoads {
    /// By stress at the surface.
    pub by_stress: BodyLoad,
    /// By the momentum that goes through the faces between points outside and inside: it is what
    /// the gas lost, but for what it has between these faces and the surface.
    pub by_momentum: BodyLoad,
}

/// A gas on its grid.
pub struct WaveletSolver {
    /// How it is solved.
    pub settings: WaveletSettings,
    /// The blocks.
    pub tree: BlockTree,
    /// Fields at their points: density, momentum, energy.
    pub values: BlockValues,
    /// Time [s].
    pub time: f64,
    /// Steps made.
    pub steps: u64,
    /// Significant points when the grid was last adapted.
    pub significant: u64,
    /// Where the time of the steps went.
    pub times: PartTimes,
    /// Loads on the bodies in the last step.
    pub loads: Vec<TwoLoads>,
    pub(crate) mask: BodyMask,
    inside: InsidePoints,
    rates: Vec<f64>,
    start: Vec<f64>,
    scales: Vec<f64>,
    fastest: f64,
    viscous: f64,
    block_scales: Vec<BlockScales>,
    marks: Vec<BlockMarks>,
    team: Team,
    variant: Variant,
    fill_rooms: Vec<FillRoom>,
    gas_rooms: Vec<GasRoom>,
    found: Vec<OfBlock>,
}

impl WaveletSolver {
    /// A gas that begins in the state `initial` gives at each place.
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn new(
        settings: WaveletSettings,
        threads: usize,
        bodies: &[impl GasBody],
        initial: impl Fn([f64; 3]) -> GasState,
    ) -> std::io::Result<Self> {
        let mut solver = Self::empty(settings, threads)?;
        solver.begin(bodies, initial);
        Ok(solver)
    }

    /// A solver that [`WaveletSolver::begin`] has yet to fill with gas.
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn empty(settings: WaveletSettings, threads: usize) -> std::io::Result<Self> {
        let tree = BlockTree::new(settings.domain(), []);
        let shape = tree.domain.shape;
        let team = Team::new("fluid-wavelet", threads)?;
        let threads = team.threads();
        Ok(Self {
            settings,
            values: BlockValues::new(&tree, field_count(settings.dims)),
            tree,
            time: 0.0,
            steps: 0,
            significant: 0,
            times: PartTimes::default(),
            loads: Vec::new(),
            mask: BodyMask::default(),
            inside: InsidePoints::default(),
            rates: Vec::new(),
            start: Vec::new(),
            scales: Vec::new(),
            fastest: 0.0,
            viscous: 0.0,
            block_scales: Vec::new(),
            marks: Vec::new(),
            team,
            variant: Variant::widest(),
            fill_rooms: (0..threads).map(|_| FillRoom::new(&shape)).collect(),
            gas_rooms: (0..threads).map(|_| GasRoom::new(&shape)).collect(),
            found: Vec::new(),
        })
    }

    /// Begins anew at time 0, in the state `initial` gives at each place.
    pub fn begin(&mut self, bodies: &[impl GasBody], initial: impl Fn([f64; 3]) -> GasState) {
        (self.time, self.steps) = (0.0, 0);
        // Each round may go one level deeper.
        for _ in 0..=self.settings.deepest {
            self.set_to(&initial);
            self.place_bodies(bodies);
            self.fill();
            if !self.adapt(bodies) {
                break;
            }
        }
        self.set_to(&initial);
        self.place_bodies(bodies);
        self.fill();
        self.find_scales();
    }

    /// The shape of its blocks.
    pub fn shape(&self) -> BlockShape {
        self.tree.domain.shape
    }

    /// Calls `see` with the block, the place and the fields of each point of the leaves.
    pub fn for_each_point(&self, mut see: impl FnMut(BlockAddress, [f64; 3], [f64; MOST_FIELDS])) {
        let (shape, places, count) = (self.shape(), self.places(), self.values.fields);
        for &leaf in &self.tree.leaves {
            let (leaf, block) = (leaf as usize, self.tree.blocks[leaf as usize]);
            for point in 0..shape.points {
                let mut fields = [0.0; MOST_FIELDS];
                for (field, value) in fields.iter_mut().enumerate().take(count) {
                    *value = self.values.own[(leaf * count + field) * shape.points + point];
                }
                see(block, places.padded_point(block, shape.padded_at(point)), fields);
            }
        }
    }

    /// Points of the leaves.
    pub fn points(&self) -> usize {
        self.tree.leaves.len() * self.shape().points
    }

    /// Points of the leaves as a share of those of a uniform grid of the finest level.
    pub fn share_of_full_grid(&self) -> f64 {
        let domain = &self.tree.domain;
        let blocks = |a: usize| f64::from(domain.blocks_along(domain.deepest, a));
        self.tree.leaves.len() as f64 / (blocks(0) * blocks(1) * blocks(2))
    }

    /// Integral of a field over a domain that wraps around, in its unit times m^dims.
    pub fn integral(&mut self, field: usize) -> f64 {
        let cell = self.settings.coarsest.powi(self.settings.dims as i32);
        cell * integral(&mut self.fill_rooms[0], &self.tree, &self.values, field)
    }

    /// Gives all points the initial state.
    fn set_to(&mut self, initial: &impl Fn([f64; 3]) -> GasState) {
        let (shape, places, count) = (self.shape(), self.places(), self.values.fields);
        for slot in 0..self.tree.blocks.len() {
            for point in 0..shape.points {
                let at = places.padded_point(self.tree.blocks[slot], shape.padded_at(point));
                let fields = self.settings.gas.fields(shape.dims, initial(at));
                for (field, value) in fields.iter().enumerate().take(count) {
                    self.values.own[(slot * count + field) * shape.points + point] = *value;
                }
            }
        }
    }

    /// Gives parents and ghosts their values.
    fn fill(&mut self) {
        let Self { values, team, tree, fill_rooms, settings, .. } = self;
        values.restrict(team, tree);
        values.fill(team, fill_rooms, tree, &settings.faces);
    }

    /// Largest values of each field, of momentum over all components; what the time
    /// step depends on.
    fn find_scales(&mut self) {
        let Self { settings, tree, values, team, block_scales, .. } = self;
        let (gas, dims, points) = (&settings.gas, settings.dims, tree.domain.shape.points);
        let length = values.fields * points;
        block_scales.resize(tree.leaves.len(), BlockScales::NONE);
        team.for_each(block_scales, |k, scales| {
            let leaf = tree.leaves[k] as usize;
            let own = &values.own[leaf * length..(leaf + 1) * length];
            *scales = BlockScales::of(gas, dims, tree.blocks[leaf].level, own, points);
        });
        let all = block_scales.iter().fold(BlockScales::NONE, BlockScales::with);
        let mut scales = all.largest[..values.fields].to_vec();
        // Gas that hardly moves has no scale of its own.
        let moving = (1..=dims).fold(0.0_f64, |m, a| m.max(scales[a]));
        let sound = (scales[0] * scales[1 + dims]).sqrt();
        scales[1..=dims].fill(moving.max(1e-2 * sound));
        (self.scales, self.fastest, self.viscous) = (scales, all.fastest, all.viscous);
    }

    /// Where blocks stand.
    pub fn places(&self) -> BlockPlaces {
        let WaveletSettings { origin, coarsest, .. } = self.settings;
        BlockPlaces { shape: self.shape(), origin, coarsest }
    }

    /// Finds which points are inside bodies, and gives them their values.
    fn place_bodies(&mut self, bodies: &[impl GasBody]) {
        self.find_inside(bodies);
        self.extend(bodies);
    }

    /// Finds which points are inside bodies.
    fn find_inside(&mut self, bodies: &[impl GasBody]) {
        let places = self.places();
        self.mask.find(&self.tree, &places, bodies);
        self.inside.find(&self.tree, &places, &self.mask, bodies);
    }

    /// Goes on from values that were put back, with the bodies where they were then.
    pub fn resume(&mut self, bodies: &[impl GasBody]) {
        self.find_inside(bodies);
        self.fill();
        self.find_scales();
    }

    /// Gives points inside bodies their values.
    fn extend(&mut self, bodies: &[impl GasBody]) {
        let Self { tree, values, inside, settings, .. } = self;
        let spacing = settings.spacing(settings.deepest);
        inside.extend((&tree.domain.shape, &settings.gas), spacing, bodies, &mut values.own);
    }

    /// Adapts the grid; true if it changed. Ghosts are filled, and are again afterwards.
    fn adapt(&mut self, bodies: &[impl GasBody]) -> bool {
        self.find_scales();
        let places = self.places();
        let Self { tree, values, team, fill_rooms, marks, scales, settings, .. } = self;
        let thresholds: Vec<f64> = scales.iter().map(|s| settings.tolerance * s).collect();
        let (shape, mask) = (places.shape, &self.mask);
        let hidden = |slot: usize| mask.of(&shape, slot);
        find_marks(team, fill_rooms, (tree, values), &thresholds, hidden, marks);
        self.significant = marks.iter().map(|marks| u64::from(marks.significant)).sum();
        let mut wanted = wanted_blocks(tree, marks);
        wanted.extend(blocks_at_surfaces(&tree.domain, &places, bodies));
        let next = BlockTree::new(tree.domain, wanted);
        if next.blocks == tree.blocks {
            return false;
        }
        *values = carry_over(team, fill_rooms, (tree, values), &next, &settings.faces);
        *tree = next;
        self.place_bodies(bodies);
        if !bodies.is_empty() {
            // What stands in bodies has changed since the blocks were carried over.
            self.fill();
        }
        true
    }

    /// The longest stable time step [s], as the last adaptation or step left the gas.
    pub fn longest_step(&self) -> f64 {
        let settings = &self.settings;
        let advection = settings.courant * settings.coarsest / self.fastest;
        let finest = settings.spacing(self.tree.levels.len() as u8 - 1);
        let gas = &settings.gas;
        if gas.viscosity == 0.0 {
            return advection;
        }
        // Heat spreads faster than momentum by the heat ratio over Prandtl's number.
        let spread = self.viscous * (gas.heat_ratio / gas.prandtl).max(4.0 / 3.0);
        advection.min(0.4 * finest * finest / (spread * settings.dims as f64))
    }

    /// Makes one step of a time [s], in which bodies stand where they are and move as they do.
    ///
    /// # Errors
    /// If somewhere there is no density or pressure any more; the solver is then of no use.
    pub fn step(&mut self, dt: f64, bodies: &[impl GasBody]) -> Result<(), NoGasError> {
        self.clocked(|times| &mut times.steps, |own| own.clocked_step(dt, bodies))
    }

    fn clocked_step(&mut self, dt: f64, bodies: &[impl GasBody]) -> Result<(), NoGasError> {
        if !bodies.is_empty() {
            self.clocked(|times| &mut times.bodies, |own| own.place_bodies(bodies));
            self.clocked(|times| &mut times.transform, Self::fill);
        }
        if self.steps.is_multiple_of(self.settings.adapt_every as u64) {
            self.clocked(|times| &mut times.adaptation, |own| own.adapt(bodies));
            self.times.adaptations += 1;
        }
        self.loads.clear();
        self.loads.resize(bodies.len(), TwoLoads::default());
        self.start.clear();
        self.start.extend_from_slice(&self.values.own);
        for (number, stage) in STAGES.into_iter().enumerate() {
            self.clocked(|times| &mut times.rates, |own| own.find_rates(bodies, number == 0))?;
            self.times.right_hand_sides += 1;
            self.mix(stage, dt);
            if !bodies.is_empty() {
                self.clocked(|times| &mut times.bodies, |own| own.extend(bodies));
            }
            self.clocked(|times| &mut times.transform, Self::fill);
        }
        self.time += dt;
        self.steps += 1;
        self.find_scales();
        Ok(())
    }

    /// The values of a stage.
    fn mix(&mut self, stage: [f64; 3], dt: f64) {
        let Self { values, rates, start, team, .. } = self;
        let pieces = (Cut::every(&mut values.own, 4096), Cut::every(rates, 4096));
        team.for_pieces(pieces, |piece, (own, rates): (&mut [f64], &mut [f64])| {
            let start = &start[piece * 4096..];
            for ((own, rate), start) in own.iter_mut().zip(rates).zip(start) {
                *own = stage[0] * start + stage[1] * *own + stage[2] * dt * *rate;
            }
        });
    }

    /// Adds the time of some work to a part.
    fn clocked<T>(
        &mut self,
        part: impl Fn(&mut PartTimes) -> &mut Duration,
        work: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let start = Instant::now();
        let done = work(self);
        *part(&mut self.times) += start.elapsed();
        done
    }

    /// Finds the loads on bodies where they stand, without a step.
    ///
    /// # Errors
    /// If somewhere there is no density or pressure.
    pub fn find_loads(&mut self, bodies: &[impl GasBody]) -> Result<(), NoGasError> {
        self.loads.clear();
        self.loads.resize(bodies.len(), TwoLoads::default());
        self.find_rates(bodies, true)
    }

    /// Rates of change of the leaves' points; ghosts are filled. The loads of bodies are found if
    /// asked for.
    fn find_rates(&mut self, bodies: &[impl GasBody], with_loads: bool) -> Result<(), NoGasError> {
        let length = self.values.fields * self.shape().points;
        self.rates.resize(self.values.own.len(), 0.0);
        let places = self.places();
        let Self { tree, values, settings, mask, scales, rates, team, gas_rooms, found, .. } = self;
        let pass =
            RatesPass { tree, values, settings, mask, scales, variant: self.variant, places };
        found.resize_with(tree.blocks.len(), OfBlock::default);
        let pieces = (Cut::every(rates, length), Cut::every(found, 1));
        team.for_pieces_with(pieces, gas_rooms, |room, slot, piece: (_, &mut [OfBlock])| {
            pass.find(slot, bodies, with_loads, room, piece.0, &mut piece.1[0]);
        });
        // In the order of the blocks, whichever thread found what.
        for (slot, found) in self.found.iter().enumerate() {
            if let Some(NoGas { at, density, pressure }) = found.failed {
                let at = places.padded_point(self.tree.blocks[slot], at);
                return Err(NoGasError { at, density, pressure });
            }
            let of_both = found.by_stress.iter().zip(&found.by_momentum);
            for (body, (by_stress, by_momentum)) in self.mask.near(slot).iter().zip(of_both) {
                let load = &mut self.loads[usize::from(*body)];
                load.by_stress.add_all(*by_stress);
                load.by_momentum.add_all(*by_momentum);
            }
        }
        Ok(())
    }
}
