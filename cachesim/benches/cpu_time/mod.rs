//! CPU time of this thread as a criterion measurement, so that a busy machine does not look like slow
//! code. Wall time where the system does not tell.

use std::time::{Duration, Instant};

use criterion::Throughput;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};

/// Time that this thread has run.
pub(crate) struct CpuTime;

/// A point in wall time and, if known, in CPU time.
pub(crate) struct Start {
    wall: Instant,
    cpu: Option<Duration>,
}

fn cpu_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

impl Measurement for CpuTime {
    type Intermediate = Start;
    type Value = Duration;

    fn start(&self) -> Start {
        Start { wall: Instant::now(), cpu: cpu_time() }
    }

    fn end(&self, start: Start) -> Duration {
        let cpu = cpu_time().zip(start.cpu).map(|(end, start)| end.saturating_sub(start));
        cpu.unwrap_or_else(|| start.wall.elapsed())
    }

    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        &Accesses
    }
}

/// Nanoseconds as time, elements as accesses per CPU-second.
struct Accesses;

impl ValueFormatter for Accesses {
    fn scale_values(&self, typical: f64, values: &mut [f64]) -> &'static str {
        WallTime.formatter().scale_values(typical, values)
    }

    fn scale_throughputs(&self, _typical: f64, throughput: &Throughput, values: &mut [f64]) -> &'static str {
        let elements = match throughput {
            Throughput::Elements(elements) => *elements as f64,
            _ => 1.0,
        };
        values.iter_mut().for_each(|nanoseconds| *nanoseconds = elements * 1e3 / *nanoseconds);
        "Macc/CPU-s"
    }

    fn scale_for_machines(&self, _values: &mut [f64]) -> &'static str {
        "ns"
    }
}
