//! The lines of reflection rays as bytes, before compression.

use super::codec::Reader;
use crate::ray::{NO_HIT, NOT_CAST};
use crate::ray_set::{RayKind, RaySetId};
use crate::trace::{RayLine, RaySet};

const LINE_BYTES: usize = 24;

/// The place of the reflection rays whose lines are kept: those of the first sample.
pub(super) fn set(sets: &[RaySetId]) -> Option<usize> {
    sets.iter().position(|set| set.kind == RayKind::Reflection && set.sample == 0)
}

/// The rays of a tile that were cast into set `set`.
pub(crate) fn cast(sets: &[RaySet], set: usize) -> impl Iterator<Item = usize> + '_ {
    let primary = &sets[0].hits;
    (0..primary.len()).filter(move |&ray| primary[ray] != NO_HIT && sets[set].hits[ray] != NOT_CAST)
}

pub(super) fn encode(lines: &[RayLine], bytes: &mut Vec<u8>) {
    for RayLine { origin, direction } in lines {
        bytes.extend(origin.iter().chain(direction).flat_map(|number| number.to_le_bytes()));
    }
}

pub(super) fn decode(reader: &mut Reader<'_>, rays: usize, lines: &mut Vec<RayLine>) -> Result<(), String> {
    for _ in 0..rays {
        let bytes: [u8; LINE_BYTES] = reader.fixed()?;
        let number = |at: usize| {
            f32::from_le_bytes([bytes[4 * at], bytes[4 * at + 1], bytes[4 * at + 2], bytes[4 * at + 3]])
        };
        let [origin, direction] = [0, 3].map(|first| [number(first), number(first + 1), number(first + 2)]);
        if !origin.iter().chain(&direction).all(|number| number.is_finite()) || direction == [0.0; 3] {
            return Err(format!("a reflection ray from {origin:?} along {direction:?}"));
        }
        lines.push(RayLine { origin, direction });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8], rays: usize) -> Result<Vec<RayLine>, String> {
        let mut reader = Reader { bytes, position: 0 };
        let mut lines = Vec::new();
        decode(&mut reader, rays, &mut lines)?;
        reader.finish()?;
        Ok(lines)
    }

    #[test]
    fn lines_round_trip_and_those_that_are_none_are_refused() {
        let line = |x: f32| RayLine { origin: [x, -2.5, 1e30], direction: [0.0, x, -0.0] };
        let lines = vec![line(1.0), line(-3e-40)];
        let mut bytes = Vec::new();
        encode(&lines, &mut bytes);
        assert_eq!(decoded(&bytes, 2), Ok(lines));
        assert!(decoded(&bytes, 1).expect_err("one too few").contains("left over"));
        assert!(decoded(&bytes, 3).expect_err("one too many").contains("end inside"));
        assert!(decoded(&bytes[..47], 2).expect_err("torn").contains("end inside"));
        for wrong in [line(f32::NAN), line(f32::INFINITY), line(0.0)] {
            let mut bytes = Vec::new();
            encode(&[wrong], &mut bytes);
            assert!(decoded(&bytes, 1).expect_err("no line").contains("a reflection ray from"), "{wrong:?}");
        }
    }
}
