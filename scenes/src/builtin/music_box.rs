//! An open music box: a cylinder with pins, a comb, a spring barrel and a train of gears in a lacquered case with a mirror
//! in its lid. Stands in for Music box of Lee et al. 2017 (106 K triangles), which is not available.
//!
//! Centimetres; the table is y = 0, the cylinder turns about x. Brass and steel are polished and the mirror is one; the
//! case is glossy with lacquer; its lining and the table are matte.

use super::builder::Builder;
use super::numeric::{SplitMix64, sin_cos};
use super::shapes::{Place, smooth};
use crate::{Camera, Instance, Light, Material, RaySelection, Reflection, Scene};
use glam::{DVec3, Vec3};

const SEED: u64 = 0xb0c5_0001;

const TABLE: u32 = 0;
const WOOD: u32 = 1;
const LINING: u32 = 2;
const BRASS: u32 = 3;
const STEEL: u32 = 4;
const MIRROR: u32 = 5;

/// Half the width and depth of the case, and its height.
const CASE: [f64; 2] = [14.0, 9.5];
const RIM: f64 = 9.0;
/// Height of the lining, and of the plate on it that carries the movement.
const FLOOR: f64 = 1.8;
const PLATE: f64 = 2.4;
/// The cylinder: its axis over z = 0, radius, and half its length.
const AXIS: f64 = 6.0;
const RADIUS: f64 = 2.2;
const HALF: f64 = 6.6;
/// Teeth of the comb, and pins that pluck each in a turn.
const TEETH: u32 = 66;
const PINS: u32 = 39;
const PIN: f64 = 0.11;

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("music-box");
    let mut random = SplitMix64(SEED);
    b.material = TABLE;
    b.backdrop(120.0, [60.0, -60.0], 80.0);
    case(&mut b);
    lid(&mut b);
    cylinder(&mut b);
    pins(&mut b, &mut random);
    comb(&mut b);
    train(&mut b);
    barrel(&mut b);
    let metal = |name, diffuse| Material {
        specular: diffuse,
        roughness: 0.0,
        reflection: Reflection::Mirror,
        ..Material::matte(name, diffuse)
    };
    Scene {
        name: "music-box".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("table", Vec3::new(0.35, 0.38, 0.36)),
            Material {
                specular: Vec3::splat(0.04),
                roughness: 0.2,
                ..Material::matte("lacquered wood", Vec3::new(0.3, 0.1, 0.04))
            },
            Material::matte("velvet", Vec3::new(0.25, 0.02, 0.05)),
            metal("brass", Vec3::new(0.7, 0.5, 0.18)),
            metal("steel", Vec3::splat(0.55)),
            metal("mirror", Vec3::splat(0.35)),
        ],
        camera: Camera {
            eye: Vec3::new(8.0, 29.0, 28.0),
            target: Vec3::new(0.2, 7.2, -1.5),
            up: Vec3::Y,
            vertical_fov_degrees: 32.0,
        },
        lights: vec![
            Light::Point { position: Vec3::new(-35.0, 60.0, 30.0) },
            Light::Point { position: Vec3::new(40.0, 45.0, 35.0) },
        ],
        rays: RaySelection { mirror: true, glossy: true, ..RaySelection::default() },
        notes: vec![],
    }
}

/// A profile `(beyond the edge, height)` carried around a rectangle with round corners.
fn frame(b: &mut Builder, place: &Place, [x, z]: [f64; 2], profile: &[(f64, f64)]) {
    let (sides, corner) = (48, 0.8);
    b.skin(sides, profile.len() as u32, |ring, turns| {
        let (out, height) = profile[ring as usize];
        // Half a side on, so that no point is in the middle of an edge.
        let (s, c) = sin_cos(turns + 0.5 / f64::from(sides));
        let along = |half: f64, part: f64| (half - corner).copysign(part) + (corner + out) * part;
        place.at(along(x, c), height, along(z, s))
    });
}

fn case(b: &mut Builder) {
    let place = Place::upright(DVec3::ZERO);
    b.material = WOOD;
    let outside =
        [(-0.3, 0.6), (0.5, 0.6), (0.55, 1.2), (0.4, 1.7), (0.05, 2.0), (0.0, 2.3), (0.0, 8.4), (0.15, 8.6)];
    let rim = [(0.15, 8.8), (0.0, RIM), (-0.6, RIM), (-0.7, 8.9), (-0.7, 8.5)];
    frame(b, &place, CASE, &[smooth(&outside, 2), rim.to_vec()].concat());
    b.material = LINING;
    frame(b, &place, CASE, &[(-0.72, 8.5), (-0.74, FLOOR + 0.3), (-0.79, FLOOR)]);
    let (x, z) = (CASE[0] - 0.7, CASE[1] - 0.7);
    b.quad([(-x, z), (x, z), (x, -z), (-x, -z)].map(|(x, z)| DVec3::new(x, FLOOR, z)));
    b.material = BRASS;
    let (x, z) = (12.4, 7.0);
    b.cuboid(DVec3::new(-x, FLOOR, -z), DVec3::new(x, PLATE, z));
    for (sx, sz) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        screw(b, DVec3::new(sx * (x - 0.7), PLATE, sz * (z - 0.7)));
        b.material = WOOD;
        let foot = smooth(&[(0.6, 0.0), (1.3, 0.15), (1.4, 0.45), (0.9, 0.65)], 3);
        b.turn(&Place::upright(DVec3::new(sx * 12.8, 0.0, sz * 8.3)), 32, &foot);
    }
}

/// The lid leans back, its upper side behind; a mirror is let into the lower one.
fn lid(b: &mut Builder) {
    let place = Place::along(DVec3::new(0.0, RIM + 9.5, -CASE[1] - 1.3), DVec3::new(0.0, -0.1, -1.0));
    b.material = WOOD;
    let inner = [(-1.6, 0.25), (-1.4, 0.0), (-0.4, 0.0), (0.0, 0.0)];
    let outer = [(0.15, 0.15), (0.15, 0.8), (0.0, 1.0), (-0.6, 1.15), (-1.0, 1.6), (-1.8, 1.8)];
    frame(b, &place, CASE, &[&inner[..], &smooth(&outer, 3)].concat());
    let face = |half: [f64; 2], height: f64| {
        [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(u, v)| place.at(u * half[0], height, v * half[1]))
    };
    let panel = CASE.map(|half| half - 1.6);
    b.quad(face(panel, 1.8));
    b.material = MIRROR;
    b.quad(face(panel, 0.24));
}

/// A screw with a countersunk edge and a slot.
fn screw(b: &mut Builder, foot: DVec3) {
    b.material = STEEL;
    let head = [(0.42, 0.0), (0.42, 0.14), (0.36, 0.2), (0.3, 0.21), (0.0, 0.21)];
    b.turn(&Place::upright(foot), 24, &head);
    b.cuboid(foot + DVec3::new(-0.28, 0.21, -0.04), foot + DVec3::new(0.28, 0.215, 0.04));
}

fn cylinder(b: &mut Builder) {
    let place = Place::along(DVec3::new(0.0, AXIS, 0.0), DVec3::X);
    b.material = BRASS;
    let ends = [
        (0.0, -HALF),
        (0.5, -HALF),
        (0.55, -HALF + 0.25),
        (1.9, -HALF + 0.25),
        (2.0, -HALF),
        (RADIUS, -HALF + 0.05),
    ];
    let other = ends.iter().rev().map(|&(r, x)| (r, -x));
    let profile: Vec<(f64, f64)> = ends.iter().copied().chain(other).collect();
    b.turn(&place, 96, &profile);
    b.material = STEEL;
    b.turn(&place, 24, &[(0.0, -11.2), (0.3, -11.2), (0.3, 10.6), (0.0, 10.6)]);
}

fn tooth_x(tooth: u32) -> f64 {
    (f64::from(tooth) + 0.5) / f64::from(TEETH) * 2.0 * (HALF - 0.4) - (HALF - 0.4)
}

/// Pins stand out of the cylinder under each tooth, at times drawn at random but never two at once.
fn pins(b: &mut Builder, random: &mut SplitMix64) {
    b.material = STEEL;
    for tooth in 0..TEETH {
        for pin in 0..PINS {
            let (s, c) = sin_cos((f64::from(pin) + random.between(0.1, 0.9)) / f64::from(PINS));
            let out = DVec3::new(0.0, s, c);
            let root = DVec3::new(tooth_x(tooth), AXIS, 0.0) + out * (RADIUS - 0.01);
            b.turn(&Place::along(root, out), 6, &[(0.035, 0.0), (0.035, PIN), (0.0, PIN + 0.03)]);
        }
    }
}

/// Steel teeth from the front to just short of the pins, shorter towards the treble, on a foot with screws.
fn comb(b: &mut Builder) {
    b.material = STEEL;
    let (tip, root) = (RADIUS + PIN + 0.08, 5.6);
    let width = (HALF - 0.4) / f64::from(TEETH) * 0.62;
    b.cuboid(DVec3::new(-HALF, AXIS - 0.35, root), DVec3::new(HALF, AXIS + 0.15, root + 1.2));
    for tooth in 0..TEETH {
        let x = tooth_x(tooth);
        let start = root - 0.05 - 1.1 * f64::from(tooth) / f64::from(TEETH);
        b.cuboid(DVec3::new(x - width, AXIS - 0.3, start), DVec3::new(x + width, AXIS + 0.14, root));
        // Four corners around, thin in the middle and thicker at the tip.
        let shape: [(f64, f64); 5] =
            [(start, 0.11), (start - 0.6, 0.05), (tip + 0.5, 0.05), (tip + 0.1, 0.1), (tip, 0.03)];
        b.skin(4, shape.len() as u32, |ring, turns| {
            let (z, thick) = shape[ring as usize];
            let (s, c) = sin_cos(turns + 0.125);
            DVec3::new(x - width.copysign(c), AXIS + 0.03 + thick.copysign(s), z)
        });
    }
    b.material = BRASS;
    b.cuboid(DVec3::new(-HALF, PLATE, root + 0.1), DVec3::new(HALF, AXIS - 0.35, root + 1.1));
    for i in 0..5 {
        screw(b, DVec3::new(f64::from(i - 2) * 2.9, AXIS + 0.15, root + 0.6));
    }
}

/// A wheel with trapezoidal teeth and a hole, between 0 and `thickness` along the axis of `place`.
fn gear(b: &mut Builder, place: &Place, teeth: u32, radius: f64, thickness: f64) {
    let (depth, hole) = (radius * 3.2 / f64::from(teeth), radius * 0.12);
    let sides = teeth * 6;
    // Inner edge, web, rim, teeth and back: (radius, height), and whether the teeth move it.
    let (web, rim) = (radius * 0.3, radius - 2.5 * depth);
    let half = [(hole, 1.0), (web, 1.0), (web + 0.04, 0.75), (rim - 0.04, 0.75), (rim, 1.0), (radius, 1.0)];
    let lower = half.map(|(r, h)| (r, (1.0 - h) * thickness));
    let upper = half.map(|(r, h)| (r, h * thickness));
    let profile: Vec<(f64, f64)> =
        lower.into_iter().chain(upper.into_iter().rev()).chain([lower[0]]).collect();
    b.skin(sides, profile.len() as u32, |ring, turns| {
        let (mut r, height) = profile[ring as usize];
        if r == radius {
            let step = (turns * f64::from(sides)).round() as u32 % 6;
            r += if matches!(step, 1 | 2) {
                depth
            } else if matches!(step, 0 | 3) {
                0.3 * depth
            } else {
                -depth
            };
        }
        let (s, c) = sin_cos(turns);
        place.at(r * c, height, r * s)
    });
}

/// From the wheel on the cylinder over two pinions to the air brake, between two plates at the right.
fn train(b: &mut Builder) {
    let along = |x: f64, y: f64, z: f64| Place::along(DVec3::new(x, y, z), DVec3::X);
    b.material = BRASS;
    gear(b, &along(7.4, AXIS, 0.0), 56, 2.6, 0.4);
    gear(b, &along(8.3, 5.2, -3.25), 48, 2.0, 0.3);
    gear(b, &along(9.2, 6.4, -5.7), 36, 1.3, 0.25);
    for x in [-8.0, 10.0] {
        b.cuboid(DVec3::new(x, PLATE, -6.6), DVec3::new(x + 0.4, AXIS + 1.2, -2.6));
        b.cuboid(DVec3::new(x, PLATE, -1.0), DVec3::new(x + 0.4, AXIS + 0.8, 1.0));
    }
    b.material = STEEL;
    gear(b, &along(7.3, 5.2, -3.25), 14, 0.62, 0.7);
    gear(b, &along(8.2, 6.4, -5.7), 12, 0.5, 0.6);
    for (y, z) in [(5.2, -3.25), (6.4, -5.7)] {
        b.turn(&along(6.9, y, z), 20, &[(0.0, 0.0), (0.14, 0.0), (0.14, 3.6), (0.0, 3.6)]);
    }
    // The brake: a worm with two vanes.
    let worm = DVec3::new(9.4, PLATE, -4.1);
    let turns = 9.0;
    b.skin(24, 121, |ring, around| {
        let v = f64::from(ring) / 120.0;
        let (s, c) = sin_cos(around);
        let thread = sin_cos(around - v * turns).0;
        let radius = 0.22 + 0.06 * thread;
        worm + DVec3::new(radius * c, 1.2 + 3.0 * v, radius * s)
    });
    b.turn(&Place::upright(worm), 20, &[(0.1, 0.0), (0.1, 6.3), (0.0, 6.4)]);
    b.material = BRASS;
    b.cuboid(worm + DVec3::new(-1.2, 4.9, -0.03), worm + DVec3::new(1.2, 6.0, 0.03));
}

/// The spring's barrel at the left, with a wheel and turned grooves.
fn barrel(b: &mut Builder) {
    let place = Place::along(DVec3::new(-11.6, AXIS - 0.4, -1.5), DVec3::X);
    b.material = BRASS;
    let mut profile = vec![(0.0, 0.5), (0.4, 0.5), (0.5, 0.6)];
    for groove in 0..6 {
        let r = 0.6 + 0.3 * f64::from(groove);
        profile.extend([(r, 0.6), (r + 0.08, 0.52), (r + 0.2, 0.52), (r + 0.28, 0.6)]);
    }
    profile.extend(smooth(&[(2.42, 0.65), (2.5, 0.8), (2.5, 2.6), (2.42, 2.75), (2.2, 2.8)], 2));
    profile.extend([(0.4, 2.8), (0.0, 2.8)]);
    b.turn(&place, 80, &profile);
    gear(b, &Place::along(DVec3::new(-8.8, AXIS - 0.4, -1.5), DVec3::X), 60, 2.75, 0.35);
    // A key of steel over it.
    b.material = STEEL;
    let stem = DVec3::new(-10.2, AXIS + 2.1, -1.5);
    b.turn(
        &Place::upright(stem),
        32,
        &smooth(&[(0.5, 0.0), (0.3, 0.3), (0.25, 1.0), (0.35, 1.3), (0.0, 1.5)], 3),
    );
    for side in [-1.0, 1.0] {
        let loop_of = |i: u32| {
            let (s, c) = sin_cos(f64::from(i) / 24.0 * 0.96 + 0.52);
            stem + DVec3::new(side * (0.85 + 0.65 * c), 1.5 + 0.5 * s, 0.0)
        };
        let path: Vec<DVec3> = (0..=24).map(loop_of).collect();
        b.pipe(&path, 0.13, 12);
    }
}
