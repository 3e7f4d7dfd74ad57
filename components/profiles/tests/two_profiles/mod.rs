//! A run of 20 windows with two profiles, for those who write its files.

use std::path::Path;
use tremie_messages::scene::{BinnedAxis, Domain, Face, GrainProfile, ProfileVelocity, Scene};
use tremie_messages::start::Clock;
use tremie_sdk::Setup;
use tremie_test_support::observers;

/// Number of windows.
pub const LAST: u64 = 20;

/// A profile of means over 5 ms.
pub fn profile(name: &str, axes: &[(usize, usize)]) -> GrainProfile {
    GrainProfile {
        name: name.into(),
        axes: axes.iter().map(|&(axis, bins)| BinnedAxis { axis, bins }).collect(),
        min: [0.0; 3],
        max: [1.0, 1.0, 0.5],
        from: 0.0,
        every: None,
        average: Some(5e-3),
        velocity: ProfileVelocity::Instantaneous,
    }
}

/// The setup of an observer whose outputs lie in a folder.
pub fn setup(output: &Path) -> Setup {
    let domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
    let profiles = vec![profile("plane", &[(2, 2), (0, 4)]), profile("line", &[(1, 3)])];
    let scene = Scene { profiles, ..Scene::empty(domain) };
    observers::setup("profiles", scene, Clock { tick: 1e-3, ticks_per_window: 1 }, LAST, output)
}
