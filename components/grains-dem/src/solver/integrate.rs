//! Velocity Verlet with predicted velocities.
//!
//! ```text
//! v_h = v + dt/2 a        x += dt v_h        v_p = v_h + dt/2 a      forces see x and v_p
//! a = F(x, v_p, w_p)/m + g                   v = v_h + dt/2 a
//! ```
//!
//! and the same for the angular velocity. Forces at the half-step velocity would leave the scheme
//! first order, because dashpots depend on it (the prediction is that of Groot & Warren, *J. Chem.
//! Phys.* 107, 1997, with lambda = 1).

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, BoundingSphere, Mobility, Twist, Wrench};
use crate::bodies::drag_bands::DragBands;
use crate::math::simd::vec4::Four;
use crate::solver::dem_solver::FluidLoads;
use crate::solver::force_sum::ForceSum;
use crate::solver::neighbour_search::{Contacts, Search};
use serde::{Deserialize, Serialize};
use tremie_grains_kit::neighbours::size_classes::Leash;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_team::{Cut, Team, Variant, instructions::Work};

/// Forces that move bodies.
#[derive(Clone, Copy)]
pub(crate) struct AppliedForces<'a> {
    pub contacts: Contacts<'a>,
    /// True if the fluid load of any body is not zero.
    pub loaded: bool,
    /// Acceleration of weight [m/s²].
    pub gravity: Vec3,
    /// Boxes in which bodies are braked.
    pub bands: &'a DragBands,
}

impl<'a> AppliedForces<'a> {
    /// Contacts as they were last evaluated, loads of the fluid, weight, drag of bands.
    pub fn of(
        search: &'a Search,
        fluid: &FluidLoads,
        (gravity, bands): (Vec3, &'a DragBands),
    ) -> Self {
        Self { contacts: search.contacts(), loaded: fluid.loaded, gravity, bands }
    }

    /// Adds the drag of bands to the acceleration of a body at a place [m] that goes at this
    /// velocity [m/s], unless its motion is given or that of a clump.
    #[inline(always)]
    pub(super) fn brake(&self, a: &mut Twist, mobility: Mobility, x: Vec3, v: Vec3) {
        if self.bands.is_any() && mobility.is_free() && !mobility.is_joined() {
            a.v += self.bands.acceleration(x, v);
        }
    }
}

/// Displacement of bodies in a step.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct StepDisplacement {
    /// Square of the largest distance of a body from its reference position [m²]; NaN if any is.
    pub farthest: f64,
    /// True if any body crossed a periodic face.
    pub crossed: bool,
    /// True if any body went as far as it may until neighbours are listed anew.
    pub due: bool,
}

impl StepDisplacement {
    /// The farther of two.
    pub fn and(self, other: Self) -> Self {
        let farther = other.farthest > self.farthest || other.farthest.is_nan();
        Self {
            farthest: if farther { other.farthest } else { self.farthest },
            crossed: self.crossed || other.crossed,
            due: self.due || other.due,
        }
    }
}

/// Acceleration and angular acceleration of a body under contact forces, loads and weight; none of
/// one that goes with a clump.
#[inline(always)]
pub(super) fn acceleration(
    contact: Wrench,
    load: Option<&Wrench>,
    mobility: Mobility,
    gravity: Vec3,
) -> Twist {
    if mobility.is_joined() {
        return Twist::zero();
    }
    let gravity = if mobility.is_free() { gravity } else { Vec3::zeros() };
    let Wrench { mut force, mut torque } = contact;
    if let Some(load) = load {
        force += load.force;
        torque += load.torque;
    }
    Twist { v: force * mobility.inverse_mass + gravity, w: torque * mobility.inverse_inertia }
}

/// Displacement of the bodies of a block, which move one by one.
#[derive(Default)]
pub(super) struct BlockDisplacement {
    farthest: f64,
    crossed: bool,
}

impl BlockDisplacement {
    /// Moves a body for a time [s] at a velocity, and turns it.
    #[inline(always)]
    pub fn go_on(
        &mut self,
        (ball, orientation): (&mut BoundingSphere, &mut [f64; 4]),
        (reference, crossed): (&mut Vec3, &mut i32),
        (mean, duration): (Twist, f64),
        bounds: &PeriodicBox,
    ) {
        let mut x = ball.x + mean.v * duration;
        if let Some((inside, shift, code)) = bounds.cross(x) {
            x = inside;
            *reference += shift;
            *crossed += code;
            self.crossed |= code != 0;
        }
        ball.x = x;
        let square = (x - *reference).norm_squared();
        if square > self.farthest || square.is_nan() {
            self.farthest = square;
        }
        *orientation = turned(*orientation, mean.w * (0.5 * duration));
    }

    /// What is to be known of the block, whose first body is `first`, once all have moved.
    #[inline(always)]
    pub fn end(
        self,
        first: usize,
        (balls, reference): (&[BoundingSphere], &[Vec3]),
        leash: Leash<'_>,
    ) -> StepDisplacement {
        let squares = balls.iter().zip(reference).map(|(ball, x)| (ball.x - x).norm_squared());
        let due = leash.is_due(self.farthest, first, squares);
        StepDisplacement { farthest: self.farthest, crossed: self.crossed, due }
    }
}

/// First half of a substep: half kick, drift, prediction. With `finish` the half kick that ends the
/// substep before comes first, so that bodies are visited once a substep. `reaches` has one entry
/// for each block of bodies.
pub(crate) fn first_half(
    team: &mut Team,
    bodies: &mut Bodies,
    (bounds, leash): (&PeriodicBox, Leash<'_>),
    forces: AppliedForces<'_>,
    (dt, finish): (f64, bool),
    reaches: &mut [StepDisplacement],
) {
    let pieces = (
        Cut::every(&mut bodies.balls, BLOCK),
        Cut::every(&mut bodies.twists, BLOCK),
        Cut::every(&mut bodies.predicted, BLOCK),
        Cut::every(&mut bodies.orientation, BLOCK),
        Cut::every(&mut bodies.reference, BLOCK),
        Cut::every(&mut bodies.crossed, BLOCK),
        Cut::every(reaches, 1),
    );
    let (load, mobility) = (&bodies.load, &bodies.mobility);
    team.for_pieces(pieces, |b, arrays| {
        let variant = Variant::widest();
        let step = (dt, finish);
        variant.run(FirstHalf { b, arrays, load, mobility, bounds, leash, forces, step, variant });
    });
}

/// The changing arrays of a block.
type Arrays<'a> = (
    &'a mut [BoundingSphere],
    &'a mut [Twist],
    &'a mut [Twist],
    &'a mut [[f64; 4]],
    &'a mut [Vec3],
    &'a mut [i32],
    &'a mut [StepDisplacement],
);

/// First half of a substep of a block.
struct FirstHalf<'a> {
    b: usize,
    arrays: Arrays<'a>,
    load: &'a [Wrench],
    mobility: &'a [Mobility],
    bounds: &'a PeriodicBox,
    leash: Leash<'a>,
    forces: AppliedForces<'a>,
    step: (f64, bool),
    variant: Variant,
}

impl Work for FirstHalf<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { b, arrays, load, mobility, bounds, leash, forces, step, variant } = self;
        let (dt, finish) = step;
        let (balls, twists, predicted, orientation, reference, crossed, reach) = arrays;
        let (first, half) = (b * BLOCK, 0.5 * dt);
        let own = first..first + balls.len();
        let mut collector = ForceSum::new(forces.contacts, b, own).with(variant);
        let mut displacement = BlockDisplacement::default();
        // Slices of equal length spare the loop its bounds checks.
        let n = balls.len();
        let (twists, predicted) = (&mut twists[..n], &mut predicted[..n]);
        let (orientation, reference) = (&mut orientation[..n], &mut reference[..n]);
        let (load, mobility) = (&load[first..first + n], &mobility[first..first + n]);
        for i in 0..n {
            let contact = collector.on(first + i, balls[i].radius);
            let load = forces.loaded.then_some(&load[i]);
            let mut a = acceleration(contact, load, mobility[i], forces.gravity);
            forces.brake(&mut a, mobility[i], balls[i].x, predicted[i].v);
            let mut twist = twists[i];
            if finish {
                twist.kick(&a, half);
            }
            twist.kick(&a, half);
            twists[i] = twist;
            predicted[i] = twist;
            predicted[i].kick(&a, half);
            displacement.go_on(
                (&mut balls[i], &mut orientation[i]),
                (&mut reference[i], &mut crossed[i]),
                (twist, dt),
                bounds,
            );
        }
        reach[0] = displacement.end(first, (balls, reference), leash);
    }
}

/// Second half of a substep: half kick with the new forces.
pub(crate) fn second_half(
    team: &mut Team,
    bodies: &mut Bodies,
    forces: AppliedForces<'_>,
    dt: f64,
) {
    let (balls, load, mobility) = (&bodies.balls, &bodies.load, &bodies.mobility);
    let predicted = &bodies.predicted;
    team.for_pieces(Cut::every(&mut bodies.twists, BLOCK), |b, twists: &mut [Twist]| {
        let own = b * BLOCK..b * BLOCK + twists.len();
        let mut collector = ForceSum::new(forces.contacts, b, own);
        for (i, twist) in (b * BLOCK..).zip(twists) {
            let contact = collector.on(i, balls[i].radius);
            let load = forces.loaded.then_some(&load[i]);
            let mut a = acceleration(contact, load, mobility[i], forces.gravity);
            forces.brake(&mut a, mobility[i], balls[i].x, predicted[i].v);
            twist.kick(&a, 0.5 * dt);
        }
    });
}

/// The orientation `q` turned by a small rotation, given as half its angle along its axis in the
/// world frame: `q + (h, 0) q`, renormalised, is exact to second order in the angle.
#[inline(always)]
pub(super) fn turned(q: [f64; 4], h: Vec3) -> [f64; 4] {
    // x + h.x w + h.y z - h.z y, and likewise y and z;  w - h.x x - h.y y - h.z z
    let (q, h, last) = (Four(q), Four::of(&h), Four([1.0, 1.0, 1.0, -1.0]));
    let turned = q
        + h.at::<0, 1, 2, 0>() * last * q.at::<3, 3, 3, 0>()
        + h.at::<1, 2, 0, 1>() * last * q.at::<2, 0, 1, 1>()
        - h.at::<2, 0, 1, 2>() * q.at::<1, 2, 0, 2>();
    // One step of Newton's for the inverse root, from 1: `q` was a unit quaternion, so that the
    // square differs from 1 by that of `h` alone.
    let [x, y, z, w] = (turned * turned).0;
    (turned * (1.5 - 0.5 * (x + y + z + w))).0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_follows_a_steady_rotation() {
        let w = Vec3::new(0.3, -0.4, 1.2);
        let steps = 2000;
        let mut q = [0.0, 0.0, 0.0, 1.0];
        for _ in 0..steps {
            q = turned(q, w * (0.5 / f64::from(steps)));
        }
        let exact = nalgebra::UnitQuaternion::from_scaled_axis(w);
        let error = (0..4).map(|a| (q[a] - exact.coords[a]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-7, "{error}");
    }
}
