//! Assembles the meshes of the generators from grids, boxes and surfaces of revolution. Points are f64 and are
//! rounded to f32 once.

use super::numeric::{sin_cos, to_f32};
use crate::Mesh;
use glam::DVec3;

pub(super) struct Builder {
    mesh: Mesh,
    /// The material of triangles added from now on.
    pub(super) material: u32,
}

impl Builder {
    pub(super) fn new(name: &str) -> Self {
        let mesh = Mesh {
            name: name.to_owned(),
            positions: Vec::new(),
            triangles: Vec::new(),
            normals: None,
            materials: Vec::new(),
        };
        Builder { mesh, material: 0 }
    }

    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }

    pub(super) fn vertex(&mut self, p: DVec3) -> u32 {
        self.mesh.positions.push(to_f32(p));
        self.mesh.positions.len() as u32 - 1
    }

    pub(super) fn triangle(&mut self, corners: [u32; 3]) {
        self.mesh.triangles.push(corners);
        self.mesh.materials.push(self.material);
    }

    /// Three new vertices and their triangle.
    pub(super) fn loose_triangle(&mut self, corners: [DVec3; 3]) {
        let ids = corners.map(|p| self.vertex(p));
        self.triangle(ids);
    }

    /// Two triangles between four points in order around the edge.
    pub(super) fn quad(&mut self, corners: [DVec3; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    /// `2 * columns * rows` triangles over `surface(u, v)` for u and v from 0 to 1.
    pub(super) fn grid(&mut self, columns: u32, rows: u32, mut surface: impl FnMut(f64, f64) -> DVec3) {
        let first = self.mesh.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                let p = surface(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
                self.vertex(p);
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = first + row * (columns + 1) + column;
                let d = a + columns + 1;
                self.triangle([a, a + 1, d + 1]);
                self.triangle([a, d + 1, d]);
            }
        }
    }

    /// The six faces of a box: 12 triangles.
    pub(super) fn cuboid(&mut self, min: DVec3, max: DVec3) {
        let p = |x: u8, y: u8, z: u8| {
            let pick = |side: u8, low: f64, high: f64| if side == 0 { low } else { high };
            DVec3::new(pick(x, min.x, max.x), pick(y, min.y, max.y), pick(z, min.z, max.z))
        };
        self.quad([p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0)]);
        self.quad([p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)]);
        self.quad([p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)]);
        self.quad([p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1)]);
        self.quad([p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)]);
        self.quad([p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0)]);
    }

    /// A profile `(radius, height)` turned about the vertical axis through `foot`, with its seam shared:
    /// `2 * sides * (profile - 1)` triangles.
    pub(super) fn revolve(&mut self, foot: DVec3, sides: u32, profile: &[(f64, f64)]) {
        let first = self.mesh.positions.len() as u32;
        for &(radius, height) in profile {
            for side in 0..sides {
                let (s, c) = sin_cos(f64::from(side) / f64::from(sides));
                self.vertex(foot + DVec3::new(radius * c, height, radius * s));
            }
        }
        for ring in 0..profile.len() as u32 - 1 {
            for side in 0..sides {
                let next = (side + 1) % sides;
                let low = first + ring * sides;
                let high = low + sides;
                self.triangle([low + side, high + side, high + next]);
                self.triangle([low + side, high + next, low + next]);
            }
        }
    }
}
