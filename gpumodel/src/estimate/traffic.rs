//! What moves between the cores and memory: by pass, by what the buffer holds, and by level.

use crate::config::{CacheRole, Gpu};
use crate::counters::{BufferTraffic, FrameCounters, Pass};
use crate::replay::ReplayConfig;

/// What one pass moves for one kind of buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrafficEstimate {
    /// Which pass.
    pub pass: Pass,
    /// What the buffers hold.
    pub buffer: &'static str,
    /// The caches that were asked, from the cores to memory.
    pub levels: Vec<LevelTraffic>,
    /// Bytes read from memory.
    pub dram_read_bytes: u64,
    /// Bytes written to memory by lines that these accesses drove out, whoever wrote them.
    pub dram_write_bytes: u64,
}

/// What was asked of one cache.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelTraffic {
    /// Its name in the GPU's description.
    pub name: String,
    /// What counters call it.
    pub role: CacheRole,
    /// Lines asked for.
    pub lines: u64,
    /// Of these, lines that it did not have.
    pub missed: u64,
    /// Bytes of the lines asked for: what its bandwidth is taken by.
    pub bytes: u64,
}

/// Of every pass. The bytes to and from memory add up to the frame's counters: what tile memory, bin lists and DMA move past the caches
/// is among them, and dirty lines that are written back after the last access are the stacks' of the pass that shades last.
pub(super) fn by_pass(counters: &FrameCounters, config: &ReplayConfig) -> Vec<TrafficEstimate> {
    let last = config.technique.last_shading();
    let of_pass = |pass: Pass| {
        let counted = counters.pass(pass);
        let mut traffic = counted.traffic;
        if pass == last {
            traffic.stack += counters.flush;
        }
        let past_caches = |written: u64, read: u64| BufferTraffic {
            dram_read_bytes: read,
            dram_write_bytes: written,
            ..BufferTraffic::default()
        };
        // Bin lists are written once and read once.
        let lists = counted.issue.bin_list_bytes / 2;
        let direct = [
            ("tile memory", past_caches(counted.issue.output_bytes, 0)),
            ("bin lists", past_caches(lists, lists)),
            ("DMA", past_caches(counted.issue.dma_write_bytes, counted.issue.dma_read_bytes)),
        ];
        let named = traffic.named().into_iter().chain(direct);
        named.filter_map(move |(buffer, traffic)| of_buffer(pass, buffer, &traffic, &config.gpu))
    };
    Pass::ALL.into_iter().flat_map(of_pass).collect()
}

fn of_buffer(
    pass: Pass,
    buffer: &'static str,
    traffic: &BufferTraffic,
    gpu: &Gpu,
) -> Option<TrafficEstimate> {
    if *traffic == BufferTraffic::default() {
        return None;
    }
    let asked = gpu.caches.iter().zip(&traffic.levels).filter(|(_, served)| served.accesses > 0);
    let levels = asked.map(|(cache, served)| LevelTraffic {
        name: cache.name.clone(),
        role: cache.role,
        lines: served.accesses,
        missed: served.misses,
        bytes: served.accesses * cache.line_bytes,
    });
    let BufferTraffic { dram_read_bytes, dram_write_bytes, .. } = *traffic;
    Some(TrafficEstimate { pass, buffer, levels: levels.collect(), dram_read_bytes, dram_write_bytes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::Value;
    use crate::estimate::{Estimate, estimate};
    use crate::mock::{Recorded, config, gpu};
    use crate::replay::{Maps, replay};
    use tracer::{Accel, NO_HIT, Op};

    fn estimated() -> Estimate {
        let rays: Vec<_> = (0..64)
            .map(|ray| (vec![(Op::Node, ray), (Op::Push, ray), (Op::Primitive, ray)], NO_HIT))
            .collect();
        let source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
        let config = config(gpu(&[]));
        let replayed = replay(&source, &config, Maps::Dropped, &|_, _| {}).expect("the mock is valid");
        estimate(&replayed, &source.header, &source.topology, &config).expect("its queues can be solved")
    }

    #[test]
    fn all_rows_together_are_the_frame_s_bytes() {
        let estimate = estimated();
        let of_frame = |id: &str| estimate.frame.get(id).and_then(Value::number).expect("a figure") as u64;
        let sum = |of: fn(&TrafficEstimate) -> u64| estimate.traffic.iter().map(of).sum::<u64>();
        assert_eq!(sum(|row| row.dram_read_bytes), of_frame("dram_read_bytes"));
        assert_eq!(sum(|row| row.dram_write_bytes), of_frame("dram_write_bytes"));
        let lines = |row: &TrafficEstimate| row.levels.first().map_or(0, |level| level.lines);
        for buffer in &estimate.buffers {
            let rows = estimate.traffic.iter().filter(|row| row.buffer == buffer.name);
            assert_eq!(rows.map(lines).sum::<u64>(), buffer.line_accesses, "{}", buffer.name);
        }
    }

    #[test]
    fn a_cache_is_asked_for_whole_lines_and_one_that_is_not_asked_is_left_out() {
        let machine = gpu(&[]);
        for row in estimated().traffic {
            for level in &row.levels {
                let cache = machine.caches.iter().find(|cache| cache.name == level.name).expect("a cache");
                assert!(level.lines > 0 && level.missed <= level.lines, "{row:?}");
                assert_eq!(level.bytes, level.lines * cache.line_bytes, "{row:?}");
            }
            assert!(!row.levels.is_empty() || row.dram_read_bytes + row.dram_write_bytes > 0, "{row:?}");
        }
    }
}
