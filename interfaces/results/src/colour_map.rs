//! A coloured map: values on a grid of cells over two axes, with a bar of colours.

use crate::charts::Area;
use crate::ticks::tick_numbers;
use plotters::prelude::*;
use std::ops::Range;

/// Most cells drawn along an axis: about two pixels each.
const CELLS: usize = 160;
/// Width of the bar of colours with its numbers [pixels].
const BAR: i32 = 90;
/// Steps of the bar.
const STEPS: usize = 64;

/// Values on a grid of cells over two axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColourMap {
    /// Above it.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Extent along each axis.
    pub extent: [[f64; 2]; 2],
    /// Number of cells along each axis.
    pub count: [usize; 2],
    /// Value of cell `(i, j)` at `i * count[1] + j`; cells without a number stay white.
    pub values: Vec<f64>,
}

impl ColourMap {
    /// Draws it.
    ///
    /// # Errors
    /// A sentence, if it cannot be drawn or written.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        let wrong = |error: DrawingAreaErrorKind<std::io::Error>| error.to_string();
        area.fill(&WHITE).map_err(wrong)?;
        let width = area.dim_in_pixel().0 as i32;
        let (map, bar) = area.split_horizontally(width - BAR);
        let small = self.merged();
        let values = small.range();
        let [x, y] = small.extent.map(|[low, high]| low..high);
        let ticks = [tick_numbers(&x), tick_numbers(&y)];
        let mut chart = ChartBuilder::on(&map)
            .caption(&self.title, ("sans-serif", 18))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(70)
            .build_cartesian_2d(x, y)
            .map_err(wrong)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&ticks[0])
            .y_label_formatter(&ticks[1])
            .draw()
            .map_err(wrong)?;
        let cells = small.cells().map(|(corners, value)| {
            let colour = ViridisRGB.get_color_normalized(value, values.start, values.end);
            Rectangle::new(corners, colour.filled())
        });
        chart.draw_series(cells).map_err(wrong)?;
        draw_bar(&bar, values)
    }

    /// Corners and values of the cells that have a number.
    fn cells(&self) -> impl Iterator<Item = ([(f64, f64); 2], f64)> + '_ {
        let edge = |axis: usize, k: usize| {
            let [low, high] = self.extent[axis];
            low + (high - low) * k as f64 / self.count[axis] as f64
        };
        let cell = move |(k, &value): (usize, &f64)| {
            let (i, j) = (k / self.count[1], k % self.count[1]);
            let corners = [(edge(0, i), edge(1, j)), (edge(0, i + 1), edge(1, j + 1))];
            (corners, value)
        };
        self.values.iter().enumerate().map(cell).filter(|(_, value)| value.is_finite())
    }

    /// Least and greatest value.
    fn range(&self) -> Range<f64> {
        let finite = self.values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = finite
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match high - low {
            span if span > 0.0 => low..high,
            _ if low.is_finite() => low..low + 0.5 * low.abs() + 1e-30,
            _ => 0.0..1.0,
        }
    }

    /// The same with no more cells than can be seen: means of those that have a number.
    fn merged(&self) -> Self {
        let stride = self.count.map(|count| count.div_ceil(CELLS).max(1));
        if stride == [1, 1] {
            return self.clone();
        }
        let count = [0, 1].map(|a| self.count[a].div_ceil(stride[a]));
        let mut sums = vec![(0.0, 0.0); count[0] * count[1]];
        for (k, value) in self.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            let (i, j) = (k / self.count[1], k % self.count[1]);
            let sum = &mut sums[i / stride[0] * count[1] + j / stride[1]];
            *sum = (sum.0 + value, sum.1 + 1.0);
        }
        // The last cells may reach beyond the map by a part of a stride.
        let extent = [0, 1].map(|a| {
            let [low, high] = self.extent[a];
            let whole = (count[a] * stride[a]) as f64 / self.count[a] as f64;
            [low, low + (high - low) * whole]
        });
        Self {
            values: sums.iter().map(|(sum, n)| sum / n).collect(),
            count,
            extent,
            ..self.clone()
        }
    }
}

/// The colours from the least to the greatest value.
fn draw_bar(area: &Area<'_>, values: Range<f64>) -> Result<(), String> {
    let wrong = |error: DrawingAreaErrorKind<std::io::Error>| error.to_string();
    let mut chart = ChartBuilder::on(area)
        .margin_top(38)
        .margin_bottom(52)
        .margin_right(8)
        .y_label_area_size(58)
        .build_cartesian_2d(0.0..1.0, values.clone())
        .map_err(wrong)?;
    let mut mesh = chart.configure_mesh();
    let ticks = tick_numbers(&values);
    mesh.disable_mesh().disable_x_axis().y_labels(5).y_label_formatter(&ticks);
    // Else as small as the bar is narrow.
    mesh.y_label_style(("sans-serif", 10));
    mesh.draw().map_err(wrong)?;
    let step = (values.end - values.start) / STEPS as f64;
    let strips = (0..STEPS).map(|k| {
        let low = values.start + step * k as f64;
        let colour = ViridisRGB.get_color_normalized(low, values.start, values.end);
        Rectangle::new([(0.0, low), (1.0, low + step)], colour.filled())
    });
    chart.draw_series(strips).map_err(wrong)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_cells_are_merged_to_means() {
        let count = [2 * CELLS + 1, 1];
        let mut values: Vec<f64> = (0..count[0]).map(|k| k as f64).collect();
        values[0] = f64::NAN;
        let map =
            ColourMap { count, values, extent: [[0.0, 1.0], [0.0, 1.0]], ..ColourMap::default() };
        let small = map.merged();
        assert_eq!(small.count, [count[0].div_ceil(3), 1]);
        assert_eq!(small.values[0], 1.5, "of 1 and 2");
        assert_eq!(small.values[1], 4.0);
        assert!(small.extent[0][1] >= 1.0 && small.extent[0][1] < 1.02);
        assert_eq!(map.range(), 1.0..320.0);
    }

    #[test]
    fn a_map_is_drawn() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.svg");
        let map = ColourMap {
            title: "fraction".into(),
            count: [2, 2],
            values: vec![0.0, 0.25, f64::NAN, 0.5],
            extent: [[0.0, 1.0], [2.0, 3.0]],
            ..ColourMap::default()
        };
        let panel = crate::SheetPanel::Map(map);
        crate::draw_panels(&[panel], "title", &path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let yellow = ViridisRGB.get_color_normalized(0.5, 0.0, 0.5);
        let code = format!("#{:02X}{:02X}{:02X}", yellow.0, yellow.1, yellow.2);
        assert!(text.contains("fraction") && text.contains(&code), "{code}");
    }
}
