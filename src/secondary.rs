//! From the rays that a frame has to those that follow each of its primary hits.

use scenes::{Feature, Gloss, Needs, RaySelection, Scene, Vec3};
use tracer::{ReflectionRays, SecondaryRays, SoftShadows};

/// Radius of a light for soft shadows, by the scene's radius.
const LIGHT_RADIUS: f64 = 1.0 / 20.0;
/// Length of rays of ambient occlusion, by the scene's radius.
const AMBIENT_OCCLUSION_RADIUS: f64 = 1.0 / 10.0;

/// What follows a primary hit besides hard shadow rays. `lights` are those of soft shadows, and those that shadow rays go to from what
/// reflection and diffuse rays hit.
pub(crate) fn rays(
    scene: &Scene,
    rays: &RaySelection,
    has: impl Fn(Feature) -> bool,
    (lights, hit_lights): (Vec<Vec3>, Vec<Vec3>),
) -> SecondaryRays {
    let reflects = has(Feature::Mirror) || has(Feature::Glossy);
    SecondaryRays {
        seed: rays.seed,
        samples: rays.samples,
        soft_shadows: has(Feature::SoftShadows)
            .then(|| SoftShadows { lights, radius: light_radius(scene, rays) }),
        reflections: reflects.then(|| reflections(scene, rays, has(Feature::Mirror), has(Feature::Glossy))),
        ambient_occlusion: has(Feature::AmbientOcclusion).then(|| ambient_occlusion_radius(scene, rays)),
        diffuse: has(Feature::Diffuse),
        lights: hit_lights,
    }
}

/// What a report says of how they are drawn.
pub(crate) fn notes(
    scene: &Scene,
    rays: &RaySelection,
    needs: &Needs,
    has: impl Fn(Feature) -> bool,
) -> Vec<String> {
    let (mirror, glossy) = (has(Feature::Mirror), has(Feature::Glossy));
    let gates = rays.roughness;
    let mut notes = Vec::new();
    if has(Feature::SoftShadows) {
        notes.push(format!("To soft shadows, lights are spheres of radius {}.", light_radius(scene, rays)));
    }
    if mirror {
        notes.push(format!("Surfaces up to roughness {} send one mirror ray.", gates.mirror));
    }
    if glossy {
        let (from, to) = (gates.mirror, gates.glossy);
        notes.push(format!("Surfaces from roughness {from} to {to} send glossy rays, drawn by GGX; a ray into the surface is mirrored."));
    }
    let forced = [
        (Feature::Mirror, "mirrors".to_owned()),
        (Feature::Glossy, format!("of roughness {}", gates.glossy)),
    ];
    for (feature, what) in forced {
        if has(feature) && !needs.smooth_enough(feature) {
            notes.push(format!("No triangle is smooth enough; for the {} rays that were forced in, those that send no other reflection ray count as {what}.", feature.name()));
        }
    }
    if has(Feature::AmbientOcclusion) {
        notes.push(format!("Rays of ambient occlusion reach {}.", ambient_occlusion_radius(scene, rays)));
    }
    if [Feature::SoftShadows, Feature::Glossy, Feature::AmbientOcclusion, Feature::Diffuse]
        .into_iter()
        .any(has)
    {
        notes.push(format!("Rays drawn at random: {} per pixel, of seed {}.", rays.samples, rays.seed));
    }
    notes
}

/// The reflection rays of each triangle. Where no triangle passes a gate whose rays are forced in, all that would send none do.
fn reflections(scene: &Scene, rays: &RaySelection, mirror: bool, glossy: bool) -> Vec<ReflectionRays> {
    let gates = rays.roughness;
    let of = |(gloss, roughness): (Gloss, Option<f32>)| match (gloss, roughness) {
        (Gloss::Mirror, _) if mirror => ReflectionRays::Mirror,
        (Gloss::Glossy, Some(roughness)) if glossy => ReflectionRays::Glossy(roughness),
        _ => ReflectionRays::None,
    };
    let roughness = scene.triangle_materials().map(|material| material.reflected_roughness());
    let mut all: Vec<ReflectionRays> =
        roughness.map(|roughness| of((gates.gloss(roughness), roughness))).collect();
    let found = |all: &[ReflectionRays], mirror: bool| {
        all.iter().any(|rays| match rays {
            ReflectionRays::Mirror => mirror,
            ReflectionRays::Glossy(_) => !mirror,
            ReflectionRays::None => false,
        })
    };
    let forced = [
        (glossy && !found(&all, false), ReflectionRays::Glossy(gates.glossy)),
        (mirror && !found(&all, true), ReflectionRays::Mirror),
    ];
    for (_, instead) in forced.into_iter().filter(|(forced, _)| *forced) {
        all.iter_mut().filter(|rays| **rays == ReflectionRays::None).for_each(|rays| *rays = instead);
    }
    all
}

fn light_radius(scene: &Scene, rays: &RaySelection) -> f32 {
    rays.light_radius.unwrap_or_else(|| (scene.radius() * LIGHT_RADIUS) as f32)
}

fn ambient_occlusion_radius(scene: &Scene, rays: &RaySelection) -> f32 {
    rays.ambient_occlusion_radius.unwrap_or_else(|| (scene.radius() * AMBIENT_OCCLUSION_RADIUS) as f32)
}
