//! From the model's estimate to a report.

use crate::counters::{Counter, Counters, Fidelity, Value};
use crate::report::{
    Bound, Buffer, Energy, EnergyCause, Forced, Inputs, LeftOut, LevelTraffic, Pass, Report, Run, SCHEMA,
    TimePart, Traffic,
};
use gpumodel::energy::FrameEnergy;
use gpumodel::{BufferEstimate, CounterSet, Estimate, Intervals, TrafficEstimate};

/// What a report says of the scene itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneFacts {
    /// What the scene needs and the traced rays do not do.
    pub left_out: Vec<LeftOut>,
    /// What was missing, assumed or noticed when the scene was loaded, in sentences.
    pub notes: Vec<String>,
}

impl Report {
    /// The report of `estimate`, which `run.fidelity` made, without a profiler's view.
    pub fn new(tool: &str, inputs: Inputs, scene: SceneFacts, estimate: &Estimate, run: Run) -> Self {
        let from = run.fidelity;
        let model = estimate
            .left_out
            .iter()
            .map(|entry| LeftOut { what: entry.what.to_string(), why: entry.why.to_string() });
        let SceneFacts { mut left_out, notes } = scene;
        left_out.extend(model);
        let frame_s = estimate.stack.iter().map(|part| part.seconds).sum();
        Self {
            schema: SCHEMA,
            tool: tool.to_owned(),
            inputs,
            left_out,
            run,
            counters: counters(&estimate.frame, from),
            passes: estimate
                .passes
                .iter()
                .map(|pass| Pass {
                    name: pass.pass.name().to_owned(),
                    counters: counters(&pass.counters, from),
                })
                .collect(),
            vendor: None,
            stack: estimate
                .stack
                .iter()
                .map(|part| TimePart { name: part.name.to_owned(), seconds: part.seconds })
                .collect(),
            bounds: estimate
                .bounds
                .iter()
                .map(|bound| Bound { name: bound.name.to_owned(), seconds: bound.seconds })
                .collect(),
            deciding_bound: Some(estimate.deciding_bound.to_owned()),
            energy: estimate.energy.as_ref().map(energy),
            buffers: estimate.buffers.iter().map(buffer).collect(),
            traffic: estimate.traffic.iter().map(traffic).collect(),
            assumptions: estimate.assumptions.clone(),
            notes,
            forced: estimate.forced.iter().map(|cost| Forced::new(cost, frame_s)).collect(),
            sustained: None,
        }
    }
}

impl Report {
    /// With how far the counters of a sample may be off; `estimate` is what the report was made of.
    #[must_use]
    pub fn with_intervals(mut self, estimate: &Estimate, intervals: &Intervals) -> Self {
        for (id, counter) in self.counters.iter_mut() {
            counter.ci95 = finite(intervals.of_frame(id));
        }
        for (pass, of) in self.passes.iter_mut().zip(&estimate.passes) {
            for (id, counter) in pass.counters.iter_mut() {
                counter.ci95 = finite(intervals.of_pass(of.pass, id));
            }
        }
        self
    }
}

/// What JSON can hold.
fn finite(interval: Option<[f64; 2]>) -> Option<[f64; 2]> {
    interval.filter(|ends| ends.iter().all(|end| end.is_finite()))
}

fn buffer(estimate: &BufferEstimate) -> Buffer {
    let BufferEstimate { name, bytes, line_accesses, line_misses, dram_read_bytes, dram_write_bytes } =
        *estimate;
    Buffer { name: name.to_owned(), bytes, line_accesses, line_misses, dram_read_bytes, dram_write_bytes }
}

fn traffic(estimate: &TrafficEstimate) -> Traffic {
    let TrafficEstimate { pass, buffer, levels, dram_read_bytes, dram_write_bytes } = estimate;
    let level = |level: &gpumodel::LevelTraffic| {
        let gpumodel::LevelTraffic { name, role, lines, missed, bytes } = level;
        let role = Some(role.name().to_owned());
        LevelTraffic { name: name.clone(), role, lines: *lines, missed: *missed, bytes: *bytes }
    };
    Traffic {
        pass: pass.name().to_owned(),
        buffer: (*buffer).to_owned(),
        levels: levels.iter().map(level).collect(),
        dram_read_bytes: *dram_read_bytes,
        dram_write_bytes: *dram_write_bytes,
    }
}

fn energy(energy: &FrameEnergy) -> Energy {
    let all = energy.total().joules;
    let causes = energy.causes.iter().map(|cause| EnergyCause {
        cause: cause.cause.clone(),
        mj: cause.joules * 1e3,
        share: cause.joules / all,
        domain: cause.domain.name().to_owned(),
        boundary: cause.boundary.name().to_owned(),
        tag: cause.tag.name().to_owned(),
    });
    Energy {
        process: energy.prices.process().to_owned(),
        volts: energy.prices.supply().volts(),
        volts_from: energy.prices.supply().origin().to_owned(),
        celsius: energy.prices.leakage().reference_celsius(),
        causes: causes.collect(),
    }
}

fn counters(set: &CounterSet, from: Fidelity) -> Counters {
    set.iter()
        .map(|(info, value)| {
            let value = match value {
                gpumodel::Value::Count(count) => Value::Count(*count),
                gpumodel::Value::Real(real) if real.is_finite() => Value::Real(*real),
                gpumodel::Value::Real(_) => {
                    Value::Absent { reason: "the figure is beyond what a number can hold".to_owned() }
                }
                gpumodel::Value::Absent { reason } => Value::Absent { reason: reason.clone() },
            };
            (info.id.to_owned(), Counter { value, unit: info.unit.to_owned(), ci95: None, from })
        })
        .collect()
}
