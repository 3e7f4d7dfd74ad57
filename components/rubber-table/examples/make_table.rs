//! Makes a table from a specification, and its pictures beside it: `make_table SPEC TABLE.json`.

use std::path::Path;
use tremie_rubber_table::{make::make, picture, spec::Spec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, spec, out] = &arguments[..] else {
        return Err("usage: make_table SPEC TABLE.json".into());
    };
    let out = Path::new(out);
    let table = make(&Spec::read(Path::new(spec))?)?;
    table.write(out)?;
    picture::draw_force(&table, &out.with_extension("force.svg"))?;
    picture::draw_shapes(&table, &out.with_extension("shapes.svg"))?;
    let last = table.frames() - 1;
    println!(
        "{} frames, {:.4} N at {:.4} mm",
        table.frames(),
        table.contents().forces[last],
        1e3 * table.last_compression()
    );
    Ok(())
}
