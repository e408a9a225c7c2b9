//! Caches one behind the other, and the paths that accesses take through them.

use crate::address::{Access, LineId, LineSize};
use crate::config::{Levels, WriteMiss, WritePolicy};
use crate::counts::{LevelCounts, MemoryCounts, MemoryRequest, Missed, Served};
use crate::engine::Engine;
use crate::error::{Error, Place};
use crate::isa::Isa;
use crate::ledger::{ByClass, Follow, Ledger};
use crate::level::{Below, Rescale, WriteRule};
use crate::tlb::{Tlb, TlbConfig};

/// One of the paths that a [`Hierarchy`] was built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PathId(pub(crate) u16);

/// A way through the hierarchy: from `entry` along each level's level below.
#[derive(Clone, Debug)]
struct Path {
    levels: Vec<usize>,
    granule: LineSize,
}

/// A set of caches in front of one memory, simulated exactly and in order.
///
/// A **path** is the list of levels that one kind of access goes through; what misses in the last goes to
/// memory. Every level has one level below it, the same on every path, where its write-backs go too. A
/// **unit** is a requester; a level with several copies shares them out evenly over neighbouring units.
/// Copies are not kept coherent, and no level invalidates lines of another (neither inclusive nor
/// exclusive).
///
/// A miss first reads its line from below and then writes back the line it evicts.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    levels: Levels,
    paths: Vec<Path>,
    below: Vec<Option<Below>>,
    isa: Isa,
    tlb: Option<TlbConfig>,
    width: Width,
}

/// Narrow until a line number does not fit.
#[derive(Clone, Debug)]
enum Width {
    Narrow(Engine<u32>),
    Wide(Engine<u64>),
}

impl Hierarchy {
    /// One path through all levels, in order.
    ///
    /// # Errors
    /// If two neighbouring levels do not fit together.
    pub fn chain(levels: &Levels) -> Result<(Self, PathId), Error> {
        let all: Vec<usize> = (0..levels.as_slice().len()).collect();
        let (hierarchy, paths) = Self::with_paths(levels, &[&all])?;
        Ok((hierarchy, paths[0]))
    }

    /// Several paths, each a list of indices into `levels`; the ids come back in the same order.
    ///
    /// # Errors
    /// If a path is empty, names a level that does not exist, goes towards the requester, or gives a
    /// level another level below than a path before it; and if a level has more copies than, or does not
    /// serve whole copies of, the one above it.
    pub fn with_paths(levels: &Levels, paths: &[&[usize]]) -> Result<(Self, Vec<PathId>), Error> {
        let configs = levels.as_slice();
        let mut below: Vec<Option<Option<usize>>> = vec![None; configs.len()];
        for path in paths {
            check_path(levels, path, &mut below)?;
        }
        let below: Vec<Option<Below>> = below
            .iter()
            .zip(configs)
            .map(|(below, above)| {
                let level = (*below)??;
                let whole = above.write == WritePolicy::Back
                    && above.write_miss != WriteMiss::Around
                    && above.granule() >= configs[level].granule();
                Some(Below {
                    level,
                    rescale: Rescale::between(above, &configs[level]),
                    rule: WriteRule::new(&configs[level], whole),
                })
            })
            .collect();
        let paths: Vec<Path> = paths
            .iter()
            .map(|path| Path { levels: path.to_vec(), granule: configs[path[0]].granule() })
            .collect();
        let ids = (0..paths.len() as u16).map(PathId).collect();
        let isa = Isa::best();
        let width = Width::Narrow(Engine::new(levels, &below, isa));
        Ok((Self { levels: levels.clone(), paths, below, isa, tlb: None, width }, ids))
    }

    /// Reads the lines in order, on behalf of one unit. Lines are counted in [`Self::granule`]s of the path;
    /// numbers beyond the end of the address space begin again at its start.
    ///
    /// # Panics
    /// If `unit` is not below [`Self::units`], or `path` is of another hierarchy with more paths.
    #[inline]
    pub fn read(&mut self, path: PathId, unit: u32, lines: &[LineId]) -> Served {
        self.total(path, unit, lines, |line| (line.get(), false))
    }

    /// Writes the lines in order; otherwise as [`Self::read`].
    ///
    /// # Panics
    /// As [`Self::read`].
    #[inline]
    pub fn write(&mut self, path: PathId, unit: u32, lines: &[LineId]) -> Served {
        self.total(path, unit, lines, |line| (line.get(), true))
    }

    /// Reads and writes in order; otherwise as [`Self::read`].
    ///
    /// # Panics
    /// As [`Self::read`].
    #[inline]
    pub fn access(&mut self, path: PathId, unit: u32, accesses: &[Access]) -> Served {
        self.total(path, unit, accesses, Access::parts)
    }

    /// As [`Self::access`], for accesses of several classes in one go: `classes[i]` is that of `accesses[i]`, and what the accesses of
    /// class `c` cause is added to `served[c]`, and to `missed` which of `accesses` missed where. A dirty line's way down counts for the access that evicts it.
    ///
    /// # Panics
    /// As [`Self::read`]; or if there are not as many classes as accesses, or `served` has no place for one of them.
    pub fn access_by_class(
        &mut self,
        path: PathId,
        unit: u32,
        accesses: &[Access],
        classes: &[u8],
        served: &mut [Served],
        missed: &mut Missed,
    ) {
        assert_eq!(accesses.len(), classes.len(), "every access has a class");
        self.run(path, unit, accesses, Access::parts, &mut ByClass::new(classes, served, missed));
    }

    /// One access, and where it went: adds to `requests` what it reads from and writes to memory, its own line first. The second
    /// answer is the number of levels of the path that did not have its data.
    ///
    /// # Panics
    /// As [`Self::read`].
    pub fn follow(
        &mut self,
        path: PathId,
        unit: u32,
        access: Access,
        requests: &mut Vec<MemoryRequest>,
    ) -> (Served, usize) {
        let mut ledger = Follow::new(requests);
        self.run(path, unit, &[access], Access::parts, &mut ledger);
        (ledger.served, ledger.missed)
    }

    #[inline]
    fn total<T: Copy>(
        &mut self,
        path: PathId,
        unit: u32,
        items: &[T],
        split: impl Fn(T) -> (u64, bool) + Copy,
    ) -> Served {
        let mut served = Served::default();
        self.run(path, unit, items, split, &mut served);
        served
    }

    #[inline]
    fn run<T: Copy>(
        &mut self,
        path: PathId,
        unit: u32,
        items: &[T],
        split: impl Fn(T) -> (u64, bool) + Copy,
        ledger: &mut impl Ledger,
    ) {
        let Path { levels, granule } = &self.paths[usize::from(path.0)];
        let (entry, last) = (levels[0], granule.last_line().get());
        let split = |item| {
            let (line, write) = split(item);
            (line & last, write)
        };
        let mut rest = items;
        if let Width::Narrow(engine) = &mut self.width {
            rest = engine.run(entry, unit, items, split, ledger);
            if rest.is_empty() {
                return;
            }
        }
        self.widen().run(entry, unit, rest, split, ledger);
    }

    fn widen(&mut self) -> &mut Engine<u64> {
        if let Width::Narrow(engine) = &mut self.width {
            self.width = Width::Wide(std::mem::take(engine).widened());
        }
        match &mut self.width {
            Width::Wide(engine) => engine,
            Width::Narrow(_) => unreachable!("widened above"),
        }
    }

    /// Writes all dirty lines back, level by level down to memory, as at the end of a frame: the copies of
    /// a level in turn, each in order of addresses. Lines stay, clean. The positions in the answer are level indices.
    pub fn flush(&mut self) -> Served {
        match &mut self.width {
            Width::Narrow(engine) => engine.flush(),
            Width::Wide(engine) => engine.flush(),
        }
    }

    /// Back to empty caches and zero counts.
    pub fn reset(&mut self) {
        let mut engine = Engine::new(&self.levels, &self.below, self.isa);
        engine.set_tlb(self.tlb.map(Tlb::new));
        self.width = Width::Narrow(engine);
    }

    /// The same hierarchy, empty, with a TLB between the last level and memory: what reaches memory is translated, but for lines
    /// that a flush writes back from the last level. It changes no count but [`Self::page_walks`].
    #[must_use]
    pub fn with_tlb(mut self, tlb: TlbConfig) -> Self {
        self.tlb = Some(tlb);
        self.reset();
        self
    }

    /// The same hierarchy, empty, simulated with the instructions of `isa` instead of [`Isa::best`]: for
    /// measurements and tests.
    #[must_use]
    pub fn on(mut self, isa: Isa) -> Self {
        self.isa = isa;
        self.reset();
        self
    }

    /// The levels, as given.
    #[must_use]
    pub fn levels(&self) -> &Levels {
        &self.levels
    }

    /// The number of requesters.
    #[must_use]
    pub fn units(&self) -> u32 {
        self.levels.units()
    }

    /// The size of what a line number means on this path: the sector of its first level, or else the line.
    #[must_use]
    pub fn granule(&self, path: PathId) -> LineSize {
        self.paths[usize::from(path.0)].granule
    }

    /// The level indices along a path.
    #[must_use]
    pub fn path(&self, path: PathId) -> &[usize] {
        &self.paths[usize::from(path.0)].levels
    }

    /// Totals of a level since the start or the last reset.
    #[must_use]
    pub fn counts(&self, level: usize) -> LevelCounts {
        match &self.width {
            Width::Narrow(engine) => engine.counts(level),
            Width::Wide(engine) => engine.counts(level),
        }
    }

    /// Pages that were walked for since the start or the last reset; 0 without a TLB.
    #[must_use]
    pub fn page_walks(&self) -> u64 {
        match &self.width {
            Width::Narrow(engine) => engine.page_walks(),
            Width::Wide(engine) => engine.page_walks(),
        }
    }

    /// Totals of memory since the start or the last reset.
    #[must_use]
    pub fn memory(&self) -> MemoryCounts {
        match &self.width {
            Width::Narrow(engine) => engine.memory(),
            Width::Wide(engine) => engine.memory(),
        }
    }
}

/// Records each level's level below in `below` and refuses a path that does not fit.
fn check_path(levels: &Levels, path: &[usize], below: &mut [Option<Option<usize>>]) -> Result<(), Error> {
    let configs = levels.as_slice();
    let at = |level: usize| Place {
        level: Some((level + 1, configs.get(level).map(|config| config.name.clone()))),
        ..Place::default()
    };
    if path.is_empty() {
        return Err(Error::levels(Place::default(), "a path has no levels", "name at least one level"));
    }
    for (position, &level) in path.iter().enumerate() {
        if level >= configs.len() {
            return Err(Error::levels(
                at(level),
                format!("a path names level {level}, expected less than {}", configs.len()),
                "name levels that exist",
            ));
        }
        let next = path.get(position + 1).copied();
        if let Some(next) = next.filter(|&next| next < configs.len()) {
            if next <= level {
                return Err(Error::levels(
                    at(level),
                    format!(
                        "a path goes on to \"{}\", which is not further from the requester",
                        configs[next].name
                    ),
                    "list levels from the requester to memory, in the paths as in the description",
                ));
            }
            if !configs[level].count.is_multiple_of(configs[next].count) {
                return Err(Error::levels(
                    at(next),
                    format!(
                        "{} copies cannot serve the {} copies of \"{}\" evenly",
                        configs[next].count, configs[level].count, configs[level].name
                    ),
                    "make count a divisor of the count of every level above it",
                ));
            }
        }
        if below[level].is_some_and(|known| known != next) {
            return Err(Error::levels(
                at(level),
                "two paths leave this level for different ones, expected one level below it".to_owned(),
                "let all paths that share a level share the rest of the way",
            ));
        }
        below[level] = Some(next);
    }
    Ok(())
}
