//! Physical quantities as a user writes them: a number and a unit, `"0.3 mm"`.
//!
//! Each type holds the value in SI units and reads a string through the `uom` crate. Units may be
//! written in ASCII (`kg/m3`, `m/s2`, `um`, `Pa s`); a bare number is refused, because it does not
//! say what it means.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::time::Duration;
use uom::si::f64 as si;

/// Unit spellings of `uom`, from spellings that a keyboard types.
fn to_uom_spelling(unit: &str) -> String {
    let unit = unit.trim().replace(['*', '·'], " ");
    let unit = unit.split_whitespace().collect::<Vec<_>>().join(" · ");
    let unit = unit.replace("^2", "²").replace("^3", "³").replace('μ', "µ");
    let mut out = String::with_capacity(unit.len() + 4);
    let mut previous = ' ';
    for c in unit.chars() {
        match c {
            '2' if previous.is_alphabetic() => out.push('²'),
            '3' if previous.is_alphabetic() => out.push('³'),
            _ => out.push(c),
        }
        previous = c;
    }
    if out == "deg" {
        return "°".into();
    }
    match out.strip_prefix('u') {
        // A leading `u` stands for micro, as in `um` and `us`.
        Some(rest) if !rest.is_empty() => format!("µ{rest}"),
        _ => out,
    }
}

/// Error: a string is not the quantity that was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found}, expected {kind} with a unit, as \"{example}\"")]
pub struct NotAQuantity {
    /// Text found.
    pub found: String,
    /// Kind of quantity expected.
    pub kind: &'static str,
    /// Example of a valid text.
    pub example: &'static str,
}

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident, $uom:ident, $kind:literal, $example:literal, $si:literal;)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl std::str::FromStr for $name {
            type Err = NotAQuantity;

            fn from_str(text: &str) -> Result<Self, NotAQuantity> {
                let wrong = || NotAQuantity {
                    found: format!("\"{text}\""),
                    kind: $kind,
                    example: $example,
                };
                let text = text.trim();
                let (number, unit) = text.split_once(char::is_whitespace).ok_or_else(wrong)?;
                let spelled = format!("{number} {}", to_uom_spelling(unit));
                // `uom` stores the value in SI base units, whatever unit was read.
                let value = spelled.parse::<si::$uom>().map_err(|_| wrong())?.value;
                if value.is_finite() { Ok(Self(value)) } else { Err(wrong()) }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!("{} ", $si), self.0)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(QuantityVisitor {
                    kind: $kind,
                    example: $example,
                    parse: |text| text.parse(),
                })
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({
                    "type": "string",
                    "description": concat!($kind, " with a unit"),
                    "examples": [$example],
                })
            }
        }
    )+

        /// Names of all kinds of quantities, as [`read`] takes them.
        pub fn kinds() -> impl Iterator<Item = String> {
            [$(stringify!($name)),+].into_iter().map(kind_of_type)
        }

        /// Reads a quantity of a kind whose name is known only at run time, as `length` or `angular
        /// velocity`, in SI units; `None` if there is no such kind.
        ///
        /// # Errors
        /// As those of the type of that kind.
        pub fn read(kind: &str, text: &str) -> Option<Result<f64, NotAQuantity>> {
            $(if kind_of_type(stringify!($name)) == kind {
                return Some(text.parse().map(|$name(value)| value));
            })+
            None
        }
    };
}

/// Name of a kind, from that of its type: `AngularVelocity` is an `angular velocity`.
fn kind_of_type(name: &str) -> String {
    let mut kind = String::with_capacity(name.len() + 1);
    for letter in name.chars() {
        if letter.is_uppercase() && !kind.is_empty() {
            kind.push(' ');
        }
        kind.extend(letter.to_lowercase());
    }
    kind
}

quantities! {
    /// A length [m].
    Length, Length, "a length", "0.3 mm", "m";
    /// An area [m²].
    Area, Area, "an area", "70.9 mm2", "m2";
    /// A volume [m³].
    Volume, Volume, "a volume", "4 L", "m3";
    /// A duration [s].
    Time, Time, "a time", "20 ms", "s";
    /// A speed or a component of a velocity [m/s].
    Velocity, Velocity, "a velocity", "0.1 m/s", "m/s";
    /// An angular velocity [rad/s].
    AngularVelocity, AngularVelocity, "an angular velocity", "2 rad/s", "rad/s";
    /// An acceleration [m/s²].
    Acceleration, Acceleration, "an acceleration", "9.81 m/s2", "m/s2";
    /// Mass [kg].
    Mass, Mass, "a mass", "9.2 g", "kg";
    /// A mass density [kg/m³].
    Density, MassDensity, "a density", "970 kg/m3", "kg/m3";
    /// A dynamic viscosity [Pa·s].
    Viscosity, DynamicViscosity, "a dynamic viscosity", "1 mPa s", "Pa s";
    /// A force [N].
    Force, Force, "a force", "57.5 N", "N";
    /// A stiffness [N/m].
    Stiffness, SurfaceTension, "a stiffness", "1e5 N/m", "N/m";
    /// The coefficient of a dashpot [kg/s].
    Dashpot, MassRate, "a dashpot coefficient", "3 kg/s", "kg/s";
    /// A pressure, or a modulus of elasticity [Pa].
    Pressure, Pressure, "a pressure", "2 kPa", "Pa";
    /// A temperature [K].
    Temperature, ThermodynamicTemperature, "a temperature", "293.15 K", "K";
    /// An angle [rad].
    Angle, Angle, "an angle", "90 deg", "rad";
    /// A frequency [1/s].
    Frequency, Frequency, "a frequency", "30 Hz", "Hz";
}

/// A wait of so many seconds of wall time. A number outside the range becomes the nearest bound,
/// zero or [`LONGEST_WAIT`], so that no number from outside can make a clock overflow.
pub fn wait(seconds: f64) -> Duration {
    let seconds = seconds.clamp(0.0, LONGEST_WAIT.as_secs_f64());
    Duration::try_from_secs_f64(seconds).unwrap_or(LONGEST_WAIT)
}

/// The longest wait for anything: a day.
pub const LONGEST_WAIT: Duration = Duration::from_secs(24 * 60 * 60);

/// Reads a quantity from a string; its errors name the value found and the kind expected.
struct QuantityVisitor<T> {
    kind: &'static str,
    example: &'static str,
    parse: fn(&str) -> Result<T, NotAQuantity>,
}

impl<T> QuantityVisitor<T> {
    fn refuse<E: de::Error>(&self, found: String) -> E {
        E::custom(NotAQuantity { found, kind: self.kind, example: self.example })
    }
}

impl<T> de::Visitor<'_> for QuantityVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} with a unit, as \"{}\"", self.kind, self.example)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        (self.parse)(text).map_err(E::custom)
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<T, E> {
        Err(self.refuse(format!("the bare number {value}")))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<T, E> {
        Err(self.refuse(format!("the bare number {value}")))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<T, E> {
        Err(self.refuse(format!("the bare number {value}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_a_user_types() {
        assert_eq!("0.3 mm".parse::<Length>().unwrap().0, 0.3e-3);
        assert_eq!("5 um".parse::<Length>().unwrap().0, 5.0 * 1e-6);
        assert_eq!("970 kg/m3".parse::<Density>().unwrap().0, 970.0);
        assert_eq!("970 kg/m^3".parse::<Density>().unwrap().0, 970.0);
        assert_eq!("0.373 Pa s".parse::<Viscosity>().unwrap().0, 0.373);
        assert_eq!("0.373 Pa*s".parse::<Viscosity>().unwrap().0, 0.373);
        assert!(("1 mPa s".parse::<Viscosity>().unwrap().0 - 1e-3).abs() < 1e-18);
        assert!(("1 cP".parse::<Viscosity>().unwrap().0 - 1e-3).abs() < 1e-18);
        assert_eq!("-9.81 m/s2".parse::<Acceleration>().unwrap().0, -9.81);
        assert_eq!("1e7 N/m".parse::<Stiffness>().unwrap().0, 1e7);
        assert_eq!("57.5 N".parse::<Force>().unwrap().0, 57.5);
        assert_eq!("3 kg/s".parse::<Dashpot>().unwrap().0, 3.0);
        assert!(("70.9 mm2".parse::<Area>().unwrap().0 - 70.9e-6).abs() < 1e-18);
        assert_eq!("4e-3 m3".parse::<Volume>().unwrap().0, 4e-3);
        assert!(("4 L".parse::<Volume>().unwrap().0 - 4e-3).abs() < 1e-15);
        assert_eq!("2 min".parse::<Time>().unwrap().0, 120.0);
        assert_eq!("100 Hz".parse::<Frequency>().unwrap().0, 100.0);
        assert_eq!("70 GPa".parse::<Pressure>().unwrap().0, 70e9);
        assert_eq!("1 bar".parse::<Pressure>().unwrap().0, 1e5);
        assert_eq!("300 K".parse::<Temperature>().unwrap().0, 300.0);
        assert_eq!("180 deg".parse::<Angle>().unwrap().0, core::f64::consts::PI);
        assert_eq!("1 rad/s".parse::<AngularVelocity>().unwrap().0, 1.0);
    }

    #[test]
    fn refuses_what_is_not_a_quantity_of_that_kind() {
        for text in ["1 kg", "1", "mm", "1mm", "one mm", "", "inf m", "1 m m"] {
            let message = text.parse::<Length>().unwrap_err().to_string();
            assert!(message.contains("a length"), "{message}");
            assert!(message.contains(text), "{message}");
        }
    }

    #[test]
    fn a_kind_is_read_by_its_name() {
        assert_eq!(read("length", "0.3 mm"), Some(Ok(0.3e-3)));
        assert_eq!(read("angular velocity", "2 rad/s"), Some(Ok(2.0)));
        assert_eq!(read("weight", "2 kg"), None);
        assert!(read("mass", "2 m").unwrap().unwrap_err().to_string().contains("a mass"));
        assert!(kinds().all(|kind| read(&kind, "").is_some()));
    }

    #[test]
    fn a_bare_number_is_refused_with_an_example() {
        let message = serde_json::from_str::<Length>("3").unwrap_err().to_string();
        assert!(message.contains("bare number 3"), "{message}");
        assert!(message.contains("0.3 mm"), "{message}");
    }

    #[test]
    fn every_number_is_some_wait() {
        assert_eq!(wait(0.25), Duration::from_millis(250));
        assert_eq!(wait(-1.0), Duration::ZERO);
        for endless in [1e20, f64::INFINITY, f64::NAN] {
            assert_eq!(wait(endless), LONGEST_WAIT);
        }
    }

    #[test]
    fn what_is_written_reads_back_equal() {
        for value in [1.0, 0.1, 1.0 / 3.0, 1.2e-7, 16.0e20] {
            assert_eq!(Length(value).to_string().parse::<Length>().unwrap(), Length(value));
            let json = serde_json::to_string(&Viscosity(value)).unwrap();
            assert_eq!(serde_json::from_str::<Viscosity>(&json).unwrap(), Viscosity(value));
        }
    }
}
