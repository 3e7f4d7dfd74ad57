//! Turns serde's sentences into ones for users.

use super::path;
use tremie_messages::Problem;
use tremie_sdk::parameters::nearest;

/// A problem with the key at `at`, of which serde said `message`; and, of an unknown key, the one
/// that was probably meant.
pub(super) fn explain(at: &str, message: &str) -> (Problem, Option<String>) {
    if let Some((unknown, valid)) = unknown(message, "unknown field `") {
        // The path ends with the unknown key itself in most cases.
        let is_last = at.rsplit(['.', ']']).next() == Some(unknown);
        let key = if is_last { at.to_string() } else { path::join(at, unknown) };
        let meant = nearest(unknown, &valid).map(|near| path::join(path::parent(&key), near));
        let problem = Problem::new(&key, format!("unknown key \"{unknown}\""));
        if let Some(help) = not_here(&key, unknown) {
            return (problem.help(help), None);
        }
        return (suggest(problem, unknown, &valid, true), meant);
    }
    if let Some((unknown, valid)) = unknown(message, "unknown variant `") {
        let message = format!("found \"{unknown}\", expected {}", list(&valid));
        return (suggest(Problem::new(at, message), unknown, &valid, false), None);
    }
    let problem = Problem::new(at, plain(message));
    if message.starts_with("invalid type: map, expected a sequence") {
        return (problem.help(as_list(at)), None);
    }
    (problem, None)
}

/// Advice on a key that users of other programs give here and this one has elsewhere.
fn not_here(key: &str, unknown: &str) -> Option<&'static str> {
    let is_mass = ["mass", "density", "inertia"].contains(&unknown);
    let parent = path::parent(key);
    if !is_mass {
        return None;
    }
    if parent.starts_with("scene.parts[") && !parent.contains(".motion") {
        return Some(
            "leave it out: a part that is fixed or moves as prescribed yields to no force, and has no mass. One that \
             forces move along an axis has it there: motion = { slider = { axis = [0, 0, 1], mass = \"9.2 g\" } }; one that is \
             to move freely is a body of [[scene.bodies]]",
        );
    }
    if parent.starts_with("scene.planes[") || parent.starts_with("scene.domain") {
        return Some("leave it out: walls move as they are told or not at all, and have no mass");
    }
    if parent.starts_with("scene.bodies[") && unknown != "density" {
        return Some("give the density in its place: the mass follows from the volume");
    }
    None
}

/// Advice to write a list of tables, where a single table was found.
fn as_list(at: &str) -> String {
    let plain = format!("write [[{at}]] in place of [{at}]");
    match at {
        "scene.contacts" => format!(
            "{plain}, with the keys of a law below it in place of body_body; a law with walls of its own (body_wall) is \
             a second [[{at}]] with between = [\"NAME\", \"wall\"], NAME the material of the bodies"
        ),
        _ => plain,
    }
}

/// The word that is unknown and those that are known.
fn unknown<'a>(message: &'a str, prefix: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let (unknown, rest) = message.strip_prefix(prefix)?.split_once('`')?;
    Some((unknown, rest.split('`').skip(1).step_by(2).collect()))
}

/// Adds the nearest valid word, or all valid keys.
fn suggest(problem: Problem, word: &str, valid: &[&str], keys: bool) -> Problem {
    match nearest(word, valid) {
        Some(near) => problem.help(format!("did you mean \"{near}\"?")),
        None if keys => problem.help(format!("valid keys: {}", valid.join(", "))),
        None => problem,
    }
}

fn list(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

/// The names of types in Rust say little to most users.
fn plain(message: &str) -> String {
    let message = message
        .replace("invalid type: ", "found ")
        .replace("invalid value: ", "found ")
        .replace("invalid length ", "found a list of length ")
        .replace('`', "");
    const WORDS: [(&str, &str); 9] = [
        ("a nonzero u32", "a whole number from 1 to 4294967295"),
        ("u32", "a whole number from 0 to 4294967295"),
        ("u64", "a whole number, not negative"),
        ("f64", "a number"),
        ("an array of length", "a list of length"),
        ("a tuple of size", "a list of length"),
        ("a sequence", "a list"),
        ("a map", "a table"),
        ("struct ", "a table: "),
    ];
    let Some((found, expected)) = message.split_once(", expected ") else {
        return message;
    };
    let found = found
        .replace("map", "a table")
        .replace("sequence", "a list")
        .replace("floating point", "number");
    if expected.starts_with("struct ") {
        return format!("{found}, expected a table");
    }
    let word = WORDS.iter().find(|(rust, _)| expected.starts_with(rust));
    match word {
        Some((rust, plain)) => format!("{found}, expected {plain}{}", &expected[rust.len()..]),
        None => format!("{found}, expected {expected}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_comes_with_the_nearest() {
        let (problem, meant) =
            explain("scene.flud", "unknown field `flud`, expected one of `fluid`, `planes`");
        assert_eq!(problem.key, "scene.flud");
        assert_eq!(meant.as_deref(), Some("scene.fluid"));
        assert_eq!(problem.help.as_deref(), Some("did you mean \"fluid\"?"));
        let (problem, _) =
            explain("scene", "unknown field `xyz`, expected one of `fluid`, `planes`");
        assert_eq!(problem.key, "scene.xyz");
        assert_eq!(problem.help.as_deref(), Some("valid keys: fluid, planes"));
    }

    #[test]
    fn a_mass_where_nothing_has_one_comes_with_what_to_do() {
        let help = |at: &str| {
            let (problem, meant) =
                explain(at, "unknown field `mass`, expected one of `name`, `material`");
            assert_eq!((problem.message.as_str(), meant), ("unknown key \"mass\"", None), "{at}");
            problem.help.unwrap()
        };
        for (at, words) in [
            ("scene.parts[0].mass", "slider"),
            ("scene.parts[3].sphere.mass", "slider"),
            ("scene.planes[0].mass", "have no mass"),
            ("scene.domain.x.lower.wall.mass", "have no mass"),
            ("scene.bodies[1].mass", "the density"),
        ] {
            assert!(help(at).contains(words), "{at}: {}", help(at));
        }
        assert!(help("scene.materials.sand.mass").starts_with("valid keys"));
    }

    #[test]
    fn a_table_in_place_of_a_list_of_tables_comes_with_the_way_to_write_it() {
        let help = |at: &str| {
            let (problem, _) = explain(at, "invalid type: map, expected a sequence");
            assert_eq!(problem.message, "found a table, expected a list");
            problem.help.unwrap()
        };
        assert_eq!(help("scene.probes"), "write [[scene.probes]] in place of [scene.probes]");
        assert!(help("scene.contacts").contains("body_wall"));
    }

    #[test]
    fn types_are_named_in_plain_words() {
        let say = |message: &str| explain("x", message).0.message;
        assert_eq!(
            say("invalid type: string \"a\", expected u32"),
            "found string \"a\", expected a whole number from 0 to 4294967295"
        );
        assert_eq!(
            say("invalid type: integer `3`, expected struct FluidTable"),
            "found integer 3, expected a table"
        );
        assert_eq!(
            say("invalid length 2, expected an array of length 3"),
            "found a list of length 2, expected a list of length 3"
        );
        assert_eq!(
            say("unknown variant `serail`, expected `serial` or `parallel`"),
            "found \"serail\", expected \"serial\" or \"parallel\""
        );
    }
}
