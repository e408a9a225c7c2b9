//! Sets the default rung beside the timed one: `rungs TRACE... -- GPU...`, one line for each pair, then mean and worst.

use gpumodel::{
    Estimate, Fidelity, GPUS, Gpu, Maps, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig, ShaderCosts,
    Technique, Value, estimate, replay,
};
use std::time::Instant;
use tracer::{TileSource, TraceFile};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (traces, gpus) = arguments.split_at(arguments.iter().position(|a| a == "--").unwrap_or(0));
    let (mut errors, mut bytes) = (Vec::new(), Vec::new());
    for path in traces {
        let source = TraceFile::open(path.as_ref())?;
        for name in &gpus[1..] {
            let gpu = GPUS.iter().find(|gpu| gpu.name == *name).ok_or("no such GPU")?;
            let mut config = ReplayConfig {
                gpu: Gpu::parse(gpu.toml, name)?,
                costs: ShaderCosts::parse(include_str!("../../configs/costs.toml"), "costs.toml")?,
                technique: Technique::builtin("fragment").ok_or("no such technique")??,
                primitive_layout: PrimitiveLayout::Padded,
                primitive_order: None,
                node_records: NodeRecords::Packed,
                node_order: NodeOrder::DepthFirst,
                fidelity: Fidelity::Replay,
                keeps_misses: false,
            };
            let mut found: Vec<(Estimate, f64)> = Vec::new();
            for fidelity in Fidelity::ALL {
                config.fidelity = fidelity;
                let start = Instant::now();
                let replayed = replay(&source, &config, Maps::Dropped, &|_, _| {})?;
                let seconds = start.elapsed().as_secs_f64();
                found.push((estimate(&replayed, source.header(), source.topology(), &config), seconds));
            }
            let of =
                |place: usize, id: &str| found[place].0.frame.get(id).and_then(Value::number).unwrap_or(0.0);
            let error = |id: &str| of(0, id) / of(1, id) - 1.0;
            let (time, dram) = (error("frame_time_ms"), error("dram_read_bytes"));
            errors.push(time);
            bytes.push(dram);
            println!(
                "{:44} {name:11} timed {:9.3} ms  error {:+6.1} %  dram {:+5.2} %  {:22} run {:.2} s and {:.2} s",
                path.rsplit('/').next().unwrap_or(path),
                of(1, "frame_time_ms"),
                100.0 * time,
                100.0 * dram,
                found[0].0.deciding_bound,
                found[0].1,
                found[1].1
            );
        }
    }
    let summary = |what: &str, errors: &[f64]| {
        let mean = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len() as f64;
        let worst = errors.iter().map(|error| error.abs()).fold(0.0, f64::max);
        println!("{what}: mean {:.1} %, worst {:.1} %", 100.0 * mean, 100.0 * worst);
    };
    summary("frame time", &errors);
    summary("DRAM bytes", &bytes);
    Ok(())
}
