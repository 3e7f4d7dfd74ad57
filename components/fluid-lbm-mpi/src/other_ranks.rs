//! The other ranks: they make the calls that rank 0 makes.

use crate::calls::Call;
use crate::mpi_ranks::MpiRanks;
use std::process::ExitCode;
use std::time::Duration;
use tremie_fluid_lbm::component::LbmComponent;
use tremie_sdk::messages::frame::SliceNode;
use tremie_sdk::messages::start::{Assignment, Hello, VolumeGrid};
use tremie_sdk::messages::{Load, PortState, Problem, values_of};
use tremie_sdk::{Fluid, Setup, SolverError, log_line};

/// Makes calls until rank 0 quits.
pub fn serve(mut ranks: MpiRanks) -> ExitCode {
    let mut share = None;
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
        Call::Advance { substeps } => {
            let bodies = values_of(behind).unwrap_or_default();
            share.advance(*substeps, &bodies, &mut vec![Load::default(); bodies.len()])
        }
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
        Call::Create | Call::Quit => Ok(()),
    }
}
