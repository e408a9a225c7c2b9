//! Do the maps of a frame of reflections show what became of each pixel, and hold what the counters say?

use super::{Coverage, LaneSlots, ReflectionFrame, ReplayedReflections, Shadows, replay_reflections};
use crate::config::{Gpu, RayScheduling};
use crate::counters::Pass;
use crate::mock;
use crate::ordering::Binning;
use crate::replay::{Maps, ReplayConfig};
use scenes::Light;
use tracer::reflections::{
    GBuffer, March, Outcome, QueryOrigin, ReflectionList, ReflectionSettings, ReflectionTracer, Reflections,
};
use tracer::wide::NodeFormat;
use tracer::{
    Aabb, AccelerationStructure, BuildOptions, Query, ReflectionRays, SceneIdentity, Silent, Traversal, View,
};

/// Not a multiple of a tile, a warp or a workgroup.
const SIZE: (u32, u32) = (75, 45);

pub(super) fn config(technique: &str) -> ReplayConfig {
    let gpu = Gpu::builtin("mali-g715").expect("built in").expect("sound");
    ReplayConfig { technique: mock::technique(technique), ..mock::config(gpu) }
}

/// Hands `use_it` the reflections of the Cornell Box, every second triangle of which is a mirror and the others rough, with or without a march.
pub(super) fn cornell<T>(
    march: Option<March>,
    use_it: impl FnOnce(&AccelerationStructure, &ReflectionFrame<'_>) -> T,
) -> T {
    let scene = scenes::load("cornell").expect("built in");
    let triangles = scene.triangles();
    let traversal = Traversal::WideStack { format: NodeFormat::Compressed8 };
    let options = BuildOptions::default();
    let structure = AccelerationStructure::build(&triangles, traversal, &options).expect("valid");
    let view = View::new(&scene.camera, SIZE.0, SIZE.1);
    let gbuffer = GBuffer::trace(&structure, &triangles, view, SIZE.0, SIZE.1);
    let surfaces: Vec<ReflectionRays> = (0..triangles.len())
        .map(|triangle| if triangle % 2 == 0 { ReflectionRays::Mirror } else { ReflectionRays::None })
        .collect();
    let origin = if march.is_some() { QueryOrigin::LastFree } else { QueryOrigin::Surface };
    let settings = ReflectionSettings { surfaces: &surfaces, seed: 0, march, origin };
    let reflections = Reflections::new(&gbuffer, settings);
    let lights: Vec<_> = scene.lights.iter().map(|Light::Point { position, .. }| *position).collect();
    let list = |order: Vec<u32>, shadows: Shadows| {
        let lights = if shadows == Shadows::Traced { lights.clone() } else { Vec::new() };
        let identity = SceneIdentity { name: "cornell".to_owned(), hash: 0 };
        let rays = reflections.rays();
        ReflectionTracer::new(&structure, &options, &triangles, identity, rays, order, lights)
            .map(|tracer| Box::new(tracer) as Box<dyn ReflectionList>)
    };
    let shaders: Vec<u32> = (0..triangles.len() as u32).map(|triangle| triangle % 5).collect();
    let bounds = triangles.iter().map(Aabb::of_triangle).fold(Aabb::EMPTY, Aabb::union);
    let frame = ReflectionFrame { reflections: &reflections, list: &list, shaders: &shaders, bounds };
    use_it(&structure, &frame)
}

pub(super) fn kept(frame: &ReflectionFrame<'_>, config: &ReplayConfig) -> ReplayedReflections {
    replay_reflections(frame, config, Maps::Kept).expect("a real frame")
}

const TECHNIQUES: [(&str, Option<March>); 5] = [
    ("reflections-pipeline", None),
    ("reflections-direct", None),
    ("reflections-hybrid-direct", Some(March::HIERARCHICAL)),
    ("reflections-hybrid-sign", Some(March::HIERARCHICAL)),
    ("reflections-visibility-buffer", Some(March::HIERARCHICAL)),
];

#[test]
fn coverage_is_the_outcome_of_each_pixel_and_what_its_ray_hits() {
    for (technique, march) in TECHNIQUES {
        cornell(march, |structure, frame| {
            let maps = kept(frame, &config(technique)).maps.expect("kept");
            let mut rays = frame.reflections.rays().iter();
            let expected: Vec<Coverage> = frame
                .reflections
                .outcomes()
                .iter()
                .map(|outcome| match outcome {
                    Outcome::Sky => Coverage::NoSurface,
                    Outcome::Fallback => Coverage::Fallback,
                    Outcome::ScreenHit { .. } => Coverage::Screen,
                    Outcome::Query => {
                        let ray = rays.next().expect("a ray for each query").ray;
                        let hit = structure.trace(&ray, Query::Closest, &mut Silent);
                        if hit.is_hit() { Coverage::QueryHit } else { Coverage::QueryMiss }
                    }
                })
                .collect();
            assert!(maps.coverage == expected, "{technique}");
            assert_eq!((maps.width, maps.coverage.len()), (SIZE.0, (SIZE.0 * SIZE.1) as usize));
            for class in [Coverage::QueryHit, Coverage::QueryMiss, Coverage::Fallback] {
                assert!(expected.contains(&class), "{technique} has {class:?}");
            }
        });
    }
}

#[test]
fn pixels_add_up_to_the_counters() {
    for (technique, march) in TECHNIQUES {
        cornell(march, |_, frame| {
            let ReplayedReflections { replayed, maps, .. } = kept(frame, &config(technique));
            let (heat, maps) = (replayed.maps.expect("kept"), maps.expect("kept"));
            let sum = |values: &[u32]| values.iter().map(|&value| u64::from(value)).sum::<u64>();
            let counters = &replayed.counters;
            assert_eq!(sum(&heat.node_fetches.values), counters.total().issue.node_fetches, "{technique}");
            assert!(sum(&heat.loaded_bytes.values) > 0 && sum(&heat.warp_misses.values) > 0, "{technique}");

            let slots: Vec<LaneSlots> =
                maps.lane_slots.expect("rays of a warp go together").into_iter().flatten().collect();
            let issue = counters.pass(Pass::Reflection).issue;
            assert_eq!(slots.len() as u64, issue.rays, "{technique}");
            // Each warp's steps stand at each of its lanes.
            let by_lane = |steps: fn(&LaneSlots) -> u64| {
                slots.iter().map(|of| steps(of) as f64 / f64::from(of.lanes)).sum::<f64>()
            };
            assert!((by_lane(|of| of.lane_steps) - issue.lane_steps as f64).abs() < 1e-3, "{technique}");
            assert!((by_lane(|of| of.warp_steps) - issue.warp_steps as f64).abs() < 1e-3, "{technique}");
        });
    }
}

#[test]
fn rays_that_are_alone_in_their_warps_waste_nothing_and_lists_of_bins_less_than_pixels() {
    cornell(Some(March::HIERARCHICAL), |_, frame| {
        let wasted = |config: &ReplayConfig| {
            let maps = kept(frame, config).maps.expect("kept");
            let slots: Vec<LaneSlots> =
                maps.lane_slots.expect("rays of a warp go together").into_iter().flatten().collect();
            slots.iter().map(|of| of.wasted()).sum::<f64>() / slots.len() as f64
        };
        let mut narrow = config("reflections-hybrid");
        narrow.gpu.cores.warp_width = 1;
        assert_eq!(wasted(&narrow), 0.0);
        let mut binned = config("reflections-hybrid-sign");
        let by_sign = wasted(&binned);
        binned.technique.reflections.as_mut().expect("it has reflections").binning = Binning::None;
        let by_arrival = wasted(&binned);
        assert!(0.0 < by_sign && by_sign < by_arrival && by_arrival < 1.0, "{by_sign} {by_arrival}");
    });
}

#[test]
fn a_unit_that_takes_each_ray_by_itself_has_no_lane_that_waits() {
    cornell(Some(March::HIERARCHICAL), |_, frame| {
        let mut config = config("reflections-hybrid-sign");
        config.gpu.ray_unit.as_mut().expect("it has one").scheduling = RayScheduling::Ray;
        assert_eq!(kept(frame, &config).maps.expect("kept").lane_slots, None);
        // Shaders walk in lockstep.
        config.gpu.ray_unit = None;
        assert!(kept(frame, &config).maps.expect("kept").lane_slots.is_some());
    });
}

#[test]
fn maps_change_no_count_and_do_not_depend_on_threads() {
    cornell(Some(March::HIERARCHICAL), |_, frame| {
        let config = config("reflections-visibility-buffer");
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| kept(frame, &config))
        };
        let [one, many] = [1, 4].map(on_threads);
        assert!(one.maps == many.maps && one.replayed.maps == many.replayed.maps);
        let dropped = replay_reflections(frame, &config, Maps::Dropped).expect("a real frame");
        assert!(dropped.maps.is_none() && dropped.replayed.maps.is_none());
        assert_eq!(dropped.replayed.counters, one.replayed.counters);
    });
}
