//! Marked graphs (Commoner, Holt, Even and Pnueli, J. Comput. Syst. Sci. 5 (1971) 511): events
//! that happen again and again, and places with tokens between them.
//!
//! An event can happen when each place into it has a token; it takes one from each and puts one
//! into each place out of it. The number of tokens on a cycle never changes. Hence two theorems:
//! all events can go on for ever exactly when no cycle is without tokens; and a place holds at most
//! as many tokens as lie on the poorest cycle through it.

/// A place between two events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Event that fills it.
    pub from: usize,
    /// Event that empties it.
    pub to: usize,
    /// Tokens at the start.
    pub tokens: u64,
}

/// Events, numbered from 0, and the places between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    pub events: usize,
    pub places: Vec<Place>,
}

impl Graph {
    /// A new place.
    pub fn place(&mut self, from: usize, to: usize, tokens: u64) {
        self.places.push(Place { from, to, tokens });
    }

    /// A cycle without tokens, as the events on it in order: they wait for each other for ever.
    pub fn dead_cycle(&self) -> Option<Vec<usize>> {
        let mut state = vec![Visit::New; self.events];
        let mut trail = Vec::new();
        (0..self.events).find_map(|event| self.follow(event, &mut state, &mut trail))
    }

    fn follow(
        &self,
        event: usize,
        state: &mut [Visit],
        trail: &mut Vec<usize>,
    ) -> Option<Vec<usize>> {
        match state[event] {
            Visit::Done => return None,
            // The event is on the trail: the part of the trail from it on is the cycle.
            Visit::Open => {
                let start = trail.iter().position(|on| *on == event)?;
                return Some(trail[start..].to_vec());
            }
            Visit::New => {}
        }
        state[event] = Visit::Open;
        trail.push(event);
        let next = self.places.iter().filter(|place| place.from == event && place.tokens == 0);
        let cycle = next.map(|place| place.to).find_map(|to| self.follow(to, state, trail));
        trail.pop();
        state[event] = Visit::Done;
        cycle
    }

    /// Most tokens that `place` can ever hold; `None`: without bound.
    pub fn bound(&self, place: Place) -> Option<u64> {
        // Bellman-Ford, with tokens as lengths, from the place's end back to its beginning.
        let mut tokens: Vec<Option<u64>> = vec![None; self.events];
        tokens[place.to] = Some(0);
        // A shortest way has fewer places than there are events, so the rounds suffice.
        for _ in 0..self.events {
            for step in &self.places {
                let Some(so_far) = tokens[step.from] else {
                    continue;
                };
                let reached = so_far + step.tokens;
                if tokens[step.to].is_none_or(|known| reached < known) {
                    tokens[step.to] = Some(reached);
                }
            }
        }
        tokens[place.from].map(|back| back + place.tokens)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Visit {
    New,
    Open,
    Done,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(tokens: &[u64]) -> Graph {
        let mut graph = Graph { events: tokens.len(), places: Vec::new() };
        for (i, tokens) in tokens.iter().enumerate() {
            graph.place(i, (i + 1) % graph.events, *tokens);
        }
        graph
    }

    #[test]
    fn a_ring_lives_on_its_tokens() {
        assert_eq!(ring(&[0, 0, 0]).dead_cycle(), Some(vec![0, 1, 2]));
        let live = ring(&[0, 1, 1]);
        assert_eq!(live.dead_cycle(), None);
        assert!(live.places.iter().all(|place| live.bound(*place) == Some(2)));
    }

    #[test]
    fn a_place_that_nothing_holds_back_has_no_bound() {
        let mut graph = ring(&[1]);
        graph.events = 2;
        graph.place(0, 1, 0);
        assert_eq!(graph.bound(graph.places[1]), None);
    }
}
