//! The loads on the facets of deformable surfaces: what they felt becomes force and place on each.

use crate::bodies::body::Body;
use crate::bodies::body_list::Bodies;
use crate::bodies::deformable_shape::DeformableShape;
use crate::bodies::facet_sums::{FACETS_PER_PIECE, FacetSums, OnFacet};
use crate::boundary::post_collision::LinkItem;
use crate::lattice::d3q19::{cross, dot};
use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::ledger::{Ledger, add_scaled};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::budget::Budget;
use crate::solver::execution::Execution;
use crate::solver::gap_model::GapModel;
use crate::solver::gap_pressure::each_felt;
use crate::solver::lattice_state::LatticeState;
use crate::solver::moving_bodies::MovingBodies;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::survey::mirrors::mirrors_of_part;
use tremie_messages::FacetLoad;
use tremie_team::Cut;

/// Data for the loads of a surface's facets, besides the forces on their links.
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

impl<'a> Finish<'a> {
    /// Of a deformable surface.
    fn of<T: Real>(lattice: &'a LatticeState<T>, bodies: &MovingBodies, body: &Body) -> Self {
        let grid = &lattice.layout.grid;
        let mirrors = mirrors_of_part(grid, body.position);
        Self {
            grid,
            average: bodies.average_force,
            mirrors,
            copies: mirrors.iter().map(|is_cut| if *is_cut { 2.0 } else { 1.0 }).product(),
            lift: bodies.lift,
            middle: body.middle(),
            from: body.position,
            cell: lattice.units.cell,
        }
    }

    /// Makes loads of what the facets felt, and balances them.
    fn all(
        &self,
        body: &Body,
        exchange: &MomentumExchange,
        shape: &mut DeformableShape,
        balance: &mut Ledger,
        exec: &mut Execution,
    ) {
        let (facets, loads, carried, sums) = shape.parts();
        let pieces = (
            Cut::every(loads, FACETS_PER_PIECE),
            Cut::every(carried, FACETS_PER_PIECE),
            Cut::every(sums, 1),
        );
        exec.team.for_pieces(pieces, |piece, (loads, carried, sums)| {
            sums[0] = FacetSums::default();
            let all = (piece * FACETS_PER_PIECE..).zip(loads.iter_mut().zip(carried));
            for (facet, (load, carried)) in all {
                self.facet(facets.corners(facet), load, carried, &mut sums[0]);
            }
        });
        sums.iter().for_each(|sums| sums.balance(balance));
        add_scaled(&mut balance.gaps, body.pressed[0], 1.0);
        add_scaled(&mut balance.images, exchange.force, -1.0);
        add_scaled(&mut balance.images, body.pressed[0], -1.0);
        add_scaled(&mut balance.images, exchange.image, 1.0);
    }

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

    /// Adds the hydrostatic pressure and the mean pressure gradient, which the lattice does not
    /// carry: their pressure is linear, zero at the middle of the surface's volume, and exact on
    /// flat facets.
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

/// Gives the facets of deformable surfaces their loads, from what they felt, and balances them.
pub fn load_facets<T: Real>(
    lattice: &LatticeState<T>,
    bodies: &mut MovingBodies,
    gaps: &GapModel,
    budget: &mut Budget,
    exec: &mut Execution,
) {
    for place in bodies.list.rigid()..bodies.list.living.len() {
        let body = &mut bodies.list.living[place];
        let mut exchange = bodies.of_bodies[place];
        if let Some(slip) = gaps.slip_on_body(body.handle) {
            exchange.join(&slip);
        }
        bodies.total.join(&exchange);
        let Some(mut shape) = body.part.as_mut().and_then(|part| part.shape.take()) else {
            continue;
        };
        let body = &bodies.list.living[place];
        sum_felt(&mut shape, body, &bodies.links, gaps, exec);
        let finish = Finish::of(lattice, bodies, body);
        finish.all(body, &exchange, &mut shape, &mut budget.balance, exec);
        if let Some(part) = &mut bodies.list.living[place].part {
            part.shape = Some(shape);
        }
    }
}

/// Adds up what the facets of a surface felt of the fluid, of gaps, and of slipping, on all ranks. Each thread
/// looks at all of it and takes what is of its own facets.
fn sum_felt(
    shape: &mut DeformableShape,
    body: &Body,
    links: &[LinkItem],
    gaps: &GapModel,
    exec: &mut Execution,
) {
    let (in_gaps, felt) = (&gaps.in_gaps[body.items.clone()], &links[body.items.clone()]);
    let length = shape.felt.len().div_ceil(exec.team.threads()).max(1);
    let pieces = Cut::every(&mut shape.felt, length);
    exec.team.for_pieces(pieces, |piece, sums: &mut [[ExactSum; 6]]| {
        sums.fill(Default::default());
        let first = piece * length;
        let mut give = |facet: usize, force: [f64; 3], at: [f64; 3]| {
            if let Some(sums) = sums.get_mut(facet.wrapping_sub(first)) {
                let load = force.into_iter().chain(cross(at, force));
                sums.iter_mut().zip(load).for_each(|(sum, x)| sum.add(x));
            }
        };
        each_felt(felt, in_gaps, &mut give);
        for felt in gaps.slip.on_facets(body.handle) {
            give(felt.facet as usize, felt.force, felt.at);
        }
    });
    exec.ranks.join_rows(&mut shape.felt);
    for (load, sums) in shape.loads.iter_mut().zip(&shape.felt) {
        let [fx, fy, fz, tx, ty, tz] = values(sums);
        *load = [[fx, fy, fz], [tx, ty, tz]];
    }
}

/// See [`crate::LbmFluid::surface_loads`].
pub fn surface_loads(
    bodies: &Bodies,
    units: &Units,
    mut loads: &mut [FacetLoad],
    exec: &mut Execution,
) {
    let mut number = 0;
    for body in &bodies.living[bodies.rigid()..] {
        let Some((part, shape)) =
            body.part.as_ref().and_then(|part| Some((part, part.shape.as_ref()?)))
        else {
            continue;
        };
        let (reference, facets) = (part.reference(), shape.facets());
        let own = loads.split_off_mut(..shape.loads.len()).unwrap_or_default();
        // Facets are numbered through, over all surfaces of the scene.
        let (first, count) = (number, own.len());
        number += count;
        exec.team.for_pieces(Cut::every(own, FACETS_PER_PIECE), |piece, loads: &mut [_]| {
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

/// The middle of a facet.
fn middle_of(corners: [[f64; 3]; 3]) -> [f64; 3] {
    std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0)
}

/// The point of a force's line of action that is nearest to the middle of a facet, no farther from
/// it than its corners are: a force that almost cancels acts far away.
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
