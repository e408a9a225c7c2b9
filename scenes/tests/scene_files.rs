//! Does a scene file set what it says, refuse what it does not know, and find its geometry beside itself?

mod common;

use scenes::{Light, RaySelection, RoughnessGates, Vec3, load, scene_file};

const WHOLE: &str = r#"
geometry = "mesh.obj"
[camera]
eye = [1.0, 2.0, 3.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, 1.0]
vertical_fov_degrees = 30.0
[[lights]]
kind = "point"
position = [0.0, 9.0, 0.0]
[rays]
shadow = false
"#;

fn refused(text: &str) -> scenes::Error {
    scene_file::parse(text.as_bytes(), "bad.toml").expect_err(text)
}

#[test]
fn everything_a_scene_file_says_is_used() {
    let (folder, path) = common::file("view.toml", WHOLE.as_bytes());
    std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let scene = load(&path).unwrap();
    assert_eq!((scene.camera.eye, scene.camera.up), (Vec3::new(1.0, 2.0, 3.0), Vec3::Z));
    assert_eq!(scene.lights, [Light::Point { position: Vec3::new(0.0, 9.0, 0.0) }]);
    assert!(scene.rays.primary && !scene.rays.shadow);
    assert_eq!(scene.name, "view");
    assert!(!scene.notes.iter().any(|n| n.text().contains("camera") || n.text().contains("light")));
    assert!(!scene.needs().shadow_rays);
    let why = scene.needs().left_out().into_iter().find(|l| l.what == "shadow_rays").unwrap().why;
    assert!(why.contains("its file turns shadow rays off"), "{why}");
}

#[test]
fn a_built_in_scene_can_be_seen_from_elsewhere() {
    let text =
        "geometry = \"cornell\"\n[camera]\neye = [1, 2, 3]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 30\n";
    let (_folder, path) = common::file("near.toml", text.as_bytes());
    let scene = load(&path).unwrap();
    let cornell = load("cornell").unwrap();
    assert_eq!(scene.camera.eye, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!((scene.triangles(), &scene.lights), (cornell.triangles(), &cornell.lights));
    assert_ne!(scene.hash(), cornell.hash());
}

#[test]
fn an_empty_list_of_lights_means_no_light() {
    let (_folder, path) = common::file("dark.toml", b"geometry = \"cornell\"\nlights = []\n");
    let scene = load(&path).unwrap();
    assert!(scene.lights.is_empty() && !scene.needs().shadow_rays);
    let why = scene.needs().left_out().into_iter().find(|l| l.what == "shadow_rays").unwrap().why;
    assert_eq!(why, "not needed: the scene has no light");
}

#[test]
fn unknown_and_missing_keys_are_refused_with_their_line() {
    for (text, line, part) in [
        ("geometry = \"a.obj\"\ncolour = 3\n", 2, "colour"),
        ("geometry = \"a.obj\"\n[camera]\neye = [0, 0, 0]\nfov = 3\n", 4, "fov"),
        ("geometry = \"a.obj\"\n[rays]\nprimary = true\nbounce = true\n", 4, "bounce"),
        ("geometry = \"a.obj\"\n[[lights]]\nkind = \"area\"\nposition = [0, 0, 0]\n", 3, "area"),
        ("geometry = \"a.obj\"\n[camera]\neye = [0, 0]\n", 3, "length"),
        ("geometry = \"a.obj\"\ngeometry = \"b.obj\"\n", 2, "duplicate"),
        ("geometry = 3\n", 1, "string"),
    ] {
        let e = refused(text);
        assert_eq!(e.line(), Some(line), "{e}");
        assert!(e.problem().contains(part), "{e}");
    }
    assert!(refused("[rays]\n").problem().contains("geometry"));
}

#[test]
fn a_camera_without_a_direction_is_refused() {
    let camera = |eye: &str, target: &str, up: &str, fov: &str| {
        format!(
            "geometry = \"cornell\"\n[camera]\neye = {eye}\ntarget = {target}\nup = {up}\nvertical_fov_degrees = {fov}\n"
        )
    };
    let parse = |text: &str| scene_file::parse(text.as_bytes(), "c.toml");
    assert!(parse(&camera("[0, 0, 1]", "[0, 0, 0]", "[0, 1, 0]", "179.9")).is_ok());
    for bad in [
        camera("[0, 0, 0]", "[0, 0, 0]", "[0, 1, 0]", "60"),
        camera("[0, 0, 1]", "[0, 0, 0]", "[0, 0, 2]", "60"),
        camera("[0, 0, 1]", "[0, 0, 0]", "[0, 0, 0]", "60"),
        camera("[0, 0, nan]", "[0, 0, 0]", "[0, 1, 0]", "60"),
        camera("[0, 0, 1e39]", "[0, 0, 0]", "[0, 1, 0]", "60"),
        camera("[0, 0, 1]", "[0, 0, 0]", "[0, 1, 0]", "0"),
        camera("[0, 0, 1]", "[0, 0, 0]", "[0, 1, 0]", "180"),
        camera("[0, 0, 1]", "[0, 0, 0]", "[0, 1, 0]", "nan"),
    ] {
        assert!(parse(&bad).is_err(), "{bad}");
    }
}

#[test]
fn a_scene_file_cannot_name_a_scene_file_or_itself() {
    let (_folder, path) = common::file("loop.toml", b"geometry = \"loop.toml\"\n");
    assert!(load(&path).unwrap_err().problem().contains("scene file as the geometry"));
}

#[test]
fn a_light_that_is_not_finite_is_refused() {
    let e = refused("geometry = \"cornell\"\n[[lights]]\nkind = \"point\"\nposition = [0, inf, 0]\n");
    assert!(e.problem().contains("light"), "{e}");
}

#[test]
fn every_key_of_the_rays_is_used_and_the_others_keep_their_defaults() {
    let rays = |keys: &str| {
        let text = format!("geometry = \"cornell\"\n[rays]\n{keys}\n");
        scene_file::parse(text.as_bytes(), "rays.toml").expect(keys).rays.expect("a table")
    };
    let plain = RaySelection::default();
    assert_eq!(rays(""), plain);
    let roughness = RoughnessGates { mirror: 0.05, ..plain.roughness };
    for (keys, expected) in [
        ("shadow = false", RaySelection { shadow: false, ..plain }),
        ("soft_shadows = true", RaySelection { soft_shadows: true, ..plain }),
        ("mirror = true", RaySelection { mirror: true, ..plain }),
        ("glossy = true", RaySelection { glossy: true, ..plain }),
        ("ambient_occlusion = true", RaySelection { ambient_occlusion: true, ..plain }),
        ("diffuse = true", RaySelection { diffuse: true, ..plain }),
        ("samples = 64", RaySelection { samples: 64, ..plain }),
        ("seed = 4294967295", RaySelection { seed: u32::MAX, ..plain }),
        ("light_radius = 2.5", RaySelection { light_radius: Some(2.5), ..plain }),
        ("ambient_occlusion_radius = 3", RaySelection { ambient_occlusion_radius: Some(3.0), ..plain }),
        ("roughness = { mirror = 0.05 }", RaySelection { roughness, ..plain }),
    ] {
        assert_eq!(rays(keys), expected, "{keys}");
    }
}
