//! The domain as a whole number of cells.

use tremie_messages::Problem;
use tremie_messages::scene::Domain;

/// Cells of an edge [m] along each axis of a domain, with a problem of the parameter `cell` for
/// each edge of the domain that is not a whole number of them.
pub fn whole_cells(domain: &Domain, cell: f64, problems: &mut Vec<Problem>) -> [usize; 3] {
    let size = domain.size();
    let common = common_cell(size, cell);
    std::array::from_fn(|axis| {
        let exact = size[axis] / cell;
        let whole = exact.round().max(1.0);
        if (exact - whole).abs() > 1e-6 * whole {
            let below = size[axis] / exact.ceil().max(1.0);
            let above = size[axis] / exact.floor().max(1.0);
            problems.push(
                Problem::of_parameter(
                    "cell",
                    format!(
                        "the domain is {} m along {}, {exact:.4} cells of {} m; it must be a whole number",
                        size[axis],
                        ["x", "y", "z"][axis],
                        cell
                    ),
                )
                .help(match common {
                    Some(cell) => format!("a cell of {cell:.9e} m fits all edges"),
                    None => format!(
                        "the nearest cells that fit this edge are {below:.6e} m and {above:.6e} m"
                    ),
                }),
            );
        }
        // A lattice that cannot exist is refused by its memory; the cast saturates.
        whole as usize
    })
}

/// The cell nearest to `wanted` of which all edges of a box are whole numbers, within a factor of
/// two; `None` if there is none.
pub fn common_cell(size: [f64; 3], wanted: f64) -> Option<f64> {
    let shortest = size.into_iter().fold(f64::INFINITY, f64::min);
    let (fewest, most) = (0.5 * shortest / wanted, 2.0 * shortest / wanted);
    if most > 1e5 {
        return None;
    }
    let fits = |cell: &f64| {
        size.iter().all(|edge| {
            let exact = edge / cell;
            (exact - exact.round()).abs() <= 1e-9 * exact
        })
    };
    let off = |cell: &f64| (cell / wanted).ln().abs();
    ((fewest.ceil().max(1.0) as u32)..=(most as u32))
        .map(|count| shortest / f64::from(count))
        .filter(fits)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_for_all_edges_is_the_nearest_that_fits_each() {
        // 4 mm divides all edges, so do its parts: 4/7 and 4/6 mm are the nearest.
        let found = common_cell([0.044, 0.028, 0.06], 0.6e-3).unwrap();
        assert!((found - 4e-3 / 7.0).abs() < 1e-12, "{found}");
        assert_eq!(common_cell([1.0, std::f64::consts::SQRT_2, 1.0], 0.1), None);
        assert_eq!(common_cell([1.0, 1.0, 1e9], 1e-12), None);
    }
}
