//! Watchdogs: quantities of a run that stop it when they pass a limit, and places where they do.

use serde::{Deserialize, Serialize};

/// A quantity that tells whether the physics of a run goes wrong. The manifest's table `watch` has
/// a key for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WatchedQuantity {
    /// Largest Mach number.
    Mach,
    /// Largest relative deviation of a density.
    Density,
    /// Deepest overlap over the smaller radius.
    Overlap,
    /// Way of the fastest thing in a step, over the smallest thing that it must not skip.
    Speed,
    /// Share of the mass or volume that the method lost or made.
    Mass,
    /// Share of the energy that the method made, where nothing else gives or takes any.
    Energy,
    /// Compression of a seal over the largest that its table reaches.
    Compression,
}

impl WatchedQuantity {
    /// All of them, in the order of the manifest's reference.
    pub const ALL: [Self; 7] = [
        Self::Mach,
        Self::Density,
        Self::Overlap,
        Self::Speed,
        Self::Mass,
        Self::Energy,
        Self::Compression,
    ];

    /// Its key in the manifest's table `watch`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mach => "mach",
            Self::Density => "density",
            Self::Overlap => "overlap",
            Self::Speed => "speed",
            Self::Mass => "mass",
            Self::Energy => "energy",
            Self::Compression => "compression",
        }
    }
}

impl std::fmt::Display for WatchedQuantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A signal of a component that the run watches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WatchedSignal {
    /// Its name, one of the component's own.
    pub signal: String,
    /// Above this value a checkpoint is made.
    pub from: f64,
    /// Above this value the run stops.
    pub limit: f64,
}

impl WatchedSignal {
    /// The signal of a limit under which a run stops: a checkpoint is made from the value on above
    /// which results are doubtful, or from half of the limit where that is no less.
    pub fn under(signal: &str, doubtful: f64, limit: f64) -> Self {
        let from = if doubtful < limit { doubtful } else { 0.5 * limit };
        Self { signal: signal.into(), from, limit }
    }
}

/// Place at which a watched quantity is greatest, as far as its component knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// Position [m]: the centre of a cell or of a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Ids of the bodies that it concerns.
    #[serde(skip_serializing_if = "no_bodies")]
    pub bodies: [Option<u64>; 2],
}

fn no_bodies(bodies: &[Option<u64>; 2]) -> bool {
    *bodies == [None; 2]
}

impl Place {
    /// Values of a place in a report: position, and ids of two bodies; NaN where there is none.
    /// (An id is exact up to 2^53.)
    pub const VALUES: usize = 5;

    /// A position.
    pub fn at(position: [f64; 3]) -> Self {
        Self { position: Some(position), bodies: [None; 2] }
    }

    /// A body, with its position.
    pub fn of_body(id: u64, position: [f64; 3]) -> Self {
        Self { position: Some(position), bodies: [Some(id), None] }
    }

    /// The same with another body.
    pub fn with(self, other: Option<u64>) -> Self {
        Self { bodies: [self.bodies[0], other], ..self }
    }

    /// True if nothing is known.
    pub fn is_unknown(&self) -> bool {
        *self == Self::default()
    }

    /// The place as values of a report.
    pub fn values(&self) -> [f64; Self::VALUES] {
        let [x, y, z] = self.position.unwrap_or([f64::NAN; 3]);
        let [a, b] = self.bodies.map(|id| id.map_or(f64::NAN, |id| id as f64));
        [x, y, z, a, b]
    }

    /// The place that values of a report say; unknown where they are not [`Place::VALUES`].
    pub fn of_values(values: &[f64]) -> Self {
        let &[x, y, z, a, b] = values else { return Self::default() };
        let position = [x, y, z];
        let id = |value: f64| (value >= 0.0).then_some(value as u64);
        Self {
            position: position.iter().all(|x| x.is_finite()).then_some(position),
            bodies: [id(a), id(b)],
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let short = crate::finding::short;
        match self.bodies {
            [None, _] => {}
            [Some(id), None] => write!(f, " of body {id}")?,
            [Some(id), Some(other)] => write!(f, " of body {id} with body {other}")?,
        }
        match self.position {
            None => Ok(()),
            Some([x, y, z]) => write!(f, " at ({}, {}, {}) m", short(x), short(y), short(z)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_comes_back_from_its_values() {
        let position = [1e-3, -2.0, 0.0];
        let places = [
            Place::default(),
            Place::at(position),
            Place::of_body(0, position),
            Place::of_body(7, position).with(Some((1 << 53) - 1)),
        ];
        for place in places {
            assert_eq!(Place::of_values(&place.values()), place);
        }
        assert!(Place::of_values(&[]).is_unknown());
    }

    #[test]
    fn a_place_is_said_in_words() {
        let body = Place::of_body(7, [1e-3, 0.0, -2.0]);
        assert_eq!(body.to_string(), " of body 7 at (0.001, 0, -2) m");
        assert_eq!(body.with(Some(9)).to_string(), " of body 7 with body 9 at (0.001, 0, -2) m");
        assert_eq!(Place::default().to_string(), "");
    }

    #[test]
    fn a_checkpoint_is_made_before_the_limit() {
        assert_eq!(WatchedSignal::under("x", 0.1, 0.5).from, 0.1);
        assert_eq!(WatchedSignal::under("x", 0.1, 0.08).from, 0.04);
    }

    #[test]
    fn names_are_those_of_documents() {
        for quantity in WatchedQuantity::ALL {
            assert_eq!(serde_json::to_value(quantity).unwrap(), quantity.name());
        }
    }
}
