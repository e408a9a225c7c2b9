//! The node tree of a glTF file, flattened into instances.

use crate::{Camera, Error, Instance, MAX_TRIANGLES, MAX_VERTICES, Mesh};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use gltf::json::Root;
use gltf::json::scene::Node;

/// What the nodes place in the world.
pub(super) struct Placed {
    pub(super) instances: Vec<Instance>,
    pub(super) camera: Option<Camera>,
}

/// Walks the default scene depth-first in file order; without scenes, all nodes that have no parent.
pub(super) fn place(root: &Root, meshes: &[Mesh], name: &str) -> Result<Placed, Error> {
    let error = |problem: String| {
        Error::new(name, problem, "export it again: nodes must form trees, and the scene must hold triangles")
    };
    let mut placed = Placed { instances: Vec::new(), camera: None };
    let (mut triangles, mut vertices) = (0usize, 0usize);
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, Transform)> =
        roots(root).map_err(&error)?.into_iter().rev().map(|n| (n, Transform::IDENTITY)).collect();
    while let Some((id, parent)) = stack.pop() {
        let node = root.nodes.get(id).ok_or_else(|| error(format!("nodes[{id}] does not exist")))?;
        if std::mem::replace(&mut visited[id], true) {
            return Err(error(format!("nodes[{id}] is reached twice, by a cycle or by two parents")));
        }
        let world = parent.then(&Transform::of(node));
        if let Some(mesh) = node.mesh {
            let mesh_id = mesh.value();
            let mesh = meshes.get(mesh_id).ok_or_else(|| {
                error(format!("nodes[{id}] places meshes[{mesh_id}], which does not exist"))
            })?;
            triangles = triangles.saturating_add(mesh.triangles.len());
            vertices = vertices.saturating_add(mesh.positions.len());
            if triangles > MAX_TRIANGLES || vertices > MAX_VERTICES {
                let problem =
                    format!("all instances together have more than {MAX_TRIANGLES} triangles or vertices");
                return Err(error(problem));
            }
            let instance = Instance { mesh: mesh_id as u32, transform: world.affine() };
            if !mesh.positions.iter().all(|&p| instance.transform_point(p).is_finite()) {
                return Err(error(format!("nodes[{id}] moves a vertex to where f32 does not reach")));
            }
            placed.instances.push(instance);
        }
        if placed.camera.is_none() {
            placed.camera = camera(root, node, &world);
        }
        stack.extend(node.children.iter().flatten().rev().map(|c| (c.value(), world)));
    }
    if triangles == 0 {
        return Err(error("no triangle in the default scene".into()));
    }
    Ok(placed)
}

fn roots(root: &Root) -> Result<Vec<usize>, String> {
    let default = root.scene.map_or(0, |s| s.value());
    match root.scenes.get(default) {
        Some(scene) => Ok(scene.nodes.iter().map(|n| n.value()).collect()),
        None if root.scene.is_some() => Err(format!("scenes[{default}] does not exist")),
        None => {
            let mut parentless = vec![true; root.nodes.len()];
            for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
                if let Some(p) = parentless.get_mut(child.value()) {
                    *p = false;
                }
            }
            Ok((0..root.nodes.len()).filter(|&n| parentless[n]).collect())
        }
    }
}

/// A perspective camera looks along -z of its node, with +y up.
fn camera(root: &Root, node: &Node, world: &Transform) -> Option<Camera> {
    let perspective = root.cameras.get(node.camera?.value())?.perspective.as_ref()?;
    let [_, y, z, eye] = world.columns.map(|c| Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32));
    let vertical_fov_degrees = (f64::from(perspective.yfov) * (180.0 / std::f64::consts::PI)) as f32;
    let camera = Camera { eye, target: eye - z, up: y, vertical_fov_degrees };
    camera.validate("").is_ok().then_some(camera)
}

/// An affine map as columns x, y, z and translation, in f64 and scalar code so that every platform agrees.
#[derive(Clone, Copy)]
struct Transform {
    columns: [[f64; 3]; 4],
}

impl Transform {
    const IDENTITY: Transform =
        Transform { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]] };

    /// The local transform of a node: its matrix, or translation * rotation * scale.
    fn of(node: &Node) -> Transform {
        if let Some(m) = node.matrix {
            let column = |c: usize| [m[4 * c], m[4 * c + 1], m[4 * c + 2]].map(f64::from);
            return Transform { columns: [column(0), column(1), column(2), column(3)] };
        }
        let [x, y, z, w] = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0).map(f64::from);
        let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let column = |c: usize| rotation[c].map(|v| v * scale[c]);
        let translation = node.translation.unwrap_or([0.0; 3]).map(f64::from);
        Transform { columns: [column(0), column(1), column(2), translation] }
    }

    /// `inner` first, then `self`.
    fn then(&self, inner: &Transform) -> Transform {
        let [x, y, z, t] = self.columns;
        let mut columns = inner.columns.map(|v| [0, 1, 2].map(|r| x[r] * v[0] + y[r] * v[1] + z[r] * v[2]));
        for (value, shift) in columns[3].iter_mut().zip(t) {
            *value += shift;
        }
        Transform { columns }
    }

    fn affine(&self) -> Affine3A {
        let [x, y, z, t] = self.columns.map(|c| Vec3A::new(c[0] as f32, c[1] as f32, c[2] as f32));
        Affine3A { matrix3: Mat3A::from_cols(x, y, z), translation: t }
    }
}
