//! Writes a synthetic address stream as raw little-endian 64-bit addresses, one per touched 64-byte line:
//! `golden_trace bvh|rnd|seq COUNT OUT.u64`.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

use cachesim::synthetic::{Stream, lines};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [stream, count, path] = &arguments[..] else {
        return Err("expected three arguments: bvh|rnd|seq COUNT OUT.u64".into());
    };
    let stream = match stream.as_str() {
        "bvh" => Stream::Bvh,
        "rnd" => Stream::Rnd,
        "seq" => Stream::Seq,
        _ => return Err(format!("no stream '{stream}', expected bvh, rnd or seq").into()),
    };
    let mut out = BufWriter::new(File::create(path)?);
    for line in lines(stream, count.parse()?) {
        out.write_all(&(line.get() * 64).to_le_bytes())?;
    }
    out.flush()?;
    Ok(())
}
