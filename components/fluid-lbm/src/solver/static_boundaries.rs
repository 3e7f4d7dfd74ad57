//! Static surroundings of the fluid with their links: curved and sliding walls, solids, and the
//! forces on them.

use crate::boundary::boundaries::{Boundaries, Built};
use crate::boundary::post_collision::PostCollision;
use crate::boundary::sheet_links::{SheetItem, SheetLinks};
use crate::boundary::static_wall_links::{StaticWallLinks, WallItem};
use crate::boundary::virtual_piston::part_surface::ReservoirSurface;
use crate::boundary::wall_mass::{Brought, Patches};
use crate::domain::boundary_condition::{BoundaryCondition, BoundaryValue};
use crate::gaps::specular_walls::SpecularWalls;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::collision_kernel::CellBlock;
use crate::lattice::exact_sum::{ExactSum, add_vector, values};
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::{ExchangeTally, MomentumExchange};
use crate::lattice::populations::Real;
use crate::lattice::reflection_impulse::ReflectionImpulse;
use crate::ranks::rank_sums::Ranks;
use crate::solver::execution::Execution;
use crate::solver::lattice_state::LatticeState;
use std::ops::Range;
use tremie_fluid_kit::survey::mirrors::{mirrors_of_part, with_image};
use tremie_messages::Load;
use tremie_state::{StateError, StateExchange};

/// Faces and static solids, and their links that need work.
pub struct StaticBoundaries {
    /// Their geometry, and the conditions that they prescribe over time.
    pub conditions: Boundaries,
    /// Values that fixtures prescribe at the end of the step.
    pub now: Vec<BoundaryValue>,
    /// Links at curved walls, walls that slide, and regions that prescribe something.
    pub links: StaticWallLinks,
    /// Their items of work.
    pub items: Vec<WallItem>,
    /// Links between two cells of the fluid that solids cut.
    pub sheets: SheetLinks,
    /// Their items of work.
    pub sheet_items: Vec<SheetItem>,
    /// Patches of wall that pay back what links take.
    pub patches: Patches,
    /// Mass that links brought to the cells at each open face in the last step, `2 axis + side`.
    pub brought: [Brought; 6],
    /// Exchange of each fixture in the last step.
    pub exchanges: Vec<MomentumExchange>,
    /// Force of the fluid on each symmetry plane, `2 axis + side`.
    pub mirrors: [[f64; 3]; 6],
    /// Room for sums over fixtures.
    tallies: Vec<ExchangeTally>,
}

impl StaticBoundaries {
    /// With the links that were found.
    pub fn new<T: Real>(conditions: Boundaries, built: &mut Built<T>) -> Self {
        let fixtures = conditions.laws.len();
        Self {
            conditions,
            now: vec![BoundaryValue::Wall([0.0; 3]); fixtures],
            links: std::mem::take(&mut built.fixed),
            items: std::mem::take(&mut built.fixed_items),
            sheets: std::mem::take(&mut built.sheets),
            sheet_items: std::mem::take(&mut built.sheet_items),
            patches: std::mem::take(&mut built.patches),
            brought: Default::default(),
            exchanges: vec![MomentumExchange::default(); fixtures],
            mirrors: [[0.0; 3]; 6],
            tallies: vec![ExchangeTally::default(); fixtures],
        }
    }

    /// Keeps what is owed and what was exchanged in the last step, or puts it back.
    ///
    /// # Errors
    /// A state of other walls.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let fixtures = self.exchanges.len();
        self.patches.exchange(&mut self.items, state)?;
        state.value("exchanges", &mut self.exchanges)?;
        state.array("on_mirrors", &mut self.mirrors)?;
        match self.exchanges.len() == fixtures {
            true => Ok(()),
            false => state.unfit("the state is that of other walls"),
        }
    }

    /// Sets what boundaries prescribe in the step of a length that ends at a time [s].
    pub fn prescribe(&mut self, end: f64, step: f64) {
        for (law, now) in self.conditions.laws.iter().zip(&mut self.now) {
            if let Some(prescribed) = law.as_ref().and_then(|law| law.in_step(end, step)) {
                *now = prescribed;
            }
        }
    }

    /// Reflects the populations that ran into static walls.
    pub fn bounce_back<T: Real>(&mut self, after: &PostCollision<T>, exec: &mut Execution) {
        let Self { conditions, now, links, items, sheets, sheet_items, .. } = self;
        let references = &conditions.references;
        exec.team.for_each(sheet_items, |_, item| after.read_sheets(sheets, item));
        exec.team.for_each(items, |_, item| after.reflect_fixed(links, now, references, item));
        exec.team.for_each(sheet_items, |_, item| after.balance_sheets(sheets, references, item));
        self.brought = Patches::brought(&self.items, &mut exec.ranks);
    }

    /// Adds up what the fluid exchanged with each fixture; returns what symmetry planes gave to it,
    /// along their axes.
    pub fn join_exchanges(
        &mut self,
        (blocks, own): (&[CellBlock], Range<usize>),
        tally: &ReflectionImpulse,
        slip: Option<&SpecularWalls>,
        surfaces: &[ReservoirSurface],
        ranks: &mut Ranks,
    ) -> [f64; 3] {
        let mut mirrors = [[ExactSum::default(); 3]; 6];
        self.tallies.fill(ExchangeTally::default());
        for number in own.clone() {
            let share = |fixture: BoundaryId, impulse: [f64; 3]| {
                let back = impulse.map(|x| -x);
                add_vector(&mut self.tallies[usize::from(fixture.0)].force, back);
            };
            tally.share(number, &blocks[number].reflected, &mut mirrors, share);
        }
        let curved = self.items.iter().filter(|item| item.is_own).flat_map(|item| &item.exchanges);
        let halfway = blocks[own].iter().flat_map(|block| &block.halfway.exchanges);
        let sheets = self.sheet_items.iter().filter(|item| item.is_own);
        let sheets = sheets.flat_map(|item| &item.exchanges);
        for (BoundaryId(number), exchange) in curved.chain(sheets).chain(halfway) {
            self.tallies[usize::from(*number)].add(exchange);
        }
        for (BoundaryId(number), exchange) in surfaces.iter().flat_map(ReservoirSurface::exchanges)
        {
            self.tallies[usize::from(number)].add(exchange);
        }
        ranks.add_up(mirrors.iter_mut().flatten());
        ranks.join_tallies(&mut self.tallies);
        for (fixture, tally) in self.exchanges.iter_mut().zip(&self.tallies) {
            *fixture = tally.value();
        }
        let mirrors = mirrors.each_ref().map(values);
        if let Some(slip) = slip {
            for (number, fixture) in self.exchanges.iter_mut().enumerate() {
                fixture.join(&slip.on_fixture(number));
            }
        }
        self.mirrors = mirrors.map(|impulse| impulse.map(|x| -x));
        std::array::from_fn(|a| mirrors[2 * a][a] + mirrors[2 * a + 1][a])
    }

    /// Mass that came in the last step through parts that let fluid through.
    pub fn through_parts(&self) -> f64 {
        let all = self.conditions.laws.iter().zip(&self.exchanges);
        let lets_through = |law: &Option<BoundaryCondition>| {
            !matches!(law, None | Some(BoundaryCondition::Wall { .. }))
        };
        all.skip(usize::from(BoundaryId::FACES))
            .filter(|(law, _)| lets_through(law))
            .map(|(_, exchange)| exchange.mass)
            .sum()
    }

    /// See [`crate::LbmFluid::loads_on_parts`]; `lift` is the force per volume that the lattice
    /// does not carry.
    pub fn loads_on_parts<T: Real>(
        &self,
        lattice: &LatticeState<T>,
        lift: [f64; 3],
        loads: &mut Vec<Load>,
    ) {
        let (force, length) = (lattice.units.force(), lattice.units.cell);
        loads.clear();
        loads.extend(self.conditions.parts().map(|(fixture, part)| {
            let exchange = &self.exchanges[fixture];
            let origin = self.conditions.references[fixture];
            let mirrors = mirrors_of_part(&lattice.layout.grid, origin);
            let mut whole = with_image(mirrors, [exchange.force, exchange.torque]);
            let buoyancy = self.conditions.displaced[fixture].load(lift);
            for (whole, buoyancy) in whole.iter_mut().zip(buoyancy) {
                add_scaled(whole, buoyancy, 1.0);
            }
            Load {
                id: part as u64,
                force: whole[0].map(|f| f * force),
                torque: whole[1].map(|t| t * force * length),
            }
        }));
    }

    /// See [`crate::LbmFluid::wall_forces`]; `unit` is that of force.
    pub fn wall_forces(&self, unit: f64) -> [[[f64; 3]; 2]; 3] {
        std::array::from_fn(|axis| {
            std::array::from_fn(|side| {
                let number = 2 * axis + side;
                let (wall, mirror) = (self.exchanges[number].force, self.mirrors[number]);
                std::array::from_fn(|a| (wall[a] + mirror[a]) * unit)
            })
        })
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.links.bytes() + self.sheets.bytes()
    }
}
