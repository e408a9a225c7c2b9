//! Raw little-endian 64-bit addresses.

use std::io::BufRead;

use crate::address::{Access, Address, LineSize};
use crate::error::{Error, Place};

const BLOCK_BYTES: usize = 8 * 4096;

#[derive(Debug)]
pub(super) struct RawReader<R> {
    input: R,
    file: String,
    offset: u64,
    bytes: Vec<u8>,
}

impl<R: BufRead> RawReader<R> {
    pub(super) fn new(input: R, file: &str) -> Self {
        Self { input, file: file.to_owned(), offset: 0, bytes: vec![0; BLOCK_BYTES] }
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    fn place(&self) -> Place {
        Place { file: Some(self.file.clone()), byte: Some(self.offset), ..Place::default() }
    }

    pub(super) fn next_block(
        &mut self,
        line: LineSize,
        block: &mut Vec<Access>,
    ) -> Result<Option<u32>, Error> {
        let mut filled = 0;
        while filled < BLOCK_BYTES {
            match self.input.read(&mut self.bytes[filled..]) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(source) if source.kind() == std::io::ErrorKind::Interrupted => {}
                Err(source) => {
                    self.offset += filled as u64;
                    return Err(Error::Read { place: self.place().into(), source });
                }
            }
        }
        let (addresses, torn) = self.bytes[..filled].as_chunks::<8>();
        block.extend(
            addresses.iter().map(|&bytes| Access::read(line.line_of(Address(u64::from_le_bytes(bytes))))),
        );
        self.offset += 8 * addresses.len() as u64;
        if !torn.is_empty() {
            return Err(Error::addresses(
                self.place(),
                format!("{} bytes are left over, expected whole 8-byte addresses", torn.len()),
                "copy the file again, or check that it holds 64-bit addresses",
            ));
        }
        Ok((!block.is_empty()).then_some(0))
    }
}
