//! Coefficient of restitution and damping ratio of a linear spring and dashpot.
//!
//! The damping ratio is `zeta = gamma / (2 sqrt(k m*))` with the reduced mass `m*`. The bilateral
//! contact lets the dashpot pull until the overlap is gone (Goetsch, thesis, 2015, Eq. 3.10);
//! the contact without tension ends when the force vanishes (Schwager & Pöschel, *Granular Matter*
//! 9, 2007).

use core::f64::consts::PI;

/// Restitution of a collision with damping ratio `zeta >= 0`, with or without `tension`.
pub fn restitution(zeta: f64, tension: bool) -> f64 {
    if tension {
        return if zeta >= 1.0 { 0.0 } else { libm::exp(-PI * zeta / (1.0 - zeta * zeta).sqrt()) };
    }
    let w2 = 1.0 - zeta * zeta;
    let w = w2.abs().sqrt();
    if w < 1e-6 {
        return libm::exp(-2.0); // the limit from both sides
    }
    let phase = if w2 > 0.0 {
        libm::atan2(2.0 * zeta * w, zeta * zeta - w2)
    } else {
        // ln((zeta + w)/(zeta - w)), without the cancellation of its denominator
        2.0 * libm::log(zeta + w)
    };
    libm::exp(-(zeta / w) * phase)
}

/// Damping ratio that gives the restitution `e` in (0, 1], with or without `tension`.
pub fn damping_ratio(e: f64, tension: bool) -> f64 {
    if tension {
        let ln_e = libm::log(e);
        return -ln_e / (PI * PI + ln_e * ln_e).sqrt();
    }
    let mut low = 0.0;
    let mut high = 1.0;
    while restitution(high, false) > e {
        low = high;
        high *= 2.0;
    }
    // Bisection: restitution falls steadily with zeta; ends when no number lies between.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return if e == 1.0 { 0.0 } else { middle };
        }
        if restitution(middle, false) > e {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restitution_has_the_tabulated_values() {
        let table = [
            (0.3, true, 0.3723),
            (0.3, false, 0.4510),
            (0.8, true, 0.0152),
            (0.8, false, 0.1798),
            (1.5, false, 0.0756),
        ];
        for (zeta, tension, e) in table {
            assert!((restitution(zeta, tension) - e).abs() < 1e-4, "{zeta}");
        }
    }

    #[test]
    fn restitution_is_continuous_where_its_formula_changes() {
        for zeta in [core::f64::consts::FRAC_1_SQRT_2, 1.0] {
            let jump = restitution(zeta - 1e-9, false) - restitution(zeta + 1e-9, false);
            assert!(jump.abs() < 1e-5, "{zeta}: {jump}");
        }
    }

    #[test]
    fn damping_ratio_inverts_restitution() {
        for tension in [true, false] {
            for e in [1e-6, 0.01, 0.1, 0.2, 0.5, 0.9, 0.999, 1.0] {
                let zeta = damping_ratio(e, tension);
                assert!((restitution(zeta, tension) - e).abs() < 1e-9 + 1e-5 * e * e);
            }
        }
        assert_eq!(damping_ratio(1.0, false), 0.0);
    }
}
