//! Is what the right eye is shown what it would see?

use super::{Eyes, Reprojection, Source, TraversalWork};
use crate::accel::{AccelerationStructure, BuildOptions, Traversal};
use crate::observe::Silent;
use crate::ray::Query;
use crate::reflections::GBuffer;
use crate::secondary::{ReflectionRays, SecondaryRays};
use crate::tracing::{FrameTracer, Rays, SceneIdentity};
use crate::view::View;
use glam::Vec3;
use scenes::{Camera, Scene, Triangle};

const SIZE: [u32; 2] = [150, 90];

struct World {
    camera: View,
    distance: f64,
    triangles: Vec<Triangle>,
    structure: AccelerationStructure,
}

impl World {
    fn new(triangles: Vec<Triangle>, camera: &Camera) -> Self {
        let options = BuildOptions::default();
        let structure =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &options).expect("it can be built");
        let [width, height] = SIZE;
        Self {
            camera: View::new(camera, width, height),
            distance: f64::from(camera.eye.distance(camera.target)),
            triangles,
            structure,
        }
    }

    fn builtin(name: &str) -> Self {
        let scene: Scene = scenes::load(name).expect("it is built in");
        Self::new(scene.triangles(), &scene.camera)
    }

    fn gbuffer(&self, view: View) -> GBuffer<'_> {
        GBuffer::trace(&self.structure, &self.triangles, view, SIZE[0], SIZE[1])
    }

    fn reprojection(&self, eyes: Eyes) -> Reprojection {
        let [left, right] = eyes.views(&self.camera);
        Reprojection::new(&self.gbuffer(left), &right)
    }

    /// Every surface a mirror, with a light above.
    fn tracer(&self, rays: Rays) -> FrameTracer<'_> {
        let light = vec![self.camera.primary_ray(0, 0).origin + Vec3::Y];
        let identity = SceneIdentity { name: "test".to_owned(), hash: 0 };
        let options = BuildOptions::default();
        let mirrors = vec![ReflectionRays::Mirror; self.triangles.len()];
        let secondary = SecondaryRays { samples: 1, reflections: Some(mirrors), ..SecondaryRays::default() };
        FrameTracer::new(&self.structure, &options, &self.triangles, identity, rays, light)
            .with_secondary(secondary)
    }
}

fn image(view: View) -> Rays {
    let [width, height] = SIZE;
    Rays::View { view, width, height }
}

/// A triangle that fills the view, `depth` in front of a camera that sees 90 degrees from its lower to its upper edge.
fn wall(depth: f32) -> World {
    let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vertical_fov_degrees: 90.0 };
    let corner = |x: f32, y: f32| Vec3::new(x * depth, y * depth, -depth);
    World::new(vec![Triangle { v: [corner(-20.0, -9.0), corner(20.0, -9.0), corner(0.0, 20.0)] }], &camera)
}

#[test]
fn eyes_in_one_place_see_the_same() {
    for name in ["cornell", "teapot", "atrium"] {
        let world = World::builtin(name);
        let known = world.reprojection(Eyes { interaxial: 0.0, convergence: world.distance });
        for (place, &source) in (0..).zip(known.sources()) {
            assert_eq!(source, Source::Left(place % SIZE[0]), "{name}, pixel {place}");
        }
    }
}

#[test]
fn a_wall_is_missing_in_as_many_columns_as_its_disparity_has_pixels() {
    // Parallel eyes: focal length in pixels times their distance over the depth.
    let focal = f64::from(SIZE[1]) / 2.0;
    for (interaxial, depth) in [(0.1, 1.5), (0.7, 4.0), (2.0, 3.0)] {
        let known = wall(depth as f32).reprojection(Eyes { interaxial, convergence: f64::INFINITY });
        let disparity = focal * interaxial / depth;
        let columns = (disparity + 0.5).floor() as u64;
        assert!((disparity.fract() - 0.5).abs() > 1e-3, "not on the edge of a pixel");
        assert_eq!(known.counts()[1..], [columns * u64::from(SIZE[1]), 0], "disparity {disparity}");
    }
}

#[test]
fn what_is_reused_is_seen_by_the_right_eye_but_for_few_pixels() {
    for name in ["cornell", "teapot", "atrium"] {
        let world = World::builtin(name);
        let eyes = Eyes { interaxial: world.distance / 30.0, convergence: world.distance };
        let [left, right] = eyes.views(&world.camera);
        let left = world.gbuffer(left);
        let known = Reprojection::new(&left, &right);
        let eye = right.primary_ray(0, 0).origin;
        let (mut reused, mut hidden) = (0_u32, 0_u32);
        for pixel in 0..left.pixels() {
            let Some(departure) = known.left_pixel(pixel).and_then(|source| left.departure(source)) else {
                continue;
            };
            reused += 1;
            let sight = departure.shadow_ray(eye);
            hidden += u32::from(world.structure.trace(&sight, Query::Any, &mut Silent).is_hit());
        }
        assert!(reused > 1500 && known.counts()[1] > 100, "{name}: {reused}");
        // At this size, what lies within half a pixel of an edge is as much.
        assert!(hidden * 30 < reused, "{name}: {hidden} of {reused} are hidden");
    }
}

#[test]
fn an_image_that_is_answered_traces_what_depends_on_the_view_alone() {
    let world = World::builtin("cornell");
    let together = Eyes { interaxial: 0.0, convergence: world.distance };
    let eye = world.tracer(image(together.views(&world.camera)[1]));
    let known = world.reprojection(together);
    let work = TraversalWork::of(&eye, Some(&known)).expect("it can be traced");
    assert!(work.reusable > 0 && work.view_dependent > 0);
    assert_eq!((work.unanswered, work.with_reuse()), (0, work.view_dependent));
    let alone = TraversalWork::of(&eye, None).expect("it can be traced");
    assert_eq!((alone.whole(), alone.with_reuse()), (work.whole(), work.whole()));
}

#[test]
fn pixels_without_an_answer_are_those_that_are_traced() {
    let world = World::builtin("atrium");
    let eyes = Eyes { interaxial: world.distance / 30.0, convergence: world.distance };
    let [_, right] = eyes.views(&world.camera);
    let known = world.reprojection(eyes);
    let work = TraversalWork::of(&world.tracer(image(right)), Some(&known)).expect("it can be traced");
    let unanswered = (0..SIZE[0] * SIZE[1]).filter(|&pixel| known.left_pixel(pixel).is_none());
    let rays = unanswered.map(|pixel| right.primary_ray(pixel % SIZE[0], pixel / SIZE[0])).collect();
    let listed = TraversalWork::of(&world.tracer(Rays::List(rays)), None).expect("it can be traced");
    assert!(listed.reusable > 0 && listed.reusable < work.reusable);
    assert_eq!(work.unanswered, listed.reusable);
}

#[test]
fn a_list_of_pixels_traces_reflections_alone_of_those_that_are_known() {
    let world = World::builtin("atrium");
    let eyes = Eyes { interaxial: world.distance / 30.0, convergence: world.distance };
    let [_, right] = eyes.views(&world.camera);
    let known = world.reprojection(eyes);
    let work = TraversalWork::of(&world.tracer(image(right)), Some(&known)).expect("it can be traced");
    // From the last pixel to the first.
    let pixels: Vec<u32> = (0..SIZE[0] * SIZE[1]).rev().collect();
    let is_known = pixels.iter().map(|&pixel| known.left_pixel(pixel).is_some()).collect();
    let list = world.tracer(Rays::Pixels { view: right, width: SIZE[0], pixels, known: is_known });
    let listed = TraversalWork::of(&list, None).expect("it can be traced");
    assert!(listed.reusable > 0 && listed.view_dependent > 0);
    assert_eq!((listed.reusable, listed.view_dependent), (work.unanswered, work.view_dependent));
}

#[test]
fn a_wall_is_shifted_by_its_disparity() {
    let known = wall(3.0).reprojection(Eyes { interaxial: 2.0, convergence: f64::INFINITY });
    // 30 pixels, from which f32 may keep those that land at the edge of a pixel.
    let shifts = known.shifts();
    assert!([-31, -30].contains(shifts.start()) && [-30, -29].contains(shifts.end()), "{shifts:?}");
    assert_eq!(known.size(), SIZE);
    assert_eq!(known.columns().len() as u32, SIZE[0] * SIZE[1]);
    for (pixel, column) in (0..).zip(known.columns()) {
        assert!((column - ((pixel % SIZE[0]) as f32 + 0.5 - 30.0)).abs() < 1e-3, "pixel {pixel}: {column}");
    }
}
