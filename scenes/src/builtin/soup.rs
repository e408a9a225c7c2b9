//! Adversarial triangles, all finite: what breaks builders and intersectors.
//!
//! Slivers, duplicates, coplanar stacks, triangles without area, tiny ones far from the origin, and a few so large
//! that the surface area of the scene only just fits into f32. Seeded.

use super::builder::Builder;
use super::numeric::SplitMix64;
use crate::{Camera, Instance, Light, Material, Note, RaySelection, Scene};
use glam::{DVec3, Vec3};

pub(super) const SEED: u64 = 0x5eed_0f50;

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("soup");
    let mut random = SplitMix64(SEED);
    ordinary(&mut b, &mut random);
    slivers(&mut b, &mut random);
    duplicates(&mut b, &mut random);
    coplanar_stacks(&mut b, &mut random);
    without_area(&mut b, &mut random);
    tiny(&mut b, &mut random);
    huge(&mut b);
    Scene {
        name: "soup".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![Material::matte("soup", Vec3::splat(0.5))],
        camera: Camera {
            eye: Vec3::new(1.5, 2.5, 5.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
        },
        lights: vec![Light::Point { position: Vec3::new(4.0, 6.0, 3.0) }],
        rays: RaySelection::default(),
        notes: vec![Note::Found(
            "Holds triangles without area, exact duplicates and coplanar stacks on purpose.".into(),
        )],
    }
}

fn around(random: &mut SplitMix64, centre: DVec3, size: f64) -> [DVec3; 3] {
    [(); 3].map(|()| centre + random.in_cube() * size)
}

fn ordinary(b: &mut Builder, random: &mut SplitMix64) {
    for _ in 0..3000 {
        let centre = random.in_cube();
        b.loose_triangle(around(random, centre, 0.08));
    }
}

/// Length up to 2 along any direction, width from 1e-3 down to 1e-9.
fn slivers(b: &mut Builder, random: &mut SplitMix64) {
    let mut width = 1e-3;
    for i in 0..2000 {
        let (from, to) = (random.in_cube(), random.in_cube());
        b.loose_triangle([from, to, to + random.in_cube() * width]);
        width = if i % 7 == 6 { 1e-3 } else { width * 0.1 };
    }
}

/// Each triangle 1 to 8 times, with its corners rotated or mirrored.
fn duplicates(b: &mut Builder, random: &mut SplitMix64) {
    for i in 0..500 {
        let centre = random.in_cube();
        let [p, q, r] = around(random, centre, 0.1);
        for copy in 0..=i % 8 {
            b.loose_triangle([[p, q, r], [q, r, p], [r, q, p]][copy % 3]);
        }
    }
}

/// Overlapping triangles in one axis-parallel plane; every fourth stack one f32 step apart.
fn coplanar_stacks(b: &mut Builder, random: &mut SplitMix64) {
    for stack in 0..40 {
        let plane = f64::from(random.between(-1.0, 1.0) as f32);
        for layer in 0..50 {
            let step = if stack % 4 == 3 { f64::from(layer) * f64::from(f32::EPSILON) } else { 0.0 };
            let flat = |random: &mut SplitMix64| {
                let (s, t) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
                match stack % 3 {
                    0 => DVec3::new(plane + step, s, t),
                    1 => DVec3::new(s, plane + step, t),
                    _ => DVec3::new(s, t, plane + step),
                }
            };
            b.loose_triangle([flat(random), flat(random), flat(random)]);
        }
    }
}

/// Points, doubled corners, and corners on a line (with integer coordinates, so exactly).
fn without_area(b: &mut Builder, random: &mut SplitMix64) {
    for i in 0..600 {
        let (p, q) = (random.in_cube(), random.in_cube());
        let whole = |v: DVec3| (v * 8.0).floor() / 8.0;
        b.loose_triangle(match i % 3 {
            0 => [p, p, p],
            1 => [p, q, q],
            _ => [whole(p), whole(p) + whole(q), whole(p) + whole(q) * 2.0],
        });
    }
}

/// From 1e-2 down to subnormal size at the origin, and a few f32 steps wide far away.
fn tiny(b: &mut Builder, random: &mut SplitMix64) {
    let mut size = 1e-2;
    for _ in 0..400 {
        b.loose_triangle(around(random, DVec3::ZERO, size));
        size = if size < 1e-40 { 1e-2 } else { size * 0.1 };
    }
    for _ in 0..400 {
        let centre = DVec3::splat(100.0) + random.in_cube();
        b.loose_triangle(around(random, centre, 3e-5));
    }
}

/// Four walls around everything at 1e6, a floor at 1e9, and one triangle at 1e18.
fn huge(b: &mut Builder) {
    let p = DVec3::new;
    let far = 1e6;
    for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        let (a, c) = (p(x * far, -far, z * far), p(-z * far, far, x * far));
        b.quad([a, p(-z * far, -far, x * far), c, p(x * far, far, z * far)]);
    }
    b.quad([p(-1e9, -2e6, -1e9), p(-1e9, -2e6, 1e9), p(1e9, -2e6, 1e9), p(1e9, -2e6, -1e9)]);
    b.loose_triangle([p(-1e18, -1e18, -1e18), p(1e18, -1e18, -1e18), p(0.0, -1e18, 1e18)]);
}
