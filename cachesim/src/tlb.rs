//! Translation of addresses behind the last cache.

/// A translation look-aside buffer: it knows the pages used last; the address of any other has to be walked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TlbConfig {
    /// Bytes of a page, a power of two.
    pub page_bytes: u64,
    /// Pages that it knows at once, at least 1. Each translation takes time proportional to it here.
    pub entries: u32,
}

/// A fully associative TLB that replaces the page least recently used.
#[derive(Clone, Debug)]
pub(crate) struct Tlb {
    shift: u32,
    /// The page used last comes first; at most `entries`.
    pages: Vec<u64>,
    entries: usize,
    walks: u64,
}

impl Tlb {
    pub(crate) fn new(config: TlbConfig) -> Self {
        let entries = config.entries.max(1) as usize;
        Self {
            shift: config.page_bytes.max(1).ilog2(),
            pages: Vec::with_capacity(entries),
            entries,
            walks: 0,
        }
    }

    /// Translates an address; true if its page has to be walked for.
    pub(crate) fn translate(&mut self, address: u64) -> bool {
        let page = address >> self.shift;
        let known = self.pages.iter().position(|&known| known == page);
        match known {
            Some(place) => self.pages[..=place].rotate_right(1),
            None => {
                self.pages.truncate(self.entries - 1);
                self.pages.insert(0, page);
                self.walks += 1;
            }
        }
        known.is_none()
    }

    pub(crate) fn walks(&self) -> u64 {
        self.walks
    }
}
