//! The pressure in gaps that hold no cell, and what it gives to bodies and what stands still; see
//! `unresolved_gaps`.

use crate::bodies::body_list::Bodies;
use crate::boundary::post_collision::LinkItem;
use crate::boundary::unresolved_gaps::{Gap, Gaps, OtherSide, ROOM};
use crate::lattice::d3q19::cross;
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::solver::execution::Execution;
use crate::solver::gap_model::GapModel;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_team::Cut;

/// Items whose gaps one thread looks at together.
const ITEMS_PER_PIECE: usize = 32;

/// Density minus 1 in each gap of an item of links.
pub type InGaps = [f64; ROOM];

/// In gaps of which nothing is known yet.
pub const UNKNOWN: InGaps = [0.0; ROOM];

/// The gaps that an item found, apart from it and in one piece of memory: those across look at
/// them, and those who add up walk through all.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Place of the body among the living.
    body: u32,
    count: u32,
    /// Other side of each, apart from the gaps: others search these.
    across: [OtherSide; ROOM],
    gaps: [Gap; ROOM],
}

impl Seen {
    /// No gaps.
    pub const NONE: Self =
        Self { body: 0, count: 0, across: [OtherSide::FROZEN; ROOM], gaps: [Gap::NONE; ROOM] };

    /// Takes those of an item of the body in a place.
    pub fn take(&mut self, body: usize, gaps: &Gaps) {
        (self.body, self.count) = (body as u32, gaps.list.len() as u32);
        for (k, gap) in gaps.list.iter().enumerate() {
            (self.across[k], self.gaps[k]) = (gap.across, *gap);
        }
    }

    /// The gaps.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps[..self.count as usize]
    }

    /// Place of the body among the living.
    pub fn body(&self) -> usize {
        self.body as usize
    }

    /// Those of which it is wanted what is across.
    pub fn to(&self, wanted: impl Fn(OtherSide) -> bool) -> impl Iterator<Item = &Gap> {
        let all = self.across[..self.count as usize].iter().zip(&self.gaps);
        all.filter(move |(across, _)| wanted(**across)).map(|(_, gap)| gap)
    }
}

/// Sum of the densities around a body's gaps that `wanted` says, and number of the cells.
fn around(seen: &[Seen], wanted: impl Fn(OtherSide) -> bool) -> [f64; 2] {
    let gaps = seen.iter().flat_map(|seen| seen.to(&wanted));
    gaps.fold([0.0; 2], |[drho, cells], gap| [drho + gap.drho, cells + gap.cells])
}

/// Density minus 1 in the gap between a body and something.
fn drho_in(seen: &[Seen], bodies: &Bodies, place: usize, across: OtherSide) -> f64 {
    let seen_by = |place: usize| &seen[bodies.living[place].items.clone()];
    let own = seen_by(place);
    let mut found = around(own, |to| to == across);
    if let Some(other) = across.as_body() {
        let other = seen_by(bodies.place_of(other));
        let back = across.seen_back(bodies.living[place].handle);
        let [drho, cells] = around(other, |to| to == back);
        found = [found[0] + drho, found[1] + cells];
    }
    if found[1] == 0.0 {
        found = around(own, |_| true);
    }
    if found[1] == 0.0 { 0.0 } else { found[0] / found[1] }
}

/// Calls `give` with the facet, force and place of everything that the facets of a deformable
/// surface felt of the fluid and of gaps, from its items of links and the densities in their gaps.
pub fn each_felt(
    items: &[LinkItem],
    in_gaps: &[InGaps],
    mut give: impl FnMut(usize, [f64; 3], [f64; 3]),
) {
    for (item, drho) in items.iter().zip(in_gaps) {
        for felt in &item.gaps.felt {
            let scale = drho.get(usize::from(felt.gap)).copied().unwrap_or(1.0);
            give(felt.facet as usize, felt.force.map(|f| f * scale), felt.at);
        }
    }
}

impl GapModel {
    /// Finds the densities in the gaps of all items.
    fn find_densities(&mut self, bodies: &Bodies, exec: &mut Execution) {
        let Self { press, modelled, seen, in_gaps, .. } = self;
        let pieces = Cut::every(in_gaps, ITEMS_PER_PIECE);
        exec.team.for_pieces(pieces, |number, piece: &mut [InGaps]| {
            for (own, in_gaps) in seen[number * ITEMS_PER_PIECE..].iter().zip(piece) {
                for (gap, drho) in own.gaps().iter().zip(in_gaps) {
                    *drho = match gap.across.as_declared() {
                        Some(number) => modelled.drho(number),
                        None if *press => drho_in(seen, bodies, own.body(), gap.across),
                        None => 0.0,
                    };
                }
            }
        });
    }

    /// Finds what the pressure in gaps gives to bodies and fixtures, from what the links' search
    /// found; `references` are the points of fixtures about which torques count.
    pub fn press_on(
        &mut self,
        bodies: &mut Bodies,
        grid: &Grid,
        references: &[[f64; 3]],
        exec: &mut Execution,
    ) {
        if !self.feels_gaps() {
            return;
        }
        let seen = &self.seen;
        self.modelled.settle_nearest(|gap| around(seen, |to| to == OtherSide::declared(gap)));
        self.find_densities(bodies, exec);
        self.pressed.fill(MomentumExchange::default());
        for body in &mut bodies.living {
            let mut load = [[0.0; 3]; 2];
            let items = body.items.clone();
            let of_items = self.seen[items.clone()].iter().zip(&self.in_gaps[items]);
            for (gap, &drho) in of_items.flat_map(|(seen, drho)| seen.gaps().iter().zip(drho)) {
                let part = gap.load.map(|v| v.map(|x| x * drho));
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
