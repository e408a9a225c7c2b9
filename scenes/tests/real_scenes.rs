//! Are the real scenes loaded whole, in the order a plain parser gives, with the notes they deserve?
//! The files are not part of the project; without them each test says that it is skipped.

mod common;

use common::{bits, plain_triangles, real_scene, text_of};
use scenes::{Reflection, Scene, load};

const TRIANGLES: [(&str, usize); 13] = [
    ("CornellBox-Original", 36),
    ("CornellBox-Mirror", 36),
    ("CornellBox-Glossy", 1_112),
    ("CornellBox-Sphere", 2_188),
    ("CornellBox-Water", 7_088),
    ("teapot_15k", 15_704),
    ("bunny_69k", 69_451),
    ("buddha_100k", 100_000),
    ("dragon_202k", 202_520),
    ("sponza_dabrovic_66k", 66_450),
    ("sponza_crytek_262k", 262_267),
    ("breakfast_room_269k", 269_538),
    ("bistro_reduced_1094k", 1_093_539),
];

fn scene(name: &str) -> Option<Scene> {
    let path = real_scene(&format!("{name}.obj.zst"))?;
    Some(load(path.to_str().unwrap()).unwrap())
}

fn says(scene: &Scene, part: &str) -> bool {
    scene.notes.iter().any(|n| n.text().contains(part))
}

#[test]
fn every_scene_has_its_published_triangle_count() {
    for (name, count) in TRIANGLES {
        let Some(scene) = scene(name) else { continue };
        assert_eq!((scene.name.as_str(), scene.triangle_count()), (name, count));
    }
}

#[test]
fn every_scene_has_the_bits_and_the_order_of_a_plain_parser() {
    for (name, _) in TRIANGLES {
        let Some(path) = real_scene(&format!("{name}.obj.zst")) else { continue };
        let ours = load(path.to_str().unwrap()).unwrap().triangles();
        assert!(bits(&ours) == bits(&plain_triangles(&text_of(&path))), "{name}");
    }
}

#[test]
fn sponza_needs_alpha_tests_textures_and_normals_and_the_mirror_box_reflections() {
    if let Some(scene) = scene("sponza_crytek_262k") {
        let needs = scene.needs();
        assert!(needs.alpha_tests && needs.textures && needs.normals && needs.several_materials);
        assert!(!needs.reflections && !needs.instances);
    }
    if let Some(scene) = scene("CornellBox-Mirror") {
        assert!(scene.needs().reflections && !scene.needs().textures);
        let mirrors: Vec<_> =
            scene.materials.iter().filter(|m| m.reflection == Reflection::Mirror).map(|m| &m.name).collect();
        assert_eq!(mirrors, ["tallBox"]);
    }
    if let Some(scene) = scene("CornellBox-Sphere") {
        assert!(scene.materials.iter().any(|m| m.reflection == Reflection::Glass));
    }
}

#[test]
fn missing_materials_and_normals_are_named_and_the_geometry_is_loaded() {
    if let Some(scene) = scene("sponza_dabrovic_66k") {
        assert!(says(&scene, "20 of the 20 materials"), "{:?}", scene.notes);
        assert!(says(&scene, "no shading normals"));
        assert_eq!(scene.materials.len(), 20);
    }
    if let Some(scene) = scene("bunny_69k") {
        assert!(says(&scene, "names no materials"));
        assert!(says(&scene, "sees the whole scene"));
    }
}

#[test]
fn known_cameras_are_used_by_file_name_and_said_to_be() {
    if let Some(scene) = scene("sponza_crytek_262k") {
        assert_eq!(scene.camera.eye.to_array(), [-1000.0, 350.0, -30.0]);
        assert!(says(&scene, "the published one for sponza_crytek_262k"));
    }
    if let Some(scene) = scene("buddha_100k") {
        assert_eq!(scene.camera.up.to_array(), [0.0, 0.0, 1.0]);
    }
}
