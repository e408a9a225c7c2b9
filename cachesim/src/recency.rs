//! A list of lines by recency or age, of any length: the order of a fully associative cache.

use crate::address::LineId;
use crate::dense::DenseIds;

const END: u32 = u32::MAX;

/// Up to `capacity` lines, the newest first. Lines keep their dense number after they leave, so memory
/// grows with the number of distinct lines.
#[derive(Clone, Debug)]
pub(crate) struct RecencyList {
    ids: DenseIds,
    links: Vec<Link>,
    newest: u32,
    oldest: u32,
    len: u64,
    capacity: u64,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    newer: u32,
    older: u32,
    listed: bool,
}

impl RecencyList {
    pub(crate) fn new(capacity: u64) -> Self {
        Self { ids: DenseIds::new(), links: Vec::new(), newest: END, oldest: END, len: 0, capacity }
    }

    /// The line's dense number, and whether this is its first touch ever.
    #[inline]
    pub(crate) fn number(&mut self, line: LineId) -> (u32, bool) {
        let id = self.ids.number(line);
        let first = id as usize == self.links.len();
        if first {
            self.links.push(Link { newer: END, older: END, listed: false });
        }
        (id, first)
    }

    #[inline]
    pub(crate) fn contains(&self, id: u32) -> bool {
        self.links[id as usize].listed
    }

    /// Makes a listed line the newest.
    #[inline]
    pub(crate) fn renew(&mut self, id: u32) {
        if self.newest != id {
            self.unlink(id);
            self.link(id);
        }
    }

    /// Lists a line as the newest; returns the oldest if it had to leave.
    #[inline]
    pub(crate) fn insert(&mut self, id: u32) -> Option<u32> {
        let evicted = (self.len == self.capacity).then_some(self.oldest);
        match evicted {
            Some(oldest) => self.unlink(oldest),
            None => self.len += 1,
        }
        self.link(id);
        evicted
    }

    fn link(&mut self, id: u32) {
        self.links[id as usize] = Link { newer: END, older: self.newest, listed: true };
        match self.newest {
            END => self.oldest = id,
            newest => self.links[newest as usize].newer = id,
        }
        self.newest = id;
    }

    fn unlink(&mut self, id: u32) {
        let Link { newer, older, .. } = self.links[id as usize];
        self.links[id as usize].listed = false;
        match newer {
            END => self.newest = older,
            newer => self.links[newer as usize].older = older,
        }
        match older {
            END => self.oldest = newer,
            older => self.links[older as usize].newer = newer,
        }
    }
}
