//! Weights of a sample, changed so that it has what is known of the frame.

/// Shares of a block in what is known of the frame in advance; those of all blocks add up to 1, or to 0 where nothing is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Auxiliary(pub(super) [f64; KNOWN]);

/// Numbers that are known.
const KNOWN: usize = 3;
/// The one that a sample has as much of as the frame where it cannot have all: the bytes of all steps.
const BYTES: usize = 1;
/// The part of a number's sum of squares that others do not explain, below which it tells nothing new.
const ALIKE: f64 = 1e-6;

impl Auxiliary {
    pub(super) fn add(&mut self, numbers: [f64; KNOWN], weight: f64) {
        self.0.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += weight * number);
    }
}

/// A block of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Member {
    pub(super) known: Auxiliary,
    pub(super) weight: f64,
    /// The variance of what it counts is taken to be in proportion to this; above 0 where it is not certain.
    pub(super) size: f64,
    /// It stands for itself, and keeps its weight.
    pub(super) certain: bool,
}

/// Weights with which the members have as much of each known number as all blocks, of which `all` is the sum (Deville and Särndal
/// 1992, linear distance). They stay as near to the old ones as that allows, and none is below 0.
pub(super) fn calibrated(all: Auxiliary, members: &[Member]) -> Vec<f64> {
    let Auxiliary(mut lacks) = all;
    let mut moments = [[0.0; KNOWN]; KNOWN];
    for &Member { known: Auxiliary(known), weight, size, certain } in members {
        lacks.iter_mut().zip(known).for_each(|(lack, known)| *lack -= weight * known);
        if !certain {
            for (row, of_row) in moments.iter_mut().zip(known) {
                row.iter_mut()
                    .zip(known)
                    .for_each(|(moment, known)| *moment += weight * of_row * known / size);
            }
        }
    }
    let multipliers = solved(moments, lacks);
    let factor = |&Member { known: Auxiliary(known), size, .. }: &Member| {
        1.0 + known.iter().zip(multipliers).map(|(known, multiplier)| known * multiplier).sum::<f64>() / size
    };
    let drawn = || members.iter().filter(|member| !member.certain);
    // Where that asks for less than nothing of a member, the sample is too unlike the frame: then it has as much but of one number.
    let bytes: f64 = drawn().map(|member| member.weight * member.known.0[BYTES]).sum();
    let ratio = if bytes > 0.0 { (1.0 + lacks[BYTES] / bytes).max(0.0) } else { 1.0 };
    let calibrates = drawn().all(|member| factor(member) >= 0.0);
    let new = |member: &Member| {
        let factor = if calibrates { factor(member) } else { ratio };
        if member.certain { member.weight } else { member.weight * factor }
    };
    members.iter().map(new).collect()
}

/// Solves for the numbers that are not explained by those before them; the multipliers of the others are 0.
fn solved(mut moments: [[f64; KNOWN]; KNOWN], mut right: [f64; KNOWN]) -> [f64; KNOWN] {
    let squares: [f64; KNOWN] = std::array::from_fn(|number| moments[number][number]);
    let used =
        |moments: &[[f64; KNOWN]; KNOWN], number: usize| moments[number][number] > ALIKE * squares[number];
    for number in 0..KNOWN {
        if !used(&moments, number) {
            continue;
        }
        let (row, of_row) = (moments[number], right[number]);
        for below in number + 1..KNOWN {
            let factor = moments[below][number] / row[number];
            moments[below].iter_mut().zip(row).for_each(|(moment, of_row)| *moment -= factor * of_row);
            right[below] -= factor * of_row;
        }
    }
    let mut multipliers = [0.0; KNOWN];
    for number in (0..KNOWN).rev().filter(|&number| used(&moments, number)) {
        let others: f64 = (number + 1..KNOWN).map(|other| moments[number][other] * multipliers[other]).sum();
        multipliers[number] = (right[number] - others) / moments[number][number];
    }
    multipliers
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn member(known: [f64; KNOWN], weight: f64) -> Member {
        Member { known: Auxiliary(known), weight, size: 1.0, certain: false }
    }

    fn sums(members: &[Member], weights: &[f64]) -> [f64; KNOWN] {
        let of = |number: usize| members.iter().zip(weights).map(|(m, w)| m.known.0[number] * w).sum();
        std::array::from_fn(of)
    }

    #[test]
    fn numbers_that_tell_nothing_new_are_not_asked_for() {
        // The second is twice the first, the third is 0.
        let members: Vec<_> = (1..9).map(|n| member([f64::from(n), 2.0 * f64::from(n), 0.0], 3.0)).collect();
        let weights = calibrated(Auxiliary([120.0, 240.0, 0.0]), &members);
        let [first, second, _] = sums(&members, &weights);
        assert!((first - 120.0).abs() < 1e-9 && (second - 240.0).abs() < 1e-9);
    }

    #[test]
    fn a_sample_that_is_too_unlike_the_frame_has_as_much_of_its_bytes() {
        let members = [member([1.0, 1.0, 1.0], 3.0), member([1.0, 2.0, 1.0], 3.0)];
        let weights = calibrated(Auxiliary([6.0, 30.0, 6.0]), &members);
        assert!((sums(&members, &weights)[BYTES] - 30.0).abs() < 1e-9, "{weights:?}");
        assert!((weights[0] - weights[1]).abs() < 1e-9);
    }

    #[test]
    fn who_is_certain_keeps_the_weight() {
        let mut members: Vec<_> =
            (1..9).map(|n| member([1.0, f64::from(n), f64::from(n * n)], 2.0)).collect();
        members[0].certain = true;
        members[0].weight = 1.0;
        let weights = calibrated(Auxiliary([15.5, 74.0, 425.0]), &members);
        assert_eq!(weights[0], 1.0);
        for (sum, expected) in sums(&members, &weights).into_iter().zip([15.5, 74.0, 425.0]) {
            assert!((sum / expected - 1.0).abs() < 1e-9, "{weights:?}");
        }
    }

    proptest! {
        #[test]
        fn any_members_get_weights_that_are_numbers(
            known in prop::collection::vec(prop::array::uniform3(0.0_f64..1.0), 0..20),
            all in prop::array::uniform3(0.0_f64..1.0),
        ) {
            let members: Vec<_> = known.into_iter().map(|known| member(known, 5.0)).collect();
            let weights = calibrated(Auxiliary(all), &members);
            prop_assert!(weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0));
        }
    }
}
