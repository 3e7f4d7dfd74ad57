//! Motion of all bodies by any rule, with what neighbour lists have to know of it.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Twist, Wrench};
use crate::solver::dem_solver::GrainsDem;
use crate::solver::force_sum::ForceSum;
use crate::solver::integrate::{AppliedForces, BlockDisplacement, acceleration};
use tremie_team::Cut;

/// State of a body, as a rule changes it.
pub(super) struct MovedBody<'a> {
    /// Acceleration and angular acceleration under the contacts of the last evaluation, and the drag
    /// of bands: what depends on the velocity.
    pub by_contacts: Twist,
    /// The same under load and weight.
    pub applied: Twist,
    /// True if forces move the body.
    pub is_free: bool,
    /// Velocities.
    pub twist: &'a mut Twist,
    /// Velocities that forces see.
    pub predicted: &'a mut Twist,
}

impl GrainsDem {
    /// Moves all bodies: `rule` changes the velocities of one and returns those with which it goes
    /// on for a time `duration` [s].
    pub(super) fn move_bodies(
        &mut self,
        duration: f64,
        rule: impl Fn(MovedBody<'_>) -> Twist + Sync,
    ) {
        let forces = AppliedForces::of(&self.search, &self.fluid, (self.gravity, &self.bands));
        let (bounds, leash) = (&self.around.bounds, self.search.leash());
        let (bodies, reaches) = (&mut self.population.bodies, &mut self.record.reaches[..]);
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
        self.threads.team.for_pieces(
            pieces,
            |b, (balls, twists, predicted, orientation, reference, crossed, reach)| {
                let first = b * BLOCK;
                let mut collector = ForceSum::new(forces.contacts, b, first..first + balls.len());
                let mut displacement = BlockDisplacement::default();
                for i in 0..balls.len() {
                    let contact = collector.on(first + i, balls[i].radius);
                    let load = forces.loaded.then_some(&load[first + i]);
                    let mobility = mobility[first + i];
                    let mut by_contacts = acceleration(contact, None, mobility, Vec3::zeros());
                    forces.brake(&mut by_contacts, mobility, balls[i].x, predicted[i].v);
                    let mean = rule(MovedBody {
                        by_contacts,
                        applied: acceleration(Wrench::zero(), load, mobility, forces.gravity),
                        is_free: mobility.is_free(),
                        twist: &mut twists[i],
                        predicted: &mut predicted[i],
                    });
                    displacement.go_on(
                        (&mut balls[i], &mut orientation[i]),
                        (&mut reference[i], &mut crossed[i]),
                        (mean, duration),
                        bounds,
                    );
                }
                reach[0] = displacement.end(first, (balls, reference), leash);
            },
        );
    }
}
