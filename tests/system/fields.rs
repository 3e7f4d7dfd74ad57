//! Files for ParaView: read by an independent reader, and at no price in bits.

use crate::tremie::{SMALL, run_text};
use std::path::Path;
use vtkio::model::{Attribute, DataSet, IOBuffer, Piece};

fn array(attributes: &[Attribute], name: &str) -> IOBuffer {
    let found = attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => Some(array.data.clone()),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no array {name}"))
}

fn read(path: &Path) -> DataSet {
    vtkio::Vtk::import(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).data
}

#[test]
fn fields_are_written_and_change_no_bit() {
    let alone = run_text(SMALL, &[]).succeeded().signals_text();
    let fields = ["--set", "outputs.fields=5 ms"];
    let plain = ["--set", "settings.fields.compression=none"];
    let ran = run_text(SMALL, &[&fields[..], &plain].concat()).succeeded();
    assert!(ran.signals_text() == alone, "fields changed the run");
    let folder = ran.out.join("fields");
    let window = ran.summary()["windows"].as_u64().unwrap();

    let DataSet::ImageData { extent, mut pieces, .. } =
        read(&folder.join(format!("lattice_{window:06}.vti")))
    else {
        panic!("no ImageData")
    };
    assert_eq!(extent.into_ranges().map(|r| r.end() - r.start() + 1), [24, 24, 32]);
    let Piece::Inline(piece) = pieces.remove(0) else { panic!("no inline piece") };
    let IOBuffer::F32(velocity) = array(&piece.data.point, "velocity") else {
        panic!("no Float32")
    };
    assert_eq!(velocity.len(), 3 * 24 * 24 * 32);
    let fastest = velocity
        .chunks(3)
        .map(|v| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let signals = ran.signals();
    let last = |name: &str| *signals[name].last().unwrap();
    // The signal is measured in the step's collision, the field after it.
    let told = last("fluid.max_speed");
    assert!((fastest / told - 1.0).abs() < 0.05, "{fastest} in the file, {told} in the table");
    let IOBuffer::U8(solid) = array(&piece.data.point, "solid") else { panic!("no UInt8") };
    assert!(solid.contains(&1) && solid.contains(&0));

    let DataSet::PolyData { mut pieces, .. } =
        read(&folder.join(format!("bodies_{window:06}.vtp")))
    else {
        panic!("no PolyData")
    };
    let Piece::Inline(piece) = pieces.remove(0) else { panic!("no inline piece") };
    let IOBuffer::F64(velocity) = array(&piece.data.point, "velocity") else {
        panic!("no Float64")
    };
    assert_eq!(velocity.len(), 3 * 3);
    let fastest = velocity.chunks(3).map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let told = last("grains.max_speed");
    assert!((fastest.fold(0.0, f64::max) / told - 1.0).abs() < 1e-12);

    let series = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    for name in ["lattice.pvd", "bodies.pvd"] {
        let text = series(name);
        let files: Vec<_> =
            text.split("file=\"").skip(1).map(|t| &t[..t.find('"').unwrap()]).collect();
        assert!(files.len() >= 5, "{text}");
        assert!(files.iter().all(|file| folder.join(file).exists()), "{text}");
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
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("frames of 12 x 12 x 16 nodes from fluid: 46.1 kB each"), "{text}");
}
