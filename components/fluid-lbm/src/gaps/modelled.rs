//! Gaps that the scene declares: which of their cells are frozen, and what presses in them.
//!
//! The thickness of a gap at a cell is the distance of the cell's centre from one side plus that
//! from the other: between two flat walls their distance, wherever the cell is between them. It
//! counts where the ways to the two sides are opposite to within 26 degrees: beside the end of a
//! gap they are not. A cell of a gap is frozen, which is solid to its neighbours, while the
//! thickness is less than `open_at`; once it is fluid it stays so down to `close_at`. A cell that a
//! body uncovers begins frozen, unless the gap there is open. Thickness is found anew with the
//! cells of the moving side (see `mesh_body`).
//!
//! As cells freeze, fluid cells may be left with no way through faces of cells to more than
//! [`POCKET`] others: such pockets are frozen too, until a neighbour becomes fluid. (One that hangs
//! on by a diagonal link fills and empties through that alone, and its pressure runs away.)
//!
//! The sides feel the pressure of the gap on their links into frozen cells, and on gap links
//! between them (see `unresolved_gaps`). Freezing takes a cell's mass and momentum from the fluid
//! as covering does, and the moving side's account has it (see `mass_correction`); a cell that
//! thaws gets the mean density of the fluid around, or that of the gap. The fluid that a gap draws
//! in as it widens leaves the rest where its pressure is measured (see `intake`).

mod mouths;
mod slipping;
mod thickness;

use self::mouths::Mouths;
use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::boundary::boundaries::Boundaries;
use crate::boundary::gap_sinks::{GapSinks, NO_GAP, SinkProbe};
use crate::boundary::post_collision::{PostCollision, density};
use crate::gaps::pockets::FillEnd;
use crate::lattice::cell_flags::{CellFlags, FLUID, FROZEN, VACATED, Vacated};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::layout::{Layout, items_in_blocks};
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::ops::Range;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::probes::sampling::samples;
use tremie_messages::scene::{Gap, GapRegion, GapRule, GapSide, Scene};
use tremie_state::{StateError, StateExchange};
use tremie_team::{Cut, Team};

/// Fluid cells with a way to fewer others than this are a pocket.
pub const POCKET: usize = 64;

/// Candidates that are one item of work.
const CELLS_PER_ITEM: usize = 256;

/// Steps by which the pressure of probes is extrapolated: it is as old as the beginning of its
/// step, half a one; forces are averaged with those of the step before, half a one; and the mass
/// that the gap draws in is paid half a step after the side has moved. A late pressure feeds the
/// sound around, as a late wall does (see [`late`](crate::bodies::body::late)).
const LEAD: f64 = 1.5;

/// One side of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wall {
    /// A face of the domain.
    Face { axis: usize, side: usize },
    /// A static solid, by its place.
    Solid(usize),
    /// A part that moves or a surface that deforms, by its number among parts and then surfaces.
    Part(usize),
}

/// A gap of the scene.
#[derive(Clone, Debug)]
struct Declared {
    sides: [Wall; 2],
    open_at: f32,
    close_at: f32,
    slip_below: f32,
    region: Option<GapRegion>,
    rule: GapRule,
    /// Probes that say the pressure.
    probes: Vec<Weighted>,
    /// Sum over the fluid cells next to frozen ones of the density minus 1, and their number.
    around: [ExactSum; 2],
    /// Density minus 1 by the rule; by probes, when it acts (see [`LEAD`]).
    drho: f64,
    /// True if both of its sides are there; `is_new`: they came with the last measurement.
    is_there: bool,
    is_new: bool,
}

/// A probe that says the pressure of a gap.
#[derive(Clone, Debug)]
struct Weighted {
    /// Its number in the scene.
    number: usize,
    weight: f64,
    /// Its cells and their weights.
    cells: Vec<(u32, f64)>,
    /// Sum over those of them that are fluid of weight and density minus 1, and of the weights.
    sums: [ExactSum; 2],
    /// Density minus 1 when it was last measured, if it was.
    last: Option<f64>,
}

impl Weighted {
    fn as_sink(&self) -> SinkProbe<'_> {
        SinkProbe { number: self.number, weight: self.weight, cells: &self.cells }
    }
}

/// A cell that may be in a gap.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cell: u32,
    gap: u16,
    /// Distance from the sides that stand still, and the way to the first of them.
    still: f32,
    way: [f32; 3],
    thickness: f32,
    /// The axis nearest to the direction across the gap.
    axis: u8,
}

/// The gaps of a scene, and their cells.
#[derive(Clone, Debug, Default)]
pub struct ModelledGaps {
    gaps: Vec<Declared>,
    candidates: Vec<Candidate>,
    /// For each stored cell its gap, and its place among the candidates.
    of: Vec<u16>,
    place: Vec<u32>,
    /// Candidates that are one item of work: of one block.
    items: Vec<Range<usize>>,
    /// Of each item, the cells that freeze or thaw in this step, with their gaps.
    turning: Vec<Vec<(u32, u16)>>,
    /// Frozen cells of no gap.
    pub pockets: Vec<u32>,
    mouths: Mouths,
    /// Room for the cells that may have become pockets, and whether they have.
    pub seeds: Vec<u32>,
    /// See there.
    pub closed: Vec<FillEnd>,
    /// Impulse of the last step on frozen cells.
    pub impulse: [f64; 3],
    centres: Centres,
    /// True if thickness was measured at all.
    is_measured: bool,
}

impl ModelledGaps {
    /// Of a scene that was checked.
    pub fn new(
        scene: &Scene,
        surroundings: &Boundaries,
        layout: &Layout,
        centres: Centres,
    ) -> Self {
        if scene.gaps.is_empty() {
            return Self::default();
        }
        let count = layout.cells.len();
        let mut own = Self {
            gaps: scene.gaps.iter().map(|gap| declared(gap, scene, surroundings, layout)).collect(),
            candidates: Vec::new(),
            of: vec![NO_GAP; count],
            place: vec![u32::MAX; count],
            items: Vec::new(),
            turning: Vec::new(),
            pockets: Vec::with_capacity(count / 16),
            mouths: Mouths::with_room(count),
            seeds: Vec::with_capacity(count / 4),
            closed: Vec::with_capacity(count / 4),
            impulse: [0.0; 3],
            centres,
            is_measured: false,
        };
        for cell in 0..count as u32 {
            let point = centres.of(layout.at(cell));
            // Of several gaps near a cell, the first of the scene has it.
            let candidate = (0..own.gaps.len()).find_map(|k| {
                let (still, way) = own.gaps[k].still(point, layout, surroundings, &centres)?;
                Some(Candidate {
                    cell,
                    gap: k as u16,
                    still: still as f32,
                    way: way.map(|x| x as f32),
                    thickness: f32::INFINITY,
                    axis: 0,
                })
            });
            own.candidates.extend(candidate);
        }
        for (place, candidate) in (0..).zip(&own.candidates) {
            own.of[candidate.cell as usize] = candidate.gap;
            own.place[candidate.cell as usize] = place;
        }
        let cells: Vec<u32> = own.candidates.iter().map(|candidate| candidate.cell).collect();
        own.items = items_in_blocks(&cells, CELLS_PER_ITEM).collect();
        own.turning = own.items.iter().map(|item| Vec::with_capacity(item.len())).collect();
        own
    }

    /// Keeps pressures and pockets, or puts them back. Thickness and mouths follow from bodies and
    /// cells.
    ///
    /// # Errors
    /// A state of other gaps.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError> {
        state.value("are_measured", &mut self.is_measured)?;
        for (k, gap) in self.gaps.iter_mut().enumerate() {
            state.within(&format!("gap{k}"), |state| gap.exchange(state))?;
        }
        let mut pockets = numbers.kept(&self.pockets);
        state.shared_list("pockets", &mut pockets)?;
        if !pockets.is_sorted() {
            return state.unfit("the pockets of the state are none of this lattice");
        }
        if state.restores() {
            self.pockets = numbers.stored(&pockets);
        }
        Ok(())
    }

    /// For each stored cell the gap that it may be frozen in.
    pub fn by_cell(&self) -> &[u16] {
        &self.of
    }

    /// Number of the gaps.
    pub fn len(&self) -> usize {
        self.gaps.len()
    }

    /// True if the scene declares none.
    pub fn is_empty(&self) -> bool {
        self.gaps.is_empty()
    }

    /// True if thickness has to be measured for the first time.
    pub fn is_fresh(&self) -> bool {
        !self.is_empty() && !self.is_measured
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        let candidate = size_of::<Candidate>() + size_of::<(u32, u16)>();
        self.of.len() * 7 + self.candidates.len() * candidate
    }

    /// The gap of a frozen cell.
    fn of(&self, cell: u32) -> Option<u16> {
        self.of.get(cell as usize).copied().filter(|&gap| gap != NO_GAP)
    }

    /// The gap between a part of the scene and something that stands still, at a point as lattice
    /// coordinates.
    pub fn between(&self, part: usize, fixture: BoundaryId, at: [f64; 3]) -> Option<u16> {
        let still = match fixture.as_solid() {
            Some(number) => Wall::Solid(number),
            None => {
                let face = usize::from(fixture.0);
                Wall::Face { axis: face / 2, side: face % 2 }
            }
        };
        let point = std::array::from_fn(|a| self.centres.min[a] + at[a] * self.centres.cell);
        let is_it = |gap: &Declared| {
            gap.sides.contains(&still)
                && gap.sides.contains(&Wall::Part(part))
                && gap.region.is_none_or(|region| region.contains(point))
        };
        self.gaps.iter().position(is_it).map(|k| k as u16)
    }

    /// The side that stands still of a gap, if there is one.
    pub fn still_side(&self, gap: u16) -> Option<usize> {
        self.gaps[usize::from(gap)].sides.iter().find_map(|side| match *side {
            Wall::Face { axis, side } => Some(usize::from(BoundaryId::face(axis, side).0)),
            Wall::Solid(number) => Some(usize::from(BoundaryId::solid(number as u16).0)),
            Wall::Part(_) => None,
        })
    }

    /// Handle of a body that opens a gap: the account of pockets that no body adjoins.
    pub fn any_mover(&self, bodies: &Bodies) -> Option<u32> {
        self.gaps.iter().find_map(|gap| gap.mover(bodies)).map(|body| body.handle)
    }

    /// Density minus 1 in a gap that holds no fluid.
    pub fn drho(&self, gap: u16) -> f64 {
        self.gaps[usize::from(gap)].drho
    }

    /// Density minus 1 of a cell that thaws with no fluid around.
    pub fn drho_at(&self, cell: u32) -> f64 {
        self.of(cell).map_or(0.0, |gap| self.drho(gap))
    }

    /// Measures the thickness at all cells that may be in gaps.
    pub fn measure(&mut self, layout: &Layout, bodies: &Bodies, team: &mut Team) {
        self.is_measured = true;
        for gap in &mut self.gaps {
            let is_there = gap.sides.iter().all(|side| match side {
                Wall::Part(index) => body_of(bodies, *index).is_some(),
                Wall::Face { .. } | Wall::Solid(_) => true,
            });
            (gap.is_new, gap.is_there) = (is_there && !gap.is_there, is_there);
        }
        let gaps = &self.gaps;
        let items = Cut::every(&mut self.candidates, CELLS_PER_ITEM);
        team.for_pieces(items, |_, item: &mut [Candidate]| {
            for candidate in item {
                let gap = &gaps[usize::from(candidate.gap)];
                (candidate.thickness, candidate.axis) = gap.thickness(layout, bodies, candidate);
            }
        });
    }

    /// Candidate of a cell, if it has one.
    fn candidate(&self, cell: u32) -> Option<&Candidate> {
        self.candidates.get(*self.place.get(cell as usize)? as usize)
    }

    /// The candidates of an item of work.
    fn item(&self, number: usize) -> &[Candidate] {
        &self.candidates[self.items[number].clone()]
    }

    /// Freezes and thaws cells, between the bodies' claims and [`CellFlags::settle`].
    pub fn freeze(&mut self, flags: &mut CellFlags, bodies: &Bodies, team: &mut Team) {
        let mut turning = std::mem::take(&mut self.turning);
        team.for_each(&mut turning, |number, turning| {
            let turns = self.item(number).iter().filter(|candidate| self.turns(flags, candidate));
            turning.clear();
            turning.extend(turns.map(|candidate| (candidate.cell, candidate.gap)));
        });
        for &(cell, gap) in turning.iter().flatten() {
            if flags.of(cell) != FROZEN {
                flags.freeze(cell);
            } else if let Some(body) = self.gaps[usize::from(gap)].mover(bodies) {
                flags.thaw(Vacated { cell, handle: body.handle });
            }
        }
        self.turning = turning;
        for gap in &mut self.gaps {
            gap.is_new = false;
        }
    }

    /// True if a cell freezes or thaws.
    fn turns(&self, flags: &CellFlags, candidate: &Candidate) -> bool {
        let &Candidate { cell, thickness, gap, .. } = candidate;
        let gap = &self.gaps[usize::from(gap)];
        match flags.of(cell) {
            FLUID => thickness < gap.close_at || (gap.is_new && thickness < gap.open_at),
            VACATED => thickness < gap.open_at,
            FROZEN => thickness >= gap.open_at && !self.is_pocket(cell),
            _ => false,
        }
    }

    /// Reflects the links into frozen cells half-way, and finds the pressure by probes.
    pub fn reflect<T: Real>(&mut self, after: &PostCollision<T>, ranks: &mut Ranks) {
        if self.is_empty() {
            return;
        }
        probes_of(&mut self.gaps).for_each(|probe| probe.look(after));
        ranks.add_up(probes_of(&mut self.gaps).flat_map(|probe| &mut probe.sums));
        for gap in &mut self.gaps {
            let (mut sum, mut weights) = (0.0, 0.0);
            for probe in &mut gap.probes {
                if let Some(drho) = probe.measure() {
                    sum += probe.weight * drho;
                    weights += probe.weight;
                }
            }
            gap.drho = if weights > 0.0 { sum / weights } else { 0.0 };
        }
        self.reflect_mouths(after, ranks);
    }

    /// The intakes of gaps.
    pub fn intakes(&self) -> GapSinks {
        let gaps = self.gaps.iter();
        GapSinks::new(gaps.map(|gap| gap.probes.iter().map(Weighted::as_sink).collect()))
    }

    /// Settles the pressures of gaps whose rule is the nearest fluid; `found` gives for a gap the
    /// sum of densities next to gap links and their number.
    pub fn settle_nearest(&mut self, found: impl Fn(u16) -> [f64; 2]) {
        for (k, gap) in (0..).zip(&mut self.gaps) {
            if gap.rule == GapRule::Nearest {
                let [drho, cells] = found(k);
                let around = values(&gap.around);
                let (drho, cells) = (drho + around[0], cells + around[1]);
                gap.drho = if cells > 0.0 { drho / cells } else { 0.0 };
            }
        }
    }
}

impl Weighted {
    /// Looks at those of its cells that this rank counts.
    fn look<T: Real>(&mut self, after: &PostCollision<T>) {
        self.sums = Default::default();
        let counts = |cell: u32| after.flags.is_fluid(cell) && after.layout.is_own(cell);
        for &(cell, part) in self.cells.iter().filter(|(cell, _)| counts(*cell)) {
            self.sums[0].add(part * (density(&after.post(cell)) - 1.0));
            self.sums[1].add(part);
        }
    }

    /// Density minus 1 at the time when it acts, see [`LEAD`]; what it was where no cell of the
    /// probe is fluid. `None` before it was measured.
    fn measure(&mut self) -> Option<f64> {
        let [drho, all] = values(&self.sums);
        if all == 0.0 {
            return self.last;
        }
        let now = drho / all;
        let before = self.last.replace(now).unwrap_or(now);
        Some(now + LEAD * (now - before))
    }
}

impl Declared {
    fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("drho", &mut self.drho)?;
        state.value("is_there", &mut self.is_there)?;
        for probe in &mut self.probes {
            state.value(&format!("probe{}", probe.number), &mut probe.last)?;
        }
        Ok(())
    }

    /// The body that opens it.
    fn mover<'a>(&self, bodies: &'a Bodies) -> Option<&'a Body> {
        self.sides.iter().find_map(|side| match side {
            Wall::Part(index) => body_of(bodies, *index),
            _ => None,
        })
    }
}

/// The probes that say the pressures of gaps.
fn probes_of(gaps: &mut [Declared]) -> impl Iterator<Item = &mut Weighted> {
    gaps.iter_mut().flat_map(|gap| &mut gap.probes)
}

/// The body that a part of the scene is.
fn body_of(bodies: &Bodies, index: usize) -> Option<&Body> {
    bodies.living.iter().find(|body| body.part.as_ref().is_some_and(|part| part.index == index))
}

fn declared(gap: &Gap, scene: &Scene, surroundings: &Boundaries, layout: &Layout) -> Declared {
    let centres = surroundings.ground().centres();
    let side = |side: &GapSide| match side {
        GapSide::Face { axis, side } => Wall::Face { axis: *axis, side: *side },
        GapSide::Part(name) => {
            // Surfaces are numbered after all parts, see `MeshBody::index`.
            let parts = scene.parts.iter().map(|part| &part.name);
            let mut names = parts.chain(scene.surfaces.iter().map(|surface| &surface.name));
            let index = names.position(|known| known == name).unwrap_or_default();
            let solid = surroundings.ground().solids.iter();
            let solid = solid.enumerate().find(|(_, solid)| solid.part == Some(index));
            solid.map_or(Wall::Part(index), |(number, _)| Wall::Solid(number))
        }
    };
    let weights = match &gap.pressure {
        GapRule::Probes(weights) => weights.as_slice(),
        GapRule::Zero | GapRule::Nearest => &[],
    };
    let probes = weights.iter().filter_map(|w| {
        let number = scene.probes.iter().position(|probe| probe.name == w.probe)?;
        let cells = samples(&layout.grid, &centres, &scene.probes[number].shape).into_iter();
        let cells = cells.filter_map(|(at, part)| Some((layout.cell(at)?, part)));
        Some(Weighted {
            number,
            weight: w.weight,
            cells: cells.collect(),
            sums: Default::default(),
            last: None,
        })
    });
    Declared {
        sides: [side(&gap.between[0]), side(&gap.between[1])],
        open_at: gap.open_at as f32,
        close_at: gap.close_at as f32,
        slip_below: gap.slip_below as f32,
        region: gap.region,
        rule: gap.pressure.clone(),
        probes: probes.collect(),
        around: Default::default(),
        drho: 0.0,
        is_there: false,
        is_new: false,
    }
}
