//! Files are read back by an independent reader, and equal the tables sent.

mod reader;
mod two_profiles;

use reader::read_npz;
use std::path::Path;
use tremie_messages::Stamp;
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_profiles::ProfileWriter;
use tremie_sdk::{Moment, Observer};
use two_profiles::setup;

fn bins(window: u64, count: usize) -> Vec<ProfileBin> {
    let bin = |k: usize| {
        let x = (k as f64 + 100.0 * window as f64) / 7.0;
        ProfileBin {
            grains: x,
            solid_fraction: 1e-3 * x,
            velocity: if k == 1 { [f64::NAN; 3] } else { [x, -x, 1e-9 * x] },
            contact_stress: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|c| c * x),
            ..ProfileBin::default()
        }
    };
    (0..count).map(bin).collect()
}

fn send(writer: &mut ProfileWriter, name: &str, window: u64, bins: &[ProfileBin]) {
    let stamp = Stamp { run: 7, window, ticks: window, ..Stamp::default() };
    let time = 1e-3 * window as f64;
    let header = ProfileHeader { stamp, begin: time - 5e-3, end: time, samples: 5 };
    writer.profile("grains", name, Moment { stamp, time }, &header, bins).unwrap();
}

/// Numbers of a table, by row, and the names of its columns.
fn csv(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(String::from).collect();
    let row = |line: &str| line.split(',').map(|text| text.parse().unwrap()).collect();
    (names, lines.map(row).collect())
}

#[test]
fn rows_and_arrays_hold_the_tables_and_end_with_the_common_window() {
    let folder = tempfile::tempdir().unwrap();
    let setup = setup(folder.path());
    let wishes = ProfileWriter::describe(&setup).unwrap().watches;
    assert!(wishes.profiles && !wishes.bodies && !wishes.signals && !wishes.log);
    let mut writer = ProfileWriter::open(&setup).unwrap();
    for window in [5, 10, 15] {
        send(&mut writer, "plane", window, &bins(window, 8));
    }
    // Already there while the run goes on.
    let path = folder.path().join("profiles/plane.csv");
    assert_eq!(csv(&path).1.len(), 24);
    let note = writer.close(12).unwrap();
    assert_eq!(note, "profiles/: tables 2 of plane, 0 of line");

    let (names, rows) = csv(&path);
    assert_eq!(names[..6], ["begin [s]", "end [s]", "samples [1]", "z [m]", "x [m]", "grains [1]"]);
    assert_eq!(rows.len(), 16, "window 15 lies beyond the last common one");
    assert_eq!(rows[0][..5], [0.0, 5e-3, 5.0, 0.125, 0.125]);
    assert_eq!(rows[5][3..5], [0.375, 0.375], "the second axis runs fastest");

    let arrays = read_npz(&folder.path().join("profiles/plane.npz"));
    assert_eq!(arrays.len(), names.len());
    assert_eq!((&arrays["x"].shape, &arrays["x"].values[..2]), (&vec![4], &[0.125, 0.375][..]));
    assert_eq!(arrays["z"].values, [0.125, 0.375]);
    assert_eq!(arrays["end"].values, [5e-3, 0.01]);
    assert_eq!(arrays["samples"].values, [5.0, 5.0]);
    for (column, name) in names.iter().enumerate().skip(5) {
        let array = &arrays[name.split(" [").next().unwrap()];
        assert_eq!(array.shape, [2, 2, 4], "{name}");
        let in_rows = rows.iter().map(|row| row[column].to_bits());
        assert!(in_rows.eq(array.values.iter().map(|value| value.to_bits())), "{name}");
    }
    let sent = bins(10, 8);
    assert_eq!(arrays["contact_stress_zx"].values[8 + 3], sent[3].contact_stress[4]);
    assert!(arrays["velocity_y"].values[1].is_nan());

    let empty = read_npz(&folder.path().join("profiles/line.npz"));
    assert_eq!((&empty["grains"].shape, empty["y"].values.len()), (&vec![0, 3], 3));
    let read = std::fs::read_dir(folder.path().join("profiles")).unwrap();
    assert_eq!(read.count(), 4, "nothing else is left");
}

#[test]
fn equal_runs_give_equal_bytes() {
    let run = || {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = ProfileWriter::open(&setup(folder.path())).unwrap();
        send(&mut writer, "line", 5, &bins(5, 3));
        writer.close(20).unwrap();
        let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
        (read("profiles/line.csv"), read("profiles/line.npz"))
    };
    assert!(run() == run());
}

#[test]
fn tables_of_no_profile_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = ProfileWriter::open(&setup(folder.path())).unwrap();
    let at = Moment { stamp: Stamp::default(), time: 0.0 };
    let told = writer.profile("grains", "line", at, &ProfileHeader::default(), &bins(1, 2));
    assert!(told.unwrap_err().to_string().contains("a table of 2 bins came"));
}
