//! Tracing speed beside a peer, in one run: million rays per CPU-second of one thread, primary and shadow rays of one frame in
//! scanline order, this crate's traversals (silent, one also recording) and obvhs's BVH2 in turn, medians of the rounds.
//!
//! `cargo bench -p tracer -- [SCENE] [ROUNDS]`; the built-in atrium without a scene.

use obvhs::{BvhBuildParams, ray::RayHit, triangle::Triangle as PeerTriangle};
use std::time::{Duration, Instant};
use tracer::{
    AccelerationStructure, BuildOptions, Hit, Query, Ray, RayOffset, RaySet, Recorder, Silent, Traversal,
    View,
};

const EDGE: u32 = 1024;

/// Traces all rays and counts the hits.
type Trace<'a> = dyn FnMut(&[Ray], Query) -> u64 + 'a;

struct Contender<'a> {
    name: String,
    trace: Box<Trace<'a>>,
    seconds: Vec<f64>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let scene = scenes::load(arguments.first().map_or("atrium", String::as_str)).expect("the scene loads");
    let rounds: usize = arguments.get(1).map_or(5, |rounds| rounds.parse().expect("a number of rounds"));
    let triangles = scene.triangles();
    let scenes::Light::Point { position: light } = scene.lights[0];

    let build = |traversal| {
        let start = Instant::now();
        let built = AccelerationStructure::build(&triangles, traversal, &BuildOptions::default())
            .expect("the structure builds");
        println!("{:>14} built in {:.3} s", traversal.name(), start.elapsed().as_secs_f64());
        built
    };
    let structures: Vec<_> = Traversal::ALL.into_iter().map(build).collect();
    let stack = &structures[0];

    let view = View::new(&scene.camera, EDGE, EDGE);
    let primary: Vec<Ray> = (0..EDGE * EDGE).map(|i| view.primary_ray(i % EDGE, i / EDGE)).collect();
    let offset = RayOffset::new(&triangles);
    let shadow: Vec<Ray> = primary
        .iter()
        .filter_map(|ray| {
            let hit = stack.trace(ray, Query::Closest, &mut Silent);
            hit.is_hit().then(|| {
                offset.shadow_ray(&triangles[hit.primitive as usize], hit.u, hit.v, ray.direction, light)
            })
        })
        .collect();

    let peer_triangles: Vec<PeerTriangle> = triangles
        .iter()
        .map(|t| PeerTriangle { v0: peer(t.v[0]), v1: peer(t.v[1]), v2: peer(t.v[2]) })
        .collect();
    let mut spent = Duration::default();
    let peer_bvh = obvhs::bvh2::builder::build_bvh2_from_tris(
        &peer_triangles,
        BvhBuildParams::medium_build(),
        &mut spent,
    );
    let peer_ordered: Vec<PeerTriangle> =
        peer_bvh.primitive_indices.iter().map(|&id| peer_triangles[id as usize]).collect();

    let mut contenders: Vec<Contender> = structures
        .iter()
        .map(|structure| Contender {
            name: format!("{} {}", structure.traversal().accel().name(), structure.traversal().name()),
            trace: Box::new(move |rays, query| count(rays, |ray| structure.trace(ray, query, &mut Silent))),
            seconds: Vec::new(),
        })
        .collect();
    let mut set = RaySet::default();
    contenders.push(Contender {
        name: "bvh stack, recording".to_owned(),
        trace: Box::new(move |rays, query| {
            let mut hits = 0;
            for tile in rays.chunks(1024) {
                set.clear();
                hits += count(tile, |ray| {
                    let hit = stack.trace(ray, query, &mut Recorder::new(&mut set));
                    set.end_ray(hit.primitive).expect("a tile within the limit");
                    hit
                });
            }
            hits
        }),
        seconds: Vec::new(),
    });
    contenders.push(Contender {
        name: "obvhs BVH2 medium".to_owned(),
        trace: Box::new(|rays, query| {
            rays.iter()
                .map(|ray| {
                    let ray =
                        obvhs::ray::Ray::new(peer(ray.origin), peer(ray.direction), ray.t_min, ray.t_max);
                    let test = |ray: &obvhs::ray::Ray, id: usize| peer_ordered[id].intersect(ray);
                    let mut hit = RayHit::none();
                    u64::from(match query {
                        Query::Closest => peer_bvh.ray_traverse(ray, &mut hit, test),
                        Query::Any => !peer_bvh.ray_traverse_miss(ray, test),
                    })
                })
                .sum()
        }),
        seconds: Vec::new(),
    });

    for (kind, rays, query) in [("primary", &primary, Query::Closest), ("shadow", &shadow, Query::Any)] {
        for contender in &mut contenders {
            contender.seconds.clear();
            let hits = (contender.trace)(rays, query);
            println!("{kind:>8} {:<24} {hits} hits of {} rays", contender.name, rays.len());
        }
        for _ in 0..rounds {
            for contender in &mut contenders {
                let start = cpu_seconds();
                std::hint::black_box((contender.trace)(rays, query));
                contender.seconds.push(cpu_seconds() - start);
            }
        }
        let median = |contender: &Contender| {
            let mut seconds = contender.seconds.clone();
            seconds.sort_by(f64::total_cmp);
            seconds[seconds.len() / 2]
        };
        let peer_seconds = median(contenders.last().expect("the peer"));
        let silent_seconds = median(&contenders[0]);
        for contender in &contenders {
            let seconds = median(contender);
            println!(
                "{kind:>8} {:<24} {:6.2} Mrays/s   {:5.2} of obvhs   {:5.2} x the time of bvh stack",
                contender.name,
                rays.len() as f64 / seconds / 1e6,
                peer_seconds / seconds,
                seconds / silent_seconds
            );
        }
    }
}

/// Seconds that this thread has run, so that a busy machine disturbs less; wall seconds where the system does not say.
fn cpu_seconds() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    let nanoseconds = std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

fn count(rays: &[Ray], mut trace: impl FnMut(&Ray) -> Hit) -> u64 {
    rays.iter().map(|ray| u64::from(trace(ray).is_hit())).sum()
}

fn peer(v: glam::Vec3) -> glam::Vec3A {
    v.into()
}
