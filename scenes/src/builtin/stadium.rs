//! A teapot in a stadium: the classic name for a small dense object in a large sparse one, which regular grids and
//! badly placed splits handle poorly. Stands in for Fairy Forest (174,117 triangles), which is not freely available.
//!
//! Metres; the teapot is 6 wide and stands in the middle of an oval bowl 200 long, with tiers, seats and a pitch.

use super::builder::Builder;
use super::numeric::{noise, sin_cos};
use super::teapot;
use crate::{Camera, Instance, Light, Material, RaySelection, Scene};
use glam::{DVec3, Vec3};

/// Steps per teapot patch: 65,280 triangles, more than a third of all in a thousandth of the ground.
const TEAPOT_STEPS: u32 = 32;
const TIERS: u32 = 24;
const SEGMENTS: u32 = 256;

pub(super) fn scene() -> Scene {
    let mut teapot = teapot::mesh(TEAPOT_STEPS);
    teapot.materials.fill(0);
    Scene {
        name: "stadium".into(),
        meshes: vec![teapot, ground(), stands()],
        instances: (0..3).map(Instance::identity).collect(),
        materials: vec![
            Material::matte("porcelain", Vec3::splat(0.7)),
            Material::matte("grass", Vec3::new(0.2, 0.45, 0.15)),
            Material::matte("concrete", Vec3::splat(0.5)),
            Material::matte("seat", Vec3::new(0.1, 0.2, 0.6)),
        ],
        camera: Camera {
            eye: Vec3::new(7.0, 4.2, 10.0),
            target: Vec3::new(0.0, 2.2, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 50.0,
        },
        lights: vec![Light::Point { position: Vec3::new(40.0, 60.0, 30.0) }],
        rays: RaySelection::default(),
        notes: vec![],
    }
}

/// Half lengths of the inner edge of the bowl.
const PITCH: DVec3 = DVec3::new(60.0, 0.0, 40.0);

fn on_oval(turns: f64, outwards: f64, height: f64) -> DVec3 {
    let (s, c) = sin_cos(turns);
    DVec3::new((PITCH.x + outwards) * c, height, (PITCH.z + outwards) * s)
}

/// The pitch, slightly uneven: 22,400 triangles.
fn ground() -> crate::Mesh {
    let mut b = Builder::new("ground");
    b.material = 1;
    b.grid(140, 80, |u, v| {
        let p = DVec3::new((u * 2.0 - 1.0) * 62.0, 0.0, (1.0 - v * 2.0) * 42.0);
        p + DVec3::Y * (0.05 * noise(p * 0.7, 11) - 0.06)
    });
    b.finish()
}

/// Rising tiers, each a riser and a tread, and a seat per segment: 24,576 + 61,440 triangles.
fn stands() -> crate::Mesh {
    let mut b = Builder::new("stands");
    for tier in 0..TIERS {
        let (depth, height) = (f64::from(tier) * 1.5, 1.0 + f64::from(tier) * 0.9);
        b.material = 2;
        b.grid(SEGMENTS, 1, |u, v| on_oval(u, depth, height + (v - 1.0) * 0.9));
        b.grid(SEGMENTS, 1, |u, v| on_oval(u, depth + v * 1.5, height));
        b.material = 3;
        for segment in 0..SEGMENTS {
            seat(&mut b, (f64::from(segment) + 0.5) / f64::from(SEGMENTS), depth, height);
        }
    }
    b.finish()
}

/// A box without a bottom, turned towards the pitch: 10 triangles.
fn seat(b: &mut Builder, turns: f64, depth: f64, height: f64) {
    let width = 0.25 / f64::from(SEGMENTS);
    let corner = |side: f64, out: f64, up: f64| on_oval(turns + side * width, depth + out, height + up);
    let foot = [(-1.0, 0.5), (1.0, 0.5), (1.0, 1.0), (-1.0, 1.0)];
    b.quad(foot.map(|(side, out)| corner(side, out, 0.45)));
    for i in 0..4 {
        let ((s0, o0), (s1, o1)) = (foot[i], foot[(i + 1) % 4]);
        b.quad([corner(s0, o0, 0.0), corner(s1, o1, 0.0), corner(s1, o1, 0.45), corner(s0, o0, 0.45)]);
    }
}
