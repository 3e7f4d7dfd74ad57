//! A seal of a scene, through windows, substeps and trials.

use crate::mesh::Point;
use crate::runtime::facets::SectorFacets;
use crate::runtime::force::{EffectiveForce, Form};
use crate::runtime::placed::Placed;
use crate::runtime::step::{Impedance, Law, Outcome, Settled, Start, Step, StepError};
use crate::table::{FacetKind, Surface, Table};
use serde::{Deserialize, Serialize};
use tremie_geometry::Vec3;
use tremie_messages::scene::DeformableSurface;
use tremie_messages::{BodyState, FacetLoad, Load, SurfaceVertex};
use tremie_state::{KeepsState, StateError, StateExchange};

/// Resistance that a fluid adds to a seal: ρ c for each area, and out of contact a mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Density [kg/m³].
    pub density: f64,
    /// Speed of sound [m/s].
    pub sound_speed: f64,
    /// Mass of fluid that moves with the seal's foot [kg]; `None`: ρ A^(3/2), A the foot's area.
    pub added_mass: Option<f64>,
    /// Time between two exchanges with the fluid [s].
    pub exchange: f64,
}

/// Why a seal cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SealError {
    /// Its compression was not found.
    #[error("the seal \"{name}\": {error}")]
    Step {
        /// Name of the surface.
        name: String,
        /// Why.
        error: StepError,
    },
    /// The table is not the one of the scene.
    #[error(
        "the table {file} of the seal \"{name}\" has another outline than the scene; did it change since the manifest was read? Start the run anew"
    )]
    OtherTable {
        /// Name of the surface.
        name: String,
        /// The table's file.
        file: String,
    },
}

/// Readings of a seal at a window's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Readings {
    /// Compression [m].
    pub compression: f64,
    /// Its rate over the last substep [m/s].
    pub rate: f64,
    /// Effective force on the seal, F [N].
    pub force: f64,
    /// Force of the table at this compression, h [N].
    pub table_force: f64,
    /// Mean pressure of contacts on what touches the seat [Pa].
    pub seat_pressure: f64,
    /// Largest pressure of contacts on a facet of it [Pa].
    pub peak_seat_pressure: f64,
    /// Passes of the window's substeps: their mean.
    pub mean_passes: f64,
    /// Most passes of a substep of the window.
    pub most_passes: u32,
}

/// A seal of a scene: its state, and the trial of a substep.
///
/// Loads and vertices are in the world's frame. The fluid's loads are constant through a window:
/// the force that they make is found once, on the surface that the window begins with.
#[derive(Clone, Debug)]
pub struct Seal {
    name: String,
    table: Table,
    surface: Surface,
    /// Vertices of the table behind the section's points.
    outline: Vec<usize>,
    /// Equivalent shear strain of each point of the section in each frame of the table.
    strains: Vec<Vec<f64>>,
    facets: SectorFacets,
    law: Law,
    form: Form,
    /// With its foot in the fluid, and on its seat.
    impedance: [Impedance; 2],
    dt: f64,
    placed: Placed,
    settled: Settled,
    /// Compression where the window began [m], and its mean rate over the window before [m/s].
    begun: f64,
    answered: f64,
    /// The section at the start of the substep, now, and its rate.
    before: Vec<Point>,
    points: Vec<Point>,
    rates: Vec<Point>,
    /// Of the trial that the next pass is about; `None` where there is none.
    trial: Option<Trial>,
    fluid: FromFluid,
    /// Load inwards on each facet [N], while the peak is sought, or 1 where anything touches, while
    /// that is; else 0.
    pressing: Vec<f64>,
    passes: Passes,
    readings: Readings,
}

/// A substep on its way. The step begins with the first pass, which tells how stiff the contacts
/// are.
#[derive(Clone, Debug)]
struct Trial(Option<Step>);

/// The fluid's loads through a window.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct FromFluid {
    /// Its part of the effective force [N].
    effective: f64,
    /// Resultant [N], and its moment about the world's origin [N m].
    force: Vec3,
    moment: Vec3,
}

/// Passes of a window.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Passes {
    substeps: u32,
    all: u32,
    most: u32,
}

impl Seal {
    /// Largest compression of its table [m].
    pub fn reach(&self) -> f64 {
        self.table.last_compression()
    }

    /// A seal at rest, compressed as the scene says, in steps of `dt` [s]. `water`: the fluid that
    /// it moves in, if any.
    ///
    /// # Errors
    /// If `table` is not the one that `scene` was made with, or does not reach the compression at
    /// the start.
    pub fn new(
        scene: &DeformableSurface,
        table: Table,
        law: Law,
        form: Form,
        water: Option<Water>,
        dt: f64,
    ) -> Result<Self, SealError> {
        let outline = table.outline();
        let (name, file) = (scene.name.clone(), scene.table.clone());
        if outline.section != scene.section {
            return Err(SealError::OtherTable { name, file });
        }
        let at = match table.bracket(scene.start.compression) {
            Ok(at) => at,
            Err(error) => return Err(SealError::Step { name, error: error.into() }),
        };
        let surface = Surface::of(scene);
        let facets =
            SectorFacets::new(&scene.section, scene.sectors, &surface, &outline.section.points);
        let points = outline.section.points;
        let mut seal = Self {
            name,
            facets,
            placed: Placed::new(scene.pose, &surface),
            pressing: vec![0.0; surface.triangles.len()],
            before: points.clone(),
            rates: vec![[0.0; 2]; points.len()],
            points,
            strains: table.strains_of(&outline.vertices),
            outline: outline.vertices,
            settled: Settled { compression: scene.start.compression, rate: 0.0, passes: 0 },
            begun: scene.start.compression,
            answered: 0.0,
            impedance: [Impedance::default(); 2],
            trial: None,
            fluid: FromFluid::default(),
            passes: Passes::default(),
            readings: Readings::default(),
            table,
            surface,
            law,
            form,
            dt,
        };
        seal.impedance = water.map_or(seal.impedance, |water| seal.impedance_of(water));
        seal.table.vertices_of_into(at, &seal.outline, &mut seal.points);
        seal.facets.shape(&seal.surface, &seal.points);
        seal.readings.compression = scene.start.compression;
        seal.readings.table_force = seal.table.force(at);
        Ok(seal)
    }

    /// Number of its vertices.
    pub fn vertex_count(&self) -> usize {
        self.surface.vertex_count()
    }

    /// Number of its facets.
    pub fn facet_count(&self) -> usize {
        self.surface.triangles.len()
    }

    /// Resistance that a fluid adds with its foot in the fluid, and on its seat.
    pub fn impedance(&self) -> [Impedance; 2] {
        self.impedance
    }

    /// Its readings.
    pub fn readings(&self) -> Readings {
        self.readings
    }

    /// Takes it to where its carrier is; its shape stays.
    pub fn follow(&mut self, carrier: &BodyState) {
        self.placed.follow(carrier, &self.surface);
    }

    /// Begins a window, with the fluid's loads.
    pub fn begin_window(&mut self, loads: impl Iterator<Item = FacetLoad>) {
        let mut sums = self.facets.areas();
        let mut fluid = FromFluid::default();
        for FacetLoad { facet, force, point, .. } in loads {
            let facet = facet as usize;
            let force = Vec3::from(force);
            let local = self.placed.turn_to_section(force);
            sums.add_load(self.facets.kind(facet), self.facets.inward(facet, local), local.z);
            fluid.force += force;
            fluid.moment += Vec3::from(point).cross(&force);
        }
        fluid.effective = sums.force(self.form).force;
        self.fluid = fluid;
        // The motion that these loads answer.
        let now = self.settled.compression;
        let window = f64::from(self.passes.substeps) * self.dt;
        self.answered = if window > 0.0 { (now - self.begun) / window } else { 0.0 };
        self.begun = now;
        self.passes = Passes::default();
    }

    /// Begins a substep, at whose end the carrier is there. The first trial has the shape of
    /// before.
    pub fn begin_substep(&mut self, carrier: &BodyState) {
        self.follow(carrier);
        self.before.copy_from_slice(&self.points);
        self.rates.fill([0.0; 2]);
        self.trial = Some(Trial(None));
    }

    /// True if the substep is done.
    pub fn is_settled(&self) -> bool {
        self.trial.is_none()
    }

    /// Writes the vertices: of the trial, or of what was accepted.
    pub fn write(&self, out: &mut [SurfaceVertex]) {
        self.placed.write(&self.surface, &self.points, &self.rates, out);
    }

    /// Writes the equivalent shear strain at each vertex, linear in the compression between two
    /// frames of the table as all of it, at the compression that was accepted last.
    pub fn write_strains(&self, out: &mut [f64]) {
        let Ok(at) = self.table.bracket(self.settled.compression) else { return };
        let (a, b) = (&self.strains[at.frame], &self.strains[at.frame + 1]);
        for (point, out) in self.surface.section.iter().zip(out) {
            let point = *point as usize;
            *out = (1.0 - at.weight) * a[point] + at.weight * b[point];
        }
    }

    /// A pass, with the loads of contacts on the trial; `true` if it settled the substep.
    ///
    /// # Errors
    /// If the step fails.
    pub fn pass(
        &mut self,
        contacts: impl Iterator<Item = FacetLoad> + Clone,
    ) -> Result<bool, SealError> {
        let Some(Trial(step)) = self.trial.take() else { return Ok(true) };
        let (of_contacts, stiffness) = self.collect(contacts.clone());
        let force = of_contacts.force + self.fluid.effective;
        let begun = match step {
            Some(step) => Ok(step),
            None => {
                let start = self.begin(stiffness, contacts.clone());
                Step::begin(&self.table, self.law, start)
            }
        };
        let wrong = |error| SealError::Step { name: self.name.clone(), error };
        let mut step = begun.map_err(wrong)?;
        let outcome = step.pass(&self.table, force).map_err(wrong)?;
        let peak = match outcome {
            Outcome::Again => 0.0,
            Outcome::Settled(_) => self.peak(contacts),
        };
        let at = step.bracket();
        self.shape(at);
        match outcome {
            Outcome::Again => self.trial = Some(Trial(Some(step))),
            Outcome::Settled(settled) => {
                let Settled { compression, rate, passes } = settled;
                self.settled = settled;
                self.passes.add(passes);
                self.readings = Readings {
                    compression,
                    rate,
                    force,
                    table_force: self.table.force(at),
                    seat_pressure: of_contacts.seat_pressure,
                    peak_seat_pressure: peak,
                    mean_passes: f64::from(self.passes.all) / f64::from(self.passes.substeps),
                    most_passes: self.passes.most,
                };
            }
        }
        Ok(matches!(outcome, Outcome::Settled(_)))
    }

    /// Load that it passes on to its carrier besides the contacts: the fluid's loads, about the
    /// carrier's reference point.
    pub fn resultant(&self) -> Load {
        let FromFluid { force, moment, .. } = self.fluid;
        let torque = moment - self.placed.reference().cross(&force);
        Load { id: 0, force: force.into(), torque: torque.into() }
    }

    fn begin(
        &mut self,
        contact_stiffness: f64,
        contacts: impl Iterator<Item = FacetLoad> + Clone,
    ) -> Start {
        let (compression, rate) = (self.settled.compression, self.answered);
        // On its seat the sides still move, and within a step a seat holds the foot by stiffness
        // times step alone, which is far less than their impedance; but no fluid moves with the
        // foot, whose mass would bounce on the seat. A grain covers a facet of it, and hardly keeps
        // the fluid away.
        let [free, seated] = self.impedance;
        let impedance = Impedance(free.0 + (seated.0 - free.0) * self.covered(contacts));
        Start { compression, rate, dt: self.dt, contact_stiffness, impedance }
    }

    /// The share of the foot that lies in facets on which contacts press.
    fn covered(&mut self, contacts: impl Iterator<Item = FacetLoad> + Clone) -> f64 {
        let mut covered = 0.0;
        for FacetLoad { facet, .. } in contacts.clone() {
            let facet = facet as usize;
            if self.facets.kind(facet) == FacetKind::Seat && self.pressing[facet] == 0.0 {
                self.pressing[facet] = 1.0;
                covered += self.facets.area(facet);
            }
        }
        contacts.for_each(|load| self.pressing[load.facet as usize] = 0.0);
        let foot = self.facets.areas().force(self.form).seat_area;
        if foot > 0.0 { (covered / foot).min(1.0) } else { 1.0 }
    }

    fn impedance_of(&self, water: Water) -> [Impedance; 2] {
        let Water { density, sound_speed, added_mass, exchange } = water;
        let foot = self.facets.areas().force(self.form).seat_area;
        let mass = added_mass.unwrap_or(density * foot * foot.sqrt());
        [mass, 0.0].map(|mass| Impedance::of_fluid(density, sound_speed, foot, mass, exchange))
    }

    /// The section at a place of the table, and its rate over the substep.
    fn shape(&mut self, at: crate::table::Bracket) {
        self.table.vertices_of_into(at, &self.outline, &mut self.points);
        for ((rate, now), before) in self.rates.iter_mut().zip(&self.points).zip(&self.before) {
            *rate = [(now[0] - before[0]) / self.dt, (now[1] - before[1]) / self.dt];
        }
        self.facets.shape(&self.surface, &self.points);
    }

    /// The contacts' part of the effective force, and their stiffness where the seal touches its
    /// seat.
    fn collect(&self, contacts: impl Iterator<Item = FacetLoad>) -> (EffectiveForce, f64) {
        let mut sums = self.facets.areas();
        let mut seat_stiffness = 0.0;
        for FacetLoad { facet, force, stiffness, .. } in contacts {
            let facet = facet as usize;
            let kind = self.facets.kind(facet);
            let local = self.placed.turn_to_section(force.into());
            sums.add_load(kind, self.facets.inward(facet, local), local.z);
            if kind == FacetKind::Seat {
                seat_stiffness += stiffness;
            }
        }
        (sums.force(self.form), seat_stiffness)
    }

    /// Largest pressure of contacts on a facet that touches the seat [Pa].
    fn peak(&mut self, contacts: impl Iterator<Item = FacetLoad> + Clone) -> f64 {
        let mut peak = 0.0f64;
        for FacetLoad { facet, force, .. } in contacts.clone() {
            let facet = facet as usize;
            if self.facets.kind(facet) != FacetKind::Seat {
                continue;
            }
            self.pressing[facet] +=
                self.facets.inward(facet, self.placed.turn_to_section(force.into()));
            let area = self.facets.area(facet);
            if area > 0.0 {
                peak = peak.max(self.pressing[facet] / area);
            }
        }
        contacts.for_each(|load| self.pressing[load.facet as usize] = 0.0);
        peak
    }
}

impl KeepsState for Seal {
    const STATE_VERSION: u32 = 1;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        if self.trial.is_some() {
            return state.unfit("a seal is kept at the end of a substep");
        }
        let mut carrier = self.placed.carrier();
        state.value("carrier", &mut carrier)?;
        state.value("settled", &mut self.settled)?;
        state.value("begun", &mut self.begun)?;
        state.value("answered", &mut self.answered)?;
        state.array("rates", &mut self.rates)?;
        state.value("of_fluid", &mut self.fluid)?;
        state.value("passes", &mut self.passes)?;
        state.value("readings", &mut self.readings)?;
        if state.restores() {
            let at = match self.table.bracket(self.settled.compression) {
                Ok(at) => at,
                Err(error) => return state.unfit(format!("the state of a seal: {error}")),
            };
            self.table.vertices_of_into(at, &self.outline, &mut self.points);
            self.facets.shape(&self.surface, &self.points);
            self.follow(&carrier);
        }
        Ok(())
    }
}

impl Passes {
    fn add(&mut self, passes: u32) {
        self.substeps += 1;
        self.all += passes;
        self.most = self.most.max(passes);
    }
}
