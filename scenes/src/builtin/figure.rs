//! A scan-like figure in a box: one closed, manifold surface of about 100,000 small, uneven triangles, standing for
//! scanned models such as the Happy Buddha.
//!
//! A standing person with hands on hips (so the surface has handles) as a smooth union of capsules, roughened by
//! noise, polygonised by marching tetrahedra over cubes cut into six along their main diagonal (Kuhn). Neighbouring
//! cubes agree on their cuts, so every edge belongs to exactly two triangles.

use super::builder::Builder;
use super::numeric::noise;
use crate::{Camera, Instance, Light, Material, Mesh, RaySelection, Scene};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Edge of a grid cube; the figure is 1.8 high.
const CELL: f64 = 0.0133;
/// Grid cubes along x, y, z, and the corner the grid starts at.
const CELLS: [usize; 3] = [79, 144, 48];
const ORIGIN: DVec3 = DVec3::new(-0.524, -0.05, -0.317);

/// Capsules: two ends and two radii.
type Capsule = ([f64; 3], [f64; 3], f64, f64);

#[rustfmt::skip]
const BODY: [Capsule; 14] = [
    ([0.0, 1.66, 0.02], [0.0, 1.60, 0.03], 0.105, 0.085), // head
    ([0.0, 1.52, 0.0], [0.0, 1.42, 0.0], 0.055, 0.065), // neck
    ([-0.16, 1.36, 0.0], [0.16, 1.36, 0.0], 0.085, 0.085), // shoulders
    ([0.0, 1.28, 0.01], [0.0, 1.08, 0.01], 0.16, 0.125), // chest
    ([0.0, 1.05, 0.01], [0.0, 0.92, 0.0], 0.125, 0.15), // waist
    ([-0.22, 1.34, 0.0], [-0.42, 1.12, -0.06], 0.06, 0.048), // right upper arm
    ([-0.42, 1.12, -0.06], [-0.17, 0.98, 0.06], 0.046, 0.038), // right forearm, hand on hip
    ([0.22, 1.34, 0.0], [0.42, 1.12, -0.06], 0.06, 0.048), // left upper arm
    ([0.42, 1.12, -0.06], [0.17, 0.98, 0.06], 0.046, 0.038), // left forearm
    ([-0.09, 0.88, 0.0], [-0.13, 0.48, 0.02], 0.095, 0.062), // right thigh
    ([-0.13, 0.48, 0.02], [-0.15, 0.08, -0.02], 0.06, 0.042), // right shin
    ([0.09, 0.88, 0.0], [0.13, 0.48, 0.02], 0.095, 0.062), // left thigh
    ([0.13, 0.48, 0.02], [0.15, 0.08, -0.02], 0.06, 0.042), // left shin
    ([-0.16, 0.03, 0.03], [0.16, 0.03, 0.03], 0.055, 0.055), // base
];

pub(super) fn scene() -> Scene {
    Scene {
        name: "figure".into(),
        meshes: vec![surface(), room()],
        instances: vec![Instance::identity(0), Instance::identity(1)],
        materials: vec![
            Material::matte("stone", Vec3::new(0.7, 0.65, 0.55)),
            Material::matte("white", Vec3::new(0.725, 0.71, 0.68)),
            Material::matte("red", Vec3::new(0.63, 0.065, 0.05)),
            Material::matte("green", Vec3::new(0.14, 0.45, 0.091)),
        ],
        camera: Camera {
            eye: Vec3::new(0.0, 1.05, 3.6),
            target: Vec3::new(0.0, 0.95, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 36.0,
        },
        lights: vec![Light::Point { position: Vec3::new(0.3, 2.1, 0.7) }],
        rays: RaySelection::default(),
        notes: vec![],
    }
}

/// Floor, ceiling, back wall and two side walls: 10 triangles.
fn room() -> Mesh {
    let mut b = Builder::new("room");
    let (low, high) = (DVec3::new(-1.1, -0.03, -1.1), DVec3::new(1.1, 2.2, 1.3));
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    b.material = 1;
    b.quad([
        p(low.x, low.y, high.z),
        p(high.x, low.y, high.z),
        p(high.x, low.y, low.z),
        p(low.x, low.y, low.z),
    ]);
    b.quad([
        p(low.x, high.y, low.z),
        p(high.x, high.y, low.z),
        p(high.x, high.y, high.z),
        p(low.x, high.y, high.z),
    ]);
    b.quad([
        p(low.x, low.y, low.z),
        p(high.x, low.y, low.z),
        p(high.x, high.y, low.z),
        p(low.x, high.y, low.z),
    ]);
    b.material = 2;
    b.quad([
        p(low.x, low.y, high.z),
        p(low.x, low.y, low.z),
        p(low.x, high.y, low.z),
        p(low.x, high.y, high.z),
    ]);
    b.material = 3;
    b.quad([
        p(high.x, low.y, low.z),
        p(high.x, low.y, high.z),
        p(high.x, high.y, high.z),
        p(high.x, high.y, low.z),
    ]);
    b.finish()
}

/// Limbs closer to each other than this are blended.
const BLEND: f64 = 0.03;

/// Positive outside the figure, negative inside; roughly the distance.
fn field(p: DVec3) -> f64 {
    let mut distance = f64::INFINITY;
    for (a, b, ra, rb) in BODY {
        let (a, b) = (DVec3::from_array(a), DVec3::from_array(b));
        let axis = b - a;
        let along = ((p - a).dot(axis) / axis.dot(axis)).clamp(0.0, 1.0);
        let off = p - (a + axis * along);
        let radius = ra + (rb - ra) * along;
        // A capsule this much farther than the nearest so far does not change the blend.
        let reach = distance + BLEND + radius;
        if reach > 0.0 && off.dot(off) > reach * reach {
            continue;
        }
        distance = smooth_min(distance, off.dot(off).sqrt() - radius, BLEND);
    }
    if distance.abs() > 0.05 {
        return distance;
    }
    distance + 0.008 * noise(p * 22.0, 1) + 0.0035 * noise(p * 61.0, 2) + 0.0012 * noise(p * 150.0, 3)
}

/// The smaller of two distances, blended by a quadratic where they differ by less than `width`.
fn smooth_min(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - overlap * overlap * width * 0.25
}

/// Paths from corner 0 to corner 7 of a cube (bit 0 is x, bit 1 y, bit 2 z), each with the sign of its orientation.
const TETRAHEDRA: [([usize; 4], bool); 6] = [
    ([0, 1, 3, 7], true),
    ([0, 1, 5, 7], false),
    ([0, 2, 3, 7], false),
    ([0, 2, 6, 7], true),
    ([0, 4, 5, 7], true),
    ([0, 4, 6, 7], false),
];

fn surface() -> Mesh {
    let [nx, ny, nz] = CELLS.map(|n| n + 1);
    let index = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
    let place = |i: usize| {
        let (x, y, z) = (i % nx, i / nx % ny, i / (nx * ny));
        ORIGIN + DVec3::new(x as f64, y as f64, z as f64) * CELL
    };
    let values: Vec<f64> = (0..nx * ny * nz).map(|i| field(place(i))).collect();
    let mut surface = Polygoniser { builder: Builder::new("figure"), crossings: HashMap::new() };
    for z in 0..CELLS[2] {
        for y in 0..CELLS[1] {
            for x in 0..CELLS[0] {
                let corner = |c: usize| index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
                let inside = (0..8).filter(|&c| values[corner(c)] < 0.0).count();
                if inside == 0 || inside == 8 {
                    continue;
                }
                for (tetrahedron, right_handed) in TETRAHEDRA {
                    surface.tetrahedron(tetrahedron.map(corner), right_handed, &values, place);
                }
            }
        }
    }
    surface.builder.finish()
}

struct Polygoniser {
    builder: Builder,
    /// The vertex on each grid edge that the surface crosses.
    crossings: HashMap<(usize, usize), u32>,
}

impl Polygoniser {
    /// Adds the triangles inside one tetrahedron, seen from outside in counter-clockwise order.
    fn tetrahedron(
        &mut self,
        corners: [usize; 4],
        right_handed: bool,
        values: &[f64],
        place: impl Fn(usize) -> DVec3,
    ) {
        let inside = corners.map(|c| values[c] < 0.0);
        let count = inside.iter().filter(|&&i| i).count();
        if count == 0 || count == 4 {
            return;
        }
        // Sorted so that the corners inside come first; an odd permutation mirrors the tetrahedron.
        let mut order = [0, 1, 2, 3];
        order.sort_by_key(|&k| !inside[k]);
        let inversions = (0..4)
            .flat_map(|i| (i + 1..4).map(move |j| (i, j)))
            .filter(|&(i, j)| order[i] > order[j])
            .count();
        let upright = right_handed == (inversions % 2 == 0);
        let c = order.map(|k| corners[k]);
        let mut cross = |a: usize, b: usize| self.crossing(c[a], c[b], values, &place);
        let polygon = match count {
            1 => vec![cross(0, 1), cross(0, 2), cross(0, 3)],
            2 => vec![cross(0, 2), cross(0, 3), cross(1, 3), cross(1, 2)],
            _ => vec![cross(0, 3), cross(1, 3), cross(2, 3)],
        };
        for i in 2..polygon.len() {
            let fan = [polygon[0], polygon[i - 1], polygon[i]];
            self.builder.triangle(if upright { fan } else { [fan[0], fan[2], fan[1]] });
        }
    }

    /// The vertex where the surface crosses the grid edge, kept off its ends so that no triangle collapses.
    fn crossing(&mut self, a: usize, b: usize, values: &[f64], place: &impl Fn(usize) -> DVec3) -> u32 {
        let (a, b) = (a.min(b), a.max(b));
        let builder = &mut self.builder;
        *self.crossings.entry((a, b)).or_insert_with(|| {
            let t = (values[a] / (values[a] - values[b])).clamp(0.05, 0.95);
            builder.vertex(place(a) + (place(b) - place(a)) * t)
        })
    }
}
