//! Probes of the scene, with sums over the spheres.
//!
//! Sums are taken over blocks of ids, and these in their order: the same bits on any number of
//! threads.

mod overlap;
mod regions;
mod rings;
mod sections;

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, PlacedSphere, take_out};
use regions::ProbeRegion;
use rings::Annulus;
use sections::Section;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_messages::scene::{Domain, Probe, ProbeShape, Scene};
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// Volume of the part of a sphere that lies in a box [m³].
pub(crate) fn volume_in_box(radius: f64, x: Vec3, min: Vec3, max: Vec3) -> f64 {
    overlap::of_sphere_and_box(radius, (min - x).into(), (max - x).into())
}

/// Names and units of the values of a scene's probes, in their order: `probe.value`. Points and
/// lines are the fluid's alone.
pub fn probe_signals(scene: &Scene) -> Vec<(String, &'static str)> {
    scene.probe_signals(values)
}

/// Meanings of these values.
#[cfg(feature = "component")]
pub(crate) const PROBE_MEANINGS: &[(&str, &str)] = &[
    (
        "mass_flow_rate",
        "mass of grains that passes in a second, positive along the axis: the mean since the row before",
    ),
    (
        "crossings",
        "grains that passed since the start, less those that came back; in a clump each piece counts",
    ),
    ("mass_passed", "mass of grains that passed since the start, less what came back"),
    (
        "solid_fraction",
        "volume of grains over that of the region; overlaps in a clump count twice unless its mass is that of the union",
    ),
    ("number", "grains there"),
    ("velocity_x", "mean velocity of the grains there, by volume"),
    ("velocity_y", "mean velocity of the grains there, by volume"),
    ("velocity_z", "mean velocity of the grains there, by volume"),
    ("projected_area", "area of the ring that grains hide, seen along its axis"),
    ("area_fraction", "that area over the ring's"),
];

fn values(shape: &ProbeShape) -> &'static [(&'static str, &'static str)] {
    match shape {
        ProbeShape::Point(_) | ProbeShape::Line { .. } | ProbeShape::Profile { .. } => &[],
        ProbeShape::Section { .. } => {
            &[("mass_flow_rate", "kg/s"), ("crossings", "1"), ("mass_passed", "kg")]
        }
        ProbeShape::Region { .. } => &[
            ("solid_fraction", "1"),
            ("number", "1"),
            ("velocity_x", "m/s"),
            ("velocity_y", "m/s"),
            ("velocity_z", "m/s"),
        ],
        ProbeShape::Ring(_) => &[("number", "1"), ("projected_area", "m2"), ("area_fraction", "1")],
    }
}

/// The probes of a scene that see spheres.
#[derive(Debug, Default)]
pub(crate) struct Probes {
    kinds: Vec<ProbeKind>,
    sections: Vec<Section>,
    regions: Vec<ProbeRegion>,
    rings: Vec<Annulus>,
    /// Masses by rank [kg]: given motions have one too.
    mass: Vec<f64>,
    /// Part of its volume that counts, by rank, where that is not all of it for some: of pieces of
    /// unions.
    parts: Vec<f64>,
    /// Positions by rank when sections were last looked at.
    before: Vec<Vec3>,
    crossings: Vec<sections::SectionSum>,
    contents: Vec<regions::RegionSum>,
    hidden: Vec<rings::RingSum>,
}

/// Kind of the next probe: the list that it stands in.
#[derive(Clone, Copy, Debug)]
enum ProbeKind {
    Section,
    Region,
    Ring,
}

impl Probes {
    /// Probes of a scene with these bodies, by id.
    pub fn new(
        probes: &[Probe],
        domain: &Domain,
        placed: &[PlacedSphere],
        bodies: &Bodies,
    ) -> Self {
        let mut own = Self::default();
        if placed.iter().any(|body| body.share.is_some()) {
            own.parts = placed.iter().map(PlacedSphere::part).collect();
        }
        for probe in probes {
            match &probe.shape {
                ProbeShape::Point(_) | ProbeShape::Line { .. } | ProbeShape::Profile { .. } => {}
                ProbeShape::Section { axis, position, min, max } => {
                    own.kinds.push(ProbeKind::Section);
                    own.sections.push(Section::new(*axis, *position, *min, *max));
                }
                ProbeShape::Region { min, max } => {
                    own.kinds.push(ProbeKind::Region);
                    own.regions.push(ProbeRegion { min: (*min).into(), max: (*max).into() });
                }
                ProbeShape::Ring(ring) => {
                    own.kinds.push(ProbeKind::Ring);
                    own.rings.push(Annulus::new(ring, domain));
                }
            }
        }
        if !own.sections.is_empty() {
            own.before = bodies.slot.iter().map(|&slot| bodies.balls[slot as usize].x).collect();
            own.mass = placed.iter().map(|body| body.mass).collect();
        }
        own.fit(bodies.len());
        own
    }

    /// Keeps what has passed sections, or puts it back, for bodies that are back already.
    pub fn keep(&mut self, state: &mut StateExchange<'_>, bodies: usize) -> Result<(), StateError> {
        state.value("sections", &mut self.sections)?;
        state.value("mass", &mut self.mass)?;
        state.value("parts", &mut self.parts)?;
        state.value("before", &mut self.before)?;
        if state.restores() {
            self.fit(bodies);
        }
        Ok(())
    }

    /// Sums for so many bodies.
    fn fit(&mut self, bodies: usize) {
        let blocks = bodies.div_ceil(BLOCK);
        self.crossings.resize(blocks * self.sections.len(), sections::SectionSum::default());
        self.contents.resize(blocks * self.regions.len(), regions::RegionSum::default());
        self.hidden.resize(blocks * self.rings.len(), rings::RingSum::default());
    }

    /// Bodies of the ranks `gone`, which ascend, are not there any more; others, with their masses
    /// [kg], came after the rest.
    pub fn exchange(&mut self, gone: &[u32], masses: impl Iterator<Item = f64>, bodies: &Bodies) {
        if !self.parts.is_empty() {
            take_out(&mut self.parts, gone);
            self.parts.resize(bodies.len(), 1.0);
        }
        if !self.sections.is_empty() {
            take_out(&mut self.mass, gone);
            take_out(&mut self.before, gone);
            self.mass.extend(masses);
            let added = &bodies.slot[self.before.len()..];
            self.before.extend(added.iter().map(|&slot| bodies.balls[slot as usize].x));
        }
        self.fit(bodies.len());
    }

    /// Notes which spheres crossed a section since the last time, `duration` [s] ago.
    pub fn pass(&mut self, team: &mut Team, bodies: &Bodies, bounds: &PeriodicBox, duration: f64) {
        if !self.sections.is_empty() {
            let (before, sums) = (&mut self.before, &mut self.crossings);
            sections::pass(&mut self.sections, before, sums, team, (bodies, &self.mass, bounds));
            self.sections.iter_mut().for_each(|section| section.end(duration));
        }
    }

    /// Begins means over time anew.
    pub fn restart_means(&mut self) {
        self.sections.iter_mut().for_each(Section::restart_mean);
    }

    /// Appends the values of all probes to `out`, SI units.
    pub fn read(
        &mut self,
        team: &mut Team,
        bodies: &Bodies,
        bounds: &PeriodicBox,
        out: &mut Vec<f64>,
    ) {
        let seen = (bodies, &self.parts[..]);
        regions::look(&self.regions, &mut self.contents, team, seen, bounds);
        rings::look(&self.rings, &mut self.hidden, team, bodies, bounds);
        let mut rings = self.rings.iter().enumerate();
        let (mut sections, mut regions) = (self.sections.iter(), self.regions.iter().enumerate());
        for kind in &self.kinds {
            match kind {
                ProbeKind::Section => {
                    out.extend(sections.next().into_iter().flat_map(Section::values))
                }
                ProbeKind::Region => {
                    out.extend(regions.next().into_iter().flat_map(|(k, region)| {
                        let sums = self.contents.iter().skip(k).step_by(self.regions.len());
                        region.values(sums)
                    }))
                }
                ProbeKind::Ring => out.extend(rings.next().into_iter().flat_map(|(k, ring)| {
                    let sums = self.hidden.iter().skip(k).step_by(self.rings.len());
                    ring.values(sums)
                })),
            }
        }
    }
}
