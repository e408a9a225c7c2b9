//! A saloon car in a studio: a smooth body with cut wheel arches, a glazed cabin, turned wheels. Stands in for BMW of Lee et
//! al. 2017 (55 K triangles), which is not available.
//!
//! Metres. The car looks along x and stands on y = 0. Paint is as smooth as a mirror, windows and lamps are closed
//! sheets and bodies of glass, rims and trim are polished; tyres, seats and the studio are matte.

use super::builder::Builder;
use super::numeric::sin_cos;
use super::shapes::{Place, interpolated, signed_sqrt, smooth};
use crate::{Camera, Instance, Light, Material, RaySelection, Reflection, Scene};
use glam::{DVec3, Vec3};

const STUDIO: u32 = 0;
const PAINT: u32 = 1;
const GLASS: u32 = 2;
const METAL: u32 = 3;
const RUBBER: u32 = 4;
const SEAT: u32 = 5;
const LAMP: u32 = 6;

/// Half the length of the body.
const REACH: f64 = 2.25;
/// Of the middles of the wheels: along the car, to each side, and up.
const AXLES: [f64; 2] = [1.38, -1.33];
const TRACK: f64 = 0.76;
const WHEEL: f64 = 0.32;
/// Radius of the arch that is cut over a wheel.
const ARCH: f64 = 0.375;

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("car");
    b.material = STUDIO;
    b.backdrop(30.0, [9.0, -8.0], 12.0);
    b.material = PAINT;
    body(&mut b);
    cabin(&mut b);
    for axle in AXLES {
        for side in [-1.0, 1.0] {
            wheel(&mut b, DVec3::new(axle, WHEEL, side * TRACK), side);
        }
    }
    for side in [-1.0, 1.0] {
        trim(&mut b, side);
        seats(&mut b, side);
    }
    let mirror = |name, diffuse| Material {
        reflection: Reflection::Mirror,
        specular: Vec3::splat(0.5),
        roughness: 0.0,
        ..Material::matte(name, diffuse)
    };
    let glass = |name, diffuse| Material { reflection: Reflection::Glass, ..mirror(name, diffuse) };
    Scene {
        name: "car".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("studio", Vec3::splat(0.5)),
            mirror("paint", Vec3::new(0.08, 0.16, 0.42)),
            glass("window", Vec3::new(0.06, 0.08, 0.09)),
            mirror("metal", Vec3::splat(0.55)),
            Material::matte("rubber", Vec3::splat(0.03)),
            Material::matte("seat", Vec3::new(0.3, 0.2, 0.12)),
            glass("lamp", Vec3::new(0.6, 0.6, 0.55)),
        ],
        camera: Camera {
            eye: Vec3::new(4.5, 1.75, 4.3),
            target: Vec3::new(0.12, 0.58, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 24.0,
        },
        lights: vec![
            Light::Point { position: Vec3::new(3.0, 6.5, 5.0) },
            Light::Point { position: Vec3::new(-5.0, 5.0, 3.0) },
        ],
        rays: RaySelection { mirror: true, glossy: true, ..RaySelection::default() },
        notes: vec![],
    }
}

/// Height of the shoulder, from tail to nose.
const SHOULDER: [(f64, f64); 9] = [
    (-2.25, 0.86),
    (-2.1, 0.98),
    (-1.5, 1.02),
    (-0.6, 0.98),
    (0.3, 0.95),
    (1.0, 0.92),
    (1.7, 0.84),
    (2.1, 0.73),
    (2.25, 0.6),
];
/// Half the width.
const WIDTH: [(f64, f64); 9] = [
    (-2.25, 0.68),
    (-2.15, 0.78),
    (-1.9, 0.86),
    (-1.2, 0.91),
    (0.0, 0.9),
    (1.3, 0.9),
    (1.8, 0.85),
    (2.1, 0.75),
    (2.25, 0.6),
];

/// Lower edge of the body: the sill, and arches over the wheels.
fn lower_edge(x: f64) -> f64 {
    let arch = |axle: f64| WHEEL + (ARCH * ARCH - (x - axle) * (x - axle)).max(0.0).sqrt();
    let sill = 0.2 + 0.12 * (x.abs() - 1.8).max(0.0) / 0.45;
    AXLES.into_iter().filter(|axle| (x - axle).abs() < ARCH).map(arch).fold(sill, f64::max)
}

/// A skin of sections from tail to nose, closed at both ends.
fn body(b: &mut Builder) {
    let (shoulder, width) = (smooth(&SHOULDER, 6), smooth(&WIDTH, 6));
    let sections = sections();
    let last = sections.len() as u32 + 1;
    b.skin(64, last + 1, |ring, turns| {
        let x = sections[(ring.max(1) - 1).min(last - 2) as usize];
        let (top, bottom) = (interpolated(&shoulder, x), lower_edge(x));
        let (middle, half) = ((top + bottom) * 0.5, (top - bottom) * 0.5);
        if ring == 0 || ring == last {
            return DVec3::new(x * 1.004, middle, 0.0);
        }
        let (s, c) = sin_cos(turns);
        let (across, up) = (signed_sqrt(c), signed_sqrt(s));
        // Sides lean in towards the shoulder and the sill, and a crease runs along the doors.
        let lean = 1.0 - 0.05 * up * up - 0.03 * up;
        // The bonnet is arched.
        let crown = 0.05 * (1.0 - across * across) * up.max(0.0);
        DVec3::new(x, middle + half * up + crown, -interpolated(&width, x) * lean * across)
    });
}

/// Where the body's sections are: evenly spaced, and the edges of the arches among them.
fn sections() -> Vec<f64> {
    let mut all: Vec<f64> = (0..=80).map(|i| -REACH + 2.0 * REACH * f64::from(i) / 80.0).collect();
    for axle in AXLES {
        for i in 0..=16 {
            let (_, c) = sin_cos(f64::from(i) / 32.0);
            all.push(axle + ARCH * 0.9999 * c);
        }
        all.extend([axle - ARCH * 1.001, axle + ARCH * 1.001]);
    }
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 2e-4);
    all
}

/// A point of the cabin, moved out by `out`: `turns` around from the front, `up` from the shoulder (0) to the middle of the
/// roof (1).
fn dome(turns: f64, up: f64, out: f64) -> DVec3 {
    let (s, c) = sin_cos(turns);
    let (along, across) = (signed_sqrt(c), signed_sqrt(s));
    // Middle and half size of the rings at the shoulder and at the edge of the roof.
    let (belt, roof) = ((-0.3, 1.42, 0.78), (-0.48, 0.78, 0.6));
    let wall = (up / 0.7).min(1.0);
    let mix = |from: f64, to: f64| from + (to - from) * wall;
    let over = ((up - 0.7) / 0.3).max(0.0);
    let shrink = 1.0 - over;
    // Walls are bulged, the roof is arched.
    let bulge = 0.07 * wall * (1.0 - wall) * 4.0;
    let (middle, length, width) = (mix(belt.0, roof.0), mix(belt.1, roof.1), mix(belt.2, roof.2));
    let height = 0.9 + 0.47 * wall * (1.18 - 0.18 * wall) + 0.07 * (1.0 - shrink * shrink);
    DVec3::new(
        middle + (length + bulge + out) * shrink * along,
        height + out * over,
        (width + 0.5 * bulge + out) * shrink * across,
    )
}

/// Windows between pillars, and a roof over both.
fn cabin(b: &mut Builder) {
    // Where windows are, around the cabin: windscreen, doors, rear window, doors.
    let windows: [(f64, f64); 6] =
        [(-0.105, 0.105), (0.13, 0.2485), (0.2515, 0.36), (0.395, 0.605), (0.64, 0.7485), (0.7515, 0.87)];
    let (sill, head) = (0.1, 0.64);
    for (i, &(from, to)) in windows.iter().enumerate() {
        let next = if i + 1 < windows.len() { windows[i + 1].0 } else { windows[0].0 + 1.0 };
        let columns = if to - from > 0.2 { 24 } else { 14 };
        let around = |u: f64| from + (to - from) * u;
        b.material = GLASS;
        let up = |v: f64| sill + (head - sill) * v;
        b.sheet(
            [columns, 12],
            |u, v| dome(around(1.0 - u), up(v), -0.006),
            |u, v| dome(around(1.0 - u), up(v), -0.011),
        );
        b.material = PAINT;
        b.grid(6, 12, |u, v| dome(to + (next - to) * u, up(v), 0.0));
    }
    b.grid(128, 3, |u, v| dome(u, sill * v, 0.0));
    b.skin(128, 12, |ring, turns| match ring {
        11 => dome(0.0, 1.0, 0.0),
        ring => dome(turns, head + (1.0 - head) * f64::from(ring) / 11.0, 0.0),
    });
}

/// A tyre, a rim with ten spokes and a brake disc; `side` is which way it faces along z.
fn wheel(b: &mut Builder, middle: DVec3, side: f64) {
    let place = Place::along(middle, DVec3::Z * side);
    b.material = RUBBER;
    let tyre = [
        (0.215, -0.09),
        (0.235, -0.1),
        (0.29, -0.105),
        (0.315, -0.085),
        (0.32, -0.04),
        (0.32, 0.04),
        (0.315, 0.085),
        (0.29, 0.105),
        (0.235, 0.1),
        (0.215, 0.09),
    ];
    b.turn(&place, 64, &tyre);
    b.material = METAL;
    let rim = [(0.215, 0.09), (0.225, 0.1), (0.215, 0.092), (0.2, 0.08), (0.195, 0.0), (0.2, -0.09)];
    b.turn(&place, 64, &rim);
    b.turn(&place, 48, &[(0.0, -0.04), (0.15, -0.04), (0.15, -0.02), (0.0, -0.02)]);
    b.turn(&place, 32, &smooth(&[(0.062, 0.02), (0.06, 0.06), (0.045, 0.075), (0.0, 0.08)], 2));
    for spoke in 0..10 {
        let (s, c) = sin_cos(f64::from(spoke) / 10.0);
        let path = smooth(&[(0.045, 0.06), (0.1, 0.068), (0.16, 0.066), (0.203, 0.06)], 3);
        let path: Vec<DVec3> = path.into_iter().map(|(r, h)| place.at(r * c, h, r * s)).collect();
        b.pipe(&path, 0.013, 8);
    }
}

/// Lamps, half of the grille, an outside mirror, and handles of doors, on one side.
fn trim(b: &mut Builder, side: f64) {
    let at = |x: f64, y: f64, z: f64| Place::upright(DVec3::new(x, y, z * side));
    b.material = LAMP;
    b.ellipsoid(&at(2.02, 0.64, 0.6), DVec3::new(0.17, 0.075, 0.13), 32, 16);
    b.ellipsoid(&at(2.1, 0.63, 0.42), DVec3::new(0.14, 0.065, 0.07), 24, 12);
    b.cushion(&at(-2.13, 0.78, 0.56), DVec3::new(0.1, 0.07, 0.18), 24, 12);
    b.material = METAL;
    let (middle, ring) = (DVec3::new(2.27, 0.55, 0.12 * side), 40);
    let loop_at = |turns: f64| {
        let (s, c) = sin_cos(turns);
        middle + DVec3::new(-0.02, 0.1 * signed_sqrt(s), 0.1 * signed_sqrt(c))
    };
    b.skin(8, ring + 1, |step, turns| {
        let (s, c) = sin_cos(turns);
        let out = loop_at(f64::from(step) / f64::from(ring)) - middle;
        middle + out * (1.0 + 0.12 * c) + DVec3::X * (0.03 * s)
    });
    for bar in -3..=3 {
        let z = middle.z + f64::from(bar) * 0.025;
        b.pipe(&[DVec3::new(2.25, 0.46, z), DVec3::new(2.25, 0.64, z)], 0.006, 8);
    }
    for x in [0.2, -0.75] {
        b.cushion(&at(x, 0.83, 0.885), DVec3::new(0.1, 0.016, 0.02), 16, 8);
    }
    b.material = PAINT;
    b.ellipsoid(&at(0.78, 1.0, 0.96), DVec3::new(0.06, 0.075, 0.12), 32, 16);
    b.pipe(&[DVec3::new(0.78, 0.94, 0.78 * side), DVec3::new(0.78, 0.97, 0.9 * side)], 0.02, 10);
}

/// Backs and headrests of the seats, over the height of the doors.
fn seats(b: &mut Builder, side: f64) {
    b.material = SEAT;
    for x in [-0.18, -1.05] {
        let lean = DVec3::new(-0.2, 1.0, 0.0);
        let back = Place::along(DVec3::new(x, 1.0, 0.34 * side), lean);
        b.cushion(&back, DVec3::new(0.22, 0.18, 0.06), 24, 12);
        let headrest = Place::along(DVec3::new(x - 0.045, 1.24, 0.34 * side), lean);
        b.cushion(&headrest, DVec3::new(0.11, 0.06, 0.045), 24, 12);
    }
}
