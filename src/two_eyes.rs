//! Two eyes that see a scene, and what their frames cost a GPU.

use crate::args::{EyesArgs, MachineArgs};
use crate::frame::Frame;
use crate::machine::Machine;
use crate::meter::{Meter, timed};
use crate::progress::Progress;
use crate::report::{self, Answer, Before};
use anyhow::{anyhow, bail};
use gpumodel::stereo::{PixelOrder, Window, replay_left, replay_right};
use gpumodel::{Attachments, Maps, Replayed, Stereo};
use reports::digits;
use scenes::Camera;
use tracer::reflections::GBuffer;
use tracer::stereo::{Eyes, Reprojection};
use tracer::{Frame as RayFrame, FrameTracer, TileSource, TraceHeader, View};

/// Between the eyes, of the depth of what is nearest: a rule of thumb of stereographers.
const INTERAXIAL: f64 = 1.0 / 30.0;
/// Times the convergence that eyes can be apart: further, and no head is meant.
const MOST_APART: f64 = 10.0;
/// Part of their distance that the places of eyes may be off.
const INEXACT: f64 = 0.01;

/// Techniques of two eyes: with the G-buffer in internal memory, in memory, and in internal memory without inspector and executor.
const TECHNIQUES: [&str; 3] = ["stereo", "stereo-memory", "stereo-in-place"];

/// Where two eyes are that see a scene.
///
/// # Errors
/// When an option is out of range, or nothing tells how far apart they are.
pub(crate) fn eyes(args: &EyesArgs, frame: &Frame<'_>) -> anyhow::Result<Eyes> {
    let Camera { eye, target, .. } = frame.scene().camera;
    let convergence = args.convergence.unwrap_or_else(|| eye.as_dvec3().distance(target.as_dvec3()));
    if convergence.is_nan() || convergence <= 0.0 {
        bail!(
            "--convergence {convergence}: a depth in front of the eyes expected; give a number above 0, or inf"
        );
    }
    let interaxial = args.interaxial.unwrap_or_else(|| INTERAXIAL * nearest(frame));
    if !interaxial.is_finite() || interaxial < 0.0 {
        match args.interaxial {
            Some(_) => bail!(
                "--interaxial {interaxial}: a distance between two eyes expected; give a finite number from 0 on"
            ),
            None => bail!(
                "{}: the camera sees no surface whose depth would tell how far apart eyes are; give --interaxial",
                frame.scene().name
            ),
        }
    }
    if interaxial > MOST_APART * convergence {
        bail!(
            "--interaxial {}: more than {MOST_APART} times the convergence of {}; give a smaller one, or a larger --convergence",
            digits(interaxial),
            digits(convergence)
        );
    }
    // Without the sign of a zero.
    let eyes = Eyes { interaxial: interaxial + 0.0, convergence };
    let [left, right] = eyes.views(&frame.view()).map(|view| view.eye().as_dvec3());
    let apart = left.distance(right);
    if (apart - interaxial).abs() > INEXACT * interaxial {
        bail!(
            "--interaxial {}: where the camera is, coordinates of 32 bits put the eyes {} apart; give a larger one, or move the scene to the origin",
            digits(interaxial),
            digits(apart)
        );
    }
    Ok(eyes)
}

/// Depth of the nearest surface that the camera between the eyes sees; infinite without one.
fn nearest(frame: &Frame<'_>) -> f64 {
    let [width, height] = frame.size();
    let between = GBuffer::trace(&frame.structure, frame.triangles(), frame.view(), width, height);
    f64::from(between.depth().nearest())
}

/// The machine that two eyes are rendered on; its technique is one of theirs, by default that which its GPU can run.
///
/// # Errors
/// When there is no such machine, or its technique is not of two eyes.
pub(crate) fn machine(args: &MachineArgs) -> anyhow::Result<Machine> {
    let with = |technique: &str| {
        let technique = Some(technique.to_owned());
        Machine::of_whole_frames(&MachineArgs { technique, ..args.clone() })
    };
    let [in_tiles, in_memory, _] = TECHNIQUES;
    let machine = match &args.technique {
        Some(technique) => with(technique)?,
        None => {
            let machine = with(in_memory)?;
            if machine.config.gpu.internal_memory.is_some() { with(in_tiles)? } else { machine }
        }
    };
    stereo(&machine)?;
    Ok(machine)
}

/// What its technique does for the right eye.
fn stereo(machine: &Machine) -> anyhow::Result<Stereo> {
    let technique = &machine.config.technique;
    technique.stereo.ok_or_else(|| {
        let names = TECHNIQUES.join(", ");
        anyhow!("--technique {}: has one eye; use one of: {names}", technique.name)
    })
}

/// What the frames of two eyes cost.
pub(crate) struct TwoEyes {
    /// Each traced as a whole: the left one, and the right one.
    pub(crate) traced: [Answer; 2],
    /// The left eye with what it does for the right one, and that with what it reuses.
    pub(crate) reusing: [Answer; 2],
    /// A table of tile sizes, where the G-buffer is in internal memory.
    pub(crate) tiles: String,
}

impl TwoEyes {
    /// Frames that are replayed.
    pub(crate) const REPLAYS: usize = 4;

    /// Replays all four frames; `known` is what the left view shows, as the right one sees it.
    ///
    /// # Errors
    /// When the machine cannot run them.
    pub(crate) fn new(
        frame: &Frame<'_>,
        [left, right]: [View; 2],
        known: &Reprojection,
        machine: &Machine,
        (before, meter): (&Before, &Meter),
    ) -> anyhow::Result<Self> {
        let [width, height] = frame.size();
        let _progress = Progress::spinner("replaying two eyes");
        let config = &machine.config;
        type Run<'r> = &'r dyn Fn(&FrameTracer<'_>) -> Result<Replayed, gpumodel::Error>;
        let answer = |source: &FrameTracer<'_>, run: Run<'_>| {
            let (replayed, seconds) = timed(|| run(source));
            let image = RayFrame::Image { width, height };
            let header = TraceHeader { frame: image, ..source.header().clone() };
            report::of_frame(&header, source.topology(), machine, replayed?, (before, seconds), meter)
        };
        let [left_eye, right_eye] = [left, right].map(|view| frame.tracer_from(view));
        let whole: Run<'_> = &|eye| gpumodel::replay(eye, config, Maps::Dropped, &|_, _| {});
        let stereo = stereo(machine)?;
        let order = PixelOrder::new(known, stereo.launch);
        let pixels = frame.tracer_of_pixels(right, order.pixels.clone(), order.known.clone());
        let in_tiles = stereo.gbuffer == Attachments::Tile;
        Ok(Self {
            reusing: [
                answer(&left_eye, &|eye| replay_left(eye, known, config))?,
                answer(&pixels, &|eye| replay_right(eye, &order, known, config))?,
            ],
            traced: [answer(&left_eye, whole)?, answer(&right_eye, whole)?],
            tiles: if in_tiles { tiles(known, &stereo, machine) } else { String::new() },
        })
    }

    /// The reports, side by side.
    pub(crate) fn reports(&self) -> reports::two_eyes::TwoEyes<'_> {
        reports::two_eyes::TwoEyes {
            traced: self.traced.each_ref().map(|answer| &answer.report),
            reusing: self.reusing.each_ref().map(|answer| &answer.report),
        }
    }
}

/// What tiles of other sizes would have in internal memory, and would read.
fn tiles(known: &Reprojection, stereo: &Stereo, machine: &Machine) -> String {
    let [width, _] = known.size();
    let others = [[8, 8], [16, 16], [32, 32], [64, 64], [width, 1]];
    let sizes = std::iter::once(stereo.tile).chain(others.into_iter().filter(|&tile| tile != stereo.tile));
    let rows: Vec<_> = sizes
        .map(|tile| {
            let Window { columns, bytes, dma_bytes, .. } = Window::of(known, &Stereo { tile, ..*stereo });
            (tile, columns, bytes, dma_bytes)
        })
        .collect();
    let there = u64::from(machine.config.gpu.tiler.tile_memory_bytes);
    reports::two_eyes::tile_table(&rows, there, stereo.tile)
}
