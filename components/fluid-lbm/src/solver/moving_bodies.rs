//! Bodies in the fluid with their links: bounce-back at walls that move, and what it exchanges.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::boundary::post_collision::{LinkItem, PostCollision, items};
use crate::lattice::momentum_exchange::{ExchangeTally, MomentumExchange};
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use crate::solver::deformable_surfaces::AwaitedSurfaces;
use crate::solver::execution::Execution;
use crate::solver::gap_flows::GapFlows;
use crate::solver::moving_boundaries::Filled;
use tremie_team::Cut;

/// Bodies, their links into the fluid, and rules of their loads.
pub struct MovingBodies {
    /// The bodies, with their places.
    pub list: Bodies,
    /// Deformable surfaces whose vertices have not come yet.
    pub awaited: AwaitedSurfaces,
    /// Links from the fluid into bodies, in items of work.
    pub links: Vec<LinkItem>,
    /// Exchange of each item in the last step.
    pub exchanges: Vec<ExchangeTally>,
    /// That of each of the living, all of its items together.
    pub of_bodies: Vec<MomentumExchange>,
    /// Sum of what all bodies exchanged.
    pub total: MomentumExchange,
    /// What parts exchanged with declared gaps.
    pub gap_flows: GapFlows,
    /// Cells that bodies uncovered in this step.
    pub refills: Vec<Filled>,
    /// True if bodies keep accounts of the mass that they owe; see `mass_correction`.
    pub keeps_mass: bool,
    /// True if loads are means over two steps.
    pub average_force: bool,
    /// Force per volume of a body by hydrostatic pressure and mean pressure gradient.
    pub lift: [f64; 3],
}

impl MovingBodies {
    /// Makes the items of the bodies' links; those of parts that press count for so many declared
    /// gaps and sinks.
    pub fn list_links(&mut self, gaps_press: bool, counts: [usize; 2]) {
        self.links = items(&mut self.list, gaps_press, counts);
        self.gap_flows = GapFlows::of(counts);
        self.exchanges = vec![ExchangeTally::default(); self.links.len()];
        self.of_bodies.resize(self.list.living.len(), MomentumExchange::default());
    }

    /// Most cells that bodies can cover or uncover in a step: fewer than their shells' rows, see
    /// `Body::new`.
    pub fn most_changes(&self) -> usize {
        self.list.living.iter().map(Body::most_changes).sum()
    }

    /// Forgets what links exchanged: the start exchange knows no flow yet.
    pub fn forget_exchange(&mut self) {
        self.total = MomentumExchange::default();
        self.exchanges.fill(ExchangeTally::default());
        self.links.iter_mut().for_each(|item| item.gaps.clear());
    }

    /// Reads the links between two fluid cells that bodies cut, before any link is reflected; true
    /// if there are some.
    pub fn read_cuts<T: Real>(&mut self, after: &PostCollision<T>, exec: &mut Execution) -> bool {
        let bodies = &self.list;
        let cut = &mut self.links[bodies.items_with_surface()];
        let any_cut = cut.iter().any(|item| !item.found.cuts().is_empty());
        if any_cut {
            exec.team.for_each(cut, |_, item| {
                after.read_cuts(&bodies.living[item.body], item.found.cuts_mut());
            });
        }
        any_cut
    }

    /// Reflects the populations that ran into bodies.
    pub fn bounce_back<T: Real>(&mut self, after: &PostCollision<T>, exec: &mut Execution) {
        let bodies = &self.list;
        let items = (Cut::every(&mut self.links, 1), Cut::every(&mut self.exchanges, 1));
        let Execution { team, batches, .. } = exec;
        team.for_pieces_with(items, batches, |batch, _, (item, exchange)| {
            exchange[0] = after.reflect(bodies, &mut item[0], batch);
        });
    }

    /// Writes what came back along the links that bodies cut, after all others were reflected. One
    /// after the other: the first of several bodies has a link.
    pub fn write_cuts<T: Real>(&mut self, after: &PostCollision<T>) {
        let with_surface = self.list.items_with_surface();
        let items = self.links[with_surface.clone()].iter();
        for (item, exchange) in items.zip(&mut self.exchanges[with_surface]) {
            let body = &self.list.living[item.body];
            *exchange += &after.write_cuts(body, item.found.cuts());
        }
    }

    /// Volume by which the walls of bodies receded in the last step, those of gaps without fluid
    /// among them.
    pub fn receded(&self) -> f64 {
        let mut parts = 0..;
        let all = self.list.living.iter().zip(&self.of_bodies);
        let counted = all.filter(|(body, _)| self.keeps_mass || body.is_part());
        let of_body = |(body, exchange): (&Body, &MomentumExchange)| {
            let part = body.is_part().then(|| parts.next()).flatten();
            let of_gaps = part.map_or(0.0, |part| self.gap_flows.drawn(part).sum());
            exchange.receded + exchange.drawn + of_gaps
        };
        counted.map(of_body).sum()
    }

    /// Adds up what the items of each body exchanged, and the cells that changed hands, of all ranks.
    pub fn join_exchanges(&mut self, ranks: &mut Ranks) {
        self.gap_flows.collect(&self.list.living, &self.links, ranks);
        let of_items = |body: &Body| {
            let mut sum = ExchangeTally::default();
            self.exchanges[body.items.clone()].iter().for_each(|item| sum += item);
            sum
        };
        if ranks.is_alone() {
            for (body, whole) in self.list.living.iter().zip(&mut self.of_bodies) {
                *whole = of_items(body).value();
            }
            return;
        }
        let mut tallies: Vec<_> = self.list.living.iter().map(of_items).collect();
        ranks.join_few(&mut tallies);
        let wholes = self.of_bodies.iter_mut().zip(tallies);
        wholes.for_each(|(whole, tally)| *whole = tally.value());
        if self.keeps_mass {
            let living = self.list.living.iter_mut();
            ranks.add_up(living.flat_map(|body| &mut body.account.changed));
        }
    }

    /// Memory that bodies and links take [bytes].
    pub fn bytes(&self) -> usize {
        self.list.living.iter().map(Body::bytes).sum::<usize>()
            + self.links.iter().map(LinkItem::bytes).sum::<usize>()
            + size_of_val(self.exchanges.as_slice())
    }
}
