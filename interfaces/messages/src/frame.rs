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

/// Loads on a body as an observer sees them. 88 bytes.
///
/// A frame carries one for each living body, in the order of the ids, as it is at a window's end.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadSample {
    /// Id of the body.
    pub id: u64,
    /// Position of its reference point [m].
    pub position: [f64; 3],
    /// Force of the fluid under which it went through the window, buoyancy included [N]; not a
    /// number where none is known.
    pub fluid: [f64; 3],
    /// Force of contacts at the window's end [N]; not a number where grains do not tell it.
    pub contact: [f64; 3],
    /// One of [`crate::BodyEvent`]'s shapes.
    pub shape: u32,
    /// Index into the scene's body sets; 0 for a part.
    pub set: u32,
}

/// Wall time that components have taken so far: time and window of the last one that all have
/// completed. The payload has a [`ComponentTiming`] for each component of
/// [`crate::start::RunCoupling`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimingHeader {
    /// Time and window.
    pub stamp: Stamp,
    /// Wall time since the run's first window [ns].
    pub elapsed: u64,
}

/// Wall time that a component has taken so far, summed over its windows. 40 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComponentTiming {
    /// Windows that it has completed.
    pub windows: u64,
    /// Time in its solver [ns].
    pub compute: u64,
    /// Time of its waits for other components or for leave to go on [ns].
    pub wait: u64,
    /// Time in sending and bookkeeping [ns].
    pub exchange: u64,
    /// Work that it has done, in the unit of its description.
    pub work: u64,
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
    /// Density of the fluid [kg/m³].
    pub density: f32,
    /// Level of refinement of the fluid's grid there, 0 for the coarsest and where it has one.
    pub level: u32,
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

/// A table of a profile of grains ([`crate::scene::GrainProfile`]): its time and its samples. The
/// payload has a [`ProfileBin`] for each bin.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfileHeader {
    /// Time and window of its end.
    pub stamp: Stamp,
    /// Simulated time at which its average begins [s]; its first sample comes an interval later.
    pub begin: f64,
    /// Simulated time of its last sample [s].
    pub end: f64,
    /// Number of samples.
    pub samples: u64,
}

/// Means over the grains whose centres lie in a bin of a profile, and over the samples of a table.
/// 176 bytes.
///
/// Grains that forces move count; those at rest or of a given motion are walls. Stresses are
/// positive under compression, and have the components xx, yy, zz, yz, zx, xy.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfileBin {
    /// Number of centres, mean over the samples [1].
    pub grains: f64,
    /// Volume of the grains over that of the bin [1].
    pub solid_fraction: f64,
    /// Mean velocity, by mass [m/s]; not a number in a bin without grains.
    pub velocity: [f64; 3],
    /// Standard deviation of each component of the velocities about this mean, over the grains and
    /// over time, by mass [m/s]; not a number in a bin without grains.
    pub fluctuation: [f64; 3],
    /// Granular temperature: mean of the squares of the fluctuations, in a plane scene of the two
    /// in the plane [m²/s²]; not a number in a bin without grains.
    pub temperature: f64,
    /// Coordination number: mean number of contacts of a grain, those with walls and parts
    /// included [1]; not a number in a bin without grains.
    pub coordination: f64,
    /// Contact stress: sum of the products of the vectors from centres to contacts and the forces
    /// on the grains, made symmetric, over the bin's volume [Pa].
    pub contact_stress: [f64; 6],
    /// Kinetic stress: density of the grains in the bin times the covariance of their velocities
    /// [Pa].
    pub kinetic_stress: [f64; 6],
}

impl ProfileBin {
    /// Names and SI units of its values, in the order of [`ProfileBin::values`].
    pub const COLUMNS: [(&'static str, &'static str); 22] = [
        ("grains", "1"),
        ("solid_fraction", "1"),
        ("velocity_x", "m/s"),
        ("velocity_y", "m/s"),
        ("velocity_z", "m/s"),
        ("fluctuation_x", "m/s"),
        ("fluctuation_y", "m/s"),
        ("fluctuation_z", "m/s"),
        ("temperature", "m2/s2"),
        ("coordination", "1"),
        ("contact_stress_xx", "Pa"),
        ("contact_stress_yy", "Pa"),
        ("contact_stress_zz", "Pa"),
        ("contact_stress_yz", "Pa"),
        ("contact_stress_zx", "Pa"),
        ("contact_stress_xy", "Pa"),
        ("kinetic_stress_xx", "Pa"),
        ("kinetic_stress_yy", "Pa"),
        ("kinetic_stress_zz", "Pa"),
        ("kinetic_stress_yz", "Pa"),
        ("kinetic_stress_zx", "Pa"),
        ("kinetic_stress_xy", "Pa"),
    ];

    /// Its values, in the order of [`ProfileBin::COLUMNS`].
    pub fn values(&self) -> [f64; 22] {
        let mut values = [0.0; 22];
        let groups: [&[f64]; 7] = [
            &[self.grains, self.solid_fraction],
            &self.velocity,
            &self.fluctuation,
            &[self.temperature],
            &[self.coordination],
            &self.contact_stress,
            &self.kinetic_stress,
        ];
        for (to, from) in values.iter_mut().zip(groups.into_iter().flatten()) {
            *to = *from;
        }
        values
    }
}

/// A piece of the messages that a component sent in a window: see
/// [`crate::start::FrameContent::Messages`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessagesHeader {
    /// Time and window of their end.
    pub stamp: Stamp,
    /// 1 if another piece of the same window follows, else 0. Heads and values may be cut anywhere.
    pub more: u64,
}

/// What stands before the copy of a message. 56 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageHead {
    /// Stamp of the message.
    pub stamp: Stamp,
    /// Index into the list of channels of its stream.
    pub channel: u64,
    /// Length of its values [bytes].
    pub bytes: u64,
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
// SAFETY: ten words of 8 bytes and two of 4, no padding.
unsafe impl Message for LoadSample {
    const TYPE_NAME: &'static str = "tremie.LoadSample.1";
}
// SAFETY: 40 bytes and a word, no padding.
unsafe impl Message for TimingHeader {
    const TYPE_NAME: &'static str = "tremie.TimingHeader.1";
}
// SAFETY: five words, no padding.
unsafe impl Message for ComponentTiming {
    const TYPE_NAME: &'static str = "tremie.ComponentTiming.1";
}
// SAFETY: 40 bytes, then eleven words, no padding.
unsafe impl Message for SliceHeader {
    const TYPE_NAME: &'static str = "tremie.SliceHeader.1";
}
// SAFETY: 40 bytes, then nine words, no padding.
unsafe impl Message for VolumeHeader {
    const TYPE_NAME: &'static str = "tremie.VolumeHeader.1";
}
// SAFETY: eight words of 4 bytes, no padding.
unsafe impl Message for SliceNode {
    const TYPE_NAME: &'static str = "tremie.SliceNode.3";
}
// SAFETY: 40 bytes, then three words, no padding.
unsafe impl Message for ProfileHeader {
    const TYPE_NAME: &'static str = "tremie.ProfileHeader.1";
}
// SAFETY: 22 words, no padding.
unsafe impl Message for ProfileBin {
    const TYPE_NAME: &'static str = "tremie.ProfileBin.1";
}
// SAFETY: 40 bytes and a word, no padding.
unsafe impl Message for MessagesHeader {
    const TYPE_NAME: &'static str = "tremie.MessagesHeader.1";
}
// SAFETY: 40 bytes and two words, no padding.
unsafe impl Message for MessageHead {
    const TYPE_NAME: &'static str = "tremie.MessageHead.1";
}
// SAFETY: 40 bytes and a word, no padding.
unsafe impl Message for LogHeader {
    const TYPE_NAME: &'static str = "tremie.LogHeader.1";
}
