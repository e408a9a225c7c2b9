//! Text with one access per line: Dinero's `label address` and `op,address,size`.

use std::io::{BufRead, Read};

use super::MAX_ACCESS_BYTES;
use crate::address::{Access, Address, LineId, LineSize};
use crate::error::{Error, Place};

/// The longest line of text, far more than a full record needs.
const MAX_TEXT: usize = 1024;
/// Accesses after which a block is full.
const BLOCK: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Syntax {
    Din,
    Csv,
}

/// One access as the file has it: `bytes` is at least 1 and `first + bytes - 1` is an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Record {
    write: bool,
    first: u64,
    bytes: u64,
    unit: u32,
}

#[derive(Debug)]
pub(super) struct TextReader<R> {
    input: R,
    syntax: Syntax,
    file: String,
    units: u32,
    line: u64,
    text: Vec<u8>,
    pending: Option<Record>,
}

/// What is wrong with a line, and the remedy.
type Complaint = (String, &'static str);

impl<R: BufRead> TextReader<R> {
    pub(super) fn new(input: R, syntax: Syntax, file: &str, units: u32) -> Self {
        Self { input, syntax, file: file.to_owned(), units, line: 0, text: Vec::new(), pending: None }
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    fn place(&self) -> Place {
        Place { file: Some(self.file.clone()), line: Some(self.line), ..Place::default() }
    }

    pub(super) fn next_block(
        &mut self,
        line: LineSize,
        block: &mut Vec<Access>,
    ) -> Result<Option<u32>, Error> {
        let mut unit = None;
        while block.len() < BLOCK {
            let Some(record) = self.next_record()? else { break };
            if unit.is_some_and(|unit| unit != record.unit) {
                self.pending = Some(record);
                break;
            }
            unit = Some(record.unit);
            let last = line.line_of(Address(record.first + (record.bytes - 1)));
            let lines = (line.line_of(Address(record.first)).get()..=last.get()).map(LineId::new);
            block.extend(lines.map(if record.write { Access::write } else { Access::read }));
        }
        Ok(unit)
    }

    fn next_record(&mut self) -> Result<Option<Record>, Error> {
        if let Some(record) = self.pending.take() {
            return Ok(Some(record));
        }
        loop {
            self.line += 1;
            self.text.clear();
            let mut limited = self.input.by_ref().take(MAX_TEXT as u64 + 1);
            let count = limited
                .read_until(b'\n', &mut self.text)
                .map_err(|source| Error::Read { place: self.place().into(), source })?;
            if count == 0 {
                return Ok(None);
            }
            match parse(&self.text, self.syntax, self.line == 1, self.units) {
                Ok(None) => {}
                Ok(record) => return Ok(record),
                Err((problem, remedy)) => return Err(Error::addresses(self.place(), problem, remedy)),
            }
        }
    }
}

/// The record in one line of text; `None` if the line is blank or a heading.
fn parse(text: &[u8], syntax: Syntax, is_first: bool, units: u32) -> Result<Option<Record>, Complaint> {
    if text.len() > MAX_TEXT {
        return Err((
            format!("the line is longer than {MAX_TEXT} bytes"),
            "check that this is a text of addresses",
        ));
    }
    let text = std::str::from_utf8(text)
        .map_err(|_| ("the line is not text".to_owned(), "check the format; .u64 is the binary one"))?
        .trim();
    if text.is_empty() {
        return Ok(None);
    }
    match syntax {
        Syntax::Din => parse_din(text).map(Some),
        Syntax::Csv if is_first && text.replace(' ', "").starts_with("op,address,size") => Ok(None),
        Syntax::Csv => parse_csv(text, units).map(Some),
    }
}

fn parse_din(text: &str) -> Result<Record, Complaint> {
    const REMEDY: &str = "write lines such as '0 10000040'";
    let mut fields = text.split_ascii_whitespace();
    let label = fields.next().unwrap_or_default();
    let write = match label {
        "0" | "2" => false,
        "1" => true,
        _ => {
            let label = shown(label);
            return Err((format!("label {label}, expected 0 (read), 1 (write) or 2 (fetch)"), REMEDY));
        }
    };
    let Some(address) = fields.next() else {
        return Err(("the address is missing, expected label and hexadecimal address".into(), REMEDY));
    };
    let digits = address.strip_prefix("0x").or(address.strip_prefix("0X")).unwrap_or(address);
    let first = unsigned(digits, 16).ok_or_else(|| {
        (format!("address {}, expected a hexadecimal number of up to 64 bits", shown(address)), REMEDY)
    })?;
    Ok(Record { write, first, bytes: 1, unit: 0 })
}

fn parse_csv(text: &str, units: u32) -> Result<Record, Complaint> {
    const REMEDY: &str = "write lines such as 'read,0x10000040,16'";
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    let (op, address, bytes, unit) = match fields[..] {
        [op, address, bytes] => (op, address, bytes, None),
        [op, address, bytes, unit] => (op, address, bytes, Some(unit)),
        _ => {
            let count = fields.len();
            return Err((
                format!("{count} columns, expected op,address,size or op,address,size,unit"),
                REMEDY,
            ));
        }
    };
    let write = match op {
        "r" | "R" | "read" => false,
        "w" | "W" | "write" => true,
        _ => return Err((format!("op {}, expected read or write", shown(op)), REMEDY)),
    };
    let number = |name: &str, text: &str| {
        let found = match text.strip_prefix("0x").or(text.strip_prefix("0X")) {
            Some(digits) => unsigned(digits, 16),
            None => unsigned(text, 10),
        };
        found.ok_or_else(|| (format!("{name} {}, expected a number of up to 64 bits", shown(text)), REMEDY))
    };
    let (first, bytes) = (number("address", address)?, number("size", bytes)?);
    if bytes == 0 || bytes > MAX_ACCESS_BYTES {
        return Err((format!("size {bytes}, expected 1 to {MAX_ACCESS_BYTES} bytes"), "split the access"));
    }
    if first.checked_add(bytes - 1).is_none() {
        return Err((
            format!("{bytes} bytes at {first:#x} run past the last address"),
            "correct the address or the size",
        ));
    }
    let unit = unit.map_or(Ok(0), |unit| number("unit", unit))?;
    if unit >= u64::from(units) {
        return Err((
            format!("unit {unit}, expected less than {units}, the largest count of any level"),
            "raise count in the description of the levels, or correct the unit",
        ));
    }
    Ok(Record { write, first, bytes, unit: unit as u32 })
}

/// A number without sign or separators.
fn unsigned(digits: &str, radix: u32) -> Option<u64> {
    if digits.starts_with('+') { None } else { u64::from_str_radix(digits, radix).ok() }
}

/// A field as an error shows it: quoted, printable and short.
fn shown(field: &str) -> String {
    let short: String = field.chars().take(24).collect();
    format!("'{}{}'", short.escape_debug(), if short.len() < field.len() { "..." } else { "" })
}
