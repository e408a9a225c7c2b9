//! The parts of a glTF file: the GLB chunks, and buffers in data URIs or in files beside it.

use crate::Error;
use crate::load::MAX_FILE_BYTES;
use gltf::json::Root;
use std::borrow::Cow;

const REMEDY: &str = "the file is cut short or damaged: export it again";

/// The JSON text, and the binary chunk of a `.glb`.
pub(super) fn split<'a>(bytes: &'a [u8], name: &str) -> Result<(&'a [u8], Option<&'a [u8]>), Error> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let version = word(bytes, 4).unwrap_or(0);
    if version != 2 {
        return Err(Error::new(name, format!("GLB version {version}, expected 2"), "export it as glTF 2.0"));
    }
    let length = word(bytes, 8).unwrap_or(0) as usize;
    let body = bytes.get(12..length).ok_or_else(|| {
        let problem = format!("the header announces {length} bytes, the file has {}", bytes.len());
        Error::new(name, problem, REMEDY)
    })?;
    let mut chunks = Chunks { rest: body };
    let json = match chunks.next() {
        Some((b"JSON", json)) => json,
        _ => return Err(Error::new(name, "the first GLB chunk is not whole or not JSON", REMEDY)),
    };
    let binary = chunks.find_map(|(kind, data)| (kind == b"BIN\0").then_some(data));
    if !chunks.rest.is_empty() && binary.is_none() {
        return Err(Error::new(name, "a GLB chunk is longer than the file", REMEDY));
    }
    Ok((json, binary))
}

/// Whole chunks as (type, data); stops before one that is cut short.
struct Chunks<'a> {
    rest: &'a [u8],
}

impl<'a> Iterator for Chunks<'a> {
    type Item = (&'a [u8], &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let length = word(self.rest, 0)? as usize;
        let kind = self.rest.get(4..8)?;
        let data = self.rest.get(8..)?.get(..length)?;
        self.rest = &self.rest[8 + length..];
        Some((kind, data))
    }
}

/// The little-endian u32 at `offset`.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..offset + 4)?;
    Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

/// The bytes of every buffer, each at least as long as it claims and together at most [`MAX_FILE_BYTES`].
pub(super) fn buffers<'a>(
    root: &Root,
    blob: Option<&'a [u8]>,
    name: &str,
    mut fetch: impl FnMut(&str, u64) -> Result<Vec<u8>, String>,
) -> Result<Vec<Cow<'a, [u8]>>, Error> {
    let mut left = MAX_FILE_BYTES;
    let mut all = Vec::with_capacity(root.buffers.len());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let bytes: Cow<'a, [u8]> = match (&buffer.uri, blob) {
            (Some(uri), _) => match uri.strip_prefix("data:") {
                Some(data) => data_uri(data)
                    .ok_or_else(|| Error::new(name, format!("buffers[{index}] is not valid base64"), REMEDY))?
                    .into(),
                None => {
                    let file = percent_decoded(uri);
                    fetch(&file, left)
                        .map_err(|why| {
                            let problem = format!("buffers[{index}], the file '{file}', was not read: {why}");
                            Error::new(name, problem, "put it beside the file and name it by a relative path")
                        })?
                        .into()
                }
            },
            (None, Some(blob)) if index == 0 => blob.into(),
            (None, _) => {
                let problem = format!("buffers[{index}] has no data");
                return Err(Error::new(name, problem, "give the .glb, or name a .bin file in its uri"));
            }
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let problem =
                format!("buffers[{index}] has {} bytes, expected {}", bytes.len(), buffer.byte_length.0);
            return Err(Error::new(name, problem, REMEDY));
        }
        left = left.checked_sub(bytes.len() as u64).ok_or_else(|| {
            let problem = format!("the buffers hold more than {MAX_FILE_BYTES} bytes together");
            Error::new(name, problem, "split the scene")
        })?;
        all.push(bytes);
    }
    Ok(all)
}

/// The bytes of a data URI after `data:`; only base64 is in use for buffers.
fn data_uri(data: &str) -> Option<Vec<u8>> {
    let (_, text) = data.split_once(";base64,")?;
    let digits = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut bits = 0u32;
        for &digit in group {
            bits = bits << 6 | base64_digit(digit)?;
        }
        match group.len() {
            4 => bytes.extend_from_slice(&bits.to_be_bytes()[1..]),
            3 => bytes.extend_from_slice(&(bits << 6).to_be_bytes()[1..3]),
            2 => bytes.push((bits >> 4) as u8),
            _ => return None,
        }
    }
    Some(bytes)
}

fn base64_digit(digit: u8) -> Option<u32> {
    let value = match digit {
        b'A'..=b'Z' => digit - b'A',
        b'a'..=b'z' => digit - b'a' + 26,
        b'0'..=b'9' => digit - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(u32::from(value))
}

/// A URI with its `%20` and the like resolved; a malformed escape stays as it is.
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let escape = bytes.get(i + 1..i + 3).filter(|_| bytes[i] == b'%');
        let value = escape.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        decoded.push(value.unwrap_or(bytes[i]));
        i += if value.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}
