//! Scenes, rays and the slow twin that the kd tests share.

#![allow(dead_code, reason = "each test binary uses its own part")]

use scenes::{Triangle, Vec3};
use std::path::{Path, PathBuf};
use tracer::kd::{FlatCells, KdCells, KdOptions, KdTree, Splits, backtrack, push_down, restart, stack};
use tracer::{Hit, Observer, Op, PreparedTriangle, Query, Ray};

/// splitmix64 (Steele, Lea & Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In `[-1, 1)`.
    pub(crate) fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// Triangles of mixed size in the cube `[-1, 1]^3`.
pub(crate) fn soup(count: usize, seed: u64) -> Vec<Triangle> {
    let mut random = Random(seed);
    (0..count)
        .map(|_| {
            let centre = random.point();
            let size = 0.5 * random.signed().abs().powi(3) + 1e-3;
            Triangle { v: [0; 3].map(|_| centre + size * random.point()) }
        })
        .collect()
}

/// A box of `n` by `n` unit quads on each face of a cube at integer coordinates: flat triangles, shared edges, splits at vertices.
pub(crate) fn quads(n: i32) -> Vec<Triangle> {
    let mut all = Vec::new();
    for axis in 0..3 {
        for level in [0, n / 2, n] {
            for i in 0..n {
                for j in 0..n {
                    let corner = |di: i32, dj: i32| {
                        let mut p = [0.0; 3];
                        p[axis] = level as f32;
                        p[(axis + 1) % 3] = (i + di) as f32;
                        p[(axis + 2) % 3] = (j + dj) as f32;
                        Vec3::from(p)
                    };
                    all.push(Triangle { v: [corner(0, 0), corner(1, 0), corner(1, 1)] });
                    all.push(Triangle { v: [corner(0, 0), corner(1, 1), corner(0, 1)] });
                }
            }
        }
    }
    all
}

/// A ray from anywhere near the scene in any direction.
pub(crate) fn random_ray(random: &mut Random, low: Vec3, high: Vec3) -> Ray {
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    Ray::new(centre + 1.5 * half * random.point(), random.point())
}

/// A ray along an axis, other components 0.0 or -0.0, from coordinates that vertices have.
pub(crate) fn axis_ray(random: &mut Random, triangles: &[Triangle]) -> Ray {
    let mut vertex = || triangles[random.below(triangles.len())].v[random.below(3)];
    let mut origin = Vec3::new(vertex().x, vertex().y, vertex().z);
    let axis = random.below(3);
    let mut direction = [0, 0, 0].map(|_: i32| if random.below(2) == 0 { 0.0 } else { -0.0 });
    direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
    if random.below(2) == 0 {
        origin[axis] -= direction[axis] * 3.0;
    }
    Ray::new(origin, Vec3::from(direction))
}

/// A ray through a vertex or the middle of an edge.
pub(crate) fn corner_ray(random: &mut Random, triangles: &[Triangle], low: Vec3, high: Vec3) -> Ray {
    let v = triangles[random.below(triangles.len())].v;
    let target = if random.below(2) == 0 { v[0] } else { (v[0] + v[1]) * 0.5 };
    let origin = random_ray(random, low, high).origin;
    Ray::new(origin, target - origin)
}

pub(crate) fn bounds(triangles: &[Triangle]) -> (Vec3, Vec3) {
    let corners = || triangles.iter().flat_map(|t| t.v);
    (corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max))
}

/// Tests every triangle: nearest hit, lowest index among equal distances.
pub(crate) fn brute_force(prepared: &[PreparedTriangle], ray: &Ray) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    for (primitive, triangle) in (0..).zip(prepared) {
        if let Some((t, u, v)) = triangle.intersect(ray, best.t)
            && (t < best.t || primitive < best.primitive)
        {
            best = Hit { t, u, v, primitive };
        }
    }
    best
}

/// All traversals of one tree.
pub(crate) struct Traversals {
    pub(crate) tree: KdTree,
    pub(crate) cells: KdCells,
}

pub(crate) const NAMES: [&str; 7] =
    ["stack", "restart", "push-down", "push-down + 1", "push-down + 3", "push-down + 64", "backtrack"];

impl Traversals {
    pub(crate) fn new(triangles: &[Triangle], options: &KdOptions) -> Self {
        let tree = KdTree::build(triangles, options).unwrap();
        let cells = KdCells::new(&tree);
        Self { tree, cells }
    }

    pub(crate) fn trace<O: Observer>(&self, name: usize, ray: &Ray, query: Query, observer: &mut O) -> Hit {
        let tree = &self.tree;
        match name {
            0 => stack::trace(tree, ray, query, observer),
            1 => restart::trace(tree, ray, query, observer),
            2 => push_down::trace(tree, 0, ray, query, observer),
            3 => push_down::trace(tree, 1, ray, query, observer),
            4 => push_down::trace(tree, 3, ray, query, observer),
            5 => push_down::trace(tree, 64, ray, query, observer),
            _ => backtrack::trace(tree, &self.cells, ray, query, observer),
        }
    }
}

/// Every kind of tree that options can ask for.
pub(crate) fn all_options() -> Vec<KdOptions> {
    let mut all = Vec::new();
    for splits in [Splits::BoundingBox, Splits::Perfect] {
        for flat_cells in [FlatCells::Allowed, FlatCells::Forbidden] {
            for preset in [KdOptions::MOBILE, KdOptions::WALD_HAVRAN] {
                all.push(KdOptions { splits, flat_cells, ..preset });
            }
        }
    }
    all
}

/// Everything a traversal reports, in order.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Log {
    pub(crate) steps: Vec<(Op, u32)>,
    pub(crate) plane_tests: u32,
    pub(crate) leaf_visits: u32,
    pub(crate) stalls: u32,
}

impl Observer for Log {
    fn step(&mut self, op: Op, id: u32) {
        self.steps.push((op, id));
    }
    fn plane_test(&mut self) {
        self.plane_tests += 1;
    }
    fn leaf_visit(&mut self) {
        self.leaf_visits += 1;
    }
    fn stall(&mut self) {
        self.stalls += 1;
    }
}

impl Log {
    pub(crate) fn of(&self, op: Op) -> impl Iterator<Item = u32> {
        self.steps.iter().filter(move |step| step.0 == op).map(|step| step.1)
    }

    /// Records read: nodes and ancestors.
    pub(crate) fn fetches(&self) -> usize {
        self.of(Op::Node).count() + self.of(Op::Up).count()
    }
}

/// The triangles of a real scene, or `None` with a visible note when it is not at hand.
pub(crate) fn real_scene(name: &str) -> Option<Vec<Triangle>> {
    let file = real_scene_path(name);
    if !file.exists() {
        eprintln!("skipped: {} is not at hand", file.display());
        return None;
    }
    Some(scenes::load(&file.to_string_lossy()).unwrap().triangles())
}

fn real_scene_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes").join(format!("{name}.obj.zst"))
}
