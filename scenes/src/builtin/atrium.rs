//! A two-storey courtyard with arcades, vaulted aisles, balustrades, curtains, plants and a tiled floor: much depth
//! complexity and geometry of very uneven size. Stands in for Crytek Sponza (262,267 triangles) where no file is given.
//!
//! Metres. The court runs along x; the aisles lie behind the arcades on both sides.

use super::builder::Builder;
use super::numeric::{SplitMix64, noise, sin_cos};
use crate::{Camera, Instance, Light, Material, RaySelection, Scene};
use glam::{DVec3, Vec3};

const SEED: u64 = 0xa7_121a;
/// Bays of the arcades along x, and their width.
const BAYS: u32 = 9;
const BAY: f64 = 4.0;
/// Distance from the middle of the court to the arcade, and from there to the wall behind the aisle.
const COURT: f64 = 4.5;
const AISLE: f64 = 3.5;
/// Height of a storey, of the springing of its arches, and the radius of an arch.
const STOREY: f64 = 6.0;
const SPRING: f64 = 3.4;
const ARCH: f64 = 1.65;

const STONE: u32 = 0;
const FLOOR: u32 = 1;
const CLOTH: u32 = 2;
const LEAF: u32 = 3;

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("atrium");
    let mut random = SplitMix64(SEED);
    b.material = FLOOR;
    tiles(&mut b, &mut random);
    b.material = STONE;
    walls(&mut b);
    for storey in 0..2 {
        let base = f64::from(storey) * STOREY;
        for side in [-1.0, 1.0] {
            for bay in 0..=BAYS {
                column(&mut b, DVec3::new(bay_edge(bay), base, side * COURT));
            }
            for bay in 0..BAYS {
                arch(&mut b, bay, base, side);
                vault(&mut b, bay, base, side);
            }
        }
    }
    for side in [-1.0, 1.0] {
        for bay in 0..BAYS {
            balustrade(&mut b, bay, side);
        }
    }
    b.material = CLOTH;
    for bay in 1..BAYS - 1 {
        for side in [-1.0, 1.0] {
            curtain(&mut b, bay, side);
        }
    }
    b.material = LEAF;
    for bay in 0..BAYS {
        for side in [-1.0, 1.0] {
            plant(&mut b, &mut random, bay_edge(bay) + BAY * 0.5, side);
        }
    }
    Scene {
        name: "atrium".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("stone", Vec3::new(0.6, 0.55, 0.45)),
            Material::matte("floor", Vec3::new(0.45, 0.42, 0.4)),
            Material::matte("cloth", Vec3::new(0.6, 0.1, 0.08)),
            Material::matte("leaf", Vec3::new(0.15, 0.4, 0.1)),
        ],
        camera: Camera {
            eye: Vec3::new(-16.5, 3.6, 1.2),
            target: Vec3::new(18.0, 4.6, -1.6),
            up: Vec3::Y,
            vertical_fov_degrees: 60.0,
        },
        lights: vec![Light::Point { position: Vec3::new(-2.0, 16.0, 0.5) }],
        rays: RaySelection::default(),
        notes: vec![],
    }
}

/// Where the bay starts along x; the court is centred on the origin.
fn bay_edge(bay: u32) -> f64 {
    (f64::from(bay) - f64::from(BAYS) * 0.5) * BAY
}

/// Bevelled floor tiles of slightly uneven height: 10 triangles each.
fn tiles(b: &mut Builder, random: &mut SplitMix64) {
    let (columns, rows) = (72, 32);
    let (w, d) = (BAY * f64::from(BAYS) / f64::from(columns), 2.0 * (COURT + AISLE) / f64::from(rows));
    for row in 0..rows {
        for column in 0..columns {
            let (x, z) = (bay_edge(0) + f64::from(column) * w, -(COURT + AISLE) + f64::from(row) * d);
            let top = random.between(-0.004, 0.004);
            let rim = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)];
            let low = rim.map(|(u, v)| DVec3::new(x + u * w, -0.02, z + v * d));
            let high =
                rim.map(|(u, v)| DVec3::new(x + (0.03 + 0.94 * u) * w, top, z + (0.03 + 0.94 * v) * d));
            b.quad(high);
            for i in 0..4 {
                b.quad([low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]]);
            }
        }
    }
}

/// Outer walls and the end walls; the court is open to the sky.
fn walls(b: &mut Builder) {
    let (x, z, top) = (bay_edge(BAYS), COURT + AISLE, 2.0 * STOREY);
    for side in [-1.0, 1.0] {
        b.cuboid(DVec3::new(-x, -0.1, side * z - 0.15), DVec3::new(x, top, side * z + 0.15));
        b.cuboid(DVec3::new(side * x - 0.15, -0.1, -z), DVec3::new(side * x + 0.15, top, z));
        // The roof over the aisle.
        let (near, far) = (side * COURT, side * z);
        b.cuboid(DVec3::new(-x, top, near.min(far)), DVec3::new(x, top + 0.3, near.max(far)));
    }
}

/// A square plinth and abacus, and a fluted shaft with base and capital mouldings.
fn column(b: &mut Builder, foot: DVec3) {
    let half = 0.34;
    b.cuboid(foot - DVec3::new(half, 0.0, half), foot + DVec3::new(half, 0.2, half));
    let top = foot + DVec3::Y * (SPRING - 0.2);
    b.cuboid(top - DVec3::new(half, 0.0, half), top + DVec3::new(half, 0.2, half));
    let mouldings = [
        (0.33, 0.2),
        (0.35, 0.26),
        (0.33, 0.32),
        (0.27, 0.36),
        (0.29, 0.42),
        (0.25, 0.48),
        (0.22, 2.7),
        (0.24, 2.74),
        (0.22, 2.8),
        (0.26, 2.95),
        (0.33, 3.08),
        (0.3, SPRING - 0.2),
    ];
    b.revolve(foot, 24, &mouldings[..6]);
    b.revolve(foot, 24, &mouldings[6..]);
    let (flutes, rows) = (48, 8);
    b.grid(flutes, rows, |u, v| {
        let radius = (0.25 + (0.22 - 0.25) * v) * (1.0 - 0.06 * (1.0 - sin_cos(u * 12.0).1));
        let (s, c) = sin_cos(u);
        foot + DVec3::new(radius * c, 0.48 + v * 2.22, radius * s)
    });
}

/// A moulded half-circle arch between two columns, and the wall above it up to the next storey.
fn arch(b: &mut Builder, bay: u32, base: f64, side: f64) {
    let centre = DVec3::new(bay_edge(bay) + BAY * 0.5, base + SPRING, side * COURT);
    let at = |turns: f64, radius: f64, depth: f64| {
        let (s, c) = sin_cos(turns);
        centre + DVec3::new(radius * c, radius * s, depth)
    };
    // The moulding in cross-section: (radius beyond ARCH, depth).
    let moulding = [
        (0.30, -0.25),
        (0.22, -0.33),
        (0.12, -0.33),
        (0.08, -0.27),
        (0.0, -0.25),
        (0.0, 0.25),
        (0.08, 0.27),
        (0.12, 0.33),
        (0.22, 0.33),
        (0.30, 0.25),
    ];
    b.grid(24, 9, |u, v| {
        let (beyond, depth) = moulding[(v * 9.0 + 0.5) as usize];
        at(u * 0.5, ARCH + beyond, depth)
    });
    // The spandrel: from the arch out to a rectangle, on both faces.
    for face in [-0.25, 0.25] {
        b.grid(24, 4, |u, v| {
            let inner = at(u * 0.5, ARCH + 0.3, face);
            let (s, c) = sin_cos(u * 0.5);
            let reach = 1.0 / c.abs().max(s);
            let outer = centre + DVec3::new(c * reach * BAY * 0.5, s * reach * (STOREY - SPRING), face);
            inner + (outer - inner) * v
        });
    }
}

/// A groin vault over one bay of the aisle: the higher of two crossing half cylinders.
fn vault(b: &mut Builder, bay: u32, base: f64, side: f64) {
    let middle = DVec3::new(bay_edge(bay) + BAY * 0.5, base + SPRING, side * (COURT + AISLE * 0.5));
    let (half_x, half_z, rise) = (BAY * 0.5, AISLE * 0.5, 1.9);
    b.grid(24, 24, |u, v| {
        let (s, t) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
        let (across, along) = ((1.0 - s * s).max(0.0).sqrt(), (1.0 - t * t).max(0.0).sqrt());
        middle + DVec3::new(s * half_x, across.max(along) * rise, t * half_z)
    });
}

/// Twelve turned balusters and a rail between two columns of the upper storey.
fn balustrade(b: &mut Builder, bay: u32, side: f64) {
    let profile = [
        (0.07, 0.0),
        (0.07, 0.08),
        (0.04, 0.12),
        (0.06, 0.25),
        (0.075, 0.36),
        (0.05, 0.5),
        (0.035, 0.62),
        (0.05, 0.7),
        (0.04, 0.76),
        (0.07, 0.8),
        (0.07, 0.88),
    ];
    let start = DVec3::new(bay_edge(bay), STOREY, side * COURT);
    for i in 0..12 {
        let x = 0.45 + f64::from(i) * (BAY - 0.9) / 11.0;
        b.revolve(start + DVec3::X * x, 10, &profile);
    }
    let rail = DVec3::new(0.34, 0.88, -0.1);
    b.cuboid(start + rail, start + DVec3::new(BAY - 0.34, 1.0, 0.1));
}

/// A hanging sheet with folds that deepen towards the hem, in front of an arch of the upper storey.
fn curtain(b: &mut Builder, bay: u32, side: f64) {
    let left = bay_edge(bay) + 0.4;
    let seed = u64::from(bay) * 2 + u64::from(side > 0.0);
    b.grid(64, 30, |u, v| {
        let fold = sin_cos(u * 7.0 + 0.15 * noise(DVec3::new(u * 3.0, v * 2.0, 0.0), seed)).0;
        let sag = 0.12 * (1.0 - (u * 2.0 - 1.0) * (u * 2.0 - 1.0)) * (1.0 - v);
        let depth = COURT - 0.5 - (0.05 + 0.13 * v) * fold;
        DVec3::new(left + u * (BAY - 0.8), STOREY + 4.2 - sag - v * 3.0, side * depth)
    });
}

/// A pot with long arching leaves, in front of the arcade.
fn plant(b: &mut Builder, random: &mut SplitMix64, x: f64, side: f64) {
    let foot = DVec3::new(x, 0.0, side * (COURT - 0.8));
    b.revolve(foot, 16, &[(0.2, 0.0), (0.3, 0.35), (0.28, 0.4), (0.34, 0.45), (0.34, 0.52), (0.01, 0.5)]);
    for _ in 0..60 {
        let (s, c) = sin_cos(random.unit());
        let (reach, rise, width) =
            (random.between(0.4, 0.9), random.between(0.4, 1.3), random.between(0.02, 0.05));
        b.grid(1, 8, |u, v| {
            let across = (u * 2.0 - 1.0) * width * (1.0 - 0.95 * v * v);
            let (out, up) = (v * reach, 0.5 + rise * v * (1.6 - v));
            foot + DVec3::new(out * c - across * s, up, out * s + across * c)
        });
    }
}
