//! The Utah teapot: Martin Newell's 32 bicubic patches (1975; published by Crow, "The Origins of the Teapot", IEEE
//! CG&A 7(1), 1987), with the four later patches of the bottom, tessellated on a regular grid.
//!
//! Steps per patch side are a power of two, so that in f64 every boundary point is computed exactly and rounded once:
//! neighbouring patches then share their boundary bit for bit, in whichever direction each runs along it.
//! Lengths are Newell's units; y is up here, z in the original.

use super::builder::Builder;
use super::newell::{PATCHES, POINTS};
use crate::{Camera, Instance, Light, Material, Mesh, RaySelection, Scene};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Steps per patch side of the built-in scene: 32 * 2 * 16^2 triangles less 128 that would have no area.
const STEPS: u32 = 16;

pub(super) fn scene() -> Scene {
    Scene {
        name: "teapot".into(),
        meshes: vec![mesh(STEPS)],
        instances: vec![Instance::identity(0)],
        materials: vec![Material::matte("porcelain", Vec3::splat(0.7))],
        camera: Camera {
            eye: Vec3::new(4.2, 4.2, 8.8),
            target: Vec3::new(0.4, 1.4, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
        },
        lights: vec![Light::Point { position: Vec3::new(6.0, 9.0, 5.0) }],
        rays: RaySelection::default(),
        notes: vec![],
    }
}

/// The teapot with `steps` (a power of two) steps per patch side. Where patches meet, they share vertices; where a
/// patch side is a single point, the triangles without area are left out.
pub(super) fn mesh(steps: u32) -> Mesh {
    assert!(steps.is_power_of_two());
    let mut builder = Builder::new("teapot");
    let mut welded: HashMap<[u32; 3], u32> = HashMap::new();
    for patch in &PATCHES {
        let mut ids = Vec::with_capacity(((steps + 1) * (steps + 1)) as usize);
        for row in 0..=steps {
            for column in 0..=steps {
                let p = point(patch, f64::from(row) / f64::from(steps), f64::from(column) / f64::from(steps));
                // Adding 0 turns -0 into +0, so that equal points have equal bits.
                let p = DVec3::new(p.x, p.z, -p.y) + DVec3::ZERO;
                let key = [p.x, p.y, p.z].map(|v| (v as f32).to_bits());
                ids.push(*welded.entry(key).or_insert_with(|| builder.vertex(p)));
            }
        }
        for row in 0..steps {
            for column in 0..steps {
                let at = |r: u32, c: u32| ids[(r * (steps + 1) + c) as usize];
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [d, c] = [at(row + 1, column), at(row + 1, column + 1)];
                for corners in [[a, b, c], [a, c, d]] {
                    if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                        builder.triangle(corners);
                    }
                }
            }
        }
    }
    builder.finish()
}

/// The patch at (u, v), Bernstein form.
fn point(patch: &[u16; 16], u: f64, v: f64) -> DVec3 {
    let (bu, bv) = (bernstein(u), bernstein(v));
    let mut sum = DVec3::ZERO;
    for (i, &id) in patch.iter().enumerate() {
        let [x, y, z] = POINTS[id as usize].map(f64::from);
        let weight = bu[i / 4] * bv[i % 4];
        sum += DVec3::new(x * weight, y * weight, z * weight);
    }
    sum
}

fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
}
