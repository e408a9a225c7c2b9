//! Scenes times powers of two: the same triangles, and distances times the same power.
//!
//! No rounding of a product or sum changes when its operands are scaled by a power of two, as long as nothing overflows or
//! falls below the smallest normal number. Moller and Trumbore multiply three lengths (`e2 . (s x e1)`), so their exponents are
//! three times those of the coordinates; the watertight test multiplies two, and goes to f64 where that does not fit.

use crate::case::{Case, Limit};
use crate::exact::crossing;
use crate::judge::Verdicts;
use crate::random::Random;
use crate::reference::Reference;
use crate::structures::{Structure, Watch, all, brute_force, options, same};
use crate::{Size, shapes};
use rayon::prelude::*;
use scenes::Triangle;
use std::ops::RangeInclusive;
use tracer::{Hit, Query, Ray, TriangleTest};

/// The exponents that are tried.
const EXPONENTS: RangeInclusive<i32> = -60..=60;

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    let triangles = shapes::sphere(glam::Vec3::new(0.25, -0.5, 0.125), 1.0, 10);
    let mut random = Random(8);
    let rays: Vec<Ray> =
        (0..size.of(60, 400)).map(|_| Ray::new(2.0 * random.point(), random.direction())).collect();
    TriangleTest::ALL.into_iter().flat_map(|test| of_test(test, &triangles, &rays, watch)).collect()
}

/// What happened at an exponent.
struct At {
    exponent: i32,
    /// Rays and traversals whose hit is not that of exponent 0, scaled.
    changed: u64,
    /// Rays for which another triangle is named than exactly, without rounding as an excuse.
    wrong: u64,
    lost: u64,
    hits: u64,
}

fn of_test(test: TriangleTest, triangles: &[Triangle], rays: &[Ray], watch: &Watch) -> [Case; 3] {
    let unscaled: Vec<Hit> = rays.iter().map(|ray| brute_force(triangles, test, ray)).collect();
    let at = |exponent: i32| {
        let factor = 2.0_f32.powi(exponent);
        let scaled = shapes::scaled(triangles, factor);
        let reference = Reference::new(&scaled);
        let structures: Vec<Structure> = all(&scaled, &options(test));
        let mut at = At { exponent, changed: 0, wrong: 0, lost: 0, hits: 0 };
        for (ray, before) in rays.iter().zip(&unscaled) {
            let ray = Ray { origin: ray.origin * factor, ..*ray };
            let expected = Hit { t: before.t * factor, ..*before };
            for structure in &structures {
                let hit = structure.trace(watch, &ray, Query::Closest);
                at.changed += u64::from(!same(&hit, &expected));
            }
            let hit = structures[0].trace(watch, &ray, Query::Closest);
            let verdict = Verdicts::of(&reference, &ray, &hit, reference.nearest(&ray));
            at.wrong += verdict.wrong;
            at.lost += verdict.lost;
            at.hits += verdict.hits;
        }
        at
    };
    let found: Vec<At> = EXPONENTS.into_par_iter().map(at).collect();
    let kept = |keeps: fn(&At) -> bool| {
        let broken = |rest: &mut dyn Iterator<Item = &At>| {
            rest.take_while(|at| keeps(at)).last().map_or(0, |at| at.exponent)
        };
        let zero = found.len() / 2;
        broken(&mut found[..=zero].iter().rev())..=broken(&mut found[zero..].iter())
    };
    let (exact, right) = (kept(|at| at.changed == 0), kept(|at| at.wrong == 0));
    let theory = theory(test, triangles, rays);
    let ends = [found.first(), found.last()].into_iter().flatten();
    let at_ends: Vec<String> =
        ends.map(|at| format!("at 2^{} {} of {} hits are lost", at.exponent, at.lost, at.hits)).collect();
    let lengths = |range: &RangeInclusive<i32>| format!("2^{} to 2^{}", range.start(), range.end());
    let row = |id: &str,
               statement: String,
               end: &str,
               limit: i32,
               found: i32,
               range: &RangeInclusive<i32>| {
        let limit = match end {
            "smallest" => Limit::AtMost(f64::from(limit)),
            _ => Limit::AtLeast(f64::from(limit)),
        };
        Case::new(format!("scale/{id}/{}", test.name()), statement, "exponent of 2", limit, f64::from(found))
            .under("scale", 2.0_f64.powi(found))
            .because(format!("found: {}; {}", lengths(range), at_ends.join(", ")))
    };
    let statement = |end: &str| {
        format!(
            "the {end} scale at which all traversals give the same bits, t scaled; by theory {}",
            lengths(&theory)
        )
    };
    let wrong: u64 = found.iter().filter(|at| theory.contains(&at.exponent)).map(|at| at.wrong).sum();
    [
        row("smallest", statement("smallest"), "smallest", *theory.start(), *exact.start(), &exact),
        row("largest", statement("largest"), "largest", *theory.end(), *exact.end(), &exact),
        Case::none_of(
            format!("scale/decisions/{}", test.name()),
            format!("at scales from {} no decision is wrong against exact arithmetic", lengths(&theory)),
            "wrong decisions",
            wrong,
        )
        .because(format!("none is from {}", lengths(&right))),
    ]
}

/// The exponents at which no intermediate result leaves the normal numbers, with 24 bits to spare below.
///
/// Moller and Trumbore: the numerator of t, `t * det`, and the largest product in it, farthest vertex times longest edge squared. The
/// watertight test: twice the area that a ray sees of a triangle, and the square of the farthest vertex. Beyond, it computes in
/// f64: decisions stay right, but bits differ from those of f32.
fn theory(test: TriangleTest, triangles: &[Triangle], rays: &[Ray]) -> RangeInclusive<i32> {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for ray in rays {
        for triangle in triangles {
            let [a, b, c] = triangle.v.map(|corner| (corner - ray.origin).as_dvec3());
            let reach = a.length().max(b.length()).max(c.length());
            let edge = (b - a).length().max((c - a).length()).max((c - b).length());
            let Some(found) = crossing(ray, triangle) else { continue };
            let det = ray.direction.as_dvec3().dot((b - a).cross(c - a)).abs();
            let weight = found.least_weight().max(1e-4);
            match test {
                TriangleTest::MoellerTrumbore => {
                    least = least.min(found.t * det);
                    most = most.max(6.0 * reach * edge * edge);
                }
                TriangleTest::Watertight => {
                    least = least.min(weight * det / f64::from(ray.direction.abs().max_element()));
                    most = most.max(4.0 * reach * reach);
                }
            }
        }
    }
    let degree = match test {
        TriangleTest::MoellerTrumbore => 3.0,
        TriangleTest::Watertight => 2.0,
    };
    let low = ((-126.0 + 24.0 - least.log2()) / degree).ceil();
    let high = ((127.0 - most.log2()) / degree).floor();
    (low as i32).max(*EXPONENTS.start())..=(high as i32).min(*EXPONENTS.end())
}
