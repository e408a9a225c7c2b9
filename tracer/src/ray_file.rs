//! Ray files: little-endian f32 x 8 per ray, origin xyz, t_min, direction xyz, t_max.

use crate::error::Error;
use crate::ray::Ray;
use glam::Vec3;
use std::io::Read;
use std::path::Path;

/// Bytes per ray.
pub const RAY_BYTES: usize = 32;

/// Most rays in a file: 2 GiB.
const MAX_RAYS: u64 = 1 << 26;

/// Reads all rays of a file. Fields may hold any value, NaN and infinities too.
///
/// # Errors
/// When the file cannot be read, is empty, too large, or not a whole number of rays.
pub fn read_rays(path: &Path) -> Result<Vec<Ray>, Error> {
    let io = |action| move |source| Error::Io { path: path.to_owned(), action, source };
    let format = |offset: u64, problem: String, remedy| Error::Format {
        path: path.to_owned(),
        offset,
        problem,
        remedy,
    };
    let file = std::fs::File::open(path).map_err(io("opening"))?;
    let mut bytes = Vec::new();
    file.take(MAX_RAYS * RAY_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(io("reading"))?;
    let length = bytes.len() as u64;
    if length > MAX_RAYS * RAY_BYTES as u64 {
        let problem = format!("more than {MAX_RAYS} rays");
        return Err(format(length - 1, problem, "split the file"));
    }
    if bytes.is_empty() || !bytes.len().is_multiple_of(RAY_BYTES) {
        let problem = format!("{length} bytes are not a positive multiple of {RAY_BYTES}, the size of a ray");
        let remedy = "write eight little-endian f32 per ray: origin xyz, t_min, direction xyz, t_max";
        return Err(format(length - length % RAY_BYTES as u64, problem, remedy));
    }
    Ok(bytes
        .chunks_exact(RAY_BYTES)
        .map(|record| {
            let field = |index: usize| {
                f32::from_le_bytes(*record[4 * index..].first_chunk().expect("a record has eight fields"))
            };
            Ray {
                origin: Vec3::new(field(0), field(1), field(2)),
                t_min: field(3),
                direction: Vec3::new(field(4), field(5), field(6)),
                t_max: field(7),
            }
        })
        .collect())
}
