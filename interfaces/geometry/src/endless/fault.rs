//! Why a part cannot go on through periodic faces.

use crate::Vec3;
use crate::error::six_digits as digits;

/// Why a part cannot go on through periodic faces, or cannot move as it should.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EndlessFault {
    /// Longer than a period, but beyond one face only.
    #[error(
        "the part is {} m long along the periodic {} axis, more than the domain's {} m, but does not reach the {} face: it would come in again where it is already",
        digits(*found), name(*axis), digits(*length), if *below { "upper" } else { "lower" }
    )]
    Longer {
        /// The axis.
        axis: usize,
        /// Its length [m].
        found: f64,
        /// Length of the domain [m].
        length: f64,
        /// True if it reaches the lower face.
        below: bool,
    },
    /// All of its surface lies beyond the faces.
    #[error("the part reaches beyond both periodic faces of {}, and none of its surface lies between them", names(*axes))]
    NoWall {
        /// The axes.
        axes: [bool; 3],
    },
    /// Its cross-sections at the two faces differ.
    #[error(
        "the part reaches from one periodic {0} face to the other, but its cross-sections there differ, by {2} m at {at} on the {1} face: it does not go on as the domain does",
        name(*axis), if *upper { "upper" } else { "lower" }, digits(*off), at = place(*at)
    )]
    Section {
        /// The axis.
        axis: usize,
        /// Distance of the cross-section at the other face [m]; infinite where there is none.
        off: f64,
        /// Place on the outline [m].
        at: Vec3,
        /// On which face.
        upper: bool,
    },
    /// Its cross-section has corners in which more than two walls meet.
    #[error("the part's cross-section at the periodic faces touches itself at {}", place(*at))]
    Touching {
        /// Place [m].
        at: Vec3,
    },
    /// It turns away from the axis along which it is endless.
    #[error("the part goes through both periodic {} faces, but turns about another axis: it would not meet itself at the faces any more", name(*axis))]
    Turns {
        /// The axis.
        axis: usize,
    },
    /// As it turns it is longer than a period.
    #[error(
        "the part turns within {} m, more than the {} m of the periodic {} axis: it would run into itself",
        digits(*found), digits(*length), name(*axis)
    )]
    TurnsIntoItself {
        /// The axis.
        axis: usize,
        /// Diameter about its origin [m].
        found: f64,
        /// Length of the domain [m].
        length: f64,
    },
}

impl EndlessFault {
    /// The remedy.
    pub fn help(&self) -> String {
        match self {
            Self::Longer { axis, .. } => format!(
                "move it so that it reaches beyond both {0} faces, which makes it endless, or make it shorter than the domain",
                name(*axis)
            ),
            Self::NoWall { .. } => "remove the part, or put it where the domain is".into(),
            Self::Section { axis, .. } => format!(
                "give it the same cross-section at both {0} faces (straight along {0}, not turned away from it), or make it shorter than the domain, or {0} a wall",
                name(*axis)
            ),
            Self::Touching { .. } => {
                "unite solids that touch along an edge, or take them apart, as parts of their own"
                    .into()
            }
            Self::Turns { axis } => format!(
                "let it turn about {0} alone, or make it shorter than the domain, or {0} a wall",
                name(*axis)
            ),
            Self::TurnsIntoItself { axis, .. } => format!(
                "make the part smaller or the domain longer along {0}, or let it turn about {0} alone",
                name(*axis)
            ),
        }
    }
}

fn name(axis: usize) -> &'static str {
    ["x", "y", "z"][axis]
}

fn names(axes: [bool; 3]) -> String {
    let named: Vec<&str> = (0..3).filter(|&a| axes[a]).map(name).collect();
    named.join(" and ")
}

fn place(at: Vec3) -> String {
    let [x, y, z] = at.map(digits).into();
    format!("({x}, {y}, {z}) m")
}
