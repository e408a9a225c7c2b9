//! Who hears what a run caused.

use crate::counts::{LevelServed, MemoryCounts, MemoryRequest, Missed, Served};
use crate::word::Word;
use std::ops::Range;

/// Follows a run down its path, level by level.
pub(crate) trait Ledger {
    /// Whether [`Self::level`] looks at who missed and who caused what.
    const TRACED: bool;

    /// The next `len` accesses of the run enter.
    fn enter(&mut self, len: usize);

    /// `len` requests went through the level at a position of the path. `missed` and `causes` are those of
    /// [`Out`](crate::out::Out), cut to what there was.
    fn level(&mut self, position: usize, len: usize, misses: u64, trail: Trail<'_>);

    /// Each request becomes `1 << bits`.
    fn split(&mut self, bits: u32);

    /// The requests reach the memory; `walks` says which of them have to walk for a page, and is empty without a TLB.
    fn memory<W: Word>(&mut self, requests: &[W], granule_bytes: u64, walks: &[bool]);
}

/// Positions among the requests that entered a level.
pub(crate) struct Trail<'a> {
    pub(crate) missed: &'a [u32],
    /// Of each request that goes below.
    pub(crate) causes: &'a [u32],
}

impl Ledger for Served {
    const TRACED: bool = false;

    fn enter(&mut self, _len: usize) {}

    #[inline(always)]
    fn level(&mut self, position: usize, len: usize, misses: u64, _trail: Trail<'_>) {
        let LevelServed { accesses, misses: sum } = &mut self.levels[position];
        *accesses += len as u64;
        *sum += misses;
    }

    fn split(&mut self, _bits: u32) {}

    fn memory<W: Word>(&mut self, requests: &[W], granule_bytes: u64, _walks: &[bool]) {
        self.memory.add(&memory_traffic(requests, granule_bytes));
    }
}

/// Tells what accesses of several classes caused, and which missed where.
pub(crate) struct ByClass<'a> {
    /// Of all accesses.
    classes: &'a [u8],
    /// Those on their way are among these.
    entered: Range<usize>,
    /// The requests on their way are the accesses themselves, in order.
    at_entry: bool,
    /// Otherwise, of each of them, the access that caused it.
    causes: Vec<u32>,
    next: Vec<u32>,
    served: &'a mut [Served],
    missed: &'a mut Missed,
}

impl<'a> ByClass<'a> {
    /// `classes` are those of all accesses; what class `c` causes is added to `served[c]`.
    pub(crate) fn new(classes: &'a [u8], served: &'a mut [Served], missed: &'a mut Missed) -> Self {
        Self { classes, entered: 0..0, at_entry: true, causes: Vec::new(), next: Vec::new(), served, missed }
    }

    /// The access that caused a request on its way.
    #[inline(always)]
    fn cause(&self, request: u32) -> u32 {
        if self.at_entry { self.entered.start as u32 + request } else { self.causes[request as usize] }
    }
}

impl Ledger for ByClass<'_> {
    const TRACED: bool = true;

    fn enter(&mut self, len: usize) {
        self.entered = self.entered.end..self.entered.end + len;
        self.at_entry = true;
    }

    fn level(&mut self, position: usize, _len: usize, _misses: u64, trail: Trail<'_>) {
        if self.at_entry {
            for &class in &self.classes[self.entered.clone()] {
                self.served[usize::from(class)].levels[position].accesses += 1;
            }
        } else {
            for &cause in &self.causes {
                self.served[usize::from(self.classes[cause as usize])].levels[position].accesses += 1;
            }
        }
        for &request in trail.missed {
            let cause = self.cause(request);
            self.served[usize::from(self.classes[cause as usize])].levels[position].misses += 1;
            self.missed.levels[position].push(cause);
        }
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        next.extend(trail.causes.iter().map(|&request| self.cause(request)));
        self.next = std::mem::replace(&mut self.causes, next);
        self.at_entry = false;
    }

    fn split(&mut self, bits: u32) {
        self.next.clear();
        self.next.extend(self.causes.iter().flat_map(|&cause| std::iter::repeat_n(cause, 1 << bits)));
        std::mem::swap(&mut self.causes, &mut self.next);
    }

    fn memory<W: Word>(&mut self, requests: &[W], granule_bytes: u64, _walks: &[bool]) {
        for (request, &cause) in requests.iter().zip(&self.causes) {
            if !request.flagged() {
                self.missed.memory.push(cause);
            }
            let class = self.classes[cause as usize];
            self.served[usize::from(class)].memory.add(&memory_traffic(&[*request], granule_bytes));
        }
    }
}

/// Follows one access to memory.
pub(crate) struct Follow<'a> {
    pub(crate) served: Served,
    /// Levels of the path that did not have its data.
    pub(crate) missed: usize,
    /// The access itself, and not only what it caused, is on its way.
    present: bool,
    requests: &'a mut Vec<MemoryRequest>,
}

impl<'a> Follow<'a> {
    /// Adds to `requests` what reaches memory.
    pub(crate) fn new(requests: &'a mut Vec<MemoryRequest>) -> Self {
        Self { served: Served::default(), missed: 0, present: true, requests }
    }
}

impl Ledger for Follow<'_> {
    const TRACED: bool = true;

    fn enter(&mut self, _len: usize) {}

    fn level(&mut self, position: usize, len: usize, misses: u64, trail: Trail<'_>) {
        self.served.level(position, len, misses, Trail { missed: &[], causes: &[] });
        // An access goes first, and what it evicts behind it.
        self.present &= trail.missed.first() == Some(&0);
        self.missed += usize::from(self.present);
    }

    fn split(&mut self, _bits: u32) {}

    fn memory<W: Word>(&mut self, requests: &[W], granule_bytes: u64, walks: &[bool]) {
        self.served.memory(requests, granule_bytes, walks);
        let walks = walks.iter().copied().chain(std::iter::repeat(false));
        let of = |(word, walks): (&W, bool)| MemoryRequest {
            address: word.id().saturating_mul(granule_bytes),
            bytes: granule_bytes as u32,
            write: word.flagged(),
            walks,
        };
        self.requests.extend(requests.iter().zip(walks).map(of));
    }
}

/// What requests are to the memory.
pub(crate) fn memory_traffic<W: Word>(requests: &[W], granule_bytes: u64) -> MemoryCounts {
    let writes = requests.iter().filter(|word| word.flagged()).count() as u64;
    let reads = requests.len() as u64 - writes;
    MemoryCounts { reads, writes, read_bytes: reads * granule_bytes, write_bytes: writes * granule_bytes }
}
