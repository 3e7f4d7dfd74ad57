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

/// Steps of a component between two exchanges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stepping {
    /// It has steps of its own, and says how long they may be.
    Own,
    /// It makes the steps of another role, and may bound their length.
    Of(Role),
    /// It knows windows alone.
    Windows,
}

/// What the program must know of a role: one row for each. All that plans, checks and supervises a run
/// asks here, and names no role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoleRules {
    /// Name as manifests and messages write it.
    pub name: &'static str,
    /// Its steps.
    pub stepping: Stepping,
    /// Advice to a user whose steps are too short.
    pub longer_steps: &'static str,
    /// The role beside which a program of this one is tried alone; none if it cannot be.
    pub tried_beside: Option<Role>,
}

impl Role {
    /// Roles of the physics. A run has at most one component of each.
    pub const PHYSICS: [Self; 3] = [Self::Fluid, Self::Grains, Self::Rubber];

    /// Its row.
    pub const fn rules(self) -> RoleRules {
        match self {
            Role::Fluid => RoleRules {
                name: "fluid",
                stepping: Stepping::Own,
                longer_steps: "a larger cell, a longer time_step where it is set",
                tried_beside: Some(Role::Grains),
            },
            Role::Grains => RoleRules {
                name: "grains",
                stepping: Stepping::Own,
                longer_steps: "larger smallest grains, softer contacts (normal_stiffness), a longer time_step where it is set",
                tried_beside: Some(Role::Fluid),
            },
            Role::Rubber => RoleRules {
                name: "rubber",
                stepping: Stepping::Of(Role::Grains),
                longer_steps: "",
                tried_beside: None,
            },
            Role::Observer => RoleRules {
                name: "observer",
                stepping: Stepping::Windows,
                longer_steps: "",
                tried_beside: None,
            },
        }
    }

    /// Name as manifests and messages write it.
    pub const fn name(self) -> &'static str {
        self.rules().name
    }

    /// True if it sets steps of its own.
    pub fn has_steps(self) -> bool {
        self.rules().stepping == Stepping::Own
    }

    /// The role whose steps it makes, if that is another.
    pub fn steps_with(self) -> Option<Role> {
        match self.rules().stepping {
            Stepping::Of(other) => Some(other),
            Stepping::Own | Stepping::Windows => None,
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
