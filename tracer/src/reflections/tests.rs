//! Does every march end, and where it should, before depths that no scene needs to have?

use super::pyramid::DepthPyramid;
use super::screen_ray::{Projection, ScreenRay};
use super::{March, MarchBounds, MarchEnd};
use crate::ray::Ray;
use crate::view::View;
use glam::Vec3;
use proptest::prelude::*;
use scenes::Camera;

const NEAR: f32 = 1.0;

/// A camera at the origin that looks along negative z, with 90 degrees from the lower to the upper edge.
fn projection([width, height]: [u32; 2]) -> Projection {
    let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vertical_fov_degrees: 90.0 };
    Projection::new(&View::new(&camera, width, height))
}

/// The end of a march, and what it read.
fn marched(march: March, ray: &Ray, depth: &DepthPyramid, faces: bool) -> (MarchEnd, Vec<[u32; 3]>) {
    let size = depth.size(0);
    let on_screen = ScreenRay::new(&projection(size), ray, size, NEAR);
    let mut texels = Vec::new();
    let end = march.follow(
        on_screen.as_ref(),
        depth,
        |_| faces,
        |level, x, y| {
            let [width, height] = depth.size(level);
            assert!(x < width && y < height, "texel {x}, {y} of level {level}");
            texels.push([level, x, y]);
        },
    );
    (end, texels)
}

fn flat(size: [u32; 2], depth: f32) -> DepthPyramid {
    DepthPyramid::new(size[0], size[1], vec![depth; (size[0] * size[1]) as usize])
}

/// A ray that begins in the middle of the left edge's pixels, at this depth, and ends there at the right edge.
fn across(edge: u32, depth: f32) -> Ray {
    let pixel = 2.0 * depth / edge as f32;
    Ray::new(Vec3::new(pixel / 2.0 - depth, pixel / 2.0, -depth), Vec3::X)
}

#[test]
fn empty_space_takes_a_texel_per_pixel_or_one_per_level() {
    let sky = flat([256, 256], f32::INFINITY);
    let (end, texels) = marched(March::LINEAR, &across(256, 4.0), &sky, true);
    assert!(matches!(end, MarchEnd::Miss { .. }));
    assert_eq!(texels, (1..256).map(|x| [0, x, 127]).collect::<Vec<_>>());
    let (end, texels) = marched(March::HIERARCHICAL, &across(256, 4.0), &sky, true);
    assert!(matches!(end, MarchEnd::Miss { .. }));
    assert_eq!(texels, (0..8).map(|level| [level, 1, 127 >> level]).collect::<Vec<_>>());
}

#[test]
fn what_is_free_ends_a_pixel_before_the_march_does() {
    let sky = flat([64, 64], f32::INFINITY);
    // 8 units are 64 pixels wide at depth 4; the ray begins half a pixel from the left.
    for march in [March::LINEAR, March::HIERARCHICAL] {
        let (end, _) = marched(march, &across(64, 4.0), &sky, true);
        let MarchEnd::Miss { t } = end else { panic!("{end:?}") };
        assert!((t - (8.0 - 1.5 * 8.0 / 64.0)).abs() < 1e-4, "{march:?}: {t}");
    }
}

/// Sky, and from column `x` on a wall of this depth.
fn wall(edge: u32, from: u32, depth: f32) -> DepthPyramid {
    let at = |pixel: u32| if pixel % edge < from { f32::INFINITY } else { depth };
    DepthPyramid::new(edge, edge, (0..edge * edge).map(at).collect())
}

#[test]
fn a_surface_is_hit_up_to_its_thickness_and_no_farther() {
    let bounds = MarchBounds { thickness: 0.25, texels: 500 };
    for march in [
        March::Linear { stride: 1, bounds },
        March::Linear { stride: 7, bounds },
        March::Hierarchical { bounds },
    ] {
        let end = |wall_depth: f32, faces: bool| {
            marched(march, &across(100, 5.0), &wall(100, 40, wall_depth), faces).0
        };
        assert_eq!(end(4.0, true), MarchEnd::Hit { x: 40, y: 49 }, "{march:?}, 5 is 4 and a quarter of it");
        assert!(matches!(end(3.99, true), MarchEnd::Miss { .. }), "{march:?}");
        assert!(matches!(end(5.01, true), MarchEnd::Miss { .. }), "{march:?} passes before it");
        // Free up to the wall, and a pixel less; of a wall that turns away no more, though the march goes on.
        for (depth, faces) in [(3.0, true), (4.5, false)] {
            let MarchEnd::Miss { t } = end(depth, faces) else { panic!("a hit by {march:?}") };
            let pixels = t / (10.0 / 100.0);
            let least = if matches!(march, March::Linear { stride: 7, .. }) { 35.0 } else { 38.4 };
            assert!((least..38.6).contains(&pixels), "{march:?}: {pixels}");
        }
    }
}

#[test]
fn a_long_stride_finds_the_first_texel_by_bisection() {
    let bounds = MarchBounds { thickness: 1.0, texels: 500 };
    for column in 1..57 {
        let (end, texels) =
            marched(March::Linear { stride: 8, bounds }, &across(64, 5.0), &wall(64, column, 4.0), true);
        assert_eq!(end, MarchEnd::Hit { x: column, y: 31 });
        assert_eq!(texels.len(), column.div_ceil(8) as usize + 3, "and in as few reads as eight texels take");
    }
}

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -3.0_f32..3.0,
        1 => Just(0.0),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, -0.0, f32::MAX, f32::MIN_POSITIVE, 1e-30, -1e20]),
    ]
}

fn any_vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(any_number()).prop_map(Vec3::from_array)
}

fn any_march() -> impl Strategy<Value = March> {
    let bounds = (prop_oneof![Just(0.0), 0.0..0.5_f32, Just(f32::INFINITY)], 0..300_u32)
        .prop_map(|(thickness, texels)| MarchBounds { thickness, texels });
    let stride = prop_oneof![Just(0), 1..40_u32, Just(u32::MAX)];
    prop_oneof![
        bounds.clone().prop_map(|bounds| March::Hierarchical { bounds }),
        (stride, bounds).prop_map(|(stride, bounds)| March::Linear { stride, bounds }),
    ]
}

proptest! {
    #[test]
    fn any_march_ends_within_its_bound_on_the_screen_and_at_a_parameter(
        march in any_march(),
        size in (1..70_u32, 1..70_u32),
        at in (0.0..1.0_f32, 0.0..1.0_f32, 0.5..20.0_f32),
        elsewhere in prop::option::weighted(0.2, any_vector()),
        direction in any_vector(),
        seed in any::<u32>(),
        faces in any::<bool>(),
    ) {
        let size = [size.0, size.1];
        let half_width = size[0] as f32 / size[1] as f32;
        let on_screen = Vec3::new((2.0 * at.0 - 1.0) * half_width, 2.0 * at.1 - 1.0, -1.0) * at.2;
        let ray = Ray::new(elsewhere.unwrap_or(on_screen), direction);
        let depth = |pixel: u32| match (pixel ^ seed).wrapping_mul(0x9E37_79B9) >> 24 {
            0..60 => f32::INFINITY,
            other => 1.0 + other as f32 / 16.0,
        };
        let pyramid = DepthPyramid::new(size[0], size[1], (0..size[0] * size[1]).map(depth).collect());
        let (end, texels) = marched(march, &ray, &pyramid, faces);
        let (March::Linear { bounds, .. } | March::Hierarchical { bounds }) = march;
        prop_assert!(texels.len() <= bounds.texels as usize);
        match end {
            MarchEnd::Hit { x, y } => prop_assert!(pyramid.depth(0, x, y).is_finite() && faces),
            MarchEnd::Miss { t } => prop_assert!(t >= 0.0, "{}", t),
        }
    }
}
