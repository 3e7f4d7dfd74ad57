//! Loads of a window as means over its substeps, so that their impulse over the window is that of
//! the substeps.

use tremie_messages::{FacetLoad, Load};

/// Room for the loads of one substep.
#[derive(Clone, Debug, Default)]
pub struct SubstepMeans {
    partial: Vec<Load>,
    partial_facets: Vec<FacetLoad>,
}

impl SubstepMeans {
    /// For a number of facets of deformable surfaces.
    pub fn new(facets: usize) -> Self {
        Self { partial: Vec::new(), partial_facets: vec![FacetLoad::default(); facets] }
    }

    /// Takes the substeps of a window; `loads` and `facets` become the means over all. `step` takes
    /// one, and writes its loads.
    ///
    /// # Errors
    /// That of the first step that fails.
    pub fn advance<E>(
        &mut self,
        substeps: u32,
        loads: &mut [Load],
        facets: &mut [FacetLoad],
        mut step: impl FnMut(&mut [Load], &mut [FacetLoad]) -> Result<(), E>,
    ) -> Result<(), E> {
        step(loads, facets)?;
        if substeps < 2 {
            return Ok(());
        }
        let share = 1.0 / f64::from(substeps);
        self.partial.clear();
        self.partial.extend_from_slice(loads);
        for load in loads.iter_mut() {
            load.force = load.force.map(|f| f * share);
            load.torque = load.torque.map(|t| t * share);
        }
        for load in facets.iter_mut() {
            load.force = load.force.map(|f| f * share);
        }
        for _ in 1..substeps {
            step(&mut self.partial, &mut self.partial_facets)?;
            for (load, part) in facets.iter_mut().zip(&self.partial_facets) {
                join_facet(load, part, share);
            }
            for (load, part) in loads.iter_mut().zip(&self.partial) {
                for axis in 0..3 {
                    load.force[axis] += part.force[axis] * share;
                    load.torque[axis] += part.torque[axis] * share;
                }
            }
        }
        Ok(())
    }
}

/// Adds a share of another load on the same facet; the point is the mean, weighted by the forces.
fn join_facet(load: &mut FacetLoad, other: &FacetLoad, share: f64) {
    let size = |force: [f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
    let (own, more) = (size(load.force), share * size(other.force));
    if own + more > 0.0 {
        for a in 0..3 {
            load.point[a] += more / (own + more) * (other.point[a] - load.point[a]);
        }
    }
    for a in 0..3 {
        load.force[a] += share * other.force[a];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_are_means_over_the_substeps() {
        let mut means = SubstepMeans::new(1);
        let (mut loads, mut facets) = ([Load::default()], [FacetLoad::default()]);
        let mut count = 0.0;
        let step = |loads: &mut [Load], facets: &mut [FacetLoad]| -> Result<(), ()> {
            count += 1.0;
            loads[0].force = [count, 0.0, 0.0];
            loads[0].torque = [0.0, 2.0 * count, 0.0];
            facets[0].force = [0.0, 0.0, 1.0];
            facets[0].point = [count, 0.0, 0.0];
            Ok(())
        };
        means.advance(4, &mut loads, &mut facets, step).unwrap();
        assert_eq!((loads[0].force, loads[0].torque), ([2.5, 0.0, 0.0], [0.0, 5.0, 0.0]));
        assert_eq!(facets[0].force, [0.0, 0.0, 1.0]);
        assert!((facets[0].point[0] - 2.5).abs() < 1e-12);
    }
}
