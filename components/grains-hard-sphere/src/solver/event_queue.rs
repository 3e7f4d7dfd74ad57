//! The next event of all: a tournament among bodies, each with one time.
//!
//! A body has one event, its earliest. A change costs as many comparisons as the tree is high, and
//! allocates nothing. Of equal times the smaller number wins.

/// Times by body, and the winners among them.
#[derive(Clone, Debug, Default)]
pub struct EventQueue {
    times: Vec<f64>,
    /// Winner of each node; the children of node `k` are `2 k` and `2 k + 1`, the leaves come last.
    winners: Vec<u32>,
    leaves: usize,
}

impl EventQueue {
    /// For so many bodies, none of which has an event.
    pub fn new(bodies: usize) -> Self {
        let leaves = bodies.next_power_of_two().max(2);
        let mut winners = vec![0; 2 * leaves];
        for k in 0..leaves {
            winners[leaves + k] = k as u32;
        }
        let mut queue = Self { times: vec![f64::INFINITY; leaves], winners, leaves };
        for node in (1..leaves).rev() {
            queue.winners[node] = queue.winner_below(node);
        }
        queue
    }

    #[inline(always)]
    fn winner_below(&self, node: usize) -> u32 {
        let (one, other) = (self.winners[2 * node], self.winners[2 * node + 1]);
        // The left one has the smaller number.
        if self.times[one as usize] <= self.times[other as usize] { one } else { other }
    }

    /// Gives a body a time.
    #[inline]
    pub fn set(&mut self, body: usize, time: f64) {
        self.times[body] = time;
        let mut node = (self.leaves + body) / 2;
        while node > 0 {
            let winner = self.winner_below(node);
            let before = self.winners[node];
            self.winners[node] = winner;
            // Where another one won and still does, nothing above changes.
            if winner == before && winner != body as u32 {
                break;
            }
            node /= 2;
        }
    }

    /// The body with the earliest event, and its time.
    #[inline]
    pub fn first(&self) -> (usize, f64) {
        let body = self.winners[1] as usize;
        (body, self.times[body])
    }

    /// All times become earlier by a duration.
    pub fn shift(&mut self, duration: f64) {
        self.times.iter_mut().for_each(|time| *time -= duration);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_first_is_that_of_a_search(
            bodies in 1usize..40, changes in prop::collection::vec((0usize..40, 0u32..9), 1..200),
        ) {
            let mut queue = EventQueue::new(bodies);
            let mut times = vec![f64::INFINITY; bodies];
            for (body, time) in changes {
                let (body, time) = (body % bodies, f64::from(time));
                queue.set(body, time);
                times[body] = time;
                let least = times.iter().copied().fold(f64::INFINITY, f64::min);
                let first = times.iter().position(|t| *t == least).unwrap();
                prop_assert_eq!(queue.first(), (first, least));
            }
        }
    }
}
