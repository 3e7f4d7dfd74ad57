//! Scales of axes: a prefix of the unit that suits the numbers, as mm for a lift.

/// Units that take prefixes; all others get a power of ten.
const PREFIXED: [&str; 8] = ["m", "s", "m/s", "Pa", "N", "J", "N m", "W"];

const PREFIXES: [(i32, &str); 7] =
    [(-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G")];

/// Divisor of numbers that are drawn, and the unit of the quotients.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The divisor.
    pub by: f64,
    /// The unit, as an axis shows it.
    pub unit: String,
}

impl Scale {
    /// For numbers up to `largest` in magnitude, in an SI unit.
    pub fn of(largest: f64, unit: &str) -> Self {
        if !(largest.is_finite() && largest > 0.0) {
            return Self { by: 1.0, unit: shown(unit) };
        }
        // 0.2 m are as good as 200 mm.
        let thousands = (libm::log10(largest * 5.0) / 3.0).floor() as i32 * 3;
        if PREFIXED.contains(&unit) {
            let (power, prefix) = PREFIXES
                .into_iter()
                .min_by_key(|(power, _)| (power - thousands).abs())
                .unwrap_or((0, ""));
            return Self { by: libm::exp10(f64::from(power)), unit: format!("{prefix}{unit}") };
        }
        match thousands {
            0 | 3 => Self { by: 1.0, unit: shown(unit) },
            power if unit == "1" => {
                Self { by: libm::exp10(f64::from(power)), unit: format!("1e{power}") }
            }
            power => Self { by: libm::exp10(f64::from(power)), unit: format!("1e{power} {unit}") },
        }
    }
}

/// A number without unit has none to show.
fn shown(unit: &str) -> String {
    if unit == "1" { "-".into() } else { unit.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_suit_the_numbers() {
        let scale = |largest, unit| {
            let Scale { by, unit } = Scale::of(largest, unit);
            (by, unit)
        };
        assert_eq!(scale(1.4e-3, "m"), (1e-3, "mm".into()));
        assert_eq!(scale(0.25, "m"), (1.0, "m".into()));
        assert_eq!(scale(4.6e5, "Pa"), (1e6, "MPa".into()));
        assert_eq!(scale(1e5, "Pa"), (1e3, "kPa".into()));
        assert_eq!(scale(35e-3, "s"), (1e-3, "ms".into()));
        assert_eq!(scale(4.2e-4, "m3/s"), (1e-3, "1e-3 m3/s".into()));
        assert_eq!(scale(0.4, "1"), (1.0, "-".into()));
        assert_eq!(scale(2.0e5, "1"), (1e6, "1e6".into()));
        assert_eq!(scale(0.0, "m"), (1.0, "m".into()));
        assert_eq!(scale(f64::NAN, "1"), (1.0, "-".into()));
    }
}
