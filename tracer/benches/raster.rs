//! What rasterising costs beside tracing the same frame, and what it counts: 1024x1024 pixels, one thread, medians of the rounds.
//!
//! `cargo bench -p tracer --bench raster -- [SCENE] [ROUNDS]`; the built-in atrium without a scene.

use std::time::Instant;
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Raster, RasterTile, Rays, SceneIdentity, Tile,
    TileSource, Traversal, View,
};

const EDGE: u32 = 1024;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let scene = scenes::load(arguments.first().map_or("atrium", String::as_str)).expect("the scene loads");
    let rounds: usize = arguments.get(1).map_or(5, |rounds| rounds.parse().expect("a number of rounds"));
    let triangles = scene.triangles();
    let scenes::Light::Point { position: light } = scene.lights[0];
    let view = View::new(&scene.camera, EDGE, EDGE);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");

    let bin_s = median(rounds, || one_thread.install(|| drop(Raster::new(&triangles, &view, EDGE, EDGE))));
    let raster = Raster::new(&triangles, &view, EDGE, EDGE);
    let mut tile = RasterTile::default();
    let (mut pairs, mut covered, mut passed, mut quads) = (0, 0, 0, 0);
    let draw_s = median(rounds, || {
        (pairs, covered, passed, quads) = (0, 0, 0, 0);
        for index in 0..(EDGE / tracer::TILE_EDGE).pow(2) {
            raster.tile(index, &mut tile);
            pairs += tile.draws.len();
            for draw in &tile.draws {
                covered += u64::from(draw.covered);
                passed += u64::from(draw.passed);
                quads += u64::from(draw.quads);
            }
        }
    });
    println!(
        "{} of {} triangles: {pairs} draws in tiles, {covered} covered, {passed} passed, {quads} quads, overdraw {:.3}",
        scene.name,
        triangles.len(),
        passed as f64 / f64::from(EDGE * EDGE)
    );

    let options = BuildOptions::default();
    let structure = AccelerationStructure::build(&triangles, Traversal::BvhStack, &options)
        .expect("the structure builds");
    let identity = SceneIdentity { name: scene.name.clone(), hash: 0 };
    let rays = Rays::View { view, width: EDGE, height: EDGE };
    let tracer =
        FrameTracer::new(&structure, &options, &triangles, identity, rays, vec![light]).with_raster();
    let mut traced = Tile::default();
    let frame_s = median(rounds, || {
        for index in 0..tracer.header().frame.tiles() {
            tracer.tile(index, &mut traced).expect("a tile within the limits");
        }
    });
    println!(
        "binned in {:.1} ms, tiles drawn in {:.1} ms; tracing and drawing all tiles {:.1} ms: rasterising is {:.1} % of it",
        bin_s * 1e3,
        draw_s * 1e3,
        frame_s * 1e3,
        100.0 * (bin_s + draw_s) / (bin_s + frame_s)
    );
}

fn median(rounds: usize, mut work: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..rounds.max(1))
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
