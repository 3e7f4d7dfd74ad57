//! Limit of the time step, in words.

use crate::math::parameters::Parameters;
use crate::setup::material_pairs::MaterialPair;
use crate::setup::slider_times::SliderTimes;
use tremie_grains_kit::packing::random_packing;
use tremie_messages::{
    finding::short,
    scene::{BodySizes, Scene},
};

/// Encounters, by index, that bound the time step: those of the shortest collision and of the least
/// stability in a packing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tightest {
    /// Index and duration of the collision [s].
    pub contact: Option<(usize, f64)>,
    /// Index and largest stable step [s].
    pub dense: Option<(usize, f64)>,
}

impl Tightest {
    /// Takes an encounter into account.
    pub fn add(&mut self, index: usize, contact: f64, dense: f64) {
        let least = |known: &mut Option<(usize, f64)>, value: f64| {
            if known.is_none_or(|(_, least)| value < least) {
                *known = Some((index, value));
            }
        };
        least(&mut self.contact, contact);
        least(&mut self.dense, dense);
    }
}

/// Why the time step is what it is, where collisions bound it by `contact` [s] over the steps in
/// one, and stability by `dense` [s].
pub(crate) fn reason(
    scene: &Scene,
    parameters: &Parameters,
    encounters: &[MaterialPair<'_>],
    sliders: &[SliderTimes],
    (tightest, contact, dense): (Tightest, f64, f64),
) -> String {
    if parameters.time_step.is_some() {
        return "time_step in its settings".into();
    }
    let steps = parameters.steps_per_contact;
    let (found, why) = if contact / steps <= dense {
        let why = format!("{} steps in the shortest collision, {} s", short(steps), short(contact));
        (tightest.contact.filter(|(_, time)| *time <= contact), why)
    } else {
        let why = format!("stability in a dense packing, {} s at most", short(dense));
        (tightest.dense, why)
    };
    match found.and_then(|(index, _)| encounters.get(index)) {
        Some(encounter) => format!("{why}: {}", lightest(scene, encounter)),
        None => format!("{why}: of {}", quickest(sliders)),
    }
}

/// The slider with the shortest time.
fn quickest(sliders: &[SliderTimes]) -> String {
    let time = |slider: &SliderTimes| {
        let times = [slider.stop_time, slider.spring_time].into_iter().flatten();
        times.fold(f64::INFINITY, f64::min)
    };
    let first = sliders.iter().min_by(|a, b| time(a).total_cmp(&time(b)));
    first.map_or("a slider".into(), |slider| format!("the slider \"{}\"", slider.part))
}

/// The lightest pair of an encounter, with its smallest grain and its stiffness.
fn lightest(scene: &Scene, encounter: &MaterialPair<'_>) -> String {
    let stiffness = encounter.law.spring.law().stiffness_in_words();
    let grain =
        smallest(scene, &encounter.materials).map_or(String::new(), |grain| format!(", {grain}"));
    format!("{}{grain}, {stiffness}", encounter.name)
}

/// The smallest grain of these materials.
fn smallest(scene: &Scene, materials: &[&str; 2]) -> Option<String> {
    let of_set = scene.bodies.iter().enumerate().filter_map(|(i, set)| {
        let known = materials.contains(&set.material.as_str());
        let least = random_packing::diameters_of(set)
            .into_iter()
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let (k, d) = least.filter(|_| known)?;
        let many = matches!(set.placement.sizes(), BodySizes::Listed(list) if list.len() > 1);
        let which = if many {
            format!("body {k} of scene.bodies[{i}] \"{}\"", set.name)
        } else {
            format!("\"{}\"", set.name)
        };
        Some((d, which))
    });
    let of_inlets = scene
        .inlets
        .iter()
        .map(|inlet| (inlet.diameters.extremes()[0], format!("the inlet \"{}\"", inlet.name)));
    let all = of_set.chain(of_inlets);
    let (d, which) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!("smallest grain {} m (of {which})", short(d)))
}
