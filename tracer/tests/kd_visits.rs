//! What do the kd traversals fetch, and how do their visits relate?

mod kd_support;

use kd_support::*;
use proptest::prelude::*;
use scenes::Vec3;
use tracer::kd::{FlatCells, KdNodeKind, KdOptions};
use tracer::{NodeFetch, Op, Query, Ray, WorkCounter};

const STACK: usize = 0;
const RESTART: usize = 1;
const PUSH_DOWN: usize = 2;
const DEEP_SHORT_STACK: usize = 5;
const BACKTRACK: usize = 6;

fn log(traversals: &Traversals, name: usize, ray: &Ray, query: Query) -> Log {
    let mut log = Log::default();
    traversals.trace(name, ray, query, &mut log);
    log
}

/// The rules that hold for each ray.
fn check(traversals: &Traversals, ray: &Ray, query: Query) {
    let logs: Vec<_> = (0..NAMES.len()).map(|name| log(traversals, name, ray, query)).collect();
    let nodes = traversals.tree.nodes();
    let is_leaf = |&id: &u32| matches!(nodes[id as usize].kind(), KdNodeKind::Leaf { .. });
    let leaves = |log: &Log| log.of(Op::Node).filter(is_leaf).collect::<Vec<_>>();
    for (log, title) in logs.iter().zip(NAMES) {
        assert_eq!(
            leaves(log),
            leaves(&logs[STACK]),
            "{title} visits the leaves of the stack traversal, in order"
        );
        assert!(log.of(Op::Primitive).eq(logs[STACK].of(Op::Primitive)), "{title} tests the same triangles");
        assert_eq!(log.stalls, 0);
        assert_eq!(log.leaf_visits as usize, leaves(log).len());
        assert_eq!(log.plane_tests as usize, log.of(Op::Node).count() - leaves(log).len());
        if let Some(&(op, id)) = log.steps.first() {
            assert_eq!((op, id), (Op::Node, 0), "{title} begins at the root");
        }
    }
    assert!(logs[PUSH_DOWN].fetches() <= logs[RESTART].fetches());
    for name in [PUSH_DOWN + 1, PUSH_DOWN + 2] {
        // Not always fewer than without a short stack: nodes taken from it do not push the restart node down.
        assert!(logs[name].fetches() <= logs[RESTART].fetches());
    }
    assert_eq!(logs[DEEP_SHORT_STACK], logs[STACK], "a deep short stack is a stack");
    for name in [RESTART, PUSH_DOWN] {
        for pair in logs[name].steps.windows(2).filter(|pair| pair[0].0 == Op::Restart) {
            assert_eq!(pair[1], (Op::Node, pair[0].1), "the node of a restart is fetched next");
            assert!(name != RESTART || pair[0].1 == 0);
        }
        assert_eq!(logs[name].of(Op::Restart).count(), logs[STACK].of(Op::Pop).count());
    }
    for pair in logs[BACKTRACK].steps.windows(2) {
        if let [(Op::Up, up), (Op::Node, down)] = *pair {
            let KdNodeKind::Inner { left, .. } = nodes[up as usize].kind() else { panic!("{up} is a leaf") };
            assert!(
                down == left || down == left + 1,
                "the descent goes on below the ancestor, without fetching it again"
            );
        }
    }
    let mut down: Vec<_> = logs[BACKTRACK].of(Op::Node).collect();
    let mut of_stack: Vec<_> = logs[STACK].of(Op::Node).collect();
    down.sort_unstable();
    of_stack.sort_unstable();
    assert_eq!(down, of_stack, "backtracking descends through each node of the stack traversal once");
}

#[test]
fn a_leaf_at_the_root_is_fetched_once() {
    let traversals = Traversals::new(&soup(1, 1), &KdOptions::MOBILE);
    let target = soup(1, 1)[0].v.iter().sum::<Vec3>() / 3.0;
    let ray = Ray::new(Vec3::splat(5.0), target - Vec3::splat(5.0));
    for (name, title) in NAMES.iter().enumerate() {
        let log = log(&traversals, name, &ray, Query::Closest);
        assert_eq!(log.steps, [(Op::Node, 0), (Op::Primitive, 0)], "{title}");
    }
}

#[test]
fn a_ray_beside_the_scene_fetches_nothing() {
    let traversals = Traversals::new(&soup(100, 1), &KdOptions::MOBILE);
    for name in 0..NAMES.len() {
        let mut work = WorkCounter::new(NodeFetch::Single);
        traversals.trace(name, &Ray::new(Vec3::splat(9.0), Vec3::X), Query::Closest, &mut work);
        assert_eq!((work.work().box_tests, work.work().node_fetches), (1, 0));
    }
}

#[test]
fn fetches_on_sponza() {
    let Some(triangles) = real_scene("sponza_crytek_262k") else { return };
    let options = KdOptions { flat_cells: FlatCells::Forbidden, ..KdOptions::MOBILE };
    let traversals = Traversals::new(&triangles, &options);
    let mut random = Random(1);
    let eye = Vec3::new(-1000.0, 350.0, -30.0);
    let rays: Vec<_> = (0..2000).map(|_| Ray::new(eye, random.point())).collect();
    let mut fetches = [0_u64; NAMES.len()];
    for ray in &rays {
        check(&traversals, ray, Query::Closest);
        for (name, fetches) in fetches.iter_mut().enumerate() {
            let mut counter = WorkCounter::new(NodeFetch::Single);
            traversals.trace(name, ray, Query::Closest, &mut counter);
            *fetches += counter.work().node_fetches;
        }
    }
    for (name, fetches_of) in NAMES.iter().zip(fetches) {
        let ratio = fetches_of as f64 / fetches[STACK] as f64;
        eprintln!(
            "{name:14} {:7.2} fetches per ray, {ratio:.3} of the stack's",
            fetches_of as f64 / rays.len() as f64
        );
    }
    assert!(fetches[PUSH_DOWN] < fetches[RESTART]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn all_traversals_visit_the_same_leaves_in_the_same_order(seed in any::<u64>(), count in 1_usize..300, regular in any::<bool>()) {
        let triangles = if regular { quads(1 + (count % 7) as i32) } else { soup(count, seed) };
        let (low, high) = bounds(&triangles);
        let mut random = Random(seed);
        for options in all_options() {
            let traversals = Traversals::new(&triangles, &options);
            for _ in 0..8 {
                let rays = [
                    random_ray(&mut random, low, high),
                    axis_ray(&mut random, &triangles),
                    corner_ray(&mut random, &triangles, low, high),
                ];
                for ray in rays {
                    check(&traversals, &ray, Query::Closest);
                    check(&traversals, &ray, Query::Any);
                }
            }
        }
    }
}
