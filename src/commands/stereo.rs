//! `raybudget stereo`: pictures for two eyes, and how much of the right one the left one answers.

use crate::Outcome;
use crate::args::{MachineArgs, StereoArgs};
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::meter::Meter;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::report::Before;
use crate::settings::{FrameSettings, start_threads};
use crate::shading::{Mirrors, Shading, srgb};
use crate::two_eyes::{self, TwoEyes};
use anyhow::bail;
use rayon::prelude::*;
use reports::image::{Rgb, write_png};
use reports::{digits, json, timeline};
use scenes::{Feature, Vec3};
use std::fmt::Write;
use tracer::reflections::GBuffer;
use tracer::stereo::{Eyes, Reprojection, Source, TraversalWork};
use tracer::{Query, Ray, Silent};

/// Part of its distance from the eye that something is nearer which hides a surface: far beyond what f32 loses.
const NEARER: f32 = 1e-4;
/// Of pixels that are traced: yellow and blue of Okabe & Ito 2008, whom colour-blind people can tell apart.
const MISSING: Rgb = [240, 228, 66];
const COVERED: Rgb = [0, 114, 178];
/// Differences are shown so many times as large.
const AMPLIFIED: u32 = 4;

/// The pictures.
const FILES: [&str; 5] = ["left.png", "right.png", "right-traced.png", "traced-pixels.png", "difference.png"];

/// The reports, with a GPU: of each eye as it is with reuse, and traced as a whole.
const REPORTS: [&str; 4] = ["left.json", "right.json", "left-traced.json", "right-traced.json"];

/// Both eyes with reuse, one after the other.
const TIMELINE: &str = "timeline.json";

pub(crate) fn run(args: &StereoArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let settings = FrameSettings::new(&args.frame)?;
    let machine = match args.machine.gpu {
        Some(_) => Some(two_eyes::machine(&args.machine)?),
        None if args.machine == MachineArgs::default() => None,
        None => bail!(
            "a technique, layout or figure of a machine without --gpu: name the GPU that both eyes are rendered on"
        ),
    };
    if settings.features.choice(Feature::Normals).is_some() {
        bail!("--force and --leave-out normals: a picture is shaded by the flat normal; leave them out");
    }
    start_threads(args.run.threads)?;
    let folder = OutputFolder::create(&args.out)?;
    folder.check(&FILES)?;
    if machine.is_some() {
        folder.check(&REPORTS)?;
        folder.check(&[TIMELINE])?;
    }
    let scene = LoadedScene::load(&args.scene)?;
    let frame = Frame::build(&scene, &settings)?;
    let eyes = two_eyes::eyes(&args.eyes, &frame)?;
    let pair = {
        let _progress = Progress::spinner("tracing two eyes");
        Pair::new(&frame, eyes)?
    };
    let width = settings.size.width;
    let pictures = FILES.into_iter().zip(pair.pictures());
    let files = pictures.map(|(name, pixels)| Ok((name.to_owned(), write_png(width, &pixels)?)));
    let mut files = files.collect::<anyhow::Result<Vec<_>>>()?;
    let mut text = pair.text(&frame, eyes);
    if let Some(machine) = &machine {
        let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
        let views = eyes.views(&frame.view());
        let modelled = TwoEyes::new(&frame, views, &pair.reprojection, machine, (&before, meter))?;
        text.push_str(&modelled.reports().text());
        text.push_str(&modelled.tiles);
        let answers = modelled.reusing.iter().chain(&modelled.traced);
        let reports = REPORTS.into_iter().zip(answers);
        files.extend(
            reports.map(|(name, answer)| (name.to_owned(), json::write(&answer.report).into_bytes())),
        );
        let [left, right] = &modelled.reusing;
        let eyes = [("left eye", &left.report), ("right eye", &right.report)];
        files.push((TIMELINE.to_owned(), timeline::write(&eyes).into_bytes()));
    }
    folder.write_all(&files)?;
    console::print(&text)?;
    Ok(Outcome::Done)
}

/// Both images, and what they took.
struct Pair {
    left: Vec<Rgb>,
    /// From what the left one shows, and traced where that gives no answer.
    right: Vec<Rgb>,
    /// All of it traced.
    right_traced: Vec<Rgb>,
    reprojection: Reprojection,
    /// Pixels of the right image that show what the right eye does not see.
    hidden: u64,
    left_work: TraversalWork,
    right_work: TraversalWork,
}

impl Pair {
    fn new(frame: &Frame<'_>, eyes: Eyes) -> anyhow::Result<Self> {
        let [width, height] = frame.size();
        let views = eyes.views(&frame.view());
        let shading = Shading::new(frame);
        let [left_buffer, right_buffer] =
            views.map(|view| GBuffer::trace(&frame.structure, frame.triangles(), view, width, height));
        let reprojection = Reprojection::new(&left_buffer, &views[1]);
        let between = frame.view().eye();
        let [left_colours, right_colours] =
            [&left_buffer, &right_buffer].map(|buffer| colours(buffer, &shading, between));
        let mirrors = Mirrors::new(frame);
        let right_eye = views[1].eye();
        let reused = |pixel: usize| reprojection.left_pixel(pixel as u32);
        // What depends on the view is the right eye's own, also where the surface is the left one's.
        let in_mirrors = |buffer: &GBuffer<'_>, pixel: u32, eye: Vec3| {
            let surface = buffer.triangle(pixel).zip(buffer.departure(pixel)).zip(buffer.position(pixel));
            let reflected = mirrors.as_ref().zip(surface).map(|(mirrors, ((triangle, hit), position))| {
                mirrors.reflected(&shading, triangle, &hit, (position - eye).normalize_or_zero())
            });
            reflected.unwrap_or(Vec3::ZERO)
        };
        let picture = |colour: &(dyn Fn(usize) -> Vec3 + Sync)| -> Vec<Rgb> {
            (0..right_colours.len()).into_par_iter().map(|pixel| srgb(colour(pixel))).collect()
        };
        let traced = |buffer: &GBuffer<'_>, colours: &[Vec3], eye: Vec3, pixel: usize| {
            colours[pixel] + in_mirrors(buffer, pixel as u32, eye)
        };
        let left = picture(&|pixel| traced(&left_buffer, &left_colours, views[0].eye(), pixel));
        let right_traced = picture(&|pixel| traced(&right_buffer, &right_colours, right_eye, pixel));
        let right = picture(&|pixel| match reused(pixel) {
            Some(source) => traced(&left_buffer, &left_colours, right_eye, source as usize),
            None => traced(&right_buffer, &right_colours, right_eye, pixel),
        });
        let is_hidden = |source: u32| {
            left_buffer.position(source).is_some_and(|surface| {
                let sight = Ray {
                    origin: right_eye,
                    t_min: 0.0,
                    direction: surface - right_eye,
                    t_max: 1.0 - NEARER,
                };
                frame.structure.trace(&sight, Query::Any, &mut Silent).is_hit()
            })
        };
        let hidden = (0..right_traced.len())
            .into_par_iter()
            .filter(|&pixel| reused(pixel).is_some_and(is_hidden))
            .count() as u64;
        let [left_view, right_view] = views;
        let left_work = TraversalWork::of(&frame.tracer_from(left_view), None)?;
        let right_work = TraversalWork::of(&frame.tracer_from(right_view), Some(&reprojection))?;
        Ok(Self { left, right, right_traced, reprojection, hidden, left_work, right_work })
    }

    /// As [`FILES`] names them.
    fn pictures(&self) -> [Vec<Rgb>; 5] {
        let grey = |&[r, g, b]: &Rgb| {
            // Luma of ITU-R BT.709.
            (0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b)).round() as u8
        };
        let traced = self.right_traced.iter().zip(self.reprojection.sources());
        let traced = traced.map(|(pixel, source)| match source {
            Source::Left(_) => [grey(pixel); 3],
            Source::Missing => MISSING,
            Source::Covered => COVERED,
        });
        let differences = self.right.iter().zip(&self.right_traced);
        let differences = differences.map(|(pixel, traced)| {
            let amplified = |channel: usize| {
                (u32::from(pixel[channel].abs_diff(traced[channel])) * AMPLIFIED).min(255) as u8
            };
            [amplified(0), amplified(1), amplified(2)]
        });
        [
            self.left.clone(),
            self.right.clone(),
            self.right_traced.clone(),
            traced.collect(),
            differences.collect(),
        ]
    }

    fn text(&self, frame: &Frame<'_>, Eyes { interaxial, convergence }: Eyes) -> String {
        let [width, height] = frame.size();
        let pixels = self.right.len() as f64;
        let [reused, missing, covered] = self.reprojection.counts();
        let mut text = format!(
            "{}: two eyes of {width}x{height}, {} apart, converging at {} (units of the scene)\n\n\
             right image                              pixels    share\n",
            frame.scene().name,
            digits(interaxial),
            digits(convergence),
        );
        for (what, count) in [
            ("what the left image shows", reused),
            ("traced: nothing lands there", missing),
            ("traced: covered, by the row test", covered),
        ] {
            let _ = writeln!(text, "{what:<36} {count:>10}  {:>5.2} %", 100.0 * count as f64 / pixels);
        }
        let differing =
            self.right.iter().zip(&self.right_traced).filter(|(pixel, traced)| pixel != traced).count();
        let _ = writeln!(
            text,
            "reused, and hidden from the right eye {:>9}  {:>5.2} %\n\n\
             against an image that is traced whole: PSNR {}, {:.2} % of the pixels differ",
            self.hidden,
            100.0 * self.hidden as f64 / pixels,
            psnr(&self.right, &self.right_traced),
            100.0 * differing as f64 / pixels,
        );
        text.push_str(&self.work());
        text
    }

    /// Speed-up S of traversal, and the model of it by the share of reusable work.
    fn work(&self) -> String {
        let Self { left_work, right_work, .. } = self;
        let without = left_work.whole() + right_work.whole();
        let with = left_work.whole() + right_work.with_reuse();
        let mut text = format!(
            "\nnode and triangle steps       left eye   right eye  with reuse\n\
             same from any view      {:>14} {:>11} {:>11}\n\
             reflections             {:>14} {:>11} {:>11}\n",
            left_work.reusable,
            right_work.reusable,
            right_work.unanswered,
            left_work.view_dependent,
            right_work.view_dependent,
            right_work.view_dependent,
        );
        if with > 0 && right_work.whole() > 0 {
            let reusable = right_work.reusable as f64 / right_work.whole() as f64;
            let [reused, missing, covered] = self.reprojection.counts();
            let traced = (missing + covered) as f64 / (reused + missing + covered) as f64;
            let _ = writeln!(
                text,
                "both eyes: {:.3} times as many steps without reuse; 2 / (2 - p (1 - b)) = {:.3} with p = {reusable:.3} of an eye's steps\n\
                 reusable and b = {traced:.4} of the pixels traced",
                without as f64 / with as f64,
                2.0 / (2.0 - reusable * (1.0 - traced)),
            );
        }
        text
    }
}

/// What an eye sees but for reflections, linear; black where that is nothing. Without lights it is lit from `between` the eyes, so that both see a
/// surface alike.
fn colours(buffer: &GBuffer<'_>, shading: &Shading<'_>, between: Vec3) -> Vec<Vec3> {
    let colour = |pixel: u32| {
        let hit = buffer.triangle(pixel).zip(buffer.departure(pixel));
        hit.map_or(Vec3::ZERO, |(triangle, surface)| {
            shading.colour(triangle, &surface, surface.origin - between)
        })
    };
    (0..buffer.pixels()).into_par_iter().map(colour).collect()
}

/// Peak signal-to-noise ratio of all channels, in decibels.
fn psnr(image: &[Rgb], reference: &[Rgb]) -> String {
    let squares = image.as_flattened().iter().zip(reference.as_flattened());
    let sum: u64 = squares.map(|(&a, &b)| u64::from(a.abs_diff(b)).pow(2)).sum();
    if sum == 0 {
        return "infinite".to_owned();
    }
    let mean = sum as f64 / reference.as_flattened().len() as f64;
    format!("{:.2} dB", 10.0 * (255.0 * 255.0 / mean).log10())
}

#[cfg(test)]
mod tests {
    use super::psnr;

    #[test]
    fn one_level_everywhere_is_48_decibels() {
        assert_eq!(psnr(&[[1, 2, 3]; 4], &[[2, 1, 4]; 4]), "48.13 dB");
        assert_eq!(psnr(&[[0, 0, 0]], &[[255, 255, 255]]), "0.00 dB");
        assert_eq!(psnr(&[[7, 8, 9]], &[[7, 8, 9]]), "infinite");
    }
}
