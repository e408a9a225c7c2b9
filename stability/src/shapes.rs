//! Scenes that are hard in one way each. Vertices are rounded once, so that triangles which share one have the same bits.

use crate::random::Random;
use glam::{DVec3, Vec3};
use scenes::Triangle;
use std::f64::consts::TAU;

/// A closed sphere of `2 n` slices and `n` stacks.
pub(crate) fn sphere(centre: Vec3, radius: f64, n: usize) -> Vec<Triangle> {
    let slices = 2 * n;
    let vertex = |stack: usize, slice: usize| {
        let polar = 0.5 * TAU * stack as f64 / n as f64;
        let azimuth = TAU * (slice % slices) as f64 / slices as f64;
        // A pole is one point, whatever the sine of half a turn is.
        let ring = if stack.is_multiple_of(n) { 0.0 } else { polar.sin() };
        let unit = DVec3::new(ring * azimuth.cos(), polar.cos(), ring * azimuth.sin());
        (centre.as_dvec3() + radius * unit).as_vec3()
    };
    let mut triangles = Vec::new();
    for stack in 0..n {
        for slice in 0..slices {
            let [a, b] = [vertex(stack, slice), vertex(stack, slice + 1)];
            let [c, d] = [vertex(stack + 1, slice), vertex(stack + 1, slice + 1)];
            if stack > 0 {
                triangles.push(Triangle { v: [a, b, d] });
            }
            if stack + 1 < n {
                triangles.push(Triangle { v: [a, d, c] });
            }
        }
    }
    triangles
}

/// A closed cone of `sides` needles from a ring of `radius` around the origin to `apex`, with a fan as its base.
pub(crate) fn cone(apex: Vec3, radius: f64, sides: usize) -> Vec<Triangle> {
    let axis = apex.as_dvec3().normalize();
    let (x, y) = axis.any_orthonormal_pair();
    let ring = |side: usize| {
        let angle = TAU * (side % sides) as f64 / sides as f64;
        (radius * (x * angle.cos() + y * angle.sin())).as_vec3()
    };
    // The base lies a little behind the origin, which is then inside.
    let base = (-0.5 * radius * axis).as_vec3();
    (0..sides)
        .flat_map(|side| {
            let [a, b] = [ring(side), ring(side + 1)];
            [Triangle { v: [a, b, apex] }, Triangle { v: [b, a, base] }]
        })
        .collect()
}

/// Triangles of mixed size in the cube from -1 to 1.
pub(crate) fn soup(count: usize, seed: u64) -> Vec<Triangle> {
    let mut random = Random(seed);
    let triangle = |_| {
        let centre = random.point();
        let size = 0.5 * random.signed().abs().powi(3) + 1e-3;
        Triangle { v: [0; 3].map(|_| centre + size * random.point()) }
    };
    (0..count).map(triangle).collect()
}

/// Faces of `n` by `n` unit quads across a cube at integer coordinates, three on each axis: shared edges, coplanar neighbours, splits
/// at vertices.
pub(crate) fn lattice(n: i32) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for level in [0, n / 2, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let corner = |di: i32, dj: i32| {
                    let mut p = Vec3::splat(level as f32);
                    p[(axis + 1) % 3] = (i + di) as f32;
                    p[(axis + 2) % 3] = (j + dj) as f32;
                    p
                };
                triangles.push(Triangle { v: [corner(0, 0), corner(1, 0), corner(1, 1)] });
                triangles.push(Triangle { v: [corner(0, 0), corner(1, 1), corner(0, 1)] });
            }
        }
    }
    triangles
}

/// Triangles of one plane, z = 1, that all hold the point (0.3, 0.3).
pub(crate) fn coplanar(count: usize) -> Vec<Triangle> {
    let layer = |i: usize| {
        let wide = 1.0 + i as f32 / count as f32;
        Triangle { v: [Vec3::Z, Vec3::new(wide, 0.0, 1.0), Vec3::new(0.0, wide, 1.0)] }
    };
    (0..count).map(layer).collect()
}

/// Parallel triangles at neighbouring floats from z = 1 on.
pub(crate) fn layers(count: usize) -> Vec<Triangle> {
    let layer = |i: usize| {
        let z = f32::from_bits(1.0_f32.to_bits() + i as u32);
        Triangle { v: [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)] }
    };
    (0..count).map(layer).collect()
}

/// Triangles that halve in size towards the origin: each split takes one off, so trees become as deep as they may.
pub(crate) fn nested(count: i32) -> Vec<Triangle> {
    let triangle = |i: i32| {
        let s = 2.0_f32.powi(i - count / 2);
        Triangle { v: [Vec3::new(s, 0.0, 0.0), Vec3::new(s, s, 0.0), Vec3::new(s, 0.0, s)] }
    };
    (0..count).map(triangle).collect()
}

/// Smallest and largest coordinates.
pub(crate) fn bounds(triangles: &[Triangle]) -> (Vec3, Vec3) {
    let corners = || triangles.iter().flat_map(|triangle| triangle.v);
    (corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max))
}

/// The same triangles, every coordinate times a power of two, which is exact.
pub(crate) fn scaled(triangles: &[Triangle], factor: f32) -> Vec<Triangle> {
    triangles.iter().map(|triangle| Triangle { v: triangle.v.map(|corner| corner * factor) }).collect()
}
