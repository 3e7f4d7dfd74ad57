//! `include/tremie.h` is what cbindgen makes of this crate.
//!
//! After a change: `TREMIE_WRITE_HEADER=1 cargo test --release -p tremie-c`.

use std::path::Path;

#[test]
fn the_header_is_that_of_this_crate() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut builder = cbindgen::Builder::new()
        .with_config(cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap())
        .with_src(here.join("../messages/src/body.rs"));
    for file in ["failure", "setup", "description", "state", "fluid", "grains", "observer"] {
        builder = builder.with_src(here.join(format!("src/{file}.rs")));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let path = here.join("include/tremie.h");
    if std::env::var_os("TREMIE_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read(&path).unwrap_or_default();
    assert!(
        kept == made,
        "include/tremie.h is of another version of this crate: \
         TREMIE_WRITE_HEADER=1 cargo test --release -p tremie-c"
    );
}
