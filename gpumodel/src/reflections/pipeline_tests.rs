//! What does a ray-tracing pipeline cost beside an uber shader?

use super::ReflectionFrame;
use super::pipeline::{Binding, Pipeline};
use super::tests::{config, cornell, kept};
use crate::config::{HitShading, Reflections, SecondaryQuery};
use crate::counters::{IssueCounters, Pass, PassCounters};
use crate::replay::{Maps, ReplayConfig};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// On the Mali-G715, whose driver links nothing unless the test says so.
fn pipeline(change: impl FnOnce(&mut Reflections)) -> ReplayConfig {
    let mut config = config("reflections-pipeline");
    change(config.technique.reflections.as_mut().expect("it has reflections"));
    config
}

fn linked() -> ReplayConfig {
    let mut config = pipeline(|_| {});
    let limits = config.gpu.ray_pipeline.as_mut().expect("it has limits");
    (limits.linked_shaders, limits.inlined_shaders) = (7, 6);
    config
}

fn tracing(frame: &ReflectionFrame<'_>, config: &ReplayConfig) -> PassCounters {
    *kept(frame, config).replayed.counters.pass(Pass::Reflection)
}

#[test]
fn linked_shaders_cost_an_uber_shader_and_the_records_and_calls_cost_more() {
    cornell(None, |_, frame| {
        let uber = tracing(frame, &config("reflections-direct")).issue;
        let linked = tracing(frame, &linked()).issue;
        let called = tracing(frame, &pipeline(|_| {})).issue;
        // Ray generation, miss and five materials are seven shaders.
        assert!(uber.shader_calls == 0 && linked.shader_calls == 0 && called.shader_calls > 0);
        assert_eq!((uber.rays, uber.shaded), (linked.rays, linked.shaded));
        assert_eq!((uber.rays, uber.shaded), (called.rays, called.shaded));
        let work = |issue: &IssueCounters| (issue.alu_active, issue.memory_instructions);
        // Two loads of 16 bytes for each ray, with their addresses.
        assert_eq!(linked.alu_active, uber.alu_active + uber.rays * 2 * 3);
        assert!(work(&linked) > work(&uber) && work(&called) > work(&linked));
        let stack = |config: &ReplayConfig| {
            tracing(frame, config).traffic.stack.levels.iter().map(|level| level.accesses).sum::<u64>()
        };
        assert!(stack(&pipeline(|_| {})) > 0 && stack(&self::linked()) == 0);
    });
}

#[test]
fn each_limit_and_a_library_alone_make_calls_of_the_shaders() {
    let config = linked();
    let binding = |config: &ReplayConfig, materials| {
        let costs = config.costs.reflections().expect("the table has them").pipeline;
        let technique = config.technique.reflections.as_ref().expect("it has reflections");
        Pipeline::of(technique, &config.gpu, costs, materials).expect("it has a pipeline").binding
    };
    assert_eq!((binding(&config, 5), binding(&config, 6)), (Binding::Linked, Binding::Called));
    let change = |edit: &dyn Fn(&mut ReplayConfig)| {
        let mut config = linked();
        edit(&mut config);
        binding(&config, 5)
    };
    let limits = |config: &mut ReplayConfig| config.gpu.ray_pipeline.expect("it has limits");
    assert_eq!(change(&|config| config.gpu.ray_pipeline = None), Binding::Called);
    for inlined in [5, 6] {
        let of = change(&|config| {
            let limits = limits(config);
            config.gpu.ray_pipeline = Some(crate::config::RayPipeline { inlined_shaders: inlined, ..limits });
        });
        assert_eq!(of == Binding::Linked, inlined == 6);
    }
    let library = change(&|config| {
        config.technique.reflections.as_mut().expect("it has reflections").hit_shading =
            HitShading::PipelineLibrary;
    });
    assert_eq!(library, Binding::Called);
}

#[test]
fn larger_payloads_move_more_and_change_nothing_else() {
    cornell(None, |_, frame| {
        let of = |bytes| tracing(frame, &pipeline(|technique| technique.payload_bytes = Some(bytes))).issue;
        let found = [4, 16, 32, 64, 256].map(of);
        assert_eq!(found[0], found[1], "both are one store of 16 bytes");
        for pair in found[1..].windows(2) {
            assert!(pair[1].lane_bytes > pair[0].lane_bytes && pair[1].alu_active > pair[0].alu_active);
            assert_eq!((pair[0].shader_calls, pair[0].shaded), (pair[1].shader_calls, pair[1].shaded));
        }
    });
}

#[test]
fn an_emulated_unit_has_to_be_taken_away() {
    cornell(None, |_, frame| {
        let mut config = pipeline(|technique| technique.secondary_query = SecondaryQuery::HitShader);
        let error = super::replay_reflections(frame, &config, Maps::Dropped).expect_err("it has a unit");
        assert!(error.to_string().contains("take ray_unit away"), "{error}");
        config.gpu.ray_unit = None;
        let issue = tracing(frame, &config).issue;
        assert!(issue.box_nodes == 0 && issue.node_steps > 0 && issue.node_alu > 0);
    });
}

#[test]
fn a_pipeline_does_not_depend_on_threads() {
    cornell(None, |_, frame| {
        let [one, many] = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| kept(frame, &pipeline(|_| {})).replayed.counters)
        });
        assert_eq!(one, many);
    });
}

proptest! {
    #[test]
    fn every_lane_is_in_one_call(hits in prop::collection::vec(prop::option::of(0_u32..6), 1..40)) {
        let lanes: Vec<u32> = (0..hits.len() as u32).collect();
        let calls = super::pipeline::calls(&lanes, &hits);
        let shaders: BTreeSet<Option<u32>> = hits.iter().copied().collect();
        prop_assert!(calls.iter().map(|call| call.shader).eq(shaders));
        let mut called: Vec<u32> = calls.iter().flat_map(|call| call.lanes.clone()).collect();
        called.sort_unstable();
        prop_assert_eq!(called, lanes);
        for call in calls {
            prop_assert!(call.lanes.iter().all(|&lane| hits[lane as usize] == call.shader));
        }
    }
}
