//! The steps of rays as bytes.
//!
//! Ids are stored as differences from the previous id of the same kind within the ray, so that neighbouring rays, which visit the
//! same nodes, leave the same bytes.

use super::codec::{Limits, Reader, push_varint, unzigzag, zigzag};
use crate::observe::Op;
use crate::trace::{RaySet, Step};

/// Ids of one kind lie near each other: which kind a step's id belongs to.
#[inline(always)]
fn kind(op: Op) -> usize {
    /// Looked up, because what comes next is hard to predict for a jump.
    const KIND_OF: [u8; Op::ALL.len()] = {
        let mut kinds = [0; Op::ALL.len()];
        let mut index = 0;
        while index < kinds.len() {
            kinds[index] = match Op::ALL[index] {
                Op::Node | Op::Up | Op::Restart => 0,
                Op::Primitive | Op::AnyHit => 1,
                Op::Push | Op::Pop => 2,
                Op::Instance => 3,
            };
            index += 1;
        }
        kinds
    };
    usize::from(KIND_OF[op as usize]) % KINDS
}

const KINDS: usize = 4;

pub(super) fn encode_steps(set: &RaySet, bytes: &mut Vec<u8>) {
    for ray in 0..set.ends.len() {
        let mut previous = [0_i64; KINDS];
        for step in &set.steps[set.range(ray)] {
            let previous = &mut previous[kind(step.op())];
            let id = i64::from(step.id());
            push_varint(bytes, zigzag(id - *previous) << 3 | step.op() as u64);
            *previous = id;
        }
    }
}

/// Decodes the steps of a set whose `ends` are known; rays lie in rows of `width`.
///
/// What begins with the same bytes is the same steps, so they are copied from the left or upper neighbour as far as that goes: on
/// coherent rays this is most of them.
pub(super) fn decode_steps(
    reader: &mut Reader<'_>,
    width: usize,
    limits: &Limits,
    set: &mut RaySet,
) -> Result<(), String> {
    let bytes = reader.bytes;
    let RaySet { steps, ends, .. } = set;
    // Where the bytes of each ray so far begin, and those of the next.
    let mut starts = Vec::with_capacity(ends.len() + 1);
    starts.push(reader.position);
    for (ray, &end) in ends.iter().enumerate() {
        let shared_with = |neighbour: usize| {
            let theirs = starts[neighbour]..starts[neighbour + 1];
            (shared_bytes(&bytes[theirs], &bytes[reader.position..]), neighbour)
        };
        let neighbours = [ray.checked_sub(1), ray.checked_sub(width)];
        let best = neighbours.into_iter().flatten().map(shared_with).max_by_key(|&(shared, _)| shared);
        let mut previous = [0_i64; KINDS];
        if let Some((shared, neighbour)) = best.filter(|&(shared, _)| shared > 0) {
            let own = steps.len();
            let start = if neighbour == 0 { 0 } else { ends[neighbour - 1] as usize };
            let shared = &bytes[reader.position..reader.position + shared];
            let (count, length) = whole_numbers(shared, end as usize - own);
            steps.extend_from_within(start..start + count);
            reader.position += length;
            if steps.len() < end as usize {
                previous = last_ids(&steps[own..]);
            }
        }
        while steps.len() < end as usize {
            let token = reader.token()?;
            let op = Op::ALL[(token & 7) as usize];
            let previous = &mut previous[kind(op)];
            *previous = previous.wrapping_add(unzigzag(token >> 3));
            let id = u32::try_from(*previous).ok().filter(|&id| id <= Step::MAX_ID && limits.allow(op, id));
            let Some(id) = id else {
                let limit = limits.ids[op as usize];
                return Err(format!("a {op:?} step with id {previous}, below {limit} expected"));
            };
            steps.push(Step::new(op, id));
        }
        starts.push(reader.position);
    }
    Ok(())
}

/// How many bytes at the beginning are the same.
fn shared_bytes(left: &[u8], right: &[u8]) -> usize {
    let words = left.as_chunks::<8>().0.iter().zip(right.as_chunks::<8>().0);
    let mut shared = 0;
    for (&left, &right) in words {
        let difference = u64::from_le_bytes(left) ^ u64::from_le_bytes(right);
        if difference != 0 {
            return shared + difference.trailing_zeros() as usize / 8;
        }
        shared += 8;
    }
    let rest = left[shared..].iter().zip(&right[shared..]);
    shared + rest.take_while(|(left, right)| left == right).count()
}

/// How many numbers end within `bytes`, at most `most`, and how many bytes they take.
fn whole_numbers(bytes: &[u8], most: usize) -> (usize, usize) {
    let ends = |byte: &u8| *byte < 0x80;
    // Sums of bytes, so that one instruction adds many; they stay below 256.
    let ends_of = |chunk: &[u8]| chunk.iter().map(|byte| u8::from(ends(byte))).sum::<u8>();
    let count = bytes.chunks(128).map(|chunk| usize::from(ends_of(chunk))).sum();
    if count <= most {
        (count, bytes.iter().rposition(ends).map_or(0, |last| last + 1))
    } else {
        let mut within = (0..).zip(bytes).filter(|(_, byte)| ends(byte)).map(|(at, _)| at + 1);
        (most, most.checked_sub(1).and_then(|last| within.nth(last)).unwrap_or(0))
    }
}

/// By kind, the id that the next one after `steps` is a difference from.
fn last_ids(steps: &[Step]) -> [i64; KINDS] {
    let mut ids = [0; KINDS];
    let mut missing = [true; KINDS];
    let mut kinds_left = KINDS;
    for step in steps.iter().rev() {
        let kind = kind(step.op());
        if std::mem::take(&mut missing[kind]) {
            ids[kind] = i64::from(step.id());
            kinds_left -= 1;
            if kinds_left == 0 {
                break;
            }
        }
    }
    ids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::NO_HIT;
    use proptest::prelude::*;

    fn limits() -> Limits {
        let ids = Op::ALL.map(|op| if op == Op::Instance { 0 } else { 5000 });
        Limits { ids, triangles: 10, plain_sets: vec![true], raster: false, any_hit_flags: 0, lines_of: None }
    }

    /// [`decode_steps`] without copies: ray by ray, number by number.
    fn decode_steps_singly(reader: &mut Reader<'_>, limits: &Limits, set: &mut RaySet) -> Result<(), String> {
        for &end in &set.ends {
            let mut previous = [0_i64; KINDS];
            while set.steps.len() < end as usize {
                let token = reader.varint()?;
                let op = Op::ALL[(token & 7) as usize];
                let id = &mut previous[kind(op)];
                *id = id.wrapping_add(unzigzag(token >> 3));
                let limit = limits.ids[op as usize];
                if *id < 0 || *id as u64 >= limit {
                    return Err(format!("a {op:?} step with id {id}, below {limit} expected"));
                }
                set.steps.push(Step::new(op, *id as u32));
            }
        }
        Ok(())
    }

    fn any_list(longest: usize) -> impl Strategy<Value = Vec<Step>> {
        let ops = [Op::Pop, Op::Restart, Op::Up, Op::Node, Op::Push, Op::Primitive, Op::Node, Op::AnyHit];
        let id = prop_oneof![0_u32..4, 0_u32..300, 0_u32..5000];
        let step = (0..ops.len(), id).prop_map(move |(op, id)| Step::new(ops[op], id));
        prop::collection::vec(step, 0..longest)
    }

    /// Rays each of which begins as an earlier one.
    fn like_rays() -> impl Strategy<Value = RaySet> {
        let ray = (any_list(8), 1_usize..9, 0_usize..60);
        prop::collection::vec(ray, 1..60).prop_map(|rays| {
            let mut set = RaySet::default();
            for (ray, (own, back, shared)) in rays.into_iter().enumerate() {
                let like = if back <= ray { set.range(ray - back) } else { 0..0 };
                let shared = shared.min(like.len());
                set.steps.extend_from_within(like.start..like.start + shared);
                set.steps.extend(own);
                set.end_ray(NO_HIT).expect("few steps");
            }
            set
        })
    }

    /// Both decoders on `bytes`, which follow the ends of `rays`.
    fn decoded_both_ways(bytes: &[u8], ends: &[u32], width: usize) -> [Result<(RaySet, usize), String>; 2] {
        let limits = limits();
        let decode = |singly: bool| {
            let mut reader = Reader { bytes, position: 0 };
            let mut set = RaySet { ends: ends.to_vec(), ..RaySet::default() };
            if singly {
                decode_steps_singly(&mut reader, &limits, &mut set)?;
            } else {
                decode_steps(&mut reader, width, &limits, &mut set)?;
            }
            Ok((set, reader.position))
        };
        [decode(false), decode(true)]
    }

    fn encoded_steps(rays: &RaySet) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode_steps(rays, &mut bytes);
        bytes
    }

    proptest! {
        #[test]
        fn steps_copied_from_neighbours_are_those_that_were_encoded(rays in like_rays(), width in 1_usize..9) {
            let bytes = encoded_steps(&rays);
            let [copied, singly] = decoded_both_ways(&bytes, &rays.ends, width);
            prop_assert_eq!(&copied, &singly);
            let (set, position) = copied.expect("sound");
            prop_assert_eq!(set.steps, rays.steps);
            prop_assert_eq!(position, bytes.len());
        }

        #[test]
        fn damaged_bytes_decode_to_the_same_steps_or_problem_with_and_without_copies(
            rays in like_rays(),
            width in 1_usize..9,
            (at, byte) in (any::<prop::sample::Index>(), any::<u8>()),
            kept in any::<prop::sample::Index>(),
            ends in any::<bool>(),
        ) {
            let mut bytes = encoded_steps(&rays);
            bytes.extend([0; 4]);
            *at.get_mut(&mut bytes) = byte;
            bytes.truncate(kept.index(2 * bytes.len()).max(1));
            let mut claimed = rays.ends.clone();
            if ends {
                let cut = kept.index(claimed.len());
                claimed[cut..].iter_mut().for_each(|end| *end += 2);
            }
            let [copied, singly] = decoded_both_ways(&bytes, &claimed, width);
            prop_assert_eq!(copied, singly);
        }
    }
}
