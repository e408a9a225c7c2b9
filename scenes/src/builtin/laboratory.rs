//! A chemist's bench: flasks, beakers, cylinders and tubes with what is in them, a rack, a stand and a shelf of bottles.
//! Stands in for Chemical Lab of Lee et al. 2017 (98 K triangles), which is not available.
//!
//! Centimetres; the top of the bench is y = 0. Vessels are closed bodies of glass with an inner and an outer wall, and
//! liquids closed bodies within. The bench is of sealed epoxy and the tiles behind it are glazed, both glossy; steel is
//! polished, the rest matte.

use super::builder::Builder;
use super::numeric::{SplitMix64, sin_cos};
use super::shapes::{Place, interpolated, smooth};
use crate::{Camera, Instance, Light, Material, RaySelection, Reflection, Scene};
use glam::{DVec3, Vec3};

const SEED: u64 = 0x1ab_0001;

const WALL: u32 = 0;
const BENCH: u32 = 1;
const GLASS: u32 = 2;
const STEEL: u32 = 3;
const WOOD: u32 = 4;
const RUBBER: u32 = 5;
const LABEL: u32 = 6;
const BROWN_GLASS: u32 = 7;
/// The first of four liquids.
const LIQUID: u32 = 8;

/// Thickness of glass, and what a liquid keeps from it.
const THICKNESS: f64 = 0.2;
const GAP: f64 = 0.02;

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("laboratory");
    let mut random = SplitMix64(SEED);
    room(&mut b);
    glassware(&mut b);
    rack(&mut b, DVec3::new(-14.0, 0.0, 9.0));
    stand(&mut b, DVec3::new(3.0, 0.0, -9.0));
    shelf(&mut b, &mut random);
    let specular = |roughness, material| Material { specular: Vec3::splat(0.04), roughness, ..material };
    let glass = |name, diffuse| Material {
        reflection: Reflection::Glass,
        ..specular(0.0, Material::matte(name, diffuse))
    };
    Scene {
        name: "laboratory".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            specular(0.2, Material::matte("tile", Vec3::new(0.55, 0.6, 0.58))),
            specular(0.3, Material::matte("bench", Vec3::new(0.1, 0.11, 0.12))),
            glass("glass", Vec3::new(0.45, 0.58, 0.6)),
            Material {
                reflection: Reflection::Mirror,
                ..specular(0.0, Material::matte("steel", Vec3::splat(0.5)))
            },
            Material::matte("wood", Vec3::new(0.5, 0.34, 0.18)),
            Material::matte("rubber", Vec3::new(0.25, 0.08, 0.05)),
            Material::matte("label", Vec3::new(0.8, 0.78, 0.7)),
            glass("brown glass", Vec3::new(0.25, 0.1, 0.03)),
            glass("copper sulphate", Vec3::new(0.05, 0.25, 0.7)),
            glass("permanganate", Vec3::new(0.4, 0.02, 0.3)),
            glass("chromate", Vec3::new(0.8, 0.55, 0.02)),
            glass("nickel sulphate", Vec3::new(0.05, 0.5, 0.2)),
        ],
        camera: Camera {
            eye: Vec3::new(-9.0, 25.0, 64.0),
            target: Vec3::new(0.0, 14.0, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 34.0,
        },
        lights: vec![
            Light::Point { position: Vec3::new(-50.0, 80.0, 60.0) },
            Light::Point { position: Vec3::new(45.0, 70.0, 25.0) },
        ],
        rays: RaySelection { mirror: true, glossy: true, ..RaySelection::default() },
        notes: vec![],
    }
}

/// The bench, and glazed tiles behind it.
fn room(b: &mut Builder) {
    b.material = BENCH;
    b.cuboid(DVec3::new(-110.0, -4.0, -30.0), DVec3::new(110.0, 0.0, 45.0));
    b.material = WALL;
    let (size, joint) = (10.0, 0.15);
    for row in 0..7 {
        for column in -11..11 {
            let (x, y) = (f64::from(column) * size, f64::from(row) * size);
            let rim = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let at = |inset: f64, z: f64| {
                rim.map(|(u, v)| {
                    DVec3::new(
                        x + u * size + inset * (1.0 - 2.0 * u),
                        y + v * size + inset * (1.0 - 2.0 * v),
                        z,
                    )
                })
            };
            let (back, front) = (at(joint, -29.0), at(2.0 * joint, -28.7));
            b.quad(front);
            for i in 0..4 {
                b.quad([back[i], back[(i + 1) % 4], front[(i + 1) % 4], front[i]]);
            }
        }
    }
    b.quad(
        [(-110.0, 0.0), (110.0, 0.0), (110.0, 70.0), (-110.0, 70.0)].map(|(x, y)| DVec3::new(x, y, -29.0)),
    );
}

/// A closed vessel: `outer` is its outside (radius, height) from the middle of its foot to its rim, the inside keeps
/// [`THICKNESS`] from it.
fn vessel(b: &mut Builder, place: &Place, sides: u32, outer: &[(f64, f64)]) {
    let mut profile = outer.to_vec();
    let (rim_radius, rim) = outer[outer.len() - 1];
    profile.push((rim_radius - 0.5 * THICKNESS, rim + 0.5 * THICKNESS));
    profile.extend(inside(outer, THICKNESS).into_iter().rev());
    b.turn(place, sides, &profile);
}

/// `outer` moved inwards by `gap`, from the foot to the rim.
fn inside(outer: &[(f64, f64)], gap: f64) -> Vec<(f64, f64)> {
    let floor = outer[0].1 + gap;
    let moved = outer.iter().map(|&(radius, height)| ((radius - gap).max(0.0), height.max(floor)));
    let mut moved: Vec<(f64, f64)> = moved.collect();
    // The flat of the foot: only its rim and its middle are left.
    let wall = moved.iter().position(|&(_, height)| height > floor).unwrap_or(1);
    moved.drain(1..wall.saturating_sub(1).max(1));
    moved
}

/// A closed body of liquid in a vessel, filled up to `level`.
fn liquid(b: &mut Builder, place: &Place, sides: u32, outer: &[(f64, f64)], level: f64) {
    let walls = inside(outer, THICKNESS + GAP);
    let mut profile: Vec<(f64, f64)> = walls.iter().copied().filter(|&(_, height)| height < level).collect();
    let by_height: Vec<(f64, f64)> = walls[1..].iter().map(|&(radius, height)| (height, radius)).collect();
    profile.extend([(interpolated(&by_height, level), level), (0.0, level)]);
    b.turn(place, sides, &profile);
}

fn beaker(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let foot = [(0.0, 0.0), (radius - 0.6, 0.0), (radius - 0.15, 0.15), (radius, 0.6)];
    let wall = [
        (radius, 0.5 * height),
        (radius, height - 0.5),
        (radius + 0.15, height - 0.15),
        (radius + 0.35, height),
    ];
    [&foot[..], &wall].concat()
}

fn erlenmeyer(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let neck = 0.33 * radius;
    let mut profile = vec![(0.0, 0.0), (radius - 0.7, 0.0)];
    profile.extend(smooth(
        &[
            (radius - 0.2, 0.15),
            (radius, 0.7),
            (neck + 0.5, 0.68 * height),
            (neck, 0.76 * height),
            (neck, 0.95 * height),
        ],
        4,
    ));
    profile.extend([(neck + 0.15, 0.97 * height), (neck + 0.35, height)]);
    profile
}

/// A bulb with a neck; its middle is `radius` above its foot.
fn round_flask(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let neck = 0.3 * radius;
    let mut profile = vec![(0.0, 0.0)];
    for step in 1..=20 {
        let (s, c) = sin_cos(f64::from(step) / 48.0 - 0.25);
        profile.push((radius * c, radius * (1.0 + s)));
    }
    profile.extend(smooth(&[(0.5 * radius, 1.87 * radius), (neck, 2.1 * radius), (neck, height - 0.4)], 4));
    profile.push((neck + 0.3, height));
    profile
}

fn cylinder(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let foot = [(0.0, 0.0), (radius + 1.2, 0.0), (radius + 1.2, 0.5), (radius + 0.2, 1.0), (radius, 1.4)];
    let wall = [(radius, 0.5 * height), (radius, height - 0.3), (radius + 0.25, height)];
    [&foot[..], &wall].concat()
}

fn bottle(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let neck = 0.4 * radius;
    let mut profile = vec![(0.0, 0.0), (radius - 0.5, 0.0), (radius - 0.1, 0.12), (radius, 0.6)];
    let shoulder = [(radius, 0.62), (0.8 * radius, 0.75), (neck, 0.82), (neck, 0.96)];
    profile.extend(smooth(&shoulder.map(|(r, h)| (r, h * height)), 3));
    profile.push((neck + 0.2, height));
    profile
}

/// What stands on the bench.
fn glassware(b: &mut Builder) {
    let on_bench = |x: f64, z: f64| Place::upright(DVec3::new(x, 0.0, z));
    let mut fill = |place: Place, outer: &[(f64, f64)], level: f64, colour: u32| {
        b.material = GLASS;
        vessel(b, &place, 64, outer);
        if level > 0.0 {
            b.material = LIQUID + colour;
            liquid(b, &place, 64, outer, level);
        }
    };
    fill(on_bench(-25.0, -4.0), &erlenmeyer(6.5, 16.0), 5.0, 0);
    fill(on_bench(15.0, 10.0), &erlenmeyer(4.5, 11.0), 4.0, 1);
    fill(on_bench(29.0, -1.0), &erlenmeyer(5.5, 14.0), 6.5, 3);
    fill(on_bench(21.9, -9.0), &cylinder(2.0, 24.0), 15.0, 2);
    fill(on_bench(-33.0, 5.0), &cylinder(1.6, 19.0), 9.0, 3);
    fill(on_bench(24.5, 11.0), &beaker(3.4, 8.0), 3.5, 2);
    fill(on_bench(3.0, 12.0), &beaker(4.4, 10.0), 5.0, 0);
    fill(on_bench(-28.5, 14.0), &beaker(3.0, 7.0), 0.0, 0);
    fill(on_bench(36.0, 8.0), &beaker(4.0, 11.0), 6.0, 1);
    fill(on_bench(-13.0, -10.0), &erlenmeyer(5.0, 13.0), 4.5, 2);
}

/// Eight test tubes in a wooden rack.
fn rack(b: &mut Builder, foot: DVec3) {
    b.material = WOOD;
    let half = DVec3::new(9.2, 0.3, 1.8);
    for height in [0.3, 3.6] {
        let middle = foot + DVec3::Y * height;
        b.cuboid(middle - half, middle + half);
    }
    for end in [-1.0, 1.0] {
        let middle = foot + DVec3::new(end * 9.5, 4.5, 0.0);
        let half = DVec3::new(0.3, 4.5, 1.8);
        b.cuboid(middle - half, middle + half);
    }
    // Two bars hold the tubes instead of a board with holes.
    for side in [-1.0, 1.0] {
        let middle = foot + DVec3::new(0.0, 8.0, side * 1.35);
        let half = DVec3::new(9.2, 0.3, 0.3);
        b.cuboid(middle - half, middle + half);
    }
    let radius = 0.9;
    let mut tube = vec![(0.0, 0.0)];
    for step in 1..=8 {
        let (s, c) = sin_cos(f64::from(step) / 32.0 - 0.25);
        tube.push((radius * c, radius * (1.0 + s)));
    }
    tube.extend([(radius, 6.0), (radius, 10.8), (radius + 0.2, 11.0)]);
    for i in 0..8_u32 {
        let place = Place::upright(foot + DVec3::new(f64::from(i) * 2.25 - 7.9, 3.95, 0.0));
        b.material = GLASS;
        vessel(b, &place, 36, &tube);
        if i != 5 {
            b.material = LIQUID + i % 4;
            liquid(b, &place, 36, &tube, 3.0 + f64::from(i * 7 % 5));
        }
    }
}

/// A round flask over a burner, held by a clamp, with a cork and a tube that is bent down into a cylinder.
fn stand(b: &mut Builder, foot: DVec3) {
    b.material = STEEL;
    b.cuboid(foot + DVec3::new(-7.0, 0.0, -5.0), foot + DVec3::new(7.0, 0.8, 5.0));
    let rod = foot + DVec3::new(-5.5, 0.8, -3.0);
    b.pipe(&[rod, rod + DVec3::Y * 36.0], 0.5, 24);
    let bulb = foot + DVec3::new(1.0, 11.0, 0.0);
    let outer = round_flask(5.2, 17.0);
    let place = Place::upright(bulb);
    let neck = bulb + DVec3::Y * 14.0;
    b.pipe(&[rod + DVec3::Y * 24.2, neck + DVec3::X * -1.9], 0.4, 16);
    b.turn(
        &Place::upright(neck - DVec3::Y * 0.5),
        32,
        &[(1.62, 0.0), (2.0, 0.0), (2.0, 1.0), (1.62, 1.0), (1.62, 0.0)],
    );
    b.cushion(&Place::upright(rod + DVec3::Y * 24.2), DVec3::new(0.9, 1.1, 0.9), 24, 12);
    b.turn(
        &Place::upright(foot + DVec3::new(1.0, 0.8, 0.0)),
        40,
        &smooth(&[(3.2, 0.0), (3.0, 0.6), (0.9, 1.2), (0.7, 2.0), (0.7, 6.5), (0.5, 6.6)], 3),
    );
    b.material = GLASS;
    vessel(b, &place, 80, &outer);
    let bent = [
        (0.0, 15.0),
        (0.0, 19.5),
        (0.6, 21.4),
        (2.5, 22.3),
        (9.0, 21.2),
        (15.5, 20.0),
        (17.3, 19.0),
        (17.9, 17.0),
        (17.9, 9.0),
    ];
    let path: Vec<DVec3> =
        smooth(&bent, 6).into_iter().map(|(x, y)| bulb + DVec3::new(x, y - 1.5, 0.0)).collect();
    b.pipe(&path, 0.35, 20);
    b.material = LIQUID + 1;
    liquid(b, &place, 80, &outer, 5.5);
    b.material = RUBBER;
    b.turn(&Place::upright(bulb), 32, &[(0.38, 14.8), (1.2, 14.8), (1.75, 17.4), (0.38, 17.4)]);
}

/// Stoppered bottles with labels on a board on the wall.
fn shelf(b: &mut Builder, random: &mut SplitMix64) {
    b.material = WOOD;
    b.cuboid(DVec3::new(-60.0, 26.0, -28.0), DVec3::new(-8.0, 27.2, -18.0));
    b.cuboid(DVec3::new(10.0, 26.0, -28.0), DVec3::new(60.0, 27.2, -18.0));
    for i in 0..11 {
        let x = if i < 6 { -53.0 + 8.0 * f64::from(i) } else { 14.5 + 8.0 * f64::from(i - 6) };
        let place = Place::upright(DVec3::new(x, 27.2, -23.0 + random.between(-0.8, 0.8)));
        let (radius, height) = (random.between(2.8, 3.5), random.between(9.5, 13.0));
        let outer = bottle(radius, height);
        b.material = if i % 3 == 1 { BROWN_GLASS } else { GLASS };
        vessel(b, &place, 40, &outer);
        let stopper = [(0.0, 0.93), (0.26, 0.94), (0.3, 1.02), (0.46, 1.06), (0.46, 1.11), (0.0, 1.13)];
        b.turn(&place, 28, &stopper.map(|(r, h)| (r * radius * 0.9, h * height)));
        b.material = LIQUID + i as u32 % 4;
        liquid(b, &place, 40, &outer, height * random.between(0.3, 0.6));
        b.material = LABEL;
        b.grid(24, 1, |u, v| {
            let (s, c) = sin_cos(0.1 + 0.3 * u);
            place.at((radius + 0.03) * c, height * (0.2 + 0.3 * v), (radius + 0.03) * s)
        });
    }
}
