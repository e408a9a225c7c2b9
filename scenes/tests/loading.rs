//! Is a path or a name turned into a scene, or into one clear error; and are missing cameras and lights filled in well?

mod common;

use common::file;
use scenes::{Aabb, Camera, Light, Reflection, Vec3, load, mtl};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn a_missing_file_is_refused_with_the_names_that_would_work() {
    let e = load("no/such/scene.obj").unwrap_err();
    assert_eq!(e.place(), "no/such/scene.obj");
    assert!(e.remedy().contains("cornell") && e.remedy().contains("soup"), "{e}");
}

#[test]
fn a_folder_and_an_unknown_extension_are_refused() {
    let (folder, path) = file("scene.stl", b"solid");
    assert!(load(folder.path().to_str().unwrap()).unwrap_err().problem().contains("folder"));
    assert!(load(&path).unwrap_err().remedy().contains(".obj.zst"));
    assert!(load("").is_err());
}

#[test]
fn a_compressed_obj_is_the_same_scene_under_the_same_name() {
    let (_a, plain) = file("a.obj", TRIANGLE.as_bytes());
    let (_b, packed) = file("a.obj.zst", &zstd::encode_all(TRIANGLE.as_bytes(), 3).unwrap());
    let (plain, packed) = (load(&plain).unwrap(), load(&packed).unwrap());
    assert_eq!((plain.name.as_str(), plain.hash()), ("a", packed.hash()));
    assert_eq!(packed.name, "a");
}

#[test]
fn a_compressed_file_that_is_torn_or_not_compressed_is_refused() {
    let packed = zstd::encode_all(TRIANGLE.repeat(50).as_bytes(), 3).unwrap();
    for length in [0, 1, 4, packed.len() / 2, packed.len() - 1] {
        let (_folder, path) = file("torn.obj.zst", &packed[..length]);
        assert!(load(&path).is_err(), "{length} of {} bytes", packed.len());
    }
    let (_folder, path) = file("plain.obj.zst", TRIANGLE.as_bytes());
    assert!(load(&path).unwrap_err().problem().contains("reading stopped"));
}

#[test]
fn a_compression_bomb_without_line_ends_is_refused_at_the_longest_line() {
    let bomb = zstd::encode_all(std::io::Read::take(std::io::repeat(b' '), 1 << 28), 1).unwrap();
    assert!(bomb.len() < 1 << 16);
    let (_folder, path) = file("bomb.obj.zst", &bomb);
    let e = load(&path).unwrap_err();
    assert_eq!(e.line(), Some(1), "{e}");
}

#[test]
fn a_compression_bomb_of_line_ends_is_refused_by_how_much_it_expands() {
    let bomb =
        zstd::encode_all(std::io::Read::take(std::io::repeat(b'\n'), scenes::FREE_EXPANSION * 2), 1).unwrap();
    let (_folder, path) = file("bomb.obj.zst", &bomb);
    let e = load(&path).unwrap_err();
    assert!(e.problem().contains("bytes of text"), "{e}");
}

#[test]
fn a_material_library_beside_the_file_is_read_and_one_outside_is_not() {
    let (folder, path) =
        file("m.obj", format!("mtllib sub\\m.mtl\nmtllib ../x.mtl\nusemtl a\n{TRIANGLE}").as_bytes());
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/m.mtl"), "newmtl a\nKd 1 0 0\nillum 7\nmap_d leaf.png\n").unwrap();
    let scene = load(&path).unwrap();
    assert_eq!(scene.materials[0].diffuse, Vec3::X);
    assert!(scene.needs().reflections && scene.needs().alpha_tests && !scene.needs().textures);
    let note = scene.notes.iter().find(|n| n.text().contains("x.mtl")).unwrap();
    assert!(note.text().contains("outside the folder"), "{note}");
}

#[test]
fn a_material_library_is_read_as_far_as_it_can_be_understood() {
    let text = "Kd 9 9 9\nnewmtl a\nKd 0.5\nKs spectral file.rfl\nNs 0\nillum 3 # mirror\n\nnewmtl b c\nillum x\nKe\nmap_Kd t.png\nNs 1e99\n";
    let m = mtl::parse(text.as_bytes());
    assert_eq!((m[0].name.as_str(), m[1].name.as_str(), m.len()), ("a", "b c", 2));
    assert_eq!(
        (m[0].diffuse, m[0].specular, m[0].reflection),
        (Vec3::splat(0.5), Vec3::ZERO, Reflection::Mirror)
    );
    assert_eq!((m[0].roughness, m[1].roughness), (1.0, 1.0));
    assert!(m[1].textured && m[1].reflection == Reflection::None);
}

#[test]
fn needs_follow_from_the_materials_in_use_only() {
    let (folder, path) =
        file("n.obj", format!("mtllib n.mtl\nusemtl plain\n{TRIANGLE}usemtl glass\n").as_bytes());
    std::fs::write(folder.path().join("n.mtl"), "newmtl plain\nnewmtl glass\nillum 7\nmap_d x\n").unwrap();
    let scene = load(&path).unwrap();
    let needs = scene.needs();
    assert_eq!(scene.materials.len(), 2);
    assert!(!needs.reflections && !needs.alpha_tests && !needs.several_materials && !needs.normals);
    assert!(needs.shadow_rays);
    let left_out = needs.left_out();
    assert!(left_out.iter().all(|l| l.why.starts_with("not needed: ")), "{left_out:?}");
    let named: Vec<&str> = left_out.iter().map(|l| l.what).collect();
    assert_eq!(
        named,
        ["normals", "reflections", "alpha_tests", "instances", "textures", "several_materials"]
    );
}

#[test]
fn what_is_left_out_names_a_need_and_its_share() {
    let text = format!("mtllib l.mtl\nusemtl m\n{TRIANGLE}usemtl p\nf 1 2 3\nf 3 2 1\n");
    let (folder, path) = file("l.obj", text.as_bytes());
    std::fs::write(folder.path().join("l.mtl"), "newmtl m\nillum 5\nnewmtl p\nmap_Kd t\n").unwrap();
    let mut left_out = load(&path).unwrap().needs().left_out();
    left_out.retain(|l| !l.why.starts_with("not needed: "));
    let named: Vec<&str> = left_out.iter().map(|l| l.what).collect();
    assert_eq!(named, ["reflections", "textures", "several_materials"]);
    assert!(left_out[0].why.starts_with("1 of 3 triangles"), "{}", left_out[0].why);
}

#[test]
fn degenerate_triangles_are_counted_in_a_note() {
    let (_folder, path) = file("d.obj", format!("{TRIANGLE}f 1 1 2\nv 2 0 0\nf 1 2 4\n").as_bytes());
    let scene = load(&path).unwrap();
    assert_eq!(scene.triangle_count(), 3);
    assert!(
        scene.notes.iter().any(|n| n.text().starts_with("2 of 3 triangles have no area")),
        "{:?}",
        scene.notes
    );
}

#[test]
fn the_hash_sees_every_coordinate_the_camera_and_the_light() {
    let scene = load("cornell").unwrap();
    let changed = |change: fn(&mut scenes::Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        other.hash()
    };
    assert_eq!(changed(|s| s.name.clear()), scene.hash());
    let moved = [
        changed(|s| s.meshes[0].positions[7].z = f32::from_bits(s.meshes[0].positions[7].z.to_bits() + 1)),
        changed(|s| s.meshes[0].positions[1].x = -0.0),
        changed(|s| s.camera.eye.x += 1.0),
        changed(|s| s.camera.vertical_fov_degrees += 1.0),
        changed(|s| s.lights = vec![Light::Point { position: Vec3::ONE }]),
        changed(|s| s.lights.clear()),
        changed(|s| s.meshes[0].triangles.swap(0, 1)),
    ];
    assert!(moved.iter().all(|&h| h != scene.hash()), "{moved:x?}");
}

#[test]
fn a_framed_camera_sees_all_corners_of_any_box() {
    let boxes = [
        Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) },
        Aabb { min: Vec3::new(1000.0, 0.0, -3.0), max: Vec3::new(1001.0, 0.0, 4.0) },
        Aabb { min: Vec3::ZERO, max: Vec3::new(100.0, 1e-3, 1e-3) },
        Aabb { min: Vec3::splat(-1e18), max: Vec3::splat(1e18) },
        Aabb { min: Vec3::splat(1e-20), max: Vec3::splat(3e-20) },
    ];
    for bounds in boxes {
        for up in [Vec3::Y, Vec3::Z, Vec3::new(1.0, 1.0, 0.0), Vec3::NEG_X] {
            let camera = Camera::frame(bounds, up);
            camera.validate("framed").unwrap();
            let eye = camera.eye.as_dvec3();
            let view = (camera.target.as_dvec3() - eye).normalize();
            let half = (f64::from(camera.vertical_fov_degrees) * 0.5).to_radians().cos();
            for corner in 0..8 {
                let pick = |bit: usize, axis: usize| {
                    if corner >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] }
                };
                let p = Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)).as_dvec3();
                assert!((p - eye).normalize().dot(view) >= half - 1e-4, "{bounds:?} {up}");
            }
            assert!(view.dot(up.as_dvec3()) < 0.0, "the camera looks down on {bounds:?} with {up} up");
        }
    }
}

#[test]
fn empty_point_like_and_huge_boxes_still_give_a_valid_camera() {
    for bounds in [
        Aabb::EMPTY,
        Aabb { min: Vec3::ZERO, max: Vec3::ZERO },
        Aabb { min: Vec3::splat(1e30), max: Vec3::splat(1e30) },
        Aabb { min: Vec3::splat(f32::MIN), max: Vec3::splat(f32::MAX) },
        Aabb { min: Vec3::splat(1e-44), max: Vec3::splat(2e-44) },
    ] {
        for up in [Vec3::Y, Vec3::ZERO, Vec3::NAN, Vec3::splat(1e38)] {
            Camera::frame(bounds, up).validate("framed").unwrap();
        }
    }
}

#[test]
fn a_scene_at_the_edge_of_f32_loads_with_a_valid_camera_and_a_finite_light() {
    let m = f32::MAX;
    let (_folder, path) =
        file("edge.obj", format!("v {m} 0 0\nv -{m} 0 {m}\nv 0 {m} -{m}\nf 1 2 3\n").as_bytes());
    let scene = load(&path).unwrap();
    let Light::Point { position } = scene.lights[0];
    assert!(position.is_finite());
    scene.camera.validate("edge").unwrap();
}
