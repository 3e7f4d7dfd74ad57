//! One impact: when two surfaces touch, the impulse between them, the guards against collapse.

pub mod approach;
pub mod collision;
pub mod guards;
pub mod impact_laws;
pub mod triangle_touch;
