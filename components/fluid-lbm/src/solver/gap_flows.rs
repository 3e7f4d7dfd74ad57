//! What the links of parts exchanged with declared gaps in a step, of all ranks.

use crate::bodies::body::Body;
use crate::boundary::post_collision::LinkItem;
use crate::lattice::exact_sum::ExactSum;
use crate::ranks::rank_sums::Ranks;

/// Of each part: the volume by which it receded from each gap, and for each intake the weight of the links that
/// gave to it, and the mass.
#[derive(Clone, Debug, Default)]
pub struct GapFlows {
    /// Gaps, and intakes.
    counts: [usize; 2],
    sums: Vec<ExactSum>,
}

impl GapFlows {
    /// Of so many gaps and intakes.
    pub fn of([gaps, intakes]: [usize; 2]) -> Self {
        Self { counts: [gaps, intakes], sums: Vec::new() }
    }

    /// Numbers of a part.
    fn length(&self) -> usize {
        let [gaps, intakes] = self.counts;
        gaps + 2 * intakes
    }

    /// Adds up what the items of parts found, of the bodies in their order.
    pub fn collect(&mut self, living: &[Body], links: &[LinkItem], ranks: &mut Ranks) {
        if self.length() == 0 {
            return;
        }
        let parts = living.iter().filter(|body| body.is_part());
        self.sums.clear();
        self.sums.resize(parts.clone().count() * self.length(), ExactSum::default());
        let (length, gaps) = (self.length(), self.counts[0]);
        for (part, sums) in parts.zip(self.sums.chunks_exact_mut(length)) {
            let (drawn, given) = sums.split_at_mut(gaps);
            for item in &links[part.items.clone()] {
                for (sum, item) in drawn.iter_mut().zip(&item.gaps.drawn) {
                    item.add_to(sum);
                }
                for (sums, item) in given.chunks_exact_mut(2).zip(&item.gaps.given) {
                    item.weight.add_to(&mut sums[0]);
                    item.mass.add_to(&mut sums[1]);
                }
            }
        }
        ranks.add_up(&mut self.sums);
    }

    /// The sums of the parts, in their order.
    fn parts(&self) -> impl Iterator<Item = &[ExactSum]> {
        self.sums.chunks_exact(self.length().max(1))
    }

    /// Volume by which a part, by its number among the parts, receded from each gap.
    pub fn drawn(&self, part: usize) -> impl Iterator<Item = f64> {
        let sums = self.parts().nth(part).unwrap_or_default();
        sums.iter().take(self.counts[0]).map(ExactSum::value)
    }

    /// Mass that the links of a part gave to intakes.
    pub fn given_by(&self, part: usize) -> f64 {
        let sums = self.parts().nth(part).unwrap_or_default();
        sums.iter().skip(self.counts[0]).skip(1).step_by(2).map(ExactSum::value).sum()
    }

    /// For each intake the weight of the links of all parts that gave to it, and the mass.
    pub fn given(&self) -> impl Iterator<Item = [f64; 2]> {
        let [gaps, intakes] = self.counts;
        let sum_of = move |place: usize| {
            let mut sum = ExactSum::default();
            self.parts().for_each(|sums| sum += sums[place]);
            sum.value()
        };
        (0..intakes).map(move |k| [0, 1].map(|which| sum_of(gaps + 2 * k + which)))
    }
}
