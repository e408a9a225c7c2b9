//! A chess set on a polished board: both sides complete, three moves into an Italian game. Stands in for Chess of Lee et
//! al. 2017 (42 K triangles), which is not available.
//!
//! Centimetres. The squares are 5 wide; white plays from positive z, files run along x. Board and men are lacquered, the
//! board as smooth as a mirror; the table beneath is matte.

use super::builder::Builder;
use super::numeric::sin_cos;
use super::shapes::{Place, smooth};
use crate::{Camera, Instance, Light, Material, RaySelection, Scene};
use glam::{DVec3, Vec3};

const SQUARE: f64 = 5.0;
/// Height of the board over the table.
const BOARD: f64 = 1.6;
const SIDES: u32 = 28;

const TABLE: u32 = 0;
const FRAME: u32 = 1;
const LIGHT_SQUARE: u32 = 2;
const DARK_SQUARE: u32 = 3;
const WHITE: u32 = 4;
const BLACK: u32 = 5;

/// The position after 1. e4 e5 2. Nf3 Nc6 3. Bc4 Bc5, eighth rank first.
const POSITION: [&str; 8] =
    ["r.bqk.nr", "pppp.ppp", "..n.....", "..b.p...", "..B.P...", ".....N..", "PPPP.PPP", "RNBQK..R"];

pub(super) fn scene() -> Scene {
    let mut b = Builder::new("chess");
    b.material = TABLE;
    b.backdrop(150.0, [70.0, -90.0], 90.0);
    board(&mut b);
    for (rank, row) in POSITION.iter().enumerate() {
        for (file, man) in row.chars().enumerate().filter(|&(_, man)| man != '.') {
            let foot = DVec3::new((file as f64 - 3.5) * SQUARE, BOARD, (rank as f64 - 3.5) * SQUARE);
            let white = man.is_ascii_uppercase();
            b.material = if white { WHITE } else { BLACK };
            // Knights look along the rank, a little towards the other side.
            let place = Place::turned(foot, if white { -0.07 } else { 0.44 });
            match man.to_ascii_lowercase() {
                'p' => pawn(&mut b, &place),
                'r' => rook(&mut b, &place),
                'n' => knight(&mut b, &place),
                'b' => bishop(&mut b, &place),
                'q' => queen(&mut b, &place),
                _ => king(&mut b, foot),
            }
        }
    }
    let lacquer = |name, diffuse, roughness| Material {
        specular: Vec3::splat(0.04),
        roughness,
        ..Material::matte(name, diffuse)
    };
    Scene {
        name: "chess".into(),
        meshes: vec![b.finish()],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("table", Vec3::new(0.32, 0.36, 0.4)),
            lacquer("frame", Vec3::new(0.16, 0.06, 0.025), 0.1),
            lacquer("light square", Vec3::new(0.62, 0.5, 0.32), 0.05),
            lacquer("dark square", Vec3::new(0.2, 0.08, 0.035), 0.05),
            lacquer("white", Vec3::new(0.75, 0.68, 0.5), 0.2),
            lacquer("black", Vec3::new(0.05, 0.035, 0.03), 0.2),
        ],
        camera: Camera {
            eye: Vec3::new(11.0, 21.0, 37.0),
            target: Vec3::new(0.6, 2.6, 1.0),
            up: Vec3::Y,
            vertical_fov_degrees: 34.0,
        },
        lights: vec![
            Light::Point { position: Vec3::new(-45.0, 60.0, 30.0) },
            Light::Point { position: Vec3::new(50.0, 55.0, 45.0) },
        ],
        rays: RaySelection { mirror: true, glossy: true, ..RaySelection::default() },
        notes: vec![],
    }
}

fn board(b: &mut Builder) {
    let half = 4.0 * SQUARE;
    for rank in 0..8 {
        for file in 0..8 {
            b.material = if (rank + file) % 2 == 0 { LIGHT_SQUARE } else { DARK_SQUARE };
            let (x, z) = (f64::from(file) * SQUARE - half, f64::from(rank) * SQUARE - half);
            let corner = |u: f64, v: f64| DVec3::new(x + u * SQUARE, BOARD, z + v * SQUARE);
            b.quad([corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)]);
        }
    }
    // A moulding around it: (beyond the squares, height).
    b.material = FRAME;
    let moulding = smooth(&[(0.0, 1.55), (0.25, 1.8), (2.0, 1.8), (2.4, 1.5), (2.5, 0.5), (2.9, 0.0)], 2);
    b.skin(4, moulding.len() as u32, |ring, turns| {
        let (out, height) = moulding[ring as usize];
        let (s, c) = sin_cos(turns + 0.125);
        // Towards a corner, both are half the square root of 2.
        DVec3::new(c.signum() * (half + out), height, s.signum() * (half + out))
    });
}

/// The base, stem and collar that all men share, `width` at the foot, up to a neck at `height`.
fn stem(width: f64, height: f64) -> Vec<(f64, f64)> {
    let foot = [(0.97, 0.0), (1.0, 0.12), (0.98, 0.3), (0.84, 0.46), (0.86, 0.6), (0.7, 0.78)];
    let shaft = [(0.7, 0.16), (0.46, 0.4), (0.36, 0.7), (0.34, 0.93)];
    let collar = [(0.34, -0.26), (0.62, -0.2), (0.63, -0.1), (0.36, 0.0)];
    let mut profile = smooth(&foot.map(|(r, h)| (r * width, h)), 1);
    let above = |points: Vec<(f64, f64)>| points.into_iter().skip(1);
    profile.extend(above(smooth(&shaft.map(|(r, h)| (r * width, 0.3 + h * (height - 0.6))), 1)));
    profile.extend(collar.map(|(r, h)| (r * width, height + h)));
    profile
}

/// A stem and what stands on it: the points of `head` are (radius, height above the neck), and drawn out smoothly.
fn turned(b: &mut Builder, place: &Place, (width, height): (f64, f64), head: &[(f64, f64)]) {
    let mut profile = stem(width, height);
    profile.extend(smooth(head, 2).into_iter().map(|(r, h)| (r, h + height)));
    b.turn(place, SIDES, &profile);
}

fn pawn(b: &mut Builder, place: &Place) {
    let head = [(0.5, 0.06), (0.8, 0.42), (0.86, 0.75), (0.62, 1.3), (0.0, 1.52)];
    turned(b, place, (1.45, 3.2), &head);
}

fn bishop(b: &mut Builder, place: &Place) {
    let mitre = [(0.5, 0.06), (0.92, 0.7), (0.88, 1.2), (0.5, 2.0), (0.18, 2.3)];
    turned(b, place, (1.6, 4.6), &mitre);
    let ball = [(0.18, 6.85), (0.3, 7.05), (0.22, 7.3), (0.0, 7.38)];
    b.turn(place, SIDES, &smooth(&ball, 2));
}

fn rook(b: &mut Builder, place: &Place) {
    let mut profile = stem(1.7, 3.4);
    profile.extend([(1.0, 3.55), (1.12, 3.8), (1.12, 4.5), (0.78, 4.5), (0.78, 4.1), (0.0, 4.06)]);
    // The two rings of its upper edge.
    let wall = profile.len() - 4..profile.len() - 2;
    b.skin(36, profile.len() as u32, |ring, turns| {
        let (radius, height) = profile[ring as usize];
        let (s, c) = sin_cos(turns);
        // Six merlons on the wall.
        let merlon = ((turns * 12.0 + 0.01) as u32).is_multiple_of(2) && wall.contains(&(ring as usize));
        place.at(radius * c, if merlon { height + 0.45 } else { height }, radius * s)
    });
}

fn queen(b: &mut Builder, place: &Place) {
    let mut profile = stem(1.8, 6.4);
    profile.extend(smooth(&[(0.6, 6.5), (0.72, 7.2), (1.12, 8.1)], 3));
    profile.extend([(0.86, 8.0), (0.8, 7.9), (0.5, 8.15), (0.0, 8.25)]);
    let rim = profile.len() as u32 - 5;
    b.skin(SIDES, profile.len() as u32, |ring, turns| {
        let (radius, height) = profile[ring as usize];
        let (s, c) = sin_cos(turns);
        // Eight points on the coronet.
        let point = if ring == rim { 0.16 * sin_cos(turns * 8.0).1 } else { 0.0 };
        place.at(radius * c, height + point, radius * s)
    });
    let ball = [(0.2, 8.2), (0.34, 8.45), (0.25, 8.7), (0.0, 8.8)];
    b.turn(place, SIDES, &smooth(&ball, 2));
}

fn king(b: &mut Builder, foot: DVec3) {
    let crown = [(0.6, 0.06), (0.75, 0.7), (1.1, 1.7), (0.9, 1.9), (0.3, 2.1), (0.0, 2.15)];
    turned(b, &Place::upright(foot), (1.85, 7.0), &crown);
    let mut bar = |half: DVec3, height: f64| {
        let middle = foot + DVec3::Y * height;
        b.cuboid(middle - half, middle + half);
    };
    bar(DVec3::new(0.16, 0.62, 0.13), 9.7);
    bar(DVec3::new(0.48, 0.15, 0.12), 9.8);
}

/// A horse's head over a low stem: a silhouette, swollen to both sides.
fn knight(b: &mut Builder, place: &Place) {
    let mut base = stem(1.7, 2.2);
    base.push((0.0, 2.25));
    b.turn(place, SIDES, &base);
    // Seen from its right side: (forwards, up), from the breast over the muzzle, ears and mane.
    let silhouette = [
        (0.95, 2.0),
        (1.05, 2.6),
        (0.75, 3.25),
        (0.95, 3.8),
        (1.45, 3.72),
        (1.85, 3.85),
        (1.98, 4.25),
        (1.6, 4.85),
        (1.05, 5.5),
        (0.85, 6.0),
        (0.6, 6.5),
        (0.35, 6.0),
        (-0.25, 5.75),
        (-0.8, 5.2),
        (-1.1, 4.4),
        (-1.2, 3.5),
        (-1.1, 2.6),
        (-0.95, 2.0),
        (0.0, 1.9),
        (0.95, 2.0),
    ];
    let outline = smooth(&silhouette, 3);
    let sides = outline.len() as u32 - 1;
    let (x, y) = (0.1, 4.0);
    // How far out, and how thick there.
    let swell = [(0.0, 0.74), (0.35, 0.72), (0.7, 0.6), (0.9, 0.38), (1.0, 0.0)];
    let rings = 2 * swell.len() as u32 - 1;
    b.skin(sides, rings, |ring, turns| {
        let (part, thick) = swell[ring.min(rings - 1 - ring) as usize];
        let (forwards, up) = outline[(turns * f64::from(sides)).round() as usize];
        let (forwards, up) = (x + (forwards - x) * part, y + (up - y) * part);
        // The head is thinner than the neck.
        let taper = (1.0 - 0.22 * (up - 3.0).max(0.0)).max(0.35);
        place.at(forwards, up, if ring < rings / 2 { thick * taper } else { -thick * taper })
    });
}
