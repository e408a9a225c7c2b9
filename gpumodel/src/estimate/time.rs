//! Time of the frame's phases, and what it is made of.

use super::bounds::{Bound, Demand, path};
use super::contention::{InPhase, LATENCY};
use crate::config::{Gpu, HitShading, Launch, Technique};
use crate::counters::{Pass, PassCounters};
use crate::error::Error;
use crate::replay::Replayed;
use crate::timed::{TimedPhase, WarpCycles};
use crate::windows::Window;

/// A part of the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StackPart {
    /// What warps use or wait for.
    pub name: &'static str,
    /// Seconds.
    pub seconds: f64,
}

/// Passes that the GPU runs at the same time, phase after phase: those of one shader.
pub(super) fn phases(technique: &Technique) -> &'static [&'static [Pass]] {
    const RAYS: [Pass; 9] = [
        Pass::Primary,
        Pass::Shadow,
        Pass::SoftShadow,
        Pass::Reflection,
        Pass::ReflectionShadow,
        Pass::AmbientOcclusion,
        Pass::Diffuse,
        Pass::DiffuseShadow,
        Pass::Output,
    ];
    const OF_A_FRAME: [&[Pass]; 6] = [
        &[Pass::Binning],
        &[Pass::Geometry],
        &[Pass::ErrorDetection],
        &RAYS,
        &[Pass::Reprojection],
        &[Pass::Present],
    ];
    const IN_PLACE: [&[Pass]; 1] =
        [&[Pass::ScreenSpace, Pass::Reflection, Pass::ReflectionShadow, Pass::Output]];
    const LISTED: [&[Pass]; 2] =
        [&[Pass::ScreenSpace], &[Pass::Reflection, Pass::ReflectionShadow, Pass::Output]];
    const BY_MATERIAL: [&[Pass]; 6] = [
        &[Pass::ScreenSpace],
        &[Pass::Reflection],
        &[Pass::BucketCount],
        &[Pass::BucketOffset],
        &[Pass::BucketCopy],
        &[Pass::HitShading, Pass::ReflectionShadow],
    ];
    match &technique.reflections {
        None => &OF_A_FRAME,
        Some(reflections) => match (reflections.launch, reflections.hit_shading) {
            (_, HitShading::VisibilityBuffer) => &BY_MATERIAL,
            (Launch::Pixel, _) => &IN_PLACE,
            (Launch::Buffer, _) => &LISTED,
        },
    }
}

/// The time of a phase.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PhaseTime {
    pub(super) seconds: f64,
    /// The largest of its bounds, and the place of that among them.
    pub(super) largest: Bound,
    pub(super) place: usize,
    /// Adds up to `seconds`.
    pub(super) stack: Vec<StackPart>,
    /// Largest relative residual of a solved network.
    pub(super) residual: f64,
}

/// What a rung recorded of a phase; `None` if no warp of it touched memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Record<'a> {
    Simulated(Option<&'a TimedPhase>),
    Windows(Option<&'a [Window]>),
}

impl<'a> Record<'a> {
    /// Of the phase that these passes are.
    pub(super) fn of(replayed: &'a Replayed, phase: &[Pass]) -> Self {
        match &replayed.timed {
            Some(frame) => {
                let found = frame.phases.iter().find(|(first, _)| phase.contains(first));
                Self::Simulated(found.map(|(_, phase)| phase))
            }
            None => {
                let found = replayed.phases.iter().find(|of| phase.contains(&of.first));
                Self::Windows(found.map(|of| of.windows.as_slice()))
            }
        }
    }
}

impl PhaseTime {
    /// Of passes that run at the same time: the first of them, what they count together, and what they need together; `None` if
    /// they need nothing.
    ///
    /// Simulated time where there is one, else time under contention; and never less than a bound, as those of fixed-function
    /// units are not simulated.
    ///
    /// # Errors
    /// See [`InPhase::contended`].
    pub(super) fn of(
        (first, counters): (Pass, &PassCounters),
        demand: &Demand,
        record: Record<'_>,
        gpu: &Gpu,
    ) -> Result<Option<Self>, Error> {
        let bounds = demand.bounds(gpu).into_iter().enumerate();
        let largest = bounds.max_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
        let Some((place, largest)) = largest.filter(|(_, bound)| bound.seconds > 0.0) else {
            return Ok(None);
        };
        let mut time = Self { seconds: 0.0, largest, place, stack: Vec::new(), residual: 0.0 };
        match record {
            Record::Simulated(Some(phase)) => {
                time.seconds = phase.cycles / gpu.clock.hz;
                time.stack = simulated_stack(phase, time.seconds);
            }
            Record::Windows(Some(windows)) => {
                let in_phase = InPhase { counters, demand, path: path(first, counters, gpu), gpu };
                time = in_phase.contended(windows, time)?;
            }
            Record::Simulated(None) | Record::Windows(None) => {}
        }
        time.seconds += demand.dispatch;
        add(&mut time.stack, "dispatches", demand.dispatch);
        let missing = largest.seconds - time.seconds;
        if missing > 0.0 {
            time.seconds = largest.seconds;
            add(&mut time.stack, largest.name, missing);
        }
        Ok(Some(time))
    }
}

/// Adds to the part of that name.
pub(super) fn add(stack: &mut Vec<StackPart>, name: &'static str, seconds: f64) {
    if seconds <= 0.0 {
        return;
    }
    match stack.iter_mut().find(|part| part.name == name) {
        Some(part) => part.seconds += seconds,
        None => stack.push(StackPart { name, seconds }),
    }
}

/// The time of a simulated phase shared out as its warps spent theirs.
fn simulated_stack(phase: &TimedPhase, seconds: f64) -> Vec<StackPart> {
    let WarpCycles { waiting_to_compute, computing, functions, waiting_for_port, issuing, waiting_for_data } =
        phase.warps;
    let parts = [
        ("ALU issue", waiting_to_compute + computing),
        ("EFU issue", functions),
        ("load/store port", waiting_for_port + issuing),
        (LATENCY, waiting_for_data),
    ];
    let all: f64 = parts.iter().map(|(_, cycles)| cycles).sum();
    let mut stack = Vec::new();
    for (name, cycles) in parts {
        add(&mut stack, name, seconds * cycles / all);
    }
    stack
}
