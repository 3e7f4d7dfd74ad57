//! The loads on the facets of deformable surfaces: what they felt becomes force and place on each.

use crate::bodies::deformable_shape::DeformableShape;
use crate::bodies::facet_sums::{FACETS_PER_PIECE, FacetSums, OnFacet};
use crate::domain::mirrors::mirrors_of_part;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::d3q19::{cross, dot};
use crate::lattice::grid::Grid;
use crate::lattice::ledger::{Ledger, add_scaled};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::solver::gap_pressure::each_felt;
use crate::solver::lbm_solver::LbmSolver;
use tremie_messages::FacetLoad;
use tremie_team::Cut;

/// What the loads of a surface's facets depend on besides what they felt.
struct Finish<'a> {
    grid: &'a Grid,
    average: bool,
    /// Axes at which the surface is its own image, and so how often each facet is there.
    mirrors: [bool; 3],
    copies: f64,
    /// Force per volume that the lattice does not carry.
    lift: [f64; 3],
    /// Of the surface's volume, and of its reference [cells].
    middle: [f64; 3],
    from: [f64; 3],
    /// Edge of a cell [m].
    cell: f64,
}

impl Finish<'_> {
    /// Counts the load for the mirrored half too, averages it, and adds buoyancy.
    fn facet(
        &self,
        corners: [[f64; 3]; 3],
        load: &mut OnFacet,
        carried: &mut OnFacet,
        sums: &mut FacetSums,
    ) {
        *load = load.map(|v| v.map(|x| x * self.copies));
        add_scaled(&mut sums.whole, load[0], 1.0);
        if self.average {
            let half = load.map(|v| v.map(|x| 0.5 * x));
            for k in 0..2 {
                load[k] = half[k];
                add_scaled(&mut load[k], carried[k], 1.0);
            }
            *carried = half;
            add_scaled(&mut sums.carried, half[0], 1.0);
        }
        add_scaled(&mut sums.delivered, load[0], 1.0);
        if self.lift != [0.0; 3] {
            self.raise(corners, load, sums);
        }
    }

    /// Adds the hydrostatic pressure and the mean pressure gradient, which the lattice does not carry:
    /// their pressure is linear, zero at the middle of the surface's volume, and exact on flat facets.
    fn raise(&self, corners: [[f64; 3]; 3], load: &mut OnFacet, sums: &mut FacetSums) {
        let corners = corners.map(|corner| corner.map(|x| x / self.cell));
        let centre = middle_of(corners);
        let is_beyond = (0..3).any(|a| {
            let x = self.from[a] + centre[a];
            self.mirrors[a] && !(0.0..=f64::from(self.grid.n[a])).contains(&x)
        });
        if is_beyond {
            return;
        }
        let edge = |k: usize| std::array::from_fn(|a| corners[k][a] - corners[0][a]);
        let area = cross(edge(1), edge(2));
        let above = std::array::from_fn(|a| centre[a] - self.middle[a]);
        let scale = 0.5 * self.copies * dot(self.lift, above);
        let force = area.map(|x| x * scale);
        add_scaled(&mut sums.buoyancy, force, 1.0);
        add_scaled(&mut load[0], force, 1.0);
        add_scaled(&mut load[1], cross(centre, force), 1.0);
    }
}

impl FacetSums {
    /// Adds them to the balance.
    fn balance(&self, balance: &mut Ledger) {
        add_scaled(&mut balance.images, self.whole, 1.0);
        add_scaled(&mut balance.carried, self.carried, 1.0);
        add_scaled(&mut balance.delivered, self.delivered, 1.0);
        add_scaled(&mut balance.buoyancy, self.buoyancy, 1.0);
    }
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// Gives the facets of deformable surfaces their loads, from what they felt, and balances them.
    pub(crate) fn load_facets(&mut self) {
        for place in self.bodies.rigid()..self.bodies.living.len() {
            let items = self.bodies.living[place].items.clone();
            let mut exchange: MomentumExchange = self.exchanges[items].iter().sum();
            if self.slips {
                exchange.join(&self.slip.on_body(self.bodies.living[place].handle));
            }
            self.exchange.join(&exchange);
            let Some(mut shape) =
                self.bodies.living[place].part.as_mut().and_then(|part| part.shape.take())
            else {
                continue;
            };
            self.feel(place, &mut shape);
            self.finish_facets(place, &exchange, &mut shape);
            if let Some(part) = &mut self.bodies.living[place].part {
                part.shape = Some(shape);
            }
        }
    }

    /// Adds up what the facets of a surface felt of the fluid, of gaps, and of slipping. Each thread looks at all of it
    /// and takes what is of its own facets: so each facet's sum has the order of what it felt.
    fn feel(&mut self, place: usize, shape: &mut DeformableShape) {
        let items = self.bodies.living[place].items.clone();
        let (in_gaps, felt) = (&self.in_gaps[items.clone()], &self.link_items[items]);
        let slip = &self.slip;
        let handle = self.bodies.living[place].handle;
        let length = shape.loads.len().div_ceil(self.team.threads()).max(1);
        let pieces = Cut::every(&mut shape.loads, length);
        self.team.for_pieces(pieces, |piece, loads: &mut [[[f64; 3]; 2]]| {
            loads.fill([[0.0; 3]; 2]);
            let first = piece * length;
            let mut give = |facet: usize, force: [f64; 3], at: [f64; 3]| {
                if let Some(load) = loads.get_mut(facet.wrapping_sub(first)) {
                    add_scaled(&mut load[0], force, 1.0);
                    add_scaled(&mut load[1], cross(at, force), 1.0);
                }
            };
            each_felt(felt, in_gaps, &mut give);
            for felt in slip.on_facets(handle) {
                give(felt.facet as usize, felt.force, felt.at);
            }
        });
    }

    /// Makes loads of what the facets felt, and balances them.
    fn finish_facets(
        &mut self,
        place: usize,
        exchange: &MomentumExchange,
        shape: &mut DeformableShape,
    ) {
        let body = &self.bodies.living[place];
        let mirrors = mirrors_of_part(&self.layout.grid, body.position);
        let finish = Finish {
            grid: &self.layout.grid,
            average: self.average_force,
            mirrors,
            copies: mirrors.iter().map(|is_cut| if *is_cut { 2.0 } else { 1.0 }).product(),
            lift: self.lift,
            middle: body.middle(),
            from: body.position,
            cell: self.units.cell,
        };
        let (facets, loads, carried, sums) = shape.parts();
        let pieces = (
            Cut::every(loads, FACETS_PER_PIECE),
            Cut::every(carried, FACETS_PER_PIECE),
            Cut::every(sums, 1),
        );
        self.team.for_pieces(pieces, |piece, (loads, carried, sums)| {
            sums[0] = FacetSums::default();
            let all = (piece * FACETS_PER_PIECE..).zip(loads.iter_mut().zip(carried));
            for (facet, (load, carried)) in all {
                finish.facet(facets.corners(facet), load, carried, &mut sums[0]);
            }
        });
        let balance = &mut self.balance;
        sums.iter().for_each(|sums| sums.balance(balance));
        add_scaled(&mut balance.gaps, body.pressed[0], 1.0);
        add_scaled(&mut balance.images, exchange.force, -1.0);
        add_scaled(&mut balance.images, body.pressed[0], -1.0);
        add_scaled(&mut balance.images, exchange.image, 1.0);
    }

    /// See [`crate::LbmFluid::surface_loads`].
    pub fn surface_loads(&mut self, mut loads: &mut [FacetLoad]) {
        let units = &self.units;
        let mut number = 0;
        for body in &self.bodies.living[self.bodies.rigid()..] {
            let Some((part, shape)) =
                body.part.as_ref().and_then(|part| Some((part, part.shape.as_ref()?)))
            else {
                continue;
            };
            let (reference, facets) = (part.reference(), shape.facets());
            let own = loads.split_off_mut(..shape.loads.len()).unwrap_or_default();
            let (first, count) = (number, own.len());
            number += count;
            self.team.for_pieces(Cut::every(own, FACETS_PER_PIECE), |piece, loads: &mut [_]| {
                for (facet, load) in (piece * FACETS_PER_PIECE..).zip(loads) {
                    let [force, torque] = shape.loads[facet];
                    let corners = facets.corners(facet).map(|v| v.map(|x| x / units.cell));
                    let point = acting_at(corners, force, torque);
                    let world = |a: usize| units.min[a] + (reference[a] + point[a]) * units.cell;
                    *load = FacetLoad {
                        facet: (first + facet) as u64,
                        force: force.map(|f| f * units.force()),
                        point: std::array::from_fn(world),
                        stiffness: 0.0,
                    };
                }
            });
        }
    }
}

/// The middle of a facet.
fn middle_of(corners: [[f64; 3]; 3]) -> [f64; 3] {
    std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0)
}

/// The point of a force's line of action that is nearest to the middle of a facet, no farther from it
/// than its corners are: a force that almost cancels acts far away.
fn acting_at(corners: [[f64; 3]; 3], force: [f64; 3], torque: [f64; 3]) -> [f64; 3] {
    let centre = middle_of(corners);
    let about = cross(centre, force);
    let about = std::array::from_fn(|a| torque[a] - about[a]);
    let square = dot(force, force);
    if square == 0.0 {
        return centre;
    }
    let away = cross(force, about).map(|x| x / square);
    let reach = corners.iter().map(|corner| {
        let to: [f64; 3] = std::array::from_fn(|a| corner[a] - centre[a]);
        dot(to, to)
    });
    let (reach, length) = (reach.fold(0.0, f64::max).sqrt(), dot(away, away).sqrt());
    let scale = if length > reach { reach / length } else { 1.0 };
    std::array::from_fn(|a| centre[a] + scale * away[a])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_acts_on_its_line_near_the_facet() {
        let corners = [[0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 3.0, 5.0]];
        let (force, at) = ([0.0, 0.0, -2.0], [1.5, 0.5, 5.0]);
        let point = acting_at(corners, force, cross(at, force));
        assert!((0..3).all(|a| (point[a] - at[a]).abs() < 1e-12), "{point:?}");
        // A pair of forces that leaves next to nothing.
        let far = acting_at(corners, [0.0, 0.0, 1e-9], [1.0, 0.0, 0.0]);
        assert!((0..3).all(|a| (far[a] - [1.0, 1.0, 5.0][a]).abs() < 2.3), "{far:?}");
        assert_eq!(acting_at(corners, [0.0; 3], [1.0; 3]), [1.0, 1.0, 5.0]);
    }
}
