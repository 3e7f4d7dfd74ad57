//! The settling sphere of ten Cate, Nieuwstad, Derksen and Van den Akker, Phys. Fluids 14 (2002) 4012: the
//! slowest and the fastest of the four cases, against the measured peak speeds.
//!
//! The lattice is coarse, 1.667 mm or 9 cells across the sphere, in f32, so that both runs end within a minute;
//! it gives -2.0 % (E1) and +1.3 % (E4). The tolerance is the 5 % that is asked of the example itself, which
//! has 16.5 cells; `examples/settling-sphere/README.md` holds its numbers.

use crate::tremie::run;

struct Case {
    density: &'static str,
    viscosity: &'static str,
    expected_speed: &'static str,
    /// Just past the peak (E4) or well on the plateau (E1).
    until: &'static str,
    /// Measured [m/s].
    peak: f64,
}

#[track_caller]
fn settles_as_measured(case: &Case) {
    let options = [
        "--quiet".to_string(),
        format!("--until={}", case.until),
        format!("--set=scene.fluid.density=\"{}\"", case.density),
        format!("--set=scene.fluid.viscosity=\"{}\"", case.viscosity),
        format!("--set=scene.fluid.expected_speed=\"{}\"", case.expected_speed),
        "--set=settings.fluid-lbm.cell=\"1.6666666667 mm\"".to_string(),
        "--set=settings.fluid-lbm.precision=\"f32\"".to_string(),
        "--set=outputs.record=false".to_string(),
    ];
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let ran = run("examples/settling-sphere/manifest.toml", &options).succeeded();
    let peak = ran.signals()["grains.body0_vz"].iter().fold(0.0_f64, |peak, vz| peak.max(-vz));
    let deviation = peak / case.peak - 1.0;
    println!("peak {peak:.5} m/s, measured {} m/s: {:+.1} %", case.peak, 100.0 * deviation);
    assert!(deviation.abs() < 0.05, "peak {peak} m/s, measured {} m/s", case.peak);
}

#[test]
fn the_slowest_sphere_settles_as_measured() {
    settles_as_measured(&Case {
        density: "970 kg/m3",
        viscosity: "0.373 Pa s",
        expected_speed: "0.038 m/s",
        until: "1.3 s",
        peak: 0.03599,
    });
}

#[test]
fn the_fastest_sphere_settles_as_measured() {
    settles_as_measured(&Case {
        density: "960 kg/m3",
        viscosity: "0.058 Pa s",
        expected_speed: "0.128 m/s",
        until: "1.05 s",
        peak: 0.12224,
    });
}
