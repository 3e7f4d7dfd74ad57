//! Values whose numbers can be looked over for those that are none.

use tremie_messages::{BodyState, FacetLoad, Load, Message, PortState, SurfaceVertex};

/// A value that says whether all its numbers are finite.
pub trait Finite: Message {
    /// True if every number is finite.
    fn is_finite(&self) -> bool;
    /// Spoils the value, for tests of the guards.
    fn spoil(&mut self);
    /// Whose value it is, as `body 7`; `place` is its index in its message.
    fn owner(&self, place: usize) -> String;
    /// Index of a value that is not finite.
    fn first_wrong(values: &[Self]) -> Option<usize> {
        values.iter().position(|value| !value.is_finite())
    }
}

/// A value that belongs to a body, or to a surface that stands for one.
pub trait OfBody: Finite {
    /// Id of the body.
    fn id(&self) -> u64;
}

impl Finite for BodyState {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.velocity[0] = f64::NAN;
    }
    fn owner(&self, _: usize) -> String {
        format!("body {}", self.id)
    }
}

impl OfBody for BodyState {
    fn id(&self) -> u64 {
        self.id
    }
}

impl Finite for Load {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.force[0] = f64::NAN;
    }
    fn owner(&self, _: usize) -> String {
        format!("body {}", self.id)
    }
}

impl OfBody for Load {
    fn id(&self) -> u64 {
        self.id
    }
}

impl Finite for FacetLoad {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.force[0] = f64::NAN;
    }
    fn owner(&self, _: usize) -> String {
        format!("facet {}", self.facet)
    }
}

impl Finite for PortState {
    fn is_finite(&self) -> bool {
        self.velocity.is_finite()
    }
    fn spoil(&mut self) {
        self.velocity = f64::NAN;
    }
    fn owner(&self, _: usize) -> String {
        format!("face {self}")
    }
}

impl Finite for SurfaceVertex {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.position[0] = f64::NAN;
    }
    fn owner(&self, place: usize) -> String {
        format!("vertex {place}")
    }
    /// All vertices of a seal are looked over in each of its trials: without a branch for each
    /// number.
    fn first_wrong(values: &[Self]) -> Option<usize> {
        const EXPONENT: u64 = 0x7ff << 52;
        // An exponent of ones, plus one, carries into the sign.
        let carry = |x: &f64| (x.to_bits() & EXPONENT).wrapping_add(1 << 52);
        let mut carries = 0;
        for SurfaceVertex { position: [a, b, c], velocity: [d, e, f] } in values {
            carries |= carry(a) | carry(b) | carry(c) | carry(d) | carry(e) | carry(f);
        }
        if carries >> 63 == 0 { None } else { values.iter().position(|v| !v.is_finite()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_vertex_that_is_no_point_is_found() {
        let mut vertices =
            vec![SurfaceVertex { position: [1.0, -2e300, 5e-324], ..Default::default() }; 9];
        assert_eq!(SurfaceVertex::first_wrong(&vertices), None);
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for field in 0..6 {
                let mut spoilt = vertices.clone();
                let SurfaceVertex { position, velocity } = &mut spoilt[4];
                *if field < 3 { &mut position[field] } else { &mut velocity[field - 3] } = wrong;
                assert_eq!(SurfaceVertex::first_wrong(&spoilt), Some(4));
            }
        }
        vertices[8].spoil();
        assert_eq!(SurfaceVertex::first_wrong(&vertices), Some(8));
    }
}
