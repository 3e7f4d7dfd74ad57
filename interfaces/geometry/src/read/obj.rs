//! OBJ files: positions and faces of all objects, as one.

use super::polygon::triangulate;
use super::text::{coordinate, decode, looks_like, quoted};
use crate::{Mesh, Vec3};
use tobj::{LoadError, LoadOptions};

/// The triangles of a file, or why it is none. Materials, normals and textures are passed over, and
/// so are lines and points.
pub fn parse(bytes: &[u8]) -> Result<Mesh, String> {
    let text = decode(bytes);
    if let Some(what) = looks_like(bytes).filter(|what| !what.starts_with("an OBJ")) {
        return Err(format!("it looks like {what}"));
    }
    let options = LoadOptions { ignore_lines: true, ignore_points: true, ..LoadOptions::default() };
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials)
        .map_err(|error| wrong_line(&text).unwrap_or_else(|| error.to_string()))?;
    let mut mesh = Mesh::default();
    for model in models {
        append(&mut mesh, &model.mesh)?;
    }
    Ok(mesh)
}

/// The first line with a corner that is none, which the library does not tell.
fn wrong_line(text: &str) -> Option<String> {
    let mut corners = 0i64;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let why = match words.next() {
            Some("v") => {
                corners += 1;
                let mut numbers = words.take(3).map(coordinate);
                let wrong = numbers.find_map(Result::err);
                wrong.or_else(|| {
                    (line.split_ascii_whitespace().count() < 4)
                        .then(|| "expected three numbers".into())
                })
            }
            Some("f") => words.find_map(|word| {
                let index = word.split('/').next().unwrap_or("").parse::<i64>();
                match index {
                    Ok(index) if index != 0 && index.unsigned_abs() <= corners.unsigned_abs() => {
                        None
                    }
                    Ok(_) => {
                        Some(format!("corner {} is not among the {corners} before", quoted(word)))
                    }
                    Err(_) => Some(format!("{} names no corner", quoted(word))),
                }
            }),
            _ => None,
        };
        if let Some(why) = why {
            return Some(format!("line {}: {}: {why}", number + 1, quoted(line)));
        }
    }
    None
}

/// Adds an object's faces. Objects share no vertices here; those at one place are welded later.
fn append(mesh: &mut Mesh, object: &tobj::Mesh) -> Result<(), String> {
    let points: Vec<Vec3> = object.positions.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let first = mesh.vertices.len();
    u32::try_from(first + points.len())
        .map_err(|_| "it has more vertices than 32-bit numbers can tell apart".to_string())?;
    let mut rest = object.indices.as_slice();
    let mut arities = object.face_arities.iter();
    while !rest.is_empty() {
        // No numbers of corners at all means three for each.
        let corners = arities.next().map_or(3, |&n| n as usize).clamp(1, rest.len());
        let (face, others) = rest.split_at(corners);
        rest = others;
        let places: Vec<Vec3> = face.iter().map(|&v| points[v as usize]).collect();
        for triangle in triangulate(&places) {
            mesh.triangles.push(triangle.map(|i| first as u32 + face[i]));
        }
    }
    mesh.vertices.extend(points);
    Ok(())
}
