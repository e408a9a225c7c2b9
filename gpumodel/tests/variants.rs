//! Do techniques, layouts and orders differ in what they should differ in, and in nothing else?

mod common;

use common::{SIZE, Traced, config};
use gpumodel::{
    FrameCounters, Gpu, Maps, NodeOrder, NodeRecords, Pass, PrimitiveLayout, PrimitiveOrder, ReplayConfig,
    Replayed, TECHNIQUES, Value, estimate, replay, replay_all,
};
use tracer::{
    AlphaMode, AlphaTests, Frame, FrameTracer, MicromapFormat, MicromapStates, Ray, Rays, TestedTriangles,
    TileSource, Traversal,
};

const PIXELS: u64 = SIZE.0 as u64 * SIZE.1 as u64;

fn teapot(traversal: Traversal) -> Traced {
    Traced::new("teapot", traversal)
}

/// The frame with what a rasteriser draws.
fn frame(traced: &Traced) -> FrameTracer<'_> {
    traced.frame().with_raster()
}

fn run(traced: &Traced, config: &ReplayConfig) -> Replayed {
    replay(&frame(traced), config, Maps::Kept, &|_, _| {}).expect("valid")
}

/// One configuration for each technique whose frames are of pixels, as a trace is.
fn of_pixels() -> Vec<ReplayConfig> {
    let all = TECHNIQUES.iter().map(|technique| config(technique.name));
    all.filter(|config| config.technique.reflections.is_none()).collect()
}

fn counters(traced: &Traced, config: &ReplayConfig) -> FrameCounters {
    run(traced, config).counters
}

#[test]
fn variants_side_by_side_count_what_each_counts_alone() {
    for traversal in [Traversal::BvhStack, Traversal::KdBacktrack] {
        let traced = teapot(traversal);
        let mut configs = of_pixels();
        for layout in PrimitiveLayout::ALL {
            configs.push(ReplayConfig { primitive_layout: layout, ..config("fragment") });
        }
        for order in NodeOrder::ALL {
            configs.push(ReplayConfig { node_order: order, ..config("hybrid") });
        }
        for order in PrimitiveOrder::ALL {
            configs.push(ReplayConfig { primitive_order: Some(order), ..config("compute") });
        }
        for records in NodeRecords::ALL
            .into_iter()
            .filter(|records| *records != NodeRecords::ChildBoxes || traversal == Traversal::BvhStack)
        {
            for layout in [PrimitiveLayout::Padded, PrimitiveLayout::Split] {
                configs.push(ReplayConfig {
                    node_records: records,
                    primitive_layout: layout,
                    ..config("fragment")
                });
            }
        }
        let together = replay_all(&frame(&traced), &configs, Maps::Kept, &|_, _| {}).expect("valid");
        for (config, together) in configs.iter().zip(together) {
            let alone = run(&traced, config);
            assert!(alone.counters == together.counters, "{}", config.technique.name);
            assert!(alone.maps == together.maps, "{}", config.technique.name);
        }
    }
}

#[test]
fn dropping_the_maps_changes_no_counter() {
    let traced = teapot(Traversal::BvhStack);
    for config in of_pixels() {
        let dropped = replay(&frame(&traced), &config, Maps::Dropped, &|_, _| {}).expect("valid");
        assert!(dropped.maps.is_none());
        assert!(dropped.counters == counters(&traced, &config), "{}", config.technique.name);
    }
}

#[test]
fn maps_add_up_to_the_counters() {
    let traced = teapot(Traversal::KdPushDown { short_stack: 0 });
    for technique in ["fragment", "hybrid"] {
        let Replayed { counters, maps, .. } = run(&traced, &config(technique));
        let maps = maps.expect("kept");
        let sum = |values: &[u32]| values.iter().map(|&value| u64::from(value)).sum::<u64>();
        let traced_passes = [Pass::Primary, Pass::Shadow].map(|pass| counters.pass(pass).issue);
        let fetches = traced_passes.iter().map(|issue| issue.node_fetches).sum::<u64>();
        assert_eq!(sum(&maps.node_fetches.values), fetches);
        let bytes = traced_passes.iter().map(|issue| issue.lane_bytes).sum::<u64>();
        assert_eq!(sum(&maps.loaded_bytes.values), bytes);
        // A warp's misses stand at each of its pixels, so that one pixel in 32 of a full warp counts.
        let by_warp: u64 = sum(&maps.warp_misses.values);
        let misses: u64 = [Pass::Primary, Pass::Shadow, Pass::Output]
            .into_iter()
            .map(|pass| counters.pass(pass).traffic.total().dram_read_bytes / 64)
            .sum();
        assert!(by_warp <= 32 * misses && by_warp > 16 * misses, "{by_warp} {misses}");
    }
}

#[test]
fn any_hit_shaders_are_in_the_maps_and_count_side_by_side_what_they_count_alone() {
    let micromap = Some(MicromapFormat { level: 3, states: MicromapStates::Four });
    for (mode, micromap) in [(AlphaMode::Unmarked, None), (AlphaMode::Micromap, micromap)] {
        let tests = AlphaTests { mode, tested: TestedTriangles::OnePairInFour, micromap };
        // Maps count no bytes of a stack.
        let opaque = teapot(Traversal::BvhParentLink);
        let structure = opaque.structure.with_alpha(tests).expect("it has such triangles");
        let traced = Traced { structure, ..opaque };
        let configs = [config("fragment"), config("compute"), {
            ReplayConfig { primitive_layout: PrimitiveLayout::Split, ..config("fragment") }
        }];
        let together = replay_all(&frame(&traced), &configs, Maps::Kept, &|_, _| {}).expect("valid");
        for (config, together) in configs.iter().zip(together) {
            let alone = run(&traced, config);
            assert!(alone.counters == together.counters && alone.maps == together.maps, "{mode:?}");
            let of_passes = [Pass::Primary, Pass::Shadow].map(|pass| alone.counters.pass(pass).issue);
            let asked: u64 = of_passes.iter().map(|issue| issue.any_hits).sum();
            assert!(asked > 0, "{mode:?}");
            let maps = alone.maps.expect("kept");
            let bytes: u64 = maps.loaded_bytes.values.iter().map(|&value| u64::from(value)).sum();
            assert_eq!(bytes, of_passes.iter().map(|issue| issue.lane_bytes).sum::<u64>(), "{mode:?}");
        }
    }
}

#[test]
fn hybrid_traces_the_same_shadow_rays_and_no_primary_ones() {
    for traversal in Traversal::ALL {
        let traced = teapot(traversal);
        let (fragment, hybrid) =
            (counters(&traced, &config("fragment")), counters(&traced, &config("hybrid")));
        assert_eq!(*hybrid.pass(Pass::Primary), gpumodel::PassCounters::default());
        let shadow = |counters: &FrameCounters| counters.pass(Pass::Shadow).issue;
        assert_eq!(shadow(&fragment), shadow(&hybrid), "{traversal:?}");
        let geometry = hybrid.pass(Pass::Geometry);
        assert!(geometry.issue.alu_active > 0 && geometry.traffic.vertex.dram_read_bytes > 0);
        assert!(geometry.issue.setup_triangles > 0 && geometry.issue.covered_fragments > 0);
    }
}

#[test]
fn the_geometry_pass_reads_each_vertex_of_a_bin_once() {
    let traced = teapot(Traversal::BvhStack);
    let hybrid = counters(&traced, &config("hybrid"));
    // 75x45 pixels are one bin: it needs no binning, and no list.
    assert_eq!(*hybrid.pass(Pass::Binning), gpumodel::PassCounters::default());
    let geometry = hybrid.pass(Pass::Geometry);
    assert_eq!(geometry.issue.bin_list_bytes, 0);
    assert_eq!(geometry.issue.vertices, 3 * geometry.issue.setup_triangles);
    let least = geometry.issue.vertices * 24;
    assert!(geometry.traffic.vertex.dram_read_bytes >= least, "{least}");

    // With little tile memory there are many bins, each with its list and its triangles.
    let toml = gpumodel::BuiltinGpu::named("adreno-540")
        .expect("it is built in")
        .toml
        .replace("tile_memory_bytes = { value = 1048576", "tile_memory_bytes = { value = 24576");
    let small = ReplayConfig { gpu: Gpu::parse(&toml, "small.toml").expect("valid"), ..config("hybrid") };
    let binned = counters(&traced, &small);
    assert_eq!(binned.pass(Pass::Binning).issue.vertices, 3 * traced.triangles.len() as u64);
    // 64x32 pixels of 12 bytes: 2 x 2 bins, one bit per triangle each, written by one pass and read by the other.
    let lists = 4 * (traced.triangles.len() as u64).div_ceil(8);
    assert_eq!(binned.pass(Pass::Binning).issue.bin_list_bytes, lists);
    assert_eq!(binned.pass(Pass::Geometry).issue.bin_list_bytes, lists);
    let setups = |counters: &FrameCounters| counters.pass(Pass::Geometry).issue.setup_triangles;
    assert!(setups(&binned) > setups(&hybrid), "triangles in two bins are set up twice");
    let fragments = |counters: &FrameCounters| counters.pass(Pass::Geometry).issue.covered_fragments;
    assert_eq!(fragments(&binned), fragments(&hybrid));
}

#[test]
fn attachments_in_memory_are_written_and_read_once_per_pixel() {
    let traced = teapot(Traversal::BvhStack);
    let (tile, memory) =
        (counters(&traced, &config("hybrid")), counters(&traced, &config("hybrid-resolved")));
    let written = |counters: &FrameCounters| counters.total().issue.output_bytes;
    assert_eq!(written(&memory), written(&tile) + PIXELS * 8);
    assert_eq!(tile.pass(Pass::Output).traffic.image, gpumodel::BufferTraffic::default());
    let read = memory.pass(Pass::Output).traffic.image.dram_read_bytes;
    // Lines at the edge of the image hold pixels outside it.
    assert!((PIXELS * 8..=PIXELS * 8 * 2).contains(&read), "{read}");
}

#[test]
fn a_compute_stage_writes_an_image_that_a_quad_reads_as_a_texture() {
    let traced = teapot(Traversal::BvhStack);
    let (fragment, compute) = (counters(&traced, &config("fragment")), counters(&traced, &config("compute")));
    let present = compute.pass(Pass::Present);
    assert_eq!(present.issue.output_bytes, PIXELS * 4);
    assert_eq!(present.issue.lane_bytes, PIXELS * 4);
    // Through the texture cache, each line once per warp.
    assert_eq!(present.traffic.image.levels[0].accesses, present.issue.line_accesses);
    assert!(present.issue.line_accesses * 64 >= PIXELS * 4);
    assert_eq!(compute.pass(Pass::Output).issue.output_bytes, 0);
    for pass in [Pass::Primary, Pass::Shadow] {
        let work = |counters: &FrameCounters| {
            let issue = counters.pass(pass).issue;
            (issue.rays, issue.lane_steps, issue.node_fetches, issue.alu_active)
        };
        assert_eq!(work(&fragment), work(&compute), "{pass:?}");
    }
    assert_eq!(*fragment.pass(Pass::Present), gpumodel::PassCounters::default());
}

#[test]
fn the_boxes_of_both_children_in_one_record_spare_a_fetch_and_the_leaves_records() {
    let traced = teapot(Traversal::BvhStack);
    let packed = run(&traced, &config("fragment"));
    let wide = ReplayConfig { node_records: NodeRecords::ChildBoxes, ..config("fragment") };
    let wide = run(&traced, &wide);
    let (packed_issue, wide_issue) = (packed.counters.total().issue, wide.counters.total().issue);
    // Each ray reads the root alone, then pairs.
    assert_eq!(packed_issue.node_fetches - packed_issue.rays, 2 * wide_issue.node_fetches);
    // Of 2n - 1 nodes, n - 1 are inner.
    let nodes = packed.structure_bytes / 32;
    assert_eq!(wide.structure_bytes, (nodes - 1) / 2 * 64);

    let single = teapot(Traversal::BvhParentLink);
    let refused = ReplayConfig { node_records: NodeRecords::ChildBoxes, ..config("fragment") };
    let message = replay(&frame(&single), &refused, Maps::Dropped, &|_, _| {})
        .expect_err("it reads one node per step")
        .to_string();
    assert!(message.contains("siblings in pairs") && message.contains("parent-link"), "{message}");
}

#[test]
fn padded_node_records_take_more_room_and_no_more_loads() {
    let traced = teapot(Traversal::BvhParentLink);
    let packed = run(&traced, &config("fragment"));
    let padded = run(&traced, &ReplayConfig { node_records: NodeRecords::Padded, ..config("fragment") });
    assert_eq!(padded.structure_bytes * 48, packed.structure_bytes * 64);
    assert_eq!(padded.counters.total().issue.lane_bytes, packed.counters.total().issue.lane_bytes);
}

#[test]
fn only_indexed_triangles_have_an_index_list() {
    for (traversal, usual) in
        [(Traversal::BvhStack, PrimitiveOrder::Leaf), (Traversal::KdStack, PrimitiveOrder::Indexed)]
    {
        let traced = teapot(traversal);
        let with = |order| counters(&traced, &ReplayConfig { primitive_order: order, ..config("fragment") });
        let [leaf, indexed] = [PrimitiveOrder::Leaf, PrimitiveOrder::Indexed].map(|order| with(Some(order)));
        assert_eq!(leaf.total().traffic.index, gpumodel::BufferTraffic::default());
        assert!(indexed.total().traffic.index.levels[1].accesses > 0);
        assert_eq!(with(None), with(Some(usual)), "{traversal:?}");
        assert_eq!(leaf.total().issue.primitive_tests, indexed.total().issue.primitive_tests);
    }
}

#[test]
fn a_list_of_rays_cannot_be_rasterised_and_says_so() {
    let traced = teapot(Traversal::BvhStack);
    let rays: Vec<Ray> = (0..40).map(|x| traced.view().primary_ray(x, 20)).collect();
    let list = traced.tracer(Rays::List(rays), Vec::new());
    assert!(matches!(list.header().frame, Frame::List { .. }));
    let message =
        replay(&list, &config("hybrid"), Maps::Dropped, &|_, _| {}).expect_err("no image").to_string();
    assert!(message.contains("use a technique that traces primary rays"), "{message}");
    replay(&list, &config("compute"), Maps::Kept, &|_, _| {}).expect("a list is computed as well");
}

#[test]
fn phases_add_up_to_the_frame_and_passes_to_their_phase() {
    let traced = teapot(Traversal::BvhStack);
    for config in of_pixels() {
        let frame = frame(&traced);
        let replayed = run(&traced, &config);
        let estimate = estimate(&replayed, frame.header(), frame.topology(), &config).unwrap();
        let time =
            |set: &gpumodel::CounterSet| set.get("frame_time_ms").and_then(Value::number).expect("a number");
        let sum: f64 = estimate.passes.iter().map(|pass| time(&pass.counters)).sum();
        assert!((sum - time(&estimate.frame)).abs() <= 1e-12 * sum, "{}", config.technique.name);
        let passes: Vec<Pass> = estimate.passes.iter().map(|pass| pass.pass).collect();
        // The frame fits into one bin, and one eye is traced as any other image.
        let others = [Pass::Binning, Pass::ErrorDetection, Pass::Reprojection];
        let expected = config.technique.passes().into_iter().filter(|pass| !others.contains(pass));
        assert_eq!(passes, expected.collect::<Vec<_>>());
        assert_eq!(
            estimate.left_out.iter().any(|entry| entry.what == "binning"),
            config.technique.raster.is_some()
        );
        assert!(estimate.bounds.iter().all(|bound| bound.seconds * 1e3 <= sum * (1.0 + 1e-12)));
        let geometry = estimate.passes.iter().find(|pass| pass.pass == Pass::Geometry);
        assert!(geometry.is_none_or(|pass| time(&pass.counters) > 0.0 && pass.deciding_bound != "none"));
    }
}
