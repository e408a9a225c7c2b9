//! Which rays a scene asks for, and how those that are drawn at random are drawn.

use crate::Error;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Samples that a pixel may have of each set of rays that is drawn at random.
pub const SAMPLES: RangeInclusive<u32> = 1..=64;

/// Which rays are traced. Lengths are in the units of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RaySelection {
    /// One ray per pixel from the eye.
    pub primary: bool,
    /// One ray per primary hit and light, to the middle of the light.
    pub shadow: bool,
    /// Rays from each primary hit to points of the sphere that each light is; any hit.
    pub soft_shadows: bool,
    /// One ray along the mirror direction from each primary hit of a surface up to [`RoughnessGates::mirror`]; closest hit.
    pub mirror: bool,
    /// Rays around it from each primary hit of a rougher surface, up to [`RoughnessGates::glossy`]; closest hit.
    pub glossy: bool,
    /// Rays from each primary hit that see how open its surroundings are; any hit.
    pub ambient_occlusion: bool,
    /// Rays from each primary hit to what lights it indirectly; closest hit.
    pub diffuse: bool,
    /// Rays per pixel of each set that is drawn at random, and there per light: within [`SAMPLES`].
    pub samples: u32,
    /// Start of the random sequence.
    pub seed: u32,
    /// Radius of the sphere that each light is to soft shadows; without one, a part of the scene's.
    pub light_radius: Option<f32>,
    /// How far rays of ambient occlusion reach; without one, a part of the scene's radius.
    pub ambient_occlusion_radius: Option<f32>,
    /// Which surfaces send reflection rays.
    pub roughness: RoughnessGates,
}

impl Default for RaySelection {
    /// Primary and hard shadow rays.
    fn default() -> Self {
        RaySelection {
            primary: true,
            shadow: true,
            soft_shadows: false,
            mirror: false,
            glossy: false,
            ambient_occlusion: false,
            diffuse: false,
            samples: 1,
            seed: 0,
            light_radius: None,
            ambient_occlusion_radius: None,
            roughness: RoughnessGates::default(),
        }
    }
}

impl RaySelection {
    /// Refuses what cannot be drawn: a number of samples, a radius or a roughness out of range.
    ///
    /// `place` names the file in the error.
    pub fn validate(&self, place: &str) -> Result<(), Error> {
        let refuse = |problem: String, remedy: &str| Err(Error::new(place, problem, remedy));
        if !SAMPLES.contains(&self.samples) {
            let (least, most) = (SAMPLES.start(), SAMPLES.end());
            let problem = format!("rays.samples is {}, expected {least} to {most}", self.samples);
            return refuse(problem, "correct the value");
        }
        let radii = [
            ("light_radius", self.light_radius),
            ("ambient_occlusion_radius", self.ambient_occlusion_radius),
        ];
        for (key, radius) in radii {
            if let Some(radius) = radius.filter(|&radius| !is_radius(radius)) {
                let problem = format!("rays.{key} is {radius}, expected a length above 0");
                return refuse(problem, "give a finite one, or leave it out");
            }
        }
        let RoughnessGates { mirror, glossy } = self.roughness;
        if !(0.0 <= mirror && mirror <= glossy && glossy <= 1.0) {
            let problem = format!(
                "rays.roughness has mirror = {mirror} and glossy = {glossy}, expected 0 to 1 and mirror not above glossy"
            );
            return refuse(problem, "correct the values");
        }
        Ok(())
    }
}

/// Whether a light can be that large, or a ray reach that far.
pub fn is_radius(radius: f32) -> bool {
    radius.is_normal() && radius > 0.0
}

/// Up to which perceptual roughness surfaces send reflection rays (Calvo Lista, Vulkanised 2026): rougher ones take a fallback
/// without rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RoughnessGates {
    /// The talk's MIRROR_ROUGHNESS, whose value it does not give.
    pub mirror: f32,
    /// The talk's MAX_RT_ROUGHNESS, whose value it does not give.
    pub glossy: f32,
}

impl Default for RoughnessGates {
    /// The roughness below which a metal of a glTF file counts as a mirror here, and, by our own choice, four times as much: no published value
    /// was found for either.
    fn default() -> Self {
        RoughnessGates { mirror: 0.1, glossy: 0.4 }
    }
}

/// The reflection rays of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gloss {
    /// One along the mirror direction.
    Mirror,
    /// Some around it.
    Glossy,
    /// None.
    Rough,
}

impl RoughnessGates {
    /// What a surface of this roughness sends; none where it reflects nothing.
    pub fn gloss(&self, roughness: Option<f32>) -> Gloss {
        match roughness {
            Some(roughness) if roughness <= self.mirror => Gloss::Mirror,
            Some(roughness) if roughness <= self.glossy => Gloss::Glossy,
            _ => Gloss::Rough,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gate_lets_its_own_roughness_through_and_the_next_one_not() {
        let gates = RoughnessGates { mirror: 0.1, glossy: 0.4 };
        for (roughness, gloss) in [
            (0.0, Gloss::Mirror),
            (0.1, Gloss::Mirror),
            (0.1_f32.next_up(), Gloss::Glossy),
            (0.4, Gloss::Glossy),
            (0.4_f32.next_up(), Gloss::Rough),
            (1.0, Gloss::Rough),
            (f32::NAN, Gloss::Rough),
        ] {
            assert_eq!(gates.gloss(Some(roughness)), gloss, "{roughness}");
        }
        assert_eq!(gates.gloss(None), Gloss::Rough);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_on_both_sides_of_each_limit() {
        let plain = RaySelection::default();
        let gates = |mirror, glossy| RaySelection { roughness: RoughnessGates { mirror, glossy }, ..plain };
        let light = |radius| RaySelection { light_radius: Some(radius), ..plain };
        let occlusion = |radius| RaySelection { ambient_occlusion_radius: Some(radius), ..plain };
        let samples = |samples| RaySelection { samples, ..plain };
        for good in [
            samples(1),
            samples(64),
            light(f32::MIN_POSITIVE),
            occlusion(f32::MAX),
            gates(0.0, 0.0),
            gates(1.0, 1.0),
        ] {
            assert_eq!(good.validate("s.toml"), Ok(()), "{good:?}");
        }
        for (bad, expected) in [
            (samples(0), "rays.samples is 0, expected 1 to 64"),
            (samples(65), "rays.samples is 65"),
            (light(0.0), "rays.light_radius is 0"),
            (light(f32::INFINITY), "rays.light_radius is inf"),
            (occlusion(-1.0), "rays.ambient_occlusion_radius is -1"),
            (occlusion(f32::NAN), "rays.ambient_occlusion_radius is NaN"),
            (gates(0.5, 0.4), "mirror = 0.5 and glossy = 0.4"),
            (gates(-0.1, 0.4), "mirror = -0.1"),
            (gates(0.1, 1.1), "glossy = 1.1"),
            (gates(f32::NAN, 0.4), "mirror = NaN"),
        ] {
            let error = bad.validate("s.toml").expect_err("beyond a limit").to_string();
            assert!(error.starts_with("s.toml: ") && error.contains(expected), "{error}");
        }
    }
}
