//! Does a replay of the real tracer count what the tracer counts, and the same on any number of threads?

mod common;

use common::{SIZE, Traced};
use gpumodel::{Maps, PrimitiveLayout, ReplayConfig, Replayed, Value, estimate, replay};
use tracer::{Query, RayOffset, Tile, TileSource, Topology, TraceHeader, Traversal, WorkCounter};

fn config(layout: PrimitiveLayout) -> ReplayConfig {
    ReplayConfig { primitive_layout: layout, ..common::config("fragment") }
}

fn cornell(traversal: Traversal) -> Traced {
    Traced::new("cornell", traversal)
}

/// Work of all rays and their number, counted without a trace.
fn work(traced: &Traced) -> (tracer::Work, u64) {
    let mut rays = 0;
    let offset = RayOffset::new(&traced.triangles);
    let mut counter = WorkCounter::new(traced.structure.traversal().node_fetch());
    for (y, x) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (y, x))) {
        let ray = traced.view().primary_ray(x, y);
        let hit = traced.structure.trace(&ray, Query::Closest, &mut counter);
        rays += 1;
        for &light in traced.lights.iter().filter(|_| hit.is_hit()) {
            let triangle = &traced.triangles[hit.primitive as usize];
            let shadow = offset.shadow_ray(triangle, hit.u, hit.v, ray.direction, light);
            traced.structure.trace(&shadow, Query::Any, &mut counter);
            rays += 1;
        }
    }
    (counter.work(), rays)
}

fn on_threads(threads: usize, run: impl FnOnce() -> Replayed + Send) -> Replayed {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(run)
}

#[test]
fn every_traversal_and_layout_counts_the_work_of_the_tracer() {
    for traversal in Traversal::ALL {
        let traced = cornell(traversal);
        let (work, rays) = work(&traced);
        for layout in PrimitiveLayout::ALL {
            let replayed =
                replay(&traced.frame(), &config(layout), Maps::Kept, &|_, _| {}).expect("a real trace");
            let total = replayed.counters.total().issue;
            assert_eq!(total.rays, rays, "{traversal:?} {layout:?}");
            assert_eq!(total.node_fetches, work.node_fetches, "{traversal:?} {layout:?}");
            assert_eq!(total.primitive_tests, work.primitive_tests, "{traversal:?} {layout:?}");
            assert_eq!(total.restarts, work.restarts, "{traversal:?} {layout:?}");
            assert_eq!((total.pushes, total.pops), (work.pushes, work.pops), "{traversal:?} {layout:?}");
            let maps = replayed.maps.expect("kept");
            let of_pixels: u64 = maps.node_fetches.values.iter().map(|&fetches| u64::from(fetches)).sum();
            assert_eq!(of_pixels, work.node_fetches);
            assert_eq!(maps.node_fetches.values.len(), (SIZE.0 * SIZE.1) as usize);
        }
    }
}

#[test]
fn accesses_add_up_from_lanes_to_memory() {
    for traversal in Traversal::ALL {
        let traced = cornell(traversal);
        let counters = replay(&traced.frame(), &config(PrimitiveLayout::Split), Maps::Kept, &|_, _| {})
            .expect("valid")
            .counters;
        for pass in &counters.passes {
            let traffic = pass.traffic.total();
            let uche = traffic.levels[1];
            assert_eq!(
                uche.accesses, pass.issue.line_accesses,
                "{traversal:?}: every line goes through UCHE"
            );
            assert_eq!(traffic.levels[0].accesses, 0, "no storage buffer goes through the texture cache");
            assert!(traffic.dram_read_bytes <= uche.misses * 64);
            assert!(pass.issue.lane_steps <= 32 * pass.issue.warp_steps);
        }
    }
}

#[test]
fn one_two_and_three_threads_count_the_same() {
    for traversal in [Traversal::BvhStack, Traversal::KdBacktrack] {
        let traced = cornell(traversal);
        let run = || {
            replay(&traced.frame(), &config(PrimitiveLayout::Padded), Maps::Kept, &|_, _| {}).expect("valid")
        };
        let one = on_threads(1, run);
        for threads in [2, 3] {
            let many = on_threads(threads, run);
            assert_eq!(one.counters, many.counters, "{threads} threads");
            assert_eq!(one.maps, many.maps, "{threads} threads");
        }
    }
}

/// Tiles from memory instead of from the tracer.
struct Recorded<'a> {
    frame: &'a tracer::FrameTracer<'a>,
    tiles: Vec<Tile>,
}

impl TileSource for Recorded<'_> {
    fn header(&self) -> &TraceHeader {
        self.frame.header()
    }

    fn topology(&self) -> &Topology {
        self.frame.topology()
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), tracer::Error> {
        tile.clone_from(&self.tiles[index as usize]);
        Ok(())
    }

    fn stalls(&self) -> u64 {
        0
    }
}

#[test]
fn a_replay_does_not_care_where_its_tiles_come_from() {
    let traced = cornell(Traversal::BvhRestartTrail {
        bits: Some(tracer::bvh::restart_trail::TrailBits::Bits32),
        short_stack: 2,
    });
    let frame = traced.frame();
    let mut tiles = vec![Tile::default(); frame.header().frame.tiles() as usize];
    for (index, tile) in (0..).zip(&mut tiles) {
        frame.tile(index, tile).expect("traced");
    }
    let recorded = Recorded { frame: &frame, tiles };
    let config = config(PrimitiveLayout::Compact);
    let live = replay(&frame, &config, Maps::Kept, &|_, _| {}).expect("valid");
    let again = replay(&recorded, &config, Maps::Kept, &|_, _| {}).expect("valid");
    assert_eq!(live.counters, again.counters);
    assert_eq!(live.maps, again.maps);
}

#[test]
fn a_compact_layout_costs_operations_and_a_split_one_none() {
    let traced = cornell(Traversal::BvhStack);
    let operations = |layout| {
        let replayed = replay(&traced.frame(), &config(layout), Maps::Kept, &|_, _| {}).expect("valid");
        let issue = replayed.counters.total().issue;
        (issue.alu_active, issue.shaded)
    };
    let (padded, shaded) = operations(PrimitiveLayout::Padded);
    assert_eq!(operations(PrimitiveLayout::Split).0, padded);
    // Two loads more, with three operations for the address of each.
    assert_eq!(operations(PrimitiveLayout::Compact).0, padded + 6 * shaded);
}

#[test]
fn an_estimate_names_its_bound_its_assumptions_and_what_is_left_out() {
    let traced = cornell(Traversal::BvhStack);
    let frame = traced.frame();
    let config = config(PrimitiveLayout::Padded);
    let replayed = replay(&frame, &config, Maps::Kept, &|_, _| {}).expect("valid");
    let estimate = estimate(&replayed, frame.header(), frame.topology(), &config).unwrap();
    assert!(estimate.bounds.iter().any(|bound| bound.name == estimate.deciding_bound));
    assert!(!estimate.assumptions.is_empty() && !estimate.left_out.is_empty());
    let number = |id: &str| estimate.frame.get(id).and_then(Value::number).expect("a number");
    assert_eq!(number("structure_bytes"), 32.0 * number("structure_nodes"));
    assert!(number("shader_alu_capacity_utilized") <= number("time_alus_working"));
    assert!(
        number("time_alus_working") <= 1.0 && number("occupancy") <= 1.0 && number("shaders_busy") <= 1.0
    );
    let fetches: f64 = estimate
        .passes
        .iter()
        .filter_map(|pass| pass.counters.get("node_fetches").and_then(Value::number))
        .sum();
    assert_eq!(fetches, number("node_fetches"));
    assert!(matches!(estimate.frame.get("energy_mj"), Some(Value::Real(energy)) if *energy > 0.0));
}
