//! Triangles, boxes, indexed meshes and their placements in the world.

use glam::{Affine3A, Vec3};

/// A triangle in world space, its corners in file order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The three corners.
    pub v: [Vec3; 3],
}

impl Triangle {
    /// True when the corners lie on one line or one point, so that the triangle has no area.
    ///
    /// Computed in f64, where edges of f32 corners are exact unless their exponents differ by more than 29: thin
    /// slivers, and triangles whose area f32 could not hold, do not count as degenerate.
    pub fn is_degenerate(&self) -> bool {
        let [a, b, c] = self.v.map(Vec3::as_dvec3);
        (b - a).cross(c - a) == glam::DVec3::ZERO
    }
}

/// An axis-aligned box. The empty box has `min` at plus infinity and `max` at minus infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The smallest coordinates.
    pub min: Vec3,
    /// The largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Aabb::EMPTY, |b, p| Aabb { min: b.min.min(p), max: b.max.max(p) })
    }

    /// True when no point lies inside.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }
}

/// Shading normals of a mesh: vectors, and for each triangle the three it uses.
#[derive(Clone, Debug, PartialEq)]
pub struct Normals {
    /// The vectors as the file has them, not normalised.
    pub vectors: Vec<Vec3>,
    /// For each triangle three indices into `vectors`, or `None` where the file gives none.
    pub triangles: Vec<Option<[u32; 3]>>,
}

/// An indexed triangle mesh in its own space. Triangle order is file order.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The name in the file, or of the generator.
    pub name: String,
    /// Vertex positions, all finite.
    pub positions: Vec<Vec3>,
    /// For each triangle three indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals, where the file has them.
    pub normals: Option<Normals>,
    /// For each triangle its index into [`Scene::materials`](crate::Scene::materials).
    pub materials: Vec<u32>,
}

impl Mesh {
    /// The corners of triangle `index`, in the space of the mesh.
    pub fn triangle(&self, index: usize) -> Triangle {
        Triangle { v: self.triangles[index].map(|i| self.positions[i as usize]) }
    }
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`](crate::Scene::meshes).
    pub mesh: u32,
    /// From the space of the mesh to the world.
    pub transform: Affine3A,
}

impl Instance {
    /// The mesh `mesh` where it is, untransformed.
    pub fn identity(mesh: u32) -> Self {
        Instance { mesh, transform: Affine3A::IDENTITY }
    }

    /// Where point `p` of the mesh lies in the world.
    ///
    /// Written out in scalar f32, because vector code paths may fuse the multiply and the add on some platforms,
    /// and world coordinates must have the same bits everywhere. The identity returns `p` unchanged, signs of
    /// zero included.
    pub fn transform_point(&self, p: Vec3) -> Vec3 {
        if self.transform == Affine3A::IDENTITY {
            return p;
        }
        let m = &self.transform.matrix3;
        let t = self.transform.translation;
        let row = |x: f32, y: f32, z: f32, w: f32| x * p.x + y * p.y + z * p.z + w;
        Vec3::new(
            row(m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x),
            row(m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y),
            row(m.x_axis.z, m.y_axis.z, m.z_axis.z, t.z),
        )
    }
}
