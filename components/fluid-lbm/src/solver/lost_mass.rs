//! The mass that the scheme lost since the start, which nothing let out.
//!
//! Links to walls that stand still make or take some where they are interpolated and owe it (see `wall_mass`), links to bodies and
//! cells that bodies cover and uncover as they move too (see `mass_correction`):
//!
//! ```text
//! lost  = took + rho_m space                                            rho_m: the fluid's mean density
//! took  = what came through open faces and parts - change of the fluid's mass
//! space = cells that the fluid gained - volume by which moving walls receded
//! ```
//!
//! Where nothing moves `space` is zero; else it is the volume between the surfaces of bodies and the last cells, by which
//! the cells that the fluid has come and go (see `mass_correction`). Walls of spheres are closed and recede by nothing, but where bodies
//! keep accounts: those count it. A part that prescribes velocity or pressure lets fluid through, and what its links brought is no
//! loss, interpolated or not. A step in which bodies appear or vanish counts nothing: what they displace is no loss.

use crate::domain::boundary_condition::BoundaryCondition;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::solver::lbm_solver::LbmSolver;

/// What is known of it [cells at density 1].
#[derive(Clone, Copy, Debug, Default)]
pub struct Lost {
    took: f64,
    space: f64,
    /// Lost before bodies came or went for the last time.
    before: f64,
    /// The fluid's cells at the end of the last step.
    cells: usize,
    /// Whether bodies come or go in this step.
    is_other: bool,
}

impl Lost {
    /// Takes note that bodies come or go.
    pub fn change(&mut self) {
        self.is_other = true;
    }

    fn total(&self, mean: f64) -> f64 {
        self.before + self.took + mean * self.space
    }
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// Begins anew: nothing is lost.
    pub(crate) fn lose_nothing(&mut self) {
        self.patches.forgive(&mut self.fixed_items);
        self.lost = Lost { cells: self.owners.fluid_cells, ..Lost::default() };
    }

    /// Adds what a step lost, once its balance is known.
    pub(crate) fn count_lost(&mut self) {
        let cells = self.owners.fluid_cells;
        let mean = self.balance.mass / cells.max(1) as f64;
        let (through, receded) = (self.through_parts(), self.receded());
        let lost = &mut self.lost;
        if std::mem::take(&mut lost.is_other) {
            *lost = Lost { before: lost.total(mean), ..Lost::default() };
        } else {
            lost.took += self.balance.mass_open + through - self.balance.mass_change;
            lost.space += cells as f64 - lost.cells as f64 - receded;
        }
        lost.cells = cells;
        self.balance.mass_lost = lost.total(mean);
        self.ledger.mass_lost = self.balance.mass_lost * self.units.mass();
    }

    /// Mass that came in the last step through parts that let fluid through.
    fn through_parts(&self) -> f64 {
        let all = self.surroundings.laws.iter().zip(&self.fixtures);
        let lets_through = |law: &Option<BoundaryCondition>| {
            !matches!(law, None | Some(BoundaryCondition::Wall { .. }))
        };
        all.skip(usize::from(BoundaryId::FACES))
            .filter(|(law, _)| lets_through(law))
            .map(|(_, exchange)| exchange.mass)
            .sum()
    }

    /// Volume by which the walls of bodies receded in the last step, those of gaps without fluid among them.
    fn receded(&self) -> f64 {
        let counted = self.bodies.living.iter().filter(|body| self.keeps_mass || body.is_part());
        let items = counted.flat_map(|body| body.items.clone());
        items
            .map(|number| {
                let exchange = &self.exchanges[number];
                let gaps: f64 = self.link_items[number].gaps.drawn.iter().sum();
                exchange.receded + exchange.drawn + gaps
            })
            .sum()
    }
}
