//! The pressure in gaps that hold no cell, and what it gives to bodies and what stands still; see
//! `unresolved_gaps`.

use crate::bodies::body_list::Bodies;
use crate::boundary::post_collision::LinkItem;
use crate::boundary::unresolved_gaps::{FORCE_UNIT, Gap, OtherSide};
use crate::lattice::d3q19::cross;
use crate::lattice::exact_sum::{ExactSum, LIMBS, values};
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::ranks::rank_sums::Ranks;
use crate::solver::execution::Execution;
use crate::solver::gap_model::GapModel;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_team::Cut;

/// Bodies whose gaps one thread looks at together.
const BODIES_PER_PIECE: usize = 32;

/// Gaps of a body for which there is room from the start: as many as equal spheres can touch one.
pub const ROOM: usize = 12;

/// A gap of a body, of all its links.
#[derive(Clone, Copy, Debug)]
struct BodyGap {
    across: OtherSide,
    /// See [`Gap`].
    drho: ExactSum,
    cells: i64,
    force: [i64; 3],
    torque: [ExactSum; 3],
}

impl BodyGap {
    fn to(across: OtherSide) -> Self {
        let (drho, torque) = Default::default();
        Self { across, drho, cells: 0, force: [0; 3], torque }
    }

    /// Adds what an item of links found.
    fn add(&mut self, gap: &Gap) {
        gap.drho.add_to(&mut self.drho);
        self.cells += i64::from(gap.cells);
        for a in 0..3 {
            self.force[a] += i64::from(gap.force[a]);
            gap.torque[a].add_to(&mut self.torque[a]);
        }
    }

    /// Adds what other ranks found.
    fn join(&mut self, other: &Self) {
        self.drho += other.drho;
        self.cells += other.cells;
        for a in 0..3 {
            self.force[a] += other.force[a];
            self.torque[a] += other.torque[a];
        }
    }

    /// Force and torque on the body at a density minus 1.
    fn load(&self, drho: f64) -> [[f64; 3]; 2] {
        let force = self.force.map(|count| count as f64 * FORCE_UNIT);
        [force, values(&self.torque)].map(|v| v.map(|x| x * drho))
    }
}

/// The gaps of a body, by what is across.
#[derive(Clone, Debug)]
pub struct BodyGaps {
    gaps: Vec<BodyGap>,
}

impl BodyGaps {
    /// None, with room.
    pub fn with_room() -> Self {
        Self { gaps: Vec::with_capacity(ROOM) }
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        size_of::<BodyGap>() * self.gaps.capacity()
    }

    /// The gap to something, listed if it is not yet.
    fn to(&mut self, across: OtherSide) -> &mut BodyGap {
        let place = self.gaps.binary_search_by_key(&across, |gap| gap.across);
        let place = place.unwrap_or_else(|place| {
            self.gaps.insert(place, BodyGap::to(across));
            place
        });
        &mut self.gaps[place]
    }

    /// Becomes those that items of links found.
    fn collect(&mut self, items: &[LinkItem]) {
        self.gaps.clear();
        for gap in items.iter().flat_map(|item| &item.gaps.list) {
            self.to(gap.across).add(gap);
        }
    }

    /// Sum of the densities around the gaps to something, and number of the cells.
    fn around(&self, across: OtherSide) -> (ExactSum, i64) {
        let found = self.gaps.binary_search_by_key(&across, |gap| gap.across);
        found.map_or_else(|_| Default::default(), |k| (self.gaps[k].drho, self.gaps[k].cells))
    }
}

/// Density minus 1 in the gap between a body and something.
fn drho_in(all: &[BodyGaps], bodies: &Bodies, place: usize, gap: &BodyGap) -> f64 {
    let (mut drho, mut cells) = (gap.drho, gap.cells);
    if let Some(other) = gap.across.as_body() {
        let back = gap.across.seen_back(bodies.living[place].handle);
        let other = all[bodies.place_of(other)].around(back);
        drho += other.0;
        cells += other.1;
    }
    if cells == 0 {
        for own in &all[place].gaps {
            drho += own.drho;
            cells += own.cells;
        }
    }
    if cells == 0 { 0.0 } else { drho.value() / cells as f64 }
}

/// Calls `give` with the facet, force and place of everything that the facets of a deformable
/// surface felt of the fluid and of gaps, from its items of links and the densities in their gaps.
pub fn each_felt(
    items: &[LinkItem],
    in_gaps: &[Vec<f64>],
    mut give: impl FnMut(usize, [f64; 3], [f64; 3]),
) {
    for (item, drho) in items.iter().zip(in_gaps) {
        for felt in &item.gaps.felt {
            let scale = drho.get(usize::from(felt.gap)).copied().unwrap_or(1.0);
            give(felt.facet as usize, felt.force.map(|f| f * scale), felt.at);
        }
    }
}

/// Numbers that carry a gap to other ranks: body, what is across, cells, force, and the sums.
const NUMBERS: usize = 6 + 4 * LIMBS;

impl GapModel {
    /// Collects the gaps of each body.
    fn collect(&mut self, bodies: &Bodies, links: &[LinkItem], exec: &mut Execution) {
        let pieces = Cut::every(&mut self.of_bodies, BODIES_PER_PIECE);
        exec.team.for_pieces(pieces, |number, piece: &mut [BodyGaps]| {
            let first = number * BODIES_PER_PIECE;
            for (body, own) in bodies.living[first..].iter().zip(piece) {
                own.collect(&links[body.items.clone()]);
            }
        });
        share(&mut self.of_bodies, &mut exec.ranks);
    }

    /// Finds the densities in the gaps of all bodies.
    fn find_densities(&mut self, bodies: &Bodies, exec: &mut Execution) {
        let Self { press, modelled, of_bodies, drho, .. } = self;
        let pieces = Cut::every(drho, BODIES_PER_PIECE);
        exec.team.for_pieces(pieces, |number, piece: &mut [Vec<f64>]| {
            for (place, drho) in (number * BODIES_PER_PIECE..).zip(piece) {
                drho.clear();
                drho.extend(of_bodies[place].gaps.iter().map(
                    |gap| match gap.across.as_declared() {
                        Some(number) => modelled.drho(number),
                        None if *press => drho_in(of_bodies, bodies, place, gap),
                        None => 0.0,
                    },
                ));
            }
        });
    }

    /// Tells the items of deformable surfaces the densities in their gaps.
    fn tell_facets(&mut self, bodies: &Bodies, links: &[LinkItem]) {
        for place in bodies.rigid()..bodies.living.len() {
            let (own, drho) = (&self.of_bodies[place], &self.drho[place]);
            for number in bodies.living[place].items.clone() {
                let in_gaps = &mut self.in_gaps[number];
                in_gaps.clear();
                in_gaps.extend(links[number].gaps.list.iter().map(|gap| {
                    let found = own.gaps.binary_search_by_key(&gap.across, |gap| gap.across);
                    found.map_or(0.0, |k| drho[k])
                }));
            }
        }
    }

    /// Finds what the pressure in gaps gives to bodies and fixtures, from what the links' search
    /// found; `references` are the points of fixtures about which torques count.
    pub fn press_on(
        &mut self,
        bodies: &mut Bodies,
        links: &[LinkItem],
        (grid, references): (&Grid, &[[f64; 3]]),
        exec: &mut Execution,
    ) {
        if !self.feels_gaps() {
            return;
        }
        self.collect(bodies, links, exec);
        let all = &self.of_bodies;
        self.modelled.settle_nearest(|gap| {
            let (mut drho, mut cells) = (ExactSum::default(), 0);
            for (own, count) in all.iter().map(|body| body.around(OtherSide::declared(gap))) {
                drho += own;
                cells += count;
            }
            [drho.value(), cells as f64]
        });
        self.find_densities(bodies, exec);
        self.tell_facets(bodies, links);
        self.pressed.fill(MomentumExchange::default());
        let found = self.of_bodies.iter().zip(&self.drho);
        for (body, (own, drho)) in bodies.living.iter_mut().zip(found) {
            let mut load = [[0.0; 3]; 2];
            for (gap, &drho) in own.gaps.iter().zip(drho) {
                let part = gap.load(drho);
                add_scaled(&mut load[0], part[0], 1.0);
                add_scaled(&mut load[1], part[1], 1.0);
                let still = match gap.across.as_declared() {
                    Some(number) => self.modelled.still_side(number),
                    None => gap.across.as_fixture(),
                };
                if let Some(number) = still {
                    // From the fixture's reference to the body, by the shortest way.
                    let arm = grid.shortest(references[number], body.position);
                    let fixture = &mut self.pressed[number];
                    add_scaled(&mut fixture.force, part[0], -1.0);
                    add_scaled(&mut fixture.torque, part[1], -1.0);
                    add_scaled(&mut fixture.torque, cross(arm, part[0]), -1.0);
                }
            }
            body.pressed = load;
        }
    }
}

/// Makes the gaps that this rank found those of all ranks.
fn share(all: &mut [BodyGaps], ranks: &mut Ranks) {
    if ranks.is_alone() {
        return;
    }
    let own =
        all.iter().enumerate().flat_map(|(place, own)| own.gaps.iter().map(move |g| (place, g)));
    let numbers: Vec<i64> = own.flat_map(|(place, gap)| gap.numbers(place)).collect();
    all.iter_mut().for_each(|own| own.gaps.clear());
    for numbers in ranks.collect(&numbers).chunks_exact(NUMBERS) {
        let (place, gap) = BodyGap::from_numbers(numbers);
        if let Some(own) = all.get_mut(place) {
            own.to(gap.across).join(&gap);
        }
    }
}

impl BodyGap {
    /// The gap of the body in a place as numbers.
    fn numbers(&self, place: usize) -> impl Iterator<Item = i64> {
        let [x, y, z] = self.force;
        let head = [place as i64, self.across.number().into(), self.cells, x, y, z];
        let [a, b, c] = self.torque;
        head.into_iter().chain([self.drho, a, b, c].into_iter().flat_map(|sum| sum.limbs()))
    }

    /// Place of a body, and its gap, of such numbers.
    fn from_numbers(numbers: &[i64]) -> (usize, Self) {
        let (head, sums) = numbers.split_at(6);
        let sum =
            |k: usize| ExactSum::from_limbs(std::array::from_fn(|limb| sums[k * LIMBS + limb]));
        let gap = Self {
            across: OtherSide::numbered(head[1] as u32),
            drho: sum(0),
            cells: head[2],
            force: [head[3], head[4], head[5]],
            torque: [sum(1), sum(2), sum(3)],
        };
        (head[0] as usize, gap)
    }
}
