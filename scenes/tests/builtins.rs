//! Do the built-in scenes have the same bits everywhere, the counts they announce, and the shape they claim?

use scenes::{Aabb, BUILTINS, Mesh, Reflection, Scene, Vec3, builtin, load};
use std::collections::HashMap;

fn scene(name: &str) -> Scene {
    builtin(name).unwrap()
}

/// How often each directed edge occurs.
fn directed_edges(mesh: &Mesh) -> HashMap<(u32, u32), u32> {
    let mut edges = HashMap::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((a, b)).or_insert(0) += 1;
        }
    }
    edges
}

/// Six times the enclosed volume; positive when the triangles are counter-clockwise seen from outside.
fn signed_volume(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len())
        .map(|i| {
            let [a, b, c] = mesh.triangle(i).v.map(Vec3::as_dvec3);
            a.dot(b.cross(c))
        })
        .sum()
}

#[test]
fn every_scene_has_its_frozen_hash() {
    let frozen: [(&str, u64); 11] = [
        ("cornell", 0xcd8b_5cc4_b12a_35fc),
        ("teapot", 0x88ff_8404_9062_5a60),
        ("stadium", 0x9816_9e24_c994_1de4),
        ("figure", 0x09f9_78d7_624e_09f7),
        ("atrium", 0x22c6_9276_c898_732d),
        ("soup", 0x2530_e481_64b4_b038),
        ("chess", 0xc0a8_0ff8_5e1b_2804),
        ("car", 0xfebb_b67c_3447_d6e7),
        ("laboratory", 0xfae9_c110_eb06_4ba7),
        ("music-box", 0xec1d_0621_d390_a0c7),
        ("village", 0xbe63_bcba_500c_5da8),
    ];
    assert_eq!(frozen.len(), BUILTINS.len());
    for (name, hash) in frozen {
        assert_eq!(scene(name).hash(), hash, "{name} is {:#018x}", scene(name).hash());
    }
}

#[test]
fn every_scene_keeps_the_promises_of_a_scene() {
    for entry in BUILTINS {
        let scene = load(entry.name).unwrap();
        assert_eq!((scene.name.as_str(), scene.triangle_count()), (entry.name, entry.triangles));
        assert_eq!(scene.triangles().len(), entry.triangles);
        assert!(scene.triangles().iter().all(|t| t.v.iter().all(|p| p.is_finite())), "{}", entry.name);
        scene.camera.validate(entry.name).unwrap();
        assert!(!scene.lights.is_empty() && scene.rays.primary && scene.rays.shadow);
        for mesh in &scene.meshes {
            assert_eq!(mesh.materials.len(), mesh.triangles.len());
            assert!(mesh.materials.iter().all(|&m| (m as usize) < scene.materials.len()));
            assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
        }
    }
}

#[test]
fn every_camera_looks_at_the_scene() {
    for entry in BUILTINS {
        let scene = scene(entry.name);
        let view = (scene.camera.target - scene.camera.eye).normalize();
        let cosine = (f64::from(scene.camera.vertical_fov_degrees).to_radians() * 0.5).cos() as f32;
        let seen = scene
            .triangles()
            .iter()
            .filter(|t| (t.v[0] - scene.camera.eye).normalize().dot(view) > cosine)
            .count();
        assert!(seen * 20 > scene.triangle_count(), "{}: only {seen} triangles ahead", entry.name);
    }
}

#[test]
fn only_soup_holds_triangles_without_area() {
    for entry in BUILTINS {
        let without = scene(entry.name).triangles().iter().filter(|t| t.is_degenerate()).count();
        if entry.name == "soup" {
            assert!(without >= 600, "{without}");
        } else {
            assert_eq!(without, 0, "{}", entry.name);
        }
    }
}

#[test]
fn the_teapot_has_newells_extents() {
    let b = scene("teapot").bounds();
    // In Newell's units: handle to spout -3 .. 3.434, width 4, height 3.15.
    let expected = Aabb { min: Vec3::new(-3.0, 0.0, -2.0), max: Vec3::new(3.434, 3.15, 2.0) };
    assert!((b.min - expected.min).abs().max_element() < 1e-2, "{b:?}");
    assert!((b.max - expected.max).abs().max_element() < 1e-2, "{b:?}");
}

/// Open are: the rim (64 edges), the lid (64), both ends of handle and spout (4 * 32).
#[test]
fn the_teapot_patches_join_without_a_gap() {
    let teapot = scene("teapot");
    let mut undirected: HashMap<(u32, u32), u32> = HashMap::new();
    for ((a, b), n) in directed_edges(&teapot.meshes[0]) {
        *undirected.entry((a.min(b), a.max(b))).or_insert(0) += n;
    }
    assert!(undirected.values().all(|&n| n <= 2));
    assert_eq!(undirected.values().filter(|&&n| n == 1).count(), 64 + 64 + 4 * 32);
}

#[test]
fn the_figure_is_closed_and_oriented_with_every_edge_in_two_triangles() {
    let figure = &scene("figure").meshes[0];
    let edges = directed_edges(figure);
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)));
    assert!(signed_volume(figure) > 0.0);
    // Euler's formula: one piece with two arms on its hips and a base between its feet has three handles, unless
    // noise adds some.
    let euler = figure.positions.len() as i64 - edges.len() as i64 / 2 + figure.triangles.len() as i64;
    assert_eq!(euler, 2 - 2 * 3);
}

#[test]
fn the_cornell_box_has_its_published_corners() {
    let cornell = scene("cornell");
    let b = cornell.bounds();
    assert_eq!((b.min.to_array(), b.max.to_array()), ([0.0; 3], [556.0, 548.8, 559.2]));
    let tall_top = Vec3::new(265.0, 330.0, 296.0);
    let faces = cornell.meshes[0].positions.iter().filter(|&&p| p == tall_top).count();
    assert_eq!(faces, 3, "three faces meet at a top corner of the tall block");
}

#[test]
fn the_stadium_has_a_third_of_its_triangles_in_a_thousandth_of_its_area() {
    let stadium = scene("stadium");
    let area = |b: Aabb| f64::from((b.max.x - b.min.x) * (b.max.z - b.min.z));
    let teapot = Aabb::around(stadium.meshes[0].positions.iter().copied());
    assert!(area(teapot) * 1000.0 < area(stadium.bounds()));
    assert!(stadium.meshes[0].triangles.len() * 3 > stadium.triangle_count());
}

#[test]
fn soup_spans_from_subnormal_sizes_to_areas_at_the_edge_of_f32() {
    let soup = scene("soup");
    let b = soup.bounds();
    let e = b.max - b.min;
    let area = 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x);
    assert!(area.is_finite() && area > 1e36, "{area:e}");
    let tiny = soup.triangles().into_iter().filter(|t| {
        let size = Aabb::around(t.v);
        let extent = (size.max - size.min).max_element();
        extent > 0.0 && extent < f32::MIN_POSITIVE
    });
    assert!(tiny.count() > 0);
}

/// Lee et al. 2017, Figure 1; they round to thousands.
#[test]
fn stand_ins_have_as_many_triangles_as_published() {
    for (name, thousands) in
        [("chess", 42), ("car", 55), ("laboratory", 98), ("music-box", 106), ("village", 600)]
    {
        let count = scene(name).triangle_count();
        assert_eq!((count + 500) / 1000, thousands, "{name}: {count}");
    }
}

/// Else a refracted ray could get lost in a wall.
#[test]
fn all_glass_is_closed_and_oriented() {
    for name in ["car", "laboratory"] {
        let scene = scene(name);
        let Mesh { triangles, materials, .. } = &scene.meshes[0];
        let is_glass = |id: u32| scene.materials[id as usize].reflection == Reflection::Glass;
        let glass = triangles.iter().zip(materials).filter(|&(_, &id)| is_glass(id)).map(|(&t, _)| t);
        let glass = Mesh { triangles: glass.collect(), ..scene.meshes[0].clone() };
        let edges = directed_edges(&glass);
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)), "{name}");
        assert!(glass.triangles.len() > 1000 && signed_volume(&glass) > 0.0, "{name}");
    }
}

#[test]
fn both_sides_of_the_chess_set_are_complete() {
    let chess = scene("chess");
    let of = |name: &str| {
        let id = chess.materials.iter().position(|m| m.name == name).unwrap() as u32;
        chess.meshes[0].materials.iter().filter(|&&material| material == id).count()
    };
    assert!(of("white") == of("black") && of("white") > 16 * 1000);
    assert_eq!((of("light square"), of("dark square")), (64, 64));
}

#[test]
fn an_unknown_name_is_no_scene() {
    assert!(builtin("conell").is_none());
    assert!(builtin("").is_none());
}
