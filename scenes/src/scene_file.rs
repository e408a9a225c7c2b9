//! Scene files (`.toml`): a geometry file with the camera, the lights and the rays to trace it with.
//!
//! ```toml
//! geometry = "sponza.obj.zst"         # beside this file, or a built-in name
//!
//! [camera]                            # optional
//! eye = [-1000.0, 350.0, -30.0]
//! target = [900.0, 400.0, 40.0]
//! up = [0.0, 1.0, 0.0]                # optional, y is up
//! vertical_fov_degrees = 60.0
//!
//! [[lights]]                          # optional
//! kind = "point"
//! position = [0.0, 1200.0, 50.0]
//!
//! [rays]                              # optional, as are its keys; these are their defaults
//! primary = true
//! shadow = true                       # to the middle of each light
//! soft_shadows = false                # to points of the sphere that each light is
//! mirror = false
//! glossy = false
//! ambient_occlusion = false
//! diffuse = false
//! samples = 1                         # per pixel, of each set that is drawn at random
//! seed = 0
//! roughness = { mirror = 0.1, glossy = 0.4 }  # up to which surfaces send reflection rays
//! # light_radius = 10.0               # of the spheres; else 1/20 of the scene's radius
//! # ambient_occlusion_radius = 50.0   # how far its rays reach; else 1/10 of the scene's radius
//! ```
//!
//! Unknown keys are refused.

use crate::load::{Format, load_geometry, read_file, stem};
use crate::{Camera, Error, Light, RaySelection, Scene, builtin};
use glam::Vec3;
use serde::Deserialize;
use std::path::Path;

/// Longest scene file read, in bytes.
pub const MAX_BYTES: u64 = 1 << 20;

/// A scene file as written, before its geometry is loaded.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// A path relative to the scene file, or a built-in name.
    pub geometry: String,
    /// The camera; without one, the scene's own or a framed one is taken.
    pub camera: Option<Camera>,
    /// The lights; without the key, the scene's own or a default one is taken. An empty list means no light.
    pub lights: Option<Vec<PointLight>>,
    /// Which rays to trace.
    pub rays: Option<RaySelection>,
}

/// A light as written in a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointLight {
    /// The only kind so far is `"point"`.
    pub kind: LightKind,
    /// Where it is, in world space.
    pub position: Vec3,
}

/// The kinds of light a scene file can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightKind {
    /// Shines from one point.
    Point,
}

/// Parses the text of a scene file and checks what can be checked without its geometry.
pub fn parse(bytes: &[u8], name: &str) -> Result<SceneFile, Error> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Error::new(name, "the file is not UTF-8 text", "a scene file is TOML"))?;
    let file: SceneFile = toml::from_str(text).map_err(|e| {
        let error = Error::new(
            name,
            e.message().trim().replace('\n', ", "),
            "see the documented form of a scene file",
        );
        match e.span() {
            Some(span) => error.at_line(1 + text[..span.start].matches('\n').count() as u64),
            None => error,
        }
    })?;
    if let Some(camera) = &file.camera {
        camera.validate(name)?;
    }
    if let Some(rays) = &file.rays {
        rays.validate(name)?;
    }
    if file.lights.iter().flatten().any(|light| !light.position.is_finite()) {
        return Err(Error::new(name, "a light's position is not finite", "give finite numbers"));
    }
    Ok(file)
}

/// Loads a scene file and the geometry it names.
pub(crate) fn load(path: &Path) -> Result<Scene, Error> {
    let place = path.display().to_string();
    let file = parse(&read_file(path, MAX_BYTES)?, &place)?;
    let lights = file
        .lights
        .map(|lights| lights.into_iter().map(|light| Light::Point { position: light.position }).collect());
    if let Some(mut scene) = builtin(&file.geometry) {
        scene.name = stem(path);
        scene.camera = file.camera.unwrap_or(scene.camera);
        scene.lights = lights.unwrap_or(scene.lights);
        scene.rays = file.rays.unwrap_or(scene.rays);
        return Ok(scene);
    }
    let geometry = path.parent().unwrap_or(Path::new("")).join(&file.geometry);
    let format = Format::of(&geometry)?;
    let scene =
        load_geometry(&geometry, format)?.into_scene(&stem(&geometry), file.camera, lights, file.rays)?;
    Ok(Scene { name: stem(path), ..scene })
}
