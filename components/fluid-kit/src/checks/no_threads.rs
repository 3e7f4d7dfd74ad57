//! A system that gives no threads.

use tremie_messages::Problem;

/// The problem of a fluid whose team got no threads.
pub fn no_threads(error: std::io::Error) -> Vec<Problem> {
    vec![Problem::new("components", format!("the system gives no threads: {error}"))]
}
