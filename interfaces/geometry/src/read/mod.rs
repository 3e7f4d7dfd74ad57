//! Triangles from files, in the file's unit, as they are.

mod obj;
mod polygon;
mod stl;
mod stl_text;
mod text;

pub use polygon::triangulate;

use crate::{GeometryError, Mesh};
use std::path::Path;

/// The triangles of an STL or OBJ file, told apart by the name's ending.
pub fn read(path: &Path) -> Result<Mesh, GeometryError> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let format = match ending.as_str() {
        "stl" => "STL",
        "obj" => "OBJ",
        _ => {
            let why = "its name ends neither in .stl nor in .obj".to_string();
            return Err(wrong(path, "STL or OBJ", why));
        }
    };
    let bytes = std::fs::read(path).map_err(|e| GeometryError::Read {
        path: path.display().to_string(),
        why: e.to_string(),
    })?;
    let mesh = if format == "STL" { stl::parse(&bytes) } else { obj::parse(&bytes) };
    mesh.map_err(|why| wrong(path, format, why))
}

fn wrong(path: &Path, format: &'static str, why: String) -> GeometryError {
    GeometryError::Format { path: path.display().to_string(), format, why }
}
