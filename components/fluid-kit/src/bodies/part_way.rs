//! Bodies within a window.

use tremie_messages::BodyState;

/// A body part of the way between two states, with the velocities that it has at a later part, where
/// the step ends that begins here.
pub fn part_way(before: &BodyState, after: &BodyState, [part, later]: [f64; 2]) -> BodyState {
    let mix = |from: f64, to: f64| from + part * (to - from);
    let turned: f64 =
        (0..4).map(|k| before.orientation[k] * after.orientation[k]).sum::<f64>().signum();
    let orientation: [f64; 4] =
        std::array::from_fn(|k| mix(turned * before.orientation[k], after.orientation[k]));
    let length = orientation.iter().map(|q| q * q).sum::<f64>().sqrt();
    BodyState {
        position: std::array::from_fn(|a| mix(before.position[a], after.position[a])),
        orientation: orientation.map(|q| q / length),
        velocity: std::array::from_fn(|a| {
            before.velocity[a] + later * (after.velocity[a] - before.velocity[a])
        }),
        angular_velocity: std::array::from_fn(|a| {
            let [from, to] = [before, after].map(|state| state.angular_velocity[a]);
            from + later * (to - from)
        }),
        ..*after
    }
}
