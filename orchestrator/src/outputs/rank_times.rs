//! How the ranks of a component shared its windows: what each computed, and how long it waited for others.

use serde::Serialize;
use tremie_messages::Finding;
use tremie_messages::start::RankTime;

/// Below this share of computing, fewer ranks would do nearly as well.
const LOW: f64 = 0.5;

/// Sums over windows of the times of a component's ranks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RankTimes {
    windows: u64,
    /// Of each rank.
    ranks: Vec<RankTime>,
    /// Of the rank that computed longest in each window [ns].
    longest: u64,
}

/// Where the time of ranks went, in the windows in which it was taken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RankShares {
    /// Windows in which the ranks told their times.
    pub windows: u64,
    /// Time for which each rank computed [s].
    pub compute: Vec<f64>,
    /// Time for which each waited for others: their numbers, their sums, and the transport of both [s].
    pub wait: Vec<f64>,
    /// Share of the ranks' time in which they computed: 1 is the most.
    pub efficiency: f64,
    /// Share in which ranks waited for the one that computed longest in a window.
    pub imbalance: f64,
    /// Share of the rest: messages.
    pub messages: f64,
}

impl RankTimes {
    /// Takes the times of all ranks in a window.
    pub fn take(&mut self, ranks: &[RankTime]) {
        self.windows += 1;
        self.ranks.resize(self.ranks.len().max(ranks.len()), RankTime::default());
        for (sum, time) in self.ranks.iter_mut().zip(ranks) {
            sum.compute += time.compute;
            sum.wait += time.wait;
        }
        self.longest += ranks.iter().map(|time| time.compute).max().unwrap_or(0);
    }

    /// The shares; `None` where no time passed.
    pub fn shares(&self) -> Option<RankShares> {
        let seconds = |nanoseconds: u64| nanoseconds as f64 * 1e-9;
        let compute: Vec<f64> = self.ranks.iter().map(|time| seconds(time.compute)).collect();
        let wait: Vec<f64> = self.ranks.iter().map(|time| seconds(time.wait)).collect();
        let computed: f64 = compute.iter().sum();
        let all = computed + wait.iter().sum::<f64>();
        let efficiency = if all > 0.0 { computed / all } else { return None };
        // Each rank has the same time; the longest would compute all of it if messages took none.
        let slowest = seconds(self.longest) * self.ranks.len() as f64 / all;
        let imbalance = (slowest - efficiency).max(0.0);
        let messages = (1.0 - efficiency - imbalance).max(0.0);
        Some(RankShares { windows: self.windows, compute, wait, efficiency, imbalance, messages })
    }
}

impl RankShares {
    /// The finding for a user who wonders whether so many ranks are worth it.
    pub fn finding(&self) -> Finding {
        let percent = |share: f64| 100.0 * share;
        let why = format!(
            "{} ranks compute {:.0} % of their time; {:.0} % they wait for the one with the most work, {:.0} % for messages",
            self.compute.len(),
            percent(self.efficiency),
            percent(self.imbalance),
            percent(self.messages),
        );
        let remedy =
            "fewer ranks, or more cells for each; no more ranks on a host than it has cores";
        Finding::new("efficiency of ranks", self.efficiency, "1").because(&why).doubtful_if(
            self.efficiency < LOW,
            why,
            remedy,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Verdict;

    fn of(windows: &[&[(u64, u64)]]) -> RankShares {
        let mut times = RankTimes::default();
        for window in windows {
            let ranks = window.iter().map(|&(compute, wait)| RankTime { compute, wait });
            times.take(&ranks.collect::<Vec<_>>());
        }
        times.shares().unwrap()
    }

    #[test]
    fn shares_tell_imbalance_from_messages() {
        // Both ranks are the slower one once: over both windows they compute alike.
        let shares = of(&[&[(80, 20), (60, 40)], &[(60, 40), (80, 20)]]);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(shares.efficiency, 0.7) && near(shares.imbalance, 0.1), "{shares:?}");
        assert!(near(shares.messages, 0.2), "{shares:?}");
        assert!(near(shares.compute[0], 140e-9) && near(shares.wait[1], 60e-9), "{shares:?}");
        let finding = shares.finding();
        assert_eq!(finding.verdict, Verdict::Ok);
        assert!(finding.why.contains("2 ranks compute 70 % of their time; 10 % they wait"));
    }

    #[test]
    fn ranks_that_mostly_wait_are_doubtful() {
        let shares = of(&[&[(40, 60), (30, 70)]]);
        assert_eq!(shares.finding().verdict, Verdict::Doubtful);
        assert_eq!(RankTimes::default().shares(), None);
    }
}
