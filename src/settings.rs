//! The frame as it was asked for, checked: what can be refused before any work is refused here.

use crate::alpha::AlphaRequest;
use crate::args::FrameArgs;
use crate::features::Features;
use crate::machine::choice;
use crate::ray_sets::RayRequest;
use anyhow::{anyhow, bail};
use tracer::bvh::restart_trail::TrailBits;
use tracer::kd::{FlatCells, KdOptions, Splits};
use tracer::wide::NodeFormat;
use tracer::{Accel, BuildOptions, Query, Traversal, TriangleTest};

/// Longest side of an image: what the described GPUs can render to (Vulkan's maxImageDimension2D on Adreno 5xx).
const MAX_SIDE: u32 = 16384;
/// Most pixels of an image: a map of one figure per pixel then takes 256 MiB.
const MAX_PIXELS: u64 = 1 << 26;

/// Size of an image in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImageSize {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Default for ImageSize {
    fn default() -> Self {
        Self { width: 1024, height: 1024 }
    }
}

impl ImageSize {
    fn parse(text: &str) -> anyhow::Result<Self> {
        let parts = text.split_once(['x', 'X']);
        let sides = parts.and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
        let Some((width, height)): Option<(u32, u32)> = sides else {
            bail!("--size {text}: expected WIDTHxHEIGHT in pixels, such as 1024x1024");
        };
        if width == 0 || height == 0 {
            bail!("--size {text}: an image without pixels casts no rays; expected at least 1x1");
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            bail!(
                "--size {text}: expected at most {MAX_SIDE} pixels a side, the largest image that the described GPUs \
                 render to; give a smaller size"
            );
        }
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            bail!(
                "--size {text}: expected at most {MAX_PIXELS} pixels (8192x8192), so that figures kept per pixel fit in \
                 memory; give a smaller size"
            );
        }
        Ok(Self { width, height })
    }
}

/// Which rays are traced through which structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameSettings {
    pub(crate) size: ImageSize,
    pub(crate) traversal: Traversal,
    pub(crate) build: BuildOptions,
    pub(crate) features: Features,
    pub(crate) rays: RayRequest,
    pub(crate) shadow_query: Query,
    pub(crate) alpha: AlphaRequest,
}

impl FrameSettings {
    pub(crate) fn new(args: &FrameArgs) -> anyhow::Result<Self> {
        let FrameArgs {
            accel,
            traversal,
            size,
            ct,
            ci,
            node_format,
            short_stack,
            trail_bits,
            force,
            leave_out,
            ray_sets: _,
            spp: _,
            ray_seed: _,
            shadow_query,
            alpha: _,
            micromap_level: _,
            micromap_states: _,
            light_radius: _,
            ao_radius: _,
            triangle_test,
            splits,
            flat_cells,
            empty_bonus,
            max_depth,
        } = args;
        let accel = match accel.as_deref() {
            Some("wide-bvh") => Accel::WideBvh,
            Some("kd") => Accel::Kd,
            Some("grid") => Accel::Grid,
            Some("two-level") => Accel::TwoLevel,
            _ => Accel::Bvh,
        };
        let plain_traversal = match accel {
            Accel::Bvh | Accel::WideBvh | Accel::Kd | Accel::TwoLevel => "stack",
            Accel::Grid => "dda",
        };
        let mut traversal = Traversal::named(accel, traversal.as_deref().unwrap_or(plain_traversal))?;
        if let Some(name) = node_format {
            let names = NodeFormat::ALL.map(NodeFormat::name).join(", ");
            let named = NodeFormat::from_name(name)
                .ok_or_else(|| anyhow!("--node-format {name}: no such one; use: {names}"))?;
            match &mut traversal {
                Traversal::WideStack { format }
                | Traversal::WideShortStack { format, .. }
                | Traversal::TwoLevelShortStack { format, .. } => *format = named,
                Traversal::TwoLevelStack { format } => *format = Some(named),
                _ => bail!(
                    "--node-format is an option of wide BVHs; add --accel wide-bvh or two-level, or leave it out"
                ),
            }
        }
        set_short_stack(&mut traversal, *short_stack, trail_bits.as_deref())?;

        let kd_options = [
            ("--splits", splits.is_some()),
            ("--flat-cells", flat_cells.is_some()),
            ("--empty-bonus", empty_bonus.is_some()),
            ("--max-depth", max_depth.is_some()),
        ];
        if let Some((option, _)) = kd_options.iter().find(|(_, given)| *given && accel != Accel::Kd) {
            if accel == Accel::TwoLevel {
                bail!(
                    "{option} is an option of kd-trees, and the trees of two levels are BVHs: binary ones, or wide ones with --node-format; \
                     leave it out"
                );
            }
            bail!("{option} is an option of kd-trees; add --accel kd, or leave it out");
        }
        let costs = [("--ct", ct.is_some()), ("--ci", ci.is_some())];
        if let Some((option, _)) = costs.iter().find(|(_, given)| *given && accel == Accel::Grid) {
            bail!(
                "{option} is a cost by which trees are built, and a grid is not; use --accel bvh or kd, or leave it out"
            );
        }
        let plain = BuildOptions::default();
        let kd = KdOptions {
            splits: match splits.as_deref() {
                Some("perfect") => Splits::Perfect,
                _ => Splits::BoundingBox,
            },
            flat_cells: match flat_cells.as_deref() {
                Some("forbidden") => FlatCells::Forbidden,
                _ => FlatCells::Allowed,
            },
            empty_bonus: empty_bonus.unwrap_or(plain.kd.empty_bonus),
            max_depth: *max_depth,
            ..plain.kd
        };
        if traversal == Traversal::KdBacktrack && flat_cells.as_deref() == Some("allowed") {
            bail!("--flat-cells allowed: backtracking cannot leave a cell without thickness; leave it out");
        }
        let features = Features::new(force, leave_out)?;
        Ok(Self {
            features,
            alpha: AlphaRequest::new(args, features)?,
            rays: RayRequest::new(args, features)?,
            shadow_query: choice(
                "--shadow-query",
                shadow_query,
                Query::from_name,
                &Query::ALL.map(Query::name),
            )?
            .unwrap_or(Query::Any),
            size: size.as_deref().map(ImageSize::parse).transpose()?.unwrap_or_default(),
            traversal,
            build: BuildOptions {
                traversal_cost: ct.unwrap_or(plain.traversal_cost),
                intersection_cost: ci.unwrap_or(plain.intersection_cost),
                kd,
                triangle_test: triangle_test.as_deref().and_then(TriangleTest::from_name).unwrap_or_default(),
            },
        })
    }
}

fn set_short_stack(
    traversal: &mut Traversal,
    entries: Option<u32>,
    trail_bits: Option<&str>,
) -> anyhow::Result<()> {
    let name = traversal.name();
    match traversal {
        Traversal::BvhRestartTrail { bits, short_stack } => {
            *short_stack = entries.unwrap_or(*short_stack);
            *bits = match trail_bits {
                Some("32") => Some(TrailBits::Bits32),
                Some(_) => Some(TrailBits::Bits64),
                None => None,
            };
            return Ok(());
        }
        Traversal::KdPushDown { short_stack }
        | Traversal::WideShortStack { short_stack, .. }
        | Traversal::TwoLevelShortStack { short_stack, .. } => {
            *short_stack = entries.unwrap_or(*short_stack);
        }
        _ if entries.is_some() => {
            bail!(
                "--short-stack: {name} has none; use --traversal restart-trail, --accel kd --traversal push-down or --accel wide-bvh or two-level \
                 --traversal short-stack, or leave it out"
            );
        }
        _ => {}
    }
    if trail_bits.is_some() {
        bail!("--trail-bits: {name} has no trail; use --traversal restart-trail, or leave it out");
    }
    Ok(())
}

/// Starts the worker threads; says how many there are.
pub(crate) fn start_threads(threads: Option<u32>) -> anyhow::Result<()> {
    let Some(threads) = threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads as usize)
        .build_global()
        .map_err(|error| anyhow!("--threads {threads}: cannot start them: {error}; give a smaller number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(args: &FrameArgs) -> Result<FrameSettings, String> {
        FrameSettings::new(args).map_err(|error| error.to_string())
    }

    fn sized(size: &str) -> Result<ImageSize, String> {
        ImageSize::parse(size).map_err(|error| error.to_string())
    }

    #[test]
    fn image_sizes_are_taken_up_to_their_limits_and_not_one_pixel_beyond() {
        assert_eq!(sized("1x1"), Ok(ImageSize { width: 1, height: 1 }));
        assert_eq!(sized("16384x4096"), Ok(ImageSize { width: 16384, height: 4096 }));
        assert!(sized("16385x1").unwrap_err().contains("at most 16384"));
        assert!(sized("1x16385").unwrap_err().contains("at most 16384"));
        assert!(sized("16384x4097").unwrap_err().contains("at most 67108864 pixels"));
        assert!(sized("100000x100000").unwrap_err().contains("at most 16384"));
        for wrong in ["0x0", "1x0", "0x1"] {
            assert!(sized(wrong).unwrap_err().contains("without pixels"), "{wrong}");
        }
        for wrong in ["", "x", "12", "12x", "x12", "1x2x3", "-1x2", "1.5x2", "99999999999x1"] {
            assert!(sized(wrong).unwrap_err().contains("expected WIDTHxHEIGHT"), "{wrong}");
        }
    }

    #[test]
    fn options_of_another_traversal_are_refused() {
        let text = |text: &str| Some(text.to_owned());
        let refused = |args: FrameArgs, expected: &str| {
            let error = settings(&args).unwrap_err();
            assert!(error.contains(expected), "{error}");
        };
        refused(FrameArgs { splits: text("perfect"), ..Default::default() }, "--accel kd");
        refused(FrameArgs { max_depth: Some(9), ..Default::default() }, "--accel kd");
        refused(FrameArgs { node_format: text("full-4"), ..Default::default() }, "--accel wide-bvh");
        refused(FrameArgs { short_stack: Some(4), ..Default::default() }, "--short-stack");
        let two_level = || FrameArgs { accel: text("two-level"), ..Default::default() };
        refused(FrameArgs { splits: text("perfect"), ..two_level() }, "the trees of two levels are BVHs");
        refused(FrameArgs { traversal: text("dda"), ..two_level() }, "use one of: stack");
        refused(FrameArgs { short_stack: Some(4), ..two_level() }, "--short-stack");
        refused(
            FrameArgs {
                trail_bits: text("32"),
                accel: text("kd"),
                traversal: text("push-down"),
                ..Default::default()
            },
            "--trail-bits",
        );
        let grid = || FrameArgs { accel: text("grid"), ..Default::default() };
        refused(FrameArgs { ct: Some(1.0), ..grid() }, "--ct");
        refused(FrameArgs { ci: Some(1.0), ..grid() }, "--ci");
        refused(FrameArgs { splits: text("perfect"), ..grid() }, "--accel kd");
        refused(FrameArgs { traversal: text("stack"), ..grid() }, "use one of: dda");
        refused(FrameArgs { traversal: text("dda"), ..Default::default() }, "use one of: stack, parent-link");
        refused(
            FrameArgs { accel: text("kd"), traversal: text("parent-link"), ..Default::default() },
            "stack, restart, push-down, backtrack",
        );
    }

    #[test]
    fn each_structure_has_a_traversal_when_none_is_named() {
        for (accel, expected) in [
            (None, Traversal::BvhStack),
            (Some("bvh"), Traversal::BvhStack),
            (Some("wide-bvh"), Traversal::WideStack { format: NodeFormat::Compressed8 }),
            (Some("kd"), Traversal::KdStack),
            (Some("grid"), Traversal::GridDda),
            (Some("two-level"), Traversal::TwoLevelStack { format: None }),
        ] {
            let args = FrameArgs { accel: accel.map(str::to_owned), ..Default::default() };
            assert_eq!(settings(&args).map(|settings| settings.traversal), Ok(expected));
        }
    }

    #[test]
    fn each_option_reaches_its_place() {
        let text = |text: &str| Some(text.to_owned());
        let bvh = settings(&FrameArgs {
            traversal: text("restart-trail"),
            short_stack: Some(4),
            trail_bits: text("32"),
            ct: Some(1.0),
            ci: Some(2.0),
            size: text("640x480"),
            ..Default::default()
        })
        .expect("a good frame");
        assert_eq!(
            bvh.traversal,
            Traversal::BvhRestartTrail { bits: Some(TrailBits::Bits32), short_stack: 4 }
        );
        assert_eq!([bvh.build.traversal_cost, bvh.build.intersection_cost], [1.0, 2.0]);
        assert_eq!(bvh.size, ImageSize { width: 640, height: 480 });
        let kd = settings(&FrameArgs {
            accel: text("kd"),
            splits: text("perfect"),
            flat_cells: text("forbidden"),
            empty_bonus: Some(0.8),
            max_depth: Some(20),
            ..Default::default()
        })
        .expect("a good frame");
        assert_eq!(kd.build.kd.splits, Splits::Perfect);
        assert_eq!(kd.build.kd.flat_cells, FlatCells::Forbidden);
        assert_eq!(kd.build.kd.empty_bonus, 0.8);
        assert_eq!(kd.build.kd.max_depth, Some(20));
    }
}
