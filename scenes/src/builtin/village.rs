//! A village on a hill behind fields of lavender: ground to the mountains, houses with tiled roofs, trees leaf by leaf.
//! Stands in for Provence of Lee et al. 2017 (600 K triangles), which is not available.
//!
//! Metres; the fields lie about y = 0, the village towards negative z. All is matte but a pond.

use super::builder::Builder;
use super::numeric::{SplitMix64, noise, sin_cos};
use super::shapes::Place;
use crate::{Camera, Instance, Light, Material, RaySelection, Reflection, Scene};
use glam::{DVec3, Vec3};

const SEED: u64 = 0x960_ce11;

const GROUND: u32 = 0;
const PLASTER: u32 = 1;
const TILE: u32 = 2;
const SHUTTER: u32 = 3;
const PANE: u32 = 4;
const STONE: u32 = 5;
const BARK: u32 = 6;
const LEAF: u32 = 7;
const CYPRESS: u32 = 8;
const LAVENDER: u32 = 9;
const WATER: u32 = 10;

/// Middle of the village's hill.
const HILL: (f64, f64) = (22.0, -150.0);
/// Middle and half lengths of the pond, and the height of its water.
const POND: (f64, f64) = (27.0, -13.0);
const POND_HALF: (f64, f64) = (12.5, 10.0);
const WATER_LEVEL: f64 = -0.9;
/// Rows of lavender: the first and the distance between two, along x; from near to far along z.
const ROWS: u32 = 34;
const FIRST_ROW: f64 = -46.0;
const ROW: f64 = 1.6;
const FIELD: [f64; 2] = [26.0, -62.0];

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("village");
    let mut random = SplitMix64(SEED);
    terrain(&mut b);
    b.material = WATER;
    b.turn(
        &Place::upright(DVec3::new(POND.0, WATER_LEVEL, POND.1)),
        64,
        &[(POND_HALF.0 * 1.4, 0.0), (0.0, 0.0)],
    );
    lavender(&mut b, &mut random);
    let houses = streets(&mut b, &mut random);
    church(&mut b, on_ground(HILL.0, HILL.1));
    woods(&mut b, &mut random, &houses);
    dry_wall(&mut b, &mut random);
    Scene {
        name: "village".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("ground", Vec3::new(0.36, 0.36, 0.17)),
            Material::matte("plaster", Vec3::new(0.62, 0.5, 0.34)),
            Material::matte("tile", Vec3::new(0.5, 0.22, 0.12)),
            Material::matte("shutter", Vec3::new(0.2, 0.34, 0.45)),
            Material::matte("pane", Vec3::new(0.06, 0.07, 0.08)),
            Material::matte("stone", Vec3::new(0.5, 0.47, 0.4)),
            Material::matte("bark", Vec3::new(0.2, 0.15, 0.1)),
            Material::matte("leaf", Vec3::new(0.22, 0.34, 0.12)),
            Material::matte("cypress", Vec3::new(0.07, 0.18, 0.07)),
            Material::matte("lavender", Vec3::new(0.33, 0.22, 0.55)),
            Material {
                specular: Vec3::splat(0.02),
                roughness: 0.0,
                reflection: Reflection::Mirror,
                ..Material::matte("water", Vec3::new(0.08, 0.16, 0.2))
            },
        ],
        camera: Camera {
            eye: Vec3::new(-8.0, 7.5, 42.0),
            target: Vec3::new(5.0, 3.0, -60.0),
            up: Vec3::Y,
            vertical_fov_degrees: 34.0,
        },
        lights: vec![Light::Point { position: Vec3::new(-900.0, 900.0, 500.0) }],
        rays: RaySelection { mirror: true, glossy: true, ..RaySelection::default() },
        notes: vec![],
    }
}

/// Height of the ground: fields with a pit for the pond, the hill, and mountains behind.
fn height(x: f64, z: f64) -> f64 {
    let rolling = 0.7 * noise(DVec3::new(x / 38.0, 0.0, z / 38.0), 1)
        + 0.12 * noise(DVec3::new(x / 5.0, 0.0, z / 5.0), 2);
    let bump = |(mx, mz): (f64, f64), (hx, hz): (f64, f64)| {
        let q = (x - mx) * (x - mx) / (hx * hx) + (z - mz) * (z - mz) / (hz * hz);
        1.0 / (1.0 + q * q)
    };
    let hill = 24.0 * bump(HILL, (72.0, 62.0));
    let pit = 3.2 * bump(POND, POND_HALF);
    let far = ((-z - 280.0) / 420.0).clamp(0.0, 1.0);
    let ridge = 1.0 - noise(DVec3::new(x / 260.0, 0.0, z / 260.0), 3).abs();
    let crags = noise(DVec3::new(x / 60.0, 0.0, z / 60.0), 4);
    let mountains = far * far * (3.0 - 2.0 * far) * (200.0 * ridge + 18.0 * crags - 30.0);
    rolling + hill - pit + mountains
}

fn on_ground(x: f64, z: f64) -> DVec3 {
    DVec3::new(x, height(x, z), z)
}

/// Finer towards the camera, where it is narrower too.
fn terrain(b: &mut Builder) {
    b.material = GROUND;
    b.grid(280, 260, |u, v| {
        let z = 48.0 - 30.0 * v - 820.0 * v * v * v;
        let half = 60.0 + 0.9 * (48.0 - z);
        on_ground((u * 2.0 - 1.0) * half, z)
    });
}

/// Bushy rows, with flowers that stand out of them.
fn lavender(b: &mut Builder, random: &mut SplitMix64) {
    b.material = LAVENDER;
    for row in 0..ROWS {
        let x = FIRST_ROW + f64::from(row) * ROW;
        let along = |v: f64| FIELD[0] + (FIELD[1] - FIELD[0]) * v;
        b.grid(6, 150, |u, v| {
            let (s, c) = sin_cos(0.5 - u * 0.5);
            let z = along(v);
            let bush = 1.0 + 0.45 * noise(DVec3::new(x, u * 2.0, z * 1.1), 5);
            on_ground(x + 0.5 * c * bush, z) + DVec3::Y * (0.62 * s * bush - 0.08)
        });
        for _ in 0..FLOWERS {
            let (across, z) = (random.between(-0.4, 0.4), along(random.unit()));
            let root = on_ground(x + across, z) + DVec3::Y * random.between(0.4, 0.6);
            let tip = root + DVec3::new(across * 0.7, random.between(0.2, 0.4), random.between(-0.15, 0.15));
            let side = DVec3::new(random.between(0.02, 0.05), 0.0, random.between(-0.03, 0.03));
            b.loose_triangle([root - side, root + side, tip]);
        }
    }
}

/// Flowers of a row.
const FLOWERS: u32 = 2000;

/// Houses in rings around the church, the fronts down the hill; where they stand.
fn streets(b: &mut Builder, random: &mut SplitMix64) -> Vec<DVec3> {
    let mut houses = Vec::new();
    for (ring, count) in [(22.0, 9), (40.0, 17), (58.0, 24), (77.0, 28)] {
        for i in 0..count {
            let turns = (f64::from(i) + random.between(0.35, 0.65)) / f64::from(count);
            let (s, c) = sin_cos(turns);
            let radius = ring + random.between(-3.0, 3.0);
            let foot = on_ground(HILL.0 + radius * c, HILL.1 + radius * s);
            let place = Place::turned(foot, turns + 0.25 + random.between(-0.03, 0.03));
            house(b, random, &place);
            houses.push(foot);
        }
    }
    houses
}

/// Walls with shuttered windows and a roof of pantiles, the ridge along x.
fn house(b: &mut Builder, random: &mut SplitMix64, place: &Place) {
    let (x, z) = (random.between(3.2, 5.2), random.between(2.8, 3.8));
    let storeys = if random.unit() < 0.35 { 3 } else { 2 };
    let (top, rise) = (2.9 * f64::from(storeys) + 0.3, 0.42 * z);
    b.material = PLASTER;
    b.block(place, DVec3::new(-x, -6.0, -z), DVec3::new(x, top, z));
    for end in [-x, x] {
        b.loose_triangle([place.at(end, top, -z), place.at(end, top, z), place.at(end, top + rise, 0.0)]);
    }
    for side in [-1.0, 1.0] {
        b.material = TILE;
        let (eaves, verge) = (0.45, 0.3);
        b.grid(48, 3, |u, v| {
            let wave = 0.05 * sin_cos(u * 12.0).0;
            let out = v * (z + eaves);
            place.at((u * 2.0 - 1.0) * (x + verge), top + rise - out * rise / z + 0.14 + wave, side * out)
        });
        for storey in 0..storeys {
            for column in -1..=1 {
                let (middle, sill) = (f64::from(column) * x * 0.6, 0.95 + 2.9 * f64::from(storey));
                window(b, place, middle, sill, side * z, side);
            }
        }
    }
    b.material = PLASTER;
    let (cx, cz) = (random.between(-0.6, 0.6) * x, 0.4 * z);
    b.block(place, DVec3::new(cx - 0.35, top, cz - 0.3), DVec3::new(cx + 0.35, top + rise + 0.9, cz + 0.3));
    b.material = TILE;
    b.block(
        place,
        DVec3::new(cx - 0.45, top + rise + 0.9, cz - 0.4),
        DVec3::new(cx + 0.45, top + rise + 1.0, cz + 0.4),
    );
}

/// A pane, a sill and two shutters on the wall at `z`, which faces `side`.
fn window(b: &mut Builder, place: &Place, x: f64, y: f64, z: f64, side: f64) {
    let mut panel = |material: u32, from: f64, to: f64, [low, high]: [f64; 2], out: f64| {
        b.material = material;
        let (back, front) = (z - 0.01 * side, z + out * side);
        let (min, max) =
            (DVec3::new(x + from, y + low, back.min(front)), DVec3::new(x + to, y + high, back.max(front)));
        b.block(place, min, max);
    };
    panel(PANE, -0.42, 0.42, [0.0, 1.4], 0.02);
    panel(SHUTTER, -0.9, -0.44, [0.0, 1.4], 0.06);
    panel(SHUTTER, 0.44, 0.9, [0.0, 1.4], 0.06);
    panel(STONE, -0.6, 0.6, [-0.12, 0.0], 0.12);
}

/// A nave, and a square tower with openings for the bells and a low pyramid.
fn church(b: &mut Builder, foot: DVec3) {
    let place = Place::turned(foot, 0.04);
    b.material = STONE;
    b.block(&place, DVec3::new(-7.0, -4.0, -4.5), DVec3::new(9.0, 8.0, 4.5));
    for end in [-7.0, 9.0] {
        b.loose_triangle([place.at(end, 8.0, -4.5), place.at(end, 8.0, 4.5), place.at(end, 10.5, 0.0)]);
    }
    let (low, high) = (DVec3::new(-13.0, -4.0, -3.0), DVec3::new(-7.0, 17.0, 3.0));
    b.block(&place, low, high);
    for x in [low.x, high.x - 1.4] {
        for z in [low.z, high.z - 1.4] {
            b.block(&place, DVec3::new(x, high.y, z), DVec3::new(x + 1.4, 20.5, z + 1.4));
        }
    }
    b.block(&place, DVec3::new(-13.2, 20.5, -3.2), DVec3::new(-6.8, 21.1, 3.2));
    b.material = TILE;
    for side in [-1.0, 1.0] {
        b.grid(96, 6, |u, v| {
            let wave = 0.06 * sin_cos(u * 24.0).0;
            place.at(-7.0 + u * 16.4, 10.7 - v * 2.9 + wave, side * v * 5.1)
        });
    }
    let peak = place.at(-10.0, 23.8, 0.0);
    let eaves = [(-13.2, -3.2), (-6.8, -3.2), (-6.8, 3.2), (-13.2, 3.2)].map(|(x, z)| place.at(x, 21.1, z));
    for i in 0..4 {
        b.loose_triangle([eaves[i], eaves[(i + 1) % 4], peak]);
    }
    b.material = BARK;
    let bell = [(0.0, 19.9), (0.3, 19.8), (0.45, 19.3), (0.55, 18.6), (0.85, 18.1)];
    b.turn(&Place::upright(place.at(-10.0, 0.0, 0.0)), 32, &bell);
}

/// Broad trees by the fields and on the slopes, cypresses by the road and among the houses.
fn woods(b: &mut Builder, random: &mut SplitMix64, houses: &[DVec3]) {
    for _ in 0..51 {
        let (x, z) = (random.between(14.0, 80.0), random.between(-64.0, -36.0));
        broad_tree(b, random, on_ground(x, z), 1300);
    }
    for _ in 0..71 {
        let (x, z) = (random.between(-115.0, -64.0), random.between(-150.0, -60.0));
        broad_tree(b, random, on_ground(x, z), 900);
    }
    for i in 0..12 {
        let foot = on_ground(11.0 + random.between(-0.4, 0.4), 18.0 - 9.0 * f64::from(i));
        cypress(b, random, foot, 1000);
    }
    let mut planted = 0;
    while planted < 70 {
        let (s, c) = sin_cos(random.unit());
        let radius = random.between(30.0, 95.0);
        let foot = on_ground(HILL.0 + radius * c, HILL.1 + radius * s);
        if houses.iter().all(|&house| (house - foot).dot(house - foot) > CLEARING * CLEARING) {
            cypress(b, random, foot, 600);
            planted += 1;
        }
    }
}

/// From the middle of a house to the next cypress.
const CLEARING: f64 = 8.0;

/// A trunk that forks, under a crown of loose leaves.
fn broad_tree(b: &mut Builder, random: &mut SplitMix64, foot: DVec3, leaves: u32) {
    let size = random.between(0.8, 1.25);
    b.material = BARK;
    let fork = foot + DVec3::new(random.between(-0.3, 0.3), 2.0, random.between(-0.3, 0.3)) * size;
    b.pipe(&[foot - DVec3::Y, fork], 0.26 * size, 8);
    let mut crowns = [DVec3::ZERO; 4];
    for crown in &mut crowns {
        let out = random.in_cube() * 1.6 + DVec3::Y * 2.6;
        *crown = fork + out * size;
        b.pipe(&[fork - DVec3::Y * 0.1, fork + out * (0.5 * size), *crown], 0.12 * size, 6);
    }
    b.material = LEAF;
    for leaf in 0..leaves {
        let middle = crowns[(leaf % 4) as usize] + in_ball(random) * (1.75 * size);
        b.loose_triangle([(); 3].map(|()| middle + random.in_cube() * 0.3));
    }
}

/// A column of leaves that narrows to a point, around a closed core.
fn cypress(b: &mut Builder, random: &mut SplitMix64, foot: DVec3, leaves: u32) {
    let (tall, wide) = (random.between(6.0, 9.5), random.between(0.7, 1.0));
    let radius = |v: f64| wide * (1.0 - v) * (0.35 + 2.6 * v.min(0.25));
    b.material = CYPRESS;
    let core: Vec<(f64, f64)> =
        (0..=8).map(|i| f64::from(i) / 8.0).map(|v| (0.8 * radius(v), v * tall)).collect();
    b.turn(&Place::upright(foot - DVec3::Y * 0.2), 10, &core);
    for _ in 0..leaves {
        let v = random.unit();
        let (s, c) = sin_cos(random.unit());
        let out = radius(v) * random.between(0.75, 1.05);
        let root = foot + DVec3::new(out * c, v * tall, out * s);
        let tip = root + DVec3::new(0.1 * c, random.between(0.25, 0.5), 0.1 * s);
        b.loose_triangle([
            root + DVec3::new(-0.07 * s, 0.0, 0.07 * c),
            root + DVec3::new(0.07 * s, 0.0, -0.07 * c),
            tip,
        ]);
    }
}

/// Uniform in the ball of radius 1.
fn in_ball(random: &mut SplitMix64) -> DVec3 {
    loop {
        let p = random.in_cube();
        if p.dot(p) <= 1.0 {
            return p;
        }
    }
}

/// Stones in three courses, along the edge of the field.
fn dry_wall(b: &mut Builder, random: &mut SplitMix64) {
    b.material = STONE;
    for course in 0..3 {
        let mut z = FIELD[0] - 2.0;
        while z > FIELD[1] {
            let long = random.between(0.35, 0.7);
            let foot = on_ground(9.2, z - 0.5 * long) + DVec3::Y * (0.3 * f64::from(course) - 0.1);
            let place = Place::turned(foot, random.between(-0.02, 0.02));
            let deep = random.between(0.22, 0.3);
            b.block(&place, DVec3::new(-deep, 0.0, -0.49 * long), DVec3::new(deep, 0.29, 0.49 * long));
            z -= long;
        }
    }
}
