//! Colour scales and their numbers, drawn as pictures: Rerun has none of its own.

use crate::scale::{Map, Scale};
use crate::stage::number;
use rerun::components::Radius;
use rerun::{Color, ColorModel, Image, Points2D, RecordingStream, RecordingStreamResult};
use std::borrow::Cow;

/// Width of the picture; its height is [`HEIGHT`].
pub const WIDTH: u32 = 256;
/// Height of the bar.
pub const HEIGHT: u32 = 8;
/// Readable on the light and on the dark ground that labels have by the user's theme.
pub const READABLE: Color = Color(rerun::Rgba32::from_rgb(70, 125, 165));
/// Numbers along the bar, ends included.
const MARKS: u32 = 5;

/// A legend: its entity, and the unit of its numbers.
#[derive(Clone, Debug)]
pub struct Legend {
    /// Entity under which bar and numbers are.
    pub path: Cow<'static, str>,
    unit: &'static str,
}

/// That of speed.
pub const SPEED: Legend = Legend { path: Cow::Borrowed("legend/speed"), unit: " m/s" };
/// That of equivalent shear strain.
pub const STRAIN: Legend = Legend { path: Cow::Borrowed("legend/strain"), unit: "" };
/// That of the solid fraction on sheets of profiles.
pub const SOLIDS: Legend = Legend { path: Cow::Borrowed("legend/solid_fraction"), unit: "" };

impl Legend {
    /// At an entity of its own, with the unit that follows its numbers.
    pub fn new(path: String, unit: &'static str) -> Self {
        Self { path: path.into(), unit }
    }

    /// Draws the bar, once.
    pub fn log_bar(&self, stream: &RecordingStream, map: Map) -> RecordingStreamResult<()> {
        let row = (0..WIDTH).flat_map(|x| map.colour(f64::from(x) / f64::from(WIDTH - 1)));
        let bytes: Vec<u8> = row.collect::<Vec<_>>().repeat(HEIGHT as usize);
        let (size, kind) = ([WIDTH, HEIGHT], rerun::ChannelDatatype::U8);
        let image = Image::from_color_model_and_bytes(bytes, size, ColorModel::RGB, kind);
        stream.log_static(format!("{}/bar", self.path), &image)
    }

    /// Writes the numbers of the scale as it is now.
    pub fn log_numbers(
        &self,
        stream: &RecordingStream,
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let at = |k: u32| f64::from(k) / f64::from(MARKS - 1);
        let value = |k: u32| scale.min() + (scale.max() - scale.min()) * at(k);
        let text = |k: u32| match k {
            0 if scale.min() < 0.0 => format!("≤ {}{}", number(value(0)), self.unit),
            0 => format!("0{}", self.unit),
            k if k == MARKS - 1 => format!("≥ {}{}", number(scale.max()), self.unit),
            k => number(value(k)),
        };
        stream.log(
            format!("{}/numbers", self.path),
            &Points2D::new((0..MARKS).map(|k| [at(k) as f32 * WIDTH as f32, HEIGHT as f32 + 1.0]))
                .with_labels((0..MARKS).map(text))
                .with_show_labels(true)
                .with_radii([Radius::new_ui_points(1.0)])
                .with_colors([READABLE]),
        )
    }
}
