//! How fast bodies in contact can oscillate and decay, and which time step follows them.

use crate::law::Law;

/// Upper estimates of the fastest oscillation and the fastest decay of a body in contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stability {
    /// Square of the angular frequency [1/s²].
    frequency_squared: f64,
    /// Rate of decay [1/s].
    decay: f64,
}

impl Stability {
    fn of(law: &Law, inverse_mass: f64, contacts: f64) -> Self {
        let root_mass = (1.0 / inverse_mass).sqrt();
        let (n, t) = (law.gamma_n(root_mass), law.gamma_t(root_mass));
        let (k_t, t) = if law.mu > 0.0 { (law.k_t, t) } else { (0.0, 0.0) };
        Self {
            frequency_squared: inverse_mass * strongest(law.k_n, k_t, contacts),
            decay: inverse_mass * strongest(n, t, contacts),
        }
    }

    /// Adds the contacts of a body under another law.
    pub fn add(&mut self, law: &Law, inverse_mass: f64, contacts: f64) {
        let more = Self::of(law, inverse_mass, contacts);
        self.frequency_squared += more.frequency_squared;
        self.decay += more.decay;
    }

    /// Takes the worse of this and other contacts.
    pub fn at_least(&mut self, law: &Law, inverse_mass: f64, contacts: f64) {
        let other = Self::of(law, inverse_mass, contacts);
        self.frequency_squared = self.frequency_squared.max(other.frequency_squared);
        self.decay = self.decay.max(other.decay);
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
fn strongest(n: f64, t: f64, contacts: f64) -> f64 {
    let single = n.max(3.5 * t);
    single.max(contacts * (n + 2.0 * t) / 3.0).max(contacts * 5.0 / 3.0 * t)
}
