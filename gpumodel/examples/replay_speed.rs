//! Measures replay in lane steps per second: `replay_speed SCENE [ACCEL TRAVERSAL [EDGE]]`.
//!
//! The trace is recorded first and kept in memory, so that the time is the replay's alone.

use gpumodel::{
    EnergyTable, Gpu, Maps, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig, ShaderCosts, Technique,
    Value, estimate, replay,
};
use scenes::{Light, Vec3};
use std::time::Instant;
use tracer::{
    Accel, AccelerationStructure, BuildOptions, FrameTracer, Rays, SceneIdentity, Tile, TileSource, Topology,
    TraceHeader, Traversal, View,
};

struct Recorded {
    header: TraceHeader,
    topology: Topology,
    tiles: Vec<Tile>,
}

impl TileSource for Recorded {
    fn header(&self) -> &TraceHeader {
        &self.header
    }

    fn topology(&self) -> &Topology {
        &self.topology
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        tile.clone_from(&self.tiles[index as usize]);
        Ok(())
    }

    fn stalls(&self) -> u64 {
        0
    }
}

/// CPU time of all threads so far, in steps of 10 ms; Linux only.
fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let after_name = stat.rsplit_once(')')?.1;
    let mut fields = after_name.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |index: usize, default: &str| arguments.get(index).map_or(default, |a| a).to_owned();
    let scene = scenes::load(&argument(0, "cornell"))?;
    let accel = if argument(1, "bvh") == "kd" { Accel::Kd } else { Accel::Bvh };
    let traversal = Traversal::named(accel, &argument(2, "stack"))?;
    let edge: u32 = argument(3, "1024").parse()?;
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let start = Instant::now();
    let structure = AccelerationStructure::build(&triangles, traversal, &options)?;
    println!("build {:?}", start.elapsed());
    let lights: Vec<Vec3> = scene.lights.iter().map(|Light::Point { position, .. }| *position).collect();
    let rays = Rays::View { view: View::new(&scene.camera, edge, edge), width: edge, height: edge };
    let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
    let tracer = FrameTracer::new(&structure, &options, &triangles, identity, rays, lights);
    let start = Instant::now();
    let mut tiles = Vec::new();
    for index in 0..tracer.header().frame.tiles() {
        let mut tile = Tile::default();
        tracer.tile(index, &mut tile)?;
        tiles.push(tile);
    }
    println!("trace {:?}", start.elapsed());
    let recorded = Recorded { header: tracer.header().clone(), topology: tracer.topology().clone(), tiles };
    let config = ReplayConfig {
        gpu: Gpu::builtin("adreno-540").ok_or("no such GPU")??,
        costs: ShaderCosts::builtin()?,
        energy: EnergyTable::builtin()?,
        technique: Technique::builtin("fragment").ok_or("no such technique")??,
        primitive_layout: PrimitiveLayout::Padded,
        primitive_order: None,
        node_records: NodeRecords::Packed,
        node_order: NodeOrder::DepthFirst,
        fidelity: gpumodel::Fidelity::Replay,
        keeps_misses: false,
    };
    let (start, cpu_start) = (Instant::now(), cpu_seconds());
    let replayed = replay(&recorded, &config, Maps::Dropped, &|_, _| {})?;
    let seconds = start.elapsed().as_secs_f64();
    let cpu = cpu_seconds().zip(cpu_start).map(|(end, start)| end - start);
    let total = replayed.counters.total().issue;
    println!(
        "replay {seconds:.3} s, {:.1} M lane steps/s, {:.1} M lines/s",
        total.lane_steps as f64 / seconds / 1e6,
        total.line_accesses as f64 / seconds / 1e6
    );
    if let Some(cpu) = cpu {
        println!("replay {cpu:.2} CPU s, {:.1} M lane steps per CPU s", total.lane_steps as f64 / cpu / 1e6);
    }
    println!("{total:#?}");
    let estimate = estimate(&replayed, &recorded.header, &recorded.topology, &config)
        .expect("built-in GPUs have a solution");
    for (counter, value) in estimate.frame.iter() {
        match value {
            Value::Absent { reason } => println!("{:32} absent: {reason}", counter.id),
            other => println!("{:32} {:?} {}", counter.id, other.number().unwrap_or(f64::NAN), counter.unit),
        }
    }
    for bound in &estimate.bounds {
        println!("{:28} {:9.3} ms", bound.name, bound.seconds * 1e3);
    }
    println!("decided by {}", estimate.deciding_bound);
    Ok(())
}
