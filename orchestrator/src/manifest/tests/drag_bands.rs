//! Bands that brake grains.

use super::*;

/// The good manifest with a band.
fn with_band() -> String {
    let band = r#"
[[scene.drag_bands]]
name = "fall"
min = ["0 mm", "0 mm", "130 mm"]
max = ["10 cm", "10 cm", "150 mm"]
terminal_speed = "20 cm/s"

[[scene.contacts]]
"#;
    GOOD.replace("\n[[scene.contacts]]\n", band)
}

fn refused(from: &str, to: &str, words: &[&str]) {
    let text = with_band();
    assert!(text.contains(from), "{from}");
    one_problem(&text.replacen(from, to, 1), words);
}

#[test]
fn a_drag_band_is_read_in_si() {
    let text = with_band();
    let scene = read(&text).unwrap_or_else(|errors| panic!("{errors}")).spec.scene;
    let [band] = &scene.drag_bands[..] else { panic!("{:?}", scene.drag_bands) };
    assert_eq!((band.name.as_str(), band.terminal_speed), ("fall", 0.2));
    assert_eq!((band.min, band.max), ([0.0, 0.0, 0.13], [0.1, 0.1, 0.15]));
    reads_back(&text);
}

#[test]
fn problems_of_drag_bands_are_told_at_their_keys() {
    refused("name = \"fall\"", "", &["drag_bands[0].name", "missing"]);
    refused("\"20 cm/s\"", "\"0 m/s\"", &["drag_bands[0].terminal_speed", "more than zero"]);
    refused("\"150 mm\"", "\"170 mm\"", &["drag_bands[0]", "out of the domain"]);
    refused("\"150 mm\"", "\"120 mm\"", &["drag_bands[0].max", "lower corner"]);
    let gravity = "gravity = [\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]";
    refused(gravity, "", &["drag_bands[0]", "no gravity"]);
    let probe = "[[scene.probes]]\nname = \"fall\"\npoint = [\"1 cm\", \"1 cm\", \"1 cm\"]\n\n[[scene.drag_bands]]";
    refused("[[scene.drag_bands]]", probe, &["drag_bands[0].name", "another inlet"]);
}
