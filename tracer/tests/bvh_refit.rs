//! Does a refitted tree find what a new tree finds?

use glam::Vec3;
use proptest::prelude::*;
use scenes::Triangle;
use tracer::bvh::{self, Bvh, BvhOptions};
use tracer::{Query, Ray, RayTriangle, Silent, WatertightTriangle};

const COSTS: [f64; 2] = [1.0, 1.0];

fn point(steps: i16) -> impl Strategy<Value = Vec3> {
    let axis = || (-steps..=steps).prop_map(|step| f32::from(step) / 64.0);
    [axis(), axis(), axis()].prop_map(Vec3::from)
}

fn triangle() -> impl Strategy<Value = Triangle> {
    (point(128), point(32), point(32))
        .prop_map(|(a, b, c)| Triangle { v: [a, a + b, a + c] })
        .prop_filter("a triangle with an area", |triangle| !triangle.is_degenerate())
}

/// Triangles before and after.
fn moved() -> impl Strategy<Value = (Vec<Triangle>, Vec<Triangle>)> {
    prop::collection::vec((triangle(), triangle()), 0..80).prop_map(|pairs| pairs.into_iter().unzip())
}

fn same_hits<P: RayTriangle>(
    before: &[Triangle],
    after: &[Triangle],
    rays: &[Ray],
) -> Result<(), TestCaseError> {
    let mut refitted = Bvh::<P>::build_for(before, &BvhOptions::EQUAL_COSTS);
    let links: Vec<_> = refitted.nodes().map(|node| node.kind).collect();
    refitted.refit(after, COSTS).unwrap();
    prop_assert_eq!(refitted.validate(after), Ok(()));
    prop_assert_eq!(refitted.nodes().map(|node| node.kind).collect::<Vec<_>>(), links);
    let parents = bvh::parent_link::ParentLinks::new(&refitted);
    let rebuilt = Bvh::<P>::build_for(after, &BvhOptions::EQUAL_COSTS);
    prop_assert_eq!(refitted.plane_slack(), rebuilt.plane_slack());
    for ray in rays {
        let expected = bvh::stack::trace(&rebuilt, ray, Query::Closest, &mut Silent);
        prop_assert_eq!(bvh::stack::trace(&refitted, ray, Query::Closest, &mut Silent), expected);
        prop_assert_eq!(
            bvh::parent_link::trace(&refitted, &parents, ray, Query::Closest, &mut Silent),
            expected
        );
        let any = bvh::stack::trace(&refitted, ray, Query::Any, &mut Silent);
        prop_assert_eq!(any.is_hit(), expected.is_hit());
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_refitted_tree_has_the_hits_of_a_new_one_and_its_own_links(
        (before, after) in moved(),
        // Offsets keep rays off the grid of the corners, where they would run within triangles.
        rays in prop::collection::vec((point(256), point(64)), 1..20)
    ) {
        let offset = Vec3::new(0.001, 0.0023, 0.0037);
        let rays: Vec<Ray> =
            rays.into_iter().map(|(origin, direction)| Ray::new(origin + offset, direction + offset)).collect();
        same_hits::<WatertightTriangle>(&before, &after, &rays)?;
        same_hits::<tracer::PreparedTriangle>(&before, &after, &rays)?;
    }
}

/// Triangles in a row along x.
fn row(at: impl Fn(u32) -> f32) -> Vec<Triangle> {
    (0..64).map(|i| Triangle { v: [Vec3::ZERO, Vec3::Y, Vec3::Z].map(|v| v + at(i) * Vec3::X) }).collect()
}

#[test]
fn the_costs_of_a_refit_are_those_of_its_boxes_and_a_new_tree_is_cheaper_after_a_shuffle() {
    let in_order = row(|i| i as f32);
    let mut bvh = Bvh::build(&in_order, &BvhOptions::EQUAL_COSTS);
    let unchanged = bvh.clone().refit(&in_order, COSTS).unwrap();
    assert_eq!(unchanged.before, unchanged.after);
    assert_eq!(unchanged.before, bvh.sah_cost(1.0, 1.0));

    let shuffled = row(|i| (i * 37 % 64) as f32);
    let refit = bvh.refit(&shuffled, COSTS).unwrap();
    assert_eq!(refit.before, unchanged.before);
    assert_eq!(refit.after, bvh.sah_cost(1.0, 1.0));
    let rebuilt = Bvh::build(&shuffled, &BvhOptions::EQUAL_COSTS).sah_cost(1.0, 1.0).unwrap();
    // The same row again, so a new tree costs what the old one did; neighbours in the refitted tree are far apart.
    assert!((rebuilt / refit.before.unwrap() - 1.0).abs() < 1e-6);
    assert!(refit.after.unwrap() > 2.0 * rebuilt, "{refit:?}");
}

#[test]
fn a_refused_refit_leaves_the_tree_as_it_was() {
    let triangles = row(|i| i as f32);
    let mut bvh = Bvh::build(&triangles, &BvhOptions::EQUAL_COSTS);
    let before: Vec<_> = bvh.nodes().collect();
    let fewer = bvh.refit(&triangles[1..], COSTS).unwrap_err();
    assert!(fewer.to_string().contains("63 triangles of a tree over 64"), "{fewer}");
    let mut bad = triangles;
    bad[5].v[1].y = f32::NAN;
    let nan = bvh.refit(&bad, COSTS).unwrap_err();
    assert!(nan.to_string().contains("triangle 5"), "{nan}");
    assert_eq!(bvh.nodes().collect::<Vec<_>>(), before);
}
