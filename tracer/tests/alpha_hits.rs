//! Do all traversals find the hit that a mask leaves, and ask about it as they should?

mod kd_support;

use kd_support::*;
use scenes::{Instance, Triangle};
use tracer::wide::NodeFormat;
use tracer::{
    Accel, AccelerationStructure, AlphaMode, AlphaTests, BuildOptions, DECIDED_BY_MICROMAP, Hit,
    MicromapFormat, MicromapStates, Observer, Op, PreparedTriangle, Query, Ray, Silent, TestedTriangles,
    Traversal, fence,
};

fn traversals() -> Vec<Traversal> {
    let mut all = Traversal::ALL.to_vec();
    all.extend(NodeFormat::ALL.map(|format| Traversal::WideStack { format }));
    all.extend(NodeFormat::ALL.map(|format| Traversal::TwoLevelStack { format: Some(format) }));
    all.push(Traversal::WideShortStack { format: NodeFormat::Adreno8, short_stack: 1 });
    all.push(Traversal::BvhRestartTrail { bits: None, short_stack: 2 });
    all.push(Traversal::KdPushDown { short_stack: 2 });
    all
}

/// Every third triangle, in runs of four.
fn tested(triangles: usize) -> TestedTriangles {
    TestedTriangles::of((0..triangles).map(|triangle| triangle / 4 % 3 == 0))
}

fn tests(mode: AlphaMode, triangles: usize) -> AlphaTests {
    let micromap =
        (mode == AlphaMode::Micromap).then_some(MicromapFormat { level: 4, states: MicromapStates::Four });
    AlphaTests { mode, tested: tested(triangles), micromap }
}

fn build(triangles: &[Triangle], traversal: Traversal, alpha: Option<AlphaTests>) -> AccelerationStructure {
    let structure = AccelerationStructure::build(triangles, traversal, &BuildOptions::default()).unwrap();
    match alpha {
        Some(alpha) => structure.with_alpha(alpha).unwrap(),
        None => structure,
    }
}

/// Whether a hit counts.
fn counts(mode: AlphaMode, tested: &TestedTriangles, hit: &Hit) -> bool {
    let is_tested = tested.contains(hit.primitive);
    match mode {
        AlphaMode::Opaque => true,
        AlphaMode::Cull => !is_tested,
        AlphaMode::AnyHit | AlphaMode::Unmarked | AlphaMode::Micromap => !is_tested || fence(hit.u),
    }
}

/// The nearest hit that counts, the lowest triangle among equals.
fn nearest(prepared: &[PreparedTriangle], ray: &Ray, counts: impl Fn(&Hit) -> bool) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    for (primitive, triangle) in (0..).zip(prepared) {
        if let Some((t, u, v)) = triangle.intersect(ray, best.t) {
            let hit = Hit { t, u, v, primitive };
            if (t < best.t || primitive < best.primitive) && counts(&hit) {
                best = hit;
            }
        }
    }
    best
}

/// The steps about triangles.
#[derive(Default)]
struct Asked(Vec<(Op, u32)>);

impl Observer for Asked {
    fn step(&mut self, op: Op, id: u32) {
        if matches!(op, Op::Primitive | Op::AnyHit) {
            self.0.push((op, id));
        }
    }
}

impl Asked {
    fn shaders(&self) -> usize {
        self.0.iter().filter(|&&(op, id)| op == Op::AnyHit && id & DECIDED_BY_MICROMAP == 0).count()
    }
}

fn rays(triangles: &[Triangle], count: usize, seed: u64) -> Vec<Ray> {
    let (low, high) = bounds(triangles);
    let mut random = Random(seed);
    (0..count)
        .map(|index| match index % 4 {
            0 => axis_ray(&mut random, triangles),
            1 => corner_ray(&mut random, triangles, low, high),
            _ => random_ray(&mut random, low, high),
        })
        .collect()
}

#[test]
fn every_traversal_finds_what_the_mask_leaves() {
    for triangles in [soup(700, 1), quads(6)] {
        let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::from).collect();
        let rays = rays(&triangles, 400, 2);
        for mode in AlphaMode::ALL {
            let tests = tests(mode, triangles.len());
            let expected: Vec<Hit> = rays
                .iter()
                .map(|ray| nearest(&prepared, ray, |hit| counts(mode, &tests.tested, hit)))
                .collect();
            for traversal in traversals() {
                let structure = build(&triangles, traversal, Some(tests.clone()));
                for (ray, expected) in rays.iter().zip(&expected) {
                    let hit = structure.trace(ray, Query::Closest, &mut Silent);
                    assert_eq!(hit, *expected, "{traversal:?} {mode:?} {ray:?}");
                    let any = structure.trace(ray, Query::Any, &mut Silent);
                    assert_eq!(any.is_hit(), expected.is_hit(), "{traversal:?} {mode:?} {ray:?}");
                    assert!(!any.is_hit() || counts(mode, &tests.tested, &any), "{traversal:?} {mode:?}");
                }
            }
        }
    }
}

#[test]
fn a_shader_is_asked_about_hits_of_its_triangles_alone_and_right_after_their_tests() {
    let triangles = soup(700, 3);
    let rays = rays(&triangles, 200, 4);
    for traversal in traversals() {
        for mode in AlphaMode::ALL {
            let tests = tests(mode, triangles.len());
            let structure = build(&triangles, traversal, Some(tests.clone()));
            let references = structure.topology().references;
            let mut asked_of_any = 0;
            for (ray, query) in rays.iter().flat_map(|ray| Query::ALL.map(|query| (ray, query))) {
                let mut asked = Asked::default();
                structure.trace(ray, query, &mut asked);
                for pair in asked.0.windows(2).filter(|pair| pair[1].0 == Op::AnyHit) {
                    let position = pair[1].1 & !DECIDED_BY_MICROMAP;
                    assert_eq!(pair[0], (Op::Primitive, position), "{traversal:?} {mode:?}");
                    let is_tested = tests.tested.contains(references[position as usize]);
                    assert!(is_tested || mode == AlphaMode::Unmarked, "{traversal:?} {mode:?}");
                }
                asked_of_any += asked.shaders();
            }
            let asks = !matches!(mode, AlphaMode::Opaque | AlphaMode::Cull);
            assert_eq!(asked_of_any > 0, asks, "{traversal:?} {mode:?}");
        }
    }
}

#[test]
fn micromaps_spare_shaders_and_leave_every_hit_as_it_is() {
    let triangles = soup(700, 5);
    let rays = rays(&triangles, 600, 6);
    for traversal in traversals() {
        let by_shader = build(&triangles, traversal, Some(tests(AlphaMode::AnyHit, triangles.len())));
        let mut calls = Vec::new();
        for level in 0..=MicromapFormat::MAX_LEVEL {
            let micromap = Some(MicromapFormat { level, states: MicromapStates::Four });
            let tests = AlphaTests { micromap, ..tests(AlphaMode::Micromap, triangles.len()) };
            let by_micromap = build(&triangles, traversal, Some(tests));
            let mut of_level = 0;
            for (ray, query) in rays.iter().flat_map(|ray| Query::ALL.map(|query| (ray, query))) {
                let (mut asked, mut spared) = (Asked::default(), Asked::default());
                let expected = by_shader.trace(ray, query, &mut asked);
                assert_eq!(by_micromap.trace(ray, query, &mut spared), expected, "{traversal:?} {level}");
                let places = |asked: &Asked| -> Vec<_> {
                    asked.0.iter().map(|&(op, id)| (op, id & !DECIDED_BY_MICROMAP)).collect()
                };
                assert_eq!(places(&asked), places(&spared), "{traversal:?}: what is asked is the same");
                of_level += spared.shaders();
            }
            calls.push(of_level);
        }
        assert!(calls.is_sorted_by(|a, b| a >= b), "{traversal:?}: {calls:?}");
        assert!(calls[4] * 4 < calls[0] * 3, "{traversal:?}: {calls:?}");
    }
}

#[test]
fn micromaps_of_two_states_never_call_a_shader() {
    let triangles = soup(300, 7);
    let micromap = Some(MicromapFormat { level: 3, states: MicromapStates::Two });
    let tests = AlphaTests { micromap, ..tests(AlphaMode::Micromap, triangles.len()) };
    let structure = build(&triangles, Traversal::BvhStack, Some(tests));
    for ray in rays(&triangles, 200, 8) {
        let mut asked = Asked::default();
        structure.trace(&ray, Query::Closest, &mut asked);
        assert_eq!(asked.shaders(), 0);
    }
}

#[test]
fn without_alpha_tested_triangles_nothing_changes() {
    let triangles = quads(4);
    for traversal in traversals() {
        let plain = build(&triangles, traversal, None);
        for mode in AlphaMode::ALL {
            let none = AlphaTests { tested: TestedTriangles::of([]), ..tests(mode, 0) };
            let tested = build(&triangles, traversal, Some(none));
            for ray in rays(&triangles, 100, 9) {
                let (mut before, mut after) = (Asked::default(), Asked::default());
                let expected = plain.trace(&ray, Query::Closest, &mut before);
                assert_eq!(tested.trace(&ray, Query::Closest, &mut after), expected);
                after.0.retain(|&(op, _)| op == Op::Primitive);
                assert_eq!(before.0, after.0, "{traversal:?} {mode:?}");
            }
        }
    }
}

#[test]
fn instances_of_a_mesh_may_be_tested_apart() {
    let mesh = vec![quads(1)[0]];
    let instances = [Instance::identity(0), Instance::identity(0)];
    let tests =
        AlphaTests { mode: AlphaMode::Cull, tested: TestedTriangles::of([true, false]), micromap: None };
    let structure = AccelerationStructure::build_two_level(
        std::slice::from_ref(&mesh),
        &instances,
        None,
        &BuildOptions::default(),
    )
    .and_then(|structure| structure.with_alpha(tests))
    .unwrap();
    assert_eq!(structure.traversal().accel(), Accel::TwoLevel);
    let [a, b, c] = mesh[0].v;
    let inside = (a + b + c) / 3.0;
    let normal = (b - a).cross(c - a);
    let hit = structure.trace(&Ray::new(inside + normal, -normal), Query::Closest, &mut Silent);
    assert_eq!(hit.primitive, 1);
}
