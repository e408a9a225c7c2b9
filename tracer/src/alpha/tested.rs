//! Which triangles are alpha-tested.

use serde::{Deserialize, Serialize};

/// Which triangles of a scene are alpha-tested, in file order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestedTriangles {
    /// The first triangle and the number of each run, rising and apart.
    Runs(Vec<[u32; 2]>),
    /// The last two of each eight, where a scene that has none is forced to have some: a quarter, in which quads that are two triangles
    /// stay whole.
    OnePairInFour,
}

impl TestedTriangles {
    /// Those for which the items are true, one for each triangle.
    pub fn of(tested: impl IntoIterator<Item = bool>) -> Self {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for (triangle, _) in (0..).zip(tested).filter(|&(_, tested)| tested) {
            match runs.last_mut() {
                Some([first, count]) if *first + *count == triangle => *count += 1,
                _ => runs.push([triangle, 1]),
            }
        }
        Self::Runs(runs)
    }

    /// Whether a triangle is one of them.
    pub fn contains(&self, triangle: u32) -> bool {
        match self {
            Self::Runs(runs) => {
                let after = runs.partition_point(|&[first, _]| first <= triangle);
                after > 0 && triangle - runs[after - 1][0] < runs[after - 1][1]
            }
            Self::OnePairInFour => triangle % 8 >= 6,
        }
    }

    /// How many there are in a scene of so many triangles.
    pub fn count(&self, triangles: u32) -> u32 {
        match self {
            Self::Runs(runs) => runs.iter().map(|&[_, count]| count).sum(),
            Self::OnePairInFour => triangles / 8 * 2 + (triangles % 8).saturating_sub(6),
        }
    }

    pub(super) fn check(&self, triangles: u32) -> Result<(), String> {
        let Self::Runs(runs) = self else { return Ok(()) };
        let mut next = 0;
        for &[first, count] in runs {
            let end = u64::from(first) + u64::from(count);
            if u64::from(first) < next || count == 0 || end > u64::from(triangles) {
                return Err(format!(
                    "alpha-tested triangles from {first} on, {count} of them: runs in rising order among {triangles} triangles expected"
                ));
            }
            next = end;
        }
        Ok(())
    }

    /// The same for quick look-up.
    pub(super) fn set(&self, triangles: u32) -> TriangleSet {
        let mut words = vec![0_u64; (triangles as usize).div_ceil(64)];
        for triangle in (0..triangles).filter(|&triangle| self.contains(triangle)) {
            words[triangle as usize / 64] |= 1 << (triangle % 64);
        }
        TriangleSet { words }
    }
}

/// A bit for each triangle.
#[derive(Clone, Debug)]
pub(super) struct TriangleSet {
    words: Vec<u64>,
}

impl TriangleSet {
    #[inline]
    pub(super) fn contains(&self, triangle: u32) -> bool {
        self.words.get(triangle as usize / 64).is_some_and(|word| word >> (triangle % 64) & 1 != 0)
    }
}
