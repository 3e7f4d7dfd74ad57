//! Signals of a scene that grains of every kind tell by the same names.

use crate::signals::body_signals::{FLUID, MOTION, PATH};
use crate::signals::followed;
use crate::space::plane_walls;
use tremie_messages::scene::Scene;
use tremie_messages::start::Signal;
use tremie_messages::start::signal_row::{SignalRow, describe};

/// So few spheres are followed one by one.
pub const FEW: usize = 4;

/// The paths of so many spheres: `body0_x`.
pub fn of_paths(spheres: usize) -> impl Iterator<Item = Signal> {
    (0..spheres).flat_map(|body| describe(PATH, &format!("body{body}_")).collect::<Vec<_>>())
}

/// Motion of each body and clump that a scene follows, and the fluid on it: `NAME.x`.
pub fn of_followed(scene: &Scene) -> Vec<Signal> {
    let mut all = Vec::new();
    for (name, _) in followed::of_scene(scene) {
        let before = format!("{name}.");
        all.extend(describe(MOTION, &before));
        if scene.fluid.is_some() {
            all.extend(describe(FLUID, &before));
        }
    }
    all
}

/// What `rows` tell of each face of the domain that holds grains: `x_lower.wall_force_x`.
pub fn of_faces<T>(scene: &Scene, rows: &[SignalRow<T>]) -> Vec<Signal> {
    let name = |(axis, side): (usize, usize)| {
        format!("{}_{}.", ["x", "y", "z"][axis], ["lower", "upper"][side])
    };
    plane_walls::faces(scene)
        .flat_map(|face| describe(rows, &name(face)).collect::<Vec<_>>())
        .collect()
}
