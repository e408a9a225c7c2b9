//! What features cost that were forced in, and what is saved by those that were forced out, as far as one run tells.

use super::values::FrameValues;
use crate::counters::Pass;
use crate::layout::normal_bytes;
use tracer::{Choice, Feature, Forced};

/// What a feature costs that was forced in or out against what the scene needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcedCost {
    /// Which.
    pub feature: Feature,
    /// Which way.
    pub choice: Choice,
    /// Seconds of the frame that it takes, or about would take; none where this run does not tell.
    pub seconds: Option<f64>,
    /// Bytes that it takes, or would take, in buffers.
    pub buffer_bytes: u64,
    /// Bytes that it reads from memory; none where this run does not tell.
    pub dram_read_bytes: Option<u64>,
}

/// What all that was forced costs; `seconds` are those of the passes.
pub(super) fn costs(
    FrameValues { replayed, header, topology, config }: &FrameValues<'_>,
    seconds: &[f64; Pass::COUNT],
) -> Vec<ForcedCost> {
    let cost = |&Forced { feature, choice }| {
        let nothing = ForcedCost { feature, choice, seconds: None, buffer_bytes: 0, dram_read_bytes: None };
        let traffic = |pass: Pass| replayed.counters.pass(pass).traffic;
        let of_passes = |passes: &[Pass]| ForcedCost {
            seconds: Some(passes.iter().map(|&pass| seconds[pass as usize]).sum()),
            dram_read_bytes: Some(passes.iter().map(|&pass| traffic(pass).total().dram_read_bytes).sum()),
            ..nothing
        };
        match (feature, choice) {
            (Feature::ShadowRays, Choice::In) => of_passes(&[Pass::Shadow]),
            (Feature::SoftShadows, Choice::In) => of_passes(&[Pass::SoftShadow]),
            (Feature::Mirror | Feature::Glossy, Choice::In) => {
                of_passes(&[Pass::Reflection, Pass::ReflectionShadow])
            }
            (Feature::AmbientOcclusion, Choice::In) => of_passes(&[Pass::AmbientOcclusion]),
            (Feature::Diffuse, Choice::In) => of_passes(&[Pass::Diffuse, Pass::DiffuseShadow]),
            // A ray to each light, each about as long as the ray whose hit it starts from.
            (Feature::ShadowRays, Choice::Out) => {
                ForcedCost { seconds: Some(seconds[Pass::Primary as usize]).filter(|&s| s > 0.0), ..nothing }
            }
            // How many such rays there would be, and how far they would spread, no other pass tells.
            (
                Feature::SoftShadows
                | Feature::Mirror
                | Feature::Glossy
                | Feature::AmbientOcclusion
                | Feature::Diffuse
                | Feature::AlphaTests,
                Choice::Out,
            ) => nothing,
            // What shaders of them take no pass tells: they run among the steps of rays.
            (Feature::AlphaTests, Choice::In) => {
                ForcedCost { buffer_bytes: replayed.buffers.mask + replayed.buffers.micromap, ..nothing }
            }
            (Feature::Normals, Choice::In) => {
                let read = traffic(Pass::Output).normal.dram_read_bytes;
                let apart = replayed.buffers.normal > 0;
                ForcedCost {
                    buffer_bytes: normal_bytes(header, topology, config),
                    dram_read_bytes: apart.then_some(read),
                    ..nothing
                }
            }
            (Feature::Normals, Choice::Out) => {
                ForcedCost { buffer_bytes: normal_bytes(header, topology, config), ..nothing }
            }
        }
    };
    header.forced.iter().map(cost).collect()
}
