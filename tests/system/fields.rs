//! Files for ParaView: read by an independent reader, and at no price in bits.

#[path = "../../components/fields/tests/reader/mod.rs"]
pub mod reader;

use crate::tremie::{SMALL, run_text};
use reader::VtkFile;

fn fastest(velocity: &[f64]) -> f64 {
    let squares = velocity.chunks(3).map(|v| v.iter().map(|x| x * x).sum::<f64>());
    squares.fold(0.0, f64::max).sqrt()
}

#[test]
fn fields_are_written_and_change_no_bit() {
    let alone = run_text(SMALL, &[]).succeeded().signals_text();
    let ran = run_text(SMALL, &["--set", "outputs.fields=5 ms"]).succeeded();
    assert!(ran.signals_text() == alone, "fields changed the run");
    let folder = ran.out.join("fields");
    let window = ran.summary()["windows"].as_u64().unwrap();
    let signals = ran.signals();
    let last = |name: &str| *signals[name].last().unwrap();

    let lattice = VtkFile::read(&folder.join(format!("lattice_{window:06}.vti")));
    assert_eq!(lattice.numbers("Piece", "Extent"), [0.0, 23.0, 0.0, 23.0, 0.0, 31.0]);
    let (_, velocity) = lattice.array::<f32>("velocity");
    assert_eq!(velocity.len(), 3 * 24 * 24 * 32);
    let found = fastest(&velocity.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
    // The signal is measured in the step's collision, the field after it.
    let told = last("fluid.max_speed");
    assert!((found / told - 1.0).abs() < 0.05, "{found} in the file, {told} in the table");
    let (_, solid) = lattice.array::<u8>("solid");
    assert!(solid.contains(&1) && solid.contains(&0));

    let bodies = VtkFile::read(&folder.join(format!("bodies_{window:06}.vtp")));
    let (_, velocity) = bodies.array::<f64>("velocity");
    assert_eq!(velocity.len(), 3 * 3);
    assert!((fastest(&velocity) / last("grains.max_speed") - 1.0).abs() < 1e-12);

    for name in ["lattice.pvd", "bodies.pvd"] {
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        let files = text.split("file=\"").skip(1).map(|rest| &rest[..rest.find('"').unwrap()]);
        assert!(files.clone().count() >= 5, "{text}");
        assert!(files.clone().all(|file| folder.join(file).exists()), "{text}");
        assert!(text.ends_with("</VTKFile>\n"));
    }
}

#[test]
fn the_plan_says_how_much_fields_will_write() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let output = crate::tremie::tremie()
        .arg("check")
        .arg(&manifest)
        .args(["--set", "outputs.fields=5 ms", "--set", "settings.fields.stride=2"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("frames of 12 x 12 x 16 nodes from fluid: 73.7 kB each"), "{text}");
}
