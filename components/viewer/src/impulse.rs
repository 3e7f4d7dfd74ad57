//! Impulse that the fluid has delivered, against what the grains have received: along the axis that
//! is up. Grains receive a window's loads a window later. So the difference is what is on its way.

use rerun::{Color, RecordingStream, RecordingStreamResult, Scalars, SeriesLines, SeriesPoints};
use std::collections::BTreeMap;
use tremie_messages::start::{FrameContent, FrameStream, Signal};

/// Entities of what was delivered and received, and of what is on its way.
pub const SUMS: &str = "coupling/impulse";
pub const ON_THE_WAY: &str = "coupling/impulse_on_the_way";
/// Names of the signals, without their axis.
const SIDES: [&str; 2] = ["impulse_delivered", "impulse_received"];
/// Windows that wait for the frame of the other side: frames may be lost.
const MOST: usize = 64;

/// Both sides of the exchange.
pub struct ImpulseBalance {
    /// Names of the two signals.
    names: [String; 2],
    /// By window: what was delivered and received [N s].
    waiting: BTreeMap<u64, [Option<f64>; 2]>,
    begun: bool,
}

impl ImpulseBalance {
    /// Along an axis, if streams have both sides.
    pub fn of_streams(frames: &[FrameStream], axis: usize) -> Option<Self> {
        let names = SIDES.map(|side| format!("{side}_{}", ["x", "y", "z"][axis]));
        let has = |name: &String| {
            frames.iter().any(|stream| match &stream.content {
                FrameContent::Signals(signals) => signals.iter().any(|signal| signal.name == *name),
                _ => false,
            })
        };
        names.iter().all(has).then(|| Self { names, waiting: BTreeMap::new(), begun: false })
    }

    /// Takes the signals of a component; draws the window once both sides are there.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        window: u64,
        signals: &[Signal],
        values: &[f64],
    ) -> RecordingStreamResult<()> {
        for (side, name) in self.names.iter().enumerate() {
            let Some(place) = signals.iter().position(|signal| signal.name == *name) else {
                continue;
            };
            self.waiting.entry(window).or_default()[side] = values.get(place).copied();
        }
        let Some([Some(delivered), Some(received)]) = self.waiting.get(&window).copied() else {
            while self.waiting.len() > MOST {
                self.waiting.pop_first();
            }
            return Ok(());
        };
        // Streams come in order: of earlier windows no other side will come.
        self.waiting = self.waiting.split_off(&(window + 1));
        if !std::mem::replace(&mut self.begun, true) {
            log_styles(stream)?;
        }
        stream.log(format!("{SUMS}/delivered"), &Scalars::new([delivered]))?;
        stream.log(format!("{SUMS}/received"), &Scalars::new([received]))?;
        stream.log(ON_THE_WAY, &Scalars::new([delivered - received]))
    }
}

fn log_styles(stream: &RecordingStream) -> RecordingStreamResult<()> {
    let style = |name: &str, [r, g, b]: [u8; 3], width: f32| {
        let style = SeriesLines::new().with_names([name]).with_widths([width]);
        style.with_colors([Color::from_rgb(r, g, b)])
    };
    stream.log_static(format!("{SUMS}/delivered"), &style("delivered", [86, 180, 233], 3.0))?;
    // The two lie on each other: points are seen on a line.
    let received = SeriesPoints::new()
        .with_names(["received"])
        .with_colors([Color::from_rgb(213, 94, 0)])
        .with_marker_sizes([1.5]);
    stream.log_static(format!("{SUMS}/received"), &received)?;
    stream.log_static(ON_THE_WAY, &style("difference", [0, 114, 178], 1.5))
}
