//! Memory that a run's bodies take, counted from the arrays that hold them and from the pairs that
//! will be listed.
//!
//! The number of pairs depends on how close bodies lie: a cloud that falls has few, the bed that it
//! becomes has many. The number of bodies depends on the inlets. Both ends are told, and their
//! geometric mean stands for the run.

use crate::Vec3;
use crate::bodies::body_arrays::{BoundingSphere, Mobility, Twist, Wrench};
use crate::contact::material_laws::longest_neck;
use crate::contact::springs::Reduced;
use crate::math::parameters::Parameters;
use crate::neighbours::neighbour_list::{ContactState, ListedPair, Rolling};
use crate::polyhedra::{self, OF_PAIR};
use crate::solver::placement;
use core::f64::consts::PI;
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::packing::random_packing::{self, Sizes};
use tremie_messages::{
    body::BodyEvent,
    scene::{BodySet, BodySizes, Diameters, Inlet, Motion, Placement, Scene},
};

/// Solid fraction of a settled bed.
const BED: f64 = 0.6;

/// Least and most memory that the bodies of a run take [bytes].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Need {
    /// Memory as they lie at the start, and with the regions of inlets filled.
    pub start: f64,
    /// Once they lie as close as in a bed, and are as many as there is room for.
    pub dense: f64,
}

impl Need {
    /// Geometric mean of both ends [bytes], the estimate for the run: no further from one end than
    /// from the other.
    pub fn middle(&self) -> f64 {
        (self.start * self.dense).sqrt()
    }

    /// Memory of a valid scene, with room for so many bodies.
    pub fn of(scene: &Scene, parameters: &Parameters, capacity: usize) -> Self {
        let few = crowds(scene, |region, _| region);
        let start: usize =
            scene.bodies.iter().map(|set| random_packing::diameters_of(set).len()).sum();
        let room = capacity.saturating_sub(start) as f64 / scene.inlets.len().max(1) as f64;
        let many = crowds(scene, |_, mean| room * mean);
        let spans = few.iter().flat_map(|crowd| &crowd.species).map(|own| [own.diameter(); 2]);
        let largest = spans.clone().fold(0.0, |most: f64, [_, d]| most.max(d));
        let film = parameters.lubrication.map_or(0.0, |lubrication| lubrication.cutoff.0);
        let reach = film.max(longest_neck(scene, largest));
        let skins = Skins::new(spans, parameters.skin_fraction(), reach);
        let rolling = scene.contacts.iter().any(|pair| pair.law.rolling_friction > 0.0);
        let cost = Cost { skins, rolling: if rolling { size_of::<Rolling>() } else { 0 } };
        let state = |crowds: &[BodyGroup]| -> f64 {
            let species = crowds.iter().flat_map(|crowd| &crowd.species);
            species.map(|own| own.count * own.state()).sum()
        };
        let of_crowd = |crowd: &BodyGroup| cost.of_crowd(&crowd.species, crowd.fraction);
        let start = state(&few) + few.iter().map(of_crowd).sum::<f64>();
        // Without weight, fluid and inlets nothing brings bodies together.
        let gathers =
            scene.gravity != [0.0; 3] || scene.fluid.is_some() || !scene.inlets.is_empty();
        let dense = if gathers { state(&many) + cost.of_bed(&many) } else { start };
        Self { start, dense: dense.max(start) }
    }
}

/// Bodies of about one size.
#[derive(Clone, Copy, Debug, Default)]
struct Species {
    count: f64,
    /// Sum of the cubes of the diameters of spheres of equal volume [m³].
    cubes: f64,
    /// Diameter of the spheres around them, over that of spheres of equal volume.
    around: f64,
    /// True if forces move them.
    free: bool,
    /// True if they are polyhedra.
    solid: bool,
}

impl Species {
    /// Width of the spheres around them [m].
    fn diameter(&self) -> f64 {
        self.around * libm::cbrt(self.cubes / self.count)
    }

    /// Memory of one body by itself [bytes].
    fn state(&self) -> f64 {
        (STATE + SEARCH + if self.solid { polyhedra::OF_BODY } else { 0 }) as f64
    }
}

/// The bodies of a set, by size, at the start.
struct BodyGroup {
    species: Vec<Species>,
    /// Their solid fraction.
    fraction: f64,
}

/// The bodies of all sets, and those that inlets feed: these have the volume [m³] that `fed` says,
/// from the volume that fills the inlet's region to its fraction and from the mean volume of one.
fn crowds(scene: &Scene, fed: impl Fn(f64, f64) -> f64) -> Vec<BodyGroup> {
    let of_set = |set: &BodySet| {
        let solid = matches!(set.placement, Placement::Polyhedra(_));
        let (around, free) = (placement::around(scene, set), set.motion == Motion::Free);
        let one = Species { around, solid, free, ..Species::default() };
        let fraction = match set.placement.sizes() {
            BodySizes::Packed(packing) => packing.fraction,
            BodySizes::Listed(_) => BED,
        };
        BodyGroup {
            species: by_size(random_packing::diameters_of(set).into_iter(), one, 1.0),
            fraction,
        }
    };
    let of_inlet = |inlet: &Inlet| {
        let mean = Sizes::new(&inlet.diameters).mean_volume();
        let region: f64 = (0..3).map(|a| inlet.max[a] - inlet.min[a]).product();
        let count = fed(inlet.fraction * region, mean) / mean;
        let one = Species { around: 1.0, free: true, ..Species::default() };
        let species = by_size(drawn(&inlet.diameters), one, count / f64::from(DRAWS));
        BodyGroup { species, fraction: inlet.fraction }
    };
    scene.bodies.iter().map(of_set).chain(scene.inlets.iter().map(of_inlet)).collect()
}

/// Diameters that stand for a distribution.
const DRAWS: u32 = 256;

fn drawn(diameters: &Diameters) -> impl Iterator<Item = f64> {
    let sizes = Sizes::new(diameters);
    (0..DRAWS).map(move |part| sizes.at((f64::from(part) + 0.5) / f64::from(DRAWS)))
}

/// Bodies of like kind by size, each within a factor of the square root of two; each diameter
/// counts `weight` times.
fn by_size(diameters: impl Iterator<Item = f64>, one: Species, weight: f64) -> Vec<Species> {
    let mut bins = std::collections::BTreeMap::<i64, Species>::new();
    for d in diameters {
        let bin = libm::floor(2.0 * libm::log2(d)) as i64;
        let own = bins.entry(bin).or_insert(one);
        own.count += weight;
        own.cubes += weight * d * d * d;
    }
    bins.into_values().filter(|own| own.count > 0.0).collect()
}

/// Memory of the pairs.
struct Cost {
    skins: Skins,
    /// Extra memory of one of two spheres where there is rolling friction, at a time [bytes].
    rolling: usize,
}

impl Cost {
    /// Pairs within a mix of species that fill a fraction of their space [bytes].
    fn of_crowd(&self, species: &[Species], fraction: f64) -> f64 {
        let cubes: f64 = species.iter().map(|own| own.cubes).sum();
        let space = PI / 6.0 * cubes / fraction;
        let pairs = species.iter().enumerate().flat_map(|(k, a)| {
            species[k..]
                .iter()
                .enumerate()
                .map(move |(l, b)| (a, b, if l == 0 { 0.5 } else { 1.0 }))
        });
        let cost = |(a, b, half): (&Species, &Species, f64)| {
            half * a.count * b.count / space * self.of_pair(a, b, fraction)
        };
        if cubes > 0.0 { pairs.map(cost).sum() } else { 0.0 }
    }

    /// Pairs in a bed [bytes]: bodies of about one size side by side, as if those of other sizes
    /// had gone elsewhere; those of different sizes as if all were mixed.
    fn of_bed(&self, crowds: &[BodyGroup]) -> f64 {
        let mut mix: Vec<Species> = Vec::new();
        for own in crowds.iter().flat_map(|crowd| &crowd.species) {
            let alike = |known: &&mut Species| {
                let ratio = known.diameter() / own.diameter();
                known.solid == own.solid && known.free == own.free && (0.75..1.34).contains(&ratio)
            };
            match mix.iter_mut().find(alike) {
                Some(known) => {
                    known.count += own.count;
                    known.cubes += own.cubes;
                }
                None => mix.push(*own),
            }
        }
        let alone: f64 = mix.iter().map(|own| self.of_crowd(std::slice::from_ref(own), BED)).sum();
        let space = PI / 6.0 * mix.iter().map(|own| own.cubes).sum::<f64>() / BED;
        let mixed =
            mix.iter().enumerate().flat_map(|(k, a)| mix[k + 1..].iter().map(move |b| (a, b)));
        let cost =
            |(a, b): (&Species, &Species)| a.count * b.count / space * self.of_pair(a, b, BED);
        alone + mixed.map(cost).sum::<f64>()
    }

    /// Space around a body of one species in which one of the other is listed, counted as often as
    /// bodies crowd there over the mean [m³], times what a pair takes [bytes].
    fn of_pair(&self, a: &Species, b: &Species, fraction: f64) -> f64 {
        if !a.free && !b.free {
            return 0.0;
        }
        let [d, e] = [a, b].map(Species::diameter);
        let [k, l] = [d, e].map(|d| self.skins.class(0.5 * d));
        let (touch, gap) = (0.5 * (d + e), self.skins.between(k, l));
        let ball = |radius: f64| 4.0 / 3.0 * PI * radius * radius * radius;
        if a.solid || b.solid {
            // The spheres around them overlap; what keeps centres apart is about that of spheres of
            // equal volume.
            let apart = 0.5 * (d / a.around + e / b.around);
            return (ball(touch + gap) - ball(apart)) * OF_PAIR as f64;
        }
        // The density of neighbours at contact over the mean (Carnahan and Starling, J. Chem. Phys.
        // 51, 1969), up to that at which spheres of a bed have five pairs listed each with the
        // default skin; it falls off within a tenth of the smaller diameter.
        let free = 1.0 - fraction;
        let crowded = ((1.0 - 0.5 * fraction) / (free * free * free)).min(MOST_CROWDED);
        let near = touch + gap.min(0.1 * d.min(e));
        let counted = crowded * (ball(near) - ball(touch)) + ball(touch + gap) - ball(near);
        counted * (TWICE + FOUND + 2 * self.rolling) as f64
    }
}

const MOST_CROWDED: f64 = 6.3;

const INDEX: usize = size_of::<u32>();

/// The state of a sphere, and that of one being put in another order.
const STATE: usize = 2 * size_of::<BoundingSphere>()
    + 3 * size_of::<Twist>()
    + 2 * size_of::<Wrench>()
    + 2 * size_of::<Mobility>()
    + 2 * size_of::<[f64; 4]>()
    + size_of::<Vec3>()
    + 8 * INDEX
    + 2 * size_of::<u16>();

/// Cells, orders, places, sums, and what the others are told at the start.
const SEARCH: usize = 14 * INDEX
    + 2 * size_of::<bool>()
    + size_of::<(u64, u32)>()
    + size_of::<f64>()
    + size_of::<BodyEvent>();

/// A pair in the list before and in that which is used, with the places where its bodies find it,
/// listed and acting.
const TWICE: usize = 2
    * (size_of::<ListedPair>()
        + size_of::<u8>()
        + size_of::<Vec3>()
        + size_of::<ContactState>()
        + 2 * INDEX)
    + size_of::<f32>()
    + size_of::<Reduced>()
    + 2 * INDEX;

/// A pair while the list is made.
const FOUND: usize = 2 * size_of::<ListedPair>() + INDEX + 2 * size_of::<u64>();

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the neighbours of a sphere in a bed of equal ones that are nearer than a tenth of
    /// its diameter.
    #[test]
    fn a_sphere_of_a_bed_has_five_pairs() {
        let one = Species { count: 1e3, cubes: 1e3, around: 1.0, free: true, solid: false };
        let cost = Cost { skins: Skins::new(std::iter::once([1.0; 2]), 0.1, 0.0), rolling: 0 };
        let pairs = cost.of_crowd(&[one], BED) / (1e3 * (TWICE + FOUND) as f64);
        assert!((pairs - 5.0).abs() < 0.1, "{pairs}");
        let halves = [Species { count: 5e2, cubes: 5e2, ..one }; 2];
        let same = cost.of_crowd(&halves, BED) / (1e3 * (TWICE + FOUND) as f64);
        assert!((same - pairs).abs() < 1e-9, "{same} {pairs}");
    }
}
