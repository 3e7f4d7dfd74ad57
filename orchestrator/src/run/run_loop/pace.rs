//! Pace: windows a second.

use std::time::Instant;

/// Shortest time of a measurement [s]: rates of shorter times are mostly noise.
const SHORTEST: f64 = 0.05;

/// Rate at which windows are completed, however long they are.
#[derive(Debug)]
pub struct Pace {
    /// Windows completed, and when the last of them was, at the begin of a measurement.
    mark: (u64, Instant),
    /// Windows completed by now.
    done: u64,
    rate: f64,
}

impl Pace {
    /// Nothing is completed yet.
    pub fn new(now: Instant) -> Self {
        Self { mark: (0, now), done: 0, rate: 0.0 }
    }

    /// Takes the number of windows that are completed, the start exchange included. Called often: a
    /// change is seen about when it happens, and only then is a measurement at its end.
    pub fn note(&mut self, done: u64, now: Instant) {
        let (before, begin) = self.mark;
        let is_news = done > self.done;
        self.done = done;
        if before == 0 {
            // The start exchange is no window, and may take longer than one.
            self.mark = (done, now);
            return;
        }
        let since = now.duration_since(begin).as_secs_f64();
        if since <= SHORTEST {
            return;
        }
        if is_news {
            self.rate = (done - before) as f64 / since;
            self.mark = (done, now);
        } else {
            // The next window is not completed yet.
            self.rate = self.rate.min((done - before + 1) as f64 / since);
        }
    }

    /// Windows a second; 0 before the first is completed.
    pub fn rate(&self) -> f64 {
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Rate after some seconds of windows of a length [s], looked at every millisecond; the start
    /// exchange takes two seconds.
    fn after(seconds: u64, window: f64) -> f64 {
        let begin = Instant::now();
        let mut pace = Pace::new(begin);
        for at in 0..1000 * seconds {
            let since_start = at as f64 * 1e-3 - 2.0;
            let done = if since_start < 0.0 { 0 } else { 1 + (since_start / window) as u64 };
            pace.note(done, begin + Duration::from_millis(at));
        }
        pace.rate()
    }

    #[test]
    fn the_rate_is_right_for_windows_of_any_length() {
        for window in [2e-5, 2e-3, 0.03, 0.049, 0.06, 0.44, 3.0] {
            let rate = after(20, window);
            assert!((rate * window - 1.0).abs() < 0.05, "{window}: {rate}");
        }
        assert_eq!(after(5, 10.0), 0.0, "no window is completed yet");
    }

    #[test]
    fn a_window_that_takes_long_lowers_the_rate() {
        let begin = Instant::now();
        let mut pace = Pace::new(begin);
        let at = |seconds: f64| begin + Duration::from_secs_f64(seconds);
        for (done, seconds) in [(1, 0.0), (2, 0.1), (3, 0.2)] {
            pace.note(done, at(seconds));
        }
        assert!((pace.rate() - 10.0).abs() < 1e-6);
        pace.note(3, at(2.2));
        assert!((pace.rate() - 0.5).abs() < 1e-6);
    }
}
