//! Spectra of signals: at which frequencies they swing, and how much.
//!
//! Welch's method (IEEE Trans. Audio Electroacoust. 15 (1967) 70): rows are cut into stretches that overlap by
//! half; each loses its mean and gets a Hann window, and the squares of their Fourier coefficients are
//! averaged. `S` is one-sided, so its sum over frequencies is the variance:
//!
//! ```text
//! S(f) = 2 dt/(sum w^2) |sum over the stretch of w x exp(-2 pi i f t)|^2
//! ```
//!
//! Drawn is its root, a value over the root of a frequency, as mean squares over a 24th of an octave.

use super::panels::{Panel, PanelCurve};
use realfft::RealFftPlanner;
use std::collections::BTreeMap;

/// Stretches that half overlap.
const STRETCHES: usize = 8;
/// Fewest rows of a stretch.
const LEAST_ROWS: usize = 16;
/// Bands of an octave in which a curve has a point.
const BANDS: f64 = 24.0;
/// Largest relative difference of the times between rows.
const UNEVEN: f64 = 1e-3;

/// What a signal does in a stretch of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Frequency [Hz], and the root of the density of the variance [unit/Hz^(1/2)].
    pub points: Vec<(f64, f64)>,
    /// Root of the mean square about the mean.
    pub rms: f64,
    /// Frequency of the greatest density [Hz].
    pub strongest: f64,
}

/// A signal has no spectrum.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoSpectrum {
    /// There are too few rows.
    #[error("{rows} rows lie in this time, and a spectrum needs {least}")]
    Few {
        /// Rows that there are.
        rows: usize,
        /// Rows that there must be.
        least: usize,
    },
    /// Rows are not evenly spaced.
    #[error("the rows are not evenly spaced: {least} s and {most} s apart")]
    Uneven {
        /// Least time between two.
        least: f64,
        /// Greatest time between two.
        most: f64,
    },
    /// A value is missing.
    #[error("a value is missing at {0} s")]
    Missing(f64),
}

/// Spectrum of the rows, times and values, from one time to another.
///
/// # Errors
/// See [`NoSpectrum`].
pub fn spectrum(rows: &[(f64, f64)], [from, until]: [f64; 2]) -> Result<Spectrum, NoSpectrum> {
    let rows: Vec<_> = rows.iter().filter(|row| (from..=until).contains(&row.0)).collect();
    let length = 2 * rows.len() / (STRETCHES + 1);
    if length < LEAST_ROWS {
        let least = (LEAST_ROWS * (STRETCHES + 1)).div_ceil(2);
        return Err(NoSpectrum::Few { rows: rows.len(), least });
    }
    if let Some(row) = rows.iter().find(|row| !row.1.is_finite()) {
        return Err(NoSpectrum::Missing(row.0));
    }
    let steps = rows.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let (least, most) =
        steps.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), dt| (a.min(dt), b.max(dt)));
    if most - least > UNEVEN * most {
        return Err(NoSpectrum::Uneven { least, most });
    }
    let dt = (rows[rows.len() - 1].0 - rows[0].0) / (rows.len() - 1) as f64;
    let values: Vec<f64> = rows.iter().map(|row| row.1).collect();
    let density = density(&values, length, dt);
    let step = 1.0 / (length as f64 * dt);
    let peak = density.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    Ok(Spectrum {
        strongest: step * (peak.map_or(0, |(k, _)| k) + 1) as f64,
        points: banded(&density, step),
        rms: (square / values.len() as f64).sqrt(),
    })
}

/// Density of the variance at the frequencies `1/(length dt)`, twice that and so on: stretches of so many
/// values.
fn density(values: &[f64], length: usize, dt: f64) -> Vec<f64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    let turn = std::f64::consts::TAU / length as f64;
    let window: Vec<f64> = (0..length).map(|k| 0.5 - 0.5 * libm::cos(turn * k as f64)).collect();
    let weight = window.iter().map(|w| w * w).sum::<f64>();
    let mut all = vec![0.0; output.len() - 1];
    let starts = (0..=values.len() - length).step_by(length / 2);
    let count = starts.clone().count() as f64;
    for start in starts {
        let stretch = &values[start..start + length];
        let mean = stretch.iter().sum::<f64>() / length as f64;
        for ((x, value), w) in input.iter_mut().zip(stretch).zip(&window) {
            *x = (value - mean) * w;
        }
        plan.process(&mut input, &mut output).expect("both have the plan's lengths");
        for (k, (sum, coefficient)) in all.iter_mut().zip(&output[1..]).enumerate() {
            // That at half the rate of rows has no partner.
            let sides = if 2 * (k + 1) == length { 1.0 } else { 2.0 };
            *sum += sides * dt / weight * coefficient.norm_sqr() / count;
        }
    }
    all
}

/// Roots of mean densities in bands of frequency; `step` is the first frequency and the distance of all.
fn banded(density: &[f64], step: f64) -> Vec<(f64, f64)> {
    let mut bands: BTreeMap<i64, (f64, f64, f64)> = BTreeMap::new();
    for (k, value) in (1..).zip(density) {
        let f = step * f64::from(k);
        let band = bands.entry((libm::log2(f) * BANDS).floor() as i64).or_default();
        *band = (band.0 + 1.0, band.1 + f, band.2 + value);
    }
    bands.values().map(|(count, f, sum)| (f / count, (sum / count).sqrt())).collect()
}

/// Spectra of panels, with a line on each curve.
///
/// # Errors
/// The name of a curve, and why it has no spectrum.
pub fn spectra(
    panels: &[Panel],
    interval: [f64; 2],
) -> Result<(Vec<Panel>, Vec<String>), (String, NoSpectrum)> {
    let (mut drawn, mut lines) = (Vec::new(), Vec::new());
    for Panel { title, unit, curves } in panels {
        let mut found = Vec::new();
        for PanelCurve { name, points } in curves {
            let what = if name == title { name.clone() } else { format!("{title}, {name}") };
            let Spectrum { points, rms, strongest } =
                spectrum(points, interval).map_err(|error| (what.clone(), error))?;
            lines.push(format!("{what}: rms {rms:.4e} {unit}, strongest at {strongest:.4e} Hz"));
            found.push(PanelCurve { name: name.clone(), points });
        }
        drawn.push(Panel { title: title.clone(), unit: unit.clone(), curves: found });
    }
    Ok((drawn, lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-5;

    fn rows(count: u32, of: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..count).map(|k| (DT * f64::from(k), of(DT * f64::from(k)))).collect()
    }

    const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Two tones about a mean: the sum over frequencies is the variance, and the stronger tone is found.
    #[test]
    fn the_density_adds_up_to_the_variance() {
        let tone = |f: f64, t: f64| libm::sin(std::f64::consts::TAU * f * t);
        let rows = rows(9000, |t| 7.0 + 3.0 * tone(5e3, t) + 0.5 * tone(20e3, t));
        let found = spectrum(&rows, ALL).unwrap();
        let expected = (4.5_f64 + 0.125).sqrt();
        assert!((found.rms / expected - 1.0).abs() < 1e-3, "{}", found.rms);
        assert!((found.strongest / 5e3 - 1.0).abs() < 0.01, "{}", found.strongest);
        let values: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let sum = density(&values, 2000, DT).iter().sum::<f64>() / (2000.0 * DT);
        assert!((sum.sqrt() / expected - 1.0).abs() < 1e-3, "{}", sum.sqrt());
        assert!(found.points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    /// White noise has the same density everywhere.
    #[test]
    fn noise_without_colour_is_flat() {
        use rand_chacha::ChaCha8Rng;
        use rand_chacha::rand_core::{Rng, SeedableRng};
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut draw = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        let rows: Vec<_> = (0..90_000).map(|k| (DT * f64::from(k), draw())).collect();
        let found = spectrum(&rows, ALL).unwrap();
        let expected = (2.0 * DT / 12.0).sqrt();
        for (f, value) in found.points.iter().filter(|point| point.0 > 1e3) {
            assert!((value / expected - 1.0).abs() < 0.15, "{f} Hz: {value}, not {expected}");
        }
    }

    #[test]
    fn rows_must_be_many_even_and_whole() {
        let few = spectrum(&rows(71, |t| t), ALL).unwrap_err();
        assert_eq!(few, NoSpectrum::Few { rows: 71, least: 72 });
        assert!(spectrum(&rows(72, |t| t), ALL).is_ok());
        let within = spectrum(&rows(9000, |t| t), [0.0, 50.0 * DT]).unwrap_err();
        assert!(matches!(within, NoSpectrum::Few { .. }));
        let mut uneven = rows(200, |t| t);
        uneven[100].0 += 0.3 * DT;
        assert!(matches!(spectrum(&uneven, ALL), Err(NoSpectrum::Uneven { .. })));
        let mut missing = rows(200, |t| t);
        missing[100].1 = f64::NAN;
        assert_eq!(spectrum(&missing, ALL), Err(NoSpectrum::Missing(100.0 * DT)));
    }
}
