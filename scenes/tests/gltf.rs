//! Does a glTF file become its triangles, materials and instances, and is a hostile one refused within bounds?

mod common;

use scenes::{Error, Geometry, Reflection, Vec3, gltf, load};
use std::fmt::Write;

/// Four corners of a square and six indices, as one buffer: 48 bytes of positions, 12 of indices, 48 of normals.
fn square() -> Vec<u8> {
    let positions: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([[0.0f32, 0.0, 1.0]; 4].iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0u32, |b, &x| b << 8 | u32::from(x)) << (8 * (3 - group.len()));
        for i in 0..=group.len() {
            text.push(DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char);
        }
        text.push_str(&"=".repeat(3 - group.len()));
    }
    text
}

const PRIMITIVE: &str = r#"{"attributes":{"POSITION":0,"NORMAL":2},"indices":1,"material":0}"#;
const NODES: &str = r#""scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#;

/// A whole document around `buffer`, with the square's accessors and the given primitives and nodes.
fn document(buffer: &str, primitives: &str, nodes: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":108{buffer}}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}},{{"buffer":0,"byteOffset":60,"byteLength":48}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}},
        {{"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"}}],
        "materials":[{{"name":"chrome","pbrMetallicRoughness":{{"metallicFactor":1,"roughnessFactor":0.0}}}},
        {{"name":"fence","alphaMode":"MASK","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "meshes":[{{"primitives":[{primitives}]}}],{nodes}}}"#
    )
}

fn embedded(primitives: &str, nodes: &str) -> String {
    document(
        &format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&square())),
        primitives,
        nodes,
    )
}

fn parse(text: &str) -> Result<Geometry, Error> {
    parse_bytes(text.as_bytes())
}

fn parse_bytes(bytes: &[u8]) -> Result<Geometry, Error> {
    gltf::parse(bytes, "test.gltf", |_, _| Err("there are no files".to_owned()))
}

fn corners(geometry: &Geometry) -> Vec<[u32; 3]> {
    geometry.meshes[0].triangles.clone()
}

#[test]
fn an_embedded_square_becomes_two_triangles_with_normals_and_material() {
    let g = parse(&embedded(PRIMITIVE, NODES)).unwrap();
    assert_eq!(corners(&g), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(g.meshes[0].positions[2], Vec3::new(1.0, 1.0, 0.0));
    let normals = g.meshes[0].normals.as_ref().unwrap();
    assert_eq!((normals.vectors[3], normals.triangles[1]), (Vec3::Z, Some([0, 2, 3])));
    assert_eq!(g.materials[0].reflection, Reflection::Mirror);
    assert!(g.materials[1].alpha_tested && g.materials[1].textured);
}

#[test]
fn a_glb_and_a_file_with_its_buffer_beside_it_give_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("my square.bin"), square()).unwrap();
    std::fs::write(path("a.gltf"), document(r#","uri":"my%20square.bin""#, PRIMITIVE, NODES)).unwrap();
    std::fs::write(path("b.glb"), glb(&document("", PRIMITIVE, NODES), &square())).unwrap();
    let [a, b] = ["a.gltf", "b.glb"].map(|n| load(path(n).to_str().unwrap()).unwrap());
    assert_eq!(a.triangles(), b.triangles());
    assert_eq!(a.hash(), b.hash());
    assert_eq!(a.triangle_count(), 2);
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, data) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    bytes
}

#[test]
fn strips_and_fans_are_unrolled_with_their_orientation_and_points_are_skipped() {
    let with_mode = |mode: u32| format!(r#"{{"attributes":{{"POSITION":0}},"mode":{mode}}}"#);
    assert_eq!(corners(&parse(&embedded(&with_mode(5), NODES)).unwrap()), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(corners(&parse(&embedded(&with_mode(6), NODES)).unwrap()), [[1, 2, 0], [2, 3, 0]]);
    let both = format!("{},{PRIMITIVE}", with_mode(0));
    let g = parse(&embedded(&both, NODES)).unwrap();
    assert_eq!(corners(&g).len(), 2);
    assert!(g.notes.iter().any(|n| n.text().starts_with("1 primitives are points")), "{:?}", g.notes);
}

#[test]
fn primitives_that_share_vertices_store_them_once() {
    let g = parse(&embedded(&format!("{PRIMITIVE},{PRIMITIVE}"), NODES)).unwrap();
    assert_eq!((g.meshes[0].positions.len(), g.meshes[0].triangles.len()), (4, 4));
}

#[test]
fn nodes_become_instances_in_depth_first_order_with_their_transforms() {
    let nodes = r#""scenes":[{"nodes":[0,3]}],"nodes":[
        {"children":[1,2],"translation":[10,0,0]},
        {"mesh":0,"scale":[2,2,2],"rotation":[0,0,0.70710678,0.70710678]},
        {"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,5,0,1]},
        {"mesh":0}]"#;
    let g = parse(&embedded(PRIMITIVE, nodes)).unwrap();
    let moved: Vec<Vec3> = g.instances.iter().map(|i| i.transform_point(Vec3::X)).collect();
    let expected = [Vec3::new(10.0, 2.0, 0.0), Vec3::new(11.0, 5.0, 0.0), Vec3::X];
    assert!(moved.iter().zip(expected).all(|(m, e)| (m - e).abs().max_element() < 1e-5), "{moved:?}");
}

#[test]
fn instances_are_flattened_and_needed() {
    let nodes = r#""scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":0,"translation":[0,0,1]}]"#;
    let (_folder, path) = common::file("two.gltf", embedded(PRIMITIVE, nodes).as_bytes());
    let scene = load(&path).unwrap();
    assert_eq!(scene.triangle_count(), 4);
    assert_eq!(scene.triangles()[2].v[1], Vec3::new(1.0, 0.0, 1.0));
    assert!(scene.needs().instances && scene.needs().reflections && scene.needs().normals);
}

#[test]
fn the_first_perspective_camera_is_taken() {
    let nodes = r#""cameras":[{"type":"perspective","perspective":{"yfov":0.7853982,"znear":0.1}}],
        "scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"camera":0,"translation":[0,1,5]}]"#;
    let (_folder, path) = common::file("camera.gltf", embedded(PRIMITIVE, nodes).as_bytes());
    let camera = load(&path).unwrap().camera;
    assert_eq!(
        (camera.eye, camera.target, camera.up),
        (Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 1.0, 4.0), Vec3::Y)
    );
    assert!((camera.vertical_fov_degrees - 45.0).abs() < 1e-4);
}

#[test]
fn nodes_that_form_a_cycle_or_share_a_child_are_refused() {
    for nodes in [
        r#""scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[1]},{"children":[0]}]"#,
        r#""scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"children":[0]}]"#,
        r#""scenes":[{"nodes":[0,0]}],"nodes":[{"mesh":0}]"#,
    ] {
        let e = parse(&embedded(PRIMITIVE, nodes)).unwrap_err();
        assert!(e.problem().contains("reached twice"), "{e}");
    }
}

#[test]
fn wrong_indices_everywhere_are_refused_by_name() {
    let good = embedded(PRIMITIVE, NODES);
    assert!(parse(&good).is_ok());
    for (from, to) in [
        (r#""POSITION":0"#, r#""POSITION":99"#),
        (r#""POSITION":0"#, r#""POSITION":1"#),
        (r#""NORMAL":2"#, r#""NORMAL":77"#),
        (r#""indices":1"#, r#""indices":9"#),
        (r#""indices":1"#, r#""indices":0"#),
        (r#""material":0"#, r#""material":2"#),
        (r#""bufferView":0"#, r#""bufferView":3"#),
        (r#""buffer":0"#, r#""buffer":1"#),
        (r#""mesh":0"#, r#""mesh":1"#),
        (r#""nodes":[0]"#, r#""nodes":[1]"#),
        (r#""scene":0"#, r#""scene":1"#),
        (r#""byteLength":12"#, r#""byteLength":10"#),
        (r#""byteOffset":60"#, r#""byteOffset":61"#),
        (r#""byteLength":108"#, r#""byteLength":109"#),
        (r#""count":4"#, r#""count":5"#),
        (r#""count":6"#, r#""count":18446744073709551615"#),
        (r#""componentType":5126"#, r#""componentType":5123"#),
        (r#""version":"2.0""#, r#""version":"1.0""#),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        let e = parse(&bad).expect_err(to);
        assert!(!e.remedy().is_empty(), "{e}");
    }
}

#[test]
fn a_vertex_index_past_the_vertices_is_refused() {
    let mut bytes = square();
    bytes[58..60].copy_from_slice(&4u16.to_le_bytes());
    let e = parse_bytes(&glb(&document("", PRIMITIVE, NODES), &bytes)).unwrap_err();
    assert!(e.problem().contains("vertex index 4"), "{e}");
}

#[test]
fn a_position_that_is_not_finite_is_refused_before_and_after_its_transform() {
    let mut bytes = square();
    bytes[0..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let e = parse_bytes(&glb(&document("", PRIMITIVE, NODES), &bytes)).unwrap_err();
    assert!(e.problem().contains("not finite"), "{e}");
    let far = r#""scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[1e30,1,1]},{"mesh":0,"scale":[1e30,1,1]}]"#;
    let e = parse(&embedded(PRIMITIVE, far)).unwrap_err();
    assert!(e.problem().contains("nodes[1]"), "{e}");
}

#[test]
fn buffers_outside_the_folder_are_refused() {
    for uri in ["../secret.bin", "/etc/passwd", "a/../../b.bin", "%2e%2e/secret.bin", "..\\\\secret.bin"] {
        let text = document(&format!(r#","uri":"{uri}""#), PRIMITIVE, NODES);
        let (_folder, path) = common::file("outside.gltf", text.as_bytes());
        let e = load(&path).unwrap_err();
        assert!(e.problem().contains("outside the folder"), "{uri}: {e}");
    }
}

#[test]
fn compressed_geometry_is_refused_by_the_name_of_its_extension() {
    let text = embedded(PRIMITIVE, NODES).replacen(
        '{',
        r#"{"extensionsRequired":["KHR_draco_mesh_compression"],"#,
        1,
    );
    let e = parse(&text).unwrap_err();
    assert!(e.problem().contains("KHR_draco_mesh_compression"), "{e}");
}

#[test]
fn a_torn_glb_is_refused_at_every_length() {
    let whole = glb(&document("", PRIMITIVE, NODES), &square());
    assert!(parse_bytes(&whole).is_ok());
    for length in 0..whole.len() {
        assert!(parse_bytes(&whole[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn many_small_nodes_that_place_a_big_mesh_too_often_are_refused() {
    let mut nodes = String::from(r#""nodes":[{"mesh":0}"#);
    let mut primitives = String::from(PRIMITIVE);
    for _ in 1..8000 {
        write!(primitives, ",{PRIMITIVE}").unwrap();
        nodes.push_str(r#",{"mesh":0}"#);
    }
    nodes.push(']');
    let e = parse(&embedded(&primitives, &nodes)).unwrap_err();
    assert!(e.problem().contains("all instances together"), "{e}");
}

#[test]
fn a_document_of_too_many_objects_is_refused_before_it_is_built() {
    let objects = vec!["{}"; gltf::MAX_JSON_OBJECTS + 1].join(",");
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{objects}]}}"#);
    assert!(parse(&text).unwrap_err().problem().contains("objects"));
}
