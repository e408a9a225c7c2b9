//! Errors of samples of a trace against its replay, and what their intervals are worth.
//!
//! `cargo run --release -p gpumodel --example sample_errors -- TRACE.rbt GPU FRACTION SEEDS`

use gpumodel::{
    Gpu, Maps, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig, Sampler, ShaderCosts, Technique,
    estimate, replay,
};
use std::time::Instant;
use tracer::{TileSource, TraceFile};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [trace, gpu, fraction, seeds] = arguments.as_slice() else {
        return Err("give TRACE.rbt GPU FRACTION SEEDS".into());
    };
    let source = TraceFile::open(trace.as_ref())?;
    let config = ReplayConfig {
        gpu: Gpu::builtin(gpu).ok_or("no such GPU")??,
        costs: ShaderCosts::builtin()?,
        technique: Technique::builtin("fragment").ok_or("no such technique")??,
        primitive_layout: PrimitiveLayout::Padded,
        primitive_order: None,
        node_records: NodeRecords::Packed,
        node_order: NodeOrder::DepthFirst,
        fidelity: gpumodel::Fidelity::Replay,
        keeps_misses: false,
    };
    let start = Instant::now();
    let replayed = replay(&source, &config, Maps::Dropped, &|_, _| ())?;
    let exact = estimate(&replayed, source.header(), source.topology(), &config)?;
    let whole_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let sampler = Sampler::new(&source, &config)?;
    let prepare_s = start.elapsed().as_secs_f64();
    println!("replay {whole_s:.3} s, preparing {prepare_s:.3} s, fractions {:?}", sampler.parts());
    let ids = [
        "frame_time_ms",
        "external_read_bytes",
        "dram_read_bytes",
        "dram_write_bytes",
        "l2_misses",
        "alu_operations_issued",
        "node_fetches",
        "simt_efficiency",
    ];
    let seeds: u64 = seeds.parse()?;
    let mut errors = vec![Vec::new(); ids.len()];
    let mut halves = vec![0.0; ids.len()];
    let mut covered = vec![0; ids.len()];
    let start = Instant::now();
    let mut tiles = 0;
    for seed in 0..seeds {
        let sampled = sampler.sample(fraction.parse()?, seed * 1000 + 7)?;
        tiles = sampled.tiles;
        for (place, id) in ids.iter().enumerate() {
            let (Some(truth), Some(found)) = (
                exact.frame.get(id).and_then(|value| value.number()),
                sampled.estimate.frame.get(id).and_then(|value| value.number()),
            ) else {
                continue;
            };
            errors[place].push(found / truth - 1.0);
            if let Some([low, high]) = sampled.intervals.of_frame(id) {
                covered[place] += u64::from((low..=high).contains(&truth));
                halves[place] += (high - low) / 2.0 / truth / seeds as f64;
            }
        }
    }
    let each_s = start.elapsed().as_secs_f64() / seeds as f64;
    println!(
        "{tiles} tiles, {each_s:.3} s each: {:.1} times faster, with preparation {:.1}",
        whole_s / each_s,
        whole_s / (each_s + prepare_s)
    );
    for (((id, errors), half), covered) in ids.iter().zip(&mut errors).zip(&halves).zip(&covered) {
        if errors.is_empty() {
            continue;
        }
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let sd = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        errors.iter_mut().for_each(|error| *error = error.abs());
        errors.sort_by(f64::total_cmp);
        let at = |part: f64| errors[((n - 1.0) * part).round() as usize] * 100.0;
        println!(
            "{id:24} bias {:+.2} % sd {:.2} % median {:.2} % p95 {:.2} % half-width {:.2} % covered {:.0} %",
            mean * 100.0,
            sd * 100.0,
            at(0.5),
            at(0.95),
            half * 100.0,
            *covered as f64 / n * 100.0
        );
    }
    Ok(())
}
