//! Walks for the addresses of pages.

use super::events::Promises;
use crate::config::Translation;
use std::collections::BTreeMap;

/// The memory management unit: so many walks at once, each for one page. Which pages it knows is decided elsewhere.
pub(super) struct Walks {
    page_shift: u32,
    walk_cycles: f64,
    /// When each walker is free.
    walkers: Vec<f64>,
    /// When the addresses of pages that are being walked for are known.
    known: BTreeMap<u64, f64>,
    due: Promises<u64>,
}

impl Walks {
    pub(super) fn new(translation: Translation, hz: f64) -> Self {
        Self {
            page_shift: translation.tlb.page_bytes.ilog2(),
            walk_cycles: translation.walk_seconds * hz,
            walkers: vec![0.0; translation.walks as usize],
            known: BTreeMap::new(),
            due: Promises::default(),
        }
    }

    /// When the address of a request is known that asks at `at`, and walks for its page unless that is known or on its way.
    pub(super) fn known(&mut self, address: u64, walks: bool, at: f64) -> f64 {
        while let Some(page) = self.due.pop_due(at) {
            if self.known.get(&page).is_some_and(|&known| known <= at) {
                self.known.remove(&page);
            }
        }
        let page = address >> self.page_shift;
        if walks {
            let first = self.walkers.iter_mut().min_by(|left, right| left.total_cmp(right));
            let ends = first.map_or(at, |free| {
                *free = free.max(at) + self.walk_cycles;
                *free
            });
            self.known.insert(page, ends);
            self.due.push(ends, page);
        }
        self.known.get(&page).copied().unwrap_or(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cachesim::TlbConfig;

    const PAGE: u64 = 4096;

    fn walks(at_once: u32) -> Walks {
        let tlb = TlbConfig { page_bytes: PAGE, entries: 8 };
        Walks::new(Translation { tlb, walk_seconds: 1e-7, walks: at_once }, 1e9)
    }

    #[test]
    fn walks_take_turns_as_far_as_there_are_not_more_at_once() {
        let ends = |at_once| {
            let mut walks = walks(at_once);
            [0, 1, 2].map(|page| walks.known(page * PAGE, true, 10.0))
        };
        assert_eq!(ends(1), [110.0, 210.0, 310.0]);
        assert_eq!(ends(2), [110.0, 110.0, 210.0]);
        assert_eq!(ends(3), [110.0; 3]);
    }

    #[test]
    fn a_page_that_is_on_its_way_is_awaited_and_one_that_is_known_is_not() {
        let mut walks = walks(1);
        assert_eq!(walks.known(7, true, 0.0), 100.0);
        assert_eq!(walks.known(PAGE - 1, false, 40.0), 100.0);
        assert_eq!(walks.known(PAGE - 1, false, 100.0), 100.0);
        assert_eq!(walks.known(0, false, 250.0), 250.0);
    }
}
