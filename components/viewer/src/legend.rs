//! The colour scale and its numbers, drawn as a picture: Rerun has none of its own.

use crate::scale::{SpeedScale, viridis};
use crate::stage::number;
use rerun::components::Radius;
use rerun::{Color, ColorModel, Image, Points2D, RecordingStream, RecordingStreamResult};

/// Width of the picture; its height is [`HEIGHT`].
pub const WIDTH: u32 = 256;
/// Height of the bar.
pub const HEIGHT: u32 = 8;
/// Readable on the light and on the dark ground that labels have by the user's theme.
const READABLE: Color = Color(rerun::Rgba32::from_rgb(70, 125, 165));
/// Numbers along the bar, ends included.
const MARKS: u32 = 5;

/// Draws the bar, once.
pub fn log_bar(stream: &RecordingStream) -> RecordingStreamResult<()> {
    let row = (0..WIDTH).flat_map(|x| viridis(f64::from(x) / f64::from(WIDTH - 1)));
    let bytes: Vec<u8> = row.collect::<Vec<_>>().repeat(HEIGHT as usize);
    stream.log_static(
        "legend/bar",
        &Image::from_color_model_and_bytes(
            bytes,
            [WIDTH, HEIGHT],
            ColorModel::RGB,
            rerun::ChannelDatatype::U8,
        ),
    )
}

/// Writes the numbers of the scale as it is now.
pub fn log_numbers(stream: &RecordingStream, scale: &SpeedScale) -> RecordingStreamResult<()> {
    let at = |k: u32| f64::from(k) / f64::from(MARKS - 1);
    let text = |k: u32| match k {
        0 => "0 m/s".to_string(),
        k if k == MARKS - 1 => format!("≥ {} m/s", number(scale.max())),
        k => number(scale.max() * at(k)),
    };
    stream.log(
        "legend/numbers",
        &Points2D::new((0..MARKS).map(|k| [at(k) as f32 * WIDTH as f32, HEIGHT as f32 + 1.0]))
            .with_labels((0..MARKS).map(text))
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(1.0)])
            .with_colors([READABLE]),
    )
}
