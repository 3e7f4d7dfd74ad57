//! Numbers at the ticks of an axis.

use std::ops::Range;

/// Least size of a number that is not the margin which is given to a range of zeros.
const NOTHING: f64 = 1e-29;

/// Numbers at the ticks of an axis with such values, without the digits that rounding left. Where the greatest
/// has seven digits or is below 1e-4, they are in powers of ten.
pub fn tick_numbers(values: &Range<f64>) -> impl Fn(&f64) -> String + use<> {
    let greatest = values.start.abs().max(values.end.abs());
    let is_plain = (1e-4..1e6).contains(&greatest);
    // Ticks of a narrow range differ in their last digits.
    let digits = (greatest / (values.end - values.start)).log10().clamp(0.0, 12.0) as usize + 3;
    move |value| {
        if value.abs() <= (1e-9 * greatest).max(NOTHING) {
            // Also what a sum of steps is where it meets 0.
            "0".into()
        } else if is_plain {
            plain(*value)
        } else {
            power_of_ten(*value, digits)
        }
    }
}

/// The number at a tick of a logarithmic axis.
pub fn decade(value: &f64) -> String {
    if (0.01..1e5).contains(value) { plain(*value) } else { format!("{value:.0e}") }
}

fn plain(value: f64) -> String {
    // 0 without a sign.
    format!("{}", (value * 1e9).round() / 1e9 + 0.0)
}

fn power_of_ten(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    let Some((digits, power)) = text.split_once('e') else { return text };
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{digits}e{power}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short_at_any_size() {
        for (end, value, text) in [
            (1.0, 0.1 + 0.2, "0.3"),
            (1.0, 1e-17, "0"),
            (1.0, -0.0, "0"),
            (999_999.0, -250_000.0, "-250000"),
            (1.2e6, 1.1e6, "1.1e6"),
            (1.2e6, -5e5, "-5e5"),
            (3e-10, 0.1e-9 + 0.2e-9, "3e-10"),
            (3e-10, 1e-26, "0"),
            (0.002, 0.0015, "0.0015"),
            (0.0, 0.0, "0"),
        ] {
            assert_eq!(tick_numbers(&(-end..end))(&value), text, "{value} of {end}");
        }
        assert_eq!(tick_numbers(&(-1e-30..1e-30))(&5e-31), "0", "of values that are all 0");
        let narrow = tick_numbers(&(1_234_565.0..1_234_571.0));
        assert_eq!([1_234_566.0, 1_234_568.0].map(|v| narrow(&v)), ["1.234566e6", "1.234568e6"]);
        assert_eq!(
            [0.1, 1e-3, 1e4, 1e5].map(|value| decade(&value)),
            ["0.1", "1e-3", "10000", "1e5"]
        );
    }
}
