//! Records of an MCAP file, as far as it goes.

use crate::recording::ReadError;
use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fs::File;
use std::io::{BufReader, Read};

/// Records of an MCAP file from its beginning to its end, or to where a killed writer left it.
pub struct Records {
    file: BufReader<File>,
    reader: LinearReader,
    is_empty: bool,
    /// True if some record was read: what is unreadable after that was damaged, and what comes
    /// before it counts.
    has_begun: bool,
}

impl Records {
    /// Records of a file; chunks come as such where they are wanted `whole`, else record by record.
    pub fn of(file: File, whole: bool) -> std::io::Result<Self> {
        let length = file.metadata()?.len();
        let mut options = LinearReaderOptions::default().with_skip_end_magic(true);
        if whole {
            // A damaged length must not take more memory than the file could fill.
            options = options.with_emit_chunks(true).with_record_length_limit(length as usize);
        }
        Ok(Self {
            is_empty: length == 0,
            file: BufReader::new(file),
            reader: LinearReader::new_with_options(options),
            has_begun: false,
        })
    }

    /// True if the file holds nothing.
    pub fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// The next record, if there is a readable one.
    pub fn next(&mut self) -> Result<Option<Record<'static>>, ReadError> {
        loop {
            let (opcode, data) = match self.reader.next_event() {
                None | Some(Err(McapError::UnexpectedEof)) => return Ok(None),
                Some(Err(_)) if self.has_begun => return Ok(None),
                Some(Err(error)) => return Err(error.into()),
                Some(Ok(LinearReadEvent::Record { opcode, data })) => (opcode, data),
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    let read = self.file.read(self.reader.insert(wanted))?;
                    self.reader.notify_read(read);
                    continue;
                }
            };
            let record = match mcap::parse_record(opcode, data) {
                Err(_) if self.has_begun => return Ok(None),
                record => record?.into_owned(),
            };
            self.has_begun = true;
            return Ok(Some(record));
        }
    }
}
