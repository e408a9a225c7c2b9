//! Do the built-in scenes load a tracer as their descriptions say?

use scenes::{Gloss, RoughnessGates, Scene};
use tracer::reflections::GBuffer;
use tracer::{AccelerationStructure, BuildOptions, Traversal, View};

/// Those that stand in for scenes of Lee et al. 2017, and the part of their primary hits that sends a reflection ray, in per cent.
const STAND_INS: [(&str, f64); 5] =
    [("chess", 69.4), ("car", 32.8), ("laboratory", 90.2), ("music-box", 54.5), ("village", 0.95)];
const SIZE: [u32; 2] = [512, 256];

/// The part of the primary hits whose surface passes a default gate of roughness, in per cent.
fn reflecting(scene: &Scene) -> f64 {
    let triangles = scene.triangles();
    let structure = AccelerationStructure::build(&triangles, Traversal::BvhStack, &BuildOptions::default())
        .expect("it builds");
    let [width, height] = SIZE;
    let view = View::new(&scene.camera, width, height);
    let seen = GBuffer::trace(&structure, &triangles, view, width, height);
    let gates = RoughnessGates::default();
    let sends: Vec<bool> =
        scene.triangle_materials().map(|m| gates.gloss(m.reflected_roughness()) != Gloss::Rough).collect();
    let hits: Vec<u32> = (0..seen.pixels()).filter_map(|pixel| seen.triangle(pixel)).collect();
    let sending = hits.iter().filter(|&&triangle| sends[triangle as usize]).count();
    100.0 * sending as f64 / hits.len() as f64
}

#[test]
fn the_part_of_hits_that_reflect_is_what_the_description_says() {
    let [width, height] = SIZE;
    for (name, stated) in STAND_INS {
        let scene = scenes::builtin(name).expect("a built-in scene");
        let entry = scenes::BUILTINS.iter().find(|entry| entry.name == name).expect("it is listed");
        let lights = scene.lights.len();
        let load = format!(
            "{lights} light{}, {stated} % of the primary hits at {width}x{height} reflect",
            if lights == 1 { "" } else { "s" }
        );
        assert!(entry.description.ends_with(&load), "{name}: no '{load}'");
        assert!(scene.rays.mirror && scene.rays.glossy, "{name} asks for these rays");
        let measured = reflecting(&scene);
        assert!((measured - stated).abs() < 0.1, "{name}: {measured} %, stated are {stated} %");
    }
}
