//! A made-up report.

use reports::{
    Bound, Counter, Counters, Fidelity, Hashes, Inputs, LeftOut, Pass, Report, Run, SCHEMA, Value, Within,
};

pub(crate) fn counter(value: Value, unit: &str) -> Counter {
    Counter { value, unit: unit.to_owned(), ci95: None, from: Fidelity::Replay }
}

fn counters() -> Counters {
    [
        ("frame_time_ms", counter(Value::Real(12.5), "ms")),
        ("rays", counter(Value::Count(9_007_199_254_740_993), "rays")),
        ("texture_memory_read_bytes", counter(Value::Absent { reason: "no texture, \"none\"".into() }, "B")),
        ("l2_miss_ratio", Counter { ci95: Some([0.1, 0.2]), ..counter(Value::Real(0.15), "ratio") }),
    ]
    .into_iter()
    .map(|(id, counter)| (id.to_owned(), counter))
    .collect()
}

/// A report of four counters, one of them absent.
pub(crate) fn report() -> Report {
    Report {
        vendor: None,
        schema: SCHEMA,
        tool: "raybudget 0.1.0".into(),
        inputs: Inputs {
            scene: "a scene".into(),
            gpu: "adreno-540".into(),
            accel: "bvh".into(),
            traversal: "restart-trail".into(),
            layout: "padded".into(),
            technique: "fragment".into(),
            primitive_order: "leaf".into(),
            node_records: "packed".into(),
            node_order: "depth-first".into(),
            width: Some(64),
            height: None,
            seed: None,
            hashes: Hashes {
                scene: "0123456789abcdef".into(),
                gpu: "0123456789abcdef".into(),
                costs: "0123456789abcdef".into(),
                energy: Some("0123456789abcdef".into()),
            },
            triangles: 32,
            ray_sets: vec!["primary".into()],
            samples_per_pixel: None,
            shadow_query: None,
            sah_costs: [3.0, 1.5],
            short_stack: 4,
            trail_bits: Some(32),
            node_format: None,
            ray_unit: None,
        },
        left_out: vec![LeftOut { what: "textures".into(), why: "not read".into() }],
        run: Run {
            wall_s: 0.5,
            peak_rss_bytes: None,
            fidelity: Fidelity::Replay,
            sampled_fraction: 1.0,
            threads: 2,
            load_s: 0.1,
            build_s: None,
            replay_s: 0.4,
            within: Some(Within::Known {
                of: Fidelity::Timed,
                frame_time: 0.125,
                dram_bytes: 0.0625,
                basis: "the worst of 3 other frames".into(),
            }),
        },
        counters: counters(),
        passes: vec![Pass { name: "primary rays".into(), counters: counters() }],
        stack: vec![reports::TimePart { name: "ALU issue".into(), seconds: 0.0130 }],
        bounds: vec![Bound { name: "ALU issue".into(), seconds: 0.0125 }],
        deciding_bound: Some("ALU issue".into()),
        energy: Some(reports::Energy {
            process: "10nm".into(),
            volts: 0.8,
            volts_from: "process".into(),
            celsius: 50.0,
            causes: [
                ("ALU operations", 1.5, "GPU", "unit"),
                ("DRAM: reads and writes", 4.5, "DRAM", "whole path"),
            ]
            .map(|(cause, mj, domain, boundary)| reports::EnergyCause {
                cause: cause.into(),
                mj,
                share: mj / 6.0,
                domain: domain.into(),
                boundary: boundary.into(),
                tag: "estimate".into(),
            })
            .into(),
        }),
        buffers: vec![reports::Buffer {
            name: "nodes".into(),
            bytes: 4096,
            line_accesses: 100,
            line_misses: 7,
            dram_read_bytes: 448,
            dram_write_bytes: 0,
        }],
        traffic: vec![reports::Traffic {
            pass: "primary rays".into(),
            buffer: "nodes".into(),
            levels: vec![reports::LevelTraffic {
                name: "uche".into(),
                role: Some("l2".into()),
                lines: 100,
                missed: 7,
                bytes: 6400,
            }],
            dram_read_bytes: 448,
            dram_write_bytes: 0,
        }],
        assumptions: vec!["Resources overlap perfectly.".into()],
        notes: vec![],
        forced: vec![],
        sustained: None,
    }
}
