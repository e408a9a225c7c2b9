//! Prints the quality of a scene's trees: nodes, SAH, and the visits of primary and shadow rays at 1024x1024.
//!
//! `cargo run --release -p tracer --example tree_quality -- SCENE [CT CI]`; costs 1 and 1 unless given.

use tracer::{AccelerationStructure, BuildOptions, Query, Traversal, View, Work, WorkCounter, shadow_ray};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scene = scenes::load(arguments.first().map_or("atrium", String::as_str)).expect("the scene loads");
    let cost = |index: usize| arguments.get(index).map_or(1.0, |text| text.parse().expect("a number"));
    let options =
        BuildOptions { traversal_cost: cost(1), intersection_cost: cost(2), ..BuildOptions::default() };
    let triangles = scene.triangles();
    let scenes::Light::Point { position: light } = scene.lights[0];
    let view = View::new(&scene.camera, 1024, 1024);
    for traversal in Traversal::ALL {
        let structure =
            AccelerationStructure::build(&triangles, traversal, &options).expect("the structure builds");
        let (mut primary, mut shadow, mut shadow_rays) = (Work::default(), Work::default(), 0_u64);
        for pixel in 0..1024 * 1024 {
            let ray = view.primary_ray(pixel % 1024, pixel / 1024);
            let mut counter = WorkCounter::new(traversal.node_fetch());
            let hit = structure.trace(&ray, Query::Closest, &mut counter);
            primary += counter.work();
            if hit.is_hit() {
                let triangle = &triangles[hit.primitive as usize];
                let mut counter = WorkCounter::new(traversal.node_fetch());
                let ray = shadow_ray(triangle, hit.u, hit.v, ray.direction, light);
                structure.trace(&ray, Query::Any, &mut counter);
                shadow += counter.work();
                shadow_rays += 1;
            }
        }
        println!(
            "{} {}: {} nodes, depth {}, SAH {:?}",
            traversal.accel().name(),
            traversal.name(),
            structure.topology().nodes.len(),
            structure.depth(),
            structure.sah_cost(options.traversal_cost, options.intersection_cost)
        );
        for (kind, work, rays) in [("primary", primary, 1024 * 1024), ("shadow", shadow, shadow_rays)] {
            let per_ray = |count: u64| count as f64 / rays as f64;
            println!(
                "  {kind:>7}: node steps {:.2}, fetches {:.2}, box tests {:.2}, plane tests {:.2}, leaves {:.2}, triangles {:.2}, \
                 restarts {:.2}, up {:.2}, stalls {}",
                per_ray(work.node_steps),
                per_ray(work.node_fetches),
                per_ray(work.box_tests),
                per_ray(work.plane_tests),
                per_ray(work.leaf_visits),
                per_ray(work.primitive_tests),
                per_ray(work.restarts),
                per_ray(work.up_steps),
                work.stalls
            );
        }
    }
}
