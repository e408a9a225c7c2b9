//! Rays that were asked for on the command line, over those that a scene asks for.

use crate::args::FrameArgs;
use crate::features::Features;
use anyhow::bail;
use scenes::{Feature, RaySelection, SAMPLES, is_radius};
use tracer::Choice;

/// A set of rays that can be asked for.
struct Named {
    name: &'static str,
    feature: Feature,
    /// Its rays are drawn at random.
    sampled: bool,
    asked: fn(&mut RaySelection) -> &mut bool,
}

/// Whether an option is of a set.
type Whose = fn(&Named) -> bool;

const NAMED: [Named; 6] = [
    Named {
        name: "hard-shadows",
        feature: Feature::ShadowRays,
        sampled: false,
        asked: |rays| &mut rays.shadow,
    },
    Named {
        name: "soft-shadows",
        feature: Feature::SoftShadows,
        sampled: true,
        asked: |rays| &mut rays.soft_shadows,
    },
    Named { name: "mirror", feature: Feature::Mirror, sampled: false, asked: |rays| &mut rays.mirror },
    Named { name: "glossy", feature: Feature::Glossy, sampled: true, asked: |rays| &mut rays.glossy },
    Named {
        name: "ao",
        feature: Feature::AmbientOcclusion,
        sampled: true,
        asked: |rays| &mut rays.ambient_occlusion,
    },
    Named { name: "diffuse", feature: Feature::Diffuse, sampled: true, asked: |rays| &mut rays.diffuse },
];

/// Names of the sets, in the order in which they are cast.
pub(crate) fn names() -> [&'static str; NAMED.len()] {
    NAMED.map(|set| set.name)
}

/// What was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RayRequest {
    /// Which sets, in the order of [`names`].
    sets: Option<[bool; NAMED.len()]>,
    samples: Option<u32>,
    seed: Option<u32>,
    light_radius: Option<f32>,
    ambient_occlusion_radius: Option<f32>,
}

impl RayRequest {
    /// Refuses what no frame can have, and options of sets that are not asked for.
    pub(crate) fn new(args: &FrameArgs, features: Features) -> anyhow::Result<Self> {
        let FrameArgs { ray_sets, spp, ray_seed, light_radius, ao_radius, .. } = args;
        if let Some(spp) = spp.filter(|spp| !SAMPLES.contains(spp)) {
            let (least, most) = (SAMPLES.start(), SAMPLES.end());
            bail!("--spp {spp}: expected {least} to {most} samples per pixel; give a number between");
        }
        for (option, radius) in [("--light-radius", light_radius), ("--ao-radius", ao_radius)] {
            if let Some(radius) = radius.filter(|&radius| !is_radius(radius)) {
                bail!(
                    "{option} {radius}: expected a length above 0 in units of the scene; give a finite one, or leave it out"
                );
            }
        }
        let named = |name: &str| ray_sets.iter().any(|set| set == name);
        let sets = (!ray_sets.is_empty()).then(|| NAMED.map(|set| named(set.name)));
        let asked = |set: &Named| named(set.name) || features.choice(set.feature) == Some(Choice::In);
        let needs: [(&str, bool, Whose); 4] = [
            ("--spp", spp.is_some(), |set| set.sampled),
            ("--ray-seed", ray_seed.is_some(), |set| set.sampled),
            ("--light-radius", light_radius.is_some(), |set| set.feature == Feature::SoftShadows),
            ("--ao-radius", ao_radius.is_some(), |set| set.feature == Feature::AmbientOcclusion),
        ];
        for (option, given, of) in needs {
            // Without --ray-sets the scene decides which sets there are.
            if sets.is_some() && given && !NAMED.iter().any(|set| of(set) && asked(set)) {
                let sets: Vec<&str> = NAMED.iter().filter(|set| of(set)).map(|set| set.name).collect();
                bail!(
                    "{option} is of other sets of rays; add one of {} to --ray-sets, or leave it out",
                    sets.join(", ")
                );
            }
        }
        Ok(Self {
            sets,
            samples: *spp,
            seed: *ray_seed,
            light_radius: *light_radius,
            ambient_occlusion_radius: *ao_radius,
        })
    }

    /// The rays of a scene's frame.
    pub(crate) fn over(self, mut rays: RaySelection) -> RaySelection {
        for (set, asked) in NAMED.iter().zip(self.sets.into_iter().flatten()) {
            *(set.asked)(&mut rays) = asked;
        }
        RaySelection {
            samples: self.samples.unwrap_or(rays.samples),
            seed: self.seed.unwrap_or(rays.seed),
            light_radius: self.light_radius.or(rays.light_radius),
            ambient_occlusion_radius: self.ambient_occlusion_radius.or(rays.ambient_occlusion_radius),
            ..rays
        }
    }

    /// Whether the sets were listed, and hard shadows are not among them.
    pub(crate) fn omits_hard_shadows(self) -> bool {
        self.sets.is_some_and(|[hard, ..]| !hard)
    }
}

/// `rays` with all that is forced in.
pub(crate) fn with_forced(mut rays: RaySelection, features: Features) -> RaySelection {
    for set in NAMED.iter().filter(|set| features.choice(set.feature) == Some(Choice::In)) {
        *(set.asked)(&mut rays) = true;
    }
    rays
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(args: &FrameArgs) -> Result<RayRequest, String> {
        let features = Features::new(&args.force, &args.leave_out).map_err(|error| error.to_string())?;
        RayRequest::new(args, features).map_err(|error| error.to_string())
    }

    fn sets(names: &[&str]) -> FrameArgs {
        FrameArgs { ray_sets: names.iter().map(|&name| name.to_owned()).collect(), ..FrameArgs::default() }
    }

    #[test]
    fn a_list_replaces_what_the_scene_asks_for_and_nothing_else_does() {
        let scene = RaySelection { diffuse: true, samples: 4, seed: 9, ..RaySelection::default() };
        assert_eq!(request(&sets(&[])).expect("nothing is asked for").over(scene), scene);
        let rays = request(&sets(&["ao", "mirror"])).expect("sound").over(scene);
        let expected =
            RaySelection { shadow: false, mirror: true, ambient_occlusion: true, diffuse: false, ..scene };
        assert_eq!(rays, expected);
        let more = FrameArgs { spp: Some(2), ray_seed: Some(1), ao_radius: Some(3.0), ..sets(&["ao"]) };
        let rays = request(&more).expect("sound").over(scene);
        assert_eq!((rays.samples, rays.seed, rays.ambient_occlusion_radius), (2, 1, Some(3.0)));
    }

    #[test]
    fn options_of_sets_that_are_not_there_are_refused() {
        let spp = |names: &[&str]| FrameArgs { spp: Some(2), ..sets(names) };
        let light = |names: &[&str]| FrameArgs { light_radius: Some(2.0), ..sets(names) };
        assert!(request(&spp(&["mirror"])).expect_err("one sample").contains("--spp is of other sets"));
        assert!(request(&light(&["ao"])).expect_err("no light").contains("add one of soft-shadows"));
        for good in [spp(&["mirror", "glossy"]), light(&["soft-shadows"]), spp(&[]), light(&[])] {
            request(&good).expect("sound");
        }
        request(&FrameArgs { force: vec!["ao".to_owned()], ..spp(&["mirror"]) }).expect("forced in");
    }

    #[test]
    fn numbers_are_refused_on_both_sides_of_their_limits() {
        let spp = |spp| FrameArgs { spp: Some(spp), ..sets(&["ao"]) };
        let radius = |radius| FrameArgs { ao_radius: Some(radius), ..sets(&["ao"]) };
        for good in [spp(1), spp(64), radius(1e-30), radius(1e30)] {
            request(&good).expect("sound");
        }
        for bad in [spp(0), spp(65)] {
            assert!(request(&bad).expect_err("out of range").contains("expected 1 to 64 samples per pixel"));
        }
        for bad in [radius(0.0), radius(-1.0), radius(f32::NAN), radius(f32::INFINITY)] {
            assert!(request(&bad).expect_err("out of range").contains("--ao-radius"));
        }
    }
}
