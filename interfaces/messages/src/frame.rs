//! Frames for observers: sent at the observer's own rate. Physics never waits for them longer than
//! the channel's buffer allows.

use crate::{BodyState, Message, Stamp, SurfaceVertex};

/// A body as an observer sees it. 144 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySample {
    /// Pose and velocity.
    pub state: BodyState,
    /// Radius of a sphere; of a part, that about its reference point that holds it [m].
    pub radius: f64,
    /// Mass [kg].
    pub mass: f64,
    /// Index into the scene's body sets.
    pub set: u32,
    /// One of [`crate::BodyEvent`]'s shapes.
    pub shape: u32,
    /// One of [`crate::BodyEvent`]'s motions.
    pub motion: u32,
    /// Index into the scene's list of parts, for a part; else 0.
    pub part: u32,
}

/// A vertex of a deformable surface as an observer sees it. 56 bytes.
///
/// A frame carries all vertices of the scene's deformable surfaces, numbered through as everywhere.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    /// Position and velocity.
    pub vertex: SurfaceVertex,
    /// Equivalent shear strain √(2/3 e:e), e the deviator of the logarithmic strain: 0 at rest, the
    /// logarithm of the stretch in a uniaxial test without change of volume; not a number where it
    /// is not known [1].
    pub strain: f64,
}

/// A plane cut through a field, sampled on a regular grid.
///
/// Node `(i, j)` of the payload, at index `i + count[0] * j`, lies at `origin + i * step[0] + j *
/// step[1]`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceHeader {
    /// Time and window.
    pub stamp: Stamp,
    /// Position of node (0, 0) [m].
    pub origin: [f64; 3],
    /// Step to the next node along each of the two grid directions [m].
    pub step: [[f64; 3]; 2],
    /// Number of nodes along each of the two grid directions.
    pub count: [u64; 2],
}

/// A field on a regular grid of nodes: a whole lattice, or every so many nodes of a box in it.
///
/// Node `(i, j, k)` of the payload, at index `i + count[0] * (j + count[1] * k)`, lies at
/// `origin + (i * step[0], j * step[1], k * step[2])`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumeHeader {
    /// Time and window.
    pub stamp: Stamp,
    /// Position of node (0, 0, 0) [m].
    pub origin: [f64; 3],
    /// Step to the next node along each axis [m].
    pub step: [f64; 3],
    /// Number of nodes along each axis.
    pub count: [u64; 3],
}

/// A node of a slice or a volume.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceNode {
    /// Fluid velocity; of no meaning where the node is solid, and zero or the solid's there [m/s].
    pub velocity: [f32; 3],
    /// Gauge pressure [Pa]: of a fluid that fills its space without its hydrostatic part.
    pub pressure: f32,
    /// Share of the node's surroundings that the fluid fills, from 0 to 1: at a free surface a
    /// half, in a solid 0.
    pub fill: f32,
    /// 1 where the node lies in a solid, else 0.
    pub solid: u32,
}

impl SliceNode {
    /// True if the node lies in the fluid: in no solid, and below the free surface.
    pub fn is_fluid(&self) -> bool {
        self.solid == 0 && self.fill >= 0.5
    }

    /// True if neither fluid nor solid is there.
    pub fn is_air(&self) -> bool {
        self.solid == 0 && self.fill < 0.5
    }
}

/// A line of the run's log, the text as payload in UTF-8.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogHeader {
    /// Time and window; those of the last report where the orchestrator writes.
    pub stamp: Stamp,
    /// [`LogHeader::INFO`], [`LogHeader::WARNING`] or [`LogHeader::ERROR`].
    pub level: u64,
}

impl LogHeader {
    /// Something that a reader wants to know.
    pub const INFO: u64 = 0;
    /// Something that may spoil a result.
    pub const WARNING: u64 = 1;
    /// Something that ended the run.
    pub const ERROR: u64 = 2;
}

// SAFETY: BodyState (112 bytes, align 8), two words of 8 bytes and four of 4, no padding.
unsafe impl Message for BodySample {
    const TYPE_NAME: &'static str = "tremie.BodySample.2";
}
// SAFETY: SurfaceVertex (48 bytes, align 8) and a word of 8 bytes, no padding.
unsafe impl Message for SurfaceSample {
    const TYPE_NAME: &'static str = "tremie.SurfaceSample.1";
}
// SAFETY: 40 bytes, then eleven words, no padding.
unsafe impl Message for SliceHeader {
    const TYPE_NAME: &'static str = "tremie.SliceHeader.1";
}
// SAFETY: 40 bytes, then nine words, no padding.
unsafe impl Message for VolumeHeader {
    const TYPE_NAME: &'static str = "tremie.VolumeHeader.1";
}
// SAFETY: six words of 4 bytes, no padding.
unsafe impl Message for SliceNode {
    const TYPE_NAME: &'static str = "tremie.SliceNode.2";
}
// SAFETY: 40 bytes and a word, no padding.
unsafe impl Message for LogHeader {
    const TYPE_NAME: &'static str = "tremie.LogHeader.1";
}
