//! How a warp adds to counters in memory.

use std::ops::AddAssign;

/// How the lanes of a warp add one each to counters: variants of Calvo Lista 2026, "Ordering the RQ visibility buffer (optimizations)".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AtomicStrategy {
    /// Every lane adds one, all in one instruction.
    BruteForce,
    /// A loop over the distinct counters, in which all lanes of a counter add one: the address is uniform, as a compiler can see.
    Loop,
    /// The same loop, in which the first lane of a counter adds as much as lanes there are, and tells the others.
    Subgroup,
    /// The same atomics; the loop goes by a mask of the lanes that are left.
    Ballot,
}

/// What a compiler knows of the address that the lanes of a warp add to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// One counter for all.
    Uniform,
    /// Each lane computes its own.
    PerLane,
}

/// Atomics of one or of many warps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AtomicTally {
    /// Atomic instructions that warps issue; trips, where they loop.
    pub instructions: u64,
    /// Distinct counters that a warp adds to, over all warps.
    pub counters: u64,
    /// Atomics that reach memory where each lane's counts.
    pub atomics: u64,
    /// Atomics that reach memory where those of one instruction become one, if its address is uniform as a compiler can see.
    pub joined: u64,
}

impl AtomicStrategy {
    /// All four.
    pub const ALL: [Self; 4] = [Self::BruteForce, Self::Loop, Self::Subgroup, Self::Ballot];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::BruteForce => "brute-force",
            Self::Loop => "loop",
            Self::Subgroup => "subgroup",
            Self::Ballot => "ballot",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|strategy| strategy.name() == name)
    }

    /// Adds one to the counter that each lane of a warp names, and puts the value before into `found`, by lane.
    ///
    /// Lanes without a counter are idle. Counters that are not there are passed over: check before.
    pub(super) fn add(
        self,
        address: Address,
        lanes: &[Option<u32>],
        counters: &mut [u32],
        found: &mut Vec<Option<u32>>,
    ) -> AtomicTally {
        found.clear();
        found.resize(lanes.len(), None);
        match self {
            Self::BruteForce => Self::by_lanes(address, lanes, counters, found),
            Self::Loop | Self::Subgroup | Self::Ballot => self.by_counters(lanes, counters, found),
        }
    }

    /// One instruction, in which memory takes lane after lane.
    fn by_lanes(
        address: Address,
        lanes: &[Option<u32>],
        counters: &mut [u32],
        found: &mut [Option<u32>],
    ) -> AtomicTally {
        let mut tally = AtomicTally::default();
        for (lane, target) in lanes.iter().enumerate() {
            let Some(target) = *target else { continue };
            tally.atomics += 1;
            tally.counters += u64::from(!lanes[..lane].contains(&Some(target)));
            found[lane] = add(counters, target, 1);
        }
        tally.instructions = tally.atomics.min(1);
        tally.joined = match address {
            Address::Uniform => tally.instructions,
            Address::PerLane => tally.atomics,
        };
        tally
    }

    /// A trip for each counter, the first lane that is left names it.
    fn by_counters(
        self,
        lanes: &[Option<u32>],
        counters: &mut [u32],
        found: &mut [Option<u32>],
    ) -> AtomicTally {
        let mut tally = AtomicTally::default();
        for (lane, target) in lanes.iter().enumerate() {
            let Some(target) = *target else { continue };
            if lanes[..lane].contains(&Some(target)) {
                continue;
            }
            let together = (lane..lanes.len()).filter(|&other| lanes[other] == Some(target));
            let size = together.clone().count() as u32;
            let before = add(counters, target, size);
            together.zip(0..).for_each(|(lane, rank)| found[lane] = before.map(|before| before + rank));
            tally += AtomicTally {
                instructions: 1,
                counters: 1,
                atomics: if self == Self::Loop { u64::from(size) } else { 1 },
                joined: 1,
            };
        }
        tally
    }
}

/// The value before.
fn add(counters: &mut [u32], counter: u32, amount: u32) -> Option<u32> {
    let counter = counters.get_mut(counter as usize)?;
    let before = *counter;
    *counter += amount;
    Some(before)
}

impl AtomicTally {
    /// The add of one lane.
    pub(super) const ONE: Self = Self { instructions: 1, counters: 1, atomics: 1, joined: 1 };

    /// Atomics that reach memory, where those of one instruction on a uniform address are or are not joined into one.
    pub fn reaching_memory(&self, joins_uniform: bool) -> u64 {
        if joins_uniform { self.joined } else { self.atomics }
    }
}

impl AddAssign for AtomicTally {
    fn add_assign(&mut self, other: Self) {
        let Self { instructions, counters, atomics, joined } = other;
        self.instructions += instructions;
        self.counters += counters;
        self.atomics += atomics;
        self.joined += joined;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COUNTERS: usize = 5;

    fn run(
        strategy: AtomicStrategy,
        address: Address,
        lanes: &[Option<u32>],
    ) -> (AtomicTally, Vec<u32>, Vec<Option<u32>>) {
        let mut counters = vec![0; COUNTERS];
        let mut found = Vec::new();
        let tally = strategy.add(address, lanes, &mut counters, &mut found);
        (tally, counters, found)
    }

    #[test]
    fn a_warp_of_two_counters_does_what_the_variants_say() {
        let lanes = [Some(3), None, Some(1), Some(3), Some(3)];
        let tally = |strategy| run(strategy, Address::PerLane, &lanes).0;
        let counters = 2;
        assert_eq!(
            tally(AtomicStrategy::BruteForce),
            AtomicTally { instructions: 1, counters, atomics: 4, joined: 4 }
        );
        assert_eq!(
            tally(AtomicStrategy::Loop),
            AtomicTally { instructions: 2, counters, atomics: 4, joined: 2 }
        );
        assert_eq!(
            tally(AtomicStrategy::Subgroup),
            AtomicTally { instructions: 2, counters, atomics: 2, joined: 2 }
        );
        assert_eq!(tally(AtomicStrategy::Ballot), tally(AtomicStrategy::Subgroup));
    }

    #[test]
    fn a_counter_that_the_compiler_knows_is_joined_without_a_loop() {
        let tally = run(AtomicStrategy::BruteForce, Address::Uniform, &[Some(0), Some(0), None, Some(0)]).0;
        assert_eq!(tally, AtomicTally { instructions: 1, counters: 1, atomics: 3, joined: 1 });
        assert_eq!((tally.reaching_memory(true), tally.reaching_memory(false)), (1, 3));
    }

    #[test]
    fn an_idle_warp_does_nothing() {
        for strategy in AtomicStrategy::ALL {
            assert_eq!(run(strategy, Address::Uniform, &[None; 4]).0, AtomicTally::default());
        }
    }

    #[test]
    fn names_are_told_apart() {
        for strategy in AtomicStrategy::ALL {
            assert_eq!(AtomicStrategy::from_name(strategy.name()), Some(strategy));
        }
        assert_eq!(AtomicStrategy::from_name("brute force"), None);
    }

    proptest! {
        #[test]
        fn all_variants_count_the_same_and_give_each_lane_its_own_place(
            lanes in prop::collection::vec(prop::option::of(0..COUNTERS as u32), 0..64),
        ) {
            let (_, expected, places) = run(AtomicStrategy::BruteForce, Address::PerLane, &lanes);
            for counter in 0..COUNTERS as u32 {
                let of_counter = lanes.iter().zip(&places).filter(|(lane, _)| **lane == Some(counter));
                let ranks: Vec<u32> = of_counter.filter_map(|(_, place)| *place).collect();
                prop_assert!(ranks.iter().copied().eq(0..expected[counter as usize]));
            }
            for strategy in AtomicStrategy::ALL {
                let (tally, counters, found) = run(strategy, Address::PerLane, &lanes);
                prop_assert_eq!(&counters, &expected);
                prop_assert_eq!(&found, &places);
                let distinct = expected.iter().filter(|&&count| count > 0).count() as u64;
                prop_assert_eq!(tally.counters, distinct);
                prop_assert!(distinct <= tally.joined && tally.joined <= tally.atomics);
            }
        }
    }
}
