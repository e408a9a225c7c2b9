//! Whole replays of hand-written traces against figures worked out by hand.

use crate::config::SharedCosts;
use crate::counters::{BufferTraffic, COUNTERS, FrameCounters, Pass, TrafficCounters, Value};
use crate::layout::PrimitiveLayout;
use crate::mock::{MockRay, Recorded, complete_tree, config, gpu, ray_set};
use crate::replay::{Maps, ReplayConfig, Replayed, replay};
use crate::{Estimate, Gpu, estimate};
use proptest::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use tracer::{Accel, LoopStructure, NO_HIT, NOT_CAST, NodeFetch, Op, RayKind, RaySetId};

fn run_on(source: &Recorded, config: &ReplayConfig) -> Replayed {
    replay(source, config, Maps::Kept, &|_, _| {}).expect("the mock is valid")
}

fn run(source: &Recorded) -> FrameCounters {
    run_on(source, &config(gpu(&[]))).counters
}

fn estimate_on(source: &Recorded, machine: Gpu) -> Estimate {
    let config = config(machine);
    estimate(&run_on(source, &config), &source.header, &source.topology, &config).unwrap()
}

fn refusal(source: &Recorded) -> String {
    replay(source, &config(gpu(&[])), Maps::Dropped, &|_, _| {}).expect_err("the mock is invalid").to_string()
}

fn node_rays(count: u32, node: impl Fn(u32) -> u32) -> Vec<MockRay> {
    (0..count).map(|ray| (vec![(Op::Node, node(ray))], NO_HIT)).collect()
}

fn number(estimate: &Estimate, id: &str) -> f64 {
    estimate.frame.get(id).and_then(Value::number).unwrap_or_else(|| panic!("{id} has a number"))
}

#[test]
fn a_warp_of_equal_rays_does_not_diverge_and_shares_every_line() {
    let ray = (vec![(Op::Node, 0), (Op::Primitive, 0)], NO_HIT);
    let source = Recorded::list(Accel::Bvh, "stack", 64, &vec![ray; 32]);
    let total = run(&source).total();
    let issue = total.issue;
    assert_eq!((issue.rays, issue.lane_steps, issue.warp_steps), (32, 64, 2));
    assert_eq!(issue.alu_active, issue.alu_issued);
    // Two loads of the node, three of the triangle, one line each; every lane receives 16 bytes by a 16-byte port.
    assert_eq!((issue.memory_instructions, issue.line_accesses), (5, 5));
    assert_eq!(issue.load_store_cycles, 5 * 32);
    assert_eq!(issue.lane_bytes, 5 * 32 * 16);
    assert_eq!(issue.memory_waits, 2);
    let uche = total.traffic.total().levels[1];
    assert_eq!((uche.accesses, uche.misses), (5, 2));
    assert_eq!(total.traffic.total().dram_read_bytes, 2 * 64);
    assert_eq!(total.issue.output_bytes, 32 * 4);
    let estimate = estimate_on(&source, gpu(&[]));
    assert_eq!(number(&estimate, "simt_efficiency"), 1.0);
    // The other loads of the two records hit.
    assert_eq!(number(&estimate, "sp_memory_read_bytes"), 2.0 * 64.0);
}

#[test]
fn lanes_that_wait_for_the_longest_of_their_warp_waste_its_slots() {
    let visits = |nodes: u32| ((0..nodes).map(|node| (Op::Node, node)).collect(), NO_HIT);
    let wasted = |rays: &[MockRay], machine: Gpu| {
        let replayed = run_on(&Recorded::list(Accel::Bvh, "stack", 64, rays), &config(machine));
        replayed.maps.expect("kept").wasted_slots.expect("shaders walk in lockstep").values
    };
    // Four steps of two lanes, in which one lane has three steps nothing to do: 3/8.
    let two = [visits(4), visits(1)];
    assert_eq!(wasted(&two, gpu(&[])), [38, 38]);
    assert_eq!(wasted(&[visits(4), visits(4)], gpu(&[])), [0, 0]);
    let mut narrow = gpu(&[]);
    narrow.cores.warp_width = 1;
    assert_eq!(wasted(&two, narrow), [0, 0]);
}

#[test]
fn rays_at_neighbouring_nodes_take_as_many_lines_as_their_records_fill() {
    for (accel, traversal, loads, lines_per_load) in [
        // 32 records of 16 bytes fill 8 lines; of 32 bytes, 16 lines, touched by both loads.
        (Accel::Kd, "stack", 1, 8),
        (Accel::Bvh, "stack", 2, 16),
    ] {
        let source = Recorded::list(accel, traversal, 64, &node_rays(32, |ray| ray));
        let total = run(&source).total();
        assert_eq!(total.issue.memory_instructions, loads, "{traversal}");
        assert_eq!(total.traffic.node.levels[1].accesses, loads * lines_per_load, "{traversal}");
        assert_eq!(total.traffic.node.levels[1].misses, lines_per_load, "{traversal}");
    }
    // 32 records of 48 bytes fill 24 lines. Each of three loads touches the lines that hold its quarter of 16 bytes.
    let source = Recorded::list(Accel::Kd, "backtrack", 64, &node_rays(32, |ray| ray));
    let total = run(&source).total();
    assert_eq!(total.issue.memory_instructions, 3);
    assert_eq!(total.traffic.node.levels[1].misses, 24);
    let by_hand: usize = (0..3)
        .map(|load| (0..32).map(|ray| (3 * ray + load) / 4).collect::<std::collections::BTreeSet<_>>().len())
        .sum();
    assert_eq!(total.traffic.node.levels[1].accesses, by_hand as u64);
}

#[test]
fn a_pair_is_two_records_except_at_the_root() {
    let rays: Vec<MockRay> = vec![(vec![(Op::Node, 0), (Op::Node, 1), (Op::Node, 5)], NO_HIT); 32];
    let mut source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
    source.header.node_fetch = NodeFetch::Pair;
    let replayed = run_on(&source, &config(gpu(&[])));
    assert_eq!(replayed.counters.pass(Pass::Primary).issue.node_fetches, 32 * 5);
    assert!(replayed.maps.as_ref().expect("kept").node_fetches.values.iter().all(|&fetches| fetches == 5));
    // Nodes 0; 1 and 2; 5 and 6: records 0 to 2 lie in lines 0 and 1, records 5 and 6 in lines 2 and 3.
    assert_eq!(replayed.counters.pass(Pass::Primary).traffic.node.levels[1].misses, 4);
    assert_eq!(replayed.counters.pass(Pass::Primary).issue.memory_instructions, 2 * 5);
}

#[test]
fn lanes_at_the_root_fetch_no_sibling_while_others_do() {
    let mut rays = node_rays(31, |_| 1);
    rays.insert(7, (vec![(Op::Node, 0)], NO_HIT));
    let mut source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
    source.header.node_fetch = NodeFetch::Pair;
    let counters = *run(&source).pass(Pass::Primary);
    assert_eq!(counters.issue.node_fetches, 31 * 2 + 1);
    // Nodes 0 and 1 share a line, and so do both loads; node 2, the sibling, has the next.
    assert_eq!(counters.issue.line_accesses, 2 + 2);
    assert_eq!(counters.issue.lane_bytes, 32 * (32 + 31));
}

#[test]
fn an_index_list_costs_one_more_load_and_one_more_wait() {
    let rays: Vec<MockRay> = (0..32).map(|ray| (vec![(Op::Primitive, ray)], NO_HIT)).collect();
    let kd = *run(&Recorded::list(Accel::Kd, "stack", 64, &rays)).pass(Pass::Primary);
    let bvh = *run(&Recorded::list(Accel::Bvh, "stack", 64, &rays)).pass(Pass::Primary);
    assert_eq!(kd.issue.memory_instructions, bvh.issue.memory_instructions + 1);
    assert_eq!(kd.issue.memory_waits, bvh.issue.memory_waits + 1);
    // 32 entries of 4 bytes.
    assert_eq!(kd.traffic.index.levels[1].accesses, 2);
    assert_eq!(kd.traffic.primitive, bvh.traffic.primitive);
}

#[test]
fn hits_are_shaded_once_and_only_where_they_are() {
    let hit = |ray: u32| if ray.is_multiple_of(2) { ray } else { NO_HIT };
    let rays: Vec<MockRay> = (0..32).map(|ray| (vec![(Op::Node, 0)], hit(ray))).collect();
    for (layout, loads) in
        [(PrimitiveLayout::Padded, 3), (PrimitiveLayout::Compact, 5), (PrimitiveLayout::Split, 3)]
    {
        let config = ReplayConfig { primitive_layout: layout, ..config(gpu(&[])) };
        let counters = run_on(&Recorded::list(Accel::Bvh, "stack", 64, &rays), &config).counters;
        assert_eq!(counters.pass(Pass::Output).issue.shaded, 16);
        assert_eq!(counters.pass(Pass::Output).issue.memory_instructions, loads, "{layout:?}");
        assert_eq!(counters.pass(Pass::Output).issue.lane_bytes, loads * 16 * 16, "{layout:?}");
        let TrafficCounters { primitive, normal, .. } = counters.pass(Pass::Output).traffic;
        let (read, other) =
            if layout == PrimitiveLayout::Split { (normal, primitive) } else { (primitive, normal) };
        assert!(read.levels[1].misses > 0 && other == BufferTraffic::default(), "{layout:?}");
    }
}

#[test]
fn shadow_rays_are_a_pass_of_their_own_and_only_of_pixels_that_hit() {
    let hit = |ray: u32| if ray < 6 { ray } else { NO_HIT };
    let primary: Vec<MockRay> = (0..32).map(|ray| (vec![(Op::Node, 0)], hit(ray))).collect();
    let mut source = Recorded::list(Accel::Bvh, "stack", 64, &primary);
    source.header.ray_sets.push(RaySetId::shadow(0));
    // The shadow ray of pixel 5 misses the box of the scene: it takes no step.
    let shadow: Vec<MockRay> = (0..32_u32)
        .map(|ray| (if ray < 5 { vec![(Op::Node, 1), (Op::Node, 2)] } else { Vec::new() }, NO_HIT))
        .collect();
    source.tiles[0].ray_sets.push(ray_set(&shadow));
    let counters = run(&source);
    assert_eq!((counters.pass(Pass::Primary).issue.rays, counters.pass(Pass::Shadow).issue.rays), (32, 6));
    assert_eq!(
        (counters.pass(Pass::Primary).issue.node_fetches, counters.pass(Pass::Shadow).issue.node_fetches),
        (32, 10)
    );
    assert_eq!(counters.total().issue.rays, 38);
}

#[test]
fn reflection_rays_are_shaded_in_their_own_pass_and_only_their_hits_send_shadow_rays() {
    let primary: Vec<MockRay> =
        (0..32).map(|ray| (vec![(Op::Node, 0)], if ray < 20 { ray } else { NO_HIT })).collect();
    let mut source = Recorded::list(Accel::Kd, "stack", 64, &primary);
    let id = |kind: RayKind| RaySetId { kind, sample: 1, light: 0 };
    source.header.ray_sets.extend([id(RayKind::Reflection), id(RayKind::ReflectionShadow)]);
    // Of 20 hits 12 surfaces reflect: 8 of those rays hit, 2 miss, and 2 miss the box of the scene.
    let reflection = |ray: u32| match ray {
        0..8 => (vec![(Op::Node, 1), (Op::Node, 2), (Op::Node, 3)], 40 + ray),
        8..10 => (vec![(Op::Node, 1)], NO_HIT),
        10..12 => (Vec::new(), NO_HIT),
        12..20 => (Vec::new(), NOT_CAST),
        _ => (Vec::new(), NO_HIT),
    };
    let shadow = |ray: u32| (if ray < 7 { vec![(Op::Node, 4)] } else { Vec::new() }, NO_HIT);
    for rays in [(0..32).map(reflection).collect::<Vec<MockRay>>(), (0..32).map(shadow).collect()] {
        source.tiles[0].ray_sets.push(ray_set(&rays));
    }
    for layout in [PrimitiveLayout::Padded, PrimitiveLayout::Compact] {
        for technique in ["fragment", "compute"] {
            let technique = crate::mock::technique(technique);
            let config = ReplayConfig { primitive_layout: layout, technique, ..config(gpu(&[])) };
            let counters = run_on(&source, &config).counters;
            let issue = |pass: Pass| counters.pass(pass).issue;
            let rays = [Pass::Primary, Pass::Reflection, Pass::ReflectionShadow].map(|pass| issue(pass).rays);
            assert_eq!(rays, [32, 12, 8]);
            assert_eq!(issue(Pass::Reflection).node_fetches, 3 * 8 + 2);
            let shaded =
                [Pass::Output, Pass::Reflection, Pass::ReflectionShadow].map(|pass| issue(pass).shaded);
            assert_eq!(shaded, [20, 8, 0]);
            let loads = if layout == PrimitiveLayout::Compact { 5 } else { 3 };
            let mut missing = Recorded {
                header: source.header.clone(),
                topology: complete_tree(64),
                tiles: source.tiles.clone(),
            };
            let hits = missing.tiles[0].ray_sets[1].hits.iter_mut();
            hits.filter(|hit| **hit < NOT_CAST).for_each(|hit| *hit = NO_HIT);
            let unshaded = run_on(&missing, &config).counters.pass(Pass::Reflection).issue;
            let shaded = issue(Pass::Reflection);
            assert_eq!(shaded.memory_instructions - unshaded.memory_instructions, loads, "{layout:?}");
            assert_eq!(shaded.lane_bytes - unshaded.lane_bytes, loads * 16 * 8, "{layout:?}");
            let SharedCosts { shade, compact_normal, address, .. } = config.costs.shared;
            let compact = if layout == PrimitiveLayout::Compact { compact_normal.alu } else { 0 };
            let operations = u64::from(shade.alu + compact + address.alu * loads as u32) * 8;
            assert_eq!(shaded.alu_active - unshaded.alu_active, operations, "{layout:?}");
        }
    }
}

#[test]
fn a_stack_in_memory_is_interleaved_by_lane_and_one_in_registers_is_free() {
    let steps = vec![(Op::Node, 0), (Op::Push, 2), (Op::Pop, 2)];
    let mut source = Recorded::list(Accel::Bvh, "stack", 64, &vec![(steps, NO_HIT); 32]);
    assert_eq!(run(&source).pass(Pass::Primary).traffic.stack, BufferTraffic::default());
    source.header.stack_entries = 7;
    let counters = run(&source);
    // 32 entries of 8 bytes at one depth are 4 lines: written without being read, then read.
    let stack = counters.pass(Pass::Primary).traffic.stack;
    assert_eq!((stack.levels[1].accesses, stack.levels[1].misses), (8, 4));
    assert_eq!((stack.dram_read_bytes, stack.dram_write_bytes), (0, 0));
    assert_eq!(counters.flush.dram_write_bytes, 4 * 64);
    // A store is not waited for.
    assert_eq!(counters.pass(Pass::Primary).issue.memory_waits, 2);
}

#[test]
fn a_frame_takes_half_the_time_at_twice_the_clock_and_bandwidth() {
    let rays: Vec<MockRay> =
        (0..640).map(|ray| (vec![(Op::Node, ray % 127), (Op::Primitive, ray % 64)], ray % 64)).collect();
    let source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
    let slow = estimate_on(&source, gpu(&[]));
    let twice = [
        ("mhz = { value = 710", "mhz = { value = 1420"),
        ("peak_gbs = { value = 29.8", "peak_gbs = { value = 59.6"),
        ("latency_ns = { value = 300", "latency_ns = { value = 150"),
    ];
    let fast = estimate_on(&source, gpu(&twice));
    for (slow, fast) in slow.bounds.iter().zip(&fast.bounds) {
        assert!((slow.seconds - 2.0 * fast.seconds).abs() <= 1e-12 * slow.seconds, "{slow:?} {fast:?}");
    }
    assert_eq!(slow.deciding_bound, fast.deciding_bound);
    let only_clock = estimate_on(&source, gpu(&twice[..1]));
    let dram = |estimate: &Estimate| {
        estimate.bounds.iter().find(|bound| bound.name == "DRAM bandwidth").map(|bound| bound.seconds)
    };
    assert_eq!(dram(&slow), dram(&only_clock));
}

#[test]
fn the_frame_time_is_no_less_than_any_bound_and_passes_and_stack_share_it_out() {
    let rays: Vec<MockRay> = (0..100).map(|ray| (vec![(Op::Node, ray)], ray % 64)).collect();
    let estimate = estimate_on(&Recorded::list(Accel::Bvh, "stack", 64, &rays), gpu(&[]));
    let largest = estimate.bounds.iter().map(|bound| bound.seconds).fold(0.0, f64::max);
    let decides = estimate.bounds.iter().find(|bound| bound.name == estimate.deciding_bound).unwrap();
    assert_eq!(decides.seconds, largest);
    let milliseconds = number(&estimate, "frame_time_ms");
    assert!(milliseconds >= largest * 1e3);
    let of_stack: f64 = estimate.stack.iter().map(|part| part.seconds).sum();
    assert!((of_stack * 1e3 - milliseconds).abs() <= 1e-12 * milliseconds);
    assert!(estimate.residual <= 1e-9);
    let of_passes = estimate.passes.iter().map(|pass| pass.counters.get("frame_time_ms").unwrap());
    let sum: f64 = of_passes.filter_map(Value::number).sum();
    assert!((sum - milliseconds).abs() <= 1e-12 * sum);
}

#[test]
fn every_counter_is_a_number_or_says_why_not() {
    for rays in [Vec::new(), node_rays(40, |ray| ray)] {
        let estimate = estimate_on(&Recorded::list(Accel::Kd, "restart", 64, &rays), gpu(&[]));
        assert_eq!(estimate.frame.iter().count(), COUNTERS.len());
        let sets = estimate.passes.iter().map(|pass| &pass.counters).chain([&estimate.frame]);
        for (counter, value) in sets.flat_map(|set| set.iter()) {
            match value {
                Value::Count(_) => {}
                Value::Real(real) => assert!(real.is_finite(), "{}: {real}", counter.id),
                Value::Absent { reason } => assert!(!reason.is_empty(), "{}", counter.id),
            }
        }
    }
}

#[test]
fn the_counters_are_the_agreed_ones() {
    let agreed = "frame_time_ms fps rays mrays_per_second structure_nodes structure_bytes node_fetches \
        node_fetches_per_ray node_fetches_per_pixel primitive_tests primitive_tests_per_ray non_opaque_hits any_hits \
        any_hits_per_ray instances instances_per_ray tlas_step_share restarts \
        ray_unit_rays ray_unit_utilization ray_unit_efficiency ray_unit_box_cycles \
        ray_unit_triangle_cycles ray_unit_port_cycles ray_unit_box_tests ray_unit_tlas_box_tests ray_unit_instances \
        ray_unit_non_opaque_hits ray_unit_resume_messages ray_unit_resumed_rays \
        ray_unit_box_nodes ray_unit_box_nodes_quarter \
        ray_unit_box_nodes_half ray_unit_box_nodes_three_quarters ray_unit_box_nodes_full \
        ray_unit_triangle_nodes ray_unit_triangle_nodes_quarter ray_unit_triangle_nodes_half \
        ray_unit_triangle_nodes_three_quarters ray_unit_triangle_nodes_full fragments \
        warps vertices alu_operations alu_operations_issued efu_operations efu_operations_issued memory_instructions \
        load_store_cycles atomics dispatches shader_calls alu_per_fragment \
        alu_issued_per_fragment efu_per_fragment simt_efficiency occupancy sp_memory_read_bytes \
        sp_memory_read_bytes_per_second texture_memory_read_bytes vertex_memory_read_bytes external_read_bytes \
        load_store_external_read_bytes texture_external_read_bytes dram_read_bytes dram_write_bytes l1_accesses \
        l1_misses l2_accesses l2_misses load_store_l2_accesses load_store_l2_misses texture_l2_accesses texture_l2_misses \
        l1_miss_ratio l2_miss_ratio shader_alu_capacity_utilized time_alus_working \
        shaders_busy stalled_on_system_memory avg_bytes_per_fragment energy_mj power_mw \
        energy_nj_per_ray dram_energy_share";
    assert!(COUNTERS.iter().map(|counter| counter.id).eq(agreed.split_whitespace()));
    for counter in COUNTERS {
        let texts = [counter.name, counter.group, counter.unit, counter.formula];
        assert!(texts.iter().all(|text| !text.is_empty()), "{}", counter.id);
    }
}

#[test]
fn progress_hears_of_every_tile() {
    let source = Recorded::list(Accel::Bvh, "stack", 64, &node_rays(5000, |_| 0));
    let (calls, last) = (AtomicU64::new(0), AtomicU64::new(0));
    let progress = |done: u64, of: u64| {
        assert!(done <= of && of == 5);
        calls.fetch_add(1, Ordering::Relaxed);
        last.fetch_max(done, Ordering::Relaxed);
    };
    replay(&source, &config(gpu(&[])), Maps::Dropped, &progress).unwrap();
    assert_eq!((calls.into_inner(), last.into_inner()), (5, 5));
}

#[test]
fn traces_that_contradict_themselves_are_refused() {
    let with = |step| Recorded::list(Accel::Bvh, "stack", 64, &[(vec![(Op::Node, 126), step], NO_HIT)]);
    run(&with((Op::Primitive, 63)));
    for (step, expected) in [
        ((Op::Node, 127), "node 127"),
        ((Op::Up, 127), "node 127"),
        ((Op::Primitive, 64), "primitive 64"),
        ((Op::Instance, 0), "instance 0"),
        ((Op::AnyHit, 0), "AnyHit"),
    ] {
        let message = refusal(&with(step));
        assert!(message.contains(expected) && message.contains("'mock'"), "{message}");
    }

    let mut pair = with((Op::Node, 125));
    pair.header.node_fetch = NodeFetch::Pair;
    assert!(refusal(&pair).contains("sibling of node 126"), "{}", refusal(&pair));

    let mut stack = with((Op::Push, 5));
    stack.header.stack_entries = 5;
    assert!(refusal(&stack).contains("stack entry 5 of 5"));
    stack.header.stack_entries = 6;
    run(&stack);

    let hit = Recorded::list(Accel::Bvh, "stack", 64, &[(vec![(Op::Node, 0)], 64)]);
    assert!(refusal(&hit).contains("triangle 64"));

    let mut sets = with((Op::Node, 0));
    sets.tiles[0].ray_sets.clear();
    assert!(refusal(&sets).contains("0 ray sets, expected 1"));

    let mut ends = with((Op::Node, 0));
    ends.tiles[0].ray_sets[0].ends[0] = 3;
    assert!(refusal(&ends).contains("2 steps up to 3"));

    let mut name = with((Op::Node, 0));
    name.header.traversal = "zigzag".to_owned();
    assert!(refusal(&name).contains("'zigzag'"));

    let mut registers = with((Op::Node, 0));
    registers.header.short_stack = 1000;
    assert!(refusal(&registers).contains("shorten the short stack"));
}

proptest! {
    #[test]
    fn simt_efficiency_is_at_least_one_lane_and_at_most_all(
        lanes in prop::collection::vec(prop::collection::vec((0..5_usize, 0_u32..60), 1..12), 1..70),
        structure in 0..3_usize,
    ) {
        let ops = [Op::Node, Op::Node, Op::Primitive, Op::Up, Op::Restart];
        let rays: Vec<MockRay> =
            lanes.into_iter().map(|lane| (lane.into_iter().map(|(op, id)| (ops[op], id)).collect(), NO_HIT)).collect();
        let mut source = Recorded::list(Accel::Bvh, "stack", 64, &rays);
        source.header.loop_structure =
            [LoopStructure::WhileWhile, LoopStructure::IfIf, LoopStructure::SingleLoop][structure];
        let issue = run(&source).total().issue;
        prop_assert!(issue.alu_active <= issue.alu_issued);
        prop_assert!(issue.alu_issued <= 32 * issue.alu_active);
        prop_assert_eq!(issue.lane_steps, rays.iter().map(|(steps, _)| steps.len() as u64).sum::<u64>());
    }
}
