//! What a run costs this machine: wall time, processor time, memory.

use std::time::Instant;

/// Started with the program.
pub(crate) struct Meter {
    start: Instant,
}

impl Meter {
    pub(crate) fn start() -> Self {
        Self { start: Instant::now() }
    }

    /// When it was.
    pub(crate) fn started(&self) -> Instant {
        self.start
    }

    /// Seconds since the start.
    pub(crate) fn wall_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

/// Runs `work` and says how many seconds it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Runs `work`, which keeps to this thread, and says how many seconds of a processor it took; of the clock where that is not known.
pub(crate) fn timed_on_thread<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let before = thread_cpu_s();
    let (result, wall_s) = timed(work);
    let cpu_s = before.zip(thread_cpu_s()).map(|(before, after)| after - before);
    (result, cpu_s.unwrap_or(wall_s))
}

/// Most bytes of memory that this process held at once; known on Linux.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Seconds that this thread has run on a processor; known on Linux with scheduler statistics.
pub(crate) fn thread_cpu_s() -> Option<f64> {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: u64 = statistics.split_whitespace().next()?.parse().ok()?;
    (nanoseconds > 0).then_some(nanoseconds as f64 * 1e-9)
}
