//! All traversals give the bits of a loop over all triangles, where rays, planes and vertices coincide.

use crate::case::{Case, Limit};
use crate::random::Random;
use crate::structures::{self, Structure, Watch, brute_force, options, same};
use crate::{Size, shapes};
use glam::Vec3;
use rayon::prelude::*;
use scenes::Triangle;
use tracer::bvh::restart_trail::TrailBits;
use tracer::bvh::{Bvh, BvhOptions};
use tracer::kd::{FlatCells, KdNodeKind, KdOptions, KdTree, Splits};
use tracer::{BuildOptions, Query, Ray, Traversal, TriangleTest};

/// A scene, rays through it, and how deep the structures must be for the case to say anything.
struct Scene {
    id: &'static str,
    about: &'static str,
    triangles: Vec<Triangle>,
    rays: Vec<Ray>,
    builds: fn() -> Vec<(Traversal, KdOptions)>,
    least_depth: u32,
}

/// One of each, built as usual.
fn usual() -> Vec<(Traversal, KdOptions)> {
    Traversal::ALL.map(|traversal| (traversal, KdOptions::MOBILE)).to_vec()
}

/// Every option that changes the shape of cells: flat and empty ones, and depths from a leaf alone to the cap.
fn cells() -> Vec<(Traversal, KdOptions)> {
    let mut builds = usual();
    let of_kd = [Traversal::KdStack, Traversal::KdRestart, Traversal::KdPushDown { short_stack: 0 }];
    for max_depth in [Some(0), Some(1), Some(5), Some(KdOptions::MAX_DEPTH)] {
        for (splits, flat_cells, empty_bonus) in [
            (Splits::BoundingBox, FlatCells::Allowed, 0.1),
            (Splits::BoundingBox, FlatCells::Forbidden, 1.0),
            (Splits::Perfect, FlatCells::Allowed, 0.8),
            (Splits::Perfect, FlatCells::Forbidden, 0.1),
        ] {
            let options = KdOptions { max_depth, splits, flat_cells, empty_bonus, ..KdOptions::MOBILE };
            builds.extend(of_kd.map(|traversal| (traversal, options)));
            builds.push((Traversal::KdBacktrack, options));
        }
    }
    builds
}

/// Every width of trail and short stack, and kd-trees as deep as a word has bits.
fn deep() -> Vec<(Traversal, KdOptions)> {
    let mut builds = usual();
    for bits in [TrailBits::Bits32, TrailBits::Bits64].map(Some) {
        builds.extend(
            [0, 1, 3, 64]
                .map(|short_stack| (Traversal::BvhRestartTrail { bits, short_stack }, KdOptions::MOBILE)),
        );
    }
    let options = KdOptions { max_depth: Some(KdOptions::MAX_DEPTH), ..KdOptions::MOBILE };
    for short_stack in [0, 1, 64] {
        builds.push((Traversal::KdPushDown { short_stack }, options));
    }
    builds.extend([Traversal::KdStack, Traversal::KdRestart, Traversal::KdBacktrack].map(|t| (t, options)));
    builds
}

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    let scenes = scenes(size);
    TriangleTest::ALL
        .into_iter()
        .flat_map(|test| {
            let of_scenes = scenes.iter().flat_map(move |scene| of_scene(scene, test, watch));
            of_scenes.chain([reach(size, test, watch)])
        })
        .collect()
}

/// From how far away traversals agree. Planes are 16 ulps of the ray's reach thick, and no more than a 16th of a triangle: from 2^15
/// triangles away. From farther away hits are uncertain by more than that.
fn reach(size: Size, test: TriangleTest, watch: &Watch) -> Case {
    let triangles = shapes::sphere(Vec3::ZERO, 1.0, 16);
    let mut extents: Vec<f32> = triangles
        .iter()
        .map(|triangle| {
            let (low, high) = shapes::bounds(std::slice::from_ref(triangle));
            (high - low).max_element()
        })
        .collect();
    extents.sort_by(f32::total_cmp);
    let extent = extents[extents.len() / 2];
    let structures = structures::all(&triangles, &options(test));
    let differs = |exponent: i32| {
        let mut random = Random(exponent.unsigned_abs().into());
        (0..size.of(200, 2000)).any(|_| {
            let place = random.point();
            let mut direction = Vec3::from([0; 3].map(|_| 1e-12 * random.signed()));
            let axis = random.below(3);
            direction[axis] = [1.0, -1.0][random.below(2)];
            let ray = Ray::new(place - direction * extent * 2.0_f32.powi(exponent), direction);
            let expected = brute_force(&triangles, test, &ray);
            structures.iter().any(|structure| !same(&structure.trace(watch, &ray, Query::Closest), &expected))
        })
    };
    let farthest = (0..40).take_while(|&exponent| !differs(exponent)).last().unwrap_or(-1);
    Case::new(
        format!("same-hits/reach/{}", test.name()),
        "rays nearly along an axis: how far away, in triangles, all traversals give the bits of a loop; by theory 2^15",
        "exponent of 2",
        Limit::AtLeast(15.0),
        f64::from(farthest),
    )
    .under("distance over extent", 2.0_f64.powi(farthest))
}

fn of_scene(scene: &Scene, test: TriangleTest, watch: &Watch) -> Vec<Case> {
    let Scene { id, about, triangles, rays, builds, least_depth } = scene;
    let expected: Vec<_> = rays.par_iter().map(|ray| brute_force(triangles, test, ray)).collect();
    let hits = expected.iter().filter(|hit| hit.is_hit()).count();
    let found: Vec<(u64, u32, String)> = builds()
        .into_par_iter()
        .map(|(traversal, kd)| {
            // Splits cost nothing, so that trees become as deep as they may.
            let traversal_cost = if *least_depth > 0 { 0.0 } else { BuildOptions::default().traversal_cost };
            let options = BuildOptions { kd, traversal_cost, ..options(test) };
            let structure = Structure::build(triangles, traversal, &options).expect("the scene is finite");
            let differs = |(ray, expected): &(&Ray, &tracer::Hit)| {
                let closest = structure.trace(watch, ray, Query::Closest);
                let any = structure.trace(watch, ray, Query::Any);
                !same(&closest, expected) || any.is_hit() != expected.is_hit()
            };
            let differing = rays.iter().zip(&expected).filter(differs).count() as u64;
            (differing, structure.depth(), structure.name)
        })
        .collect();
    let differing = found.iter().map(|found| found.0).sum();
    let depth = found.iter().map(|found| found.1).max().unwrap_or(0);
    let mut names: Vec<&str> =
        found.iter().filter(|found| found.0 > 0).map(|found| found.2.as_str()).collect();
    names.dedup();
    let remark = format!(
        "{} rays through {} structures, of which {hits} rays hit{}{}",
        rays.len(),
        found.len(),
        if names.is_empty() { "" } else { "; by " },
        names.join(", ")
    );
    let mut cases = vec![
        Case::none_of(
            format!("same-hits/{id}/{}", test.name()),
            format!("{about}: every traversal gives the bits of a loop over all triangles"),
            "differing hits",
            differing,
        )
        .under("depth", f64::from(depth))
        .because(remark),
    ];
    if *least_depth > 0 {
        cases.push(Case::new(
            format!("same-hits/{id}/depth/{}", test.name()),
            format!("{about}: the deepest tree reaches its cap"),
            "edges",
            Limit::AtLeast(f64::from(*least_depth)),
            f64::from(depth),
        ));
    }
    cases
}

/// Either zero.
fn zero(random: &mut Random) -> f32 {
    [0.0, -0.0][random.below(2)]
}

/// A ray in the plane `axis = place`: along another axis, or across.
fn in_plane(axis: usize, place: f32, triangles: &[Triangle], random: &mut Random) -> Ray {
    let mut vertex = || triangles[random.below(triangles.len())].v[random.below(3)];
    let mut origin = Vec3::new(vertex().x, vertex().y, vertex().z);
    let mut direction = random.point();
    if random.below(2) == 0 {
        let along = (axis + 1 + random.below(2)) % 3;
        direction = Vec3::from([0; 3].map(|_| zero(random)));
        direction[along] = [1.0, -1.0][random.below(2)];
        origin[along] -= 3.0 * direction[along];
    }
    origin[axis] = place;
    direction[axis] = zero(random);
    Ray::new(origin, direction)
}

fn scenes(size: Size) -> Vec<Scene> {
    let count = size.of(300, 2000);
    let mut random = Random(77);
    let lattice = shapes::lattice(8);
    let soup = shapes::soup(400, 5);
    let (low, high) = shapes::bounds(&soup);
    let mut places = |rays: &mut dyn FnMut(&mut Random) -> Ray| -> Vec<Ray> {
        (0..count).map(|_| rays(&mut random)).collect()
    };

    let in_faces = places(&mut |random| {
        let axis = random.below(3);
        let place = random.below(9) as f32;
        in_plane(axis, place, &lattice, random)
    });
    let splits: Vec<(usize, f32)> = KdTree::build(&soup, &KdOptions::MOBILE)
        .expect("the scene is finite")
        .nodes()
        .iter()
        .filter_map(|node| match node.kind() {
            KdNodeKind::Inner { axis, split, .. } => Some((axis, split)),
            KdNodeKind::Leaf { .. } => None,
        })
        .collect();
    let in_splits = places(&mut |random| {
        let (axis, place) = splits[random.below(splits.len())];
        in_plane(axis, place, &soup, random)
    });
    let bvh = Bvh::build(&soup, &BvhOptions::MOBILE);
    let boxes: Vec<_> = bvh.nodes().map(|node| node.bounds).collect();
    let in_boxes = places(&mut |random| {
        let (bounds, axis) = (boxes[random.below(boxes.len())], random.below(3));
        let place = [bounds.min, bounds.max][random.below(2)][axis];
        in_plane(axis, place, &soup, random)
    });
    let from_vertices = places(&mut |random| {
        let mut vertex = || soup[random.below(soup.len())].v[random.below(3)];
        let (origin, target) = (vertex(), vertex());
        Ray::new(origin, if random.below(2) == 0 { target - origin } else { random.direction() })
    });
    let free = places(&mut |random| {
        let origin = (low + high) * 0.5 + (high - low) * random.point();
        Ray::new(origin, random.direction())
    });

    let many = size.of(20_000, 100_000);
    let few = |count: usize| -> Vec<Ray> {
        let mut random = Random(9);
        let from =
            |random: &mut Random| Vec3::new(0.3 + 0.05 * random.signed(), 0.3, [-2.0, 4.0][random.below(2)]);
        (0..count)
            .map(|_| {
                let origin = from(&mut random);
                Ray::new(origin, Vec3::new(0.0, -0.0, if origin.z < 0.0 { 1.0 } else { -1.0 }))
            })
            .collect()
    };
    let copies = vec![Triangle { v: [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)] }; many];
    // 100 halvings: from 2^-50 to 2^50 and deeper than any trail.
    let nested = shapes::nested(100);
    let deep_rays = (0..100)
        .flat_map(|i| {
            let s = 2.0_f32.powi(i - 50);
            [(-s, 1.0), (4.0 * s, -1.0)]
                .map(|(x, d)| Ray::new(Vec3::new(x, 0.2 * s, 0.2 * s), Vec3::new(d, 0.0, -0.0)))
        })
        .collect();
    let far = Vec3::new(1e7, -1e7, 1e7);
    let sphere = shapes::sphere(far, 2000.0, 16);
    let offset = places(&mut |random| Ray::new(far + 4000.0 * random.point(), random.direction()));
    let scene = |id, about, triangles: &[Triangle], rays, builds: fn() -> _, least_depth| Scene {
        id,
        about,
        triangles: triangles.to_vec(),
        rays,
        builds,
        least_depth,
    };
    vec![
        scene("faces", "rays in the faces of unit quads, along and across", &lattice, in_faces, usual, 0),
        scene("split-planes", "rays in the split planes of a kd-tree", &soup, in_splits, usual, 0),
        scene("box-faces", "rays in the faces of a BVH's boxes", &soup, in_boxes, usual, 0),
        scene("vertices", "rays from vertices to vertices and anywhere", &soup, from_vertices, usual, 0),
        scene("cells", "flat and empty cells, depths from 0 to 64, perfect splits", &soup, free, cells, 0),
        scene("copies", "copies of one triangle", &copies, few(4), usual, 0),
        scene("coplanar", "layers of one plane", &shapes::coplanar(many), few(4), usual, 0),
        scene(
            "layers",
            "layers at neighbouring floats",
            &shapes::layers(many),
            few(size.of(20, 100)),
            usual,
            0,
        ),
        scene("depth-cap", "triangles that halve in size a hundred times", &nested, deep_rays, deep, 63),
        scene("offset", "a sphere at 1e7 from near by", &sphere, offset, usual, 0),
    ]
}
