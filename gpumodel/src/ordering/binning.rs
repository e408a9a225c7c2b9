//! Into which bin a ray goes.

use super::refuse;
use crate::error::Error;
use std::fmt;
use tracer::Aabb;

/// Most bins: shared memory holds a counter of 4 bytes for each and the start of the group, and Vulkan guarantees 16 KiB of it.
pub const MOST_BINS: u32 = 4095;
/// Bins by the signs of a direction.
const SIGNS: u32 = 8;

/// How rays are put into bins.
///
/// Every ray has a bin: a coordinate that is no number goes where the lowest one goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binning {
    /// Not at all: rays are appended warp by warp.
    None,
    /// By the signs of the direction; a zero of either sign counts as negative.
    Sign,
    /// By the direction, on an octahedron unfolded into a square that is cut into columns and rows (Cigolle et al. 2014, "A Survey of
    /// Efficient Representations for Independent Unit Vectors").
    Octahedral {
        /// Along the first axis of the square.
        columns: u32,
        /// Along the second.
        rows: u32,
    },
    /// By the origin, in the order of a Morton curve through the scene's box.
    Position {
        /// Of each axis: it is cut into 2 to the power of this.
        bits: u32,
    },
    /// By the signs of the direction, then by the origin.
    PositionAndSign {
        /// As [`Binning::Position`].
        bits: u32,
    },
}

impl Binning {
    /// The binning of that name: `none`, `sign`, `octahedral-4x4`, `position-2`, `position-sign-1`, with any numbers that leave
    /// 1 to [`MOST_BINS`] bins.
    ///
    /// # Errors
    /// Says which names there are, or how many bins are too many.
    pub fn from_name(name: &str) -> Result<Self, Error> {
        let number = |digits: &str| digits.parse::<u32>().ok();
        let found = match name {
            "none" => Some(Self::None),
            "sign" => Some(Self::Sign),
            _ => {
                if let Some(bits) = name.strip_prefix("position-sign-") {
                    number(bits).map(|bits| Self::PositionAndSign { bits })
                } else if let Some(bits) = name.strip_prefix("position-") {
                    number(bits).map(|bits| Self::Position { bits })
                } else {
                    name.strip_prefix("octahedral-").and_then(|size| size.split_once('x')).and_then(
                        |(columns, rows)| {
                            Some(Self::Octahedral { columns: number(columns)?, rows: number(rows)? })
                        },
                    )
                }
            }
        };
        // Numbers can be written in other ways, with zeros or a sign before them: these are refused.
        let Some(binning) = found.filter(|binning| binning.to_string() == name) else {
            let remedy = "expected none, sign, octahedral-4x4, position-2 or position-sign-1, or other numbers in them";
            return Err(refuse(format!("no binning is called '{name}'"), remedy));
        };
        match binning.checked_bins() {
            Some(1..=MOST_BINS) => Ok(binning),
            bins => {
                let bins = bins.map_or_else(|| "more than 4294967295".to_owned(), |bins| bins.to_string());
                let problem = format!("binning '{name}' has {bins} bins, expected 1 to {MOST_BINS}");
                Err(refuse(problem, "choose other numbers: a workgroup counts its bins in shared memory"))
            }
        }
    }

    /// Number of bins: 1 where there are none; at most [`MOST_BINS`] of those that have a name, at most `u32::MAX` of any.
    pub fn bins(self) -> u32 {
        self.checked_bins().unwrap_or(u32::MAX)
    }

    fn checked_bins(self) -> Option<u32> {
        let cells = |bits: u32| 1_u32.checked_shl(bits.checked_mul(3)?);
        match self {
            Self::None => Some(1),
            Self::Sign => Some(SIGNS),
            Self::Octahedral { columns, rows } => columns.checked_mul(rows),
            Self::Position { bits } => cells(bits),
            Self::PositionAndSign { bits } => cells(bits)?.checked_mul(SIGNS),
        }
    }

    /// The bin of a ray, below [`Self::bins`]; `bounds` is the scene's box, beyond which origins go to the bins at its border.
    pub fn bin(self, direction: [f32; 3], origin: [f32; 3], bounds: &Aabb) -> u32 {
        match self {
            Self::None => 0,
            Self::Sign => signs(direction),
            Self::Octahedral { columns, rows } => {
                let [u, v] = unfolded(direction);
                cell(u, columns) + cell(v, rows) * columns
            }
            Self::Position { bits } => morton(origin, bounds, bits),
            Self::PositionAndSign { bits } => signs(direction) << (3 * bits) | morton(origin, bounds, bits),
        }
    }
}

impl fmt::Display for Binning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Sign => f.write_str("sign"),
            Self::Octahedral { columns, rows } => write!(f, "octahedral-{columns}x{rows}"),
            Self::Position { bits } => write!(f, "position-{bits}"),
            Self::PositionAndSign { bits } => write!(f, "position-sign-{bits}"),
        }
    }
}

fn signs([x, y, z]: [f32; 3]) -> u32 {
    u32::from(z > 0.0) << 2 | u32::from(y > 0.0) << 1 | u32::from(x > 0.0)
}

/// Where a direction of any length lies in the square of the unfolded octahedron, 0 to 1 along both axes; NaN where it has none.
fn unfolded([x, y, z]: [f32; 3]) -> [f32; 2] {
    let length = x.abs() + y.abs() + z.abs();
    let (x, y) = (x / length, y / length);
    let sign = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [x.mul_add(0.5, 0.5), y.mul_add(0.5, 0.5)]
}

/// Which of `count` equal parts of 0 to 1 a value is in, the nearest if in none, the first if it is no number.
fn cell(value: f32, count: u32) -> u32 {
    // A cast of a float ends at the limits of the integer and makes 0 of NaN.
    ((value * count as f32) as u32).min(count.saturating_sub(1))
}

fn morton(origin: [f32; 3], bounds: &Aabb, bits: u32) -> u32 {
    let (low, extent) = (bounds.min.to_array(), bounds.extent().to_array());
    let mut code = 0;
    for axis in 0..3 {
        let cell = cell((origin[axis] - low[axis]) / extent[axis], 1 << bits);
        for bit in 0..bits {
            code |= (cell >> bit & 1) << (3 * bit + axis as u32);
        }
    }
    code
}

#[cfg(test)]
mod tests;
