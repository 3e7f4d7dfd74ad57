//! A grain at one moment.

/// A grain at one moment, as a profile sees it. SI units, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainSample {
    /// Id of its body.
    pub id: u64,
    /// Centre, in the domain [m].
    pub position: [f64; 3],
    /// Velocity of the centre [m/s].
    pub velocity: [f64; 3],
    /// Volume [m³].
    pub volume: f64,
    /// Mass [kg]; more than zero.
    pub mass: f64,
    /// Number of its contacts.
    pub contacts: u32,
    /// Virial of its contacts: sum of the products of the vectors from the centre to the contacts
    /// and the forces there on the grain, made symmetric, with the opposite sign, so that
    /// compression counts positive: xx, yy, zz, yz, zx, xy [J].
    pub virial: [f64; 6],
}

impl GrainSample {
    /// A grain of an id of which nothing is known.
    pub fn new(id: u64) -> Self {
        Self {
            id,
            position: [0.0; 3],
            velocity: [0.0; 3],
            volume: 0.0,
            mass: 0.0,
            contacts: 0,
            virial: [0.0; 6],
        }
    }

    /// Adds to the virial a force on the grain [N] at the end of an arm from the centre [m].
    #[inline]
    pub fn push(&mut self, arm: [f64; 3], force: [f64; 3]) {
        add_virial(&mut self.virial, arm, force);
    }
}

/// Adds to a virial a force on a grain [N] at the end of an arm from its centre [m].
#[inline]
pub fn add_virial(virial: &mut [f64; 6], arm: [f64; 3], force: [f64; 3]) {
    for (sum, (a, b)) in virial.iter_mut().zip(PAIRS) {
        *sum -= 0.5 * (arm[a] * force[b] + arm[b] * force[a]);
    }
}

/// Axes of the components of a symmetric tensor: xx, yy, zz, yz, zx, xy.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];
