//! Can any bytes make a parser panic? They must end in a scene or in an error.

mod common;

use proptest::prelude::*;
use scenes::{gltf, load, mtl, obj, scene_file};

const OBJ: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0.5e1 0\nv 0 1 -2\nvn 0 0 1\nusemtl m\nf 1/1/1 2//1 -1\nf 1 2 3 \\\n1\n";
const TOML: &str = "geometry = \"cornell\"\n[camera]\neye = [1, 2, 3]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 30\n[[lights]]\nkind = \"point\"\nposition = [0, 1, 0]\n[rays]\nshadow = true\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36,"byteStride":12}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0},"mode":4}]}],"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"rotation":[0,0,0,1],"children":[2]},{"camera":0},{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

/// `text` with some bytes replaced, removed or repeated, or with numbers swapped for awkward ones.
fn mutated(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let edit = (any::<prop::sample::Index>(), any::<u8>(), 0..6u8, any::<prop::sample::Index>());
    prop::collection::vec(edit, 1..8).prop_map(|edits| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, value, kind, word) in edits {
            if bytes.is_empty() {
                break;
            }
            let i = at.index(bytes.len());
            match kind {
                0 => bytes[i] = value,
                1 => drop(bytes.remove(i)),
                2 => bytes.truncate(i),
                3 => bytes.insert(i, value),
                _ => {
                    let words =
                        ["-1", "4294967295", "18446744073709551616", "1e999", "nan", "0", "-0", "1.5"];
                    let from = (i..bytes.len()).find(|&k| bytes[k].is_ascii_digit()).unwrap_or(i);
                    let digits = bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
                    bytes.splice(from..from + digits, words[word.index(words.len())].bytes());
                }
            }
        }
        bytes
    })
}

fn read_all(bytes: &[u8]) {
    drop(obj::parse(bytes, "x"));
    drop(mtl::parse(bytes));
    drop(scene_file::parse(bytes, "x"));
    drop(gltf::parse(bytes, "x", |_, _| Err(String::new())));
}

#[test]
fn the_unmutated_inputs_are_good() {
    assert!(obj::parse(OBJ.as_bytes(), "x").is_ok());
    assert!(scene_file::parse(TOML.as_bytes(), "x").is_ok());
    assert!(gltf::parse(GLTF.as_bytes(), "x", |_, _| Err(String::new())).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        read_all(&bytes);
    }

    #[test]
    fn arbitrary_glb_bodies_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read_all(&[b"glTF\x02\0\0\0".as_slice(), &bytes].concat());
    }

    #[test]
    fn a_mutated_obj_never_panics_and_keeps_its_indices_in_range(bytes in mutated(OBJ)) {
        if let Ok(file) = obj::parse(&bytes, "x") {
            let mesh = &file.mesh;
            prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
            prop_assert!(mesh.materials.iter().all(|&m| (m as usize) < file.material_names.len()));
            prop_assert_eq!(mesh.materials.len(), mesh.triangles.len());
            if let Some(n) = &mesh.normals {
                prop_assert_eq!(n.triangles.len(), mesh.triangles.len());
                prop_assert!(n.triangles.iter().flatten().flatten().all(|&i| (i as usize) < n.vectors.len()));
            }
        }
    }

    #[test]
    fn a_mutated_gltf_never_panics_and_keeps_its_indices_in_range(bytes in mutated(GLTF)) {
        if let Ok(g) = gltf::parse(&bytes, "x", |_, _| Ok(vec![0; 40])) {
            for i in &g.instances {
                let mesh = &g.meshes[i.mesh as usize];
                prop_assert!(mesh.positions.iter().all(|&p| i.transform_point(p).is_finite()));
                prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
                prop_assert!(mesh.materials.iter().all(|&m| (m as usize) < g.materials.len()));
            }
        }
    }

    #[test]
    fn a_mutated_scene_file_never_panics_and_has_a_valid_camera(bytes in mutated(TOML)) {
        if let Some(camera) = scene_file::parse(&bytes, "x").ok().and_then(|file| file.camera) {
            prop_assert!(camera.validate("x").is_ok());
        }
    }

    #[test]
    fn a_mutated_compressed_file_never_panics(bytes in mutated(OBJ), flip in any::<prop::sample::Index>(), bit in 0..8u8) {
        let mut packed = zstd::encode_all(&bytes[..], 3).unwrap();
        let i = flip.index(packed.len());
        packed[i] ^= 1 << bit;
        let (_folder, path) = common::file("x.obj.zst", &packed);
        drop(load(&path));
    }
}
