//! Monitor: windows completed by each component, sums of their reports, waits for peers. It is
//! pure: reports and waits go in, rows of signals and faults come out.

use crate::outputs::{ComponentTotals, SignalRow};
use std::collections::VecDeque;
use std::time::{Duration, Instant};
use tremie_messages::control::Report;
use tremie_messages::start::{Clock, Fault, FaultKind};

/// A component that takes part in the physics.
#[derive(Clone, Debug)]
pub struct WatchedComponent {
    /// Its name.
    pub name: String,
    /// Substeps that it must make in a window.
    pub substeps: u32,
    /// Number of its signals.
    pub signals: usize,
    /// Number of values of places that follow them in its reports.
    pub places: usize,
}

/// A row of signals, with the places of those that the run watches.
#[derive(Clone, Debug, PartialEq)]
pub struct WatchedRow {
    /// The signals.
    pub row: SignalRow,
    /// Places of each component, one component after the other.
    pub places: Vec<f64>,
}

/// A row that waits for the reports of some components.
#[derive(Debug)]
struct PendingRow {
    row: WatchedRow,
    missing: usize,
}

/// A component that waits for a peer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// The peer.
    pub from: String,
    /// The missing message, as `state of window 7`.
    pub what: String,
    /// Window of the missing message.
    pub owed: u64,
    /// Time at which the wait began, by the machine's clock [ns].
    pub since: u64,
    /// Time at which the last look at the channel began, by the same clock [ns].
    pub looked: u64,
    /// The window that the component works on.
    pub window: u64,
    /// Inside a window: place of the message in its exchange; else 0.
    pub turn: u64,
}

/// Progress of a run: reports, rows of signals, waits.
#[derive(Debug)]
pub struct Monitor {
    run: u64,
    clock: Clock,
    watched: Vec<WatchedComponent>,
    /// Index of each component's first signal in a row, and of its first value of a place.
    offsets: Vec<[usize; 2]>,
    /// Next window that each component has to report.
    next: Vec<u64>,
    totals: Vec<ComponentTotals>,
    waiting: Vec<Option<Waiting>>,
    /// Time of each component's last report.
    heard: Vec<Instant>,
    rows: VecDeque<PendingRow>,
}

impl Monitor {
    /// Nothing has been reported yet; the windows up to `done` were, before the run goes on.
    pub fn new(
        run: u64,
        clock: Clock,
        watched: Vec<WatchedComponent>,
        done: Option<u64>,
        now: Instant,
    ) -> Self {
        let offsets = watched
            .iter()
            .scan([0; 2], |next, component| {
                let offset = *next;
                *next = [next[0] + component.signals, next[1] + component.places];
                Some(offset)
            })
            .collect();
        let count = watched.len();
        Self {
            run,
            clock,
            watched,
            offsets,
            next: vec![done.map_or(0, |window| window + 1); count],
            totals: vec![ComponentTotals::default(); count],
            waiting: vec![None; count],
            heard: vec![now; count],
            rows: VecDeque::new(),
        }
    }

    /// Takes component `index`'s report on a window.
    ///
    /// # Errors
    /// A fault if the report is not the one that the schedule foretells.
    pub fn report(
        &mut self,
        index: usize,
        report: &Report,
        signals: &[f64],
        now: Instant,
    ) -> Result<(), Fault> {
        let window = self.next[index];
        let component = &self.watched[index];
        // The start exchange makes no substeps.
        let substeps = if window == 0 { 0 } else { component.substeps };
        let stamp = report.stamp;
        let wrong = |kind, message| Err(self.fault(kind, index, window, message));
        // The stamp first: the rest of a report of another run or window means nothing.
        if stamp.run != self.run || stamp.window != window {
            return wrong(
                FaultKind::Stamp,
                format!(
                    "it reported {stamp}; the plan of the orchestrator expects window {window}"
                ),
            );
        }
        if stamp.substep != substeps || stamp.ticks != window * self.clock.ticks_per_window {
            return wrong(
                FaultKind::Substeps,
                format!(
                    "it made {} substeps; the plan of the orchestrator has {substeps}",
                    stamp.substep
                ),
            );
        }
        let Some((signals, places)) = (signals.len() == component.signals + component.places)
            .then(|| signals.split_at(component.signals))
        else {
            let WatchedComponent { signals: expected, places, .. } = component;
            let text = format!(
                "it reported {} values, expected {expected} signals and {places} values of places",
                signals.len()
            );
            return wrong(FaultKind::Count, text);
        };
        let totals = &mut self.totals[index];
        totals.compute += report.compute;
        totals.wait += report.wait;
        totals.exchange += report.exchange;
        totals.work += report.work;
        self.next[index] = window + 1;
        self.heard[index] = now;
        self.enter(index, window, signals, places);
        Ok(())
    }

    fn enter(&mut self, index: usize, window: u64, signals: &[f64], places: &[f64]) {
        let width = |of: fn(&WatchedComponent) -> usize| self.watched.iter().map(of).sum();
        let (width, room) =
            (width(|component| component.signals), width(|component| component.places));
        let first = self.rows.front().map_or(window, |first| first.row.row.window);
        let place = (window - first) as usize;
        // A component may report windows ahead of the others: their rows stand open until all have.
        while self.rows.len() <= place {
            let window = first + self.rows.len() as u64;
            let row = WatchedRow {
                row: SignalRow { window, values: vec![f64::NAN; width] },
                places: vec![f64::NAN; room],
            };
            self.rows.push_back(PendingRow { row, missing: self.watched.len() });
        }
        let pending = &mut self.rows[place];
        let [at, place] = self.offsets[index];
        pending.row.row.values[at..at + signals.len()].copy_from_slice(signals);
        pending.row.places[place..place + places.len()].copy_from_slice(places);
        pending.missing -= 1;
    }

    /// The next window that all components have reported, once.
    pub fn next_row(&mut self) -> Option<WatchedRow> {
        if self.rows.front()?.missing > 0 {
            return None;
        }
        self.rows.pop_front().map(|pending| pending.row)
    }

    /// Rows that some components have yet to report, in the order of their windows; what is missing
    /// is NaN.
    pub fn rows_under_way(&self) -> impl Iterator<Item = &WatchedRow> {
        self.rows.iter().map(|pending| &pending.row)
    }

    /// Last window that all components completed; `None` before the start exchange is over.
    pub fn common_window(&self) -> Option<u64> {
        self.next.iter().min().and_then(|next| next.checked_sub(1))
    }

    /// Last window that component `index` completed.
    pub fn window_of(&self, index: usize) -> Option<u64> {
        self.next[index].checked_sub(1)
    }

    /// Sums of the reports of each component.
    pub fn totals(&self) -> &[ComponentTotals] {
        &self.totals
    }

    /// The same, to be put back where a run goes on.
    pub fn totals_mut(&mut self) -> &mut [ComponentTotals] {
        &mut self.totals
    }

    /// Takes word from component `index` that it has looked for a peer's message in vain.
    pub fn waiting(&mut self, index: usize, wait: Waiting) {
        self.waiting[index] = Some(wait);
    }

    /// Takes word from component `index` that it waits no longer.
    pub fn resumed(&mut self, index: usize, now: Instant) {
        self.waiting[index] = None;
        self.heard[index] = now;
    }

    /// True if every component has completed all windows through `granted`.
    pub fn all_wait_for_credit(&self, granted: u64) -> bool {
        self.next.iter().all(|next| *next > granted)
    }

    /// Components may advance further from now on: deadlines for their reports count from `now`.
    pub fn granted(&mut self, now: Instant) {
        self.heard.fill(now);
    }

    /// Fault of a lost message; `None` while a message may be under way. A message is lost if every
    /// component has looked for one after the last of them had sent everything and begun to wait.
    /// However slow the machine is, nothing can be under way then.
    pub fn lost_message(&self) -> Option<Fault> {
        let all: Option<Vec<&Waiting>> = self.waiting.iter().map(Option::as_ref).collect();
        let all = all?;
        let last_began = all.iter().map(|wait| wait.since).max()?;
        if all.iter().any(|wait| wait.looked <= last_began) {
            return None;
        }
        // A sender that has completed the window of the missing message claims to have sent it.
        // Inside a window, a sender that waits for a later message of the same exchange claims it
        // too.
        let claims_to_have_sent = |wait: &Waiting| {
            let Some(sender) = self.watched.iter().position(|c| c.name == wait.from) else {
                return false;
            };
            let later = all[sender].owed == wait.owed && all[sender].turn > wait.turn;
            self.next[sender] > wait.owed || (wait.turn > 0 && later)
        };
        let (index, wait) = (self.waiting.iter().enumerate())
            .filter_map(|(index, wait)| Some((index, wait.as_ref()?)))
            // A waiter whose sender claims to have sent comes first; then the lowest index.
            .max_by_key(|(index, wait)| (claims_to_have_sent(wait), std::cmp::Reverse(*index)))?;
        Some(Fault {
            kind: FaultKind::Lost,
            noticed_by: self.watched[index].name.clone(),
            blamed: wait.from.clone(),
            window: wait.window,
            message: format!(
                "{} never reached {}, and all components wait for each other",
                wait.what, self.watched[index].name
            ),
        })
    }

    /// Fault of a component that may advance through `granted`, does not wait, and has not reported
    /// for longer than `deadline`.
    pub fn silent(&self, now: Instant, granted: u64, deadline: Duration) -> Option<Fault> {
        let index = (0..self.watched.len()).find(|&index| {
            self.next[index] <= granted
                && self.waiting[index].is_none()
                && now.duration_since(self.heard[index]) > deadline
        })?;
        let text = format!(
            "it reported nothing within the deadline of {} s (run.deadline)",
            deadline.as_secs_f64()
        );
        Some(self.fault(FaultKind::Deadline, index, self.next[index], text))
    }

    fn fault(&self, kind: FaultKind, index: usize, window: u64, message: String) -> Fault {
        Fault {
            kind,
            noticed_by: "the orchestrator".into(),
            blamed: self.watched[index].name.clone(),
            window,
            message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Stamp;

    fn monitor() -> Monitor {
        let watched = |name: &str, substeps, signals| WatchedComponent {
            name: name.into(),
            substeps,
            signals,
            places: if name == "grains" { 5 } else { 0 },
        };
        let clock = Clock { tick: 0.1, ticks_per_window: 3 };
        Monitor::new(
            7,
            clock,
            vec![watched("fluid", 1, 1), watched("grains", 3, 2)],
            None,
            Instant::now(),
        )
    }

    /// Two signals of the grains, and a place.
    fn with_places([a, b]: [f64; 2]) -> [f64; 7] {
        [a, b, 0.1, 0.2, 0.3, 7.0, f64::NAN]
    }

    fn report(window: u64, substep: u32) -> Report {
        let stamp = Stamp { run: 7, window, ticks: 3 * window, events: 0, substep, iteration: 0 };
        Report { stamp, compute: 5, ..Report::default() }
    }

    #[test]
    fn a_row_is_whole_when_all_have_reported() {
        let (mut m, now) = (monitor(), Instant::now());
        m.report(1, &report(0, 0), &with_places([1.0, 2.0]), now).unwrap();
        m.report(1, &report(1, 3), &with_places([3.0, 4.0]), now).unwrap();
        assert_eq!((m.common_window(), m.next_row()), (None, None));
        m.report(0, &report(0, 0), &[9.0], now).unwrap();
        assert_eq!(m.common_window(), Some(0));
        assert_eq!(m.next_row().unwrap().row.values, [9.0, 1.0, 2.0]);
        assert_eq!(m.next_row(), None);
        m.report(0, &report(1, 1), &[8.0], now).unwrap();
        assert_eq!(m.next_row().unwrap().row.values, [8.0, 3.0, 4.0]);
        assert_eq!(m.totals()[1].compute, 10);
    }

    #[test]
    fn places_follow_the_signals_and_rows_under_way_are_seen() {
        let (mut m, now) = (monitor(), Instant::now());
        m.report(1, &report(0, 0), &with_places([1.0, 2.0]), now).unwrap();
        let under_way = m.rows_under_way().next().unwrap().clone();
        assert!(under_way.row.values[0].is_nan() && under_way.row.values[1..] == [1.0, 2.0]);
        assert_eq!(under_way.places[..4], [0.1, 0.2, 0.3, 7.0]);
        m.report(0, &report(0, 0), &[9.0], now).unwrap();
        assert_eq!(m.next_row().unwrap().places[..4], under_way.places[..4]);
        let fault = m.report(1, &report(1, 3), &[1.0, 2.0], now).unwrap_err();
        assert!(fault.message.contains("2 values, expected 2 signals and 5 values"), "{fault}");
    }

    #[test]
    fn one_substep_too_many_or_too_few_is_a_fault_of_that_component() {
        for wrong in [2, 4] {
            let (mut m, now) = (monitor(), Instant::now());
            m.report(1, &report(0, 0), &with_places([0.0; 2]), now).unwrap();
            let fault = m.report(1, &report(1, wrong), &with_places([0.0; 2]), now).unwrap_err();
            assert_eq!((fault.kind, fault.blamed.as_str()), (FaultKind::Substeps, "grains"));
            assert!(fault.message.contains(&format!("made {wrong}")), "{fault}");
            assert!(fault.message.contains("has 3"), "{fault}");
        }
    }

    #[test]
    fn a_skipped_window_and_a_foreign_run_are_faults() {
        let (mut m, now) = (monitor(), Instant::now());
        assert_eq!(m.report(0, &report(1, 1), &[0.0], now).unwrap_err().kind, FaultKind::Stamp);
        let mut foreign = report(0, 0);
        foreign.stamp.run = 8;
        assert_eq!(m.report(0, &foreign, &[0.0], now).unwrap_err().kind, FaultKind::Stamp);
    }

    #[test]
    fn a_lost_message_is_blamed_on_its_sender() {
        let (mut m, now) = (monitor(), Instant::now());
        for window in 0..=4 {
            m.report(
                1,
                &report(window, if window == 0 { 0 } else { 3 }),
                &with_places([0.0; 2]),
                now,
            )
            .unwrap();
        }
        let wait = |from: &str, owed, since, looked, window| Waiting {
            from: from.into(),
            what: "a message".into(),
            owed,
            since,
            looked,
            window,
            turn: 0,
        };
        m.waiting(1, wait("fluid", 4, 100, 160, 5));
        m.waiting(1, wait("fluid", 4, 100, 220, 5));
        assert_eq!(m.lost_message(), None, "the fluid may be computing");
        m.waiting(0, wait("grains", 4, 230, 290, 4));
        assert_eq!(m.lost_message(), None, "the fluid may have sent after the grains looked");
        m.waiting(1, wait("fluid", 4, 100, 280, 5));
        let fault = m.lost_message().unwrap();
        assert_eq!((fault.blamed.as_str(), fault.noticed_by.as_str()), ("grains", "fluid"));
        m.resumed(0, now);
        assert_eq!(m.lost_message(), None);
    }

    #[test]
    fn inside_a_window_the_one_that_waits_for_a_later_message_has_lost_an_earlier() {
        let (mut m, now) = (monitor(), Instant::now());
        for index in 0..2 {
            let values = if index == 0 { vec![0.0] } else { with_places([0.0; 2]).to_vec() };
            m.report(index, &report(0, 0), &values, now).unwrap();
        }
        let wait = |from: &str, turn| Waiting {
            from: from.into(),
            what: "a trial".into(),
            owed: 1,
            since: 100,
            looked: 200,
            window: 1,
            turn,
        };
        for [early, late] in [["fluid", "grains"], ["grains", "fluid"]] {
            let index = usize::from(early == "grains");
            m.waiting(index, wait(late, 7));
            m.waiting(1 - index, wait(early, 8));
            let fault = m.lost_message().unwrap();
            assert_eq!((fault.blamed.as_str(), fault.noticed_by.as_str()), (late, early));
        }
    }

    #[test]
    fn silence_counts_only_with_leave_to_advance() {
        let (mut m, now) = (monitor(), Instant::now());
        let later = now + Duration::from_secs(2);
        m.report(0, &report(0, 0), &[0.0], later).unwrap();
        let fault = m.silent(later, 0, Duration::from_secs(1)).unwrap();
        assert_eq!((fault.blamed.as_str(), fault.window), ("grains", 0));
        m.report(1, &report(0, 0), &with_places([0.0; 2]), later).unwrap();
        assert_eq!(m.silent(later + Duration::from_secs(9), 0, Duration::from_secs(1)), None);
    }
}
