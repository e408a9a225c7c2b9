//! glTF 2.0 scenes, as text (`.gltf`) or binary (`.glb`): positions, indices, normals, materials, node transforms
//! as instances, and the first perspective camera. Images, animation, skins and morph targets are not read.
//!
//! Order: instances in depth-first order of the nodes, then primitives and triangles in file order. Strips and fans
//! are unrolled with the orientation the specification gives them.
//!
//! The JSON goes through the schema types of the gltf crate. Its validator and readers are not used: the validator
//! indexes out of bounds on a wrong accessor number, and the readers trust the sizes a file claims. Here every index
//! and every byte range is checked, and nothing is allocated for an element that the file does not contain.

mod accessor;
mod container;
mod nodes;

use crate::load::{Geometry, MAX_FILE_BYTES, beside, read_file};
use crate::{Error, MAX_TRIANGLES, MAX_VERTICES, Material, Mesh, Normals, Note, Reflection};
use accessor::Buffers;
use glam::Vec3;
use gltf::json::validation::Checked;
use gltf::json::{self, Root, mesh::Mode};
use gltf::mesh::Semantic;
use std::collections::HashMap;
use std::path::Path;

/// Longest JSON part read, in bytes.
pub const MAX_JSON_BYTES: usize = 256 << 20;
/// Most JSON objects in a file; each can cost a few hundred bytes of memory.
pub const MAX_JSON_OBJECTS: usize = 1 << 20;

/// Required extensions that leave the triangles as they are.
const HARMLESS_EXTENSIONS: [&str; 3] = ["KHR_materials_", "KHR_texture_", "KHR_lights_punctual"];

pub(crate) fn load(path: &Path) -> Result<Geometry, Error> {
    let bytes = read_file(path, MAX_FILE_BYTES)?;
    parse(&bytes, &path.display().to_string(), |uri, limit| match beside(path, uri) {
        Some(file) => read_file(&file, limit).map_err(|e| e.problem().to_owned()),
        None => Err("it lies outside the folder of the file".to_owned()),
    })
}

/// Parses a whole `.gltf` or `.glb`. `fetch` returns the bytes of a buffer file, at most as many as given, by its
/// decoded relative path, or says why it cannot; `name` stands for the file in errors.
pub fn parse(
    bytes: &[u8],
    name: &str,
    fetch: impl FnMut(&str, u64) -> Result<Vec<u8>, String>,
) -> Result<Geometry, Error> {
    if bytes.is_empty() {
        return Err(Error::new(name, "the file is empty (0 bytes)", "give a glTF 2.0 file"));
    }
    let (text, blob) = container::split(bytes, name)?;
    let root = read_json(text, name)?;
    let buffers = Buffers { bytes: container::buffers(&root, blob, name, fetch)?, root: &root, name };
    let mut reader = Reader { buffers, vertices: 0, triangles: 0, skipped: 0, some_without_material: false };
    let meshes = root
        .meshes
        .iter()
        .enumerate()
        .map(|(index, mesh)| reader.mesh(index, mesh))
        .collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    if reader.skipped > 0 {
        let text = format!("{} primitives are points or lines and were skipped.", reader.skipped);
        notes.push(Note::Missing(text));
    }
    let without_normals = meshes.iter().filter(|m| m.normals.is_none()).count();
    if without_normals > 0 {
        let text = format!("{without_normals} of {} meshes have no shading normals.", meshes.len());
        notes.push(Note::Missing(text));
    }
    let mut materials: Vec<Material> = root.materials.iter().enumerate().map(material).collect();
    if reader.some_without_material {
        materials.push(Material::assumed("unnamed"));
        notes.push(Note::Missing("Some primitives have no material; they count as matte grey.".into()));
    }
    let placed = nodes::place(&root, &meshes, name)?;
    Ok(Geometry { meshes, instances: placed.instances, materials, camera: placed.camera, notes })
}

fn read_json(text: &[u8], name: &str) -> Result<Root, Error> {
    if text.len() > MAX_JSON_BYTES || text.iter().filter(|&&b| b == b'{').count() > MAX_JSON_OBJECTS {
        return Err(Error::new(
            name,
            format!("the JSON part has more than {MAX_JSON_BYTES} bytes or {MAX_JSON_OBJECTS} objects"),
            "split the scene, and keep buffers in .bin files or use .glb",
        ));
    }
    let root: Root = json::deserialize::from_slice(text).map_err(|e| {
        Error::new(name, format!("not glTF 2.0: {e}"), "give a .gltf or .glb as an exporter writes it")
            .at_line(e.line() as u64)
    })?;
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        let problem = format!("the asset has glTF version '{version}', expected 2.x");
        return Err(Error::new(name, problem, "export it as glTF 2.0"));
    }
    let unknown = |e: &&String| !HARMLESS_EXTENSIONS.iter().any(|known| e.starts_with(known));
    if let Some(extension) = root.extensions_required.iter().find(unknown) {
        let problem = format!("the file requires the extension {extension}, which is not supported");
        return Err(Error::new(name, problem, "export it without compression or quantisation"));
    }
    Ok(root)
}

struct Reader<'a> {
    buffers: Buffers<'a>,
    /// Vertices, triangles and point or line primitives so far, over all meshes.
    vertices: usize,
    triangles: usize,
    skipped: usize,
    /// Some primitives name no material; their material id is the one after the last of the file.
    some_without_material: bool,
}

impl Reader<'_> {
    fn error(&self, mesh: usize, problem: impl std::fmt::Display) -> Error {
        let remedy = "the file is damaged or unusual: export it again";
        Error::new(self.buffers.name, format!("meshes[{mesh}]: {problem}"), remedy)
    }

    fn mesh(&mut self, index: usize, source: &json::Mesh) -> Result<Mesh, Error> {
        let mut mesh = Mesh {
            name: source.name.clone().unwrap_or_else(|| format!("mesh {index}")),
            positions: Vec::new(),
            triangles: Vec::new(),
            normals: None,
            materials: Vec::new(),
        };
        let mut normals = Normals { vectors: Vec::new(), triangles: Vec::new() };
        // Primitives often share one vertex buffer: each accessor is decoded once per mesh.
        let (mut decoded, mut decoded_normals) = (HashMap::new(), HashMap::new());
        for primitive in &source.primitives {
            let Checked::Valid(mode) = primitive.mode else {
                return Err(self.error(index, "a primitive has an unknown mode"));
            };
            if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                self.skipped += 1;
                continue;
            }
            let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value());
            let positions = attribute(Semantic::Positions)
                .ok_or_else(|| self.error(index, "a primitive has no POSITION attribute"))?;
            let (first, count) = self.vectors(positions, &mut mesh.positions, &mut decoded, index)?;
            if let Some(bad) = mesh.positions[first..first + count].iter().position(|p| !p.is_finite()) {
                return Err(
                    self.error(index, format!("vertex {bad} of accessors[{positions}] is not finite"))
                );
            }
            let shading = match attribute(Semantic::Normals) {
                None => None,
                Some(n) => {
                    let (first_normal, normal_count) =
                        self.vectors(n, &mut normals.vectors, &mut decoded_normals, index)?;
                    if normal_count != count {
                        let problem = format!("{normal_count} normals for {count} positions");
                        return Err(self.error(index, problem));
                    }
                    let finite =
                        normals.vectors[first_normal..first_normal + count].iter().all(|v| v.is_finite());
                    finite.then_some(first_normal)
                }
            };
            let corners = match primitive.indices {
                Some(indices) => self.buffers.indices(indices.value())?,
                None => (0..count as u32).collect(),
            };
            if let Some(bad) = corners.iter().find(|&&i| i as usize >= count) {
                return Err(
                    self.error(index, format!("vertex index {bad}, but the primitive has {count} vertices"))
                );
            }
            let triangles = assemble(mode, &corners);
            self.triangles += triangles.len();
            if self.triangles > MAX_TRIANGLES {
                return Err(self.error(index, format!("more than {MAX_TRIANGLES} triangles up to here")));
            }
            let known = self.buffers.root.materials.len();
            let material = match primitive.material.map(|m| m.value()) {
                Some(m) if m < known => m as u32,
                Some(m) => {
                    return Err(self.error(index, format!("a primitive uses materials[{m}], of {known}")));
                }
                None => {
                    self.some_without_material = true;
                    known as u32
                }
            };
            for t in triangles {
                mesh.triangles.push(t.map(|i| first as u32 + i));
                normals.triangles.push(shading.map(|n| t.map(|i| n as u32 + i)));
                mesh.materials.push(material);
            }
        }
        if normals.triangles.iter().any(Option::is_some) {
            mesh.normals = Some(normals);
        }
        Ok(mesh)
    }

    /// Appends the vectors of an accessor to `into`, unless this mesh already holds them; returns their range.
    fn vectors(
        &mut self,
        accessor: usize,
        into: &mut Vec<Vec3>,
        decoded: &mut HashMap<usize, (usize, usize)>,
        mesh: usize,
    ) -> Result<(usize, usize), Error> {
        if let Some(&range) = decoded.get(&accessor) {
            return Ok(range);
        }
        let vectors = self.buffers.vectors(accessor)?;
        self.vertices += vectors.len();
        if self.vertices > MAX_VERTICES {
            return Err(self.error(mesh, format!("more than {MAX_VERTICES} vertices up to here")));
        }
        let range = (into.len(), vectors.len());
        into.extend(vectors);
        decoded.insert(accessor, range);
        Ok(range)
    }
}

/// Triangles from corners, oriented as glTF 2.0 section 3.7.2.1 says. Corners left over are dropped.
fn assemble(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => {
            corners.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], corners[0]]).collect()
        }
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// A metal smoother than roughness 0.1 counts as a mirror; glass needs an extension and is not recognised.
fn material((index, source): (usize, &json::Material)) -> Material {
    let pbr = &source.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0;
    let (metallic, roughness) =
        (pbr.metallic_factor.0.clamp(0.0, 1.0), pbr.roughness_factor.0.clamp(0.0, 1.0));
    let base = Vec3::new(r, g, b);
    let textures = [
        pbr.base_color_texture.is_some(),
        pbr.metallic_roughness_texture.is_some(),
        source.normal_texture.is_some(),
        source.occlusion_texture.is_some(),
        source.emissive_texture.is_some(),
    ];
    Material {
        name: source.name.clone().unwrap_or_else(|| format!("material {index}")),
        diffuse: base * (1.0 - metallic),
        specular: base * metallic + Vec3::splat(0.04 * (1.0 - metallic)),
        emission: Vec3::from_array(source.emissive_factor.0),
        roughness,
        reflection: if metallic > 0.5 && roughness < 0.1 { Reflection::Mirror } else { Reflection::None },
        alpha_tested: matches!(source.alpha_mode, Checked::Valid(json::material::AlphaMode::Mask)),
        textured: textures.contains(&true),
    }
}
