//! Quantities as text with a unit that suits them.

use super::file_unit::three_digits;

/// A text as TOML has it.
pub fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A unit: the least number in SI units that is written in it, what one of it is, its name.
type Unit = (f64, f64, &'static str);

/// Units of length. One for a wide range: origin, size and cell are compared by eye.
const LENGTHS: [Unit; 3] = [(10.0, 1.0, "m"), (1e-4, 1e-3, "mm"), (0.0, 1e-6, "um")];
/// Units of speed.
const SPEEDS: [Unit; 3] = [(0.1, 1.0, "m/s"), (1e-4, 1e-3, "mm/s"), (0.0, 1e-6, "um/s")];
/// Units of time.
const TIMES: [Unit; 3] = [(1.0, 1.0, "s"), (1e-3, 1e-3, "ms"), (0.0, 1e-6, "us")];

/// A number in a unit that suits it, without the digits that rounding adds.
fn written(value: f64, units: &[Unit; 3]) -> String {
    let fits = |(least, ..): &&Unit| value.abs() >= 0.9999 * least;
    let (_, scale, unit) = units.iter().find(fits).unwrap_or(&units[2]);
    let rounded = (value / scale * 1e7).round() / 1e7;
    // No minus before a zero.
    format!("{} {unit}", rounded + 0.0)
}

/// A length.
pub fn length(metres: f64) -> String {
    written(metres, &LENGTHS)
}

/// Three lengths, as a list of TOML.
pub fn lengths(metres: [f64; 3]) -> String {
    let unit =
        |x: f64| if x == 0.0 { "\"0 mm\"".to_string() } else { format!("\"{}\"", length(x)) };
    format!("[{}]", metres.map(unit).join(", "))
}

/// A speed.
pub fn speed(value: f64) -> String {
    match value {
        0.0 => "0 m/s".into(),
        _ => written(value, &SPEEDS),
    }
}

/// A duration, with three digits.
pub fn time(seconds: f64) -> String {
    written(three_digits(seconds), &TIMES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_units_that_suit_them() {
        assert_eq!(length(0.1 * 3.0 * 1e-3), "0.3 mm");
        assert_eq!(length(25e-6), "25 um");
        assert_eq!(length(-12.0), "-12 m");
        assert_eq!(lengths([0.0, -6.5e-3, 1.0]), "[\"0 mm\", \"-6.5 mm\", \"1000 mm\"]");
        assert_eq!((speed(0.0), speed(-6.25e-3)), ("0 m/s".into(), "-6.25 mm/s".into()));
        assert_eq!((time(6.4321), time(0.02)), ("6.43 s".into(), "20 ms".into()));
        assert_eq!(quoted("a \"b\".stl"), "'a \"b\".stl'");
    }
}
