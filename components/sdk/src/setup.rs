//! The run as a component knows it when it is created.

use serde::de::DeserializeOwned;
use tremie_messages::Problem;
use tremie_messages::start::{Assignment, Hello};

/// The run as a component knows it: the hello, and later the assignment.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Scene, role, parameters, threads.
    pub hello: Hello,
    /// Steps, windows, streams; `None` while the component is only asked to describe itself.
    pub assignment: Option<Assignment>,
}

impl Setup {
    /// The component's parameters as a type of its own.
    ///
    /// # Errors
    /// A problem that names the key, what was found and what was expected; an unknown key comes
    /// with the nearest valid one.
    pub fn parameters<P: DeserializeOwned>(&self) -> Result<P, Vec<Problem>> {
        crate::parameters::read(&self.hello.parameters)
    }

    /// True if the run goes on from a checkpoint, with the outputs that were written before.
    pub fn goes_on(&self) -> bool {
        let resume = self.assignment.as_ref().and_then(|assignment| assignment.resume.as_ref());
        resume.is_some_and(|resume| resume.same_outputs)
    }

    /// The assignment; there from [`crate::Fluid::create`] and its like on.
    ///
    /// # Errors
    /// A problem, if it is asked for while the component only describes itself.
    pub fn assigned(&self) -> Result<&Assignment, Vec<Problem>> {
        self.assignment
            .as_ref()
            .ok_or_else(|| vec![Problem::new("", "asked for an assignment before there is one")])
    }
}
