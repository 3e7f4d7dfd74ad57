//! Choice between a team of threads and its caller alone, by measured times.
//!
//! A second thread costs some microseconds a list, and more where it has to be woken. So one thread
//! does small work sooner. Results do not depend on threads, so measurement may choose.

use std::time::{Duration, Instant};

/// Number of times that either way is tried.
const TRIES: u32 = 8;
/// Number of times after which both ways are tried again. It begins at `SOON`, because other
/// programs may have been in the way. It doubles up to `LATE` as long as the finding stays, and
/// begins anew where the finding changes.
const SOON: u32 = 1_000;
const LATE: u32 = 20_000;
/// Ratio of the team's time to the caller's below which the team is used.
const WORTH: f64 = 0.95;

/// Work that comes again and again, and the faster way to do it.
#[derive(Debug)]
pub struct Choice {
    threads: usize,
    /// Size of the work when it was tried.
    size: usize,
    tried: u32,
    /// Times that the work was done since trying began, and times after which it is tried again.
    since: u32,
    again: u32,
    /// Least time on the whole team, and alone.
    least: [Duration; 2],
    is_alone: bool,
    spent: Duration,
}

/// Finding of the tries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Threads of the team.
    pub threads: usize,
    /// Least time on all of them.
    pub together: Duration,
    /// Least time on one.
    pub alone: Duration,
    /// The work goes on with one thread.
    pub is_alone: bool,
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Self { threads, together, alone, is_alone } = *self;
        let used = if is_alone { 1 } else { threads };
        let [together, alone] = [together, alone].map(|time| 1e6 * time.as_secs_f64());
        write!(
            f,
            "takes {together:.0} us on {threads} threads, {alone:.0} us on one: it gets {used}"
        )
    }
}

impl Choice {
    /// Nothing is known yet of a team of `threads`.
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            size: 0,
            tried: 0,
            since: 0,
            again: SOON,
            least: [Duration::MAX; 2],
            is_alone: threads < 2,
            spent: Duration::ZERO,
        }
    }

    /// Begins work of some size; returns `true` if the caller does it alone. Both ways are tried
    /// anew when the size has grown by half or shrunk by a third since they were tried. They are
    /// tried anew now and then besides: the cost may depend on more than the size.
    pub fn begin(&mut self, size: usize) -> bool {
        if self.threads < 2 {
            return true;
        }
        self.since += 1;
        // Integers: 3/2 and 2/3 of the size, without rounding. The first call with work comes here.
        if 2 * size > 3 * self.size || 3 * size < 2 * self.size {
            *self = Self { size, ..Self::new(self.threads) };
        } else if self.since > self.again {
            (self.tried, self.since, self.least) = (0, 0, [Duration::MAX; 2]);
        }
        if self.is_trying() {
            self.spent = Duration::ZERO;
            // The first tries go to the team, the later ones to the caller alone.
            return self.tried >= TRIES;
        }
        self.is_alone
    }

    /// The present time, while tries go on; `None` spares the clock otherwise.
    pub fn clock(&self) -> Option<Instant> {
        self.is_trying().then(Instant::now)
    }

    /// Adds the time of a part of the work that began at `begin`.
    pub fn spend(&mut self, begin: Option<Instant>) {
        if let Some(begin) = begin {
            self.spent += begin.elapsed();
        }
    }

    /// Ends the work. Returns the finding, once, after the last try.
    pub fn end(&mut self) -> Option<Found> {
        if !self.is_trying() {
            return None;
        }
        let least = &mut self.least[usize::from(self.tried >= TRIES)];
        // The least time: whatever else runs on the machine only ever adds to it.
        *least = (*least).min(self.spent);
        self.tried += 1;
        if self.is_trying() {
            return None;
        }
        let [together, alone] = self.least;
        let was_alone = self.is_alone;
        self.is_alone = together.as_secs_f64() > WORTH * alone.as_secs_f64();
        self.again = if self.is_alone == was_alone { LATE.min(2 * self.again) } else { SOON };
        Some(Found { threads: self.threads, together, alone, is_alone: self.is_alone })
    }

    fn is_trying(&self) -> bool {
        self.threads > 1 && self.tried < 2 * TRIES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work of a size that takes these times.
    fn tried(
        choice: &mut Choice,
        size: usize,
        [together, alone]: [u64; 2],
    ) -> (Vec<bool>, Option<Found>) {
        let mut ways = Vec::new();
        for _ in 0..2 * TRIES {
            let is_alone = choice.begin(size);
            ways.push(is_alone);
            choice.spent = Duration::from_micros(if is_alone { alone } else { together });
            if let Some(found) = choice.end() {
                return (ways, Some(found));
            }
        }
        (ways, None)
    }

    #[test]
    fn both_ways_are_tried_and_the_faster_stays() {
        let mut choice = Choice::new(2);
        let (ways, found) = tried(&mut choice, 100, [60, 100]);
        assert_eq!(ways.iter().filter(|alone| **alone).count(), TRIES as usize);
        assert!(!found.unwrap().is_alone && !choice.begin(100) && !choice.begin(149));
        assert_eq!(choice.end(), None);
        choice = Choice::new(2);
        let (_, found) = tried(&mut choice, 100, [80, 50]);
        assert!(found.unwrap().is_alone);
        let (_, found) = tried(&mut choice, 10, [9, 7]);
        assert!(found.unwrap().is_alone && choice.begin(10));
        let (_, found) = tried(&mut choice, 16, [98, 100]);
        assert!(found.unwrap().is_alone, "hardly faster is not worth a core");
    }

    #[test]
    fn what_was_found_is_tried_again_and_ever_later_while_it_stays() {
        let mut choice = Choice::new(2);
        // Times of the work until it is tried again.
        let mut after = |times: [u64; 2]| {
            let found = tried(&mut choice, 100, times).1.unwrap();
            let mut until = 2 * TRIES;
            loop {
                let is_alone = choice.begin(100);
                if choice.clock().is_some() {
                    return until;
                }
                assert_eq!((is_alone, choice.end()), (found.is_alone, None));
                until += 1;
            }
        };
        assert!((1_000..2_100).contains(&after([60, 100])));
        assert!((2_000..4_100).contains(&after([60, 100])));
        let late: Vec<_> = (0..6).map(|_| after([60, 100])).collect();
        assert!((20_000..20_100).contains(&late[5]), "{late:?}");
        // Other programs take the cores for a while.
        assert!((1_000..1_100).contains(&after([100, 100])));
        assert!((1_000..1_100).contains(&after([60, 100])));
    }

    #[test]
    fn one_thread_has_no_choice() {
        let mut choice = Choice::new(1);
        assert!(choice.begin(1000));
        assert_eq!(choice.clock(), None);
        assert_eq!(choice.end(), None);
    }
}
