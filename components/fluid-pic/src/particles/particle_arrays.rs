//! Particles in memory: an array for each component.

use tremie_state::{StateError, StateExchange};

/// How velocities travel between particles and grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// Particles gain the grid's change of velocity (FLIP, Brackbill & Ruppel, *J. Comput. Phys.*
    /// 65 (1986) 314), but for a share, which they take from the grid anew (PIC, Harlow 1964). A
    /// share of 0 is pure FLIP, of 1 pure PIC.
    Blend {
        /// Share of PIC in a step.
        pic: f64,
    },
    /// Particles take the grid's velocity and its gradients (APIC, Jiang et al., *ACM Trans.
    /// Graph.* 34 (2015) 51).
    Affine,
}

/// Particles of one mass.
#[derive(Clone, Debug)]
pub struct ParticleArrays<const D: usize> {
    /// Positions [m], component by component.
    pub position: [Vec<f64>; D],
    /// Velocities [m/s].
    pub velocity: [Vec<f64>; D],
    /// Gradients of each component of the velocity along each axis [1/s]; empty without APIC.
    pub gradient: [[Vec<f64>; D]; D],
    /// Mass of a particle [kg], in two dimensions [kg/m].
    pub mass: f64,
}

impl<const D: usize> ParticleArrays<D> {
    /// No particles yet.
    pub fn new(mass: f64) -> Self {
        let none = || std::array::from_fn(|_| Vec::new());
        Self { position: none(), velocity: none(), gradient: std::array::from_fn(|_| none()), mass }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position[0].len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of a particle [m].
    #[inline]
    pub fn at(&self, particle: usize) -> [f64; D] {
        std::array::from_fn(|a| self.position[a][particle])
    }

    /// Adds a particle; where there are gradients, its own is zero.
    pub fn push(&mut self, position: [f64; D], velocity: [f64; D]) {
        for a in 0..D {
            self.position[a].push(position[a]);
            self.velocity[a].push(velocity[a]);
        }
        let gradients = self.gradient.iter_mut().flatten();
        gradients.filter(|gradient| !gradient.is_empty()).for_each(|gradient| gradient.push(0.0));
    }

    /// Takes from the velocity of a particle what goes into a wall of a normal and velocity.
    pub fn stop_into(&mut self, particle: usize, normal: [f64; D], wall: [f64; D]) {
        let into: f64 = (0..D)
            .map(|a| (self.velocity[a][particle] - wall[a]) * normal[a])
            .sum::<f64>()
            .min(0.0);
        for a in 0..D {
            self.velocity[a][particle] -= into * normal[a];
        }
    }

    /// Keeps the particles whose position `is_kept`, in their order.
    pub fn retain(&mut self, mut is_kept: impl FnMut([f64; D]) -> bool) {
        let mut kept = 0;
        for particle in 0..self.len() {
            if is_kept(self.at(particle)) {
                let arrays = self.position.iter_mut().chain(&mut self.velocity);
                let arrays = arrays.chain(self.gradient.iter_mut().flatten());
                for array in arrays.filter(|array| !array.is_empty()) {
                    array[kept] = array[particle];
                }
                kept += 1;
            }
        }
        let arrays = self.position.iter_mut().chain(&mut self.velocity);
        let arrays = arrays.chain(self.gradient.iter_mut().flatten());
        arrays.for_each(|array| array.truncate(kept));
    }

    /// Keeps the particles, or puts them back.
    ///
    /// # Errors
    /// Arrays of different lengths.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        for a in 0..D {
            state.list(&format!("position{a}"), &mut self.position[a])?;
            state.list(&format!("velocity{a}"), &mut self.velocity[a])?;
            for b in 0..D {
                state.list(&format!("gradient{a}{b}"), &mut self.gradient[a][b])?;
            }
        }
        let count = self.len();
        let mut vectors = self.position.iter().chain(&self.velocity);
        let gradients = || self.gradient.iter().flatten();
        if vectors.any(|along| along.len() != count)
            || !(gradients().all(Vec::is_empty) || gradients().all(|along| along.len() == count))
        {
            return state.unfit("the state has particles without all of their numbers");
        }
        Ok(())
    }

    /// Momentum of all particles [kg m/s].
    pub fn momentum(&self) -> [f64; D] {
        std::array::from_fn(|a| self.mass * self.velocity[a].iter().sum::<f64>())
    }
}
