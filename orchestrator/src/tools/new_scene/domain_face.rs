//! Faces of the domain.

use clap::ValueEnum;

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DomainFace {
    /// Lower face along x.
    XMin,
    /// Upper face along x.
    XMax,
    /// Lower face along y.
    YMin,
    /// Upper face along y.
    YMax,
    /// Lower face along z.
    ZMin,
    /// Upper face along z.
    ZMax,
}

impl DomainFace {
    /// Its axis: 0, 1, 2 for x, y, z.
    pub fn axis(self) -> usize {
        match self {
            Self::XMin | Self::XMax => 0,
            Self::YMin | Self::YMax => 1,
            Self::ZMin | Self::ZMax => 2,
        }
    }

    /// True for a face at the upper end of its axis.
    pub fn is_upper(self) -> bool {
        matches!(self, Self::XMax | Self::YMax | Self::ZMax)
    }

    /// The face of an axis.
    pub fn of(axis: usize, is_upper: bool) -> Self {
        let [lower, upper] =
            [[Self::XMin, Self::XMax], [Self::YMin, Self::YMax], [Self::ZMin, Self::ZMax]]
                [axis.min(2)];
        if is_upper { upper } else { lower }
    }

    /// The face opposite.
    pub fn opposite(self) -> Self {
        Self::of(self.axis(), !self.is_upper())
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::XMin => "x-min",
            Self::XMax => "x-max",
            Self::YMin => "y-min",
            Self::YMax => "y-max",
            Self::ZMin => "z-min",
            Self::ZMax => "z-max",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_have_opposites() {
        assert_eq!(DomainFace::XMin.opposite(), DomainFace::XMax);
        assert_eq!(DomainFace::of(2, true), DomainFace::ZMax);
        assert_eq!(DomainFace::YMax.opposite().name(), "y-min");
    }
}
