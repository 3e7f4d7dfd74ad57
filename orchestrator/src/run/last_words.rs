//! Last words of a component: of what it wrote to standard error, the line that says best why it ended.

/// The line that a user is told.
#[derive(Clone, Debug, Default)]
pub struct LastWords {
    text: String,
    weight: Weight,
}

/// How much a line tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Weight {
    /// Any line.
    #[default]
    Line,
    /// A launcher of MPI says which of its ranks has died, or which host is out of reach, among many lines of advice.
    OfLauncher,
    /// The component calls it an error.
    Error,
}

/// Words of Open MPI and of MPICH about a rank that has died, and of Open MPI about a host that is out of reach.
const OF_LAUNCHERS: [&str; 3] = ["noticed that process rank", " RUNNING AT ", "Remote daemon: "];

impl LastWords {
    /// Hears a line, which the component may call an error.
    pub fn hear(&mut self, text: &str, is_error: bool) {
        let weight = match OF_LAUNCHERS.iter().any(|words| text.contains(words)) {
            _ if is_error => Weight::Error,
            true => Weight::OfLauncher,
            false => Weight::Line,
        };
        // A ruler says nothing.
        if weight >= self.weight && text.contains(char::is_alphanumeric) {
            *self = Self { text: text.trim().into(), weight };
        }
    }

    /// The line, if there was one.
    pub fn text(&self) -> Option<&str> {
        Some(&*self.text).filter(|text| !text.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_that_says_why_counts() {
        let mut words = LastWords::default();
        assert_eq!(words.text(), None);
        let mut hear = |text: &str, is_error: bool| {
            words.hear(text, is_error);
            words.text().map(str::to_string)
        };
        assert_eq!(hear("step 4", false).as_deref(), Some("step 4"));
        assert_eq!(hear("------", false).as_deref(), Some("step 4"));
        let of_mpi = "mpiexec noticed that process rank 2 with PID 77 on node a exited on signal 9";
        assert_eq!(hear(of_mpi, false).as_deref(), Some(of_mpi));
        assert_eq!(hear("please see the FAQ", false).as_deref(), Some(of_mpi));
        let lost = "Remote daemon: [[4228,0],1] on node far";
        assert_eq!(hear(&format!("  {lost}"), false).as_deref(), Some(lost));
        assert_eq!(hear("rank 1 does not answer", true).as_deref(), Some("rank 1 does not answer"));
        assert_eq!(hear("good bye", false).as_deref(), Some("rank 1 does not answer"));
    }
}
