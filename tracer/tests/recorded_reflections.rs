//! Does a trace give back the reflection rays of its frame, in any order?

mod reflection_support;

use glam::Vec3;
use reflection_support::{World, settings};
use std::path::Path;
use tracer::reflections::{
    NO_RAY, RecordedReflections, ReflectionList, ReflectionRay, ReflectionTracer, Reflections,
};
use tracer::{
    BuildOptions, EncodedTile, Error, Frame, FrameTracer, MOST_SHADERS, Rays, ReflectionRays,
    ReflectionRecord, SceneIdentity, SecondaryRays, Tile, TileSource, TraceFile, TraceHeader, TraceWriter,
};

/// Not a multiple of a tile.
const EDGE: u32 = 70;

fn identity() -> SceneIdentity {
    SceneIdentity { name: "test".to_owned(), hash: 1 }
}

fn lights() -> Vec<Vec3> {
    vec![Vec3::new(278.0, 500.0, 279.5), Vec3::new(100.0, 300.0, 100.0)]
}

/// A third of the triangles are mirrors, a third glossy and a third rough.
fn surfaces(world: &World) -> Vec<ReflectionRays> {
    let kinds = [ReflectionRays::Mirror, ReflectionRays::Glossy(0.3), ReflectionRays::None];
    kinds.into_iter().cycle().take(world.triangles.len()).collect()
}

fn record() -> ReflectionRecord {
    ReflectionRecord { bounds: [[-1.0; 3], [600.0; 3]], shaders: "Shaders were dealt out.".to_owned() }
}

fn frame_tracer(world: &World) -> FrameTracer<'_> {
    let secondary = SecondaryRays {
        seed: 5,
        samples: 2,
        reflections: Some(surfaces(world)),
        ambient_occlusion: Some(50.0),
        lights: lights(),
        ..SecondaryRays::default()
    };
    let rays = Rays::View { view: world.view(), width: world.edge, height: world.edge };
    let options = BuildOptions::default();
    FrameTracer::new(&world.structure, &options, &world.triangles, identity(), rays, lights())
        .with_secondary(secondary)
        .with_reflection_record(record())
}

fn written(tracer: &FrameTracer<'_>, shaders: &[u32], path: &Path) -> Result<(), Error> {
    let mut writer = TraceWriter::create_with_shaders(path, tracer.header(), tracer.topology(), shaders)?;
    let mut tile = Tile::default();
    for index in 0..tracer.header().frame.tiles() {
        tracer.tile(index, &mut tile)?;
        writer.write_tile(&EncodedTile::new(&tile, tracer.header())?)?;
    }
    writer.finish(tracer.stalls()).map(drop)
}

fn tiles(source: &(impl TileSource + ?Sized)) -> Vec<Tile> {
    let tile = |index| {
        let mut tile = Tile::default();
        source.tile(index, &mut tile).expect("a tile");
        tile
    };
    (0..source.header().frame.tiles()).map(tile).collect()
}

#[test]
fn a_trace_gives_back_the_rays_of_its_reflections_and_their_lists() {
    let world = World::builtin("cornell", EDGE);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("reflections.rbt");
    let shaders: Vec<u32> = (0..world.triangles.len() as u32).map(|triangle| triangle * 7 % 300).collect();
    let tracer = frame_tracer(&world);
    written(&tracer, &shaders, &path).expect("it is written");
    let trace = TraceFile::open(&path).expect("it is read");
    assert_eq!((trace.header().reflections.as_ref(), trace.shaders()), (Some(&record()), &shaders[..]));
    assert!(tiles(&tracer) == tiles(&trace));

    let (gbuffer, of_triangles) = (world.gbuffer(), surfaces(&world));
    let live = Reflections::new(&gbuffer, settings(&of_triangles, None));
    let recorded = RecordedReflections::read(&trace).expect("it has reflections");
    let found = recorded.reflections();
    assert_eq!((found.size(), found.outcomes()), ([EDGE; 2], live.outcomes()));
    let lines = |rays: &[ReflectionRay]| {
        rays.iter().map(|of| (of.pixel, of.ray.origin, of.ray.direction)).collect::<Vec<_>>()
    };
    assert!(lines(found.rays()) == lines(live.rays()) && found.rays().len() > 2000);
    assert!(found.depth().is_none() && live.depth().is_some());

    let count = live.rays().len() as u32;
    let with_gap = [(1..count).rev().collect(), vec![NO_RAY, 0, NO_RAY]].concat();
    let mixed = (0..count).map(|place| (u64::from(place) * 7919 % u64::from(count)) as u32).collect();
    for order in [mixed, with_gap] {
        for with_shadows in [true, false] {
            let lights = if with_shadows { lights() } else { Vec::new() };
            let World { structure, triangles, .. } = &world;
            let options = BuildOptions::default();
            let live = live.rays();
            let live = ReflectionTracer::new(
                structure,
                &options,
                triangles,
                identity(),
                live,
                order.clone(),
                lights,
            )
            .expect("each ray once");
            let list = recorded.list(order.clone(), with_shadows).expect("each ray once");
            assert_eq!(list.header(), live.header());
            assert!(tiles(&list) == tiles(&live), "with shadows: {with_shadows}");
            assert!((0..order.len() as u32).all(|place| list.pixel(place) == live.pixel(place)));
        }
    }
    let refused = recorded.list(vec![0; count as usize], true).err().expect("refused").to_string();
    assert!(refused.contains("ray 0 at place 1"), "{refused}");
}

#[test]
fn a_trace_without_reflection_rays_says_how_to_record_them() {
    let world = World::builtin("cornell", 8);
    let rays = Rays::View { view: world.view(), width: 8, height: 8 };
    let options = BuildOptions::default();
    let tracer = FrameTracer::new(&world.structure, &options, &world.triangles, identity(), rays, lights())
        .with_reflection_record(record());
    assert_eq!(tracer.header().reflections, None, "it casts none");
    let refused = RecordedReflections::read(&tracer).err().expect("refused").to_string();
    assert!(refused.contains("--force mirror"), "{refused}");
}

#[test]
fn what_contradicts_itself_is_not_written() {
    let world = World::builtin("cornell", 8);
    let tracer = frame_tracer(&world);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wrong.rbt");
    let header = || tracer.header().clone();
    let triangles = world.triangles.len();
    let refused = |header: &TraceHeader, shaders: &[u32]| {
        let writer = TraceWriter::create_with_shaders(&path, header, tracer.topology(), shaders);
        writer.err().expect("refused").to_string()
    };
    let shaders = vec![MOST_SHADERS - 1; triangles];
    TraceWriter::create_with_shaders(&path, &header(), tracer.topology(), &shaders).expect("as many as fit");
    for (shaders, expected) in [
        (vec![0; triangles - 1], "shaders of"),
        (vec![MOST_SHADERS; triangles], "a shader 65536"),
        (Vec::new(), "shaders of 0 triangles"),
    ] {
        let message = refused(&header(), &shaders);
        assert!(message.contains(expected), "{message}");
    }
    let of = |change: fn(&mut TraceHeader)| {
        let mut header = header();
        change(&mut header);
        refused(&header, &shaders)
    };
    let lost = of(|header| header.ray_sets.truncate(1));
    let listed = of(|header| header.frame = Frame::List { rays: 64 });
    for message in [lost, listed] {
        assert!(message.contains("lines of reflection rays without an image"), "{message}");
    }
    for wrong in [f32::NAN, f32::INFINITY, -2.0] {
        let mut header = header();
        header.reflections.as_mut().expect("kept").bounds[1][2] = wrong;
        let message = refused(&header, &shaders);
        assert!(message.contains("a scene's box"), "{message}");
    }
    let without = of(|header| header.reflections = None);
    assert!(without.contains("0 expected"), "{without}");
}
