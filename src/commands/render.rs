//! `raybudget render`: a picture of a scene, traced on this machine's CPU.
//!
//! The rays are those of a frame: a primary ray for each pixel and, from its hit, a shadow ray to each light. No observer listens, so the
//! time is that of the traversals themselves. It is no estimate of any GPU.

use crate::Outcome;
use crate::args::RenderArgs;
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::meter::timed;
use crate::output::OutputFile;
use crate::progress::Progress;
use crate::ray_sets::RayRequest;
use crate::settings::{FrameSettings, start_threads};
use crate::shading::{Shading, srgb};
use anyhow::bail;
use rayon::prelude::*;
use reports::image::{self, Rgb};
use scenes::{Feature, Vec3};
use tracer::{Query, RayOffset, Silent, View};

pub(crate) fn run(args: &RenderArgs) -> anyhow::Result<Outcome> {
    let settings = FrameSettings::new(&args.frame)?;
    if settings.features.choice(Feature::Normals).is_some() {
        bail!("--force and --leave-out normals: a picture is shaded by the flat normal; leave them out");
    }
    let others =
        Feature::ALL.into_iter().filter(|&feature| feature.is_rays() && feature != Feature::ShadowRays);
    if settings.rays != RayRequest::default()
        || others.into_iter().any(|feature| settings.features.choice(feature).is_some())
    {
        bail!("--ray-sets and its options: a picture has primary and hard shadow rays alone; leave them out");
    }
    start_threads(args.run.threads)?;
    let out = OutputFile::create(&args.out)?;
    let scene = LoadedScene::load(&args.scene)?;
    let frame = Frame::build(&scene, &settings)?;
    let (width, height) = (settings.size.width, settings.size.height);
    let camera = Camera {
        frame: &frame,
        view: frame.view(),
        offset: RayOffset::new(frame.triangles()),
        shading: Shading::new(&frame),
    };
    let progress = Progress::spinner("rendering");
    let mut pixels: Vec<Rgb> = vec![[0; 3]; width as usize * height as usize];
    let (shadow_rays, trace_s) = timed(|| {
        let rows = pixels.par_chunks_mut(width as usize).enumerate();
        rows.map(|(y, row)| camera.row(y as u32, row)).sum::<u64>()
    });
    drop(progress);
    out.written(&image::write_png(width, &pixels)?)?.finish()?;
    let primary_rays = pixels.len() as u64;
    console::print(&format!(
        "{}: {primary_rays} primary and {shadow_rays} shadow rays through {} {} in {trace_s:.3} s, {:.3} Mrays/s \
         with --threads {}\nCPU time on this machine, shading included; no GPU is modelled\nload {:.2} s, build {:.2} s\n",
        args.out.display(),
        settings.traversal.accel().name(),
        settings.traversal.name(),
        (primary_rays + shadow_rays) as f64 / trace_s / 1e6,
        rayon::current_num_threads(),
        scene.load_s,
        frame.build_s,
    ))?;
    Ok(Outcome::Done)
}

/// What a pixel is rendered from.
struct Camera<'a> {
    frame: &'a Frame<'a>,
    view: View,
    offset: RayOffset,
    shading: Shading<'a>,
}

impl Camera<'_> {
    /// Renders row `y`; says how many shadow rays that took.
    fn row(&self, y: u32, row: &mut [Rgb]) -> u64 {
        let mut shadow_rays = 0;
        for (x, pixel) in (0..).zip(row) {
            let colour = self.pixel(x, y);
            shadow_rays += colour.map_or(0, |_| self.shading.lights());
            *pixel = srgb(colour.unwrap_or(Vec3::ZERO));
        }
        shadow_rays
    }

    /// Linear colour of a pixel; `None` where the primary ray hits nothing.
    fn pixel(&self, x: u32, y: u32) -> Option<Vec3> {
        let structure = &self.frame.structure;
        let ray = self.view.primary_ray(x, y);
        let hit = structure.trace(&ray, Query::Closest, &mut Silent);
        if !hit.is_hit() {
            return None;
        }
        let triangle = &self.frame.triangles()[hit.primitive as usize];
        let departure = self.offset.departure(triangle, hit.u, hit.v, ray.direction);
        Some(self.shading.colour(hit.primitive, &departure, ray.direction))
    }
}
