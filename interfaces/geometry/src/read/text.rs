//! Text as programs write it: any encoding of letters, any ends of lines.

use std::borrow::Cow;

/// Longest part of a line that an error quotes.
const QUOTED: usize = 60;

/// The text of a file. Marks of its encoding are taken away and UTF-16 is read; letters of other
/// encodings, which stand in names only, become some sign. Lines that end as on an old Macintosh
/// end as others do.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let text = match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => String::from_utf8_lossy(rest),
        [0xFF, 0xFE, rest @ ..] => Cow::Owned(wide(rest, u16::from_le_bytes)),
        [0xFE, 0xFF, rest @ ..] => Cow::Owned(wide(rest, u16::from_be_bytes)),
        all => String::from_utf8_lossy(all),
    };
    if text.contains('\r') && !text.contains('\n') {
        return Cow::Owned(text.replace('\r', "\n"));
    }
    text
}

fn wide(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// A line as an error quotes it.
pub fn quoted(line: &str) -> String {
    let line = line.trim();
    let end = line.floor_char_boundary(QUOTED);
    let more = if end < line.len() { ".." } else { "" };
    format!("\"{}{more}\"", line[..end].escape_debug())
}

/// A coordinate, or why it is none.
pub fn coordinate(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("{} is not finite", quoted(word))),
        Err(_) if word.contains(',') => Err(format!(
            "{} is no number: write decimals with a point, as 4.5, not 4,5",
            quoted(word)
        )),
        Err(_) => Err(format!("{} is no number", quoted(word))),
    }
}

/// Format of a file whose contents contradict its name; `None` if they do not.
pub fn looks_like(bytes: &[u8]) -> Option<&'static str> {
    const BEGINNINGS: [(&[u8], &str); 15] = [
        (b"PK\x03\x04", "a ZIP archive, as 3MF files are"),
        (b"\x1f\x8b", "compressed by gzip"),
        (b"glTF", "a glTF file"),
        (b"Kaydara FBX", "an FBX file"),
        (b"; FBX", "an FBX file"),
        (b"ISO-10303-21", "a STEP file"),
        (
            b"version https://git-lfs",
            "a pointer of Git LFS; fetch the file itself with git lfs pull",
        ),
        (b"# vtk DataFile", "a VTK file"),
        (b"<?xml", "an XML file, as AMF, 3MF, VTK and COLLADA are"),
        (b"<!DOCTYPE html", "a page of the web"),
        (b"<html", "a page of the web"),
        (b"FoamFile", "a file of OpenFOAM"),
        (b"$MeshFormat", "a mesh of Gmsh"),
        (b"\x7fELF", "a program"),
        (b"{", "a JSON file, as glTF is"),
    ];
    if let Some((_, what)) = BEGINNINGS.iter().find(|(begin, _)| bytes.starts_with(begin)) {
        return Some(what);
    }
    let text = decode(&bytes[..bytes.len().min(4096)]).into_owned();
    let first = text.split_whitespace().next().unwrap_or("");
    if first.eq_ignore_ascii_case("ply") {
        return Some("a PLY file");
    }
    if first == "OFF" {
        return Some("an OFF file");
    }
    if first.eq_ignore_ascii_case("solid") && text.to_ascii_lowercase().contains("facet") {
        return Some("an STL file in text");
    }
    let mut words = text.lines().filter_map(|line| line.split_whitespace().next());
    let is_obj = |word: &str| matches!(word, "v" | "vn" | "vt" | "f" | "mtllib" | "usemtl");
    words
        .find(|word| !matches!(*word, "#" | "o" | "g" | "s") && !word.starts_with('#'))
        .filter(|w| is_obj(w))?;
    Some("an OBJ file; name it so")
}
