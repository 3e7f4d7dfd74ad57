//! Pieces that overlap against formulas and integrals that know nothing of rays: volume, centroid
//! and inertia of their union.

use nalgebra::Matrix3;
use std::f64::consts::PI;
use tremie_geometry::{Convex, Piece, Share, Vec3, shares, solid};

/// Of the union: volume, centroid, inertia about the origin for a density of one.
fn together(shares: &[Share]) -> (f64, Vec3, Matrix3<f64>) {
    let volume: f64 = shares.iter().map(|share| share.volume).sum();
    let centroid: Vec3 = shares.iter().map(|share| share.centroid * share.volume / volume).sum();
    let about_origin = |share: &Share| {
        let Share { volume, centroid: c, inertia } = share;
        let around = Matrix3::from_diagonal_element(c.norm_squared()) - c * c.transpose();
        inertia + around * *volume
    };
    (volume, centroid, shares.iter().map(about_origin).sum())
}

/// The same of spheres along x, given as place and radius, from their cross-sections: discs, the
/// largest of which counts.
fn of_row(balls: &[(f64, f64)]) -> (f64, f64, [f64; 2]) {
    let low = balls.iter().map(|(x, r)| x - r).fold(f64::INFINITY, f64::min);
    let high = balls.iter().map(|(x, r)| x + r).fold(f64::NEG_INFINITY, f64::max);
    let (n, mut sums) = (2_000_000, [0.0; 4]);
    let step = (high - low) / f64::from(n);
    for k in 0..n {
        let x = low + (f64::from(k) + 0.5) * step;
        let square = balls.iter().map(|(c, r)| r * r - (x - c) * (x - c)).fold(0.0, f64::max);
        let area = PI * square * step;
        let more = [area, area * x, area * square / 2.0, area * (square / 4.0 + x * x)];
        sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }
    (sums[0], sums[1] / sums[0], [sums[2], sums[3]])
}

#[track_caller]
fn close(found: f64, expected: f64, scale: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * scale.abs(), "{found} {expected}");
}

/// Dumbbells and chains in closed form, to rounding of the sections; where three overlap, and
/// nested ones, to the tolerance that is stated.
#[test]
fn rows_of_spheres_are_what_their_sections_say() {
    let exact = 1e-9;
    for (row, tolerance) in [
        (&[(0.0, 1.0), (1.2, 0.7)][..], exact),
        (&[(0.0, 1.0), (1.0, 1.0)], exact),
        (&[(0.0, 1.0), (0.8, 0.3)], exact),
        (&[(0.0, 1.0), (0.4, 0.3)], exact),
        (&[(0.0, 1.0), (0.0, 1.0)], exact),
        (&[(0.0, 1.0), (1.5, 0.8), (2.9, 1.1), (6.0, 0.5)], exact),
        (&[(0.0, 1.0), (0.5, 1.0), (1.0, 1.0)], 2e-5),
        (&[(0.0, 1.0), (0.3, 0.5), (0.7, 0.4), (1.1, 0.6)], 2e-5),
        (&[(0.0, 1.0), (0.1, 0.6), (0.2, 0.3)], 2e-5),
    ] {
        // Somewhere, along a line of no distinction.
        let (at, way) = (Vec3::new(0.3, -0.2, 0.4), Vec3::new(2.0, -1.0, 2.0) / 3.0);
        let place = |x: f64| at + way * x;
        let pieces: Vec<Piece> = row.iter().map(|&(x, r)| Piece::ball(place(x), r)).collect();
        let (volume, middle, [along, across]) = of_row(row);
        let (v, c, _) = together(&shares(&pieces));
        close(v, volume, volume, tolerance);
        (0..3).for_each(|a| close(c[a], place(middle)[a], 1.0, 4.0 * tolerance));
        // About the row's own origin, from it.
        let central: Vec<Piece> = row.iter().map(|&(x, r)| Piece::ball(way * x, r)).collect();
        let (_, _, inertia) = together(&shares(&central));
        for a in 0..3 {
            for b in 0..3 {
                let unit = if a == b { 1.0 } else { 0.0 };
                let expected = across * unit + (along - across) * way[a] * way[b];
                close(inertia[(a, b)], expected, across, 5.0 * tolerance);
            }
        }
    }
}

/// The union of points of a fine grid, whatever the pieces are.
fn counted(inside: impl Fn(Vec3) -> bool, low: f64, high: f64) -> f64 {
    let n = 180;
    let step = (high - low) / f64::from(n);
    let at = |k: i32| low + (f64::from(k) + 0.5) * step;
    let mut count = 0;
    for i in 0..n {
        for j in 0..n {
            count += (0..n).filter(|&k| inside(Vec3::new(at(i), at(j), at(k)))).count();
        }
    }
    count as f64 * step.powi(3)
}

#[test]
fn spheres_all_over_each_other_share_what_points_count() {
    let balls =
        [([0.0; 3], 1.0), ([0.9, 0.0, 0.1], 0.8), ([0.3, 0.8, 0.0], 0.9), ([0.2, 0.3, 0.9], 0.5)]
            .map(|(x, r)| (Vec3::from(x), r));
    let pieces = balls.map(|(x, r)| Piece::ball(x, r));
    let found = shares(&pieces);
    let is_in = |p: Vec3, (x, r): (Vec3, f64)| (p - x).norm_squared() < r * r;
    let volume = counted(|p| balls.iter().any(|&ball| is_in(p, ball)), -1.1, 1.8);
    let (v, c, _) = together(&found);
    close(v, volume, volume, 3e-4);
    // A third of what three hold is each one's: the shares of a piece, not only their sum.
    let own = counted(
        |p| is_in(p, balls[3]) && balls[..3].iter().filter(|&&b| is_in(p, b)).count() == 0,
        -1.1,
        1.8,
    ) + (1..4)
        .map(|n| {
            counted(
                |p| is_in(p, balls[3]) && balls[..3].iter().filter(|&&b| is_in(p, b)).count() == n,
                -1.1,
                1.8,
            ) / (n as f64 + 1.0)
        })
        .sum::<f64>();
    close(found[3].volume, own, own, 2e-3);
    // The order is of no account.
    let turned =
        shares(&[pieces[2].clone(), pieces[3].clone(), pieces[0].clone(), pieces[1].clone()]);
    let (w, d, _) = together(&turned);
    close(v, w, v, 1e-12);
    (0..3).for_each(|a| close(c[a], d[a], 1.0, 1e-12));
}

const UPRIGHT: [Vec3; 3] =
    [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];

/// A cube of edge 1 at a place, its axes turned.
fn cube(at: Vec3, axes: [Vec3; 3]) -> Piece {
    let cube = Convex::hull(&solid("cube").unwrap()).unwrap().unit();
    let edge = (PI / 6.0_f64).cbrt();
    Piece::solid(&cube, 1.0 / edge, axes, at)
}

#[test]
fn cubes_and_spheres_are_what_formulas_say() {
    let turned = [Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.8, 0.6, 0.0), Vec3::z()];
    let ball = |r: f64| 4.0 / 3.0 * PI * r * r * r;
    for axes in [UPRIGHT, turned] {
        let to = |v: Vec3| Matrix3::from_columns(&axes) * v;
        for (pieces, volume, middle) in [
            (
                vec![cube(Vec3::zeros(), axes), cube(to(Vec3::new(0.5, 0.0, 0.0)), axes)],
                1.5,
                [0.25, 0.0, 0.0],
            ),
            (
                vec![cube(Vec3::zeros(), axes), cube(to(Vec3::from_element(0.5)), axes)],
                2.0 - 0.125,
                [0.25, 0.25, 0.25],
            ),
            (
                vec![cube(Vec3::zeros(), axes), Piece::ball(to(Vec3::new(0.5, 0.0, 0.0)), 0.4)],
                1.0 + 0.5 * ball(0.4),
                // Of a half ball 3/8 of the radius from its flat side.
                [0.5 * ball(0.4) * (0.5 + 0.15) / (1.0 + 0.5 * ball(0.4)), 0.0, 0.0],
            ),
            (vec![cube(Vec3::zeros(), axes), Piece::ball(Vec3::zeros(), 0.5)], 1.0, [0.0; 3]),
            (vec![cube(Vec3::zeros(), axes), Piece::ball(Vec3::zeros(), 0.9)], ball(0.9), [0.0; 3]),
        ] {
            let (v, c, _) = together(&shares(&pieces));
            close(v, volume, volume, 2e-5);
            (0..3).for_each(|a| close(c[a], to(middle.into())[a], 1.0, 1e-4));
        }
        // What overlaps nothing is what it is, to rounding; and so are equal pieces halves of one.
        let apart = shares(&[cube(Vec3::zeros(), axes), cube(Vec3::new(3.0, 0.0, 0.0), axes)]);
        close(apart[1].volume, 1.0, 1.0, 1e-14);
        close(apart[1].inertia[(2, 2)], 1.0 / 6.0, 1.0, 1e-14);
        let twice = shares(&[cube(Vec3::zeros(), axes), cube(Vec3::zeros(), axes)]);
        close(twice[0].volume, 0.5, 1.0, 2e-5);
        close(twice[0].inertia[(0, 0)], 1.0 / 12.0, 1.0, 1e-5);
    }
}

/// A grain of dust in a boulder: its share is half of it, and it costs the boulder nothing that
/// counts.
#[test]
fn a_small_piece_in_a_large_one_keeps_a_share() {
    let pieces = [
        cube(Vec3::zeros(), UPRIGHT),
        Piece::ball(Vec3::new(0.1, 0.2, 0.3), 1e-3),
        Piece::ball(Vec3::new(0.5, 0.0, 0.0), 0.3),
    ];
    let found = shares(&pieces);
    let (v, ..) = together(&found);
    close(v, 1.0 + 2.0 / 3.0 * PI * 0.027, 1.0, 4e-5);
    assert!(found[1].volume > 0.0 && found[1].volume <= pieces[1].volume());
    assert!(found.iter().flat_map(|share| share.centroid.iter()).all(|x| x.is_finite()));
}
