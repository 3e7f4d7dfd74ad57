//! Periods of sliders, and the time step that resolves them.

use crate::bodies::placed_parts::PlacedPart;
use crate::bodies::slider::Slider;
use crate::contact::stability::Stability;
use core::f64::consts::{FRAC_PI_4, PI};
use serde::Serialize;
use tremie_messages::scene::{Motion, Scene, Stops};

/// Times of a slider that bear on the time step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliderTimes {
    /// Name of the part.
    pub part: String,
    /// Duration of a collision with a stop without damping [s], if there are stops.
    pub stop_time: Option<f64>,
    /// Half a period of the mass on its spring where that is stiffest [s], if it has one.
    pub spring_time: Option<f64>,
    /// Depth in a stop at rest, from spring, weight and constant force, over the stroke; 0 without
    /// two stops.
    pub rest_depth: f64,
}

/// Grains on sliders as they bear on stability.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grains {
    /// Number of grains that move.
    pub free: usize,
    /// Smallest diameter [m].
    pub diameter: f64,
    /// Largest normal stiffness at a surface [N/m].
    pub stiffness: f64,
}

/// The sliders of a scene with its parts placed.
pub(crate) fn of(scene: &Scene, parts: &[PlacedPart]) -> Vec<SliderTimes> {
    let named = scene.parts.iter().zip(parts);
    named
        .filter_map(|(part, placed)| {
            let Motion::Slider(given) = &part.motion else { return None };
            let slider = placed.slider()?;
            let [stops, spring] = slider.stiffnesses();
            let half_period = |k: f64| (k > 0.0).then(|| PI * (slider.mass / k).sqrt());
            Some(SliderTimes {
                part: part.name.clone(),
                stop_time: half_period(stops),
                spring_time: half_period(spring),
                rest_depth: given.stops.map_or(0.0, |stops| rest_depth(slider, &stops)),
            })
        })
        .collect()
}

/// Depth to which the constant forces press a slider into a stop, over the stroke.
fn rest_depth(slider: &Slider, stops: &Stops) -> f64 {
    let (Some(lower), Some(upper)) = (stops.lower, stops.upper) else { return 0.0 };
    let pressed = (-slider.constant_at(lower)).max(slider.constant_at(upper)).max(0.0);
    pressed / stops.stiffness / (upper - lower)
}

/// The shortest duration of a collision or half an oscillation of these sliders [s]; infinite
/// without any.
pub(crate) fn shortest(sliders: &[SliderTimes]) -> f64 {
    let times = sliders.iter().flat_map(|slider| [slider.stop_time, slider.spring_time]);
    times.flatten().fold(f64::INFINITY, f64::min)
}

/// Stability of the worst slider alone, and of the worst one covered with grains: as many as there
/// are, or as its surface has room for.
pub(crate) fn stability(parts: &[PlacedPart], grains: Grains) -> [Stability; 2] {
    let mut worst = [Stability::default(); 2];
    for part in parts {
        let Some(slider) = part.slider() else { continue };
        let [k, gamma] = slider.stiffest();
        let alone = Stability::of_mass(k, gamma, slider.mass);
        let room = part.shape.area() / (FRAC_PI_4 * grains.diameter * grains.diameter);
        let touching = if grains.free > 0 { (grains.free as f64).min(room) } else { 0.0 };
        let covered = slider.whole * touching * grains.stiffness;
        worst[0] = worst[0].or(alone);
        worst[1] = worst[1].or(alone.and(Stability::of_mass(covered, 0.0, slider.mass)));
    }
    worst
}
