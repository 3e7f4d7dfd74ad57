//! A profile in a run: when it is sampled, and its table.

use super::bins::ProfileBins;
use super::displacement::Displacements;
use super::grain_sample::GrainSample;
use super::sums::{BinMeasure, BinSums};
use tremie_messages::Stamp;
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::{Domain, GrainProfile, ProfileSchedule, ProfileVelocity};
use tremie_state::{StateError, StateExchange};

/// A profile with the sums of its table.
#[derive(Clone, Debug)]
pub struct ProfileSampler {
    name: String,
    bins: ProfileBins,
    measure: BinMeasure,
    schedule: ProfileSchedule,
    /// Length of a window [s].
    window: f64,
    sums: Vec<BinSums>,
    /// Windows of the table's beginning and of its last sample.
    begin: u64,
    last: u64,
    samples: u64,
    /// Where velocities are those of displacements.
    displacements: Option<Displacements>,
}

impl ProfileSampler {
    /// For a valid profile in a run with windows of a length [s], with room for so many grains.
    pub fn new(profile: &GrainProfile, domain: &Domain, window: f64, grains: usize) -> Self {
        let schedule = profile.schedule(window);
        let by_displacement = profile.velocity == ProfileVelocity::Displacement;
        Self {
            name: profile.name.clone(),
            bins: ProfileBins::new(profile, domain),
            measure: BinMeasure { volume: profile.bin_volume(), across: domain.across },
            schedule,
            window,
            sums: vec![BinSums::default(); profile.bins()],
            begin: schedule.begin,
            last: schedule.begin,
            samples: 0,
            displacements: by_displacement.then(|| Displacements::new(domain, grains)),
        }
    }

    /// Memory of the samplers of some profiles, and of the samples of so many grains [bytes].
    pub fn memory(profiles: &[GrainProfile], grains: usize) -> u64 {
        let of_profile = |profile: &GrainProfile| {
            let is_seen = profile.velocity == ProfileVelocity::Displacement;
            let places = if is_seen { 2 * grains * size_of::<(u64, [f64; 3])>() } else { 0 };
            places + profile.bins() * size_of::<BinSums>()
        };
        let samples = if profiles.is_empty() { 0 } else { grains * size_of::<GrainSample>() };
        (samples + profiles.iter().map(of_profile).sum::<usize>()) as u64
    }

    /// Keeps the table that was begun, or puts it back.
    ///
    /// # Errors
    /// A state of another profile.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let bins = self.sums.len();
        state.value("sums", &mut self.sums)?;
        state.value("begin", &mut self.begin)?;
        state.value("last", &mut self.last)?;
        state.value("samples", &mut self.samples)?;
        state.value("displacements", &mut self.displacements)?;
        if self.sums.len() != bins {
            return state
                .unfit(format!("the state has {} bins of a profile of {bins}", self.sums.len()));
        }
        Ok(())
    }

    /// Name of the profile.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// True if the grains are wanted as they are at the end of a window.
    pub fn wants(&self, window: u64) -> bool {
        let begins = self.displacements.is_some() && window == self.schedule.begin;
        begins || self.schedule.is_sample(window)
    }

    /// Takes the grains at the end of a [wanted](Self::wants) window, by ascending ids. The first
    /// sample after a table has ended begins the next.
    pub fn take(&mut self, window: u64, grains: impl Iterator<Item = GrainSample>) {
        if window == self.schedule.begin {
            // Where displacements begin; no sample yet.
            if let Some(displacements) = &mut self.displacements {
                for grain in grains {
                    // There is no way yet.
                    let _ = displacements.of(grain.id, grain.position);
                }
                displacements.end();
            }
            return;
        }
        if self.is_whole() {
            self.sums.fill(BinSums::default());
            (self.begin, self.samples) = (self.last, 0);
        }
        self.last = window;
        self.samples += 1;
        let Self { bins, sums, .. } = self;
        let between = self.schedule.every as f64 * self.window;
        for grain in grains {
            let bin = bins.of(grain.position);
            if let Some(bin) = bin {
                sums[bin].add(&grain);
            }
            let (bin, velocity) = match &mut self.displacements {
                None => (bin, grain.velocity),
                Some(displacements) => match displacements.of(grain.id, grain.position) {
                    Some(way) => (bins.of(way.middle), way.by.map(|by| by / between)),
                    None => (None, grain.velocity),
                },
            };
            if let Some(bin) = bin {
                sums[bin].add_velocity(grain.mass, velocity);
            }
        }
        self.displacements.iter_mut().for_each(Displacements::end);
    }

    /// True if the table has all its samples.
    fn is_whole(&self) -> bool {
        self.schedule.samples.is_some_and(|samples| self.samples >= samples)
    }

    /// True if a table has ended with a window; with `is_last` the run has, and what the table has
    /// by then counts, if that was not told before.
    pub fn has_table(&self, window: u64, is_last: bool) -> bool {
        let whole = self.is_whole();
        self.samples > 0 && if whole { self.last == window } else { is_last }
    }

    /// Writes the means of the table as it is, one for each bin.
    ///
    /// # Panics
    /// If `bins` does not have an entry for each bin.
    pub fn table(&self, bins: &mut [ProfileBin]) -> ProfileHeader {
        assert_eq!(bins.len(), self.sums.len(), "one entry for each bin");
        for (bin, sums) in bins.iter_mut().zip(&self.sums) {
            *bin = sums.means(self.samples, self.measure);
        }
        let time = |window: u64| window as f64 * self.window;
        ProfileHeader {
            stamp: Stamp::default(),
            begin: time(self.begin),
            end: time(self.last),
            samples: self.samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{BinnedAxis, Face};

    const WINDOW: f64 = 1e-3;
    const PERIODIC: [[Face; 2]; 3] = [const { [Face::Periodic, Face::Periodic] }; 3];

    fn profile(bins: usize) -> GrainProfile {
        GrainProfile {
            name: "p".into(),
            axes: vec![BinnedAxis { axis: 0, bins }],
            min: [0.0; 3],
            max: [1.0; 3],
            from: 0.0,
            every: None,
            average: None,
            velocity: ProfileVelocity::Instantaneous,
        }
    }

    fn sampler(profile: &GrainProfile) -> ProfileSampler {
        ProfileSampler::new(profile, &Domain::new([0.0; 3], [1.0; 3], PERIODIC), WINDOW, 4)
    }

    fn table(sampler: &ProfileSampler) -> (ProfileHeader, Vec<ProfileBin>) {
        let mut bins = vec![ProfileBin::default(); sampler.sums.len()];
        (sampler.table(&mut bins), bins)
    }

    /// Numbers from 0 to 1 that follow from a key.
    fn unit(k: u64) -> f64 {
        let mixed = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64
            / (1u64 << 53) as f64
    }

    /// A uniform gas whose velocities are those of a box about a mean: variance h²/3 each, `h` half
    /// the box's edge.
    #[test]
    fn a_uniform_gas_has_its_mean_its_temperature_and_its_pressure() {
        let (grains, samples, half, mass, volume) = (4000u64, 5u64, 0.3, 2e-6, 1e-5);
        let mut sampler = sampler(&profile(4));
        for window in 1..=samples {
            let grain = |id: u64| {
                let key = 16 * (id + grains * window);
                let velocity = [0, 1, 2].map(|a| half * (2.0 * unit(key + a) - 1.0));
                GrainSample {
                    position: [3, 4, 5].map(|a| unit(key + a)),
                    velocity: [velocity[0] + 7.0, velocity[1], velocity[2] - 2.0],
                    volume,
                    mass,
                    contacts: 3,
                    virial: [1e-7, 0.0, 0.0, 0.0, 0.0, -2e-7],
                    ..GrainSample::new(id)
                }
            };
            sampler.take(window, (0..grains).map(grain));
        }
        let (header, bins) = table(&sampler);
        assert_eq!((header.samples, header.end), (samples, samples as f64 * WINDOW));
        let expected = half * half / 3.0;
        for bin in bins {
            // Four standard errors and more, of 5000 grains a bin.
            assert!((bin.grains / 1000.0 - 1.0).abs() < 0.05, "{}", bin.grains);
            assert!((bin.solid_fraction / (bin.grains * 4.0 * volume) - 1.0).abs() < 1e-12);
            assert!((bin.velocity[0] - 7.0).abs() < 0.01 && (bin.velocity[2] + 2.0).abs() < 0.01);
            assert!((bin.temperature / expected - 1.0).abs() < 0.03, "{}", bin.temperature);
            assert!((bin.fluctuation[1].powi(2) / expected - 1.0).abs() < 0.06);
            assert_eq!(bin.coordination, 3.0);
            let density = bin.grains * 4.0 * mass;
            let trace: f64 = bin.kinetic_stress[..3].iter().sum();
            assert!((trace / (3.0 * density * bin.temperature) - 1.0).abs() < 1e-12);
            assert!((bin.contact_stress[0] / (bin.grains * 4.0 * 1e-7) - 1.0).abs() < 1e-9);
            assert!((bin.contact_stress[5] / bin.contact_stress[0] + 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn velocities_of_displacements_ignore_periodic_faces_and_jitter() {
        let timed = GrainProfile {
            every: Some(4.0 * WINDOW),
            velocity: ProfileVelocity::Displacement,
            ..profile(2)
        };
        let mut sampler = sampler(&timed);
        // It goes around at 10 m/s; at the moments of samples its velocity is another.
        let at = |window: u64| GrainSample {
            position: [(0.97 + 10.0 * WINDOW * window as f64) % 1.0, 0.5, 0.5],
            velocity: [-99.0; 3],
            volume: 0.1,
            mass: 1.0,
            ..GrainSample::new(3)
        };
        let wanted: Vec<u64> = (0..20).filter(|&window| sampler.wants(window)).collect();
        assert_eq!(wanted, [0, 4, 8, 12, 16]);
        for window in wanted {
            sampler.take(window, std::iter::once(at(window)));
        }
        let (header, bins) = table(&sampler);
        assert_eq!(header.samples, 4);
        // The middle of the first way is 0.99, in the upper bin.
        for bin in &bins {
            assert!((bin.velocity[0] - 10.0).abs() < 1e-9, "{:?}", bin.velocity);
            assert!(bin.fluctuation[0] < 1e-6);
        }
        assert_eq!([bins[0].grains, bins[1].grains], [1.0, 0.0]);
    }

    #[test]
    fn tables_follow_each_other_and_the_last_may_be_short() {
        let timed = GrainProfile { from: WINDOW, average: Some(2.0 * WINDOW), ..profile(1) };
        let mut sampler = sampler(&timed);
        let mut told = Vec::new();
        for window in 1..=6 {
            if sampler.wants(window) {
                let grain = GrainSample {
                    position: [0.5; 3],
                    velocity: [window as f64, 0.0, 0.0],
                    mass: 1.0,
                    ..GrainSample::new(0)
                };
                sampler.take(window, std::iter::once(grain));
            }
            if sampler.has_table(window, window == 6) {
                let (header, bins) = table(&sampler);
                let times = [header.begin, header.end].map(|t| (t / WINDOW).round() as u64);
                told.push((times, header.samples, bins[0].velocity[0]));
            }
        }
        assert_eq!(told, [([1, 3], 2, 2.5), ([3, 5], 2, 4.5), ([5, 6], 1, 6.0)]);
        assert!(!sampler.has_table(7, false));
    }

    #[test]
    fn a_run_that_ends_with_a_table_tells_it_once() {
        let mut sampler = sampler(&GrainProfile { average: Some(WINDOW), ..profile(1) });
        assert!(!sampler.has_table(0, true), "there is no sample");
        sampler.take(1, std::iter::empty());
        assert!(sampler.has_table(1, false));
        assert!(!sampler.has_table(2, true), "it was told with its own window");
        let (_, bins) = table(&sampler);
        assert_eq!((bins[0].solid_fraction, bins[0].contact_stress), (0.0, [0.0; 6]));
        assert!(bins[0].velocity[0].is_nan() && bins[0].coordination.is_nan());
        assert_eq!(bins[0].kinetic_stress, [0.0; 6]);
    }
}
