//! Motion of all bodies by any rule, with what neighbour lists have to know of it.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, BoundingSphere, Twist, Wrench};
use crate::math::periodic::PeriodicBox;
use crate::neighbours::size_classes::Leash;
use crate::solver::force_sum::ForceSum;
use crate::solver::integrate::{AppliedForces, StepDisplacement, acceleration, turned};
use tremie_team::{Cut, Team};

/// State of a body, as a rule changes it.
pub(super) struct MovedBody<'a> {
    /// Acceleration and angular acceleration under the contacts of the last evaluation.
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

/// Moves all bodies: `rule` changes the velocities of one and returns those with which it goes on
/// for a time `duration` [s]. `reaches` has one entry for each block of bodies.
pub(super) fn move_bodies(
    team: &mut Team,
    bodies: &mut Bodies,
    (bounds, leash): (&PeriodicBox, Leash<'_>),
    forces: AppliedForces<'_>,
    duration: f64,
    reaches: &mut [StepDisplacement],
    rule: impl Fn(MovedBody<'_>) -> Twist + Sync,
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
    team.for_pieces(
        pieces,
        |b, (balls, twists, predicted, orientation, reference, crossed, reach)| {
            let first = b * BLOCK;
            let mut collector = ForceSum::new(forces.contacts, b, first..first + balls.len());
            let (mut farthest, mut any_crossed) = (0.0, false);
            for i in 0..balls.len() {
                let contact = collector.on(first + i, balls[i].radius);
                let load = forces.loaded.then_some(&load[first + i]);
                let mobility = mobility[first + i];
                let mean = rule(MovedBody {
                    by_contacts: acceleration(contact, None, mobility, Vec3::zeros()),
                    applied: acceleration(Wrench::zero(), load, mobility, forces.gravity),
                    is_free: mobility.is_free(),
                    twist: &mut twists[i],
                    predicted: &mut predicted[i],
                });
                let mut x = balls[i].x + mean.v * duration;
                if let Some((inside, shift, code)) = bounds.cross(x) {
                    x = inside;
                    reference[i] += shift;
                    crossed[i] += code;
                    any_crossed |= code != 0;
                }
                balls[i].x = x;
                let square = (x - reference[i]).norm_squared();
                if square > farthest || square.is_nan() {
                    farthest = square;
                }
                orientation[i] = turned(orientation[i], mean.w * (0.5 * duration));
            }
            let place = |(ball, from): (&BoundingSphere, &Vec3)| (ball.x - from).norm_squared();
            let squares = balls.iter().zip(&*reference).map(place);
            let due = leash.is_due(farthest, first, squares);
            reach[0] = StepDisplacement { farthest, crossed: any_crossed, due };
        },
    );
}
