//! A VTK file: XML that describes arrays, and the arrays behind it as raw bytes.

use crate::encode::{Scalar, append, bytes};
use crate::parameters::Compression;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;
use tremie_sdk::Moment;

/// A VTK file being put together.
pub struct Document {
    text: String,
    data: Vec<u8>,
    compression: Compression,
    open: Vec<&'static str>,
}

impl Document {
    /// A file of a kind of data set, as `ImageData`, with the attributes of its element, at a
    /// moment.
    pub fn new(kind: &'static str, attributes: &str, compression: Compression) -> Self {
        let compressor = match compression {
            Compression::None => "",
            Compression::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
        };
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n"
        );
        let mut document = Self { text, data: Vec::new(), compression, open: Vec::new() };
        document.begin(kind, attributes);
        document
    }

    /// A file of a surface of so many points and triangles at a moment: data of points and cells
    /// follow, and then [`Self::mesh`].
    pub fn surface(at: Moment, points: usize, triangles: usize, compression: Compression) -> Self {
        let mut document = Self::new("PolyData", "", compression).moment(at.time, at.stamp.window);
        document.begin(
            "Piece",
            &format!(
                "NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" \
                 NumberOfStrips=\"0\" NumberOfPolys=\"{triangles}\""
            ),
        );
        document
    }

    /// Adds the points [m] of a surface and the corners of its triangles.
    pub fn mesh(
        &mut self,
        points: impl Iterator<Item = f64>,
        corners: impl Iterator<Item = [i64; 3]>,
    ) {
        self.begin("Points", "");
        self.array("points", 3, "m", points);
        self.end();
        self.begin("Polys", "");
        let mut triangles = 0;
        let counted = corners.inspect(|_| triangles += 1).flatten();
        self.array("connectivity", 1, "", counted);
        self.array("offsets", 1, "", (1..=triangles).map(|k: i64| 3 * k));
        self.end();
    }

    /// Notes when the data hold: ParaView reads `TimeValue`.
    pub fn moment(mut self, time: f64, window: u64) -> Self {
        self.begin("FieldData", "");
        self.push::<f64>("TimeValue", "NumberOfTuples=\"1\"", "s", [time].into_iter());
        self.push::<u64>("window", "NumberOfTuples=\"1\"", "", [window].into_iter());
        self.end();
        self
    }

    /// Begins an element; `attributes` as they stand in XML.
    pub fn begin(&mut self, element: &'static str, attributes: &str) {
        let space = if attributes.is_empty() { "" } else { " " };
        let indent = "  ".repeat(self.open.len() + 1);
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{indent}<{element}{space}{attributes}>");
        self.open.push(element);
    }

    /// Ends the element that was begun last.
    pub fn end(&mut self) {
        if let Some(element) = self.open.pop() {
            let _ = writeln!(self.text, "{}</{element}>", "  ".repeat(self.open.len() + 1));
        }
    }

    /// Adds an array of `components` numbers a tuple; `unit` is empty where there is none.
    pub fn array<T: Scalar>(
        &mut self,
        name: &str,
        components: usize,
        unit: &str,
        values: impl Iterator<Item = T>,
    ) {
        self.push(name, &format!("NumberOfComponents=\"{components}\""), unit, values);
    }

    fn push<T: Scalar>(
        &mut self,
        name: &str,
        size: &str,
        unit: &str,
        values: impl Iterator<Item = T>,
    ) {
        let offset = self.data.len();
        append(&mut self.data, &bytes(values), self.compression);
        let indent = "  ".repeat(self.open.len() + 1);
        let kind = T::NAME;
        let _ = write!(
            self.text,
            "{indent}<DataArray type=\"{kind}\" Name=\"{name}\" {size} format=\"appended\" offset=\"{offset}\""
        );
        let _ = match unit {
            "" => writeln!(self.text, "/>"),
            _ => writeln!(
                self.text,
                ">\n{indent}  <InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>\n\
                 {indent}</DataArray>"
            ),
        };
    }

    /// Writes the file; under its name it is whole. Returns its size [bytes].
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(mut self, path: &Path) -> io::Result<u64> {
        while !self.open.is_empty() {
            self.end();
        }
        let begun = path.with_extension("part");
        let parts: [&[u8]; 4] = [
            self.text.as_bytes(),
            b"  <AppendedData encoding=\"raw\">\n   _",
            &self.data,
            b"\n  </AppendedData>\n</VTKFile>\n",
        ];
        let written = std::fs::File::create(&begun)
            .and_then(|mut file| parts.iter().try_for_each(|part| file.write_all(part)))
            .and_then(|()| std::fs::rename(&begun, path));
        if let Err(error) = written {
            // Half a file is of no use, and its room may be.
            let _ = std::fs::remove_file(&begun);
            return Err(error);
        }
        Ok(parts.iter().map(|part| part.len() as u64).sum())
    }
}
