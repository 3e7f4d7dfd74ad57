//! Bodies in the fluid with their links: bounce-back at walls that move, and what it exchanges.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::boundary::link_batch::Batch;
use crate::boundary::post_collision::{LinkItem, PostCollision, items};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::solver::deformable_surfaces::AwaitedSurfaces;
use crate::solver::execution::Execution;
use crate::solver::gap_pressure::Seen;
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
    pub exchanges: Vec<MomentumExchange>,
    /// Sum of what all bodies exchanged.
    pub total: MomentumExchange,
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
        self.exchanges = vec![MomentumExchange::default(); self.links.len()];
    }

    /// Most cells that bodies can cover or uncover in a step: fewer than their shells' rows, see
    /// `Body::new`.
    pub fn most_changes(&self) -> usize {
        self.list.living.iter().map(Body::most_changes).sum()
    }

    /// Forgets what links exchanged: the start exchange knows no flow yet.
    pub fn forget_exchange(&mut self) {
        self.total = MomentumExchange::default();
        self.exchanges.fill(MomentumExchange::default());
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

    /// Reflects the populations that ran into bodies; `seen` takes the gaps that links found, if
    /// gaps press.
    pub fn bounce_back<T: Real>(
        &mut self,
        after: &PostCollision<T>,
        seen: &mut [Seen],
        exec: &mut Execution,
    ) {
        let bodies = &self.list;
        let items = (Cut::every(&mut self.links, 1), Cut::every(&mut self.exchanges, 1));
        let reflect = |batch: &mut Batch, item: &mut LinkItem, exchange: &mut MomentumExchange| {
            *exchange = after.reflect(bodies, item, batch);
        };
        let Execution { team, batches, .. } = exec;
        if after.gaps.walls.is_some() {
            let items = (items.0, items.1, Cut::every(seen, 1));
            team.for_pieces_with(items, batches, |batch, _, (item, exchange, seen)| {
                reflect(batch, &mut item[0], &mut exchange[0]);
                seen[0].take(item[0].body, &item[0].gaps);
            });
        } else {
            team.for_pieces_with(items, batches, |batch, _, (item, exchange)| {
                reflect(batch, &mut item[0], &mut exchange[0]);
            });
        }
    }

    /// Writes what came back along the links that bodies cut, after all others were reflected. One
    /// after the other: the first of several bodies has a link.
    pub fn write_cuts<T: Real>(&mut self, after: &PostCollision<T>) {
        let with_surface = self.list.items_with_surface();
        let items = self.links[with_surface.clone()].iter();
        for (item, exchange) in items.zip(&mut self.exchanges[with_surface]) {
            let body = &self.list.living[item.body];
            exchange.join(&after.write_cuts(body, item.found.cuts()));
        }
    }

    /// Volume by which the walls of bodies receded in the last step, those of gaps without fluid
    /// among them.
    pub fn receded(&self) -> f64 {
        let counted = self.list.living.iter().filter(|body| self.keeps_mass || body.is_part());
        let items = counted.flat_map(|body| body.items.clone());
        items
            .map(|number| {
                let exchange = &self.exchanges[number];
                let gaps: f64 = self.links[number].gaps.drawn.iter().sum();
                exchange.receded + exchange.drawn + gaps
            })
            .sum()
    }

    /// Memory that bodies and links take [bytes].
    pub fn bytes(&self) -> usize {
        self.list.living.iter().map(Body::bytes).sum::<usize>()
            + self.links.iter().map(LinkItem::bytes).sum::<usize>()
            + size_of_val(self.exchanges.as_slice())
    }
}
