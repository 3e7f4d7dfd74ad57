//! The bin of a place.

use tremie_messages::scene::{BinnedAxis, Domain, GrainProfile};

/// The bins of a profile.
#[derive(Clone, Debug)]
pub(super) struct ProfileBins {
    profile: GrainProfile,
    /// Axes along which a place must lie in the box: all but that across a plane scene.
    inside: [bool; 3],
}

impl ProfileBins {
    /// Bins of a profile in a domain.
    pub fn new(profile: &GrainProfile, domain: &Domain) -> Self {
        let inside = [0, 1, 2].map(|axis| domain.across != Some(axis));
        Self { profile: profile.clone(), inside }
    }

    /// Number of the bin that holds a place; `None` outside the box.
    pub fn of(&self, place: [f64; 3]) -> Option<usize> {
        let GrainProfile { min, max, axes, .. } = &self.profile;
        let within = |a: usize| place[a] >= min[a] && place[a] < max[a];
        if (0..3).any(|a| self.inside[a] && !within(a)) {
            return None;
        }
        Some(axes.iter().fold(0, |bin, &along| bin * along.bins + self.along(along, place)))
    }

    /// Number of the bin along one axis.
    fn along(&self, along: BinnedAxis, place: [f64; 3]) -> usize {
        let (profile, x) = (&self.profile, place[along.axis]);
        let (min, max) = (profile.min[along.axis], profile.max[along.axis]);
        let last = along.bins - 1;
        let near = ((x - min) / (max - min) * along.bins as f64) as usize;
        let mut k = near.min(last);
        // The division rounds; the edges decide.
        if k > 0 && x < profile.edge(along, k) {
            k -= 1;
        } else if k < last && x >= profile.edge(along, k + 1) {
            k += 1;
        }
        k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tremie_messages::scene::{Face, ProfileVelocity};

    fn bins(min: f64, max: f64, bins: usize) -> ProfileBins {
        let profile = GrainProfile {
            name: "p".into(),
            axes: vec![BinnedAxis { axis: 1, bins: 2 }, BinnedAxis { axis: 0, bins }],
            min: [min, 0.0, 0.0],
            max: [max, 1.0, 1.0],
            from: 0.0,
            every: None,
            average: None,
            velocity: ProfileVelocity::Instantaneous,
        };
        ProfileBins::new(&profile, &Domain::new([min, 0.0, 0.0], [max, 1.0, 1.0], Face::WALLS))
    }

    #[test]
    fn a_bin_holds_its_lower_edge_and_not_its_upper_one() {
        let bins = bins(0.0, 0.3, 3);
        let of = |x: f64| bins.of([x, 0.7, 0.5]);
        let edge = |k| bins.profile.edge(bins.profile.axes[1], k);
        assert_eq!([0.0, edge(1).next_down(), edge(1)].map(of), [3, 3, 4].map(Some));
        assert_eq!(
            [edge(2).next_down(), edge(2), edge(3).next_down()].map(of),
            [4, 5, 5].map(Some)
        );
        assert_eq!([0.3, -1e-300, f64::NAN].map(of), [None; 3]);
        assert_eq!(bins.of([0.1, 1.0, 0.5]), None);
        assert_eq!(bins.of([0.1, 0.2, 1.5]), None, "outside along an axis without bins");
    }

    proptest! {
        #[test]
        fn every_place_lies_between_the_edges_of_its_bin(
            min in -1e3..1e3f64, size in 1e-6..1e3f64, count in 1usize..500, part in 0.0..1.0f64,
        ) {
            let (max, bins) = (min + size, bins(min, min + size, count));
            let along = bins.profile.axes[1];
            for x in [min + part * size, bins.profile.edge(along, (part * count as f64) as usize)] {
                let k = bins.of([x, 0.0, 0.0]);
                prop_assert_eq!(k.is_some(), x < max && x >= min);
                if let Some(k) = k {
                    let (low, high) = (bins.profile.edge(along, k), bins.profile.edge(along, k + 1));
                    prop_assert!(low <= x && (x < high || k + 1 == count), "{low} {x} {high}");
                }
            }
        }
    }
}
