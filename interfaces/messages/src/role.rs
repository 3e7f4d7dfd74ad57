//! Roles: a component's place in the physics of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Role of a component. Fluid, grains and rubber take part in the physics; observers watch.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Takes poses of bodies, gives loads on them.
    Fluid,
    /// Takes loads on bodies, gives their poses and the events of their lives.
    Grains,
    /// Takes loads on deformable surfaces, gives their shapes and what they pass on to their
    /// carriers.
    Rubber,
    /// Watches; physics never waits for it longer than its bounded buffer allows.
    Observer,
}

impl Role {
    /// Name as manifests and messages write it.
    pub fn name(self) -> &'static str {
        match self {
            Role::Fluid => "fluid",
            Role::Grains => "grains",
            Role::Rubber => "rubber",
            Role::Observer => "observer",
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
