//! Frequency and decay of the oscillations of bodies in contact, and the time step that resolves
//! them.

use crate::contact::contact_law::Law;
use crate::contact::springs::Reduced;

/// Upper estimates of the fastest oscillation and the fastest decay of a body in contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stability {
    /// Square of the angular frequency [1/s²].
    frequency_squared: f64,
    /// Rate of decay [1/s].
    decay: f64,
}

impl Stability {
    /// A body in `contacts` contacts at an overlap, where `inverse_mass` is the sum of both
    /// bodies'.
    pub fn of(law: &Law, pair: Reduced, inverse_mass: f64, overlap: f64, contacts: f64) -> Self {
        let at = law.at(overlap, overlap, pair);
        let across = if law.mu > 0.0 { 1.0 } else { 0.0 };
        // A spring of one step is a dashpot `k_t dt`, stable up to half the step of the spring.
        let of_one_step = 4.0 * law.spring.law().one_step_stiffness(pair);
        let (k_t, gamma_t) = ((at.k_t + of_one_step) * across, at.gamma_t * across);
        let rolls = law.mu_rolling > 0.0;
        Self {
            frequency_squared: inverse_mass
                * strongest(law.normal_slope(overlap, pair), k_t, contacts, rolls),
            decay: inverse_mass * strongest(at.gamma_n, gamma_t, contacts, rolls),
        }
    }

    /// A mass [kg] on a spring [N/m] and a dashpot [kg/s].
    pub fn of_mass(stiffness: f64, gamma: f64, mass: f64) -> Self {
        Self { frequency_squared: stiffness / mass, decay: gamma / mass }
    }

    /// A body between `contacts` normal dashpots that slow it at a rate each [1/s].
    pub fn of_dashpot(rate: f64, contacts: f64) -> Self {
        Self { frequency_squared: 0.0, decay: rate * (contacts / 3.0).max(1.0) }
    }

    /// The contacts of a body under two laws.
    pub fn and(self, more: Self) -> Self {
        Self {
            frequency_squared: self.frequency_squared + more.frequency_squared,
            decay: self.decay + more.decay,
        }
    }

    /// The worse of two.
    pub fn or(self, other: Self) -> Self {
        Self {
            frequency_squared: self.frequency_squared.max(other.frequency_squared),
            decay: self.decay.max(other.decay),
        }
    }

    /// Verlet needs `dt < 2/w`; with the dashpot at predicted velocities `dt < 1/decay`: the
    /// amplification of a pure decay z = decay dt leaves the unit circle through -1 at z = 1.
    pub fn largest_step(self) -> f64 {
        (2.0 / self.frequency_squared.sqrt()).min(1.0 / self.decay)
    }
}

/// Largest eigenvalue of the sum of `contacts` springs (or dashpots) `n` along and `t` across
/// normals that are spread evenly, at least that of one contact: translation `z (n + 2 t)/3`,
/// rotation `z 5/2 2/3 t`; one contact `n`, and `7/2 t` across with the rotation of a sphere.
/// Rolling springs `t R*^2` add as much again to a rotation.
fn strongest(n: f64, t: f64, contacts: f64, rolls: bool) -> f64 {
    let rolling = if rolls { 2.5 * t } else { 0.0 };
    let single = n.max(3.5 * t + rolling);
    let turning = 5.0 / 3.0 * t + 2.0 / 3.0 * rolling;
    single.max(contacts * (n + 2.0 * t) / 3.0).max(contacts * turning)
}
