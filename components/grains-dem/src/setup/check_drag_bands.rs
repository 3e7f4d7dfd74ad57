//! Checks of drag bands.

use tremie_grains_kit::checks::numbers::{AXES, all_finite, not_positive};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::{
    Problem,
    scene::{DragBand, Scene},
};

/// Checks that each band is a box and brakes.
pub(crate) fn drag_bands(scene: &Scene, problems: &mut Vec<Problem>) {
    for (i, one) in scene.drag_bands.iter().enumerate() {
        band(&format!("scene.drag_bands[{i}]"), one, problems);
        if scene.gravity == [0.0; 3] {
            let message = "brakes by the weight of bodies, but there is no gravity";
            let help = "give the scene gravity, or leave the band out";
            problems.push(Problem::new(format!("scene.drag_bands[{i}]"), message).help(help));
        }
    }
}

fn band(key: &str, band: &DragBand, problems: &mut Vec<Problem>) {
    if !is_positive(band.terminal_speed) {
        problems.push(not_positive(format!("{key}.terminal_speed"), band.terminal_speed));
    }
    if !all_finite(&band.min) || !all_finite(&band.max) {
        problems.push(Problem::new(key, "has a corner that is not finite"));
    } else if let Some(a) = (0..3).find(|&a| band.max[a] <= band.min[a]) {
        let (min, max, axis) = (band.min[a], band.max[a], AXES[a]);
        let message = format!("has no extent in {axis}: it reaches from {min} to {max} m there");
        problems.push(Problem::new(format!("{key}.max"), message));
    }
}
