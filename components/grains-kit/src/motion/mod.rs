//! Motions that a scene prescribes.

pub mod prescribed_motion;
