//! Intakes: the cells at which fluid that gaps draw in leaves the fluid.
//!
//! A gap that holds no fluid draws some in as it widens, and presses it out as it narrows. Pressure
//! and flow belong together: what a gap does on the sound around is its pressure times what it
//! draws in, and where the one is taken from another place than the other, a shut valve feeds some
//! of that sound. So each probe that says a gap's pressure is an *intake*, and its share of what
//! the gap draws in goes through the links of moving parts to which it is the nearest by way of the
//! fluid: on its side of the gap. A gap without probes has none: its body pays for it all along its
//! surface; and so it does where an intake has no links.

use crate::boundary::wall_distances::WallDistances;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::exact_sum::BinnedSum;
use crate::lattice::layout::Layout;
use crate::lattice::layout::faces;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use crate::ranks::whole_ways::WholeWays;
use std::collections::{BTreeMap, VecDeque};
use tremie_fluid_kit::cells::obstacles::Obstacles;
use tremie_state::{StateError, StateExchange};

/// Entry of the table of cells where no modelled gap is.
pub const NO_GAP: u16 = u16::MAX;

/// Gaps that hold no fluid, as links need them.
#[derive(Clone, Debug, Default)]
pub struct GapTables {
    /// Distances of cells from static walls along links, if gaps press.
    pub walls: Option<WallDistances>,
    /// For each stored cell the modelled gap that it may be frozen in; empty without such gaps.
    pub gap_of: Vec<u16>,
    /// True if walls slip in such gaps.
    pub slips: bool,
    /// Places through which such gaps draw fluid in.
    pub sinks: GapSinks,
}

/// A probe that says a gap's pressure.
#[derive(Clone, Copy, Debug)]
pub struct SinkProbe<'a> {
    /// Number among all probes.
    pub number: usize,
    /// Its weight in the gap's pressure.
    pub weight: f64,
    /// Its cells, with their weights.
    pub cells: &'a [(u32, f64)],
}

/// Near no intake.
const FAR: u16 = u16::MAX;

/// The intakes of the gaps of a scene.
#[derive(Clone, Debug, Default)]
pub struct GapSinks {
    list: Vec<Intake>,
    /// Of each gap those through which it draws in fluid, and the share of each.
    shares: Vec<Vec<(u16, f64)>>,
    /// Cells of the probes, by intake, until the nearest were looked for.
    seeds: Vec<(u16, u32)>,
    /// For each stored cell the intake nearest by way of the fluid, once it was looked for.
    nearest: Vec<u16>,
}

/// Intake of a gap: links at which its share of the drawn mass leaves the fluid.
#[derive(Clone, Copy, Debug, Default)]
struct Intake {
    /// Mass that it has still to take from the fluid.
    due: f64,
    /// Sum of `6 w_i rho` over its links in the last step, and what each gives for a unit of it.
    weight: f64,
    rate: f64,
}

/// Sums over the links that gave to an intake.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Sum of `6 w_i rho` over them.
    pub weight: BinnedSum,
    /// Mass that they took from the fluid.
    pub mass: BinnedSum,
}

impl GapSinks {
    /// Of gaps, in their order, each by the probes that say its pressure.
    pub fn new<'p>(gaps: impl Iterator<Item = Vec<SinkProbe<'p>>>) -> Self {
        let mut own = Self::default();
        let mut of_probes = BTreeMap::new();
        for gap in gaps {
            let weights: f64 = gap.iter().map(|probe| probe.weight).sum();
            let shares = gap.iter().map(|probe| {
                let intake = of_probes.entry(probe.number).or_insert_with(|| own.add(probe.cells));
                (*intake, probe.weight / weights)
            });
            let shares = shares.collect();
            own.shares.push(shares);
        }
        own
    }

    /// Adds the intake of a probe's cells.
    fn add(&mut self, cells: &[(u32, f64)]) -> u16 {
        let number = self.list.len() as u16;
        self.list.push(Intake::default());
        self.seeds.extend(cells.iter().map(|&(cell, _)| (number, cell)));
        number
    }

    /// Number of them.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Finds for each cell the nearest, if that is not known: through fluid outside of gaps first,
    /// then through what bodies cover there now and may leave later, then into the gaps.
    pub fn look(
        &mut self,
        in_gap: &[u16],
        flags: &CellFlags,
        layout: &Layout,
        (numbers, obstacles, ranks): (&WholeNumbers, &Obstacles, &Ranks),
    ) {
        if !self.nearest.is_empty() || self.list.is_empty() {
            return;
        }
        let order = |cell: u32| {
            let is_in_gap = in_gap[cell as usize] != NO_GAP;
            2 * u8::from(is_in_gap) + u8::from(!flags.is_fluid(cell))
        };
        let mut seeds = std::mem::take(&mut self.seeds);
        seeds.sort_unstable();
        if ranks.is_alone() {
            let around =
                |cell: u32, visit: &mut dyn FnMut(u32)| faces(layout, cell).for_each(visit);
            self.nearest = spread(in_gap.len(), &seeds, order, around);
            return;
        }
        let whole = WholeWays::gather(layout, order, (numbers, obstacles, ranks));
        let own = seeds.iter().filter(|(_, cell)| layout.is_own(*cell));
        let told: Vec<i64> =
            own.flat_map(|&(k, cell)| [k.into(), numbers.in_whole(cell).into()]).collect();
        let all = ranks.collect(&told);
        let mut seeds: Vec<_> = all.chunks_exact(2).map(|s| (s[0] as u16, s[1] as u32)).collect();
        seeds.sort_unstable();
        let order = |cell: u32| whole.order(cell);
        let around = |cell: u32, visit: &mut dyn FnMut(u32)| whole.faces(cell, visit);
        let nearest = spread(whole.len(), &seeds, order, around);
        let here = |cell: u32| nearest[numbers.in_whole(cell) as usize];
        self.nearest = (0..layout.cells.len() as u32).map(here).collect();
    }

    /// Keeps what is due at the intakes and which is nearest to each of `cells` cells, or puts it
    /// back.
    ///
    /// # Errors
    /// A state of other gaps.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
        cells: usize,
    ) -> Result<(), StateError> {
        let get = |intake: &Intake| [intake.due, intake.weight, intake.rate];
        let set = |intake: &mut Intake, [due, weight, rate]: [f64; 3]| {
            *intake = Intake { due, weight, rate };
        };
        state.column("intakes", &mut self.list, get, set)?;
        // They depend on which cells were fluid when they were looked for.
        let mut are_known = !self.nearest.is_empty();
        state.value("nearest_are_known", &mut are_known)?;
        if !are_known {
            return Ok(());
        }
        self.nearest.resize(cells, FAR);
        self.seeds.clear();
        numbers.exchange_values(state, "nearest_intakes", &mut self.nearest)
    }

    /// Memory that the table takes [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.nearest.as_slice())
    }

    /// The intake of a link at a cell, and what it gives there for each unit of `6 w_i rho`.
    #[inline]
    pub fn at(&self, cell: u32) -> Option<(usize, f64)> {
        let number = usize::from(*self.nearest.get(cell as usize)?);
        Some((number, self.list.get(number)?.rate))
    }

    /// Takes over what a gap drew in, as far as there are links to take it, and returns that part.
    pub fn draw(&mut self, gap: u16, mass: f64) -> f64 {
        let mut part = 0.0;
        for &(intake, share) in &self.shares[usize::from(gap)] {
            let intake = &mut self.list[usize::from(intake)];
            if intake.weight > 0.0 {
                intake.due += share * mass;
                part += share * mass;
            }
        }
        part
    }

    /// Begins to settle a step: what the links of parts gave is due no more, of each intake the weight and
    /// the mass. Returns what nobody can give, because the links of an intake have gone.
    pub fn receive(&mut self, given: impl Iterator<Item = [f64; 2]>) -> f64 {
        for (intake, [weight, mass]) in self.list.iter_mut().zip(given) {
            intake.weight = weight;
            intake.due -= mass;
        }
        let gone = self.list.iter_mut().filter(|intake| intake.weight == 0.0);
        gone.map(|intake| std::mem::take(&mut intake.due)).sum()
    }

    /// Decides what the coming step takes: all that is due.
    pub fn decide(&mut self) {
        for intake in &mut self.list {
            intake.rate = if intake.weight > 0.0 { intake.due / intake.weight } else { 0.0 };
        }
    }

    /// Mass that they have still to take.
    pub fn due(&self) -> f64 {
        self.list.iter().map(|intake| intake.due).sum()
    }
}

/// The intake nearest to each of so many cells, from these cells of intakes on, by way of the cells around; those of
/// a lower order first.
fn spread(
    cells: usize,
    seeds: &[(u16, u32)],
    order: impl Fn(u32) -> u8,
    around: impl Fn(u32, &mut dyn FnMut(u32)),
) -> Vec<u16> {
    let mut nearest = vec![FAR; cells];
    let mut reached = [const { VecDeque::new() }; 4];
    for &(intake, cell) in seeds {
        nearest[cell as usize] = intake;
        reached[0].push_back(cell);
    }
    while let Some(cell) = reached.iter_mut().find_map(VecDeque::pop_front) {
        let intake = nearest[cell as usize];
        around(cell, &mut |next| {
            if nearest[next as usize] == FAR {
                nearest[next as usize] = intake;
                reached[usize::from(order(next))].push_back(next);
            }
        });
    }
    nearest
}

impl Given {
    /// A link of `6 w_i rho` gave at a rate.
    #[inline]
    pub fn add(&mut self, weight: f64, rate: f64) {
        self.weight.add(weight);
        self.mass.add(rate * weight);
    }
}
