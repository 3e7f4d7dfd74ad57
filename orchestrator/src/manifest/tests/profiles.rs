//! Profiles of grains.

use super::*;
use tremie_messages::scene::{BinnedAxis, ProfileVelocity};

/// The good manifest with a probe, and a profile of these lines.
fn with(profile: &str) -> String {
    let probe = "[[scene.probes]]\nname = \"gauge\"\npoint = [\"1 mm\", \"1 mm\", \"10 mm\"]\n";
    let table = format!("{probe}\n[[scene.profiles]]\n{profile}\n\n[scene.fluid]");
    GOOD.replacen("[scene.fluid]", &table, 1)
}

#[test]
fn a_profile_is_read_with_its_defaults() {
    let text = with("name = \"height\"\nalong = [\"z\"]\nbins = [16]");
    let scene = read(&text).unwrap().spec.scene;
    let [profile] = &scene.profiles[..] else { panic!() };
    assert_eq!(profile.axes, [BinnedAxis { axis: 2, bins: 16 }]);
    assert_eq!((profile.min, profile.max), (scene.domain.min, scene.domain.max));
    assert_eq!((profile.from, profile.every, profile.average), (0.0, None, None));
    assert_eq!(profile.velocity, ProfileVelocity::Instantaneous);
    reads_back(&text);
}

#[test]
fn widths_become_the_nearest_whole_number_of_bins() {
    let text = with(
        "name = \"plane\"\nalong = [\"z\", \"x\"]\nbin_width = [\"4.5 mm\", \"100 mm\"]\nmax = [\"100 mm\", \"100 mm\", \"50 mm\"]\n\
         from = \"0.5 s\"\nevery = \"1 ms\"\naverage = \"0.5 s\"\nvelocity = \"displacement\"",
    );
    let scene = read(&text).unwrap().spec.scene;
    let profile = &scene.profiles[0];
    let axes = [BinnedAxis { axis: 2, bins: 11 }, BinnedAxis { axis: 0, bins: 1 }];
    assert_eq!(profile.axes, axes, "50 mm are 11.1 times 4.5 mm");
    assert_eq!((profile.every, profile.average), (Some(1e-3), Some(0.5)));
    assert_eq!(profile.velocity, ProfileVelocity::Displacement);
    reads_back(&text);
}

#[test]
fn what_is_wrong_with_a_profile_is_one_problem() {
    let wrong = |lines: &str, parts: &[&str]| one_problem(&with(lines), parts);
    let name = "name = \"p\"";
    let right = format!("{name}\nalong = [\"z\"]\nbins = [4]");
    wrong("along = [\"z\"]\nbins = [4]", &["missing", "\"name\""]);
    wrong(
        "name = \"gauge\"\nalong = [\"z\"]\nbins = [4]",
        &["name", "a second probe, gap or profile"],
    );
    wrong(&format!("{name}\nbins = [4]"), &["missing", "\"along\""]);
    wrong(&format!("{name}\nalong = []\nbins = []"), &["along", "no axis"]);
    wrong(
        &format!("{name}\nalong = [\"x\", \"x\"]\nbins = [4, 4]"),
        &["along", "the axis \"x\" twice"],
    );
    wrong(
        &format!("{name}\nalong = [\"x\", \"y\", \"z\"]\nbins = [4, 4, 4]"),
        &["along", "3 axes"],
    );
    wrong(&format!("{name}\nalong = [\"w\"]\nbins = [4]"), &["along", "\"w\""]);
    wrong(&format!("{name}\nalong = [\"z\"]"), &["missing", "bins, bin_width"]);
    wrong(&format!("{right}\nbin_width = [\"1 mm\"]"), &["both bins and bin_width"]);
    wrong(&format!("{name}\nalong = [\"z\"]\nbins = [0]"), &["bins", "found 0"]);
    wrong(&format!("{name}\nalong = [\"z\"]\nbins = [4, 4]"), &["bins", "found 2", "1"]);
    wrong(
        &format!("{name}\nalong = [\"x\", \"z\"]\nbins = [400, 400]"),
        &["bins", "160000", "100000"],
    );
    wrong(
        &format!("{name}\nalong = [\"z\"]\nbin_width = [\"0 mm\"]"),
        &["bin_width", "more than zero"],
    );
    wrong(
        &format!("{name}\nalong = [\"z\"]\nbin_width = [\"2 m\"]"),
        &["bin_width", "more than the box"],
    );
    wrong(
        &format!("{right}\nmin = [\"0 mm\", \"0 mm\", \"9 m\"]"),
        &["max", "more than the lower corner"],
    );
    wrong(&format!("{right}\nmax = [\"1 m\", \"1 mm\", \"9 mm\"]"), &["reaches out of the domain"]);
    wrong(&format!("{right}\nfrom = \"-1 s\""), &["from", "zero or more"]);
    wrong(&format!("{right}\nevery = \"0 s\""), &["every", "more than zero"]);
    wrong(&format!("{right}\nevery = \"10 ms\"\naverage = \"1 ms\""), &["average", "shorter than"]);
    wrong(&format!("{right}\nfrom = \"2 s\""), &["after the run has ended"]);
    wrong(&format!("{right}\naverage = \"1 us\""), &["rows", "average longer"]);
    let twice = format!("{right}\n[[scene.profiles]]\n{right}");
    wrong(&twice, &["scene.profiles[1].name", "a second"]);
}

#[test]
fn a_plane_scene_has_no_bins_across_it() {
    let text = "[run]\nuntil = \"1 s\"\n[scene.domain]\nsize = [\"1 m\", \"10 cm\", \"1 m\"]\nacross = \"y\"\n\
                [[scene.profiles]]\nname = \"p\"\nalong = [\"x\"]\nbins = [5]\nmin = [\"0 m\", \"4 cm\", \"0 m\"]\n\
                [components]\ngrains = \"grains-dem\"\n";
    let profile = &read(text).unwrap().spec.scene.profiles[0];
    assert_eq!((profile.min[1], profile.max[1]), (0.0, 0.1), "as deep as the domain");
    one_problem(&text.replace("[\"x\"]", "[\"y\"]"), &["along", "across the plane scene"]);
}
