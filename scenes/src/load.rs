//! From a name or a path to a scene.

use crate::{
    Camera, Error, Light, Material, Note, RaySelection, Scene, builtin, camera, gltf, mtl, obj, scene_file,
};
use crate::{Instance, Mesh, known_cameras};
use glam::Vec3;
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Component, Path, PathBuf};

/// Most bytes read from one file, and most bytes one `.zst` may expand to.
pub const MAX_FILE_BYTES: u64 = 2 << 30;
/// A `.zst` may expand to this many bytes, and by [`MAX_EXPANSION`] times its length more.
pub const FREE_EXPANSION: u64 = 64 << 20;
/// How much longer than its compressed form a text may be; OBJ files of public scenes are 3 to 9 times as long.
pub const MAX_EXPANSION: u64 = 200;

/// Loads a scene by built-in name or by path: `.obj`, `.obj.zst`, `.gltf`, `.glb`, or a scene file `.toml`.
///
/// A built-in name wins over a file of that name; write `./cornell` for the file.
pub fn load(spec: &str) -> Result<Scene, Error> {
    if let Some(scene) = builtin(spec) {
        return Ok(scene);
    }
    let path = Path::new(spec);
    match Format::of(path)? {
        Format::SceneFile => scene_file::load(path),
        format => load_geometry(path, format)?.into_scene(&stem(path), None, None, None),
    }
}

/// What a geometry file holds, before a camera and lights are chosen. The fields are those of [`Scene`].
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// The meshes, in file order.
    pub meshes: Vec<Mesh>,
    /// Where the meshes stand.
    pub instances: Vec<Instance>,
    /// The materials that meshes refer to.
    pub materials: Vec<Material>,
    /// The camera of the file, where it has one.
    pub camera: Option<Camera>,
    /// What was missing or noticed.
    pub notes: Vec<Note>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Obj,
    ObjZst,
    Gltf,
    SceneFile,
}

impl Format {
    /// The format by extension, once the path is known to be a file.
    pub(crate) fn of(path: &Path) -> Result<Format, Error> {
        let place = path.display().to_string();
        match path.metadata() {
            Ok(m) if m.is_dir() => {
                return Err(Error::new(place, "this is a folder", "name a file inside it"));
            }
            Ok(_) => {}
            Err(e) => {
                let names: Vec<&str> = crate::BUILTINS.iter().map(|b| b.name).collect();
                let remedy = format!("give a file, or one of the built-in scenes: {}", names.join(", "));
                return Err(Error::new(place, format!("cannot open it: {e}"), remedy));
            }
        }
        let lower = path.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        [
            (".obj", Format::Obj),
            (".obj.zst", Format::ObjZst),
            (".gltf", Format::Gltf),
            (".glb", Format::Gltf),
            (".toml", Format::SceneFile),
        ]
        .into_iter()
        .find_map(|(extension, format)| lower.ends_with(extension).then_some(format))
        .ok_or_else(|| {
            Error::new(place, "not a known kind of scene", "expected .obj, .obj.zst, .gltf, .glb or .toml")
        })
    }
}

/// The file name without `.obj.zst` or its one extension.
pub(crate) fn stem(path: &Path) -> String {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.strip_suffix(".zst").unwrap_or(&name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

pub(crate) fn load_geometry(path: &Path, format: Format) -> Result<Geometry, Error> {
    let place = path.display().to_string();
    match format {
        Format::Obj => {
            let file = BufReader::with_capacity(1 << 18, Capped::new(open(path)?, MAX_FILE_BYTES));
            with_materials(obj::read(file, &place)?, path)
        }
        Format::ObjZst => {
            let packed = open(path)?;
            let limit = expansion_limit(packed.metadata().map_or(0, |m| m.len()));
            let decoder = zstd::Decoder::new(packed).map_err(|e| {
                Error::new(&place, format!("cannot decompress: {e}"), "give a zstd-compressed OBJ")
            })?;
            let file = BufReader::with_capacity(1 << 18, Capped::new(decoder, limit));
            with_materials(obj::read(file, &place)?, path)
        }
        Format::Gltf => gltf::load(path),
        Format::SceneFile => {
            Err(Error::new(place, "a scene file as the geometry of a scene file", "name an OBJ or glTF file"))
        }
    }
}

pub(crate) fn open(path: &Path) -> Result<File, Error> {
    File::open(path).map_err(|e| {
        Error::new(
            path.display().to_string(),
            format!("cannot open it: {e}"),
            "check its name and permissions",
        )
    })
}

/// The whole of a file of at most `limit` bytes.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let place = path.display().to_string();
    let mut bytes = Vec::new();
    open(path)?.take(limit + 1).read_to_end(&mut bytes).map_err(|e| {
        Error::new(&place, format!("reading stopped: {e}"), "check that it is a file and whole")
    })?;
    if bytes.len() as u64 > limit {
        return Err(Error::new(place, format!("more than {limit} bytes"), "give a smaller file"));
    }
    Ok(bytes)
}

/// How many bytes a `.zst` of `packed` bytes may expand to, so that a bomb ends soon and not after two gigabytes.
fn expansion_limit(packed: u64) -> u64 {
    packed.saturating_mul(MAX_EXPANSION).saturating_add(FREE_EXPANSION).min(MAX_FILE_BYTES)
}

/// A reader that fails, rather than ends, once more than `limit` bytes came through.
struct Capped<R> {
    inner: R,
    limit: u64,
    read: u64,
}

impl<R> Capped<R> {
    fn new(inner: R, limit: u64) -> Self {
        Capped { inner, limit, read: 0 }
    }
}

impl<R: Read> Read for Capped<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.read += read as u64;
        if self.read > self.limit {
            let problem =
                format!("more than {} bytes of text, the most taken from a file of its length", self.limit);
            return Err(std::io::Error::other(problem));
        }
        Ok(read)
    }
}

/// Where a file named inside another file is looked for: relative to it and inside its folder only.
pub(crate) fn beside(path: &Path, named: &str) -> Option<PathBuf> {
    let relative = PathBuf::from(named.replace('\\', "/"));
    let inside = relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    (inside && !named.is_empty()).then(|| path.parent().unwrap_or(Path::new("")).join(relative))
}

fn with_materials(file: obj::ObjFile, path: &Path) -> Result<Geometry, Error> {
    let obj::ObjFile { mesh, material_names, libraries, mut notes } = file;
    let mut defined: HashMap<String, Material> = HashMap::new();
    for library in &libraries {
        let read = match beside(path, library) {
            Some(file) => read_file(&file, mtl::MAX_BYTES).map_err(|e| e.problem().to_owned()),
            None => Err("it lies outside the folder of the OBJ".to_owned()),
        };
        match read {
            Ok(bytes) => defined.extend(mtl::parse(&bytes).into_iter().map(|m| (m.name.clone(), m))),
            Err(why) => {
                notes.push(Note::Missing(format!("The material library {library} was not read: {why}.")));
            }
        }
    }
    let mut undefined = 0;
    let materials: Vec<Material> = material_names
        .iter()
        .map(|name| match name {
            None => Material::assumed("unnamed"),
            Some(name) => defined.get(name).cloned().unwrap_or_else(|| {
                undefined += 1;
                Material::assumed(name)
            }),
        })
        .collect();
    let named = material_names.iter().flatten().count();
    if undefined > 0 {
        notes.push(Note::Missing(format!(
            "{undefined} of the {named} materials that the file names are not defined; they count as matte grey."
        )));
    } else if named == 0 {
        notes.push(Note::Missing("The file names no materials; all triangles count as matte grey.".into()));
    }
    Ok(Geometry {
        meshes: vec![mesh],
        instances: vec![Instance::identity(0)],
        materials,
        camera: None,
        notes,
    })
}

impl Geometry {
    /// Completes the scene with the given camera, lights and rays, or with ones that are found or assumed.
    pub(crate) fn into_scene(
        self,
        name: &str,
        camera: Option<Camera>,
        lights: Option<Vec<Light>>,
        rays: Option<RaySelection>,
    ) -> Result<Scene, Error> {
        let mut scene = Scene {
            name: name.to_owned(),
            meshes: self.meshes,
            instances: self.instances,
            materials: self.materials,
            camera: Camera { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vertical_fov_degrees: 45.0 },
            lights: Vec::new(),
            rays: rays.unwrap_or_default(),
            notes: self.notes,
        };
        note_degenerate(&mut scene);
        let bounds = scene.bounds();
        let known = known_cameras::find(name);
        scene.camera = match (camera, self.camera, known.and_then(|k| k.view)) {
            (Some(camera), ..) => camera,
            (None, Some(camera), _) => {
                scene.notes.push(Note::Found("The camera is the first one in the file.".into()));
                camera
            }
            (None, None, Some(camera)) => {
                let text = format!("The file has no camera; the published one for {name} is used.");
                scene.notes.push(Note::Assumed(text));
                camera
            }
            (None, None, None) => {
                let text = "The file has no camera; one was placed so that it sees the whole scene.";
                scene.notes.push(Note::Assumed(text.into()));
                Camera::frame(bounds, known.and_then(|k| k.up).unwrap_or(Vec3::Y))
            }
        };
        scene.camera.validate(name)?;
        scene.lights = match (lights, known.and_then(|k| k.light)) {
            (Some(lights), _) => lights,
            (None, Some(position)) => {
                let text = format!("The file has no light; the usual point light for {name} is used.");
                scene.notes.push(Note::Assumed(text));
                vec![Light::Point { position }]
            }
            (None, None) => {
                let text = "The file has no light; a point light was placed above and behind the camera.";
                scene.notes.push(Note::Assumed(text.into()));
                vec![default_light(&scene.camera, bounds)]
            }
        };
        Ok(scene)
    }
}

/// Above and behind the camera, a bounding radius away along its up vector.
pub(crate) fn default_light(camera: &Camera, bounds: crate::Aabb) -> Light {
    let (_, radius) = camera::bounding_sphere(bounds);
    let up = camera.up.as_dvec3() / f64::from(camera.up.abs().max_element());
    let up = up / up.dot(up).sqrt();
    let back = camera.eye.as_dvec3() - camera.target.as_dvec3();
    let back = back / back.abs().max_element();
    let back = back / back.dot(back).sqrt();
    let limit = glam::DVec3::splat(f64::from(f32::MAX));
    let position = camera.eye.as_dvec3() + (up + back * 0.25) * radius;
    Light::Point { position: position.clamp(-limit, limit).as_vec3() }
}

fn note_degenerate(scene: &mut Scene) {
    let (mut degenerate, mut all) = (0, 0);
    for triangle in scene.triangles() {
        degenerate += usize::from(triangle.is_degenerate());
        all += 1;
    }
    if degenerate > 0 {
        let text =
            format!("{degenerate} of {all} triangles have no area; they are kept, so that ids do not shift.");
        scene.notes.push(Note::Found(text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    #[test]
    fn text_at_the_limit_is_read_and_one_byte_more_is_refused() {
        let read = |limit| obj::read(BufReader::new(Capped::new(TRIANGLE, limit)), "bomb.obj.zst");
        assert!(read(TRIANGLE.len() as u64).is_ok());
        let e = read(TRIANGLE.len() as u64 - 1).unwrap_err();
        assert!(e.problem().contains("more than 31 bytes"), "{e}");
    }

    #[test]
    fn a_bomb_of_line_ends_is_stopped_by_the_limit() {
        let endless = BufReader::new(Capped::new(std::io::repeat(b'\n'), 1 << 20));
        assert!(obj::read(endless, "bomb.obj").is_err());
    }

    #[test]
    fn a_compressed_file_may_expand_by_its_length_up_to_the_file_limit() {
        assert_eq!(expansion_limit(0), FREE_EXPANSION);
        assert_eq!(expansion_limit(1000), FREE_EXPANSION + 1000 * MAX_EXPANSION);
        assert_eq!(expansion_limit(u64::MAX), MAX_FILE_BYTES);
    }

    #[test]
    fn stems_lose_one_extension_and_zst() {
        for (path, name) in [("a/b.obj.zst", "b"), ("b.v2.obj", "b.v2"), ("b.glb", "b"), ("b", "b")] {
            assert_eq!(stem(Path::new(path)), name);
        }
    }

    #[test]
    fn files_are_found_beside_and_below_but_never_above() {
        let path = Path::new("dir/a.obj");
        assert_eq!(beside(path, "sub\\m.mtl"), Some(PathBuf::from("dir/sub/m.mtl")));
        assert_eq!(beside(path, "./m.mtl"), Some(PathBuf::from("dir/./m.mtl")));
        for outside in ["../m.mtl", "/etc/m.mtl", "sub/../../m.mtl", "", "..\\m.mtl"] {
            assert_eq!(beside(path, outside), None, "{outside}");
        }
    }
}
