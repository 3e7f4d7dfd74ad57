//! Damping of the fluid in narrow gaps, an option: a model of what the grid does not resolve there
//! (Chen, Zhang, Zang & Ning, *J. Fluids Struct.* 91 (2019) 102772, sec. 2.4).
//!
//! Where two round bodies, or one and a wall, are nearer than a gap, the velocities of particles in
//! a band along the contact's tangent are reduced:
//!
//! ```text
//! u := C u,   C = beta + (1 - beta) min(1, |s| / l)        l two cells, thickness a cell on each side
//! ```
//!
//! with the distance `s` from the contact point along the tangent. It takes momentum out of the fluid
//! that nothing gets; the solver keeps the account.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::cell_order::CellOrder;
use crate::particles::particle_arrays::ParticleArrays;
use crate::solids::open_fractions::OpenFractions;
use crate::solids::rigid_body::{BodyShape, RigidBody};

/// Half length of a band, in edges of cells.
const HALF_LENGTH: f64 = 2.0;
/// Half thickness of a band, in edges of cells.
const HALF_THICKNESS: f64 = 1.0;

/// Settings of the damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapDamping {
    /// Part of the velocity that is left at the contact point in a step; 1 damps nothing.
    pub beta: f64,
    /// Width of the gap from which on there is a contact [m].
    pub gap: f64,
}

/// A contact: its point, in the middle of the gap, and the normal across it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GapContact<const D: usize> {
    point: [f64; D],
    normal: [f64; D],
}

/// Finds contacts, and damps the particles there.
#[derive(Clone, Debug, Default)]
pub struct GapBands<const D: usize> {
    contacts: Vec<GapContact<D>>,
    /// Bodies by their lower end along the first axis.
    order: Vec<u32>,
    /// Momentum that the last step took from the fluid [kg m/s].
    pub taken: [f64; 3],
}

impl<const D: usize> GapBands<D> {
    /// Damps the particles of a step, which are in the order of their cells.
    pub fn damp(
        &mut self,
        damping: &GapDamping,
        grid: &StaggeredGrid<D>,
        (fractions, bodies): (&OpenFractions<D>, &[RigidBody<D>]),
        order: &CellOrder,
        particles: &mut ParticleArrays<D>,
    ) {
        self.find_pairs(damping.gap, bodies);
        self.find_walls(damping.gap, grid, fractions, bodies);
        self.taken = [0.0; 3];
        let Self { contacts, taken, .. } = self;
        for contact in contacts.iter() {
            contact.damp(damping.beta, grid, order, particles, taken);
        }
    }

    /// Contacts of two round bodies, by a sweep along the first axis.
    fn find_pairs(&mut self, gap: f64, bodies: &[RigidBody<D>]) {
        let Self { contacts, order, .. } = self;
        contacts.clear();
        let low = |k: u32| bodies[k as usize].bounds()[0][0];
        order.clear();
        order.extend((0..bodies.len() as u32).filter(|&k| bodies[k as usize].is_round()));
        order.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
        for (place, &first) in order.iter().enumerate() {
            let one = &bodies[first as usize];
            let end = one.bounds()[1][0] + gap;
            for &second in order[place + 1..].iter().take_while(|&&k| low(k) <= end) {
                contacts.extend(GapContact::of_pair(gap, one, &bodies[second as usize]));
            }
        }
    }

    /// Contacts with closed faces of the box, and with solids at rest.
    fn find_walls(
        &mut self,
        gap: f64,
        grid: &StaggeredGrid<D>,
        fractions: &OpenFractions<D>,
        bodies: &[RigidBody<D>],
    ) {
        for body in bodies {
            let BodyShape::Ball(radius) = body.shape else { continue };
            let mut touch = |distance: f64, normal: [f64; D]| {
                let width = distance - radius;
                if width < gap {
                    let reach = radius + 0.5 * width;
                    let point = std::array::from_fn(|a| body.centre[a] - reach * normal[a]);
                    self.contacts.push(GapContact { point, normal });
                }
            };
            for a in 0..D {
                for (side, end) in [grid.origin, grid.end()].into_iter().enumerate() {
                    if fractions.is_closed(a, side) {
                        let sign = [1.0, -1.0][side];
                        let normal = std::array::from_fn(|k| if k == a { sign } else { 0.0 });
                        touch(sign * (body.centre[a] - end[a]), normal);
                    }
                }
            }
            for solid in &fractions.at_rest {
                if let Some((height, normal)) = solid.height(body.centre, radius + gap) {
                    touch(height, normal);
                }
            }
        }
    }
}

impl<const D: usize> GapContact<D> {
    fn of_pair(gap: f64, one: &RigidBody<D>, other: &RigidBody<D>) -> Option<Self> {
        let (BodyShape::Ball(first), BodyShape::Ball(second)) = (&one.shape, &other.shape) else {
            return None;
        };
        let arm: [f64; D] = std::array::from_fn(|a| other.centre[a] - one.centre[a]);
        let distance = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
        if distance >= first + second + gap || distance == 0.0 {
            return None;
        }
        let normal = arm.map(|x| x / distance);
        let reach = first + 0.5 * (distance - first - second);
        let point = std::array::from_fn(|a| one.centre[a] + reach * normal[a]);
        Some(Self { point, normal })
    }

    /// Damps the particles of its band, and adds what it takes.
    fn damp(
        &self,
        beta: f64,
        grid: &StaggeredGrid<D>,
        order: &CellOrder,
        particles: &mut ParticleArrays<D>,
        taken: &mut [f64; 3],
    ) {
        let (length, thickness) = (HALF_LENGTH * grid.spacing, HALF_THICKNESS * grid.spacing);
        let cell = |x: f64, a: usize| ((x - grid.origin[a]) / grid.spacing).floor() as isize;
        let first: [isize; D] = std::array::from_fn(|a| cell(self.point[a] - length, a).max(0));
        let last: [isize; D] = std::array::from_fn(|a| {
            cell(self.point[a] + length, a).min(grid.cells[a] as isize - 1)
        });
        if (0..D).any(|a| last[a] < first[a]) {
            return;
        }
        let counts: [usize; D] = std::array::from_fn(|a| (last[a] - first[a] + 1) as usize);
        for mut k in 0..counts.iter().product::<usize>() {
            let at = std::array::from_fn(|a| {
                let along = k % counts[a];
                k /= counts[a];
                first[a] + along as isize
            });
            for particle in order.in_cell(grid.place(at)) {
                let arm: [f64; D] =
                    std::array::from_fn(|a| particles.position[a][particle] - self.point[a]);
                let across: f64 = (0..D).map(|a| arm[a] * self.normal[a]).sum();
                let square: f64 = arm.iter().map(|x| x * x).sum();
                let along = (square - across * across).max(0.0).sqrt();
                if across.abs() > thickness || along > length {
                    continue;
                }
                let left = beta + (1.0 - beta) * along / length;
                for a in 0..D {
                    let velocity = &mut particles.velocity[a][particle];
                    taken[a] += particles.mass * (1.0 - left) * *velocity;
                    *velocity *= left;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::seeding::seed;

    /// In the gap between two discs velocities shrink to `beta` at the contact point, and not at
    /// all two cells beside it; the account holds what is missing.
    #[test]
    fn a_gap_damps_what_its_account_says() {
        let grid = StaggeredGrid::<2>::new([40, 40], 0.025, [0.0; 2], [false; 2]);
        let fractions = OpenFractions::new(&grid, |_, _| false, Vec::new());
        let mut particles = ParticleArrays::new(0.1);
        seed(&grid, &mut particles, 2, 0.0, 1, |_| true, |_| [1.0, -2.0]);
        let mut order = CellOrder::default();
        order.sort(&grid, &mut particles);
        let bodies = [[0.38, 0.5], [0.62, 0.5]].map(|at| RigidBody::ball(at, 0.1).with_mass(1.0));
        let before = particles.momentum();
        let mut bands = GapBands::default();
        let damping = GapDamping { beta: 0.5, gap: 0.05 };
        bands.damp(&damping, &grid, (&fractions, &bodies), &order, &mut particles);
        assert_eq!(bands.contacts.len(), 1);
        assert!((bands.contacts[0].point[0] - 0.5).abs() < 1e-12);
        let after = particles.momentum();
        for a in 0..2 {
            assert!((before[a] - after[a] - bands.taken[a]).abs() < 1e-12);
        }
        assert!(bands.taken[1] < -0.1);
        for k in 0..particles.len() {
            let [x, z] = particles.at(k);
            let left = particles.velocity[0][k];
            let expected = if (x - 0.5).abs() <= 0.025 && (z - 0.5).abs() <= 0.05 {
                0.5 + 0.5 * (z - 0.5).abs() / 0.05
            } else {
                1.0
            };
            assert!((left - expected).abs() < 1e-12, "{x} {z}: {left} {expected}");
        }
        // Farther apart there is no contact.
        let damping = GapDamping { beta: 0.5, gap: 0.039 };
        bands.damp(&damping, &grid, (&fractions, &bodies), &order, &mut particles);
        assert_eq!(bands.taken, [0.0; 3]);
    }
}
