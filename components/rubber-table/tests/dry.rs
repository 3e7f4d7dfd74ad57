//! A valve with a rubber ring comes down on twelve spheres (Mutabaruka and Kamrin, Fig. 11): 40 N
//! for 5 ms, then 10 N.

mod common;

use common::{RUBBER, linear, model, press, ring};
use tremie_geometry::Vec3;
use tremie_rubber_table::fem::Hold;
use tremie_rubber_table::fem::contact::Seat;
use tremie_rubber_table::make::tabulate;
use tremie_rubber_table::mesh::Point;
use tremie_rubber_table::runtime::{
    Eta, Form, Impedance, Law, Outcome, Settled, Start, Step, StepError, effective_force, relax,
};
use tremie_rubber_table::table::{Bracket, FacetKind, Surface, Table};

const MASS: f64 = 9.2e-3;
const DT: f64 = 1e-7;
/// Of each of the twelve.
const SPHERE_STIFFNESS: f64 = 1e5;
const CONTACTS: f64 = 12.0 * SPHERE_STIFFNESS;

/// The ring of the valve.
fn finite_elements() -> Table {
    let model = model(ring([6, 4]), RUBBER, &[Hold::bonded("top")], Some(Seat::flat(0.0)));
    tabulate(&model, &press(&model, 0.6e-3, 41), 0.6e-3, "test".into(), None).unwrap()
}

/// A row for each step.
#[derive(Debug)]
struct Row {
    force: f64,
    rubber: f64,
    settled: Settled,
}

/// The valve at `height`, pushed down by `load`; `contact` gives the force on the ring.
fn drop_valve(
    table: &Table,
    law: Law,
    steps: usize,
    mut contact: impl FnMut(f64, Bracket) -> f64,
) -> Vec<Row> {
    let (mut height, mut speed) = (0.0, 0.0);
    let mut settled = Settled { compression: 0.0, rate: 0.0, passes: 0 };
    let mut rows = Vec::new();
    for step in 0..steps {
        let load = if step < 50_000 { 40.0 } else { 10.0 };
        let start = Start {
            compression: settled.compression,
            rate: settled.rate,
            dt: DT,
            contact_stiffness: CONTACTS,
            impedance: Impedance::default(),
        };
        settled = relax(table, law, start, |at| contact(height, at)).unwrap();
        let at = table.bracket(settled.compression).unwrap();
        let force = contact(height, at);
        speed += (force - load) / MASS * DT;
        height += speed * DT;
        rows.push(Row { force, rubber: table.force(at), settled });
    }
    rows
}

/// Twelve springs below a flat foot.
fn springs(table: &Table) -> impl Fn(f64, Bracket) -> f64 {
    let spacing = table.contents().compressions[1];
    move |height, at| {
        let compression = (at.frame as f64 + at.weight) * spacing;
        CONTACTS * (-(height + compression)).max(0.0)
    }
}

/// Time [ms] at which `rubber` has gone a share of its way from `from` to `to` [N].
fn time_of(rows: &[Row], from: f64, to: f64, share: f64) -> f64 {
    let gone = |row: &Row| (row.rubber - from) / (to - from) >= share;
    1e3 * DT * (1 + rows.iter().position(gone).unwrap()) as f64
}

/// An independent calculation of the same system gave these numbers.
#[test]
fn a_linear_ring_relaxes_as_calculated() {
    let table = linear(1.194e5);
    let law = Law { eta: Eta::Fixed(10.0), ..Law::default() };
    let rows = drop_valve(&table, law, 100_000, springs(&table));
    let (loaded, unloaded) = rows.split_at(50_000);
    for (share, expected) in [(0.63, 0.670), (0.95, 1.73), (0.99, 2.58)] {
        let found = time_of(loaded, 0.0, 40.0, share);
        assert!((found / expected - 1.0).abs() < 0.01, "{share}: {found} ms");
    }
    assert!((loaded[49_999].rubber - 39.996).abs() < 0.002, "{}", loaded[49_999].rubber);
    assert!((loaded[49_999].settled.compression - 0.335e-3).abs() < 0.001e-3);
    let peak = loaded.iter().map(|row| row.force).fold(0.0, f64::max);
    assert!((peak - 48.0).abs() < 0.5, "{peak} N");
    let found = time_of(unloaded, 40.0, 10.0, 0.63);
    assert!((found / 0.670 - 1.0).abs() < 0.01, "{found} ms");
    let last = &unloaded[49_999];
    assert!((last.settled.compression - 0.084e-3).abs() < 0.001e-3);
    assert!((last.force - 10.0).abs() < 0.01 && (last.rubber - 10.0).abs() < 0.01);
    // What is lost over the way goes into the damping.
    let mut work = [0.0; 2];
    let mut before = 0.0;
    for row in &rows {
        let moved = row.settled.compression - before;
        work[0] += (row.force - row.rubber) * moved;
        work[1] += 80.0 * row.settled.rate * moved;
        before = row.settled.compression;
    }
    assert!(work[0] > 0.0 && (work[0] / work[1] - 1.0).abs() < 1e-6, "{work:?}");
}

/// Spheres of the grains, in the middle of each of twelve sectors at a radius of 8.75 mm.
struct Spheres {
    surface: Surface,
    foot: Vec<[usize; 2]>,
    section: Vec<Point>,
    places: Vec<Vec3>,
    loads: Vec<Vec3>,
}

impl Spheres {
    fn new(table: &Table) -> Self {
        let surface = table.surface(12);
        let section = table.contents().vertices[0].clone();
        let places = surface.places(&section);
        let loads = vec![Vec3::zeros(); surface.triangles.len()];
        Self { surface, foot: table.contents().facets.seat.clone(), section, places, loads }
    }

    /// Twelve pushes on the facets above the spheres, and their effective force.
    fn force(&mut self, table: &Table, height: f64, at: Bracket) -> f64 {
        const RADIUS: f64 = 8.75e-3;
        table.vertices_into(at, &mut self.section);
        self.surface.place_into(&self.section, &mut self.places);
        let spans = |edge: &[usize; 2]| {
            let [a, b] = edge.map(|vertex| self.section[vertex][0]);
            a <= RADIUS && RADIUS < b
        };
        let piece = self.foot.iter().position(spans).unwrap();
        let [a, b] = self.foot[piece].map(|vertex| self.section[vertex]);
        let foot = a[1] + (b[1] - a[1]) * (RADIUS - a[0]) / (b[0] - a[0]);
        let push = SPHERE_STIFFNESS * (-(height + foot)).max(0.0);
        self.loads.fill(Vec3::zeros());
        for sector in 0..12 {
            // Two triangles for each sector of each piece of the foot.
            self.loads[2 * (12 * piece + sector)] = Vec3::z() * push;
        }
        effective_force(Form::Axial, &self.surface, &self.places, &self.loads).force
    }
}

#[test]
fn the_valves_ring_finds_its_load_both_ways() {
    let table = finite_elements();
    let mut spheres = Spheres::new(&table);
    assert_eq!(spheres.surface.kinds[2 * 12 * 6 - 1], FacetKind::Seat);
    let law = Law { eta: Eta::Fixed(10.0), ..Law::default() };
    let rows = drop_valve(&table, law, 100_000, |height, at| spheres.force(&table, height, at));
    let (loaded, unloaded) = rows.split_at(50_000);
    for (rows, load, compression) in [(loaded, 40.0, 0.313e-3), (unloaded, 10.0, 0.087e-3)] {
        let last = &rows[49_999];
        assert!((last.force / load - 1.0).abs() < 2e-3, "{} N of {load}", last.force);
        assert!((last.rubber / load - 1.0).abs() < 2e-3, "{} N of {load}", last.rubber);
        assert!((last.settled.compression / compression - 1.0).abs() < 0.03, "{last:?}");
    }
    // Damping over slope, the secant's from rest to the load.
    let slope = 40.0 / loaded[49_999].settled.compression;
    let found = 1e-3 * time_of(loaded, 0.0, 40.0, 1.0 - libm::exp(-1.0));
    assert!((found * slope / 80.0 - 1.0).abs() < 0.1, "{found} s, {}", 80.0 / slope);
    let mean = rows.iter().map(|row| f64::from(row.settled.passes)).sum::<f64>() / 1e5;
    assert!((9.0..11.0).contains(&mean), "{mean} passes");
}

#[test]
fn passes_grow_with_the_digits_asked_for() {
    let table = linear(1.194e5);
    for (tolerance, expected) in [(1e-4, 6.0), (1e-8, 10.0), (1e-10, 11.9)] {
        let law = Law { eta: Eta::Fixed(10.0), tolerance, ..Law::default() };
        let rows = drop_valve(&table, law, 20_000, springs(&table));
        let mean = rows.iter().map(|row| f64::from(row.settled.passes)).sum::<f64>() / 2e4;
        assert!((mean - expected).abs() < 0.5, "{tolerance}: {mean} passes");
    }
}

/// A step in full contact: the foot is 40 um deep in the spheres.
fn contact(at: Bracket) -> f64 {
    let compression = (at.frame as f64 + at.weight) * 0.3e-3;
    CONTACTS * (140e-6 - compression).max(0.0)
}

const START: Start = Start {
    compression: 100e-6,
    rate: 0.0,
    dt: DT,
    contact_stiffness: CONTACTS,
    impedance: Impedance(0.0),
};

#[test]
fn the_end_of_a_step_does_not_depend_on_eta() {
    let table = linear(1.194e5);
    let (k, h, d0) = (CONTACTS, 1.194e5, 100e-6);
    // k (140 um - d) = h d + nu (d - d0)/dt.
    let exact = (k * 140e-6 + 80.0 / DT * d0) / (k + h + 80.0 / DT);
    for eta in [Eta::Fixed(1.0), Eta::Fixed(10.0), Eta::Fixed(100.0), Eta::AtLeast(0.0)] {
        let law = Law { eta, tolerance: 1e-10, ..Law::default() };
        let found = relax(&table, law, START, contact).unwrap().compression;
        assert!((found - exact).abs() < 2e-15, "{eta:?}: {found} {exact}");
    }
}

#[test]
fn errors_shrink_by_the_factor_of_theory() {
    let table = linear(1.194e5);
    for (eta, damping) in [(10.0, 80.0), (50.0, 80.0), (1.0, 2.0)] {
        let law = Law { eta: Eta::Fixed(eta), damping, ..Law::default() };
        let mut step = Step::begin(&table, law, START).unwrap();
        let mut trials = vec![step.trial()];
        while step.pass(&table, contact(step.bracket())).unwrap() == Outcome::Again
            && trials.len() < 5
        {
            trials.push(step.trial());
        }
        let factor = (trials[3] - trials[2]) / (trials[2] - trials[1]);
        let expected = (eta - (CONTACTS + 1.194e5) * DT) / (eta + damping);
        assert!((factor / expected - 1.0).abs() < 0.05, "{eta}: {factor} {expected}");
    }
}

/// A grain's contact pushes with its dashpot up to the end: where it opens in the trials of a step,
/// the force jumps. No pass of a fixed size settles on the place where the ring just touches the
/// grain; whether that retreats or comes down.
#[test]
fn a_contact_that_opens_within_a_step_is_found_where_it_opens() {
    let table = linear(1.194e5);
    let (spring, dashpot, approach) = (1e6, 1.9, 1.5);
    // A grain is so deep in the foot at the start, and pushes away from others' 10 N.
    for depth in [1e-13, 1e-11, 1e-9, 3e-9, 1e-8, -1e-9, -1e-11] {
        let contact = |at: Bracket| {
            let retreat = (at.frame as f64 + at.weight) * 0.3e-3 - START.compression;
            let (overlap, speed) = (depth - retreat, approach - retreat / DT);
            let pushes = if overlap > 0.0 { spring * overlap + dashpot * speed } else { 0.0 };
            11.5 + pushes.max(0.0)
        };
        let start = Start { contact_stiffness: spring + dashpot / DT, ..START };
        let found = relax(&table, Law::default(), start, contact).unwrap();
        let excess = |away: f64| {
            let d = found.compression + away;
            let at = table.bracket(d).unwrap();
            contact(at) - table.force(at) - 80.0 * (d - START.compression) / DT
        };
        // The excess changes its sign here, by a jump or without.
        assert!(excess(-5e-15) > 0.0 && excess(5e-15) < 0.0, "{depth}: {found:?}");
        assert!(found.passes <= 60, "{depth}: {found:?}");
        if depth > 1e-8 {
            assert!(found.passes <= 4, "{depth}: {found:?}");
        }
    }
    // The repetition with one eta goes to and fro.
    let flickers = |at: Bracket| {
        let retreat = (at.frame as f64 + at.weight) * 0.3e-3 - START.compression;
        11.94 + if retreat < 1e-9 { dashpot * approach } else { 0.0 }
    };
    let fixed = Law { eta: Eta::Fixed(10.0), ..Law::default() };
    assert!(matches!(relax(&table, fixed, START, flickers), Err(StepError::NotSettled { .. })));
    let found = relax(&table, Law::default(), START, flickers).unwrap();
    assert!((found.compression - START.compression - 1e-9).abs() < 2e-15, "{found:?}");
}

/// A grain at the foot's rim counts with the foot or with the side: whichever a trial says, a step
/// ends.
#[test]
fn a_contact_that_changes_its_facet_does_not_end_a_run() {
    let table = linear(1.194e5);
    for jump in [-7.0, 7.0] {
        for at_least in [-1e-9, 0.0, 1e-13, 1e-10, 1e-9] {
            let contact = |at: Bracket| {
                let retreat = (at.frame as f64 + at.weight) * 0.3e-3 - START.compression;
                60.0 + if retreat > at_least { jump } else { 0.0 }
            };
            let start = Start { contact_stiffness: 1e6, ..START };
            let found = relax(&table, Law::default(), start, contact).unwrap();
            let by = |force: f64| (force - 11.94) / (80.0 / DT + 1.194e5);
            let retreat = found.compression - START.compression;
            let ends = [by(60.0), by(60.0 + jump), at_least];
            assert!(ends.iter().any(|end| (retreat - end).abs() < 2e-15), "{jump} {found:?}");
        }
    }
}

/// Ten thousand vertices of 1e6 N/m each, and no damping: a fixed eta fails, one that adapts does
/// not.
#[test]
fn an_eta_that_adapts_settles_whatever_the_contacts() {
    let table = linear(1.194e5);
    let stiffness = 1e10;
    let contact =
        |at: Bracket| stiffness * (100.1e-6 - (at.frame as f64 + at.weight) * 0.3e-3).max(0.0);
    let start = Start { contact_stiffness: stiffness, ..START };
    for damping in [0.0, 80.0] {
        let fixed = Law { eta: Eta::Fixed(10.0), damping, ..Law::default() };
        let error = relax(&table, fixed, start, contact).unwrap_err();
        assert!(matches!(error, StepError::NotSettled { passes: 100, .. }), "{error}");
        let law = Law { damping, ..Law::default() };
        let found = relax(&table, law, start, contact).unwrap();
        let residual = contact(table.bracket(found.compression).unwrap())
            - table.force(table.bracket(found.compression).unwrap())
            - damping * found.rate;
        assert!(residual.abs() < 1e-3 && found.passes < 30, "{residual} N, {found:?}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let table = linear(1.194e5);
    let law = Law::default();
    // Faster than damping holds it.
    let pulled = |at: Bracket| 1e9 * ((at.frame as f64 + at.weight) * 0.3e-3 - 60e-6);
    let start = Start { contact_stiffness: 1e9, ..START };
    let error = relax(&table, law, start, pulled).unwrap_err();
    assert!(matches!(error, StepError::WrongSign { .. }), "{error}");
    let error = relax(&table, law, START, |_| f64::NAN).unwrap_err();
    assert!(matches!(error, StepError::NotFinite { .. }), "{error}");
    let error = relax(&table, law, Start { dt: 1.0, ..START }, |_| 1e3).unwrap_err();
    assert!(matches!(error, StepError::Beyond(_)), "{error}");
    // Pulled away from the seat, it rests.
    let resting = relax(&table, law, Start { compression: 0.0, ..START }, |_| -5.0).unwrap();
    assert_eq!((resting.compression, resting.rate), (0.0, 0.0));
}

/// A ring out of contact, whose load follows its own motion one exchange late, as a fluid's does:
/// with the impedance alone it comes to rest.
#[test]
fn impedance_keeps_a_ring_in_a_fluid_stable() {
    let table = linear(1.194e5);
    let (impedance, pressure) = (617.0, 12.0);
    let swing = |z: f64| {
        let mut now = Settled { compression: 50e-6, rate: 0.0, passes: 0 };
        let mut rates = vec![0.0; 1];
        for _ in 0..60_000 {
            // The fluid pushes back on the rate of the exchange before.
            let load = pressure - impedance * rates[rates.len() - 1];
            let start = Start {
                compression: now.compression,
                rate: now.rate,
                dt: 4e-7,
                contact_stiffness: 0.0,
                impedance: Impedance(z),
            };
            match relax(&table, Law::default(), start, |_| load) {
                Ok(settled) => now = settled,
                Err(_) => return f64::INFINITY,
            }
            rates.push(now.rate);
        }
        let tail = &rates[rates.len() - 100..];
        tail.iter().fold(0.0f64, |a, rate| a.max(rate.abs()))
    };
    let fluid = Impedance::of_fluid(1000.0, 2500.0, impedance / 2.5e6, 0.0, 1.0);
    assert!((fluid.0 - impedance).abs() < 1e-9);
    assert!(swing(0.0) > 0.1, "without it, the ring shakes or leaves the table");
    assert!(swing(fluid.0) < 1e-3, "with it, it rests");
}
