//! Files of addresses, read as a stream of bounded blocks.

mod raw;
mod text;

use std::io::BufRead;
use std::path::Path;

use crate::address::{Access, LineId, LineSize};
use crate::error::{Error, Place};
use crate::hierarchy::{Hierarchy, PathId};

/// The most bytes that one access may touch.
pub const MAX_ACCESS_BYTES: u64 = 1 << 20;

/// How a file holds its addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddressFormat {
    /// Dinero's text: `label address` per line, label 0 read, 1 write, 2 instruction fetch (a read), the
    /// address in hexadecimal. Each access touches the one line that holds the address; the rest of the
    /// line of text is ignored, as by Dinero.
    Din,
    /// `op,address,size` per line, with an optional fourth column `unit` (the requester, from 0) and an
    /// optional heading. `op` is `read`, `r`, `write` or `w`; numbers are decimal, or hexadecimal after
    /// `0x`. An access touches every line that its bytes overlap.
    Csv,
    /// Raw little-endian 64-bit addresses, each a read of one byte.
    U64,
}

impl AddressFormat {
    /// The format that a file's extension names: `.din`, `.csv` or `.u64`.
    ///
    /// # Errors
    /// If it is none of these.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("din") => Ok(Self::Din),
            Some("csv") => Ok(Self::Csv),
            Some("u64") => Ok(Self::U64),
            _ => Err(Error::addresses(
                Place { file: Some(path.display().to_string()), ..Place::default() },
                "unknown format of addresses, expected a name that ends in .din, .csv or .u64",
                "rename or convert the file",
            )),
        }
    }
}

/// Reads a file of addresses as blocks of line accesses.
#[derive(Debug)]
pub struct AddressReader<R> {
    source: Source<R>,
    any: bool,
}

#[derive(Debug)]
enum Source<R> {
    Text(text::TextReader<R>),
    Raw(raw::RawReader<R>),
}

impl<R: BufRead> AddressReader<R> {
    /// Reads `input`. `file` is its name, for errors; `units` the number of requesters that it may name,
    /// [`Hierarchy::units`] or 1.
    pub fn new(input: R, format: AddressFormat, file: &str, units: u32) -> Self {
        let source = match format {
            AddressFormat::Din => Source::Text(text::TextReader::new(input, text::Syntax::Din, file, units)),
            AddressFormat::Csv => Source::Text(text::TextReader::new(input, text::Syntax::Csv, file, units)),
            AddressFormat::U64 => Source::Raw(raw::RawReader::new(input, file)),
        };
        Self { source, any: false }
    }

    /// Puts the next accesses, all of one unit, into `block` and returns the unit; `None` at the end.
    ///
    /// # Errors
    /// If the file cannot be read or understood, or holds no access at all; the error names the line or the
    /// byte offset.
    pub fn next_block(&mut self, line: LineSize, block: &mut Vec<Access>) -> Result<Option<u32>, Error> {
        block.clear();
        let (unit, file) = match &mut self.source {
            Source::Text(text) => (text.next_block(line, block)?, text.file()),
            Source::Raw(raw) => (raw.next_block(line, block)?, raw.file()),
        };
        if unit.is_none() && !self.any {
            return Err(Error::addresses(
                Place { file: Some(file.to_owned()), ..Place::default() },
                "the file holds no accesses, expected at least one",
                "record the addresses again",
            ));
        }
        self.any = true;
        Ok(unit)
    }

    /// Takes all accesses through `path` of `hierarchy`, in order.
    ///
    /// # Errors
    /// As [`Self::next_block`].
    pub fn replay(mut self, hierarchy: &mut Hierarchy, path: PathId) -> Result<(), Error> {
        let line = hierarchy.granule(path);
        let mut block = Vec::new();
        while let Some(unit) = self.next_block(line, &mut block)? {
            hierarchy.access(path, unit, &block);
        }
        Ok(())
    }

    /// Calls `touch` with the line, of size `line`, of every access, reads and writes of all units alike.
    ///
    /// # Errors
    /// As [`Self::next_block`].
    pub fn for_each_line(mut self, line: LineSize, mut touch: impl FnMut(LineId)) -> Result<(), Error> {
        let mut block = Vec::new();
        while self.next_block(line, &mut block)?.is_some() {
            block.iter().for_each(|access| touch(access.line()));
        }
        Ok(())
    }
}
