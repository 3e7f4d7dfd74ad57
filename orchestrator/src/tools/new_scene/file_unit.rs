//! The unit of a file of triangles: its numbers are bare.

use clap::ValueEnum;

/// Shortest and longest part that is taken for one without a question of its unit [m].
const USUAL: [f64; 2] = [5e-4, 5.0];

/// Lengths that a person knows: up to which length a part is about as long [m], and the words.
const KNOWN: [(f64, &str); 7] = [
    (3e-4, "a speck of dust"),
    (3e-3, "a pinhead"),
    (3e-2, "a finger is wide"),
    (0.15, "a finger"),
    (0.5, "a forearm"),
    (3.0, "a door is high"),
    (f64::INFINITY, "a house or more"),
];

/// A unit of length of a file of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FileUnit {
    /// Metre.
    M,
    /// Centimetre.
    Cm,
    /// Millimetre.
    Mm,
    /// Micrometre.
    Um,
    /// Inch.
    #[value(alias = "inch")]
    In,
}

impl FileUnit {
    /// Length of one unit [m].
    pub fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
            Self::Um => 1e-6,
            Self::In => 25.4e-3,
        }
    }

    /// The unit as a manifest has it.
    pub fn manifest_name(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::Um => "um",
            Self::In => "inch",
        }
    }

    /// The unit in words, of several.
    pub fn plural(self) -> &'static str {
        match self {
            Self::M => "metres",
            Self::Cm => "centimetres",
            Self::Mm => "millimetres",
            Self::Um => "micrometres",
            Self::In => "inches",
        }
    }

    /// The unit that a part's longest edge suggests, in the file's numbers: millimetres, unless the part would be
    /// shorter than half a millimetre or longer than five metres; then metres, then micrometres.
    pub fn guess(longest: f64) -> Option<Self> {
        let is_usual = |unit: &Self| (USUAL[0]..=USUAL[1]).contains(&(longest * unit.metres()));
        [Self::Mm, Self::M, Self::Um].into_iter().find(is_usual)
    }
}

/// Edges of a box [m] in a unit that suits them: `40 x 12 x 12 mm`.
pub fn edges_text(edges: [f64; 3]) -> String {
    let longest = edges.into_iter().fold(0.0, f64::max);
    let (unit, metres) = match longest {
        _ if longest >= 1.0 => ("m", 1.0),
        _ if longest >= 1e-3 => ("mm", 1e-3),
        _ => ("um", 1e-6),
    };
    let [x, y, z] = edges.map(|edge| three_digits(edge / metres));
    format!("{x} x {y} x {z} {unit}")
}

/// A length as something that a person knows: `as long as a finger`.
pub fn in_words(length: f64) -> String {
    let known = KNOWN.iter().find(|(up_to, _)| length < *up_to);
    format!("about as long as {}", known.map_or("a house or more", |(_, words)| words))
}

/// A number with three digits that count.
pub fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The unit of a file whose box has these edges in its own numbers, as the user says.
///
/// A file of triangles does not say its unit, and a wrong one is wrong by a factor of 25 or 1000: so a guess
/// counts only once a person has agreed to it. Where nobody can be asked, the unit must be given.
///
/// # Errors
/// Sentences: nobody answered, or not with a unit.
pub fn agreed_unit(
    file: &str,
    edges: [f64; 3],
    ask: &mut dyn FnMut(&str) -> Option<String>,
) -> Result<FileUnit, String> {
    let longest = edges.into_iter().fold(0.0, f64::max);
    let [x, y, z] = edges.map(three_digits);
    let guess = FileUnit::guess(longest);
    let sized = |unit: FileUnit| {
        let metres = unit.metres();
        let size = edges_text(edges.map(|edge| edge * metres));
        format!("{size}, {}", in_words(longest * metres))
    };
    let found = format!("{file} is {x} x {y} x {z} of a unit that the file does not say");
    let question = match guess {
        Some(unit) => format!(
            "{found}.\nIn {} it is {}.\nEnter if that is right, else its unit (m, cm, mm, um, in): ",
            unit.plural(),
            sized(unit)
        ),
        None => format!("{found}.\nIts unit (m, cm, mm, um, in): "),
    };
    match ask(&question) {
        None => {
            let advice = guess.map_or(String::new(), |unit| {
                let name = unit.manifest_name();
                format!("; --unit {name} makes it {}", sized(unit))
            });
            Err(format!(
                "{found}, and nobody answered at a terminal\nexpected --unit m, cm, mm, um or in{advice}"
            ))
        }
        Some(answer) => match (answer.trim().to_ascii_lowercase().as_str(), guess) {
            ("" | "y" | "yes", Some(unit)) => Ok(unit),
            (word, _) => FileUnit::from_str(word, true).map_err(|_| {
                format!("the unit of {file}: found \"{word}\", expected m, cm, mm, um or in")
            }),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_in_millimetres_unless_that_is_absurd() {
        for (longest, unit) in [
            (40.0, Some(FileUnit::Mm)),
            (0.6, Some(FileUnit::Mm)),
            (4999.0, Some(FileUnit::Mm)),
            (0.04, Some(FileUnit::M)),
            (0.4, Some(FileUnit::M)),
            (8000.0, Some(FileUnit::Um)),
            (1e-5, None),
            (1e9, None),
            (f64::NAN, None),
        ] {
            assert_eq!(FileUnit::guess(longest), unit, "{longest}");
        }
    }

    #[test]
    fn sizes_are_said_in_words() {
        assert_eq!(edges_text([0.04, 0.012, 0.0125]), "40 x 12 x 12.5 mm");
        assert_eq!(edges_text([2.0, 0.5, 0.01]), "2 x 0.5 x 0.01 m");
        assert_eq!(edges_text([2e-4, 1e-4, 1e-5]), "200 x 100 x 10 um");
        assert_eq!(in_words(0.04), "about as long as a finger");
        assert!(in_words(1e9).contains("house"));
    }

    #[test]
    fn a_guess_counts_once_a_person_agrees() {
        let edges = [40.0, 12.0, 12.0];
        let mut asked = String::new();
        let mut answered = |answer: &str| {
            agreed_unit("a.stl", edges, &mut |question| {
                asked = question.into();
                Some(answer.into())
            })
        };
        assert_eq!(answered("\n"), Ok(FileUnit::Mm));
        assert_eq!(answered("in\n"), Ok(FileUnit::In));
        assert!(answered("furlong").unwrap_err().contains("expected m, cm, mm, um or in"));
        assert!(asked.contains("In millimetres it is 40 x 12 x 12 mm, about as long as a finger"));
        let alone = agreed_unit("a.stl", edges, &mut |_| None).unwrap_err();
        assert!(alone.contains("--unit mm makes it 40 x 12 x 12 mm"), "{alone}");
    }
}
