//! Gaps that hold no fluid: those that the scene declares, and those that links see across.

use crate::bodies::body_list::Bodies;
use crate::boundary::boundaries::Boundaries;
use crate::boundary::gap_sinks::GapTables;
use crate::boundary::wall_distances::WallDistances;
use crate::domain::parameters::{GapPressure, Parameters};
use crate::gaps::modelled::ModelledGaps;
use crate::gaps::specular_walls::SpecularWalls;
use crate::lattice::d3q19::{CS2, Q};
use crate::lattice::layout::Layout;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::solver::execution::Execution;
use crate::solver::gap_pressure::{BodyGaps, ROOM};
use crate::solver::lattice_state::LatticeState;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::cells::obstacles::Obstacles;
use tremie_messages::scene::Scene;
use tremie_state::{StateError, StateExchange};

/// The gaps of a scene, what fills them, and what they give.
pub struct GapModel {
    /// True if gaps without cells press on bodies.
    pub press: bool,
    /// Gaps that the scene declares.
    pub modelled: ModelledGaps,
    /// The same as links need them.
    pub tables: GapTables,
    /// Links that slip in them.
    pub slip: SpecularWalls,
    /// The gaps of each body, if gaps press, and the densities minus 1 in them.
    pub of_bodies: Vec<BodyGaps>,
    /// See there.
    pub drho: Vec<Vec<f64>>,
    /// Density minus 1 in the gaps of each item of links, of surfaces that deform.
    pub in_gaps: Vec<Vec<f64>>,
    /// Exchange of gaps without cells with each fixture.
    pub pressed: Vec<MomentumExchange>,
}

impl GapModel {
    /// Of a scene that was checked, for a fluid of a relaxation time.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        boundaries: &Boundaries,
        layout: &Layout,
        centres: Centres,
        tau: f64,
    ) -> Self {
        let modelled = ModelledGaps::new(scene, boundaries, layout, centres);
        let slips = modelled.any_slips() && (tau - 0.5) * CS2 < parameters.slip_viscosity;
        let press = parameters.gap_pressure == GapPressure::Nearest;
        let feels_gaps = press || !modelled.is_empty();
        Self {
            press,
            tables: GapTables {
                walls: feels_gaps.then(WallDistances::default),
                gap_of: modelled.by_cell().to_vec(),
                slips,
                sinks: modelled.intakes(),
            },
            slip: if slips {
                SpecularWalls::in_gaps(&modelled, layout)
            } else {
                SpecularWalls::default()
            },
            modelled,
            of_bodies: Vec::new(),
            drho: Vec::new(),
            in_gaps: Vec::new(),
            pressed: vec![MomentumExchange::default(); boundaries.laws.len()],
        }
    }

    /// True if the links' search looks across gaps that hold no fluid.
    pub fn feels_gaps(&self) -> bool {
        self.tables.walls.is_some()
    }

    /// Keeps what earlier steps left in declared gaps, or puts it back; `cells` is the number of
    /// stored cells.
    ///
    /// # Errors
    /// A state of other gaps.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
        cells: usize,
    ) -> Result<(), StateError> {
        if self.modelled.is_empty() {
            return Ok(());
        }
        self.modelled.exchange(state, numbers)?;
        self.tables.sinks.exchange(state, numbers, cells)
    }

    /// Finds what follows from a state: thickness, and then as [`GapModel::find_openings`].
    pub fn resume<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        obstacles: &Obstacles,
        bodies: &Bodies,
        exec: &mut Execution,
    ) {
        if !self.modelled.is_empty() && !self.modelled.is_fresh() {
            self.modelled.measure(&lattice.layout, bodies, &mut exec.team);
            self.find_openings(lattice, obstacles, bodies, exec);
        }
    }

    /// Makes room for what so many items of links of so many bodies find.
    pub fn make_room(&mut self, items: usize, bodies: usize) {
        let bodies = if self.feels_gaps() { bodies } else { 0 };
        self.of_bodies.resize_with(bodies, BodyGaps::with_room);
        self.drho.resize_with(bodies, || Vec::with_capacity(ROOM));
        self.in_gaps.resize(items, Vec::new());
    }

    /// Handle of the body that covers a cell or cut it off from the fluid.
    pub fn holder_of<T: Real>(
        &self,
        lattice: &LatticeState<T>,
        bodies: &Bodies,
        cell: u32,
    ) -> Option<u32> {
        let (flags, layout) = (&lattice.flags, &lattice.layout);
        let of_neighbours = || (1..Q).find_map(|i| flags.holder(layout.neighbour(cell, i)?));
        let of_gaps = || self.modelled.any_mover(bodies);
        flags.holder(cell).or_else(of_neighbours).or_else(of_gaps)
    }

    /// Freezes and thaws cells of gaps, and decides which cells are isolated.
    pub fn freeze<T: Real>(
        &mut self,
        lattice: &mut LatticeState<T>,
        bodies: &Bodies,
        exec: &mut Execution,
    ) {
        let LatticeState { layout, flags, numbers, .. } = lattice;
        if self.modelled.is_empty() {
            return flags.settle(layout);
        }
        if bodies.parts_moved() || self.modelled.is_fresh() {
            self.modelled.measure(layout, bodies, &mut exec.team);
        }
        self.modelled.freeze(flags, bodies, &mut exec.team);
        flags.settle(layout);
        self.modelled.close_pockets(flags, layout, numbers, (&mut exec.team, &mut exec.ranks));
    }

    /// Finds what follows from which cells are frozen: openings, sinks, links that slip.
    pub fn find_openings<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        obstacles: &Obstacles,
        bodies: &Bodies,
        exec: &mut Execution,
    ) {
        let LatticeState { layout, flags, numbers, .. } = lattice;
        if !self.modelled.is_empty() {
            self.modelled.find_mouths(flags, layout);
            let whole = (numbers, obstacles, &exec.ranks);
            self.tables.sinks.look(self.modelled.by_cell(), flags, layout, whole);
        }
        if self.tables.slips {
            self.slip.find(&self.modelled, bodies, flags, layout, &mut exec.team);
        }
    }

    /// The addition of slipping to a body's exchange, if anything slips.
    pub fn slip_on_body(&self, handle: u32) -> Option<MomentumExchange> {
        self.tables.slips.then(|| self.slip.on_body(handle))
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.modelled.bytes()
            + self.tables.sinks.bytes()
            + self.tables.walls.as_ref().map_or(0, WallDistances::bytes)
            + self.of_bodies.iter().map(BodyGaps::bytes).sum::<usize>()
    }
}
