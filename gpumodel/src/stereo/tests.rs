//! Do the frames of two eyes move the bytes that closed forms say, and trace what they should?

use super::{PixelOrder, Window, replay_left, replay_right};
use crate::config::{Gpu, Stereo};
use crate::counters::{IssueCounters, Pass, PassCounters};
use crate::estimate::estimate;
use crate::mock;
use crate::replay::{Maps, ReplayConfig, Replayed, replay};
use scenes::{Camera, Triangle, Vec3};
use tracer::reflections::GBuffer;
use tracer::stereo::{Eyes, Reprojection};
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Rays, ReflectionRays, SceneIdentity, SecondaryRays,
    Traversal, View,
};

/// Whose fields of the G-buffer are many times the last cache.
const SIZE: [u32; 2] = [512, 192];
const PIXELS: u64 = SIZE[0] as u64 * SIZE[1] as u64;

fn config(technique: &str, replacements: &[(&str, &str)]) -> ReplayConfig {
    let mut text = crate::BuiltinGpu::named("sgrt").expect("it is built in").toml.to_owned();
    for (from, to) in replacements {
        assert!(text.contains(from), "the description has '{from}'");
        text = text.replace(from, to);
    }
    let gpu = Gpu::parse(&text, "mock.toml").expect("the description stays valid");
    ReplayConfig { technique: mock::technique(technique), ..mock::config(gpu) }
}

/// A wall, a triangle that fills both views.
struct World {
    triangles: Vec<Triangle>,
    structure: AccelerationStructure,
    views: [View; 2],
    known: Reprojection,
    mirrors: bool,
}

impl World {
    /// `disparity` pixels are between what the eyes see of each point, to the left in the right image.
    fn new(disparity: f64, mirrors: bool) -> Self {
        let [width, height] = SIZE;
        let corner = |x: f32, y: f32| Vec3::new(x, y, -1.0);
        let triangles = vec![Triangle { v: [corner(-40.0, -18.0), corner(40.0, -18.0), corner(0.0, 40.0)] }];
        let structure =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &BuildOptions::default())
                .expect("it can be built");
        let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vertical_fov_degrees: 90.0 };
        // Parallel eyes: pixels of focal length times the distance of the eyes over the depth.
        let interaxial = disparity / (f64::from(height) / 2.0);
        let eyes = Eyes { interaxial, convergence: f64::INFINITY };
        let views = eyes.views(&View::new(&camera, width, height));
        let left = GBuffer::trace(&structure, &triangles, views[0], width, height);
        let known = Reprojection::new(&left, &views[1]);
        Self { triangles, structure, views, known, mirrors }
    }

    fn tracer(&self, rays: Rays) -> FrameTracer<'_> {
        let identity = SceneIdentity { name: "wall".to_owned(), hash: 0 };
        let reflections = self.mirrors.then(|| vec![ReflectionRays::Mirror; self.triangles.len()]);
        let secondary = SecondaryRays { samples: 1, reflections, ..SecondaryRays::default() };
        FrameTracer::new(
            &self.structure,
            &BuildOptions::default(),
            &self.triangles,
            identity,
            rays,
            Vec::new(),
        )
        .with_secondary(secondary)
    }

    fn image(&self, eye: usize) -> FrameTracer<'_> {
        self.tracer(Rays::View { view: self.views[eye], width: SIZE[0], height: SIZE[1] })
    }

    fn order(&self, config: &ReplayConfig) -> PixelOrder {
        PixelOrder::new(&self.known, stereo(config).launch)
    }

    fn pixels(&self, order: &PixelOrder) -> Rays {
        let PixelOrder { pixels, known } = order.clone();
        Rays::Pixels { view: self.views[1], width: SIZE[0], pixels, known }
    }

    fn eyes(&self, config: &ReplayConfig) -> [Replayed; 2] {
        let order = self.order(config);
        [
            replay_left(&self.image(0), &self.known, config).expect("it fits"),
            replay_right(&self.tracer(self.pixels(&order)), &order, &self.known, config).expect("it fits"),
        ]
    }
}

fn stereo(config: &ReplayConfig) -> &Stereo {
    config.technique.stereo.as_ref().expect("it is of two eyes")
}

/// Bytes read from memory and written to it, the last write-back among them.
fn memory(replayed: &Replayed) -> [u64; 2] {
    let PassCounters { issue, traffic } = replayed.counters.total();
    let IssueCounters { output_bytes, dma_read_bytes, dma_write_bytes, .. } = issue;
    let traffic = traffic.total();
    [traffic.dram_read_bytes + dma_read_bytes, traffic.dram_write_bytes + output_bytes + dma_write_bytes]
}

/// `found` is `expected` bytes, but for a few lines at edges of planes and lists and the small tree.
fn close(found: u64, expected: u64) -> bool {
    found.abs_diff(expected) <= expected / 100 + 16384
}

/// Bytes of columns that all tiles see whose pixels lie `disparity` pixels further to the left in the right image, by hand.
fn spans(disparity: i64, [tile_width, _]: [u32; 2]) -> u64 {
    let width = i64::from(SIZE[0]);
    let of_tile = |tile: u32| {
        let start = i64::from(tile * tile_width);
        let end = width.min(start + i64::from(tile_width));
        (end + disparity + 1).clamp(0, width) - (start + disparity - 1).clamp(0, width)
    };
    let columns: i64 = (0..SIZE[0].div_ceil(tile_width)).map(of_tile).sum();
    columns as u64 * u64::from(SIZE[1]) * 8
}

#[test]
fn in_tiles_memory_moves_colours_and_what_the_row_test_needs_and_nothing_else() {
    // Not at the edges of pixels, so that rounding moves none.
    let world = World::new(20.25, false);
    let config = config("stereo", &[]);
    let [left, right] = world.eyes(&config).map(|eye| memory(&eye));
    let colours = 4 * PIXELS;
    assert!(close(left[0], 0) && close(left[1], colours + 8 * PIXELS), "{left:?}");
    assert!(close(right[0], spans(20, stereo(&config).tile)) && close(right[1], colours), "{right:?}");
}

#[test]
fn whole_rows_are_read_once_but_for_what_leaves_the_image() {
    let world = World::new(20.25, false);
    let mut config = config("stereo", &[]);
    config.technique.stereo = Some(Stereo { tile: [SIZE[0], 1], ..*stereo(&config) });
    let window = Window::of(&world.known, stereo(&config));
    // The pixel beside the last that lands in the image is among them.
    let columns = SIZE[0] - 20 + 1;
    let bytes = 8 * u64::from(columns * SIZE[1]);
    assert_eq!(bytes, spans(20, stereo(&config).tile));
    assert_eq!((window.columns, window.dma_bytes, window.dma_reads), (columns, bytes, u64::from(SIZE[1])));
    let [_, right] = world.eyes(&config);
    assert_eq!(right.counters.total().issue.dma_read_bytes, bytes);
}

#[test]
fn in_memory_each_field_is_written_once_and_read_where_it_is_needed() {
    let world = World::new(20.25, false);
    let config = config("stereo-memory", &[]);
    let [left, right] = world.eyes(&config).map(|eye| memory(&eye));
    let fields = u64::from(stereo(&config).fields.bytes());
    let position = u64::from(stereo(&config).fields.position);
    let answered = world.known.counts()[0];
    let (colours, spans, lists) = (4 * PIXELS, 8 * PIXELS, 4 * PIXELS);
    assert!(close(left[0], position * PIXELS), "{left:?}");
    assert!(close(left[1], colours + fields * PIXELS + spans), "{left:?}");
    // Tiles that lie side by side find in the caches what both of them see.
    assert!(close(right[0], spans + lists + fields * answered), "{right:?}");
    assert!(close(right[1], colours + lists), "{right:?}");
}

#[test]
fn dma_is_waited_for_once_where_kernels_take_longer_and_for_each_tile_where_memory_does() {
    let world = World::new(20.25, false);
    let waits = |peak: &str| {
        let config = config("stereo", &[("peak_gbs = { value = 29.8", peak)]);
        let [_, right] = world.eyes(&config);
        let tracer = world.tracer(world.pixels(&world.order(&config)));
        let header = tracer::TileSource::header(&tracer);
        let found = estimate(&right, header, tracer::TileSource::topology(&tracer), &config).expect("it can");
        let rows: [u64; 2] = found.traffic.iter().fold([0; 2], |[read, written], row| {
            [read + row.dram_read_bytes, written + row.dram_write_bytes]
        });
        assert_eq!(rows, memory(&right), "by pass and buffer, and in all");
        let part = found.stack.iter().find(|part| part.name == "DMA").expect("it reads").seconds;
        let issue = right.counters.pass(Pass::ErrorDetection).issue;
        let gpu = &config.gpu;
        let bandwidth = gpu.dram.peak_bytes_per_second * gpu.dram.efficiency;
        let setup = gpu.internal_memory.expect("it has some").dma_setup_seconds;
        let read = setup + issue.dma_read_bytes as f64 / issue.dma_reads as f64 / bandwidth;
        (part, read, issue.dma_reads as f64)
    };
    let (part, read, _) = waits("peak_gbs = { value = 29.8");
    assert!((part / read - 1.0).abs() < 1e-9, "{part} and {read}");
    let (part, read, reads) = waits("peak_gbs = { value = 0.5");
    assert!(part > 0.5 * reads * read && part < reads * read, "{part} of {}", reads * read);
}

#[test]
fn eyes_in_one_place_trace_no_primary_ray_of_the_right_one() {
    for mirrors in [false, true] {
        let world = World::new(0.0, mirrors);
        for technique in ["stereo", "stereo-memory"] {
            let [left, right] = world.eyes(&config(technique, &[]));
            let rays = |eye: &Replayed, pass: Pass| eye.counters.pass(pass).issue.rays;
            assert_eq!((rays(&left, Pass::Primary), rays(&right, Pass::Primary)), (PIXELS, 0));
            let reflections = if mirrors { PIXELS } else { 0 };
            assert_eq!(rays(&right, Pass::Reflection), reflections);
        }
    }
}

#[test]
fn with_reuse_the_right_eye_traces_what_it_misses_and_the_left_one_all() {
    let world = World::new(20.25, true);
    let config = config("stereo", &[]);
    let [left, right] = world.eyes(&config);
    let whole = |eye: usize| replay(&world.image(eye), &config, Maps::Dropped, &|_, _| {}).expect("it fits");
    let tracing = |eye: &Replayed| {
        let issue = eye.counters.pass(Pass::Primary).issue;
        (issue.rays, issue.node_fetches, issue.primitive_tests)
    };
    assert_eq!(tracing(&left), tracing(&whole(0)));
    let [_, missing, covered] = world.known.counts();
    assert_eq!(missing + covered, 20 * u64::from(SIZE[1]));
    assert_eq!(tracing(&right).0, 20 * u64::from(SIZE[1]));
    assert_eq!(right.counters.pass(Pass::Reflection).issue, {
        let all = whole(1).counters.pass(Pass::Reflection).issue;
        // The same rays, in another order.
        let of = right.counters.pass(Pass::Reflection).issue;
        assert_eq!((of.rays, of.lane_steps, of.node_fetches), (all.rays, all.lane_steps, all.node_fetches));
        of
    });
}

#[test]
fn counts_do_not_depend_on_threads() {
    let world = World::new(33.3, true);
    let run = |threads: usize, technique: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| world.eyes(&config(technique, &[])).map(|eye| eye.counters))
    };
    for technique in ["stereo", "stereo-memory"] {
        assert_eq!(run(1, technique), run(3, technique));
    }
}

#[test]
fn what_does_not_fit_or_is_not_there_is_refused_with_the_remedy() {
    let world = World::new(20.25, false);
    let refusal = |config: &ReplayConfig| {
        replay_left(&world.image(0), &world.known, config).expect_err("it cannot run").to_string()
    };
    let tiles = config("stereo", &[]);
    let needed = Window::of(&world.known, stereo(&tiles)).bytes;
    let with_memory = |bytes: u64| {
        let value = format!("tile_memory_bytes = {{ value = {bytes}");
        config("stereo", &[("tile_memory_bytes = { value = 131072", value.as_str())])
    };
    assert!(replay_left(&world.image(0), &world.known, &with_memory(needed)).is_ok());
    let message = refusal(&with_memory(needed - 1));
    assert!(
        message.contains(&format!("needs {needed} bytes")) && message.contains("smaller tiles"),
        "{message}"
    );

    let adreno = Gpu::builtin("adreno-740").expect("built in").expect("sound");
    let elsewhere = ReplayConfig { technique: mock::technique("stereo"), ..mock::config(adreno) };
    assert!(refusal(&elsewhere).contains("use stereo-memory"));
    let one_eye = ReplayConfig { technique: mock::technique("compute"), ..tiles.clone() };
    assert!(refusal(&one_eye).contains("has no [stereo]"));
    let timed = ReplayConfig { fidelity: crate::Fidelity::Timed, ..tiles };
    assert!(refusal(&timed).contains("use --fidelity replay"));
}
