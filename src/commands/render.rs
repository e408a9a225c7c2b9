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
use anyhow::bail;
use rayon::prelude::*;
use reports::image::{self, Rgb};
use scenes::{Feature, Scene, Vec3};
use tracer::{Query, RayOffset, Silent, View};

/// Light that reaches every surface, so that shadows keep their shapes.
const AMBIENT: f32 = 0.1;

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
        lights: frame.lights(),
        offset: RayOffset::new(frame.triangles()),
        colours: colours(&scene.scene),
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

/// The diffuse colour of every triangle, in the order of [`Scene::triangles`].
fn colours(scene: &Scene) -> Vec<Vec3> {
    let meshes = scene.instances.iter().map(|instance| &scene.meshes[instance.mesh as usize]);
    let materials = meshes.flat_map(|mesh| &mesh.materials);
    materials.map(|&material| scene.materials[material as usize].diffuse).collect()
}

/// What a pixel is rendered from.
struct Camera<'a> {
    frame: &'a Frame<'a>,
    view: View,
    lights: Vec<Vec3>,
    offset: RayOffset,
    /// Linear, by triangle.
    colours: Vec<Vec3>,
}

impl Camera<'_> {
    /// Renders row `y`; says how many shadow rays that took.
    fn row(&self, y: u32, row: &mut [Rgb]) -> u64 {
        let mut shadow_rays = 0;
        for (x, pixel) in (0..).zip(row) {
            let colour = self.pixel(x, y);
            shadow_rays += colour.map_or(0, |_| self.lights.len() as u64);
            *pixel = srgb(colour.unwrap_or(Vec3::ZERO));
        }
        shadow_rays
    }

    /// Linear colour of a pixel: the diffuse colour, lit through the angle of the geometric normal by each light that is seen. Without
    /// lights it is lit from the eye. `None` where the primary ray hits nothing.
    fn pixel(&self, x: u32, y: u32) -> Option<Vec3> {
        let structure = &self.frame.structure;
        let ray = self.view.primary_ray(x, y);
        let hit = structure.trace(&ray, Query::Closest, &mut Silent);
        if !hit.is_hit() {
            return None;
        }
        let triangle = &self.frame.triangles()[hit.primitive as usize];
        let [a, b, c] = triangle.v;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let angle = |towards: Vec3| normal.dot(towards.normalize_or_zero()).abs();
        let seen = |&light: &Vec3| {
            let shadow = self.offset.shadow_ray(triangle, hit.u, hit.v, ray.direction, light);
            let hidden = structure.trace(&shadow, Query::Any, &mut Silent).is_hit();
            if hidden { 0.0 } else { angle(shadow.direction) }
        };
        let light = match self.lights.as_slice() {
            [] => angle(ray.direction),
            lights => lights.iter().map(seen).sum(),
        };
        Some(self.colours[hit.primitive as usize] * (AMBIENT + (1.0 - AMBIENT) * light))
    }
}

/// Linear light as sRGB of 8 bits (IEC 61966-2-1); what is brighter than white is white.
fn srgb(linear: Vec3) -> Rgb {
    linear.to_array().map(|value| {
        let value = value.clamp(0.0, 1.0);
        let curve = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (curve * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_encoded_by_the_curve_of_srgb() {
        assert_eq!(srgb(Vec3::new(0.0, 1.0, 7.0)), [0, 255, 255]);
        assert_eq!(srgb(Vec3::new(-1.0, 0.215_861, 0.001)), [0, 128, 3]);
    }

    #[test]
    fn every_triangle_has_a_colour() {
        for builtin in scenes::BUILTINS {
            let scene = scenes::load(builtin.name).expect("it is built in");
            assert_eq!(colours(&scene).len(), scene.triangles().len(), "{}", builtin.name);
        }
    }
}
