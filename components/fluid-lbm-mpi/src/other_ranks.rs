//! The other ranks: they make the calls that rank 0 makes.

use crate::calls::Call;
use crate::first_rank::part_of;
use crate::mpi_ranks::MpiRanks;
use crate::timed_window::TimedWindow;
use std::path::Path;
use std::process::ExitCode;
use std::thread::JoinHandle;
use std::time::Duration;
use tremie_fluid_lbm::component::LbmComponent;
use tremie_sdk::messages::frame::SliceNode;
use tremie_sdk::messages::start::{Assignment, Hello, VolumeGrid};
use tremie_sdk::messages::{Load, PortState, Problem, values_of};
use tremie_sdk::state::{SavedState, StateArchive, StateError, StatePart, StatePlace};
use tremie_sdk::{Fluid, Setup, SolverError, log_line};

/// Makes calls until rank 0 quits.
pub fn serve(mut ranks: MpiRanks) -> ExitCode {
    let mut share = None;
    let mut writer = PartWriter::default();
    loop {
        let bytes = ranks.wait_for_call();
        let Some((call, behind)) = Call::read(&bytes) else {
            log_line(
                "rank 0 made a call that this rank does not know: they are of different versions",
            );
            return ExitCode::FAILURE;
        };
        match (call, &mut share) {
            (Call::Quit, _) => return ExitCode::SUCCESS,
            (Call::Create, _) => match create(behind, &ranks) {
                Ok(created) => share = Some(created),
                // Rank 0 has the same problems, and tells them.
                Err(_) => share = None,
            },
            (Call::Keep, Some(share)) => {
                // An error is rank 0's as well, who tells it.
                let _ = writer.keep(behind, part_of(&ranks), share);
            }
            (Call::PutBack, Some(share)) => {
                let _ = put_back(behind, share);
            }
            (Call::Advance { substeps, is_timed }, Some(share)) => {
                let window = TimedWindow::begin(&mut ranks);
                if advance(substeps, behind, share).is_ok() && is_timed {
                    window.end(&mut ranks);
                }
            }
            // A share that failed has failed on rank 0 as well, which says why and ends.
            (call, Some(share)) => drop(make(&call, behind, share)),
            (_, None) => {}
        }
    }
}

fn create(text: &[u8], ranks: &MpiRanks) -> Result<LbmComponent, Vec<Problem>> {
    let wrong = |error: serde_json::Error| vec![Problem::new("", error.to_string())];
    let (hello, assignment, deadline): (Hello, Assignment, f64) =
        serde_json::from_slice(text).map_err(wrong)?;
    ranks.set_deadline(Duration::from_secs_f64(deadline));
    let setup = Setup { hello, assignment: Some(assignment) };
    LbmComponent::along(&setup, Some(Box::new(ranks.clone())))
}

/// Makes a call; what it gives is rank 0's to tell.
fn make(call: &Call, behind: &[u8], share: &mut LbmComponent) -> Result<(), SolverError> {
    match call {
        Call::Events => share.events(&values_of(behind).unwrap_or_default()),
        Call::Start => {
            let bodies = values_of(behind).unwrap_or_default();
            share.start(&bodies, &mut vec![Load::default(); bodies.len()])
        }
        Call::Surface => share.surface(&values_of(behind).unwrap_or_default()),
        Call::Ports(count) => share.ports(&mut vec![PortState::default(); *count as usize]),
        Call::Sampled => {
            share.sampled(&mut Vec::new());
            Ok(())
        }
        Call::RowKept => {
            share.row_kept();
            Ok(())
        }
        Call::Place(signal) => {
            share.place(signal);
            Ok(())
        }
        Call::Slice(name, count) => {
            share.slice(name, &mut vec![SliceNode::default(); *count as usize]);
            Ok(())
        }
        Call::Volume(count) => {
            let grid: Option<VolumeGrid> = serde_json::from_slice(behind).ok();
            if let Some(grid) = grid {
                share.volume(&grid, &mut vec![SliceNode::default(); *count as usize]);
            }
            Ok(())
        }
        Call::Create | Call::Advance { .. } | Call::Keep | Call::PutBack | Call::Quit => Ok(()),
    }
}

fn advance(substeps: u32, bodies: &[u8], share: &mut LbmComponent) -> Result<(), SolverError> {
    let bodies = values_of(bodies).unwrap_or_default();
    share.advance(substeps, &bodies, &mut vec![Load::default(); bodies.len()])
}

/// Writes the parts of states that this rank has, while it computes.
#[derive(Default)]
struct PartWriter {
    thread: Option<JoinHandle<()>>,
}

impl PartWriter {
    /// Copies a share's part of the state, and begins to write it.
    fn keep(
        &mut self,
        place: &[u8],
        part: StatePart,
        share: &mut LbmComponent,
    ) -> Result<(), StateError> {
        self.wait();
        let place = match place_of(place) {
            Ok(place) => place,
            Err(error) => return share.fail_exchange(error),
        };
        let state = SavedState::told(|state| {
            state.keep_part(part);
            state.within(&place.within, |state| share.exchange_state(state))
        })?;
        let write = move || {
            if let Err(error) = state.write_part(&place) {
                log_line(format_args!("rank {}: {error}", part.number));
            }
        };
        self.thread = Some(std::thread::spawn(write));
        Ok(())
    }

    /// Waits until the disk has the last part.
    fn wait(&mut self) {
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Drop for PartWriter {
    fn drop(&mut self) {
        self.wait();
    }
}

/// Puts back what a share has of a state.
fn put_back(place: &[u8], share: &mut LbmComponent) -> Result<(), StateError> {
    let opened = place_of(place).and_then(|place| Ok((StateArchive::open(&place.path)?, place)));
    let (mut archive, place) = match opened {
        Ok(opened) => opened,
        Err(error) => return share.fail_exchange(error),
    };
    archive.put_back(&place.header.program, place.header.version, |state| {
        state.within(&place.within, |state| share.exchange_state(state))?;
        // What is rank 0's alone.
        state.leave_rest();
        Ok(())
    })
}

/// The place of a state that rank 0 tells, if this rank sees its folder.
fn place_of(text: &[u8]) -> Result<StatePlace, StateError> {
    let place: StatePlace =
        serde_json::from_slice(text).map_err(|error| StateError::Unfit(error.to_string()))?;
    match place.path.parent().is_some_and(Path::is_dir) {
        true => Ok(place),
        false => Err(StateError::Unfit(format!(
            "{} is not seen from its host: ranks need a file system that they share",
            place.path.display()
        ))),
    }
}
