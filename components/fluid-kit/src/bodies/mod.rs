//! The moving bodies of a run as a fluid keeps them: by their ids, between two windows.

pub mod body_registry;
pub mod part_way;
