//! Streams of frames, and the part of a lattice that one carries.

use super::{Signal, VolumeSpec, VolumeWish};
use crate::Role;
use crate::schedule::{Content, Edge, Schedule};
use serde::{Deserialize, Serialize};

/// Content of a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameContent {
    /// [`crate::frame::BodySample`]s of all bodies.
    Bodies,
    /// [`crate::frame::SurfaceSample`]s of all vertices of the scene's deformable surfaces.
    Surfaces,
    /// [`crate::frame::LoadSample`]s of all bodies.
    Loads,
    /// A cut of that name: [`crate::frame::SliceNode`]s.
    Slice(String),
    /// Nodes of a lattice: [`crate::frame::SliceNode`]s.
    Volume(VolumeGrid),
    /// A table of the scene's profile of that name: [`crate::frame::ProfileBin`]s. It comes when the
    /// table has ended, whatever [`FrameStream::every`] says; one of the start exchange has no samples.
    Profile(String),
    /// The component's signals, in the order of its description, with that order given here.
    Signals(Vec<Signal>),
    /// Hashes of the messages that the component sends, on these channels. The frame holds a row for
    /// each window since the frame before: the window, then a hash for each channel, as 64-bit
    /// words. A row of window 0 is of the start exchange.
    ///
    /// The hash of a window begins as 0. Each message of the channel, in the order of sending, makes
    /// it `XXH64(values, XXH64(stamp, hash))`: the second argument is the seed, the stamp is as it
    /// lies in memory with 0 for the run's id, and so are the values. The hash of a channel without
    /// a message in the window is 0.
    Hashes(Vec<SentChannel>),
    /// Copies of all messages that the component sends, on these channels: of each a
    /// [`crate::frame::MessageHead`] and its values, one after the other in the order of sending, as
    /// bytes. The messages of a window may take several frames.
    Messages(Vec<SentChannel>),
    /// Wall time that components have taken: [`crate::frame::ComponentTiming`]s in the order given
    /// here, with the schedule (sent by the orchestrator, whatever [`FrameStream::lossless`] says only
    /// as far as there is room, and not at the same windows in each run).
    Timings(RunCoupling),
    /// Lines of the log (sent by the orchestrator).
    Log,
}

/// The components of a run's physics, and what passes between them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunCoupling {
    /// Order in which fluid and grains advance.
    pub schedule: Schedule,
    /// The components, in the order of the plan.
    pub components: Vec<CoupledComponent>,
    /// What passes between them.
    pub exchanges: Vec<CoupledExchange>,
}

/// A component of a run's physics.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoupledComponent {
    /// Its name.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Substeps that it makes in a window.
    pub substeps: u32,
}

/// What a component sends another in each window.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoupledExchange {
    /// Index of the sending component.
    pub from: usize,
    /// Index of the receiving component.
    pub to: usize,
    /// Content of the messages.
    pub content: Content,
    /// Windows between the advance that a message is of and the advance that uses it first; 0 where
    /// the receiver uses it in the same window.
    pub delay: u64,
}

impl FrameContent {
    /// True if the orchestrator sends it.
    pub fn is_of_orchestrator(&self) -> bool {
        matches!(self, Self::Timings(_) | Self::Log)
    }
}

/// A channel from a component, as observers know it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SentChannel {
    /// Content of its messages.
    pub content: Content,
    /// The receiving component.
    pub to: String,
}

impl SentChannel {
    /// Channels of a component, in the order of the edges.
    pub fn of_sender(component: &str, edges: &[Edge]) -> Vec<Self> {
        let own = edges.iter().filter(|edge| edge.from == component);
        own.map(|edge| Self { content: edge.content, to: edge.to.clone() }).collect()
    }
}

impl FrameContent {
    /// Most windows between two frames of hashes: few frames, and few rows that a killed run loses.
    pub const MOST_HASHED_WINDOWS: u64 = 256;
}

/// Nodes of a lattice, the same number apart along each axis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VolumeGrid {
    /// Name of the volume in its component's description.
    pub name: String,
    /// Node of the lattice where the grid begins.
    pub first: [u64; 3],
    /// Every so many nodes of the lattice, along each axis.
    pub stride: u64,
    /// Number of nodes along each axis.
    pub count: [u64; 3],
}

impl VolumeGrid {
    /// The part of `volume` that an observer wants; `None` if no node of it is.
    ///
    /// Nodes that a stride leaves out are left out evenly at both ends.
    pub fn new(volume: &VolumeSpec, wish: &VolumeWish) -> Option<Self> {
        let ranges: Vec<[u64; 2]> =
            (0..3).map(|axis| wanted(volume, wish, axis)).collect::<Option<_>>()?;
        let grid = |stride: u64| {
            let count = std::array::from_fn(|a| (ranges[a][1] - ranges[a][0]).div_ceil(stride));
            let left_out = |a: usize| ranges[a][1] - ranges[a][0] - 1 - (count[a] - 1) * stride;
            let first = std::array::from_fn(|a| ranges[a][0] + left_out(a) / 2);
            Self { name: volume.name.clone(), first, stride, count }
        };
        let most = wish.most_nodes.unwrap_or(u64::MAX).max(1);
        let longest = ranges.iter().map(|[begin, end]| end - begin).max()?;
        // A stride of the longest edge leaves one node.
        (wish.stride.max(1)..=longest.max(wish.stride)).map(grid).find(|grid| grid.nodes() <= most)
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u64 {
        self.count.iter().product()
    }

    /// Node of the lattice that node `at` of the grid is.
    pub fn lattice_node(&self, at: [u64; 3]) -> [u64; 3] {
        std::array::from_fn(|a| self.first[a] + self.stride * at[a])
    }
}

/// Nodes along an axis that lie in the wanted region, as `[begin, end]`; `None` if there are none.
fn wanted(volume: &VolumeSpec, wish: &VolumeWish, axis: usize) -> Option<[u64; 2]> {
    let count = volume.count[axis];
    let (begin, end) = match wish.region {
        None => (0, count),
        Some([min, max]) => {
            let nodes = |x: f64| (x - volume.origin[axis]) / volume.step[axis];
            // Half a millionth of a step of slack: a region may end on a node.
            let begin = (nodes(min[axis]) - 5e-7).ceil().max(0.0) as u64;
            let end = (nodes(max[axis]) + 5e-7).floor() + 1.0;
            (begin, (end.max(0.0) as u64).min(count))
        }
    };
    (begin < end).then_some([begin, end])
}

/// A stream of frames from a component to an observer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameStream {
    /// Sending component.
    pub from: String,
    /// Receiving observer.
    pub to: String,
    /// Content of a frame.
    pub content: FrameContent,
    /// A frame every so many windows, one of the start exchange, and one of the run's last window.
    pub every: u64,
    /// `true`: the sender waits (boundedly) for room; `false`: the oldest frame gives way.
    pub lossless: bool,
    /// Name of the shared-memory service.
    pub service: String,
    /// Most values in a frame.
    pub capacity: u64,
    /// Most frames under way.
    pub depth: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(count: [u64; 3]) -> VolumeSpec {
        VolumeSpec { name: "lattice".into(), origin: [0.5; 3], step: [1.0; 3], count }
    }

    #[test]
    fn a_whole_lattice_is_itself() {
        let grid = VolumeGrid::new(&lattice([4, 5, 6]), &VolumeWish::default()).unwrap();
        assert_eq!((grid.first, grid.stride, grid.count), ([0; 3], 1, [4, 5, 6]));
    }

    #[test]
    fn the_stride_grows_until_nodes_fit_and_leaves_out_evenly() {
        let wish = VolumeWish { most_nodes: Some(100_000), ..Default::default() };
        let grid = VolumeGrid::new(&lattice([110, 110, 176]), &wish).unwrap();
        assert_eq!((grid.stride, grid.count), (3, [37, 37, 59]));
        assert_eq!(grid.first, [0, 0, 0]);
        assert_eq!(grid.lattice_node([36, 36, 58]), [108, 108, 174]);
        let wish = VolumeWish { stride: 4, ..Default::default() };
        let grid = VolumeGrid::new(&lattice([8, 7, 1]), &wish).unwrap();
        assert_eq!((grid.first, grid.count), ([1, 1, 0], [2, 2, 1]));
        let one = VolumeWish { most_nodes: Some(1), ..Default::default() };
        assert_eq!(VolumeGrid::new(&lattice([8, 7, 1]), &one).unwrap().nodes(), 1);
    }

    #[test]
    fn a_region_takes_the_nodes_in_it() {
        let region = |min, max| VolumeWish { region: Some([min, max]), ..Default::default() };
        let grid = VolumeGrid::new(&lattice([10; 3]), &region([2.5, -9.0, 3.6], [4.5, 99.0, 4.4]));
        assert!(grid.is_none(), "no node lies between 3.6 and 4.4 along z");
        let wish = region([2.5, -9.0, 3.0], [4.5, 99.0, 4.9]);
        let grid = VolumeGrid::new(&lattice([10; 3]), &wish).unwrap();
        assert_eq!((grid.first, grid.count), ([2, 0, 3], [3, 10, 2]));
    }
}
