//! Scripts: the ordered operations of a component in a window, and the edges that they use.
//!
//! The orchestrator derives the scripts of all components from the plan, once; each component
//! then follows its own, and every message carries the stamp that the script foretells.

use crate::{BodyEvent, BodyState, FacetLoad, Load, Message, PortState, SurfaceVertex};
use serde::{Deserialize, Serialize};

/// Order in which fluid and grains advance.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Schedule {
    /// One after the other (Gauss-Seidel), the order of Mutabaruka and Kamrin (2018): grains
    /// advance under the loads of the window before, then the fluid with the bodies at the window's
    /// end.
    #[default]
    Serial,
    /// At the same time (Jacobi): the fluid takes the bodies at the window's start, the grains the
    /// loads of the window before. One window more of lag.
    Parallel,
}

/// Content of an edge between two components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// [`crate::BodyEvent`]s of a window, even none.
    Events,
    /// [`crate::BodyState`]s at a window's end.
    State,
    /// [`crate::Load`]s found in a window.
    Load,
    /// [`crate::PortState`]s at a window's end: of the faces on which inlets of grains sit.
    Ports,
    /// [`crate::SurfaceVertex`]es of the deformable surfaces at a window's end.
    Surface,
    /// [`crate::FacetLoad`]s of a fluid, found in a window.
    SurfaceLoad,
    /// Inside a window: [`crate::BodyState`]s of the parts that carry surfaces, at a substep's end;
    /// `id` is the surface's number in the scene.
    Carrier,
    /// Inside a window: [`crate::SurfaceVertex`]es of a trial, or of the accepted surfaces.
    Trial,
    /// Inside a window: [`crate::FacetLoad`]s of contacts on a trial.
    Contact,
    /// Inside a window: [`crate::Load`]s that the accepted surfaces pass on to their carriers,
    /// contacts left out; `id` is the surface's number in the scene.
    Resultant,
}

/// Most trials of a substep: a rubber that wants more does not converge.
pub const MOST_TRIALS: u32 = 10_000;

impl Content {
    /// Name in services and messages.
    pub fn name(self) -> &'static str {
        match self {
            Content::Events => "events",
            Content::State => "state",
            Content::Load => "load",
            Content::Ports => "ports",
            Content::Surface => "surface",
            Content::SurfaceLoad => "surface_load",
            Content::Carrier => "carrier",
            Content::Trial => "trial",
            Content::Contact => "contact",
            Content::Resultant => "resultant",
        }
    }
}

impl Content {
    /// Name of the type of its values, and the size of one in memory [bytes].
    pub fn value_type(self) -> (&'static str, usize) {
        fn of<T: Message>() -> (&'static str, usize) {
            (T::TYPE_NAME, size_of::<T>())
        }
        match self {
            Content::Events => of::<BodyEvent>(),
            Content::State | Content::Carrier => of::<BodyState>(),
            Content::Load | Content::Resultant => of::<Load>(),
            Content::Ports => of::<PortState>(),
            Content::Surface | Content::Trial => of::<SurfaceVertex>(),
            Content::SurfaceLoad | Content::Contact => of::<FacetLoad>(),
        }
    }

    /// All contents, in the order in which a window of a serial schedule has them: what stands
    /// earlier may be the cause of what stands later.
    pub const ALL: [Content; 10] = [
        Content::Events,
        Content::Carrier,
        Content::Trial,
        Content::Contact,
        Content::Resultant,
        Content::State,
        Content::Surface,
        Content::Ports,
        Content::Load,
        Content::SurfaceLoad,
    ];

    /// The content of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|content| content.name() == name)
    }

    /// True if it travels inside a window, between grains and rubber, as part of their advance; no
    /// operation of a script names its edge.
    pub fn is_inside_window(self) -> bool {
        matches!(self, Content::Carrier | Content::Trial | Content::Contact | Content::Resultant)
    }
}

/// A directed channel between two components, with one sender and one receiver.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// Sending component.
    pub from: String,
    /// Receiving component.
    pub to: String,
    /// Content of its messages.
    pub content: Content,
    /// Name of the shared-memory service.
    pub service: String,
    /// Most values in one message.
    pub capacity: u64,
    /// Most messages under way.
    pub depth: u64,
    /// Substeps that the sender makes in a window; its stamps carry this number.
    pub sender_substeps: u32,
    /// Number of event lists by which the content lags behind its own window (1 for loads of a
    /// parallel schedule).
    pub events_lag: u64,
}

impl Edge {
    /// `grains -> fluid, state`: how messages call this edge.
    pub fn label(&self) -> String {
        format!("{} -> {}, {}", self.from, self.to, self.content.name())
    }
}

/// One operation of a script. Edges are indices into the component's list of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Op {
    /// Take the message of an edge for the window that is `lag` before the present one.
    Receive {
        /// Index of the edge.
        edge: usize,
        /// Windows before the present one.
        lag: u64,
    },
    /// Advance through the window (in the start exchange: only look at what is there).
    Advance,
    /// Send the present window's message on an edge.
    Send {
        /// Index of the edge.
        edge: usize,
    },
}

/// Operations of a component: once in the start exchange or where a run goes on, then in every
/// window.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Script {
    /// Start exchange (window 0).
    pub start: Vec<Op>,
    /// Every window from 1 on.
    pub window: Vec<Op>,
    /// In place of the start exchange, where a run goes on from a checkpoint: sends again, of the
    /// checkpoint's window, what receivers take in the next.
    #[serde(default)]
    pub resume: Vec<Op>,
}
