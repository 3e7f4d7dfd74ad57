//! Bodies on their way: from collision to collision, or from step to step.

pub mod diagnostics;
pub mod event_driver;
pub mod event_queue;
pub mod hard_system;
pub mod step_driver;
