//! Numbers that look random and are always the same.

/// The finaliser of SplitMix64 (Steele et al. 2014): every bit of `value` flips every bit of the result half of the time.
pub(crate) fn hash(value: u64) -> u64 {
    let mut mixed = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ mixed >> 31
}

/// A number below `end`, from the upper bits of a hash.
pub(crate) fn below(end: u64, value: u64) -> u64 {
    ((u128::from(hash(value)) * u128::from(end)) >> 64) as u64
}

/// A number from 0 to below 1, from the upper bits of a hash.
pub(crate) fn fraction(value: u64) -> f64 {
    (hash(value) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Bits of each half of a page's number.
const HALF_BITS: u32 = 11;

/// Another page for each page below 2^22: a Feistel network, which can be undone, so that no two pages meet.
pub(crate) fn scattered(page: u64) -> u64 {
    const MASK: u64 = (1 << HALF_BITS) - 1;
    let (mut left, mut right) = (page >> HALF_BITS & MASK, page & MASK);
    for round in 0..4 {
        (left, right) = (right, left ^ hash(round << HALF_BITS | right) & MASK);
    }
    page >> (2 * HALF_BITS) << (2 * HALF_BITS) | left << HALF_BITS | right
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_pages_never_meet_and_do_not_stay_neighbours() {
        let pages = 1_usize << 18;
        let mut found: Vec<u64> = (0..pages as u64).map(scattered).collect();
        let neighbours = found.windows(2).filter(|pair| pair[0].abs_diff(pair[1]) == 1).count();
        assert!(neighbours < pages / 1000, "{neighbours}");
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), pages);
    }

    #[test]
    fn numbers_below_a_limit_fill_it_evenly() {
        let mut bins = [0_u32; 32];
        (0..32_000).for_each(|value| bins[below(32, value) as usize] += 1);
        assert!(bins.iter().all(|&bin| (850..1150).contains(&bin)), "{bins:?}");
    }
}
