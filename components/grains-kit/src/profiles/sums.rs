//! Sums of a bin over grains and samples, and the means that follow.

use super::grain_sample::GrainSample;
use super::moments::VelocityMoments;
use serde::{Deserialize, Serialize};
use tremie_messages::frame::ProfileBin;

/// Sums of a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BinSums {
    grains: u64,
    contacts: u64,
    /// [m³]
    volume: f64,
    /// [kg]
    mass: f64,
    /// [J]
    virial: [f64; 6],
    velocities: VelocityMoments,
}

/// What all bins of a profile have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMeasure {
    /// Volume [m³].
    pub volume: f64,
    /// The axis across a plane scene, along which nothing moves.
    pub across: Option<usize>,
}

impl BinSums {
    /// Adds a grain whose centre lies in the bin, without its velocity.
    pub fn add(&mut self, grain: &GrainSample) {
        self.grains += 1;
        self.contacts += u64::from(grain.contacts);
        self.volume += grain.volume;
        self.mass += grain.mass;
        for (sum, virial) in self.virial.iter_mut().zip(grain.virial) {
            *sum += virial;
        }
    }

    /// Adds a grain's velocity.
    pub fn add_velocity(&mut self, mass: f64, velocity: [f64; 3]) {
        self.velocities.add(mass, velocity);
    }

    /// The means over so many samples.
    pub fn means(&self, samples: u64, bin: BinMeasure) -> ProfileBin {
        let space = samples as f64 * bin.volume;
        let covariance = self.velocities.covariance();
        let moving = (0..3).filter(|axis| bin.across != Some(*axis));
        let variances = moving.clone().map(|axis| covariance[axis]).sum::<f64>();
        let density = self.mass / space;
        ProfileBin {
            grains: self.grains as f64 / samples as f64,
            solid_fraction: self.volume / space,
            velocity: self.velocities.mean(),
            fluctuation: [0, 1, 2].map(|axis| covariance[axis].sqrt()),
            temperature: variances / moving.count() as f64,
            coordination: self.contacts as f64 / self.grains as f64,
            contact_stress: self.virial.map(|virial| virial / space),
            // Where no velocity is known yet there is no stress to tell.
            kinetic_stress: covariance.map(|c| if c.is_nan() { 0.0 } else { density * c }),
        }
    }
}
