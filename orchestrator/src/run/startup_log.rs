//! Startup log: lines that components wrote to standard error before the run's log file was open.

/// Most lines that are kept of one component.
const KEPT: u64 = 1000;

/// Lines that components wrote before the first window, in the order in which they came.
#[derive(Debug, Default)]
pub struct EarlyLog {
    lines: Vec<(usize, String)>,
    /// Lines of each component, those included that were not kept.
    counts: Vec<u64>,
}

impl EarlyLog {
    /// Keeps a line of component `index`, unless `KEPT` lines of it are kept already.
    pub fn push(&mut self, index: usize, text: String) {
        if self.counts.len() <= index {
            self.counts.resize(index + 1, 0);
        }
        self.counts[index] += 1;
        if self.counts[index] <= KEPT {
            self.lines.push((index, text));
        }
    }

    /// The lines, each with its component; after them the number of lines left out.
    pub fn into_lines(self) -> impl Iterator<Item = (usize, String)> {
        let missing = self.counts.into_iter().enumerate().filter(|(_, count)| *count > KEPT).map(
            |(index, count)| {
                (index, format!("{} more lines before this are left out", count - KEPT))
            },
        );
        self.lines.into_iter().chain(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_that_floods_does_not_push_out_the_others() {
        let mut log = EarlyLog::default();
        (0..KEPT + 5).for_each(|_| log.push(1, "noise".into()));
        log.push(0, "a word".into());
        let lines: Vec<_> = log.into_lines().collect();
        assert_eq!(lines.len() as u64, KEPT + 2);
        assert_eq!(lines[lines.len() - 2], (0, "a word".into()));
        assert_eq!(lines[lines.len() - 1], (1, "5 more lines before this are left out".into()));
    }
}
