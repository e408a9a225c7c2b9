//! Does a trace file give back what was recorded, and is every kind of damage noticed?

use glam::Vec3;
use std::path::{Path, PathBuf};
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, AlphaMode, AlphaTests, BuildOptions, DECIDED_BY_MICROMAP, EncodedTile, Error,
    FrameTracer, MAX_RAY_SETS, MicromapFormat, MicromapStates, NOT_CAST, Op, RayKind, RaySample, Rays,
    SampledRay, Sampling, SceneIdentity, Step, TestedTriangles, Tile, TileRect, TileSource, TopologyNode,
    TraceFile, TraceHeader, TraceWriter, Traversal, View,
};

fn with_tracer<R>(
    traversal: Traversal,
    width: u32,
    height: u32,
    use_it: impl FnOnce(&FrameTracer) -> R,
) -> R {
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let structure = AccelerationStructure::build(&triangles, traversal, &options).expect("it builds");
    let view = View::new(&scene.camera, width, height);
    let scenes::Light::Point { position } = scene.lights[0];
    let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
    let rays = Rays::View { view, width, height };
    let tracer = FrameTracer::new(&structure, &options, &triangles, identity, rays, vec![position]);
    use_it(&tracer.with_raster())
}

fn write(source: &impl TileSource, path: &Path) -> Result<u64, Error> {
    let mut writer = TraceWriter::create(path, source.header(), source.topology())?;
    let mut tile = Tile::default();
    for index in 0..source.header().frame.tiles() {
        source.tile(index, &mut tile)?;
        writer.write_tile(&EncodedTile::new(&tile, source.header())?)?;
    }
    writer.finish(source.stalls())
}

/// Reads everything a replay would read.
fn read_all(path: &Path) -> Result<(TraceFile, Vec<Tile>), Error> {
    let file = TraceFile::open(path)?;
    let tiles = (0..file.header().frame.tiles())
        .map(|index| {
            let mut tile = Tile::default();
            file.tile(index, &mut tile).map(|()| tile)
        })
        .collect::<Result<_, _>>()?;
    Ok((file, tiles))
}

#[test]
fn what_was_recorded_comes_back_for_every_traversal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cornell.rbt");
    for traversal in Traversal::ALL {
        with_tracer(traversal, 70, 41, |tracer| {
            write(tracer, &path).expect("it is written");
            let (file, tiles) = read_all(&path).expect("it is read");
            assert_eq!(file.header(), tracer.header());
            assert_eq!(file.topology(), tracer.topology());
            let mut expected = Tile::default();
            for (index, tile) in (0..).zip(&tiles) {
                tracer.tile(index, &mut expected).expect("it is traced");
                assert_eq!(*tile, expected, "tile {index} of {}", traversal.name());
            }
            assert!(tiles.iter().any(|tile| tile.draws.iter().any(|draw| draw.passed > 0)));
            let steps: usize = tiles.iter().flat_map(|tile| &tile.ray_sets).map(|set| set.steps.len()).sum();
            assert_eq!(file.steps(), steps as u64);
        });
    }
}

/// Uses a tracer of the Cornell Box with masks on a quarter of its triangles, whose micromaps say so much.
fn with_micromaps<R>(traversal: Traversal, use_it: impl FnOnce(&FrameTracer) -> R) -> R {
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let tests = AlphaTests {
        mode: AlphaMode::Micromap,
        tested: TestedTriangles::OnePairInFour,
        micromap: Some(MicromapFormat { level: 4, states: MicromapStates::Four }),
    };
    let structure = AccelerationStructure::build(&triangles, traversal, &options)
        .and_then(|structure| structure.with_alpha(tests))
        .expect("it builds");
    let view = View::new(&scene.camera, 40, 40);
    let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
    let rays = Rays::View { view, width: 40, height: 40 };
    use_it(&FrameTracer::new(&structure, &options, &triangles, identity, rays, Vec::new()))
}

#[test]
fn what_micromaps_decided_comes_back_for_every_traversal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("alpha.rbt");
    for traversal in Traversal::ALL {
        with_micromaps(traversal, |tracer| {
            write(tracer, &path).expect("it is written");
            let (file, tiles) = read_all(&path).expect("it is read");
            assert_eq!(file.header(), tracer.header());
            let mut expected = Tile::default();
            for (index, tile) in (0..).zip(&tiles) {
                tracer.tile(index, &mut expected).expect("it is traced");
                assert_eq!(*tile, expected, "tile {index} of {}", traversal.name());
            }
            let steps = || tiles.iter().flat_map(|tile| &tile.ray_sets).flat_map(|set| &set.steps);
            let any_hits = || steps().filter(|step| step.op() == Op::AnyHit);
            let decided = any_hits().filter(|step| step.id() & DECIDED_BY_MICROMAP != 0).count();
            assert!(decided > 0 && decided < any_hits().count(), "{decided}");
        });
    }
}

#[test]
fn only_any_hit_steps_of_a_trace_with_micromaps_have_the_bit_and_positions_stay_in_range() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("alpha.rbt");
    with_micromaps(Traversal::BvhStack, |tracer| {
        let references = tracer.topology().references.len() as u32;
        let mut by_shader = tracer.header().clone();
        let alpha = by_shader.alpha.as_mut().expect("it has alpha tests");
        (alpha.mode, alpha.micromap) = (AlphaMode::AnyHit, None);
        let last = (references - 1) | DECIDED_BY_MICROMAP;
        for (header, op, id, is_read) in [
            (tracer.header(), Op::AnyHit, last, true),
            (tracer.header(), Op::AnyHit, last + 1, false),
            (tracer.header(), Op::AnyHit, references, false),
            (tracer.header(), Op::Primitive, last, false),
            (&by_shader, Op::AnyHit, references - 1, true),
            (&by_shader, Op::AnyHit, last, false),
        ] {
            let mut writer = TraceWriter::create(&path, header, tracer.topology()).expect("a good header");
            let mut tile = Tile::default();
            for index in 0..header.frame.tiles() {
                tracer.tile(index, &mut tile).expect("it is traced");
                tile.ray_sets[0].steps.iter_mut().for_each(|step| *step = Step::new(Op::Node, 0));
                tile.ray_sets[0].steps[0] = Step::new(op, id);
                writer.write_tile(&EncodedTile::new(&tile, header).expect("it fits")).expect("it is written");
            }
            writer.finish(0).expect("it is written");
            assert_eq!(read_all(&path).is_ok(), is_read, "{op:?} {id:#x}");
        }
    });
}

#[test]
fn contradictory_alpha_tests_are_neither_written_nor_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("alpha.rbt");
    with_micromaps(Traversal::BvhStack, |tracer| {
        for tests in [
            AlphaTests {
                tested: TestedTriangles::Runs(vec![[31, 2]]),
                ..tracer.header().alpha.clone().unwrap()
            },
            AlphaTests { micromap: None, ..tracer.header().alpha.clone().unwrap() },
        ] {
            let header = TraceHeader { alpha: Some(tests), ..tracer.header().clone() };
            assert!(TraceWriter::create(&path, &header, tracer.topology()).is_err());
        }
    });
}

#[test]
fn every_corruption_of_a_single_byte_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.rbt");
    with_tracer(Traversal::BvhStack, 8, 8, |tracer| write(tracer, &path).expect("it is written"));
    let good = std::fs::read(&path).expect("it is there");
    read_all(&path).expect("the undamaged file reads");
    let damaged = folder.path().join("damaged.rbt");
    for position in 0..good.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = good.clone();
            bytes[position] ^= flip;
            std::fs::write(&damaged, &bytes).expect("it is written");
            let error =
                read_all(&damaged).err().unwrap_or_else(|| panic!("byte {position} ^ {flip:#x} passed"));
            assert!(error.to_string().contains("damaged.rbt"), "{error}");
        }
    }
}

#[test]
fn every_truncation_and_every_extension_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.rbt");
    with_tracer(Traversal::KdPushDown { short_stack: 0 }, 8, 8, |tracer| {
        write(tracer, &path).expect("it is written")
    });
    let good = std::fs::read(&path).expect("it is there");
    let torn = folder.path().join("torn.rbt");
    for length in 0..good.len() {
        std::fs::write(&torn, &good[..length]).expect("it is written");
        assert!(read_all(&torn).is_err(), "{length} of {} bytes passed", good.len());
    }
    std::fs::write(&torn, [&good[..], b"x"].concat()).expect("it is written");
    assert!(read_all(&torn).is_err());
}

#[test]
fn a_foreign_file_is_called_foreign() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("image.rbt");
    std::fs::write(&path, b"\x89PNG\r\n\x1a\n and more than a hundred bytes of something that is no trace")
        .expect("written");
    let message = TraceFile::open(&path).err().expect("refused").to_string();
    assert!(message.contains("not a raybudget trace") && message.contains("image.rbt"), "{message}");
}

#[test]
fn a_writer_that_is_dropped_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    with_tracer(Traversal::BvhStack, 64, 64, |tracer| {
        let path = folder.path().join("unfinished.rbt");
        let mut writer = TraceWriter::create(&path, tracer.header(), tracer.topology()).expect("it opens");
        let mut tile = Tile::default();
        tracer.tile(0, &mut tile).expect("it is traced");
        writer
            .write_tile(&EncodedTile::new(&tile, tracer.header()).expect("it fits"))
            .expect("it is written");
    });
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn a_folder_that_does_not_exist_is_named() {
    let message = with_tracer(Traversal::BvhStack, 8, 8, |tracer| {
        write(tracer, Path::new("no/such/folder/t.rbt")).expect_err("refused").to_string()
    });
    assert!(message.contains("no/such/folder/t.rbt"), "{message}");
}

#[test]
fn a_ray_list_is_cut_into_tiles_and_comes_back() {
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let structure =
        AccelerationStructure::build(&triangles, Traversal::BvhStack, &options).expect("it builds");
    let view = View::new(&scene.camera, 50, 50);
    let rays: Vec<_> = (0..2500).map(|i| view.primary_ray(i % 50, i / 50)).collect();
    let identity = || SceneIdentity { name: "list".to_owned(), hash: 1 };
    let light = vec![Vec3::ZERO];
    let list = FrameTracer::new(&structure, &options, &triangles, identity(), Rays::List(rays), light);
    assert_eq!(list.header().frame.tiles(), 3);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("list.rbt");
    write(&list, &path).expect("it is written");
    let (file, tiles) = read_all(&path).expect("it is read");
    assert!(!file.header().raster && tiles.iter().all(|tile| tile.draws.is_empty()));
    assert_eq!(tiles.iter().map(|tile| tile.ray_sets[0].ends.len()).collect::<Vec<_>>(), [1024, 1024, 452]);
}

/// Puts a file that is kept to be read for ever into `folder`. Its first byte tells the fuzzer that a file follows.
fn kept(name: &str, folder: &Path) -> (PathBuf, Vec<u8>) {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/trace_file").join(name);
    let bytes = std::fs::read(kept).expect("a file of the repository").split_off(1);
    let path = folder.join(name);
    std::fs::write(&path, &bytes).expect("it is written");
    (path, bytes)
}

#[test]
fn a_kept_file_with_every_kind_of_ray_reads_and_is_written_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, kept) = kept("ray_sets.rbt", folder.path());
    let (file, tiles) = read_all(&path).expect("it is read");
    let sets = &file.header().ray_sets;
    assert!(RayKind::ALL.iter().all(|kind| sets.iter().any(|set| set.kind == *kind)), "{sets:?}");
    assert!(sets.iter().any(|set| set.sample == 1));
    let not_cast = tiles.iter().flat_map(|tile| &tile.ray_sets).flat_map(|set| &set.hits);
    assert!(not_cast.filter(|&&hit| hit == NOT_CAST).count() > 0);
    let again = folder.path().join("again.rbt");
    write(&file, &again).expect("it is written");
    assert!(std::fs::read(&again).expect("it is there") == kept);
}

#[test]
fn a_file_from_before_drawn_triangles_reads_as_before_and_its_tiles_are_written_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, old) = kept("whole.rbt", folder.path());
    let again = folder.path().join("again.rbt");
    let (file, tiles) = read_all(&path).expect("it is read");
    assert!(!file.header().raster && tiles.iter().all(|tile| tile.draws.is_empty()));
    assert!(tiles.iter().any(|tile| !tile.ray_sets[0].steps.is_empty()));
    write(&file, &again).expect("it is written");
    // Headers have gained keys since; the tree and the tiles lie between header and index.
    let chunks = |file: &[u8]| {
        let text = u32::from_le_bytes(*file[8..].first_chunk().expect("a length")) as usize;
        let trailer = file.len() - 48;
        let index = u64::from_le_bytes(*file[trailer..].first_chunk().expect("an offset")) as usize;
        file[12 + text + 8..index].to_vec()
    };
    assert_eq!(chunks(&std::fs::read(&again).expect("it is there")), chunks(&old));
}

#[test]
fn a_file_with_a_binary_tlas_over_wide_blases_reads_as_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, old) = kept("binary_tlas.rbt", folder.path());
    let (file, tiles) = read_all(&path).expect("it is read");
    // Then names of formats had no hyphen.
    assert!(String::from_utf8_lossy(&old).contains(r#""node_format":"full4","node_fetch":"pair""#));
    assert_eq!(file.header().node_format, Some(NodeFormat::Full4));
    let trees = file.topology().trees();
    assert_eq!(trees.iter().map(|(_, tree)| tree.is_wide()).collect::<Vec<_>>(), [false, true]);
    assert!(tiles.iter().flat_map(|tile| &tile.ray_sets).any(|set| !set.steps.is_empty()));
    let again = folder.path().join("again.rbt");
    write(&file, &again).expect("it is written");
    let (file_again, tiles_again) = read_all(&again).expect("it is read");
    assert_eq!((file_again.header(), file_again.topology()), (file.header(), file.topology()));
    assert_eq!(tiles_again, tiles);
    // Over binary BLASes a TLAS cannot be wide.
    let mut mixed = file.topology().clone();
    let blas = mixed.levels.as_ref().expect("two levels").blases[0].nodes.start as usize;
    mixed.nodes[blas] = TopologyNode::Leaf { first: 0, count: 4 };
    mixed.validate().expect("both binary");
    mixed.nodes[0] = TopologyNode::Wide { first: 1, count: 2, leaves: 0 };
    let refused = mixed.validate().expect_err("the TLAS alone is wide");
    assert!(refused.contains("the nodes of the TLAS are wide"), "{refused}");
}

#[test]
fn drawn_triangles_without_an_image_are_not_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("list.rbt");
    with_tracer(Traversal::BvhStack, 8, 8, |tracer| {
        let mut header = tracer.header().clone();
        header.frame = tracer::Frame::List { rays: 64 };
        let refused = TraceWriter::create(&path, &header, tracer.topology()).err().expect("refused");
        assert!(refused.to_string().contains("drawn triangles for a list of rays"), "{refused}");
        header.raster = false;
        TraceWriter::create(&path, &header, tracer.topology()).expect("a list alone");
    });
}

#[test]
fn a_node_format_belongs_to_wide_bvhs_and_to_no_other_structure() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wide.rbt");
    with_tracer(Traversal::WideStack { format: NodeFormat::Adreno8 }, 8, 8, |tracer| {
        let mut header = tracer.header().clone();
        assert_eq!(header.node_format, Some(NodeFormat::Adreno8));
        TraceWriter::create(&path, &header, tracer.topology()).expect("a wide BVH in a format");
        header.node_format = None;
        let refused = TraceWriter::create(&path, &header, tracer.topology()).err().expect("refused");
        assert!(refused.to_string().contains("no node format for a structure 'wide-bvh'"), "{refused}");
    });
    with_tracer(Traversal::BvhStack, 8, 8, |tracer| {
        let header = TraceHeader { node_format: Some(NodeFormat::Full4), ..tracer.header().clone() };
        let refused = TraceWriter::create(&path, &header, tracer.topology()).err().expect("refused");
        assert!(refused.to_string().contains("full-4 for a structure 'bvh'"), "{refused}");
    });
}

#[test]
fn what_a_reader_would_refuse_is_not_written() {
    let scene = scenes::builtin("cornell").expect("a built-in scene");
    let triangles = scene.triangles();
    let options = BuildOptions::default();
    let structure =
        AccelerationStructure::build(&triangles, Traversal::BvhStack, &options).expect("it builds");
    let view = View::new(&scene.camera, 8, 8);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lights.rbt");
    let with_lights = |lights| {
        let identity = SceneIdentity { name: scene.name.clone(), hash: scene.hash() };
        let rays = Rays::View { view, width: 8, height: 8 };
        write(
            &FrameTracer::new(&structure, &options, &triangles, identity, rays, vec![Vec3::ZERO; lights]),
            &path,
        )
    };
    let message = with_lights(MAX_RAY_SETS).expect_err("one set of rays too many").to_string();
    assert!(message.contains("1025 ray sets"), "{message}");
    assert!(!path.exists());
    with_lights(MAX_RAY_SETS - 1).expect("just enough");
    assert_eq!(read_all(&path).expect("it is read").1.len(), 1);
}

#[test]
fn a_sample_of_pixels_keeps_their_rays_and_changes_no_tile() {
    with_tracer(Traversal::BvhStack, 75, 45, |tracer| {
        let sampling = Sampling::new(tracer, 100);
        let (mut plain, mut sampled) = (Tile::default(), Tile::default());
        let mut tiles = Vec::new();
        // In any order, and some of them twice.
        for index in (0..tracer.header().frame.tiles()).rev().chain([0]) {
            tracer.tile(index, &mut plain).expect("a tile");
            sampling.tile(index, &mut sampled).expect("a tile");
            assert_eq!(plain, sampled);
            tiles.push((tracer.header().frame.tile(index), plain.clone()));
        }
        let RaySample { every, first, size, rays } = sampling.finish().expect("every tile was made");
        assert_eq!((every, first, size), (8, [4, 4], [9, 6]));
        let sets = tracer.header().ray_sets.len();
        assert_eq!(rays.len() as u32, size[0] * size[1] * sets as u32);
        for (place, SampledRay { steps, hit }) in rays.iter().enumerate() {
            let (pixel, set) = (place / sets, place % sets);
            let [x, y] = [first[0] + 8 * (pixel as u32 % size[0]), first[1] + 8 * (pixel as u32 / size[0])];
            let holds = |rect: &TileRect| {
                (rect.x..rect.x + rect.width).contains(&x) && (rect.y..rect.y + rect.height).contains(&y)
            };
            let (rect, tile) = tiles.iter().find(|(rect, _)| holds(rect)).expect("a tile of the pixel");
            let (set, ray) = (&tile.ray_sets[set], ((y - rect.y) * rect.width + x - rect.x) as usize);
            assert_eq!((steps.as_slice(), *hit), (&set.steps[set.range(ray)], set.hits[ray]), "{x} {y}");
        }
        let unfinished = Sampling::new(tracer, 100);
        unfinished.tile(0, &mut sampled).expect("a tile");
        assert_eq!(unfinished.finish(), None);
        assert_eq!(Sampling::new(tracer, 0).finish(), None);
    });
}
