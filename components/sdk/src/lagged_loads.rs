//! Loads that answer an older list of bodies than the present one.
//!
//! In a parallel schedule, and in the first window after one, the fluid of a window does not know yet
//! who came or went at the end of it. Grains take its loads for those who are still there. Who came
//! since feels none in its first window, as if it had come a window later to the fluid: an error of
//! the order of the window, like the lag itself.

use tremie_messages::Load;

/// The bodies that loads answer, and loads brought to the bodies that there are.
#[derive(Debug, Default)]
pub struct Answers {
    /// Ids of the bodies that the next loads answer, ascending.
    pub ids: Vec<u64>,
    fitted: Vec<Load>,
}

impl Answers {
    /// Notes that the loads after the next ones answer these bodies.
    pub fn note(&mut self, ids: impl Iterator<Item = u64>) {
        self.ids.clear();
        self.ids.extend(ids);
    }

    /// The loads on the bodies `ids`, ascending as those of `loads`.
    pub fn fit<'a>(
        &'a mut self,
        loads: &'a [Load],
        ids: impl ExactSizeIterator<Item = u64> + Clone,
    ) -> &'a [Load] {
        if loads.len() == ids.len() && loads.iter().map(|load| load.id).eq(ids.clone()) {
            return loads;
        }
        self.fitted.clear();
        let mut rest = loads.iter().peekable();
        for id in ids {
            while rest.next_if(|load| load.id < id).is_some() {}
            let load = rest.next_if(|load| load.id == id).copied();
            self.fitted.push(load.unwrap_or(Load { id, ..Load::default() }));
        }
        &self.fitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(id: u64) -> Load {
        Load { id, force: [id as f64, 0.0, 0.0], torque: [0.0, 1.0, 0.0] }
    }

    #[test]
    fn loads_find_their_bodies_when_some_came_and_went() {
        let mut answers = Answers::default();
        let loads: Vec<_> = [1, 3, 4, 8].map(load).to_vec();
        let none = |id| Load { id, ..Load::default() };
        let mut fit = |ids: &[u64]| answers.fit(&loads, ids.iter().copied()).to_vec();
        assert_eq!(fit(&[1, 3, 4, 8]), loads);
        assert_eq!(fit(&[3, 8, 9, 10]), [load(3), load(8), none(9), none(10)]);
        assert_eq!(fit(&[0, 1, 2, 4]), [none(0), load(1), none(2), load(4)]);
        assert_eq!(fit(&[]), []);
        let mut nothing = Answers::default();
        assert_eq!(nothing.fit(&[], [5].into_iter()), [none(5)]);
    }
}
