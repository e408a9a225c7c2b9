//! The Cornell Box as measured (Cornell University Program of Computer Graphics, "Cornell Box Data", 1998).
//!
//! Lengths are millimetres, axes and corner order as published: x to the left, y up, z into the box. One departure:
//! the published light lies in the plane of the ceiling; here it hangs 0.1 mm below, so that no ray meets two
//! surfaces at one distance. The published blocks have no bottom. 16 quadrilaterals, hence 32 triangles.

use crate::{Camera, Instance, Light, Material, Mesh, Note, RaySelection, Scene};
use glam::Vec3;

const WHITE: u32 = 0;
const RED: u32 = 1;
const GREEN: u32 = 2;
const LIGHT: u32 = 3;

type Quad = [[f32; 3]; 4];

#[rustfmt::skip]
const QUADS: [(u32, Quad); 16] = [
    // floor, light, ceiling, back wall, right wall, left wall
    (WHITE, [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]),
    (LIGHT, [[343.0, 548.7, 227.0], [343.0, 548.7, 332.0], [213.0, 548.7, 332.0], [213.0, 548.7, 227.0]]),
    (WHITE, [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]]),
    (WHITE, [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]]),
    (GREEN, [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]),
    (RED, [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]]),
    // short block
    (WHITE, [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]]),
    (WHITE, [[290.0, 0.0, 114.0], [290.0, 165.0, 114.0], [240.0, 165.0, 272.0], [240.0, 0.0, 272.0]]),
    (WHITE, [[130.0, 0.0, 65.0], [130.0, 165.0, 65.0], [290.0, 165.0, 114.0], [290.0, 0.0, 114.0]]),
    (WHITE, [[82.0, 0.0, 225.0], [82.0, 165.0, 225.0], [130.0, 165.0, 65.0], [130.0, 0.0, 65.0]]),
    (WHITE, [[240.0, 0.0, 272.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0], [82.0, 0.0, 225.0]]),
    // tall block
    (WHITE, [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]]),
    (WHITE, [[423.0, 0.0, 247.0], [423.0, 330.0, 247.0], [472.0, 330.0, 406.0], [472.0, 0.0, 406.0]]),
    (WHITE, [[472.0, 0.0, 406.0], [472.0, 330.0, 406.0], [314.0, 330.0, 456.0], [314.0, 0.0, 456.0]]),
    (WHITE, [[314.0, 0.0, 456.0], [314.0, 330.0, 456.0], [265.0, 330.0, 296.0], [265.0, 0.0, 296.0]]),
    (WHITE, [[265.0, 0.0, 296.0], [265.0, 330.0, 296.0], [423.0, 330.0, 247.0], [423.0, 0.0, 247.0]]),
];

pub(super) fn scene() -> Scene {
    let mut mesh = Mesh {
        name: "cornell".into(),
        positions: vec![],
        triangles: vec![],
        normals: None,
        materials: vec![],
    };
    for (material, quad) in QUADS {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(quad.map(Vec3::from_array));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.materials.extend([material; 2]);
    }
    let light =
        Material { emission: Vec3::new(17.0, 12.0, 4.0), ..Material::matte("light", Vec3::splat(0.78)) };
    Scene {
        name: "cornell".into(),
        meshes: vec![mesh],
        instances: vec![Instance::identity(0)],
        materials: vec![
            Material::matte("white", Vec3::new(0.725, 0.71, 0.68)),
            Material::matte("red", Vec3::new(0.63, 0.065, 0.05)),
            Material::matte("green", Vec3::new(0.14, 0.45, 0.091)),
            light,
        ],
        // Published: position 278 273 -800, direction 0 0 1, focal length 0.035, film 0.025 square.
        camera: Camera {
            eye: Vec3::new(278.0, 273.0, -800.0),
            target: Vec3::new(278.0, 273.0, 0.0),
            up: Vec3::Y,
            vertical_fov_degrees: 39.307_65,
        },
        lights: vec![Light::Point { position: Vec3::new(278.0, 548.0, 279.5) }],
        rays: RaySelection::default(),
        notes: vec![Note::Assumed("The area light is replaced by a point light at its centre.".into())],
    }
}
