//! Damaged quantities, lines of the start contract, and messages: each is read or refused, soon and in
//! little memory.

use std::path::Path;
use tremie_messages::frame::{BodySample, SliceNode};
use tremie_messages::start::{Reply, Request};
use tremie_messages::{BodyState, Stamp, bytes_of, units, values_of};
use tremie_test_support::{Counting, DamagedInput, inputs};

#[global_allocator]
static COUNTING: Counting = Counting;

/// What is said of a text as one kind of quantity.
fn told<Q: std::str::FromStr<Err = units::NotAQuantity> + std::fmt::Display>(text: &str) -> String {
    match text.parse::<Q>() {
        Ok(value) => {
            let again = value.to_string();
            assert!(again.parse::<Q>().is_ok(), "{again} was written and cannot be read");
            "a quantity".into()
        }
        Err(error) => error.to_string(),
    }
}

fn try_quantities(count: u64) {
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        [
            told::<units::Length>(&text),
            told::<units::Area>(&text),
            told::<units::Time>(&text),
            told::<units::Velocity>(&text),
            told::<units::Acceleration>(&text),
            told::<units::Density>(&text),
            told::<units::Viscosity>(&text),
            told::<units::Stiffness>(&text),
            told::<units::Pressure>(&text),
            told::<units::Temperature>(&text),
            told::<units::Angle>(&text),
        ]
        .map(|said| if said == "a quantity" { "y" } else { "n" })
        .concat()
    };
    let texts = [
        "0.3 mm",
        "70.9 mm2",
        "4 L",
        "20 ms",
        "0.1 m/s",
        "2 rad/s",
        "-9.81 m/s^2",
        "9.2 g",
        "970 kg/m3",
        "1 mPa s",
        "1 mPa*s",
        "57.5 N",
        "1e5 N/m",
        "3 kg/s",
        "2 kPa",
        "293.15 K",
        "90 deg",
        "30 Hz",
        "5 um",
        "5 μm",
        "1 cP",
        "2 min",
        "20 °C",
    ];
    let inputs = texts.map(|text| text.as_bytes().to_vec()).into();
    let words = [
        "mm", "kg", "m3", "s2", "Pa s", "·", "µ", "u", "²", "^2", "*", "/", " ", "\t", "\u{a0}",
        "°", "inf", "NaN", "E", "_", "0x1", "deg", "K", "\u{0}",
    ];
    // Eleven refusals, each with the text.
    let memory = [1 << 12, 300];
    DamagedInput { name: "quantities", inputs, words: &words, read: &read, memory }.try_many(count);
}

fn try_lines(count: u64) {
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        let reply = match serde_json::from_str::<Reply>(&text) {
            Ok(reply) => format!("a reply {}", serde_json::to_string(&reply).unwrap().len() > 100),
            Err(error) => error.to_string(),
        };
        match serde_json::from_str::<Request>(&text) {
            Ok(request) => {
                let line = serde_json::to_string(&request).unwrap();
                format!("{reply}, a request of {}", line.len() > 100)
            }
            Err(error) => format!("{reply}, {error}"),
        }
    };
    let inputs = inputs(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/lines"));
    let words = [
        "\"hello\"",
        "\"assignment\"",
        "\"quit\"",
        "\"description\"",
        "\"refusal\"",
        "\"ready\"",
        "\"finished\"",
        "\"fault\"",
        "\"saved\"",
        "\"waiting\"",
        "null",
        "true",
        "[",
        "{",
        "}",
        "]",
        ",",
        ":",
        "\"",
        "\\u0000",
        "\\ud800",
        "1e400",
        "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
        "{\"a\":{\"a\":{\"a\":{\"a\":",
        "\"window\"",
        "\"kind\"",
        "\"exit\"",
    ];
    let memory = [1 << 14, 400];
    DamagedInput {
        name: "lines of the start contract",
        inputs,
        words: &words,
        read: &read,
        memory,
    }
    .try_many(count);
}

/// Any bytes are whole messages or none, and come back as they were.
fn try_messages(count: u64) {
    fn there_and_back<T: tremie_messages::Message>(bytes: &[u8]) -> usize {
        let Some(values) = values_of::<T>(bytes) else { return 0 };
        assert!(bytes_of(&values) == bytes);
        // What a log would say of them.
        format!("{values:?}").len().min(1)
    }
    let read = |bytes: &[u8]| {
        let stamps = values_of::<Stamp>(bytes).unwrap_or_default();
        let states = values_of::<BodyState>(bytes).unwrap_or_default();
        let finite = states.iter().filter(|state| state.is_finite()).count();
        let shown: usize = stamps.iter().map(|stamp| stamp.to_string().len().min(1)).sum();
        let samples = there_and_back::<BodySample>(bytes) + there_and_back::<SliceNode>(bytes);
        format!("{} {} {}", finite.min(3) > 0, shown > 0, samples > 0)
    };
    let body = BodyState::at_rest(7, [0.1, 0.2, 0.3]);
    let inputs = vec![
        bytes_of(&[body; 2]).to_vec(),
        bytes_of(&[Stamp { run: 1, window: 2, ticks: 3, events: 4, substep: 5, iteration: 6 }; 3])
            .to_vec(),
        bytes_of(&[SliceNode::default(); 4]).to_vec(),
    ];
    let memory = [1 << 12, 60];
    DamagedInput { name: "messages", inputs, words: &[], read: &read, memory }.try_many(count);
}

#[test]
fn damaged_quantities_are_read_or_refused() {
    try_quantities(5000);
}

#[test]
fn damaged_lines_are_read_or_refused() {
    try_lines(5000);
}

#[test]
fn any_bytes_are_messages_or_none() {
    try_messages(5000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_quantities_are_read_or_refused() {
    try_quantities(1_000_000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_lines_are_read_or_refused() {
    try_lines(1_000_000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_pieces_of_bytes_are_messages_or_none() {
    try_messages(1_000_000);
}
