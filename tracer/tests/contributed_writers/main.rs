//! Do the writers for other renderers, in C and in Python, write what they are told, and refuse what does not fit?
//!
//! A listing of numbers tells `rewrite.c` and `rewrite.py` what to call. Tests go without a writer where `cc` or `python3` is missing, and say so.

mod listing;
mod misuse;
mod programs;

use listing::{Recorded, listing};
use programs::Programs;
use std::fmt::Write;
use std::path::Path;
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, NO_HIT, NodeFetch, Op, RayKind, Rays, SceneIdentity,
    Step, Tile, TraceFile, Traversal, View,
};
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Reads everything a replay would read.
fn read(path: &Path) -> Recorded {
    Recorded::of(&TraceFile::open(path).expect("it is opened"))
}

/// That every writer makes a file of `recorded` in which a reader finds the same.
fn assert_comes_back(programs: &Programs, recorded: &Recorded, what: &str) {
    for program in &programs.all {
        let path = programs.folder.path().join("copy.rbt");
        program.run(&[path.as_ref()], listing(recorded)).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(read(&path) == *recorded, "{what} by {}", program.name);
        std::fs::remove_file(&path).expect("it is there");
    }
}

fn traced(traversal: Traversal, rays: impl Fn(View) -> Rays) -> Recorded {
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let structure = AccelerationStructure::build(&triangles, traversal, &options).expect("it builds");
    let scenes::Light::Point { position } = scene.lights[0];
    let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
    let rays = rays(View::new(&scene.camera, 70, 41));
    Recorded::of(&FrameTracer::new(&structure, &options, &triangles, identity, rays, vec![position]))
}

fn image(view: View) -> Rays {
    Rays::View { view, width: 70, height: 41 }
}

#[test]
fn what_raybudget_records_comes_back_from_both_writers_for_every_traversal() {
    let programs = Programs::new("rewrite");
    let formats = NodeFormat::ALL.map(|format| Traversal::WideStack { format });
    for traversal in Traversal::ALL.into_iter().chain(formats) {
        let recorded = traced(traversal, image);
        assert!(recorded.tiles.len() == 6 && recorded.steps() > 20_000);
        assert_comes_back(&programs, &recorded, traversal.name());
    }
}

#[test]
fn a_list_of_rays_comes_back_from_both_writers() {
    let rays = |view: View| Rays::List((0..2500).map(|i| view.primary_ray(i % 50, i / 50)).collect());
    let recorded = traced(Traversal::BvhStack, rays);
    assert_eq!(recorded.tiles.len(), 3);
    assert_comes_back(&Programs::new("rewrite"), &recorded, "a list");
}

#[test]
fn two_levels_of_several_meshes_come_back_from_both_writers() {
    let programs = Programs::new("rewrite");
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let meshes = [triangles[..17].to_vec(), triangles[17..].to_vec()];
    let place = |mesh, x| scenes::Instance {
        mesh,
        transform: scenes::Affine3A::from_translation(scenes::Vec3::new(x, 0.0, 0.0)),
    };
    let instances = [place(1, 0.0), place(0, 0.0), place(1, 150.0)];
    let flat: Vec<_> = [&meshes[1], &meshes[0], &meshes[1]].into_iter().flatten().copied().collect();
    let options = BuildOptions::default();
    let formats = NodeFormat::ALL.map(Some).into_iter().chain([None]);
    for traversal in formats.map(|format| Traversal::TwoLevelStack { format }) {
        let structure = AccelerationStructure::build_two_level(&meshes, &instances, traversal, &options)
            .expect("it builds");
        let identity = SceneIdentity { name: "boxes".to_owned(), hash: u64::MAX };
        let rays = image(View::new(&scene.camera, 70, 41));
        let tracer = FrameTracer::new(&structure, &options, &flat, identity, rays, Vec::new());
        let recorded = Recorded::of(&tracer);
        assert!(recorded.all_steps().any(|step| step.op() == Op::Instance && step.id() == 2));
        assert_comes_back(&programs, &recorded, &format!("{traversal:?}"));
    }
}

#[test]
fn every_kind_of_ray_comes_back_from_both_writers_and_rays_that_are_left_out_were_not_cast() {
    let programs = Programs::new("rewrite");
    // The first byte tells the fuzzer that a file follows.
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/trace_file/ray_sets.rbt");
    let bytes = std::fs::read(kept).expect("a file of the repository").split_off(1);
    let path = programs.folder.path().join("kept.rbt");
    std::fs::write(&path, bytes).expect("it is written");
    let recorded = read(&path);
    assert!(RayKind::ALL.iter().all(|kind| recorded.header.ray_sets.iter().any(|set| set.kind == *kind)));
    let not_cast =
        |tile: &Tile| tile.ray_sets.iter().flat_map(|set| &set.hits).any(|&hit| hit == tracer::NOT_CAST);
    assert!(recorded.tiles.iter().any(not_cast));
    assert_comes_back(&programs, &recorded, "every kind of ray");
}

#[test]
fn a_tile_larger_than_a_block_of_its_frame_comes_back_from_both_writers() {
    let mut recorded = traced(Traversal::BvhStack, |view| Rays::List(vec![view.primary_ray(3, 4); 300]));
    let references = recorded.topology.references.len() as u32;
    recorded.header.ray_sets.truncate(1);
    for tile in &mut recorded.tiles {
        tile.ray_sets.truncate(1);
        let set = &mut tile.ray_sets[0];
        set.clear();
        for ray in 0..300 {
            let ops = [Op::Node, Op::Up, Op::Restart, Op::Primitive, Op::AnyHit, Op::Primitive];
            set.steps.extend((0..900).map(|i| Step::new(ops[i % 6], (7 * i as u32 + ray) % references / 4)));
            set.end_ray(if ray % 3 == 0 { NO_HIT } else { ray % 32 }).expect("few steps");
        }
    }
    assert!(recorded.steps() > 2 << 17);
    assert_comes_back(&Programs::new("rewrite"), &recorded, "a large tile");
}

#[test]
fn texts_and_optional_keys_come_back_from_both_writers() {
    let mut recorded = traced(Traversal::BvhStack, |view| Rays::List(vec![view.primary_ray(3, 4)]));
    recorded.header.scene = "a \"scene\" \\ of\ttabs, \u{1} and \u{e9}\u{1f642}, \u{7f}\u{80}\u{7ff}\u{800}\u{d7ff}\u{e000}\u{ffff}\u{10000}\u{10ffff}".to_owned();
    recorded.header.normals = false;
    recorded.header.shadow_query = tracer::Query::Closest;
    recorded.header.trail_bits = Some(32);
    recorded.header.sah_costs = [0.1, 1e-7];
    recorded.header.node_fetch = NodeFetch::Single;
    recorded.header.remarks.notes = vec!["half of it is sky".to_owned()];
    recorded.stalls = 3;
    assert_comes_back(&Programs::new("rewrite"), &recorded, "texts");
}

#[test]
fn checksums_of_both_writers_are_those_of_the_reference_at_every_length_and_seed() {
    let programs = Programs::new("checksum");
    let data: Vec<u8> = (0..1_usize << 14).map(|i| (i * i % 251) as u8).collect();
    let lengths = (9..=600).chain([1023, 1024, 1025, 1088, 1089, 2048, 2049, 5000, 1 << 14]);
    let cases: Vec<(usize, u64)> =
        lengths.flat_map(|length| [0, 1, 3, 1 << 32 | 7].map(|seed| (length, seed))).collect();
    let (mut asked, mut expected) = (String::new(), String::new());
    for (length, seed) in cases {
        writeln!(asked, "{length} {seed}").expect("a string grows");
        writeln!(expected, "{:016x}", xxh3_64_with_seed(&data[..length], seed)).expect("a string grows");
    }
    for program in &programs.all {
        let printed = program.run(&[], &asked).unwrap_or_else(|error| panic!("{error}"));
        assert!(printed == expected, "{}", program.name);
    }
}
