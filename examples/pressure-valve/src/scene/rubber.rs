//! The rubber ring: specification of its table, and its rest on the seat.

use super::dimensions::Dimensions;
use super::text::mm;
use super::working::Working;
use std::f64::consts::PI;
use tremie_rubber_table::table::Table;

/// The specification of the ring's table, for `tremie rubber make-table`. Rubber as Mutabaruka and
/// Kamrin state it; compressed by up to three tenths of its height: a very viscous fluid does by
/// more than a fifth. Its inner side lies against the hub.
pub fn specification(valve: &Dimensions) -> String {
    format!(
        r#"# The rubber ring of the valve. After a change: tremie rubber make-table ring.toml

[section.rectangle]
inner_radius = "{inner} mm"
outer_radius = "{outer} mm"
height = "{height} mm"
elements = [9, 6]

[rubber]
shear_modulus = "0.3 MPa"
bulk_modulus = "8 MPa"

[carrier]
bonded = ["top"]
guided = ["inner"] # along the hub

[table]
compression = "{compression} mm"
frames = 61
"#,
        inner = mm(valve.rubber_inner_radius.0),
        outer = mm(valve.rubber_outer_radius.0),
        height = mm(valve.rubber_height.0),
        compression = mm(0.3 * valve.rubber_height.0),
    )
}

/// A ring at rest on its seat, under spring and outlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resting {
    /// Compression [m].
    pub compression: f64,
    /// Lift of the valve [m].
    pub lift: f64,
}

impl Resting {
    /// Compression at which the table's force balances the closing force; `None` if there is none,
    /// or only with metal on metal. The seat is as stiff as the usual `seat_stiffness` makes it: a
    /// hundred times the ring's stiffness at first, over the foot's area at rest.
    pub fn of(valve: &Dimensions, run: &Working, table: &Table) -> Option<Self> {
        let pressing = run.closing_force(valve);
        // Bisection: the table's force ascends with the compression.
        let (mut low, mut high) = (0.0, table.last_compression());
        if table.force(table.bracket(high).ok()?) < pressing {
            return None;
        }
        while high - low > 1e-9 * table.last_compression() {
            let middle = 0.5 * (low + high);
            match table.force(table.bracket(middle).ok()?) < pressing {
                true => low = middle,
                false => high = middle,
            }
        }
        // The foot widens as it is pressed, and a wider foot sinks less into its seat.
        let wider = foot(table, high)? / foot(table, 0.0)?;
        let depth = 0.01 * pressing / table.slope(table.bracket(0.0).ok()?) / wider;
        let lift = valve.lip.0 - high - depth;
        (lift >= 0.0).then_some(Self { compression: high, lift })
    }
}

/// Area of a flat foot [m²].
fn foot(table: &Table, compression: f64) -> Option<f64> {
    let points = table.vertices(table.bracket(compression).ok()?);
    let radii =
        table.contents().facets.seat.iter().map(|edge| edge.map(|vertex| points[vertex][0]));
    Some(radii.map(|[a, b]| PI * (a * a - b * b).abs()).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use tremie_rubber_table::make::make;
    use tremie_rubber_table::spec::Spec;

    fn table_of(text: String) -> Table {
        make(&Spec::parse(Path::new("ring.toml"), text).unwrap()).unwrap()
    }

    fn table(valve: &Dimensions) -> Table {
        table_of(specification(valve))
    }

    /// Forces of the same elements with a free inner side in an independent program, 57.52 N at
    /// 0.42 mm and 67.76 N at 0.48 mm: 61.46 N between them. One that the hub guides is compressed
    /// by 5 to 10 % less.
    #[test]
    fn a_ring_rests_where_its_force_is_that_of_spring_and_outlet() {
        let (valve, run) = (Dimensions::default(), Working::default());
        let guided = specification(&valve);
        let free = guided.replace("guided = [\"inner\"] # along the hub\n", "");
        assert_ne!(free, guided);
        let rest = Resting::of(&valve, &run, &table_of(free)).unwrap();
        let expected = 0.42e-3 + 0.06e-3 * (61.46 - 57.52) / (67.76 - 57.52);
        assert!((rest.compression / expected - 1.0).abs() < 2e-3, "{rest:?}, {expected}");
        // The seat gives way by 61.46 N over a hundred times 1.117e5 N/m, and less, as the foot is
        // wider.
        let depth = 0.48e-3 - rest.compression - rest.lift;
        assert!((4e-6..5.5e-6).contains(&depth), "{rest:?}");
        let held = Resting::of(&valve, &run, &table(&valve)).unwrap();
        let less = 1.0 - held.compression / rest.compression;
        assert!((0.05..0.1).contains(&less), "{less}");
    }

    #[test]
    fn a_ring_too_weak_for_the_spring_rests_nowhere() {
        let valve =
            Dimensions { lip: tremie_messages::units::Length(0.4e-3), ..Default::default() };
        assert_eq!(Resting::of(&valve, &Working::default(), &table(&valve)), None);
        let strong =
            Working { spring_preload: tremie_messages::units::Length(0.3), ..Working::default() };
        let usual = Dimensions::default();
        assert_eq!(Resting::of(&usual, &strong, &table(&usual)), None);
    }
}
