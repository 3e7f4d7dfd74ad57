//! Rough walls of hoppers: a hexagonal layer of spheres, bent along the leaning walls and those of
//! the channel above.
//!
//! Rows run through the depth. In the plane of the hopper their centres lie on a line half a
//! diameter behind the wall, `sqrt(3)/2` diameters from one row to the next, also around the corner;
//! every second row is shifted by half a sphere. The first one leaves the slit as wide as it is.
//! Where a depth holds no whole number of spheres they stand a little apart along their rows.

use super::super::read::Findings;
use super::hoppers::Hopper;
use tremie_messages::scene::{Domain, Sphere};

/// Most spheres on the walls of a hopper: they are listed one by one.
const MOST: f64 = 1e6;
/// Part of a spacing that counts as none: rounding.
const ROUNDING: f64 = 1e-9;

/// The spheres on both sides, row by row from the slit on.
pub(super) fn spheres(
    hopper: &Hopper,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> Option<Vec<Sphere>> {
    let (diameter, depth) = (hopper.diameter, hopper.axes[2]);
    let [from, length] = [domain.min[depth], domain.size()[depth]];
    let plane = domain.across.is_some();
    let step = if plane { diameter } else { 0.75_f64.sqrt() * diameter };
    let in_row = if plane { 1.0 } else { (length / diameter + ROUNDING).floor() };
    let path = hopper.half_width + hopper.height + hopper.half_width * hopper.sine / hopper.cosine;
    let count = 2.0 * in_row * (path / step + 1.0);
    if count > MOST {
        let message =
            format!("makes up to {count:.3e} spheres on its walls, expected {MOST:e} at most");
        let help = "make the spheres larger, or the height of the walls smaller";
        findings.problem_with_help(&format!("{at}.rough"), message, help);
        return None;
    }
    let pitch = length / in_row;
    let mut spheres = Vec::with_capacity(count as usize);
    for (row, [a, h]) in rows(hopper, step).into_iter().enumerate() {
        let shifted = row % 2 == 1 && !plane;
        let last = in_row as usize - usize::from(shifted && !domain.is_periodic(depth));
        let shift = if shifted && !domain.is_periodic(depth) { 1.0 } else { 0.5 };
        // Across a periodic face rows go on: the shifted one begins on it.
        let shift = if shifted && domain.is_periodic(depth) { 0.0 } else { shift };
        for (side, k) in [-1.0, 1.0].into_iter().flat_map(|s| (0..last).map(move |k| (s, k))) {
            spheres.push(Sphere {
                position: hopper.place([side * a, h], from + pitch * (k as f64 + shift)),
                diameter,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
            });
        }
    }
    Some(spheres)
}

/// Centres of the rows on one side, `step` from each other [m].
fn rows(hopper: &Hopper, step: f64) -> Vec<[f64; 2]> {
    let Hopper { sine, cosine, half_slit, half_width, height, diameter, .. } = *hopper;
    let radius = 0.5 * diameter;
    let on_slope = |t: f64| [half_slit + radius * sine + t * cosine, t * sine - radius * cosine];
    let (first, channel) = (radius * (1.0 - sine) / cosine, half_width + radius);
    let corner = (channel - half_slit - radius * sine) / cosine;
    let slack = ROUNDING * step;
    let mut rows = Vec::new();
    let on_it = ((corner - first) / step + ROUNDING).floor().max(0.0) as usize;
    rows.extend((0..=on_it).map(|k| on_slope(first + step * k as f64)));
    let [a, h] = on_slope(first + step * on_it as f64);
    let beside = (channel - a).clamp(0.0, step);
    let mut next = h + (step * step - beside * beside).sqrt();
    while next + radius <= height + slack {
        rows.push([channel, next]);
        next += step;
    }
    rows
}
