//! Seals as a component of a run.

use crate::parameters::Parameters;
use crate::runtime::{Readings, Seal, SealError, Water};
use crate::table::{FileError, Table};
use std::collections::BTreeMap;
use std::path::Path;
use tremie_sdk::messages::finding::short;
use tremie_sdk::messages::scene::{DeformableSurface, Scene};
use tremie_sdk::messages::schedule::Content;
use tremie_sdk::messages::start::{Assignment, Description, Signal};
use tremie_sdk::messages::{
    BodyState, FacetLoad, Limit, Load, Problem, SurfaceVertex, WatchedQuantity,
};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsRubber, ControlPipe, Rubber, Setup, SolverError};

/// Seals behind the sdk's interface, in the scene's order.
pub struct Seals {
    seals: Vec<Seal>,
    /// First vertex and first facet of each.
    first: Vec<[usize; 2]>,
}

/// Name of the signal with the compression over the table's largest.
const SHARE: &str = "compression_share";
/// Shares of the table's reach, doubtful and wrong.
const REACHED: [f64; 2] = [0.9, 0.99];

/// Signals of each seal, in the order in which they are pushed, named `surface.value`.
const SIGNALS: [(&str, &str, &str); 9] = [
    ("compression", "m", "how far it is compressed"),
    (SHARE, "1", "the same over the largest compression of its table"),
    ("rate", "m/s", "rate of the compression over the last step"),
    ("force", "N", "what compresses it: the effective force of all that acts on its surface"),
    ("table_force", "N", "force of the table at this compression"),
    ("mean_passes", "1", "trials of a step, in the mean over the window"),
    ("most_passes", "1", "most trials of a step in the window"),
    ("seat_pressure", "Pa", "mean pressure of contacts on what touches the seat"),
    ("peak_seat_pressure", "Pa", "largest pressure of contacts on a facet of that"),
];

impl Rubber for Seals {
    const PROGRAM: &'static str = concat!("rubber-table ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        parameters.law()?;
        let tables = tables(scene)?;
        let pairs = || scene.surfaces.iter().zip(&tables);
        let mut resolution = BTreeMap::new();
        for (surface, table) in pairs() {
            let slope = table.bracket(0.0).map_or(f64::NAN, |at| table.slope(at));
            let name = &surface.name;
            resolution.insert(format!("facets of {name}"), surface.facet_count() as f64);
            resolution
                .insert(format!("time to settle of {name} [s]"), parameters.damping.0 / slope);
        }
        Ok(Description {
            // Implicit: any step of the grains will do.
            step: None,
            signals: signals(scene),
            work: "vertices".into(),
            notes: pairs().map(|(surface, table)| note(surface, table)).collect(),
            resolution,
            limits: scene.surfaces.iter().map(limit).collect(),
            state: Some(Seal::STATE_VERSION),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let (scene, assignment) = (&setup.hello.scene, setup.assigned()?);
        let (law, form) = (parameters.law()?, parameters.form());
        let water = water(&parameters, scene, assignment);
        let mut seals = Vec::new();
        for (i, (surface, table)) in scene.surfaces.iter().zip(tables(scene)?).enumerate() {
            let seal = Seal::new(surface, table, law, form, water, assignment.step);
            seals.push(seal.map_err(|error| vec![of_table(i, &error)])?);
        }
        let first = (seals.iter())
            .scan([0; 2], |next, seal| {
                let first = *next;
                *next = [next[0] + seal.vertex_count(), next[1] + seal.facet_count()];
                Some(first)
            })
            .collect();
        Ok(Self { seals, first })
    }

    fn start(&mut self, carriers: &[BodyState]) -> Result<(), SolverError> {
        self.seals.iter_mut().zip(carriers).for_each(|(seal, carrier)| seal.follow(carrier));
        Ok(())
    }

    fn begin_window(&mut self, loads: &[FacetLoad]) -> Result<(), SolverError> {
        for (seal, [_, first]) in self.seals.iter_mut().zip(&self.first) {
            seal.begin_window(own(loads, *first, seal.facet_count()));
        }
        Ok(())
    }

    fn begin_substep(&mut self, carriers: &[BodyState]) -> Result<(), SolverError> {
        let pairs = self.seals.iter_mut().zip(carriers);
        pairs.for_each(|(seal, carrier)| seal.begin_substep(carrier));
        Ok(())
    }

    fn surface(&self, vertices: &mut [SurfaceVertex]) {
        for (seal, [first, _]) in self.seals.iter().zip(&self.first) {
            seal.write(&mut vertices[*first..first + seal.vertex_count()]);
        }
    }

    fn strains(&self, strains: &mut [f64]) {
        for (seal, [first, _]) in self.seals.iter().zip(&self.first) {
            seal.write_strains(&mut strains[*first..first + seal.vertex_count()]);
        }
    }

    fn pass(&mut self, contacts: &[FacetLoad]) -> Result<bool, SolverError> {
        let mut all_settled = true;
        for (seal, [_, first]) in self.seals.iter_mut().zip(&self.first) {
            let facets = seal.facet_count();
            all_settled &= seal.pass(own(contacts, *first, facets)).map_err(failed)?;
        }
        Ok(all_settled)
    }

    fn resultants(&self, loads: &mut [Load]) {
        for (seal, load) in self.seals.iter().zip(loads) {
            *load = seal.resultant();
        }
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        for (k, seal) in self.seals.iter_mut().enumerate() {
            state.within(&format!("seal{k}"), |state| seal.exchange_state(state))?;
        }
        Ok(())
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        for seal in &self.seals {
            let Readings { compression, rate, force, table_force, .. } = seal.readings();
            let Readings { mean_passes, most_passes, .. } = seal.readings();
            let Readings { seat_pressure, peak_seat_pressure, .. } = seal.readings();
            values.extend([compression, compression / seal.reach(), rate, force, table_force]);
            values.extend([mean_passes, f64::from(most_passes), seat_pressure, peak_seat_pressure]);
        }
    }

    fn work(&self) -> u64 {
        self.seals.iter().map(|seal| seal.vertex_count() as u64).sum()
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsRubber<Seals>>(line)
}

/// The loads on `facets` facets from number `first` on, numbered from 0.
fn own(
    loads: &[FacetLoad],
    first: usize,
    facets: usize,
) -> impl Iterator<Item = FacetLoad> + Clone {
    let (first, end) = (first as u64, (first + facets) as u64);
    let is_own = move |load: &&FacetLoad| (first..end).contains(&load.facet);
    loads.iter().filter(is_own).map(move |load| FacetLoad { facet: load.facet - first, ..*load })
}

/// Resistance that a fluid adds to the seals, where one sits opposite.
fn water(parameters: &Parameters, scene: &Scene, assignment: &Assignment) -> Option<Water> {
    let is_wet = assignment.edges.iter().any(|edge| edge.content == Content::SurfaceLoad);
    let fluid = scene.fluid.as_ref().filter(|_| is_wet)?;
    Some(Water {
        density: fluid.density,
        sound_speed: parameters.sound_speed.0,
        added_mass: parameters.added_mass.map(|mass| mass.0),
        exchange: assignment.clock.window(),
    })
}

fn tables(scene: &Scene) -> Result<Vec<Table>, Vec<Problem>> {
    let read = |(i, surface): (usize, &DeformableSurface)| {
        Table::read(Path::new(&surface.table)).map_err(|error: FileError| of_table(i, &error))
    };
    let (mut tables, mut problems) = (Vec::new(), Vec::new());
    for table in scene.surfaces.iter().enumerate().map(read) {
        match table {
            Ok(table) => tables.push(table),
            Err(problem) => problems.push(problem),
        }
    }
    if problems.is_empty() { Ok(tables) } else { Err(problems) }
}

fn of_table(surface: usize, error: &dyn std::error::Error) -> Problem {
    Problem::new(format!("scene.surfaces[{surface}].table"), error.to_string())
}

fn failed(error: SealError) -> SolverError {
    SolverError::from_error(error)
}

fn signals(scene: &Scene) -> Vec<Signal> {
    let of = |surface: &DeformableSurface| {
        let name = surface.name.clone();
        SIGNALS.map(|(value, unit, meaning)| Signal {
            name: format!("{name}.{value}"),
            unit: unit.into(),
            meaning: meaning.into(),
            sampled: false,
        })
    };
    scene.surfaces.iter().flat_map(of).collect()
}

fn limit(surface: &DeformableSurface) -> Limit {
    let name = &surface.name;
    let [doubtful, wrong] = REACHED;
    Limit {
        signal: format!("{name}.{SHARE}"),
        quantity: format!("compression of {name} over the largest of its table"),
        unit: "1".into(),
        doubtful,
        wrong: Some(wrong),
        why: "beyond its table nothing is known of the rubber".into(),
        remedy: "a table that reaches further (`tremie rubber make-table`), a stiffer rubber, or stops that hold its carrier".into(),
        watch: Some(WatchedQuantity::Compression),
    }
}

fn note(surface: &DeformableSurface, table: &Table) -> String {
    format!(
        "{}: {} vertices, {} facets on {}; the table has {} frames up to {} m, {} N",
        surface.name,
        surface.vertex_count(),
        surface.facet_count(),
        surface.carrier,
        table.frames(),
        short(table.last_compression()),
        short(table.contents().forces[table.frames() - 1])
    )
}
