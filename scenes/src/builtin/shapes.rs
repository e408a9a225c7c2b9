//! Shapes of the generators that are turned, swept or carried around: skins over rings of points. Where a ring is one
//! point, the skin is closed there by a fan; one with such a pole at both ends is closed, and its triangles are
//! counter-clockwise seen from outside where the rings follow a profile that runs up on the outside.

use super::builder::Builder;
use super::numeric::sin_cos;
use glam::DVec3;

/// A point and three perpendicular axes of length 1, right-handed; shapes are turned about y.
#[derive(Clone, Copy)]
pub(super) struct Place {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl Place {
    /// Axes as the world's.
    pub(super) fn upright(origin: DVec3) -> Self {
        Place { origin, x: DVec3::X, y: DVec3::Y, z: DVec3::Z }
    }

    /// Upright, turned so that x points `turns` of a whole turn from the world's x towards its z.
    pub(super) fn turned(origin: DVec3, turns: f64) -> Self {
        let (s, c) = sin_cos(turns);
        Place { origin, x: DVec3::new(c, 0.0, s), y: DVec3::Y, z: DVec3::new(-s, 0.0, c) }
    }

    /// With y along `axis`, of any length but 0.
    pub(super) fn along(origin: DVec3, axis: DVec3) -> Self {
        let y = unit(axis);
        let helper = if y.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
        let x = unit(helper.cross(y));
        Place { origin, x, y, z: x.cross(y) }
    }

    pub(super) fn at(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.origin + self.x * x + self.y * y + self.z * z
    }
}

fn unit(v: DVec3) -> DVec3 {
    v / v.dot(v).sqrt()
}

/// A Catmull-Rom curve through `points`, `steps` pieces between two of them.
pub(super) fn smooth(points: &[(f64, f64)], steps: u32) -> Vec<(f64, f64)> {
    let last = points.len() - 1;
    let beyond = |end: (f64, f64), next: (f64, f64)| (2.0 * end.0 - next.0, 2.0 * end.1 - next.1);
    let mut curve = vec![points[0]];
    for i in 0..last {
        let (b, c) = (points[i], points[i + 1]);
        let a = if i == 0 { beyond(b, c) } else { points[i - 1] };
        let d = if i + 1 == last { beyond(c, b) } else { points[i + 2] };
        for step in 1..=steps {
            let t = f64::from(step) / f64::from(steps);
            let blend = |a: f64, b: f64, c: f64, d: f64| {
                b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
            };
            curve.push(if step == steps {
                c
            } else {
                (blend(a.0, b.0, c.0, d.0), blend(a.1, b.1, c.1, d.1))
            });
        }
    }
    curve
}

/// The value at `x` of the curve that is given at increasing places: straight between two of them.
pub(super) fn interpolated(curve: &[(f64, f64)], x: f64) -> f64 {
    let after = curve.iter().position(|&(place, _)| place > x).unwrap_or(curve.len() - 1).max(1);
    let ((x0, y0), (x1, y1)) = (curve[after - 1], curve[after]);
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}

/// The square root of the size, with the sign: of sine and cosine, it makes a circle a superellipse of exponent 4.
pub(super) fn signed_sqrt(v: f64) -> f64 {
    v.abs().sqrt().copysign(v)
}

impl Builder {
    /// A skin over rings of `sides` points `at(ring, turns)`, closed around: two triangles for each side between two
    /// rings, one where a ring is a pole.
    pub(super) fn skin(&mut self, sides: u32, rings: u32, mut at: impl FnMut(u32, f64) -> DVec3) {
        let mut below: Vec<u32> = Vec::new();
        for ring in 0..rings {
            let points: Vec<DVec3> =
                (0..sides).map(|side| at(ring, f64::from(side) / f64::from(sides))).collect();
            let ids = if points.iter().all(|&p| p == points[0]) {
                vec![self.vertex(points[0]); sides as usize]
            } else {
                points.into_iter().map(|p| self.vertex(p)).collect()
            };
            for side in 0..below.len() {
                let next = (side + 1) % below.len();
                let (a, b, c, d) = (below[side], ids[side], ids[next], below[next]);
                if b != c {
                    self.triangle([a, b, c]);
                }
                if a != d {
                    self.triangle([a, c, d]);
                }
            }
            below = ids;
        }
    }

    /// A profile `(radius, height)` turned about the y axis of `place`; a radius of 0 is a pole.
    pub(super) fn turn(&mut self, place: &Place, sides: u32, profile: &[(f64, f64)]) {
        self.skin(sides, profile.len() as u32, |ring, turns| {
            let (radius, height) = profile[ring as usize];
            let (s, c) = sin_cos(turns);
            place.at(radius * c, height, radius * s)
        });
    }

    /// The six faces of a box between two corners in the axes of `place`: 12 triangles.
    pub(super) fn block(&mut self, place: &Place, min: DVec3, max: DVec3) {
        let corner = |i: usize| {
            let pick = |bit: usize, low: f64, high: f64| if i & bit == 0 { low } else { high };
            place.at(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
        };
        for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]] {
            self.quad(face.map(corner));
        }
    }

    /// A closed ellipsoid about the origin of `place`: `2 * sides * (rings - 1)` triangles.
    pub(super) fn ellipsoid(&mut self, place: &Place, half: DVec3, sides: u32, rings: u32) {
        self.rounded(place, half, sides, rings, |v| v);
    }

    /// A closed superellipsoid of exponent 4, a box with round edges: `2 * sides * (rings - 1)` triangles.
    pub(super) fn cushion(&mut self, place: &Place, half: DVec3, sides: u32, rings: u32) {
        self.rounded(place, half, sides, rings, signed_sqrt);
    }

    fn rounded(&mut self, place: &Place, half: DVec3, sides: u32, rings: u32, shape: impl Fn(f64) -> f64) {
        self.skin(sides, rings + 1, |ring, turns| {
            if ring == 0 || ring == rings {
                return place.at(0.0, if ring == 0 { -half.y } else { half.y }, 0.0);
            }
            let (height, radius) = sin_cos(f64::from(ring) / f64::from(rings) * 0.5 - 0.25);
            let (s, c) = sin_cos(turns);
            let out = shape(radius);
            place.at(half.x * out * shape(c), half.y * shape(height), half.z * out * shape(s))
        });
    }

    /// A closed pipe of round section along a path without sharp turns.
    pub(super) fn pipe(&mut self, path: &[DVec3], radius: f64, sides: u32) {
        let last = path.len() - 1;
        let whole = unit(path[last] - path[0]).abs();
        let helper = match whole {
            w if w.x <= w.y && w.x <= w.z => DVec3::X,
            w if w.y <= w.z => DVec3::Y,
            _ => DVec3::Z,
        };
        self.skin(sides, path.len() as u32 + 2, |ring, turns| {
            let i = (ring as usize).saturating_sub(1).min(last);
            if ring == 0 || ring as usize == last + 2 {
                return path[i];
            }
            let y = unit(path[(i + 1).min(last)] - path[i.saturating_sub(1)]);
            let x = unit(helper.cross(y));
            let (s, c) = sin_cos(turns);
            path[i] + (x * c + x.cross(y) * s) * radius
        });
    }

    /// A closed sheet between two faces over the same grid: `4 * (columns * rows + columns + rows)` triangles. They are
    /// counter-clockwise seen from outside where u, v and the way from `inner` to `outer` are right-handed.
    pub(super) fn sheet(
        &mut self,
        [columns, rows]: [u32; 2],
        outer: impl Fn(f64, f64) -> DVec3,
        inner: impl Fn(f64, f64) -> DVec3,
    ) {
        let at = |ids: &[u32], (column, row): (u32, u32)| ids[(row * (columns + 1) + column) as usize];
        let (outer, inner) = (self.lattice([columns, rows], outer), self.lattice([columns, rows], inner));
        let (outer, inner) = (|place| at(&outer, place), |place| at(&inner, place));
        let mut quad = |[a, b, c, d]: [u32; 4]| {
            self.triangle([a, b, c]);
            self.triangle([a, c, d]);
        };
        for row in 0..rows {
            for column in 0..columns {
                let (right, up) = (column + 1, row + 1);
                quad([(column, row), (right, row), (right, up), (column, up)].map(outer));
                quad([(column, row), (column, up), (right, up), (right, row)].map(inner));
            }
        }
        let mut rim = |from, to| quad([inner(from), inner(to), outer(to), outer(from)]);
        for column in 0..columns {
            rim((column, 0), (column + 1, 0));
            rim((column + 1, rows), (column, rows));
        }
        for row in 0..rows {
            rim((columns, row), (columns, row + 1));
            rim((0, row + 1), (0, row));
        }
    }

    /// Vertices over a grid, row by row.
    fn lattice(&mut self, [columns, rows]: [u32; 2], surface: impl Fn(f64, f64) -> DVec3) -> Vec<u32> {
        let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
        let part = |step: u32, of: u32| f64::from(step) / f64::from(of);
        places.map(|(column, row)| self.vertex(surface(part(column, columns), part(row, rows)))).collect()
    }

    /// A floor at height 0 that bends up into a wall behind, as in a photographer's studio: `800` triangles.
    ///
    /// It reaches from `front` to `back` along z and `half_width` to both sides, and `height` up.
    pub(super) fn backdrop(&mut self, half_width: f64, [front, back]: [f64; 2], height: f64) {
        let bend = height * 0.5;
        self.grid(20, 20, |u, v| {
            let x = (u * 2.0 - 1.0) * half_width;
            let (y, z) = match (v * 20.0).round() {
                row if row < 8.0 => (0.0, front + (back + bend - front) * row / 8.0),
                row if row < 16.0 => {
                    let (s, c) = sin_cos((row - 8.0) / 8.0 * 0.25);
                    (bend * (1.0 - c), back + bend * (1.0 - s))
                }
                row => (bend + (height - bend) * (row - 16.0) / 4.0, back),
            };
            DVec3::new(x, y, z)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, Vec3};
    use std::collections::HashMap;

    /// The volume that a closed mesh has inside; positive where its triangles are counter-clockwise seen from outside.
    fn volume(shape: impl Fn(&mut Builder)) -> f64 {
        let mut b = Builder::new("shape");
        shape(&mut b);
        let mesh: Mesh = b.finish();
        let mut edges = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                assert_eq!(edges.insert(edge, ()), None, "an edge in two triangles of one direction");
            }
        }
        assert!(edges.keys().all(|&(a, b)| edges.contains_key(&(b, a))), "it is open");
        let six = |i: usize| {
            let [a, b, c] = mesh.triangle(i).v.map(Vec3::as_dvec3);
            a.dot(b.cross(c))
        };
        (0..mesh.triangles.len()).map(six).sum::<f64>() / 6.0
    }

    #[test]
    fn closed_shapes_are_closed_and_have_their_volume_inside() {
        let place = Place::along(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -0.4, 1.0));
        let half = DVec3::new(1.0, 0.5, 2.0);
        let straight = [place.at(0.0, 0.0, 0.0), place.at(0.0, 1.0, 0.0), place.at(0.0, 2.0, 0.0)];
        let face = |y: f64| move |u: f64, v: f64| place.at(v, y, u);
        let circle = std::f64::consts::PI;
        for (name, found, expected) in [
            ("ellipsoid", volume(|b| b.ellipsoid(&place, half, 64, 32)), 4.0 / 3.0 * circle),
            ("cone", volume(|b| b.turn(&place, 64, &[(0.0, 0.0), (1.0, 0.0), (0.0, 3.0)])), circle),
            ("pipe", volume(|b| b.pipe(&straight, 0.5, 64)), circle * 0.5),
            ("sheet", volume(|b| b.sheet([5, 7], face(0.2), face(0.0))), 0.2),
        ] {
            assert!((found / expected - 1.0).abs() < 0.01, "{name}: {found}, not {expected}");
        }
        // Between the ellipsoid and the box.
        let cushion = volume(|b| b.cushion(&place, half, 64, 32));
        assert!((4.0 / 3.0 * circle..8.0).contains(&cushion), "{cushion}");
    }

    #[test]
    fn a_curve_passes_its_points_and_a_straight_one_stays_straight() {
        let points = [(0.0, 1.0), (2.0, 3.0), (3.0, -1.0), (7.0, 0.0)];
        let curve = smooth(&points, 4);
        assert_eq!(curve.len(), 13);
        assert!((0..4).all(|i| curve[4 * i] == points[i]));
        let line = smooth(&[(0.0, 0.0), (1.0, 2.0), (2.0, 4.0)], 3);
        assert!(line.iter().all(|&(x, y)| (y - 2.0 * x).abs() < 1e-12), "{line:?}");
    }

    #[test]
    fn between_its_places_a_curve_is_straight_and_beyond_them_it_keeps_its_ends() {
        let curve = [(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)];
        for (x, y) in
            [(0.0, 10.0), (1.0, 10.0), (1.5, 15.0), (2.0, 20.0), (3.0, 10.0), (4.0, 0.0), (9.0, 0.0)]
        {
            assert_eq!(interpolated(&curve, x), y, "at {x}");
        }
    }
}
