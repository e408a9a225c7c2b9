//! Tiles as bytes, before compression.
//!
//! Everything is a sequence of variable-length integers (LEB128). Those of the steps are in [`super::ray_steps`], those of trees in
//! [`super::shape`].

use super::ray_steps::{decode_steps, encode_steps};
use super::reflection_lines;
use crate::observe::{DECIDED_BY_MICROMAP, NodeFetch, Op};
use crate::raster::TileDraw;
use crate::ray::{NO_HIT, NOT_CAST};
use crate::topology::Topology;
use crate::trace::{MAX_TILE_STEPS, Tile, TileRect, TraceHeader};

pub(super) fn push_varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

pub(super) fn zigzag(value: i64) -> u64 {
    (value << 1 ^ value >> 63) as u64
}

pub(super) fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// Encodes a tile of a trace with this header.
pub(super) fn encode_tile(tile: &Tile, header: &TraceHeader) -> Vec<u8> {
    let steps: usize = tile.ray_sets.iter().map(|set| set.steps.len()).sum();
    let mut bytes = Vec::with_capacity(steps * 2 + 4096);
    for set in &tile.ray_sets {
        for ray in 0..set.ends.len() {
            push_varint(&mut bytes, set.range(ray).len() as u64);
        }
        let mut previous = 0;
        for &hit in &set.hits {
            let hit = match hit {
                NOT_CAST => i64::from(header.triangles) + 1,
                _ => i64::from(hit.wrapping_add(1)),
            };
            push_varint(&mut bytes, zigzag(hit - previous));
            previous = hit;
        }
        encode_steps(set, &mut bytes);
    }
    if header.raster {
        encode_draws(&tile.draws, &mut bytes);
    }
    if header.reflections.is_some() {
        reflection_lines::encode(&tile.reflections, &mut bytes);
    }
    bytes
}

/// Triangles rise, so each is stored as its distance from the least possible one.
fn encode_draws(draws: &[TileDraw], bytes: &mut Vec<u8>) {
    push_varint(bytes, draws.len() as u64);
    let mut least = 0;
    for &TileDraw { triangle, covered, passed, quads } in draws {
        for value in [triangle - least, covered, passed, quads] {
            push_varint(bytes, u64::from(value));
        }
        least = triangle + 1;
    }
}

fn decode_draws(
    reader: &mut Reader<'_>,
    rect: TileRect,
    triangles: u64,
    draws: &mut Vec<TileDraw>,
) -> Result<(), String> {
    let (pixels, tile_quads) = (rect.width * rect.height, rect.width.div_ceil(2) * rect.height.div_ceil(2));
    let count = reader.bounded(triangles, "a number of drawn triangles of")?;
    // A draw takes at least four bytes, so the claimed number cannot make the vector larger than the data.
    draws.reserve((count as usize).min(reader.bytes.len() / 4));
    let mut least = 0;
    for _ in 0..count {
        let triangle = least + reader.bounded(triangles, "a step of drawn triangles of")?;
        if triangle >= triangles {
            return Err(format!("a drawn triangle {triangle}, below {triangles} expected"));
        }
        let covered = reader.bounded(u64::from(pixels), "a number of covered pixels of")? as u32;
        let passed = reader.bounded(u64::from(covered), "a number of passed pixels of")? as u32;
        let most_quads = u64::from(passed.min(tile_quads));
        let quads = reader.bounded(most_quads, "a number of quads of")? as u32;
        if quads * 4 < passed {
            return Err(format!("{passed} passed pixels in {quads} quads of 4"));
        }
        draws.push(TileDraw { triangle: triangle as u32, covered, passed, quads });
        least = triangle + 1;
    }
    Ok(())
}

/// Reads variable-length integers; a problem is a sentence.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) position: usize,
}

impl Reader<'_> {
    pub(super) fn varint(&mut self) -> Result<u64, String> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = *self.bytes.get(self.position).ok_or("the data end inside a number")?;
            self.position += 1;
            if shift == 63 && byte > 1 {
                break;
            }
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number of more than 64 bits".to_owned())
    }

    /// As [`Self::varint`], faster for the small numbers that most steps are.
    #[inline(always)]
    pub(super) fn token(&mut self) -> Result<u64, String> {
        let word = match self.bytes.get(self.position..).and_then(|rest| rest.first_chunk()) {
            Some(&chunk) => u32::from_le_bytes(chunk),
            None => return self.varint(),
        };
        let ends = !word & 0x8080_8080;
        if ends == 0 {
            return self.varint();
        }
        self.position += (ends.trailing_zeros() / 8 + 1) as usize;
        let own = word & (ends ^ (ends - 1));
        let value = own & 0x7f | own >> 1 & 0x3f80 | own >> 2 & 0x1f_c000 | own >> 3 & 0xfe0_0000;
        Ok(u64::from(value))
    }

    pub(super) fn bounded(&mut self, limit: u64, what: &str) -> Result<u64, String> {
        let value = self.varint()?;
        if value > limit { Err(format!("{what} {value}, at most {limit} expected")) } else { Ok(value) }
    }

    /// The next bytes as they are.
    pub(super) fn fixed<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let bytes = self.bytes.get(self.position..).and_then(|rest| rest.first_chunk::<N>());
        self.position += N;
        bytes.copied().ok_or_else(|| "the data end inside a record".to_owned())
    }

    pub(super) fn finish(&self) -> Result<(), String> {
        match self.bytes.len() - self.position {
            0 => Ok(()),
            rest => Err(format!("{rest} bytes left over")),
        }
    }
}

/// What ids a step may have.
pub(super) struct Limits {
    /// Per op, one more than the largest id.
    pub(super) ids: [u64; Op::ALL.len()],
    pub(super) triangles: u64,
    /// Per ray set, whether its hits say nothing of rays that were not cast.
    pub(super) plain_sets: Vec<bool>,
    pub(super) raster: bool,
    /// Bits of an any-hit step's id that are no part of the position.
    pub(super) any_hit_flags: u32,
    /// The set of reflection rays whose lines are kept, if any are.
    pub(super) lines_of: Option<usize>,
}

impl Limits {
    /// Whether a step may have an id that fits into a step.
    #[inline(always)]
    pub(super) fn allow(&self, op: Op, id: u32) -> bool {
        let flags = if op == Op::AnyHit { self.any_hit_flags } else { 0 };
        u64::from(id & !flags) < self.ids[op as usize]
    }

    pub(super) fn new(header: &TraceHeader, topology: &Topology) -> Self {
        let nodes = topology.nodes.len() as u64;
        let references = topology.references.len() as u64;
        let stack = u64::from(header.stack_entries.max(header.short_stack));
        let instances = topology.levels.as_ref().map_or(0, |levels| levels.meshes.len() as u64);
        let ids = Op::ALL.map(|op| match op {
            // A pair reads `id + 1` too, except for the root, which is always there. With two levels the last node can be a root.
            Op::Node if header.node_fetch == NodeFetch::Pair && topology.levels.is_none() => {
                nodes.saturating_sub(1).max(1)
            }
            Op::Node | Op::Up | Op::Restart => nodes,
            Op::Push | Op::Pop => stack,
            Op::Primitive | Op::AnyHit => references,
            Op::Instance => instances,
        });
        Self {
            ids,
            triangles: u64::from(topology.triangles),
            plain_sets: header.ray_sets.iter().map(|set| set.is_plain()).collect(),
            raster: header.raster,
            any_hit_flags: if header.alpha.as_ref().is_some_and(|alpha| alpha.micromap.is_some()) {
                DECIDED_BY_MICROMAP
            } else {
                0
            },
            lines_of: header.reflections.as_ref().and_then(|_| reflection_lines::set(&header.ray_sets)),
        }
    }
}

/// Decodes a tile, checking every id.
pub(super) fn decode_tile(
    bytes: &[u8],
    rect: TileRect,
    limits: &Limits,
    tile: &mut Tile,
) -> Result<(), String> {
    let rays = rect.width * rect.height;
    let mut reader = Reader { bytes, position: 0 };
    tile.ray_sets.resize_with(limits.plain_sets.len(), Default::default);
    for (set, &plain) in tile.ray_sets.iter_mut().zip(&limits.plain_sets) {
        let most_hit = limits.triangles + u64::from(!plain);
        set.clear();
        let mut end = 0;
        for _ in 0..rays {
            end += reader.bounded(MAX_TILE_STEPS as u64, "a ray with a number of steps of")?;
            if end > MAX_TILE_STEPS as u64 {
                return Err(format!("a tile of more than {MAX_TILE_STEPS} steps"));
            }
            set.ends.push(end as u32);
        }
        let mut previous = 0_i64;
        for _ in 0..rays {
            previous = previous.wrapping_add(unzigzag(reader.varint()?));
            if previous < 0 || previous as u64 > most_hit {
                return Err(format!("a hit of a triangle that is not among the {}", limits.triangles));
            }
            let cast = previous as u64 <= limits.triangles;
            set.hits.push(if cast { (previous as u32).wrapping_sub(1) } else { NOT_CAST });
            debug_assert!(previous > 0 || set.hits.last() == Some(&NO_HIT));
        }
        // A step takes at least one byte, so the claimed number cannot make the vector larger than the data.
        set.steps.reserve((end as usize).min(bytes.len()));
        decode_steps(&mut reader, rect.width as usize, limits, set)?;
    }
    tile.draws.clear();
    if limits.raster {
        decode_draws(&mut reader, rect, limits.triangles, &mut tile.draws)?;
    }
    tile.reflections.clear();
    if let Some(set) = limits.lines_of {
        let rays = reflection_lines::cast(&tile.ray_sets, set).count();
        reflection_lines::decode(&mut reader, rays, &mut tile.reflections)?;
    }
    reader.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a tile of 5x3 pixels in a scene of 10 triangles makes of drawn triangles.
    fn decoded(numbers: &[u64]) -> Result<Vec<TileDraw>, String> {
        let mut bytes = Vec::new();
        numbers.iter().for_each(|&number| push_varint(&mut bytes, number));
        let mut reader = Reader { bytes: &bytes, position: 0 };
        let mut draws = Vec::new();
        decode_draws(&mut reader, TileRect { x: 32, y: 64, width: 5, height: 3 }, 10, &mut draws)?;
        reader.finish()?;
        Ok(draws)
    }

    #[test]
    fn drawn_triangles_round_trip_and_rise() {
        let draw = |triangle, covered, passed, quads| TileDraw { triangle, covered, passed, quads };
        let draws = vec![draw(0, 15, 15, 6), draw(1, 0, 0, 0), draw(9, 4, 3, 3)];
        let mut bytes = Vec::new();
        encode_draws(&draws, &mut bytes);
        assert_eq!(bytes, [3, 0, 15, 15, 6, 0, 0, 0, 0, 7, 4, 3, 3]);
        let numbers: Vec<u64> = bytes.into_iter().map(u64::from).collect();
        assert_eq!(decoded(&numbers), Ok(draws));
        assert_eq!(decoded(&[0]), Ok(Vec::new()));
    }

    #[test]
    fn drawn_triangles_are_refused_just_beyond_each_limit() {
        let limits: [(&[u64], &[u64], &str); 8] = [
            (&[1, 9, 0, 0, 0], &[1, 10, 0, 0, 0], "a drawn triangle 10"),
            (&[2, 0, 0, 0, 0, 8, 0, 0, 0], &[2, 0, 0, 0, 0, 9, 0, 0, 0], "a drawn triangle 10"),
            (&[1, 0, 15, 0, 0], &[1, 0, 16, 0, 0], "covered pixels of 16"),
            (&[1, 0, 4, 4, 1], &[1, 0, 4, 5, 2], "passed pixels of 5"),
            (&[1, 0, 15, 15, 6], &[1, 0, 15, 15, 7], "quads of 7"),
            (&[1, 0, 3, 3, 3], &[1, 0, 3, 3, 4], "quads of 4"),
            (&[1, 0, 8, 8, 2], &[1, 0, 9, 9, 2], "9 passed pixels in 2 quads"),
            (&[1, 0, 0, 0, 0], &[1, 0, 0, 0], "end inside a number"),
        ];
        for (good, bad, problem) in limits {
            assert!(decoded(good).is_ok(), "{good:?}");
            assert!(decoded(bad).expect_err("beyond").contains(problem), "{bad:?}: {:?}", decoded(bad));
        }
        assert!(decoded(&[11]).expect_err("more than triangles").contains("drawn triangles of 11"));
        assert!(decoded(&[1, u64::MAX, 0, 0, 0]).is_err());
        assert!(decoded(&[0, 0]).is_err(), "left over");
    }

    #[test]
    fn varints_and_zigzag_round_trip_at_the_edges() {
        let values = [0, 1, 0x7f, 0x80, 0x3fff, 0x4000, u64::from(u32::MAX), u64::MAX];
        let mut bytes = Vec::new();
        values.iter().for_each(|&value| push_varint(&mut bytes, value));
        let mut reader = Reader { bytes: &bytes, position: 0 };
        assert!(values.iter().all(|&value| reader.varint() == Ok(value)));
        assert_eq!(reader.finish(), Ok(()));
        let too_long = [&[0xff; 9][..], &[2]].concat();
        assert!(Reader { bytes: &too_long, position: 0 }.varint().is_err());
        for value in [0, 1, -1, i64::MAX, i64::MIN] {
            assert_eq!(unzigzag(zigzag(value)), value);
        }
    }

    #[test]
    fn numbers_are_read_alike_by_the_fast_and_the_slow_way() {
        for shift in 0..64 {
            for value in [(1_u64 << shift) - 1, 1 << shift, u64::MAX >> shift] {
                for following in 0..9 {
                    let mut bytes = Vec::new();
                    push_varint(&mut bytes, value);
                    bytes.extend(vec![0xff; following]);
                    let (mut fast, mut slow) =
                        (Reader { bytes: &bytes, position: 0 }, Reader { bytes: &bytes, position: 0 });
                    assert_eq!((fast.token(), slow.varint()), (Ok(value), Ok(value)));
                    assert_eq!(fast.position, slow.position);
                }
            }
        }
        assert!(Reader { bytes: &[], position: 0 }.token().is_err());
        assert!(Reader { bytes: &[0xff; 9], position: 0 }.token().is_err());
    }
}
