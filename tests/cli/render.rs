//! `raybudget render`: one picture, whatever traces it.

use crate::support::{arg, file, folder, names_in, raybudget};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// The bytes of a rendered picture.
fn rendered(dir: &TempDir, scene: &str, options: &[&str]) -> Vec<u8> {
    let image = dir.path().join("image.png");
    raybudget(["render", scene, "--size", "61x47", "-o", arg(&image)].iter().chain(options)).ok();
    fs::read(image).expect("a picture")
}

#[test]
fn every_traversal_on_any_number_of_threads_renders_the_same_picture() {
    let dir = folder();
    for scene in ["cornell", "teapot"] {
        let picture = rendered(&dir, scene, &["--threads", "1"]);
        assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n"));
        assert_eq!(picture[16..24], [0, 0, 0, 61, 0, 0, 0, 47]);
        for traversal in tracer::Traversal::ALL {
            let options =
                ["--accel", traversal.accel().name(), "--traversal", traversal.name(), "--threads", "3"];
            assert!(rendered(&dir, scene, &options) == picture, "{scene}, {traversal:?}");
        }
    }
}

#[test]
fn it_says_what_it_traced_and_that_it_is_no_gpu() {
    let dir = folder();
    let image = dir.path().join("image.png");
    let text = raybudget(["render", "cornell", "--size", "40x24", "-o", arg(&image), "--threads", "2"]).ok();
    let profile = raybudget(["profile", "cornell", "--size", "40x24", "--format", "json"]).json();
    let shadow_rays = profile["counters"]["rays"]["value"].as_u64().expect("a count") - 40 * 24;
    for part in [
        &format!("image.png: 960 primary and {shadow_rays} shadow rays through bvh stack in "),
        " Mrays/s with --threads 2\n",
        "CPU time on this machine, shading included; no GPU is modelled\n",
        ", build ",
    ] {
        assert!(text.contains(part), "no '{part}' in: {text}");
    }
}

/// A square that faces the camera, and one behind the camera's back that stands between it and a far light.
const SQUARE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
const OCCLUDER: &str = "v -1 -1 6\nv 1 -1 6\nv 1 1 6\nv -1 1 6\nf 5 6 7 8\n";

/// Red of the middle of a picture of `geometry` from (0, 0, 3).
fn brightness(geometry: &str, light: [f32; 3], rays: &str) -> u8 {
    let dir = folder();
    file(&dir, "square.obj", geometry);
    let text = format!(
        "geometry = \"square.obj\"\n[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
         vertical_fov_degrees = 20\n[[lights]]\nkind = \"point\"\nposition = {light:?}\n{rays}"
    );
    let scene = file(&dir, "square.toml", text);
    let image = dir.path().join("image.png");
    raybudget(["render", arg(&scene), "--size", "5x5", "-o", arg(&image)]).ok();
    centre(&image)
}

#[test]
fn a_surface_is_bright_towards_its_light_and_dark_in_shadow() {
    let front = brightness(SQUARE, [0.0, 0.0, 9.0], "");
    let slanted = brightness(SQUARE, [9.0, 0.0, 5.0], "");
    let behind = brightness(SQUARE, [0.0, 0.0, -9.0], "");
    assert!(front > slanted && slanted > behind && behind > 0, "{front}, {slanted}, {behind}");
    let both = format!("{SQUARE}{OCCLUDER}");
    assert_eq!(brightness(&both, [0.0, 0.0, 9.0], ""), behind, "the light is hidden");
    assert_eq!(brightness(&both, [0.0, 0.0, 5.0], ""), front, "the light is before the occluder");
}

#[test]
fn a_scene_without_shadow_rays_is_lit_from_the_eye() {
    let hidden = brightness(SQUARE, [0.0, 0.0, -9.0], "[rays]\nshadow = false\n");
    assert_eq!(hidden, brightness(SQUARE, [0.0, 0.0, 9.0], ""));
}

/// Red of the middle pixel.
fn centre(image: &Path) -> u8 {
    let bytes = fs::read(image).expect("a picture");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    reader.next_frame(&mut pixels).expect("pixels");
    pixels[pixels.len() / 2 / 3 * 3]
}

#[test]
fn a_picture_without_a_name_a_folder_or_a_scene_is_refused_and_nothing_is_written() {
    let dir = folder();
    let without = raybudget(["render", "cornell"]);
    assert_eq!(without.code, Some(2));
    assert!(without.stderr.contains("--out <IMAGE.png>"), "{}", without.stderr);
    let image = dir.path().join("image.png");
    for (args, expected) in [
        (["no-such-scene", "-o", arg(&image)], "no-such-scene"),
        (["no-such-scene", "-o", arg(&dir.path().join("no/image.png"))], "create its folder first"),
        (["no-such-scene", "-o", arg(dir.path())], "this is a folder"),
    ] {
        let message = raybudget(["render"].iter().chain(&args)).refused();
        assert!(message.contains(expected), "{args:?}: {message}");
    }
    let message = raybudget(["render", "cornell", "-o", arg(&image), "--size", "0x1"]).refused();
    assert!(message.contains("without pixels"), "{message}");
    assert_eq!(names_in(dir.path()), Vec::<String>::new());
}
