//! What is said of features that were forced in or out.

use crate::counters::Value;
use crate::report::Forced;
use crate::units;
use gpumodel::{Choice, Feature, ForcedCost};

impl Forced {
    /// `frame_s` is the time of the whole frame.
    pub(crate) fn new(cost: &ForcedCost, frame_s: f64) -> Self {
        let &ForcedCost { feature, choice, seconds, buffer_bytes, dram_read_bytes } = cost;
        let time = seconds.map(|seconds| format!("{} ms", units::digits(seconds * 1e3)));
        let frame = units::digits(frame_s * 1e3);
        let sentence = match (feature, choice) {
            (
                Feature::ShadowRays
                | Feature::SoftShadows
                | Feature::Mirror
                | Feature::Glossy
                | Feature::AmbientOcclusion
                | Feature::Diffuse,
                Choice::In,
            ) => format!(
                "it takes {} of the frame's {frame} ms and reads {} from DRAM; it shares caches with the other passes of its shader",
                time.unwrap_or_else(|| "no time".to_owned()),
                bytes(dram_read_bytes.unwrap_or(0)),
            ),
            (Feature::ShadowRays, Choice::Out) => match time {
                Some(time) => format!(
                    "it would add about {time} to the frame's {frame} ms for each light, the time of the primary rays: an estimate"
                ),
                None => {
                    "what it would add does not follow from a frame without rays; run it with them".to_owned()
                }
            },
            (
                Feature::SoftShadows
                | Feature::Mirror
                | Feature::Glossy
                | Feature::AmbientOcclusion
                | Feature::Diffuse
                | Feature::AlphaTests,
                Choice::Out,
            ) => format!(
                "what it would add to the frame's {frame} ms follows from a run without --leave-out {}",
                feature.name()
            ),
            (Feature::AlphaTests, Choice::In) => format!(
                "masks and micromaps take {}; what shaders of them add to the frame's {frame} ms follows from a run without --force alpha-tests",
                bytes(buffer_bytes),
            ),
            (Feature::Normals, Choice::In) => {
                let read =
                    dram_read_bytes.map(|read| format!(", and {} are read from DRAM for them", bytes(read)));
                format!(
                    "they take {} of records{}; what they add to the frame's {frame} ms follows from a run without --force normals",
                    bytes(buffer_bytes),
                    read.unwrap_or_default(),
                )
            }
            (Feature::Normals, Choice::Out) => format!(
                "they would take {} of records; what they would add to the frame's {frame} ms follows from a run without --leave-out normals",
                bytes(buffer_bytes),
            ),
        };
        let choice = match choice {
            Choice::In => "in",
            Choice::Out => "out",
        };
        Self {
            what: feature.what().to_owned(),
            choice: choice.to_owned(),
            frame_time_ms: seconds.map(|seconds| seconds * 1e3),
            buffer_bytes,
            dram_read_bytes,
            cost: sentence,
        }
    }
}

fn bytes(bytes: u64) -> String {
    let (number, unit) = units::scaled(&Value::Count(bytes), "B").unwrap_or_default();
    format!("{number} {unit}")
}
