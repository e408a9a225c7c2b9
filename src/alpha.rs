//! Alpha tests as they were asked for: how they are made, of which triangles, and what a report says of it.

use crate::args::FrameArgs;
use crate::features::Features;
use crate::machine::choice;
use anyhow::bail;
use scenes::{Feature, Scene};
use tracer::{AlphaMode, AlphaTests, Choice, MicromapFormat, MicromapStates, TestedTriangles};

/// How alpha-tested triangles are treated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AlphaRequest {
    mode: AlphaMode,
    micromap: Option<MicromapFormat>,
}

impl AlphaRequest {
    pub(crate) fn new(args: &FrameArgs, features: Features) -> anyhow::Result<Self> {
        let FrameArgs { alpha, micromap_level, micromap_states, .. } = args;
        let mode = choice("--alpha", alpha, AlphaMode::from_name, &AlphaMode::ALL.map(AlphaMode::name))?;
        if let Some(mode) = mode
            && features.choice(Feature::AlphaTests) == Some(Choice::Out)
        {
            bail!(
                "--alpha {}: --leave-out alpha-tests leaves it nothing to decide; leave out one of them",
                mode.name()
            );
        }
        let mode = mode.unwrap_or_default();
        let states = choice(
            "--micromap-states",
            micromap_states,
            MicromapStates::from_name,
            &MicromapStates::ALL.map(MicromapStates::name),
        )?;
        let options =
            [("--micromap-level", micromap_level.is_some()), ("--micromap-states", states.is_some())];
        if let Some((option, _)) = options.iter().find(|(_, given)| *given && mode != AlphaMode::Micromap) {
            bail!("{option} is an option of opacity micromaps; add --alpha micromap, or leave it out");
        }
        let micromap = (mode == AlphaMode::Micromap).then(|| MicromapFormat {
            level: micromap_level.unwrap_or(MicromapFormat::MAX_LEVEL),
            states: states.unwrap_or(MicromapStates::Four),
        });
        Ok(Self { mode, micromap })
    }

    /// The alpha tests of a frame that `has` them or not; `None` where every triangle is opaque and marked so.
    pub(crate) fn tests(self, scene: &Scene, has: bool) -> Option<AlphaTests> {
        let Self { mode, micromap } = self;
        let tested = match (has, scene.alpha_tested().any(|tested| tested)) {
            (true, true) => TestedTriangles::of(scene.alpha_tested()),
            (true, false) => TestedTriangles::OnePairInFour,
            (false, _) if mode == AlphaMode::Unmarked => TestedTriangles::of([]),
            (false, _) => return None,
        };
        Some(AlphaTests { mode, tested, micromap })
    }
}

/// Why alpha tests that the frame has are not made after all.
pub(crate) fn omission(tests: &AlphaTests) -> Option<String> {
    (tests.mode == AlphaMode::Opaque)
        .then(|| "--alpha opaque: rays take alpha-tested triangles as opaque".to_owned())
}

/// What a report says of alpha tests.
pub(crate) fn note(tests: &AlphaTests, triangles: u32) -> String {
    let count = tests.tested.count(triangles);
    let mask = "images are not read, so the mask of each is three opaque posts along its first edge, with gaps as wide";
    match tests.tested {
        TestedTriangles::OnePairInFour => format!(
            "No triangle of the scene carries an alpha mask; for the alpha tests that were forced in, the last two of each eight have one, {count} of \
             {triangles}; {mask}."
        ),
        TestedTriangles::Runs(_) if count == 0 => {
            "No triangle of the scene carries an alpha mask; none is marked opaque, so that an \
             any-hit shader accepts every hit."
                .to_owned()
        }
        TestedTriangles::Runs(_) => format!("{count} of {triangles} triangles carry an alpha mask; {mask}."),
    }
}
