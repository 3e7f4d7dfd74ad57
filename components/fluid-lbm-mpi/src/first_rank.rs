//! Rank 0: the component that the run knows.

use crate::calls::Call;
use crate::mpi_ranks::MpiRanks;
use crate::run_line::RunLine;
use crate::timed_window::TimedWindow;
use std::cell::RefCell;
use std::process::ExitCode;
use std::time::{Duration, SystemTime};
use tremie_fluid_lbm::Communicator;
use tremie_fluid_lbm::component::LbmComponent;
use tremie_sdk::messages::frame::{SliceHeader, SliceNode, VolumeHeader};
use tremie_sdk::messages::start::{Description, VolumeGrid};
use tremie_sdk::messages::units::Time;
use tremie_sdk::messages::{
    BodyEvent, BodyState, FacetLoad, Load, Place, PortState, Problem, SurfaceVertex, bytes_of,
};
use tremie_sdk::state::{StateError, StateExchange, StatePart};
use tremie_sdk::{AsFluid, Fluid, Participant, Setup, SolverError};

/// Key of the ranks' deadline among the settings.
const DEADLINE: &str = "deadline";

/// Deadline where the settings have none [s].
const PATIENCE: f64 = 30.0;

thread_local! {
    /// The ranks that were launched together: the sdk makes the component of nothing but its setup.
    static RANKS: RefCell<Option<MpiRanks>> = const { RefCell::new(None) };
}

/// The fluid on all ranks, as rank 0 has it.
struct MpiFluid {
    share: LbmComponent,
    ranks: MpiRanks,
}

/// Takes part in the run, and ends the other ranks with it.
pub fn main(ranks: MpiRanks) -> ExitCode {
    type Component = AsFluid<MpiFluid>;
    RANKS.set(Some(ranks.clone()));
    let role = Component::ROLE.name();
    let code = tremie_sdk::main_of(&Component::program(), role, |line| {
        ranks.set_line(RunLine::new(line.replier()));
        tremie_sdk::run::<Component>(line)
    });
    ranks.tell(&Call::Quit.head(), &[]);
    code
}

/// The part of the state that a rank has.
pub fn part_of(ranks: &MpiRanks) -> StatePart {
    StatePart { number: ranks.rank() as u32, of: ranks.ranks() as u32 }
}

fn ranks() -> Result<MpiRanks, Vec<Problem>> {
    let ranks = RANKS.with_borrow(Clone::clone);
    ranks.ok_or_else(|| vec![Problem::new("settings.fluid-lbm-mpi", "there are no ranks")])
}

/// The setup of the lattice, and the deadline of ranks, from that of the component.
fn split(setup: &Setup) -> Result<(Setup, Duration), Vec<Problem>> {
    let mut of_lattice = setup.clone();
    let deadline = match of_lattice.hello.parameters.remove(DEADLINE) {
        None => PATIENCE,
        Some(value) => {
            let wrong = |text: String| vec![Problem::of_parameter(DEADLINE, text)];
            let Time(seconds) =
                serde_json::from_value(value).map_err(|error| wrong(error.to_string()))?;
            if !(seconds > 0.0 && seconds.is_finite()) {
                return Err(wrong(format!("found {seconds} s, expected more than 0")));
            }
            seconds
        }
    };
    Ok((of_lattice, Duration::from_secs_f64(deadline)))
}

impl MpiFluid {
    /// Has all other ranks make a call.
    fn call(&self, call: &Call, behind: &[u8]) {
        self.ranks.tell(&call.head(), behind);
    }
}

impl Fluid for MpiFluid {
    /// Its first word names the states, which are those of one process.
    const PROGRAM: &'static str =
        concat!("fluid-lbm ", env!("CARGO_PKG_VERSION"), " on ranks of MPI");
    const TAKES_SURFACES: bool = true;
    const TELLS_PORTS: bool = true;

    fn takes_polyhedra() -> bool {
        true
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let ranks = ranks()?;
        let (of_lattice, _) = split(setup)?;
        let description = LbmComponent::describe(&of_lattice)?;
        let shares = LbmComponent::shares(&of_lattice, ranks.ranks())?;
        let mut notes = description.notes.clone();
        // One rank has all of it: it may be asked so before a job begins.
        notes.extend(shares.into_iter().filter(|_| ranks.ranks() > 1));
        Ok(Description { notes, ..description })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let ranks = ranks()?;
        let (mut of_lattice, deadline) = split(setup)?;
        ranks.set_deadline(deadline);
        let begun = setup.assigned()?.resume.as_ref().filter(|resume| !resume.bodies_only);
        let window = begun.map_or(0, |resume| resume.window);
        let timed = setup.assigned()?.timed;
        ranks.on_line(|line| line.begin(&setup.hello.component, window, timed));
        // The ranks of a host share the threads that the component has there.
        let threads = of_lattice.hello.threads / ranks.on_this_host() as u32;
        of_lattice.hello.threads = threads.max(1);
        let wrong = |error: serde_json::Error| vec![Problem::new("", error.to_string())];
        let all = (&of_lattice.hello, of_lattice.assigned()?, deadline.as_secs_f64());
        let text = serde_json::to_vec(&all).map_err(wrong)?;
        ranks.tell(&Call::Create.head(), &text);
        let share = LbmComponent::along(&of_lattice, Some(Box::new(ranks.clone())))?;
        Ok(Self { share, ranks })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        self.call(&Call::Events, bytes_of(events));
        self.share.events(events)
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        self.call(&Call::Start, bytes_of(bodies));
        self.share.start(bodies, loads)
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        let is_timed = self.ranks.on_line(RunLine::next_window).unwrap_or(false);
        let begun = is_timed.then(SystemTime::now);
        self.call(&Call::Advance { substeps, is_timed }, bytes_of(bodies));
        let window = TimedWindow::begin(&mut self.ranks);
        self.share.advance(substeps, bodies, loads)?;
        if let Some(begun) = begun {
            let times = window.end(&mut self.ranks);
            let since = begun.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            self.ranks.on_line(|line| line.tell_times(since.as_nanos() as u64, times));
        }
        Ok(())
    }

    fn surface(&mut self, vertices: &[SurfaceVertex]) -> Result<(), SolverError> {
        self.call(&Call::Surface, bytes_of(vertices));
        self.share.surface(vertices)
    }

    fn surface_loads(&mut self, loads: &mut Vec<FacetLoad>) -> Result<(), SolverError> {
        self.share.surface_loads(loads)
    }

    fn ports(&mut self, ports: &mut [PortState]) -> Result<(), SolverError> {
        self.call(&Call::Ports(ports.len() as u64), &[]);
        self.share.ports(ports)
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Some(place) = state.place() else {
            return state.unfit("the state of several ranks is kept in files only");
        };
        let text =
            serde_json::to_vec(&place).map_err(|error| StateError::Unfit(error.to_string()))?;
        if state.restores() {
            self.call(&Call::PutBack, &text);
        } else {
            self.call(&Call::Keep, &text);
            state.keep_part(part_of(&self.ranks));
        }
        self.share.exchange_state(state)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        self.share.signals(values);
    }

    fn sampled(&mut self, values: &mut Vec<f64>) {
        self.call(&Call::Sampled, &[]);
        self.share.sampled(values);
    }

    fn row_kept(&mut self) {
        self.call(&Call::RowKept, &[]);
        self.share.row_kept();
    }

    fn place(&self, signal: &str) -> Option<Place> {
        self.call(&Call::Place(signal.into()), &[]);
        self.share.place(signal)
    }

    fn work(&self) -> u64 {
        self.share.work()
    }

    fn slice(&mut self, name: &str, nodes: &mut [SliceNode]) -> SliceHeader {
        self.call(&Call::Slice(name.into(), nodes.len() as u64), &[]);
        self.share.slice(name, nodes)
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [SliceNode]) -> VolumeHeader {
        let text = serde_json::to_vec(grid).unwrap_or_default();
        self.call(&Call::Volume(nodes.len() as u64), &text);
        self.share.volume(grid, nodes)
    }
}
